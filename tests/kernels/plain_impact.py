"""Short impacts: at their ends, inside, under loads; beside small steps, at any tolerance."""

import itertools
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support import NOTHING, Approach, contact_parts, follow_contact, side_of
from test_impact_variations import APPROACH, SET6, Impact, impact_with, random_impacts

from nlds_vines import load_system, simulate
from nlds_vines.kernels.events.contact import Steps, contact
from nlds_vines.kernels.impact import impact, inside
from nlds_vines.kernels.impact.arc import ARC, CHOICES, LEVEL, choices_for, make_arc
from nlds_vines.kernels.impact.inside import motion_of_touch, tally_nodes
from nlds_vines.kernels.motion.flight import rate_of
from nlds_vines.kernels.motion.response_sums import CS, CV, MOST, NUMBERS, SIZE, SUMS, Tally
from nlds_vines.kernels.scene.codes import RELEASED, STOPPED
from nlds_vines.kernels.scene.drive import Moment, later
from nlds_vines.kernels.scene.scene import accelerations, with_load
from nlds_vines.kernels.watch.observe import LIMIT, energies
from nlds_vines.kernels.watch.touch import may_pass

TOLERANCES = (1e-6, 1e-9, 1e-12)
STANDARD = make_arc()


def outside_of(one):
    """Return the other acceleration at touch as a share of the contact's; rate * free time."""
    approach, (ps, damper, wall) = one.approach, one.parts
    _, outside = accelerations(
        ps, damper, approach.x1, approach.v1, wall.gap, approach.speed, np.cos(approach.phase), 0.0
    )
    b = (approach.speed / wall.speed) ** 0.2
    lasting = 2.5 * approach.speed / (wall.kappa * b**6) * impact.LENGTH
    return abs(outside) / (wall.kappa * b**6), one.rate * lasting


def at_touch(one):
    return impact.approach_of(side_of(one.parts), one.phase, one.approach.touch[1:])


def errors_of(one, arc, exact):
    solved, s, _, _, took, depth = one.solve(arc, True)
    assert solved
    pairs = ((-s, exact.speed), (took, exact.duration), (depth, exact.depth))
    return [abs(mine / true - 1) for mine, true in pairs]


@cache
def stepped_impacts(seed):
    return [(one, one.approach.step(one.parts, 100)) for one in random_impacts(12, STANDARD, seed)]


@pytest.mark.parametrize("arc", [STANDARD, make_arc(nodes=12)], ids=["1e-9", "12 nodes"])
def test_depth_wherever_a_short_impact_is_accepted(arc):
    """Relative error below 2e-11: an integral to a place between the nodes errs by 1e-7."""
    errors = np.array([errors_of(one, arc, exact) for one, exact in stepped_impacts(5)])
    speeds, _, depths = errors.T
    assert max(depths) <= 2e-11
    assert np.median(depths) <= 1e-13
    assert max(depths) <= max(speeds)


@pytest.mark.parametrize("nodes", [4, 6, 8])
def test_depth_with_few_nodes_is_no_worse_than_speed(nodes):
    parts = impact_with(c2=20 * SET6["c2"]).parts
    exact, solved = APPROACH.step(parts, 100), APPROACH.solve(parts, nodes)
    assert abs(solved.depth / exact.depth - 1) <= 2 * abs(solved.speed / exact.speed - 1)


def test_a_depth_that_is_not_wanted_changes_nothing_else():
    """Of the impact, and of variations, which read the nodes of the whole one."""
    one = impact_with()
    with_depth, without = one.solve(STANDARD, True), one.solve(STANDARD)
    assert with_depth[:5] == without[:5]
    assert with_depth[5] > 0.0 == without[5]
    np.testing.assert_array_equal(one.carried(STANDARD, impacts=True), one.carried(STANDARD))


