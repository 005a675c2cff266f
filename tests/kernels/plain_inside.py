"""Inside a short impact, which is stepped where that is asked: beside small steps."""

import math

import numpy as np
import pytest
from support import NOTHING, contact_parts, references, side_of

from nlds_vines.kernels.events.contact import Steps, contact
from nlds_vines.kernels.impact import inside
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.impact.impact import short_impact
from nlds_vines.kernels.motion.response_sums import BEGIN, MOST, SIZE, SUMS, Tally
from nlds_vines.kernels.scene.codes import RELEASED, STOPPED
from nlds_vines.kernels.watch.observe import energies
from nlds_vines.model.catalog import load_system
from nlds_vines.orbits.simulation import simulate
from nlds_vines.orbits.solver_settings import Settings

SET6 = references()["ssul-set6"].numbers
PARTS = contact_parts(**{**SET6, "near": SET6["C"]})
TOUCH = 1.3, 0.011, 0.2  # s, x1, v1
PHASE = math.cos(1.0), math.sin(1.0)
FINE = Steps(120.0, math.inf)


def stepped(time, energy=None, touch=TOUCH, phase=PHASE, parts=PARTS):
    """Return (event, q, s, x1, v1) of an impact a `time` after its touch, by small steps."""
    watch = NOTHING._replace(energy=energy)
    return contact(side_of(parts, steps=FINE), watch, phase, (0.0, *touch), time)[:5]


def stepping(arc, parts=PARTS):
    """Return a side that steps as finely as its impacts are solved."""
    settings = Settings(tolerance=min(4.0 * arc.tolerance, 1e-12 if arc.settled <= 1e-15 else 1.0))
    return side_of(parts, arc, steps=Steps(settings.steps, settings.stepped_to))


def ahead_of(arc, touch=TOUCH, phase=PHASE, parts=PARTS):
    solved, out, a1, b1, took, _ = short_impact(side_of(parts, arc), None, phase, (0.0, *touch))
    assert solved
    return inside.Ahead(took, 0.0, 0.0, touch, (out, a1, b1))


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_the_state_at_any_time(tolerance):
    """Notices: the half from release taken forward in time; too few nodes."""
    arc = make_arc(tolerance)
    ahead = ahead_of(arc)
    for share in (1e-6, 0.01, 0.2, 0.4, 0.499, 0.501, 0.6, 0.9, 0.999):
        time = share * ahead.took
        event, q, s, x1, v1 = stepped(time)
        assert event == STOPPED
        state, *others = inside.state_inside(stepping(arc), PHASE, ahead, time)
        off = np.abs(np.array([state * state, *others]) - (q * q, s, x1, v1))
        scales = TOUCH[0] * ahead.took, TOUCH[0], TOUCH[0] * ahead.took, TOUCH[0]
        assert (off / scales).max() <= tolerance + 1e-13


def test_the_ends_are_what_they_are():
    arc = make_arc(1e-9)
    ahead = ahead_of(arc)
    assert inside.state_inside(stepping(arc), PHASE, ahead, 0.0) == (0.0, *TOUCH)
    assert inside.state_inside(stepping(arc), PHASE, ahead, ahead.took) == (0.0, *ahead.release)


def test_backward_in_time_an_impact_is_an_impact():
    """From its release it leads to its touch. Notices: a dashpot that still takes."""
    arc = make_arc(1e-12)
    ahead = ahead_of(arc)
    turned = inside.side_backward(side_of(PARTS))
    parts = turned.ps, turned.damper, turned.wall
    angle = 1.0 + turned.ps.omega * ahead.took
    s, x1, v1 = ahead.release
    back = ahead_of(arc, (-s, x1, -v1), (math.cos(angle), -math.sin(angle)), parts)
    assert abs(back.took / ahead.took - 1) < 1e-12
    s, x1, v1 = back.release
    np.testing.assert_allclose((-s, x1, -v1), TOUCH, rtol=1e-12)


def drawn(count, seed=3):
    """Return random impacts (touch, phase, parts) around those of Set 6."""
    rng = np.random.default_rng(seed)
    while count:
        changes = {name: SET6[name] * 10 ** rng.uniform(-1, 1) for name in ("c1", "c2", "P", "k2")}
        parts = contact_parts(
            **{**SET6, "near": SET6["C"], "K": 10 ** rng.uniform(7, 10), **changes}
        )
        angle = rng.uniform(0, 6.28)
        phase, touch = (math.cos(angle), math.sin(angle)), (
            10 ** rng.uniform(-2, 0.5), rng.normal(0, 0.02), rng.normal(0, 0.3),
        )  # fmt: skip
        if short_impact(side_of(parts, make_arc()), None, phase, (0.0, *touch))[0]:
            count -= 1
            yield touch, phase, parts


