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
from ..laws.restitution import PULL
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
    HIGHEST,
    SCRATCH,
    SERIES,
    STEEP,
    STIFF,
    WEIGHT,
    contact_terms,
    damped,
    damped_term,
    depth_of,
    drag_term,
    elastic,
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
from .springs import push_springs, spring_force


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
    pushes: Any  # (walls,) 1 where the force acts, 0 where it is switched off, or of a rigid wall 0
    rows: Any  # (walls,) of the impact under way in `Impacts`, -1 if it is not recorded
    scratch: Any  # SCRATCH numbers of each wall (`law`)
    series: Any  # (HIGHEST + 1) powers of the motion's columns, one after the other, and two more
    scales: Any  # (SCALES walls,) of a step
    unit: Any  # (1,) of theta in the series
    end: Any  # (2 size,) the state at the end of a step
    forces: Any  # (walls,) of rigid walls [N]
    matrix: Any  # (walls, walls + 1) scratch for them
    rebounds: Any  # (walls,) e of walls in an impact that rebound, otherwise 0
    compressed: Any  # (walls,) 1 of rigid walls that bring bodies to rest in an impact
    expanded: Any  # (walls,) 1 of those that bodies would enter by the rebounds of others
    joins: Any  # (walls,) the part of rigid walls in an impact: APART ...
    presses: Any  # (walls,) 1 of those that the forces press after an impact
    impulses: Any  # (walls,) of rigid walls in an impact [N s], 0 within round-off
    least: Any  # (walls,) rates of depths that are round-off [m/s or m/s^2]
    rough: Any  # (walls,) 1 where the series of the force does not hold in a step
    values: Any  # 2 (HIGHEST + 1) scratch: values at places, and coefficients
    tolerance: float
    arc: Any  # `impact.Arc`


# Places of a wall in `scales`: a speed and a q of its impact, 1 / p of z = q^p; at the end of a
# step dt/dtheta and dq/dtheta of its own
FAST, ROOT, OWN_SHARE, OWN_WEIGHT, OWN_RATE = range(5)
SCALES = 5

AT_REST = 1.0e-13  # round-off of r and s of a state that a rigid wall holds, relative to their sums
FIRM = 0.1  # least rate at which a wall begins to push, in units of that at which one lets go
MOST_PIVOTS = 10  # of `press` for each wall; a few are usual

# `joins`: walls that take no part in an impact, that held before it, that are struck, that bodies
# leave, and those of an earlier impact at the same instant
APART, HELD, STRUCK, LEFT, PASSED = range(5)
AT_PLACE = 4.0e-15  # round-off of r of bodies that are at a wall, relative to its parts
# |cosine| of the impulses of two walls up to which neither changes the other's rate, and above
# which they limit the same motion
INDEPENDENT, PARALLEL = 1.0e-12, 1.0 - 1.0e-12


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


@jit
def is_rough(walls, wall):
    """Return True if a wall's force is no whole power of q, so that it has no series at q = 0."""
    result = False
    if walls.law[wall] == IS_POWER:
        result = wall_of(walls.laws.power, walls, wall).fraction > 0.0
    return result


@jit
def slopes_of_rough(walls, wall, q, s):
    """Return the derivatives of a rough wall's force by its depth [N/m] and its speed [N s/m]."""
    one = wall_of(walls.laws.power, walls, wall)
    z = depth_of(one, q)
    if not z > 0.0:
        return 0.0, 0.0
    push = elastic(one, one.K, q, z)
    return one.exponent * push / z * damped(one, s), one.damping.a * push


# ---- polynomials of theta ------------------------------------------------------------------------

# sin^2(pi i / 28), in an order in which each is far from those before it (Leja's)
PLACES = (
    0.0,
    1.0,
    0.5,
    0.8117449009293668,
    0.18825509907063323,
    0.9504844339512095,
    0.049515566048790434,
    0.6112604669781572,
    0.2830581304412209,
    0.890915741234015,
    0.1090842587659851,
    0.716941869558779,
    0.3887395330218428,
    0.9874639560909118,
    0.012536043909088197,
)


