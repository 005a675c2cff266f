"""Contacts that are stepped: depth, release, how steps are judged; walls of different laws."""

import numpy as np
import pytest
from support import BOTH, NOTHING, follow_contact, side_of
from test_impact_variations import APPROACH, impact_with

from nlds_vines import load_system, simulate
from nlds_vines.kernels.events import contact as stepping
from nlds_vines.kernels.events.contact import Steps, contact
from nlds_vines.kernels.motion import taylor
from nlds_vines.kernels.scene import law as series
from nlds_vines.kernels.scene.codes import RELEASED, STOPPED
from nlds_vines.kernels.scene.drive import after, drive_now
from nlds_vines.kernels.scene.scene import Step
from nlds_vines.model.system import System

WAVE = APPROACH.wave
FREE = dict.fromkeys(("k1", "c1", "k2", "c2", "P"), 0.0)


def follow(parts, q, s, x1, v1, stop=1e3, steps=28.0, rk4=None):
    """Follow a contact from phase 1 and return what `contact` does."""
    side = side_of(parts, steps=Steps(steps, np.inf), rate=10.0, rk4=rk4)
    return follow_contact(side, WAVE, (q, s, x1, v1), stop)


@pytest.mark.parametrize("steps", [6.0, 8.0, 12.0, 28.0])
@pytest.mark.parametrize("speed", [0.01, 1.0])
def test_depth_of_a_free_impact_is_as_good_as_the_steps(steps, speed):
    """Steps of order fourteen leave 1e-10 at 12. Notices: the parabola left out."""
    parts = impact_with(**FREE).parts
    exact = (speed / parts[2].speed) ** 0.8
    depth = follow(parts, 0.0, speed, 0.0, 0.0, steps=steps)[6]
    assert abs(depth / exact - 1) <= 1.5e-10 * (12 / steps) ** 13 + 4e-15


@pytest.mark.parametrize("share", [0.5005, 0.503, 0.51, 0.53, 0.56])
@pytest.mark.parametrize("rk4", [None, True])
def test_depth_where_a_section_cuts_the_contact_behind_it(share, rk4):
    """The deepest point then lies in a step that the section has cut short."""
    parts = impact_with(c2=500.0).parts
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
    parts = impact_with(**soft, P=2858.5, K=7970.98).parts
    start = 0.0, 8.7324, 0.13344, -0.62335
    wave = np.cos(1.7384), np.sin(1.7384)
    depths = [
        follow_contact(side_of(parts, steps=steps, rate=32.6), wave, start, 1.0)[6]
        for steps in [Steps(300.0, np.inf)] + [Steps(n, 1e-4) for n in np.linspace(4.2, 5.4, 25)]
    ]
    assert depths == pytest.approx([depths[0]] * 26, rel=2.5e-7)


def test_a_damper_that_is_out_and_back_by_the_end_of_a_step_is_released():
    """Slowly. Notices: a step of which only the end is looked at."""
    parts = impact_with(K=1e5, k2=5e3, near=-0.05, c2=0.0).parts
    for s in (-0.1460, -0.1463, -0.15):
        few, fine = (follow(parts, 0.05, s, 0.0, 0.0, stop=0.15, steps=n) for n in (3.0, 112.0))
        assert few[0] == fine[0]
        assert few[5] == pytest.approx(fine[5], rel=1e-3)


def test_a_damper_that_is_pressed_back_before_it_is_out_stays_in_contact():
    """The preload turns it round; a landing would take it out. Notices: other forces ignored."""
    parts = impact_with(K=1e5, k2=5e3, near=-0.05, c2=0.0).parts
    events = []
    for s in (-0.10, -0.12, -0.13, -0.14, -0.16, -0.2):
        event, *_, took, depth = follow(parts, 0.05, s, 0.0, 0.0, stop=0.15)
        fine = follow(parts, 0.05, s, 0.0, 0.0, stop=0.15, steps=112.0)
        assert (event, took) == (fine[0], pytest.approx(fine[5], rel=1e-9))
        assert depth == pytest.approx(fine[6], rel=1e-9)
        events.append(event)
    assert events == [STOPPED] * 4 + [RELEASED] * 2


def largest_error(parts, tolerance):
    """Return the largest error of speed and of time of contacts that begin too coarsely."""
    side, errors = side_of(parts, steps=Steps(3.0, tolerance), rate=10.0), []
    for speed in (0.05, 0.3, 1.3, 4.0):
        start = 0.0, speed, 0.011, 0.2
        true, one = follow(parts, *start, steps=60.0), contact(side, NOTHING, WAVE, start, 1e3)
        errors += [abs(one[2] / true[2] - 1), abs(one[5] / true[5] - 1)]
    return max(errors)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_steps_that_are_foreseen_much_too_long_are_found_out(tolerance, monkeypatch):
    """As if the last terms of a step allowed any length. Notices: no check of a step at its end."""
    parts = impact_with(K=1e6).parts
    monkeypatch.setattr(stepping, "length_of", lambda side, h, *others: h)
    assert largest_error(parts, tolerance) <= tolerance
    monkeypatch.setattr(stepping, "defect_of", lambda *arguments: 0.0)
    assert largest_error(parts, tolerance) >= 10 * tolerance


