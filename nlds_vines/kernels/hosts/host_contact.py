"""Contacts of a host from touch to release, stepped; several walls may be in contact at once.

As in `taylor`, a step is a polynomial in a fictitious time theta, in which contacts are smooth:
with z = q^p at each wall in contact, dt is the product w of their q^(p - 1) dtheta. The equations

    dq/dtheta = s / p times the others' q^(p - 1)      dX/dtheta = w V      dV/dtheta = w (...)

are polynomials, and a law supplies the series of its force as for one damper. A step's length
follows from its last terms; its error is read from the defect of the equation of motion at its end,
with the law's force and not its series. Releases, further touches and places where a force is
switched off are first roots of polynomials, certified as touches are (`touch.first_touch`).

A rigid wall takes an impact at once (`strike`). If rebounds end in finite time it holds the damper,
s = 0, until its force would have to pull.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..events.contact import (
    LAST_TERMS,
    LEAST_GRANTED,
    MOST_ATTEMPTS,
    MOST_NEWTON,
    MOST_REPEATS,
    MOST_STEPS,
    SOON,
)
from ..laws.restitution import BRIEF
from ..numerics.compiling import jit
from ..numerics.elementary import TINIEST, exp, exponent_of, log, power_of_two
from ..numerics.fours import from_place
from ..numerics.roots import guarded
from ..scene.law import (
    AT_Q,
    AT_S,
    COLUMNS,
    DEPTH,
    FORCE,
    HIGHEST,
    LARGEST_UNIT,
    LEAST_UNIT,
    LOGARITHM,
    SERIES,
    WEIGHT,
    product,
)
from ..watch.touch import AT_R, NOWHERE
from .body import accelerate, along, differentiate, integrate, move, push_link, put_at_theta
from .host_energies import is_impact_below
from .host_flight import (
    LOST_TOUCH,
    carry,
    drive_of,
    note_miss,
    place_at,
    touch_at,
    touch_in,
)
from .host_impact import OF_MOMENTS, bounce, deepest, vary_short
from .host_variations import (
    remember,
    vary_after_impact,
    vary_at_impact,
    vary_jump,
    vary_shortly,
    vary_step,
)
from .host_watch import largest_in, note_series, read_line
from .springs import (
    defect_of_springs,
    kick_by_springs,
    kick_variation,
    length_by_springs,
    push_springs,
    push_springs_in_step,
    scale_springs,
)
from .walls import (
    APART,
    FAST,
    HELD,
    INDEPENDENT,
    IS_RIGID,
    LEFT,
    OWN_RATE,
    OWN_SHARE,
    OWN_WEIGHT,
    PASSED,
    PLACES,
    ROOT,
    SCALES,
    STRUCK,
    apply_impulses,
    at_theta,
    cosine,
    fill,
    hold,
    interpolate,
    is_at,
    is_rough,
    least_rates,
    look,
    outward_at,
    press,
    press_now,
    push_all,
    push_soft,
    q_and_s,
    scratch_of,
    start_of,
)

LONGEST_HELD = 0.5  # of a step that a rigid wall holds, in units of 1 / rate
NEGLIGIBLE = 1.0e-14  # time before a release, in units of 1 / rate
FLIGHT_TERMS = 0.25  # last terms of s along springs, in units of the tolerance
LAST_POWERS = 5  # whose terms tell the radius of convergence: a free impact has every fifth alone

NOT_SHORT = -3  # in place of a cell

# Columns of a power of theta in `series`, behind 3 size numbers X, V and the accelerations:
OF_TOTAL, OF_TIME, OF_DRIVE = range(3)
MOTION_COLUMNS = 2  # and those of the drive
BEHIND_SERIES = 2  # numbers behind the last row, as the drive's numbers are even (`integrate`)
# ... and of a wall's scratch (`law`), in columns that others use for variations: products of the
# weights of walls before and behind, and the margin of a force that is switched off
WEIGHTS_BEFORE, WEIGHTS_OF_OTHERS, WEIGHTS_BEHIND = LOGARITHM + 1, LOGARITHM + 2, LOGARITHM + 3
AT_MARGIN = LOGARITHM


# ---- the series of a step ------------------------------------------------------------------------


@jit
def width_of(body):
    """Return the number of columns of a power in `series`."""
    return 3 * body.size + MOTION_COLUMNS + body.drives


@jit
def fill_weights(contacts, n):
    """Fill coefficient n of the products of the other walls' weights; return that of all."""
    active, count = contacts.active, contacts.active[0]
    total = behind = 1.0 if n == 0 else 0.0
    if count == 1:
        return scratch_of(contacts, active[1])[SERIES + COLUMNS * n + WEIGHT]
    for c in range(count):
        k = scratch_of(contacts, active[1 + c])
        k[SERIES + COLUMNS * n + WEIGHTS_BEFORE] = total
        total = product(k, int(WEIGHTS_BEFORE), int(WEIGHT), n)
    for c in range(count - 1, -1, -1):
        k = scratch_of(contacts, active[1 + c])
        k[SERIES + COLUMNS * n + WEIGHTS_BEHIND] = behind
        k[SERIES + COLUMNS * n + WEIGHTS_OF_OTHERS] = product(
            k, int(WEIGHTS_BEFORE), int(WEIGHTS_BEHIND), n
        )
        behind = product(k, int(WEIGHTS_BEHIND), int(WEIGHT), n)
    return total


