"""Short impacts of hosts without compiling: their series with what they leave out, and the jump."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg

import nlds_vines as nv
from nlds_vines.engine.host_orbits import HostOrbits
from nlds_vines.kernels.hosts import host_impact
from nlds_vines.kernels.hosts.body import along
from nlds_vines.kernels.hosts.grid import LONG_TERMS, WINDOW, host_grid, matrix_of
from nlds_vines.kernels.hosts.host_flight import bound_of, derive, r_and_slope
from nlds_vines.kernels.hosts.host_orbit import host_flow
from nlds_vines.kernels.impact.arc import LEVEL


def frame(storeys=4, dashpot=60.0):
    host = nv.shear_frame([1000.0] * storeys, [8e5] * storeys, ratio=0.01)
    omega = 0.95 * float(host.frequencies[0])
    walls = [nv.Wall(0.02, K=3e7), nv.Wall(0.03, "-", K=3e7)]
    cell = nv.Damper("cell", "roof", m=120.0, k=120.0 * omega**2, c=dashpot, walls=walls)
    return nv.System.from_host(host, [cell], force={"roof": 900.0}, omega=omega)


def beam():
    host = nv.beam(1.0, 65.6, 1.18, ratio=0.02).reduced(5, statics=["w20"])
    ball = nv.Damper("ball", "w20", m=0.06, k=40.0, c=0.3, walls=[nv.Wall(0.01, K=2e9)])
    return nv.System.from_host(host, [ball], force={"w20": 1.0}, omega=26.0)


SYSTEMS = {
    "one storey": frame(1),
    "four storeys": frame(4),
    "dashpot": frame(2, dashpot=6e3),
    "beam": beam(),
}


def flow_of(name):
    orbits = HostOrbits(SYSTEMS[name])
    return host_flow(orbits.body, orbits.walls, orbits.contacts(), orbits.room_for(0, False), 1)[0]


@pytest.fixture(params=SYSTEMS)
def flow(request):
    return flow_of(request.param)


@pytest.fixture(params=[name for name in SYSTEMS if name != "dashpot"])  # it has no short impacts
def short_flow(request):
    return flow_of(request.param)


def random_states(flow, count, seed=0):
    """Return states in which each pair moves, with the drive behind them."""
    size, rng = flow.host.body.size, np.random.default_rng(seed)
    states = rng.normal(size=(count, 2 * size + 2))
    states[:, :size] /= np.where(flow.space.scales > 0, flow.space.scales, 1.0)
    return states


def test_what_a_polynomial_of_r_leaves_out_is_bounded(flow):
    """The 32nd derivative over WINDOW long cells, by the bound of the fourth at their beginning."""
    body, grid = flow.host.body, flow.host.grid
    A, length = matrix_of(body), grid.h * 2 ** (grid.levels - grid.long)
    row = np.concatenate([body.rows[: body.size], np.zeros(body.size + 2)])
    last = row @ np.linalg.matrix_power(A * length, LONG_TERMS)
    largest = 0.0
    for z in random_states(flow, 20):
        gaps = np.array(along(body, 0, z, 0))
        bound = grid.rests[0] * bound_of(body, grid, 0, z, gaps, z[-2:])
        places = np.linspace(0, WINDOW, 61) * length
        true = max(abs(last @ scipy.linalg.expm(A * t) @ z) for t in places)
        assert true <= bound
        largest = max(largest, true / bound)
    assert largest > 1e-12  # the bound is loose, by powers of the highest frequency


def test_polynomials_of_r_and_their_derivatives(flow):
    body, grid = flow.host.body, flow.host.grid
    A, length = matrix_of(body), grid.h * 2 ** (grid.levels - grid.long)
    for z in random_states(flow, 3):
        flow.host.scratch.columns[: len(z)] = z
        r = flow.host.scratch.r
        host_impact.expand_long(body, grid, 0, flow.host.scratch.columns, r)
        exact = np.polynomial.Polynomial(r[:LONG_TERMS])
        size = np.abs(r).sum()
        for x in (0.0, 0.3, 1.0):
            later = scipy.linalg.expm(A * (x * length)) @ z
            value, slope = r_and_slope(r, x)
            assert value == pytest.approx(along(body, 0, later, 0)[0], abs=1e-13 * size)
            assert slope == pytest.approx(length * along(body, 0, later, 0)[1], abs=1e-12 * size)
            for k in (1, 2, 7, 16, 29):
                four = derive(r, k, x)
                for i in range(min(4, LONG_TERMS - k)):
                    true = exact.deriv(k + i)(x) / float(np.prod(np.arange(1.0, k + i + 1)))
                    assert four[i] == pytest.approx(true, rel=1e-12, abs=1e-14 * size)


def test_weights_of_the_memory_and_their_bounds(flow):
    """Those that are computed invert the series of the gap; those beyond stay below a power."""
    body, short = flow.host.body, flow.host.short
    A = matrix_of(body)[: 2 * body.size, : 2 * body.size] * short.length
    state = np.concatenate([np.zeros(body.size), body.answers[: body.size]])
    g, count = [], 3 * host_impact.SUMMED
    for _ in range(count):
        g.append(along(body, 0, state, 0)[1])
        state = A @ state
    g = np.array(g) / g[0]
    inverse = [1.0]
    for k in range(1, count):
        inverse.append(-sum(g[k - i] * inverse[i] for i in range(k)))
    w = -np.array(inverse)
    known = short.weights[: host_impact.SUMMED]
    assert known == pytest.approx(w[: host_impact.SUMMED], rel=1e-9, abs=1e-12)
    k = np.arange(count)
    measured = slice(host_impact.LEAST_POWERS + 3, host_impact.SUMMED)
    assert np.all(np.abs(w[measured]) <= (1 + 1e-12) * short.growths[0] ** k[measured])
    q = host_impact.SUM_OF_WEIGHTS / short.reaches[0]
    assert np.all(np.abs(w) <= q**k)


def touch_of(flow, place=0.4, speed=0.3, seed=0):
    """Return the bound of |r''''| at the beginning of a long cell with a touch at a place."""
    body, grid, walls = flow.host.body, flow.host.grid, flow.host.walls
    A, length = matrix_of(body), grid.h * 2 ** (grid.levels - grid.long)
    z = 0.01 * random_states(flow, 1, seed)[0]
    forward = scipy.linalg.expm(A * (place * length))
    size, mass = body.size, body.modes  # r = w q - u, u the coordinate of the mass
    later = forward @ z
    r, s = along(body, 0, later, 0)
    later[mass] += r - walls.gaps[0]
    later[size + mass] += s - speed
    z = np.linalg.solve(forward, later)
    flow.host.scratch.columns[: len(z)] = z
    host_impact.expand_long(body, grid, 0, flow.host.scratch.columns, flow.host.scratch.r)
    gaps = np.array(along(body, 0, z, 0))
    return z, bound_of(body, grid, 0, z, gaps, z[-2:])


def test_the_rest_of_the_push_is_bounded(short_flow, monkeypatch):
    """(1) beside the terms that follow, for each number of powers."""
    short, parts = short_flow.host.short, []
    rest_of_push = host_impact.rest_of_push

    def noted(d, powers, bound):
        rest = rest_of_push(d, powers, bound)
        unit = host_impact.TIMES[powers] * host_impact.PER_FACTORIAL[powers]
        parts.append((powers, rest * unit))
        return math_inf if powers < host_impact.MOST_POWERS else 0.0

    math_inf = float("inf")
    monkeypatch.setattr(host_impact, "rest_of_push", noted)
    monkeypatch.setattr(host_impact, "PROMISING", math_inf)
    for seed in range(5):
        _, fourth = touch_of(short_flow, seed=seed)
        parts.clear()
        host_impact.approach_at(short_flow.host, 0, 0.4, fourth, 1e9)
        d = short.numbers
        times = np.linspace(0, host_impact.LONGEST_SHORT, 200)
        push = d[host_impact.OF_PUSH :][: host_impact.MOST_POWERS]
        for powers, bound in parts:
            beyond = sum(push[k] * times**k for k in range(powers, host_impact.MOST_POWERS))
            assert np.abs(beyond).max() <= bound * (1 + 1e-9) + 1e-16
    assert len(parts) > 3


def test_a_jump_is_the_free_motion_back_to_the_beginning_of_a_cell(flow):
    """An impulse at the release, and a force before it: moments about the cell's beginning."""
    body, short = flow.host.body, flow.host.short
    A = matrix_of(body)[: 2 * body.size, : 2 * body.size]
    b = np.concatenate([np.zeros(body.size), body.answers[: body.size]])
    b /= along(body, 0, b, 0)[1]
    rng = np.random.default_rng(1)
    for place in (0.0, 0.35, 0.95):
        y = rng.normal(size=2 * body.size)
        jumped, d = y.copy(), short.numbers
        moments = d[host_impact.OF_MOMENTS :]
        moments[:12] = 0.0
        moments[0] = 0.7
        host_impact.jump(short, 0, place, 4, 2 * body.size, jumped)
        moments[0] = 0.0
        later = scipy.linalg.expm(A * (place * short.length))
        size = np.abs(later @ b).max()
        assert later @ jumped == pytest.approx(later @ y - 0.7 * b, abs=3e-14 * size, rel=1e-12)


def test_nodes_change_the_memory_by_less_than_before(short_flow, monkeypatch):
    """By at most FELT_AGAIN times the share of its bound that was seen, and first by all of it."""
    changes, shares = [], []
    sweep, remember = host_impact.sweep, host_impact.remember_depths

    def swept(d, nodes, arc):
        changes.append(sweep(d, nodes, arc))
        return changes[-1]

    def remembered(d, nodes, arc):
        moved = remember(d, nodes, arc)
        if len(changes) > 1 and moved > 1e-12:  # the first one replaces a guess
            shares.append((len(changes), moved / (arc.remembered * changes[-2])))
        return moved

    monkeypatch.setattr(host_impact, "sweep", swept)
    monkeypatch.setattr(host_impact, "remember_depths", remembered)
    monkeypatch.setattr(host_impact, "STALE", 0.0)
    for seed in range(20):
        _, fourth = touch_of(short_flow, seed=seed, speed=0.1 + 0.1 * seed)
        arc = host_impact.approach_at(short_flow.host, 0, 0.4, fourth, 1e9)
        changes.clear()
        if arc.powers > 0 and arc.shrinks < host_impact.LARGEST_OF_HOST:
            host_impact.solve_short(short_flow.host.short, LEVEL.whole, LEVEL.error, arc)
    assert max(share for _, share in shares) < 1.0
    later = [b / a for (m, a), (n, b) in pairwise(shares) if n == m + 1]
    assert 0 < max(later) < host_impact.FELT_AGAIN


def test_a_grid_is_fine_enough_for_long_cells():
    for system in SYSTEMS.values():
        grid, is_fine = host_grid(HostOrbits(system).body, 1)
        assert is_fine
        assert 0 <= grid.long <= grid.levels


def test_the_fourth_derivative_of_r_is_bounded_over_a_coarse_cell(flow):
    """Also for a motion that begins with rates alone."""
    body, grid = flow.host.body, flow.host.grid
    A, coarse = matrix_of(body), grid.h * 2**grid.levels
    row = np.concatenate([body.rows[: body.size], np.zeros(body.size + 2)])
    fourth = row @ np.linalg.matrix_power(A, 4)
    pairs = 2 * body.size + 2
    for z in (*random_states(flow, 20), *np.eye(pairs)):
        bound = bound_of(body, grid, 0, z, np.array(along(body, 0, z, 0)), z[-2:])
        motions = [scipy.linalg.expm(A * t) @ z for t in np.linspace(0, coarse, 31)]
        size = np.abs(fourth) @ np.abs(z)
        assert max(abs(fourth @ later) for later in motions) <= bound + 1e-13 * size
