"""The short impact: as good in depth as in speed, wherever it is accepted, at any tolerance."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support import Approach, contact_parts, references, side_of

from nlds_vines.kernels.impact import impact
from nlds_vines.kernels.impact.arc import ARC, CHOICES, LEVEL, choices_for, make_arc
from nlds_vines.kernels.impact.impact import (
    approach_of,
    first_guess,
    level_for,
    nodes_of,
    settle,
    short_impact,
)
from nlds_vines.kernels.motion.flight import rate_of
from nlds_vines.kernels.scene.scene import accelerations

SET6 = references()["ssul-set6"].numbers
APPROACH = Approach(speed=1.3, x1=0.011, v1=0.2, phase=1.0)
TOLERANCES = (1e-6, 1e-9, 1e-12)
STANDARD = make_arc()


def parts_of(**changes):
    return contact_parts(**{**SET6, "near": SET6["C"], **changes})


def outside_of(approach, parts):
    """Return the other acceleration at touch, and rate * time of the free impact.

    The one as a share of the contact's own.
    """
    ps, damper, wall = parts
    _, outside = accelerations(
        ps, damper, approach.x1, approach.v1, wall.gap, approach.speed, np.cos(approach.phase), 0.0
    )
    b = (approach.speed / wall.speed) ** 0.2
    lasting = 2.5 * approach.speed / (wall.kappa * b**6) * impact.LENGTH
    return abs(outside) / (wall.kappa * b**6), rate_of(ps, damper) * lasting


def at_touch(approach, parts):
    return approach_of(*parts, approach.wave, approach.touch[1:])


def accepted(approach, parts, impacts=True, arc=STANDARD):
    return short_impact(side_of(parts, arc), impacts, approach.wave, approach.touch)


def random_impacts(count, seed):
    """Return approaches with everything varied, dashpots above all, that are short impacts."""
    rng = np.random.default_rng(seed)
    impacts = []
    while len(impacts) < count:
        changes = {k: SET6[k] * 10 ** rng.uniform(-1, 1) for k in ("m1", "k1", "c1", "m2", "k2")}
        changes["c2"], changes["K"] = (
            SET6["c2"] * 10 ** rng.uniform(-1, 2),
            10 ** rng.uniform(5, 12),
        )
        parts = parts_of(**changes)
        approach = Approach(
            10 ** rng.uniform(-2, 1), *rng.normal(0, (0.05, 0.3)), rng.uniform(0, 6)
        )
        if accepted(approach, parts)[0]:
            impacts.append((approach, parts))
    return impacts


def errors_of(approach, parts, arc, exact):
    solved, s, _, _, took, depth = accepted(approach, parts, arc=arc)
    assert solved
    pairs = ((-s, exact.speed), (took, exact.duration), (depth, exact.depth))
    return [abs(mine / true - 1) for mine, true in pairs]


@cache
def stepped(seed):
    """Return random impacts (approach, parts) with the contact by many steps."""
    return [(*impact, impact[0].step(impact[1], 100)) for impact in random_impacts(60, seed)]


# ---- depth ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("arc", [STANDARD, make_arc(nodes=12)], ids=["1e-9", "12 nodes"])
def test_depth_wherever_a_short_impact_is_accepted(arc):
    """Relative error below 2e-11: an integral to a place between the nodes errs by 1e-7."""
    errors = np.array(
        [errors_of(approach, parts, arc, exact) for approach, parts, exact in stepped(5)]
    )
    speeds, _, depths = errors.T
    assert max(depths) <= 2e-11
    assert np.median(depths) <= 1e-13
    assert max(depths) <= max(speeds)


@pytest.mark.parametrize("nodes", [4, 6, 8])
def test_depth_with_few_nodes_is_no_worse_than_speed(nodes):
    parts = parts_of(c2=20 * SET6["c2"])
    exact, solved = APPROACH.step(parts, 100), APPROACH.solve(parts, nodes)
    assert abs(solved.depth / exact.depth - 1) <= 2 * abs(solved.speed / exact.speed - 1)


def test_a_depth_that_is_not_wanted_changes_nothing_else():
    parts = parts_of()
    with_depth, without = accepted(APPROACH, parts), accepted(APPROACH, parts, None)
    assert with_depth[:5] == without[:5]
    assert with_depth[5] > 0.0 == without[5]


# ---- speed ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("nodes", "bound"), [(8, 5e-12), (12, 2e-13)])
def test_what_the_nodes_miss_of_the_dashpots_is_added(nodes, bound):
    """Notices: the correction by the drag dropped: with 12 nodes errors are 1e-11 and more then."""
    arc = make_arc(nodes=nodes)
    for c2 in (1.0, 3.0, 10.0):
        parts = parts_of(c2=c2 * SET6["c2"], K=1e9)
        assert errors_of(APPROACH, parts, arc, APPROACH.step(parts, 100))[0] <= bound


def guess_error(changes, row, unit):
    """Return by how much the guess errs of what the sweeps find; `unit` of the `Approach`."""
    none = dict.fromkeys(("k1", "c1", "k2", "c2", "P"), 0.0)
    parts = parts_of(**{**none, **changes})
    ps, damper, wall = parts
    arc, approach = make_arc(nodes=24), at_touch(APPROACH, parts)
    nodes = nodes_of(arc, 0, LEVEL.whole)
    first_guess(ps, damper, nodes, approach)
    guess = arc.table[row : row + 24].copy()
    assert settle(ps, damper, wall, nodes, approach, arc.settled)
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


# ---- nodes ---------------------------------------------------------------------------------------


def test_the_nodes_are_the_fewest_that_the_tolerance_allows():
    """Notices: a bound that is not looked at; of the half arc, the errors of the whole."""
    for column, error in enumerate((LEVEL.error, LEVEL.half_error)):
        seen = set()
        for tolerance in (1e-3, *TOLERANCES, 1e-13):
            arc, choices = make_arc(tolerance), choices_for(tolerance)
            for size in np.geomspace(1e-7, impact.LARGEST, 60):
                level = level_for(arc, int(error), size)
                bounds = {n: errors[column] * size**1.5 for n, errors in choices.items()}
                enough = [n for n, bound in bounds.items() if bound <= tolerance]
                nodes = nodes_of(arc, level, LEVEL.whole).n
                assert nodes == (enough[0] if enough else max(choices))
                seen.add(nodes)
        assert seen == set(list(CHOICES)[: 4 if column == 0 else 3])  # more only after a doubt


def test_given_nodes_are_taken_whatever_the_error():
    for n in (2, 12, 24):
        arc = make_arc(nodes=n)
        for size in (1e-7, impact.LARGEST):
            assert level_for(arc, LEVEL.error, size) == 0
            assert nodes_of(arc, 0, LEVEL.whole).n == nodes_of(arc, 0, LEVEL.half).n == n


def test_given_nodes_solve_every_impact_that_a_tolerance_solves():
    """Their sweeps go on to round-off. Notices: more of them needed than there may be."""
    arcs = [make_arc(nodes=n) for n in (4, 8, 12, 16, 24)]
    for approach, parts in random_impacts(60, seed=11):
        assert all(accepted(approach, parts, arc=arc)[0] for arc in arcs)


@pytest.mark.parametrize("tolerance", [*TOLERANCES, 1e-13])
def test_a_short_impact_errs_by_less_than_the_tolerance(tolerance):
    arc, round_off = make_arc(tolerance), 5e-14  # of the stepped contact, and of the depth
    errors = [errors_of(approach, parts, arc, exact) for approach, parts, exact in stepped(7)]
    assert np.max(errors) <= tolerance + round_off
    if tolerance > 1e-12:  # and no more is done than is asked for
        assert np.max(errors) > 1e-3 * tolerance


# ---- which impacts are short ---------------------------------------------------------------------


def size_of_all(approach, parts):
    """Return the largest other acceleration of a contact as a share of the free impact's own."""
    ps, damper, wall = parts
    wave = np.cos(approach.phase), np.sin(approach.phase)

    def outside(t, y):
        cosine = wave[0] * np.cos(ps.omega * t) - wave[1] * np.sin(ps.omega * t)
        return accelerations(ps, damper, y[0], y[1], wall.gap + y[2], y[3], cosine, 0.0)

    def slope(t, y):
        alone, free = outside(t, y)
        push = wall.kappa * max(y[2], 0.0) ** 1.5
        return y[1], alone - damper.share * push, y[3], free - push

    def release(t, y):
        return y[2] if t > 0.0 else 1.0

    release.terminal, release.direction = True, -1.0
    b = (approach.speed / wall.speed) ** 0.2
    stiffness = wall.kappa * b**6
    solution = solve_ivp(
        slope, (0.0, 10.0 * approach.speed / stiffness),
        [approach.x1, approach.v1, 0.0, approach.speed],
        events=release, rtol=1e-8, atol=1e-14, max_step=0.1 * approach.speed / stiffness,
    )  # fmt: skip
    assert solution.status == 1
    pairs = zip(solution.t, solution.y.T, strict=True)
    return max(abs(outside(t, y)[1]) for t, y in pairs) / stiffness


