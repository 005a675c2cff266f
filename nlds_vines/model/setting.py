"""Settings: the keys of request files, each described once, as a field of the request.

    transient: int = setting(600, Whole(0), "sampling", "periods that are discarded", "PERIODS")

The fields of a request determine the keys of its file and their validation (`Form.read`), the
options that override them (`cli.options`), the file that means exactly this request (`entries`),
the page of keys and the schema for editors.  A new setting is a field.
"""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from functools import cache, cached_property
from types import MappingProxyType
from typing import Any, ClassVar, TypeVar

from nlds_vines.archives.files import toml_text
from nlds_vines.archives.representation import Outlined
from nlds_vines.errors import (
    LeftAside,
    RequestError,
    at,
    choice,
    is_command,
    number,
    shown,
    string,
    table,
    truth,
    unknown,
    whole,
)
from nlds_vines.model.axis import Axis, Samples, samples_of
from nlds_vines.model.catalog import (
    MARKS,
    any_system_from,
    load_system,
    read_request,
    without_hosts,
)
from nlds_vines.model.parameters import DESCRIBED, flat, setting_in_words
from nlds_vines.model.presets import refuse_contradiction
from nlds_vines.model.ratios import meant_by
from nlds_vines.model.system import System

Made = TypeVar("Made")
Taken = TypeVar("Taken", bound=System)


# validates the value of the key that it is given the name of: returns the value as it is stored
Check = Callable[[str, Any], Any]


@dataclass(frozen=True)
class Whole:
    low: int
    high: int = 10**9

    def __call__(self, name: str, value: Any, /) -> int:
        return whole(name, value, self.low, self.high)


@dataclass(frozen=True)
class Real:
    """A number from `low` to `high`; with `inside`, the ends themselves are not allowed."""

    low: float
    high: float
    inside: bool = False

    def __call__(self, name: str, value: Any, /) -> float:
        real = number(name, value)
        if self.inside and not self.low < real < self.high:
            raise RequestError(f"{name} = {real!r} must be between {self.low:g} and {self.high:g}")
        if not self.low <= real <= self.high:
            raise RequestError(f"{name} = {real!r}; allowed: {self.low:g} to {self.high:g}")
        return real


@dataclass(frozen=True)
class OneOf:
    """One of some words; messages call it `what`, by default by its key."""

    words: Collection[str]
    what: str = ""

    def __call__(self, name: str, value: Any, /) -> str:
        return choice(self.what or name, value, self.words)


@dataclass(frozen=True)
class Text:
    def __call__(self, name: str, value: Any, /) -> str:
        return string(name, value)


@dataclass(frozen=True)
class Truth:
    def __call__(self, name: str, value: Any, /) -> bool:
        return truth(name, value)


@dataclass(frozen=True)
class Checked:
    """A value that `check` validates; `check` knows the name of the key. `listed`: it is a list."""

    check: Callable[[Any], Any]
    listed: bool = False

    def __call__(self, name: str, value: Any, /) -> Any:
        return self.check(value)


@dataclass(frozen=True)
class Setting:
    table: str  # or `[column]`, an array of tables; if empty, the attribute `table` of the class
    check: Check
    words: str  # its meaning, in Markdown, for the help of its option and the page of keys
    form: str = ""  # the value of the option in the help, such as PERIODS; empty: no option
    option: str = ""  # by default the name of the field, as is the key
    key: str = ""
    usual: str = ""  # the default in words, if the field's own does not say it
    replaces: tuple[str, ...] = ()  # keys that an override removes: the steps of another method
    default: Any = None

    @property
    def has_option(self) -> bool:
        return bool(self.form or self.option)

    @property
    def flag(self) -> str:
        return self.option or f"--{self.key.replace('_', '-')}"

    @property
    def default_in_words(self) -> str:
        """Its default for the help and the page of keys; empty for none."""
        none = self.default in (None, (), "", MISSING) or self.default is False
        value = "" if none else self.default
        return self.usual or (f"{value:g}" if isinstance(value, float) else str(value))


def setting(
    default: Any, check: Check, table: str, words: str, form: str = "", **options: Any
) -> Any:
    entry = Setting(table, check, words, form, **options)
    return field(
        metadata={"setting": entry}, **({} if default is MISSING else {"default": default})
    )


