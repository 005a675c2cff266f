"""Cells under nonlinear springs without compiling: their errors, and their bounds of |r''|."""

import copy
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nlds_vines as nv
from nlds_vines.engine.host_orbits import HostOrbits
from nlds_vines.kernels.hosts.grid import host_grid, matrix_of
from nlds_vines.kernels.hosts.host_flight import drive_of
from nlds_vines.kernels.hosts.spring_cells import (
    ACCEPTED,
    LEVELS,
    bound_bends,
    end_cell,
    is_cell_clear,
    solve_cell,
    spring_cells,
    vary_cell,
)

LEVEL = 3


def frame_with_two_sinks(gap):
    """Return a frame with two sinks, and a ball between walls on a linear spring."""
    frame = nv.shear_frame([1.0] * 3, [9.0] * 3, ratio=0.02)
    walls = [nv.Wall(gap, side, law="restitution", e=0.6) for side in "+-"]
    springs = [nv.Spring(k2=0.02, k3=0.4), nv.Spring(k3=0.1, k5=0.6)]
    sinks = [
        nv.Damper(f"sink{i}", place, m=0.1, k=k, c=0.01, spring=spring, walls=walls)
        for i, (place, k, spring) in enumerate(
            zip(("roof", "floor1"), (-0.1, 0.05), springs, strict=True)
        )
    ]
    ball = nv.Damper("ball", "roof", m=0.05, k=0.02, c=0.01, walls=walls)
    return nv.System.from_host(frame, [*sinks, ball], force={"roof": 0.3}, omega=1.3)


@cache
def prepared():
    """Return the body, its grid, walls far away and the cells, which take seconds."""
    orbits = HostOrbits(frame_with_two_sinks(1e3))
    grid, _ = host_grid(orbits.body, 1)
    return orbits.body, grid, orbits.walls, spring_cells(orbits.body, grid, orbits.walls, 1)


class Cell:
    """A solved cell from a random state on, and the exact motion in it."""

    def __init__(self, seed=2):
        self.body, self.grid, self.walls, self.cells = copy.deepcopy(prepared())
        self.h = self.cells.lengths[LEVEL] * self.grid.h
        size = self.body.size
        start = np.random.default_rng(seed).normal(0.0, 0.4, 2 * size)
        y = self.cells.begin
        y[: 2 * size] = start
        drive_of(self.grid, 0, 0.0, y[2 * size :])
        self.doubt = solve_cell(self.body, self.cells, LEVEL, self.h, 1e-9)
        end_cell(self.body, self.cells, LEVEL)
        a = matrix_of(self.body)
        rows = self.body.rows.reshape(-1, size)
        answers = self.body.answers.reshape(-1, size)
        springs = [damper.spring for damper in frame_with_two_sinks(1e3).dampers]

        def rate(t, z):
            out = a @ z
            for row, answer, spring in zip(rows, answers, springs, strict=True):
                if spring is not None:
                    out[size : 2 * size] -= answer * spring.force(row @ z[:size])
            return out

        times = np.concatenate([[0.0], self.body.springs.constants.nodes * self.h, [self.h]])
        how = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "dense_output": True}
        exact = solve_ivp(rate, (0.0, self.h), y[: a.shape[0]].copy(), t_eval=times, **how)
        self.exact, self.rows, self.rate = exact, rows, rate

    def bends(self):
        """Return the largest |r''| of all links in the cell."""
        size = self.body.size
        states = self.exact.sol(np.linspace(0.0, self.h, 400)).T
        accelerations = np.array([self.rate(0.0, z)[size : 2 * size] for z in states])
        return np.abs(accelerations @ self.rows.T).max(axis=0)


def test_a_cell_has_the_motion_of_dop853():
    cell = Cell()
    assert cell.doubt < ACCEPTED * np.sqrt(1e-9)
    size = cell.body.size
    strokes = cell.rows @ cell.exact.y[:size, 1:-1]
    solved = cell.cells.strokes.reshape(-1, 16)
    assert np.abs(solved[:2] - strokes[:2]).max() < 1e-10
    end = cell.exact.y[: 2 * size, -1]
    assert np.abs(cell.cells.end[: 2 * size] - end).max() < 3e-12


def end_from(cell, start):
    """Return the end of the cell from another state on, solved to round-off."""
    cell.cells.begin[: len(start)] = start
    solve_cell(cell.body, cell.cells, LEVEL, cell.h, 1e-16)
    end_cell(cell.body, cell.cells, LEVEL)
    return cell.cells.end[: len(start)].copy()


