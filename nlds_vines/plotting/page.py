"""The width of a picture and its margins, and the settings of matplotlib that it is drawn with."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.archives.durable import open_regular
from nlds_vines.errors import RequestError, choice, shown
from nlds_vines.plotting.style import CM, LEFT, RIGHT, STYLE, WIDTH

_MOST_BYTES = 1 << 20
"""Bytes of a style sheet: matplotlib's longest have some kilobytes."""


@dataclass(frozen=True)
class Page:
    """The size of a picture for one column of a paper or for both.

    Letters keep their size in either; margins and panels are given in inches.

    Attributes:
        width: of the picture; left, right: the margins of its panels.
        panel: the height of a panel of a diagram.
        map_width, map_height: of the panel of a map; beside: whether its legend stands to the right
            of it, or else below.
        columns: entries of a legend side by side.
    """

    width: float
    left: float
    right: float
    panel: float
    map_width: float
    map_height: float
    beside: bool
    columns: int

    @property
    def across(self) -> float:
        """The width of the panels of a diagram."""
        return self.width - self.left - self.right


TWO_COLUMNS = Page(
    width=WIDTH,
    left=LEFT * WIDTH,
    right=(1 - RIGHT) * WIDTH,
    panel=4.4 * CM,
    map_width=0.665 * WIDTH,
    map_height=8.8 * CM,
    beside=True,
    columns=4,
)
"""A picture over both columns, or over the width of a report: 16 cm."""

ONE_COLUMN = Page(
    width=8.4 * CM,
    left=1.45 * CM,
    right=1.35 * CM,
    panel=4.2 * CM,
    map_width=5.3 * CM,
    map_height=5.0 * CM,
    beside=False,
    columns=2,
)
"""A picture for one column of a paper: 8.4 cm."""


def page_of(columns: object) -> Page:
    """Return the page of a picture for 1 or 2 columns; `RequestError` for anything else."""
    return {"1": ONE_COLUMN, "2": TWO_COLUMNS}[choice("columns", str(columns), ("1", "2"))]


@contextmanager
def styled() -> Iterator[None]:
    """Draw with `style.STYLE`, as far as the user has set nothing else; also a decorator.

    What differs from matplotlib's own defaults was set by a `matplotlibrc`, by a style sheet or in
    `matplotlib.rcParams`: it stays.
    """
    usual = matplotlib.rcParamsDefault
    ours = {k: v for k, v in STYLE.items() if matplotlib.rcParams[k] == usual[k]}
    with matplotlib.rc_context(ours):
        yield


def sheet(style: str | None) -> AbstractContextManager[None]:
    """Return the context of a style sheet of matplotlib's, of that name or path; None for none.

    Raises `RequestError` where there is no such sheet.
    """
    if style is None:
        return nullcontext()
    from matplotlib import style as sheets

    if style not in sheets.available:
        try:
            _check_size(Path(style).expanduser())
            matplotlib.rc_params_from_file(style)
        except (OSError, ValueError, TypeError):
            names = ", ".join(sheets.available)
            raise RequestError(f"style {shown(style)} is no file; allowed: {names}") from None
    return sheets.context(style)


def _check_size(path: Path) -> None:
    """Raise ValueError or OSError unless a file is as small as style sheets are."""
    with open_regular(path) as file:
        if os.fstat(file.fileno()).st_size > _MOST_BYTES:
            raise ValueError("it is larger than style sheets are")


def into(ax: Axes, fill: Callable[[], None]) -> Figure:
    """Draw into given axes by `fill`, and return their figure: where it is in another, that one."""
    with styled():
        fill()
    figure = ax.get_figure(root=True)
    assert isinstance(figure, Figure)
    return figure
