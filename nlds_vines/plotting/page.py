"""The page of a picture: its width, its rows of panels, its title, legends, ticks and settings.

Matplotlib's constrained layout makes room for labels, letters, names and legends.  Panels have
fixed heights, and the page grows with them:

    figure, grid = new_figure(page, [2.0, 1.0])  # inches
    panels = [figure.add_subplot(grid[row]) for row in range(grid.nrows)]
    ...
    finish(figure, grid, "a title")
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, replace
from math import ceil, floor, log10
from pathlib import Path
from typing import Any, Literal

import matplotlib
import numpy as np
from matplotlib import rcParams, ticker
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.gridspec import GridSpec, GridSpecBase
from matplotlib.layout_engine import ConstrainedLayoutEngine, PlaceHolderLayoutEngine
from matplotlib.legend import Legend
from matplotlib.textpath import TextPath
from matplotlib.transforms import offset_copy

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.files import open_regular, parse_toml
from nlds_vines.errors import RequestError, checked_width, choice, shown
from nlds_vines.model.ratios import HZ, RAD, frequency_in, frequency_unit
from nlds_vines.plotting.style import CM, STYLE, WIDTH, axis_label, typeset

_PAD = 0.1 * CM  # inches around each panel with its labels, and around the page
_PASSES = 2  # layouts before the last, as ticks depend on the heights of panels
_INVISIBLE = 1e-6  # inches that panels may miss of their heights
_LEFT, _RIGHT = 1.45 * CM, 0.3 * CM  # inches beside panels, before their labels are measured
_LEGEND_BELOW, _LEGEND_ABOVE, _LEGEND_BESIDE = 29, 4, 6  # points between a panel and its legend
LETTER_ROOM = 12  # points above a panel that its letter takes: the offset of a legend there
_DECADE = 60  # points of a decade below which 2 and 5 have no room between 1 and 10
_FEWEST = 3  # numbers along a logarithmic axis
_ROUNDEST = (1, 2, 5, 3, 4, 6, 7, 8, 9)  # digits in the order in which they are written
_CLAUSE = re.compile(r"(?<=[,;:]) ")  # spaces at which a title may be broken


@dataclass(frozen=True)
class Page:
    """The size [inches] of a picture; panels and legends stand `beside` each other, or below."""

    width: float
    panel: float
    map_height: float
    beside: bool


# a picture over both columns, or over the width of a report, and one for one column of a paper
TWO_COLUMNS = Page(width=WIDTH, panel=4.4 * CM, map_height=8.8 * CM, beside=True)
ONE_COLUMN = Page(width=8.4 * CM, panel=4.2 * CM, map_height=5.0 * CM, beside=False)


def page_of(columns: object, width: float | None = None) -> Page:
    """Return the page for one or two columns of a paper, perhaps with another width [cm]."""
    page = {"1": ONE_COLUMN, "2": TWO_COLUMNS}[choice("columns", str(columns), ("1", "2"))]
    return page if width is None else replace(page, width=checked_width(width) * CM)


@contextmanager
def styled(settings: Mapping[Any, Any] = STYLE) -> Iterator[None]:
    """Draw with `settings`, unless the user has set something else; also a decorator.

    Settings that differ from matplotlib's defaults come from the user's `matplotlibrc`, style sheet
    or `rcParams` and stay.  Characters that no font has are drawn as boxes.
    """
    usual = matplotlib.rcParamsDefault
    ours = {k: v for k, v in settings.items() if matplotlib.rcParams[k] == usual[k]}
    with matplotlib.rc_context(ours), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def sheet(style: str | None) -> AbstractContextManager[None]:
    """Return the context of a style sheet of matplotlib, by name or path; None for no sheet."""
    if style is None:
        return nullcontext()
    from matplotlib import style as sheets

    if style not in sheets.available:
        try:
            open_regular(Path(style).expanduser()).close()  # matplotlib would wait for a pipe
            matplotlib.rc_params_from_file(style)
        except (OSError, ValueError, TypeError):
            names = ", ".join(sheets.available)
            raise RequestError(f"style {shown(style)} is no file; allowed: {names}") from None
    return sheets.context(style)


_OF_LETTERS = ("font.family", "mathtext.fontset")


def styled_for(ax: Axes | None) -> AbstractContextManager[None]:
    """Return the context to draw into a user's axes, whose letters stay, or on a page of ours."""
    if ax is None:
        return styled()
    return styled({name: value for name, value in STYLE.items() if name not in _OF_LETTERS})


