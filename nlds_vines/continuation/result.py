"""The results of a continuation, branches, special points and curves, and their datasets."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.archive import ArchivePath, read
from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.archives.provenance import CONTINUATION
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.continuation.arclength import best_map, place_at, seen_by
from nlds_vines.continuation.branch_arm import ENDS, at_value
from nlds_vines.continuation.exploration import Switch, Track, is_same
from nlds_vines.continuation.request import Continuation, load_continuation
from nlds_vines.continuation.special_curves import ENDS as CURVE_ENDS
from nlds_vines.continuation.special_points import KINDS, Special, torus_pair
from nlds_vines.engine.engine import engine_for
from nlds_vines.engine.section_map import Cycle, SectionMap
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.errors import RequestError, number, option
from nlds_vines.kernels.numerics.elementary import cos_sin_of_turn, exp
from nlds_vines.model.axis import Interval
from nlds_vines.model.labels import QUASIPERIODIC, UNDETERMINED
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.model.system import System
from nlds_vines.plotting.drawable import Drawable
from nlds_vines.plotting.style import HUES

# the marks of special points in pictures
MARKS: dict[str, dict[str, Any]] = {
    "LP": {"marker": "o", "color": HUES["green"]},
    "PD": {"marker": "^", "color": HUES["vermillion"]},
    "NS": {"marker": "s", "color": HUES["blue"]},
    "BP": {"marker": "X", "color": HUES["black"]},
    "GR": {"marker": "D", "color": HUES["pink"]},
    "LIM": {"marker": "v", "color": HUES["orange"]},
    "UZ": {"marker": "*", "color": HUES["sky"]},
}

# the marks of ends in the middle of a picture: of branches, and of curves in a plane
STOPS = {"lost": "x", "long": "+", "unstable": "|", "neutral": "|"}

WORDS = {
    "LP": "fold", "PD": "period doubling", "NS": "torus", "BP": "branch point",
    "GR": "grazing", "LIM": "limit touched", "UZ": "monitor",
}  # fmt: skip

# CF flags of datasets
ORIGINS = {"start": 0, "PD": 1, "BP": 2}
KIND_FLAGS = {kind: number for number, kind in enumerate(KINDS)}
END_FLAGS = {word: number for number, word in enumerate(ENDS)}
SWITCH_FLAGS = {outcome.name.lower(): int(outcome) for outcome in Switch}
STATUS_FLAGS = {"complete": 0, "incomplete": 1}
STABLE_FLAGS = {"unstable": 0, "stable": 1}
CURVE_END_FLAGS = {word: number for number, word in enumerate(CURVE_ENDS)}

STATE_UNITS = "m, m/s"
DEFECT = "closing error of the orbit, relative"
INCOMPLETE = {"lost", "long"}  # ends of branches and curves that are not complete
RESOLVED = 1.0e-10  # largest last bracket of a resolved special point, relative to the parameter
# residual of a monitor, relative to its size beside the point, above which it jumps there
JUMP = 1.0e-6

MOST_RUNS = 6  # regimes of a torus that the report lists

NEWTON_STEPS = 8  # for an angle: the error of the first is up to 1/4 turn, then its cube

# dimensions of datasets that an archive leaves out if they are empty
MAY_BE_EMPTY = {"special", "special_row", "torus_cell", "curve_point", "curve", "meeting_point"}

Tables = dict[str, np.ndarray]  # by the name of a dataset


@dataclass(frozen=True, repr=False)
class Branch(Outlined):
    """One branch of nT orbits; arrays have an entry for each of its points, in order.

    Attributes
    ----------
    parameter : (points,) ndarray
        The free parameter [SI].
    states : (points, 4) ndarray
        x1, v1, x2, v2 [m, m/s] at phase zero; without a damper two components; of a host those of
        its `scene.components`.
    sections : (points, n, 4) ndarray
        The states one, two, ... periods later; the last ones are `states`.
    period : int
        n of nT.
    labels : (points,) ndarray of str
        "T,1", "3T,3" ...
    impacts : (points, 2) ndarray
        Impacts per nT at the near and the far wall; of a host, at each of its walls, damper by
        damper.
    stable : (points,) ndarray of bool
        Whether all multipliers lie inside the unit circle.
    multipliers : (points, 4) complex ndarray
        Floquet multipliers, the largest modulus first.
    E1max, E2max : (points,) ndarray
        Largest energies [J]; E2max is NaN without a damper, and (points, dampers) of several.
    residual : (points,) ndarray
        Closing error of the orbit in the energy norm, relative to the orbit.
    determinant_error : (points,) ndarray
        Relative difference of the product of the multipliers and the one that the divergence of
        the equation of motion requires: an error bar of the multipliers; NaN of a host.
    clearance : (points,) ndarray
        Smallest distance [m] of a pass that misses a wall; inf without any.
    softest_impact, fastest_impact : (points,) ndarray
        Smallest and largest approach speed [m/s]; inf and 0 without an impact.
    largest_force : (points,) ndarray
        Largest contact force [N].
    ends : (str, str)
        Why it ends at the first and the last point, keys of `branch_arm.ENDS`.
    origin : str
        "start", or the special point at which it leaves another branch: "PD" or "BP".
    parent : int
        Number of that branch; -1 for "start".
    monitors : mapping of str to (points,) ndarray
        The values of the functions among the monitors, by name.
    """

    parameter: np.ndarray
    states: np.ndarray
    sections: np.ndarray
    period: int
    labels: np.ndarray
    impacts: np.ndarray
    stable: np.ndarray
    multipliers: np.ndarray
    E1max: np.ndarray
    E2max: np.ndarray
    residual: np.ndarray
    determinant_error: np.ndarray
    clearance: np.ndarray
    softest_impact: np.ndarray
    fastest_impact: np.ndarray
    largest_force: np.ndarray
    ends: tuple[str, str]
    origin: str
    parent: int
    monitors: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.parameter)


@dataclass(frozen=True, repr=False)
class Crossing(Outlined):
    """The orbit of a branch at one value of the parameter.

    Attributes
    ----------
    branch : int
        Number of the branch.
    system : System
        The system with this value: `simulate(orbit.system, start=orbit.state)` is the orbit.
    value : float
        The value [SI].
    label : str
        "T,1", "3T,3" ...
    state : (4,) ndarray
        x1, v1, x2, v2 [m, m/s] at phase zero.
    multipliers : (4,) complex ndarray
        Floquet multipliers.
    unstable : int
        Number of multipliers outside the unit circle.
    sections : (n, 4) ndarray
        The states one, two, ... periods later; the last one is `state`.
    impacts : (2,) ndarray
        Impacts per nT at the near and the far wall; of a host, at each of its walls.
    E1max, E2max : float
        Largest energies [J]; E2max is NaN without a damper, and (dampers,) of several.
    clearance : float
        Smallest distance [m] of a pass that misses a wall; inf without any.
    softest_impact, fastest_impact : float
        Smallest and largest approach speed [m/s]; inf and 0 without an impact.
    largest_force : float
        Largest contact force [N].
    """

    branch: int
    system: System
    value: float
    label: str
    state: np.ndarray
    multipliers: np.ndarray
    unstable: int
    sections: np.ndarray
    impacts: np.ndarray
    E1max: float
    E2max: float | np.ndarray
    clearance: float
    softest_impact: float
    fastest_impact: float
    largest_force: float

    @property
    def period(self) -> int:
        """The n of nT."""
        return len(self.sections)

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie inside the unit circle."""
        return self.unstable == 0


