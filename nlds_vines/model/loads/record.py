"""Records: samples of a force or of the ground's acceleration, joined by lines or a spline.

`RecordFile.read` returns the samples in a file: accelerograms of PEER, CSMIP, COSMOS and SMC,
tables of text, HDF5.  A format is a function that recognizes its files and reads them (`FORMATS`);
every other text is a table, or numbers at a constant step `dt`.
"""

from __future__ import annotations

import codecs
import csv
import math
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass
from functools import cache, cached_property, partial
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from nlds_vines.archives.files import open_regular
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import RequestError, at, from_text, number, shown, table, unknown, whole
from nlds_vines.model.loads.courses import TIME, UNITS, Course, canonical, polynomial, unit_in
from nlds_vines.model.setting import (
    OneOf,
    Real,
    Text,
    Truth,
    Whole,
    check_settings,
    setting,
    settings_of,
)

LINEAR, CUBIC = "linear", "cubic"
GAP = 1.5  # a step this many times the median one is a gap
MOST_SAMPLES = 10**6  # samples of a record: hours of an accelerogram
MOST_BYTES = 1 << 26  # bytes of a text
HEADER = 40  # lines in which a format states what follows
TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}  # units of time, in s
_TIME_UNITS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("ms", "msec", "msecs", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("min", "minute", "minutes"), "min"),
}
_TIME_NAMES = ("time", "t", "times", "zeit", "temps", "tiempo", "tempo", "tid")

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?")
_PLAIN = re.compile(r"[0-9eE+\-. ]*")  # of these signs `float` reads what `_NUMBER` is, no more
_NOT_FINITE = ("nan", "+nan", "-nan", "inf", "+inf", "-inf")
_NOTES = ("#", "%", "//", "!", "|")  # marks before comments
_NOTE = re.compile(rf"\s*(?:{'|'.join(map(re.escape, _NOTES))})")
_SIGNS = {0x2212: "-", 0xA0: " ", 0x2009: " ", 0x202F: " ", 0xFEFF: None, 0x1A: None}
_HDF5 = (".h5", ".hdf5", ".nc")
# a heading between blanks: a name, and its unit in brackets, which may stand apart from it
_HEADING = re.compile(r"\"[^\"]*\"|[^\s\[(]+(?:\s*[\[(][^\[(\])]*[\])])?")


class Column(NamedTuple):
    name: str  # "" if it has none
    unit: str
    read: Callable[[], list[float]]


class Content(NamedTuple):
    columns: list[Column]
    dt: float = 0.0  # step of the samples [s]; 0: a column has times
    format: str = ""
    is_ordered: bool = True


Lines = list[tuple[int, str]]  # the lines of a text that are not empty, with their numbers


def _column(name: str, value: Any, /) -> int | str:
    if isinstance(value, str):
        is_number = value.isascii() and value.isdigit()
        return from_text(int, name, value) if is_number else value
    return whole(name, value, 0)