@jit
def interpolate(values, x, line):
    """Write to a line the coefficients of the polynomial of theta with `values` at x * PLACES.

    By Newton's divided differences; `values` are overwritten.
    """
    for n in range(1, HIGHEST + 1):
        for i in range(HIGHEST, n - 1, -1):
            values[i] = (values[i] - values[i - 1]) / (PLACES[i] - PLACES[i - n])
    for n in range(HIGHEST + 1):
        line[n] = 0.0
    for n in range(HIGHEST, -1, -1):  # times (theta - place), plus the next difference
        for k in range(HIGHEST, 0, -1):
            line[k] = line[k - 1] - PLACES[n] * line[k]
        line[0] = values[n] - PLACES[n] * line[0]
    power = 1.0
    for n in range(HIGHEST + 1):
        line[n] /= power
        power *= x


@jit
def at_theta(S, column, width, x):
    """Return a column of a series at theta = x units."""
    total = 0.0
    for n in range(HIGHEST, -1, -1):
        total = total * x + S[width * n + column]
    return total


@jit
def q_and_s(k, x):
    """Return q and s of a wall in contact at theta = x units."""
    q = max(at_theta(k, SERIES + AT_Q, COLUMNS, x), 0.0)
    return q, at_theta(k, SERIES + AT_S, COLUMNS, x)


# ---- the forces of all walls in contact ---------------------------------------------------------


@jit
def outward_at(body, walls, wall, accelerations, at):
    """Return d2z/dt2 of a wall."""
    row, total = walls.links[wall] * body.size, 0.0
    for i in range(body.size):
        total += body.rows[row + i] * accelerations[at + i]
    return walls.signs[wall] * total


@jit
def is_at(body, walls, wall, y):
    """Return True if the bodies of y are at a wall, within round-off."""
    r, _ = along(body, walls.links[wall], y, 0)
    return abs(walls.signs[wall] * r - walls.gaps[wall]) <= AT_PLACE * (
        abs(walls.gaps[wall]) + abs(r)
    )


@jit
def cosine(body, walls, wall, other):
    """Return the cosine of the impulses of two walls, in the norm of the kinetic energy.

    It is 0 if an impulse of one leaves the rate of the other's depth as it is.
    """
    size, total = body.size, 0.0
    row, answer = walls.links[wall] * size, walls.links[other] * size
    for i in range(size):
        total += body.rows[row + i] * body.answers[answer + i]
    sign = walls.signs[wall] * walls.signs[other]
    return sign * total / math.sqrt(walls.inverse[wall] * walls.inverse[other])


@jit
def fill_held(body, walls, contacts, at, out):
    """Fill `matrix` for the rigid walls in contact that push, by the rates out[at : at + size].

    A row holds the rates of a wall's depth by unit forces of all, and in the last column that
    without them. Returns their number.
    """
    active, size, matrix, count = contacts.active, body.size, contacts.matrix, 0
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] != IS_RIGID or contacts.pushes[wall] == 0.0:
            continue
        sign, row, column = walls.signs[wall], walls.links[wall] * size, 0
        matrix[count, -1] = outward_at(body, walls, wall, out, at)
        for d in range(active[0]):
            other = active[1 + d]
            if walls.law[other] == IS_RIGID and contacts.pushes[other] != 0.0:
                total, answer = 0.0, walls.links[other] * size
                for i in range(size):
                    total += body.rows[row + i] * body.answers[answer + i]
                matrix[count, column] = sign * walls.signs[other] * total
                column += 1
        count += 1
    return count


@jit
def hold(body, walls, contacts, at, out):
    """Add to the accelerations out[at : at + size] the forces of rigid walls in contact that push.

    They are those that keep s = 0 at each, and go to `forces`. Of velocities they are impulses.
    """
    count = fill_held(body, walls, contacts, at, out)
    if count > 0:
        solve(contacts.matrix[:count, :count], contacts.matrix[:count, -1:])
        push_held(body, walls, contacts, 1.0, at, out)


@jit
def rebound(body, walls, contacts, at, out):
    """Add to velocities the impulses of `hold`, each (1 + `rebounds`) times as large.

    All are scaled by the largest of these factors before they are solved for, so that walls with
    one coefficient of restitution have the bits of -e s.
    """
    active, matrix, most = contacts.active, contacts.matrix, 1.0
    count = fill_held(body, walls, contacts, at, out)
    if count == 0:
        return
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID and contacts.pushes[wall] != 0.0:
            most = max(most, 1.0 + contacts.rebounds[wall])
    for i in range(count):
        matrix[i, -1] *= most
    solve(matrix[:count, :count], matrix[:count, -1:])
    push_held(body, walls, contacts, most, at, out)


