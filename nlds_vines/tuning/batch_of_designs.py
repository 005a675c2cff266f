"""The designs of a tuning under harmonic forces: many orbits in one call of the kernels."""

from __future__ import annotations

import numpy as np

from nlds_vines.engine import responses
from nlds_vines.engine.batch import COUNTED, METHOD, Outcome, Wanted
from nlds_vines.engine.engine import engine_for
from nlds_vines.engine.solver_settings import TOLERANCE, Settings
from nlds_vines.model.system import System
from nlds_vines.runs.progress import Tell


class Batch:
    """Runs the designs of a tuning for an objective of `responses`."""

    def __init__(
        self,
        system: System,
        objective: str = "E1max",
        tolerance: float = TOLERANCE,
        tell: Tell | None = None,
    ) -> None:
        owner, _, self._objective = objective.rpartition(".")
        words = ["energy", COUNTED]
        if objective not in responses.ENERGIES:
            words.append("response")
        wanted = Wanted(system.scene, words, METHOD, "quick", Settings.of(METHOD, tolerance))
        self._has_walls = bool(system.scene.walls)
        self._engine = engine_for(system)
        self.start_size = self._engine.start_size
        of = (owner,) if owner and self._objective != responses.IMPULSE else ()
        dampers = system.scene.dampers
        self._place = dampers.index(owner) if owner in dampers and not of else None
        self._runner = self._engine.runner(wanted, tell, of=of, helped=False)

    def run(self, cells: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outcome:
        """Run one orbit for each of the cells (...) from `starts` (..., n) of the kernels."""
        shape = cells.shape
        sweeps = np.ascontiguousarray(cells.reshape(-1, 1))
        outputs = self._runner.run(sweeps, starts.reshape(cells.size, -1), transient, periods)
        energy, violation = outputs.buffers.energy, outputs.buffers.violation
        E2max = energy[..., 1:].max(axis=-1)  # of all dampers
        values = {"E1max": energy[..., 0], "E2max": E2max}
        values |= self._runner.responses(outputs, sweeps)
        objective = values[self._objective]
        if self._place is not None:
            objective = objective[..., self._place]
        if objective.ndim > 2:  # of two walls, or of one displacement
            objective = objective.max(axis=-1)
        broken = np.zeros(shape) if violation is None else violation[..., 2].reshape(shape)
        rate = outputs.by_wall.sum(axis=-1).reshape(shape) / periods
        return Outcome(
            objective=objective.reshape(shape),
            E2max=E2max.reshape(shape),
            status=outputs.status.reshape(shape),
            violations=broken,
            impacts=rate if self._has_walls else None,
        )

    def random_states(self, cells: np.ndarray, draws: np.ndarray) -> np.ndarray:
        """Return states (..., draws, n) of the kernels in the cells (...), of draws [-1, 1)."""
        return self._engine.random_states(cells, draws)