@pytest.mark.parametrize(("nodes", "bound"), [(8, 5e-12), (12, 2e-13)])
def test_what_the_nodes_miss_of_the_dashpots_is_added(nodes, bound):
    """Notices: the correction by the drag dropped: with 12 nodes errors are 1e-11 and more then."""
    arc = make_arc(nodes=nodes)
    for c2 in (1.0, 3.0, 10.0):
        one = impact_with(c2=c2 * SET6["c2"], K=1e9)
        assert errors_of(one, arc, APPROACH.step(one.parts, 100))[0] <= bound


def guess_error(changes, row, unit):
    """Return by how much the guess errs of what the sweeps find; `unit` of the `Approach`."""
    none = dict.fromkeys(("k1", "c1", "k2", "c2", "P"), 0.0)
    one = impact_with(**{**none, **changes})
    side, arc, approach = side_of(one.parts), make_arc(nodes=24), at_touch(one)
    nodes = impact.nodes_of(arc, 0, LEVEL.whole)
    impact.first_guess(side, nodes, approach)
    guess = arc.table[row : row + 24].copy()
    assert impact.settle(side, nodes, approach, arc.settled)
    return np.abs(arc.table[row : row + 24] - guess).max() / getattr(approach, unit)


@pytest.mark.parametrize(("row", "unit"), [(ARC.amplitudes, "b"), (ARC.times, "tick")])
def test_the_first_guess_errs_by_the_second_order_or_higher(row, unit):
    """A tenth of one force, a hundredth of the error; of dashpots a ten thousandth, a thousandth.

    Notices: one left out; a term of second order, or of third order in the drag, left out.
    """
    cases = {"c2": (4.0, 2e-4), "c1": (6.0, 2e-3), "k1": (3.0, 0.02), "k2": (3.0, 0.02)}
    for name, (size, ratio) in {**cases, "P": (60.0, 0.04)}.items():
        whole, tenth = (
            guess_error({name: part * size * SET6[name]}, row, unit) for part in (1.0, 0.1)
        )
        assert whole > 1e-9
        assert tenth < ratio * whole


def test_the_nodes_are_the_fewest_that_the_tolerance_allows():
    """Notices: a bound that is not looked at; of the half arc, the errors of the whole."""
    for column, error in enumerate((LEVEL.error, LEVEL.half_error)):
        seen = set()
        for tolerance in (1e-3, *TOLERANCES, 1e-13):
            arc, choices = make_arc(tolerance), choices_for(tolerance)
            for size in np.geomspace(1e-7, impact.LARGEST, 60):
                level = impact.level_for(arc, int(error), size)
                bounds = {n: errors[column] * size**1.5 for n, errors in choices.items()}
                enough = [n for n, bound in bounds.items() if bound <= tolerance]
                nodes = impact.nodes_of(arc, level, LEVEL.whole).n
                assert nodes == (enough[0] if enough else max(choices))
                seen.add(nodes)
        assert seen == set(list(CHOICES)[: 4 if column == 0 else 3])  # more only after a doubt


def test_given_nodes_are_taken_and_solve_all_that_a_tolerance_solves():
    for n in (2, 12, 24):
        arc = make_arc(nodes=n)
        for size in (1e-7, impact.LARGEST):
            assert impact.level_for(arc, LEVEL.error, size) == 0
            assert (
                impact.nodes_of(arc, 0, LEVEL.whole).n == impact.nodes_of(arc, 0, LEVEL.half).n == n
            )
    # their sweeps go on to round-off. Notices: more of them needed than there may be
    arcs = [make_arc(nodes=n) for n in (4, 8, 12, 16, 24)]
    for one in random_impacts(8, STANDARD, seed=11):
        assert all(one.solve(arc, True)[0] for arc in arcs)


@pytest.mark.parametrize("tolerance", [*TOLERANCES, 1e-13])
def test_a_short_impact_errs_by_less_than_the_tolerance(tolerance):
    arc, round_off = make_arc(tolerance), 5e-14  # of the stepped_impacts contact, and of the depth
    errors = [errors_of(one, arc, exact) for one, exact in stepped_impacts(5)]
    assert np.max(errors) <= tolerance + round_off
    if tolerance > 1e-12:  # and no more is done than is asked for
        assert np.max(errors) > 1e-3 * tolerance