@jit
def push_held(body, walls, contacts, most, at, out):
    """Push with the solved forces; with `most` above 1 as `rebound` does."""
    active, count = contacts.active, 0
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID and contacts.pushes[wall] != 0.0:
            force = contacts.matrix[count, -1]
            if most > 1.0:
                force *= (1.0 + contacts.rebounds[wall]) / most
            contacts.forces[wall] = force
            push_link(body, walls.links[wall], walls.signs[wall] * force, out, at)
            count += 1


@jit
def press(body, walls, contacts, slack, at, out):
    """Add the forces of rigid walls in contact, none of which pulls, to out[at : at + size].

    They solve the complementarity problem: each force is >= 0, each rate of a depth is <= 0, and of
    the two one is 0. `pushes` becomes 0 of a wall without force. slack: share of `least` by which
    walls may pull.

    If all walls push as equations demand, these are the forces. Otherwise the problem is solved as
    least squares with bounds by the method of Lawson and Hanson (Solving Least Squares Problems,
    chapter 23): the rates after it are the point of the convex cone of admissible rates that is
    nearest, in the norm of the kinetic energy. So they exist and are unique, and the energy of
    velocities does not rise. Forces are unique unless walls depend on each other; then walls with
    the largest rates push first.
    """
    active, forces, pushes = contacts.active, contacts.forces, contacts.pushes
    least = contacts.least
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID:
            pushes[wall] = 1.0
    count = fill_held(body, walls, contacts, at, out)
    if count == 0:
        return
    fits = solve(contacts.matrix[:count, :count], contacts.matrix[:count, -1:]) != 0.0
    count = 0
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID:
            fits = fits and contacts.matrix[count, -1] * walls.inverse[wall] >= -slack * least[wall]
            count += 1
    if fits:
        push_held(body, walls, contacts, 1.0, at, out)
        return
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID:
            pushes[wall], forces[wall] = 0.0, 0.0
    for _ in range(MOST_PIVOTS * count):
        worst, place = 0.0, -1
        for c in range(active[0]):
            wall = active[1 + c]
            if walls.law[wall] == IS_RIGID and pushes[wall] == 0.0:
                rate = outward_at(body, walls, wall, out, at)
                rate -= pushed_out(body, walls, contacts, wall)
                if rate > max(worst, slack * FIRM * least[wall]):
                    worst, place = rate, wall
        if place < 0:
            break
        pushes[place] = 1.0
        admit(body, walls, contacts, at, out)
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID and pushes[wall] != 0.0:
            push_link(body, walls.links[wall], walls.signs[wall] * forces[wall], out, at)


@jit
def pushed_out(body, walls, contacts, wall):
    """Return the rate of a wall's depth that the `forces` of rigid walls take away."""
    active, size, row, total = contacts.active, body.size, walls.links[wall] * body.size, 0.0
    for c in range(active[0]):
        other = active[1 + c]
        if walls.law[other] == IS_RIGID and contacts.pushes[other] != 0.0:
            answer, per_force = walls.links[other] * size, 0.0
            for i in range(size):
                per_force += body.rows[row + i] * body.answers[answer + i]
            total += walls.signs[other] * contacts.forces[other] * per_force
    return walls.signs[wall] * total


@jit
def admit(body, walls, contacts, at, out):
    """Solve for the forces of the walls that push; those that would pull push no longer."""
    active, forces, pushes = contacts.active, contacts.forces, contacts.pushes
    matrix = contacts.matrix
    while True:
        count = fill_held(body, walls, contacts, at, out)
        if count == 0:
            return
        solve(matrix[:count, :count], matrix[:count, -1:])
        share, count, first = 1.0, 0, -1
        for c in range(active[0]):
            wall = active[1 + c]
            if walls.law[wall] == IS_RIGID and pushes[wall] != 0.0:
                force = matrix[count, -1]
                if not force > 0.0:
                    part = forces[wall] / (forces[wall] - force) if force < 0.0 else 0.0
                    if first < 0 or part < share:
                        share, first = part, wall
                count += 1
        count = 0
        for c in range(active[0]):
            wall = active[1 + c]
            if walls.law[wall] == IS_RIGID and pushes[wall] != 0.0:
                forces[wall] += share * (matrix[count, -1] - forces[wall])
                count += 1
        if first < 0:
            return
        pushes[first], forces[first] = 0.0, 0.0