@dataclass(frozen=True, repr=False)
class Torus(Outlined):
    """The attractor that is followed, cell by cell, from an NS to where the orbit is unstable.

    Attributes
    ----------
    special : int
        Row of the NS in `Continued.special_points`.
    values : (cells,) ndarray
        The parameter [SI], from the NS on; around the first border of regimes the cells are denser.
    labels : (cells,) ndarray of str
        The regimes: "quasiperiodic" on the torus, "14T,14" where it is locked, "chaos" ...
    """

    special: int
    values: np.ndarray
    labels: np.ndarray

    @property
    def runs(self) -> list[tuple[str, float, float]]:
        """The regimes in turn, each with the parameter in its first and its last cell."""
        borders = (np.flatnonzero(self.labels[1:] != self.labels[:-1]) + 1).tolist()
        ends = zip([0, *borders], [*borders, len(self.labels)], strict=True)
        return [
            (str(self.labels[first]), float(self.values[first]), float(self.values[behind - 1]))
            for first, behind in ends
        ]


@dataclass(frozen=True, repr=False)
class SpecialCurve(Outlined):
    """A curve of special points in the plane of two parameters.

    Attributes
    ----------
    kind : str
        LP, PD, NS or GR.
    period : int
        n of nT.
    values : (points, 2) ndarray
        Both parameters [SI].
    states : (points, 4) ndarray
        x1, v1, x2, v2 [m, m/s] at phase zero.
    multipliers : (points, 4) complex ndarray
        Floquet multipliers.
    ends : (str, str)
        Why it ends at the first and the last point, keys of `special_curves.ENDS`.
    meetings : tuple of (str, float, float)
        Name and parameters of points of codimension two: R1 to R4, strong resonances; CP, cusp;
        LP-PD, fold-flip; GR-LP, GR-PD, GR-NS, contact with a curve of grazing.
    """

    kind: str
    period: int
    values: np.ndarray
    states: np.ndarray
    multipliers: np.ndarray
    ends: tuple[str, str]
    meetings: tuple[tuple[str, float, float], ...]