def size_of_all(one):
    """Return the largest other acceleration of a contact as a share of the free impact's own."""
    approach, (ps, damper, wall) = one.approach, one.parts
    duration, now, sizes = approach.step(one.parts, 20).duration, approach.touch, []
    for elapsed in np.linspace(0.0, duration, 20, endpoint=False):
        angle, (q, s, x1, v1) = approach.phase + ps.omega * elapsed, now
        phase = math.cos(angle), math.sin(angle)
        y = x1, v1, wall.gap + q * q, s
        sizes.append(abs(accelerations(ps, damper, *y, phase[0], 0.0)[1]))
        now = contact(side_of(one.parts), NOTHING, phase, now, duration / 20)[1:5]
    return max(sizes) / (wall.kappa * (approach.speed / wall.speed) ** 1.2)


def test_the_size_of_an_impact_bounds_all_other_acceleration_during_it():
    """Notices: one of the five numbers left out of it."""
    impacts = random_impacts(15, STANDARD, seed=3)
    ratios = [size_of_all(one) / at_touch(one).size for one in impacts]
    assert max(ratios) <= 1.0 + 0.05
    assert max(ratios) > 0.9  # and not far above


def test_only_what_is_short_and_nearly_free_is_taken_for_a_short_impact():
    """Notices: a share of other forces of up to a half allowed, and none allowed."""
    for P in np.geomspace(1e4, 1e7, 60):
        one = impact_with(P=P, K=1e9)
        (share, lasting), size = outside_of(one), at_touch(one).size
        assert lasting < 0.25
        assert share < size < 1.1 * share + 0.003
        assert one.solve(STANDARD)[0] == (size < 0.15)
    for K in np.geomspace(4e5, 1e9, 60):
        one = impact_with(K=K)
        assert at_touch(one).size < 0.15
        assert one.solve(STANDARD)[0] == (outside_of(one)[1] < 0.25)


def test_a_short_impact_keeps_its_accuracy_up_to_the_largest_share():
    """The bound is where errors begin to grow. Notices: a bound five times as large."""
    arcs, worst = [make_arc(tolerance) for tolerance in TOLERANCES], []
    for K, phase, speed in itertools.product(
        (1e6, 1e7, 1e8), np.linspace(0, 6, 5), np.geomspace(1e-4, 1.0, 10)
    ):
        one = impact_with(K=K)._replace(approach=Approach(speed, 0.01, 0.1, phase))
        if one.solve(STANDARD, True)[0]:
            exact = one.approach.step(one.parts, 60)
            worst.append([max(errors_of(one, arc, exact)) for arc in arcs])
    assert len(worst) > 20
    assert (np.max(worst, axis=0) <= TOLERANCES).all()
    assert np.max(worst, axis=0)[TOLERANCES.index(1e-9)] <= 2e-10


IMPACT = impact_with()
TOUCH, PHASE = APPROACH.touch, APPROACH.wave
FINE = Steps(120.0, math.inf)


@pytest.fixture
def arc():
    """Return an arc that knows no impact yet."""
    return make_arc()


def stepped(one, time, energy=None):
    """Return (event, q, s, x1, v1) of an impact a `time` after its touch, by small steps."""
    watch = NOTHING._replace(energy=energy)
    return contact(side_of(one.parts, steps=FINE), watch, one.phase, one.approach.touch, time)[:5]


def energies_of(one, q, s, x1, v1):
    ps, damper, wall = one.parts
    return np.array(energies(ps, damper, x1, v1, wall.gap + q * q, s))


def note(one, arc, energy, ahead, now, time):
    inside.note_inside(one.side(arc), energy, one.phase, ahead, now, time)


