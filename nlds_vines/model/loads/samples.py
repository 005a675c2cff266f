"""Two columns of a file, CSV or HDF5: time, and a force or an acceleration, each with its unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from nlds_vines.archives.durable import open_regular
from nlds_vines.errors import RequestError, choice, from_text, unknown
from nlds_vines.model.loads.load import ACCELERATIONS, FORCES

TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}
"""Units of time, in s."""

MOST_SAMPLES = 10**6
"""Samples of a record: hours of an accelerogram."""

_MOST_BYTES = 1 << 27
_HDF5 = (".h5", ".hdf5", ".nc")
_HEADING = re.compile(r"^\s*(?P<name>[^\[(]*?)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?\s*$")
"""A column's name, and its unit in brackets: `acceleration [g]`."""

_BETWEEN = re.compile(r"\s+(?![\[(])")
"""What is between headings where nothing else is; a unit belongs to what stands before it."""


class Samples(NamedTuple):
    """What a file holds: times [s], values, and the unit of these."""

    times: tuple[float, ...]
    values: tuple[float, ...]
    unit: str


class Column(NamedTuple):
    """A column of a file: its name and unit, empty where it has none, and its numbers."""

    name: str
    unit: str
    numbers: Sequence[float]


def samples_in(path: Path, column: str, unit: str, time_unit: str) -> Samples:
    """Return the samples in a file.

    Arguments: `column`, the name of that of the values, empty for the one after the time's; `unit`
    of the values and `time_unit`, empty for what the file says.

    Raises `RequestError`, one line with the file and the line, for what cannot be read.
    """
    columns = _of_archive(path) if path.suffix.lower() in _HDF5 else _of_text(path)
    if len(columns) < 2:
        raise RequestError(f"{path}: needs two columns, time and force or acceleration")
    time = next((one for one in columns if one.name.lower() in ("time", "t")), columns[0])
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
    if len(time.numbers) != len(found.numbers):
        raise RequestError(
            f"{path}: {len(time.numbers)} times for {len(found.numbers)} values of {found.name!r}"
        )
    return Samples(tuple(scale * t for t in time.numbers), tuple(found.numbers), of_values)


def _of_archive(path: Path) -> list[Column]:
    """Return the columns of an HDF5 file: its datasets of one dimension, with their `units`."""
    from nlds_vines.archives.archive import columns

    return [Column(name, unit, values.tolist()) for name, unit, values in columns(path)]


def _of_text(path: Path) -> list[Column]:
    """Return the columns of a text file: with or without a line of headings, `#` before notes."""
    lines = _lines(path)
    if not lines:
        raise RequestError(f"{path}: holds no numbers")
    (first, text), *_ = lines
    cut = next((mark for mark in (",", ";", "\t") if mark in text), None)
    words = _split(text, cut) if cut else _BETWEEN.split(text)
    headed = not _is_number(words[0])
    headings = [_HEADING.match(word) for word in words] if headed else [None] * len(words)
    rows: list[list[float]] = []
    for number, line in lines[headed:]:
        cells = _split(line, cut)
        if len(cells) != len(words):
            raise RequestError(
                f"{path}, line {number}: {len(cells)} columns; line {first} has {len(words)}"
            )
        rows.append([_number(f"{path}, line {number}: value", cell) for cell in cells])
    return [
        Column(*((h["name"], h["unit"] or "") if h else ("", "")), [row[i] for row in rows])
        for i, h in enumerate(headings)
    ]


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
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RequestError(f"{path}: not UTF-8 text at byte {error.start}") from None
    stripped = ((i, line.partition("#")[0].strip()) for i, line in enumerate(text.splitlines(), 1))
    found = [(i, line) for i, line in stripped if line]
    if len(found) > MOST_SAMPLES:
        raise RequestError(f"{path}: {len(found)} lines; allowed: up to {MOST_SAMPLES} samples")
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