@dataclass(frozen=True, eq=False, repr=False)
class Continued(Drawable):
    """The branches of a continuation and their special points, from `continue_branch`.

    Attributes
    ----------
    request : Continuation
        The request; `continue_branch` computes the same again from it.
    tables : dict of str to ndarray
        The datasets of the archive by name.
    path : path-like
        The archive; None without one.
    kinds : dict of str to str
        The kinds of special points, with a word for each.
    marks : dict of str to dict
        The marker and the color of each kind in pictures, as options of Matplotlib.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> branches = nv.continue_branch("ssul-set6", "omega", (5.4, 5.6), quiet=True)
    >>> branches.branches[0].labels[0], bool(branches.branches[0].stable.all())
    ('T,1', True)
    >>> (orbit,) = branches.orbits_at(5.5)
    >>> orbit.label, orbit.unstable
    ('T,1', 0)
    """

    drawn_by = "nlds_vines.continuation.picture"
    kinds: ClassVar[Mapping[str, str]] = WORDS
    marks: ClassVar[Mapping[str, Mapping[str, Any]]] = MARKS

    request: Continuation
    tables: Tables
    path: ArchivePath | None = None

    @cached_property
    def branches(self) -> tuple[Branch, ...]:
        """All branches, those of the start orbits first."""
        t, words, branches = self.tables, list(ENDS), []
        names = (
            *("E1max", "E2max", "residual", "determinant_error", "clearance"),
            *("softest_impact", "fastest_impact", "largest_force"),
        )
        for i in range(len(t["status"])):
            rows = t["branch_of_point"] == i
            pairs, period = t["multipliers"][rows], int(t["periodicity"][rows][0])
            states = t["state"][rows]
            impacts = t.get("impacts_by_wall", np.zeros((len(rows), 0), int))[rows]
            sections = t["section"][np.repeat(rows, t["periodicity"])]
            along = {name: t[name][rows] for name in names if name in t}
            branches.append(
                Branch(
                    parameter=t[self.request.along.name][rows],
                    states=states,
                    sections=sections.reshape(len(states), -1, states.shape[1]),
                    period=period,
                    labels=t["label"][rows],
                    impacts=impacts,
                    stable=t["stable"][rows].astype(bool),
                    multipliers=pairs[..., 0] + 1j * pairs[..., 1],
                    ends=(words[int(t["first_end"][i])], words[int(t["last_end"][i])]),
                    origin=list(ORIGINS)[int(t["origin"][i])],
                    parent=int(t["parent"][i]),
                    monitors={
                        one.name: t[one.dataset][rows]
                        for one in self.request.monitors
                        if one.is_function
                    },
                    **{**dict.fromkeys(names, np.full(len(states), np.nan)), **along},
                )
            )
        return tuple(branches)

    @cached_property
    def special_points(self) -> np.recarray:
        """The special points, a row each, branch after branch.

        The columns are kind (LP, PD, NS, BP, GR, LIM or UZ); value of the parameter; before and
        after, the labels along the branch; residual of the test function, relative (of a BP, the
        difference of two extrapolations; the closing error is defect); bracket, the width of the
        last bracket in units of the parameter; resolved, whether that is at most 1e-10 of the
        value; defect, the closing error, relative; wall of a grazing impact; branch, its number;
        index of the preceding point of its branch; periodicity, n of nT; state at phase zero [m,
        m/s]; switch, the outcome of following the branch that leaves there: none, followed, known
        or failed; rotation, of an NS the rotation number of the torus, in turns per nT: |arg mu| /
        2 pi, NaN of other kinds; monitor, of a UZ the quantity and its value, or a function's name.
        """
        t = self.tables
        values, bracket = t[f"special_{self.request.along.name}"], t["bracket"]
        columns: dict[str, tuple[Any, Any]] = {
            "kind": ("U3", [KINDS[int(code)] for code in t["kind"]]),
            "value": (float, values),
            "before": ("U48", t["before"].astype(str)),
            "after": ("U48", t["after"].astype(str)),
            "residual": (float, t["special_residual"]),
            "bracket": (float, bracket),
            "defect": (float, t["special_defect"]),
            "wall": ("U48", t["special_wall"].astype(str)),
            "branch": (int, t["special_branch"]),
            "index": (int, t["special_index"]),
            "periodicity": (int, t["special_periodicity"]),
            "state": ((float, t["special_state"].shape[1:]), t["special_state"]),
            "switch": ("U8", [Switch(int(code)).name.lower() for code in t["switch"]]),
            "resolved": (bool, bracket <= RESOLVED * np.abs(values)),
            "monitor": ("U64", t.get("special_monitor", np.full(len(values), "")).astype(str)),
            "rotation": (float, t.get("rotation", np.full(len(values), np.nan))),
        }
        kinds = [(name, kind) for name, (kind, _) in columns.items()]
        return np.rec.fromarrays([column for _, column in columns.values()], kinds)

    @cached_property
    def special_sections(self) -> tuple[np.ndarray, ...]:
        """The states (n, 4) of each special point one, two, ... periods later."""
        rows = self.tables.get("special_section")
        if rows is None:  # an archive of an earlier version
            return tuple(state[np.newaxis] for state in self.tables["special_state"])
        periods = self.tables["special_periodicity"]
        return tuple(np.split(rows, np.cumsum(periods)[:-1])) if len(periods) else ()

    @cached_property
    def tori(self) -> tuple[Torus, ...]:
        """The tori at each NS where a stable orbit loses its stability; () without `tori`."""
        tori = []
        if self.request.tori:
            of_cells = self.tables["torus_special"]
            for number in dict.fromkeys(of_cells.tolist()):
                rows = of_cells == number
                values = self.tables[f"torus_{self.request.along.name}"][rows]
                tori.append(Torus(number, values, self.tables["torus_label"][rows].astype(str)))
        return tuple(tori)

    @cached_property
    def curves(self) -> tuple[SpecialCurve, ...]:
        """The curves of special points in the plane of two parameters; () for one parameter."""
        if self.request.plane is None:
            return ()
        t, names = self.tables, (self.request.along.name, self.request.plane.name)
        words, curves = list(CURVE_ENDS), []
        for i in range(len(t["curve_kind"])):
            rows, met = t["curve_of_point"] == i, t["curve_of_meeting"] == i
            pairs = t["curve_multipliers"][rows]
            at = [t["meeting"][met], *(t[f"meeting_{name}"][met] for name in names)]
            curves.append(
                SpecialCurve(
                    kind=KINDS[int(t["curve_kind"][i])],
                    period=int(t["curve_periodicity"][i]),
                    values=np.stack([t[f"curve_{name}"][rows] for name in names], axis=-1),
                    states=t["curve_state"][rows],
                    multipliers=pairs[..., 0] + 1j * pairs[..., 1],
                    ends=(words[int(t["curve_first_end"][i])], words[int(t["curve_last_end"][i])]),
                    meetings=tuple(
                        (str(n), float(a), float(b)) for n, a, b in zip(*at, strict=True)
                    ),
                )
            )
        return tuple(curves)

    @property
    def incomplete(self) -> tuple[int, int]:
        """The numbers of branches and of curves that end as "lost" or "long"."""
        branches = sum(not INCOMPLETE.isdisjoint(branch.ends) for branch in self.branches)
        curves = sum(not INCOMPLETE.isdisjoint(curve.ends) for curve in self.curves)
        return branches, curves

    def orbits_at(self, value: float) -> list[Crossing]:
        """Return the orbits of all branches at a value of the parameter.

        Parameters
        ----------
        value : float
            Value of the parameter within the interval.

        Returns
        -------
        list of Crossing
            Each closed by Newton's method.

        Raises
        ------
        RequestError
            If the value lies outside the interval.
        """
        along = self.request.along
        value = number(along.name, value)
        if not along.low <= value <= along.high:
            raise RequestError(
                f"{along.name} = {value!r}; allowed: {along.low!r} to {along.high!r}"
            )
        section_map = map_of(self.request)
        there = self.request.system.with_(**{along.name: value})
        crossings: list[Crossing] = []
        for i, branch in enumerate(self.branches):
            cycles: list[Cycle] = []
            for _, cycle in self.cycles_at(section_map, branch, value):
                if any(is_same(section_map, cycle, other) for other in cycles):
                    continue
                cycles.append(cycle)
                crossings.append(crossing_of(section_map, there, i, cycle))
        return crossings

    def cycles_at(
        self, section_map: SectionMap, branch: Branch, value: float
    ) -> Iterator[tuple[int, Cycle]]:
        """Yield (index of the preceding point, orbit) for each orbit of a branch at a value."""
        values, n = branch.parameter, branch.period
        for i in np.flatnonzero((values[:-1] - value) * (values[1:] - value) <= 0.0):
            ends = [
                section_map.place_of(float(values[j]), branch.states[j].tolist())
                for j in (i, i + 1)
            ]
            # at a phase in flight, as a rigid impact may pass phase zero between the two points
            there = best_map(section_map, ends[0], n)
            a, b = (place_at(section_map, place, n, there.since) for place in ends)
            if a is None or b is None:
                continue
            step = values[i + 1] - values[i]
            share = (value - values[i]) / step if step else 0.0
            cycle = at_value(there, a + share * (b - a), n, value)
            if cycle is not None and cycle.since:
                seen = seen_by(there, section_map, cycle, np.zeros(len(cycle.place)))
                cycle = None if seen is None else seen[0]
            if cycle is not None:
                yield int(i), cycle

    def lines(self) -> Iterator[str]:
        """Yield the lines of the report."""
        yield self.request.title
        counts = (
            (len(self.branches), "branch", "es"),
            (len(self.tables["periodicity"]), "point", "s"),
            (len(self.special_points), "special point", "s"),
        )
        yield ", ".join(f"{n} {word}{plural * (n != 1)}" for n, word, plural in counts)
        along = self.request.along
        for i, branch in enumerate(self.branches):
            labels = ", ".join(dict.fromkeys(branch.labels.tolist()))
            origin = "" if branch.parent < 0 else f" from {branch.origin} of branch {branch.parent}"
            ends = along.range_in_words(branch.parameter.min(), branch.parameter.max())
            yield (
                f"branch {i}{origin}: {labels}; {ends}; {int(branch.stable.sum())} of "
                f"{len(branch)} points stable; ends: {branch.ends[0]}, {branch.ends[1]}"
            )
            yield from _stops_in_words(branch.ends, ENDS)
            for at in np.flatnonzero(self.special_points.branch == i):
                row = self.special_points[at]
                place = along.value_in_words(row.value, 12)
                yield f"  {row.kind:<3} {place}  {_change_in_words(row)}"
                for torus in self.tori:
                    if torus.special == at:
                        yield f"      {_torus_in_words(torus, along)}"
        for curve in self.curves:
            pairs = list(zip(self.request.free, curve.values.T, strict=True))
            ranges = ", ".join(item.range_in_words(x.min(), x.max()) for item, x in pairs)
            yield f"curve of {curve.kind}, {curve.period}T: {ranges}; ends: {', '.join(curve.ends)}"
            yield from _stops_in_words(curve.ends, CURVE_ENDS)
            for name, *values in curve.meetings:
                places = [
                    item.value_in_words(value, 10)
                    for item, value in zip(self.request.free, values, strict=True)
                ]
                yield f"  {name:<6} {', '.join(places)}"

    def outline(self) -> Rows:
        """Return the numbers of branches, special points and curves."""
        labels = dict.fromkeys(str(label) for b in self.branches for label in b.labels)
        points = sum(len(branch) for branch in self.branches)
        yield "branches", f"{len(self.branches)}, {points} points: {', '.join(labels)}"
        kinds = Counter(self.special_points.kind.tolist()).items()
        yield "special points", ", ".join(f"{n} {kind}" for kind, n in kinds) or "none"
        if self.curves:
            kinds = Counter(curve.kind for curve in self.curves).items()
            yield "curves", ", ".join(f"{n} of {kind}" for kind, n in kinds)


