"""A contact as Taylor polynomials in theta, in which it is smooth at touch and at release.

The Hertz force z^(3/2) is only once differentiable at z = 0, so a method in time loses its order
at every touch and every release. With q = sqrt(z) and the fictitious time dt = q dtheta, eq. (5)
becomes

    dq/dtheta  = s / 2                    dx1/dtheta = q v1
    ds/dtheta  = q (external - kappa q^3) dv1/dtheta = q (...)       dt/dtheta = q

polynomials in all unknowns, so that their Taylor coefficients follow one from the other by products
of series (`law`, also for other laws). The release is a root of the polynomial of q.

The error of a step comes from its defect, the residual of the equation at its end, which grows like
h^N for a polynomial of degree N: the step errs by h / (N + 1) of it. The defect uses the law's
force and not its series, so that it also shows a wrong series.
"""

from __future__ import annotations

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import exp, exponent_of, log, power_of_two, whole_power
from ..numerics.fours import four, four_at, four_of, number_of, put_four
from ..scene.drive import Moment, after, drive_now, drive_term
from ..scene.law import (
    AT_Q,
    AT_S,
    AT_V,
    AT_X,
    COLUMNS,
    COSINE,
    DEPTH,
    DRAG,
    DS,
    DV,
    ELASTIC,
    FORCE,
    HIGHEST,
    LARGEST_UNIT,
    LEAST_UNIT,
    LENGTHS,
    LOADED,
    NEW,
    OLD,
    ORDER_OF_RK4,
    RATES,
    ROW,
    SAVE,
    SERIES,
    SHRINKS,
    SINE,
    STEEP,
    STIFF,
    TAU,
    UNIT,
    VARIED,
    VOLUME,
    WEIGHT,
    WIDTH,
    contact_terms,
    damped_term,
    depth_of,
    drag_term,
    force_of,
    product,
    rate_of_q,
    steep_term,
    weight_of,
)
from ..scene.scene import Step, StepPiece, accelerations, accelerations_at, unloaded
from .driven import Driven, drive_terms
from .flight import COEF

# --------------------------------------------------------------------------------------------------
# A step of a contact by the classical Runge-Kutta method, for method rk4.
#
# In theta the equations are smooth from touch to release, so that the method has its order four.
# It has no series: a state within a step is the end of a shorter step.


@jit
def rates_at(side, phase, y):
    """Return the derivatives of y = (q, s, x1, v1, tau) by theta; phase: the instant at tau = 0."""
    wall, (q, s, x1, v1, tau) = side.wall, y
    z, weight = depth_of(wall, q), weight_of(wall, q)
    drive, force = drive_now(after(side.ps, phase, tau)), force_of(wall, q, z, s)
    dv, ds = accelerations_at(side, side.ps, (x1, v1, wall.gap + z, s), drive, force)
    return rate_of_q(wall, s), weight * ds, weight * v1, weight * dv, weight


@jit
def moved_by(y, h, rates):
    return (
        y[0] + h * rates[0], y[1] + h * rates[1], y[2] + h * rates[2], y[3] + h * rates[3],
        y[4] + h * rates[4],
    )  # fmt: skip


@jit
def runge_kutta(side, step):
    """Write row NEW where a `Step` from row Y ends."""
    k, h, phase = side.k, step.h, step.phase
    y = k[OLD], k[OLD + 1], k[OLD + 2], k[OLD + 3], 0.0
    a = rates_at(side, phase, y)
    b = rates_at(side, phase, moved_by(y, 0.5 * h, a))
    c = rates_at(side, phase, moved_by(y, 0.5 * h, b))
    d = rates_at(side, phase, moved_by(y, h, c))
    for i in range(5):
        k[NEW + i] = y[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i])
    if step.landing:
        k[NEW] = 0.0


# ---- Taylor polynomials --------------------------------------------------------------------------


@jit
def order_of(rk4):
    """Return the degree in theta; under rk4, where only variations have series, its order."""
    if rk4 is None:
        return HIGHEST
    return ORDER_OF_RK4


