"""Many orbits of hosts, as `batch` runs those of kinds: one call of the kernels for each orbit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.errors import RequestError
from nlds_vines.kernels.hosts.host_contact import OF_SPEED, OF_TOUCH, OF_WALL
from nlds_vines.kernels.orbit.repetition import TOLERANCE as RECURRENCE
from nlds_vines.kernels.orbit.repetition import impacts_of, period_of
from nlds_vines.kernels.scene.codes import BAD_PARAMETERS, DIVERGED, OK
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.host_system import HostSystem
from nlds_vines.model.parameters import PHASE
from nlds_vines.model.system import System
from nlds_vines.orbits import responses
from nlds_vines.orbits.batch import (
    COUNTED,
    METHOD,
    TURN,
    Kernels,
    Outcome,
    Outputs,
    Wanted,
    evidence_arrays,
    on_threads,
)
from nlds_vines.orbits.host_orbits import (
    HostOrbits,
    compile_host,
    energies_of,
    response_of,
    rows_of,
)
from nlds_vines.orbits.records import JUDGED
from nlds_vines.orbits.responses import OF_ROWS
from nlds_vines.orbits.solver_settings import TOLERANCE, Settings
from nlds_vines.orbits.starts import Start, random_states, start_states
from nlds_vines.runs import interrupts
from nlds_vines.runs.progress import Tell

MOST_AT_ONCE = 4  # sweeps that a thread takes at a time: one may take longer than all others


def kernels_for(
    system: System | HostSystem,
    wanted: Wanted,
    tell: Tell | None = None,
    *,
    of: tuple[str, ...] = (),
    helped: bool = True,
) -> Kernels | HostKernels:
    """Return the kernels for orbits of a kind, or of a host with its displacements `of`."""
    if isinstance(system, HostSystem):
        return HostKernels(system, wanted, tell, of)
    return Kernels(wanted, tell, helped=helped)


class HostKernels:
    """The kernels for orbits of a host whose parameters differ from cell to cell.

    Cells are records of parameters (`HostSystem.cells`), starts are in the user's coordinates.
    """

    def __init__(
        self, system: HostSystem, wanted: Wanted, tell: Tell | None = None, of: tuple[str, ...] = ()
    ) -> None:
        self._system, self._wanted, self._tell, self._of = system, wanted, tell, of
        self.records = bool(wanted.want)

    def run(self, sweeps: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outputs:
        """Run sweeps (sweeps, cells) from `starts` (sweeps, components)."""
        shape, others = (len(sweeps), sweeps.shape[1]), {*self._wanted.want} - {"response"}
        outputs = Outputs.of(replace(self._wanted, want=others), shape, 0, periods)
        if "response" in self._wanted.want:
            response = np.full((*shape, len(self._of), len(OF_ROWS)), np.nan)
            outputs = replace(outputs, buffers=outputs.buffers._replace(response=response))
        if not JUDGED.isdisjoint(others):
            length = HostOrbits(self._system).layout.impacts.stop
            outputs = replace(outputs, evidence=np.full((*shape, length), np.nan))
        has_records = not {"energy", "response"}.isdisjoint(self._wanted.want)
        compile_host(self._tell, has_records, outputs.evidence is not None)
        arguments = sweeps, starts, Span(transient, periods, 1), outputs
        on_threads(self._sweep, arguments, len(sweeps), 1, MOST_AT_ONCE)
        return outputs

    def verdicts(self, outputs: Outputs, cells: np.ndarray) -> dict[str, np.ndarray]:
        assert outputs.evidence is not None
        orbits, counts = HostOrbits(self._system), outputs.by_wall
        arguments = outputs.status, outputs.evidence, counts[..., : orbits.walls.number]
        arrays = evidence_arrays(*arguments, cells["omega"], orbits.layout)
        arrays["orbit_point"] = orbits.states(arrays["orbit_point"])
        return arrays

    def user_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return starts, which are in the user's coordinates."""
        return states

    def sections(self, sweeps: np.ndarray, starts: np.ndarray, periods: int) -> np.ndarray:
        """Return the section (sweeps, cells, periods, components) without a verdict."""
        wanted = replace(self._wanted, want=("section",))
        outputs = HostKernels(self._system, wanted, self._tell).run(sweeps, starts, 0, periods)
        section: np.ndarray = outputs.buffers.section
        return section

    def _sweep(
        self, begin: int, end: int, sweeps: np.ndarray, starts: np.ndarray, span: Span, out: Outputs
    ) -> None:
        """Run sweeps `begin` to `end` - 1; each cell begins where the orbit before it ended."""
        for sweep in range(begin, end):
            state = starts[sweep]
            for link, cell in enumerate(sweeps[sweep]):
                interrupts.check()
                place = sweep, link
                out.status[place], state = self._orbit(cell, state, span, out, place)
                if out.status[place] != OK:
                    state = np.zeros_like(state)

    def _orbit(
        self, cell: Any, start: np.ndarray, span: Span, out: Outputs, place: tuple[int, int]
    ) -> tuple[int, np.ndarray]:
        """Run an orbit and record it; return its status and its last state."""
        try:
            orbits = HostOrbits(in_cell(self._system, cell), self._wanted.settings.stepped_to)
        except RequestError:  # samples, or corners of a grid, of which each value is allowed
            return BAD_PARAMETERS, start
        if not np.isfinite(start).all():  # it failed before its first section
            return DIVERGED, start
        state = orbits.start(start, is_put_on_walls=True)
        watched = orbits.records(out.buffers.energy is not None, self._of)
        if out.evidence is None:
            code, section, impacts = orbits.follow(state, span, watched)
        else:
            effort = self._wanted.effort
            code, section, impacts, row = orbits.follow_judged(state, span, effort, watched)
            out.evidence[place] = row
        if code != OK:
            return code, start
        buffers, period = out.buffers, orbits.system.period
        if buffers.section is not None:
            buffers.section[place] = orbits.states(section)
        if watched is not None and buffers.energy is not None:
            E1, E2 = energies_of(watched, orbits.system)
            buffers.energy[place] = [E1, *(E2 if len(E2) else [0.0])]
        if watched is not None and buffers.response is not None:
            buffers.response[place] = response_of(watched, span.periods * period)
        rows = rows_of(impacts)
        walls, touches = rows[:, OF_WALL].astype(np.int64), rows[:, OF_TOUCH] / period
        if buffers.touches is not None:
            room = buffers.touches[place]
            columns = np.stack([rows[:, OF_WALL], touches, rows[:, OF_SPEED]], axis=1)
            room[: len(rows)] = columns[: len(room)]
        by_period = np.zeros((span.periods, orbits.walls.number), np.int64)
        np.add.at(
            by_period, (np.clip(touches - span.first, 0, span.periods - 1).astype(int), walls), 1
        )
        if buffers.counts is not None:
            buffers.counts[place][:-1] = by_period.sum(axis=0)
            buffers.counts[place][-1] = np.count_nonzero(by_period.sum(axis=1) == 2)
        if buffers.cycle is not None:
            n = period_of(orbits.states(section), RECURRENCE)
            by_wall = [impacts_of(by_period, wall, n) for wall in range(orbits.walls.number)]
            buffers.cycle[place] = [n, *by_wall]
        return code, orbits.states(state)