@jit
def expand(body, walls, contacts, drive, unit, y):
    """Fill the series of the motion and of the walls in contact, in steps of theta = `unit`."""
    size, active, S = body.size, contacts.active, contacts.series
    width, count, extra = width_of(body), active[0], 3 * size
    for i in range(2 * size):
        S[i] = y[i]
    S[extra + OF_TIME] = 0.0
    for i in range(body.drives):
        S[extra + OF_DRIVE + i] = drive[i]
    is_held = False
    for c in range(count):
        scratch_of(contacts, active[1 + c])[SERIES + AT_Q] = contacts.q[active[1 + c]]
        is_held = is_held or walls.law[active[1 + c]] == IS_RIGID
    for n in range(HIGHEST + 1):
        row, at, per = width * n, SERIES + COLUMNS * n, unit / (n + 1.0)
        accelerate(body, S, row, S[row + extra + OF_DRIVE], S, row + 2 * size)
        if body.springs is not None:
            push_springs_in_step(body, S, row, n)
        for c in range(count):
            wall = active[1 + c]
            k, sign, link = scratch_of(contacts, wall), walls.signs[wall], walls.links[wall]
            if walls.law[wall] == IS_RIGID:
                k[at + AT_S], k[at + WEIGHT], k[at + DEPTH] = 0.0, (1.0 if n == 0 else 0.0), 0.0
                continue
            k[at + AT_S] = sign * along(body, link, S, row)[1]
            force, share = fill(walls, wall, k, n)
            m, margins = 3 * wall, walls.margins
            k[at + AT_MARGIN] = margins[m + 1] * k[at + AT_Q] + margins[m + 2] * k[at + AT_S]
            if n == 0:
                k[at + AT_MARGIN] += margins[m]
            k[at + FORCE] = force * contacts.pushes[wall]
            contacts.scales[SCALES * wall + OWN_SHARE] = share
            push_link(body, link, sign * k[at + FORCE], S, row + 2 * size)
        if is_held:
            hold(body, walls, contacts, row + 2 * size, S)
        S[row + extra + OF_TOTAL] = fill_weights(contacts, n)
        for c in range(count):
            wall = active[1 + c]
            k = scratch_of(contacts, wall)
            if walls.law[wall] == IS_RIGID:
                k[at + FORCE] = contacts.forces[wall]
                k[at + COLUMNS + AT_Q] = 0.0
            else:
                s = k[at + AT_S]
                if count > 1:
                    s = product(k, int(WEIGHTS_OF_OTHERS), int(AT_S), n)
                k[at + COLUMNS + AT_Q] = per * s * contacts.scales[SCALES * wall + OWN_SHARE]
        if n == HIGHEST:
            break
        weights, of_drive = (S, extra + OF_TOTAL, width), extra + OF_DRIVE
        integrate(S, (width, size, 0, 2 * size), weights, n, per)
        integrate(S, (width, of_drive, of_drive, body.drives), weights, n, per)
        after = row + width
        differentiate(body, S, after + of_drive)
        S[after + extra + OF_TIME] = per * S[row + extra + OF_TOTAL]


# ---- rough forces --------------------------------------------------------------------------------
#
# A force z^n whose n p is no whole number has no series in theta at a touch, and near one its
# radius is short. That does not shorten steps while the force is small beside others, so its own
# series need not hold in a step whose motion does. It is replaced by the polynomial through the
# law's force at HIGHEST + 1 places. z^n is q^(n p), n p > 5, with a zero at or beyond the ends of
# the step, so that the polynomial through Chebyshev's places errs by less than 1e-10 of the largest
# value.

SERIES_HOLDS = 1.0e-12  # error at the end of a step of a series that holds, relative to the force


@jit
def smooth_forces(body, walls, contacts, x):
    """Make the series of all forces and accelerations hold up to theta = x units."""
    active, S, size = contacts.active, contacts.series, body.size
    width, values, line = width_of(body), contacts.values, from_place(contacts.values, HIGHEST + 1)
    is_changed = False
    for c in range(active[0]):
        wall = active[1 + c]
        if not is_rough(walls, wall):
            continue
        k, push = scratch_of(contacts, wall), contacts.pushes[wall]
        for i in range(2):
            q, s = q_and_s(k, x * PLACES[i])
            values[i] = push * look(walls, wall, q, s, 0.0, body.omega).force
        off = at_theta(k, SERIES + FORCE, COLUMNS, x) - values[1]
        if abs(off) <= SERIES_HOLDS * max(values[0], values[1]) or not x > 0.0:
            continue
        for i in range(2, HIGHEST + 1):
            q, s = q_and_s(k, x * PLACES[i])
            values[i] = push * look(walls, wall, q, s, 0.0, body.omega).force
        contacts.rough[wall], is_changed = 1.0, True
        interpolate(values, x, line)
        for n in range(HIGHEST + 1):
            at = SERIES + COLUMNS * n + FORCE
            more = line[n] - k[at]
            k[at] = line[n]
            push_link(body, walls.links[wall], walls.signs[wall] * more, S, width * n + 2 * size)
    for n in range(HIGHEST + 1 if is_changed else 0):
        hold(body, walls, contacts, width * n + 2 * size, S)
        for c in range(active[0]):
            wall = active[1 + c]
            if walls.law[wall] == IS_RIGID:
                scratch_of(contacts, wall)[SERIES + COLUMNS * n + FORCE] += contacts.forces[wall]


# ---- places on the series ------------------------------------------------------------------------


@jit
def slope_at(S, column, width, x):
    total = 0.0
    for n in range(HIGHEST, 0, -1):
        total = total * x + n * S[width * n + column]
    return total


@jit
def place_of(S, column, width, x, value):
    """Return the theta in (0, x] at which a rising column reaches a value, by Newton's method."""
    low, high, place = 0.0, x, x
    for _ in range(MOST_NEWTON):
        miss = value - at_theta(S, column, width, place)
        if miss == 0.0 or not high - low > 2.0e-16 * high:
            break
        if miss > 0.0:
            low = place
        else:
            high = place
        slope = slope_at(S, column, width, place)
        guess = place + miss / slope if slope > 0.0 else low
        if guess == place:
            break
        place = guarded(guess, low, high)
    return place


@jit
def first_zero(k, column, sign, level, x, table):
    """Return the first theta in [0, x], in units, at which sign times a column rises to a level.

    Infinite if there is none, negative if it is lost.
    """
    power = 1.0
    for n in range(HIGHEST + 1):
        table[AT_R + 4 * n] = power * k[SERIES + COLUMNS * n + column]
        power *= x
    return place_in(touch_at(sign, level, 1.0, table), x)


