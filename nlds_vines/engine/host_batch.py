"""Many orbits of hosts, as `batch` runs those of kinds: one call of the kernels for each orbit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from nlds_vines.engine import responses
from nlds_vines.engine.batch import (
    Outputs,
    Wanted,
    evidence_arrays,
    on_threads,
)
from nlds_vines.engine.host_orbits import (
    HostOrbits,
    compile_host,
    energies_of,
    largest_impulses,
    response_of,
    rows_of,
)
from nlds_vines.engine.records import JUDGED
from nlds_vines.engine.responses import of_rows
from nlds_vines.errors import RequestError
from nlds_vines.kernels.hosts.host_contact import OF_SPEED, OF_TOUCH, OF_WALL
from nlds_vines.kernels.orbit.repetition import TOLERANCE as RECURRENCE
from nlds_vines.kernels.orbit.repetition import impacts_of, period_of
from nlds_vines.kernels.scene.codes import BAD_PARAMETERS, DIVERGED, OK
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.system import General
from nlds_vines.runs import interrupts
from nlds_vines.runs.progress import Tell

MOST_AT_ONCE = 4  # sweeps that a thread takes at a time: one may take longer than all others


class HostKernels:
    """The kernels for orbits of a host whose parameters differ from cell to cell.

    Cells are records of parameters (`General.cells`), starts are in the user's coordinates.
    """

    def __init__(
        self, system: General, wanted: Wanted, tell: Tell | None = None, of: tuple[str, ...] = ()
    ) -> None:
        self._system, self._wanted, self._tell, self._of = system, wanted, tell, of
        self.records = bool(wanted.want)

    def run(self, sweeps: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outputs:
        """Run sweeps (sweeps, cells) from `starts` (sweeps, components)."""
        return self._run(sweeps, starts, Span(transient, periods, 1))

    def _run(self, sweeps: np.ndarray, starts: np.ndarray, span: Span) -> Outputs:
        shape, others = (len(sweeps), sweeps.shape[1]), {*self._wanted.want} - {"response"}
        points = span.periods * span.stops
        outputs = Outputs.of(replace(self._wanted, want=others), shape, 0, points)
        if "response" in self._wanted.want:
            count = len(of_rows(self._system))
            response = np.full((*shape, len(self._of), count), np.nan)
            buffers = outputs.buffers._replace(response=response)
            impulses = np.full((*shape, len(self._system.dampers)), np.nan)
            outputs = replace(outputs, buffers=buffers, impulses=impulses)
        if not JUDGED.isdisjoint(others):
            length = HostOrbits(self._system).layout.impacts.stop
            outputs = replace(outputs, evidence=np.full((*shape, length), np.nan))
        has_records = not {"energy", "response"}.isdisjoint(self._wanted.want)
        compile_host(self._system, self._tell, has_records, outputs.evidence is not None)
        arguments = sweeps, starts, span, outputs
        on_threads(self._sweep, arguments, len(sweeps), 1, MOST_AT_ONCE)
        return outputs

    def verdicts(self, outputs: Outputs, cells: np.ndarray) -> dict[str, np.ndarray]:
        assert outputs.evidence is not None
        orbits = HostOrbits(self._system)
        arguments = outputs.status, outputs.evidence, cells["omega"], orbits.layout
        arrays = evidence_arrays(*arguments)
        arrays["orbit_point"] = orbits.states(arrays["orbit_point"])
        return arrays

    def responses(self, outputs: Outputs, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return the datasets of the response by name.

        They are arrays (sweeps, cells, displacements), and with rigid walls `impulse_max` (sweeps,
        cells, dampers), of a single damper (sweeps, cells).
        """
        filled, scene = outputs.buffers.response, self._wanted.scene
        if filled is None:
            return {}
        arrays = {entry.name: entry.from_buffer(filled) for entry in responses.quantities_of(scene)}
        if outputs.impulses is not None and scene.with_rigid_walls:
            impulses = outputs.impulses
            arrays[responses.IMPULSE] = impulses if scene.dampers else impulses[..., 0]
        return arrays

    def states(
        self, sweeps: np.ndarray, starts: np.ndarray, span: Span
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return states (sweeps, cells, periods stops, components) and status, without a verdict.

        `span` has `stops` equidistant states per period.
        """
        wanted = replace(self._wanted, want=("section",))
        outputs = HostKernels(self._system, wanted, self._tell)._run(sweeps, starts, span)
        return outputs.buffers.section, outputs.status

    def sections(self, sweeps: np.ndarray, starts: np.ndarray, periods: int) -> np.ndarray:
        """Return the section (sweeps, cells, periods, components) without a verdict."""
        return self.states(sweeps, starts, Span(0, periods, 1))[0]

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
            buffers.response[place] = response_of(orbits, watched, impacts, span.periods * period)
        if out.impulses is not None:
            out.impulses[place] = largest_impulses(orbits, impacts)
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


def in_cell(system: General, cell: Any) -> General:
    """Return the system of a cell of `General.cells`."""
    return system.with_values(cell.dtype.names, cell.tolist())