@dataclass(frozen=True, kw_only=True)
class RecordFile:
    """A file of samples, and what it does not say of itself."""

    table: ClassVar[str] = "load.record"

    file: str = setting(MISSING, Text(), "", "path of a file, in place of `times` and `values`")
    dt: float = setting(0.0, Real(0.0, 1e6), "", "step between the samples of a file [s]")
    skip: int = setting(0, Whole(0, 10**6), "", "lines to leave out at the beginning of a file")
    column: int | str = setting(
        "", _column, "",
        "name or number of the column of the values; 0: all numbers of a file, row by row",
    )  # fmt: skip
    time_unit: str = setting("", OneOf(("", *TIMES), "time_unit"), "", "`s`, `ms` or `min`")
    decimal: str = setting("", OneOf(("", ".", ","), "decimal"), "", "decimal sign: `.` or `,`")

    def __post_init__(self) -> None:
        check_settings(self)

    def read(self, unit: str) -> dict[str, Any]:
        """Return the settings of the record in the file; `unit` may override that of its values.

        A file that can be read in several ways is refused; the message names the key that chooses.
        """
        content = self._content(Path(self.file))
        columns, notes = content.columns, [content.format] if content.format else []
        if content.dt and self.dt and not math.isclose(self.dt, content.dt, rel_tol=1e-6):
            raise RequestError(f"dt = {self.dt:g} s, but the file has steps of {content.dt:g} s")
        dt = content.dt or self.dt
        has_unit = unit or any(one.unit for one in columns)
        also = "" if has_unit else f"; give unit, too, of its values: {', '.join(UNITS)}"
        time = None if dt else _time_of(content, also)
        if self.dt and (stamps := next(filter(_is_time, columns), None)):
            name = _name_of(stamps, columns)
            raise RequestError(f"dt = {self.dt:g} s stands beside {name}, which has times")
        others = [one for one in columns if one is not time]
        # the values: the first other column, or the one with the name or the number that is given
        column = others[0]
        if self.column not in ("", 0):
            names = {one.name.lower(): one for one in reversed(others) if one.name}
            chosen = names.get(str(self.column).lower())
            if chosen is None and isinstance(self.column, int) and self.column <= len(columns):
                chosen = columns[self.column - 1]
            if chosen is None or chosen is time:
                allowed = [one.name or str(columns.index(one) + 1) for one in others]
                raise unknown("column", str(self.column), allowed)
            column = chosen
        name = _name_of(column, columns)
        if not unit and not column.unit:
            raise RequestError(
                f"give the unit of {name}, in its heading as `acceleration [g]` or as unit; "
                f"allowed: {', '.join(UNITS)}"
            )
        unit = unit or unit_in(f"unit of {name}", column.unit)
        values = column.read()
        if time is None:
            times = [dt * i for i in range(len(values))]
        else:
            time_unit = _TIME_UNITS.get((self.time_unit or time.unit or "s").lower())
            if time_unit is None:
                words = ", ".join(TIMES)
                raise RequestError(f"unit of time {time.unit!r}; allowed as time_unit: {words}")
            times = [TIMES[time_unit] * t for t in time.read()]
            if len(times) != len(values):
                text = f"{len(times)} times for {len(values)} values of {column.name!r}"
                raise RequestError(text)
            if not _is_time(time):
                notes.append(f"times [{time_unit}] in {_name_of(time, columns)}")
        unused = [_name_of(one, columns) for one in others if one is not column]
        if unused and self.column == "":
            notes.append(f"values in {name}, not in {', '.join(unused)}")
        return {"times": times, "values": values, "unit": unit, "reading": "; ".join(notes)[:200]}

    def _content(self, path: Path) -> Content:
        is_hdf5 = path.suffix.lower() in _HDF5
        try:
            with open_regular(path) as file:
                data = bytes(file.read(8 if is_hdf5 else MOST_BYTES + 1))
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise RequestError(f"cannot be read: {reason}") from None
        if is_hdf5 or data.startswith(b"\x89HDF\r\n\x1a\n"):
            from nlds_vines.archives import archive

            def read(name: str) -> list[float]:
                return list(archive.column(path, name, MOST_SAMPLES).tolist())

            # datasets of one dimension, of which none is read before it is chosen
            names = archive.columns(path)
            columns = [Column(name, unit, cache(partial(read, name))) for name, unit in names]
            if not columns:
                raise RequestError("has no datasets of numbers with one dimension")
            return Content(columns, is_ordered=False)
        texts = _lines_in(data)[self.skip :]
        del data  # which may be 64 MB
        lines = [(i, text) for i, text in enumerate(texts, self.skip + 1) if text.strip()]
        if not lines:
            raise RequestError("holds no numbers")
        contents = (reads(lines) for reads in FORMATS)
        return next(filter(None, contents), None) or _table(lines, self)


def _time_of(content: Content, also: str) -> Column:
    """Return the column of the times: a named one, or the first if it ascends."""
    columns = content.columns
    if len(columns) < 2:
        text = "needs two columns, time and force or acceleration; one column needs dt, its step"
        raise RequestError(f"{text}{also}")
    if named := [one for one in columns if _is_time(one)]:
        return named[0]
    candidates = columns[:1] if content.is_ordered else columns
    ascending = [one for one in candidates if _ascends(one.read())]
    if len(ascending) == 1:
        return ascending[0]
    if content.is_ordered:
        raise RequestError(
            "its first column has no ascending times: give dt, the step of its samples, or a "
            f"heading with `time`{also}"
        )
    names = ", ".join(one.name for one in columns)
    raise RequestError(
        f"{len(ascending)} of the datasets {names} ascend; allowed: one alone, a dataset `time` or "
        f"`t`, or dt, the step of the samples{also}"
    )