@jit
def place_in(place, x):
    """Return the theta of a place in [0, x], as `touch_at` returns it.

    Infinite without a touch, also if x is 0, and negative if it is lost.
    """
    if place == NOWHERE:
        return math.inf
    return x * place if place >= 0.0 else place


@jit
def expand_r_by_theta(body, walls, S, wall, x, table):
    """Fill the table with r on [0, x] of a step; return a bound of its change."""
    size, width, power, most = body.size, width_of(body), 1.0, 0.0
    row = walls.links[wall] * size
    for n in range(HIGHEST + 1):
        r = 0.0
        for i in range(size):
            r += body.rows[row + i] * S[width * n + i]
        table[AT_R + 4 * n] = power * r
        if n > 0:
            most += abs(power * r)
        power *= x
    return most


@jit
def first_rise(body, walls, contacts, wall, x, table):
    """Return (theta, depth [m]): as `first_zero`, the first place in [0, x] of a wall's touch.

    The depth is 0, or if a compliant wall is touched almost at rest (`leave_at_rest`), that up to
    which its force is round-off beside the other contacts'. There the contact begins: in a row of
    bodies that touch, the depths grow by ever higher powers of the time, and the product of their
    q^(p - 1) would leave the range of numbers.
    """
    S = contacts.series
    most = expand_r_by_theta(body, walls, S, wall, x, table)
    sign, gap = walls.signs[wall], walls.gaps[wall]
    if sign * table[AT_R] + most < gap:
        return math.inf, 0.0
    place = touch_in(walls, wall, 1.0, table)
    if walls.law[wall] == IS_RIGID or not 0.0 <= place <= 1.0:
        return place_in(place, x), 0.0
    size, width, at = body.size, width_of(body), walls.links[wall] * body.size
    s = 0.0
    for i in range(size):
        s += sign * body.rows[at + i] * at_theta(S, size + i, width, x * place)
    external = largest_push(body, walls, contacts, x)
    if external > 0.0:
        depth, _ = start_of(walls, wall, external, 0.0)
        if s < math.sqrt(2.0 * external) * math.sqrt(depth):
            expand_r_by_theta(body, walls, S, wall, x, table)
            return place_in(touch_at(sign, gap + depth, 1.0, table), x), depth
    return x * place, 0.0


@jit
def largest_push(body, walls, contacts, x):
    """Return the largest acceleration [m/s^2] of a compliant contact at theta = 0 and x units."""
    active, largest = contacts.active, 0.0
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID:
            continue
        for end in (0.0, x):
            q, s = q_and_s(scratch_of(contacts, wall), end)
            force = abs(look(walls, wall, q, s, 0.0, body.omega).force)
            largest = max(largest, force * walls.inverse[wall])
    return largest


@jit
def is_in_contact(contacts, wall):
    is_active = False
    for c in range(contacts.active[0]):
        is_active = is_active or contacts.active[1 + c] == wall
    return is_active


@jit
def note_misses_in_step(body, walls, contacts, clearance, x, table):
    """Lower `clearance` to the near misses of other walls in a step: where s falls through zero."""
    S = contacts.series
    for wall in range(walls.number):
        sign, link = walls.signs[wall], walls.links[wall]
        before, after = along(body, link, S, 0)[1], along(body, link, contacts.end, 0)[1]
        if sign * before > 0.0 >= sign * after and not is_in_contact(contacts, wall):
            expand_r_by_theta(body, walls, S, wall, x, table)
            note_miss(walls, wall, clearance, 1.0, table, True)


# ---- a step --------------------------------------------------------------------------------------


@jit
def guess_of(body, walls, contacts, drive, rate, y, work):
    """Return a length of theta near that of a free impact, and fill the scales of the walls.

    It is infinite if no wall in contact has speed or is pressed. A flight under springs, without
    walls in contact, is as long as a hold.
    """
    active, scales, length = contacts.active, contacts.scales, math.inf
    accelerate(body, y, 0, drive[0], work, 0)
    if body.springs is not None:
        push_springs(body, y, work, 0)
        scale_springs(body, rate, y, work)
        if active[0] == 0:
            length = LONGEST_HELD / rate
    for c in range(active[0]):
        wall = active[1 + c]
        at, external = SCALES * wall, outward_at(body, walls, wall, work, 0)
        _, s = along(body, walls.links[wall], y, 0)
        seen = look(walls, wall, contacts.q[wall], walls.signs[wall] * s, external, rate)
        scales[at + FAST], scales[at + ROOT] = max(seen.fast, abs(s)), seen.root
        if walls.law[wall] == IS_RIGID:
            length = min(length, LONGEST_HELD / rate)
            continue
        per = seen.per_theta
        for d in range(active[0]):
            other = active[1 + d]
            if d != c and contacts.q[other] > 0.0:
                per *= look(walls, other, contacts.q[other], 0.0, 0.0, rate).weight
        if per > 0.0 and (abs(s) > 0.0 or contacts.q[wall] > 0.0 or external > 0.0):
            length = min(length, 1.0 / per)
    return length


