"""Text files of numbers: lines, tables of any dialect, rows, and fixed fields that touch.

`lines_in` bounds what a file may hold before it is cut into lines and cells; `read_table` reads a
file that is of no network's format (`formats`).
"""

from __future__ import annotations

import csv
import math
import re
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from datetime import date
from functools import cache, partial
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from nlds_vines.archives.files import decoded
from nlds_vines.errors import RequestError, shown
from nlds_vines.model.loads.courses import canonical

MOST_SAMPLES = 10**6  # samples of a record: hours of an accelerogram
MOST_BYTES = 1 << 26  # bytes of a text
MOST_LINES = 12 * 10**5  # of a text: a sample each, and headers
MOST_CELLS = 5 * 10**6  # of a text: a time and four components of the longest record
MOST_COLUMNS = 1000  # of a table or an HDF5 file
TIME_UNITS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("ms", "msec", "msecs", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("min", "minute", "minutes"), "min"),
}
TIME_NAMES = ("time", "t", "times", "zeit", "temps", "tiempo", "tempo", "tid")

_GAPS = np.zeros(256, bool)  # the bytes between cells
_GAPS[list(b" \t,;\r\n\0")] = True
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?")
_PLAIN = re.compile(r"[0-9eE+\-. ]*")  # of these signs `float` reads what `_NUMBER` is, no more
_NOT_FINITE = ("nan", "+nan", "-nan", "inf", "+inf", "-inf")
_NOTES = ("#", "%", "//", "!", "|")  # marks before comments
_NOTE = re.compile(rf"\s*(?:{'|'.join(map(re.escape, _NOTES))})")
_SIGNS = {0x2212: "-", 0xA0: " ", 0x2009: " ", 0x202F: " ", 0xFEFF: None, 0x1A: None}
# a heading between blanks: a name, and its unit in brackets, which may stand apart from it
_HEADING = re.compile(r"\"[^\"]*\"|[^\s\[(]+(?:\s*[\[(][^\[(\])]*[\])])?")
_UNITS_OF = re.compile(r"\bUNITS?\s*(?:OF|:|=)\s*(\S+)", re.IGNORECASE)
_BRACKETED = re.compile(r"[\[(]([^\[\]()]{1,20})[\])]")
# a line that is no comment and has the form KEY: value or KEY = value
_KEY = re.compile(r"\W*[a-z][^:=]{0,80}[:=](?!//)\s*\S", re.IGNORECASE)
# words about how samples were taken, in several languages
_SAMPLING = re.compile(
    r"sampl|muestr|interval|scale|escala|factor|\bfreq|hz\b|\bdt\b|\bcounts?\b|\bnpts\b|"
    r"\bpoints\b|\bpuntos\b|units?\s*[:=]|unidades",
    re.IGNORECASE,
)
_STAMP = re.compile(
    r"(\d{4})([-/])(\d\d)\2(\d\d)[T ](\d\d):(\d\d):(\d\d)(?:\.(\d{1,9})\d*)?"
    r"(?:Z|([+-])(\d\d):?(\d\d))?(?![\w.])"
)
TOUCHING = re.compile(r"[0-9.][+-][0-9.]|\.[0-9]*\.")  # two numbers without a blank between
_WIDEST = 25  # characters of a fixed field

Lines = list[tuple[int, str]]  # the lines of a text that are not empty, with their numbers


class Column(NamedTuple):
    name: str  # "" if it has none
    unit: str
    read: Callable[[], list[float]]


class Content(NamedTuple):
    columns: list[Column]
    dt: float = 0.0  # step of the samples [s]; 0: a column has times
    format: str = ""
    is_ordered: bool = True
    are_components: bool = False  # whether each column but that of times is a component of motion


# ---- lines ---------------------------------------------------------------------------------------