def test_a_state_errs_by_the_tolerance():
    """Beside forty nodes. Notices: too few nodes for an impact; a sweep too few."""
    arcs, fine = [make_arc(tolerance) for tolerance in (1e-6, 1e-9, 1e-12)], make_arc(nodes=40)
    for touch, phase, parts in drawn(60, seed=5):
        ahead = ahead_of(fine, touch, phase, parts)
        scales = touch[0] * ahead.took, touch[0], touch[0] * ahead.took, touch[0]
        for share in (0.001, 0.1, 0.3, 0.49, 0.7, 0.99):
            time, states = share * ahead.took, []
            for arc in (fine, *arcs):
                q, *others = inside.state_inside(stepping(arc, parts), phase, ahead, time)
                states.append([q * q, *others])
            off = np.abs(np.array(states[1:]) - states[0]).T
            round_off = 1e-15 * np.abs(states[0]) + 1e-13 * np.array(scales)
            for arc, errors in zip(arcs, off.T, strict=True):
                assert (errors <= arc.tolerance * np.array(scales) + round_off).all()


def test_of_an_impact_that_is_known_nothing_is_solved():
    """All but the last one that a section cut. Notices: any impact taken for the last."""
    arc = make_arc(1e-9)
    ahead = ahead_of(arc)._replace(elapsed=0.001)
    first = inside.state_at_section(stepping(arc), PHASE, ahead)
    assert first == inside.state_inside(stepping(arc), PHASE, ahead, 0.001)
    close = ahead._replace(elapsed=0.001 * (1 + 1e-13))
    assert inside.state_at_section(stepping(arc), PHASE, close) == first
    later = ahead._replace(elapsed=0.001 * (1 + 1e-8))
    other = ahead_of(arc, (TOUCH[0], TOUCH[1], TOUCH[2] * (1 + 1e-9)))._replace(elapsed=0.001)
    for apart in (later, other):
        state = inside.state_at_section(stepping(arc), PHASE, apart)
        assert state == inside.state_inside(stepping(arc), PHASE, apart, apart.elapsed)
        assert state != first


def test_the_largest_energies_are_those_of_small_steps():
    """Notices: a half that is not looked at, an energy's power with the wrong sign."""
    arc, between = make_arc(1e-9), 0
    for touch, phase, parts in drawn(150):
        ps, damper, wall = parts
        ahead = ahead_of(arc, touch, phase, parts)
        ends = np.array(
            [energies(ps, damper, y[1], y[2], wall.gap, y[0]) for y in (touch, ahead.release)]
        )
        start = ends.max(axis=0)
        true, noted = start.copy(), start.copy()
        assert stepped(1.0, true, touch, phase, parts)[0] == RELEASED
        inside.note_inside(stepping(arc, parts), noted, phase, ahead, (0.0, *touch), ahead.took)
        # of the impact's own part in an energy: v1 and x1 are good to the tolerance of its speed
        scale = ps.m1 * touch[0] * max(abs(touch[2]), abs(ahead.release[2]))
        assert (np.abs(noted - true) <= 1e-9 * (true + scale)).all()
        between += (true > start * (1 + 1e-12)).sum()
    assert between > 25


def test_only_what_lasts_is_looked_at():
    """Up to a time and from there on: together the largest of all. Notices: a span turned round."""
    arc = make_arc(1e-9)
    for touch, phase, parts in drawn(30, seed=4):
        ps, damper, wall = parts
        s, x1, v1 = touch
        begin = energies(ps, damper, x1, v1, wall.gap, s)
        whole, ahead = np.array(begin), ahead_of(arc, touch, phase, parts)
        inside.note_inside(stepping(arc, parts), whole, phase, ahead, (0.0, *touch), ahead.took)
        s, x1, v1 = ahead.release
        last = energies(ps, damper, x1, v1, wall.gap, s)
        whole = np.maximum(whole, last)
        for share in (0.02, 0.5, 0.98):
            pieces, moment = np.array((begin, begin)), share * ahead.took
            side, now = stepping(arc, parts), (0.0, *touch)
            inside.note_inside(side, pieces[0], phase, ahead, now, moment)
            q, s, x1, v1 = now = inside.state_inside(side, phase, ahead, moment)
            cut = np.array(energies(ps, damper, x1, v1, wall.gap + q * q, s))
            pieces[1] = np.maximum(cut, last)
            later = ahead._replace(elapsed=moment)
            inside.note_inside(side, pieces[1], phase, later, now, ahead.took - moment)
            peak, first = np.maximum(*pieces), np.array(begin)
            stepped(moment, first, touch, phase, parts)
            assert (pieces[0] <= np.maximum(first, cut) * (1 + 1e-9)).all()
            np.testing.assert_allclose(peak[whole > cut], whole[whole > cut])


