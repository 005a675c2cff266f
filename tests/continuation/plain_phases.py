"""Branches of rigid bodies whose impacts pass the phase of the section, and graze two at a time.

A damper between two walls under restitution, T,2: its impact passes phase zero at omega = 1.2128,
and at 1.07382 both walls are grazed at once. (Run by `contract/test_plain.py`.)
"""

import numpy as np
import pytest
from support import kernel_state

from nlds_vines import load_system
from nlds_vines.continuation import arclength
from nlds_vines.continuation.branch_arm import Bounds, first_point, follow
from nlds_vines.engine.section_map import SectionMap

SYSTEM = load_system(
    "ssbl", law="restitution", m1=1.0, k1=1.0, P=1.0, C=1.0, D=1.0, c1=0.04, m2=0.05,
    k2=0.0453152, c2=0.0127, e=0.9,
)  # fmt: skip
# (omega, (x1, v1, x2, v2)): before the impact passes phase zero
BEFORE = 1.2249972454229396, (
    -1.6313374820442195, 0.2828298996933553, -1.6135583166033252, -1.6467655311720084
)  # fmt: skip
# near the grazing at both walls
SOFT = 1.0745428059013842, (
    -4.486831067410545, 0.9730590463897917, -3.8500663394336883, 3.5841913471960027
)  # fmt: skip


def on_branch(case, phase=0.0):
    """Return the map at a phase, and a case's orbit there as a point of the branch of omega."""
    omega, state = case
    place = np.append(kernel_state(SYSTEM.with_(omega=omega), state), omega)
    zero = SectionMap(SYSTEM, ("omega",))
    shot = zero.shot(phase)
    cycle = shot.at(zero.later(place, phase), 1)
    return shot, arclength.point_of(shot, cycle, np.eye(5)[4], np.ones(1))


def down(case, low):
    """Follow the branch of a case down to omega = `low`."""
    zero, point = on_branch(case)
    start = first_point(zero, point.cycle, Bounds(low, 2.5), -1.0)
    return follow(zero, start, Bounds(low, 2.5))


def test_a_branch_goes_on_where_an_impact_passes_phase_zero_and_ends_where_two_graze():
    arm = down(BEFORE, 1.2)
    assert arm.end == "bound"
    assert not arm.specials
    cycles = [point.cycle for point in arm.points]
    assert {cycle.counts for cycle in cycles} == {(1, 1)}
    assert max(cycle.defect for cycle in cycles) < 1e-9
    # the stored states are at phase zero: only an impact that passes it makes them jump
    assert {cycle.since for cycle in cycles} == {0.0}
    jumps = np.sort(np.abs(np.diff([cycle.state[3] for cycle in cycles])))
    assert jumps[-1] > 1.0 > 0.2 > jumps[-2]
    # impacts at both walls graze as one
    arm = down(SOFT, 1.0735)
    assert arm.end == "grazing"
    (special,) = arm.specials
    assert (special.kind, special.wall) == ("GR", "both")
    assert (special.before, special.after) == ("T,2", "T,4")
    assert special.value == pytest.approx(1.0738219690, abs=1e-9)


def test_an_orbit_is_one_at_any_phase():
    zero, point = on_branch(SOFT)
    for phase in (0.25, 0.5):
        shot = zero.shot(phase)
        there = arclength.moved(zero, shot, point)
        assert there.cycle.since == phase
        assert there.cycle.defect < 1e-11
        again = shot.at(there.cycle.place, 1).multipliers
        np.testing.assert_allclose(np.sort(abs(again)), np.sort(abs(point.cycle.multipliers)), 1e-8)
        back = arclength.point_at_zero(zero, there)
        np.testing.assert_allclose(back.cycle.place, point.cycle.place, rtol=0, atol=1e-11)
        size = np.abs(point.tangent).max()
        np.testing.assert_allclose(back.tangent, point.tangent, rtol=0, atol=1e-7 * size)


def test_derivatives_at_a_phase_are_those_of_differences():
    shot, point = on_branch(SOFT, 0.375)
    place = point.cycle.place
    for i, exact in enumerate([*point.cycle.matrix.T, point.cycle.slopes[0]]):
        step = 1e-6 * np.eye(5)[i]
        ahead, behind = (shot.at(place + sign * step, 1).points[0] for sign in (1, -1))
        slope = (ahead - behind) / 2e-6
        np.testing.assert_allclose(exact, slope, rtol=0, atol=1e-6 * np.abs(slope).max())


def test_the_phase_changes_before_an_impact_is_near():
    """It moves to the middle of the longest flight, and stays there."""
    zero, point = on_branch(BEFORE)
    better = arclength.better_map(zero, point.cycle)
    rows = zero.impacts(point.cycle.place, 1)
    assert rows[:, 0].tolist() in ([0, 1], [1, 0])
    apart = np.abs((rows[:, 1] - better.since + 0.5) % 1.0 - 0.5)
    np.testing.assert_allclose(apart, 0.25, rtol=0, atol=0.05)
    assert arclength.better_map(better, arclength.moved(zero, better, point).cycle) is None


@pytest.mark.parametrize("case", [SOFT, BEFORE])
def test_an_orbit_between_two_walls_is_known_as_its_own_mirror(case):
    zero, point = on_branch(case)
    assert zero.grazing_walls(point.cycle, "slowest") == (0, 1)
    aside = zero.at(point.cycle.place * (1.0 + 1e-4 * np.eye(5)[0]), 1)
    assert zero.grazing_walls(aside, "slowest") == ()