def _stops_in_words(ends: tuple[str, str], reasons: Mapping[str, str]) -> Iterator[str]:
    """Yield a line for each end that the user has not asked for."""
    for end in dict.fromkeys(ends):
        if end in STOPS and end != "unstable":
            more = f"; {option('points')} allows more" if end == "long" else ""
            yield f"  {end}: {reasons[end]}{more}"


def _change_in_words(row: Any) -> str:
    """Return the report on a special point behind its place: the labels on both sides, and more.

    That is the wall that is grazed, the monitor, the rotation number, and what was not found.
    """
    words = f"{row.before} -> {row.after}" if row.before != row.after else str(row.before)
    if row.wall:
        several = row.wall == "both" or " " in row.wall
        words += f" ({row.wall} wall{'s' * several})"
    if row.monitor:
        words += f"; {row.monitor}"
        if row.residual > JUMP:
            words += ", across which it jumps"
    if row.kind == "NS":
        words += f"; rotation number {row.rotation:.8g}"
    if not row.resolved:
        words += f"; unresolved, within {row.bracket:.1g}"
    if row.switch == "failed":
        words += "; the branch that leaves there was not found"
    return words


def _torus_in_words(torus: Torus, along: Interval) -> str:
    """Return where a torus ends, and the regimes behind it, each with its last cell."""
    if torus.labels[0] not in (QUASIPERIODIC, UNDETERMINED):
        return f"no stable torus beside it, but {torus.labels[0]}"
    texts = []
    for label, _, last in torus.runs[:MOST_RUNS]:
        texts.append(f"{label} to {along.as_stated(last):.8g}")
    more = ", ..." if len(torus.runs) > MOST_RUNS else ""
    return f"torus: {', '.join(texts)}{more}"


