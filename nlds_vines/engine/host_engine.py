"""The engine of hosts: a linear structure of any size with any number of dampers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.engine.batch import TURN, Wanted, room_for
from nlds_vines.engine.compilation import notice
from nlds_vines.engine.host_batch import HostKernels, in_cell
from nlds_vines.engine.host_loads import HostLoads
from nlds_vines.engine.host_orbits import (
    HostOrbits,
    energies_of,
    follow_host,
    largest_impulses,
    response_of,
)
from nlds_vines.engine.host_section_map import HostSectionMap
from nlds_vines.engine.load_task import LoadTask
from nlds_vines.engine.one_orbit import IntegrationError, Orbit
from nlds_vines.engine.responses import of_rows
from nlds_vines.engine.section_map import SectionMap, Variations
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.engine.starts import (
    FALLBACK_LENGTH,
    LEAST_AMPLITUDE,
    Start,
    checked_start,
    start_states,
)
from nlds_vines.errors import RequestError
from nlds_vines.kernels.cells.host_cycles import trace_host
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.parameters import PHASE
from nlds_vines.model.system import General
from nlds_vines.runs.progress import Tell


class HostEngine:
    """The engine of a host with dampers; see `engine.Engine`.

    It takes and returns states in the system's components, as users have them; `HostOrbits` turns
    them into the kernels' modal coordinates.
    """

    recognizes_cycles = False

    def __init__(self, system: General) -> None:
        self.system = system

    def runner(
        self, wanted: Wanted, tell: Tell | None = None, *, of: Sequence[str], helped: bool
    ) -> HostKernels:
        return HostKernels(self.system, wanted, tell, tuple(of))

    def begin(
        self, start: Any, method: str, settings: Settings, of: Sequence[str] = ()
    ) -> HostBeginning:
        return HostBeginning(self.system, settings, start, of=tuple(of))

    def start(self, start: Any) -> np.ndarray:
        HostOrbits(self.system).start(start)  # refuses what is inside a rigid wall
        if start is None:
            return np.array(self.system.state_at_rest)
        return checked_start(start, self.system.scene.components)

    def begin_in(
        self,
        cell: Any,
        state: np.ndarray,
        method: str,
        settings: Settings,
        of: Sequence[str] = (),
    ) -> HostBeginning:
        return HostBeginning(in_cell(self.system, cell), settings, state, True, tuple(of))

    def states(
        self,
        cells: np.ndarray,
        start: Start,
        lanes: np.ndarray,
        initial: Mapping[str, np.ndarray],
        how: tuple[str, Settings],
        tell: Tell | None = None,
    ) -> np.ndarray:
        """Return the states; NaN of an orbit that fails before its first section."""
        names = self.system.scene.components
        if start.policy == "random":
            draws = start_states(start, len(names))[lanes]
            in_cells = (HostOrbits(in_cell(self.system, cell)) for cell in cells)
            pairs = zip(in_cells, draws, strict=True)
            return np.array([orbits.random_state(draw) for orbits, draw in pairs])
        if start.state or not any(damper.spring for damper in self.system.dampers):
            states = np.tile(start.state or self.system.state_at_rest, (len(cells), 1))
        else:  # wells depend on the cell
            rests = [in_cell(self.system, cell).state_at_rest for cell in cells]
            states = np.reshape(rests, (len(cells), len(names)))
        for name in initial.keys() - {PHASE}:
            states[:, names.index(name)] = initial[name]
        begun = initial.get(PHASE, np.full(len(cells), start.phase)) / TURN
        _, settings = how
        for i in np.flatnonzero((begun > 0.0) & (begun < 1.0)):
            try:
                orbits = HostOrbits(in_cell(self.system, cells[i]), settings.stepped_to)
            except RequestError:  # the orbit fails, too
                continue
            turns = 1.0 - float(begun[i])
            period = turns * orbits.body.period
            orbits.body = orbits.body._replace(begun=float(begun[i]), turns=turns, period=period)
            state = orbits.start(states[i], is_put_on_walls=True)
            code, *_ = orbits.follow(state, Span(0, 1, 1))
            states[i] = orbits.states(state) if code == OK else np.nan
        return states

    @property
    def start_size(self) -> int:
        return len(self.system.scene.components)

    def random_states(self, cells: np.ndarray, draws: np.ndarray) -> np.ndarray:
        states = [
            [HostOrbits(in_cell(self.system, cell)).random_state(draw) for draw in draws]
            for cell in cells.ravel()
        ]
        return np.reshape(states, (*cells.shape, *draws.shape))

    def user_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        return states

    def kernel_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        return states

    def begun_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        return states

    def amplitudes(self, cell: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return the amplitudes; coordinates of the host share one, as some hardly move."""
        omega, count = float(cell["omega"][0]), len(self.system.host.inertia)
        pairs = np.hypot(states[:, ::2], states[:, 1::2] / omega)
        lengths = pairs.max(axis=0, initial=0.0)
        lengths[:count] = lengths[:count].max()
        floor = LEAST_AMPLITUDE * max(float(lengths.max()), FALLBACK_LENGTH)
        lengths = np.maximum(lengths, floor)
        return (lengths[:, np.newaxis] * np.array([1.0, omega])).ravel()

    def counts(self, by_wall: Sequence[int]) -> dict[str, int]:
        return dict(zip(self.system.scene.wall_words, by_wall, strict=True))

    def energies(self, row: np.ndarray) -> tuple[float, np.ndarray]:
        return float(row[0]), row[1 : 1 + len(self.system.dampers)].copy()

    def variations(self, start: Any) -> Variations:
        size = len(self.system.scene.components)
        orbits, norms = HostOrbits(self.system), np.zeros(size + 1)
        traced = room_for(1, size, 0, size, orbits.walls.number)
        return Variations(
            kernel=trace_host,
            arguments=(orbits.body, orbits.walls, orbits.contacts()),
            state=orbits.start(start, True),
            traced=traced,
            others=(norms,),
            norms=norms[:size],
        )

    def trace(
        self, names: tuple[str, ...], settings: Settings, lengths: Sequence[float]
    ) -> SectionMap:
        return HostSectionMap(self.system, names, settings, lengths)

    def load(self, task: LoadTask, tell: Tell | None = None) -> HostLoads:
        return HostLoads(self.system, task, tell)


