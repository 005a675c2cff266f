"""Matrices of a host as users bring them: arrays, tables and files, checked before they are used.

A file is dense text (.csv, .txt, .dat, .tsv, .asc), NumPy's .npy or .npz, or Matrix Market's .mtx.
Its header, its shape and the number of its entries are checked against its size before its numbers
are read.
"""

from __future__ import annotations

import io
import math
import os
import re
import sys
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy  # whose modules are loaded when they are first used: systems of one mass need none

from nlds_vines.archives.files import decoded, read_bytes
from nlds_vines.errors import RequestError, at, dof_name, shown
from nlds_vines.model.axis import refuse_masked

MOST_DENSE = 2000
"""The most degrees of freedom whose matrices are dense; a larger host has to be reduced."""

MOST_BYTES = 1 << 28
"""Bytes of a file, and of what is compressed in it: a dense matrix of 5,792 rows."""

MOST_ROWS = 1_000_000
"""Rows of a sparse matrix."""

MOST_ENTRIES = 1 << 24
"""Entries of a file: a dense matrix of 4,096 rows, or a sparse one of 200,000 with 80 a row."""

_ASYMMETRY = 1e-8
"""The largest difference of two entries that should be equal, over the largest entry."""

_LARGEST = 1e100  # entry of a matrix [SI]: the products of three of them are finite
_LONGEST_NAME = 64  # bytes of a name in a .npz
_MOST_NAMED = 8  # arrays that an error lists
_HEADER = 10_000  # bytes of the header of a .npy

NAMES: Mapping[str, tuple[str, ...]] = {
    "M": ("M", "m", "mass"),
    "K": ("K", "k", "stiffness"),
    "C": ("C", "c", "damping"),
}
"""How the matrices are named in a file."""

_IN_WORDS = ".csv, .txt, .dat, .tsv, .asc, .npy, .npz and .mtx"


# ---- arguments -----------------------------------------------------------------------------------


class Labeled(NamedTuple):
    """A matrix, an array or a sparse one, and the names of its columns, () without names."""

    matrix: Any
    labels: tuple[str, ...]


