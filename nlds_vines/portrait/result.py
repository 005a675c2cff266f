"""A portrait: its windows, the request that it is drawn from, and its archive."""

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
from nlds_vines.portrait.view_table import views_in
from nlds_vines.portrait.window_view import View

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Portrait(Drawable):
    """An orbit in full.

    Attributes:
        path: of the archive; None where none was asked for.
        views: the windows of its orbits, a column of the page each.
        drawn_from: the request, as far as it concerns the page: an orbit of a scan's cell is
            not computed again from it.
        cell: of such an orbit, the options that name it; empty for any other.
    """

    drawn_by = "nlds_vines.portrait.picture"

    path: ArchivePath | None
    views: tuple[View, ...]
    drawn_from: PortraitRequest
    cell: str = ""

    @property
    def request(self) -> PortraitRequest:
        """The request with which the same numbers are computed again.

        Raises `RequestError` for the orbit of a scan's cell, which that scan's archive has.
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
    """Return the names of what an open archive tells over time: time, the state, what follows."""
    found = [name for name in view.names if view.dims(name) == ("state",)]
    first = [name for name in ("time", *view["component"]) if name in found]
    return (*first, *(name for name in found if name not in first))


def portrait_in(path: str | os.PathLike[str]) -> Portrait:
    """Return the portrait in an archive; `RequestError` for an archive of anything else."""
    with read(path) as view:
        request = view.request(PORTRAIT, load_portrait)
        cell = view.text(CELL) if CELL_OF in view.attrs else ""
        return Portrait(ArchivePath.of(view.path), tuple(views_in(view, request)), request, cell)
