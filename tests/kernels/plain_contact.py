"""A contact that is stepped: where it is deepest, when a step may land on its release, sections."""

import numpy as np
import pytest
from support import NOTHING, Approach, contact_parts, references, side_of

from nlds_vines.kernels.events.contact import Steps, contact, near_release
from nlds_vines.kernels.laws.hertz import HertzWall
from nlds_vines.kernels.motion import runge_kutta as rk
from nlds_vines.kernels.scene.codes import RELEASED, STOPPED
from nlds_vines.kernels.watch.observe import COLUMNS, Impacts

SET6 = references()["ssul-set6"].numbers
WAVE = np.cos(1.0), np.sin(1.0)
FREE = dict.fromkeys(("k1", "c1", "k2", "c2", "P"), 0.0)


def parts_of(**changes):
    return contact_parts(**{**SET6, "near": SET6["C"], **changes})


def follow(parts, q, s, x1, v1, stop=1e3, steps=28.0, rk4=None):
    """Follow a contact from phase 1 and return what `contact` does."""
    noted = Impacts(np.zeros((1, COLUMNS)), np.zeros(1, np.int64))
    side = side_of(parts, steps=Steps(steps, np.inf), rate=10.0, rk4=rk4)
    return contact(side, NOTHING._replace(impacts=noted), WAVE, (q, s, x1, v1), stop)


# ---- the deepest point ---------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [28.0, 32.0, 36.0, 40.0, 44.0, 48.0])
@pytest.mark.parametrize("speed", [0.01, 1.0])
def test_depth_of_a_free_impact_is_as_good_as_the_steps(steps, speed):
    """Steps of order eight leave 1e-11 at 28. Notices: the parabola left out."""
    parts = parts_of(**FREE)
    exact = (speed / parts[2].speed) ** 0.8
    depth = follow(parts, 0.0, speed, 0.0, 0.0, steps=steps)[6]
    assert abs(depth / exact - 1) <= 1.2e-11 * (28 / steps) ** 8 + 4e-15


@pytest.mark.kernels
@pytest.mark.parametrize("share", [0.5005, 0.503, 0.51, 0.53, 0.56])
@pytest.mark.parametrize("rk4", [None, True])
def test_depth_where_a_section_cuts_the_contact_behind_it(share, rk4):
    """The deepest point then lies in a step that the section has cut short."""
    parts = parts_of(c2=500.0)
    start = 0.0, 1.3, 0.011, 0.2
    steps = 28.0 if rk4 is None else 256.0
    event, *_, took, depth = follow(parts, *start, steps=steps, rk4=rk4)
    assert event == RELEASED
    event, q, s, x1, v1, first, before = follow(
        parts, *start, stop=share * took, steps=steps, rk4=rk4
    )
    assert event == STOPPED
    assert first == pytest.approx(share * took, rel=1e-14)
    if s < 0.0:
        assert before == pytest.approx(depth, rel=1e-10 if rk4 is None else 1e-8)
    event, *_, rest, behind = follow(parts, q, s, x1, v1, steps=steps, rk4=rk4)
    assert event == RELEASED
    assert max(before, behind) == pytest.approx(depth, rel=2e-10 if rk4 is None else 1e-8) or (
        s > 0.0  # at another phase, the rest of the contact is another one
    )
    assert rest > 0.0


def test_depth_where_a_contact_comes_to_rest():
    """By long steps, whose end is behind a second turn. Notices: the first guess taken as it is."""
    soft = {"m1": 196.8, "k1": 51223.1, "c1": 843.3, "m2": 53.39, "k2": 1274.4, "c2": 649.0}
    parts = parts_of(**soft, P=2858.5, K=7970.98)
    start = 0.0, 8.7324, 0.13344, -0.62335
    noted = Impacts(np.zeros((1, COLUMNS)), np.zeros(1, np.int64))
    watch, wave = NOTHING._replace(impacts=noted), (np.cos(1.7384), np.sin(1.7384))
    depths = [
        contact(side_of(parts, steps=steps, rate=32.6), watch, wave, start, 1.0)[6]
        for steps in [Steps(300.0, np.inf)] + [Steps(n, 1e-4) for n in np.linspace(4.2, 5.4, 25)]
    ]
    assert depths == pytest.approx([depths[0]] * 26, rel=2.5e-7)


# ---- the release ---------------------------------------------------------------------------------


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("external", "s", "near"),
    [
        (0.0, -2.0, True),
        (0.9, -2.0, True),
        (1.1, -2.0, False),  # pressed back: it may turn before it is out
        (-5.0, -2.0, True),
        (0.9, 2.0, False),  # on the way in
        (0.0, -0.5, False),  # too far for one step
    ],
)
def test_a_step_lands_only_on_a_release_that_is_certain(external, s, near):
    """Notices: the other forces ignored, the direction, the distance."""
    k = np.zeros(rk.SCRATCH)
    k[rk.Y], k[rk.Y + 1] = 1.0, s
    assert near_release(HertzWall(0.0, 1.0, 1.0, 1.0), external, 1.0, k) == near


def test_a_damper_that_is_pressed_back_before_it_is_out_stays_in_contact():
    """The preload turns it round; a landing would take it out. Notices: other forces ignored."""
    parts = parts_of(K=1e5, k2=5e3, near=-0.05, c2=0.0)
    events = []
    for s in (-0.10, -0.12, -0.13, -0.14, -0.16, -0.2):
        event, *_, took, depth = follow(parts, 0.05, s, 0.0, 0.0, stop=0.15)
        fine = follow(parts, 0.05, s, 0.0, 0.0, stop=0.15, steps=112.0)
        assert (event, took) == (fine[0], pytest.approx(fine[5], rel=1e-9))
        assert depth == pytest.approx(fine[6], rel=1e-9)
        events.append(event)
    assert events == [STOPPED] * 4 + [RELEASED] * 2


def test_approaches_of_both_orders_agree():
    parts, approach = parts_of(), Approach(speed=0.7, x1=0.0, v1=0.1, phase=2.0)
    exact = approach.step(parts, 200)
    assert approach.step(parts, 28).difference(exact) <= 1e-10
    assert approach.step(parts, 512, rk4=True).difference(exact) <= 1e-9
