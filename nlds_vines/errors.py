"""The one error of a wrong request, and the small checks at the door that raise it.

Every message is one line that says what was given, where, and what is allowed.
"""

from __future__ import annotations

import difflib
import math
import numbers
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from importlib import import_module
from typing import Any, TypeVar

Number = TypeVar("Number", int, float)

MOST_MESSAGE = 2000  # characters of a message, whose texts come from files of others
MOST_CHARACTERS = 1000  # characters of a title, a name or a note: as many as a picture can hold

MOST_LISTED = 4000  # characters of the names that a message lists: two screens

# Unicode's categories of control and formatting characters, half characters and line ends
_UNPRINTABLE = ("Cc", "Cf", "Cs", "Zl", "Zp")
_NUMBERS = {
    int: re.compile(r"\s*[+-]?[0-9]+\s*"),
    float: re.compile(
        r"\s*[+-]?(nan|inf(inity)?|([0-9]+\.?[0-9]*|\.[0-9]+)(e[+-]?[0-9]+)?)\s*",
        re.IGNORECASE | re.ASCII,
    ),
}
"""How numbers are written: Python itself would also take 1_000, and digits of any script."""


class LeftAside(UserWarning):
    """A request file has tables for other commands than the one that reads it."""


class Reordered(LeftAside):
    """The values of an axis are not in ascending order, in which they are computed."""


class RequestError(ValueError):
    """The request is wrong: an unknown name, a value out of range, a contradiction.

    The message is one line that names what was given, where, and what is allowed.

    Parameters
    ----------
    message : str
        The message; line ends in it are escaped.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.load_system("tmd", m2=-1.0)
    Traceback (most recent call last):
        ...
    nlds_vines.errors.RequestError: m2 = -1.0 is not allowed: ... must be > 0 and finite
    """

    def __init__(self, message: str) -> None:
        super().__init__(_one_line(message))


def _one_line(message: str) -> str:
    """Return a message with line ends escaped, and without its middle if it is very long."""
    text = printable(message)
    if len(text) <= MOST_MESSAGE:
        return text
    return f"{text[: MOST_MESSAGE - 500]} ... {text[-490:]}"


_is_command: ContextVar[bool] = ContextVar("whether a command is carried out", default=False)


@contextmanager
def as_command() -> Iterator[None]:
    """Let messages in the `with` block name options as a command has them (`option`)."""
    token = _is_command.set(True)
    try:
        yield
    finally:
        _is_command.reset(token)


def is_command() -> bool:
    """Return True if a command is carried out, False for a call in Python."""
    return _is_command.get()


def option(name: str, value: object = True) -> str:
    """Return an option as its user gives it: `--resume` to a command, `resume=True` in Python."""
    if is_command():
        return f"--{name}" if value is True else f"--{name} {value}"
    return f"{name}={value}"


@contextmanager
def at(where: str) -> Iterator[None]:
    """Prefix the message of a `RequestError` raised inside with a file, table or option."""
    try:
        yield
    except RequestError as error:
        raise RequestError(f"{where}: {error}" if where else str(error)) from None


def shown(value: object) -> str:
    """Return `value` as it is quoted in a message: its repr, shortened to 60 characters."""
    try:
        text = " ".join(repr(value).split("\n"))
    except Exception:  # of someone else's object, or of a whole number with thousands of digits
        text = f"<{type(value).__name__}>"
    return text if len(text) <= 60 else f"{text[:56]} ..."


def printable(text: str) -> str:
    """Return `text` with invisible characters escaped, which could move a terminal's cursor."""
    return "".join(
        letter.encode("unicode_escape").decode() if _hidden(letter) else letter for letter in text
    )


def _hidden(letter: str) -> bool:
    return unicodedata.category(letter) in _UNPRINTABLE