def test_a_record_out_of_reach_is_not_looked_for(monkeypatch):
    """Of two equal impacts the second is known. Notices: doubt without end."""
    arc = make_arc(1e-9)
    side, ahead = stepping(arc), ahead_of(arc)
    assert inside.where_peaks_are(side, np.full(2, 1e9), PHASE, ahead) == (0.0, 0.0)
    early, late = inside.where_peaks_are(side, np.zeros(2), PHASE, ahead)
    assert 0.0 < max(early, late) < 0.25 * ahead.took
    noted, again, now = np.zeros(2), np.zeros(2), (0.0, *TOUCH)
    inside.note_inside(side, noted, PHASE, ahead, now, ahead.took)
    monkeypatch.setattr(inside, "contact", None)
    inside.note_inside(side, again, PHASE, ahead, now, ahead.took)
    np.testing.assert_allclose(again, noted, rtol=1e-15)


def test_no_peak_is_out_of_reach():
    """Of energies that no record bounds. Notices: a reach that ends before a peak."""
    arc = make_arc(1e-9)
    for touch, phase, parts in drawn(100, seed=6):
        ahead, noted, true = ahead_of(arc, touch, phase, parts), np.zeros(2), np.zeros(2)
        stepped(1.0, true, touch, phase, parts)
        s, x1, v1 = touch
        true = np.maximum(true, energies(*parts[:2], x1, v1, parts[2].gap, s))
        inside.note_inside(stepping(arc, parts), noted, phase, ahead, (0.0, *touch), ahead.took)
        ends = energies(*parts[:2], x1, v1, parts[2].gap, s)
        s, x1, v1 = ahead.release
        ends = np.maximum(ends, energies(*parts[:2], x1, v1, parts[2].gap, s))
        scale = parts[0].m1 * touch[0] * max(abs(touch[2]), abs(v1))
        assert (np.abs(np.maximum(noted, ends) - true) <= 1e-9 * (true + scale)).all()


def test_a_response_is_that_of_all_steps(monkeypatch):
    """And of an impact that is known the same again. Notices: sums that begin with those before."""
    arc, now = make_arc(1e-9), (0.0, *TOUCH)
    side, rows = stepping(arc), np.zeros((3, SIZE))
    rows[:, :SUMS], rows[:, MOST:BEGIN] = 1e-3, 1e-6
    tallies = [Tally(row, None, None) for row in rows]
    contact(side, NOTHING._replace(tally=tallies[0]), PHASE, now, math.inf)
    inside.tally_inside(side, tallies[1], PHASE, now, now)
    monkeypatch.setattr(inside, "contact", None)
    inside.tally_inside(side, tallies[2], PHASE, now, now)
    np.testing.assert_allclose(rows[1, :BEGIN], rows[0, :BEGIN], rtol=1e-14)
    np.testing.assert_array_equal(rows[2, :BEGIN], rows[1, :BEGIN])


@pytest.mark.parametrize("stops", [8, 64])
def test_samples_inside_impacts_are_states_of_the_orbit(stops):
    """However often sections cut an impact, the orbit goes on as if they did not."""
    system = load_system("ssul-set3", omega=6.28)
    plain = simulate(system, 4, record=["section"])
    cut = simulate(system, 4, record=["section", "trajectory"], samples=stops)
    fine = simulate(system, 4, record=["section", "trajectory"], samples=stops, tolerance=1e-12)
    np.testing.assert_allclose(cut.trajectory, fine.trajectory, rtol=0, atol=1e-7)
    steps = {"method": "rk4", "period_steps": 1024}  # where nothing is solved as a whole
    other = simulate(system, 2, record=["trajectory"], samples=stops, **steps)
    np.testing.assert_allclose(cut.trajectory[: 2 * stops], other.trajectory, rtol=0, atol=1e-6)
    np.testing.assert_allclose(cut.section, plain.section, rtol=0, atol=1e-8)
