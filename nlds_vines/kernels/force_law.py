"""The force of a contact that is stepped: Hertz's, or any power of the depth.

    F = K z^n, or with damping F = K z^n max(0, 1 + a dz/dt)

(Hunt and Crossley: Journal of Applied Mechanics 42 (1975) 440. It never attracts: where 1 + a dz/dt
falls through zero the wall lets go, and there is no force until it rises again. That is an event of
the contact (`contact.up_to_switch`), and so each factor here is smooth: 1 + a dz/dt, or 0.)

A contact is regularised (`contact_field`) by z = q^p and dt = q^(p - 1) dtheta. For Hertz p = 2.
For another n, p is the least number that makes p n an integer, and the equations polynomial; where
none is small enough, it is so large that a method of order eight sees no end of their smoothness.

Of a free contact with s^2 / 2 + kappa z^(n + 1) / (n + 1) constant, N = p (n + 1):

    from touch to release    theta = 2 p I(N) q_m / v    time = 2 I(n + 1) z_m / v
    I(N) = integral of 1 / sqrt(1 - u^N) over [0, 1]     v = sqrt(2 kappa / (n + 1)) q_m^(N/2)

These are no more than units of how finely to step.
"""

from __future__ import annotations

import math

from .compiling import jit
from .deciding import is_a
from .elementary import exp, fifth_root, hypotenuse, log
from .scene import Damping, LinearWall, PowerWall

WHOLE = 5.607  # theta from touch to release of a free Hertz impact, times sqrt(kappa) q_m^(3/2)
LASTING = 2.943  # time from touch to release of a free Hertz impact, times speed / depth


@jit
def whole_power(q, m):
    """Return q^m for a whole m >= 0."""
    result = 1.0
    while m > 0:
        if m % 2 == 1:
            result *= q
        q *= q
        m //= 2
    return result


@jit
def power(q, m, fraction):
    """Return q^(m + fraction) for q >= 0."""
    result = whole_power(q, m)
    if fraction > 0.0:
        result = result * exp(fraction * log(q)) if q > 0.0 else 0.0
    return result


# ---- depth ---------------------------------------------------------------------------------------


@jit
def depth_of(wall, q):
    """Return the depth z [m] that belongs to q, which is z itself where contacts are linear."""
    if is_a(wall, PowerWall):
        return whole_power(q, wall.root)
    if is_a(wall, LinearWall):
        return q
    return q * q


@jit
def root_of(wall, z):
    """Return the q that belongs to a depth z [m]."""
    if is_a(wall, PowerWall):
        return root_of_power(wall, z)
    if is_a(wall, LinearWall):
        return z
    return math.sqrt(z)


@jit
def root_of_power(wall, z):
    """Return the p-th root of z."""
    if wall.root == 1:
        return z
    if wall.root == 2:
        return math.sqrt(z)
    if not z > 0.0:
        return 0.0
    return exp(log(z) / wall.root)


@jit
def weight_of(wall, q):
    """Return dt/dtheta."""
    if is_a(wall, PowerWall):
        return whole_power(q, wall.root - 1)
    return q


@jit
def rate_of_q(wall, s):
    """Return dq/dtheta at dz/dt = s."""
    if is_a(wall, PowerWall):
        return s / wall.root
    return 0.5 * s


# ---- force ---------------------------------------------------------------------------------------


@jit
def elastic(wall, stiffness, q, z):
    """Return stiffness z^n, for K [N/m^n] the elastic force [N]."""
    if is_a(wall, PowerWall):
        return stiffness * power(q, wall.high, wall.fraction)
    return stiffness * z * q


@jit
def damping_of(wall):
    """Return the `Damping` of a law with damping, None of any other."""
    if is_a(wall, PowerWall):
        return wall.damping


@jit
def damped(wall, s):
    """Return the factor by which damping changes the elastic force."""
    if is_a(wall, PowerWall):
        return factor_of(wall.damping, s)
    return 1.0


@jit
def factor_of(damping, s):
    """Return 1 + a s of `Damping`, 0 where the wall has let go, 1 of None."""
    if damping is None:
        return 1.0
    return damping.acts + damping.a * s


@jit
def acting(wall, pushes):
    """Return a wall as it acts while it `pushes`, or while it has let go: with damping, or 0."""
    if wall.damping is None:
        return wall
    acts = 1.0 if pushes else 0.0
    return PowerWall(
        wall.gap, wall.K, wall.kappa, wall.speed, wall.exponent, wall.root, wall.high,
        wall.fraction, wall.whole, wall.lasting, Damping(acts, acts * wall.damping.a),
    )  # fmt: skip


@jit
def force_of(wall, q, z, s):
    """Return the contact force [N] of a depth z = z(q) that grows with s = dz/dt."""
    if is_a(wall, PowerWall):
        return elastic(wall, wall.K, q, z) * damped(wall, s)
    return elastic(wall, wall.K, q, z)


