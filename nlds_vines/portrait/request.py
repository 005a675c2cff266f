"""The request of a portrait: systems, windows of forcing periods, panels; its file."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise
from math import pi
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from nlds_vines.archives.provenance import PORTRAIT, Value
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.engine.solver_settings import chosen_settings, method_setting, tolerance_setting
from nlds_vines.engine.spectrum import TAPERS
from nlds_vines.engine.starts import starts_inside
from nlds_vines.errors import (
    RequestError,
    at,
    checked_names,
    checked_state,
    checked_words,
    choice,
    from_text,
    shown,
    string,
    table,
    whole,
)
from nlds_vines.model.parameters import flat, setting_in_words
from nlds_vines.model.ratios import HZ, RAD
from nlds_vines.model.setting import (
    Checked,
    Form,
    Merged,
    OneOf,
    Real,
    Request,
    Text,
    Whole,
    check_settings,
    entries,
    is_given,
    setting,
)
from nlds_vines.model.signals import Motion
from nlds_vines.model.system import System
from nlds_vines.plotting.bands import LARGEST

if TYPE_CHECKING:
    from nlds_vines.bifurcation.result import CellOrbit

EXPONENTS = "exponents"  # the panel whose numbers take a further computation

PANELS: Mapping[str, str] = {
    "displacement": "x1, x2 and what is struck; of a host those named by `of`",
    "velocity": "v1 and v2",
    "relative": "x2 - x1 and what is struck; of a host r, walls and touches",
    "force": "contact force and harmonic force",
    "energy": "E1 and E2",
    "energy1": "E1 alone",
    "energy2": "E2 alone",
    "phase": "structure, damper and what is struck in one phase plane",
    "phase1": "phase trajectory of the structure, its section",
    "phase2": "phase trajectory of the damper, its section, what is struck",
    "section": "Poincaré section of the damper, or of the structure without one",
    "section1": "Poincaré section of the structure",
    "shape": "shape of a host: its largest displacements, and instants of the last period",
    "impact-section": "section at impact: phase of the force and approach speed of each touch",
    "spectrum": "Fourier spectrum",
    EXPONENTS: "Lyapunov exponents from the end of the window on: running means, 99 % intervals",
}
"""The panels by name, with their contents; a page has them in the order of the request."""

# the default panels
USUAL = ("displacement", "relative", "force", "energy", "phase1", "phase2", "shape", "spectrum")

# the panels that are planes, two of them side by side
PLANES = ("phase", "phase1", "phase2", "section", "section1", "impact-section", "shape")
_BY_OWNER = ("relative", "phase1", "phase2", "section", "section1")
"""The panels that a host has for each displacement, or for each damper: `relative:cell1`."""

SYSTEM, SAMPLES, SHOW = "ssul-set6", 1024, 12
"""What is drawn unless something else is asked for.  1024 samples of a period are some 20 of a
contact: its force is folded onto its lines by 4e-4 of the largest at most."""

# the most numbers in the states of a run: 320 MB, which any machine has
MOST_NUMBERS = 4 * 10**7
MOST_COLUMNS = 4  # columns of a page: more of them are too narrow to read


# attributes of an archive of the orbit of a scan's cell: which one, and the hash of the scan
CELL, CELL_OF = "cell", "cell_of"


def word_of(panel: str) -> str:
    """Return the word of `PANELS` that a panel's name begins with: relative of `relative:cell1`."""
    return panel.partition(":")[0]


def checked_panels(value: Any) -> tuple[str, ...]:
    is_list = isinstance(value, Sequence) and not isinstance(value, str)
    named = [name for name in value if isinstance(name, str) and ":" in name] if is_list else []
    return checked_words("panels", value, [*PANELS, *(n for n in named if word_of(n) in PANELS)])


def _signals(value: object) -> tuple[str, ...]:
    return checked_names("signal", [value] if isinstance(value, str) else value)


class Window(NamedTuple):
    """Forcing periods from `begin` to `end`, counted from the start of the orbit."""

    begin: int
    end: int