def crossing_of(section_map: SectionMap, system: System, branch: int, cycle: Cycle) -> Crossing:
    """Return an orbit at phase zero, of a branch and of a system with the orbit's value."""
    size, value = section_map.size, float(cycle.values[0])
    places = np.column_stack([cycle.points[:, :size], np.full(cycle.n, value)])
    extremes = section_map.measure(cycle.place[np.newaxis], np.array([cycle.n]))
    energy, (fastest, force) = extremes.energy[0], extremes.strokes[0].tolist()
    E2max: float | np.ndarray = math.nan
    if system.scene.dampers:
        E2max = energy[1:]
    elif system.scene.damper:
        E2max = float(energy[1])
    return Crossing(
        branch=branch,
        system=system,
        value=value,
        label=cycle.label,
        state=section_map.states_of(cycle.place[np.newaxis])[0],
        multipliers=cycle.multipliers,
        unstable=cycle.unstable,
        sections=section_map.states_of(places),
        impacts=np.array(cycle.counts),
        E1max=float(energy[0]),
        E2max=E2max,
        clearance=cycle.clearance,
        softest_impact=cycle.slowest,
        fastest_impact=fastest,
        largest_force=force,
    )


def map_of(request: Continuation, free: int = 1) -> SectionMap:
    """Return the section map of the first of the free parameters, or of both."""
    items, settings = request.free[:free], Settings(float(request.tolerance))
    names = tuple(item.name for item in items)
    lengths = [item.high - item.low for item in items]
    return engine_for(request.system).trace(names, settings, lengths)


