"""Numbers of an orbit under a load, kernel by kernel: contacts, bounds of E1, last times."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from nlds_vines.kernels.cells.load_numbers import (
    NO_PLACE,
    excess_in_cell,
    last_place_above,
    may_exceed,
    motion_in,
    place_of_most,
    rms_of_x1,
)
from nlds_vines.kernels.cells.load_orbit import Load, ends_of_cell, lasts_until, touch_by
from nlds_vines.kernels.motion.flight import REACH
from nlds_vines.kernels.motion.load_cells import LOAD_ROW, sums_of
from nlds_vines.kernels.scene.scene import Structure
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS, RELEASE, TOUCH, Impacts


def impacts_at(touches, lasting):
    data = np.zeros((len(touches), IMPACT_COLUMNS))
    data[:, TOUCH], data[:, RELEASE] = touches, np.asarray(touches) + lasting
    return Impacts(data, np.array([len(touches)]))


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


def test_the_rms_leaves_out_what_is_before_the_time_to_settle():
    edges, sums = np.array([0.0, 1.0, 3.0, 4.0]), np.zeros((4, 5))
    sums[:, 4] = 0.0, 2.0, 6.0, 20.0
    for settle, rms in ((0.0, 5.0), (0.5, 6.0), (1.0, 6.0), (3.0, 14.0), (3.9, 14.0)):
        assert rms_of_x1(edges, sums, settle) == math.sqrt(rms)


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
        jumps = np.array([0.0, rng.normal()])  # of which the motion in the cell knows nothing
        load = Load(np.array([0.0, h]), rows, jumps, sums_of(rows), None)
        motion = motion_in(ps, None, load, section, 0)
        section[1, :2] = motion.sum(axis=0)
        section[1, 1] += jumps[1]
        most = max(excess_in_cell(ps, motion, 0.0, x) for x in np.linspace(0.0, 1.0, 2001))
        ends = ends_of_cell(ps, None, load, section, 0)
        assert may_exceed(most * (1.0 - 1e-12), h, ends, False, False)
        assert ends[2] >= most


def test_the_ends_of_a_cell_are_before_a_jump_at_its_end():
    ps = Structure(2.0, 3.0, 0.0, 0.0, 1.0, 0.0, None, None)
    rows, jumps = np.zeros(2 * LOAD_ROW), np.array([7.0, 5.0, 0.0])
    section = np.array([[0.1, 0.2, 0.0, 0.0], [0.3, 5.4, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])
    load = Load(np.array([0.0, 0.5, 1.0]), rows, jumps, sums_of(rows), None)
    begin, end, _, _ = ends_of_cell(ps, None, load, section, 0)
    twice = ps.m1 * np.array([0.2, 5.4 - 5.0]) ** 2 + ps.k1 * np.array([0.1, 0.3]) ** 2
    assert (begin[0], end[0]) == pytest.approx(tuple(0.5 * twice))


def test_a_contact_may_bring_all_energy_of_its_cell_and_more_if_it_has_begun_before():
    h, begin, end = 0.5, (3.0, 0.0, -1.0), (2.0, 0.0, 4.0)
    for order in ((begin, end), (end, begin)):
        assert may_exceed(9.99, h, (*order, 10.0, 0.0), True, False)
        assert not may_exceed(9.99, h, (*order, 9.9, 0.0), True, False)
        assert may_exceed(9.99, h, (*order, 0.0, 0.0), True, True)  # what it holds is unknown


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
