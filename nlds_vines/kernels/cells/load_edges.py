"""An orbit under a load at the edges of its cells: energies, bounds over a cell, contacts there."""

from __future__ import annotations

import math

from ..motion.bounds import REACH
from ..motion.load_cells import END, LOAD_ROW, OF_CELL
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.law import contact_energy, wall_like
from ..scene.scene import Ground, greatest_push, joined, moved_mass, near_constants
from ..watch.observe import RELEASE, TOUCH
from ..watch.peaks import work_at
from .load_orbit import apart_after


@jit
def energy_of(ps, x1, v1):
    """Return E1 [J]."""
    return 0.5 * (ps.m1 * v1 * v1 + ps.k1 * x1 * x1)


@jit
def structure_energy(ps, section, i):
    """Return E1 [J] at an edge."""
    return energy_of(ps, section[i, 0], section[i, 1])


@jit
def joint_energy(damper, y):
    """Return the energy [J] of the damper's motion and of its spring in a state (x1, v1, r, s)."""
    if damper is None:
        return 0.0
    v2 = y[1] - y[3]
    return 0.5 * (damper.m2 * v2 * v2 + damper.k2 * y[2] * y[2])


@jit
def held_by(wall, r):
    """Return the elastic energy [J] of the contact with a wall at r; 0 without one."""
    if wall is None:
        return 0.0
    return contact_energy(wall, max(r - wall.gap, 0.0))


@jit
def weight_energy(ps, x1):
    """Return the potential energy [J] of a constant load, 0 at x1 = 0."""
    if ps.load is None:
        return 0.0
    return -ps.m1 * ps.load * x1


@jit
def energy_stored(ps, damper, walls, section, i, by):
    """Return the energy [J] at an edge before v1 jumped by so much, with that of contacts.

    damper: of `damper_of`; walls: the near and the far one.
    """
    x1, v1, r, s = state_at(ps, joined(damper), section, i, by)
    if is_a(damper, Ground):
        r = x1
    held = held_by(walls[0], r) + held_by(walls[1], -r)
    energy = energy_of(ps, x1, v1) + joint_energy(joined(damper), (x1, v1, r, s))
    return energy + weight_energy(ps, x1) + held


@jit
def state_at(ps, damper, section, i, by):
    """Return the state (x1, v1, r, s) at an edge before v1 jumped by so much."""
    x1, v1 = section[i, 0], section[i, 1] - by
    if damper is None:
        return x1, v1, 0.0, 0.0
    s = section[i, 1] - section[i, 3]
    return x1, v1, x1 - section[i, 2] + damper.rest, s - apart_after(ps, by)


@jit
def ends_of_cell(ps, damper, load, section, i):
    """Return `work_at` both ends of a cell, before a jump at its end, and two bounds over it.

    Those of the energy of all [J], with what the load may bring, and of the fourth derivative of E1
    by the place. The energy's root S / sqrt(2) grows by the force alone, so that its derivatives
    are at most REACH times the one before and what the force's own adds (`sums_of`). In a contact
    no energy comes in.
    """
    h, at = load.edges[i + 1] - load.edges[i], OF_CELL * i
    y = state_at(ps, damper, section, i, 0.0)
    z = state_at(ps, damper, section, i + 1, load.jumps[i + 1])
    begin = work_at(ps, damper, y, load.rows[LOAD_ROW * i])
    end = work_at(ps, damper, z, load.sums[at + END])
    unit = h * math.sqrt(moved_mass(ps, damper))
    push = unit * greatest_push(ps.load, ps.force * load.sums[at])
    most = math.sqrt(2.0 * (begin[0] + joint_energy(damper, y))) + push
    first = REACH * most + push
    second = REACH * first + unit * ps.force * load.sums[at + 1]
    third = REACH * second + unit * ps.force * load.sums[at + 2]
    fourth = REACH * third + unit * ps.force * load.sums[at + 3]
    bend = most * fourth + 4.0 * first * third + 3.0 * second * second
    return begin, end, 0.5 * most * most, bend


@jit
def on_wall(near, far, damper, section, i):
    """Tell whether an orbit touches a wall at an edge, or is beyond it."""
    x1 = section[i, 0]
    r = x1 if damper is None else x1 - section[i, 2] + damper.rest
    return beyond(near, r) or beyond(far, -r)


@jit
def beyond(wall, r):
    """Tell whether r is at the limit of a wall or beyond it."""
    if wall is None:
        return False
    return r >= wall.gap


@jit
def walls_of(parts, cell, damper):
    """Return the near and the far wall."""
    near = wall_like(parts.near, cell.near, damper, near_constants(parts.apart, cell))
    return near, wall_like(parts.far, cell.far, damper, cell)


@jit
def touch_by(impacts, j, time):
    """Return the last impact that has begun by a time [s], looked for from j on; -1: none has."""
    if impacts is None:
        return -1
    while j + 1 < impacts.filled[0] and impacts.data[j + 1, TOUCH] <= time:
        j += 1
    while j >= 0 and impacts.data[j, TOUCH] > time:
        j -= 1
    return j


@jit
def touch_within(impacts, begin, end):
    """Return the time [s] of the last touch from `begin` to `end` [s], NaN where there is none."""
    if impacts is None:
        return math.nan
    j = touch_by(impacts, -1, end)
    return impacts.data[j, TOUCH] if j >= 0 and impacts.data[j, TOUCH] >= begin else math.nan


@jit
def lasts_until(impacts, j, time):
    """Tell whether impact j, if there is one, is not over before a time [s].

    The release of a contact that still lasts is NaN.
    """
    if impacts is None:
        return False
    return j >= 0 and not impacts.data[j, RELEASE] < time