def lines_in(data: bytes, skip: int) -> Lines:
    """Return the lines of a text, or of one that gzip packed, behind the first `skip` lines."""
    data = _unpacked(data)
    if 0 not in data[:10_000]:
        data = data.replace(b"\0", b" ")  # some networks pad files with it
    if len(data) > MOST_BYTES:
        raise RequestError(f"has more than {MOST_BYTES} bytes")
    _refuse_too_many(data)
    text = decoded(data)
    del data  # which may be 64 MB
    if not text.isascii() or "\x1a" in text:
        text = text.translate(_SIGNS)
    texts = text.split("\n")
    lines = enumerate(texts[skip:], skip + 1)
    return [(i, text) for i, text in lines if text and not text.isspace()]


def _unpacked(data: bytes) -> bytes:
    if not data.startswith(b"\x1f\x8b"):
        return data
    unpacking = zlib.decompressobj(zlib.MAX_WBITS + 16)  # + 16: with a header of gzip
    try:
        unpacked = unpacking.decompress(data, MOST_BYTES + 1)
    except zlib.error as error:
        raise RequestError(f"cannot be unpacked as gzip: {error}") from None
    if not unpacking.eof and len(unpacked) <= MOST_BYTES:
        raise RequestError("cannot be unpacked as gzip: its end is missing")
    return unpacked


def _refuse_too_many(data: bytes) -> None:
    """Refuse a text whose lines or cells, as objects of Python, would fill the memory."""
    lines = data.count(b"\n") + data.count(b"\r") - data.count(b"\r\n")
    if lines > MOST_LINES:
        raise RequestError(f"has {lines} lines; allowed: up to {MOST_LINES}")
    cells = 0
    for begin in range(0, len(data), 1 << 20):
        is_gap = _GAPS[np.frombuffer(data[begin : begin + (1 << 20) + 1], np.uint8)]
        cells += int(np.count_nonzero(is_gap[:-1] < is_gap[1:]))
    if cells > MOST_CELLS:
        raise RequestError(f"has {cells} numbers or words; allowed: up to {MOST_CELLS}")


# ---- numbers -------------------------------------------------------------------------------------


def number_in(cell: str) -> float | None:
    if _NUMBER.fullmatch(cell):
        return float(cell.replace("D", "E").replace("d", "e"))
    return float(cell) if cell.lower() in _NOT_FINITE else None


def numbers_in(cells: Sequence[str], decimal: str = ".") -> list[float] | None:
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
    numbers = [number_in(cell) for cell in cells]
    return None if None in numbers else [value for value in numbers if value is not None]


class Dialect(NamedTuple):
    """What stands between the cells of a table (None: blanks), and its decimal sign."""

    cut: str | None
    decimal: str
    width: int = 0  # of fixed fields [characters], between which nothing need stand

    def cells(self, text: str, width: int = 0) -> list[str]:
        """Return the cells of a line, without an empty one beyond `width` at its end."""
        if self.width:
            fields = range(0, len(text.rstrip()), self.width)
            return [text[i : i + self.width].strip() for i in fields]
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
        return numbers_in(self.cells(text), self.decimal)

    def columns(self, rows: Lines, width: int) -> list[list[float]] | None:
        """Return the columns of rows that have `width` numbers each; None for any other rows."""
        texts = [text for _, text in rows]
        if self.width:
            parts = [self.cells(text) for text in texts]
            cells = [cell for part in parts for cell in part]
            is_even = {len(part) for part in parts} == {width}
        elif self.cut is None:
            cells = [cell for text in texts for cell in text.split()]
            is_even = {len(text.split()) for text in texts} == {width}
        else:
            cells = self.cut.join(texts).split(self.cut)
            is_even = {text.count(self.cut) for text in texts} == {width - 1}
        numbers = numbers_in(cells, self.decimal) if is_even else None
        return None if numbers is None else [numbers[i::width] for i in range(width)]

    def read_column(self, rows: Lines, width: int, i: int) -> list[float]:
        """Return column `i` of rows with `width` cells each; refuse any other row."""
        numbers = []
        for place, text in rows:
            cells = self.cells(text, width)
            if len(cells) != width:
                raise RequestError(f"line {place}: {len(cells)} columns; others have {width}")
            value = numbers_in(cells[i : i + 1], self.decimal)
            if value is None:
                words = f"{shown(cells[i])} is no number" if cells[i] else "a value is missing"
                raise RequestError(f"line {place}: {words}")
            numbers += value
        return numbers