def read_continuation(path: str | os.PathLike[str]) -> Continued:
    """Return the results in the archive of a continuation; `RequestError` for any other file."""
    with read(path) as view:
        request = view.request(CONTINUATION, load_continuation)
        size, tables = len(request.system.scene.components), dict[str, np.ndarray]()
        dampers = len(request.system.scene.dampers)
        shapes = {"component": size, "multiplier": size, "part": 2, "damper": dampers}
        for entry in datasets_of(request):
            if entry.name in view:
                tables[entry.name] = view[entry.name]
            elif entry.dims[0] in MAY_BE_EMPTY:
                kind = object if entry.dtype == "str" else entry.dtype
                tables[entry.name] = np.empty((0, *(shapes[dim] for dim in entry.dims[1:])), kind)
    return Continued(request, tables, ArchivePath.of(path))


# ---- the datasets of an archive ----


def _entries(request: Continuation) -> Iterator[tuple[Dataset, Callable[[Any], Any] | None]]:
    """Yield the datasets of branches and special points, each with the function of one entry.

    By the first dimension of the dataset, its argument is the `Cycle` of a point, a `Special` or a
    `Track`; it is None if all entries are computed at once.
    """
    free, scene, pair = DESCRIBED[request.along.name], request.system.scene, ("multiplier", "part")
    dims: tuple[str, ...] = ("point",)
    yield Dataset.whole("branch_of_point", dims, "branch that a point belongs to"), None
    yield free.dataset(dims), lambda c: c.values[0]
    yield Dataset.real("state", (*dims, "component"), STATE_UNITS, "orbit at phase zero"), None
    yield Dataset.real("section", ("row", "component"), STATE_UNITS, "orbits at phase zero"), None
    yield Dataset.whole("periodicity", dims, "n of nT"), lambda c: c.n
    if scene.counted:
        by_wall = Dataset.whole("impacts_by_wall", (*dims, "wall"), "impacts per nT by wall")
        yield by_wall, lambda c: c.counts
    yield Dataset.text("label", dims, "n and k of nT,k"), lambda c: c.label
    words = "whether all multipliers lie inside the unit circle"
    yield Dataset.code("stable", dims, words, STABLE_FLAGS), lambda c: c.unstable == 0
    yield BY_NAME["multipliers"].dataset((*dims, *pair), scene), lambda c: _parts(c.multipliers)
    yield Dataset.real("residual", dims, "1", DEFECT), lambda c: c.defect
    if scene.is_volume_known:
        words = "error of the product of multipliers, relative"
        yield Dataset.real("determinant_error", dims, "1", words), _determinant_error
    yield BY_NAME["E1max"].dataset(dims, scene), None
    by_damper = ("damper",) * bool(scene.dampers)
    yield BY_NAME["E2max"].dataset((*dims, *by_damper), scene), None
    yield BY_NAME["clearance"].dataset(dims, scene), lambda c: c.clearance
    yield BY_NAME["softest_impact"].dataset(dims, scene), lambda c: c.slowest
    words = "largest approach speed"
    yield Dataset("fastest_impact", dims, "float64", "m/s", words, 0.0), None
    yield Dataset("largest_force", dims, "float64", "N", "largest contact force", 0.0), None

    dims = ("special",)
    yield Dataset.whole("special_branch", dims, "branch that it lies on"), None
    words = "kind of special point"
    yield Dataset.code("kind", dims, words, KIND_FLAGS), lambda s: KIND_FLAGS[s.kind]
    yield free.dataset(dims, "special_"), lambda s: s.point.cycle.values[0]
    words = "orbit at phase zero"
    yield Dataset.real("special_state", (*dims, "component"), STATE_UNITS, words), None
    yield Dataset.whole("special_index", dims, "preceding point of its branch"), lambda s: s.index
    yield Dataset.whole("special_periodicity", dims, "n of nT"), lambda s: s.point.cycle.n
    words = "orbits at phase zero"
    yield Dataset.real("special_section", ("special_row", "component"), STATE_UNITS, words), None
    yield BY_NAME["E1max"].dataset(dims, scene, prefix="special_"), None
    if scene.damper:
        yield BY_NAME["E2max"].dataset((*dims, *by_damper), scene, prefix="special_"), None
    words = "largest approach speed"
    yield Dataset("special_fastest_impact", dims, "float64", "m/s", words, 0.0), None
    words = "largest contact force"
    yield Dataset("special_largest_force", dims, "float64", "N", words, 0.0), None
    clearance = BY_NAME["clearance"].dataset(dims, scene, prefix="special_")
    yield clearance, lambda s: s.point.cycle.clearance
    softest = BY_NAME["softest_impact"].dataset(dims, scene, prefix="special_")
    yield softest, lambda s: s.point.cycle.slowest
    words = "rotation number of the torus that begins or ends, in turns per nT"
    yield Dataset.real("rotation", dims, "1", words), rotation_of
    yield Dataset.text("before", dims, "label before it along the branch"), lambda s: s.before
    yield Dataset.text("after", dims, "label after it along the branch"), lambda s: s.after
    if request.monitors:
        words = "the monitor that is zero"
        yield Dataset.text("special_monitor", dims, words), lambda s: s.monitor
    for one in request.monitors:
        if one.is_function:
            words = f"{one.name}, a function of the user"
            yield Dataset.real(one.dataset, ("point",), "1", words), None
            yield Dataset.real(f"special_{one.dataset}", dims, "1", words), None
    yield Dataset.text("special_wall", dims, "wall of a grazing impact"), lambda s: s.wall
    words = "test function there, relative"
    yield Dataset.real("special_residual", dims, "1", words), lambda s: s.residual
    yield Dataset.real("special_defect", dims, "1", DEFECT), lambda s: s.point.cycle.defect
    yield Dataset.real("bracket", dims, free.unit, "width of the last bracket"), lambda s: s.bracket
    words = "outcome of following the branch that leaves or crosses there"
    yield Dataset.code("switch", dims, words, SWITCH_FLAGS), None
    multipliers = BY_NAME["multipliers"].dataset((*dims, *pair), scene, prefix="special_")
    yield multipliers, lambda s: _parts(s.point.cycle.multipliers)

    dims = ("branch",)
    status = Dataset.code("status", dims, "whether a branch is complete", STATUS_FLAGS)
    yield status, lambda t: not INCOMPLETE.isdisjoint(t.ends)
    yield Dataset.code("origin", dims, "origin of the branch", ORIGINS), lambda t: ORIGINS[t.origin]
    yield Dataset.whole("parent", dims, "branch that it leaves, -1 if none", -1), lambda t: t.parent
    words = "special point at which it leaves that branch, -1 if none"
    yield Dataset.whole("parent_special", dims, words, -1), lambda t: t.at
    first = Dataset.code("first_end", dims, "why it ends at its first point", END_FLAGS)
    yield first, lambda t: END_FLAGS[t.ends[0]]
    last = Dataset.code("last_end", dims, "why it ends at its last point", END_FLAGS)
    yield last, lambda t: END_FLAGS[t.ends[1]]


