"""The engine of a system: what tasks ask of the kernels, whichever kernels there are.

`engine_for` alone knows which kernels compute a system.  Tasks, pictures and pages ask an `Engine`,
and never what a system is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from nlds_vines.engine.batch import Outputs, Wanted
from nlds_vines.engine.host_engine import HostEngine
from nlds_vines.engine.kind_engine import KindEngine
from nlds_vines.engine.load_task import LoadRunner, LoadTask
from nlds_vines.engine.one_orbit import Orbit
from nlds_vines.engine.section_map import SectionMap, Variations
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.engine.starts import Start
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.catalog import without_hosts
from nlds_vines.model.system import General, System
from nlds_vines.runs.progress import Tell


class Beginning(Protocol):
    """A state at phase zero from which one orbit is followed."""

    @property
    def system(self) -> Any:
        """The system of the orbit."""

    def follow(
        self,
        record: tuple[str, ...],
        transient: int,
        periods: int,
        samples: int = 1,
        *,
        quiet: bool = True,
    ) -> Orbit:
        """Integrate the orbit as `simulate` does; raise `IntegrationError` if that fails."""

    def after(self, periods: int) -> Beginning:
        """Return the beginning at the state after so many periods."""

    def resumed(self, periods: int, section: np.ndarray) -> Beginning:
        """Return the beginning after so many periods, where the orbit has a known `section`."""

    def carried(self, periods: int, cell: Any) -> Beginning:
        """Return the beginning in the next cell of a sweep, at rest if the orbit fails."""


class Runner(Protocol):
    """The kernels for many orbits of a system with the same records."""

    @property
    def records(self) -> bool:
        """Whether the kernels record anything but a status."""

    def run(self, sweeps: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outputs:
        """Run sweeps (sweeps, cells), each cell from where the orbit before it ended."""

    def verdicts(self, outputs: Outputs, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return the datasets of the verdicts on `cells` (sweeps, cells) by name."""

    def responses(self, outputs: Outputs, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return the datasets of the response by name; none if it is not recorded."""

    def states(
        self, sweeps: np.ndarray, starts: np.ndarray, span: Span
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return states (sweeps, cells, periods stops, components) and status, without a verdict.

        `span` has `stops` equidistant states per period.  The section must be the only record.
        """

    def sections(self, sweeps: np.ndarray, starts: np.ndarray, periods: int) -> np.ndarray:
        """Return the section (sweeps, cells, periods, components) without a verdict."""


class Engine(Protocol):
    """The kernels of one system, behind the verbs of tasks.

    Cells are records of `system.cells`.  States of kernels are rows of `states`; their numbers
    have a meaning for the engine alone, and `user_states` has the components of the system.
    """

    system: Any
    recognizes_cycles: bool  # whether an orbit can be ended at a known cycle

    def runner(
        self, wanted: Wanted, tell: Tell | None = None, *, of: Sequence[str], helped: bool
    ) -> Runner:
        """Return the kernels for many orbits; `of` are the displacements of a response."""

    def start(self, start: Any) -> np.ndarray:
        """Return the state (n,) of the kernels at a `start` in components, validated."""

    def begin(self, start: Any, method: str, settings: Settings, of: Sequence[str]) -> Beginning:
        """Return where the orbit of a `start` in components begins, validated."""

    def begin_in(
        self, cell: Any, state: np.ndarray, method: str, settings: Settings, of: Sequence[str]
    ) -> Beginning:
        """Return where the orbit of a cell of a scan begins, at a state of the kernels."""

    def states(
        self,
        cells: np.ndarray,
        start: Start,
        lanes: np.ndarray,
        initial: Mapping[str, np.ndarray],
        how: tuple[str, Settings],
        tell: Tell | None = None,
    ) -> np.ndarray:
        """Return the states (n, ...) of the kernels in `cells` (n,), at the first section.

        `lanes` (n,) are the numbers of the starts in their cells.  `initial` are components of the
        state and the phase that axes set, (n,) each; an orbit that begins at another phase is
        followed to the next section by the method and the settings `how`.
        """

    @property
    def start_size(self) -> int:
        """The number of random numbers from [-1, 1) that make one start."""

    def random_states(self, cells: np.ndarray, draws: np.ndarray) -> np.ndarray:
        """Return states (..., draws, components) in the cells (...), of draws from [-1, 1)."""

    def user_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return states of the kernels (..., n) of `cells` (...) in components."""

    def kernel_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return states (n, components) of `cells` (n,) as kernels have them."""

    def begun_states(self, cells: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return, in components, where orbits begin that kernels start in `states`.

        One that begins beyond a rigid wall is put on the wall: here, or, of a host, by its kernels.
        """

    def amplitudes(self, cell: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return the amplitudes (components,) of states (n, ...) of the kernels in a cell (1,)."""

    def counts(self, by_wall: Sequence[int]) -> dict[str, int]:
        """Return the impacts of an orbit at each wall, by `Scene.wall_words`."""

    def energies(self, row: np.ndarray) -> tuple[float, Any]:
        """Return the largest energies E1 and E2 [J] of a row of the buffer of energies."""

    def variations(self, start: Any) -> Variations:
        """Return the flow and its derivative over one forcing period, from a start."""

    def trace(
        self, names: tuple[str, ...], settings: Settings, lengths: Sequence[float]
    ) -> SectionMap:
        """Return the n-fold stroboscopic map with free parameters `names`.

        `lengths` are units of these parameters, as of their intervals.
        """

    def load(self, task: LoadTask, tell: Tell | None = None) -> LoadRunner:
        """Return the kernels for orbits under loads in time."""


def engine_for(system: System) -> Engine:
    """Return the engine that computes the orbits of a system."""
    if isinstance(system, General):
        return HostEngine(system)
    return KindEngine(without_hosts(system))
