"""Orbits that begin at any phase of the forcing: from there to the next section, at phase zero.

What is left of the period is a period of a grid of its own, with as many cells, shorter ones, and
its phases. The time loop knows no difference; only where an orbit begins so is this code compiled.
"""

from __future__ import annotations

import math

from .arguments import OrbitBuffers, Prepared, Span
from .cells import STABLE, cells_for, held_too_stiff, prepared_cell
from .codes import BAD_PARAMETERS, OK, TOO_STIFF
from .compiling import chosen, is_a, jit
from .fixed_step import fixed_grid_with
from .flight import cells_of, grid_with
from .linear_contact import pressed_of
from .once_rounded import rounded_once
from .orbit import bounded, on_ground, orbit_of, set_mode
from .restitution import Stuck
from .scene import LinearWall, RigidWall, allowed, damper_of, joined, structure_under
from .variations import new_state


@chosen
def part_grid(rk4, near, far, ps, damper, n, begun):
    """Return the grid of the method, of n cells in what is left of a period."""
    if rk4 is not None:
        return lambda rk4, near, far, ps, damper, n, begun: fixed_grid_with(
            ps, damper, length_of_cell(ps, n, begun), n, begun
        )
    if is_a(near, LinearWall) or is_a(far, LinearWall):
        return lambda rk4, near, far, ps, damper, n, begun: rounded_once(
            ps, damper, flight_part(ps, damper, n, begun)
        )
    return lambda rk4, near, far, ps, damper, n, begun: flight_part(ps, damper, n, begun)


@jit
def length_of_cell(ps, n, begun):
    """Return the length [s] of n cells in what is left of a period."""
    return (1.0 - begun) * (2.0 * math.pi / ps.omega) / n


@jit
def flight_part(ps, damper, n, begun):
    """Return the grid of exact flight in what is left of a period."""
    return grid_with(ps, damper, length_of_cell(ps, n, begun), n, n, begun)


@chosen
def part_held(held, ps, damper, wall, n, begun):
    """Return the motion on a wall in what is left of a period; `held`: over a whole one."""
    if is_a(wall, RigidWall):
        return lambda held, ps, damper, wall, n, begun: Stuck(
            held.ps, flight_part(held.ps, None, n, begun)
        )
    if is_a(wall, LinearWall):
        return lambda held, ps, damper, wall, n, begun: pressed_of(ps, damper, wall, begun)
    return lambda held, ps, damper, wall, n, begun: None


@jit(dissolved=True)
def part_prepared(parts, cell, ps, damper, n, begun):
    """Return a cell `Prepared` for what is left of a period of which a share has `begun`."""
    whole = prepared_cell(parts, cell, ps, damper, n, 1)
    near, far = whole.near, whole.far
    count = cells_for(parts.rk4, near, far, n, parts.period_steps, 1)
    return Prepared(
        whole.rk4, ps, damper, near, far, whole.arc,
        part_grid(parts.rk4, near, far, ps, damper, count, begun),
        whole.contact_steps, whole.scratch,
        part_held(whole.held_near, ps, damper, near, n, begun),
        part_held(whole.held_far, ps, damper, far, n, begun),
    )  # fmt: skip


@jit(dissolved=True)
def come_to_section(parts, cell, begun, state):
    """Advance `state` (SIZE,) to the next section, and return a status."""
    ps, damper = structure_under(parts.load, cell), damper_of(parts.damper, cell)
    if not allowed(parts.rk4, joined(parts.damper), parts.near, parts.far, parts.apart, cell):
        return BAD_PARAMETERS
    n = cells_of(ps, damper)
    if n < 0:
        return TOO_STIFF
    prepared = part_prepared(parts, cell, ps, damper, n, begun)
    if held_too_stiff(prepared.held_near) or held_too_stiff(prepared.held_far):
        return TOO_STIFF
    if parts.rk4 is not None and not prepared.grid.h * prepared.grid.rate <= STABLE:
        return TOO_STIFF
    noted = OrbitBuffers(None, None, None, None, None, None, None, None)
    run = orbit_of(prepared.near, prepared.far)
    on_ground(damper, state)
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
        status[lane] = come_to_section(parts, cells[lane], begun[lane], state)
        if status[lane] == OK:
            for i in range(4):
                y[i] = state[i]