def test_the_ends_are_what_they_are(arc):
    ahead, side = IMPACT.ahead(arc), IMPACT.side(arc)
    assert inside.state_inside(side, PHASE, ahead, 0.0) == TOUCH
    assert inside.state_inside(side, PHASE, ahead, ahead.took) == (0.0, *ahead.release)


def test_backward_in_time_an_impact_is_an_impact():
    """From its release it leads to its touch. Notices: a dashpot that still takes."""
    arc = make_arc(1e-12)
    ahead = IMPACT.ahead(arc)
    turned = inside.side_backward(side_of(IMPACT.parts))
    s, x1, v1 = ahead.release
    release = Approach(-s, x1, -v1, -1.0 - turned.ps.omega * ahead.took)
    back = Impact((turned.ps, turned.damper, turned.wall), release).ahead(arc)
    assert abs(back.took / ahead.took - 1) < 1e-12
    s, x1, v1 = back.release
    np.testing.assert_allclose((-s, x1, -v1), TOUCH[1:], rtol=1e-12)


def test_a_state_errs_by_the_tolerance():
    """Beside forty nodes. Notices: too few nodes for an impact; a sweep too few."""
    arcs, fine = [make_arc(tolerance) for tolerance in TOLERANCES], make_arc(nodes=40)
    for one in random_impacts(8, STANDARD, seed=5):
        ahead, speed = one.ahead(fine), one.approach.speed
        scales = speed * ahead.took, speed, speed * ahead.took, speed
        for share in (0.001, 0.1, 0.3, 0.49, 0.7, 0.99):
            time, states = share * ahead.took, []
            for arc in (fine, *arcs):
                q, *others = inside.state_inside(one.side(arc), one.phase, ahead, time)
                states.append([q * q, *others])
            off = np.abs(np.array(states[1:]) - states[0])
            round_off = 1e-15 * np.abs(states[0]) + 1e-13 * np.array(scales)
            assert (off <= np.outer(TOLERANCES, scales) + round_off).all()


def test_of_an_impact_that_is_known_nothing_is_solved(arc):
    """All but the last one that a section cut. Notices: any impact taken for the last."""
    ahead, side = IMPACT.ahead(arc)._replace(elapsed=0.001), IMPACT.side(arc)
    first = inside.state_at_section(side, PHASE, ahead)
    assert first == inside.state_inside(side, PHASE, ahead, 0.001)
    close = ahead._replace(elapsed=0.001 * (1 + 1e-13))
    assert inside.state_at_section(side, PHASE, close) == first
    later = ahead._replace(elapsed=0.001 * (1 + 1e-8))
    faster = replace(APPROACH, v1=APPROACH.v1 * (1 + 1e-9))
    other = IMPACT._replace(approach=faster).ahead(arc)._replace(elapsed=0.001)
    for apart in (later, other):
        state = inside.state_at_section(side, PHASE, apart)
        assert state == inside.state_inside(side, PHASE, apart, apart.elapsed)
        assert state != first


def test_the_largest_energies_are_those_of_small_steps():
    """From those of its ends on, and from a record of zero, which bounds none.

    Notices: a half that is not looked at, an energy's power with the wrong sign, a reach that ends
    before a peak.
    """
    arcs, between = (make_arc(), make_arc()), 0  # of which each meets an impact once
    for one in random_impacts(12, STANDARD, seed=3):
        ahead, touch = one.ahead(arcs[0]), one.approach.touch
        ends = np.maximum(energies_of(one, *touch), energies_of(one, 0.0, *ahead.release))
        true = ends.copy()
        assert stepped(one, 1.0, true)[0] == RELEASED
        # of the impact's own part in an energy: v1 and x1 are good to the tolerance of its speed
        scale = one.parts[0].m1 * touch[1] * max(abs(touch[3]), abs(ahead.release[2]))
        for arc, record in zip(arcs, (ends, np.zeros(2)), strict=True):
            noted = record.copy()
            note(one, arc, noted, ahead, touch, ahead.took)
            assert (np.abs(np.maximum(noted, ends) - true) <= 1e-9 * (true + scale)).all()
        between += (true > ends * (1 + 1e-12)).sum()
    assert between > 3


