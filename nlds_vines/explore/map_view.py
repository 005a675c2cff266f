"""Maps and diagrams as images: what can be shown, painted cells, legends, and a cell in words.

An image is an array of codes and a palette, so a change of the shown number sends a byte per cell.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from bokeh.palettes import Viridis256

from nlds_vines.bifurcation.picture.choices import COEXISTING, REGIMES, SHARE
from nlds_vines.engine.records import CAPTURE_FLAGS as CAPTURE
from nlds_vines.engine.records import NOT_COMPUTED, OK, STATUS
from nlds_vines.explore.map_data import TOUCHES, Stored
from nlds_vines.model.axis import Axis
from nlds_vines.model.labels import by_frequency, coexisting, finals, most_frequent, share_of
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.plotting import palette
from nlds_vines.plotting.style import GRAY, NAVY, NO_VALUE, STARTS, start_colors
from nlds_vines.plotting.style import HUES as HUES

INK = "#3f77b5"
"""The color of a single curve, readable on a light page and on a dark one."""

CLEAR = "#00000000"
UNKNOWN = "not computed"
# words and colors of a map of an archive that records nothing else to show
COMPUTED = ((UNKNOWN, CLEAR), ("computed", palette.RAMP[0]), ("failed", palette.OTHERS["failed"]))
MOST_SHARES = 6  # the most regimes whose share of the starts can be shown
MOST_NAMED = 40  # the most regimes in a legend

MOST_POINTS = 2_000_000  # of a diagram; of longer sections it shows the last periods
_SHADES = 254  # of numbers; codes 0 and 1 mean "not computed" and "no value"


class Places(NamedTuple):
    """The places of the cells of an axis: its shown values or, of uneven values, 0, 1, 2 ...

    `low` and `high` are the outer edges of the first and the last cell; the parameter is `one`
    times the values of the `axis` [SI units].
    """

    axis: Axis
    at: np.ndarray
    low: float
    high: float
    even: bool
    one: float

    def nearest(self, place: float) -> int | None:
        inside = self.low <= place <= self.high
        return int(np.abs(self.at - place).argmin()) if inside else None

    def parameter(self, place: float) -> float:
        value = place if self.even else float(np.interp(place, self.at, self.axis.values))
        return value * self.one

    def of(self, parameter: Any) -> np.ndarray:
        values = np.asarray(parameter, float) / self.one
        return values if self.even else np.interp(values, self.axis.values, self.at)

    @property
    def label(self) -> str:
        entry = DESCRIBED[self.axis.name]
        words = ", ".join(filter(None, (entry.meaning.partition(";")[0], entry.short_symbol)))
        return in_brackets(words, entry.unit)


def places_of(results: Stored) -> list[Places]:
    places = []
    for axis, stored in zip(results.axes, results.scan.axes, strict=True):
        values, count = axis.values, axis.values.size
        step = (values[-1] - values[0]) / (count - 1) if count > 1 else abs(values[0]) or 1.0
        close = np.abs(values - values[0] - step * np.arange(count)) <= 1e-6 * abs(step) * count
        even = bool(close.all())
        at, size = (values, step) if even else (np.arange(count, dtype=float), 1.0)
        _, one = results.shown(stored.name)
        low, high = float(at[0] - size / 2), float(at[-1] + size / 2)
        places.append(Places(axis, at, low, high, even, one))
    return places


def in_brackets(words: str, unit: str) -> str:
    return words if unit == "1" else f"{words} [{unit}]"


def in_unit(text: str, unit: str) -> str:
    return text if unit == "1" else f"{text} {unit}"


def with_unit(value: float, unit: str, digits: int = 4) -> str:
    return in_unit(f"{value:.{digits}g}".replace("-", "−"), unit)


# ---- what can be shown ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Show:
    """A quantity that a map or a diagram can show; `name` is as in `--show`.

    `column` is the argument of the function `column`.  `classes` are (word, color[, shared name])
    of each code, empty for numbers; of `points`, a diagram draws several per cell.
    """

    name: str
    title: str
    column: str
    of_start: bool = True
    classes: tuple[tuple[str, ...], ...] = ()
    unit: str = "1"
    logarithmic: bool = False
    points: bool = False


STATUS_SHOW = Show("status", "status", "computed", classes=COMPUTED)


def shows_of(results: Stored) -> list[Show]:
    is_map, scene = len(results.scan.axes) == 2, results.scan.system.scene
    shows: list[Show] = []
    if is_map and "label" in results:
        classes = classes_of(results)
        if len(results.starts) == 1:
            shows.append(Show(REGIMES, "regimes", "label", classes=classes))
        else:
            several = f"{REGIMES} of a start", "regimes of a start"
            shows.append(Show(REGIMES, "regimes, most frequent", "most", False, classes))
            shows.append(Show(*several, "label", classes=classes))
            *words, last = map(str, range(1, len(palette.COUNTS) + 1))
            counts = zip((*words, f"{last} or more"), palette.COUNTS, strict=True)
            counted = (("none known", palette.OTHERS[palette.HATCHED]), *counts)
            shows.append(Show(COEXISTING, "how many regimes coexist", COEXISTING, False, counted))
            by = results.cached("finals", lambda: by_frequency(finals(results.arrays["label"])))
            for label in [word for word, _ in by if word][:MOST_SHARES]:
                name = f"{SHARE}{label}"
                shows.append(Show(name, f"share of the starts in {label}", name, False))
    if is_map and "capture" in results:
        words = [word.replace("_to_", ":").replace("_", " ") for word in CAPTURE]
        classes = ((UNKNOWN, CLEAR), *zip(words, palette.COUNTS, strict=False))
        shows.append(Show("capture", "response by impacts a period", "capture", classes=classes))
    if not is_map and "section" in results:
        for curve in results.planes[::-1]:  # those of dampers first
            title, (name, _) = f"displacement {curve.symbols[0]}, section t = nT", curve.names
            shows.append(Show(name, title, f"section {name}", unit="m", points=True))
    for name in () if is_map else filter(results.__contains__, TOUCHES):
        one = BY_NAME[name]
        shows.append(Show(name, one.title(scene.body), name, unit=one.unit, points=True))
    shows += [
        Show(name, one.title, name, unit=one.unit, logarithmic=one.logarithmic)
        for name, one in results.numbers.items()
    ]
    return shows or [STATUS_SHOW]


def label_codes(results: Stored) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return labels by code (0: not computed), codes of orbits, and of each cell's usual one."""

    def encode() -> tuple[list[str], np.ndarray, np.ndarray]:
        labels = results.lanes("label").astype(np.str_)
        most = labels[:, 0]
        if len(results.starts) > 1:
            most = most_frequent(results.lanes("label")).astype(np.str_)
            most = np.where((labels == "").any(axis=-1), "", most)
        words, places = np.unique(np.column_stack([labels, most]), return_inverse=True)
        every = [UNKNOWN, *palette.ordered({*words.tolist()} - {""})]
        code = {word: i for i, word in enumerate(every)} | {"": 0}
        codes = np.array([code[word] for word in words.tolist()], np.uint16)[places]
        codes = codes.reshape(len(labels), -1)
        return every, codes[:, :-1], codes[:, -1]

    codes: tuple[list[str], np.ndarray, np.ndarray] = results.cached("labels", encode)
    return codes


