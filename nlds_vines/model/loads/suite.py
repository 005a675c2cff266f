"""Suites: records that act one at a time, and the common size to which records are scaled."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from nlds_vines.errors import RequestError, at, from_text, number, shown, table
from nlds_vines.model.loads.courses import ACCELERATIONS, FORCES, unit_in
from nlds_vines.model.loads.record import Record

MOST_RECORDS = 10_000  # of a suite
NO_RECORDS = (".dt2", ".vt2")  # displacements and velocities as PEER sends them
ZETA = 0.05  # the damping ratio of a spectral ordinate by default

_SIZE = re.compile(r"\s*([-+.\deE]*\d\.?)\s*(\S.*?)?\s*")  # a number and its unit, such as 0.3 g


def suite_of(value: object) -> tuple[Record, ...]:
    """Return the records of a suite, each with another source.

    Parameters
    ----------
    value : str, mapping, Record, or a list of these
        The path of a record, of a folder of records, or the table of a record; in a table `file`
        may be a list of paths, which share its other keys.
    """
    if value == ():  # the default: no suite
        return ()
    records: list[Record] = []
    paths: list[Path | None] = []
    for one in _listed(value):
        if isinstance(one, Record):
            records.append(one)
            paths.append(None)
            continue
        for entry in _entries(one):
            records.append(Record.of(entry))
            paths.append(Path(entry["file"]) if "file" in entry else None)
    if not records:
        raise RequestError(f"suite = {shown(value)} must be one or more records")
    if len(records) > MOST_RECORDS:
        raise RequestError(f"suite has {len(records)} records; allowed: {MOST_RECORDS}")
    return _told_apart(records, paths)


def _listed(value: object) -> Sequence[Any]:
    return value if isinstance(value, list | tuple) else [value]


def _entries(value: object) -> Iterator[Mapping[str, Any]]:
    """Yield the table of each record in a path, a folder or a table."""
    if isinstance(value, str | os.PathLike):
        for path in _files(Path(os.fspath(value))):
            yield {"file": str(path)}
        return
    if not isinstance(value, Mapping):
        raise RequestError(f"suite = {shown(value)} must be paths or tables of records")
    if "file" not in value:
        yield value
        return
    for file in _listed(value["file"]):
        if not isinstance(file, str | os.PathLike):
            raise RequestError(f"file = {shown(file)} must be the path of a record")
        for path in _files(Path(os.fspath(file))):
            yield {**value, "file": str(path)}


def _files(path: Path) -> list[Path]:
    """Return a file, or the records in a folder by name.

    Of a folder, hidden files, names with `_` in front, and velocities and displacements of PEER are
    left out; everything else is taken for a record.
    """
    if not path.is_dir():
        return [path]
    files = [
        one
        for one in sorted(path.iterdir())
        if one.is_file() and one.name[0] not in "._" and one.suffix.lower() not in NO_RECORDS
    ]
    if not files:
        raise RequestError(f"folder {shown(str(path))} has no record")
    return files


def _told_apart(records: Sequence[Record], paths: Sequence[Path | None]) -> tuple[Record, ...]:
    """Return the records with names: of equal ones, the folder stands before the file."""
    counts = Counter(record.source for record in records)
    named: list[Record] = []
    for place, (record, path) in enumerate(zip(records, paths, strict=True), start=1):
        source = record.source or f"record {place}"
        if counts[record.source] > 1 and path is not None:
            source = f"{path.parent.name}/{source}"
        named.append(record if source == record.source else replace(record, source=source))
    for source, count in Counter(record.source for record in named).items():
        if count > 1:
            raise RequestError(f"record {source} stands {count} times in the suite")
    return tuple(named)


# ---- a common size -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Size:
    """The size to which records are scaled: a peak, or a pseudo-acceleration at a period.

    `value` is in m/s^2, or in N of forces.
    """

    value: float
    is_force: bool
    period: float | None = None  # T [s] of a spectral ordinate; None: the peak
    zeta: float = ZETA

    def words(self) -> str:
        unit = "N" if self.is_force else "m/s^2"
        if self.period is None:
            return f"a peak of {self.value:g} {unit}"
        return f"Sa({self.period:g} s, {100 * self.zeta:g} %) = {self.value:g} {unit}"


def size_of(value: object) -> Size:
    """Return the size in a table, or in a text such as "Sa=0.5g,T=0.8"."""
    if isinstance(value, Size):
        return value
    if isinstance(value, str):
        pairs = (pair.partition("=") for pair in value.split(","))
        value = {key.strip(): text.strip() for key, _, text in pairs}
    with at("scale_to"):
        entries = table("scale_to", value, ("peak", "Sa", "T", "zeta"))
        if ("peak" in entries) == ("Sa" in entries):
            raise RequestError(f"{shown(value)}: allowed: peak, or Sa and T (and zeta)")
        if "peak" in entries:
            for key in ("T", "zeta"):
                if key in entries:
                    raise RequestError(f"{key} stands beside peak; allowed: beside Sa")
            size, is_force = _size("peak", entries["peak"])
            return Size(size, is_force)
        if "T" not in entries:
            raise RequestError("Sa needs T, the period of the ordinate [s]")
        size, is_force = _size("Sa", entries["Sa"])
        if is_force:
            raise RequestError(f"Sa = {shown(entries['Sa'])} must be an acceleration")
        period = _number("T", entries["T"])
        zeta = _number("zeta", entries.get("zeta", ZETA))
        if not 0.0 < period <= 1e3:
            raise RequestError(f"T = {period:g} s; allowed: above 0 to 1000 s")
        if not 0.0 <= zeta < 1.0:
            raise RequestError(f"zeta = {zeta:g} must be at least 0 and below 1")
        return Size(size, False, period, zeta)


def _number(name: str, value: object) -> float:
    return from_text(float, name, value) if isinstance(value, str) else number(name, value)


def _size(name: str, value: object) -> tuple[float, bool]:
    """Return a positive size in m/s^2 or N, and whether it is a force."""
    unit = "m/s^2"
    if isinstance(value, str):
        match = _SIZE.fullmatch(value)
        if match is None:
            raise RequestError(f"{name} = {shown(value)} must be a number with a unit, as '0.3 g'")
        size = from_text(float, name, match[1])
        if match[2]:
            unit = unit_in(f"unit of {name}", match[2])
    else:
        size = number(name, value)
    size *= (FORCES | ACCELERATIONS)[unit]
    if not 0.0 < size <= 1e15:
        raise RequestError(f"{name} = {shown(value)} must be > 0")
    return size, unit in FORCES
