"""The archive of a scan as Python has it: a path that can be read and drawn."""

from __future__ import annotations

import os
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.archives.view import ArchiveView


class ScanArchive(type(Path())):  # type: ignore[misc]  # the concrete class: Path alone is abstract
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
        found = cls(path)
        found.picture = None if picture is None else Path(picture)
        return found

    def read(self) -> AbstractContextManager[ArchiveView]:
        """Open it, in a `with` statement, as `nlds_vines.read` does."""
        from nlds_vines.archives.archive import read

        return read(self)

    def plot(self, show: str | None = None, ax: Axes | None = None) -> Figure:
        """Return its picture as a matplotlib figure, as `nlds_vines.plot` does."""
        from nlds_vines.bifurcation.picture.drawing import draw

        with self.read() as view:
            return draw(view, show, ax=ax)