def classes_of(results: Stored) -> tuple[tuple[str, ...], ...]:
    """Return word, color and name of all labels, by code; labels of one color share a name."""
    _, *words = label_codes(results)[0]
    shades = palette.colors(words)
    named = (
        (palette.short(word), shades[word], palette.short(palette.drawn_as(word))) for word in words
    )
    return ((UNKNOWN, CLEAR, UNKNOWN), *named)


def column(results: Stored, name: str) -> np.ndarray:
    """Return codes or numbers of all cells, shape (cells, starts), or (cells, 1) of all starts.

    Numbers are float32, NaN where they do not apply.  `capture` holds the codes of the archive plus
    1, `multiplier` the modulus of the largest Floquet multiplier, `computed` codes of `COMPUTED`.
    """
    if name == "label":
        return label_codes(results)[1]
    if name == "most":
        return label_codes(results)[2][:, np.newaxis]
    if name == COEXISTING:
        return np.minimum(coexisting(results.lanes("label")), len(palette.COUNTS))[:, np.newaxis]
    if name.startswith(SHARE):
        shares = share_of(results.lanes("label"), name.removeprefix(SHARE))
        return shares.astype(np.float32)[:, np.newaxis]
    if name == "capture":
        return (results.lanes(name) + 1).astype(np.uint8)
    if name == "computed":
        status = results.lanes("status")
        return np.select([status == NOT_COMPUTED, status == OK], [0, 1], 2).astype(np.uint8)
    if name == "multiplier":
        largest = results.lanes("multipliers")[:, :, 0]
        return np.hypot(largest[..., 0], largest[..., 1]).astype(np.float32)
    number = results.numbers[name]
    with np.errstate(over="ignore"):
        return number.of(results.lanes(number.dataset)).astype(np.float32)