def settings_of(owner: Any, table: str | None = None) -> dict[str, Setting]:
    return dict(_settings_of(owner if isinstance(owner, type) else type(owner), table))


@cache
def _settings_of(owner: Any, table: str | None) -> dict[str, Setting]:
    settings = {}
    for item in fields(owner):
        entry = item.metadata.get("setting")
        place = entry and (entry.table or owner.table)
        if entry is not None and table in (None, place):
            key = entry.key or item.name
            settings[item.name] = replace(entry, table=place, key=key, default=item.default)
    return settings


def check_settings(owner: Any) -> None:
    """Validate the fields of an object made in Python; None stays if it is the default.

    Of a document, `Form.read` has validated them before: its errors name file and table.
    """
    for name, entry in settings_of(owner).items():
        value = getattr(owner, name)
        if value is not None or entry.default is not None:
            object.__setattr__(owner, name, entry.check(entry.key, value))


def entries(owner: Any, table: str) -> dict[str, Any]:
    """Return the entries of `table` that mean exactly this object; None and () have no entry."""
    values = {entry.key: getattr(owner, name) for name, entry in settings_of(owner, table).items()}
    return {key: value for key, value in values.items() if value not in (None, ())}


# the keys of a system's table that change numbers, and those that do not
_OF_NUMBERS = ("kind", "parameters", "law", "law_2", "host", "dampers", "force")
_OF_TEXTS = ("name", "title", "sources", "assumptions")


