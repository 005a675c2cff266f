"""For how long the orbits of a scan were watched that are not periodic, and what that says.

Chaos may be transient. That it did not end within a time is a fact; how long it lasts on average
is then bounded from below (`labels.least_lifetime`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.model.labels import CHAOS, least_lifetime
from nlds_vines.orbits.solver_settings import most_watched

if TYPE_CHECKING:
    from nlds_vines.archives.archive import ArchiveView


def watched_of(view: ArchiveView) -> int:
    """Return the forcing periods for which the chaotic orbits of an archive were watched."""
    scan = view.request(SCAN, load_scan)
    return most_watched(scan.transient, scan.periods, scan.effort)


def in_legend(label: str, view: ArchiveView) -> str:
    """Return a label as a legend says it: of chaos, for how long it was watched."""
    return f"{label} (for {watched_of(view)} T)" if label == CHAOS else label


def of_chaos(watched: int) -> str:
    """Return in words what the summary says of chaos that was watched for so long."""
    least = least_lifetime(watched)
    return (
        f"chaos: watched for {watched} periods each; if it is transient, its mean lifetime is "
        f"{least:.0f} periods or more (95 %, one orbit)"
    )
