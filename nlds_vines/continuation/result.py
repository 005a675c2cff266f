"""The results of a continuation: branches, special points, and what they say of one value."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from nlds_vines.archives.archive import ArchivePath, read
from nlds_vines.archives.dataset import Dataset
from nlds_vines.archives.provenance import CONTINUATION
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.continuation.arclength import best_map, cycle_at_zero, place_at
from nlds_vines.continuation.branch_arm import ENDS, at_value
from nlds_vines.continuation.branch_table import (
    KIND_FLAGS,
    ORIGINS,
    SWITCH_FLAGS,
    Tables,
    curve_datasets,
    datasets_of,
)
from nlds_vines.continuation.exploration import is_same
from nlds_vines.continuation.request import Continuation, load_continuation
from nlds_vines.continuation.section_map import Cycle, SectionMap, place_of, states_of
from nlds_vines.continuation.special_curves import ENDS as CURVE_ENDS
from nlds_vines.continuation.special_points import label_of_cycle
from nlds_vines.errors import RequestError, number
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.plotting.drawable import Drawable
from nlds_vines.plotting.style import HUES

MARKS: dict[str, dict[str, Any]] = {
    "LP": {"marker": "o", "color": HUES["green"]},
    "PD": {"marker": "^", "color": HUES["vermillion"]},
    "NS": {"marker": "s", "color": HUES["blue"]},
    "BP": {"marker": "X", "color": HUES["black"]},
    "GR": {"marker": "D", "color": HUES["orange"]},
    "LIM": {"marker": "v", "color": HUES["pink"]},
}
"""The mark of each kind of special point in pictures."""

WORDS = {
    "LP": "fold", "PD": "period doubling", "NS": "torus", "BP": "branch point",
    "GR": "grazing", "LIM": "limit touched",
}  # fmt: skip
"""The kinds of special points in words."""

_KINDS = {code: kind for kind, code in KIND_FLAGS.items()}
_SWITCHES = {code: word for word, code in SWITCH_FLAGS.items()}
_ORIGINS = {code: word for word, code in ORIGINS.items()}
_ALONG = (
    *("E1max", "E2max", "residual", "determinant_error", "clearance"),
    *("softest_impact", "fastest_impact", "largest_force"),
)  # along a branch, by the names of datasets


RESOLVED = 1.0e-10
"""Width of the last bracket, relative to the parameter, of a special point that is resolved."""


@dataclass(frozen=True, repr=False)
class Branch(Outlined):
    """One branch of nT orbits; arrays have an entry for each of its points, in order.

    Attributes:
        parameter: the free parameter [SI].
        states: (points, components) at phase zero, in the user's coordinates [m, m/s].
        sections: (points, n, components) those one, two ... periods later; the last is `states`.
        period: n of nT.
        labels: "T,1", "3T,3" ... at each point.
        impacts: (points, 2) per nT, at the near and the far wall.
        stable: whether all multipliers lie inside the unit circle.
        multipliers: (points, components) complex, the largest modulus first.
        E1max, E2max: largest energies [J]; E2max is NaN without a damper.
        residual: what does not close, relative; determinant_error: by how much the product of the
            multipliers is not what the damping makes it, relative: an error bar of the matrix.
        clearance: nearest miss [m]; softest_impact, fastest_impact: [m/s]; largest_force: [N].
        ends: in words, why it ends at its beginning and at its end.
        origin: "start", "PD" or "BP"; parent: number of the branch that it leaves, or -1.
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

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.parameter)


