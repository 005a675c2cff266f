"""A contact as Taylor polynomials in theta, in which it is smooth at touch and at release alike.

The Hertz force z^(3/2) is only once differentiable at z = 0, so a method in time loses its order
at every touch and every release. With q = sqrt(z) and the fictitious time dt = q dtheta, eq. (5)
becomes

    dq/dtheta  = s / 2                    dx1/dtheta = q v1
    ds/dtheta  = q (external - kappa q^3) dv1/dtheta = q (...)       dt/dtheta = q

a polynomial in all its unknowns, so that coefficients of their Taylor polynomials follow one from
the other by products of series alone (`law`). Other laws: `law`. The release is a root
of the polynomial of q.

A step's polynomial is judged by the equation itself: what is missing to it where the step ends,
its defect, grows like h^N of a polynomial of power N, and the step errs by h / (N + 1) of it. It
is taken by the law's own force and not by its series, so that a wrong series is doubted, too.

For a wall that pushes towards -x2 the mirrored state and forcing are handed in: eq. (5) is odd.
"""

from __future__ import annotations

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import exp, exponent_of, log, power_of_two, whole_power
from ..numerics.fours import four, four_at, four_of, number_of, put_four
from ..numerics.roots import guarded
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
from ..scene.scene import Step, StepPiece, accelerations, unloaded
from .driven import Driven, drive_terms
from .flight import COEF

# --------------------------------------------------------------------------------------------------
# A step of a contact by the classical Runge-Kutta method: of rk4, in the variables of `taylor`.
#
# In theta the equations are smooth from touch to release, so that the method keeps its order four
# there. It knows no series: what is asked within a step is another step, as long as that.


@jit
def rates_at(side, phase, y):
    """Return the derivatives of y = (q, s, x1, v1, tau) by theta; phase: the instant at tau = 0."""
    wall, (q, s, x1, v1, tau) = side.wall, y
    z, weight = depth_of(wall, q), weight_of(wall, q)
    drive, force = drive_now(after(side.ps, phase, tau)), force_of(wall, q, z, s)
    dv, ds = accelerations(side.ps, side.damper, x1, v1, wall.gap + z, s, drive, force)
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


MOST_NEWTON = 80  # of the search for a release: it needs some five
NEAREST = 2.0e-16  # error of its place


@jit
def order_of(rk4):
    """Return the highest power of theta: by rk4 that of variations, which is the order of steps."""
    if rk4 is None:
        return HIGHEST
    return ORDER_OF_RK4


@jit
def expand_contact(side, tangent, phase, h):
    """Fill the series of steps from row Y; phase: (cos, sin) of the forcing's there.

    Their terms are of the size of what they sum to where steps are about h long.

    With `tangent`, those of four variations (x1, v1, r, s) at fixed time, too: they obey the
    equation linearized, with the contact's stiffness, of Hertz' law 3/2 K sqrt(z) = 3/2 K q, as
    polynomial as the rest, and what drives them (`driven`).
    """
    k = side.k
    k[UNIT] = power_of_two(min(max(exponent_of(h), LEAST_UNIT), LARGEST_UNIT))
    k[SERIES + AT_Q], k[SERIES + AT_S] = k[OLD], k[OLD + 1]
    k[SERIES + AT_X], k[SERIES + AT_V] = k[OLD + 2], k[OLD + 3]
    k[SERIES + TAU] = 0.0
    # The first coefficient of the force's series.
    if is_a(phase, Moment):
        # The load's polynomial in the time from this instant on, by Horner's scheme.
        top, at = phase.degree, SERIES + LOADED
        for j in range(HIGHEST + 1):
            k[at + j] = phase.sign * phase.w[phase.row + j] if j <= top else 0.0
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
        integrate_term(side, phase, n)


@jit
def fill_terms(side, n):
    """Fill coefficient n of the contact's terms and of what is multiplied by dt/dtheta."""
    ps, damper, wall, k, row = side.ps, side.damper, side.wall, side.k, SERIES + COLUMNS * n
    contact_terms(wall, k, n)
    force = wall.K * damped_term(wall, k, int(ELASTIC), n)
    x1, v1, drive = k[row + AT_X], k[row + AT_V], k[row + COSINE]
    z, s = k[row + DEPTH], k[row + AT_S]
    if n == 0:
        dv, ds = accelerations(ps, damper, x1, v1, wall.gap + z, s, drive, force)
    else:  # what is constant has no higher powers
        dv, ds = accelerations(unloaded(ps), damper, x1, v1, z, s, drive, force)
    k[row + FORCE], k[row + DS], k[row + DV] = force, ds, dv


