"""TOML read, with errors of one line; TOML written, in the canonical form that is hashed."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nlds_vines.errors import RequestError

MOST_BYTES = 2**28
"""Bytes of a TOML file: enough for the values of the longest axis, written out."""

_HDF5 = b"\x89HDF\r\n\x1a\n"
"""The first bytes of an archive."""

MOST_LEVELS = 64
"""Tables within tables: no request has more than five, and the reader's memory grows as n²."""

_DEEP_KEY = re.compile(
    r"""(?:^[ \t\[]*|[{,]\s*)(?:(?>[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){64}""",
    re.MULTILINE,
)
"""A key that names so many tables: where a line begins, or a key of a table in one line."""

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def read_toml(path: Path) -> dict[str, Any]:
    """Return the document in the TOML file `path`.

    Raises `RequestError` with file, line and column where the file cannot be read as TOML.
    """
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):  # opening a pipe would wait
            raise RequestError(f"{path}: cannot be read: it is no regular file")
        if path.is_file() and path.stat().st_size > MOST_BYTES:
            text = f"it has {path.stat().st_size} bytes; allowed: up to {MOST_BYTES}"
            raise RequestError(f"{path}: cannot be read: {text}")
        content = path.read_bytes()
        if content.startswith(_HDF5):
            raise RequestError(
                f"{path}: is an archive (HDF5), not TOML: `nlds-vines plot {path}` draws it, "
                f"`nlds-vines rerun {path}` computes it again"
            )
        return parse_toml(content.decode("utf-8").replace("\r\n", "\n"), str(path))
    except UnicodeDecodeError as error:
        raise RequestError(f"{path}: not UTF-8 text at byte {error.start}") from None
    except (OSError, ValueError) as error:
        if isinstance(error, RequestError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{path}: cannot be read: {reason}") from None


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the document in the TOML `text`; `where` names it in the message of an error."""
    too_deep = RequestError(f"{where}: malformed TOML: nested too deeply")
    if _DEEP_KEY.search(text):
        raise too_deep
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        lines = text.split("\n")
        end = f"at line {len(lines)}, column {len(lines[-1]) + 1}, the end of the document"
        reason = str(error).replace("at end of document", end)
        raise RequestError(f"{where}: malformed TOML: {reason}") from None
    except RecursionError:
        raise too_deep from None
    if _levels(document) > MOST_LEVELS:
        raise too_deep
    return document


def _levels(document: dict[str, Any]) -> int:
    """Return how many tables and lists stand within one another."""
    levels = 0
    inside: list[Any] = [document]
    while inside:
        levels += 1
        inside = [
            item
            for outer in inside
            for item in (outer.values() if isinstance(outer, dict) else outer)
            if isinstance(item, dict | list)
        ]
    return levels


def toml_text(document: Mapping[str, Any]) -> str:
    """Return `document` as TOML: scalars first, then a `[table]` for each mapping in it.

    Values are str, bool, int, float, sequences of these, mappings, or lists of mappings, each of
    which becomes a table `[[key]]`.  Floats are written with the digits that read back to the same
    bits.
    """
    return "\n".join(_lines(document, ())) + "\n"


def _lines(document: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    plain = {
        key: value
        for key, value in document.items()
        if not (isinstance(value, Mapping) or _are_tables(value))
    }
    lines = [f"{_key(key)} = {_value(value)}" for key, value in plain.items()]
    for key, value in document.items():
        if isinstance(value, Mapping):
            inner = (*path, key)
            only_tables = value and all(isinstance(item, Mapping) for item in value.values())
            header = [] if only_tables else ["", f"[{'.'.join(map(_key, inner))}]"]
            lines += header + _lines(value, inner)
        elif _are_tables(value):
            inner = (*path, key)
            for item in value:
                lines += ["", f"[[{'.'.join(map(_key, inner))}]]", *_lines(item, inner)]
    return lines


def _are_tables(value: object) -> bool:
    """Return whether a value is written as tables `[[key]]`: a list of mappings."""
    return isinstance(value, list) and bool(value) and all(isinstance(v, Mapping) for v in value)


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _value(key)


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