def test_only_what_lasts_is_looked_at(arc):
    """Up to a time and from there on: together the largest of all. Notices: a span turned round."""
    for one in random_impacts(5, STANDARD, seed=4):
        touch, ahead = one.approach.touch, one.ahead(arc)
        begin, last = energies_of(one, *touch), energies_of(one, 0.0, *ahead.release)
        whole = begin.copy()
        note(one, arc, whole, ahead, touch, ahead.took)
        whole = np.maximum(whole, last)
        for share in (0.02, 0.5, 0.98):
            moment, early, first = share * ahead.took, begin.copy(), begin.copy()
            note(one, arc, early, ahead, touch, moment)
            now = inside.state_inside(one.side(arc), one.phase, ahead, moment)
            cut = energies_of(one, *now)
            late = np.maximum(cut, last)
            later = ahead._replace(elapsed=moment)
            note(one, arc, late, later, now, ahead.took - moment)
            stepped(one, moment, first)
            assert (early <= np.maximum(first, cut) * (1 + 1e-9)).all()
            peak = np.maximum(early, late)
            np.testing.assert_allclose(peak[whole > cut], whole[whole > cut])


def test_a_record_out_of_reach_is_not_looked_for(monkeypatch, arc):
    """Of two equal impacts the second is known. Notices: doubt without end."""
    side, ahead = IMPACT.side(arc), IMPACT.ahead(arc)
    assert inside.where_peaks_are(side, np.full(2, 1e9), PHASE, ahead) == (0.0, 0.0)
    early, late = inside.where_peaks_are(side, np.zeros(2), PHASE, ahead)
    assert 0.0 < max(early, late) < 0.25 * ahead.took
    noted, again = np.zeros(2), np.zeros(2)
    inside.note_inside(side, noted, PHASE, ahead, TOUCH, ahead.took)
    monkeypatch.setattr(inside, "contact", None)
    inside.note_inside(side, again, PHASE, ahead, TOUCH, ahead.took)
    np.testing.assert_allclose(again, noted, rtol=1e-15)


def test_a_response_is_that_of_all_steps(monkeypatch, arc):
    """And of an impact that is known the same again. Notices: sums that begin with those before."""
    side, rows = IMPACT.side(arc), np.zeros((3, SIZE))
    rows[:, :SUMS], rows[:, MOST:NUMBERS] = 1e-3, 1e-6
    tallies = [Tally(row, None, None) for row in rows]
    contact(side, NOTHING._replace(tally=tallies[0]), PHASE, TOUCH, math.inf)
    inside.tally_inside(side, tallies[1], PHASE, TOUCH, TOUCH)
    monkeypatch.setattr(inside, "contact", None)
    inside.tally_inside(side, tallies[2], PHASE, TOUCH, TOUCH)
    np.testing.assert_allclose(rows[1, :NUMBERS], rows[0, :NUMBERS], rtol=1e-14)
    np.testing.assert_array_equal(rows[2, :NUMBERS], rows[1, :NUMBERS])


def loaded(load, **changes):
    """Return the impact under a load [m/s^2]; the contact's own acceleration is some 3000."""
    ps, damper, wall = impact_with(**changes).parts
    return Impact((with_load(ps, load), damper, wall), APPROACH)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_a_ball_that_falls_on_a_soft_table(tolerance):
    """From 1 m, under g = 10 m/s^2: at the deepest point 0.4 K z^2.5 = m g (h + z).

    The time is twice a quadrature.
    """
    ball = load_system("bouncing-ball", law="hertz", K=1e5, g=10, Y=0, omega=1)
    orbit = simulate(ball, 1, start=(1, 0), record=("impacts",), tolerance=tolerance).impacts[0]
    assert orbit["depth"] == pytest.approx(0.036766164808134, rel=tolerance)
    assert orbit["release"] - orbit["touch"] == pytest.approx(0.024010630555907, rel=tolerance)
    assert orbit["force"] == pytest.approx(1e5 * orbit["depth"] ** 1.5, rel=1e-12)