BLANKS = Dialect(None, ".")


def in_columns(rows: Lines, width: int, dialect: Dialect) -> list[Callable[[], list[float]]]:
    """Return a reader of each of `width` columns; all are read together if no row is odd."""
    together = cache(partial(dialect.columns, rows, width))

    def read(i: int) -> list[float]:
        columns = together()
        return dialect.read_column(rows, width, i) if columns is None else columns[i]

    return [cache(partial(read, i)) for i in range(width)]


def row_by_row(
    lines: Iterable[tuple[int, str]],
    count: int = MOST_BYTES,
    width: int = 0,
    dialect: Dialect = BLANKS,
) -> list[float]:
    """Return the first `count` numbers of lines, in fields of a `width` if Fortran wrote them."""
    numbers: list[float] = []
    fields = Dialect(None, ".", width)
    for place, text in lines:
        row = dialect.numbers(text)
        in_fields = numbers_in([cell for cell in fields.cells(text) if cell]) if width else None
        if in_fields is not None and len(in_fields) > len(row or ()):  # numbers that touch
            row = in_fields
        if row is None:
            raise RequestError(f"line {place}: {shown(text.strip())} must hold numbers alone")
        numbers += row
        if len(numbers) >= count:
            break
    if len(numbers) > MOST_SAMPLES and count > MOST_SAMPLES:
        raise RequestError(f"more than {MOST_SAMPLES} samples, which are allowed")
    return numbers


def field_width(lines: Lines) -> int:
    """Return the width of the fixed fields that numbers which touch stand in; 0 if none do.

    It is the widest one by which every line that holds touching numbers is cut into numbers with
    their decimal points at the same place.
    """
    touching = [text for _, text in lines if TOUCHING.search(text[:1000])]
    rows = [text.rstrip() for text in touching if not re.search("[a-cf-zA-CF-Z:/,;]", text[:1000])]
    widths = range(_WIDEST, 3, -1)
    return next((w for w in widths if rows and all(_has_fields(text, w) for text in rows)), 0)


def _has_fields(text: str, width: int) -> bool:
    fields = [text[i : i + width] for i in range(0, len(text), width)]
    if len(text) % width or len(fields) < 2:
        return False
    points = {field.find(".") for field in fields}
    return len(points) == 1 and all(_NUMBER.fullmatch(field.lstrip()) for field in fields)


# ---- tables --------------------------------------------------------------------------------------


_DIALECTS = (
    *(Dialect(cut, decimal) for cut in (";", "\t") for decimal in (".", ",")),
    Dialect(",", "."), BLANKS, Dialect(None, ","), Dialect(",", ","),
)  # fmt: skip


