"""An nT orbit of a host as a point of a branch."""

from __future__ import annotations

from ..hosts.host_orbit import host_flow, new_host_state, no_impacts
from ..numerics.compiling import jit
from ..orbit.variations import norm, state_for
from ..scene.codes import OK
from .cycles import LOG_DETERMINANT, follow_cycle


@jit(entry=True)
def trace_host(body, walls, contacts, y, traced, norms):
    """Follow an orbit from y (2 size,) for as many periods as `Traced` has points; return a status.

    Fills `traced` but for the slopes, and norms (2 size + 1,): those of unit states, then the wall
    of the smallest near miss.
    """
    flow, status = host_flow(body, walls, contacts, no_impacts(walls), 1)
    if status != OK:
        return status
    status = follow_cycle(flow, y, traced, state_for(flow))
    duration = len(traced.points) * flow.period
    traced.numbers[LOG_DETERMINANT] = flow.trace * duration + flow.shrunk[0]
    unit, size = new_host_state(flow), flow.space.size
    for i in range(size):
        unit[i] = 1.0
        norms[i] = norm(flow.space, unit)
        unit[i] = 0.0
    norms[size] = flow.clearance[1]
    return status