@dataclass(frozen=True, repr=False)
class Column(Outlined):
    """A column of a page, which fills some `panels`, or all if none is named."""

    system: Any  # System
    window: Window
    name: str = ""
    panels: tuple[str, ...] = ()

    def heading(self) -> str:
        return f"{self.system.name}, periods {self.window.begin} to {self.window.end}"

    def outline(self) -> Rows:
        """Return the panels, if not all of the page."""
        return [("panels", ", ".join(self.panels))] if self.panels else []

    def fills(self, panel: str) -> bool:
        return not self.panels or panel in self.panels or word_of(panel) in self.panels


@dataclass(frozen=True, repr=False)
class PortraitRequest(Request):
    """The request of a portrait; validated when it is made, immutable afterwards.

    Columns of equal systems show windows of one run.  `panels` lacks those that no scene here can
    fill; of hosts a panel for each of several dampers or displacements has its name, as in
    `relative:cell1`.  `start` is the state [m, m/s] of every orbit, None for rest; `cell`, the
    orbit of an archive's cell, takes its place.
    """

    content: ClassVar[str] = PORTRAIT

    title: str
    columns: tuple[Column, ...]
    panels: tuple[str, ...] = setting(
        USUAL, Checked(checked_panels, listed=True),
        "portrait", "from top to bottom, see [Portrait](portrait.md)", "A,B,C",
        usual=", ".join(USUAL),
    )  # fmt: skip
    start: tuple[float, ...] | None = None
    samples: int = setting(
        SAMPLES, Whole(2, 10**6), "sampling", "states in each forcing period", "N"
    )
    method: str = method_setting()
    show: int = setting(
        SHOW, Whole(1), "portrait", "forcing periods in a time history, at most", "PERIODS"
    )
    signal: tuple[str, ...] = setting(
        (), Checked(_signals, listed=True), "portrait",
        "what spectra are of", "A,B", usual="x2, or x1 without damper; of a host as `of`",
    )  # fmt: skip
    of: tuple[str, ...] = setting(
        (), Checked(partial(checked_names, "of"), listed=True), "portrait",
        "displacements of a host that are drawn: `roof`, `cell1` or `roof-floor2`", "A,B",
        usual="where dampers hang",
    )  # fmt: skip
    taper: str = setting(
        "rectangular", OneOf(TAPERS), "portrait",
        f"of the spectrum: {' or '.join(f'`{name}`' for name in TAPERS)}",
    )  # fmt: skip
    comb: int = setting(
        0, Whole(0), "portrait", "n of the nT whose lines do not count as broadband",
        usual="as found, or 1",
    )  # fmt: skip
    section_phase: float = setting(
        0.0, Real(0.0, 1.0), "portrait",
        "phase of the force at which sections are taken, in turns: 0.25 where P cos(omega t) falls "
        "through zero; the nearest sample",
    )  # fmt: skip
    frequency: str = setting(
        RAD, OneOf((RAD, HZ)), "portrait", "unit of the forcing frequency on the page", "UNIT",
        usual="rad/s, or Hz if f is set",
    )  # fmt: skip
    tolerance: float | str | None = tolerance_setting("sampling")
    cell: CellOrbit | None = None

    def __post_init__(self) -> None:
        string("title", self.title)
        whole("number of columns", len(self.columns), 1, MOST_COLUMNS)
        check_settings(self)
        settings = chosen_settings(self.method, {"tolerance": self.tolerance})
        if self.method == "exact":
            object.__setattr__(self, "tolerance", settings.tolerance)
        systems = [column.system for column in self.columns]
        for system in systems:
            choice("method", self.method, system.scene.methods)
            system.shown(self.of)
        words = (*self.panels, *map(word_of, self.panels))
        for panel in [panel for column in self.columns for panel in column.panels]:
            choice("panel of a column", panel, words)
        for panel in self.panels:
            if not any(column.fills(panel) for column in self.columns):
                raise RequestError(f"panels: {panel!r} is filled by no column")
        allowed = panels_of(systems, self.of)
        possible = [name for one in self.panels for name in allowed if one in (name, word_of(name))]
        if not possible:
            raise RequestError(
                f"panels {', '.join(self.panels)} cannot be filled for kind {systems[0].kind!r}; "
                f"allowed: {', '.join(allowed)}"
            )
        object.__setattr__(self, "panels", tuple(dict.fromkeys(possible)))
        whole("comb", self.comb, 0, min(c.window.end - c.window.begin for c in self.columns))
        object.__setattr__(self, "signal", self.signal or _common_signals(systems, self.of))
        for system in systems:
            components = system.scene.components
            for name in self.signal:
                system.signal(name)
            if self.start is not None and len(self.start) != len(components):
                names = ", ".join(components)
                raise RequestError(f"start = {shown(self.start)}; allowed: rest, or {names}")
            for name, place in system.places.items():
                if abs(place) > LARGEST:
                    raise RequestError(
                        f"{name} at {place!r} m cannot be drawn; allowed: up to {LARGEST:g} m"
                    )
        for run in self.runs():
            begin, end = span(run)
            most = MOST_NUMBERS // len(run[0].system.scene.components)
            if (end - begin) * self.samples > most:
                raise RequestError(
                    f"periods {begin} to {end} with {self.samples} samples each are too many "
                    f"states; allowed: {most}; take fewer samples or nearer windows"
                )

    def starts_inside(self) -> list[str]:
        """Return a line for each system whose orbit begins inside a wall; none for a cell's."""
        lines = []
        for system in () if self.cell else [run[0].system for run in self.runs()]:
            state = dict(zip(system.scene.components, self.start or (), strict=False))
            lines += [f"{system.name}: {line}" for line in starts_inside(system, {}, state)]
        return lines

    def runs(self) -> tuple[tuple[Column, ...], ...]:
        """Return the columns in groups of one system, which share an orbit."""
        runs: list[tuple[Column, ...]] = []
        for column in self.columns:
            same = (i for i, run in enumerate(runs) if _are_same(run[0].system, column.system))
            if (i := next(same, None)) is None:
                runs.append((column,))
            else:
                runs[i] += (column,)
        return tuple(runs)

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of the archive beside the request: of a cell's orbit, which cell it is."""
        if self.cell is None:
            return {}
        values = self.cell.begin.system.parameters
        at = ",".join(f"{axis.name}={values[axis.name]!r}" for axis in self.cell.scan.axes)
        return {CELL: f"--at {at} --start {self.cell.start}", CELL_OF: self.cell.scan.hash}

    def document(self) -> dict[str, Any]:
        """Return the request file of this portrait, as nested tables.

        The system is that of the first column; the others set the parameters that differ.  If they
        differ in more, it can be hashed, but not read.  A cell's orbit becomes one from `start`.
        """
        system = self.columns[0].system
        return {
            "title": self.title,
            "system": system.to_table(),
            "start": {"policy": "rest"} if self.start is None else {"state": list(self.start)},
            "sampling": entries(self, "sampling"),
            "portrait": entries(self, "portrait") | {"panels": list(self.panels)},
            "column": [
                {
                    "name": column.name,
                    "window": list(column.window),
                    **({"panels": list(column.panels)} if column.panels else {}),
                    **({} if self.is_of_one_kind else {"system": column.system.to_table()}),
                    "set": column.system.changes_from(system),
                }
                for column in self.columns
            ],
        }

    @property
    def is_of_one_kind(self) -> bool:
        """Whether the systems of the columns differ in nothing but what `[set]` changes."""
        first, *others = (column.system for column in self.columns)
        return all(system.has_parts_of(first) for system in others)

    @cached_property
    def hash(self) -> str:
        """The hash of the document and, for the orbit of a cell, of its scan and its start."""
        cell = "" if self.cell is None else f"{self.cell.scan.hash} {self.cell.start}"
        return hashlib.sha256(f"{super().hash} {cell}".encode()).hexdigest()