def test_a_wrong_series_is_doubted(monkeypatch):
    """A force whose series is off by 1e-6 of it. Notices: a defect by the series itself."""
    parts = impact_with(K=1e6).parts
    side = side_of(parts, steps=Steps(20.0, np.inf), rate=10.0)
    doubts = []
    for wrong in (0.0, 1e-6):
        plain = taylor.contact_terms

        def contact_terms(wall, k, n, plain=plain, wrong=wrong):
            plain(wall, k, n)
            k[series.SERIES + series.COLUMNS * n + series.ELASTIC] *= 1.0 + wrong

        monkeypatch.setattr(taylor, "contact_terms", contact_terms)
        side.k[series.OLD : series.OLD + 4] = 0.08, 0.5, 0.011, 0.2
        taylor.expand_contact(side, None, WAVE, 0.04)
        taylor.advance(side, None, Step(WAVE, False, 0.04))
        drive = drive_now(after(parts[0], WAVE, side.k[series.NEW + 4]))
        doubts.append(taylor.defect_of(side, drive, 0.04, (1.0, 0.01, 0.1)))
        monkeypatch.setattr(taylor, "contact_terms", plain)
    assert doubts[0] < 1e-12
    assert doubts[1] > 1e-10


STEEP = 3e7  # K of the powers


def test_each_wall_has_its_own_law():
    """The structure's contact as a power of 3/2 is that of Hertz; another changes the orbit."""
    plain = load_system("ssbl", K=STEEP)
    same = plain.with_(law_2="power", K_2=STEEP, exponent_2=1.5)
    rigid = plain.with_(law_2="restitution", e_2=1.0)
    stiff = plain.with_(law_2="hertz", K_2=1e16)
    walls = plain, same, rigid, stiff
    a, b, c, d = (simulate(system, 10, record=BOTH, tolerance=1e-12) for system in walls)
    assert set(a.impacts["wall"]) == {"structure", "obstacle"}
    np.testing.assert_allclose(b.section, a.section, rtol=0, atol=1e-9)
    assert np.abs(c.section - a.section).max() > 1e-4
    np.testing.assert_allclose(c.section[:3], d.section[:3], rtol=0, atol=1e-5)
    of = c.impacts["wall"] == "structure"
    assert np.isinf(c.impacts["force"][of]).all()
    assert np.isfinite(c.impacts["force"][~of]).all()


def test_the_second_stop_is_the_mirror_of_the_first():
    """Half a period later the force is the opposite: the mirror runs the mirrored orbit."""
    numbers = {"m": 1.0, "k": 1.0, "c": 0.1, "C": 0.4, "C_2": 0.5, "P": 0.7, "omega": 1.3}
    one = System(
        "oscillator-2", {**numbers, "e": 0.7, "kc_2": 50.0}, law="restitution", law_2="linear"
    )
    other = System(
        "oscillator-2", {**numbers, "C": 0.5, "C_2": 0.4, "kc": 50.0, "e_2": 0.7},
        law="linear", law_2="restitution",
    )  # fmt: skip
    record = (*BOTH, "trajectory")
    a = simulate(one, 40, start=(0.1, 0.2), record=record, samples=2)
    half = a.trajectory[0]  # the state at T / 2
    b = simulate(other, 39, start=-half, record=record, samples=2)
    assert set(a.impacts["wall"]) == {"stop", "second stop"}
    np.testing.assert_allclose(b.trajectory[1::2], -a.trajectory[2:-1:2], rtol=0, atol=1e-9)


def test_both_stops_of_a_symmetric_orbit_take_the_same_force():
    """The impact at one stop is the mirror image of that at the other, and no repetition of it."""
    numbers = {"m": 1.0, "k": 1.0, "c": 0.2, "C": 1.0, "C_2": 1.0, "P": 1.5, "omega": 0.9}
    system = System("oscillator-2", {**numbers, "K": 1e6})
    orbit = simulate(system, 2, transient=100, record=("impacts", "response"))
    assert orbit.impacts["wall"].tolist() == ["stop", "second stop"] * 2
    assert orbit.response["force_max"] == pytest.approx(orbit.impacts["force"][:2], rel=1e-8)


def test_a_base_that_moves_is_a_force():
    numbers = {"m": 2.0, "k": 3.0, "c": 0.1, "C": 0.4, "omega": 1.3, "e": 0.7}
    shaken = System("oscillator", {**numbers, "Y": 0.2}, law="restitution")
    forced = System("oscillator", {**numbers, "P": 2.0 * 0.2 * 1.3**2}, law="restitution")
    np.testing.assert_allclose(
        simulate(shaken, 20).section, simulate(forced, 20).section, rtol=0, atol=1e-13
    )
    assert shaken.with_(P=1.0).parameters["P"] == 1.0