def _is_time(column: Column) -> bool:
    return column.name.lower() in _TIME_NAMES or column.unit.lower() in _TIME_UNITS


def _name_of(column: Column, columns: Sequence[Column]) -> str:
    name = column.name or columns.index(column) + 1
    return f"column {name}" if len(columns) > 1 else "its values"


def _ascends(numbers: list[float]) -> bool:
    return len(numbers) > 1 and all(a < b < math.inf for a, b in pairwise(numbers))


# ---- text ----------------------------------------------------------------------------------------


def _lines_in(data: bytes) -> list[str]:
    if len(data) > MOST_BYTES:
        raise RequestError(f"has more than {MOST_BYTES} bytes")
    if data.startswith((b"PK\x03\x04", b"\x1f\x8b")):
        raise RequestError("is a workbook or compressed; allowed: text (CSV) and HDF5")
    is_utf16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    encodings = ["utf-16"] if is_utf16 else ["utf-8-sig", "latin-1"]
    if not is_utf16 and 0 in data[:100]:
        encodings = ["utf-16-le" if 0 in data[1:100:2] else "utf-16-be"]
    for encoding in encodings:
        try:
            text = data.decode(encoding)
            break
        except UnicodeDecodeError as error:
            reason = f"is no text: {encoding} fails at byte {error.start}"
    else:
        raise RequestError(reason)
    if "\0" in text[:10_000]:
        raise RequestError("is no text: it holds the character 0")
    if not text.isascii() or "\x1a" in text:
        text = text.translate(_SIGNS)
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _number(cell: str) -> float | None:
    if _NUMBER.fullmatch(cell):
        return float(cell.replace("D", "E").replace("d", "e"))
    return float(cell) if cell.lower() in _NOT_FINITE else None


def _numbers(cells: Sequence[str], decimal: str = ".") -> list[float] | None:
    text = " ".join(cells)
    if decimal == ",":
        if "." in text:
            return None
        cells, text = [cell.replace(",", ".") for cell in cells], text.replace(",", ".")
    if _PLAIN.fullmatch(text):
        try:
            return [*map(float, cells)] or None
        except ValueError:
            return None
    numbers = [_number(cell) for cell in cells]
    return None if None in numbers else [value for value in numbers if value is not None]


class Dialect(NamedTuple):
    """What stands between the cells of a table (None: blanks), and its decimal sign."""

    cut: str | None
    decimal: str

    def cells(self, text: str, width: int = 0) -> list[str]:
        """Return the cells of a line, without an empty one beyond `width` at its end."""
        cells = text.strip().split(self.cut)
        if '"' in text:
            cut = self.cut or " "
            try:
                cells = next(csv.reader([text.strip()], delimiter=cut, skipinitialspace=True))
            except csv.Error:
                return []
        if len(cells) > max(width, 1) and not cells[-1].strip():
            cells = cells[:-1]
        return [cell.strip() for cell in cells]

    def numbers(self, text: str) -> list[float] | None:
        return _numbers(self.cells(text), self.decimal)

    def columns(self, rows: Lines, width: int) -> list[list[float]] | None:
        """Return the columns of rows that have `width` numbers each; None for any other rows."""
        texts = [text for _, text in rows]
        if self.cut is None:
            cells = [cell for text in texts for cell in text.split()]
            is_even = {len(text.split()) for text in texts} == {width}
        else:
            cells = self.cut.join(texts).split(self.cut)
            is_even = {text.count(self.cut) for text in texts} == {width - 1}
        numbers = _numbers(cells, self.decimal) if is_even else None
        return None if numbers is None else [numbers[i::width] for i in range(width)]


BLANKS = Dialect(None, ".")


def _row_by_row(
    lines: Lines, count: int = MOST_BYTES, width: int = 0, dialect: Dialect = BLANKS
) -> list[float]:
    """Return the first `count` numbers of lines, in fields of a `width` if Fortran wrote them."""
    numbers: list[float] = []
    for place, text in lines:
        if len(numbers) >= count:
            break
        fields = [text[i : i + width].strip() for i in range(0, len(text), width)] if width else []
        row = _numbers([cell for cell in fields if cell]) or dialect.numbers(text)
        if row is None:
            raise RequestError(f"line {place}: {shown(text.strip())} must hold numbers alone")
        numbers += row
    return numbers


