"""The contact regularised: smooth at touch and at release alike.

The Hertz force z^(3/2) is only once differentiable at z = 0, so a method in time loses its order
at every touch and every release. With q = sqrt(z) and the fictitious time dt = q dtheta, eq. (5)
becomes

    dq/dtheta  = s / 2                    dx1/dtheta = q v1
    ds/dtheta  = q (external - kappa q^3) dv1/dtheta = q (...)       dt/dtheta = q

a polynomial in all its unknowns: every Runge-Kutta method keeps its full order across the whole
contact, its ends included, and no root is ever taken. With q itself as the independent variable
(Henon's trick) the last step lands on z = 0 exactly.

What a step has done can be judged by the energy and the virial of the contact alone, of which both
sides are known: with a = ds/dt without the Hertz force,

    d(s^2 / 2 + 2/5 kappa q^5)/dtheta = q s a        d(q^2 s)/dtheta = q (s^2 + q^2 ds/dt)

The left sides are functions of the state, the right ones are integrated along with it. (Other
laws: `law`.)

For a wall that pushes towards -x2 the mirrored state and forcing are handed in: eq. (5) is odd.
"""

from __future__ import annotations

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from ..scene.drive import drive_after, drive_now, later
from ..scene.law import (
    depth_of,
    drag_of,
    elastic,
    force_of,
    pushed_by,
    rate_of_q,
    stiffness_of,
    weight_of,
)
from ..scene.scene import accelerations, unloaded, without_shaking
from .driven import Driven, count_of, drive_contact
from .response_sums import A2, CV, CX, LOSS, R2, S2, U2, V2, X2, Y2, Tally, beside, from_foot

WORK, VIRIAL = 21, 22  # places in a row of slopes: the right sides, by theta or by q
DRAIN = 23  # place in a row of slopes: the rate by which damping shrinks volumes


@jit
def work_along(side, tally, step, now, y, out):
    """Fill the integrands of a tally, times dt by theta or q, into a row of slopes.

    now: (force, share of P, (dv1/dt, ds/dt), dt by theta or q, depth) of the row k[y:].
    """
    force, drive, (dv, _), weight, z = now
    k, wall, first = side.k, side.wall, out + 5
    q, s, x1, v1 = k[y], k[y + 1], k[y + 2], k[y + 3]
    r = wall.gap + z
    phase = later(side.ps, step.phase, k[y + 4])
    cosine = drive_now(phase)
    gone, rate = from_foot(tally.foot, x1, v1, phase)
    k[first + X2], k[first + V2] = weight * x1 * x1, weight * v1 * v1
    a1 = without_shaking(side.ps, dv, drive)
    k[first + A2] = weight * a1 * a1
    k[first + R2], k[first + S2] = weight * r * r, weight * s * s
    k[first + CV], k[first + CX] = weight * cosine * v1, weight * cosine * beside(phase, x1, s)
    k[first + LOSS] = weight * (force - elastic(wall, wall.K, q, z)) * s
    k[first + Y2], k[first + U2] = weight * gone * gone, weight * rate * rate


@jit
def vary_along(side, tangent, now, y, out):
    """Fill the slopes of variations, and DRAIN, into a row of slopes; now: as in `work_along`."""
    _, drive, (dv, ds), weight, z = now
    ps, damper, wall, k = side.ps, side.damper, side.wall, side.k
    q, s, x1, v1 = k[y], k[y + 1], k[y + 2], k[y + 3]
    stiffness = stiffness_of(wall, q, s)
    k[out + DRAIN] = weight * (damper.inv_mu * drag_of(wall, q, z, s))
    for i in range(5, 5 + count_of(tangent), 4):
        a, b, r, u = k[y + i], k[y + i + 1], k[y + i + 2], k[y + i + 3]
        push = pushed_by(wall, stiffness, q, z, s, r, u)
        db, du = accelerations(unloaded(ps), damper, a, b, r, u, 0.0, push)
        k[out + i] = weight * b
        k[out + i + 1] = weight * db
        k[out + i + 2] = weight * u
        k[out + i + 3] = weight * du
    if is_a(tangent, Driven):
        drive_contact(side, tangent, (q, z, x1, v1, s), drive, (dv, ds), weight, out)


@jit
def slope(side, tangent, step, y, out):
    """Write the derivative of the row k[y:] = (q, s, x1, v1, tau) into the row k[out:].

    Derivatives are by theta, or, when the `step` is landing, by q, which must then be moving. With
    `tangent`, four variations (x1, v1, r, s) at fixed time follow in the row: they obey the
    equation linearised, with the contact's stiffness, of Hertz' law 3/2 K sqrt(z) = 3/2 K q, as
    polynomial as the rest, and what drives them (`driven`); or the integrands of a tally. The
    places WORK and VIRIAL of the row are filled too, and DRAIN beside variations.
    """
    wall, k = side.wall, side.k
    q, s, x1, v1 = k[y], k[y + 1], k[y + 2], k[y + 3]
    z = depth_of(wall, q)
    force = force_of(wall, q, z, s)
    drive = drive_after(side.ps, step.phase, k[y + 4])
    dv, ds = accelerations(side.ps, side.damper, x1, v1, wall.gap + z, s, drive, force)
    rate, weight = rate_of_q(wall, s), weight_of(wall, q)
    if step.landing:
        weight = weight / rate
        rate = 1.0
    k[out] = rate
    k[out + 1] = weight * ds
    k[out + 2] = weight * v1
    k[out + 3] = weight * dv
    k[out + 4] = weight
    k[out + WORK] = weight * s * (ds + elastic(wall, wall.kappa, q, z))
    k[out + VIRIAL] = weight * (s * s + z * ds)
    if tangent is not None:
        now = force, drive, (dv, ds), weight, z
        if is_a(tangent, Tally):
            work_along(side, tangent, step, now, y, out)
        else:
            vary_along(side, tangent, now, y, out)