def read_table(lines: Lines, *, dt: float, column: int | str, decimal: str, unit: str) -> Content:
    """Read a table, or numbers row by row; arguments are the user's keys for what it lacks."""
    body = lines
    if any(mark in text for _, text in lines for mark in _NOTES):
        cut = ((i, text.partition("#")[0]) for i, text in lines)
        body = [(i, text) for i, text in cut if text.strip() and not _NOTE.match(text)]
    body, stamp = _with_seconds(body)
    dialect, width = _dialect(body, decimal)
    if width > MOST_COLUMNS and not dt:
        raise RequestError(f"has {width} columns; allowed: up to {MOST_COLUMNS}, or dt, their step")
    may_flow = column == 0 or (dt > 0.0 and column == "")
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
    names_times = any(is_time(name, unit) for name, unit in headings) or stamp is not None
    # words above numbers that flow are a title, unless they name times or each has a unit; so are
    # five words or more between blanks without a unit
    are_names = names_times or all(unit for _, unit in headings)
    if dialect.cut is None and width > 4 and not any(unit for _, unit in headings):
        are_names = stamp is not None
    if headings and not are_names and (may_flow or (dialect.cut is None and width > 4)):
        headings = []
    has_unit = any(canonical(unit) for _, unit in headings)
    if not (names_times and has_unit):
        _refuse_header(titles[:-1] if headings else titles, rows[0][0] - 1)
    if len(rows) > MOST_SAMPLES:
        raise RequestError(f"more than {MOST_SAMPLES} samples, which are allowed")
    notes = ["decimal comma"] if dialect.decimal == "," and not decimal else []
    if dialect.width:
        notes.append(f"fields of {dialect.width} characters")
    if may_flow and not headings and not decimal and dialect == (",", ".", 0):
        pairs = (re.fullmatch(r"\s*[+-]?\d+,\d+\s*", text[:100]) for _, text in rows)
        if all(pairs):
            raise RequestError("commas may be decimal signs or stand between columns: give decimal")
    widest = max(width, len(row))
    if column == 0 or (may_flow and not headings and stamp is None and widest > 1):
        if column == "":
            _refuse_ambiguous_rows(rows, dialect, widest)
        read = cache(partial(row_by_row, rows, dialect=dialect))
        columns = [Column("", unit_in_titles(titles), read)]
        return Content(columns, format=", ".join([*notes, f"{len(row)} values a row"]))
    names = headings or [("", "")] * width
    if stamp is not None:
        place = min(len(dialect.cells(f"{stamp}0")), width) - 1
        names[place] = (names[place][0] or "time", "s")
    reads = in_columns(rows, width, dialect)
    columns = [Column(*name, read) for name, read in zip(names, reads, strict=True)]
    if width == 1:
        columns = [columns[0]._replace(unit=columns[0].unit or unit_in_titles(titles))]
    return Content(columns, format=", ".join(notes))


def is_time(name: str, unit: str) -> bool:
    return name.lower() in TIME_NAMES or unit.lower() in TIME_UNITS


def _refuse_header(titles: Lines, end: int) -> None:
    """Refuse titles that state something about the numbers below which nobody has read."""
    for place, text in titles:
        states_key = _KEY.match(text[:200]) and not _NOTE.match(text)
        if (states_key or _SAMPLING.search(text[:200])) and not _unit_in_title(text):
            raise RequestError(
                f"line {place}: {shown(' '.join(text.split()))} is in a header of no known format; "
                f"skip = {end} leaves it out, dt, unit and column say what it means"
            )


def _refuse_ambiguous_rows(rows: Lines, dialect: Dialect, width: int) -> None:
    """Refuse rows that may be columns as well as numbers in a row, and rows of unequal lengths."""
    sizes = [len(dialect.cells(text)) for _, text in rows]
    usual = Counter(sizes).most_common(1)[0][0]
    odd = next((i for i, size in enumerate(sizes[:-1]) if size != usual), None)
    if odd is not None or sizes[-1] > usual:
        place, size = (rows[-1][0], sizes[-1]) if odd is None else (rows[odd][0], sizes[odd])
        raise RequestError(
            f"line {place} has {size} numbers where others have {usual}: column = 0 reads all "
            "numbers row by row, skip leaves lines out"
        )
    if width < 5:
        raise RequestError(
            f"its rows have {usual} numbers: column = 1 to {usual} chooses one, "
            "column = 0 reads all of them row by row; with times in column 1, leave out dt"
        )


def _with_seconds(body: Lines) -> tuple[Lines, str | None]:
    """Return the lines with ISO times as seconds from the first one, and what stands before that.

    Lines with other words are titles and stay as they are.
    """
    if not body or not _STAMP.search(body[-1][1][:1000]):
        return body, None
    first, before, lines = None, None, []
    for place, text in body:
        match = _STAMP.search(text)
        if match is None or re.search("[a-zA-Z]{2}", _STAMP.sub("", text).replace("nan", "")):
            lines.append((place, text))
            continue
        nanoseconds = _nanoseconds(place, match)
        if first is None:
            first, before = nanoseconds, text[: match.start()]
        seconds = f"{nanoseconds - first}e-9"
        lines.append((place, text[: match.start()] + seconds + text[match.end() :]))
    return lines, before