@jit
def integrate_term(side, phase, n):
    """Fill coefficient n + 1 of the motion: that of dt/dtheta times its rate, over n + 1."""
    k, row = side.k, SERIES + COLUMNS * n
    i, j, sums, others, sine = SERIES + WEIGHT, row + DS, four(0.0), four(0.0), 0.0
    rates = four_of(k[j], k[j + 1], k[j + 2], k[j + 3])  # four_at waits until they are in memory
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
def fill_variations(side, tangent, n):
    """Fill coefficient n of the rates of variations, and n + 1 of these and of their volumes."""
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
    """Write row NEW where a `Step` ends, with `tangent` variations, too.

    By the series; by rk4, which has them for variations alone, a step of Runge and Kutta.
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
    """Return the derivatives of q, s, x1, tau (as a four) and of v1 by theta at a place h."""
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

    drive: cos of the forcing's phase there. What is missing to eq. (5) at its end, by the force
    of the law itself, is (N + 1) / h of what the polynomial errs by. The error of q is that of the
    depth, that of tau of the time.
    """
    ps, wall, k, (fast, deep, root) = side.ps, side.wall, side.k, scales
    q, s = k[NEW], k[NEW + 1]
    z, weight = depth_of(wall, q), weight_of(wall, q)
    force = force_of(wall, q, z, s)
    dv, ds = accelerations(ps, side.damper, k[NEW + 2], k[NEW + 3], wall.gap + z, s, drive, force)
    motion, v = slopes(side, h)
    missing = abs(number_of(motion, AT_S) - weight * ds) + abs(v - weight * dv)
    late = abs(number_of(motion, TAU) - weight) * fast / (wall.lasting * deep)
    off = abs(number_of(motion, AT_Q) - rate_of_q(wall, s)) / root
    return h * (missing / fast + late + off) / (order_of(side.rk4) + 1.0)


@jit
def length_of(side, h, tolerance, fast):
    """Return the length of a step, at most h, of which the last two terms are a tolerance.

    Of all velocities, in parts of fast [m/s]. Variations, whose polynomials have the same radius of
    convergence, have no say: they change nothing of an orbit.
    """
    k, n = side.k, order_of(side.rk4)
    less, x = 0.0, h / k[UNIT]  # the logarithm of what is left of h
    for m in range(n - 1, n + 1):
        row = SERIES + COLUMNS * m
        last = max(abs(k[row + AT_S]), abs(k[row + AT_V])) * whole_power(x, m) / fast
        if last > tolerance:
            less = min(less, log(tolerance / last) / m)
    return exp(less) * h


@jit
def to_release(side, step):
    """Return the step cut short where q falls through zero, q being less than 0 at its end.

    Row NEW is there.
    """
    k, low, high, x = side.k, 0.0, step.h, step.h
    for _ in range(MOST_NEWTON):
        advance(side, None, Step(step.phase, False, x))
        q, slope = k[NEW], rate_of_q(side.wall, k[NEW + 1])
        if q > 0.0:
            low = x
        else:
            high = x
        if q == 0.0 or not high - low > NEAREST * high:
            break
        guess = x - q / slope if slope < 0.0 else low
        if guess == x:
            break
        x = guarded(guess, low, high)
    k[NEW] = 0.0
    return Step(step.phase, True, x)


@jit
def piece_of(side, h):
    """Return the step h from row Y as a `StepPiece`.

    Of the rates, too, the last coefficient is filled, which the step itself has no need of.
    """
    k, sign = side.k, side.sign
    fill_terms(side, order_of(side.rk4))
    power = 1.0
    for n in range(HIGHEST + 1):
        k[LENGTHS + n] = power
        power *= h / k[UNIT]
    for n in range(HIGHEST + 1):
        row, i, part = SERIES + COLUMNS * n, COEF + 4 * n, sign * k[LENGTHS + n]
        k[i], k[i + 1] = part * k[row + AT_X], part * k[row + AT_V]
        k[i + 2], k[i + 3] = part * k[row + DEPTH], part * k[row + AT_S]
    k[COEF + 2] += sign * side.wall.gap
    return StepPiece(k, sign)


@jit
def part_of(step, x):
    return Step(step.phase, step.landing and x == 1.0, x * step.h)


@jit
def set_aside(k):
    """Keep row NEW in row SAVE."""
    for i in range(ROW):
        k[SAVE + i] = k[NEW + i]


@jit
def restore(k):
    """Write what was kept into row NEW again."""
    for i in range(ROW):
        k[NEW + i] = k[SAVE + i]
