"""The tasks by their archives: each has a `Job` that computes, reads and draws one."""

from __future__ import annotations

from collections.abc import Mapping

from nlds_vines.archives import provenance
from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation import command as bifurcation
from nlds_vines.bifurcation import curves_command
from nlds_vines.cli.command import Job
from nlds_vines.continuation import command as continuation
from nlds_vines.loads import command as loads
from nlds_vines.portrait import command as portrait
from nlds_vines.transients import command as transients
from nlds_vines.transients.ensemble import is_ensemble
from nlds_vines.tuning import command as tuning

JOBS: Mapping[str, type[Job]] = {
    provenance.SCAN: bifurcation.Job,
    provenance.RESPONSE_CURVES: curves_command.Job,
    provenance.RESPONSE_HISTORY: loads.Job,
    provenance.PORTRAIT: portrait.Job,
    provenance.TUNING: tuning.Job,
    provenance.CONTINUATION: continuation.Job,
}
"""By the content of an archive; a new kind of archive is a new entry."""

ENSEMBLE: type[Job] = transients.Job  # of a scan of many starts in one cell


def job_for(view: ArchiveView) -> type[Job] | None:
    """Return the job whose archives an open one is among; None for any other content."""
    if view.content == provenance.SCAN and is_ensemble(view):
        return ENSEMBLE
    return JOBS.get(view.content)
