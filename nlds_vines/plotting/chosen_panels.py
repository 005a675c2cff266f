"""Archives drawn, as a page of panels or one panel in the user's axes, and figures saved."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.archives.files import in_one_line, whole
from nlds_vines.errors import MOST_CHARACTERS, RequestError, choice, printable
from nlds_vines.model.look import USUAL_LOOK, Look
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    count_in,
    into,
    others_beside,
    page_of,
    set_title,
    styled,
)
from nlds_vines.runs.progress import in_notebook

Drawn = TypeVar("Drawn")

FORMATS = {"png": 200, "pdf": 600, "svg": 600}
"""The suffixes of pictures with their resolutions [dots per inch], of vector formats that of clouds
of dots and of shaded cells."""


class Drawing(ABC):
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
        """Return the figure of an open archive; `show` are names, separated by commas.

        The axes `ax` take one panel, by default the main one.  Raises `RequestError` for what the
        archive cannot show, and for several panels in `ax`.
        """

    def of(
        self, path: str | os.PathLike[str], show: str | None = None, ax: Axes | None = None
    ) -> Figure:
        """Return the figure of the archive at a path, on the default page; see `figure`."""
        let_figures_be_shown()
        with read(path) as view:
            there = others_beside(ax)
            figure = drawn(view, lambda opened: self.figure(opened, show, ax=ax))
            count_in(figure, None, view, others=there)
            return figure

    def save(
        self,
        archive_path: str | os.PathLike[str],
        plot_path: str | os.PathLike[str],
        show: str | None = None,
        frequency: str | None = None,
        look: Look = USUAL_LOOK,
    ) -> None:
        """Draw an archive and save the picture; equal archives give equal bytes."""
        page = page_of(look.columns, look.width)
        with read(archive_path) as view:
            figure = drawn(view, lambda opened: self.figure(opened, show, page))
            count_in(figure, frequency, view, strict=False)
            if look.title is not None:
                set_title(figure, look.title)
            title, scan_hash = view.text("title"), view.text("scan_hash")
        save_figure(figure, Path(plot_path), title, ("scan_hash", scan_hash))


@dataclass(frozen=True)
class Picture(Drawing):
    """A drawing panel by panel: `draw` draws some of them on a page, `fill` one into axes.

    `panels` returns those of an archive, the main one first, `usual` the default ones, else all.
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
    """Return the different panels in `show`, or the `usual` ones; `RequestError` for any other."""
    if show is None:
        return list(usual)
    panels = list(panels)
    names = list(dict.fromkeys(choice("show", word.strip(), panels) for word in show.split(",")))
    if len(names) > 1 and not several:
        raise several_panels(show, panels)
    return names


def several_panels(show: str, panels: Iterable[str]) -> RequestError:
    names = ", ".join(panels)
    return RequestError(f"show = {show!r} names several panels, axes take one of: {names}")


def drawn(view: ArchiveView, draw: Callable[[ArchiveView], Drawn]) -> Drawn:
    """Return `draw(view)`; raise `RequestError` if the content of the archive is inconsistent."""
    try:
        return draw(view)
    except RequestError:
        raise
    except (ValueError, LookupError, TypeError, ArithmeticError, AttributeError) as error:
        reason = (str(error).splitlines() or [""])[0]
        raise RequestError(
            f"{view.path} is complete, but cannot be drawn: {type(error).__name__}: {reason}"
        ) from error


def save_figure(figure: Figure, path: Path, title: str, origin: tuple[str, str]) -> None:
    """Save a figure, completely or not at all.

    Title and `origin`, the name and the value of a hash, are in the metadata.  The suffix chooses
    one of `FORMATS`.  The file has no date, so its bytes repeat.
    """
    form, (name, digest) = path.suffix.lower().removeprefix("."), origin
    if form not in FORMATS:
        raise RequestError(f"{path}: a picture is one of .{', .'.join(FORMATS)}")
    # matplotlib names the elements of an SVG at random unless it is given a salt
    salt: dict[Any, Any] = {"svg.hashsalt": digest}
    title, words = printable(title[:MOST_CHARACTERS]), f"{name} {digest}"
    metadata: dict[str, dict[str, str | None]] = {
        "png": {"Title": title, name: digest},
        "pdf": {"Title": title, "Subject": words, "CreationDate": None},
        "svg": {"Title": title, "Description": words, "Date": None},
    }
    with in_one_line(f"write {path}"), styled(), matplotlib.rc_context(salt), whole(path) as part:
        figure.savefig(part, format=form, dpi=FORMATS[form], metadata=metadata[form])


def let_figures_be_shown() -> None:
    """Let a notebook show figures that its cells return, as matplotlib.pyplot would do."""
    if in_notebook():
        from IPython import get_ipython
        from IPython.core.pylabtools import select_figure_formats

        select_figure_formats(get_ipython(), {"png"})
