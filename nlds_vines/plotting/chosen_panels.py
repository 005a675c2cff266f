"""The drawing of an archive: a page with all panels or some, or one panel in the user's axes."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.errors import RequestError, choice
from nlds_vines.plotting.page import TWO_COLUMNS, Page, count_in, into
from nlds_vines.plotting.save import check_format, drawn, let_figures_be_shown, save_figure


class Drawing(ABC):
    """A drawing of the archives of one kind."""

    @abstractmethod
    def names(self, view: ArchiveView) -> Mapping[str, str]:
        """Return the names and meanings of what an archive can show."""

    @abstractmethod
    def figure(
        self,
        view: ArchiveView,
        show: str | None = None,
        page: Page = TWO_COLUMNS,
        ax: Axes | None = None,
    ) -> Figure:
        """Return the figure of an open archive.

        Arguments: `show`, names separated by commas, None for the default; the page; `ax`, axes for
        one panel, by default the main one.

        Raises `RequestError` for what the archive cannot show, and for several panels in `ax`.
        """

    def of(
        self, path: str | os.PathLike[str], show: str | None = None, ax: Axes | None = None
    ) -> Figure:
        """Return the figure of the archive at a path, on the default page; see `figure`."""
        let_figures_be_shown()
        with read(path) as view:
            figure = drawn(view, lambda opened: self.figure(opened, show, ax=ax))
            count_in(figure, None, view)
            return figure

    def save(
        self,
        archive_path: str | os.PathLike[str],
        plot_path: str | os.PathLike[str],
        show: str | None = None,
        frequency: str | None = None,
    ) -> Path:
        """Draw the archive at a path, save the picture and return the picture's path.

        The suffix of `plot_path` chooses one of `plotting.save.FORMATS`, `frequency` the unit of
        axes of the frequency (`count_in`).  The metadata have the hash of the request.  Equal
        archives give equal bytes.

        Raises `RequestError` for another suffix, for an archive that cannot be read or drawn, and
        for a path that cannot be written.
        """
        path = Path(plot_path)
        check_format(path)
        with read(archive_path) as view:
            figure = drawn(view, lambda opened: self.figure(opened, show))
            count_in(figure, frequency, view, strict=False)
            title, scan_hash = view.text("title"), view.text("scan_hash")
        return save_figure(figure, path, title, ("scan_hash", scan_hash))


@dataclass(frozen=True)
class Picture(Drawing):
    """A drawing panel by panel.

    Attributes:
        panels: the panels of an archive with their meanings, the main one first.
        draw: returns the figure of an archive with some of the panels, on a page.
        fill: draws one panel of an archive into axes.
        usual: returns the default panels of an archive; None for all panels.
    """

    panels: Callable[[ArchiveView], Mapping[str, str]]
    draw: Callable[[ArchiveView, Sequence[str], Page], Figure]
    fill: Callable[[Axes, ArchiveView, str], None]
    usual: Callable[[ArchiveView], Sequence[str]] | None = None

    def names(self, view: ArchiveView) -> Mapping[str, str]:
        return self.panels(view)

    def figure(
        self,
        view: ArchiveView,
        show: str | None = None,
        page: Page = TWO_COLUMNS,
        ax: Axes | None = None,
    ) -> Figure:
        panels = self.panels(view)
        usual = panels if self.usual is None else self.usual(view)
        names = chosen(show, panels, usual, ax is None)
        if ax is None:
            return self.draw(view, names, page)
        return into(ax, lambda: self.fill(ax, view, names[0]))


def chosen(
    show: str | None, panels: Iterable[str], usual: Iterable[str], several: bool
) -> list[str]:
    """Return the different panels in `show`, or the `usual` ones.

    Raises `RequestError` for one that is not among the `panels` and, unless `several` are possible,
    for more than one.
    """
    if show is None:
        return list(usual)
    panels = list(panels)
    names = list(dict.fromkeys(choice("show", word.strip(), panels) for word in show.split(",")))
    if len(names) > 1 and not several:
        raise several_panels(show, panels)
    return names


def several_panels(show: str, panels: Iterable[str]) -> RequestError:
    """Return the error of several panels in one pair of axes."""
    names = ", ".join(panels)
    return RequestError(f"show = {show!r} names several panels, axes take one of: {names}")