class Request(Outlined):
    """A request of a task: a frozen dataclass whose fields are the settings of its file."""

    content: ClassVar[str]  # its kind, of `archives.provenance`

    def document(self) -> dict[str, Any]:
        raise NotImplementedError

    def starts_inside(self) -> list[str]:
        """Return a line for each kind of orbit that starts inside a wall."""
        return []

    def to_toml(self) -> str:
        return toml_text(self.document())

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the canonical TOML without titles and sources, which do not change numbers.

        Raises `RequestError` for a key of a system that neither changes numbers nor is a text.
        """

        def counted(system: Document) -> Document:
            table("system", system, (*_OF_NUMBERS, *_OF_TEXTS))
            return {key: system[key] for key in _OF_NUMBERS if key in system}

        document = {**self.document(), "title": ""}
        if "system" in document:
            document["system"] = counted(document["system"])
        if "systems" in document:
            document["systems"] = [counted(system) for system in document["systems"]]
        return hashlib.sha256(toml_text(document).encode()).hexdigest()


# ---- requests read from documents ----------------------------------------------------------------

Document = Mapping[str, Any]  # the content of a TOML file, as nested tables

# used even from a file for another kind of request
LENT = ("title", "system", "set", "sampling", "record")
SHARED = ("start", "search")  # tables with a meaning of their own in each kind of request
# all keys of tables that several kinds of request have; `want` marks a scan
KEYS_OF: Mapping[str, frozenset[str]] = {
    "sampling": frozenset(
        ("transient", "periods", "method", "tolerance", "effort", "nodes", "contact_steps",
         "period_steps", "samples", "windows", "duration", "settle")
    ),
    "record": frozenset(("want", "of", "heights", "beside")),
    "start": frozenset(("policy", "count", "seed", "state", "phase", "label", "states", "values",
                        "periods")),
    "search": frozenset(
        ("method", "objective", "population", "generations", "polish", "optima", "within", "apart",
         "seed", "seeds", "records", "draws", "quantile", "doublings", "step", "unstable", "points",
         "tori", "tolerance")
    ),
}  # fmt: skip
OWNER_OF_LOADS = "load."  # in front of numbers of loads: load.scale
ELSEWHERE = {("sampling", "of"): "[record]"}  # keys that belong in another table


@dataclass(frozen=True)
class Form:
    """The tables and keys that the files of one kind of request may have.

    A request is read from one document: a file or its equivalent, with changes (options of the
    command line, keywords of a function) merged over it.  The fields of the `owners` validate the
    merged document, once.  Of a file for another kind of request, this kind uses title, system,
    [set] and the keys of [sampling] that both have.
    """

    kind: str
    owners: tuple[type, ...]  # the classes whose settings the file has
    names: tuple[str, ...] = ("set",)  # tables by names of parameters, merged entry by entry
    whole: tuple[str, ...] = ()  # such tables that a table of changes replaces as a whole
    lists: tuple[str, ...] = ()
    rows: Mapping[str, type] = field(default_factory=dict)  # the classes of arrays of tables
    nested: Collection[str] = ()  # tables in tables of parameters: `tone.omega`
    without: Collection[str] = ()  # tables of the owners that it does not have
    systems: bool = True  # whether a `System`, or the name of one, may replace a file
    sources: str = "a path, a name, a table or a System"

    @cached_property
    def tables(self) -> dict[str, dict[str, Setting]]:
        tables: dict[str, dict[str, Setting]] = {name: {} for name in (*self.names, *self.whole)}
        for owner in self.owners:
            for entry in settings_of(owner).values():
                if entry.table not in self.without:
                    tables.setdefault(entry.table, {})[entry.key] = entry
        return tables

    @property
    def keys(self) -> tuple[str, ...]:
        return ("title", "system", *self.tables, *self.lists, *self.rows)

    def read(
        self, source: Any, changes: Document | None, changes_from: str, where: str = ""
    ) -> Merged:
        """Merge changes over the document of a source, and validate every setting.

        `changes_from` and `where` are the names of changes and source in messages.
        """
        changes = checked_changes(changes, changes_from)
        where, below, left = self._open(source, where)
        above = {k: v for k, v in changes.items() if not (isinstance(v, Mapping) and not v)}
        for place, layer in ((where, below), (changes_from, above)):
            for key in layer:
                if key not in self.keys:
                    with at(place):
                        raise self._unknown(key)
            for name in self.tables.keys() & layer.keys():
                with at(f"{place}: [{name}]"):
                    table(name, layer[name])
        merged = {**below, **above}
        for name in (below.keys() & above.keys() & self.tables.keys()).difference(self.whole):
            # a change of a value removes the entries that its setting `replaces`; a change to the
            # same value does so only if an entry of the source replaces its key
            old, new, settings = below[name], above[name], self.tables[name]
            displaced = {key for one in old if one in settings for key in settings[one].replaces}
            gone = {
                other
                for key in new.keys() & settings.keys()
                if key in displaced or _text(old.get(key, settings[key].default)) != _text(new[key])
                for other in settings[key].replaces
            }
            merged[name] = {key: old[key] for key in old if key not in gone} | dict(new)
        document = Merged(self, ((where, below), (changes_from, above)), merged, left)
        for name, settings in self.tables.items():
            for key, value in merged.get(name, {}).items() if settings else ():
                with at(document.place(name, key)):
                    if key not in settings:
                        if other := ELSEWHERE.get((name, key)):
                            raise RequestError(f"{key} = {shown(value)} belongs in {other}")
                        raise unknown("key", key, settings)
                    checked = settings[key].check(key, value)
                    document.values.setdefault(name, {})[key] = checked
        return document

    def _unknown(self, key: object) -> RequestError:
        """Return the error for a key that no table has; it says in which ones it may stand."""
        if not isinstance(key, str):
            return RequestError(f"key = {shown(key)} must be a string")
        places = [name for name, settings in self.tables.items() if key in settings]
        if key in DESCRIBED:
            of_parameters = (*self.names, *self.whole)
            places += [
                name for name in of_parameters if name not in ("samples", "places", "monitors")
            ]
        if not places:
            return unknown("key", key, self.keys)
        words = [f"[{name}]" if is_command() else f"{name}={{{key!r}: ...}}" for name in places]
        return RequestError(f"unknown key {key!r}: it stands in {' or '.join(words)}")

    def _open(self, source: Any, where: str) -> tuple[str, Document, list[str] | None]:
        """Return the name of a source, its document, and a file's keys for other tasks."""
        if document := getattr(source, "document", None):
            source = document()
        if self.systems and isinstance(source, str) and not source.endswith(".toml"):
            source = load_system(source)
        if self.systems and isinstance(source, System):
            source = {"system": source}
        if isinstance(source, Mapping):
            return where or self.kind, source, None
        if not isinstance(source, str | os.PathLike):
            raise RequestError(f"{self.kind} = {shown(source)} must be {self.sources}")
        where, document = str(source), read_request(source)
        foreign = [key for key in document if key in (*MARKS, *SHARED) and key not in self.keys]
        others: dict[str, list[str]] = {}  # keys of other kinds in tables of this kind as well
        for name, keys in KEYS_OF.items():
            if name in self.tables and isinstance(entries := document.get(name), Mapping):
                own = self.tables[name]
                others[name] = [key for key in entries if key in keys and key not in own]
                if name != "sampling" and others[name] and len(others[name]) == len(entries):
                    foreign.append(name)
        if not foreign and not any(others[name] for name in others if name != "sampling"):
            return where, document, []
        ours = any(key in MARKS and key in self.keys and self._is_marked(key) for key in document)
        lent = {
            key: value
            for key, value in document.items()
            if key not in foreign and (ours or key in LENT or key not in self.keys)
        }
        left = [f"[{key}]" for key in document if key not in lent]
        if "sampling" not in self.tables:
            left += ["[sampling]"] if lent.pop("sampling", None) else []
        for name in others.keys() & lent.keys():
            lent[name] = {k: v for k, v in document[name].items() if k not in others[name]}
            left += [f"{key} of [{name}]" for key in others[name]]
        return where, lent, left

    def _is_marked(self, key: str) -> bool:
        """Return True if a table at the top of a file shows that the file is for this kind."""
        return key != "record" or "want" in self.tables[key]