@jit
def let_push(walls, contacts, which):
    """Make those rigid walls in contact push whose number in `which` is not 0."""
    for c in range(contacts.active[0]):
        wall = contacts.active[1 + c]
        if walls.law[wall] == IS_RIGID:
            contacts.pushes[wall] = which[wall]


@jit
def apply_impulses(body, walls, contacts, at, out):
    """Apply the impulses of an impact, whose walls are known, to velocities out[at : at + size].

    The map is linear, so that variations take it, too.
    """
    let_push(walls, contacts, contacts.compressed)
    rebound(body, walls, contacts, at, out)
    let_push(walls, contacts, contacts.expanded)
    hold(body, walls, contacts, at, out)


@jit
def push_all(body, walls, contacts, drive, y, work):
    """Write the accelerations to work[: size], with the forces of all walls in contact.

    drive: of the instant; the q are those of `contacts`, whose scales take the walls' own rates.
    """
    push_soft(body, walls, contacts, drive, y, work)
    hold(body, walls, contacts, 0, work)


@jit
def push_soft(body, walls, contacts, drive, y, work):
    """Write the accelerations without the forces of rigid walls, as `push_all`."""
    active, scales = contacts.active, contacts.scales
    accelerate(body, y, 0, drive[0], work, 0)
    if body.springs is not None:
        push_springs(body, y, work, 0)
    for c in range(active[0]):
        wall = active[1 + c]
        _, s = along(body, walls.links[wall], y, 0)
        sign, at = walls.signs[wall], SCALES * wall
        seen = look(walls, wall, contacts.q[wall], sign * s, 0.0, body.omega)
        push_link(body, walls.links[wall], sign * seen.force * contacts.pushes[wall], work, 0)
        scales[at + OWN_WEIGHT], scales[at + OWN_RATE] = seen.weight, seen.rate


@jit
def least_rates(body, walls, contacts, y, at):
    """Fill `least` for velocities, which begin at y[at]."""
    size = body.size
    for wall in range(walls.number):
        row, total = walls.links[wall] * size, 0.0
        for i in range(size):
            total += abs(body.rows[row + i] * y[at + i])
        contacts.least[wall] = AT_REST * total


@jit
def least_accelerations(body, walls, contacts, drive, y, work):
    """Fill `least` for accelerations: PULL times the sum of their parts' sizes.

    work: (size,) scratch.
    """
    size, n, active, force = body.size, body.modes, contacts.active, 0.0
    for k in range(body.drives):
        force += abs(drive[k])
    for i in range(size):
        work[i] = abs(body.push[i]) * force
    for i in range(n):
        work[i] += abs(body.squares[i] * y[i]) + abs(body.damping[i] * y[size + i])
    if body.coupled:
        for j in range(n):
            for i in range(n):
                work[i] += abs(body.coupling[n * j + i] * y[size + j])
    for link in range(body.links):
        r, s = along(body, link, y, 0)
        joint = abs(body.stiffness[link] * r) + abs(body.dashpots[link] * s)
        for i in range(size):
            work[i] += joint * abs(body.answers[link * size + i])
    if body.springs is not None:
        for spring in range(body.springs.number):
            link = body.springs.links[spring]
            r, _ = along(body, link, y, 0)
            joint = abs(spring_force(body.springs, spring, r))
            for i in range(size):
                work[i] += joint * abs(body.answers[link * size + i])
    for c in range(active[0]):
        wall = active[1 + c]
        link = walls.links[wall]
        _, s = along(body, link, y, 0)
        seen = look(walls, wall, contacts.q[wall], walls.signs[wall] * s, 0.0, body.omega)
        for i in range(size):
            work[i] += abs(seen.force * body.answers[link * size + i])
    for wall in range(walls.number):
        row, total = walls.links[wall] * size, 0.0
        for i in range(size):
            total += abs(body.rows[row + i]) * work[i]
        contacts.least[wall] = PULL * total


@jit
def press_now(body, walls, contacts, drive, y, work):
    """Fill `forces` and `pushes` of the rigid walls in contact by `press`, at an instant.

    work: (size,) takes the accelerations.
    """
    least_accelerations(body, walls, contacts, drive, y, work)
    push_soft(body, walls, contacts, drive, y, work)
    press(body, walls, contacts, 1.0, 0, work)
