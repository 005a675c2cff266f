"""A setting: one key of a request file, said once, as a field of the request.

    transient: int = setting(600, Whole(0), "sampling", "periods that are discarded", "PERIODS")

From the fields of a request follow what may stand in its file and how it is checked (`checks`), the
options that override it (`cli.setting_options`), the file that means exactly this request
(`Request.entries`), the page of keys and the schema for editors.  A new setting is a new field.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import MISSING, dataclass, field, fields, replace
from functools import cached_property, partial
from typing import Any, ClassVar, Protocol

from nlds_vines.archives.representation import Outlined
from nlds_vines.archives.toml import toml_text
from nlds_vines.errors import RequestError, at, choice, number, shown, string, table, whole
from nlds_vines.model.request_layers import request_hash


class Check(Protocol):
    """Returns the value of a key, whose name it is told, as it is kept; else `RequestError`."""

    def __call__(self, name: str, value: Any, /) -> Any:
        """Return it."""


@dataclass(frozen=True)
class Whole:
    """A whole number from `low` to `high`."""

    low: int
    high: int = 10**9

    def __call__(self, name: str, value: Any, /) -> int:
        """Return it."""
        return whole(name, value, self.low, self.high)


@dataclass(frozen=True)
class Real:
    """A number from `low` to `high`; `inside` where the ends themselves are not allowed."""

    low: float
    high: float
    inside: bool = False

    def __call__(self, name: str, value: Any, /) -> float:
        """Return it as a float."""
        found = number(name, value)
        if self.inside and not self.low < found < self.high:
            raise RequestError(f"{name} = {found!r} must be between {self.low:g} and {self.high:g}")
        if not self.low <= found <= self.high:
            raise RequestError(f"{name} = {found!r}; allowed: {self.low:g} to {self.high:g}")
        return found


@dataclass(frozen=True)
class OneOf:
    """One of some words; `what` it is called in messages, where that is not its key."""

    words: Collection[str]
    what: str = ""

    def __call__(self, name: str, value: Any, /) -> str:
        """Return it."""
        return choice(self.what or name, value, self.words)


@dataclass(frozen=True)
class Text:
    """A text of one line."""

    def __call__(self, name: str, value: Any, /) -> str:
        """Return it."""
        return string(name, value)


@dataclass(frozen=True)
class Truth:
    """True or false."""

    def __call__(self, name: str, value: Any, /) -> bool:
        """Return it."""
        if not isinstance(value, bool):
            raise RequestError(f"{name} = {shown(value)} must be true or false")
        return value


@dataclass(frozen=True)
class ParameterTable:
    """A table of parameters, which the system checks."""

    def __call__(self, name: str, value: Any, /) -> Any:
        """Return it."""
        return table(name, value)


@dataclass(frozen=True)
class Checked:
    """What a function returns that knows the name of its key by itself; `listed`: several words."""

    check: Callable[[Any], Any]
    listed: bool = False

    def __call__(self, name: str, value: Any, /) -> Any:
        """Return it."""
        return self.check(value)


@dataclass(frozen=True)
class Setting:
    """What is said of one key of a request file.

    Arguments:
        table: the table in which it stands, without brackets; of an array of tables with a pair of
            them, `[column]`; empty for that which its class names in an attribute `table`.
        check: returns a value as it is kept.
        words: what it means, in Markdown, for the help of its option and the page of keys.
        form: of the value of its option, as PERIODS; empty where there is none.
        option: its name where it is not that of the key, as `--record`.
        key: where it is not the name of the field.
        usual: the default in words, where the field's own does not say it.
    """

    table: str
    check: Check
    words: str
    form: str = ""
    option: str = ""
    key: str = ""
    usual: str = ""
    default: Any = None

    @property
    def has_option(self) -> bool:
        """Whether there is an option for it."""
        return bool(self.form or self.option)

    @property
    def flag(self) -> str:
        """Its option."""
        return self.option or f"--{self.key.replace('_', '-')}"

    @property
    def default_in_words(self) -> str:
        """Its default as help and the page of keys tell it; empty for none."""
        none = self.default in (None, (), "", MISSING) or self.default is False
        value = "" if none else self.default
        return self.usual or (f"{value:g}" if isinstance(value, float) else str(value))


def setting(default: Any, check: Check, table: str, words: str, form: str = "", **more: Any) -> Any:
    """Return a field of a request: its default, and the other arguments of a `Setting`."""
    said = Setting(table, check, words, form, **more)
    given = {} if default is MISSING else {"default": default}
    return field(metadata={"setting": said}, **given)


def settings_of(owner: Any, table: str | None = None) -> dict[str, Setting]:
    """Return the settings of a request, or of a table of one, by field; those of one `table`."""
    found = {}
    for item in fields(owner):
        said = item.metadata.get("setting")
        place = said and (said.table or owner.table)
        if said is not None and table in (None, place):
            key = said.key or item.name
            found[item.name] = replace(said, table=place, key=key, default=item.default)
    return found


def checks(*owners: Any) -> dict[str, dict[str, Callable[[object], Any]]]:
    """Return the checks of all keys of requests and their tables, by table and key."""
    found: dict[str, dict[str, Callable[[object], Any]]] = {}
    for owner in owners:
        for said in settings_of(owner).values():
            found.setdefault(said.table, {})[said.key] = partial(said.check, said.key)
    return found


def reader(record: Any) -> Callable[[str, object], Any]:
    """Return what reads an entry of an array of tables, at a place, into a record of settings."""
    known = {said.key: (name, said.check) for name, said in settings_of(record).items()}

    def read(place: str, entry: object) -> Any:
        with at(place):
            found = table("it", entry, known)
            return record(**{known[key][0]: known[key][1](key, found[key]) for key in found})

    return read


def check_settings(owner: Any) -> None:
    """Let the fields of an object be as their settings keep them; None stays where it is usual."""
    for name, said in settings_of(owner).items():
        value = getattr(owner, name)
        if value is not None or said.default is not None:
            object.__setattr__(owner, name, said.check(said.key, value))


def entries(owner: Any, table: str) -> dict[str, Any]:
    """Return the entries of `table` that mean exactly this object; None and () have no entry."""
    values = {said.key: getattr(owner, name) for name, said in settings_of(owner, table).items()}
    return {key: value for key, value in values.items() if value not in (None, ())}


class Request(Outlined):
    """What a task is to do: a frozen dataclass whose fields say what stands in its file."""

    content: ClassVar[str]  # its kind, of `archives.provenance`

    def document(self) -> dict[str, Any]:
        """Return the file that means exactly this request, complete, as nested tables."""
        raise NotImplementedError

    def to_toml(self) -> str:
        """Return it as canonical TOML, which is read back to an equal one, to the last digit."""
        return toml_text(self.document())

    @cached_property
    def hash(self) -> str:
        """SHA-256 of what determines the numbers: the canonical TOML without titles and sources."""
        return request_hash(self.document())
