"""A response over Runge-Kutta steps of a contact.

Integrals are those of the step's own stages. A quantity can be largest at an end of a step or where
its rate vanishes within it.
"""

from __future__ import annotations

from ..motion import runge_kutta as rk
from ..motion.response_sums import OF_FOOT, OF_FORCE, SUMS, motion_of, place_of, raise_to
from ..numerics.compiling import jit
from ..numerics.roots import narrowed, secant
from ..scene.drive import drive_now, later
from ..scene.law import depth_of, force_of, pushed_by, stiffness_of
from ..scene.scene import accelerations
from .observe import PRECISE, opposite

ROOT_STEPS = 40  # of the search for a maximum: it needs some five


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
    """Return `motion_of` a row (q, s, x1, v1, tau) of a contact; phase: that at tau = 0."""
    ps, damper, wall, k = side.ps, side.damper, side.wall, side.k
    q, s, x1, v1 = k[row], k[row + 1], k[row + 2], k[row + 3]
    z = depth_of(wall, q)
    now = later(ps, phase, k[row + 4])
    y, force = (x1, v1, wall.gap + z, s), force_of(wall, q, z, s)
    _, ds = accelerations(ps, damper, x1, v1, wall.gap + z, s, drive_now(now), force)
    push = pushed_by(wall, stiffness_of(wall, q, s), q, z, s, s, ds)
    return motion_of(tally, ps, damper, y, now, force, push)


@jit
def tally_step(side, tally, step):
    """Add the contact step from row Y to row NEW, which is kept, to a tally.

    `slope` has filled the integrands into the rows of its slopes.
    """
    sign, phase, k = side.sign, step.phase, side.k
    for i in range(SUMS):
        tally.row[i] += step.h * rk.mean_of(side.rk4, k, rk.WIDTH + i)
    before, rates = motion_in(side, tally, phase, int(rk.Y))
    after, slopes = motion_in(side, tally, phase, int(rk.NEW))
    raise_all(tally, sign, before)
    raise_all(tally, sign, after)
    rk.save(k)
    time = k[rk.NEW + 4]
    for which in range(6):
        top = tally.row[place_of(which, sign)]
        f0, f1 = rates[which], slopes[which]
        if may_rise(top, before[which], after[which], f0, f1, time):
            low, high = 0.0, 1.0
            for _ in range(ROOT_STEPS):
                x = secant(low, high, f0, f1)
                rk.advance(side, None, rk.part_of(step, x))
                values, turns = motion_in(side, tally, phase, int(rk.NEW))
                raise_to(tally.row, place_of(which, sign), values[which])
                if turns[which] == 0.0 or min(x - low, high - x) < PRECISE:
                    break
                low, high, f0, f1 = narrowed(low, high, f0, f1, x, turns[which])
            rk.restore(k)
