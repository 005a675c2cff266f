"""Records that describe their own columns: dataclasses whose fields carry units and a meaning.

    @dataclass(frozen=True)
    class Found:
        error: Annotated[float, Column("m", "of the last state")] = math.nan

From such a field follow the column of an archive, the value in a row, and the record read back.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import fields
from typing import Any, NamedTuple, TypeVar, get_type_hints

import numpy as np

from nlds_vines.archives.dataset import Dataset

DIMS = ("row",)
"""The one dimension of a table."""

Row = Mapping[str, Any]
"""One measurement: a value for each column."""

Record = TypeVar("Record")

_DTYPES = {str: "str", float: "float64", int: "int32", bool: "int8"}
_FILLS: dict[type, float | int | str] = {str: "", float: np.nan}  # of others 0


class Column(NamedTuple):
    """What a field says of its column; its type is str, float, int or bool.

    `name` is given where it is not that of the field; `flags` are the words of an enumeration.
    """

    units: str
    long_name: str
    name: str = ""
    flags: Mapping[str, int] | None = None


class _Described(NamedTuple):
    """A field that is a column: its name and type, the column's name, and the column."""

    field: str
    kind: type
    name: str
    column: Column
    given: bool  # to the record when it is made


def _described(record: type) -> tuple[_Described, ...]:
    """Return the fields of a dataclass that are columns."""
    hints, found = get_type_hints(record, include_extras=True), []
    for entry in fields(record):
        for note in getattr(hints[entry.name], "__metadata__", ()):
            if isinstance(note, Column):
                kind, name = hints[entry.name].__origin__, note.name or entry.name
                found.append(_Described(entry.name, kind, name, note, entry.init))
    return tuple(found)


def columns(*records: type, without: Collection[str] = ()) -> tuple[Dataset, ...]:
    """Return the columns of a table whose rows these records fill, `without` some of them."""
    every = (entry for record in records for entry in _described(record))
    return tuple(_dataset(entry) for entry in every if entry.name not in without)


def _dataset(entry: _Described) -> Dataset:
    column, fill = entry.column, _FILLS.get(entry.kind, 0)
    dtype = _DTYPES[entry.kind]
    return Dataset(entry.name, DIMS, dtype, column.units, column.long_name, fill, column.flags)


def row_of(*records: Any) -> Row:
    """Return the row that some records fill together."""
    described = ((record, entry) for record in records for entry in _described(type(record)))
    return {entry.name: getattr(record, entry.field) for record, entry in described}


def record_of(record: type[Record], row: Row, **more: Any) -> Record:
    """Return the record that filled a row; `more` are its fields that are no columns."""
    described = (entry for entry in _described(record) if entry.given and entry.name in row)
    return record(**{entry.field: entry.kind(row[entry.name]) for entry in described}, **more)


def table_of(columns: Iterable[Dataset], rows: Collection[Row]) -> dict[str, np.ndarray]:
    """Return rows as contiguous arrays by column."""
    found = {}
    for column in columns:
        dtype: Any = np.str_ if column.dtype == "str" else column.dtype
        found[column.name] = np.array([row[column.name] for row in rows], dtype=dtype)
    return found