def span(run: Sequence[Column]) -> Window:
    windows = [column.window for column in run]
    return Window(min(w.begin for w in windows), max(w.end for w in windows))


def panels_of(systems: Iterable[System], of: Sequence[str] = ()) -> tuple[str, ...]:
    """Return the names of the panels that any of the systems can fill, in the order of `PANELS`.

    of: the displacements of hosts, as of a request.
    """
    names = [name for system in systems for name in _panels_of(system, of)]
    return tuple(sorted(dict.fromkeys(names), key=lambda name: [*PANELS].index(word_of(name))))


def _panels_of(system: System, of: Sequence[str]) -> Iterator[str]:
    for name in PANELS:
        owners = _owners(name, system, of)
        several = owners is not None and len(owners) > 1
        if several and name in _BY_OWNER:
            yield from [f"{name}:{owner}" for owner in owners or ()]
        elif owners:
            yield name


def _owners(panel: str, system: System, of: Sequence[str]) -> Sequence[str]:
    """Return the bodies that a panel shows; none if the system cannot fill it."""
    scene = system.scene
    match panel:
        case "shape":
            return system.chain
        case "impact-section":
            return scene.wall_words
        case "force":
            return system.force_signals
        case "energy2":
            return system.damper_names
        case _:
            return [motion.body for motion in motions_in(panel, system, of)]


