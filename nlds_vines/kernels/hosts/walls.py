"""The walls of a host with their contact laws, and the state and the forces of contacts.

Walls of all laws stand in the same rows; a law is a number that chooses the law's kernels, so that
one compilation serves all hosts.

A compliant wall pushes with its law's force. A force that would attract is switched off where its
margin m0 + mq q + ms s falls through zero, until it rises again: 1 + a s under Hunt and Crossley's
damping, kc q + cc s of a spring with a dashpot, 1 of all others. A rigid wall that holds a damper
pushes with the force that keeps s = 0.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..events.contact import FAINT
from ..numerics.compiling import jit
from ..numerics.deciding import says
from ..numerics.fours import from_place
from ..numerics.matrices import solve
from ..scene.law import (
    AT_Q,
    AT_S,
    COLUMNS,
    DEPTH,
    DRAG,
    ELASTIC,
    SCRATCH,
    SERIES,
    STEEP,
    STIFF,
    WEIGHT,
    contact_terms,
    damped_term,
    depth_of,
    drag_term,
    faint,
    force_of,
    made,
    pressed,
    rate_of_q,
    reach_of,
    root_of,
    steep_term,
    turn_of,
    weight_of,
)
from .body import accelerate, along, push_link


class Walls(NamedTuple):
    """The walls of all links; each array is one row, in inner kernels a bare row."""

    number: int
    links: Any  # (number,) the link whose r a wall limits
    signs: Any  # (number,) 1.0: r <= gap; -1.0: -r <= gap
    gaps: Any  # (number,) [m]
    inverse: Any  # (number,) 1 / mu of the bodies [1/kg]
    laws: Any  # `Laws`
    law: Any  # (number,) IS_HERTZ ...
    constants: Any  # (number,) records with the constants of laws
    margins: Any  # 3 numbers of each: m0, mq and ms of its margin


class Laws(NamedTuple):
    """A wall of each compliant law, of which only the type matters."""

    hertz: Any  # without damping
    power: Any  # with damping, of Hertz' law, too; it may be 0
    linear: Any


IS_HERTZ, IS_POWER, IS_SPRING, IS_PULLING, IS_RIGID = range(5)  # IS_PULLING: a joint may pull


class Contacts(NamedTuple):
    """The walls in contact, their series and scratch; arrays as in `Walls`."""

    active: Any  # (walls + 1,) number of walls in contact, and which
    q: Any  # (walls,)
    pushes: Any  # (walls,) 1 where the force acts, 0 where it is switched off
    rows: Any  # (walls,) of the impact under way in `Impacts`, -1 if it is not recorded
    scratch: Any  # SCRATCH numbers of each wall (`law`)
    series: Any  # (HIGHEST + 1) powers of the motion's columns, one after the other
    scales: Any  # (SCALES walls,) of a step
    unit: Any  # (1,) of theta in the series
    end: Any  # (2 size,) the state at the end of a step
    forces: Any  # (walls,) of rigid walls [N]
    matrix: Any  # (walls, walls + 1) scratch for them
    rebounds: Any  # (walls,) e of walls that are being struck, otherwise 0
    tolerance: float
    arc: Any  # `impact.Arc`


# Places of a wall in `scales`: a speed and a q of its impact, 1 / p of z = q^p; at the end of a
# step dt/dtheta and dq/dtheta of its own
FAST, ROOT, OWN_SHARE, OWN_WEIGHT, OWN_RATE = range(5)
SCALES = 5


@jit
def scratch_of(contacts, wall):
    return from_place(contacts.scratch, SCRATCH * wall)


class Reduced(NamedTuple):
    """The bodies of a wall, as `law.made` takes them."""

    inv_mu: float  # 1 / mu [1/kg]


@jit
def wall_of(sort, walls, wall):
    return made(sort, walls.gaps[wall], Reduced(walls.inverse[wall]), walls.constants[wall])


# ---- kernels for a wall of one law ---------------------------------------------------------------


@jit
def fill_wall(wall, k, n):
    """Fill coefficient n of a wall's terms; return (coefficient of its force, 1 / p of z = q^p)."""
    row = SERIES + COLUMNS * n
    if says(wall, "LINEAR"):
        k[row + DEPTH], k[row + WEIGHT] = k[row + AT_Q], (1.0 if n == 0 else 0.0)
        return wall.kc * k[row + AT_Q] + wall.cc * k[row + AT_S], 1.0
    contact_terms(wall, k, n)
    return wall.K * damped_term(wall, k, int(ELASTIC), n), rate_of_q(wall, 1.0)


@jit
def steepen_wall(wall, k, n):
    """Fill coefficient n of the derivatives of a wall's force by its depth and by its speed."""
    row = SERIES + COLUMNS * n
    if says(wall, "LINEAR"):
        k[row + STIFF], k[row + DRAG] = (wall.kc, wall.cc) if n == 0 else (0.0, 0.0)
        return
    k[row + STEEP] = steep_term(wall, k, n)
    k[row + STIFF] = damped_term(wall, k, int(STEEP), n)
    if wall.damping is None:
        k[row + DRAG] = 0.0
    else:
        k[row + DRAG] = drag_term(wall, k, n)


class Seen(NamedTuple):
    """A wall in contact at an instant."""

    weight: float  # dt/dtheta of its own
    force: float  # [N]
    rate: float  # dq/dtheta of its own
    fast: float  # the approach speed of a free impact of this energy [m/s]
    root: float  # q where it turns
    per_theta: float  # free impacts per unit of its own theta


