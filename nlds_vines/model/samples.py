"""Tables of samples: sets of parameters, one a row, which are computed one after the other.

A table is a mapping of arrays, a DataFrame, or a CSV file whose first line names the columns.
Values are in SI units.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.errors import RequestError, at, number, shown
from nlds_vines.model.axis import MOST_VALUES
from nlds_vines.model.parameters import described, ends_in_words

if TYPE_CHECKING:
    from nlds_vines.model.setting import Merged

SAMPLE = "sample"
"""The dimension of results of samples."""

FILE = "file"
"""The key of a table `[samples]` that names a CSV file in place of columns."""


@dataclass(frozen=True, eq=False)
class Samples:
    """A table of samples; `columns` are read-only arrays (n,) of finite numbers by name."""

    columns: Mapping[str, np.ndarray]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.columns)

    @property
    def count(self) -> int:
        return next(iter(self.columns.values())).size

    def document(self) -> dict[str, list[float]]:
        return {name: values.tolist() for name, values in self.columns.items()}

    def ranges(self) -> list[str]:
        return [
            f"{name} = {ends_in_words(name, float(values.min()), float(values.max()))}"
            for name, values in self.columns.items()
        ]

    def contents(self) -> Iterator[tuple[Dataset, np.ndarray]]:
        for name, values in self.columns.items():
            yield described(name).dataset((SAMPLE,)), values

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Samples) and list(self.document().items()) == list(
            other.document().items()
        )

    def __hash__(self) -> int:
        return hash(tuple((name, values.tobytes()) for name, values in self.columns.items()))


def sample_scale(count: int) -> Scale:
    return Scale.counted(SAMPLE, count, "row of the table of samples, from 1", 1)


def samples_of(source: Any) -> Samples:
    """Read a table of samples.

    Parameters
    ----------
    source : Samples, mapping, DataFrame or path-like
        Arrays of one length by name; anything with `columns` as a DataFrame has them; a CSV file,
        or the mapping `{"file": path}`.  The cells of a CSV file are separated by commas, tabs or
        semicolons (which permit decimal commas); lines that begin with # are comments.

    Returns
    -------
    Samples

    Raises
    ------
    RequestError
        For a column of other lengths, text, NaN, an empty table; the message names column and row.

    Examples
    --------
    >>> table = samples_of({"k1": [4e4, 5e4], "C": [0.05, 0.06]})
    >>> table.names, table.count
    (('k1', 'C'), 2)
    """
    if isinstance(source, Samples):
        return source
    if isinstance(source, Mapping) and source.keys() == {FILE}:
        source = source[FILE]
    if isinstance(source, str | os.PathLike):
        with at(f"samples {str(source)!r}"):
            return _checked(_read_csv(Path(source)))
    if hasattr(source, "columns") and not isinstance(source, Mapping):
        source = {name: np.asarray(source[name]) for name in source.columns}
    if not isinstance(source, Mapping):
        text = "must be arrays by name, a DataFrame or the path of a CSV file"
        raise RequestError(f"samples = {shown(source)} {text}")
    with at("samples"):
        return _checked(source)


def samples_in(request: Merged) -> Samples | None:
    """Return the table of samples, if the uppermost layer that varies anything has one."""
    tables = [name for name in ("vary", "samples") if request.document.get(name)]
    if len(tables) == 2:
        tables = [name for name in tables if request.is_changed(name)]
        if len(tables) != 1:
            raise RequestError(f"{request.place('samples')} beside [vary]: give one of them")
    if tables != ["samples"]:
        return None
    with at(request.origin("samples")):
        return samples_of(request.document["samples"])


def _checked(table: Mapping[Any, Any]) -> Samples:
    """Return the table if its columns have one length and finite numbers."""
    if not table:
        raise RequestError("the table has no column")
    columns: dict[str, np.ndarray] = {}
    for name, values in table.items():
        if not isinstance(name, str):
            raise RequestError(f"column {shown(name)} must be named by a string")
        try:
            array = np.asarray(values)
            if array.dtype.kind in "US":  # numbers beside text became text, too
                array = np.asarray(values, dtype=object)
        except ValueError:  # lists of different lengths
            array = np.zeros((0, 0))
        if array.ndim != 1:
            raise RequestError(f"column {name} must be a list of numbers")
        if array.dtype.kind not in "iuf" or not np.isfinite(array).all():
            for row, value in enumerate(array.tolist(), start=1):
                with at(f"row {row}"):
                    number(name, value)
        columns[name] = array.astype(np.float64) + 0.0  # -0.0 becomes 0.0; a copy
        columns[name].setflags(write=False)
    counts = {name: column.size for name, column in columns.items()}
    if len({*counts.values()}) > 1:
        words = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise RequestError(f"columns of different lengths: {words}; all must have as many values")
    if not 1 <= (count := min(counts.values())) <= MOST_VALUES:
        raise RequestError(f"the table has {count} rows; allowed: 1 to {MOST_VALUES}")
    return Samples(columns)


def _read_csv(path: Path) -> dict[str, np.ndarray]:
    """Return the columns of a CSV file; a cell that is no number is refused with its line."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no text (UTF-8)"
        raise RequestError(f"cannot be read: {reason}") from None
    lines = enumerate(text.splitlines(), start=1)
    numbered = {i: line for i, line in lines if line.strip() and not line.startswith("#")}
    if not numbered:
        raise RequestError("the file is empty; its first line must name the columns")
    separator = max(",;\t", key=next(iter(numbered.values())).count)
    heading, *rows = csv.reader(numbered.values(), delimiter=separator)
    names = [name.strip() for name in heading]
    if "" in names:
        raise RequestError(
            f"column {names.index('') + 1} has no name; pandas writes its index so: "
            "to_csv(..., index=False)"
        )
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise RequestError(f"column {shown(twice)} occurs twice")
    values = np.empty((len(rows), len(names)))
    for i, (line, row) in enumerate(zip([*numbered][1:], rows, strict=False)):
        if len(row) != len(names):
            raise RequestError(f"line {line} has {len(row)} cells, the heading {len(names)}")
        for j, cell in enumerate(row):
            try:
                values[i, j] = float(cell.replace(",", ".") if separator == ";" else cell)
            except ValueError:
                place = f"{names[j]} = {shown(cell)} in line {line}"
                raise RequestError(f"{place} must be a number") from None
    return dict(zip(names, values.T, strict=True))