def motions_in(panel: str, system: System, of: Sequence[str]) -> Sequence[Motion]:
    """Return the motions in a panel, a word of `PANELS`; all bodies where it shows no motion."""
    motions = system.motions(of)
    match panel:
        case "relative":
            return motions.strokes
        case "phase1":
            return motions.structure
        case "phase2":
            return motions.dampers
        case "section":
            return motions.dampers or motions.structure
        case "section1":
            return motions.structure if motions.dampers else ()
        case _:
            return motions.bodies


def _common_signals(systems: Sequence[System], of: Sequence[str]) -> tuple[str, ...]:
    """Return the usual signals of the first system whose signals all systems have."""
    usual = [system.usual_signals(of) for system in systems]
    for names in usual:
        try:
            for system in systems:
                for name in names:
                    system.signal(name)
        except RequestError:
            continue
        return names
    return usual[0]


def _are_same(one: System, other: System) -> bool:
    return one is other or one.to_table() == other.to_table()


def checked_window(what: str, value: object) -> Window:
    pair: Any = value.split(":") if isinstance(value, str) else value
    form = f"{what} = {shown(value)} must be BEGIN:END, two numbers of forcing periods"
    if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
        raise RequestError(form)
    if isinstance(value, str):
        try:
            pair = [from_text(int, what, text) for text in pair]
        except RequestError:
            raise RequestError(form) from None
    begin = whole(f"begin of {what}", pair[0], 0)
    return Window(begin, whole(f"end of {what}", pair[1], begin + 1))


def described(system: System, frequency: str = RAD) -> str:
    """Return a system in one line: title, numbers that the user set, forcing frequency."""
    changed = [name for name in system.changed_by_user if name in system.parameters]
    different = dict.fromkeys([*(name for name in changed if name != "omega"), "omega"])
    settings = [setting_in_words(name, system.parameters[name]) for name in different]
    if frequency == HZ:
        settings[-1] = setting_in_words("f", system.parameters["omega"] / (2.0 * pi))
    return ", ".join([system.in_words(), *settings])


def _checked_windows(value: object) -> list[Window]:
    if not isinstance(value, Sequence) or isinstance(value, str) or not value:
        raise RequestError(f"windows = {shown(value)} must be a list of pairs [begin, end]")
    windows = [checked_window("windows", pair) for pair in value]
    for first, second in pairwise(windows):
        if second.begin < first.end:
            raise RequestError(
                f"windows {first.begin}:{first.end} and {second.begin}:{second.end} "
                "must follow each other in time"
            )
    return windows


@dataclass(frozen=True)
class Times:
    """The starts of the orbits and the periods that a portrait shows."""

    policy: str = setting("rest", OneOf(("rest",)), "start", "`rest`", replaces=("state",))
    state: tuple[float, ...] | None = setting(
        None, Checked(checked_state), "start",
        "x1, v1, x2, v2 at t = 0 [m, m/s]; of a host its `scene.components`",
        replaces=("policy",),
    )  # fmt: skip
    transient: int = setting(
        600, Whole(0), "sampling", "forcing periods that are discarded", "PERIODS",
        replaces=("windows",),
    )  # fmt: skip
    periods: int = setting(
        240, Whole(1), "sampling", "forcing periods that are sampled", "PERIODS",
        replaces=("windows",),
    )  # fmt: skip
    windows: Any = setting(
        (), Checked(_checked_windows, listed=True), "sampling",
        "`[[begin, end], ...]`: periods to look at, in place of `transient` and `periods`",
        "B:E,B:E", replaces=("transient", "periods"),
    )  # fmt: skip


@dataclass(frozen=True)
class ColumnEntry:
    name: str = setting("", Text(), "[column]", "heading above it")
    settings: Mapping[str, Any] | None = setting(
        None, table, "[column]", "its parameters", key="set"
    )
    window: Window | None = setting(
        None, Checked(lambda value: checked_window("window", value)), "[column]",
        "`[begin, end]`: the periods that it shows", usual="those of `[sampling]`",
    )  # fmt: skip
    panels: tuple[str, ...] = setting(
        (),
        Checked(lambda n: checked_panels(n) if n != () else (), listed=True),
        "[column]", "of the page, which it fills", usual="all",
    )  # fmt: skip