def matrices_of(values: Mapping[str, Any]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return symmetric matrices by name, and the names of their columns, () if none has any.

    Each value is an array, a sparse array, a table of pandas or the path of a file.  Up to
    `MOST_DENSE` rows a matrix is dense, otherwise sparse.  Raises `RequestError` if two matrices
    name their columns differently.
    """
    matrices: dict[str, Any] = {}
    labels: tuple[str, ...] = ()
    first = ""
    for name, value in values.items():
        is_path = isinstance(value, str | os.PathLike)
        with at(f"{name} = {shown(str(value))}" if is_path else ""):
            entries = read_matrix(name, Path(value)) if is_path else _labeled(name, value)
            matrices[name] = _symmetric(name, entries.matrix)
        if labels and entries.labels and entries.labels != labels:
            raise RequestError(f"{name} names its columns otherwise than {first}")
        if entries.labels and not labels:
            labels = entries.labels
            first = name
    return matrices, labels


def _labeled(name: str, value: Any) -> Labeled:
    """Return an array or a table of pandas, whose rows must have the names of its columns."""
    if not (hasattr(value, "columns") and hasattr(value, "index") and hasattr(value, "to_numpy")):
        return Labeled(value, ())
    labels = _labels("columns", value.columns)
    rows = _labels("rows", value.index)
    if rows and rows != labels:
        raise RequestError(f"{name} names its rows otherwise than its columns")
    return Labeled(value.to_numpy(), labels)


def _labels(what: str, index: Any) -> tuple[str, ...]:
    """Return the labels of the columns or rows of a table, () if they only count from 0."""
    labels = list(index)
    if labels == list(range(len(labels))):
        return ()
    return tuple(dof_name(what, label) for label in labels)


def _symmetric(name: str, value: Any) -> Any:
    if not scipy.sparse.issparse(value):
        value = array_of(name, value, "a matrix of numbers")
    if value.ndim != 2 or value.shape[0] != value.shape[1] or value.shape[0] == 0:
        hint = ": np.diag makes it of a diagonal" if value.ndim == 1 else ""
        raise RequestError(f"{name} has the shape {value.shape}; it must be square{hint}")
    entries = scipy.sparse.coo_array(value)
    entries.data = without_imaginary_parts(entries.data)
    if entries.data.dtype.kind not in "iuf" or not np.isfinite(entries.data).all():
        raise RequestError(f"{name} holds a value that is no finite real number")
    entries = entries.astype(np.float64)
    if entries.nnz and np.abs(entries.data).max() > _LARGEST:
        raise RequestError(f"{name} holds a value beyond {_LARGEST:g}, in SI units")
    difference = scipy.sparse.coo_array(entries - entries.T)
    worst = np.abs(difference.data).argmax() if difference.nnz else 0
    if difference.nnz and abs(difference.data[worst]) > _ASYMMETRY * np.abs(entries.data).max():
        i, j = sorted((difference.row[worst], difference.col[worst]))
        one, other = entries.tocsr()[[i, j], [j, i]].ravel()
        raise RequestError(
            f"{name} is not symmetric: {name}[{i}, {j}] = {float(one)!r}, {name}[{j}, {i}] = "
            f"{float(other)!r}{_triangle(entries)}"
        )
    symmetric = (entries + entries.T).tocsc() / 2
    return symmetric.toarray() if value.shape[0] <= MOST_DENSE else symmetric


def _triangle(entries: Any) -> str:
    """Return the hint for a matrix that is 0 above or below its diagonal, otherwise ""."""
    is_stored = entries.data != 0
    below = bool((entries.row > entries.col)[is_stored].any())
    above = bool((entries.row < entries.col)[is_stored].any())
    if below and above:
        return ""
    side = "lower" if below else "upper"
    return f": it is its {side} triangle alone; give all of it, A + A.T - np.diag(A.diagonal())"


def array_of(name: str, value: Any, words: str) -> np.ndarray:
    """Return an array of floats, or of complex numbers if an imaginary part is not 0."""
    refuse_masked(name, value)
    try:
        array = np.array(value, dtype=complex if np.iscomplexobj(value) else float)
    except (TypeError, ValueError, OverflowError):
        raise RequestError(f"{name} = {shown(value)} must be {words}") from None
    return without_imaginary_parts(array)


def without_imaginary_parts(array: np.ndarray) -> np.ndarray:
    """Return the real parts of complex numbers whose imaginary parts are 0; others as they are."""
    return array.real if np.iscomplexobj(array) and not array.imag.any() else array


# ---- files ---------------------------------------------------------------------------------------


def read_matrix(name: str, path: Path) -> Labeled:
    """Read the matrix in a file; of a .npz with several, the one of the `name`.

    Raises `RequestError` for a file that is damaged, no regular one, too large or of another type.
    """
    suffix = path.suffix.lower()
    if suffix not in _READERS:
        _refuse_suffix(suffix)
    return _READERS[suffix](name, read_bytes(path, MOST_BYTES))


def read_arrays(path: Path) -> dict[str, Any]:
    """Return the matrices M, K and C, `influence` and `dofs` of a .npz file, those that it has."""
    suffix = path.suffix.lower()
    if suffix in _READERS and suffix != ".npz":
        raise RequestError(
            f"a {suffix} file holds one matrix: nv.Host(M='M{suffix}', K='K{suffix}') reads two"
        )
    if suffix in (".toml", ".h5"):
        raise RequestError(f"a {suffix} file holds no host: nv.load_system reads a system of .toml")
    if suffix != ".npz":
        _refuse_suffix(suffix)
    members = _members(read_bytes(path, MOST_BYTES))
    arrays: dict[str, Any] = {}
    for name, aliases in NAMES.items():
        present = [alias for alias in aliases if alias in members]
        if len(present) > 1:
            raise RequestError(f"{present[0]} stands beside {present[1]}: give one of them")
        if present:
            arrays[name] = members[present[0]]
        elif name != "C":
            raise members.lack(name)
    for name in ("influence", "dofs"):
        if name in members:
            values = np.ravel(members[name])
            with at(name), _in_one_line():
                texts = np.char.decode(values, "utf-8") if values.dtype.kind == "S" else values
                arrays[name] = texts.tolist()
    return arrays


def _refuse_suffix(suffix: str) -> None:
    if suffix == ".mat":
        raise RequestError(
            "MATLAB's files are not read here: a = scipy.io.loadmat(path) in Python reads one, "
            f"then nv.Host(M=a['M'], K=a['K']); allowed: {_IN_WORDS}"
        )
    raise RequestError(f"{suffix or 'no suffix'} is no type of a matrix; allowed: {_IN_WORDS}")


@contextmanager
def _in_one_line() -> Iterator[None]:
    """Turn what a damaged file lets zipfile and NumPy raise, which is not listed, into one line."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except RequestError:
        raise
    except Exception as error:
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise RequestError(f"is damaged: {reason}") from None


# ---- .npy and .npz -------------------------------------------------------------------------------


def _npy(name: str, data: bytes) -> Labeled:
    return Labeled(_array_in(data), ())


def _array_in(data: bytes) -> np.ndarray:
    """Return the array in the bytes of a .npy file, whose shape must be that of its bytes."""
    file = io.BytesIO(data)
    with _in_one_line():
        version = np.lib.format.read_magic(file)
        readers = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }
        if version not in readers:
            raise RequestError(f"has version {version} of the .npy format; allowed: 1.0 and 2.0")
        shape, is_fortran, dtype = readers[version](file, max_header_size=_HEADER)
    if dtype.kind not in "iufcUS":
        raise RequestError(f"holds values of type {dtype}; allowed: numbers, and names as text")
    size = math.prod(shape) * dtype.itemsize
    left = len(data) - file.tell()
    if size != left or min(shape, default=1) < 0:
        raise RequestError(f"is damaged: its shape {shape} takes {size} bytes, but it has {left}")
    if math.prod(shape) > MOST_ENTRIES:
        raise RequestError(f"has {math.prod(shape)} entries; allowed: up to {MOST_ENTRIES}")
    if dtype.kind == "U" and size:
        letters = np.frombuffer(data, np.dtype("u4").newbyteorder(dtype.byteorder), -1, file.tell())
        if letters.max() > sys.maxunicode:  # NumPy would make a text that Python cannot read
            raise RequestError(f"is damaged: {letters.max()} is the number of no character")
    with _in_one_line():
        values = np.frombuffer(data, dtype, offset=file.tell())
        return values.reshape(shape, order="F" if is_fortran else "C")