@pytest.mark.parametrize(
    ("load", "tolerance"),
    [*((None, tolerance) for tolerance in TOLERANCES), (30.0, 1e-6), (-30.0, 1e-9), (30.0, 1e-12)],
)
def test_a_short_impact_is_that_of_small_steps_at_any_time(load, tolerance):
    """Notices: the half from release taken forward in time; too few nodes."""
    one, arc = IMPACT if load is None else loaded(load), make_arc(tolerance)
    ahead, true = one.ahead(arc), APPROACH.step(one.parts, 200)
    s, _, v1 = ahead.release
    assert -s == pytest.approx(true.speed, rel=tolerance)
    assert ahead.took == pytest.approx(true.duration, rel=tolerance)
    assert v1 == pytest.approx(true.v1, abs=tolerance * APPROACH.speed)
    assert APPROACH.solve(one.parts, 24).depth == pytest.approx(true.depth, rel=1e-12)
    scales = APPROACH.speed * np.array([ahead.took, 1.0, ahead.took, 1.0])
    for share in (1e-6, 0.01, 0.2, 0.4, 0.499, 0.501, 0.6, 0.9, 0.99, 0.999):
        event, q, *others = stepped(one, share * ahead.took)
        assert event == STOPPED
        p, *state = inside.state_inside(one.side(arc), PHASE, ahead, share * ahead.took)
        off = np.abs(np.array([p * p, *state]) - (q * q, *others))
        assert (off / scales).max() <= tolerance + 1e-13


@pytest.mark.parametrize("load", [30.0, -30.0])
def test_largest_energies_and_variations_under_a_load_are_those_of_small_steps(load, arc):
    one = loaded(load)
    ahead, energy = one.ahead(arc), energies_of(one, *TOUCH)
    true = energy.copy()
    assert stepped(one, 1.0, true)[0] == RELEASED
    note(one, arc, energy, ahead, TOUCH, ahead.took)
    np.testing.assert_allclose(energy, true, rtol=1e-9)
    # to its release, and to a section in either half. Notices: factors that know of no load
    assert one.error(arc) <= 1e-9
    for share in (0.3, 0.8):
        ahead, (first, _) = one.cut(arc, share)
        exact = one.matrix(one.stepped(100.0, ahead.elapsed)[0])
        assert np.abs(one.matrix(first) - exact).max() <= 1e-9 * np.abs(exact).max()


def test_an_impact_is_doubted_whose_solution_lacks_a_force(monkeypatch, arc):
    """The balance has its forces from the equation of motion, not from what solves the impact."""
    assert loaded(30.0).solve(arc)[0]
    monkeypatch.setattr(impact, "under", lambda load, alone: alone)
    assert not loaded(30.0).solve(arc)[0]


def test_a_limit_may_be_passed_because_of_a_load():
    """An impact reaches farther under a load that presses than its energy at touch alone would."""
    ps, damper, wall = loaded(300.0, P=0.0, k2=0.0, c1=0.0, k1=0.0, c2=0.0).parts
    ps = ps._replace(m1=1e9)
    touch = 1.3, 0.0, 0.0
    log = np.zeros(6)
    log[LIMIT] = wall.gap + 1.001 * (math.sqrt(damper.m2 / 0.8 / wall.K) * touch[0]) ** 0.8
    assert may_pass(side_of((ps, damper, wall)), log, PHASE, 0.01, touch)
    assert not may_pass(side_of((with_load(ps, 0.0), damper, wall)), log, PHASE, 0.01, touch)


SMALL_STEPS = Steps(80.0, math.inf)


