"""The results of a continuation: branches, special points, curves, and orbits at one value."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from nlds_vines.archives.archive import ArchivePath, read
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
"""Largest width of the last bracket, relative to the parameter, of a resolved special point."""


@dataclass(frozen=True, repr=False)
class Branch(Outlined):
    """One branch of nT orbits; arrays have an entry for each of its points, in order.

    Attributes
    ----------
    parameter : (points,) ndarray
        The free parameter [SI].
    states : (points, 4) ndarray
        x1, v1, x2, v2 [m, m/s] at phase zero; without a damper two components.
    sections : (points, n, 4) ndarray
        The states one, two, ... periods later; the last ones are `states`.
    period : int
        n of nT.
    labels : (points,) ndarray of str
        "T,1", "3T,3" ...
    impacts : (points, 2) ndarray
        Impacts per nT at the near and the far wall.
    stable : (points,) ndarray of bool
        Whether all multipliers lie inside the unit circle.
    multipliers : (points, 4) complex ndarray
        Floquet multipliers, the largest modulus first.
    E1max, E2max : (points,) ndarray
        Largest energies [J]; E2max is NaN without a damper.
    residual : (points,) ndarray
        Closing error of the orbit in the energy norm, relative to the orbit.
    determinant_error : (points,) ndarray
        Relative difference of the product of the multipliers and the one that the divergence of
        the equation of motion requires: an error bar of the multipliers.
    clearance : (points,) ndarray
        Smallest distance [m] of a pass that misses a wall; inf without any.
    softest_impact, fastest_impact : (points,) ndarray
        Approach speeds [m/s].
    largest_force : (points,) ndarray
        Largest contact force [N].
    ends : (str, str)
        Reasons of its ends at the first and the last point, keys of `branch_arm.ENDS`.
    origin : str
        "start", or the special point at which it leaves another branch: "PD" or "BP".
    parent : int
        Number of that branch; -1 for "start".
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

    Attributes
    ----------
    branch : int
        Number of the branch.
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
    """

    branch: int
    label: str
    state: np.ndarray
    multipliers: np.ndarray
    unstable: int
    sections: np.ndarray

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie inside the unit circle."""
        return self.unstable == 0


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
        Reasons of its ends, keys of `special_curves.ENDS`.
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

    request: Continuation
    tables: Tables
    path: ArchivePath | None = None

    @cached_property
    def branches(self) -> tuple[Branch, ...]:
        """All branches, those of the start orbits first."""
        t, words, branches = self.tables, list(ENDS), []
        for i in range(len(t["status"])):
            rows = t["branch_of_point"] == i
            pairs, period = t["multipliers"][rows], int(t["periodicity"][rows][0])
            states = t["state"][rows]
            sections = t["section"][np.repeat(rows, t["periodicity"])]
            along = {name: t[name][rows] for name in _ALONG if name in t}
            branches.append(
                Branch(
                    parameter=t[self.request.along.name][rows],
                    states=states,
                    sections=sections.reshape(len(states), -1, states.shape[1]),
                    period=period,
                    labels=t["label"][rows],
                    impacts=np.stack([t["impacts_near"][rows], t["impacts_far"][rows]], axis=1),
                    stable=t["stable"][rows].astype(bool),
                    multipliers=pairs[..., 0] + 1j * pairs[..., 1],
                    ends=(words[int(t["first_end"][i])], words[int(t["last_end"][i])]),
                    origin=_ORIGINS[int(t["origin"][i])],
                    parent=int(t["parent"][i]),
                    **{"E2max": np.full(len(states), np.nan), **along},
                )
            )
        return tuple(branches)

    @cached_property
    def special_points(self) -> np.recarray:
        """The special points, a row each, branch after branch.

        The columns are kind (LP, PD, NS, BP, GR or LIM); value of the parameter; before and after,
        the labels along the branch; residual of the test function, relative; bracket, the width of
        the last bracket in units of the parameter, and resolved, whether that is narrow; defect,
        the closing error, relative; wall of a grazing impact; branch, its number; index, the number
        of the branch's point before it; periodicity, n of nT; state at phase zero [m, m/s];
        switch, the outcome of following the branch that leaves there.
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
                    kind=_KINDS[int(t["curve_kind"][i])],
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
        section_map, system, names = map_of(self.request), self.request.system, (along.name,)
        crossings: list[Crossing] = []
        for i, branch in enumerate(self.branches):
            cycles: list[Cycle] = []
            for _, cycle in self.cycles_at(section_map, branch, value):
                if any(is_same(section_map, cycle, other) for other in cycles):
                    continue
                cycles.append(cycle)
                state = states_of(system, names, cycle.place[np.newaxis])[0]
                places = np.column_stack([cycle.points[:, : len(state)], np.full(cycle.n, value)])
                sections = states_of(system, names, places)
                label, mu = label_of_cycle(cycle), cycle.multipliers
                crossings.append(Crossing(i, label, state, mu, cycle.unstable, sections))
        return crossings

    def cycles_at(
        self, section_map: SectionMap, branch: Branch, value: float
    ) -> Iterator[tuple[int, Cycle]]:
        """Yield the orbits of a branch at a value, each after the number of the point before.

        Between two neighboring points, a rigid impact may pass phase zero.  The orbit is therefore
        interpolated and corrected at a phase in flight.
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
            at_zero = None if cycle is None else cycle_at_zero(section_map, cycle)
            if at_zero is not None:
                yield int(i), at_zero

    def lines(self) -> Iterator[str]:
        """Yield the lines of the report."""
        yield self.request.title
        counts = (
            (len(self.branches), "branch", "es"),
            (len(self.tables["periodicity"]), "point", "s"),
            (len(self.special_points), "special point", "s"),
        )
        yield ", ".join(f"{n} {word}{plural * (n != 1)}" for n, word, plural in counts)
        names = [item.name for item in self.request.free]
        for i, branch in enumerate(self.branches):
            labels = ", ".join(dict.fromkeys(branch.labels.tolist()))
            origin = "" if branch.parent < 0 else f" from {branch.origin} of branch {branch.parent}"
            yield (
                f"branch {i}{origin}: {labels}; {names[0]} {branch.parameter.min():.6g} to "
                f"{branch.parameter.max():.6g}; {int(branch.stable.sum())} of {len(branch)} points "
                f"stable; ends: {branch.ends[0]}, {branch.ends[1]}"
            )
            for row in self.special_points[self.special_points.branch == i]:
                change = f"{row.before} -> {row.after}" if row.before != row.after else row.before
                wall = f" ({row.wall} wall{'s' * (row.wall == 'both')})" if row.wall else ""
                note = "" if row.resolved else f"; unresolved, within {row.bracket:.1g}"
                if row.switch == "failed":
                    note += "; the branch that leaves there was not found"
                yield f"  {row.kind:<3} {names[0]} = {row.value:.12g}  {change}{wall}{note}"
        for curve in self.curves:
            ranges = ", ".join(
                f"{name} {column.min():.6g} to {column.max():.6g}"
                for name, column in zip(names, curve.values.T, strict=True)
            )
            yield f"curve of {curve.kind}, {curve.period}T: {ranges}; ends: {', '.join(curve.ends)}"
            for name, first, second in curve.meetings:
                yield f"  {name:<6} {names[0]} = {first:.10g}, {names[1]} = {second:.10g}"

    def outline(self) -> Rows:
        """Return the numbers of branches, special points and curves."""
        labels = dict.fromkeys(str(label) for b in self.branches for label in b.labels)
        points = sum(len(branch) for branch in self.branches)
        yield "branches", f"{len(self.branches)}, {points} points: {', '.join(labels)}"
        names = ", ".join(f"{n} {k}" for k, n in _counted(self.special_points.kind.tolist()))
        yield "special points", names or "none"
        if self.curves:
            kinds = _counted([curve.kind for curve in self.curves])
            yield "curves", ", ".join(f"{n} of {k}" for k, n in kinds)


_MAY_BE_EMPTY = ("special", "curve_point", "curve", "meeting_point")
"""The dimensions of datasets that an archive leaves out if they are empty."""


def _counted(words: list[str]) -> list[tuple[str, int]]:
    return [(word, words.count(word)) for word in dict.fromkeys(words)]


def map_of(request: Continuation) -> SectionMap:
    return SectionMap(request.system, (request.along.name,), Settings(float(request.tolerance)))


def continued(path: str | os.PathLike[str]) -> Continued:
    """Return the results in the archive of a continuation; `RequestError` for any other file."""
    with read(path) as view:
        request = view.request(CONTINUATION, load_continuation)
        size, tables = len(request.system.scene.components), dict[str, np.ndarray]()
        shapes = {"component": size, "multiplier": size, "part": 2}
        curves = () if request.plane is None else curve_datasets(request)
        for entry in (*datasets_of(request), *curves):
            if entry.name in view:
                tables[entry.name] = view[entry.name]
            elif entry.dims[0] in _MAY_BE_EMPTY:
                kind = object if entry.dtype == "str" else entry.dtype
                tables[entry.name] = np.empty((0, *(shapes[dim] for dim in entry.dims[1:])), kind)
    return Continued(request, tables, ArchivePath.of(path))