def _series(lines: Lines, begin: int, count: int, width: int = 0) -> list[float]:
    if not 2 <= count <= MOST_SAMPLES:
        raise RequestError(f"{count} samples; allowed: 2 to {MOST_SAMPLES}")
    numbers = _row_by_row(lines[begin:], count, width)
    if len(numbers) != count:
        raise RequestError(f"the header states {count} values, {len(numbers)} follow")
    return numbers


# ---- formats -------------------------------------------------------------------------------------

_PEER = re.compile(
    r"NPTS\s*=\s*(\d+)[\s,]*DT\s*=\s*([\d.EeDd+-]+)|(\d+)[\s,]+([\d.EeDd+-]+)\s+NPTS,?\s*DT",
    re.IGNORECASE,
)
_UNITS_OF = re.compile(r"\bUNITS?\s*(?:OF|:|=)\s*(\S+)", re.IGNORECASE)
_CSMIP = re.compile(
    r"(?P<count>\d+) points of accel data equally spaced at *(?P<dt>[\d.]+) *sec"
    r"(?:\W* (?:in|units:?) +(?P<unit>[^\s()]+))?",
    re.IGNORECASE,
)
_COSMOS = re.compile(
    r"(?P<count>\d+)\s+acceleration\s+pts,\s*approx\s+(?P<seconds>[\d.]+)\s+secs?,\s*"
    r"units\s*=\s*(?P<unit>[^\s(,]+)",
    re.IGNORECASE,
)
_BRACKETED = re.compile(r"[\[(]([^\[\]()]{1,20})[\])]")
_FORTRAN = re.compile(r"\(\s*\d*[FEDGI](\d+)", re.IGNORECASE)
_REALS = re.compile(r"(\d+)\s+Real-header values follow", re.IGNORECASE)
_SMC = re.compile(r"\s*[12]\s+(?:UN)?CORRECTED ACCELEROGRAM")


def _peer(lines: Lines) -> Content | None:
    """PEER .AT2: a header with NPTS, DT and the unit, then five or eight values a line."""
    head = [text[:200] for _, text in lines[:HEADER]]
    for i, text in enumerate(head):
        match = _PEER.search(text)
        if not match:
            continue
        title = " ".join(head[: i + 1])
        if other := re.search(r"\b(velocity|displacement)\b", title, re.IGNORECASE):
            raise RequestError(f"holds a {other[1].lower()}; needs an acceleration or a force")
        named = _UNITS_OF.search(title)
        count, dt = int(match[1] or match[3]), match[2] or match[4]
        if sum(len(text.split()) for _, text in lines[i + 1 :]) > count:
            raise RequestError(f"the header states {count} values, more follow")
        read = cache(partial(_series, lines, i + 1, count))
        unit = named[1].strip(".,;") if named else ""
        return Content([Column("", unit, read)], _step(dt), "PEER")
    return None


def _step(text: str) -> float:
    dt = _number(text)
    if dt is None or not 0.0 < dt < math.inf:
        raise RequestError(f"its header states a step of {text!r} s; dt must be above 0")
    return dt


def _width(line: str) -> int:
    """Return the width of the fields that a header states in Fortran's words; 0 if it does not."""
    field = _FORTRAN.search(line[:200])
    return int(field[1]) if field else 0