def drawn_under(kind, count, seed=1):
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
            calm, side = Moment(row, 0, 0, 0.0, h), side_of((ps, damper, wall))
            free = impact.approach_of(side, calm, touch[1:])
            h = min(h, rng.uniform(1.7, 20) * free.tick)
            row[degree] = decades(-4, -1) * wall.kappa * free.b**6 / (1.6 * free.tick / h) ** degree
        else:
            degree, start = 14, np.exp(1j * rng.uniform(0, 6))
            row[:] = [(size * start * turn**k / math.factorial(k)).real for k in range(15)]
        row *= rng.choice([-1.0, 1.0])
        moment = Moment(row, 0, degree, place, h)
        if impact.short_impact(side_of((ps, damper, wall), arc), True, moment, touch)[0]:
            drawn_count += 1
            yield (ps, damper, wall), moment, touch


@pytest.mark.parametrize("kind", ["cubic", "tone", "shaken", "sudden"])
def test_it_errs_by_less_than_the_tolerance(kind):
    """Speed, duration and depth. Notices: third derivatives without a say in how many nodes."""
    for parts, moment, touch in drawn_under(kind, 8):
        event, _, s, x1, v1, took, depth = follow_contact(
            side_of(parts, steps=SMALL_STEPS), moment, touch
        )
        assert event == RELEASED
        for tolerance in TOLERANCES:
            side = side_of(parts, make_arc(tolerance))
            solved, out, x, v, lasted, deep = impact.short_impact(side, True, moment, touch)
            assert solved
            off = [out / s - 1, lasted / took - 1, deep / depth - 1]
            off.append((v - v1) / (touch[1] + 1e3 * abs(v1)))
            off.append((x - x1) / (touch[1] * took + 1e3 * abs(x1)))
            assert np.abs(off).max() <= tolerance + 1e-13


def test_an_impact_that_outlasts_what_is_known_of_a_load_is_none():
    ((parts, moment, touch),) = drawn_under("cubic", 1)
    side, steady = side_of(parts, make_arc(1e-9)), moment._replace(degree=0)
    took = impact.short_impact(side, None, steady, touch)[4]
    for left, whole in ((1.2, True), (0.9999, False)):
        near_edge = steady._replace(x=1.0 - left * took / moment.length)
        assert impact.short_impact(side, None, near_edge, touch)[0] == whole


@pytest.mark.parametrize("kind", ["cubic", "shaken"])
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_its_response_is_that_of_small_steps(kind, tolerance):
    """Sums and largest values, where the nodes say that they know them."""
    added = 0
    for parts, moment, touch in drawn_under(kind, 12, seed=3):
        (ps, _, wall), side = parts, side_of(parts, make_arc(tolerance))
        ground = ps.force if kind == "shaken" else None
        _, s, x1, v1, took, _ = impact.short_impact(side, True, moment, touch)
        after = later(ps, moment, took)
        ends = touch[1:], (s, x1, v1)
        row = np.zeros(SIZE)
        seen = [
            motion_of_touch(side, ground, y, at)
            for y, at in zip(ends, (moment, after), strict=True)
        ]
        row[MOST : MOST + 3] = np.abs(seen)[:, [0, 1, 3]].max(axis=0)
        row[MOST + 3] = abs(wall.gap)
        mine, true = Tally(row.copy(), ground, None), Tally(row.copy(), ground, None)
        if not tally_nodes(side, mine, moment, touch, (s, x1, v1, took)):
            assert (mine.row[:NUMBERS] == row[:NUMBERS]).all()
            continue
        added += 1
        contact(side_of(parts, steps=SMALL_STEPS), NOTHING._replace(tally=true), moment, touch, 1e3)
        scale = np.where(true.row > 0.0, true.row, 1.0)
        scale[MOST], most = scale[MOST] + touch[1] * took, np.abs(moment.w).sum()
        scale[CV], scale[CS] = (most * math.sqrt(true.row[i] * took) for i in (1, 4))
        off = np.abs(mine.row - true.row)[:NUMBERS] / scale[:NUMBERS]
        assert off[SUMS:].max() <= tolerance + 1e-13
        assert off[:SUMS].max() <= 10 * tolerance + 1e-12  # places within an arc are less known
    assert added >= 2
