"""What a map or a diagram shows: choices, painted cells, legends, and a cell in words.

A picture is an array of codes and the color of each code, so that one message of a byte a cell
shows another number.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape
from typing import NamedTuple

import numpy as np
from bokeh.palettes import Viridis256

from nlds_vines.bifurcation.picture.choices import COEXISTING, REGIMES, SHARE
from nlds_vines.explore.map_data import NUMBERS, TOUCHES, Stored
from nlds_vines.model.axis import Axis
from nlds_vines.model.labels import by_frequency, coexisting, finals, most_frequent, share_of
from nlds_vines.model.parameters import described
from nlds_vines.model.quantities import BY_NAME, COORDINATES, ERROR
from nlds_vines.orbits.records import CAPTURE_FLAGS as CAPTURE
from nlds_vines.orbits.records import NOT_COMPUTED, OK, STATUS
from nlds_vines.plotting.palette import (
    COUNTS,
    HATCHED,
    OTHERS,
    RAMP,
    colors,
    drawn_as,
    ordered,
    short,
)
from nlds_vines.plotting.style import NAVY, NO_VALUE, start_colors

INK = "#3f77b5"
"""The color of a curve that stands alone: readable on a light page and on a dark one."""

CLEAR = "#00000000"
UNKNOWN = "not computed"
COMPUTED = ((UNKNOWN, CLEAR), ("computed", RAMP[0]), ("failed", OTHERS["failed"]))
"""What a map shows if the archive holds nothing else by which cells can be colored."""

MOST_SHARES = 6
"""The largest number of regimes whose share of the starts can be chosen."""

MOST_NAMED = 40
"""The largest number of regimes in a legend."""

MOST_POINTS = 2_000_000
"""The largest number of points of a diagram; of longer sections it shows the last periods."""

_SHADES = 254  # of numbers; codes 0 and 1 mean `not computed` and `no value`


class Places(NamedTuple):
    """Where the cells of an axis are drawn: at their values, or at 0, 1, 2 ... if uneven."""

    axis: Axis
    at: np.ndarray
    low: float
    high: float
    even: bool

    @classmethod
    def of(cls, axis: Axis) -> Places:
        """Return the places of the cells of an axis, and the outer edges of its first and last."""
        values, count = axis.values, axis.values.size
        step = (values[-1] - values[0]) / (count - 1) if count > 1 else abs(values[0]) or 1.0
        close = np.abs(values - values[0] - step * np.arange(count)) <= 1e-6 * abs(step) * count
        even = bool(close.all())
        at, size = (values, step) if even else (np.arange(count, dtype=float), 1.0)
        return cls(axis, at, float(at[0] - size / 2), float(at[-1] + size / 2), even)

    def nearest(self, place: float) -> int | None:
        """Return the index of the cell at a place; None outside the map."""
        inside = self.low <= place <= self.high
        return int(np.abs(self.at - place).argmin()) if inside else None

    def value(self, place: float) -> float:
        """Return the value of the parameter at a place."""
        return place if self.even else float(np.interp(place, self.at, self.axis.values))

    @property
    def label(self) -> str:
        """Meaning, symbol and unit."""
        entry = described(self.axis.name)
        return f"{entry.meaning.partition(';')[0]}, {in_brackets(entry.symbol, entry.unit)}"


def in_brackets(words: str, unit: str) -> str:
    """Return words followed by their unit in brackets, if there is one."""
    return words if unit == "1" else f"{words} [{unit}]"


def with_unit(value: float, unit: str, digits: int = 4) -> str:
    """Return a number with so many digits, and its unit."""
    text = f"{value:.{digits}g}".replace("-", "−")
    return text if unit == "1" else f"{text} {unit}"


# ---- what can be chosen --------------------------------------------------------------------------


@dataclass(frozen=True)
class Show:
    """One thing that a map or a diagram may show.

    Attributes:
        name, title: as in `--show`, and in words.
        column: the name of its `column`.
        of_start: whether each start has its own value.
        classes: word, color and shared name of each code; empty for numbers.
        unit, logarithmic: of numbers.
        points: whether a diagram draws it as the points of a section.
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


def shows_of(found: Stored) -> list[Show]:
    """Return what the map or the diagram of a scan may show, the default first."""
    is_map, shows = len(found.scan.axes) == 2, []
    if not is_map:
        shows = [*_points(found)]
    elif "label" in found:
        shows = [*_regimes(found)]
    if is_map and "capture" in found:
        words = [word.replace("_to_", ":").replace("_", " ") for word in CAPTURE]
        classes = ((UNKNOWN, CLEAR), *zip(words, COUNTS, strict=False))
        shows.append(Show("capture", "response by impacts a period", "capture", classes=classes))
    body = found.scan.system.scene.body
    for name in filter(found.__contains__, NUMBERS):
        one = BY_NAME[name]
        is_error = one.scale == ERROR
        shows.append(Show(name, one.title(body), name, unit=one.unit, logarithmic=is_error))
    return shows or [STATUS_SHOW]


