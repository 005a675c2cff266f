"""How networks write records of ground motion: `FORMATS`, one entry each.

An entry says how its files are recognized (`mark`), above which line the numbers begin, and where
the header states the count of samples, step or rate, unit, scale and component (`facts`: regular
expressions with groups of these names).  `read_format` reads every entry in the same way.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import NamedTuple

from nlds_vines.errors import RequestError, shown
from nlds_vines.model.loads.record_text import (
    MOST_BYTES,
    MOST_SAMPLES,
    TOUCHING,
    Column,
    Content,
    Dialect,
    Lines,
    ascends,
    field_width,
    in_columns,
    number_in,
    numbers_in,
    row_by_row,
    unit_in_titles,
)

IN_ROWS, IN_COLUMNS, IN_PAIRS = "rows", "columns", "pairs"  # of time and value
MARKED = 60  # lines in which a format is recognized
HEADER = 150  # lines of the longest header
UNKNOWN = 1e38  # what SMC writes for a number that is not known

Facts = Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class Format:
    """A format of text files with one or several components of a ground motion."""

    name: str
    mark: str  # a line of its header, which no other format has
    above: str  # the last line of the header that has words
    facts: Sequence[str]  # groups: count, step, rate, seconds, unit, scale, per, component, ...
    header_rows: int = 0  # rows of numbers below `above` that belong to the header
    is_repeated: bool = False  # whether each component has a header of its own
    layout: str = IN_ROWS
    has_times: bool = False  # whether the first column has the times
    width: int = 0  # of fields [characters]
    unit: str = ""  # if the header states none
    factors: Mapping[str, tuple[str, float]] = field(
        default_factory=dict
    )  # units that are multiples of others
    components: Mapping[str, str] = field(default_factory=dict)  # names for those of the header
    between: str = r"[\s;,/]+"  # what separates several components or counts
    is_centered: bool = False  # whether the mean of the counts is no acceleration
    # facts at places rather than beside words, from the lines and where the header begins and ends
    find: Callable[[Lines, int, int], Facts] | None = None


class FileBlock(NamedTuple):
    """One component: the words of its header, and the lines from its first number on."""

    facts: Facts
    rows: Lines


def read_format(form: Format, lines: Lines) -> Content | None:
    """Return the content of a file in this format; None if it has another format."""
    mark, above = re.compile(form.mark, re.IGNORECASE), re.compile(form.above, re.IGNORECASE)
    if not any(mark.search(text[:200]) for _, text in lines[:MARKED]):
        return None
    blocks = list(_blocks(form, above, lines))
    if not blocks:
        raise RequestError(f"has the header of a record of {form.name}, but no values below it")
    steps = {_step(block.facts) for block in blocks}
    if len(steps) > 1:
        raise RequestError(f"its components have the steps {sorted(steps)} s; allowed: one step")
    step = steps.pop()
    if form.layout == IN_COLUMNS:
        columns = _columns(form, blocks[0])
        has_times = form.has_times
    else:
        names = _component_names(form, blocks)
        columns = []
        for name, block in zip(names, blocks, strict=True):
            columns += _series_of(form, block, name, step, is_only=len(blocks) == 1)
        has_times = form.layout == IN_PAIRS
    name = form.name
    scale, per = blocks[0].facts.get("scale"), blocks[0].facts.get("per")
    if scale and per:
        name = f"{name}: counts times {scale}/{per}"
    if form.is_centered:
        name = f"{name}, without their mean"
    return Content(columns, 0.0 if has_times else step, name, are_components=True)


def _blocks(form: Format, above: re.Pattern[str], lines: Lines) -> Iterator[FileBlock]:
    """Yield the components; a header is all words between the numbers above and those below it."""
    searched = lines if form.is_repeated else lines[:HEADER]
    worded = [i for i, (_, text) in enumerate(searched) if re.search("[A-Za-z#]", text[:200])]
    ends = [i for i in worded if above.search(lines[i][1][:200])]
    if ends and not form.is_repeated:
        ends = ends[-1:]
    begin = 0
    for end in ends:
        words = [lines[i][1][:400] for i in worded if begin <= i <= end]
        facts = {} if form.find is None else dict(form.find(lines, begin, end))
        for pattern in form.facts:
            expression = re.compile(pattern, re.IGNORECASE)
            matches = (expression.search(text) for text in reversed(words))
            match = next((one for one in matches if one is not None), None)
            groups = {} if match is None else match.groupdict()
            for key, text in groups.items():
                if text:
                    facts.setdefault(key, text)
        kind = facts.get("kind", "acceleration").lower()
        if not kind.startswith("acc") or "spectrum" in kind:
            article = "an" if kind.startswith("a") else "a"
            raise RequestError(f"holds {article} {kind}; needs an acceleration or a force")
        first = end + 1 + int(facts.get("header_rows", form.header_rows))
        while first < len(lines) and not _has_numbers(lines[first][1]):
            first += 1  # names of columns, rulers
        yield FileBlock(facts, lines[first:])
        begin = end + 1


def _has_numbers(text: str) -> bool:
    """Return True if a line holds digits and no word."""
    without_exponents = re.sub("(?<=[0-9.])[EeDd](?=[+-]?[0-9])", "", text[:200])
    return bool(re.search("[0-9]", text[:200])) and not re.search("[A-Za-z]", without_exponents)


def _step(facts: Facts) -> float:
    """Return the step [s] that a header states, as such or as samples a second; 0 for none."""
    steps = {_positive("step", text) for text in _several(facts.get("step", ""))}
    steps |= {1.0 / _positive("rate", text) for text in _several(facts.get("rate", ""))}
    if len(steps) > 1:
        low, high = min(steps), max(steps)
        if not math.isclose(low, high, rel_tol=1e-6):
            raise RequestError(f"its header states steps of {low:g} and {high:g} s; allowed: one")
    return min(steps, default=0.0)


def _several(text: str) -> list[str]:
    return [part for part in re.split(r"[\s/]+", text) if part]


def _positive(what: str, text: str) -> float:
    value = number_in(text)
    if value is None or not 0.0 < value < math.inf:
        raise RequestError(f"its header states a {what} of {shown(text)}, which must be above 0")
    return value


def _count(facts: Facts, step: float) -> int:
    """Return the count of samples that a header states, by itself or by rate and seconds; or 0."""
    counts = {int(_positive("count", text)) for text in _several(facts.get("count", ""))}
    if len(counts) > 1:
        raise RequestError(f"its components have {sorted(counts)} samples; allowed: one number")
    count = counts.pop() if counts else 0
    seconds = number_in(facts.get("seconds", "0"))
    if seconds is None or not 0.0 <= seconds < math.inf:
        raise RequestError(f"its header states a duration of {shown(facts['seconds'])}")
    if count and step and seconds and abs(count * step - seconds) > 1.5 + 0.02 * seconds:
        raise RequestError(
            f"its header states {count} values at steps of {step:g} s in {seconds:g} s; skip "
            "leaves the header out, dt and unit say what it means"
        )
    return count or (round(seconds / step) if step else 0)


def _unit(form: Format, facts: Facts) -> tuple[str, float]:
    """Return the unit of the values, and their factor."""
    stated = facts.get("unit", form.unit).strip(".,;")
    unit, factor = form.factors.get(stated.lower(), (stated, 1.0))
    if "scale" in facts:
        factor *= _positive("scale", facts["scale"]) / _positive("scale", facts.get("per", "1"))
    return unit, factor


def _component_names(form: Format, blocks: Sequence[FileBlock]) -> list[str]:
    """Return the names of components, which differ, of blocks that each have one."""
    stated = [" ".join(block.facts.get("component", "").split()) for block in blocks]
    names = [form.components.get(name, name) for name in stated]
    if len(names) == 1:
        return names
    return [
        name if name and names.count(name) == 1 else f"channel {i} {name}".strip()
        for i, name in enumerate(names, 1)
    ]


def _series_of(
    form: Format, block: FileBlock, name: str, step: float, is_only: bool
) -> list[Column]:
    """Return the values of a block that stand row by row, and their times if it has them."""
    unit, factor = _unit(form, block.facts)
    count, width = _count(block.facts, step), int(block.facts.get("width", form.width))
    in_pairs = form.layout == IN_PAIRS or "pairs" in block.facts
    numbers = cache(partial(_numbers, block.rows, count * (2 if in_pairs else 1), width, is_only))

    def times() -> list[float]:
        return numbers()[::2]

    def values() -> list[float]:
        counts = numbers()[1::2] if in_pairs else numbers()
        mean = math.fsum(counts) / len(counts) if form.is_centered else 0.0
        return [factor * (value - mean) for value in counts]

    column = Column(name, unit, cache(values))
    return [Column("time", "s", cache(times)), column] if in_pairs else [column]


def _numbers(rows: Lines, count: int, width: int, is_only: bool) -> list[float]:
    """Return the numbers row by row, as many as the header states, or all if it does not say."""
    if not count:
        return row_by_row(rows, MOST_BYTES, width)
    if not 2 <= count <= 2 * MOST_SAMPLES:
        raise RequestError(f"{count} samples; allowed: 2 to {MOST_SAMPLES}")
    rest = iter(rows)
    numbers = row_by_row(rest, count, width or field_width(rows[:count]))
    if len(numbers) < count:
        raise RequestError(f"the header states {count} values, {len(numbers)} follow")
    _, below = next(rest, (0, ""))
    if len(numbers) > count or (is_only and _has_numbers(below)):
        raise RequestError(f"the header states {count} values, more follow")
    return numbers


def _columns(form: Format, block: FileBlock) -> list[Column]:
    """Return the columns of components, behind that of times if there is one."""
    stated = block.facts.get("component", "").replace("(+)", "").strip()
    names = [name for name in re.split(form.between, stated) if name]
    unit, factor = _unit(form, block.facts)
    count = _count(block.facts, _step(block.facts))
    if count and len(block.rows) != count:
        raise RequestError(f"the header states {count} values, {len(block.rows)} follow")
    is_touching = any(TOUCHING.search(text) for _, text in block.rows)
    width = int(block.facts.get("width", form.width)) if is_touching else 0
    heads = [("time", "s")] if form.has_times else []
    heads += [(form.components.get(name, name), unit) for name in names]
    reads = in_columns(block.rows, len(heads), Dialect(None, ".", width))
    columns = [Column(*head, read) for head, read in zip(heads, reads, strict=True)]
    scaled = [one._replace(read=cache(partial(_scaled, one.read, factor))) for one in columns]
    return [*columns[: form.has_times], *scaled[form.has_times :]]


def _scaled(read: Callable[[], list[float]], factor: float) -> list[float]:
    return [factor * value for value in read()]


# ---- the formats ---------------------------------------------------------------------------------

_DIRECTIONS = {  # of KiK-net, by the number of its channel
    f"{3 * place + i}": f"{direction}, {where}"
    for place, where in enumerate(("borehole", "surface"))
    for i, direction in enumerate(("N-S", "E-W", "U-D"), 1)
}
_TENTH_OF_G = {"g/10": ("g", 0.1)}
_COSMOS = (
    r"(?P<count>\d+)\s+(?:raw )?accel\w*\.?\s+pts,\s*approx\s+(?P<seconds>[\d.]+)\s+secs?,"
    r"\s*units\s*=\s*(?P<unit>[^\s(,]+)"
)
_FIELDS = r"\(\s*\d*[FEDGI](?P<width>\d+)[.\d]*\)"
_REALS = re.compile(r"(\d+)\s+Real-header values follow", re.IGNORECASE)


def _cosmos_step(lines: Lines, begin: int, end: int) -> Facts:
    """Return the step in real header 62 [ms] or 34 [s]: the one that agrees with the duration."""
    stated = re.search(_COSMOS, lines[end][1][:200], re.IGNORECASE)
    headers = [i for i in range(begin, end) if _REALS.search(lines[i][1][:200])]
    if stated is None or not headers:
        raise RequestError("holds no real headers, which state the step")
    title = lines[headers[-1]][1][:200]
    size, fields = _REALS.search(title), re.search(_FIELDS, title, re.IGNORECASE)
    width = 0 if fields is None else int(fields["width"])
    reals = [] if size is None else row_by_row(lines[headers[-1] + 1 : end], int(size[1]), width)
    reals += [0.0] * 62
    count, seconds = int(stated["count"]), number_in(stated["seconds"])
    if seconds is None:
        raise RequestError(f"its header states a duration of {shown(stated['seconds'])}")
    for step in (reals[61] * 1e-3, reals[33]):
        if step > 0.0 and abs(count * step - seconds) <= 1.5 + 0.02 * seconds:
            return {"step": repr(step)}
    raise RequestError(
        f"its headers state steps of {reals[61] * 1e-3:g} and {reals[33]:g} s for {count} values "
        f"in {seconds:g} s; copy the values into a file of their own, and give dt"
    )


def _smc_facts(lines: Lines, begin: int, end: int) -> Facts:
    """Return count and rate of SMC: 11 lines of text, 48 integers, 50 reals, then comments.

    Integer 16 counts the comments, 17 the numbers; real 2 is the number of samples a second.  An
    uncorrected record whose rate is not known has a time before each value.
    """
    first = lines[end][0]

    def between(start: int, stop: int) -> Lines:  # lines of the header, of which some are empty
        return [line for line in lines[end : end + stop] if start <= line[0] - first < stop]

    integers = row_by_row(between(11, 17), 48, 10)
    reals = row_by_row(between(17, 27), 50, 15)
    if len(integers) < 48 or len(reals) < 50:
        raise RequestError("its headers must hold 48 integers and 50 reals")
    count, comments = int(integers[16]), max(0, int(integers[15]))
    facts = {"header_rows": str(len(between(1, 27 + min(comments, len(lines)))))}
    titles = " ".join(text[:200] for _, text in between(0, 11))
    if component := re.search(r"component\s*=\s*(\S+)", titles):
        facts["component"] = component[1]
    if reals[1] >= UNKNOWN:
        return {**facts, "count": str(count // 2), "pairs": "yes"}
    return {**facts, "count": str(count), "rate": repr(reals[1])}


_VOLUME_1 = Format(
    name="CSMIP volume 1",
    mark=r"^UNITS (?:OF UNCOR ACCEL )?ARE SEC AND G",
    above=r"^RMS ACC\w*\.? OF COMPLETE RECORD",
    facts=(
        r"^NO\. OF POINTS\s*=\s*(?P<count>\d+)",
        r"^UNITS .* AND\s+(?P<unit>G(?:/10)?)\b",
        r"^(?:CHAN\s*\d+:|COMP)\s*(?P<component>[^(]+?)(?:\s*\(|\s+\d+\s*$|\s*$)",
    ),
    header_rows=14,
    is_repeated=True,
    layout=IN_PAIRS,
    width=7,
    factors=_TENTH_OF_G,
)

FORMATS: tuple[Format, ...] = (
    Format(
        name="PEER",
        mark=r"NPTS.*\bDT\b",
        above=(
            r"NPTS\s*=\s*\d+[\s,]*DT\s*=|\d[\s,]+[\d.EeDd+-]+\s+NPTS,?\s*DT|"
            r"^acceleration\b.*(?:\bunits?\b|\()"
        ),
        facts=(
            r"NPTS\s*=\s*(?P<count>\d+)[\s,]*DT\s*=\s*(?P<step>[\d.EeDd+-]+)",
            r"(?P<count>\d+)[\s,]+(?P<step>[\d.EeDd+-]+)\s+NPTS,?\s*DT",
            r"\bUNITS?\s*(?:OF|:|=)\s*(?P<unit>\S+)",
            r"^acceleration\s*\((?P<unit>[^)]+)\)",
            r"\b(?P<kind>acceleration|velocity|displacement)\b",
        ),
    ),
    Format(
        name="K-NET or KiK-net",
        mark=r"^Scale Factor\s+[\d.]+\(gal\)/",
        above=r"^Memo\b",
        facts=(
            r"^Sampling Freq\(Hz\)\s+(?P<rate>[\d.]+)",
            r"^Duration Time\(s\)\s+(?P<seconds>[\d.]+)",
            r"^Scale Factor\s+(?P<scale>[\d.]+)\((?P<unit>gal)\)/(?P<per>[\d.]+)",
            r"^Dir\.\s+(?P<component>\S+)",
        ),
        components=_DIRECTIONS,
        is_centered=True,
    ),
    Format(
        name="ESM, ITACA or AFAD",
        mark=r"^SAMPLING_INTERVAL_S:",
        above=r"^[A-Z0-9_/^()]+:",
        facts=(
            r"^SAMPLING_INTERVAL_S:\s*(?P<step>\S+)",
            r"^NDATA:\s*(?P<count>\d+)",
            r"^UNITS:\s*(?P<unit>\S+)",
            r"^(?:STREAM|COMPONENT):\s*(?P<component>\S+)",
            r"^DATA_TYPE:\s*(?:(?:UN)?PROCESSED\s+)?(?P<kind>\w[\w -]*)",
        ),
    ),
    Format(
        name="AFAD",
        mark=r"^STRONG GROUND MOTION RECORDS OF TURK",
        above=r"^\s*[NSEWUD]-[NSEWUD]\s+[NSEWUD]-[NSEWUD]",
        facts=(
            r"^NUMBER OF DATA\s*:\s*(?P<count>\d+)",
            r"^SAMPLING INTERVAL \(sec\)\s*:\s*(?P<step>\S+)",
            r"^RAW PGA VALUES \((?P<unit>[^)]+)\)",
            r"^\s*(?P<component>[NSEWUD]-[NSEWUD](?:\s+[NSEWUD]-[NSEWUD])*)\s*$",
        ),
        layout=IN_COLUMNS,
    ),
    Format(
        name="CSMNC",
        mark=r"EQUALLY SPACED INTERVALS OF:",
        above=r"^(?:NO\. OF POINTS|PEAK VALUE|PRE-EVENT TIME|SITE CONDITION|CSMNC)",
        facts=(
            r"NO\. OF POINTS:\s*(?P<count>\d+)",
            r"EQUALLY SPACED INTERVALS OF:\s*(?P<step>[\d.]+)",
            r"\bUNIT:\s*(?P<unit>\S+)",
            r"^COMP\.\s*(?P<component>\S+)",
            r"CORRECTED (?P<kind>acceleration|velocity|displacement)",
        ),
    ),
    Format(
        name="UNAM",
        mark=r"^ARCHIVO ESTANDAR DE ACELERACION",
        above=r"^DATOS DE ACELERACION",
        facts=(
            r"^NUM\. TOTAL DE MUESTRAS, C1-C6\s*:\s*/(?P<count>[\d/ ]+)",
            r"^INTERVALO DE MUESTREO, C1-C6[^:]*:\s*/(?P<step>[\d./ ]+)",
            r"^UNIDADES DE LOS DATOS\s*:\s*(?P<unit>\S+)",
            r"^ORIENTACION C1-C6[^:]*:\s*/(?P<component>.+)",
            r"^FORMATO DATOS[^:]*:\s*\d*F(?P<width>\d+)",
        ),
        layout=IN_COLUMNS,
        between="/",
    ),
    Format(
        name="CWB",
        mark=r"^#\s*SampleRate\(Hz\)",
        above=r"^#",
        facts=(
            r"^#\s*AmplitudeUnit:\s*(?P<unit>[^\s.]+)",
            r"^#\s*DataSequence:\s*Time\s+(?P<component>.+)",
            r"^#\s*Data:\s*\d*F(?P<width>\d+)",
        ),
        layout=IN_COLUMNS,
        has_times=True,
    ),
    Format(
        name="GeoNet",
        mark=r"^(?:un)?corrected accelerogram .*GNS Science",
        above=r"^Displacement[: ]",
        facts=(
            r"^Number of points\s+(?P<count>\d+)\s+Duration\s+(?P<seconds>[\d.]+)",
            r"^Raw readings in units of\s+(?P<scale>[\d.]+)\s+(?P<unit>\S+)\s+at intervals of\s+"
            r"(?P<step>[\d.]+)",
            r"^Instrument corrected data at\s+(?P<step>[\d.]+)",
            r"^Acceleration:\s+peak\s+\S+\s+(?P<unit>\S+)",
            r"^Component\s+(?P<component>\S+)",
        ),
        header_rows=10,
        is_repeated=True,
        width=8,
    ),
    Format(
        name="CSMIP",
        mark=r"points of acc\w* data equally spaced|accelerogram points at",
        above=r"points of acc\w* data equally spaced|accelerogram points at",
        facts=(
            r"(?P<count>\d+) points of acc\w* data equally spaced at *(?P<step>[\d.]+) *sec",
            r"(?P<count>\d+) accelerogram points at *(?P<rate>[\d.]+) *pts/sec",
            r"(?:equally spaced at *[\d.]+ *sec|pts/sec)\W*\b(?:in units of|in units|in|units:)"
            r" +(?P<unit>[^\s()]+)",
            r"^(?:Chan\s*\d+:|COMP)\s*(?P<component>[^(]+?)(?:\s*\(|\s+\d+\s*$|\s*$)",
            _FIELDS,
        ),
        is_repeated=True,
    ),
    Format(
        name="COSMOS",
        mark=r"\(Format v[\d.]+ with \d+ text lines\)",
        above=r"\baccel\w*\.?\s+pts,\s*approx",
        facts=(
            _COSMOS,
            r"^Sta\s+Cha\w*:?\s*\S+:?\s+(?P<component>[^(]+?)\s*\(Rcrdr",
            _FIELDS,
        ),
        is_repeated=True,
        find=_cosmos_step,
    ),
    replace(_VOLUME_1, name="RENADIC", mark="^UNIVERSIDAD DE CHILE - RENADIC"),
    _VOLUME_1,
    Format(
        name="SMC",
        mark=r"^\s*[12]\s+(?:UN)?CORRECTED ACCELEROGRAM",
        above=r"^\s*[12]\s+(?:UN)?CORRECTED ACCELEROGRAM",
        facts=(),
        width=10,
        unit="cm/s^2",
        find=_smc_facts,
    ),
)  # fmt: skip
"""The formats that are recognized, in this order; a new one is an entry."""


def content_of(lines: Lines) -> Content | None:
    """Return the content of a file in a known format; None if its format is unknown."""
    for form in FORMATS:
        content = read_format(form, lines)
        if content is not None:
            return content
    return _counted(lines)


def _counted(lines: Lines) -> Content | None:
    """Read titles, a line with the number of values and their step [s], then the values."""
    for i, (place, text) in enumerate(lines[:MARKED]):
        cells = text[:200].split()
        row = numbers_in(cells)
        if row is None:
            continue
        if len(row) != 2 or not cells[0].isdigit() or not 0.0 < (dt := row[1]) <= 10.0:
            return None
        count, rows = int(cells[0]), [text.split() for _, text in lines[i + 1 :]]
        if count < 3 or sum(map(len, rows)) != count:
            return None
        if all(len(one) == 2 for one in rows):
            first = [float(count), *(number_in(one[0]) or 0.0 for one in rows)]
            if ascends(first):
                raise RequestError(
                    f"line {place} states {count} values at steps of {dt:g} s, or is the "
                    "first row of two columns: skip and dt choose the former, a heading the latter"
                )
        read = cache(partial(_numbers, lines[i + 1 :], count, 0, True))
        return Content([Column("", unit_in_titles(lines[:i]), read)], dt, "counted values")
    return None