def into(ax: Axes, fill: Callable[[], None]) -> Figure:
    """Call `fill`, which draws into axes, and return their outermost figure."""
    with styled_for(ax):
        fill()
    return figure_of(ax)


def others_beside(ax: Axes | None) -> list[Axes]:
    """Return the axes of a user's figure but for those that are drawn into."""
    return [] if ax is None else [axes for axes in figure_of(ax).axes if axes is not ax]


def figure_of(axes: Axes) -> Figure:
    figure = axes.figure.figure
    assert isinstance(figure, Figure)
    return figure


def new_figure(page: Page, heights: Sequence[float], columns: int = 1) -> tuple[Figure, GridSpec]:
    """Return an empty figure and a grid whose rows have these heights [inches]; see `finish`.

    Panels have about their final sizes already, by which names and ticks are chosen.
    """
    tall = sum(heights) + 2.0
    figure = Figure(figsize=(page.width, tall), layout=_engine())
    grid = figure.add_gridspec(
        len(heights), columns, height_ratios=heights, hspace=0.0, bottom=1.0 / tall,
        top=1.0 - 1.0 / tall, left=_LEFT / page.width, right=1.0 - _RIGHT / page.width,
    )  # fmt: skip
    return figure, grid


def finish(figure: Figure, grid: GridSpec, title: str, below: str = "") -> None:
    """Write the title, plain text, and a line `below` it, in LaTeX; set the heights of the rows."""
    _write_title(figure, title, below)
    fit(figure, grid)


@styled()
def set_title(figure: Figure, title: str) -> None:
    """Replace the title of a finished figure; an empty one leaves no room for it."""
    if title:
        _write_title(figure, title)
    else:
        figure.suptitle("").set_in_layout(False)
    spec = figure.axes[0].get_subplotspec()
    if spec is not None:
        fit(figure, spec.get_topmost_subplotspec().get_gridspec())


def _write_title(figure: Figure, title: str, below: str = "") -> None:
    size = FontProperties(size=rcParams["font.size"]).get_size_in_points()
    width, lines = 72 * (figure.get_figwidth() - _LEFT), list[str]()
    for part in filter(None, [typeset(title), below]):
        first, *clauses = _CLAUSE.split(part)
        lines.append(first)
        for clause in clauses:  # breaks stand after commas and colons
            longer = f"{lines[-1]} {clause}"
            if text_width(longer, size) <= width:
                lines[-1] = longer
            else:
                lines.append(clause)
    figure.suptitle("\n".join(lines), ha="left", fontsize=rcParams["font.size"])


def fit(figure: Figure, grid: GridSpecBase) -> None:
    """Set the heights of the rows, and make room for labels and legends."""
    engine, ratios = _engine(), np.asarray(grid.get_height_ratios(), float)
    figure.set_layout_engine(engine)
    for axes in figure.axes:  # ticks depend on these sizes, also without our settings
        axes.tick_params(axis="x", which="both", labelsize=rcParams["xtick.labelsize"])
        axes.tick_params(axis="y", which="both", labelsize=rcParams["ytick.labelsize"])
    panels = [(axes, spec) for axes in figure.axes if (spec := axes.get_subplotspec())]
    for _ in range(_PASSES):
        engine.execute(figure)
        if title := figure.get_suptitle() and figure.texts[0]:
            left = min(axes.get_position().x0 for axes, _ in panels)
            title.set_x(min(left, _LEFT / figure.get_figwidth()))
        tall, (axes, spec) = figure.get_figheight(), panels[0]
        wanted = ratios[spec.get_topmost_subplotspec().rowspan].sum()
        missing = ratios.sum() * (1.0 - axes.get_position().height * tall / wanted)
        if abs(missing) < _INVISIBLE:
            break
        figure.set_figheight(tall + missing)
    else:
        engine.execute(figure)
    figure.set_layout_engine("none")


def _engine() -> ConstrainedLayoutEngine:
    return ConstrainedLayoutEngine(w_pad=_PAD, h_pad=_PAD, wspace=0.0, hspace=0.0)


