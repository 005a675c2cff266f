"""Flight between rigid walls: its short cuts beside the way that all other flights take."""

import numpy as np
import pytest
from support import kernel_cell

from nlds_vines.kernels.flight import CELLS, PERIOD, at, cell_polynomial, cells_of, grid_of, step
from nlds_vines.kernels.rigid_flight import (
    LONG_SPAN,
    after_jump,
    from_start,
    grid_of_spans,
    knows_end,
    note_end,
    note_speeds,
    unless_at_once,
)
from nlds_vines.kernels.scene import damper_in, ground_under, structure_of, with_load

NUMBERS = {"m1": 1000.0, "k1": 3.95e4, "c1": 452.0, "m2": 60.0, "k2": 669.0, "c2": 50.8}
FORCED = {**NUMBERS, "P": 800.0, "omega": 3.0}


def scene(kind):
    """Return (structure, damper, cells of a period)."""
    cell = kernel_cell(**FORCED)
    ps, damper = structure_of(cell), damper_in(cell)
    if kind == "load":
        ps = with_load(ps, -9.81)
    if kind == "ground":
        damper = ground_under(cell)
    return ps, damper, cells_of(ps, damper)


def states():
    return [tuple(float(x) for x in y) for y in np.random.default_rng(11).uniform(-1, 1, (20, 4))]


@pytest.mark.kernels
@pytest.mark.parametrize("kind", ["damper", "load", "ground"])
def test_the_cells_of_a_span_follow_from_its_start_as_one_from_the_other(kind):
    """Notices: a wrong power, cos and sin that do not turn from cell to cell, a load left out."""
    ps, damper, n = scene(kind)
    plain, grid = grid_of(ps, damper, n), grid_of_spans(ps, damper, n, PERIOD)
    assert n >= LONG_SPAN
    for begin in states():
        for first in range(n - LONG_SPAN + 1):
            y = begin
            for j in range(first, first + LONG_SPAN):
                y = step(damper, plain.table, j, *y)
                found = from_start(
                    grid.powers, None, grid.load, damper, grid.table, (first, begin), j, y
                )
                assert found == pytest.approx(y, rel=1e-14, abs=1e-14 * np.max(np.abs(y)))


@pytest.mark.kernels
@pytest.mark.parametrize("kind", ["damper", "load"])
def test_after_an_impact_a_cell_ends_as_its_own_polynomial_says(kind):
    """Notices: a jump of the wrong sign, or taken from the start of the cell."""
    ps, damper, n = scene(kind)
    grid = grid_of_spans(ps, damper, n, PERIOD)
    w, j = grid.table, 2
    phase = w[CELLS + 6 * j + 4], w[CELLS + 6 * j + 5]
    for place, begin in zip(np.linspace(0.0, 1.0, 20), states(), strict=True):
        note_end(grid.powers, w, step(damper, w, j, *begin))
        cell_polynomial(grid, *begin, *phase)
        touch = at(w, place)
        note_speeds(grid.powers, w, touch)
        assert knows_end(grid.powers, w)
        left = touch[0], touch[1] + 0.3, touch[2], touch[3] - 2.0
        found = after_jump(grid.powers, w, 1.0 - place, left)
        turned = turned_by(ps.omega * grid.h * place, phase)
        cell_polynomial(grid, *left, *turned)
        expected = at(w, 1.0 - place)
        assert found == pytest.approx(expected, rel=1e-13, abs=1e-14 * np.max(np.abs(expected)))


def turned_by(angle, phase):
    """Return (cos, sin) of a phase turned by an angle [rad]."""
    c, d = np.cos(angle), np.sin(angle)
    return phase[0] * c - phase[1] * d, phase[1] * c + phase[0] * d


def test_a_contact_that_took_time_ends_what_was_known():
    ps, damper, n = scene("damper")
    grid = grid_of_spans(ps, damper, n, PERIOD)
    assert not knows_end(grid.powers, grid.table)
    note_speeds(grid.powers, grid.table, (0.1, 0.2, 0.3, 0.4))
    unless_at_once(grid.powers, grid.table, 0.0)
    assert knows_end(grid.powers, grid.table)
    unless_at_once(grid.powers, grid.table, 1e-300)
    assert not knows_end(grid.powers, grid.table)
