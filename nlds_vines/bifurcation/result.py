"""The archive of a scan as Python has it: a path that can be read and drawn."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines.archives.archive_path import ArchivePath

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.bifurcation.request import Scan


class ScanArchive(ArchivePath):
    """The path of a scan's archive; wherever a path may stand, it may stand.

    Attributes:
        picture: the path of the picture that was drawn with it; None for none.
    """

    picture: Path | None = None

    @classmethod
    def of(
        cls, path: str | os.PathLike[str], picture: str | os.PathLike[str] | None = None
    ) -> ScanArchive:
        """Return the archive at a path, with the path of its picture."""
        found = super().of(path)
        found.picture = None if picture is None else Path(picture)
        return found

    @property
    def request(self) -> Scan:
        """The scan, with which the same numbers are computed again."""
        from nlds_vines.bifurcation.archived import scan_in

        return scan_in(self)

    def plot(self, show: str | None = None, ax: Axes | None = None) -> Figure:
        """Return its picture as a matplotlib figure, as `nlds_vines.plot` does."""
        from nlds_vines.bifurcation.picture.drawing import draw
        from nlds_vines.plotting.notebook import let_figures_be_shown

        let_figures_be_shown()
        with self.read() as view:
            return draw(view, show, ax=ax)