@jit
def length_of(body, walls, contacts, longest):
    """Return the length of a step in units of theta whose last terms are within the tolerance.

    The radius of convergence is read from the last terms of s and q of the compliant walls in
    contact. The motion on rigid walls alone is as smooth as a flight, and has `LONGEST_HELD`.
    """
    active, scales, radius = contacts.active, contacts.scales, math.inf
    if body.springs is not None:
        granted = FLIGHT_TERMS * max(contacts.tolerance, LEAST_GRANTED)
        longest = length_by_springs(body, granted, longest)
    for c in range(active[0]):
        wall = active[1 + c]
        k = scratch_of(contacts, wall)
        if walls.law[wall] == IS_RIGID:
            continue
        fast, root = scales[SCALES * wall + FAST], scales[SCALES * wall + ROOT]
        for n in range(HIGHEST - LAST_POWERS + 1, HIGHEST + 1):
            share = 0.0
            last = abs(k[SERIES + COLUMNS * n + AT_S])
            if last > TINIEST:
                share = last / fast
            last = abs(k[SERIES + COLUMNS * n + AT_Q])
            if last > TINIEST:
                share = max(share, last / root)
            if share > 0.0:
                radius = min(radius, -log(share) / n)
    granted = log(LAST_TERMS * max(contacts.tolerance, LEAST_GRANTED)) / HIGHEST
    return min(exp(radius + granted), longest)


@jit
def end_state(body, contacts, x, y):
    """Write the state at theta = x units into y, and into `contacts.q`."""
    active = contacts.active
    put_at_theta(contacts.series, (width_of(body), body.size), int(HIGHEST), x, y)
    for c in range(active[0]):
        q = at_theta(scratch_of(contacts, active[1 + c]), SERIES + AT_Q, COLUMNS, x)
        contacts.q[active[1 + c]] = max(q, 0.0)


@jit
def defect_of(body, walls, contacts, drive, x, y, work):
    """Return the error of a step to theta = x units, relative to the scales of impacts.

    It is x / (N + 1) of the defect of the equations at the end y, with the q of `contacts`; drive:
    that there; work: (size,) accelerations.
    """
    active, scales, count = contacts.active, contacts.scales, contacts.active[0]
    unit, total, missing = contacts.unit[0], 1.0, 0.0
    push_all(body, walls, contacts, drive, y, work)
    for c in range(count):
        total *= scales[SCALES * active[1 + c] + OWN_WEIGHT]
    for c in range(count):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID:
            continue
        k, at, others = scratch_of(contacts, wall), SCALES * wall, unit
        for d in range(count):
            if d != c:
                others *= scales[SCALES * active[1 + d] + OWN_WEIGHT]
        off = slope_at(k, SERIES + AT_S, COLUMNS, x)
        off -= unit * total * outward_at(body, walls, wall, work, 0)
        missing += abs(off) / scales[at + FAST]
        off = slope_at(k, SERIES + AT_Q, COLUMNS, x) - others * scales[at + OWN_RATE]
        missing += abs(off) / scales[at + ROOT]
    if body.springs is not None:
        missing += defect_of_springs(body, x, unit * total, work)
    return x * missing / (HIGHEST + 1.0)


# ---- from touch to release -----------------------------------------------------------------------


class PreparedHost(NamedTuple):
    """One host prepared for orbits."""

    body: Any  # `body.Body`
    grid: Any  # `grid.HostGrid`
    walls: Any  # `walls.Walls`
    contacts: Any  # `walls.Contacts`
    impacts: Any  # `Impacts`
    scratch: Any  # `host_flight.Scratch`
    short: Any  # `host_impact.ShortImpacts`
    cells: Any  # `spring_cells.SpringCells`, or None without springs that are not linear


class Impacts(NamedTuple):
    """The impacts one by one: rows of the columns OF_WALL, OF_TOUCH ... OF_RELEASE_IN_PERIOD.

    Kernels pass times within the period that began at `began`. Rows have them beside the times from
    the orbit's beginning, so that they can be copied to later periods to the bit.
    """

    data: Any  # ROW_OF_IMPACT numbers of each; all arrays are rows, in inner kernels bare ones
    filled: Any  # (1,) begun, also beyond the room
    room: int
    counts: Any  # (walls,) of impacts that have begun
    slowest: Any  # (1,) smallest approach speed so far [m/s]
    hardest: Any  # (walls,) largest impulse of a rigid wall so far [N s]
    has_depths: bool  # whether the largest depths and forces of compliant walls are recorded
    began: Any  # (1,) time at which the period, or the cell of a load, began [s]


OF_WALL, OF_TOUCH, OF_RELEASE, OF_SPEED, OF_LARGEST, OF_DEEPEST, OF_IMPULSE = range(7)
OF_TOUCH_IN_PERIOD, OF_RELEASE_IN_PERIOD, ROW_OF_IMPACT = 7, 8, 9


@jit
def begin(host, varied, wall, time, y):
    """Add a wall to those in contact that is touched at a time [s] of the period; begin its row."""
    body, walls, contacts, impacts = host.body, host.walls, host.contacts, host.impacts
    active = contacts.active
    _, s = along(body, walls.links[wall], y, 0)
    note_touch(walls, contacts, impacts, wall, time, walls.signs[wall] * s)
    active[0] += 1
    active[active[0]] = wall
    contacts.q[wall], contacts.pushes[wall] = 0.0, 1.0
    if varied is not None:
        vary_jump(body, walls, contacts, varied, wall, 1.0)


@jit
def note_touch(walls, contacts, impacts, wall, time, speed):
    """Count an impact, and begin its row."""
    row = impacts.filled[0]
    contacts.rows[wall] = row
    impacts.filled[0] += 1
    impacts.counts[wall] += 1
    impacts.slowest[0] = min(impacts.slowest[0], speed)
    if row < impacts.room:
        data, at = impacts.data, ROW_OF_IMPACT * row
        data[at + OF_WALL] = wall
        data[at + OF_TOUCH] = impacts.began[0] + time
        data[at + OF_TOUCH_IN_PERIOD] = time
        data[at + OF_RELEASE] = math.nan
        data[at + OF_RELEASE_IN_PERIOD] = math.nan
        data[at + OF_SPEED] = speed
        data[at + OF_DEEPEST], data[at + OF_IMPULSE] = 0.0, 0.0
        data[at + OF_LARGEST] = math.inf if walls.law[wall] == IS_RIGID else 0.0


