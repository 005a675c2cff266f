"""The n-fold stroboscopic map of a system with free parameters, and its derivatives."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np

from nlds_vines.archives.representation import Outlined
from nlds_vines.engine.batch import parts_of, room_for, unit_norms
from nlds_vines.engine.compilation import Compilation, Needed
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.engine.starts import user_states
from nlds_vines.kernels.cells import cells as part_period
from nlds_vines.kernels.cells import cycles
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.model.labels import name_of
from nlds_vines.model.parameters import DESCRIBED, PARAMETERS
from nlds_vines.model.system import System
from nlds_vines.runs.progress import Tell

# Difference step for the formulas that turn parameters into a cell's numbers, relative to the
# parameter; and the least parameter that it is relative to.
NEARBY, TINY = 2.0**-10, 1.0e-9

# Weights of the one-sided difference of order four: values at 0 to 4 steps.
WEIGHTS = (-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25)

SAME_ORBIT = 1.0e-7  # distance, relative to the orbit, below which two states are the same

# the compiled entries of a continuation
KERNELS = (
    cycles.trace, cycles.measure_cycles, cycles.solve_bordered, part_period.enter,
)  # fmt: skip


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Cycle(Outlined):
    """A state, its image after n forcing periods, and derivatives; if closed, an nT orbit."""

    state: np.ndarray  # (size,) as kernels have it: x1, v1, r, s [m, m/s], or x, v
    values: np.ndarray  # (m,) free parameters
    points: np.ndarray  # (n, size or more) sections, the last one the image of `state`
    counts: tuple[int, ...]  # impacts by wall, the near one before the far one
    matrix: np.ndarray  # (size, size) monodromy matrix M
    slopes: np.ndarray  # (m, size) derivatives of the image with respect to the free parameters
    multipliers: np.ndarray  # (size,) complex eigenvalues of M, the largest modulus first
    defect: float  # energy norm of the residual, relative to that of the orbit
    span: float  # energy norm of the orbit
    clearance: float  # smallest gap of a pass that misses a wall [m]; inf if there is none
    slowest: float  # smallest approach speed of an impact [m/s]; inf if there is none
    volume: float  # ln |det M| from the divergence of the equation of motion and the impact laws
    norms: np.ndarray  # (size,) energy norms of unit states
    shares: tuple[int, ...] = ()  # impacts by damper, of several dampers
    nearest: int = 0  # the wall of the clearance, of a host
    since: float = 0.0  # phase of `state` and `points` [periods] after a section at phase zero

    @property
    def n(self) -> int:
        return len(self.points)

    @property
    def label(self) -> str:
        return name_of(self.n, sum(self.counts), *self.shares)

    @property
    def place(self) -> np.ndarray:
        """The state followed by the free parameters (size + m,)."""
        return np.concatenate([self.state, self.values])

    @property
    def residual(self) -> np.ndarray:
        """The image minus the state (size,)."""
        return self.points[-1, : self.state.size] - self.state

    @property
    def closing(self) -> np.ndarray:  # M - I
        return shifted(self.matrix, -1.0)

    @property
    def unstable(self) -> int:  # the number of multipliers outside the unit circle
        return sum(abs(mu) > 1.0 for mu in self.multipliers.tolist())


class Variations(NamedTuple):
    """What follows an orbit and its variations from section to section."""

    kernel: Any  # the compiled function
    arguments: tuple[Any, ...]  # before the state
    state: np.ndarray  # where the orbit begins
    traced: cycles.Traced  # the results of a period
    others: tuple[Any, ...]  # arguments behind these results
    norms: np.ndarray  # (components,) energy norms of unit states

    def step(self, state: np.ndarray) -> int:
        """Follow a period from a state and return the status; `traced` has the results."""
        status: int = self.kernel(*self.arguments, state, self.traced, *self.others)
        return status


class SectionMap:
    """The n-fold stroboscopic map, of which nT orbits are fixed points."""

    system: Any  # a `System`; a `General` in a `HostSectionMap`
    scene: Any

    def __init__(
        self, system: System, names: tuple[str, ...], settings: Settings | None = None
    ) -> None:
        self.system, self.names = system.with_axes(names), names
        self.scene = self.system.scene
        self.size = len(self.scene.components)
        self.since = 0.0
        self.of_gap = 2 if self.size == 4 else 0  # the component of a state that walls limit
        # If impacts are rigid, `arclength` shoots from states in flight.
        self.is_rigid = bool(self.scene.walls) and any(law.instant for law in self.scene.laws)
        self._template = np.atleast_1d(self.system.cells())  # the cell record of the system itself
        self._parts = parts_of("exact", self.scene, settings)

    def shot(self, since: float) -> Self:
        """Return the map whose sections lie `since` periods after phase zero."""
        shifted = copy.copy(self)
        shifted.since = since
        return shifted

    def accepts(self, values: np.ndarray) -> bool:
        """Return True if each free parameter has an allowed value."""
        pairs = zip(self.names, values, strict=True)
        return all(bool(DESCRIBED[name].accepts(value)) for name, value in pairs)

    @cached_property
    def _direct(self) -> tuple[tuple[int, ...], ...] | None:
        """For each free parameter, the columns of the cell record that hold its value.

        None if any parameter enters in another way; then `System.cells` makes every record.
        """
        columns = []
        for name in self.names:
            value = self.system.parameters.get(name)
            if value is None:
                return None
            other = value * (1.0 + 2.0**-10) if value else PARAMETERS[name].low + 2.0**-10
            if not PARAMETERS[name].accepts(np.asarray(other)):
                return None
            before = self.system.cells().reshape(1).view(np.float64)
            after = self.system.cells({name: np.asarray(other)}).reshape(1).view(np.float64)
            changed = np.flatnonzero(before != after).tolist()
            if any(after[place] != other or before[place] != value for place in changed):
                return None
            columns.append(tuple(changed))
        return tuple(columns)

    def compile(self, tell: Tell | None) -> None:
        parts, size, state = self._parts, self.size, np.zeros(4)
        # invalid parameters: each kernel returns at once
        cells = np.zeros(1, self._template.dtype).view(np.recarray)
        compilation = Compilation(Needed(self.scene.key, "exact", ()), tell, helped=False)
        with compilation.followed(dict.fromkeys(KERNELS, "branches")):
            cycles.trace(parts, cells, cells, 0.0, state, room_for(1, size, 1))
            if self.is_rigid:
                none, status = np.zeros((0, 4)), np.zeros(0, np.int64)
                part_period.enter(0, 0, parts, cells, none[:, :2].copy(), none, status)
            self.measure(np.zeros((0, size + len(self.names))), np.zeros(0, np.int64))
            bordered(np.eye(size), np.zeros((1, size)), np.ones((1, size + 1)), np.zeros(size + 1))

    def cells(self, points: np.ndarray) -> np.recarray:
        """Return the cell records for values (count, m) of the free parameters."""
        if self._direct is None:
            grid = {name: points[:, i] for i, name in enumerate(self.names)}
            return self.system.cells(grid).view(np.recarray)
        cells = np.repeat(self._template, len(points))
        numbers = cells.view(np.float64).reshape(len(points), cells.dtype.itemsize // 8)
        for i, columns in enumerate(self._direct):
            numbers[:, columns] = points[:, i : i + 1]
        return cells.view(np.recarray)

    def _changes(self, values: np.ndarray) -> np.recarray:
        """Return the derivatives (m,) of a cell record with respect to the free parameters."""
        if self._direct is not None:  # each parameter is itself the value of its columns
            derivatives = np.zeros(len(values), self._template.dtype)
            entries = derivatives.view(np.float64).reshape(len(values), -1)
            for i, columns in enumerate(self._direct):
                entries[i, columns] = 1.0
            return derivatives.view(np.recarray)
        # formulas are differentiated by one-sided differences of order four, on an allowed side
        steps = []
        points = np.repeat(values[np.newaxis], 5 * len(values), axis=0)
        for i, (name, value) in enumerate(zip(self.names, values.tolist(), strict=True)):
            least = max(1.0e-3 * abs(self.system.parameters.get(name, 1.0)), TINY)
            step = NEARBY * max(abs(value), least)
            steps.append(step if value + 4.0 * step <= PARAMETERS[name].high else -step)
            points[5 * i : 5 * i + 5, i] += np.arange(5) * steps[i]
        numbers = self.cells(points).view(np.float64).reshape(len(values), 5, -1)
        rows = np.zeros((len(values), numbers.shape[2]))
        for i, step in enumerate(steps):
            for weight, row in zip(WEIGHTS, numbers[i], strict=True):
                rows[i] += weight / step * row
        return rows.view(self._template.dtype)[:, 0].view(np.recarray)

    def at(self, place: np.ndarray, n: int) -> Cycle | None:
        """Return the map of n periods at a place (size + m,), if it is allowed and integrable."""
        size, values = self.size, place[self.size :]
        if not self.accepts(values):
            return None
        y = np.zeros(4)
        y[:size] = place[:size]
        traced = room_for(n, size, len(values))
        cell, changes = self.cells(values[np.newaxis]), self._changes(values)
        if cycles.trace(self._parts, cell, changes, self.since % 1.0, y, traced) != OK:
            return None
        defect, span, clearance, slowest, volume = traced.numbers.tolist()
        pairs, counts, norms = traced.multipliers, traced.counts, unit_norms(cell[0], size)
        if size == 4:  # a spring without stiffness has no energy
            norms[2] = max(norms[2], norms[3] * float(cell[0].omega))
        return Cycle(
            state=y[:size].copy(), values=values.copy(), points=traced.points,
            counts=(int(counts[0]), int(counts[1])), matrix=traced.matrix,
            slopes=traced.slopes[:, :size],
            multipliers=pairs[:, 0] + 1j * pairs[:, 1], defect=defect, span=span,
            clearance=clearance, slowest=slowest, volume=volume, since=self.since,
            norms=norms,
        )  # fmt: skip

    def weights(self, cycle: Cycle, lengths: np.ndarray) -> np.ndarray:
        """Return the weights (size + m,) that make states and parameters comparable.

        The weight of a state component is the energy norm of its unit, relative to that of the
        orbit; that of a parameter is 1 / `lengths` (m,).
        """
        norms = cycle.norms / (cycle.span if cycle.span > 0.0 else 1.0)
        return np.concatenate([np.where(norms > 0.0, norms, 1.0), 1.0 / lengths])

    def later(self, place: np.ndarray, time: float) -> np.ndarray | None:
        """Return the place `time` [periods] later, on the sections of `shot(since + time)`."""
        y, now, end = np.zeros((1, 4)), self.since % 1.0, self.since % 1.0 + time
        y[0, : self.size], status = place[: self.size], np.zeros(1, np.int64)
        cell = self.cells(place[np.newaxis, self.size :])
        while now < end:
            until = min(np.floor(now) + 1.0, end)
            begun = np.array([[now % 1.0, until - now]])
            part_period.enter(0, 1, self._parts, cell, begun, y, status)
            if status[0] != OK:
                return None
            now = until
        return np.concatenate([y[0, : self.size], place[self.size :]])

    def impacts(self, place: np.ndarray, n: int) -> np.ndarray:
        """Return the impacts (count, 4) of n periods from a place at phase zero.

        Columns: wall (0 near, 1 far), touch and release [periods], approach speed [m/s].
        """
        rows = np.full((1, cycles.MOST_NOTED, 4), np.nan)
        self.measure(place[np.newaxis], np.array([n]), rows)
        impacts = rows[0][~np.isnan(rows[0, :, 0])]
        omega = float(self.cells(place[np.newaxis, self.size :])[0].omega)
        impacts[:, 1:3] *= omega / (2.0 * np.pi)
        return impacts

    def measure(
        self, places: np.ndarray, periods: np.ndarray, touches: np.ndarray | None = None
    ) -> cycles.Extremes:
        """Return the extremes of orbits from `places` (count, size + m) at phase zero."""
        count, cells = len(places), self.cells(places[:, self.size :])
        starts = np.zeros((count, 4))
        starts[:, : self.size] = places[:, : self.size]
        extremes = cycles.Extremes(
            energy=np.zeros((count, 2)), strokes=np.zeros((count, 2)),
            violation=None if self.scene.limit is None else np.zeros((count, 3)),
            touches=np.empty((count, 0, 4)) if touches is None else touches,
        )  # fmt: skip
        cycles.measure_cycles(0, count, self._parts, cells, starts, periods, extremes)
        return extremes

    def grazing_walls(self, cycle: Cycle, name: str) -> tuple[int, ...]:
        """Return the walls that graze where `slowest` or `clearance` of an orbit vanishes.

        Both, if an orbit between two walls is its own mirror image n/2 periods later; none if that
        is not known.
        """
        present = tuple(self.scene.counted.index(wall) for wall in self.scene.walls)
        if len(present) < 2 or cycle.n % 2 == 0:
            return present[:1] if len(present) < 2 else ()
        cell = self.cells(cycle.values[np.newaxis])[0]
        mirrored = -cycle.state
        mirrored[-2] += float(cell.near) - float(cell.far)  # r, or x, between the walls
        return present if self.comes_to(cycle, mirrored) else ()

    def comes_to(self, cycle: Cycle, state: np.ndarray) -> bool:
        """Return True if an orbit has a state n/2 periods later."""
        later = self.later(cycle.place, 0.5 * cycle.n)
        if later is None:
            return False
        weights = self.weights(cycle, np.ones(len(cycle.values)))[: self.size]
        return bool((np.abs(later[: self.size] - state) * weights).max() < SAME_ORBIT)

    def label_beyond(self, cycle: Cycle, walls: Sequence[int], change: int) -> str:
        """Return an orbit's label with other impacts at `walls`; at one, if they are unknown."""
        return name_of(cycle.n, sum(cycle.counts) + change * max(1, len(walls)))

    def place_of(self, value: float, state: Sequence[float]) -> np.ndarray:
        """Return the place (size + 1,) of a state in the user's coordinates at a value."""
        place = [*state, value]
        rest = self.system.with_(**{self.names[0]: value}).rest
        if rest is not None:
            place[2], place[3] = state[0] - (state[2] - rest), state[1] - state[3]
        return np.array(place)

    def states_of(self, places: np.ndarray) -> np.ndarray:
        """Return the states (count, size) in the user's coordinates at places (count, size + m)."""
        cells = self.cells(places[:, self.size :])
        return user_states(cells, places[:, : self.size], self.scene)


def bordered(
    matrix: np.ndarray, columns: np.ndarray, rows: np.ndarray, right: np.ndarray
) -> tuple[np.ndarray | None, float]:
    """Solve ((matrix, columns), (rows)) x = right, with the same bits on every processor.

    Parameters: matrix (n, n), columns (m, n), rows (m, n + m), right (n + m,).
    Returns x (n + m,), or None if the system is singular, and the determinant.
    """
    x = right[:, np.newaxis].copy()
    scratch = np.empty((len(right), len(right)))
    determinant = cycles.solve_bordered(matrix, columns, rows, x, scratch)
    return (x[:, 0] if determinant != 0.0 else None), determinant


def shifted(matrix: np.ndarray, shift: float) -> np.ndarray:
    """Return matrix + shift I."""
    result = matrix.copy()
    for i in range(len(result)):  # faster than np.fill_diagonal
        result[i, i] += shift
    return result
