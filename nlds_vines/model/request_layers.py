"""A request in layers: a file, or what stands for one, and the changes that are laid over it.

Every kind of request file (scan, tuning, portrait, figure) has a title, a system and some tables.
The command line, or the keywords of a function, give a second document of the same form, which
overrides the first one entry by entry.  Here both are checked for unknown keys and put together;
what an entry means is known to the kind of request.  Every message begins with the place of what is
wrong: the file and the table.

One file serves several commands.  Where it has tables of another kind of request, it lends what all
kinds have: title, system, [set], and of [sampling] what this kind knows, too.  What is left aside
is told in a warning.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from nlds_vines.archives.files import read_toml
from nlds_vines.errors import LeftAside, RequestError, at, shown, string, table
from nlds_vines.model.catalog import load_system, system_from
from nlds_vines.model.system import System

Document = Mapping[str, Any]
"""What a TOML file holds, as nested tables."""

Request = TypeVar("Request")

Check = Callable[[object], Any]
"""Returns the value of a key as it is kept; raises `RequestError` where it is not allowed."""


def unchecked(value: object) -> Any:
    """Return the value as it is: for a key that is checked later, together with others."""
    return value


LENT = ("title", "system", "set", "sampling")
"""What a file lends to a command for which it was not written."""

MARKS = {
    "vary": "scan", "record": "scan", "spectrum": "scan", "free": "tuning", "over": "tuning",
    "surface": "tuning", "uncertain": "tuning", "along": "continuation", "plane": "continuation",
    "portrait": "portrait", "column": "portrait",
    "figure": "page of curves", "panels": "page of curves", "curves": "page of curves",
    "systems": "response history", "load": "response history",
}  # fmt: skip
"""What only some kinds of request have at the top of their files, and one that has it."""

SHARED = ("start", "search")
"""Tables that several kinds of request have, each with a meaning of its own."""

SAMPLING = frozenset(
    ("transient", "periods", "method", "tolerance", "effort", "nodes", "contact_steps",
     "period_steps", "samples", "windows", "duration", "settle")
)  # fmt: skip
"""What some kind of request or other has in its [sampling]."""


@dataclass(frozen=True)
class Form:
    """What may stand in the files of one kind of request.

    Arguments:
        kind: the word for messages, `scan`.
        tables: the check of each key, by table; None for a table whose keys are names of
            parameters, which the system checks.
        lists: keys of lists.
        rows: what an entry of an array of tables is read into, by the key of the array, `column`.
        names: whether a `System`, or the name of one, may stand in place of a file.
        sources: what may be given in place of a file, in words.
    """

    kind: str
    tables: Mapping[str, Mapping[str, Check] | None]
    lists: Collection[str] = ()
    rows: Mapping[str, Callable[[str, object], Any]] = field(default_factory=dict)
    names: bool = True
    sources: str = "a path, a name, a table or a System"

    @property
    def keys(self) -> tuple[str, ...]:
        """All that may stand at the top of a file."""
        return ("title", "system", *self.tables, *self.lists, *self.rows)

    def open(self, source: object) -> Layer:
        """Return the layer of a path, of a document, or of a system or its name.

        Raises `RequestError` for anything else, an unreadable file, and unknown keys.
        """
        if isinstance(source, Mapping):
            return Layer(self, self.kind, source)
        if self.names and isinstance(source, System):
            return Layer(self, self.kind, {"system": source})
        if self.names and isinstance(source, str) and not source.endswith(".toml"):
            return Layer(self, self.kind, {"system": load_system(source)})
        if isinstance(source, str | os.PathLike):
            document, left = self._own(read_toml(Path(source)))
            return Layer(self, str(source), document, of_file=True, left=tuple(left))
        raise RequestError(f"{self.kind} = {shown(source)} must be {self.sources}")

    def _own(self, document: Document) -> tuple[Document, list[str]]:
        """Return what of a file is for this kind of request, and the names of what is not."""
        others = (*MARKS, *SHARED)
        foreign = [key for key in document if key in others and key not in self.keys]
        if not foreign:
            return document, []
        ours = any(key in MARKS and key in self.keys for key in document)
        taken = {
            key: value
            for key, value in document.items()
            if key not in foreign and (ours or key in LENT or key not in self.keys)
        }
        left = [f"[{key}]" for key in document if key not in taken]
        sampling, known = document.get("sampling"), self.tables.get("sampling")
        if known is None:
            left += ["[sampling]"] if taken.pop("sampling", None) else []
        elif isinstance(sampling, Mapping):
            other = [name for name in sampling if name in SAMPLING and name not in known]
            taken["sampling"] = {k: v for k, v in sampling.items() if k not in other}
            left += [f"{name} of [sampling]" for name in other]
        return taken, left


@dataclass(frozen=True)
class Layer:
    """One document of a request: its form, where it comes from, and what stands in it."""

    form: Form
    where: str
    document: Document
    of_file: bool = False
    left: tuple[str, ...] = ()  # what of a file is for other kinds of request

    def __post_init__(self) -> None:
        """Raise `RequestError` for keys that the form does not know."""
        with at(self.where):
            table(f"the {self.form.kind}", self.document, self.form.keys)
        for key in self.form.tables:
            self.table(key)

    def place(self, key: str) -> str:
        """Return the place of the table `key`, as messages name it."""
        return f"{self.where}: [{key}]"

    def table(self, key: str) -> Document:
        """Return the table `key`, empty where there is none; its values are not yet checked."""
        with at(self.place(key)):
            return table(key, self.document.get(key, {}), self.form.tables[key])

    def rows(self, key: str) -> list[Any]:
        """Return the entries of the array of tables `key`, each as the form reads it."""
        found = self.document.get(key, [])
        with at(self.where):
            if not isinstance(found, list | tuple) or (not found and key in self.document):
                raise RequestError(f"{key} = {shown(found)} must be one or more tables [[{key}]]")
            return [
                self.form.rows[key](f"[[{key}]] {number}", entry)
                for number, entry in enumerate(found, start=1)
            ]

    def values(self, key: str) -> dict[str, Any]:
        """Return the entries of the table `key`, each checked."""
        checks = self.form.tables[key] or {}
        with at(self.place(key)):
            return {name: checks[name](value) for name, value in self.table(key).items()}


@dataclass(frozen=True)
class Layers:
    """A document and the changes that are laid over it."""

    below: Layer
    above: Layer

    @classmethod
    def of(cls, form: Form, source: object, changes: Document | None, changes_from: str) -> Layers:
        """Return what a source means, as `Form.open` has it, with `changes` above it.

        A request is the document that means exactly it; `changes_from` names the changes in
        messages.
        """
        document = getattr(source, "document", None)
        below = (
            source if isinstance(source, Layer) else form.open(document() if document else source)
        )
        return cls(below, Layer(form, changes_from, changes or {}))

    def __iter__(self) -> Iterator[Layer]:
        """Yield the layers, the one below first."""
        return iter((self.below, self.above))

    def told(self, request: Request) -> Request:
        """Return what was read, and warn (`LeftAside`) of what of the file is for others."""
        if self.below.left:
            what = ", ".join(self.below.left)
            warnings.warn(f"{self.below.where}: left aside here: {what}", LeftAside, stacklevel=3)
        return request

    def holder(self, key: str) -> Layer:
        """Return the uppermost layer with something under this key; the one below if none has."""
        return self.above if self.above.document.get(key) else self.below

    def place(self, key: str) -> str:
        """Return the place of the table `key` in the uppermost layer that holds it."""
        return self.holder(key).place(key)

    def table(self, key: str) -> dict[str, Any]:
        """Return the entries of the table `key` of both layers; its values are not yet checked."""
        return {**self.below.table(key), **self.above.table(key)}

    def values(self, key: str) -> dict[str, Any]:
        """Return the entries of the table `key` of both layers, each checked."""
        return self.below.values(key) | self.above.values(key)

    def system(self) -> System:
        """Return the system that the uppermost layer with one names; without `[set]`."""
        layer = self.holder("system")
        with at(layer.where):
            return system_from(layer.document.get("system"))

    def system_as_set(self, default: str) -> System:
        """Return the system, by default that of a name, as `[set]` of both layers changes it."""
        layer = self.holder("system")
        with at(layer.where):
            system = system_from(layer.document.get("system", default))
        for layer in self:
            with at(layer.place("set")):
                system = system.with_(**layer.table("set"))
        return system

    def title(self, outdated_by: Collection[str]) -> str | None:
        """Return the title; None where none is given.

        That of a file stays. Another title of the layer below does not hold any more where the one
        above has something under one of the keys `outdated_by`.
        """
        changed = not self.below.of_file and any(
            self.above.document.get(key) for key in outdated_by
        )
        for layer in (self.above,) if changed else (self.above, self.below):
            if "title" in layer.document:
                with at(layer.where):
                    return string("title", layer.document["title"])
        return None