def _volume(lines: Lines) -> Content | None:
    """CSMIP .V2 and COSMOS: the accelerations of one channel or several, each below a header.

    CSMIP: `7601 points of accel data equally spaced at .005 sec, in ...`; COSMOS: integer and real
    headers, then `7601 acceleration pts, approx 38 secs, units=...`.  The step of the latter is
    real header 62 [ms], or 34 [s]; it must agree with the duration beside the values.
    """
    whole = "\n".join([text for _, text in lines]).lower()
    if "points of accel" not in whole and "pts," not in whole:
        return None
    marked = [(i, text[:200]) for i, (_, text) in enumerate(lines) if "accel" in text.lower()]
    heads = [(i, match) for i, text in marked if (match := _CSMIP.search(text))]
    if heads:
        steps = {_step(match["dt"]) for _, match in heads}
        if len(steps) > 1:
            raise RequestError(f"its channels have the steps {sorted(steps)} s; allowed: one step")
        dt, name = steps.pop(), "CSMIP"
    else:
        heads = [(i, match) for i, text in marked if (match := _COSMOS.search(text))]
        texts = ((i, text[:200]) for i, (_, text) in enumerate(lines) if heads)
        reals = [(i, match) for i, text in texts if (match := _REALS.search(text))]
        if not reals:
            return None
        (begin, real), head = reals[0], heads[0][1]
        header = _row_by_row(lines[begin + 1 :], int(real[1]), _width(lines[begin][1]))
        count, seconds = int(head["count"]), float(head["seconds"])
        header += [0.0] * 62
        choices = [header[61] * 1e-3, header[33]]
        agree = [h for h in choices if h > 0.0 and abs(count * h - seconds) <= 1.5 + 0.02 * seconds]
        if not agree:
            raise RequestError(
                f"its headers state steps of {choices[0]:g} and {choices[1]:g} s for {count} "
                f"values in {seconds:g} s; copy the values into a file of their own, and give dt"
            )
        dt, name = agree[0], "COSMOS"
    columns = [
        Column(
            f"channel {channel}" if len(heads) > 1 else "",
            (match["unit"] or "").strip(".,;"),
            partial(_series, lines, i + 1, int(match["count"]), _width(lines[i][1])),
        )
        for channel, (i, match) in enumerate(heads, 1)
    ]
    return Content(columns, dt, name)


def _smc(lines: Lines) -> Content | None:
    """USGS SMC: 11 lines of text, 48 integers, 50 reals, comments, then values [cm/s^2].

    Integer 16 counts the comments, 17 the values; real 2 is the number of samples a second.
    """
    if not _SMC.match(lines[0][1][:200]):
        return None
    integers, reals = _row_by_row(lines[11:17], 48, 10), _row_by_row(lines[17:27], 50, 15)
    if len(integers) < 48 or len(reals) < 50 or not reals[1] > 0.0:
        raise RequestError("its headers must hold 48 integers and 50 reals")
    begin = 27 + max(0, int(integers[15]))
    read = partial(_series, lines, begin, int(integers[16]), 10)
    return Content([Column("", "cm/s^2", read)], 1.0 / reals[1], "SMC")


def _counted(lines: Lines) -> Content | None:
    """Titles, a line with the number of values and their step [s], then the values."""
    for i, (place, text) in enumerate(lines[:HEADER]):
        cells = text[:200].split()
        row = _numbers(cells)
        if row is None:
            continue
        if len(row) != 2 or not cells[0].isdigit() or not 0.0 < (dt := row[1]) <= 10.0:
            return None
        count, rows = int(cells[0]), [text.split() for _, text in lines[i + 1 :]]
        if count < 3 or sum(map(len, rows)) != count:
            return None
        if all(len(one) == 2 for one in rows):
            first = [float(count), *(_number(one[0]) or 0.0 for one in rows)]
            if _ascends(first):
                raise RequestError(
                    f"line {place} states {count} values at steps of {dt:g} s, or is the "
                    "first row of two columns: skip and dt choose the former, a heading the latter"
                )
        read = partial(_series, lines, i + 1, count)
        return Content([Column("", _unit_in_titles(lines[:i]), cache(read))], dt, "counted values")
    return None


def _unit_in_titles(lines: Lines) -> str:
    title = " ".join(text[:200] for _, text in lines[-3:])
    if match := _UNITS_OF.search(title):
        return match[1].strip(".,;")
    words = [match[1] for match in _BRACKETED.finditer(title) if _is_unit(match[1])]
    return words[-1] if words else ""


FORMATS: tuple[Callable[[Lines], Content | None], ...] = (_peer, _volume, _smc, _counted)
"""The formats that state how many values follow, and their step."""


# ---- tables --------------------------------------------------------------------------------------


_DIALECTS = (
    *(Dialect(cut, decimal) for cut in (";", "\t") for decimal in (".", ",")),
    Dialect(",", "."), BLANKS, Dialect(None, ","), Dialect(",", ","),
)  # fmt: skip