@jit
def seen_at(wall, inverse, q, s, external, rate):
    if says(wall, "LINEAR"):
        own = math.sqrt(wall.kc * inverse)
        deep = max(q, abs(s) / own)
        quick = max(own, rate) + wall.cc * inverse
        force = wall.kc * q + wall.cc * s
        return Seen(1.0, force, s, max(own * q, abs(s)), deep, quick)
    z = depth_of(wall, q)
    reach = reach_of(wall, q, z, s)
    cube, root = turn_of(wall, reach)
    span = min(root, 2.0 * max(q, root_of(wall, abs(s) / rate)))
    swing = rate * weight_of(wall, span)
    square = wall.kappa * cube + pressed(wall, external) + swing * swing
    return Seen(
        weight_of(wall, q), force_of(wall, q, z, s), rate_of_q(wall, s), wall.speed * reach, root,
        max(math.sqrt(square) / wall.whole, swing),
    )  # fmt: skip


@jit
def begin_at(wall, external, depth):
    """Return (the depth up to which the contact's force is round-off, q at a `depth`)."""
    return faint(wall, FAINT * external / wall.kappa), root_of(wall, depth)


# ---- the same for a wall of any law --------------------------------------------------------------


@jit
def fill(walls, wall, k, n):
    laws, law, result = walls.laws, walls.law[wall], (0.0, 0.0)
    if law == IS_HERTZ:
        result = fill_wall(wall_of(laws.hertz, walls, wall), k, n)
    if law == IS_POWER:
        result = fill_wall(wall_of(laws.power, walls, wall), k, n)
    if law in (IS_SPRING, IS_PULLING):
        result = fill_wall(wall_of(laws.linear, walls, wall), k, n)
    return result


@jit
def steepen(walls, wall, k, n):
    laws, law = walls.laws, walls.law[wall]
    if law == IS_HERTZ:
        steepen_wall(wall_of(laws.hertz, walls, wall), k, n)
    if law == IS_POWER:
        steepen_wall(wall_of(laws.power, walls, wall), k, n)
    if law in (IS_SPRING, IS_PULLING):
        steepen_wall(wall_of(laws.linear, walls, wall), k, n)


@jit
def look(walls, wall, q, s, external, rate):
    laws, law, b = walls.laws, walls.law[wall], walls.inverse[wall]
    result = Seen(1.0, 0.0, 0.0, abs(s), 0.0, rate)
    if law == IS_HERTZ:
        result = seen_at(wall_of(laws.hertz, walls, wall), b, q, s, external, rate)
    if law == IS_POWER:
        result = seen_at(wall_of(laws.power, walls, wall), b, q, s, external, rate)
    if law in (IS_SPRING, IS_PULLING):
        result = seen_at(wall_of(laws.linear, walls, wall), b, q, s, external, rate)
    return result


@jit
def start_of(walls, wall, external, depth):
    laws, law, result = walls.laws, walls.law[wall], (0.0, 0.0)
    if law == IS_HERTZ:
        result = begin_at(wall_of(laws.hertz, walls, wall), external, depth)
    if law == IS_POWER:
        result = begin_at(wall_of(laws.power, walls, wall), external, depth)
    if law in (IS_SPRING, IS_PULLING):
        kappa = walls.constants[wall].kc * walls.inverse[wall]
        result = FAINT * external / kappa, depth
    return result


# ---- the forces of all walls in contact ---------------------------------------------------------


@jit
def outward_at(body, walls, wall, accelerations, at):
    """Return d2z/dt2 of a wall."""
    row, total = walls.links[wall] * body.size, 0.0
    for i in range(body.size):
        total += body.rows[row + i] * accelerations[at + i]
    return walls.signs[wall] * total


@jit
def hold(body, walls, contacts, at, out):
    """Add to the accelerations out[at : at + size] the forces of rigid walls in contact.

    They are those that keep s = 0 at each, and go to `forces`. Of velocities they are impulses;
    those of walls that are struck are (1 + `rebounds`) times as large.
    """
    active, size, matrix, count = contacts.active, body.size, contacts.matrix, 0
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] != IS_RIGID:
            continue
        sign, row, column = walls.signs[wall], walls.links[wall] * size, 0
        outward = outward_at(body, walls, wall, out, at)
        matrix[count, -1] = (1.0 + contacts.rebounds[wall]) * outward
        for d in range(active[0]):
            other = active[1 + d]
            if walls.law[other] == IS_RIGID:
                total, answer = 0.0, walls.links[other] * size
                for i in range(size):
                    total += body.rows[row + i] * body.answers[answer + i]
                matrix[count, column] = sign * walls.signs[other] * total
                column += 1
        count += 1
    if count == 0:
        return
    solve(matrix[:count, :count], matrix[:count, -1:])
    count = 0
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID:
            force = matrix[count, -1]
            contacts.forces[wall] = force
            push_link(body, walls.links[wall], walls.signs[wall] * force, out, at)
            count += 1


@jit
def push_all(body, walls, contacts, drive, y, work):
    """Write the accelerations to work[: size], with the forces of all walls in contact.

    drive: of the instant; the q are those of `contacts`, whose scales take the walls' own rates.
    """
    active, scales = contacts.active, contacts.scales
    accelerate(body, y, 0, drive[0], work, 0)
    for c in range(active[0]):
        wall = active[1 + c]
        _, s = along(body, walls.links[wall], y, 0)
        sign, at = walls.signs[wall], SCALES * wall
        seen = look(walls, wall, contacts.q[wall], sign * s, 0.0, body.omega)
        push_link(body, walls.links[wall], sign * seen.force * contacts.pushes[wall], work, 0)
        scales[at + OWN_WEIGHT], scales[at + OWN_RATE] = seen.weight, seen.rate
    hold(body, walls, contacts, 0, work)