class _Members(dict[str, np.ndarray]):
    """The arrays of a .npz file that are read, by name; `others` are the names of the rest."""

    others: list[str]

    def lack(self, name: str) -> RequestError:
        """Return the error for a matrix that is not among the arrays."""
        has = [*self, *self.others]
        words = ", ".join(has[:_MOST_NAMED]) + ", ..." * (len(has) > _MOST_NAMED)
        return RequestError(
            f"has no array {name} (or {', '.join(NAMES[name][1:])}); it has: {words or 'none'}"
        )


def _members(data: bytes) -> _Members:
    """Return the arrays in the bytes of a .npz file.

    What its members take when they are decompressed is limited before they are: 3 MB may be 5 GB.
    """
    arrays = _Members()
    arrays.others = []
    with _in_one_line(), zipfile.ZipFile(io.BytesIO(data)) as archive:
        entries = archive.infolist()
        total = sum(entry.file_size for entry in entries)
        if total > MOST_BYTES:
            raise RequestError(f"holds {total} bytes; allowed: up to {MOST_BYTES}")
        for entry in entries:
            name = entry.filename.removesuffix(".npy")
            if len(name) > _LONGEST_NAME or not name.isprintable():
                raise RequestError(f"holds a member {shown(name)}, which is no name of an array")
            if name in arrays:
                raise RequestError(f"holds two members {shown(name)}")
            # of other methods one byte may become a million in one step
            is_plain = entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
            if entry.flag_bits & 1 or not is_plain:
                raise RequestError(f"its member {shown(name)} is encrypted or packed otherwise")
            if not _is_read(name):
                arrays.others.append(name)
                continue
            with archive.open(entry) as member:
                content = member.read(entry.file_size + 1)
            with at(shown(name)):
                arrays[name] = _array_in(content)
    return arrays