@jit
def expand_contact(side, tangent, phase, h):
    """Fill the series from row OLD on, at the instant `phase`, in units for steps of about h.

    With `tangent`, also those of four variations (x1, v1, r, s) at fixed time. They obey the
    linearized equation with the contact's stiffness, for Hertz' law 3/2 K sqrt(z) = 3/2 K q, which
    is a polynomial, too, and their source (`driven`).
    """
    k = side.k
    k[UNIT] = power_of_two(min(max(exponent_of(h), LEAST_UNIT), LARGEST_UNIT))
    k[SERIES + AT_Q], k[SERIES + AT_S] = k[OLD], k[OLD + 1]
    k[SERIES + AT_X], k[SERIES + AT_V] = k[OLD + 2], k[OLD + 3]
    k[SERIES + TAU] = 0.0
    # the first coefficient of the force's series
    if is_a(phase, Moment):
        # the load's polynomial in the time from this instant on: a Taylor shift
        top, at = phase.degree, SERIES + LOADED
        for j in range(HIGHEST + 1):
            k[at + j] = phase.w[phase.row + j] if j <= top else 0.0
        for j in range(top):
            for i in range(top - 1, j - 1, -1):
                k[at + i] += phase.x * k[at + i + 1]
        per = 1.0
        for j in range(top + 1):
            k[at + j] *= per
            per /= phase.length
        k[SERIES + COSINE] = k[at]
    else:
        k[SERIES + COSINE], k[SERIES + SINE] = phase
    if tangent is not None:
        k[SERIES + SHRINKS] = 0.0
        for i in range(4):
            for j in range(4):
                k[SERIES + VARIED + 4 * i + j] = k[OLD + WIDTH + 4 * j + i]
    for n in range(order_of(side.rk4)):
        fill_terms(side, n)
        if tangent is not None:
            fill_variations(side, tangent, n)
        # coefficient n + 1 of the motion, from coefficient n of dt/dtheta times its rate
        row = SERIES + COLUMNS * n
        i, j, sums, others, sine = SERIES + WEIGHT, row + DS, four(0.0), four(0.0), 0.0
        rates = four_of(
            k[j], k[j + 1], k[j + 2], k[j + 3]
        )  # four_at waits until they are in memory
        for _ in range((n + 1) // 2):  # two sums at a time, neither of which waits for the other
            sums = sums + k[i] * rates
            others = others + k[i + COLUMNS] * four_at(k, j - COLUMNS)
            sine += k[i] * k[j + (SINE - DS)] + k[i + COLUMNS] * k[j - COLUMNS + (SINE - DS)]
            i, j = i + 2 * COLUMNS, j - 2 * COLUMNS
            rates = four_at(k, j)
        if n % 2 == 0:
            sums = sums + k[i] * rates
            sine += k[i] * k[j + (SINE - DS)]
        sums = sums + others
        per, behind = k[UNIT] / (n + 1.0), row + COLUMNS
        k[behind + AT_Q] = per * rate_of_q(side.wall, k[row + AT_S])
        k[behind + AT_S] = per * number_of(sums, 0)
        k[behind + AT_V], k[behind + AT_X] = per * number_of(sums, 1), per * number_of(sums, 2)
        k[behind + TAU] = per * k[row + WEIGHT]
        drive_term(side.ps, phase, k, n + 1, (number_of(sums, COSINE - DS), sine))


@jit
def fill_terms(side, n):
    """Fill coefficient n of the contact's terms, of the force and of the accelerations."""
    wall, k, row = side.wall, side.k, SERIES + COLUMNS * n
    contact_terms(wall, k, n)
    force = wall.K * damped_term(wall, k, int(ELASTIC), n)
    x1, v1, drive = k[row + AT_X], k[row + AT_V], k[row + COSINE]
    z, s = k[row + DEPTH], k[row + AT_S]
    if n == 0:
        dv, ds = accelerations_at(side, side.ps, (x1, v1, wall.gap + z, s), drive, force)
    else:  # constants have no higher powers
        dv, ds = accelerations_at(side, unloaded(side.ps), (x1, v1, z, s), drive, force)
    k[row + FORCE], k[row + DS], k[row + DV] = force, ds, dv


@jit
def fill_variations(side, tangent, n):
    """Fill coefficient n of the rates of variations and n + 1 of variations and of ln(volume)."""
    wall, k, row = side.wall, side.k, SERIES + COLUMNS * n
    k[row + STEEP] = steep_term(wall, k, n)
    k[row + STIFF] = damped_term(wall, k, int(STEEP), n)
    push = four(0.0)
    for m in range(n + 1):
        stiff = k[SERIES + COLUMNS * m + STIFF]
        push = push + stiff * four_at(k, row - COLUMNS * m + VARIED + 8)
    per, behind = k[UNIT] / (n + 1.0), row + COLUMNS
    if wall.damping is not None:
        k[row + DRAG] = drag_term(wall, k, n)
        for m in range(n + 1):
            drag = k[SERIES + COLUMNS * m + DRAG]
            push = push + drag * four_at(k, row - COLUMNS * m + VARIED + 12)
        drained = product(k, int(WEIGHT), int(DRAG), n)
        k[behind + SHRINKS] = -per * (side.damper.inv_mu * drained)
    a, b = four_at(k, row + VARIED), four_at(k, row + VARIED + 4)
    r, u = four_at(k, row + VARIED + 8), four_at(k, row + VARIED + 12)
    db, du = accelerations(unloaded(side.ps), side.damper, a, b, r, u, 0.0, push)
    put_four(k, row + RATES, b)
    put_four(k, row + RATES + 4, db)
    put_four(k, row + RATES + 8, u)
    put_four(k, row + RATES + 12, du)
    if is_a(tangent, Driven):
        drive_terms(side, tangent, n)
    for c in range(0, 16, 4):
        sums = four(0.0)
        for m in range(n + 1):
            weight = k[SERIES + COLUMNS * m + WEIGHT]
            sums = sums + weight * four_at(k, row - COLUMNS * m + RATES + c)
        put_four(k, behind + VARIED + c, per * sums)


@jit
def along_series(side, step):
    k, row = side.k, SERIES + COLUMNS * HIGHEST
    h = step.h / k[UNIT]
    motion, v = four_at(k, row), k[row + AT_V]
    while row > SERIES:
        row -= COLUMNS
        motion, v = motion * h + four_at(k, row), v * h + k[row + AT_V]
    k[NEW] = 0.0 if step.landing else number_of(motion, AT_Q)
    k[NEW + 1], k[NEW + 2], k[NEW + 4] = (
        number_of(motion, AT_S), number_of(motion, AT_X), number_of(motion, TAU)
    )  # fmt: skip
    k[NEW + 3] = v


@jit
def advance(side, tangent, step):
    """Write the end of a `Step` into row NEW, with `tangent` variations, too.

    By the series, or by a Runge-Kutta step under rk4, where only variations have series.
    """
    k = side.k
    if side.rk4 is None:
        along_series(side, step)
    else:
        runge_kutta(side, step)
    if tangent is not None:
        h, row = step.h / k[UNIT], SERIES + COLUMNS * order_of(side.rk4)
        a, b = four_at(k, row + VARIED), four_at(k, row + VARIED + 4)
        r, u = four_at(k, row + VARIED + 8), four_at(k, row + VARIED + 12)
        shrinks = k[row + SHRINKS]
        while row > SERIES:
            row -= COLUMNS
            a, b = a * h + four_at(k, row + VARIED), b * h + four_at(k, row + VARIED + 4)
            r, u = r * h + four_at(k, row + VARIED + 8), u * h + four_at(k, row + VARIED + 12)
            shrinks = shrinks * h + k[row + SHRINKS]
        k[NEW + VOLUME] = shrinks
        for j in range(4):
            i = NEW + WIDTH + 4 * j
            k[i], k[i + 1], k[i + 2], k[i + 3] = (
                number_of(a, j), number_of(b, j), number_of(r, j), number_of(u, j)
            )  # fmt: skip


@jit
def slopes(side, h):
    """Return the derivatives by theta of (q, s, x1, tau), as a four, and of v1 at theta = h."""
    k, n = side.k, 1.0 * order_of(side.rk4)
    row = SERIES + COLUMNS * order_of(side.rk4)
    motion, v = n * four_at(k, row), n * k[row + AT_V]
    x, per = h / k[UNIT], 1.0 / k[UNIT]
    while n > 1.0:
        n, row = n - 1.0, row - COLUMNS
        motion, v = motion * x + n * four_at(k, row), v * x + n * k[row + AT_V]
    return per * motion, per * v


@jit
def defect_of(side, drive, h, scales):
    """Return the error of a step h to row NEW, relative to scales of speed, depth and q.

    It is h / (N + 1) of the defect of eq. (5) there, with the force of the law itself. drive: the
    force on the structure there.
    """
    wall, k, (fast, deep, root) = side.wall, side.k, scales
    q, s = k[NEW], k[NEW + 1]
    z, weight = depth_of(wall, q), weight_of(wall, q)
    force = force_of(wall, q, z, s)
    y = k[NEW + 2], k[NEW + 3], wall.gap + z, s
    dv, ds = accelerations_at(side, side.ps, y, drive, force)
    motion, v = slopes(side, h)
    missing = abs(number_of(motion, AT_S) - weight * ds) + abs(v - weight * dv)
    late = abs(number_of(motion, TAU) - weight) * fast / (wall.lasting * deep)
    off = abs(number_of(motion, AT_Q) - rate_of_q(wall, s)) / root
    return h * (missing / fast + late + off) / (order_of(side.rk4) + 1.0)


@jit
def length_of(side, h, tolerance, fast):
    """Return the length of a step, at most h, whose last two terms are at most a tolerance.

    They are those of the velocities, in units of `fast` [m/s]. Variations, whose polynomials have
    the same radius of convergence, do not count: they must not change an orbit.
    """
    k, n = side.k, order_of(side.rk4)
    less, x = 0.0, h / k[UNIT]  # less: the logarithm of the share of h
    for m in range(n - 1, n + 1):
        row = SERIES + COLUMNS * m
        last = max(abs(k[row + AT_S]), abs(k[row + AT_V])) * whole_power(x, m) / fast
        if last > tolerance:
            less = min(less, log(tolerance / last) / m)
    return exp(less) * h


@jit
def piece_of(side, h):
    """Return the step h from row OLD as a `StepPiece`.

    This also fills the last coefficient of the rates, which the step itself does not need.
    """
    k, sign = side.k, side.sign
    fill_terms(side, order_of(side.rk4))
    power = 1.0
    for n in range(HIGHEST + 1):
        k[LENGTHS + n] = power
        power *= h / k[UNIT]
    for n in range(HIGHEST + 1):
        row, i, part = SERIES + COLUMNS * n, COEF + 4 * n, k[LENGTHS + n]
        k[i], k[i + 1] = part * k[row + AT_X], part * k[row + AT_V]
        part *= sign
        k[i + 2], k[i + 3] = part * k[row + DEPTH], part * k[row + AT_S]
    k[COEF + 2] += sign * side.wall.gap
    return StepPiece(k, sign)


@jit
def part_of(step, x):
    return Step(step.phase, step.landing and x == 1.0, x * step.h)


@jit
def set_aside(k):
    """Copy row NEW to row SAVE."""
    for i in range(ROW):
        k[SAVE + i] = k[NEW + i]


@jit
def restore(k):
    """Copy row SAVE to row NEW."""
    for i in range(ROW):
        k[NEW + i] = k[SAVE + i]
