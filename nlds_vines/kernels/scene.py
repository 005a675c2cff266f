"""The parts of a scene as kernels see them: plain numbers, and None for what is absent.

Inside the kernels the state is (x1, v1, r, s): displacement and velocity of the primary structure,
shortening of the damper's spring r = x1 - x2 + rest and its rate s = v1 - v2. The rest state is
then all zeros, the spring pulls with k2 r, and a wall is nothing but a limit of r, so that a
contact's depth z = r - gap carries no cancellation between the two displacements.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .compiling import chosen, is_a, jit


class Structure(NamedTuple):
    """Primary structure and forcing, per unit of mass m1 where that saves a division."""

    m1: float
    k1: float
    stiffness: float  # k1 / m1 [1/s^2]
    damping: float  # c1 / m1 [1/s]
    force: float  # P / m1 [m/s^2]
    omega: float  # [rad/s]


class Damper(NamedTuple):
    """Damper mass on its spring and dashpot."""

    m2: float
    k2: float
    c2: float
    inv_m1: float  # 1 / m1
    inv_mu: float  # 1 / m1 + 1 / m2, mu the reduced mass [1/kg]
    share: float  # mu / m1 = m2 / (m1 + m2)
    rest: float  # x2 - x1 of the unstretched spring [m]


class Ground(NamedTuple):
    """What a wall stands on that limits the structure itself: it never moves.

    A damper without end and without a joint, so the fields are those of `Damper`. Then v2 = 0,
    r = x1 and s = v1: the structure's own motion, which the walls limit.
    """

    m2: float
    k2: float
    c2: float
    inv_m1: float
    inv_mu: float
    share: float
    rest: float


class Wall(NamedTuple):
    """Obstacle with Hertz contact: depth z = r - gap (or -r - gap), force K z^(3/2)."""

    gap: float  # [m]
    K: float  # [N/m^1.5]
    kappa: float  # K / mu [m^-0.5 s^-2]
    speed: float  # sqrt(4 kappa / 5): approach speed = speed * (greatest depth)^(5/4)


class RigidWall(NamedTuple):
    """Obstacle of a rigid body: the approach speed s turns into -e s (`restitution`)."""

    gap: float  # [m]
    e: float  # coefficient of restitution, 0 to 1


@jit
def finite(x):
    """Tell whether a number is neither infinite nor NaN."""
    return abs(x) < math.inf


@jit
def allowed(rk4, has_damper, near, far, cell):
    """Tell whether the parameters of one cell are finite and in range, those of its parts alone.

    `model` has checked them; numbers that came another way must not pass for a result. By rk4 the
    force may be negative; the exact method's bounds of the motion presume P >= 0.
    """
    fine = 0.0 < cell.m1 < math.inf and 0.0 < cell.omega < math.inf
    fine = fine and 0.0 <= cell.k1 < math.inf and 0.0 <= cell.c1 < math.inf
    fine = fine and finite(cell.P) and (rk4 is not None or cell.P >= 0.0)
    if has_damper is not None:
        fine = fine and 0.0 < cell.m2 < math.inf and finite(cell.rest)
        fine = fine and 0.0 <= cell.k2 < math.inf and 0.0 <= cell.c2 < math.inf
    if near is not None:
        fine = fine and law_allowed(near, cell) and finite(cell.near)
    if far is not None:
        fine = fine and law_allowed(far, cell) and finite(cell.far)
        if near is not None:
            fine = fine and cell.near + cell.far >= 0.0
    return fine


@chosen
def law_allowed(sort, cell):
    """Tell whether the constants of a wall's law are in range; sort: a wall of that law."""
    if is_a(sort, RigidWall):
        return lambda sort, cell: 0.0 <= cell.e <= 1.0
    return lambda sort, cell: 0.0 < cell.K < math.inf


@jit
def structure_of(cell):
    """Return the `Structure` of one cell of parameters."""
    m1 = cell.m1
    return Structure(m1, cell.k1, cell.k1 / m1, cell.c1 / m1, cell.P / m1, cell.omega)


@jit
def damper_in(cell):
    """Return the `Damper` of one cell."""
    inv_m1 = 1.0 / cell.m1
    inv_mu = inv_m1 + 1.0 / cell.m2
    return Damper(cell.m2, cell.k2, cell.c2, inv_m1, inv_mu, inv_m1 / inv_mu, cell.rest)


@jit
def ground_under(cell):
    """Return the `Ground` under the structure of one cell."""
    inv_m1 = 1.0 / cell.m1
    return Ground(0.0, 0.0, 0.0, inv_m1, inv_m1, 1.0, 0.0)


@chosen
def damper_of(sort, cell):
    """Return the `Damper` of one cell; its `Ground` where the sort is one; None where it is."""
    if sort is None:
        return lambda sort, cell: None
    if is_a(sort, Ground):
        return lambda sort, cell: ground_under(cell)
    return lambda sort, cell: damper_in(cell)


@chosen
def joined(damper):
    """Return the damper, or None where nothing is joined to the structure."""
    if damper is None or is_a(damper, Ground):
        return lambda damper: None
    return lambda damper: damper


@jit
def wall_at(gap, inv_mu, cell):
    """Return the `Wall` at a limit `gap` of the spring's shortening; inv_mu: of the bodies."""
    kappa = cell.K * inv_mu
    return Wall(gap, cell.K, kappa, math.sqrt(0.8 * kappa))


@chosen
def wall_like(sort, gap, damper, cell):
    """Return the wall at a limit `gap`, of the same law as the wall `sort`; None where it is."""
    if sort is None:
        return lambda sort, gap, damper, cell: None
    if is_a(sort, RigidWall):
        return lambda sort, gap, damper, cell: RigidWall(gap, cell.e)
    return lambda sort, gap, damper, cell: wall_at(gap, damper.inv_mu, cell)


@jit
def accelerations(ps, damper, x1, v1, r, s, drive, contact):
    """Return (dv1/dt, ds/dt), eq. (5) in the kernels' coordinates.

    `drive` is cos(omega t); `contact` the force [N] of a wall on the damper towards +x2.
    """
    alone = ps.force * drive - ps.stiffness * x1 - ps.damping * v1
    if damper is None:
        return alone, 0.0
    pull = damper.k2 * r + damper.c2 * s + contact
    return alone - pull * damper.inv_m1, alone - pull * damper.inv_mu


@jit
def scale_of(ps, damper, x1, v1, r, s):
    """Return S = sqrt(2 E), E the mechanical energy [J] of the structure and the damper's spring.

    Damping only takes energy and the force gives at most P |v1|, hence |dS/dt| <= P / sqrt(m1):
    a bound on the motion ahead that the certificate of `touch` rests on.
    """
    energy = ps.k1 * x1 * x1 + ps.m1 * v1 * v1
    if damper is not None:
        v2 = v1 - s
        energy += damper.k2 * r * r + damper.m2 * v2 * v2
    return math.sqrt(energy)
