"""A response over steps of a contact.

Integrals are sums over Gauss points of each step. A quantity can be largest at an end of a step or
where its rate vanishes within it.
"""

from __future__ import annotations

from ..motion.response_sums import (
    A2,
    CV,
    CX,
    LOSS,
    OF_FOOT,
    OF_FORCE,
    POINTS,
    R2,
    S2,
    U2,
    V2,
    WEIGHTS,
    X2,
    Y2,
    beside,
    motion_of,
    place_of,
    raise_to,
)
from ..motion.taylor import advance, part_of, restore, save
from ..numerics.compiling import jit
from ..numerics.roots import ROOT_STEPS, narrowed, secant
from ..scene.contact_series import NEW, OLD, SAVE
from ..scene.drive import after, drive_now
from ..scene.law import depth_of, elastic, force_of, pushed_by, stiffness_of, weight_of
from ..scene.scene import accelerations
from .observe import NEAR_PEAK, opposite


@jit
def may_rise(top, before, after, rate, slope, time):
    """Tell whether a quantity may exceed its largest, where its rate changes sign in a `time` [s].

    before, after: its values at the ends, rate and slope: its rates there.
    """
    if not opposite(rate, slope):
        return False
    reach = min(abs(before) + abs(rate) * time, abs(after) + abs(slope) * time)
    return reach > top


@jit
def raise_all(tally, sign, values):
    """Raise the maxima of all quantities to their values in one state."""
    for which in range(OF_FOOT):
        raise_to(tally.row, place_of(which, sign), values[which])
    if tally.foot is not None:
        raise_to(tally.row, place_of(int(OF_FOOT), sign), values[OF_FOOT])
    raise_to(tally.row, place_of(int(OF_FORCE), sign), values[OF_FORCE])


@jit
def motion_in(side, tally, phase, row):
    """Return `motion_of` a row of a contact, and its force that is not elastic [N].

    phase: that at row Y.
    """
    ps, damper, wall, k = side.ps, side.damper, side.wall, side.k
    q, s, x1, v1 = k[row], k[row + 1], k[row + 2], k[row + 3]
    z, now = depth_of(wall, q), after(ps, phase, k[row + 4])
    y, force = (x1, v1, wall.gap + z, s), force_of(wall, q, z, s)
    _, ds = accelerations(ps, damper, x1, v1, wall.gap + z, s, drive_now(now), force)
    push = pushed_by(wall, stiffness_of(wall, q, s), q, z, s, s, ds)
    values, rates = motion_of(tally, ps, damper, y, now, force, push)
    return values, rates, force - elastic(wall, wall.K, q, z)


@jit
def add_row(side, tally, phase, at, dt):
    """Add `dt` [s] in the state of a row to the integrals; phase: that at row Y."""
    row, now = tally.row, after(side.ps, phase, side.k[at + 4])
    (x1, v1, a1, r, gone, _), rates, loses = motion_in(side, tally, phase, at)
    s, rate, force = rates[3], rates[4], drive_now(now)
    row[X2] += dt * x1 * x1
    row[V2] += dt * v1 * v1
    row[A2] += dt * a1 * a1
    row[R2] += dt * r * r
    row[S2] += dt * s * s
    row[CV] += dt * force * v1
    row[CX] += dt * force * beside(now, x1, s)
    row[LOSS] += dt * loses * s
    row[Y2] += dt * gone * gone
    row[U2] += dt * rate * rate


@jit
def add_step(side, tally, step):
    """Add the integrals over a step, at Gauss points in theta. Row NEW is lost."""
    for i in range(6):
        advance(side, None, part_of(step, POINTS[i]))
        dt = WEIGHTS[i] * step.h * weight_of(side.wall, side.k[NEW])
        add_row(side, tally, step.phase, int(NEW), dt)


@jit
def tally_step(side, tally, step):
    """Add the contact step from row Y to row NEW, which is kept, to a tally."""
    sign, k = side.sign, side.k
    before, rates, _ = motion_in(side, tally, step.phase, int(OLD))
    after, slopes, _ = motion_in(side, tally, step.phase, int(NEW))
    raise_all(tally, sign, before)
    raise_all(tally, sign, after)
    save(k)
    add_step(side, tally, step)
    time = k[SAVE + 4]
    for which in range(6):
        top = tally.row[place_of(which, sign)]
        f0, f1 = rates[which], slopes[which]
        if may_rise(top, before[which], after[which], f0, f1, time):
            low, high = 0.0, 1.0
            for _ in range(ROOT_STEPS):
                x = secant(low, high, f0, f1)
                advance(side, None, part_of(step, x))
                values, turns, _ = motion_in(side, tally, step.phase, int(NEW))
                raise_to(tally.row, place_of(which, sign), values[which])
                if turns[which] == 0.0 or min(x - low, high - x) < NEAR_PEAK:
                    break
                low, high, f0, f1 = narrowed(low, high, f0, f1, x, turns[which])
    restore(k)
