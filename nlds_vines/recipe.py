"""What a portrait shows: a system or several, windows of forcing periods, panels.

`load_recipe` reads one from TOML and checks it once; what comes out is sound.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from nlds_vines._toml import read_toml
from nlds_vines.catalogue import load_system, system_from
from nlds_vines.errors import RequestError, at, choice, number, shown, string, table, whole
from nlds_vines.record import COMPONENTS
from nlds_vines.scan import METHODS
from nlds_vines.scenes import Scene
from nlds_vines.signals import checked_signal
from nlds_vines.spectra import TAPERS
from nlds_vines.system import System

PANELS: Mapping[str, str] = {
    "displacement": "x1, x2 and what is struck",
    "velocity": "v1 and v2",
    "relative": "x2 - x1 and what is struck",
    "force": "contact force and harmonic force",
    "energy": "E1 and E2",
    "energy1": "E1 alone",
    "energy2": "E2 alone",
    "phase": "structure, damper and what is struck in one phase plane",
    "phase1": "phase trajectory of the structure, its section",
    "phase2": "phase trajectory of the damper, its section, what is struck",
    "spectrum": "Fourier spectrum",
}
"""What can be drawn, by name; on a page the panels stand in this order."""

USUAL = ("displacement", "relative", "force", "energy", "phase1", "phase2", "spectrum")
"""The panels of a page unless others are asked for."""

_OF_DAMPER = ("relative", "energy2", "phase2")
_AT_WALLS = ("force",)

SYSTEM, TRANSIENT, PERIODS, SAMPLES, SHOW = "ssul-set6", 600, 240, 1024, 12
"""What is drawn unless something else is asked for.  1024 samples of a period are some 20 of a
contact: its force is folded onto its lines by 4e-4 of the largest at most."""

MOST_STATES = 10**7
"""The most states of a run, 320 MB."""

MOST_COLUMNS = 4


class Window(NamedTuple):
    """Forcing periods from `begin` to `end`, counted from the start of the orbit."""

    begin: int
    end: int


@dataclass(frozen=True)
class Column:
    """One column of a page: a system, a window of its orbit, and what stands above it."""

    system: System
    window: Window
    name: str = ""


@dataclass(frozen=True)
class Recipe:
    """What to draw; checked when made, immutable afterwards.

    Arguments:
        title: one line for people.
        columns: one to four; those of equal systems show one run.
        panels: of `PANELS`; kept in that order.  Those that no scene here can fill are left out.
        start: (x1, v1, x2, v2) [m, m/s] of every orbit, None for rest.
        samples: states in each forcing period; method: one of `METHODS`.
        show: the most periods drawn in a time history, from the beginning of its window.
        signal: what the spectrum is of, by default x2, or x1 without a damper; taper: its window.

    Raises `RequestError` for anything else.
    """

    title: str
    columns: tuple[Column, ...]
    panels: tuple[str, ...] = USUAL
    start: tuple[float, ...] | None = None
    samples: int = SAMPLES
    method: str = "exact"
    show: int = SHOW
    signal: str = ""
    taper: str = "rectangular"
    _scenes: tuple[Scene, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check everything."""
        string("title", self.title)
        whole("number of columns", len(self.columns), 1, MOST_COLUMNS)
        scenes = tuple(column.system.scene for column in self.columns)
        object.__setattr__(self, "_scenes", scenes)
        object.__setattr__(self, "panels", self._possible(_words("panels", self.panels, PANELS)))
        whole("samples", self.samples, 2, 10**6)
        whole("show", self.show, 1)
        choice("method", self.method, METHODS)
        choice("taper", self.taper, TAPERS)
        usual = "x2" if all(scene.damper for scene in scenes) else "x1"
        object.__setattr__(self, "signal", self.signal or usual)
        for scene in scenes:
            checked_signal(self.signal, scene)
        self._check_start()
        for run in self.runs():
            self._check_run(run)

    def _possible(self, panels: tuple[str, ...]) -> tuple[str, ...]:
        """Return the panels that can be filled; refuse a choice of which nothing remains."""
        allowed = panels_of(self._scenes)
        found = tuple(name for name in panels if name in allowed)
        if not found:
            kind = self._scenes[0].kind
            raise RequestError(
                f"panels {', '.join(panels)} cannot be filled for kind {kind!r}; "
                f"allowed: {', '.join(allowed)}"
            )
        return found

    def _check_start(self) -> None:
        for scene in self._scenes:
            width = 4 if scene.damper else 2
            if self.start is not None and len(self.start) != width:
                names = ", ".join(COMPONENTS[:width])
                raise RequestError(f"start = {shown(self.start)}; allowed: rest, or {names}")

    def _check_run(self, run: Sequence[Column]) -> None:
        begin, end = span(run)
        if (end - begin) * self.samples > MOST_STATES:
            raise RequestError(
                f"periods {begin} to {end} with {self.samples} samples each are too many states; "
                f"allowed: {MOST_STATES}; take fewer samples or nearer windows"
            )

    def runs(self) -> tuple[tuple[Column, ...], ...]:
        """Return the columns in groups of one system: what one orbit serves."""
        groups: list[list[Column]] = []
        for column in self.columns:
            same = [group for group in groups if group[0].system == column.system]
            if same:
                same[0].append(column)
            else:
                groups.append([column])
        return tuple(tuple(group) for group in groups)