@jit
def at_depth(wall, stiffness, depth):
    """Return stiffness z^n at a depth z [m], for K the force [N] where nothing moves."""
    if is_a(wall, PowerWall):
        return elastic(wall, stiffness, root_of(wall, depth), depth)
    return stiffness * depth * math.sqrt(depth)


@jit
def stiffness_of(wall, q, s):
    """Return dF/dz [N/m]."""
    if is_a(wall, PowerWall):
        return stiffness_of_power(wall, q, s)
    return 1.5 * wall.K * q


@jit
def stiffness_of_power(wall, q, s):
    """Return n K z^(n - 1) by the power of q, damping included."""
    steep = power(q, wall.high - wall.root, wall.fraction)
    return wall.exponent * wall.K * steep * damped(wall, s)


@jit
def pushed_by(wall, stiffness, q, z, s, r, u):
    """Return the change [N] of the contact force that a variation (r, u) of (z, s) makes."""
    if is_a(wall, PowerWall):
        return stiffness * r + drag_of(wall, q, z, s) * u
    return stiffness * r


@jit
def drag_of(wall, q, z, s):
    """Return dF/ds [N s/m]."""
    if wall.damping is not None:
        return wall.damping.a * elastic(wall, wall.K, q, z)
    return 0.0


# ---- energy and scales ---------------------------------------------------------------------------


@jit
def gained(wall, y, p, z, q):
    """Return by how much the elastic energy per reduced mass [m^2/s^2] rises from (z, q) to (y, p).

    y = z(p) and z = z(q) are depths.
    """
    if is_a(wall, PowerWall):
        return (elastic(wall, wall.kappa, p, y) * y - elastic(wall, wall.kappa, q, z) * z) / (
            wall.exponent + 1.0
        )
    return 0.4 * wall.kappa * (y * y * p - z * z * q)


@jit
def twice_stored(wall, z, q):
    """Return twice the elastic energy [J] of a depth z = z(q)."""
    if is_a(wall, PowerWall):
        return 2.0 * elastic(wall, wall.K, q, z) * z / (wall.exponent + 1.0)
    return 0.8 * wall.K * z * z * q


@jit
def reach_of(wall, q, z, s):
    """Return q^(N/2) where the free contact through (q, s) turns."""
    if is_a(wall, PowerWall):
        return hypotenuse(math.sqrt(z * elastic(wall, 1.0, q, z)), s / wall.speed)
    return hypotenuse(q * q * math.sqrt(q), s / wall.speed)


@jit
def turn_of(wall, reach):
    """Return (q^(N - 2), q) where a free contact turns, whose q^(N/2) there is `reach`."""
    if is_a(wall, PowerWall):
        return turn_of_power(wall, reach)
    return turn_of_hertz(wall, reach)


@jit
def turn_of_hertz(wall, reach):
    """Return (reach^1.2, reach^0.4)."""
    fifth = fifth_root(reach)
    return reach * fifth, fifth * fifth


@jit
def turn_of_power(wall, reach):
    """Return (q^(N - 2), q) by powers of `reach` = q^(N/2)."""
    if not reach > 0.0:
        return 0.0, 0.0
    q = exp(2.0 / (wall.root * (wall.exponent + 1.0)) * log(reach))
    return (reach / q) * (reach / q), q


@jit
def pressed(wall, external):
    """Return the square of the rate by theta of a contact that an acceleration [m/s^2] presses."""
    if is_a(wall, PowerWall):
        return pressed_power(wall, external)
    return abs(external)


@jit
def pressed_power(wall, external):
    """Return n |a| q^(p - 2) at the q where the contact carries the acceleration a."""
    a = abs(external)
    if wall.root == 2 or not a > 0.0:
        return wall.exponent * a
    q = exp(log(a / wall.kappa) / (wall.root * wall.exponent))
    return wall.exponent * a * (q if wall.root == 3 else exp((wall.root - 2.0) * log(q)))


@jit
def faint(wall, ratio):
    """Return the depth [m] at which kappa z^n is `ratio` kappa [m^n]."""
    if is_a(wall, PowerWall):
        return exp(log(ratio) / wall.exponent)
    return exp(2.0 / 3.0 * log(ratio))


@jit
def whole_of(wall):
    """Return theta from touch to release of a free contact in units of its own rate."""
    if is_a(wall, PowerWall):
        return wall.whole
    return WHOLE


@jit
def lasting_of(wall):
    """Return the time from touch to release of a free contact in units of depth / speed."""
    if is_a(wall, PowerWall):
        return wall.lasting
    return LASTING


@jit
def way_of_step(wall, h, s):
    """Return by how much q changes in a step h at the rate s, but for the sign."""
    if is_a(wall, PowerWall):
        return 2.0 * h * s / wall.root
    return h * s
