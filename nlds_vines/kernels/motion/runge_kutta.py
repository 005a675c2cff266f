"""A step of a contact by the classical Runge-Kutta method: of rk4, in the variables of `taylor`.

In theta the equations are smooth from touch to release, so that the method keeps its order four
there. It knows no series: what is asked within a step is another step, as long as that.
"""

from __future__ import annotations

from ..numerics.compiling import jit
from ..scene.contact_series import NEW, OLD
from ..scene.drive import after, drive_now
from ..scene.law import depth_of, force_of, rate_of_q, weight_of
from ..scene.scene import accelerations


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
    """Return y + h rates."""
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