_OF_SPARSE = ("data", "row", "col", "indices", "indptr", "offsets", "shape", "format")


def _is_read(name: str) -> bool:
    """Return True if a member of a .npz has a matrix or belongs to one; others are left alone."""
    aliases = [alias for names in NAMES.values() for alias in names]
    return name in (*aliases, "influence", "dofs", *_OF_SPARSE)


def _npz(name: str, data: bytes) -> Labeled:
    """Read the matrix of a name, or the sparse matrix that `scipy.sparse.save_npz` wrote."""
    members = _members(data)
    if {"format", "shape", "data"} <= members.keys():
        return Labeled(_saved_sparse(members), ())
    present = [alias for alias in NAMES[name] if alias in members]
    if len(present) != 1:
        raise members.lack(name)
    return Labeled(members[present[0]], ())


_PLACES = {
    "coo": ("row", "col"),
    "csr": ("indices", "indptr"),
    "csc": ("indices", "indptr"),
    "bsr": ("indices", "indptr"),
    "dia": ("offsets",),
}
"""The arrays that say where the entries of a sparse matrix are, by its format."""

_DIMENSIONS = {"dia": 2, "bsr": 3}  # of the entries, otherwise 1


def _saved_sparse(members: Mapping[str, np.ndarray]) -> Any:
    form = str(members["format"].astype("U").item()) if members["format"].size == 1 else ""
    shape = members["shape"].ravel().tolist()
    values = members["data"]
    if form not in _PLACES or not {*_PLACES[form]} <= members.keys():
        formats = ", ".join(_PLACES)
        raise RequestError(f"is no sparse matrix in one of the formats {formats}: {shown(form)}")
    places = [members[key] for key in _PLACES[form]]
    is_whole = all(array.dtype.kind in "iu" and array.ndim == 1 for array in places)
    is_sound = values.ndim == _DIMENSIONS.get(form, 1) and values.dtype.kind in "iufc"
    if not is_whole or not is_sound or len(shape) != 2:
        raise RequestError("is damaged: its arrays are no sparse matrix")
    _check_size(shape)
    if form == "dia":
        return _diagonals(shape, values, places[0])
    if form == "coo":
        return _coordinates(shape, places[0], places[1], values)
    indices, pointers = places
    height, width = values.shape[1:] if form == "bsr" else (1, 1)
    if height == 0 or width == 0 or shape[0] % height or shape[1] % width:
        raise RequestError("is damaged: its blocks do not fit its shape")
    count = shape[0] // height if form != "csc" else shape[1]
    steps = pointers[1:].astype(np.int64) - pointers[:-1].astype(np.int64)
    is_sound = pointers.size == count + 1 and pointers[0] == 0 and pointers[-1] == len(values)
    if not is_sound or (steps < 0).any():
        raise RequestError("is damaged: its index pointers do not ascend to its entries")
    if indices.size != len(values):
        raise RequestError("is damaged: its entries and their indices differ in number")
    groups = np.repeat(np.arange(count), steps)
    if form == "csc":
        return _coordinates(shape, indices, groups, values)
    if form == "bsr":
        rows = groups[:, None, None] * height + np.arange(height)[:, None]
        columns = indices[:, None, None].astype(np.int64) * width + np.arange(width)
        groups = np.broadcast_to(rows, values.shape).ravel()
        indices = np.broadcast_to(columns, values.shape).ravel()
    return _coordinates(shape, groups, indices, values.ravel())