def add_legend(
    axes: Axes,
    handles: Sequence[Any],
    side: Literal["right", "below", "above"],
    offset: float = 0.0,
    **look: Any,
) -> Legend:
    """Add a legend outside axes, above or below them in as many columns as fit."""
    size = FontProperties(size=rcParams["legend.fontsize"]).get_size_in_points()
    usual: dict[str, Any] = {"borderaxespad": 0.0, "borderpad": 0.0, "columnspacing": 1.4}
    usual |= {"handlelength": 1.4, "handletextpad": 0.4, "labelspacing": 0.35} | look
    mark = sum(usual[key] for key in ("handlelength", "handletextpad", "columnspacing")) * size
    widths = np.array([mark + text_width(handle.get_label(), size) for handle in handles])
    room = size_of(axes)[0]
    columns = 1
    if side != "right":
        for n in range(2, len(widths) + 1):
            if sum(column.max() for column in np.array_split(widths, n)) <= room:
                columns = n
    x, y, corner, anchor = {
        "right": (_LEGEND_BESIDE + offset, 0.0, "upper left", (1.0, 1.0)),
        "below": (0.0, -_LEGEND_BELOW - offset, "upper left", (0.0, 0.0)),
        "above": (0.0, _LEGEND_ABOVE + offset, "lower left", (0.0, 1.0)),
    }[side]
    place = offset_copy(axes.transAxes, figure_of(axes), x, y, units="points")
    usual |= {"alignment": "left", "loc": corner, "bbox_to_anchor": anchor}
    if (other := axes.get_legend()) is not None:
        axes.add_artist(other).set_clip_on(False)  # clipped artists have no room in a layout
    while True:
        columns = ceil(len(widths) / ceil(len(widths) / columns))  # rows of equal length
        legend = axes.legend(handles=list(handles), bbox_transform=place, ncols=columns, **usual)
        # hinted letters are up to 15 % wider than their outlines
        wide = float(legend.get_window_extent().width) * 72 / float(axes.figure.dpi)
        if columns == 1 or wide <= room:
            return legend
        columns -= 1


def text_width(text: str, size: float) -> float:
    """Return the width of a text [points] at a font size [points]."""
    font = FontProperties(family=rcParams["font.family"], size=size)
    return float(TextPath((0, 0), text, prop=font).get_extents().width)


def letter(index: int) -> str:
    """Return the letter of a panel by its index: (a) ... (z), (aa) ... (zz)."""
    return f"({chr(ord('a') + index % 26) * (1 + index // 26)})"


def write_letters(panels: Sequence[Axes]) -> None:
    """Write (a), (b) ... above the upper left corners of panels."""
    if len(panels) < 2:
        return
    look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    for place, axes in enumerate(panels):
        axes.annotate(letter(place), (0, 1), (0, 2.5), ha="left", va="bottom", **look)


def logarithmic_ticks() -> ticker.LogLocator:
    return ticker.LogLocator(subs=(1.0, 2.0, 5.0))


class _WrittenOut(ticker.LogLocator):
    """Ticks at 1, 2, 5, 10, ... as far as the panel has room for their numbers."""

    def __init__(self, axis: Axis) -> None:
        super().__init__()
        self._along, self._across = axis, axis is axis.axes.xaxis
        name = rcParams["xtick.labelsize" if self._across else "ytick.labelsize"]
        self._size = FontProperties(size=name).get_size_in_points()
        self._digit = text_width(10 * "0", self._size) / 10

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        low, high = sorted((vmin, vmax))
        decade = size_of(self._along.axes)[not self._across] / log10(high / low)
        ticks = _places((1, 2, 5), low, high)
        longest = max((len(f"{value:g}") for value in ticks), default=1)
        room = longest * self._digit + 0.5 * self._size if self._across else 1.1 * self._size
        if decade < max(_DECADE, room / log10(2.0)):
            ticks = _places((1,), low, high, ceil(room / decade))
        if len(ticks) >= _FEWEST:
            return ticks
        ticks = []
        for value in [v for digit in _ROUNDEST for v in _places((digit,), low, high)]:
            if all(abs(log10(value / other)) * decade >= room for other in ticks):
                ticks.append(value)
        if len(ticks) < _FEWEST:  # less than half a decade: round numbers at equal distances
            ticks = [v for v in ticker.MaxNLocator(4).tick_values(low, high) if low <= v <= high]
        return sorted(ticks)


def _places(digits: Sequence[int], low: float, high: float, every: int = 1) -> list[float]:
    """Return digits times each, or `every` n-th, power of ten from `low` to `high`."""
    powers = range(floor(log10(low)) - 1, ceil(log10(high)) + 1)
    ticks = [float(f"{digit}e{n}") for n in powers if n % every == 0 for digit in digits]
    # an end may miss its power by round-off
    return [value for value in ticks if low * (1.0 - 1e-9) <= value <= high * (1.0 + 1e-9)]


