"""What is asked of the orbits of a system under loads in time, whichever kernels compute them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from nlds_vines.model.loads.loading import Loading

LoadOfOrbit = tuple[Loading, float]
"""The load of one orbit without its blow at t = 0, and the impulse of that blow [N s].

Orbits whose loads differ in this impulse alone share the coefficients of their loads.
"""


class LoadTask(NamedTuple):
    """The duration of orbits under loads, their start, and what is recorded."""

    duration: float  # [s]
    times: np.ndarray  # (times,) of histories [s], from 0 to the duration
    has_histories: bool  # whether histories are recorded: of one orbit
    shaken: bool  # whether the loads are accelerations of the ground
    state: tuple[float, ...]  # components at t = 0, before any blow; a system has the first of them
    settle: float  # time that the rms of x1 leaves out [s]
    tolerance: float | str | None  # of contacts
    of: tuple[str, ...]  # displacements of the system that are recorded


class LoadRunner(Protocol):
    """The kernels for orbits of a system under loads."""

    @property
    def names(self) -> frozenset[str]:
        """The names of the quantities, and of the histories if they are recorded."""

    def run(
        self, grid: Mapping[str, np.ndarray], loads: Sequence[LoadOfOrbit]
    ) -> dict[str, np.ndarray]:
        """Return the datasets (n, ...) of an orbit under each of n loads by name.

        `grid` (n,) are numbers of the system by name.  There are the quantities and histories of
        `names`, with a column for each displacement of the task or for each damper; `status` and
        the `violations` of a limit; and, with histories, the impacts as `touches` (impacts,
        columns), if kernels record them.  An orbit that failed has the fill values of its
        quantities.
        """