def checked_changes(changes: object, changes_from: object) -> Document:
    """Return the document of changes, {} for None; `RequestError` for anything else."""
    if not isinstance(changes_from, str):
        raise RequestError(f"changes_from = {shown(changes_from)} must be a string")
    if changes is None:
        return {}
    if not isinstance(changes, Mapping):
        raise RequestError(f"{changes_from} = {shown(changes)} must be a mapping of tables")
    return changes


def _text(value: object) -> str:
    """Return a value as text, in which the option 2.5 is the number; empty if it has none."""
    try:
        return str(value)
    except Exception:  # of an object of someone else's, or thousands of digits: refused later
        return ""


def is_given(entry: object) -> bool:
    """Return False for None and for an empty text, list or table, which say nothing."""
    return not (entry is None or (isinstance(entry, Mapping | Sequence) and not entry))


def tables(entries: Mapping[str, Any], nested: Collection[str] = ()) -> dict[str, Any]:
    """Return the entries of a table by names of parameters, those of inner tables as tone.omega.

    Inner tables are those of the names `nested`, and of hosts' dampers, whose entries are tables.
    """
    result: dict[str, Any] = {}
    for key, entry in entries.items():
        is_table = isinstance(entry, Mapping)
        if is_table and (key in nested or any(isinstance(v, Mapping) for v in entry.values())):
            result |= {f"{key}.{inner}": value for inner, value in entry.items()}
        else:
            result[key] = entry
    return result