def _table(lines: Lines, keys: RecordFile) -> Content:
    body, whole = lines, "\n".join([text for _, text in lines])
    if any(mark in whole for mark in _NOTES):
        cut = ((i, text.partition("#")[0]) for i, text in lines)
        body = [(i, text) for i, text in cut if text.strip() and not _NOTE.match(text)]
    dialect, width = _dialect(body, keys.decimal)
    may_flow = keys.column == 0 or (keys.dt > 0.0 and keys.column == "")
    begin = 0
    while (row := dialect.numbers(body[begin][1])) is None or not (len(row) == width or may_flow):
        if row is not None:
            raise RequestError(
                f"line {body[begin][0]} has {len(row)} numbers where later lines have {width}: "
                f"skip = {body[begin][0]} leaves it out"
            )
        begin += 1
    rows = body[begin:]
    titles = [*takewhile(lambda line: line[0] < rows[0][0], lines)]
    headings = _headings(titles, dialect, width)
    if len(rows) > MOST_SAMPLES:
        raise RequestError(f"more than {MOST_SAMPLES} samples, which are allowed")
    notes = ["decimal comma"] if dialect.decimal == "," and not keys.decimal else []
    if may_flow and not headings and not keys.decimal and dialect == (",", "."):
        pairs = (re.fullmatch(r"\s*[+-]?\d+,\d+\s*", text[:100]) for _, text in rows)
        if all(pairs):
            raise RequestError("commas may be decimal signs or stand between columns: give decimal")
    if keys.column == 0 or (may_flow and not headings and max(width, len(row)) > 1):
        widths = {len(dialect.cells(text)) for _, text in rows[:-1]}
        if keys.column == "" and len(widths) <= 1 and max(width, len(row)) < 5:
            raise RequestError(
                f"its rows have {len(row)} numbers: column = 1 to {len(row)} chooses one, "
                "column = 0 reads all of them row by row; with times in column 1, leave out dt"
            )
        read = cache(partial(_row_by_row, rows, dialect=dialect))
        columns = [Column("", _unit_in_titles(titles), read)]
        return Content(columns, format=", ".join([*notes, f"{len(row)} values a row"]))
    plain = cache(partial(dialect.columns, rows, width))

    def read_column(i: int) -> list[float]:
        if columns := plain():  # all at once
            return columns[i]
        numbers = []
        for place, text in rows:
            cells = dialect.cells(text, width)
            if len(cells) != width:
                raise RequestError(f"line {place}: {len(cells)} columns; others have {width}")
            value = _numbers(cells[i : i + 1], dialect.decimal)
            if value is None:
                words = f"{shown(cells[i])} is no number" if cells[i] else "a value is missing"
                raise RequestError(f"line {place}: {words}")
            numbers += value
        return numbers

    names = enumerate(headings or [("", "")] * width)
    columns = [Column(name, unit, cache(partial(read_column, i))) for i, (name, unit) in names]
    if width == 1:
        columns = [columns[0]._replace(unit=columns[0].unit or _unit_in_titles(titles))]
    return Content(columns, format=", ".join(notes))