def _diagonals(shape: Sequence[int], values: np.ndarray, offsets: np.ndarray) -> Any:
    """Return the sparse matrix of `values` (diagonals, columns), each j - i = offset."""
    if len(offsets) != len(values):
        raise RequestError("is damaged: its diagonals and their offsets differ in number")
    columns = np.broadcast_to(np.arange(values.shape[1]), values.shape)
    rows = columns - offsets[:, None].astype(np.int64)
    is_inside = (rows >= 0) & (rows < shape[0]) & (columns < shape[1])  # others are no entries
    return _coordinates(shape, rows[is_inside], columns[is_inside], values[is_inside])


def _check_size(shape: Sequence[Any]) -> None:
    rows, columns = shape
    if rows != columns or not 1 <= rows <= MOST_ROWS:
        raise RequestError(
            f"states {rows} rows and {columns} columns; allowed: as many, from 1 to {MOST_ROWS}"
        )


def _coordinates(shape: Sequence[int], rows: Any, columns: Any, values: Any) -> Any:
    """Return the sparse matrix of entries at indices from 0, each at most once."""
    if not rows.size == columns.size == values.size:
        raise RequestError("is damaged: its entries and their indices differ in number")
    for index in (rows, columns):
        if index.size and not 0 <= index.min() <= index.max() < shape[0]:
            raise RequestError(f"is damaged: an index is outside of its {shape[0]} rows")
    places = rows.astype(np.int64) * shape[1] + columns.astype(np.int64)
    places.sort()
    twice = places[1:][np.diff(places) == 0]
    if twice.size:
        row, column = divmod(int(twice[0]), shape[1])
        raise RequestError(f"states the entry in row {row + 1}, column {column + 1} twice")
    return scipy.sparse.coo_array((values, (rows, columns)), shape=tuple(shape))


# ---- text ----------------------------------------------------------------------------------------

