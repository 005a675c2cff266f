"""The engine of the kinds of systems: one structure, and one damper or none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.engine import responses, starts
from nlds_vines.engine.batch import (
    Kernels,
    Wanted,
    at_section,
    parts_of,
    room_for,
    room_for_impacts,
    start_state,
    unit_norms,
)
from nlds_vines.engine.compilation import Compilation, Needed, notice
from nlds_vines.engine.load_flight import KindLoads
from nlds_vines.engine.load_task import LoadTask
from nlds_vines.engine.one_orbit import IntegrationError, Orbit
from nlds_vines.engine.records import IMPACT, IMPACT_NUMBERS, Violation
from nlds_vines.engine.section_map import SectionMap, Variations
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.engine.starts import Start
from nlds_vines.kernels.cells import cycles
from nlds_vines.kernels.cells.cells import run_cell
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK, RESPONSE_COLUMNS
from nlds_vines.kernels.scene.scene import CellBuffers, Span
from nlds_vines.kernels.watch.observe import Impacts
from nlds_vines.model.parameters import PHASE
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import Preset
from nlds_vines.runs.interrupts import stoppable
from nlds_vines.runs.progress import Tell

# Up to so many periods (some milliseconds), kernels run in the calling thread.  Longer work runs in
# a second one, so that signals can end it; that costs more CPU time than a period.
SHORT = 1000

_RUN_CELL = getattr(run_cell, "entry", run_cell)  # the compiled entry of `run_cell`
_loaded: set[Needed] = set()  # the kernels that have run in this process


class KindEngine:
    """The engine of one structure with one damper or none; see `engine.Engine`.

    States of the kernels are rows x1, v1, r = x1 - (x2 - rest), s = v1 - v2 [m, m/s].
    """

    recognizes_cycles = True

    def __init__(self, system: Preset) -> None:
        self.system = system
        self._scene = system.scene

    def runner(
        self, wanted: Wanted, tell: Tell | None = None, *, of: Sequence[str], helped: bool
    ) -> Kernels:
        return Kernels(wanted, tell, helped=helped)

    def begin(
        self, start: Any, method: str, settings: Settings, of: Sequence[str] = ()
    ) -> Beginning:
        cell = self.system.cell
        state = start_state(self.system, cell.rest, start)
        return Beginning(self.system, method, settings, cell, state)

    def start(self, start: Any) -> np.ndarray:
        return start_state(self.system, self.system.cell.rest, start)[:4]

    def begin_in(
        self,
        cell: Any,
        state: np.ndarray,
        method: str,
        settings: Settings,
        of: Sequence[str] = (),
    ) -> Beginning:
        at_phase_zero = np.zeros(STATE_SIZE)
        at_phase_zero[: state.size] = state
        return Beginning(self.system, method, settings, cell, at_phase_zero)

    def states(
        self,
        cells: np.ndarray,
        start: Start,
        lanes: np.ndarray,
        initial: Mapping[str, np.ndarray],
        how: tuple[str, Settings],
        tell: Tell | None = None,
    ) -> np.ndarray:
        if start.policy == "random":
            draws = starts.start_states(start)[lanes]
            return starts.random_states(cells, draws[:, np.newaxis], self._scene)[:, 0]
        components = {name: values for name, values in initial.items() if name != PHASE}
        states = starts.given_states(cells, start, components, self._scene)
        if PHASE not in initial and not start.phase:
            return states
        phases = initial.get(PHASE, np.full(len(cells), start.phase))
        return at_section(self._scene, how, cells, states, phases, tell)

    @property
    def start_size(self) -> int:
        return 4

    def random_states(self, cells: np.ndarray, draws: np.ndarray) -> np.ndarray:
        return starts.random_states(cells, draws, self._scene)

    def user_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        return starts.user_states(cells, states, self._scene)

    def kernel_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        components = dict(zip(self._scene.components, states.T, strict=True))
        return starts.given_states(cells, Start(), components, self._scene)

    def begun_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        return self.user_states(cells, starts.put_on_walls(cells, states, self._scene))

    def amplitudes(self, cell: np.ndarray, states: np.ndarray) -> np.ndarray:
        size = len(self._scene.components)
        omega = float(cell["omega"][0])
        pairs = np.hypot(states[:, ::2], states[:, 1::2] / omega)  # of x1, v1 and of r, s
        lengths = pairs.max(axis=0, initial=0.0)
        of_round_off = 1e-9 * abs(float(cell["rest"][0]))
        floor = max(starts.LEAST_AMPLITUDE * float(starts.length_unit(cell)[0]), of_round_off)
        lengths = np.maximum(lengths, floor)
        return (lengths[:, np.newaxis] * np.array([1.0, omega])).ravel()[:size]

    def counts(self, by_wall: Sequence[int]) -> dict[str, int]:
        pairs = zip(self._scene.counted, by_wall, strict=True)
        return {self._scene.struck[wall]: k for wall, k in pairs if wall in self._scene.walls}

    def energies(self, row: np.ndarray) -> tuple[float, float]:
        E1, E2 = row.tolist()
        return E1, E2

    def variations(self, start: Any) -> Variations:
        system, size = self.system, len(self._scene.components)
        cell = np.atleast_1d(system.cells()).view(np.recarray)
        norms = unit_norms(cell[0], size)
        norms[norms == 0.0] = 1.0  # a spring without stiffness has no energy
        return Variations(
            kernel=cycles.trace,
            arguments=(parts_of("exact", self._scene, Settings()), cell, cell[:0], 0.0),
            state=self.start(start),
            traced=room_for(1, size, 0),
            others=(),
            norms=norms,
        )

    def trace(
        self, names: tuple[str, ...], settings: Settings, lengths: Sequence[float]
    ) -> SectionMap:
        return SectionMap(self.system, names, settings)

    def load(self, task: LoadTask, tell: Tell | None = None) -> KindLoads:
        return KindLoads(self.system, task, tell)


class Beginning(NamedTuple):
    """A state from which kernels follow an orbit, with the system and the method."""

    system: Preset
    method: str
    settings: Settings
    cell: Any  # the record of the system
    state: np.ndarray  # (STATE_SIZE,) x1, v1, r, s, q, mode ... at phase zero

    def follow(
        self,
        record: tuple[str, ...],
        transient: int,
        periods: int,
        samples: int = 1,
        *,
        quiet: bool = True,
    ) -> Orbit:
        system, scene = self.system, self.system.scene
        stops = samples if "trajectory" in record else 1
        has_states = "section" in record or "trajectory" in record
        cell = CellBuffers(
            section=np.empty((periods * stops, len(scene.components))) if has_states else None,
            impacts=room_for_impacts(16 + 4 * periods) if "impacts" in record else None,
            energy=np.zeros(2) if "energy" in record else None,
            peak=np.zeros(2) if "peak" in record else None,
            clearance=np.full(1, np.inf) if "clearance" in record else None,
            violation=None if scene.limit is None else np.zeros(3),
            response=np.full(RESPONSE_COLUMNS, np.nan) if "response" in record else None,
        )
        while True:
            state, span = self.state.copy(), Span(transient, periods, stops)
            self._run(record, cell, state, span, quiet)
            impacts = cell.impacts
            if impacts is None or impacts.filled[0] <= len(impacts.data):
                break
            # run again with enough room: the same orbit has the same number of impacts; a clearance
            # is the least so far
            cell = cell._replace(impacts=room_for_impacts(int(impacts.filled[0])))
            if cell.clearance is not None:
                cell = cell._replace(clearance=np.full(1, np.inf))

        # last state and records in the user's coordinates
        results = dict[str, Any]()
        if "trajectory" in record:
            count = transient * stops + 1 + np.arange(len(cell.section))
            results["trajectory"], results["time"] = cell.section, count * (system.period / stops)
        if "section" in record:
            results["section"] = np.ascontiguousarray(cell.section[stops - 1 :: stops])
        for name, energies in (("max", cell.energy), ("peak", cell.peak)):
            if energies is not None:
                results[f"E1{name}"] = float(energies[0])
                results[f"E2{name}"] = float(energies[1]) if scene.damper else None
        if cell.impacts is not None:
            results["impacts"] = impacts_of(cell.impacts, scene)
        if cell.clearance is not None:
            results["clearance"] = float(cell.clearance[0])
        if cell.response is not None:
            results["response"] = responses.values_of(cell.response, system)
        if cell.violation is not None:
            time, depth, number = cell.violation.tolist()
            results["violation"] = Violation(int(number), time, depth)
        x1, v1, r, s = state[:4].tolist()
        last = [x1, v1, x1 - r + self.cell.rest, v1 - s] if scene.damper else [x1, v1]
        return Orbit(system, np.array(last), **results, transient=transient)

    def resumed(self, periods: int, section: np.ndarray) -> Beginning:
        return self.after(periods)  # as a section does not tell the contacts under way

    def carried(self, periods: int, cell: Any) -> Beginning:
        state = np.zeros(STATE_SIZE)
        try:
            state[:4] = self.after(periods).state[:4]
            # the displacement is carried over; the contact follows from r and s in this cell
            state[2] += cell.rest - self.cell.rest
        except IntegrationError:
            pass
        return self._replace(cell=cell, state=state)

    def after(self, periods: int) -> Beginning:
        state, limit = self.state.copy(), self.system.scene.limit
        cell = CellBuffers(violation=None if limit is None else np.zeros(3))
        self._run((), cell, state, Span(periods, 0, 1), quiet=True)
        return self._replace(state=state)

    def _run(
        self, record: tuple[str, ...], cell: CellBuffers, state: np.ndarray, span: Span, quiet: bool
    ) -> None:
        needed = Needed(self.system.scene.key, self.method, record)
        parts = parts_of(self.method, self.system.scene, self.settings)
        arguments = parts, self.cell, state, span, cell
        if needed in _loaded and span.first + span.periods <= SHORT:
            code = run_cell(*arguments)
        else:
            code = _run_compiling(needed, quiet, arguments)
            _loaded.add(needed)
        if code != OK:
            raise IntegrationError.of(self.system, code)


@stoppable
def _run_compiling(needed: Needed, quiet: bool, arguments: tuple[Any, ...]) -> int:
    """Run a cell in another thread, so that it can be stopped, and say what is compiled."""
    with Compilation(needed, notice(quiet), helped=False).followed({_RUN_CELL: "orbit"}):
        return run_cell(*arguments)


# `IMPACT` with its numbers as one array
_ROW = np.dtype([("wall", IMPACT["wall"]), ("numbers", float, len(IMPACT_NUMBERS))])


def impacts_of(impacts: Impacts, scene: Scene) -> np.ndarray:
    """Return the impacts that kernels recorded as rows of dtype `IMPACT`."""
    rows = impacts.data[: impacts.filled[0]]
    table = np.zeros(len(rows), _ROW)
    if len(rows):
        table["wall"] = np.where(rows[:, 0] == 0, scene.struck["near"], scene.struck["far"])
        values: np.ndarray = table["numbers"]
        values[:] = rows[:, 1 : 1 + values.shape[1]]
        values[np.isnan(values[:, 1]), -2:] = np.nan  # gains are complete at the release
    return table.view(IMPACT)