@dataclass(frozen=True, repr=False)
class Crossing(Outlined):
    """The orbit of a branch at one value of the parameter.

    Attributes: number of the `branch`; its `label`; the `state` at phase zero in the user's
    coordinates; complex `multipliers`; `unstable`: how many lie outside the unit circle;
    `sections`: (n, components), the states one, two ... periods later, the last being `state`.
    """

    branch: int
    label: str
    state: np.ndarray
    multipliers: np.ndarray
    unstable: int
    sections: np.ndarray

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie inside."""
        return self.unstable == 0


@dataclass(frozen=True, repr=False)
class SpecialCurve(Outlined):
    """A curve of special points in the plane of two parameters.

    Attributes:
        kind: LP, PD, NS or GR; period: n of nT.
        values: (points, 2) both parameters; states: (points, components) at phase zero.
        multipliers: (points, components), complex.
        ends: in a word each, why it ends (`special_curves.ENDS`).
        meetings: (name, first parameter, second) where another kind is met: R1 to R4, the strong
            resonances; CP, a cusp; LP-PD, a fold-flip; GR-LP, GR-PD, GR-NS.
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
    """The branches of a continuation, and their special points.

    Attributes:
        request: with which the same is computed again.
        tables: the datasets of its archive by name.
        path: the archive; None for results that have none.
    """

    drawn_by = "nlds_vines.continuation.picture"

    request: Continuation
    tables: Tables
    path: ArchivePath | None = None

    @cached_property
    def branches(self) -> tuple[Branch, ...]:
        """All branches, those of the start orbits first."""
        t, found = self.tables, []
        for i in range(len(t["status"])):
            rows = t["branch_of_point"] == i
            pairs = t["multipliers"][rows]
            own = {name: t[name][rows] for name in _ALONG if name in t}
            found.append(
                Branch(
                    parameter=t[self.request.along.name][rows],
                    states=t["state"][rows],
                    sections=self._sections(rows),
                    period=int(t["periodicity"][rows][0]),
                    labels=t["label"][rows],
                    impacts=np.stack([t["impacts_near"][rows], t["impacts_far"][rows]], axis=1),
                    stable=t["stable"][rows].astype(bool),
                    multipliers=pairs[..., 0] + 1j * pairs[..., 1],
                    ends=self._ends(i),
                    origin=_ORIGINS[int(t["origin"][i])],
                    parent=int(t["parent"][i]),
                    **{"E2max": np.full(int(rows.sum()), np.nan), **own},
                )
            )
        return tuple(found)

    def _sections(self, rows: np.ndarray) -> np.ndarray:
        """Return the sections (points, n, components) of the points of a branch."""
        periods = self.tables["periodicity"]
        found = self.tables["section"][np.repeat(rows, periods)]
        return found.reshape(int(rows.sum()), -1, found.shape[-1])

    def _ends(self, i: int) -> tuple[str, str]:
        words = list(ENDS)
        first, last = (words[int(self.tables[name][i])] for name in ("first_end", "last_end"))
        return first, last

    @cached_property
    def special_points(self) -> np.recarray:
        """The special points, a row each, branch after branch.

        kind: LP, PD, NS, BP, GR or LIM; value: of the parameter; before, after: the labels along
        the branch; residual: the test function, relative; bracket: width of the last bracket, in
        units of the parameter; defect: what does not close, relative; wall: of an impact that
        grazes; branch: its number; index: of the branch's point before it; periodicity: n of nT;
        state: at phase zero, in the user's coordinates.
        """
        t = self.tables
        size = t["special_state"].shape[1]
        kinds = [
            ("kind", "U3"), ("value", float), ("before", "U16"), ("after", "U16"),
            ("residual", float), ("bracket", float), ("defect", float), ("wall", "U4"),
            ("branch", int), ("index", int), ("periodicity", int), ("state", float, (size,)),
            ("switch", "U8"), ("resolved", bool),
        ]  # fmt: skip
        rows = np.zeros(len(t["kind"]), kinds)
        rows["kind"] = [_KINDS[int(code)] for code in t["kind"]]
        rows["value"] = t[f"special_{self.request.along.name}"]
        rows["before"], rows["after"] = t["before"].astype(str), t["after"].astype(str)
        rows["wall"] = t["wall"].astype(str)
        for name in ("residual", "defect", "branch", "index", "periodicity", "state"):
            rows[name] = t[f"special_{name}"]
        rows["bracket"] = t["bracket"]
        rows["switch"] = [_SWITCHES[int(code)] for code in t["switch"]]
        rows["resolved"] = rows["bracket"] <= RESOLVED * np.abs(rows["value"])
        return rows.view(np.recarray)

    @cached_property
    def curves(self) -> tuple[SpecialCurve, ...]:
        """The curves of special points in the plane of two parameters; none without a second."""
        if self.request.plane is None:
            return ()
        t, names = self.tables, (self.request.along.name, self.request.plane.name)
        words, found = list(CURVE_ENDS), []
        for i in range(len(t["curve_kind"])):
            rows, met = t["curve_of_point"] == i, t["curve_of_meeting"] == i
            pairs = t["curve_multipliers"][rows]
            at = [t["meeting"][met], *(t[f"meeting_{name}"][met] for name in names)]
            found.append(
                SpecialCurve(
                    kind=_KINDS[int(t["curve_kind"][i])],
                    period=int(t["curve_periodicity"][i]),
                    values=np.stack([t[f"curve_{name}"][rows] for name in names], axis=-1),
                    states=t["curve_state"][rows],
                    multipliers=pairs[..., 0] + 1j * pairs[..., 1],
                    ends=(
                        words[int(t["curve_first_end"][i])],
                        words[int(t["curve_last_end"][i])],
                    ),
                    meetings=tuple(
                        (str(n), float(a), float(b)) for n, a, b in zip(*at, strict=True)
                    ),
                )
            )
        return tuple(found)

    def orbits_at(self, value: float) -> list[Crossing]:
        """Return the orbits of all branches at a value of the parameter, each closed by Newton.

        Raises `RequestError` for a value outside the interval.
        """
        along = self.request.along
        value = number(along.name, value)
        if not along.low <= value <= along.high:
            raise RequestError(
                f"{along.name} = {value!r}; allowed: {along.low!r} to {along.high!r}"
            )
        section_map = map_of(self.request)
        found: list[Crossing] = []
        for i, branch in enumerate(self.branches):
            cycles: list[Cycle] = []
            for _, cycle in self.cycles_at(section_map, branch, value):
                if any(is_same(section_map, cycle, other) for other in cycles):
                    continue
                cycles.append(cycle)
                state = states_of(self.request.system, (along.name,), cycle.place[np.newaxis])[0]
                label, mu = label_of_cycle(cycle), cycle.multipliers
                places = np.column_stack(
                    [cycle.points[:, : len(state)], np.full(cycle.n, float(value))]
                )
                sections = states_of(self.request.system, (along.name,), places)
                found.append(Crossing(i, label, state, mu, cycle.unstable, sections))
        return found

    def cycles_at(
        self, section_map: SectionMap, branch: Branch, value: float
    ) -> Iterator[tuple[int, Cycle]]:
        """Yield the orbits of a branch at a value, each with the number of the point before.

        The states at phase zero of two neighbors may stand on both sides of an impact of rigid
        bodies: what is between them is sought in flight.
        """
        values, name, n = branch.parameter, self.request.along.name, branch.period
        for i in np.flatnonzero((values[:-1] - value) * (values[1:] - value) <= 0.0):
            ends = [
                place_of(self.request.system, name, float(values[j]), tuple(branch.states[j]))
                for j in (i, i + 1)
            ]
            there = best_map(section_map, ends[0], n)
            a, b = (place_at(section_map, place, n, there.since) for place in ends)
            if a is None or b is None:
                continue
            step = values[i + 1] - values[i]
            share = (value - values[i]) / step if step else 0.0
            cycle = at_value(there, a + share * (b - a), n, value)
            found = None if cycle is None else cycle_at_zero(section_map, cycle)
            if found is not None:
                yield int(i), found

    def lines(self) -> Iterator[str]:
        """Yield the report, a line at a time."""
        yield self.request.title
        points = len(self.tables["periodicity"])
        counts = (len(self.branches), "branch", "es"), (points, "point", "s")
        special = (len(self.special_points), "special point", "s")
        yield ", ".join(f"{n} {word}{more * (n != 1)}" for n, word, more in (*counts, special))
        for i, branch in enumerate(self.branches):
            yield from self._branch_lines(i, branch)
        for curve in self.curves:
            yield from self._curve_lines(curve)

    def _curve_lines(self, curve: SpecialCurve) -> Iterator[str]:
        names = [item.name for item in self.request.free]
        ranges = [
            f"{name} {column.min():.6g} to {column.max():.6g}"
            for name, column in zip(names, curve.values.T, strict=True)
        ]
        ends = ", ".join(curve.ends)
        yield f"curve of {curve.kind}, {curve.period}T: {', '.join(ranges)}; ends: {ends}"
        for name, first, second in curve.meetings:
            yield f"  {name:<6} {names[0]} = {first:.10g}, {names[1]} = {second:.10g}"

    def _branch_lines(self, i: int, branch: Branch) -> Iterator[str]:
        name = self.request.along.name
        labels = ", ".join(dict.fromkeys(branch.labels.tolist()))
        origin = "" if branch.parent < 0 else f" from {branch.origin} of branch {branch.parent}"
        yield (
            f"branch {i}{origin}: {labels}; {name} {branch.parameter.min():.6g} to "
            f"{branch.parameter.max():.6g}; {int(branch.stable.sum())} of {len(branch)} points "
            f"stable; ends: {branch.ends[0]}, {branch.ends[1]}"
        )
        for row in self.special_points[self.special_points.branch == i]:
            change = f"{row.before} -> {row.after}" if row.before != row.after else row.before
            wall = f" ({row.wall} wall{'s' * (row.wall == 'both')})" if row.wall else ""
            note = "" if row.resolved else f"; unresolved, within {row.bracket:.1g}"
            if row.switch == "failed":
                note += "; the branch that leaves there was not found"
            yield f"  {row.kind:<3} {name} = {row.value:.12g}  {change}{wall}{note}"

    def heading(self) -> str:
        """Return the title."""
        return self.request.title

    def outline(self) -> Rows:
        """Return how many branches, curves and special points there are."""
        labels = dict.fromkeys(str(label) for b in self.branches for label in b.labels)
        points = sum(len(branch) for branch in self.branches)
        yield "branches", f"{len(self.branches)}, {points} points: {', '.join(labels)}"
        names = ", ".join(f"{n} {k}" for k, n in _counted(self.special_points.kind.tolist()))
        yield "special points", names or "none"
        if self.curves:
            kinds = _counted([curve.kind for curve in self.curves])
            yield "curves", ", ".join(f"{n} of {k}" for k, n in kinds)


