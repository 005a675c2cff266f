"""A computed portrait: its windows, its request, its archive, its page."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.provenance import PORTRAIT
from nlds_vines.errors import RequestError
from nlds_vines.plotting.drawable import Drawable
from nlds_vines.portrait.request import CELL, CELL_OF, PortraitRequest, load_portrait
from nlds_vines.portrait.window_view import View, views_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Portrait(Drawable):
    """The windows of one or several orbits.

    Attributes:
        path: path of the archive; None without one.
        views: the windows, one for each column of the page.
        drawn_from: the request of the page; it does not repeat the orbit of a scan's cell.
        cell: the options that name such a cell; empty for other orbits.
    """

    drawn_by = "nlds_vines.portrait.picture"

    path: ArchivePath | None
    views: tuple[View, ...]
    drawn_from: PortraitRequest
    cell: str = ""

    @property
    def request(self) -> PortraitRequest:
        """The request that computes the same numbers again.

        Raises `RequestError` for the orbit of a scan's cell, which needs the scan's archive.
        """
        if self.cell:
            raise RequestError(
                f"{self.path} holds the orbit of a cell: of the archive of its scan, "
                f"`nlds-vines portrait SCAN.h5 {self.cell}` computes it again"
            )
        return self.drawn_from

    @cached_property
    def page(self) -> Figure:
        """The page, a matplotlib figure."""
        page: Figure = import_module(self.drawn_by).portrait(self.drawn_from, self.views)
        return page

    def lines(self) -> Iterator[str]:
        """Yield the title and the report of each window."""
        yield self.drawn_from.title
        for view in self.views:
            yield from view.lines()

    def to_dataframe(self, *names: str) -> Any:
        """Return datasets over one dimension, by default the histories, as a `DataFrame`."""
        with self.archive.read() as view:
            return view.to_dataframe(*(names or histories_in(view)))


def histories_in(view: ArchiveView) -> tuple[str, ...]:
    """Return the datasets over time in an open archive: time, the state, then all others."""
    names = [name for name in view.names if view.dims(name) == ("state",)]
    first = [name for name in ("time", *view["component"]) if name in names]
    return (*first, *(name for name in names if name not in first))


def portrait_in(path: str | os.PathLike[str]) -> Portrait:
    """Return the portrait in an archive; `RequestError` if it holds anything else."""
    with read(path) as view:
        request = view.request(PORTRAIT, load_portrait)
        cell = view.text(CELL) if CELL_OF in view.attrs else ""
        return Portrait(ArchivePath.of(view.path), tuple(views_in(view, request)), request, cell)
