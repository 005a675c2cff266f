"""A constant load in short impacts: whatever they are solved for knows of it.

The load presses a body of Set 6 into its wall, or pulls it off, by a part of the contact's own
force; all is compared with small steps, whose forces are those of `scene.accelerations`.
"""

import math

import numpy as np
import pytest
from plain_inside import PHASE, TOUCH, ahead_of, stepped, stepping
from support import Approach, contact_parts, references, side_of
from test_impact_variations import APPROACH, Impact

from nlds_vines import load_system, simulate
from nlds_vines.kernels.impact import impact, inside
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.scene.codes import RELEASED
from nlds_vines.kernels.scene.scene import with_load
from nlds_vines.kernels.watch.observe import LIMIT, energies
from nlds_vines.kernels.watch.touch import may_pass

SET6 = references()["ssul-set6"].numbers
LOADS = (30.0, -30.0)  # [m/s^2]; the contact's own acceleration is some 3000


def loaded(load, **changes):
    ps, damper, wall = contact_parts(**{**SET6, "near": SET6["C"], **changes})
    return with_load(ps, load), damper, wall


def dropped(tolerance, **law):
    """Return the first impact of a ball of 1 kg that falls 1 m under g = 10 m/s^2."""
    ball = load_system("bouncing-ball", law="hertz", K=1e5, g=10, Y=0, omega=1, **law)
    return simulate(ball, 1, start=(1, 0), record=("impacts",), tolerance=tolerance).impacts[0]


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_a_ball_that_falls_on_a_soft_table(tolerance):
    """At the deepest point 0.4 K z^2.5 = m g (h + z); the time is twice a quadrature."""
    orbit = dropped(tolerance)
    assert orbit["depth"] == pytest.approx(0.036766164808134, rel=tolerance)
    assert orbit["release"] - orbit["touch"] == pytest.approx(0.024010630555907, rel=tolerance)
    assert orbit["force"] == pytest.approx(1e5 * orbit["depth"] ** 1.5, rel=1e-12)


@pytest.mark.parametrize(("load", "tolerance"), [(30.0, 1e-6), (-30.0, 1e-9), (30.0, 1e-12)])
def test_a_short_impact_is_that_of_small_steps(load, tolerance):
    parts, arc = loaded(load), make_arc(tolerance)
    approach = Approach(*TOUCH, 1.0)
    ahead = ahead_of(arc, parts=parts)
    true = approach.step(parts, 200)
    s, x1, v1 = ahead.release
    assert -s == pytest.approx(true.speed, rel=tolerance)
    assert ahead.took == pytest.approx(true.duration, rel=tolerance)
    assert v1 == pytest.approx(true.v1, abs=tolerance * TOUCH[0])
    assert approach.solve(parts, 24).depth == pytest.approx(true.depth, rel=1e-12)
    for share in (0.01, 0.4, 0.6, 0.99):
        time = share * ahead.took
        _, q, s, x1, v1 = stepped(time, parts=parts)
        p, *others = inside.state_inside(stepping(arc, parts), PHASE, ahead, time)
        off = np.abs(np.array([p * p, *others]) - (q * q, s, x1, v1))
        scales = TOUCH[0] * ahead.took, TOUCH[0], TOUCH[0] * ahead.took, TOUCH[0]
        assert (off / scales).max() <= tolerance + 1e-13


@pytest.mark.parametrize("load", LOADS)
def test_its_largest_energies_are_those_of_small_steps(load):
    parts, arc = loaded(load), make_arc(1e-9)
    ps, damper, wall = parts
    ahead, (s, x1, v1) = ahead_of(arc, parts=parts), TOUCH
    energy = np.array(energies(ps, damper, x1, v1, wall.gap, s))
    true = energy.copy()
    assert stepped(1.0, true, parts=parts)[0] == RELEASED
    inside.note_inside(stepping(arc, parts), energy, PHASE, ahead, (0.0, *TOUCH), ahead.took)
    np.testing.assert_allclose(energy, true, rtol=1e-9)


@pytest.mark.parametrize("load", LOADS)
def test_its_variations_are_those_of_small_steps(load):
    """To its release, and to a section in either half. Notices: factors that know of no load."""
    arc, of = make_arc(1e-9), Impact(loaded(load), APPROACH)
    assert of.error(arc) <= 1e-9
    for share in (0.3, 0.8):
        ahead, (first, _) = of.cut(arc, share)
        exact = of.matrix(of.stepped(100.0, ahead.elapsed)[0])
        assert np.abs(of.matrix(first) - exact).max() <= 1e-9 * np.abs(exact).max()


def test_an_impact_is_doubted_whose_solution_lacks_a_force(monkeypatch):
    """The balance has its forces from the equation of motion, not from what solves the impact."""
    parts, arc = loaded(30.0), make_arc(1e-9)
    arguments = side_of(parts, arc), None, PHASE, (0.0, *TOUCH)
    assert impact.short_impact(*arguments)[0]
    monkeypatch.setattr(impact, "under", lambda load, alone: alone)
    assert not impact.short_impact(*arguments)[0]


def test_a_limit_may_be_passed_because_of_a_load():
    """An impact reaches farther under a load that presses than its energy at touch alone would."""
    ps, damper, wall = loaded(300.0, P=0.0, k2=0.0, c1=0.0, k1=0.0, c2=0.0)
    ps = ps._replace(m1=1e9)
    touch = 1.3, 0.0, 0.0
    log = np.zeros(6)
    log[LIMIT] = wall.gap + 1.001 * (math.sqrt(damper.m2 / 0.8 / wall.K) * touch[0]) ** 0.8
    assert may_pass(side_of((ps, damper, wall)), log, PHASE, 0.01, touch)
    assert not may_pass(side_of((with_load(ps, 0.0), damper, wall)), log, PHASE, 0.01, touch)
