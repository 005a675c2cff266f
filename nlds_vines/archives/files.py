"""Files that appear whole or not at all, and TOML.

A writer may be killed, or the power cut, between any two system calls.  So no file is written in
place: the bytes go to a temporary file, are forced to the disk (fsync), and take their name by a
rename, which is forced to the disk as well (fsync of the folder).
"""

from __future__ import annotations

import codecs
import csv
import io
import json
import os
import re
import secrets
import stat
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from nlds_vines.errors import RequestError

_HDF5 = b"\x89HDF\r\n\x1a\n"  # the first bytes of every archive

_MOST_TOML = 1 << 27  # bytes: matrices and records may stand in a request

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


@contextmanager
def in_one_line(doing: str) -> Iterator[None]:
    """Turn an error of the operating system or of HDF5 into "cannot `doing`: reason".

    HDF5 reports a full disk as OSError or, while closing, as RuntimeError, both over many lines.
    """
    try:
        yield
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise RequestError(f"cannot {doing}: {reason}") from error


@contextmanager
def whole(path: Path, *, archive: bool = False) -> Iterator[Path]:
    """Return the path of a temporary file that becomes `path` at the end of the `with` block.

    The file and its name are forced to the disk.  A symbolic link stays, and what it points to is
    replaced.  If the block fails, everything is as it was.  `archive` as in `protection`.
    """
    target = Path(os.path.realpath(path))
    if reason := protection(target, archive=archive):
        raise RequestError(f"cannot write {path}: {reason}")
    temporary = target.with_name(f"{secrets.token_hex(8)}.tmp")  # nobody can foresee it
    try:
        yield temporary
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())
        os.replace(temporary, target)
        sync_folder(target.parent)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text as the file `path`, as `whole`; `RequestError` of one line if that fails."""
    with in_one_line(f"write {path}"), whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


def write_csv(
    path: str | os.PathLike[str], rows: Iterable[Iterable[object]], overwrite: bool
) -> None:
    """Write rows as comma-separated values; refuse a file that exists unless `overwrite`."""
    if os.path.lexists(path) and not overwrite:
        raise RequestError(f"{path} exists: overwrite=True replaces it, another name keeps it")
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows(rows)
    write_text(Path(path), text.getvalue())


class Csv:
    """A result whose rows, of which the first names the columns, can be written as a table."""

    def csv_rows(self) -> Iterable[Iterable[object]]:
        raise NotImplementedError

    def to_csv(self, path: str | os.PathLike[str], overwrite: bool = False) -> None:
        """Write a table of comma-separated values.

        Parameters
        ----------
        path : path-like
            The file to write.
        overwrite : bool, optional
            Whether a file of this name is replaced.

        Raises
        ------
        RequestError
            If the file exists and is not to be replaced, or cannot be written.
        """
        write_csv(path, self.csv_rows(), overwrite)


def sync_folder(folder: Path) -> None:
    if os.name == "posix":  # Windows opens no folder
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def protection(path: Path, *, archive: bool = False) -> str | None:
    """Return in words what forbids to replace the file `path`; None if nothing does.

    Only an archive (`archive`) replaces an archive.  A read-only file is not replaced, although a
    rename could.  Raises OSError if the file cannot be looked at.
    """
    try:
        with open_regular(path) as file:
            is_archive = file.read(len(_HDF5)) == _HDF5
            mode = os.fstat(file.fileno()).st_mode
    except FileNotFoundError:
        return None
    except PermissionError:  # it cannot be read, and so may be an archive
        is_archive, mode = True, path.stat().st_mode
    except ValueError as error:
        return str(error)
    if not mode & 0o222:
        return "it is read-only"
    if is_archive and not archive:
        return "it is an archive, which nothing else replaces"
    return None


def open_regular(path: Path) -> BinaryIO:
    """Open a regular file; ValueError for a pipe or a device, to read which might never end."""
    flags = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)  # a pipe would be waited for
    descriptor = os.open(path, os.O_RDONLY | flags)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise ValueError("it is no regular file")
    return os.fdopen(descriptor, "rb")


def read_bytes(path: Path, most: int, first: int | None = None) -> bytes:
    """Return the content of a regular file of at most `most` bytes, or its `first` bytes.

    Raises `RequestError` for any other file: every file that a user names is read by this function.
    """
    try:
        with open_regular(path) as file:
            if first is not None:
                return file.read(first)
            size = os.fstat(file.fileno()).st_size
            content = file.read(most + 1) if size <= most else b""
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"cannot be read: {reason}") from None
    if size > most or len(content) > most:
        raise RequestError(f"has {max(size, len(content))} bytes; allowed: up to {most}")
    return content


def decoded(data: bytes) -> str:
    """Return a text in UTF-8, UTF-16 or Latin-1, with line ends \\n and without a byte order mark.

    Raises `RequestError` for a workbook, a compressed file and whatever else is no text.
    """
    if data.startswith((b"PK\x03\x04", b"\x1f\x8b", b"\xd0\xcf\x11\xe0")):
        raise RequestError("is a workbook or compressed; save it as text (CSV)")
    is_utf16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    encodings = ["utf-16"] if is_utf16 else ["utf-8-sig", "latin-1"]
    if not is_utf16 and 0 in data[:100]:
        encodings = ["utf-16-le" if 0 in data[1:100:2] else "utf-16-be"]
    reason = ""
    for encoding in encodings:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError as error:
            reason = f"is no text: {encoding} fails at byte {error.start}"
            continue
        if "\0" in text:
            raise RequestError("is no text: it holds the character 0")
        return text.replace("\r\n", "\n").replace("\r", "\n")
    raise RequestError(reason)


def read_toml(path: Path) -> dict[str, Any]:
    """Return the document in a TOML file; `RequestError` with the place if it cannot be read."""
    try:
        if read_bytes(path, _MOST_TOML, first=len(_HDF5)) == _HDF5:
            raise RequestError(
                f"is an archive (HDF5), not TOML: `nlds-vines plot {path}` draws it, "
                f"`nlds-vines rerun {path}` computes it again"
            )
        text = read_bytes(path, _MOST_TOML).decode("utf-8")
    except UnicodeDecodeError as error:
        raise RequestError(f"{path}: not UTF-8 text at byte {error.start}") from None
    except RequestError as error:
        raise RequestError(f"{path}: {error}") from None
    return parse_toml(text.replace("\r\n", "\n"), str(path))


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the document in the TOML `text`; `where` names it in the message of an error."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        lines = text.split("\n")
        end = f"at line {len(lines)}, column {len(lines[-1]) + 1}, the end of the document"
        reason = str(error).replace("at end of document", end)
        raise RequestError(f"{where}: malformed TOML: {reason}") from None
    except RecursionError:
        raise RequestError(f"{where}: malformed TOML: nested too deeply") from None


def toml_text(document: Mapping[str, Any]) -> str:
    """Return `document` as TOML: scalars first, then a `[table]` for each mapping in it.

    Lists of mappings become tables `[[key]]`.  Floats have the digits that read back to their bits.
    """
    return "\n".join(_lines(document, "")) + "\n"


def _lines(document: Mapping[str, Any], path: str) -> Iterator[str]:
    tables = {}
    for key, value in document.items():
        name = key if _BARE_KEY.fullmatch(key) else _value(key)
        is_list = isinstance(value, list) and value != []
        if isinstance(value, Mapping) or (is_list and all(isinstance(v, Mapping) for v in value)):
            tables[path + name] = value
        else:
            yield f"{name} = {_value(value)}"
    for name, value in tables.items():
        if not isinstance(value, Mapping):
            for item in value:
                yield from ("", f"[[{name}]]", *_lines(item, f"{name}."))
            continue
        if not (value and all(isinstance(item, Mapping) for item in value.values())):
            yield from ("", f"[{name}]")
        yield from _lines(value, f"{name}.")


def _value(value: Any) -> str:
    if isinstance(value, str):
        # JSON's escapes are TOML's, but for DEL, which TOML wants escaped as well
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(float(value))  # NumPy's own floats print differently
    return f"[{', '.join(map(_value, value))}]"