def _points(found: Stored) -> Iterator[Show]:
    for name in ("x2", "x1", "x") if "section" in found else ():
        if name in found.scan.system.scene.components:
            title = f"displacement {COORDINATES[name][1]} of the section"
            yield Show(name, title, f"section {name}", unit="m", points=True)
    for name in filter(found.__contains__, TOUCHES):
        one = BY_NAME[name]
        yield Show(name, one.title(), name, unit=one.unit, points=True)


def _regimes(found: Stored) -> Iterator[Show]:
    classes = classes_of(found)
    if len(found.starts) == 1:
        yield Show(REGIMES, "regimes", "label", classes=classes)
        return
    yield Show(REGIMES, "regimes, most frequent", "most", False, classes)
    yield Show(f"{REGIMES} of a start", "regimes of a start", "label", classes=classes)
    last = len(COUNTS)
    words = [(f"{n} or more" if n == last else str(n), COUNTS[n - 1]) for n in range(1, last + 1)]
    counts = (("none known", OTHERS[HATCHED]), *words)
    yield Show(COEXISTING, "how many regimes coexist", COEXISTING, False, counts)
    for label in shared_labels(found):
        yield Show(f"{SHARE}{label}", f"share of the starts in {label}", f"{SHARE}{label}", False)


def shared_labels(found: Stored) -> list[str]:
    """Return the most frequent final regimes."""

    def count() -> list[str]:
        return [word for word, _ in by_frequency(finals(found.arrays["label"])) if word]

    labels: list[str] = found.once("shared labels", count)[:MOST_SHARES]
    return labels