def span(run: Sequence[Column]) -> Window:
    """Return the periods from the first to the last that columns of one run show."""
    windows = [column.window for column in run]
    return Window(min(w.begin for w in windows), max(w.end for w in windows))


def panels_of(scenes: Sequence[Scene]) -> tuple[str, ...]:
    """Return the panels that at least one of the scenes can fill."""
    damper, walls = any(s.damper for s in scenes), any(s.walls for s in scenes)
    without = (() if damper else _OF_DAMPER) + (() if walls else _AT_WALLS)
    return tuple(name for name in PANELS if name not in without)


def checked_window(what: str, value: object) -> Window:
    """Return the window that a pair (begin, end) of whole numbers or a text `begin:end` means."""
    pair: Any = value.split(":") if isinstance(value, str) else value
    form = f"{what} = {shown(value)} must be BEGIN:END, two numbers of forcing periods"
    if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
        raise RequestError(form)
    if isinstance(value, str):
        try:
            pair = [int(text) for text in pair]
        except ValueError:
            raise RequestError(form) from None
    begin = whole(f"begin of {what}", pair[0], 0)
    return Window(begin, whole(f"end of {what}", pair[1], begin + 1))


_KEYS: Mapping[str, tuple[str, ...] | None] = {
    "set": None,  # the system knows which parameters it has
    "start": ("policy", "state"),
    "sampling": ("transient", "periods", "windows", "samples", "method"),
    "portrait": ("panels", "show", "signal", "taper"),
}
_TOP = ("title", "system", *_KEYS, "column")


def load_recipe(
    source: str | os.PathLike[str] | Mapping[str, Any] | System | None = None,
    changes: Mapping[str, Any] | None = None,
) -> Recipe:
    """Return the recipe that a source means, checked throughout.

    Arguments:
        source: path of a TOML file (.toml), name of a system, the document in a file as nested
            tables, a `System`, or None for SSul NES Set 6 as it stands in the catalogue.
        changes: a document of the same form that overrides it entry by entry.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    where, document = _open(source)
    with at(where):
        below = _checked(document)
    above = _checked(changes or {})
    merged = {key: {**below.get(key, {}), **above.get(key, {})} for key in _KEYS}
    if above.get("sampling", {}).keys() & {"transient", "periods"}:
        merged["sampling"].pop("windows", None)  # what was asked for last is meant
        _refuse_both(above["sampling"])
    with at(where):
        columns = _columns(below, above, merged)
        return Recipe(
            _title(below, above, columns),
            columns,
            start=_start(merged["start"]),
            **{k: merged["sampling"][k] for k in ("samples", "method") if k in merged["sampling"]},
            **merged["portrait"],
        )


def _open(source: object) -> tuple[str, Mapping[str, Any]]:
    """Return the name of a source's place, empty if there is none, and the document in it."""
    if source is None:
        return "", {"system": SYSTEM}
    if isinstance(source, System):
        return "", {"system": source}
    if isinstance(source, Mapping):
        return "recipe", source
    if isinstance(source, str) and not source.endswith(".toml"):
        return "", {"system": load_system(source)}
    if isinstance(source, str | os.PathLike):
        return str(source), read_toml(Path(source))
    raise RequestError(f"recipe = {shown(source)} must be a path, a name, a table or a System")