def unknown(what: str, value: object, allowed: Iterable[str]) -> RequestError:
    """Return the error for a name (`what` names its kind) that does not exist, with the nearest."""
    names = list(allowed)
    near = _nearest(value[:60], names) if isinstance(value, str) else ""
    hint = f"; did you mean {near!r}?" if near else ";"
    return RequestError(f"unknown {what} {shown(value)}{hint} allowed: {listed(names)}")


def listed(names: Iterable[str]) -> str:
    """Return names with commas between them; of more than a screen, the first and their number."""
    every = list(names)
    text = ", ".join(every)
    if len(text) <= MOST_LISTED:
        return text
    shown_names = text[:MOST_LISTED].rpartition(", ")[0] or text[:MOST_LISTED]
    return f"{shown_names} ... ({len(every)} in all)"


def _nearest(text: str, names: Sequence[str]) -> str:
    """Return the name that was probably meant, which begins with the text or resembles it, or "".

    Symbols of up to three letters resemble those of the same length with the same first letter.
    """
    word = text.lstrip("-")
    longer = [name for name in names if len(word) > 1 and name.lstrip("-").startswith(word)]
    if longer:
        return longer[0]
    if len(word) > 3:
        by_word = {name.lstrip("-"): name for name in reversed(names)}
        near = difflib.get_close_matches(word, by_word, n=1, cutoff=0.6)
        return by_word[near[0]] if near else ""
    first, length = word[:1].lower(), len(word)
    alike = [name for name in names if len(name) == length and name[:1].lower() == first]
    return (difflib.get_close_matches(word, alike, n=1, cutoff=0.3) or [""])[0]


def checked_width(value: object) -> float:
    """Return the width of a picture [cm]; `RequestError` unless it is from 4 to 100."""
    width = number("width", value)
    if not 4.0 <= width <= 100.0:
        raise RequestError(f"width = {width:g}; allowed: 4 to 100 cm")
    return width


