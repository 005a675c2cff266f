"""The one error of a wrong request, and the small checks at the door that raise it.

Every message is one line that says what was given, where, and what is allowed.
"""

from __future__ import annotations

import difflib
import math
import numbers
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any


class RequestError(ValueError):
    """The request is wrong: an unknown name, a value out of range, a contradiction.

    The message is one line that names what was given, where, and what is allowed.
    """


@contextmanager
def at(where: str) -> Iterator[None]:
    """Prefix the message of a `RequestError` raised inside with the place it comes from.

    Arguments: `where`, a file, table or option; empty for no prefix.
    """
    try:
        yield
    except RequestError as error:
        raise RequestError(f"{where}: {error}" if where else str(error)) from None


def shown(value: object, width: int = 60) -> str:
    """Return `value` as it is quoted in a message: its repr, shortened to `width` characters."""
    text = repr(value)
    return text if len(text) <= width else f"{text[: width - 4]} ..."


def unknown(what: str, given: object, allowed: Iterable[str]) -> RequestError:
    """Return the error for a name that does not exist, with the nearest one that does.

    Arguments: `what` kind of name it is, the name as `given`, and the names that are `allowed`.
    """
    names = list(allowed)
    near = difflib.get_close_matches(str(given)[:60], names, n=1, cutoff=0.5)
    hint = f"; did you mean {near[0]!r}?" if near else ";"
    return RequestError(f"unknown {what} {shown(given)}{hint} allowed: {', '.join(names)}")


def number(what: str, value: object) -> float:
    """Return `value` as a float; integers become floats here.

    Raises `RequestError` for anything but a finite real number (a bool is none).
    """
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise RequestError(f"{what} = {shown(value)} must be a number")
    try:
        result = float(value) + 0.0  # -0.0 becomes 0.0: equal numbers print alike
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise RequestError(f"{what} = {shown(value)} must be a finite number")
    return result


def whole(what: str, value: object, low: int, high: int = 10**9) -> int:
    """Return `value` as an int.

    Raises `RequestError` for anything but a whole number from `low` to `high` (a bool is none).
    """
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        count = int(value)
        if low <= count <= high:
            return count
    raise RequestError(f"{what} = {shown(value)} must be a whole number from {low} to {high}")


def string(what: str, value: object) -> str:
    """Return `value` if it is a string; raises `RequestError` otherwise."""
    if isinstance(value, str):
        return value
    raise RequestError(f"{what} = {shown(value)} must be a string")


def choice(what: str, value: object, allowed: Iterable[str]) -> str:
    """Return `value` if it is one of the `allowed` words; raises `RequestError` otherwise."""
    names = list(allowed)
    if isinstance(value, str) and value in names:
        return value
    raise unknown(what, value, names)


def table(what: str, value: object, keys: Iterable[str] | None = None) -> Mapping[str, Any]:
    """Return `value` if it is a table (a mapping) that holds none but the allowed `keys`.

    Arguments: `keys` is None where any key may stand.  Raises `RequestError` otherwise.
    """
    if not isinstance(value, Mapping):
        raise RequestError(f"{what} = {shown(value)} must be a table")
    allowed = None if keys is None else list(keys)
    for key in value:
        string("key", key)
        if allowed is not None and key not in allowed:
            raise unknown("key", key, allowed)
    return value