def label_codes(found: Stored) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return the labels by code, and the codes of each orbit and of each cell's most frequent one.

    Code 0 is a cell that is not computed.
    """

    def encode() -> tuple[list[str], np.ndarray, np.ndarray]:
        labels = found.lanes("label").astype(np.str_)
        most = labels[:, 0]
        if len(found.starts) > 1:
            most = most_frequent(found.lanes("label")).astype(np.str_)
            most = np.where((labels == "").any(axis=-1), "", most)
        words, places = np.unique(np.column_stack([labels, most]), return_inverse=True)
        every = [UNKNOWN, *ordered({*words.tolist()} - {""})]
        code = {word: i for i, word in enumerate(every)} | {"": 0}
        codes = np.array([code[word] for word in words.tolist()], np.uint16)[places]
        codes = codes.reshape(len(labels), -1)
        return every, codes[:, :-1], codes[:, -1]

    encoded: tuple[list[str], np.ndarray, np.ndarray] = found.once("labels", encode)
    return encoded


def classes_of(found: Stored) -> tuple[tuple[str, ...], ...]:
    """Return word, color and name of all labels in the order of their codes.

    Regimes that are drawn in the same color share a name.
    """
    _, *words = label_codes(found)[0]
    shades = colors(words)
    named = ((short(word), shades[word], short(drawn_as(word))) for word in words)
    return ((UNKNOWN, CLEAR, UNKNOWN), *named)


def column(found: Stored, name: str) -> np.ndarray:
    """Return codes or numbers of all cells, shape (cells, starts); (cells, 1) if starts share one.

    Numbers are float32, NaN where they do not apply.  `capture` counts the codes of the archive
    from 1, `multiplier` is the modulus of the largest Floquet multiplier, `computed` holds codes
    of `COMPUTED`.
    """
    if name == "label":
        return label_codes(found)[1]
    if name == "most":
        return label_codes(found)[2][:, np.newaxis]
    if name == COEXISTING:
        return np.minimum(coexisting(found.lanes("label")), len(COUNTS))[:, np.newaxis]
    if name.startswith(SHARE):
        shares = share_of(found.lanes("label"), name.removeprefix(SHARE))
        return shares.astype(np.float32)[:, np.newaxis]
    if name == "capture":
        return (found.lanes(name) + 1).astype(np.uint8)
    if name == "computed":
        status = found.lanes("status")
        return np.select([status == NOT_COMPUTED, status == OK], [0, 1], 2).astype(np.uint8)
    if name == "multiplier":
        largest = found.lanes("multipliers")[:, :, 0]
        return np.hypot(largest[..., 0], largest[..., 1]).astype(np.float32)
    numbers = found.lanes(name).astype(np.float64)
    numbers[numbers == BY_NAME[name].fill] = np.nan
    with np.errstate(over="ignore"):
        return numbers.astype(np.float32)


# ---- pictures ------------------------------------------------------------------------------------


class Picture(NamedTuple):
    """Codes of what is seen, rows upward; the color of each code; the legend; the hatched code."""

    codes: np.ndarray
    palette: list[str]
    legend: str
    hatched: int = -1


def painted(found: Stored, show: Show, start: int) -> Picture:
    """Return a map as it is seen, of one start if starts differ."""
    values = column(found, show.column)
    values = values[:, start if show.of_start else 0].reshape(found.shape).T
    if show.classes:
        words = [word for word, *_ in show.classes]
        shades = [shade for _, shade, *_ in show.classes]
        dtype = np.uint8 if len(words) <= 256 else np.uint16
        hatched = words.index(HATCHED) if HATCHED in words else -1
        legend = shares_legend(show.classes, values)
        return Picture(values.astype(dtype), shades, legend, hatched)
    known = values[np.isfinite(values) & ((values > 0) | (not show.logarithmic))]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    if show.name.startswith(SHARE):
        low, high = 0.0, 1.0
    part = _part_of_range(values, low, high, show.logarithmic)
    codes = np.where(np.isfinite(part), 2 + np.floor(np.clip(part, 0, 0.999) * _SHADES), 1)
    status = found.lanes("status")
    unknown = status[:, start] if show.of_start else status.min(axis=1)
    codes[unknown.reshape(found.shape).T == NOT_COMPUTED] = 0
    palette = [CLEAR, NO_VALUE, *Viridis256[: _SHADES + 1]]
    return Picture(codes.astype(np.uint8), palette, _ramp_legend(show, low, high))


def _part_of_range(values: np.ndarray, low: float, high: float, logarithmic: bool) -> np.ndarray:
    """Return where numbers stand between two, from 0 to 1; NaN for those that have no place."""
    if low == high:
        return np.where(np.isfinite(values), 0.0, np.nan)
    if logarithmic:
        values = np.where(values >= 0, np.log(np.maximum(values, low)), np.nan)
        low, high = np.log(low), np.log(high)
    return (values - low) / (high - low)


def painted_strip(found: Stored) -> Picture:
    """Return the regimes along the axis of a diagram, a row for each start, the first on top."""
    classes = classes_of(found)
    codes = label_codes(found)[1]
    return Picture(codes.T[::-1].copy(), [one[1] for one in classes], "")


def diagram_values(found: Stored, show: Show) -> np.ndarray:
    """Return what a diagram draws, shape (cells, starts, points)."""
    if not show.points:
        return column(found, show.column)[..., np.newaxis]
    most = max(1, MOST_POINTS // found.scan.lanes)
    if show.column.startswith("section "):
        place = found.scan.system.scene.components.index(show.name)
        return found.lanes("section")[:, :, -most:, place]
    return found.lanes(show.column)[..., :most]


def diagram_colors(found: Stored) -> list[str]:
    """Return the color of each start in a diagram."""
    return [INK if shade == NAVY else shade for shade in start_colors(found.starts)]


def painted_diagram(
    found: Stored, show: Show, window: tuple[float, float, float, float], size: tuple[int, int]
) -> Picture:
    """Return the dots of a diagram in a window (x0, x1, y0, y1), in so many pixels.

    The cost of the picture does not depend on the number of dots, and they stay fine in any zoom.
    """
    (x0, x1, y0, y1), (width, height) = window, size
    values, places = diagram_values(found, show), Places.of(found.scan.axes[0])
    with np.errstate(invalid="ignore", over="ignore"):
        columns = np.rint((places.at - x0) / (x1 - x0) * (width - 1))
        rows = np.rint((values - y0) / (y1 - y0) * (height - 1))
        seen = (rows >= 0) & (rows < height)
    seen &= ((columns >= 0) & (columns < width))[:, np.newaxis, np.newaxis]
    across = 3 if not show.points else 2 if places.at.size < width / 1.5 else 1
    codes = np.zeros((height + 2, width + 2), np.uint8)
    shades = diagram_colors(found)
    for k in range(len(found.starts)):
        cells, points = np.nonzero(seen[:, k])
        u, v = columns[cells].astype(int), rows[cells, k, points].astype(int)
        for du in range(across):
            for dv in range(across):
                codes[v + dv, u + du] = 1 + k % 255
    legend = ""
    if len(shades) > 1:
        legend = "".join(map(_chip, shades[:MOST_NAMED], found.starts[:MOST_NAMED]))
    if "label" in found:
        legend += shares_legend(classes_of(found), label_codes(found)[1])
    middle = slice(across // 2, across // 2 + height), slice(across // 2, across // 2 + width)
    return Picture(codes[middle], [CLEAR, *shades[:255]], legend)


# ---- legends and words ---------------------------------------------------------------------------


def shares_legend(classes: Iterable[tuple[str, ...]], codes: np.ndarray) -> str:
    """Return the legend of regimes with their shares; those of one color are one entry."""
    counts = np.bincount(codes.ravel().astype(int)).tolist()
    groups: dict[str, tuple[str, int]] = {}
    for (word, shade, *shared), count in zip(classes, counts, strict=False):
        name = shared[0] if shared else word
        if count:
            groups[name] = shade, count + groups.get(name, ("", 0))[1]
    named = sorted(groups, key=lambda name: -groups[name][1])[:MOST_NAMED]
    entries = [
        _chip(groups[name][0], f"{name}  {_percent(groups[name][1] / codes.size)}", name == HATCHED)
        for name in groups
        if name in named
    ]
    rest = len(groups) - len(named)
    return "".join(entries) + (f"<span>and {rest} more</span>" if rest else "")


def _percent(share: float) -> str:
    return (
        f"{share:.1%}".replace("%", " %") if share < 0.0995 else f"{share:.0%}".replace("%", " %")
    )


def _chip(shade: str, words: str, hatched: bool = False) -> str:
    kind = "chip hatched" if hatched else "chip"
    return f'<span><i class="{kind}" style="background-color:{shade}"></i>{escape(words)}</span>'


def _ramp_legend(show: Show, low: float, high: float) -> str:
    ends = [with_unit(end, show.unit) for end in (low, high)]
    if show.name.startswith(SHARE):
        ends = ["0 %", "100 %"]
    shades = ",".join(Viridis256[: _SHADES + 1 : 15])
    bar = f'<i class="chip ramp" style="background:linear-gradient(90deg,{shades})"></i>'
    scale = ", logarithmic" if show.logarithmic else ""
    return f"<span>{escape(ends[0])} {bar} {escape(ends[1])}{scale}</span>"


def told(found: Stored) -> list[list[str]]:
    """Return the numbers of a cell: column, words, unit and column of the half width of each."""
    body = found.scan.system.scene.body
    widths = {BY_NAME[name].width for name in NUMBERS}
    rows = [
        [name, BY_NAME[name].title(body), BY_NAME[name].unit, BY_NAME[name].width]
        for name in NUMBERS
        if name in found and name not in widths
    ]
    if "multipliers" in found:
        rows.append(["multiplier", "largest multiplier |μ|", "1", ""])
    return rows


def values_in_words(axis: Axis) -> list[str]:
    """Return the values of an axis: `ω = 7.4 rad/s`."""
    entry = described(axis.name)
    return [f"{entry.symbol} = {with_unit(float(value), entry.unit, 6)}" for value in axis.values]


def place_in_words(found: Stored, cell: tuple[int, int]) -> str:
    """Return the varied parameters of a cell: `ω = 7.4 rad/s, P = 800 N`."""
    pairs = zip(found.scan.axes, cell, strict=False)
    return ", ".join(values_in_words(axis)[i] for axis, i in pairs)


def cell_in_words(found: Stored, cell: tuple[int, int], start: int) -> str:
    """Return what the archive holds of a cell, as lines of HTML."""
    row, lines = cell[0] * found.shape[1] + cell[1], [place_in_words(found, cell)]
    several = len(found.starts) > 1
    head = found.starts[start] if several else ""
    if "label" in found:
        labels = found.lanes("label")[row].tolist()
        label = labels[start] or UNKNOWN
        head = f"{label} ({head})" if head else label
        if several:
            counts = sorted({(-labels.count(one), one or UNKNOWN) for one in labels})
            lines.append("all starts: " + ", ".join(f"{one} × {-n}" for n, one in counts))
    for name, words, unit, width in told(found):
        source = "multipliers" if name == "multiplier" else name
        value = _number(found, source, row, start)
        if value is not None:
            half = _number(found, width, row, start) if width in found else None
            text = f"{value:.4g} ± {half:.2g}" if half else f"{value:.4g}"
            lines.append(f"{words}: {text}" + ("" if unit == "1" else f" {unit}"))
    status = int(found.lanes("status")[row, start])
    if status not in (OK, NOT_COMPUTED):
        lines.append(f"status: {STATUS[status].name if status in STATUS else status}")
    return "<br>".join([f"<b>{escape(head)}</b>" if head else "", *map(escape, lines)][not head :])


def _number(found: Stored, name: str, row: int, start: int) -> float | None:
    """Return one number of an orbit; None where it does not apply."""
    value = found.lanes(name)[row, start]
    if name == "multipliers":
        value = np.hypot(*value[0])
    elif value == BY_NAME[name].fill:
        return None
    return float(value) if np.isfinite(value) else None