def test_variations_of_a_cell_are_differences_of_its_end():
    cell = Cell()
    count = 3
    directions = np.random.default_rng(3).normal(0.0, 1.0, (count, 2 * cell.body.size))
    rows = directions.ravel().copy()
    assert vary_cell(cell.body, cell.cells, LEVEL, rows, count)
    start = cell.cells.begin[: 2 * cell.body.size].copy()
    for direction, varied in zip(directions, rows.reshape(count, -1), strict=True):
        slopes = []
        for h in (1e-4, 2e-4):
            ends = [end_from(cell, start + sign * h * direction) for sign in (1, -1)]
            slopes.append((ends[0] - ends[1]) / (2 * h))
        difference = (4 * slopes[0] - slopes[1]) / 3
        assert np.abs(varied - difference).max() < 1e-10 * np.abs(difference).max()


def test_variations_stay_where_the_elimination_fails():
    """Springs so stiff that the sweeps of the cell would not settle."""
    cell = Cell()
    cell.body.springs.k3[:] *= -1e4
    rows = np.eye(2 * cell.body.size)[0].copy()
    before = rows.copy()
    assert not vary_cell(cell.body, cell.cells, LEVEL, rows, 1)
    assert np.array_equal(rows, before)


def test_a_long_cell_under_stiff_springs_is_doubted():
    """The same cell with forces that turn 30 times as fast is refused."""
    cell = Cell()
    cell.body.springs.k3[:] *= 1e3
    doubt = solve_cell(cell.body, cell.cells, LEVEL, cell.h, 1e-9)
    assert not doubt <= ACCEPTED * np.sqrt(1e-9)


@pytest.mark.parametrize("size", [1e3, 1e80, np.nan])
def test_a_cell_without_a_solution_is_refused(size):
    cell = Cell()
    cell.cells.begin[: 2 * cell.body.size] = size
    with np.errstate(all="ignore"):
        doubt = solve_cell(cell.body, cell.cells, LEVEL, cell.h, 1e-9)
    assert not doubt < np.inf


@pytest.mark.parametrize("seed", range(4))
def test_bends_stay_within_their_bounds(seed):
    cell = Cell(seed=seed)
    assert is_cell_clear(cell.body, cell.walls, cell.cells, LEVEL, cell.h, 0.0)
    assert bound_bends(cell.body, cell.cells, LEVEL, cell.h)
    largest = cell.bends()
    assert np.all(largest <= cell.cells.bends)
    assert np.all(cell.cells.bends < 60 * largest)


def test_a_cell_is_clear_only_with_room_for_the_bend_between_nodes():
    """A wall just above the largest r at the nodes leaves a doubt, one beyond the bound none."""
    cell = Cell()
    walls = cell.walls
    assert is_cell_clear(cell.body, walls, cell.cells, LEVEL, cell.h, 0.0)
    assert not is_cell_clear(cell.body, walls, cell.cells, LEVEL, cell.h, 1e3)
    solved = np.abs(cell.cells.strokes.reshape(-1, 16)).max(axis=1)
    ends = [np.abs(cell.rows @ cell.exact.y[: cell.body.size, i]) for i in (0, -1)]
    top = np.maximum(solved, np.maximum(*ends))
    room = 0.125 * (0.0951 * cell.h) ** 2 * cell.cells.bends
    for wall in range(walls.number):
        link = walls.links[wall]
        walls.gaps[wall] = top[link] + 1.01 * room[link]
    assert is_cell_clear(cell.body, walls, cell.cells, LEVEL, cell.h, 0.0)
    for wall in range(walls.number):
        kept = walls.gaps[wall]
        walls.gaps[wall] = top[walls.links[wall]] * (1 - 1e-9)
        both = walls.gaps[wall ^ 1]
        walls.gaps[wall ^ 1] = walls.gaps[wall]
        assert not is_cell_clear(cell.body, walls, cell.cells, LEVEL, cell.h, 0.0)
        walls.gaps[wall], walls.gaps[wall ^ 1] = kept, both


def test_a_bound_that_reaches_too_far_is_no_bound():
    """If r may leave the interval for which the forces are bounded, the cell is doubted."""
    cell = Cell()
    cell.cells.by_force[:] *= 1e4
    assert not bound_bends(cell.body, cell.cells, LEVEL, cell.h)
    assert not is_cell_clear(cell.body, cell.walls, cell.cells, LEVEL, cell.h, 0.0)


def test_lengths_are_halved():
    cell = Cell()
    assert len(cell.cells.lengths) == LEVELS
    assert np.all(cell.cells.lengths[:-1] == 2.0 * cell.cells.lengths[1:])
