"""Numbers of an orbit under a load, kernel by kernel: captures, passages, batches, last times."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from nlds_vines.kernels.cells.load_edges import ends_of_cell, lasts_until, touch_by
from nlds_vines.kernels.cells.load_numbers import Asked, fill_capture
from nlds_vines.kernels.cells.load_orbit import Load
from nlds_vines.kernels.cells.load_passages import (
    ABOVE,
    BATCHES,
    CROSSINGS,
    FIRST_PASSAGE,
    NEVER,
    RMS,
    STATISTICS,
    SURE,
    above_in_cell,
    fill_passages,
)
from nlds_vines.kernels.cells.load_times import (
    NO_PLACE,
    excess_in_cell,
    last_place_above,
    may_exceed,
    motion_in,
    place_of_most,
)
from nlds_vines.kernels.motion.bounds import REACH
from nlds_vines.kernels.motion.load_cells import LOAD_ROW, sums_of
from nlds_vines.kernels.scene.scene import Structure
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS, RELEASE, TOUCH, WALL, Impacts


def impacts_at(touches, lasting=0.01, walls=0):
    data = np.zeros((len(touches), IMPACT_COLUMNS))
    data[:, TOUCH], data[:, RELEASE] = touches, np.asarray(touches) + lasting
    data[:, WALL] = walls
    return Impacts(data, np.array([len(touches)]))


def capture_of(touches, walls, end):
    """Return how long the longest capture lasts, its beginning and end; a period lasts 1.

    walls: how many there are, or which one each of the touches is on.
    """
    found, two = np.empty(3), np.size(walls) > 1
    impacts = impacts_at(touches, walls=walls if two else 0)
    fill_capture(impacts, 2 if two else walls, 1.0, end, found)
    return found.tolist()


def test_captures_are_the_longest_stretch_of_impacts_in_each_cycle():
    touches = [0.0, 5.0, 6.0, 7.02, 8.5, 10.1, 11.0]
    assert capture_of(touches, 1, 20.0) == [8.5 - 5.0, 5.0, 8.5]
    lasted, begin, end = capture_of(np.arange(0.3, 9.9, 0.5), np.arange(20) % 2, 10.0)
    assert (lasted, begin) == (pytest.approx(9.5), 0.3)
    assert math.isnan(end)
    one_sided = np.repeat([0, 1, 0], [2, 16, 2])  # the other wall is left alone meanwhile
    assert capture_of(np.arange(0.3, 9.9, 0.5), one_sided, 10.0)[0] <= 2.0
    for few in ([], touches[:1]):
        lasted, begin, end = capture_of(few, 1, 20.0)
        assert lasted == 0.0
        assert math.isnan(begin)
        assert math.isnan(end)


def test_captures_of_random_touches_are_those_of_all_stretches():
    rng = np.random.default_rng(5)
    for walls in (1, 2):
        for _ in range(50):
            touches = np.cumsum(rng.uniform(0.1, 2.0 / walls, 30))
            struck = rng.integers(0, walls, 30)
            lasted, begin, end = capture_of(touches, struck if walls == 2 else 1, 1000.0)
            best = 0.0
            for i in range(30):
                for j in range(i + walls, 30):
                    own, on = touches[i : j + 1], struck[i : j + 1]
                    gaps = [
                        np.diff([own[0], *own[on == wall], own[-1]]).max() for wall in range(walls)
                    ]
                    if max(gaps) <= 1.5 and len(set(on)) == walls:
                        best = max(best, own[-1] - own[0])
            assert lasted == best
            if best:
                assert end - begin == best


def test_a_contact_lasts_from_its_touch_to_its_release():
    impacts, j, seen = impacts_at([1.0, 2.0], lasting=0.5), -1, []
    times = (0.9, 1.0, 1.4, 1.6, 2.2, 3.0, 1.2)  # the last one is looked for backward
    for time in times:
        j = touch_by(impacts, j, time)
        seen.append((j, lasts_until(impacts, j, time)))
    assert seen == [
        (-1, False), (0, True), (0, True), (0, False), (1, True), (1, False), (0, True),
    ]  # fmt: skip
    impacts.data[0, RELEASE] = math.nan  # ended by a jump: over when the next one begins
    assert lasts_until(impacts, touch_by(impacts, -1, 1.9), 1.9)
    assert not lasts_until(impacts, touch_by(impacts, -1, 2.6), 2.6)


def test_no_cell_holds_more_than_its_bound_says():
    """The largest of 2001 places, of 300 random forces; the first would be missed without them."""
    rng, h = np.random.default_rng(6), REACH
    ps = Structure(1.0, 1.0, 1.0, 0.0, 1.0, 0.0, None, None)
    for i in range(300):
        rows, section = np.zeros(LOAD_ROW), np.zeros((2, 4))
        rows[: 1 + i % 4] = rng.normal(size=1 + i % 4)
        section[0, :2] = rng.normal(size=2) * 10.0 ** rng.uniform(-6.0, 0.5)
        if i == 0:  # from rest by 1 - 2 x
            rows[:2], section[0] = (1.0, -2.0), 0.0
        load = Load(np.array([0.0, h]), rows, np.zeros(2), sums_of(rows), None)
        motion = motion_in(ps, None, load, section, 0)
        section[1, :2] = motion.sum(axis=0)
        most = max(excess_in_cell(ps, motion, 0.0, x) for x in np.linspace(0.0, 1.0, 2001))
        ends = ends_of_cell(ps, None, load, section, 0)
        assert may_exceed(most * (1.0 - 1e-12), h, ends, False, False)
        assert ends[2] >= most


def test_a_random_cubic_is_above_zero_where_its_values_are():
    rng, x = np.random.default_rng(3), np.linspace(0.0, 1.0, 20001)
    for _ in range(300):
        f0, f1, g0, g1 = rng.normal(size=4) * [1, 1, 6, 6]
        values = (
            f0 * (1 + 2 * x) * (1 - x) ** 2 + g0 * x * (1 - x) ** 2
            + f1 * x**2 * (3 - 2 * x) + g1 * x**2 * (x - 1)
        )  # fmt: skip
        over = values > 0.0
        rises = np.flatnonzero(~over[:-1] & over[1:])
        share, count, place = above_in_cell(f0, f1, g0, g1)
        assert share == pytest.approx(over.mean(), abs=2e-4)
        assert count == len(rises)
        assert place == (pytest.approx(x[rises[0]], abs=1e-4) if count else NEVER)


def statistics_of(x1, v1, squares, level, settle, h):
    """Return the statistics of values, velocities and integrals of x1^2 at edges h apart."""
    edges, found = h * np.arange(len(x1)), np.full(STATISTICS, math.nan)
    load = SimpleNamespace(edges=edges, jumps=np.zeros(len(edges)))
    sums = np.zeros((len(edges), 5))
    sums[:, 4] = squares
    buffers = SimpleNamespace(section=np.column_stack([x1, v1, x1, v1]), sums=sums)
    fill_passages(load, buffers, Asked(np.zeros(3), level, settle), found)
    return found


def test_statistics_of_a_sine():
    """|sin t| is above 1/2 for 2/3 of the time, and rises above it twice in a period."""
    h = 2 * math.pi / 64
    t = h * np.arange(64 * 40 + 1)
    found = statistics_of(np.sin(t), np.cos(t), t / 2 - np.sin(2 * t) / 4, 0.5, 0.0, h)
    assert found[RMS] == pytest.approx(math.sqrt(0.5), rel=1e-12)
    assert found[ABOVE] == pytest.approx(2 / 3, abs=1e-6)
    assert found[CROSSINGS] == pytest.approx(2 / (2 * math.pi), rel=1e-12)
    error = h**4 / 384 * 0.5  # of the cubic where sin t is 1/2; there its slope is cos(pi / 6)
    assert found[FIRST_PASSAGE] == pytest.approx(math.pi / 6, abs=error / math.cos(math.pi / 6))
    np.testing.assert_allclose(found[RMS + 1 : RMS + 3], found[RMS], rtol=1e-10)  # no spread


def test_intervals_are_those_of_batch_means():
    rng, h = np.random.default_rng(8), 0.1
    x1 = rng.normal(size=3401)
    squares = np.concatenate([[0.0], np.cumsum(h * x1[1:] ** 2)])
    found = statistics_of(x1, np.zeros(3401), squares, 1.0, 20.0, h)
    means = (x1[201:].reshape(BATCHES, -1) ** 2).mean(axis=1)
    half = SURE * means.std(ddof=1) / math.sqrt(BATCHES)
    wanted = np.sqrt([means.mean(), means.mean() - half, means.mean() + half])
    np.testing.assert_allclose(found[RMS : RMS + 3], wanted, rtol=1e-12)
    assert found[ABOVE + 1] < found[ABOVE] < found[ABOVE + 2]
    first = np.flatnonzero(np.abs(x1) > 1.0)[0]
    assert h * (first - 1) < found[FIRST_PASSAGE] <= h * first


def test_no_passage_is_no_time():
    h, t = 0.1, 0.1 * np.arange(400)
    found = statistics_of(np.sin(t), np.cos(t), t, 1.5, 0.0, h)
    assert math.isnan(found[FIRST_PASSAGE])
    assert found[ABOVE] == found[CROSSINGS] == 0.0


def test_an_energy_is_last_above_a_level_at_the_root_of_its_polynomial():
    ps = SimpleNamespace(m1=2.0, k1=0.0)
    motion = np.zeros((15, 2))
    motion[0, 1], motion[1, 1] = 1.0, -1.0  # v1 = 1 - x, E1 = (1 - x)^2
    assert last_place_above(ps, motion, 0.25) == pytest.approx(0.5, abs=1e-15)
    assert last_place_above(ps, motion, -1.0) == 1.0
    assert last_place_above(ps, motion, 1.5) == NO_PLACE
    motion[1, 1], motion[2, 1] = 1.2, -1.0  # v1 = 1 + 1.2 x - x^2, below 1.3 at both ends
    assert last_place_above(ps, motion, 1.3**2) == pytest.approx(0.6 + math.sqrt(0.06), abs=1e-15)
    assert place_of_most(ps, motion) == pytest.approx(0.6, abs=1e-15)
