"""Results that can be drawn, without an import of Matplotlib before that."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import RequestError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.plotting.chosen_panels import Drawing


class Drawable(Outlined):
    """A result, drawn by the `PICTURE` in `drawn_by`, of which an archive holds everything."""

    drawn_by: ClassVar[str]
    path: ArchivePath | None

    @property
    def archive(self) -> ArchivePath:
        """Its archive; `RequestError` for a result that was made without one."""
        if self.path is None:
            raise RequestError(f"this {type(self).__name__} has no archive: it was made of arrays")
        return self.path

    def sel(self, **values: float | str) -> dict[str, np.ndarray]:
        """Return the part of all datasets at values of dimensions, see `ArchiveView.sel`."""
        return self.archive.sel(**values)

    def to_xarray(self) -> Any:
        """Return all that the archive holds as an `xarray.Dataset` in memory."""
        return self.archive.to_xarray()

    def to_dataframe(self, *names: str) -> Any:
        """Return a `pandas.DataFrame`, by default of all datasets with one value for each orbit."""
        return self.archive.to_dataframe(*names)

    def lines(self) -> Iterator[str]:
        """Yield the title, then the lines of the report."""
        raise NotImplementedError

    def heading(self) -> str:
        """Return the title."""
        return next(self.lines())

    def outline(self) -> Rows:
        """Return the lines of the report, which have no names."""
        _, *lines = self.lines()
        return [("", line.strip()) for line in lines]

    def plot(self, show: str | None = None, ax: Axes | None = None) -> Figure:
        """Draw the result, as `nlds_vines.plot` does.

        Parameters
        ----------
        show : str, optional
            Names of panels, separated by commas; by default the usual ones.
        ax : matplotlib.axes.Axes, optional
            Axes for one panel.

        Returns
        -------
        matplotlib.figure.Figure
            The picture, or the figure of `ax`.
        """
        picture: Drawing = import_module(self.drawn_by).PICTURE
        return picture.of(self.archive, show, ax)
