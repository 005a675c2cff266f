"""Pictures whose panels can be chosen: all of them on a page, some, or one in axes of the user."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.errors import RequestError, choice
from nlds_vines.plotting.inline_figures import let_figures_be_shown
from nlds_vines.plotting.page import Page, into, page_of
from nlds_vines.plotting.save import drawn, save_drawn


@dataclass(frozen=True)
class Picture:
    """What draws archives of one kind.

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

    def usual_in(self, view: ArchiveView) -> list[str]:
        """Return the panels that are drawn of an archive where none is named."""
        return list(self.panels(view) if self.usual is None else self.usual(view))

    def save(self, archive_path: str | os.PathLike[str], plot_path: str | os.PathLike[str]) -> Path:
        """Draw an archive, save its usual panels, and return the path, as `save_drawn`."""
        return save_drawn(
            archive_path, plot_path, lambda view: drawn_by(self, view, None, page_of(2), None)
        )


def drawn_by(
    picture: Picture, view: ArchiveView, show: str | None, page: Page, ax: Axes | None
) -> Figure:
    """Return the figure of an archive.

    Arguments: what draws it; the archive; the names of panels to `show`, separated by commas, None
    for the usual ones; the page; axes to draw one panel into, without `show` the main one.

    Raises `RequestError` for a panel that there is not, and for several in given axes.
    """
    known = picture.panels(view)
    words = [word.strip() for word in (show or "").split(",")]
    names = (
        picture.usual_in(view) if show is None else [choice("show", word, known) for word in words]
    )
    if ax is None:
        return picture.draw(view, list(dict.fromkeys(names)), page)
    if show is not None and len(names) > 1:
        raise several_panels(show, known)
    return into(ax, lambda: picture.fill(ax, view, names[0]))


def picture_of(
    picture: Picture, path: str | os.PathLike[str], show: str | None, ax: Axes | None
) -> Figure:
    """Return the figure of the archive at a path, as `drawn_by` does, on the usual page."""
    let_figures_be_shown()
    with read(path) as view:
        return drawn(view, lambda opened: drawn_by(picture, opened, show, page_of(2), ax))


def several_panels(show: str, known: Mapping[str, object]) -> RequestError:
    """Return the error of axes that were given for several panels, of those that are `known`."""
    names = ", ".join(known)
    return RequestError(f"show = {show!r} names several panels, axes take one of: {names}")
