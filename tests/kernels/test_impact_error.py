"""Short impacts over the whole domain of `short_impact`, beside the twin in 80-bit arithmetic."""

from functools import partial

import numpy as np
import pytest
from support import Approach, contact_parts, side_of
from twin import HIGH, PI, REAL, Lanes, Model

from nlds_vines.kernels.impact import arc as arc_table
from nlds_vines.kernels.impact.arc import CHOICES, make_arc
from nlds_vines.kernels.impact.impact import approach_of, short_impact

pytestmark = pytest.mark.kernels

TOLERANCES = (1e-6, 1e-9, 1e-12)
OF_TWIN = 1e-13  # relative, of a duration: six of 10,000 by the twin, whatever n, are off so far
ROUND_OFF = 2e-14  # relative, of a depth and of a time that are sums of some twenty terms


def solved(numbers, approach, arc):
    """Return (solved, s, x1, v1, duration, depth) of an impact."""
    side = side_of(contact_parts(**numbers), arc)
    return short_impact(side, True, approach.wave, approach.touch)


def drawn(count, seed=1):
    """Return impacts (numbers, approach) that are short, and a few at the edge of what is."""
    rng, impacts, arc = np.random.default_rng(seed), [], make_arc(1e-3)
    while len(impacts) < count:
        d = lambda low, high: 10.0 ** rng.uniform(low, high)  # noqa: E731  # decades
        m2 = d(-3, 0.5)
        numbers = {
            "m1": 1.0, "m2": m2, "k1": 1.0, "c1": d(-3, 0.3), "k2": m2 * d(-2, 2),
            "c2": m2 * d(-3, 1.5), "omega": d(-1, 1), "P": d(-2, 2), "near": rng.uniform(-1, 2),
            "K": d(1, 12),
        }  # fmt: skip
        state = d(-4, 2), rng.normal() * d(-2, 1), rng.normal() * d(-2, 1), rng.uniform(0, 6.28)
        if solved(numbers, Approach(*state), arc)[0]:
            impacts.append((numbers, Approach(*state)))
    return impacts


def column(impacts, name):
    """Return a parameter, or a number of the approach, of all impacts."""
    return np.array([{**numbers, **vars(approach)}[name] for numbers, approach in impacts], REAL)


def seen_by_twin(impacts):
    """Return (s, x1, v1, duration, depth) at release, (5, count)."""
    lanes_of = partial(column, impacts)
    s, zero = lanes_of("speed"), np.zeros(len(impacts), REAL)
    of_structure = map(lanes_of, ("m1", "k1", "c1", "m2", "k2", "c2", "P", "omega", "K"))
    model = Model(*of_structure, zero, zero - np.inf, lanes_of("near"), zero)
    # the twin's wall pushes above u = x2 - x1, ours above r = x1 - x2: displacements and the force
    # are mirrored, the latter by half a turn
    begun = (lanes_of("phase") + PI) / model.omega
    y = np.array([-lanes_of("x1"), -lanes_of("v1"), model.high, s, begun])
    lanes = Lanes(model, y, 1, noting=False)
    lanes.period = np.full(len(impacts), REAL(1e30))  # no section cuts an impact
    for i in range(len(impacts)):
        lanes.begin(i, 1, begun[i], s[i])
    lanes.mode[:] = HIGH
    while (under_way := np.flatnonzero(lanes.mode == HIGH)).size:
        lanes.touch(under_way)
    rows = np.array([contacts[0] for contacts in lanes.contacts])
    x1, v1, _, w, _ = lanes.y
    return np.array([w, -x1, -v1, rows[:, 2] - rows[:, 1], rows[:, 4]])


def errors_of(solutions, true, impacts):
    """Return the errors (5, count), each in units of the impact's own scale."""
    s, took, depth = column(impacts, "speed"), true[3], true[4]
    off = np.abs(np.array(solutions) - true)
    # 80 bits hold a short duration in a time from phase zero, and a depth in a place, so well
    off[3] = np.maximum(off[3] - 4e-18 / column(impacts, "omega"), 0)
    off[4] = np.maximum(off[4] - 4e-19 * np.abs(column(impacts, "near")), 0)
    # x1 and v1 in double precision hold the impact's own part of them only so well
    scales = s, s * took + 1e3 * np.abs(true[1]), s + 1e3 * np.abs(true[2]), took, depth
    return off.astype(float) / np.array(scales, float)


COUNT = [300, pytest.param(10_000, marks=pytest.mark.long)]


@pytest.mark.parametrize("count", COUNT)
def test_error_at_most_the_tolerance(count):
    """Of speed, place, duration, depth and force. Notices: a correction or a sweep left out."""
    impacts = drawn(count)
    true = seen_by_twin(impacts)
    for tolerance in TOLERANCES:
        arc = make_arc(tolerance)
        solutions = np.array([solved(*impact, arc) for impact in impacts])
        assert solutions[:, 0].mean() > 0.995
        errors = errors_of(solutions[:, 1:].T, true, impacts)[:, solutions[:, 0] > 0]
        assert errors.max() <= tolerance + ROUND_OFF
        assert 1.5 * errors[4].max() <= tolerance + ROUND_OFF  # of the force K z^1.5


@pytest.mark.parametrize("count", COUNT)
@pytest.mark.parametrize("n", [8, 12, 16, 20])
def test_the_estimate_is_never_below_a_third_of_the_error(count, n):
    impacts = drawn(count)
    true = seen_by_twin(impacts)
    sides = (side_of(contact_parts(**numbers)) for numbers, _ in impacts)
    size = np.array([
        approach_of(side, approach.wave, approach.touch[1:]).size ** 1.5
        for side, (_, approach) in zip(sides, impacts, strict=True)
    ])  # fmt: skip
    arc = make_arc(nodes=n)
    solutions = np.array([solved(*impact, arc) for impact in impacts])
    settled = solutions[:, 0] > 0  # few do not in twelve sweeps: they are stepped
    assert settled.mean() > 0.998
    errors, size = errors_of(solutions[:, 1:].T, true, impacts)[:, settled], size[settled]
    release, depth = errors[[0, 3]].max(axis=0), errors[4]
    whole, half = CHOICES[n]
    assert (release <= 3 * whole * size + OF_TWIN).all()
    assert (depth <= 3 * half * size + ROUND_OFF).all()
    # and not far above it: half of the choices would otherwise never be made
    if n <= 16:
        assert (release / size).max() >= whole / 30


def test_a_wrong_estimate_is_caught():
    """With errors that are said to be none, eight nodes are tried first, and found wanting."""
    impacts, tolerance = drawn(600), 1e-10
    true = seen_by_twin(impacts)
    arc = make_arc(1e-6)._replace(tolerance=tolerance, settled=0.03 * tolerance)
    for level in range(arc.levels):
        row = arc_table.ARC.levels + arc_table.LEVEL_ROW * level
        arc.table[row + arc_table.LEVEL.error] = arc.table[row + arc_table.LEVEL.half_error] = 0.0
    believing = arc._replace(tolerance=np.inf)
    worst = {}
    for name, one in (("checked", arc), ("believed", believing)):
        solutions = np.array([solved(*impact, one) for impact in impacts])
        worst[name] = errors_of(solutions[:, 1:].T, true, impacts)[0][solutions[:, 0] > 0]
    assert (worst["believed"] > 10 * tolerance).sum() > 20
    caught = worst["checked"][worst["believed"] > 10 * tolerance] <= tolerance
    assert caught.mean() > 0.5
    assert worst["checked"].max() < 0.1 * worst["believed"].max()