def _counted(words: list[str]) -> list[tuple[str, int]]:
    return [(word, words.count(word)) for word in dict.fromkeys(words)]


def map_of(request: Continuation) -> SectionMap:
    """Return the section map of a continuation."""
    return SectionMap(request.system, (request.along.name,), Settings(float(request.tolerance)))


def continued(path: str | os.PathLike[str]) -> Continued:
    """Return the results of a continuation, from its archive.

    Raises `RequestError` for any other file.
    """
    with read(path) as view:
        request = view.request(CONTINUATION, load_continuation)
        names = [entry.name for entry in _datasets(request) if entry.name in view]
        tables = {name: view[name] for name in names}
    return Continued(request, with_empty(request, tables), ArchivePath.of(path))


def _datasets(request: Continuation) -> list[Dataset]:
    """Return the datasets that an archive of a continuation may hold."""
    curves = () if request.plane is None else curve_datasets(request)
    return [*datasets_of(request), *curves]


_MAY_BE_EMPTY = ("special", "curve_point", "curve", "meeting_point")


def with_empty(request: Continuation, tables: Tables) -> Tables:
    """Return tables with those, empty, that an archive leaves out: without special points."""
    size = len(request.system.scene.components)
    shapes = {"component": size, "multiplier": size, "part": 2}
    for entry in _datasets(request):
        if entry.name not in tables and entry.dims[0] in _MAY_BE_EMPTY:
            kind = object if entry.dtype == "str" else entry.dtype
            tables[entry.name] = np.empty((0, *(shapes[dim] for dim in entry.dims[1:])), kind)
    return tables
