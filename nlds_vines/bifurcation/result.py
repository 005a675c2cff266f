"""The archive of a scan: as Python has it, a path that can be read and drawn, and as a request."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.files import parse_toml
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.errors import RequestError, at, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.archives.archive import ArchiveView


class ScanArchive(ArchivePath):
    """The path of a scan's archive, which is accepted wherever a path is.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> scan = nv.scan("tmd", vary={"omega": {"values": [6.0]}}, record=["energy"], quiet=True)
    >>> scan.request.system.name, scan.request.want
    ('tmd', ('energy',))
    """

    @property
    def request(self) -> Scan:
        """The scan; computed again, it gives the same numbers."""
        if self.named is not None and not self.is_file():
            raise RequestError(f"{shown(str(self))}: there is no such file")
        with self.read() as view:
            return scan_of(view)

    def plot(self, show: str | None = None, ax: Axes | None = None) -> Figure:
        """Return its picture as a Matplotlib figure, see `nlds_vines.plot`."""
        from nlds_vines.bifurcation.picture.drawing import PICTURE

        return PICTURE.of(self, show, ax)


def scan_in(path: str | os.PathLike[str]) -> ScanArchive:
    """Return an archive as `nlds_vines.scan` returned it, one in memory among them."""
    return ScanArchive.of(path)


def scan_of(view: ArchiveView) -> Scan:
    """Return the scan of an open archive.

    Raises `RequestError` if it holds no scan, or if this version reads the scan differently.
    """
    if view.content != SCAN:
        raise RequestError(f"{view.path} holds a {view.content}, not a scan")
    text, digest = view.text("scan"), view.text("scan_hash")
    with at(f"{view.path}: its scan"):
        scan = load_scan(parse_toml(text, "the attribute scan"))
    if scan.hash != digest:
        raise RequestError(
            f"{view.path}: its scan is damaged, or means something else to this version; "
            f"it was made by {view.attrs.get('source', 'an unknown version')}"
        )
    return scan