# ---- images --------------------------------------------------------------------------------------


class Picture(NamedTuple):
    """An image: codes, rows upward; the color of each code; the legend (HTML); the hatched code."""

    codes: np.ndarray
    palette: list[str]
    legend: str
    hatched: int = -1


def painted(results: Stored, show: Show, start: int) -> Picture:
    values = column(results, show.column)
    values = values[:, start if show.of_start else 0].reshape(results.shape).T
    if show.classes:
        words = [word for word, *_ in show.classes]
        shades = [shade for _, shade, *_ in show.classes]
        dtype = np.uint8 if len(words) <= 256 else np.uint16
        hatched = words.index(palette.HATCHED) if palette.HATCHED in words else -1
        legend = shares_legend(show.classes, values)
        return Picture(values.astype(dtype), shades, legend, hatched)
    drawn = values[np.isfinite(values) & ((values > 0) | (not show.logarithmic))]
    low, high = (float(drawn.min()), float(drawn.max())) if drawn.size else (0.0, 1.0)
    ends = [with_unit(end, show.unit) for end in (low, high)]
    if show.name.startswith(SHARE):
        low, high, ends = 0.0, 1.0, ["0 %", "100 %"]
    if low == high:
        part = np.where(np.isfinite(values), 0.0, np.nan)
    elif show.logarithmic:
        logs = np.where(values >= 0, np.log(np.maximum(values, low)), np.nan)
        part = (logs - np.log(low)) / (np.log(high) - np.log(low))
    else:
        part = (values - low) / (high - low)
    codes = np.where(np.isfinite(part), 2 + np.floor(np.clip(part, 0, 0.999) * _SHADES), 1)
    status = results.lanes("status")
    of_cell = status[:, start] if show.of_start else status.min(axis=1)
    codes[of_cell.reshape(results.shape).T == NOT_COMPUTED] = 0
    shades = [CLEAR, NO_VALUE, *Viridis256[: _SHADES + 1]]
    ramp = ",".join(Viridis256[: _SHADES + 1 : 15])
    bar = f'<i class="chip ramp" style="background:linear-gradient(90deg,{ramp})"></i>'
    scale = ", logarithmic" if show.logarithmic else ""
    legend = f"<span>{escape(ends[0])} {bar} {escape(ends[1])}{scale}</span>"
    return Picture(codes.astype(np.uint8), shades, legend)


