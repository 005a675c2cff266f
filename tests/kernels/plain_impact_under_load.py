"""A short impact under a load, of any shape within its cell, is that of small steps.

Loads of all sizes up to those that are stepped press a body into its wall, shake both, or change so
fast that they matter in their third derivative alone.
"""

import math

import numpy as np
import pytest
from support import NOTHING, contact_parts, side_of

from nlds_vines.kernels.events.contact import Steps, contact
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.impact.impact import approach_of, short_impact
from nlds_vines.kernels.impact.inside import motion_of_touch, tally_nodes
from nlds_vines.kernels.motion.flight import rate_of
from nlds_vines.kernels.motion.response_sums import BEGIN, CV, CX, MOST, SIZE, SUMS, Tally
from nlds_vines.kernels.scene.codes import RELEASED
from nlds_vines.kernels.scene.drive import Moment, later
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS, Impacts

FINE = Steps(80.0, math.inf)
TOLERANCES = (1e-6, 1e-9, 1e-12)
KINDS = ("cubic", "tone", "shaken", "sudden")


def drawn(kind, count, seed=1):
    """Yield (parts, moment, touch) of impacts that are short, parameters and loads over decades."""
    rng = np.random.default_rng(seed)
    arc, drawn_count = make_arc(1e-6), 0

    def decades(low, high):
        return 10.0 ** rng.uniform(low, high)

    while drawn_count < count:
        m2 = decades(-3, 0.5)
        ps, damper, wall = contact_parts(
            m1=1.0, m2=m2, k1=1.0, c1=decades(-3, 0.3), k2=m2 * decades(-2, 2),
            c2=m2 * decades(-3, 1.5), omega=1.0, near=rng.uniform(-1, 2), K=decades(1, 12),
        )  # fmt: skip
        ps = ps._replace(force=1.0, omega=0.0, shaken=True if kind == "shaken" else None)
        h, row, degree, place = 0.7 / rate_of(ps, damper), np.zeros(15), 3, rng.uniform(0, 0.9)
        touch = 0.0, decades(-3, 2), rng.normal() * decades(-2, 1), rng.normal() * decades(-2, 1)
        size, turn = decades(-2, 5), 1j * rng.uniform(0.05, 1.0)
        if kind == "cubic":
            row[:4] = size * rng.normal(size=4)
        elif kind == "sudden":  # nothing but a high power, from the touch on
            degree, place = int(rng.integers(3, 10)), 0.0
            free = approach_of(ps, damper, wall, Moment(row, 0, 0, 0.0, h, 1.0), touch[1:])
            h = min(h, rng.uniform(1.7, 20) * free.tick)
            row[degree] = decades(-4, -1) * wall.kappa * free.b**6 / (1.6 * free.tick / h) ** degree
        else:
            degree, start = 14, np.exp(1j * rng.uniform(0, 6))
            row[:] = [(size * start * turn**k / math.factorial(k)).real for k in range(15)]
        moment = Moment(row, 0, degree, place, h, rng.choice([-1.0, 1.0]))
        if short_impact(side_of((ps, damper, wall), arc), True, moment, touch)[0]:
            drawn_count += 1
            yield (ps, damper, wall), moment, touch


@pytest.mark.parametrize("kind", KINDS)
def test_it_errs_by_less_than_the_tolerance(kind):
    """Speed, duration and depth. Notices: third derivatives without a say in how many nodes."""
    for parts, moment, touch in drawn(kind, 25):
        noted = Impacts(np.zeros((1, IMPACT_COLUMNS)), np.zeros(1, np.int64))
        watch = NOTHING._replace(impacts=noted)
        event, _, s, x1, v1, took, depth = contact(
            side_of(parts, steps=FINE), watch, moment, touch, 1e3
        )
        assert event == RELEASED
        for tolerance in TOLERANCES:
            impact = short_impact(side_of(parts, make_arc(tolerance)), True, moment, touch)
            assert impact[0]
            off = [impact[1] / s - 1, impact[4] / took - 1, impact[5] / depth - 1]
            off.append((impact[3] - v1) / (touch[1] + 1e3 * abs(v1)))
            off.append((impact[2] - x1) / (touch[1] * took + 1e3 * abs(x1)))
            assert np.abs(off).max() <= tolerance + 1e-13


def test_an_impact_that_outlasts_what_is_known_of_a_load_is_none():
    ((parts, moment, touch),) = drawn("cubic", 1)
    side, steady = side_of(parts, make_arc(1e-9)), moment._replace(degree=0)
    took = short_impact(side, None, steady, touch)[4]
    for left, whole in ((1.2, True), (0.9999, False)):
        near_edge = steady._replace(x=1.0 - left * took / moment.length)
        assert short_impact(side, None, near_edge, touch)[0] == whole


@pytest.mark.parametrize("kind", ["cubic", "shaken"])
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_its_response_is_that_of_small_steps(kind, tolerance):
    """Sums and largest values, where the nodes say that they know them."""
    added = 0
    for parts, moment, touch in drawn(kind, 30, seed=3):
        (ps, damper, wall), side = parts, side_of(parts, make_arc(tolerance))
        ground = ps.force if kind == "shaken" else None
        _, s, x1, v1, took, _ = short_impact(side, True, moment, touch)
        after = later(ps, moment, took)
        ends = (touch[2], touch[3], wall.gap, touch[1]), (x1, v1, wall.gap, s)
        row = np.zeros(SIZE)
        seen = [
            motion_of_touch(ps, damper, ground, y, at)
            for y, at in zip(ends, (moment, after), strict=True)
        ]
        row[MOST : MOST + 3] = np.abs(seen)[:, [0, 1, 3]].max(axis=0)
        row[MOST + 3] = abs(wall.gap)
        mine, true = Tally(row.copy(), None, ground), Tally(row.copy(), None, ground)
        if not tally_nodes(side, mine, moment, touch, (s, x1, v1, took)):
            assert (mine.row[:BEGIN] == row[:BEGIN]).all()
            continue
        added += 1
        contact(side_of(parts, steps=FINE), NOTHING._replace(tally=true), moment, touch, 1e3)
        scale = np.where(true.row > 0.0, true.row, 1.0)
        scale[MOST], most = scale[MOST] + touch[1] * took, np.abs(moment.w).sum()
        scale[CV], scale[CX] = (most * math.sqrt(true.row[i] * took) for i in (1, 4))
        off = np.abs(mine.row - true.row)[:BEGIN] / scale[:BEGIN]
        assert off[SUMS:].max() <= tolerance + 1e-13
        assert off[:SUMS].max() <= 10 * tolerance + 1e-12  # places within an arc are less known
    assert added >= 3
