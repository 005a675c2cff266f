"""The short impact at the default nodes: as good in depth as in speed, wherever it is accepted."""

import numpy as np
import pytest
from support import Approach, contact_parts, references

from nlds_vines.kernels import impact
from nlds_vines.kernels.flight import rate_of
from nlds_vines.kernels.impact import first_guess, settle, short_impact
from nlds_vines.kernels.scene import accelerations
from nlds_vines.orbits.hertz_arc import make_arc
from nlds_vines.orbits.settings import NODES

SET6 = references()["ssul-set6"].numbers
APPROACH = Approach(speed=1.3, x1=0.011, v1=0.2, phase=1.0)


def parts_of(**changes):
    return contact_parts(**{**SET6, "near": SET6["C"], **changes})


def share_of(approach, parts):
    """Return the other acceleration at touch as a share of the contact's own, and rate * time."""
    ps, damper, wall = parts
    _, outside = accelerations(
        ps, damper, approach.x1, approach.v1, wall.gap, approach.speed, np.cos(approach.phase), 0.0
    )
    b = (approach.speed / wall.speed) ** 0.2
    lasting = 2.5 * approach.speed / (wall.kappa * b**6) * make_arc(NODES).length
    return abs(outside) / (wall.kappa * b**6), rate_of(ps, damper) * lasting


def accepted(approach, parts, impacts=True):
    ps, damper, _ = parts
    return short_impact(
        *parts, make_arc(NODES), impacts, rate_of(ps, damper), np.cos(approach.phase),
        np.sin(approach.phase), 0.0, approach.speed, approach.x1, approach.v1,
    )  # fmt: skip


def random_impacts(count, seed=5):
    """Return approaches with everything varied, dashpots above all, that are short impacts."""
    rng = np.random.default_rng(seed)
    found = []
    while len(found) < count:
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
            found.append((approach, parts))
    return found


# ---- depth ---------------------------------------------------------------------------------------


def test_depth_wherever_a_short_impact_is_accepted():
    """Relative error below 2e-11: an integral to a place between the nodes errs by 1e-7."""
    errors, speeds = [], []
    for approach, parts in random_impacts(60):
        exact = approach.step(parts, 100)
        found = approach.solve(parts, NODES)
        errors.append(abs(found.depth / exact.depth - 1))
        speeds.append(abs(found.speed / exact.speed - 1))
    assert max(errors) <= 2e-11
    assert np.median(errors) <= 1e-12
    assert max(errors) <= max(speeds)


@pytest.mark.parametrize("nodes", [4, 6, 8])
def test_depth_with_few_nodes_is_no_worse_than_speed(nodes):
    parts = parts_of(c2=20 * SET6["c2"])
    exact, found = APPROACH.step(parts, 100), APPROACH.solve(parts, nodes)
    assert abs(found.depth / exact.depth - 1) <= 2 * abs(found.speed / exact.speed - 1)


def test_a_depth_that_is_not_wanted_changes_nothing_else():
    parts = parts_of()
    with_depth, without = accepted(APPROACH, parts), accepted(APPROACH, parts, None)
    assert with_depth[:5] == without[:5]
    assert with_depth[5] > 0.0 == without[5]


# ---- speed ---------------------------------------------------------------------------------------


def test_what_the_nodes_miss_of_the_dashpots_is_added():
    """Notices: the correction by the drag dropped: errors are 3e-11 and 1e-10 then."""
    for c2 in (1.0, 3.0):
        parts = parts_of(c2=c2 * SET6["c2"], K=1e9)
        exact, found = APPROACH.step(parts, 100), APPROACH.solve(parts, NODES)
        assert abs(found.speed / exact.speed - 1) <= 5e-12


def test_the_first_guess_errs_by_the_second_order():
    """Of the other forces: a tenth of one, a hundredth of the error. Notices: one left out."""
    for one in ({"c2": 40.0}, {"c1": 60.0}, {"k1": 30.0}, {"P": 60.0}):
        errors = []
        for part in (1.0, 0.1):
            none = dict.fromkeys(("k1", "c1", "k2", "c2", "P"), 0.0)
            changes = {name: part * factor * SET6[name] for name, factor in one.items()}
            parts = parts_of(**{**none, **changes})
            ps, damper, wall = parts
            arc = make_arc(24)
            b = (APPROACH.speed / wall.speed) ** 0.2
            rest = b, APPROACH.speed, APPROACH.x1, APPROACH.v1, np.cos(1.0), np.sin(1.0)
            first_guess(ps, damper, wall, arc, *rest)
            guess = arc.table[impact.B : impact.B + 24].copy()
            assert settle(ps, damper, wall, arc, *rest)
            errors.append(np.abs(arc.table[impact.B : impact.B + 24] - guess).max() / b)
        assert errors[0] > 1e-7
        assert errors[1] < 0.04 * errors[0]


# ---- which impacts are short ---------------------------------------------------------------------


def test_only_a_small_share_of_other_forces_is_taken_for_a_short_impact():
    """Notices: a share of up to a half allowed, and none allowed."""
    for P in np.geomspace(1e4, 1e7, 60):
        parts = parts_of(P=P, K=1e9)
        share, lasting = share_of(APPROACH, parts)
        assert lasting < 0.2
        assert accepted(APPROACH, parts)[0] == (share < 0.1)


def test_only_what_is_short_beside_all_other_motion_is_taken_for_a_short_impact():
    for K in np.geomspace(1e5, 1e9, 60):
        parts = parts_of(K=K)
        share, lasting = share_of(APPROACH, parts)
        assert share < 0.1
        assert accepted(APPROACH, parts)[0] == (lasting < 0.2)


def test_a_short_impact_keeps_its_accuracy_up_to_the_largest_share():
    """The bound is where errors begin to grow. Notices: a bound five times as large."""
    worst = {}
    for K in (1e6, 1e7, 1e8):
        for phase in np.linspace(0, 6, 7):
            for speed in np.geomspace(1e-4, 1.0, 24):
                approach, parts = Approach(speed, 0.01, 0.1, phase), parts_of(K=K)
                solved, s, *_ = accepted(approach, parts)
                if solved:
                    exact = approach.step(parts, 60)
                    worst[speed, K, phase] = abs(-s / exact.speed - 1)
    assert len(worst) > 50
    assert max(worst.values()) <= 3e-9