class HostBeginning(NamedTuple):
    """A state from which kernels follow an orbit of a host."""

    system: General
    settings: Settings
    state: Any  # (components,) at phase zero, as of `simulate`
    is_put_on_walls: bool = False  # whether a state inside a rigid wall is put on it, or refused
    of: tuple[str, ...] = ()  # displacements whose response is recorded, if it is

    def follow(
        self,
        record: tuple[str, ...],
        transient: int,
        periods: int,
        samples: int = 1,
        *,
        quiet: bool = True,
    ) -> Orbit:
        system, has_all = self.system, "trajectory" in record
        span = Span(transient, periods, samples if has_all else 1)
        orbits = HostOrbits(system, self.settings.stepped_to)
        state = orbits.start(self.state, self.is_put_on_walls)
        rows: tuple[str, ...] = ()
        if "response" in record:
            rows = self.of or system.displacements((), record)
        records: Any = orbits.records("energy" in record, rows)
        code, section, impacts, _ = follow_host(
            orbits, state, span, notice(quiet), records, has_depths="impacts" in record
        )
        if code != OK:
            raise IntegrationError.of(system, code)
        states, results = orbits.states(section), dict[str, Any]()
        if "energy" in record:
            results["E1max"], results["E2max"] = energies_of(records, system)
        if "response" in record:
            table = response_of(orbits, records, impacts, periods * system.period).tolist()
            results["response"] = {
                f"{row}.{quantity}": value
                for row, values in zip(rows, table, strict=True)
                for quantity, value in zip(of_rows(system), values, strict=True)
            }
            impulses = largest_impulses(orbits, impacts).tolist()
            results["response"] |= {
                f"{damper.name}.impulse_max": value
                for damper, value in zip(system.dampers, impulses, strict=True)
                if not math.isnan(value)
            }
        count = span.first * span.stops + 1 + np.arange(len(states))
        return Orbit(
            system,
            orbits.states(state),
            section=states[span.stops - 1 :: span.stops] if "section" in record else None,
            impacts=orbits.table_of(impacts) if "impacts" in record else None,
            **results,
            trajectory=states if has_all else None,
            time=count * (system.period / span.stops) if has_all else None,
            transient=span.first,
        )

    def resumed(self, periods: int, section: np.ndarray) -> HostBeginning:
        return self._replace(state=section, is_put_on_walls=True)  # contacts follow from the state

    def carried(self, periods: int, cell: Any) -> HostBeginning:
        try:
            state = self.after(periods).state
        except IntegrationError:
            state = np.zeros_like(self.state)
        system = in_cell(self.system, cell)
        return self._replace(system=system, state=state, is_put_on_walls=True)

    def after(self, periods: int) -> HostBeginning:
        state = self.follow((), periods, 0).state
        return self._replace(state=state, is_put_on_walls=True)