@jit
def strike(host, varied, wall, time, drive, y):
    """Take the impact with a rigid wall, and with all others that are struck at this instant.

    Walls that interact, directly or by others, take one impact (`strike_together`). Those that do
    not are struck one after the other, in any order: an impulse of one leaves the rates at the
    others as they are, and variations pass each at its own time.
    """
    body, walls, contacts = host.body, host.walls, host.contacts
    for other in range(walls.number):
        contacts.joins[other] = int(APART)
    while wall >= 0:
        strike_together(host, varied, wall, time, drive, y)
        wall = -1
        for other in range(walls.number):
            if contacts.joins[other] != APART:
                contacts.joins[other] = int(PASSED)
            elif wall < 0 and part_of(body, walls, contacts, other, y) == STRUCK:
                wall = other


@jit
def part_of(body, walls, contacts, wall, y):
    """Return HELD, STRUCK or LEFT of a rigid wall that holds or that bodies are at, else APART."""
    if walls.law[wall] != IS_RIGID:
        return int(APART)
    if is_in_contact(contacts, wall):
        return int(HELD)
    if not is_at(body, walls, wall, y):
        return int(APART)
    _, s = along(body, walls.links[wall], y, 0)
    return int(STRUCK) if walls.signs[wall] * s > 0.0 else int(LEFT)


@jit
def join(body, walls, contacts, wall, y):
    """Fill `joins` for a wall that is struck, and for those that interact with it and are APART."""
    joins, is_changed = contacts.joins, True
    joins[wall] = int(STRUCK)
    while is_changed:
        is_changed = False
        for other in range(walls.number):
            if joins[other] != APART:
                continue
            part, interacts = part_of(body, walls, contacts, other, y), False
            for one in range(walls.number if part != APART else 0):
                if joins[one] in (HELD, STRUCK, LEFT):
                    bond = abs(cosine(body, walls, one, other))
                    interacts = interacts or bond > INDEPENDENT
            if interacts:
                joins[other], is_changed = part, True


@jit
def strike_together(host, varied, wall, time, drive, y):
    """Take the impact with a rigid wall, and with those that interact and that the bodies are at.

    By Poisson's law of impacts without friction, as Glocker and Pfeiffer state it (Nonlinear
    Dynamics 7 (1995) 471), for walls that are struck and walls that hold alike. Impulses >= 0 first
    bring all walls to rates of their depths <= 0, of which those with an impulse are 0. Then each
    wall returns e times its impulse, and again impulses >= 0 keep bodies out of walls that they
    would enter by the rebounds of others. One wall alone turns s into -e s.

    Energy does not rise, whatever e the walls have. With u the velocities after compression and n
    what its impulses changed, orthogonal in the norm of energy, the velocities at the end are the
    admissible ones nearest to u - e n. Their energy is at most that of u - e n less any
    nonnegative impulses, (1 - e) n among them, hence at most that of u - n, and of u + n before.

    A wall holds from then on if it is pressed and rebounds from the returned speed, or from that by
    the impulses of others, end in rest within a negligible time. They are completed at once.
    """
    body, walls, contacts = host.body, host.walls, host.contacts
    active, size, work, rate = contacts.active, body.size, host.scratch.work, host.grid.rate
    if varied is not None:
        remember(body, walls, contacts, varied, drive, y, work)
    join(body, walls, contacts, wall, y)
    begin(host, varied, wall, time, y)
    for part in (int(STRUCK), int(LEFT)):  # those that the bodies leave may be pushed into them
        for other in range(walls.number):
            if other == wall or contacts.joins[other] != part:
                continue
            if part == STRUCK:
                begin(host, varied, other, time, y)
            else:
                contacts.rows[other] = -1
                active[0] += 1
                active[active[0]] = other
    compress(host, drive, y)
    for c in range(active[0]):
        other = active[1 + c]
        if walls.law[other] != IS_RIGID:
            continue
        e, impulse = walls.constants[other].e, contacts.compressed[other]
        s, pressing = e * impulse * walls.inverse[other], contacts.presses[other]
        stays = pressing > 0.0 and rate * s <= BRIEF * pressing and (e < 1.0 or s == 0.0)
        contacts.rebounds[other] = 0.0 if stays else e
        contacts.impulses[other] *= 1.0 + contacts.rebounds[other]
        contacts.compressed[other] = 1.0 if impulse != 0.0 else 0.0
    expand_impulses(host, y)
    note_impulses(walls, contacts, host.impacts)
    if varied is not None:
        vary_at_impact(body, walls, contacts, varied, wall, y)
    departs = False  # whether a wall that holds is left at a negligible speed
    for place in range(active[0], 0, -1):
        other = active[place]
        if walls.law[other] != IS_RIGID:
            continue
        contacts.pushes[other], contacts.rebounds[other] = 1.0, 0.0
        s, pressing = -outward_at(body, walls, other, y, size), contacts.presses[other]
        is_brief = walls.constants[other].e < 1.0 and rate * s <= BRIEF * pressing
        if pressing > 0.0 and (s <= contacts.least[other] or is_brief):
            departs = departs or s > contacts.least[other]
        else:
            release(host, varied, place, time, y)
    if departs:
        hold(body, walls, contacts, size, y)
    if varied is not None:
        vary_after_impact(body, walls, contacts, varied, wall, drive, y, work)


@jit
def compress(host, drive, y):
    """Fill `compressed` with the impulses that bring bodies to rest on the walls in contact.

    `presses` takes the accelerations [m/s^2] by which the forces press them there.
    """
    body, walls, contacts, work = host.body, host.walls, host.contacts, host.scratch.work
    active, size = contacts.active, body.size
    for i in range(size):
        work[size + i], work[2 * size + i] = y[size + i], y[size + i]
    least_rates(body, walls, contacts, y, size)
    press(body, walls, contacts, 1.0, size, work)
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID:
            contacts.compressed[wall] = contacts.forces[wall] * contacts.pushes[wall]
            contacts.impulses[wall] = firm_impulse(walls, contacts, wall)
    for i in range(size):
        y[size + i] = work[size + i]
    push_soft(body, walls, contacts, drive, y, work)
    press(body, walls, contacts, 0.0, 0, work)
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID:
            pressing = contacts.forces[wall] * walls.inverse[wall]
            contacts.presses[wall] = pressing * contacts.pushes[wall]
    for i in range(size):
        y[size + i] = work[2 * size + i]


