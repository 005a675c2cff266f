"""Many designs at once: an array of cells through the kernels, each lane an orbit of its own.

What a search needs of an orbit is how it ended and its largest energies; nothing else is computed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nlds_vines.block import RESOLUTION, method_parts
from nlds_vines.kernels import lanes
from nlds_vines.record import OK
from nlds_vines.scenes import Scene

METHOD = "exact"
"""The integrator of searches: rk4 is a cross-check, and too slow for them."""


@dataclass(frozen=True)
class Outcome:
    """How every lane ended: largest energies [J] after the transient and status, one shape all.

    `violations` counts how often the damper came where its scene forbids it, from the start on.

    Energies of a lane that failed mean nothing; `inadmissible` says which may not be looked at.
    """

    E1max: np.ndarray
    E2max: np.ndarray
    status: np.ndarray
    violations: np.ndarray

    @property
    def inadmissible(self) -> np.ndarray:
        """Lane by lane, whether a design is refused for it, whatever its energies.

        The one place that decides it: it failed, or broke the constraint of scenes b and c.
        """
        return (self.status != OK) | ~np.isfinite(self.E1max) | (self.violations > 0)


class Batch:
    """Runs batches of cells of one scene; what all batches share is prepared once."""

    def __init__(self, scene: Scene) -> None:
        """Prepare for cells of `scene`."""
        self._scene, self._parts = scene, method_parts(METHOD, scene)

    def run(self, cells: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outcome:
        """Run one lane for each cell on the current threads, all in one call of the kernel.

        Arguments: `cells` of dtype `CELL` and any shape; `starts` (x1, v1, r, s) as
        `starts.random_states` has it, of that shape + (4,), zeros for rest; the forcing periods
        discarded and sampled.
        """
        chains = np.ascontiguousarray(cells.reshape(-1, 1))
        energy = np.zeros((*chains.shape, 2))
        violation = None if self._scene.limit is None else np.zeros((*chains.shape, 3))
        status = np.zeros(chains.shape, np.int64)
        classical, damper, near, far, arc = self._parts
        lanes.run_lanes(
            classical,
            damper,
            near,
            far,
            arc,
            RESOLUTION[METHOD],
            chains.view(np.recarray),
            np.ascontiguousarray(starts.reshape(-1, 4)),
            transient,
            periods,
            None,
            None,
            None,
            energy,
            None,
            None,
            violation,
            None,
            status,
        )
        broken = np.zeros(chains.shape) if violation is None else violation[..., 2]
        shape = cells.shape
        return Outcome(
            E1max=energy[..., 0].reshape(shape),
            E2max=energy[..., 1].reshape(shape),
            status=status.reshape(shape),
            violations=broken.reshape(shape),
        )
