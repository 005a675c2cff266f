"""Orbits that begin at any phase of the forcing: from there to the next section, at phase zero.

What is left of the period, or another share of it, is a period of a grid of its own, with as many
cells, shorter ones, and its phases. The time loop knows no difference; only where an orbit begins
so is this code compiled.
"""

from __future__ import annotations

from ..motion.flight import Begun
from ..numerics.compiling import jit
from ..orbit.orbit import bounded, on_ground, run, set_mode
from ..orbit.variations import new_state
from ..scene.arguments import OrbitBuffers, Span
from ..scene.codes import OK
from .cells import checked_cell


@jit
def come_along(parts, cell, begun, state):
    """Advance `state` (SIZE,) over the share of a period that is a `Begun`; return a status."""
    status, prepared = checked_cell(parts, cell, 1, begun)
    if status != OK:
        return status
    noted = OrbitBuffers(None, None, None, None, None, None, None, None, None)
    on_ground(prepared.damper, state)
    set_mode(prepared.near, prepared.far, state)
    return run(prepared, noted, Span(0, 1, 1), state, None, None)


@jit(entry=True)
def enter(begin, end, parts, cells, begun, starts, status):
    """Advance starts `begin` to `end` - 1 from their phase to the next section.

    cells (n,); begun (n,): the share of the forcing's period before the start, 0 or 1 where it is
    at a section already. starts (n, 4), x1, v1, r, s, become those at phase zero; status (n,) takes
    those of `codes`. What fails is left as it is.
    """
    for lane in range(begin, end):
        status[lane] = OK
        y = starts[lane]
        if not (0.0 < begun[lane] < 1.0 and bounded(y[0], y[1], y[2], y[3])):
            continue
        state = new_state()
        for i in range(4):
            state[i] = y[i]
        left = Begun(begun[lane], 1.0 - begun[lane])
        status[lane] = come_along(parts, cells[lane], left, state)
        if status[lane] == OK:
            for i in range(4):
                y[i] = state[i]


@jit(entry=True)
def come_on(parts, cell, phase, share, y):
    """Advance y (4,), x1, v1, r, s, from a phase over a share of a period; return a status.

    cell (1,); phase: the share of the forcing's period before it.
    """
    state = new_state()
    for i in range(4):
        state[i] = y[i]
    status = come_along(parts, cell[0], Begun(phase, share), state)
    for i in range(4):
        y[i] = state[i]
    return status