def _dialect(body: Lines, decimal: str) -> tuple[Dialect, int]:
    """Return the dialect that most lines in the middle agree with, and their number of cells."""
    middle = body[len(body) // 2 :][:20]
    best, chosen, width = 0, None, 0
    for dialect in _DIALECTS:
        is_used = dialect.cut is None or any(dialect.cut in text for _, text in middle)
        if is_used and decimal in ("", dialect.decimal):
            rows = [dialect.numbers(text[:100_000]) for _, text in middle]
            sizes = Counter(len(row) for row in rows if row)
            size, score = max(sizes.items(), key=lambda item: (item[1], item[0]), default=(0, 0))
            if score > best:
                best, chosen, width = score, dialect, size
    if chosen is None:
        places = f"line {middle[0][0]}: {shown(middle[0][1].strip())}" if middle else "it"
        raise RequestError(f"{places} holds no numbers")
    return chosen, width


def _headings(titles: Lines, dialect: Dialect, width: int) -> list[tuple[str, str]]:
    """Return the name and the unit of each column, in one or two lines; empty without headings."""
    rows: list[list[str]] = []
    for _, title in titles[-2:]:
        text = title.strip().lstrip("".join(_NOTES)).strip()[:1000]
        cells = dialect.cells(text)
        # between blanks, names may be of several words
        others = (re.split(r"\s{2,}|\t", text), _HEADING.findall(text), text.split(","))
        fitting = next((row for row in (cells, *others) if len(row) == width), None)
        rows.append([cell.strip().strip('"') for cell in fitting] if fitting else cells)
    if not rows:
        return []
    if len(rows[-1]) != width:
        place, text = titles[-1]
        if dialect.cut and dialect.cut in text and not _NOTE.match(text):
            raise RequestError(
                f"line {place} has {len(rows[-1])} headings for {width} columns (a decimal comma "
                "between commas? save the file with semicolons); skip leaves the line out"
            )
        return []
    if all(_is_unit(cell) or not cell for cell in rows[-1]):
        names = rows[0] if len(rows) == 2 and len(rows[0]) == width else [""] * width
        pairs = zip(names, rows[-1], strict=True)
        return [(_heading(name)[0], cell.strip("[]()")) for name, cell in pairs]
    return [_heading(cell) for cell in rows[-1]]


def _is_unit(text: str) -> bool:
    word = text.strip("[]() ")
    return word.lower() in _TIME_UNITS or canonical(word) is not None


def _heading(word: str) -> tuple[str, str]:
    """Return the name of a column and its unit: `acceleration [g]`, `a / (m/s^2)`, `time_s`."""
    if match := re.search(r"\[([^\]]*)\]|\(([^()]*(?:\([^()]*\)[^()]*)?)\)", word):
        return word[: match.start()].strip(" /_,"), (match[1] or match[2] or "").strip()
    for place in (match.start() for match in re.finditer(r"[\s/_,]", word)):
        if _is_unit(word[place + 1 :]):
            return word[:place].strip(" /_,"), word[place + 1 :].strip()
    return word, ""


# ---- records as loads ----------------------------------------------------------------------------


def _samples(name: str, value: Any, /) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or not 2 <= len(value) <= MOST_SAMPLES:
        raise RequestError(f"{name} = {shown(value)} must be a list of 2 to {MOST_SAMPLES} numbers")
    if set(map(type, value)) == {float} and np.isfinite(samples := np.array(value)).all():
        return tuple((samples + 0.0).tolist())  # -0.0 becomes 0.0, as in `number`
    return tuple(number(f"{name}, sample {i},", one) for i, one in enumerate(value, 1))


@dataclass(frozen=True, kw_only=True, repr=False)
class Record(Outlined, Course):
    """Samples joined by straight lines or a natural cubic spline; 0 before and after."""

    times: tuple[float, ...] = setting(MISSING, _samples, "", "of the samples [s], ascending")
    values: tuple[float, ...] = setting(MISSING, _samples, "", "the samples, in `unit`")
    at: float = setting(0.0, TIME, "", "when the first sample is [s]")
    interpolation: str = setting(
        LINEAR, OneOf((LINEAR, CUBIC), "interpolation"), "",
        "`linear` between samples, or `cubic`: a natural spline",
    )  # fmt: skip
    uneven: bool = setting(False, Truth(), "", "whether steps may differ: what else is a gap")
    source: str = setting("", Text(), "", "where the samples come from")
    reading: str = setting("", Text(), "", "how their file was read, where it does not say so")

    def heading(self) -> str:
        return self.source

    def outline(self) -> Rows:
        yield "samples", f"{len(self.times)} from {self.times[0]:g} to {self.times[-1]:g} s"

    @classmethod
    def of(cls, entry: object) -> Record:
        if isinstance(entry, str):
            entry = {"file": entry}
        if not isinstance(entry, Mapping) or "file" not in entry:
            return super().of(entry)
        of_file = settings_of(RecordFile)  # keys that a table with a file has as well
        with at(f"[{cls.table}]"):
            if twice := next((key for key in ("times", "values") if key in entry), None):
                raise RequestError(f"{twice} stands beside file = {shown(entry['file'])}")
            keys = [one.key for one in settings_of(cls).values()]
            entry = table(cls.kind, entry, [*of_file, *keys])
            unit = unit_in("unit", entry["unit"]) if "unit" in entry else ""
            file = RecordFile(**{key: entry[key] for key in of_file if key in entry})
            path = Path(file.file)
            with at(str(path)):
                samples = file.read(unit)
        rest = {key: value for key, value in entry.items() if key not in of_file}
        with at(str(path)):
            return super().of({"source": path.name, **rest, **samples})

    def check(self) -> None:
        if len(self.times) != len(self.values):
            raise RequestError(f"{len(self.times)} times for {len(self.values)} values")
        steps = np.diff(self._times)
        if (steps <= 0.0).any():
            i = int(np.flatnonzero(steps <= 0.0)[0])
            raise RequestError(
                f"times must ascend: sample {i + 2} at {self.times[i + 1]:g} s follows one at "
                f"{self.times[i]:g} s"
            )
        usual = float(np.median(steps))
        if not self.uneven and (steps > GAP * usual).any():
            i = int(np.flatnonzero(steps > GAP * usual)[0])
            raise RequestError(
                f"a gap of {steps[i]:g} s after {self.times[i]:g} s, where steps are of {usual:g} "
                "s; allowed with uneven = true"
            )

    @property
    def step(self) -> float:
        return float(np.diff(self._times).max())

    def words(self) -> str:
        return f"record {self.source or len(self.values)}"

    def summary(self, duration: float) -> str:
        steps, length = np.diff(self._times), float(self._times[-1])
        low, high = f"{steps.min():g}", f"{steps.max():g}"
        within, values = min(max(duration - self.at, 0.0), length), np.array(self.values)
        peak = int(np.argmax(np.abs(values)))
        words = [
            f"record {self.source}".rstrip(),
            f"{len(values)} samples",
            f"step {low} s" if low == high else f"steps {low} to {high} s",
            f"{length:g} s" + ("" if within == length else f", of which {within:g} s are computed"),
            f"peak {abs(values[peak]):g} {self.unit} at {self._times[peak]:g} s",
        ]
        if self.times[0] != self.at:
            words.append(f"moved from {self.times[0]:g} s to {self.at:g} s")
        return ", ".join(words) + (f" ({self.reading})" if self.reading else "")

    @cached_property
    def _times(self) -> np.ndarray:
        """The times (n,) [s] from the first sample on."""
        return np.array(self.times) - self.times[0]

    @cached_property
    def _pieces(self) -> np.ndarray:
        """The coefficients (n + 1, 2 or 4) of the powers of the time from each sample on.

        The first row, before the first sample, and the last one are 0.  The second derivatives m of
        a natural spline are 0 at both ends, and follow from h_i m_i + 2 (h_i + h_(i+1)) m_(i+1)
        + h_(i+1) m_(i+2) = 6 (slope_(i+1) - slope_i) between them.
        """
        y, h = np.array(self.values), np.diff(self._times)
        is_cubic, slopes = self.interpolation == CUBIC, np.diff(y) / h
        pieces = np.zeros((len(y) + 1, 4 if is_cubic else 2))
        pieces[1:-1, 0], pieces[1:-1, 1] = y[:-1], slopes
        if not is_cubic:
            return pieces
        # elimination from the first sample on (Thomas), number by number
        steps, eliminated = h.tolist(), list[tuple[float, float]]()
        upper = value = 0.0
        for i, side in enumerate((6.0 * np.diff(slopes)).tolist()):
            pivot = 2.0 * (steps[i] + steps[i + 1]) - steps[i] * upper
            upper, value = steps[i + 1] / pivot, (side - steps[i] * value) / pivot
            eliminated.append((upper, value))
        curvatures = [0.0]
        for upper, value in reversed(eliminated):
            curvatures.append(value - upper * curvatures[-1])
        m = np.array([*curvatures, 0.0][::-1])
        pieces[1:-1, 1] -= h * (2.0 * m[:-1] + m[1:]) / 6.0
        pieces[1:-1, 2], pieces[1:-1, 3] = 0.5 * m[:-1], np.diff(m) / (6.0 * h)
        return pieces

    @property
    def kinks(self) -> np.ndarray:
        return self.at + self._times

    def rates(self, times: np.ndarray) -> np.ndarray:
        return np.zeros(len(times))

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        kinks = self.kinks
        piece = np.searchsorted(kinks, begins + 0.5 * lengths, side="right")
        return polynomial(self._pieces[piece], begins - kinks[piece - 1], lengths)