_NOTES = (b"#", b"%", b"//", b"!", b"**", b"sep=")  # marks before comments; the last is Excel's
_FORTRAN = bytes.maketrans(b"dD", b"eE")  # exponents
_NUMBER = re.compile(rb"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_DECIMAL_COMMA = re.compile(rb"[+-]?[0-9]+,[0-9]+(?:[eEdD][+-]?[0-9]+)?")
_THOUSANDS = re.compile(rb'"[+-]?[0-9]{1,3}(?:,[0-9]{3})+(?:\.[0-9]*)?"')
_WHOLE = re.compile(r"[0-9]{1,9}")
_SIGNS = {0x2212: "-", 0xA0: " ", 0x202F: " ", 0x1A: None}
_MOST_COLUMNS = math.isqrt(MOST_ENTRIES)
_LONGEST_LINE = re.compile(rb"[^\n]{300}")  # of one entry of Matrix Market


def _text(name: str, data: bytes) -> Labeled:
    """Read a dense matrix: commas, semicolons or tabs or blanks with either decimal sign.

    A first line of names or of node numbers labels the columns, and a first column that repeats
    them, or stands alone, the rows.
    """
    if _BANNER.match(data):  # as ANSYS may name it
        return _market(name, data)
    lines = _lines(data)
    cut = _separator(max(lines[1:] or lines, key=len))
    if cut is not None:
        lines = _without_margins(lines, cut)
    if cut == b",":
        _refuse_thousands(data)
    else:
        lines = _with_decimal_points(lines)
    labels, lines = _named(lines, cut)
    if cut is not None:
        _check_empty_cells(lines, cut)
    _check_widths([len(line.split(cut, _MOST_COLUMNS)) for line in lines])
    if labels and len(labels) != len(lines):
        raise RequestError(
            f"its first line has the words {shown(', '.join(labels))}, but {len(lines)} columns "
            "need names; a title begins with # or %"
        )
    try:
        delimiter = None if cut is None else cut.decode()
        numbers = [line.translate(_FORTRAN) for line in lines]
        matrix = np.loadtxt(numbers, delimiter=delimiter, comments=None, ndmin=2)
    except ValueError:
        raise _no_number(lines, cut) from None
    return Labeled(matrix, _labels("columns", [_node(label) for label in labels]))


def _is_number(cell: bytes) -> bool:
    return _NUMBER.fullmatch(cell.strip().translate(_FORTRAN)) is not None


def _named(lines: list[bytes], cut: bytes | None) -> tuple[list[str], list[bytes]]:
    """Return the names of the columns, [] if they have none, and the lines of numbers."""
    first = [cell.strip() for cell in lines[0].split(cut, _MOST_COLUMNS)]
    rest = lines[1:]
    are_words = not any(map(_is_number, first))
    are_nodes = all(cell.isdigit() for cell in first)
    begins = [line.split(cut, 1)[0].strip() for line in lines]
    # "node,101,102" above "101,..." and "102,..."
    is_repeated = not _is_number(first[0]) and begins[1:] == first[1:]
    are_nodes_behind = not first[0] and all(cell.isdigit() for cell in first[1:])
    has_head = are_words or is_repeated or are_nodes_behind
    has_head = has_head or (are_nodes and len(rest) == len(first))
    if not rest or not has_head:
        if any(not begin or _is_number(begin) for begin in begins):
            return [], lines
        return _decoded(begins), _without_first_column(lines, cut)
    begins = begins[1:]
    width = len(rest[0].split(cut, _MOST_COLUMNS))
    has_rows = is_repeated or not first[0]
    if has_rows and width == len(first):
        first = first[1:]
    elif begins != first or width != len(first) + 1:
        return _decoded(first), rest
    columns = _labels("columns", [_node(label) for label in _decoded(first)])
    rows = _labels("rows", [_node(label) for label in _decoded(begins)])
    if rows and rows != columns:
        raise RequestError("names its rows otherwise than its columns")
    return _decoded(first), _without_first_column(rest, cut)


def _decoded(cells: Sequence[bytes]) -> list[str]:
    return [cell.decode("utf-8", "replace") for cell in cells]


def _without_first_column(lines: Sequence[bytes], cut: bytes | None) -> list[bytes]:
    parts = [line.split(cut, 1) for line in lines]
    return [part[1] if len(part) > 1 else b"" for part in parts]


def _without_margins(lines: list[bytes], cut: bytes) -> list[bytes]:
    """Return lines without the empty rows and columns that a sheet has around its numbers."""
    lines = [line for line in lines if line.strip(cut + b" ")]
    if not lines:
        raise RequestError("holds no numbers")
    left = min(len(line) - len(line.lstrip(cut)) for line in lines)
    right = min(len(line) - len(line.rstrip(cut)) for line in lines)
    return [line[left : len(line) - right] for line in lines]


def _node(label: str) -> str | int:
    return int(label) if _WHOLE.fullmatch(label) else label


def _lines(data: bytes) -> list[bytes]:
    """Return the lines of a text that are neither empty nor comments, without quotation marks."""
    if not data.isascii() or b"\0" in data or b"\r" in data or data.startswith(b"PK"):
        data = decoded(data).translate(_SIGNS).encode()
    lines: list[bytes] = []
    # without runs of empty lines: 64 MB of line ends would take minutes one by one
    for raw in io.BytesIO(re.sub(rb"\n\s+", b"\n", data)):
        line = raw.strip(b" \r\n").replace(b'"', b"")
        if not line or line.startswith(_NOTES):
            continue
        if len(lines) > _MOST_COLUMNS:
            raise RequestError(f"has more than {_MOST_COLUMNS} rows of numbers")
        lines.append(line)
    if not lines:
        raise RequestError("holds no numbers")
    return lines


def _separator(line: bytes) -> bytes | None:
    """Return the separator of the numbers in a line, None for blanks."""
    for cut in (b";", b"\t"):
        if cut in line:
            return cut
    if b"," not in line:
        return None
    cells = line.split(None, _MOST_COLUMNS)
    is_decimal = all(_DECIMAL_COMMA.fullmatch(cell) for cell in cells if b"," in cell)
    return None if is_decimal and len(cells) > 1 else b","


def _with_decimal_points(lines: list[bytes]) -> list[bytes]:
    """Return lines in which a comma is the decimal sign with points in its place."""
    with_comma = [line for line in lines if b"," in line]
    if any(b"." in line for line in with_comma):
        raise RequestError("holds numbers with a comma and a point: one of them is a decimal sign")
    return [line.replace(b",", b".") for line in lines] if with_comma else lines


def _refuse_thousands(data: bytes) -> None:
    if match := _THOUSANDS.search(data):
        text = match[0].decode()
        raise RequestError(f"holds {text}: export its numbers without signs between thousands")


def _check_empty_cells(lines: list[bytes], cut: bytes) -> None:
    """Raise `RequestError` for an empty cell; Excel may leave those of a triangle empty."""
    pair = cut + cut
    if not any(pair in line or line[:1] == cut or line[-1:] == cut for line in lines):
        return
    first: tuple[int, int] | None = None
    is_lower = True
    is_upper = True
    for row, line in enumerate(lines):
        cells = line.split(cut, _MOST_COLUMNS)
        empty = [column for column, cell in enumerate(cells) if not cell.strip()]
        if empty and first is None:
            first = row, empty[0]
        is_lower = is_lower and empty == [*range(row + 1, len(lines))]
        is_upper = is_upper and empty == [*range(row)]
        if first is not None and not (is_lower or is_upper):
            break
    if first is None:
        return
    if is_lower:
        _refuse_triangle("lower")
    if is_upper:
        _refuse_triangle("upper")
    row, column = first
    raise RequestError(f"row {row + 1}, column {column + 1} is empty: give all numbers, also 0")


def _refuse_triangle(side: str) -> None:
    raise RequestError(
        f"is the {side} triangle of a symmetric matrix alone: give all of its rows in full"
    )


def _check_widths(widths: Sequence[int]) -> None:
    """Raise `RequestError` unless a text has as many numbers in each row as it has rows."""
    count = len(widths)
    for side, triangle in (("lower", range(1, count + 1)), ("upper", range(count, 0, -1))):
        if count > 1 and [*widths] == [*triangle]:
            _refuse_triangle(side)
    for row, width in enumerate(widths, start=1):
        if width != widths[0]:
            raise RequestError(f"row {row} has {width} numbers, the first one {widths[0]}")
    if count != widths[0]:
        hint = ""
        if widths[0] == len(("row", "column", "value")) and count > widths[0]:
            hint = "; rows of `row, column, value` are read by np.loadtxt"
        raise RequestError(f"has the shape ({count}, {widths[0]}); it must be square{hint}")


def _no_number(lines: list[bytes], cut: bytes | None) -> RequestError:
    """Return the error for the first cell of a table that is no number."""
    for row, line in enumerate(lines, start=1):
        for column, cell in enumerate(line.split(cut), start=1):
            if not _is_number(cell):
                text = shown(cell.strip().decode("utf-8", "replace"))
                return RequestError(f"row {row}, column {column}: {text} must be a number")
    return RequestError("holds a cell that is no number")


# ---- Matrix Market -------------------------------------------------------------------------------

_BANNER = re.compile(
    rb"%%MatrixMarket\s+matrix\s+(?P<form>coordinate|array)"
    rb"\s+(?P<field>real|double|integer|complex|pattern)"
    rb"\s+(?P<symmetry>general|symmetric|hermitian|skew-symmetric)",
    re.IGNORECASE,
)


def _market(name: str, data: bytes) -> Labeled:
    """Read a Matrix Market file, of which the size line must agree with the lines that follow.

    SciPy's reader ends the process at some damaged files, and believes any size.
    """
    file = io.BytesIO(data)
    banner = _BANNER.fullmatch(file.readline(_LONGEST_BANNER).strip())
    if banner is None:
        raise RequestError(
            "has no header of Matrix Market, `%%MatrixMarket matrix coordinate real symmetric`; "
            "Abaqus' rows of `row, column, value` are read by np.loadtxt"
        )
    form, field, symmetry = (banner[key].decode().lower() for key in _BANNER.groupindex)
    if field == "pattern" or symmetry == "skew-symmetric":
        raise RequestError(f"is of the kind {field}, {symmetry}: no matrix of a host")
    size: list[bytes] = []
    while not size:
        line = file.readline()
        if not line:
            raise RequestError("is damaged: it ends before the line with its size")
        size = [] if line.startswith(b"%") else line.split(None, 3)
    is_sparse = form == "coordinate"
    if len(size) != 2 + is_sparse or not all(_WHOLE.fullmatch(n.decode("latin-1")) for n in size):
        words = "rows, columns and entries" if is_sparse else "rows and columns"
        text = shown(b" ".join(size).decode("latin-1"))
        raise RequestError(f"is damaged: its size {text} must be {words}")
    shape = [int(size[0]), int(size[1])]
    _check_size(shape)
    n = shape[0]
    count = int(size[2]) if is_sparse else (n * n if symmetry == "general" else n * (n + 1) // 2)
    width = 2 * is_sparse + (2 if field == "complex" else 1)
    numbers = _entries(file.read(), count, width)
    values = numbers[:, -1]
    if field == "complex":
        values = numbers[:, -2] + 1j * numbers[:, -1]
    if is_sparse:
        places = numbers[:, :2] - 1
        is_index = (places >= 0) & (places < n) & (places == np.floor(places))
        if not is_index.all():
            raise RequestError(f"is damaged: an index is no whole number from 1 to {n}")
        columns, rows = places[:, 1].astype(np.int64), places[:, 0].astype(np.int64)
    elif symmetry == "general":
        columns, rows = (index.ravel() for index in np.indices((n, n)))
    else:
        columns, rows = np.triu_indices(n)  # by column, from the diagonal on
    if symmetry != "general":
        beside = rows != columns
        mirrored = values[beside].conj() if symmetry == "hermitian" else values[beside]
        values = np.concatenate([values, mirrored])
        rows, columns = (
            np.concatenate([rows, columns[beside]]),
            np.concatenate([columns, rows[beside]]),
        )
    return Labeled(_coordinates(shape, rows, columns, values), ())


_LONGEST_BANNER = 200  # bytes


def _entries(body: bytes, count: int, width: int) -> np.ndarray:
    """Return the numbers below the size line, (count, width)."""
    body = re.sub(rb"\n\s+", b"\n", body.replace(b"\r", b"\n").strip()).translate(_FORTRAN)
    lines = body.count(b"\n") + 1 if body else 0
    if lines != count:
        raise RequestError(f"is damaged: it states {count} entries, and has {lines} lines of them")
    if count > MOST_ENTRIES:
        raise RequestError(f"has {count} entries; allowed: up to {MOST_ENTRIES}")
    if count == 0:
        return np.zeros((0, width))
    if _LONGEST_LINE.search(body):
        raise RequestError("is damaged: a line is longer than an entry can be")
    with _in_one_line():
        numbers = np.loadtxt(io.BytesIO(body), comments=None, ndmin=2)
    if numbers.shape != (count, width):
        raise RequestError(
            f"is damaged: its entries have {numbers.shape[1]} numbers each, not {width}"
        )
    return numbers


_READERS: Mapping[str, Callable[[str, bytes], Labeled]] = {
    ".csv": _text,
    ".txt": _text,
    ".dat": _text,
    ".tsv": _text,
    ".asc": _text,
    ".npy": _npy,
    ".npz": _npz,
    ".mtx": _market,
}