@jit
def expand_impulses(host, y):
    """Apply an impact's impulses to the velocities, and fill `expanded`; after `compress`."""
    body, walls, contacts, size = host.body, host.walls, host.contacts, host.body.size
    active, enters = contacts.active, False
    for c in range(active[0]):
        contacts.expanded[active[1 + c]] = 0.0
    apply_impulses(body, walls, contacts, size, y)
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] == IS_RIGID:
            rate = outward_at(body, walls, wall, y, size)
            enters = enters or rate > contacts.least[wall]
    if enters:
        press(body, walls, contacts, 1.0, size, y)
        for c in range(active[0]):
            wall = active[1 + c]
            if walls.law[wall] == IS_RIGID:
                contacts.expanded[wall] = contacts.pushes[wall]
                contacts.impulses[wall] += firm_impulse(walls, contacts, wall)


@jit
def firm_impulse(walls, contacts, wall):
    """Return the impulse [N s] that `press` has found for a wall, 0 within round-off."""
    impulse = contacts.forces[wall] * contacts.pushes[wall]
    return impulse if impulse * walls.inverse[wall] > contacts.least[wall] else 0.0


@jit
def note_impulses(walls, contacts, impacts):
    """Raise the largest impulses by those of an impact, also at walls that held before it."""
    active, hardest, data = contacts.active, impacts.hardest, impacts.data
    for c in range(active[0]):
        wall = active[1 + c]
        if walls.law[wall] != IS_RIGID:
            continue
        impulse, row = contacts.impulses[wall], contacts.rows[wall]
        hardest[wall] = max(hardest[wall], impulse)
        if 0 <= row < impacts.room:
            at = ROW_OF_IMPACT * row + OF_IMPULSE
            data[at] = max(data[at], impulse)


@jit
def release(host, varied, place, time, y):
    """Remove the wall at a place of `active`, and put the state back on it."""
    body, walls, contacts, impacts = host.body, host.walls, host.contacts, host.impacts
    active = contacts.active
    wall = active[place]
    if varied is not None and contacts.pushes[wall] == 1.0:
        vary_jump(body, walls, contacts, varied, wall, -1.0)
    for c in range(place, active[0]):
        active[c] = active[c + 1]
    active[0] -= 1
    put_on(body, walls, wall, y)
    turn_away(body, walls, wall, y)
    note_release(impacts, contacts.rows[wall], time)


@jit
def note_release(impacts, row, time):
    """Note the time [s] of the period at which the contact of a row ends, if it is recorded."""
    if 0 <= row < impacts.room:
        at = ROW_OF_IMPACT * row
        impacts.data[at + OF_RELEASE] = impacts.began[0] + time
        impacts.data[at + OF_RELEASE_IN_PERIOD] = time


@jit
def put_on(body, walls, wall, y):
    """Move the bodies so that r is at a wall, which it left or holds within round-off."""
    link = walls.links[wall]
    r, _ = along(body, link, y, 0)
    excess = (r - walls.signs[wall] * walls.gaps[wall]) / walls.inverse[wall]
    push_link(body, link, excess, y, 0)


@jit
def turn_away(body, walls, wall, y):
    """Change the velocities by round-off, if it takes that to lead away from a wall."""
    link, size, scale = walls.links[wall], body.size, 0.0
    for i in range(size):
        scale += abs(body.rows[link * size + i] * y[size + i])
    _, s = along(body, link, y, 0)
    excess = walls.signs[wall] * s + 4.0e-16 * scale
    if excess > 0.0:
        push_link(body, link, walls.signs[wall] * excess / walls.inverse[wall], y, size)


@jit
def is_noted(contacts, impacts, watch):
    """Return True if records take the forces of a step."""
    takes = watch is not None and watch.is_on[0] > 0.0
    for c in range(contacts.active[0]):
        row = contacts.rows[contacts.active[1 + c]]
        takes = takes or (impacts.has_depths and 0 <= row < impacts.room)
    return takes


@jit
def note_step(walls, contacts, impacts, x, table):
    """Raise the largest force and depth of the impacts under way by those of a step."""
    active, data = contacts.active, impacts.data
    for c in range(active[0] if impacts.has_depths else 0):
        wall = active[1 + c]
        row = contacts.rows[wall]
        if 0 <= row < impacts.room and walls.law[wall] != IS_RIGID:
            for column, place in ((int(DEPTH), OF_DEEPEST), (int(FORCE), OF_LARGEST)):
                read_line(scratch_of(contacts, wall), COLUMNS, SERIES + column, x, table)
                at = ROW_OF_IMPACT * row + place
                data[at] = largest_in(table, int(HIGHEST), data[at])