def diagram_values(results: Stored, show: Show) -> np.ndarray:
    if not show.points:
        return column(results, show.column)[..., np.newaxis]
    most = max(1, MOST_POINTS // results.scan.lanes)
    if show.column.startswith("section "):
        (curve,) = (one for one in results.planes if one.names[0] == show.name)
        return curve.of(results.lanes("section")[:, :, -most:])
    return results.lanes(show.column)[..., :most]


def damper_color(system: str) -> str:
    """Return the color of the damper of a named system in all pictures; `INK` of others."""
    return palette.DAMPERS.get(system, INK)


def diagram_colors(results: Stored) -> list[str]:
    """Return the color of each start in a diagram, readable on a light page and on a dark one."""
    shades = {NAVY: INK, STARTS[-1]: GRAY}
    return [shades.get(shade, shade) for shade in start_colors(results.starts)]


def painted_diagram(
    results: Stored, show: Show, window: tuple[float, float, float, float], size: tuple[int, int]
) -> Picture:
    """Return the image of the dots of a diagram in a window (x0, x1, y0, y1).

    Its `size` [pixels] sets its cost, not the number of dots, and dots are as fine in any zoom.
    """
    (x0, x1, y0, y1), (width, height) = window, size
    values, places = diagram_values(results, show), places_of(results)[0]
    with np.errstate(invalid="ignore", over="ignore"):
        columns = np.rint((places.at - x0) / (x1 - x0) * (width - 1))
        rows = np.rint((values - y0) / (y1 - y0) * (height - 1))
        seen = (rows >= 0) & (rows < height)
    seen &= ((columns >= 0) & (columns < width))[:, np.newaxis, np.newaxis]
    across = 3 if not show.points else 2 if places.at.size < width / 1.5 else 1
    codes = np.zeros((height + 2, width + 2), np.uint8)
    shades = diagram_colors(results)
    for k in range(len(results.starts)):
        cells, points = np.nonzero(seen[:, k])
        u, v = columns[cells].astype(int), rows[cells, k, points].astype(int)
        for du in range(across):
            for dv in range(across):
                codes[v + dv, u + du] = 1 + k % 255
    legend = ""
    if len(shades) > 1:
        legend = "".join(map(chip, shades[:MOST_NAMED], results.starts[:MOST_NAMED]))
    if "label" in results:
        legend += shares_legend(classes_of(results), label_codes(results)[1])
    middle = slice(across // 2, across // 2 + height), slice(across // 2, across // 2 + width)
    return Picture(codes[middle], [CLEAR, *shades[:255]], legend)


# ---- legends and words ---------------------------------------------------------------------------


def shares_legend(classes: Iterable[tuple[str, ...]], codes: np.ndarray) -> str:
    """Return the legend of regimes with their shares; regimes of one color share an entry."""
    counts = np.bincount(codes.ravel().astype(int)).tolist()
    groups: dict[str, tuple[str, int]] = {}
    for (word, shade, *shared), count in zip(classes, counts, strict=False):
        name = shared[0] if shared else word
        if count:
            groups[name] = shade, count + groups.get(name, ("", 0))[1]
    named = sorted(groups, key=lambda name: -groups[name][1])[:MOST_NAMED]
    entries = []
    for name, (shade, count) in groups.items():
        if name in named:
            share = count / codes.size
            percent = f"{100 * share:.1f} %" if share < 0.0995 else f"{100 * share:.0f} %"
            entries.append(chip(shade, f"{name}  {percent}", name == palette.HATCHED))
    others = len(groups) - len(named)
    return "".join(entries) + (f"<span>and {others} more</span>" if others else "")


def chip(shade: str, words: str, hatched: bool = False) -> str:
    kind = "chip hatched" if hatched else "chip"
    return f'<span><i class="{kind}" style="background-color:{shade}"></i>{escape(words)}</span>'


def numbers_of(results: Stored) -> list[list[str]]:
    """Return column, title, unit and column of the half width of each number of a cell."""
    widths = {one.width for one in results.numbers.values()}
    rows = [
        [name, one.title, one.unit, one.width]
        for name, one in results.numbers.items()
        if name not in widths
    ]
    if "multipliers" in results:
        rows.append(["multiplier", "largest multiplier |μ|", "1", ""])
    return rows


def values_in_words(axis: Axis) -> list[str]:
    """Return the values of an axis in words: `ω = 7.4 rad/s`."""
    entry = DESCRIBED[axis.name]
    return [f"{entry.symbol} = {with_unit(float(value), entry.unit, 6)}" for value in axis.values]


def head_of(results: Stored, cell: tuple[int, int], start: int) -> str:
    """Return the label of an orbit and the name of its start; empty if there is neither."""
    name = results.starts[start] if len(results.starts) > 1 else ""
    if "label" not in results:
        return name
    label = str(results.lanes("label")[_row(results, cell), start]) or UNKNOWN
    return f"{label} ({name})" if name else label


def place_in_words(results: Stored, cell: tuple[int, int]) -> str:
    pairs = zip(results.axes, cell, strict=False)
    return ", ".join(values_in_words(axis)[i] for axis, i in pairs)


def _row(results: Stored, cell: tuple[int, int]) -> int:
    return cell[0] * results.shape[1] + cell[1]


def numbers_in_words(results: Stored, cell: tuple[int, int], start: int) -> dict[str, str]:
    """Return the finite numbers of an orbit in words, by column."""
    row = _row(results, cell)

    def number(name: str) -> float:
        if name == "multiplier":
            return float(np.hypot(*results.lanes("multipliers")[row, start, 0]))
        one = results.numbers[name]
        return float(one.of(results.lanes(one.dataset)[row, start]))

    lines = {}
    for name, words, unit, width in numbers_of(results):
        value = number(name)
        if not isfinite(value):
            continue
        half = number(width) if width in results else 0.0
        text = f"{value:.4g} ± {half:.2g}" if half > 0 else f"{value:.4g}"
        lines[name] = f"{words}: {in_unit(text, unit)}"
    return lines


def tip_in_words(results: Stored, cell: tuple[int, int], start: int, show: Show) -> list[str]:
    """Return what a small box beside the pointer has room for: label, place and one number.

    It is the shown number or, of regimes and of points, the first one.
    """
    numbers = numbers_in_words(results, cell, start)
    first = next(iter(numbers), "")
    shown = numbers.get(show.column if show.column in results.numbers else first, "")
    lines = [head_of(results, cell, start), place_in_words(results, cell)]
    return [*lines, shown] if shown else lines


def cell_in_words(results: Stored, cell: tuple[int, int], start: int) -> list[str]:
    """Return the label of a cell, empty if there is none, its place, and its recorded numbers."""
    row = _row(results, cell)
    lines = [head_of(results, cell, start), place_in_words(results, cell)]
    if "label" in results and len(results.starts) > 1:
        labels = results.lanes("label")[row].tolist()
        counts = sorted({(-labels.count(one), one or UNKNOWN) for one in labels})
        lines.append("all starts: " + ", ".join(f"{one} × {-n}" for n, one in counts))
    lines += numbers_in_words(results, cell, start).values()
    status = int(results.lanes("status")[row, start])
    if status not in (OK, NOT_COMPUTED):
        lines.append(f"status: {STATUS[status].name if status in STATUS else status}")
    return lines


# ---- a map or a diagram in words, for readers who do not see it ----------------------------------


def picture_in_words(results: Stored, show: Show, start: int) -> str:
    """Return what a map or a diagram shows: its axes, and where which regimes or numbers are."""
    kind = "Map" if len(results.scan.axes) == 2 else "Diagram"
    spans = " and ".join(_axis_in_words(axis) for axis in results.axes)
    said = [f"{kind} over {spans}. Shown: {show.title}"]
    if len(results.starts) > 1 and (show.of_start or kind == "Diagram"):
        said.append(f", {results.starts[start]}")
    said.append(". ")
    if show.classes:
        column_of_start = start if show.of_start else 0
        codes = column(results, show.column)[:, column_of_start]
        said.append(_classes_in_words(results, show.classes, codes))
    else:
        said.append(_range_in_words(results, show, start))
    if kind == "Diagram" and "label" in results:
        said.append(" " + _runs_in_words(results, label_codes(results)[1][:, start]))
    return "".join(said)


def _axis_in_words(axis: Axis) -> str:
    entry = DESCRIBED[axis.name]
    meaning = entry.meaning.partition(";")[0]
    low, high = float(axis.values[0]), float(axis.values[-1])
    span = f"from {low:.6g} to {in_unit(f'{high:.6g}', entry.unit)}"
    return f"{meaning}, {entry.symbol}, {span} in {axis.values.size} cells"


def _extent_in_words(results: Stored, cells: np.ndarray) -> str:
    """Return the least and the largest value of each axis among cells, given by number."""
    places = np.unravel_index(cells, results.shape)
    spans = []
    for axis, indices in zip(results.axes, places, strict=False):
        entry = DESCRIBED[axis.name]
        low, high = float(axis.values[indices].min()), float(axis.values[indices].max())
        span = f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"
        spans.append(f"{entry.symbol} = {in_unit(span, entry.unit)}")
    return ", ".join(spans)


def _classes_in_words(
    results: Stored, classes: Sequence[tuple[str, ...]], codes: np.ndarray
) -> str:
    """Return the share of each class and where it is, the most frequent first."""
    numbers, counts = np.unique(codes.astype(int), return_counts=True)
    order = np.argsort(-counts, kind="stable")
    said = []
    for k in order[:MOST_NAMED].tolist():
        cells = np.flatnonzero(codes == numbers[k])
        share = counts[k] / codes.size
        word = classes[int(numbers[k])][0]
        said.append(f"{word}: {share:.1%} of the cells, at {_extent_in_words(results, cells)}")
    others = len(order) - len(said)
    more = f"; and {others} more" if others else ""
    return "; ".join(said) + f"{more}."


def _range_in_words(results: Stored, show: Show, start: int) -> str:
    """Return the least and the largest of the shown numbers, and where they are."""
    if show.points:
        values = diagram_values(results, show)[:, start]
    else:
        values = column(results, show.column)[:, start if show.of_start else 0, np.newaxis]
    if not np.isfinite(values).any():
        return "No value is known."
    said = []
    for word, place in (("Least", np.nanargmin(values)), ("largest", np.nanargmax(values))):
        value = in_unit(f"{values.flat[place]:.4g}", show.unit)
        cell = np.array([place // values.shape[1]])
        said.append(f"{word}: {value} at {_extent_in_words(results, cell)}")
    return "; ".join(said) + "."


def _runs_in_words(results: Stored, codes: np.ndarray) -> str:
    """Return the labels along the axis of a diagram, neighbors of one label together."""
    every, _, _ = label_codes(results)
    ends = [*(np.flatnonzero(np.diff(codes)) + 1).tolist(), codes.size]
    said, first = [], 0
    for end in ends[:MOST_NAMED]:
        cells = np.arange(first, end)
        said.append(f"{_extent_in_words(results, cells)}: {every[int(codes[first])]}")
        first = end
    others = len(ends) - len(said)
    more = f"; and {others} changes more" if others else ""
    return "Regimes along the axis: " + "; ".join(said) + f"{more}."