def _of_tori(request: Continuation) -> Iterator[Dataset]:
    cells = ("torus_cell",)
    yield Dataset.whole("torus_special", cells, "special point, from 0, at which the torus begins")
    yield DESCRIBED[request.along.name].dataset(cells, "torus_")
    yield Dataset.text("torus_label", cells, "regime that is followed from the special point")


def datasets_of(request: Continuation) -> Iterator[Dataset]:
    """Yield the datasets of branches and special points, and of curves if there is a plane."""
    yield from (entry for entry, _ in _entries(request))
    if request.tori:
        yield from _of_tori(request)
    if request.plane is None:
        return
    point, curve, meeting = ("curve_point",), ("curve",), ("meeting_point",)
    yield Dataset.whole("curve_of_point", point, "curve that a point belongs to")
    for name in (item.name for item in request.free):
        yield DESCRIBED[name].dataset(point, "curve_")
        yield DESCRIBED[name].dataset(meeting, "meeting_")
    yield Dataset.real("curve_state", (*point, "component"), STATE_UNITS, "orbit at phase zero")
    pair = (*point, "multiplier", "part")
    yield Dataset.real("curve_multipliers", pair, "1", "Floquet multipliers")
    yield Dataset.whole("curve_impact_count", point, "k of nT,k")
    yield Dataset.code("curve_kind", curve, "kind of its special points", KIND_FLAGS)
    yield Dataset.whole("curve_periodicity", curve, "n of nT")
    yield Dataset.code("curve_first_end", curve, "why it ends at its first point", CURVE_END_FLAGS)
    yield Dataset.code("curve_last_end", curve, "why it ends at its last point", CURVE_END_FLAGS)
    yield Dataset.whole("curve_of_meeting", meeting, "curve that it lies on")
    yield Dataset.text("meeting", meeting, "the kinds that meet")


def scales_of(request: Continuation, tables: Tables) -> list[Scale]:
    components, scene = request.system.scene.components, request.system.scene

    def counted(name: str, like: str, text: str) -> Scale:
        return Scale.counted(name, len(tables[like]), text)

    scales = [
        counted("point", "periodicity", "point of a branch, branch after branch"),
        counted("row", "section", "section state, n for each point, point after point"),
        counted("special", "kind", "special point, branch after branch"),
        counted("special_row", "special_section", "section state of special points, n for each"),
        counted("branch", "status", "branch"),
        Scale("component", np.array(components), "1", "component of the state"),
        Scale.counted(
            "multiplier", len(components), "Floquet multiplier, the largest modulus first", 1
        ),
        Scale("part", np.array(["real", "imaginary"]), "1", "part of a complex number"),
    ]
    if request.tori:
        scales.append(counted("torus_cell", "torus_special", "cell of a scan beside an NS"))
    if scene.counted:
        scales.append(Scale("wall", np.array(scene.counted), "1", "name of the wall"))
    if scene.dampers:
        scales.append(Scale("damper", np.array(scene.dampers), "1", "name of the damper"))
    if request.plane is not None:
        scales += [
            counted("curve_point", "curve_of_point", "point of a curve, curve after curve"),
            counted("curve", "curve_kind", "curve of special points"),
            counted("meeting_point", "meeting", "point where two kinds meet"),
        ]
    return scales