def write_out_ticks(axis: Axis) -> None:
    """Mark 1, 2, 5, 10, ... on a logarithmic axis, as far as there is room, at least three."""
    axis.set_major_locator(_WrittenOut(axis))
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_formatter(ticker.NullFormatter())


def size_of(axes: Axes) -> tuple[float, float]:
    point = 72 / float(axes.figure.dpi)
    return point * float(axes.bbox.width), point * float(axes.bbox.height)


# ---- the frequency in Hz, or over that of the structure, in place of rad/s -----------------------


class _Scaled(ticker.Locator):
    """Ticks where another locator has them for the values times a factor."""

    def __init__(self, locator: ticker.Locator, factor: float) -> None:
        self._locator, self._factor = locator, factor

    def set_axis(self, axis: Any) -> None:
        super().set_axis(axis)
        self._locator.set_axis(axis)

    def __call__(self) -> Sequence[float]:
        assert self.axis is not None
        return self.tick_values(*self.axis.get_view_interval())

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        places = self._locator.tick_values(vmin * self._factor, vmax * self._factor)
        return [float(place) / self._factor for place in places]


class _ScaledNumbers(ticker.Formatter):
    """The numbers of ticks times a factor, all with as many decimals as one of them needs."""

    def __init__(self, factor: float) -> None:
        self._factor = factor

    def __call__(self, value: float, pos: int | None = None) -> str:
        return f"{value * self._factor:.6g}"

    def format_ticks(self, values: Sequence[float]) -> list[str]:
        texts = [self(value) for value in values]
        if any("e" in text for text in texts):
            return texts
        decimals = max((len(text.partition(".")[2]) for text in texts), default=0)
        return [f"{value * self._factor:.{decimals}f}" for value in values]


@styled()
def count_in(
    figure: Figure,
    unit: str | None,
    view: ArchiveView,
    *,
    strict: bool = True,
    others: Collection[Axes] = (),
) -> None:
    """Let the frequency axes of an archive's figure, but for `others`, count in a unit of `UNITS`.

    None is the unit of the request.  Raises `RequestError` for a ratio unless the archive has one
    frequency of the structure and, if `strict`, for a unit of a figure without such an axis.
    """
    strict = strict and unit is not None
    unit = frequency_unit(unit, parse_toml(view.text("scan"), "the attribute scan"))
    # the axes labeled as omega, each with all axes in its direction
    whole, labeled = axis_label("omega"), []
    frames = [axes for axes in figure.axes if axes not in others]
    for along in ([frame.xaxis for frame in frames], [frame.yaxis for frame in frames]):
        for axis in along:
            if axis.get_label_text() in (whole, whole.rpartition("force ")[2]):
                labeled.append((axis, along))
    if unit == RAD or not (labeled or strict):
        return

    def value_of(name: str) -> float:
        """Return the value that a parameter has everywhere in the archive, NaN for several."""
        values = view[name] if name in view else np.asarray(view.attrs.get(name, np.nan))
        first = float(np.ravel(values)[0])
        return first if (values == first).all() else np.nan

    factor = 1.0 / frequency_in(unit, value_of)[1]
    if not labeled:
        raise RequestError(f"frequency = {unit!r}: the picture has no axis of the frequency omega")
    words = axis_label("f") if unit == HZ else r"frequency ratio $\omega/\omega_0$"
    for axis, along in labeled:
        is_whole = axis.get_label_text() == whole
        axis.set_label_text(words if is_whole else words[words.index("$") :])
        ends = axis.get_view_interval()
        for other in along:
            # a panel with the same range, unless its ticks are fixed
            locator = other.get_major_locator()
            is_fixed = isinstance(locator, ticker.FixedLocator | ticker.NullLocator)
            if not is_fixed and np.array_equal(other.get_view_interval(), ends):
                is_linear = other.get_scale() == "linear"
                ticks = ticker.AutoLocator() if is_linear else _WrittenOut(other)
                other.set_major_locator(_Scaled(ticks, factor))
                other.set_major_formatter(_ScaledNumbers(factor))
                other.set_minor_formatter(ticker.NullFormatter())
    spec = figure.axes[0].get_subplotspec()
    if isinstance(figure.get_layout_engine(), PlaceHolderLayoutEngine) and spec is not None:
        fit(figure, spec.get_topmost_subplotspec().get_gridspec())  # other numbers, other widths