FORM = Form("portrait", (Times, PortraitRequest), rows={"column": ColumnEntry})
"""The tables and keys of the request file of a portrait."""


def load_portrait(
    source: str | os.PathLike[str] | Mapping[str, Any] | System | None = None,
    changes: Mapping[str, Any] | None = None,
    changes_from: str = "changes",
) -> PortraitRequest:
    """Return the request of a portrait, checked.

    Parameters
    ----------
    source : str, path-like, mapping or System, optional
        A request file (.toml), its content, or a system or its name; by default SSul NES Set 6.
    changes : mapping, optional
        Tables and keys that override those of the request, entry by entry.
    changes_from : str, optional
        The name of the changes in errors.

    Returns
    -------
    PortraitRequest
        The request, which `orbit_portrait` takes.

    Raises
    ------
    RequestError
        If an entry is unknown or not allowed.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> request = nv.load_portrait("ssul-set6", {"sampling": {"windows": [[600, 612]]}})
    >>> request.columns[0].window.begin
    600
    """
    request = FORM.read(SYSTEM if source is None else source, changes, changes_from)
    times = request.of(Times)
    for names in (("windows", "transient"), ("windows", "periods"), ("policy", "state")):
        if {*names} <= times.keys():
            place = request.place("start" if "state" in names else "sampling")
            raise RequestError(f"{place}: {names[0]} beside {names[1]}: give one of them")
    columns = tuple(_columns(request, Times(**times)))
    title, system = request.title("system", "set"), columns[0].system
    settings = request.of(PortraitRequest)
    changed = [name for _, layer in request.layers for name in flat(layer.get("set", {}))]
    if "f" in changed:
        settings = {"frequency": HZ, **settings}
    if title is None:
        is_one = all(_are_same(system, column.system) for column in columns)
        unit = settings.get("frequency", RAD)
        title = described(system, unit) if is_one else system.in_words()
    return request.make(
        PortraitRequest,
        request.layers[0][0],
        **settings,
        title=title,
        columns=columns,
        start=times.get("state"),
    )


def portrait_of(
    cell: CellOrbit, changes: Mapping[str, Any], changes_from: str = "changes"
) -> PortraitRequest:
    """Return the request for the orbit of an archive's cell, by default over the scan's periods.

    System, start and method are the cell's, so `changes` must not have them.
    """
    scan, system = cell.scan, cell.begin.system
    sampling = table("sampling", changes.get("sampling", {}))
    beside = [key for key in ("system", "set", "start") if is_given(changes.get(key))]
    beside += [key for key in ("method", "tolerance") if key in sampling]
    if beside:
        raise RequestError(f"{changes_from}: {beside[0]} beside an archive, which holds it")
    start = f", start {cell.start}" if scan.starts > 1 else ""
    regime = f"; in the scan: {cell.label}" if cell.label else ""
    usual = {"transient": scan.transient, "periods": scan.periods, "method": scan.method}
    unit = table("portrait", changes.get("portrait", {})).get("frequency", RAD)
    title = described(system, unit) + start + regime
    document = {"title": title, "system": system, "sampling": usual}
    return replace(load_portrait(document, changes, changes_from), cell=cell)


def _columns(request: Merged, times: Times) -> Iterator[Column]:
    """Yield the columns; windows and panels of the changes replace those of a column."""
    system: Any = request.any_system()
    (where, below), (changes_from, above) = request.layers
    default = [Window(times.transient, times.transient + times.periods)]
    windows = [*times.windows] or default
    is_asked = not {"windows", "transient", "periods"}.isdisjoint(above.get("sampling", {}))
    for entry in request.rows("column") or [ColumnEntry()]:
        with at(where):
            one = system.with_(**flat(below.get("set", {})) | flat(entry.settings or {}))
        with at(f"{changes_from}: [set]"):
            one = one.with_(**above.get("set", {}))
        panels = () if "panels" in above.get("portrait", {}) else entry.panels
        for window in windows if is_asked or entry.window is None else [entry.window]:
            yield Column(one, window, entry.name, panels)