def tables_of(request: Continuation, section_map: SectionMap, tracks: Sequence[Track]) -> Tables:
    """Return the arrays of the datasets of branches and special points."""
    cycles = [point.cycle for track in tracks for point in track.points]
    specials = [special for track in tracks for special in track.specials]
    size, scene = section_map.size, request.system.scene
    # the datasets that are functions of single records
    records: dict[str, Sequence[Any]] = {"point": cycles, "special": specials, "branch": tracks}
    tables: Tables = {}
    for entry, of in _entries(request):
        if of is not None:
            kind: Any = object if entry.dtype == "str" else entry.dtype
            lengths = {"multiplier": size, "part": 2, "wall": len(scene.counted)}
            shape = len(records[entry.dims[0]]), *(lengths[dim] for dim in entry.dims[1:])
            values = np.array([of(one) for one in records[entry.dims[0]]], dtype=kind)
            tables[entry.name] = values.reshape(shape)

    def placed(cycles: Sequence[Cycle]) -> tuple[np.ndarray, np.ndarray]:
        places = np.array([cycle.place for cycle in cycles]).reshape(-1, size + 1)
        return places, np.array([cycle.n for cycle in cycles], dtype=np.int64)

    # those that are computed for all points, or all special points, at once
    def sections_of(cycles: Sequence[Cycle]) -> np.ndarray:
        """Return the n sections of each orbit, orbit after orbit."""
        rows = [np.empty((0, size + 1))]
        for cycle in cycles:
            values = np.full(cycle.n, float(cycle.values[0]))
            rows.append(np.column_stack([cycle.points[:, :size], values]))
        return section_map.states_of(np.concatenate(rows))

    def measured(places: np.ndarray, periods: np.ndarray, prefix: str) -> Tables:
        extremes = section_map.measure(places, periods)
        energy, strokes = extremes.energy, extremes.strokes
        numbers = {
            f"{prefix}E1max": energy[:, 0],
            f"{prefix}fastest_impact": strokes[:, 0],
            f"{prefix}largest_force": strokes[:, 1],
        }
        if scene.damper:
            numbers[f"{prefix}E2max"] = energy[:, 1:] if scene.dampers else energy[:, 1]
        return numbers

    places, periods = placed(cycles)
    of_specials = [special.point.cycle for special in specials]
    there = placed(of_specials)
    switches = [t.switches.get(at, Switch.NONE) for t in tracks for at in range(len(t.specials))]
    numbers = np.arange(len(tracks))
    return {
        **tables,
        **measured(places, periods, ""),
        **measured(*there, "special_"),
        "branch_of_point": np.repeat(numbers, [len(t.points) for t in tracks]),
        "state": section_map.states_of(places),
        "section": sections_of(cycles),
        "switch": np.array(switches, dtype=np.int8),
        "special_branch": np.repeat(numbers, [len(t.specials) for t in tracks]),
        "special_state": section_map.states_of(there[0]),
        "special_section": sections_of(of_specials),
    }


def rotation_of(special: Special) -> float:
    """Return the rotation number of a torus where it begins, from 0 to 1/2; NaN of other kinds.

    It is |arg mu| / 2 pi for the pair of multipliers mu on the unit circle.
    """
    if special.kind != "NS":
        return math.nan
    mu, _ = torus_pair(special.point.cycle)
    real, imaginary = mu.real, abs(mu.imag)
    size, turn = math.sqrt(real * real + imaginary * imaginary), 0.25
    for _ in range(NEWTON_STEPS):  # on sin(arg mu - 2 pi turn) = 0
        cos, sin = cos_sin_of_turn(turn)
        turn += (imaginary * cos - real * sin) / (2.0 * math.pi * size)
    return float(turn)


def _parts(multipliers: np.ndarray) -> np.ndarray:  # real and imaginary
    return np.stack([multipliers.real, multipliers.imag], axis=-1)


def _determinant_error(cycle: Cycle) -> float:
    """Return the relative difference of the product of multipliers and exp(volume) = |det M|.

    exp(volume) may be 0 (an impact with e = 0, a damper that sticks); then it is not relative.
    """
    product, exact = math.prod(cycle.multipliers.tolist(), start=1.0 + 0.0j), exp(cycle.volume)
    return abs(abs(product) - exact) / (exact if exact > 0.0 else 1.0)