class Batch:
    """Runs the designs of a tuning of a kind or a host for an objective of `responses`."""

    def __init__(
        self,
        system: System | HostSystem,
        objective: str = "E1max",
        tolerance: float = TOLERANCE,
        tell: Tell | None = None,
    ) -> None:
        self._system = system
        row, _, self._objective = objective.rpartition(".")
        response = () if objective in responses.ENERGIES else ("response",)
        settings = Settings.of(METHOD, tolerance)
        wanted = Wanted(system.scene, ("energy", COUNTED, *response), METHOD, "quick", settings)
        of = (row,) if row else ()
        self._kernels = kernels_for(system, wanted, tell, of=of, helped=False)

    def run(self, cells: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outcome:
        """Run one orbit for each of the cells (...) from `starts` (..., components)."""
        shape, sweeps = cells.shape, np.ascontiguousarray(cells.reshape(-1, 1))
        outputs = self._kernels.run(sweeps, starts.reshape(cells.size, -1), transient, periods)
        energy, response, violation = (
            getattr(outputs.buffers, name) for name in ("energy", "response", "violation")
        )
        E2max = energy[..., 1:].max(axis=-1)  # of all dampers
        values = {"E1max": energy[..., 0], "E2max": E2max}
        if response is not None and isinstance(self._system, HostSystem):
            values |= dict(zip(OF_ROWS, np.moveaxis(response[:, :, 0], -1, 0), strict=True))
        elif response is not None:
            values |= responses.arrays_of(response, self._system.scene, sweeps)
        objective = values[self._objective]
        objective = objective if objective.ndim == 2 else objective.max(axis=-1)
        broken = np.zeros(shape) if violation is None else violation[..., 2].reshape(shape)
        rate = outputs.by_wall.sum(axis=-1).reshape(shape) / periods
        return Outcome(
            objective.reshape(shape), E2max.reshape(shape), outputs.status.reshape(shape), broken,
            rate if self._system.scene.walls else None,
        )  # fmt: skip

    def random_states(self, cells: np.ndarray, draws: np.ndarray) -> np.ndarray:
        """Return starts (..., draws, components) of the cells (...), of draws from [-1, 1)."""
        if not isinstance(self._system, HostSystem):
            return random_states(cells, draws, self._system.scene)
        states = [
            [HostOrbits(in_cell(self._system, cell)).random_state(draw) for draw in draws]
            for cell in cells.ravel()
        ]
        return np.reshape(states, (*cells.shape, *draws.shape))


def in_cell(system: HostSystem, cell: Any) -> HostSystem:
    """Return the system of a cell of `HostSystem.cells`."""
    return system.with_values(cell.dtype.names, cell.tolist())


def host_starts(
    system: Any,
    cells: np.ndarray,
    start: Start,
    lanes: np.ndarray,
    initial: Mapping[str, np.ndarray] = MappingProxyType({}),
    tolerance: float = TOLERANCE,
) -> np.ndarray:
    """Return the starts (n, components) of the orbits `lanes` (n,) in the `cells` (n,).

    `initial` are components and the phase that axes set, (n,) each.  An orbit that begins at
    another phase is followed to the next section; it is NaN if it fails before.
    """
    names = system.scene.components
    if start.policy == "random":
        draws = start_states(start, len(names))[lanes]
        in_cells = (HostOrbits(in_cell(system, cell)) for cell in cells)
        pairs = zip(in_cells, draws, strict=True)
        return np.array([orbits.random_state(draw) for orbits, draw in pairs])
    states = np.tile(np.array(start.state or np.zeros(len(names))), (len(cells), 1))
    for name in initial.keys() - {PHASE}:
        states[:, names.index(name)] = initial[name]
    begun = initial.get(PHASE, np.full(len(cells), start.phase)) / TURN
    for i in np.flatnonzero((begun > 0.0) & (begun < 1.0)):
        try:
            orbits = HostOrbits(in_cell(system, cells[i]), tolerance)
        except RequestError:  # the orbit fails, too
            continue
        turns = 1.0 - float(begun[i])
        period = turns * orbits.body.period
        orbits.body = orbits.body._replace(begun=float(begun[i]), turns=turns, period=period)
        state = orbits.start(states[i], is_put_on_walls=True)
        code, *_ = orbits.follow(state, Span(0, 1, 1))
        states[i] = orbits.states(state) if code == OK else np.nan
    return states
