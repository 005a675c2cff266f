"""Short impacts over the whole domain of `short_impact`, beside the twin in 80-bit arithmetic."""

from typing import NamedTuple

import numpy as np
import pytest
from support import contact_parts, side_of
from twin import HIGH, PI, REAL, Lanes, Model

from nlds_vines.kernels.impact import arc as arc_table
from nlds_vines.kernels.impact.arc import CHOICES, make_arc
from nlds_vines.kernels.impact.impact import approach_of, short_impact

pytestmark = pytest.mark.kernels

TOLERANCES = (1e-6, 1e-9, 1e-12)
OF_TWIN = 1e-13  # relative, of a duration: six of 10,000 by the twin, whatever n, are off so far
ROUND_OFF = 2e-14  # relative, of a depth and of a time that are sums of some twenty terms


class Impacts(NamedTuple):
    """Impacts at touch: a row of each parameter and of the state."""

    numbers: dict[str, np.ndarray]
    s: np.ndarray
    x1: np.ndarray
    v1: np.ndarray
    phase: np.ndarray

    def parts(self, i):
        return contact_parts(**{name: float(values[i]) for name, values in self.numbers.items()})

    def at_touch(self, i):
        """Return the phase (cos, sin) and (s, x1, v1)."""
        c, d = np.cos(self.phase[i]), np.sin(self.phase[i])
        return (float(c), float(d)), (float(self.s[i]), float(self.x1[i]), float(self.v1[i]))


def solved(impacts, i, arc):
    """Return (solved, s, x1, v1, duration, depth) of an impact."""
    phase, touch = impacts.at_touch(i)
    return short_impact(side_of(impacts.parts(i), arc), True, phase, (0.0, *touch))


def drawn(count, seed=1):
    """Return impacts that are short, and a few that touch the edge of what is."""
    rng, cases = np.random.default_rng(seed), []
    arc = make_arc(1e-3)
    while len(cases) < count:
        d = lambda low, high: 10.0 ** rng.uniform(low, high)  # noqa: E731  # decades
        m2 = d(-3, 0.5)
        one = {
            "m1": 1.0, "m2": m2, "k1": 1.0, "c1": d(-3, 0.3), "k2": m2 * d(-2, 2),
            "c2": m2 * d(-3, 1.5), "omega": d(-1, 1), "P": d(-2, 2), "near": rng.uniform(-1, 2),
            "K": d(1, 12),
        }  # fmt: skip
        state = d(-4, 2), rng.normal() * d(-2, 1), rng.normal() * d(-2, 1), rng.uniform(0, 6.28)
        impacts = Impacts({name: np.array([v]) for name, v in one.items()}, *np.array([state]).T)
        if solved(impacts, 0, arc)[0]:
            cases.append((one, state))
    names = cases[0][0]
    numbers = {name: np.array([one[name] for one, _ in cases]) for name in names}
    return Impacts(numbers, *np.array([state for _, state in cases]).T)


def seen_by_twin(impacts):
    """Return (s, x1, v1, duration, depth) at release, (5, count)."""
    n = {name: values.astype(REAL) for name, values in impacts.numbers.items()}
    zero, inf = np.zeros(len(impacts.s), REAL), np.full(len(impacts.s), REAL(np.inf))
    model = Model(
        n["m1"], n["k1"], n["c1"], n["m2"], n["k2"], n["c2"], n["P"], n["omega"], n["K"],
        zero, -inf, n["near"], zero,
    )  # fmt: skip
    # the twin's wall pushes above u = x2 - x1, ours above r = x1 - x2: displacements and the force
    # are mirrored, the latter by half a turn
    begun = (impacts.phase.astype(REAL) + PI) / n["omega"]
    y = np.array([-impacts.x1.astype(REAL), -impacts.v1.astype(REAL), n["near"], impacts.s, begun])
    lanes = Lanes(model, y, 1, noting=False)
    lanes.period = np.full(len(impacts.s), REAL(1e30))  # no section cuts an impact
    for i in range(len(impacts.s)):
        lanes.begin(i, 1, begun[i], impacts.s[i])
    lanes.mode[:] = HIGH
    while (under_way := np.flatnonzero(lanes.mode == HIGH)).size:
        lanes.touch(under_way)
    rows = np.array([contacts[0] for contacts in lanes.contacts])
    x1, v1, _, w, _ = lanes.y
    return np.array([w, -x1, -v1, rows[:, 2] - rows[:, 1], rows[:, 4]])


def errors_of(solutions, true, impacts):
    """Return the errors (5, count), each in units of the impact's own scale."""
    s, took, depth = impacts.s, true[3], true[4]
    off = np.abs(np.array(solutions) - true)
    # 80 bits hold a short duration in a time from phase zero, and a depth in a place, so well
    off[3] = np.maximum(off[3] - 4e-18 / impacts.numbers["omega"], 0)
    off[4] = np.maximum(off[4] - 4e-19 * np.abs(impacts.numbers["near"]), 0)
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
        solutions = np.array([solved(impacts, i, arc) for i in range(count)])
        assert solutions[:, 0].mean() > 0.995
        errors = errors_of(solutions[:, 1:].T, true, impacts)[:, solutions[:, 0] > 0]
        print(tolerance, errors.max(axis=1))
        assert errors.max() <= tolerance + ROUND_OFF
        assert 1.5 * errors[4].max() <= tolerance + ROUND_OFF  # of the force K z^1.5


@pytest.mark.parametrize("count", COUNT)
@pytest.mark.parametrize("n", [8, 12, 16, 20])
def test_the_estimate_is_never_below_a_third_of_the_error(count, n):
    impacts = drawn(count)
    true = seen_by_twin(impacts)
    approaches = (
        approach_of(side_of(impacts.parts(i)), *impacts.at_touch(i)) for i in range(count)
    )
    size = np.array([approach.size for approach in approaches]) ** 1.5
    solutions = np.array([solved(impacts, i, make_arc(nodes=n)) for i in range(count)])
    settled = solutions[:, 0] > 0  # few do not in twelve sweeps: they are stepped
    assert settled.mean() > 0.998
    errors, size = errors_of(solutions[:, 1:].T, true, impacts)[:, settled], size[settled]
    release, depth = errors[[0, 3]].max(axis=0), errors[4]
    whole, half = CHOICES[n]
    print(n, (release / size)[release > ROUND_OFF].max(initial=0), (depth / size).max())
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
        solutions = np.array([solved(impacts, i, one) for i in range(600)])
        worst[name] = errors_of(solutions[:, 1:].T, true, impacts)[0][solutions[:, 0] > 0]
    assert (worst["believed"] > 10 * tolerance).sum() > 20
    caught = worst["checked"][worst["believed"] > 10 * tolerance] <= tolerance
    print(caught.mean(), worst["checked"].max(), worst["believed"].max())
    assert caught.mean() > 0.5
    assert worst["checked"].max() < 0.1 * worst["believed"].max()
