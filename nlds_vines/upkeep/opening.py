"""Open an archive as the results that its task returned."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from nlds_vines.archives.archive import ArchivePath, read
from nlds_vines.cli.command import task_of

if TYPE_CHECKING:
    from nlds_vines.bifurcation.response_curves import ResponseCurves
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

    Parameters
    ----------
    path : str or os.PathLike
        The archive (.h5).

    Returns
    -------
    ScanArchive, Ensemble, ResponseCurves, Tuned, Continued, ResponseHistories or Portrait
        The results, with `.request`, `.plot()`, `.to_xarray()` and `.to_dataframe()`.

    Raises
    ------
    RequestError
        If the file is no archive of this program, or is damaged.

    See Also
    --------
    read : The datasets of any archive by name.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> vary = {"omega": {"values": [6.0, 6.4]}}
    >>> scan = nv.scan("ssul-set6", vary=vary, sampling={"transient": 100}, quiet=True)
    >>> nv.open_archive(scan).request.axes[0].name
    'omega'
    """
    with read(path) as view:
        task = task_of(view)
        return task.read(view.path) if task else ArchivePath.of(view.path)