def number(what: str, value: object) -> float:
    """Return `value` as a float; `RequestError` for anything but a finite number, or for a bool."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise RequestError(f"{what} = {shown(value)} must be a number")
    try:
        result = float(value) + 0.0  # -0.0 becomes 0.0: equal numbers print alike
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise RequestError(f"{what} = {shown(value)} must be a finite number")
    return result


def truth(what: str, value: object) -> bool:
    """Return `value` if it is True or False; a text such as "false" would count as true."""
    if not isinstance(value, bool):
        raise RequestError(f"{what} = {shown(value)} must be true or false")
    return value


def whole(what: str, value: object, low: int, high: int = 10**9) -> int:
    """Return `value` as an int; `RequestError` if it is out of range or no whole number."""
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        count = int(value)
        if low <= count <= high:
            return count
    raise RequestError(f"{what} = {shown(value)} must be a whole number from {low} to {high}")


def from_text(kind: type[Number], what: str, text: str) -> Number:
    """Return the number that `text` means in the digits 0 to 9: 1_000 is none."""
    if _NUMBERS[kind].fullmatch(text):
        try:
            return kind(text)
        except ValueError:  # Python refuses to read more than 4300 digits
            pass
    words = "a whole number" if kind is int else "a number"
    plain = "" if text.isascii() and "_" not in text else " in the digits 0 to 9, without _"
    raise RequestError(f"{what} = {shown(text)} must be {words}{plain}")


def string(what: str, value: object, lines: bool = False) -> str:
    """Return `value` if it is a string that may stand in a file, a picture and on a terminal.

    Raises `RequestError` for a control character, half a character (a byte that is no UTF-8), more
    than `MOST_CHARACTERS`, and a line end unless several `lines` are allowed.
    """
    if not isinstance(value, str):
        raise RequestError(f"{what} = {shown(value)} must be a string")
    if len(value) > MOST_CHARACTERS:
        raise RequestError(
            f"{what} = {shown(value)} has {len(value)} characters; allowed: up to {MOST_CHARACTERS}"
        )
    refuse_bytes(what, value)
    allowed = "\t\r\n" if lines else ""
    odd = "" if value.isprintable() else value  # most texts are looked at as a whole
    # emoji and some scripts need `Cf`
    hidden = [c for c in odd if c not in allowed and _hidden(c) and unicodedata.category(c) != "Cf"]
    if hidden:
        raise RequestError(
            f"{what} = {shown(value)} holds {hidden[0]!r}: "
            "control characters and line ends are not allowed"
        )
    return value


def check_name(what: str, value: object) -> str:
    """Return a name of a part that stands in others, as in cell1.k = 300, and in archives."""
    name = string(what, value)
    if not name or not name.strip() == name or {*name} & {*"./=$"}:
        raise RequestError(
            f"{what} = {shown(name)} must be a text without . / = $ and without spaces at its ends"
        )
    return name


def dof_name(what: str, label: object) -> str:
    """Return the name of a degree of freedom: a text, or the digits of a whole number."""
    if isinstance(label, str):
        return label
    if isinstance(label, numbers.Integral) and not isinstance(label, bool):
        node = int(label)
        if abs(node) < 10**18:  # Python makes no text of thousands of digits
            return str(node)
    raise RequestError(f"{what}: {shown(label)} must be a text or a whole number")


def by_dof_names(what: str, values: object) -> object:
    """Return a mapping whose keys are names of degrees of freedom; other values as they are."""
    if not isinstance(values, Mapping):
        return values
    by_name = {dof_name(what, label): value for label, value in values.items()}
    if len(by_name) < len(values):
        raise RequestError(f"{what} = {shown(values)} names a degree of freedom twice")
    return by_name


def refuse_bytes(what: str, text: str) -> None:
    """Raise `RequestError` for a null character, or for bytes that are no UTF-8."""
    if "\0" in text:
        raise RequestError(f"{what} {shown(text)} holds a null character, which is not allowed")
    try:
        text.encode()
    except UnicodeEncodeError:
        raise RequestError(f"{what} {shown(text)} is not UTF-8 text: use another name") from None


def choice(what: str, value: object, allowed: Iterable[str]) -> str:
    names = list(allowed)
    if isinstance(value, str) and value in names:
        return value
    raise unknown(what, value, names)


def checked_words(
    what: str, value: object, allowed: Iterable[str], one: str = ""
) -> tuple[str, ...]:
    """Return different words of those `allowed`; `one` is the name of a single word in an error."""
    names = list(allowed)
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise RequestError(f"{what} = {shown(value)} must be a list of words")
    if not value:
        raise RequestError(f"{what} = [] is an empty request; allowed: {', '.join(names)}")
    chosen = [choice(one or what, word, names) for word in value]
    if len(set(chosen)) < len(chosen):
        raise RequestError(f"{what} = {shown(chosen)} names something twice")
    return tuple(chosen)


def checked_names(what: str, value: object) -> tuple[str, ...]:
    """Return the different names of a list, of which some may be numbers of nodes."""
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise RequestError(f"{what} = {shown(value)} must be a list of names")
    return tuple(dict.fromkeys(string(what, dof_name(what, one)) for one in value))


def checked_state(value: object) -> tuple[float, ...]:
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise RequestError(f"state = {shown(value)} must be a list of numbers")
    return tuple(number("state", one) for one in value)


def table(
    what: str, value: object, keys: Iterable[str] | None = None, needed: Iterable[str] = ()
) -> Mapping[str, Any]:
    """Return `value` if it is a mapping with only `keys`, any if None, and all `needed` ones."""
    if not isinstance(value, Mapping):
        raise RequestError(f"{what} = {shown(value)} must be a table")
    allowed = None if keys is None else list(keys)
    for key in value:
        if not isinstance(key, str):
            raise RequestError(f"key = {shown(key)} must be a string")
        if allowed is not None and key not in allowed:
            raise unknown("key", key, allowed)
    if missing := [key for key in needed if key not in value]:
        raise RequestError(f"{missing[0]} is missing")
    return value


def library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise RequestError(
            f"{name} is not installed: pip install 'nlds-vines[xarray]' brings xarray and pandas"
        ) from None