def test_the_size_of_an_impact_bounds_all_other_acceleration_during_it():
    """Notices: one of the five numbers left out of it."""
    ratios = []
    for approach, parts in random_impacts(40, seed=3):
        ratios.append(size_of_all(approach, parts) / at_touch(approach, parts).size)
    assert max(ratios) <= 1.0 + 0.05
    assert max(ratios) > 0.9  # and not far above


def test_only_a_small_share_of_other_forces_is_taken_for_a_short_impact():
    """Notices: a share of up to a half allowed, and none allowed."""
    for P in np.geomspace(1e4, 1e7, 60):
        parts = parts_of(P=P, K=1e9)
        share, lasting = outside_of(APPROACH, parts)
        size = at_touch(APPROACH, parts).size
        assert lasting < 0.25
        assert share < size < 1.1 * share + 0.003
        assert accepted(APPROACH, parts)[0] == (size < 0.15)


def test_only_what_is_short_beside_all_other_motion_is_taken_for_a_short_impact():
    for K in np.geomspace(4e5, 1e9, 60):
        parts = parts_of(K=K)
        _, lasting = outside_of(APPROACH, parts)
        assert at_touch(APPROACH, parts).size < 0.15
        assert accepted(APPROACH, parts)[0] == (lasting < 0.25)


def test_a_short_impact_keeps_its_accuracy_up_to_the_largest_share():
    """The bound is where errors begin to grow. Notices: a bound five times as large."""
    worst = {}
    for K in (1e6, 1e7, 1e8):
        for phase in np.linspace(0, 6, 7):
            for speed in np.geomspace(1e-4, 1.0, 16):
                approach, parts = Approach(speed, 0.01, 0.1, phase), parts_of(K=K)
                if accepted(approach, parts)[0]:
                    exact = approach.step(parts, 60)
                    for tolerance in TOLERANCES:
                        errors = errors_of(approach, parts, make_arc(tolerance), exact)
                        worst[speed, K, phase, tolerance] = max(errors)
    assert len(worst) > 150
    for tolerance in TOLERANCES:
        errors = [error for (*_, asked), error in worst.items() if asked == tolerance]
        assert max(errors) <= tolerance
    assert max(error for (*_, asked), error in worst.items() if asked == 1e-9) <= 2e-10
