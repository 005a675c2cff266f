"""Results that can be drawn: what draws them is named, and loaded when it is asked to."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, ClassVar

from nlds_vines.archives.archive_path import Archived

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.plotting.chosen_panels import Drawing


class Drawable(Archived):
    """A result with an archive, from which the `PICTURE` in a module of its wing is drawn."""

    drawn_by: ClassVar[str]

    def plot(self, show: str | None = None, ax: Axes | None = None) -> Figure:
        """Return its picture as a matplotlib figure, as `nlds_vines.plot` does.

        Arguments: names of panels to `show`, separated by commas, by default all; `ax`, axes to
        draw one panel into.
        """
        picture: Drawing = import_module(self.drawn_by).PICTURE
        return picture.of(self.archive, show, ax)
