"""Two columns of a file, CSV or HDF5: time, and a force or an acceleration, each with its unit."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from nlds_vines.archives.files import open_regular
from nlds_vines.errors import RequestError, choice, from_text, unknown
from nlds_vines.model.loads.load import ACCELERATIONS, FORCES

TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}
"""Units of time, in s."""

MOST_SAMPLES = 10**6
"""Samples of a record: hours of an accelerogram."""

_MOST_BYTES = 1 << 27
_MOST_LETTERS = 10_000  # of a line
_HDF5 = (".h5", ".hdf5", ".nc")
_HEADING = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\[(\])]*[\])])?")
"""A heading between blanks: a name, and its unit in brackets, which may stand apart from it."""


class Samples(NamedTuple):
    """What a file holds: times [s], values, and the unit of these."""

    times: tuple[float, ...]
    values: tuple[float, ...]
    unit: str


class Column(NamedTuple):
    """A column of a file: its name and unit, empty if it has none, and a reader of its numbers."""

    name: str
    unit: str
    read: Callable[[], list[float]]


def samples_in(path: Path, column: str, unit: str, time_unit: str) -> Samples:
    """Return the samples in a file.

    Arguments: `column`, the name of that of the values, empty for the first beside the time; `unit`
    of the values and `time_unit`, empty for what the file says.

    The time is the column `time` or `t`; without one, the first column of a text, and the only
    ascending dataset of an HDF5 file, which has no order.  No other column is read.

    Raises `RequestError`, one line with the file and the line, for what cannot be read.
    """
    is_hdf5 = path.suffix.lower() in _HDF5
    columns = _of_archive(path) if is_hdf5 else _of_text(path)
    if len(columns) < 2:
        raise RequestError(f"{path}: needs two columns, time and force or acceleration")
    named_time = (one for one in columns if one.name.lower() in ("time", "t"))
    time = next(named_time, None) or (_ascending(path, columns) if is_hdf5 else columns[0])
    others = [one for one in columns if one is not time]
    if column:
        named = {one.name: one for one in others}
        if column not in named:
            raise unknown(f"column of {path}", column, named)
        found = named[column]
    else:
        found = others[0]
    of_values, of_time = unit or found.unit, time_unit or time.unit or "s"
    if not of_values:
        raise RequestError(
            f"{path}: give the unit of column {found.name or 2!r}, in its heading as "
            f"`acceleration [g]` or as unit; allowed: {', '.join((*FORCES, *ACCELERATIONS))}"
        )
    choice(f"unit of {path}", of_values, (*FORCES, *ACCELERATIONS))
    scale = TIMES[choice(f"unit of time of {path}", of_time, TIMES)]
    times, values = time.read(), found.read()
    if len(times) != len(values):
        raise RequestError(f"{path}: {len(times)} times for {len(values)} values of {found.name!r}")
    return Samples(tuple(scale * t for t in times), tuple(values), of_values)


def _ascending(path: Path, columns: list[Column]) -> Column:
    """Return the only column whose numbers ascend; raise `RequestError` if none or several do."""
    ascending = [one for one in columns if _ascends(one.read())]
    if len(ascending) != 1:
        raise RequestError(
            f"{path}: {len(ascending)} of the datasets {', '.join(one.name for one in columns)} "
            "ascend; allowed: one alone, or a dataset `time` or `t`"
        )
    return ascending[0]


def _ascends(numbers: list[float]) -> bool:
    return len(numbers) > 1 and all(a < b < math.inf for a, b in pairwise(numbers))


def _of_archive(path: Path) -> list[Column]:
    """Return the columns of an HDF5 file: its datasets of one dimension, with their `units`."""
    from nlds_vines.archives import archive

    def read(name: str) -> list[float]:
        return list(archive.column(path, name, MOST_SAMPLES).tolist())

    return [Column(name, unit, partial(read, name)) for name, unit in archive.columns(path)]


def _of_text(path: Path) -> list[Column]:
    """Return the columns of a text file: with or without a line of headings, `#` before notes."""
    lines = _lines(path)
    if not lines:
        raise RequestError(f"{path}: holds no numbers")
    (first, text), *_ = lines
    cut = next((mark for mark in (",", ";", "\t") if mark in text), None)
    words = _split(text, cut)
    headed = not _is_number(words[0])
    if headed and not cut:
        words = _HEADING.findall(text)
    rows = lines[headed:]
    if len(rows) > MOST_SAMPLES:
        raise RequestError(f"{path}: more than {MOST_SAMPLES} samples, which are allowed")

    def read(i: int) -> list[float]:
        numbers = []
        for number, line in rows:
            cells = _split(line, cut)
            if len(cells) != len(words):
                raise RequestError(
                    f"{path}, line {number}: {len(cells)} columns; line {first} has {len(words)}"
                )
            numbers.append(_number(f"{path}, line {number}: value", cells[i]))
        return numbers

    headings = [_heading(word) if headed else ("", "") for word in words]
    return [Column(name, unit, partial(read, i)) for i, (name, unit) in enumerate(headings)]


def _heading(word: str) -> tuple[str, str]:
    """Return a column's name, and its unit in brackets: `acceleration [g]`."""
    name, _, rest = word.replace("(", "[").partition("[")
    return name.strip(), rest.replace(")", "]").partition("]")[0].strip()


def _lines(path: Path) -> list[tuple[int, str]]:
    """Return the lines of a text file with their numbers, without empty ones and notes."""
    try:
        with open_regular(path) as file:
            content = file.read(_MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{path}: cannot be read: {reason}") from None
    if len(content) > _MOST_BYTES:
        raise RequestError(f"{path}: has more than {_MOST_BYTES} bytes")
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RequestError(f"{path}: not UTF-8 text at byte {error.start}") from None
    found: list[tuple[int, str]] = []
    lines = io.TextIOWrapper(io.BytesIO(content), encoding="utf-8-sig")  # one at a time
    for i, line in enumerate(lines, 1):
        if len(line) > _MOST_LETTERS:
            raise RequestError(f"{path}, line {i}: has more than {_MOST_LETTERS} letters")
        if stripped := line.partition("#")[0].strip():
            found.append((i, stripped))
        if len(found) > MOST_SAMPLES + 1:  # and a heading
            break
    return found


def _split(line: str, cut: str | None) -> list[str]:
    return [word.strip() for word in line.split(cut)]


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _number(what: str, text: str) -> float:
    """Return a number; `RequestError` for a text that is none, and for an empty one."""
    if not text:
        raise RequestError(f"{what} is missing")
    return from_text(float, what, text)