@jit
def leave_at_rest(body, walls, contacts, drive, left, rate, y, work):
    """Move past touches that steps in theta cannot leave, for `left` [s]; return the time.

    The state and the drive are advanced in place.

    At a touch without speed the depth grows as a t^2 / 2 under an acceleration a, and at two walls
    that are touched at one instant dt/dtheta has a double zero. For so short a time the contacts'
    forces are round-off.
    """
    active, touched, time = contacts.active, 0, 0.0
    accelerate(body, y, 0, drive[0], work, 0)
    if body.springs is not None:
        push_springs(body, y, work, 0)
    for c in range(active[0]):
        wall = active[1 + c]
        if contacts.q[wall] > 0.0 or walls.law[wall] == IS_RIGID:
            continue
        touched += 1
        _, s = along(body, walls.links[wall], y, 0)
        s *= walls.signs[wall]
        external = outward_at(body, walls, wall, work, 0)
        if external > 0.0:
            soon = SOON / rate
            depth, _ = start_of(walls, wall, external, 0.0)
            depth = min(depth, 0.5 * external * soon * soon)
            if 0.5 * s * s / external < depth:
                time = max(time, (math.sqrt(2.0 * external * depth) - s) / external)
    if touched > 1:
        time = max(time, SOON * SOON / rate)
    time = min(time, left)
    if time > 0.0:
        if body.springs is not None:
            for i in range(2 * body.size):
                contacts.end[i] = y[i]
        move(body, rate, drive, time, y, work)
        if body.springs is not None:
            kick_by_springs(body, contacts.end, time, y)
        for c in range(active[0]):
            wall = active[1 + c]
            if contacts.q[wall] == 0.0 and walls.law[wall] != IS_RIGID:
                r, _ = along(body, walls.links[wall], y, 0)
                depth = max(walls.signs[wall] * r - walls.gaps[wall], 0.0)
                _, contacts.q[wall] = start_of(walls, wall, 0.0, depth)
    return time


@jit
def release_spent(host, varied, time, y):
    """Release those of several walls that will be left within a negligible time.

    If walls are left at one instant, dt/dtheta has a double zero there, so that each step lowers
    their q by a factor, and none reaches zero.
    """
    body, walls, contacts, rate = host.body, host.walls, host.contacts, host.grid.rate
    for place in range(contacts.active[0], 0, -1):
        wall = contacts.active[place]
        _, s = along(body, walls.links[wall], y, 0)
        q = contacts.q[wall]
        seen = look(walls, wall, q, walls.signs[wall] * s, 0.0, rate)
        if q > 0.0 and rate * q * seen.weight <= NEGLIGIBLE * -seen.rate:
            release(host, varied, place, time, y)


@jit
def release_pulled(host, varied, drive, time, y):
    """Release the rigid walls that would pull, those that hold at one instant together (`press`).

    Their forces may jump where the force of another contact or a load does.
    """
    body, walls, contacts, active = host.body, host.walls, host.contacts, host.contacts.active
    is_held = False
    for c in range(active[0]):
        is_held = is_held or walls.law[active[1 + c]] == IS_RIGID
    if not is_held:
        return
    press_now(body, walls, contacts, drive, y, host.scratch.work)
    for place in range(active[0], 0, -1):
        wall = active[place]
        if walls.law[wall] == IS_RIGID and contacts.pushes[wall] == 0.0:
            contacts.pushes[wall] = 1.0
            release(host, varied, place, time, y)


ENDS, SWITCHES, TOUCHED = range(3)  # what ends a step, unless its length or the period


@jit
def first_event(body, walls, contacts, h, table):
    """Return (length of the step, event, place in `active` or wall, depth); ENDS, 0: none.

    The length is negative if an event is lost; depth: of a touch, as of `first_rise`.
    """
    active, event, place, depth = contacts.active, ENDS, 0, 0.0
    is_held = False
    for c in range(active[0]):
        wall = active[1 + c]
        k = scratch_of(contacts, wall)
        if walls.law[wall] == IS_RIGID:
            is_held = True
            continue
        x = first_zero(k, int(AT_Q), -1.0, 0.0, h, table)
        if x < 0.0:
            return x, event, place, depth
        if x <= h:
            h, event, place = x, ENDS, 1 + c
        if walls.margins[3 * wall + 2] > 0.0:
            sense = -1.0 if contacts.pushes[wall] == 1.0 else 1.0
            x = first_zero(k, int(AT_MARGIN), sense, 0.0, h, table)
            if x < 0.0:
                return x, event, place, depth
            if x < h:
                h, event, place = x, SWITCHES, 1 + c
    for wall in range(walls.number):
        if not is_in_contact(contacts, wall):
            x, deep = first_rise(body, walls, contacts, wall, h, table)
            if x < 0.0:
                return x, event, place, depth
            is_free = event == ENDS and place == 0  # whether the step ends without an event
            if x < h or (x == h and is_free):
                h, event, place, depth = x, TOUCHED, wall, deep
    if is_held:
        smooth_forces(body, walls, contacts, h)
        for c in range(active[0]):
            wall = active[1 + c]
            if walls.law[wall] != IS_RIGID:
                continue
            level = contacts.least[wall] / walls.inverse[wall]
            x = first_zero(scratch_of(contacts, wall), int(FORCE), -1.0, level, h, table)
            if x < 0.0:
                return x, event, place, depth
            if x <= h:
                h, event, place = x, ENDS, 1 + c
    return h, event, place, depth


@jit
def take_at_once(host, varied, watch, wall, touch, stop, y):
    """Take a short impact at once; return (j, x) of its release, then of the base of y.

    touch: (j, x, place) as of `fly`. Where it is not short, j is NOT_SHORT, and y is as it was; it
    is LOST_TOUCH if steps are lost. What a short impact does not tell is noted by steps beside it,
    which leave the orbit as it is.
    """
    body, grid, contacts, impacts, scratch = (
        host.body,
        host.grid,
        host.contacts,
        host.impacts,
        host.scratch,
    )
    j, x, place = touch
    active = contacts.active
    is_followed = is_watched = False
    if watch is not None:
        is_watched = watch.is_on[0] > 0.0
    is_followed = varied is not None or is_watched
    if is_followed:
        for i in range(2 * body.size):
            scratch.touch[i] = y[i]
    arc, took, distance, places = bounce(host, wall, touch, stop, y)
    if arc.powers == 0:
        return NOT_SHORT, 0.0, 0, 0.0
    begun, begun_x = place_at(grid, j, x, place)
    time = (begun + begun_x) * grid.h
    note_touch(host.walls, contacts, impacts, wall, time, arc.s)
    row = contacts.rows[wall]
    if varied is not None and not distance < varied.clearance[0]:
        is_followed = not vary_short(host, varied, wall, arc, took)
    if is_followed:
        carry(body, grid, scratch, (j, x), (begun, begun_x), scratch.touch)
    if watch is not None and is_watched and watch.rows == 0:
        for i in range(2 * body.size):
            scratch.begin[i] = y[i]
        left, left_x, base, shift = places
        carry(body, grid, scratch, (base, shift), (left, left_x), scratch.begin)
        impulse = host.short.numbers[OF_MOMENTS]
        ends = (begun, begun_x), (left, left_x)
        duration = took * arc.tick
        is_followed = not is_impact_below(host, watch.alone, wall, impulse, duration, ends)
    if is_followed:
        active[0], active[1], contacts.rows[wall] = 1, wall, -1
        contacts.q[wall], contacts.pushes[wall] = 0.0, 1.0
        from_there = begun, begun_x, stop
        if step_contacts(host, varied, watch, from_there, scratch.touch)[0] == LOST_TOUCH:
            return LOST_TOUCH, 0.0, 0, 0.0
        active[0] = 0
    note_release(impacts, row, time + took * arc.tick)
    at = ROW_OF_IMPACT * row
    if 0 <= row < impacts.room and impacts.has_depths:
        depth = deepest(host.short, arc)
        impacts.data[at + OF_DEEPEST] = depth
        impacts.data[at + OF_LARGEST] = host.walls.constants[wall].K * depth * math.sqrt(depth)
    return places


