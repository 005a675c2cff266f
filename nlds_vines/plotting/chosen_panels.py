"""What draws archives: all panels of a picture on a page, some, or one in axes of the user."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.errors import RequestError, choice
from nlds_vines.plotting.page import TWO_COLUMNS, Page, into
from nlds_vines.plotting.save import check_format, drawn, let_figures_be_shown, save_figure


class Drawing(ABC):
    """What draws archives of one kind."""

    @abstractmethod
    def names(self, view: ArchiveView) -> Mapping[str, str]:
        """Return what of an archive can be shown, by name, and what it is."""

    @abstractmethod
    def figure(
        self,
        view: ArchiveView,
        show: str | None = None,
        page: Page = TWO_COLUMNS,
        ax: Axes | None = None,
    ) -> Figure:
        """Return the figure of an open archive.

        Arguments: the archive; what to `show`, names separated by commas, None for what is usual;
        the page; axes to draw one panel into, without `show` the main one.

        Raises `RequestError` where the archive does not hold what to show, and for several panels
        in given axes.
        """

    def of(
        self, path: str | os.PathLike[str], show: str | None = None, ax: Axes | None = None
    ) -> Figure:
        """Return the figure of the archive at a path, on the usual page; see `figure`."""
        let_figures_be_shown()
        with read(path) as view:
            return drawn(view, lambda opened: self.figure(opened, show, ax=ax))

    def save(
        self,
        archive_path: str | os.PathLike[str],
        plot_path: str | os.PathLike[str],
        show: str | None = None,
    ) -> Path:
        """Draw the archive at a path, save the picture and return the picture's path.

        Arguments: `plot_path`, whose suffix chooses one of `plotting.save.FORMATS`; what to `show`.

        The file takes its name only when it is complete.  Its metadata hold the hash of the
        request, and it has the same bytes whenever it is drawn from the same archive.

        Raises `RequestError` for another suffix, for an archive that cannot be read or holds
        nothing to draw, and for a place that cannot be written.
        """
        path = Path(plot_path)
        check_format(path)
        with read(archive_path) as view:
            figure = drawn(view, lambda opened: self.figure(opened, show))
            title, scan_hash = view.text("title"), view.text("scan_hash")
        return save_figure(figure, path, title, ("scan_hash", scan_hash))


@dataclass(frozen=True)
class Picture(Drawing):
    """What draws archives of one kind panel by panel.

    Attributes:
        panels: what the panels of an archive's picture show, by name, the main one first.
        draw: the figure of an archive with some of the panels, on a page.
        fill: draws one panel of an archive into given axes.
        usual: the panels that are drawn where none is named; None for all.
    """

    panels: Callable[[ArchiveView], Mapping[str, str]]
    draw: Callable[[ArchiveView, Sequence[str], Page], Figure]
    fill: Callable[[Axes, ArchiveView, str], None]
    usual: Callable[[ArchiveView], Sequence[str]] | None = None

    def names(self, view: ArchiveView) -> Mapping[str, str]:
        """Return what the panels show, by name."""
        return self.panels(view)

    def figure(
        self,
        view: ArchiveView,
        show: str | None = None,
        page: Page = TWO_COLUMNS,
        ax: Axes | None = None,
    ) -> Figure:
        """Return the figure of an open archive, see `Drawing`."""
        panels = self.panels(view)
        if show is None:
            names = [*(panels if self.usual is None else self.usual(view))]
        else:
            names = [choice("show", word.strip(), panels) for word in show.split(",")]
        if ax is None:
            return self.draw(view, list(dict.fromkeys(names)), page)
        if show is not None and len(names) > 1:
            raise several_panels(show, panels)
        return into(ax, lambda: self.fill(ax, view, names[0]))


def several_panels(show: str, known: Mapping[str, object]) -> RequestError:
    """Return the error of axes that were given for several panels, of those that are `known`."""
    names = ", ".join(known)
    return RequestError(f"show = {show!r} names several panels, axes take one of: {names}")