@dataclass(frozen=True)
class Merged:
    """The merged document of a request, and its validated settings by table and key."""

    form: Form
    # the document below and the changes above it, each with its name in messages
    layers: tuple[tuple[str, Document], tuple[str, Document]]
    document: Document
    left: Collection[str] | None = None  # what a file has for other requests; None: it is no file
    values: dict[str, dict[str, Any]] = field(default_factory=dict)

    def origin(self, name: str, key: str = "") -> str:
        """Return the name in messages of the uppermost layer that has a table, or a key of it."""
        (where, _), (changes_from, above) = self.layers
        entry: Any = above.get(name)
        return changes_from if is_given(entry) and (not key or key in entry) else where

    def place(self, name: str, key: str = "") -> str:
        """Return the place of a table in the uppermost layer that has it, or a key of it."""
        return f"{self.origin(name, key)}: [{name}]"

    def is_changed(self, *names: str) -> bool:
        return any(is_given(self.layers[1][1].get(name)) for name in names)

    def table(self, name: str) -> Document:
        """Return the merged entries of a table by names of parameters, which are not validated.

        A number of the loads may have its owner in front: `load.scale` is `scale`.
        """
        named: dict[str, Any] = {}
        for key, entry in tables(self.document.get(name, {}), self.form.nested).items():
            plain = key.removeprefix(OWNER_OF_LOADS) if self.form.nested else key
            if plain in named:
                raise RequestError(f"{self.place(name)}: {plain} stands twice, also as {key}")
            named[plain] = entry
        return named

    def of(self, owner: Any) -> dict[str, Any]:
        return {
            name: self.values[entry.table][entry.key]
            for name, entry in settings_of(owner).items()
            if entry.key in self.values.get(entry.table, {})
        }

    def rows(self, key: str) -> list[Any]:
        entries, record, rows = self.document.get(key, []), self.form.rows[key], []
        by_key = {item.key: (name, item.check) for name, item in settings_of(record).items()}
        with at(self.origin(key)):
            if not isinstance(entries, list | tuple) or (not entries and key in self.document):
                raise RequestError(f"{key} = {shown(entries)} must be one or more tables [[{key}]]")
            for place, entry in enumerate(entries, start=1):
                with at(f"[[{key}]] {place}"):
                    columns = [(*by_key[k], k, v) for k, v in table("it", entry, by_key).items()]
                    rows.append(record(**{name: check(k, v) for name, check, k, v in columns}))
        return rows

    def axes(self, name: str) -> tuple[Axis, ...]:
        axes = []
        for parameter, entry in self.table(name).items():
            with at(f"{self.place(name)} {parameter}"):
                axes.append(Axis.of(parameter, entry))
        return tuple(axes)

    def samples(self) -> Samples | None:
        """Return the table of samples, if the uppermost layer that varies anything has one."""
        tables = [name for name in ("vary", "samples") if self.document.get(name)]
        if len(tables) == 2:
            tables = [name for name in tables if self.is_changed(name)]
            if len(tables) != 1:
                raise RequestError(f"{self.place('samples')} beside [vary]: give one of them")
        if tables != ["samples"]:
            return None
        with at(self.origin("samples")):
            return samples_of(self.document["samples"])

    def system(self) -> System:
        """Return `any_system`; refuse a host."""
        with at(self.origin("system")):
            return without_hosts(self.any_system())

    def any_system(self, default: str | None = None, *, needs_force: bool = True) -> System:
        """Return the system that the uppermost layer names, without [set]."""
        with at(self.origin("system")):
            entry = self.document.get("system", default)
            return any_system_from(entry, needs_force=needs_force)

    def as_set(
        self,
        system: Taken,
        varied: Mapping[str, str] = MappingProxyType({}),
        takes: Callable[[Taken, str], bool] = lambda *_: True,
    ) -> Taken:
        """Return a system with [set] of the file and then [set] of the changes, as it `takes` them.

        If the changes vary a parameter, the file does not set it; any other parameter that is both
        set and `varied`, by the table of that name, is refused.
        """
        changed: Any = system
        axes = meant_by(changed.scene, varied)
        tables = dict(zip(axes, varied.values(), strict=True))
        _, (_, above) = self.layers
        for place, layer in self.layers:
            settings = {k: v for k, v in flat(layer.get("set", {})).items() if takes(changed, k)}
            with at(f"{place}: [set]"):
                for name, meant in zip([*settings], meant_by(changed.scene, settings), strict=True):
                    if meant in axes and layer is not above and above.get(tables[meant]):
                        del settings[name]
                    elif meant in axes:
                        raise RequestError(
                            f"{name} = {shown(settings[name])}: {meant} is varied by "
                            f"{self.place(tables[meant])}; set it or vary it, not both"
                        )
                refuse_contradiction([*settings, *axes])
                changed = changed.with_(**settings)
        result: Taken = changed
        return result

    def set_in_words(self, system: System, free: Collection[str]) -> list[str]:
        """Return what [set] changes in a system, `C = 0.05 m`, but no parameter in `free`."""
        names = {name for _, layer in self.layers for name in layer.get("set", {})}
        names |= {*meant_by(system.scene, names)}
        names &= system.statements.keys() - {*free}
        return [setting_in_words(name, system.statements[name]) for name in sorted(names)]

    def title(self, *outdated_by: str) -> str | None:
        """Return the title; None if there is none, or if changes outdate one that is in no file."""
        (where, below), (changes_from, above) = self.layers
        if "title" not in above and (
            "title" not in below or (self.left is None and self.is_changed(*outdated_by))
        ):
            return None
        with at(changes_from if "title" in above else where):
            return string("title", self.document["title"])

    def make(self, owner: Callable[..., Made], place: str, **values: Any) -> Made:
        """Make the request; a warning names the parts of the file for other commands."""
        with at(place):
            request = owner(**values)
        self.tell_left()
        return request

    def tell_left(self) -> None:
        """Warn of the parts of the file that are for other commands."""
        if self.left:
            text = f"{self.layers[0][0]}: left aside here: {', '.join(self.left)}"
            warnings.warn(text, LeftAside, stacklevel=4)