@jit
def step_contacts(host, varied, watch, begun, y):
    """Follow the walls in contact until the last one is released, or to cell `stop`.

    Under springs that are not linear flights are stepped, too, always to `stop`, which may lie
    within a cell.

    varied: `Varied` or None; watch: `HostWatch` or None; begun: (j, x, `stop`); y: the state,
    advanced in place. Returns (j, x), or (LOST_TOUCH, x) if an event is lost or there are too many
    steps.
    """
    body, grid, walls, contacts, impacts, scratch, _, _ = host
    (j, x, stop), S, active, work = begun, contacts.series, contacts.active, scratch.work
    size, table, rate, drive = body.size, scratch.polynomial, grid.rate, scratch.drive
    width, first = width_of(body), 3 * size
    elapsed, left = 0.0, (stop - j - x) * grid.h
    touched_at = (j + x) * grid.h
    for step in range(MOST_STEPS):
        if active[0] == 0 and host.body.springs is None:
            break
        if step == MOST_STEPS - 1:
            return LOST_TOUCH, x
        drive_of(grid, j, x + elapsed / grid.h, drive)
        took = leave_at_rest(body, walls, contacts, drive, left - elapsed, rate, y, work)
        elapsed += took
        if varied is not None and took > 0.0:
            vary_shortly(body, rate, varied, took, work)
            if host.body.springs is not None:
                for c in range(varied.number):
                    kick_variation(body, y, took, varied.rows, 2 * size * c)
        if not elapsed < left:
            return stop, 0.0
        if active[0] > 1:
            release_spent(host, varied, touched_at + elapsed, y)
        release_pulled(host, varied, drive, touched_at + elapsed, y)
        longest = guess_of(body, walls, contacts, drive, rate, y, work)
        if not longest < math.inf:  # without speed and pushed off: the contacts are over
            while active[0] > 0:
                release(host, varied, 1, touched_at + elapsed, y)
            break
        unit = power_of_two(min(max(exponent_of(longest), LEAST_UNIT), LARGEST_UNIT))
        contacts.unit[0] = unit
        expand(body, walls, contacts, drive, unit, y)
        for c in range(active[0]):
            contacts.rough[active[1 + c]] = 0.0
        h = length_of(body, walls, contacts, longest / unit)
        event, place, depth, stopped = ENDS, 0, 0.0, False
        for attempt in range(MOST_ATTEMPTS):
            h, event, place, depth = first_event(body, walls, contacts, h, table)
            if h < 0.0:
                return LOST_TOUCH, x
            took = at_theta(S, first + OF_TIME, width, h)
            stopped = took > left - elapsed
            if stopped:
                took = left - elapsed
                h, event, place = place_of(S, first + OF_TIME, width, h, took), ENDS, 0
            end_state(body, contacts, h, contacts.end)
            drive_of(grid, j, x + (elapsed + took) / grid.h, drive)
            doubt = defect_of(body, walls, contacts, drive, h, contacts.end, work)
            if not doubt > contacts.tolerance or attempt > MOST_REPEATS:
                break
            h *= max(0.3, 0.9 * exp(log(contacts.tolerance / doubt) / HIGHEST))
        if varied is not None or is_noted(contacts, impacts, watch):
            smooth_forces(body, walls, contacts, h)
        note_step(walls, contacts, impacts, h, table)
        if watch is not None:
            note_series(body, watch, S, (width, first + OF_DRIVE, first + OF_TOTAL, unit), h)
        if varied is not None:
            vary_step(body, walls, contacts, varied, (first + OF_TOTAL, width), h)
            note_misses_in_step(body, walls, contacts, varied.clearance, h, table)
        for i in range(2 * size):
            y[i] = contacts.end[i]
        for c in range(active[0]):
            if walls.law[active[1 + c]] == IS_RIGID:
                put_on(body, walls, active[1 + c], y)
        elapsed += took
        time = touched_at + elapsed
        if event == TOUCHED:
            drive_of(grid, j, x + elapsed / grid.h, drive)
            if walls.law[place] == IS_RIGID:
                strike(host, varied, place, time, drive, y)
            else:
                begin(host, varied, place, time, y)
                if depth > 0.0:
                    _, contacts.q[place] = start_of(walls, place, 0.0, depth)
        elif event == SWITCHES:
            wall = active[place]
            contacts.pushes[wall] = 1.0 - contacts.pushes[wall]
        elif place > 0:
            release(host, varied, place, time, y)
        if stopped:
            return stop, 0.0
    at = x + elapsed / grid.h
    whole = int(at)
    if j + whole >= stop:
        return stop, 0.0
    return j + whole, at - whole
