"""Open an archive as the results that its task returned."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from nlds_vines.archives.archive import ArchivePath, read
from nlds_vines.cli.command import task_of

if TYPE_CHECKING:
    from nlds_vines.bifurcation.response_curves.result import ResponseCurves
    from nlds_vines.bifurcation.result import ScanArchive
    from nlds_vines.continuation.result import Continued
    from nlds_vines.loads.result import ResponseHistories
    from nlds_vines.portrait.result import Portrait
    from nlds_vines.transients.ensemble import Ensemble
    from nlds_vines.tuning.result import Tuned

    Opened = (
        ScanArchive
        | Ensemble
        | ResponseCurves
        | Tuned
        | Continued
        | ResponseHistories
        | Portrait
        | ArchivePath
    )


def open_archive(path: str | os.PathLike[str]) -> Opened:
    """Return the results in an archive, as the function that computed them returned them.

    Arguments: the path (.h5).  The object has `.request`, `.plot()` and `.to_xarray()`.

    Raises `RequestError` if it cannot be read.
    """
    with read(path) as view:
        task = task_of(view)
        return task.read(view.path) if task and task.reads else ArchivePath.of(view.path)
