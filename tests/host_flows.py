"""The flow of a host from section to section, with its derivative, called from Python."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nlds_vines.engine.host_orbits import HostOrbits
from nlds_vines.kernels.hosts.host_contact import Impacts
from nlds_vines.kernels.hosts.host_orbit import (
    advance_host,
    host_flow,
    new_host_state,
    place_host_state,
    run_on_host,
)
from nlds_vines.kernels.numerics.compiling import jit
from nlds_vines.kernels.scene.codes import OK


@jit(entry=True)
def follow_flow(body, walls, contacts, impacts, y, sections, tangent, counts):
    """Fill sections, the tangent and counts over periods; without a tangent in two runs.

    Returns (status, state, tr A, logarithm of the factor by which contacts have changed volumes,
    smallest clearance [m], smallest approach speed [m/s]).
    """
    flow, status = host_flow(body, walls, contacts, impacts, 1)
    state, first = new_host_state(flow), len(sections) // 2
    place_host_state(flow, y, state)
    if len(tangent) == 0:
        status = run_on_host(flow, sections, first, state)
        status = max(run_on_host(flow, sections[first:], len(sections) - first, state), status)
    for p in range(len(sections) if len(tangent) > 0 else 0):
        if status == OK:
            status = advance_host(flow, sections[p : p + 1], 1, tangent, state)
            counts += flow.by_period[0]
    return status, state, flow.trace, flow.shrunk[0], flow.clearance[0], flow.slowest[0]


class Mapped(NamedTuple):
    """Some periods of a host's orbit; y = (X, V) in the coordinates of its modes."""

    sections: np.ndarray  # (periods, N)
    state: np.ndarray
    trace: float  # tr A
    shrunk: float  # logarithm of the factor by which contacts have changed volumes
    matrix: np.ndarray  # (N, N) the derivative of the last section by y
    counts: np.ndarray  # impacts by wall
    clearance: float
    slowest: float


class HostMap:
    """The flow of a host."""

    def __init__(self, system, tolerance=1e-13):
        self.orbits = HostOrbits(system, tolerance)
        self.size = 2 * self.orbits.size

    def __call__(self, y, periods, varied=True):
        N, walls = self.size, self.orbits.walls.number
        sections, tangent = np.zeros((periods, N)), np.eye(N).ravel() if varied else np.zeros(0)
        counts = np.zeros(walls, np.int64)
        filled, one = np.zeros(1, np.int64), np.full(1, np.inf)
        impacts = Impacts(
            np.zeros(0), filled, 0, np.zeros(walls, np.int64), one, np.zeros(walls), False,
            np.zeros(1),
        )  # fmt: skip
        status, state, trace, shrunk, clearance, slowest = follow_flow(
            self.orbits.body, self.orbits.walls, self.orbits.contacts(), impacts, y.copy(),
            sections, tangent, counts,
        )  # fmt: skip
        assert status == OK
        matrix = tangent.reshape(-1, N).T
        return Mapped(sections, state, trace, shrunk, matrix, counts, clearance, slowest)

    def scales(self, sections):
        """Return the largest displacement and the largest rate, for each component."""
        parts = np.abs(sections).reshape(len(sections), 2, -1).max(axis=(0, 2))
        return np.repeat(parts, self.size // 2)

    def difference(self, y, periods, direction, share=1e-6):
        """Return the derivative along a direction by central differences of two lengths."""

        def slope(h):
            ends = [self(y + s * h * direction, periods, False).sections[-1] for s in (1, -1)]
            return (ends[0] - ends[1]) / (2 * h)

        return (4 * slope(share / 2) - slope(share)) / 3