def _checked(document: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a document whose tables hold none but known keys."""
    table("the recipe", document, _TOP)
    for key, allowed in _KEYS.items():
        table(f"[{key}]", document.get(key, {}), allowed)
    columns = document.get("column", [])
    if not isinstance(columns, Sequence) or isinstance(columns, str):
        raise RequestError(f"column = {shown(columns)} must be a list of tables [[column]]")
    for entry in columns:
        table("[[column]]", entry, ("name", "set", "window"))
    _refuse_both(document.get("sampling", {}))
    return document


def _refuse_both(sampling: Mapping[str, Any]) -> None:
    if "windows" in sampling and sampling.keys() & {"transient", "periods"}:
        raise RequestError("windows beside transient or periods: give windows, or the other two")


def _columns(
    below: Mapping[str, Any], above: Mapping[str, Any], merged: Mapping[str, Any]
) -> tuple[Column, ...]:
    """Return the columns: each entry of [[column]], in each of the windows unless it has its own."""
    system = system_from(above.get("system", below.get("system")))
    asked = above.get("sampling", {}).keys() & {"windows", "transient", "periods"}
    windows, found = _windows(merged["sampling"]), []
    for entry in below.get("column", []) or [{}]:
        own = {**below.get("set", {}), **table("set", entry.get("set", {})), **above.get("set", {})}
        one = system.with_(**own)
        given = "window" in entry and not asked
        for window in [checked_window("window", entry["window"])] if given else windows:
            name = string("name", entry.get("name", ""))
            found.append(Column(one, window, name))
    return tuple(found)


def _windows(sampling: Mapping[str, Any]) -> list[Window]:
    """Return the windows of a run, in the order of time."""
    if "windows" not in sampling:
        transient = whole("transient", sampling.get("transient", TRANSIENT), 0)
        return [Window(transient, transient + whole("periods", sampling.get("periods", PERIODS), 1))]
    value = sampling["windows"]
    if not isinstance(value, Sequence) or isinstance(value, str) or not value:
        raise RequestError(f"windows = {shown(value)} must be a list of pairs [begin, end]")
    found = [checked_window("window", pair) for pair in value]
    for first, second in pairwise(found):
        if second.begin < first.end:
            raise RequestError(
                f"windows {first.begin}:{first.end} and {second.begin}:{second.end} "
                "must follow each other in time"
            )
    return found


def _start(entry: Mapping[str, Any]) -> tuple[float, ...] | None:
    if "state" not in entry:
        choice("policy", entry.get("policy", "rest"), ("rest",))
        return None
    if "policy" in entry:
        raise RequestError("[start] policy beside state: give one of them")
    values = entry["state"]
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise RequestError(f"state = {shown(values)} must be a list of numbers")
    return tuple(number("state", value) for value in values)


def _title(
    below: Mapping[str, Any], above: Mapping[str, Any], columns: Sequence[Column]
) -> str:
    """Return the title given, or one made of the system where none is or it is true no more."""
    for document in (above, below):
        outdated = document is below and above.keys() & {"system", "set"}
        if "title" in document and not outdated:
            return string("title", document["title"])
    system = columns[0].system
    same = all(column.system == system for column in columns)
    return described(system) if same else (system.title or system.name)


def described(system: System) -> str:
    """Return a system in one line: its title, what was set, the frequency of the force."""
    title = system.title or system.name
    changed = (name for name, text in system.sources.items() if text == "set by the user")
    names = dict.fromkeys([*changed, "omega"])
    return ", ".join([title, *(f"{name} = {system.parameters[name]:g}" for name in names)])


def _words(what: str, value: object, allowed: Mapping[str, Any]) -> tuple[str, ...]:
    """Return different words out of those allowed, in that order."""
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise RequestError(f"{what} = {shown(value)} must be a list of words")
    if not value:
        raise RequestError(f"{what} = [] is an empty request; allowed: {', '.join(allowed)}")
    words = [choice(what, word, allowed) for word in value]
    if len(set(words)) < len(words):
        raise RequestError(f"{what} = {shown(words)} names something twice")
    return tuple(word for word in allowed if word in words)
