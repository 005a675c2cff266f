"""Force K z^n, or with damping, of Hertz's law, too, K z^n max(0, 1 + a dz/dt).

The damping is Hunt and Crossley's: Journal of Applied Mechanics 42 (1975) 440. The force never
attracts: where 1 + a dz/dt falls through zero the wall lets go until it rises again. This is a
switch of the contact (`contact.up_to_switch`), between which the factor is smooth: 1 + a dz/dt, or
0.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..motion.driven import Driven
from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..numerics.elementary import exp, log, power
from ..scene.law import (
    AT_S,
    COLUMNS,
    DEPTH,
    ELASTIC,
    FORCE,
    LOGARITHM,
    POWERS_OF_Q,
    SERIES,
    STEEP,
    fill_power,
    power_term,
    product,
    scales_of,
)

MOST_ROOT = 6  # largest p of z = q^p; a larger p takes more steps near the touch
SMOOTH = 10.0  # p (n + 1) if p n is no integer; a smaller one makes the first steps shorter
OF_K, EXPONENT, DAMPED = 0, 1, 2  # columns of the rates of constants


class Damping(NamedTuple):
    """The factor `acts` + a dz/dt of the force; both are 0 where the force would attract."""

    acts: float  # 1, or 0 where the wall has let go
    a: float  # [s/m]


class PowerWall(NamedTuple):
    """Obstacle with force K z^n, with or without damping; the numbers are those of `law`."""

    gap: float  # [m]
    K: float  # [N/m^n]
    kappa: float  # K / mu [m^(1 - n) s^-2]
    speed: float
    exponent: float  # n
    root: int  # p of z = q^p
    high: int  # p n is `high` + `fraction`
    fraction: float
    whole: float
    lasting: float
    damping: Any  # `Damping`, or None
    switch: Any  # True with damping: the wall lets go where the factor falls through zero


_PLAIN = PowerWall(0.0, 0.0, 0.0, 0.0, 0.0, 1, 1, 0.0, 0.0, 0.0, None, None)
_DAMPED = _PLAIN._replace(damping=Damping(0.0, 0.0), switch=True)
SORTS = {("power", False): _PLAIN, ("power", True): _DAMPED, ("hertz", True): _DAMPED}


# ---- a wall --------------------------------------------------------------------------------------


@jit
def made(sort, gap, damper, cell):
    root, kappa = root_for(cell.exponent), cell.K * damper.inv_mu
    damping = None if sort.damping is None else Damping(1.0, cell.hunt_crossley)
    return power_wall_with(root, gap, cell.K, cell.exponent, damping, kappa, sort.switch)


@jit
def root_for(n):
    """Return p of z = q^p for a force z^n."""
    for p in range(1, MOST_ROOT + 1):
        if abs(p * n - math.floor(p * n + 0.5)) < 1.0e-12:
            return p
    return math.ceil(SMOOTH / (n + 1.0))


@jit
def power_wall_with(p, gap, K, n, damping, kappa, switch):
    high = math.floor(p * n + 1.0e-12)
    fraction = p * n - high
    if fraction < 1.0e-11:
        fraction = 0.0
    speed, whole, lasting = scales_of(p, n, kappa)
    return PowerWall(
        gap, K, kappa, speed, n, p, int(high), fraction, whole, lasting, damping, switch
    )


@jit
def in_range(sort, cell):
    fine = 0.0 < cell.K < math.inf and 1.0 <= cell.exponent <= 3.0
    return fine and 0.0 <= cell.hunt_crossley < math.inf


# ---- force and energy ----------------------------------------------------------------------------


@jit
def elastic(wall, stiffness, q, z):
    return stiffness * power(q, wall.high, wall.fraction)


@jit
def elastic_term(wall, k, n):
    """Return coefficient n of z^n: by whole powers of q, or of z itself if p n is no integer."""
    if wall.fraction > 0.0:
        return power_term(k, int(DEPTH), wall.exponent, int(ELASTIC), n)
    for m in range(wall.root + 1, wall.high + 1):
        fill_power(k, m, n)
    return k[SERIES + COLUMNS * n + POWERS_OF_Q + wall.high]


@jit
def steep_term(wall, k, n):
    """Return coefficient n of n K z^(n - 1)."""
    scale = wall.exponent * wall.K
    if wall.fraction > 0.0:
        term = power_term(k, int(DEPTH), wall.exponent - 1.0, int(STEEP), n)
        return scale * term if n == 0 else term
    if wall.high == wall.root:
        return scale if n == 0 else 0.0
    return scale * k[SERIES + COLUMNS * n + POWERS_OF_Q + wall.high - wall.root]


@jit
def smooth_up_to(wall, tangent, at, tolerance):
    """Return the q, relative to the greatest, at which z^n is `tolerance` of its greatest value.

    It is infinite if z^n has a power series in q, and no parameter changes the exponent, which
    would add a term z^n ln z.
    """
    rough = wall.fraction > 0.0
    if is_a(tangent, Driven):
        for i in range(len(tangent.rates)):
            rough = rough or tangent.rates[i, at + EXPONENT] != 0.0
    return exp(log(tolerance) / (wall.root * wall.exponent)) if rough else math.inf


@jit
def damped_term(wall, k, column, n):
    """Return coefficient n of a column times 1 + a s, or 0 if the wall has let go."""
    term = k[SERIES + COLUMNS * n + column]
    if wall.damping is None:
        return term
    return wall.damping.acts * term + wall.damping.a * product(k, column, int(AT_S), n)


@jit
def drag_term(wall, k, n):
    return wall.damping.a * wall.K * k[SERIES + COLUMNS * n + ELASTIC]


@jit
def stored(wall, stiffness, z, q):
    return elastic(wall, stiffness, q, z) * z / (wall.exponent + 1.0)


# ---- damping -------------------------------------------------------------------------------------


@jit
def damped(wall, s):
    """Return 1 + a s, or 0 if the wall has let go."""
    if wall.damping is None:
        return 1.0
    return wall.damping.acts + wall.damping.a * s


@jit
def switching(wall, z, s):
    """Return 1 + a s, which is positive while the wall pushes.

    wall: the side's own, not that of `acting`, for which this is 0 once it has let go.
    """
    return damped(wall, s)


@jit
def rate_of_switching(wall, s, ds):
    return ds, wall.damping.a


@jit
def acting(wall, positive):
    """Return the wall that pushes, or that has let go."""
    if wall.damping is None:
        return wall
    acts = 1.0 if positive else 0.0
    return PowerWall(
        wall.gap, wall.K, wall.kappa, wall.speed, wall.exponent, wall.root, wall.high,
        wall.fraction, wall.whole, wall.lasting, Damping(acts, acts * wall.damping.a), wall.switch,
    )  # fmt: skip


# ---- derivatives by parameters -------------------------------------------------------------------


@jit
def fill_constants(sort, change, rates, at):
    rates[at + OF_K], rates[at + EXPONENT] = change.K, change.exponent
    if sort.damping is not None:
        rates[at + DAMPED] = change.hunt_crossley


@jit
def pushed_term(wall, k, by, at, n):
    """Return coefficient n of the derivative of the force [N] by a parameter of K, n and a."""
    row = SERIES + COLUMNS * n
    term = by[at + OF_K] * damped_term(wall, k, int(ELASTIC), n)
    # ln z by z (ln z)' = z'; 0 if the depth begins with 0, where its factor vanishes
    first, logarithm = k[SERIES + DEPTH], 0.0
    if first > 0.0 and n == 0:
        logarithm = log(first)
    elif first > 0.0:
        total = n * k[row + DEPTH]
        for m in range(1, n):
            at_m = SERIES + COLUMNS * m
            total -= m * k[at_m + LOGARITHM] * k[row - COLUMNS * m + DEPTH]
        logarithm = total / (n * first)
    k[row + LOGARITHM] = logarithm
    term += by[at + EXPONENT] * product(k, int(FORCE), int(LOGARITHM), n)
    if wall.damping is not None:
        acts = wall.damping.acts * wall.K
        term += by[at + DAMPED] * (acts * product(k, int(ELASTIC), int(AT_S), n))
    return term
