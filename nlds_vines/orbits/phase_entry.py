"""Orbits that begin at any phase of the force: their states at the next section."""

from __future__ import annotations

import numpy as np

from nlds_vines.kernels.cells import cells as part_period
from nlds_vines.kernels.scene.codes import BAD_PARAMETERS, OK, TOO_STIFF
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.batch import on_threads, records_of
from nlds_vines.orbits.compilation import Compilation, Needed
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.runs.progress import Tell

TURN = 6.283185307179586
"""2 pi."""

_LEAST = 16  # orbits of a piece that a thread takes


class Entries:
    """Lets orbits of one scene begin at a phase."""

    def __init__(
        self, scene: Scene, method: str, settings: Settings, tell: Tell | None = None
    ) -> None:
        """Prepare the parts of a scene; `tell` takes what is waited for."""
        self._parts = parts_of(method, scene, settings)
        self._compilation = Compilation(Needed(scene.key, method, ()), tell, helped=False)

    def at_section(self, cells: np.ndarray, starts: np.ndarray, phases: np.ndarray) -> np.ndarray:
        """Return the states (n, 4) of orbits at the next section.

        Arguments: the `cells` (n,) and `starts` (n, 4), x1, v1, r, s, of orbits; the `phases` (n,)
        [rad] of the force there, from 0 to 2 pi: at either end they are at a section.

        An orbit that does not come so far has NaN there, and then counts as one that diverges;
        parameters that cannot be computed are left to what follows.
        """
        states, status = np.array(starts, float), np.zeros(len(cells), np.int64)
        begun = np.array(phases, float) / TURN
        with self._compilation.followed({part_period.enter: "entry"}):
            arguments = self._parts, records_of(cells), begun, states, status
            on_threads(part_period.enter, arguments, len(cells), _LEAST)
        states[~np.isin(status, (OK, BAD_PARAMETERS, TOO_STIFF))] = np.nan
        return states