def _nanoseconds(place: int, stamp: re.Match[str]) -> int:
    year, _, month, day, hour, minute, second, fraction, sign, hours, minutes = stamp.groups()
    try:
        days = date(int(year), int(month), int(day)).toordinal()
    except ValueError as error:
        raise RequestError(f"line {place}: {stamp[0]}: {error}") from None
    total = ((24 * days + int(hour)) * 60 + int(minute)) * 60 + int(second)
    if sign:
        zone = 3600 * int(hours) + 60 * int(minutes)
        total -= zone if sign == "+" else -zone
    return total * 10**9 + int((fraction or "0").ljust(9, "0"))


def _dialect(body: Lines, decimal: str) -> tuple[Dialect, int]:
    """Return the dialect that most lines in the middle agree with, and their number of cells."""
    middle = body[len(body) // 2 :][:20]
    width = field_width(body)
    fields = [Dialect(None, ".", width)] if width else []
    best, chosen, size = 0, None, 0
    for dialect in (*fields, *_DIALECTS):
        is_used = dialect.cut is None or any(dialect.cut in text for _, text in middle)
        if is_used and decimal in ("", dialect.decimal):
            rows = [dialect.numbers(text[:100_000]) for _, text in middle]
            sizes = Counter(len(row) for row in rows if row)
            usual, score = max(sizes.items(), key=lambda item: (item[1], item[0]), default=(0, 0))
            if score > best:
                best, chosen, size = score, dialect, usual
    if chosen is None:
        places = f"line {middle[0][0]}: {shown(middle[0][1].strip())}" if middle else "it"
        raise RequestError(f"{places} holds no numbers")
    return chosen, size


def unit_in_titles(lines: Lines) -> str:
    units = [unit for _, text in lines[-3:] if (unit := _unit_in_title(text))]
    return units[-1] if units else ""


def _unit_in_title(text: str) -> str:
    """Return the unit that a title states, as `units of g`; or any in brackets, as `(m/s^2)`."""
    if match := _UNITS_OF.search(text[:200]):
        return match[1].strip(".,;")
    words = [match[1] for match in _BRACKETED.finditer(text[:200]) if _is_unit(match[1])]
    return words[-1] if words else ""


def _headings(titles: Lines, dialect: Dialect, width: int) -> list[tuple[str, str]]:
    """Return the name and the unit of each column, in one or two lines; empty without headings."""
    rows: list[list[str]] = []
    for _, title in titles[-2:]:
        text = title.strip().lstrip("".join(_NOTES)).strip()[:1000]
        cells = dialect._replace(width=0).cells(text)
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
    return word.lower() in TIME_UNITS or canonical(word) is not None


_VELOCITY = re.compile(r"(mm|cm|m|km|in|ft)/s(ec)?", re.IGNORECASE)


def _heading(word: str) -> tuple[str, str]:
    """Return the name of a column and its unit: `acceleration [g]`, `a / (m/s^2)`, `time_s`."""
    if "/" in word and (canonical(word) is not None or _VELOCITY.fullmatch(word.strip())):
        return "", word.strip()  # `m/s/s` is no m/s in seconds
    if match := re.search(r"\[([^\]]*)\]|\(([^()]*(?:\([^()]*\)[^()]*)?)\)", word):
        return word[: match.start()].strip(" /_,"), (match[1] or match[2] or "").strip()
    for place in (match.start() for match in re.finditer(r"[\s/_,]", word)):
        if _is_unit(word[place + 1 :]):
            return word[:place].strip(" /_,"), word[place + 1 :].strip()
    return word, ""


def ascends(numbers: list[float]) -> bool:
    if len(numbers) < 2:
        return False
    steps = np.diff(numbers)
    return bool((steps > 0.0).all()) and math.isfinite(numbers[-1])
