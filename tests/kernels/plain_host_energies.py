"""Largest energies of hosts without compiling: bounds, pieces that are skipped, short impacts."""

import math

import numpy as np
import pytest
import scipy.linalg
from scipy.integrate import solve_ivp

import nlds_vines as nv
from nlds_vines.engine.host_orbits import HostOrbits
from nlds_vines.kernels.hosts import host_energies, host_orbit
from nlds_vines.kernels.hosts.grid import matrix_of
from nlds_vines.kernels.hosts.host_energies import bound_fourths, is_impact_below
from nlds_vines.kernels.hosts.host_orbit import host_flow
from nlds_vines.kernels.hosts.host_watch import host_watch


def system_of(storeys, gap, **force):
    frame = nv.shear_frame([1000.0] * storeys, [8e5] * storeys, ratio=0.005)
    walls = [nv.Wall(gap, K=3e8), nv.Wall(gap, "-", K=3e8)]
    cell = nv.Damper("cell", "roof", m=60.0, k=300.0, c=40.0, walls=walls)
    return nv.System.from_host(frame, [cell], omega=4.0, **force)


FORCES = [{"force": {"roof": 900.0}}, {"base": {"acceleration": 0.3}}]


def prepared(system):
    """Return (orbits, host, energies) of a system."""
    orbits = HostOrbits(system)
    flow, _ = host_flow(orbits.body, orbits.walls, orbits.contacts(), orbits.room_for(0, False), 1)
    host = flow.host
    records = orbits.records(True, ())
    return orbits, host, host_watch(host.body, host.grid, host.walls, records).alone


def energies_of(energies, modes, states):
    """Return E1 and E2 (states, 2)."""
    size = states.shape[1] // 2
    parts = 0.5 * (
        energies.masses * states[:, size:] ** 2 + energies.springs * states[:, :size] ** 2
    )
    return np.stack([parts[:, :modes].sum(axis=1), parts[:, modes:].sum(axis=1)], axis=1)


@pytest.mark.parametrize(("force", "side"), [(FORCES[0], "after"), (FORCES[1], "before")])
def test_fourth_derivatives_stay_within_their_bounds(force, side):
    """Along an exact motion, over a coarse cell after a state or before it."""
    orbits, host, energies = prepared(system_of(4, 0.03, **force))
    body, A, size = orbits.body, matrix_of(orbits.body), orbits.body.size
    y = orbits.start(np.random.default_rng(1).normal(size=10) * np.tile([0.01, 0.2], 5))
    columns = np.concatenate([y, [0.8, -0.6], np.zeros(4)])
    bound_fourths(body, energies, getattr(energies, side), columns)
    coarse = host.grid.h * 2**host.grid.levels
    largest = np.zeros(2)
    for share in np.linspace(0, 1, 41) * (1.0 if side == "after" else -1.0):
        jet = [scipy.linalg.expm(A * (share * coarse)) @ columns[: len(A)]]
        for _ in range(4):
            jet.append(A @ jet[-1])
        X, V = np.array([z[:size] for z in jet]), np.array([z[size : 2 * size] for z in jet])
        fourth = energies.masses * (V[0] * V[4] + 4 * V[1] * V[3] + 3 * V[2] ** 2)
        fourth += energies.springs * (X[0] * X[4] + 4 * X[1] * X[3] + 3 * X[2] ** 2)
        values = np.abs([fourth[: body.modes].sum(), fourth[body.modes :].sum()])
        largest = np.maximum(largest, values)
    assert np.all(largest <= energies.fourths)
    assert energies.fourths[0] < 20.0 * largest[0]


@pytest.mark.parametrize("force", FORCES)
def test_pieces_that_are_skipped_hold_no_largest_energy(force, monkeypatch):
    """Beside records for which each piece is halved often, and beside samples."""
    start = np.random.default_rng(1).normal(size=4) * np.tile([0.01, 0.2], 2)
    system = system_of(1, 0.004, **force)
    orbit = nv.simulate(system, 1, start=start, record=["section", "energy"], quiet=True)
    largest = np.array([orbit.E1max, *orbit.E2max])
    points = nv.simulate(
        system, 1, start=start, record=["trajectory"], samples=400, quiet=True
    ).trajectory
    inner = np.array([HostOrbits(system).start(state) for state in points])
    sampled = energies_of(prepared(system)[2], 1, inner).max(axis=0)
    assert np.all(sampled <= largest * (1 + 1e-9))
    assert largest == pytest.approx(sampled, rel=0.05)

    monkeypatch.setattr(host_energies, "HALVINGS", 2)
    settle = host_energies.settle_piece

    def settle_short(host, energies, begun, length, is_real):
        is_settled = settle(host, energies, begun, length, is_real)
        return is_settled and length <= 0.3

    monkeypatch.setattr(host_energies, "settle_piece", settle_short)
    monkeypatch.setattr(host_orbit, "note_energies", host_energies.note_energies)
    halved = nv.simulate(system, 1, start=start, record=["section", "energy"], quiet=True)
    assert [halved.E1max, *halved.E2max] == pytest.approx(largest, rel=1e-12)
    assert np.array_equal(orbit.section, halved.section)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("K", "slack"), [(3e7, 20.0), (3e8, 2.0)])
def test_an_energy_in_a_short_impact_is_below_what_the_flights_beside_it_prove(seed, K, slack):
    """Beside DOP853: records above the proof's bound are kept, and those below a sample are not."""
    system = system_of(1, 0.004, force={"roof": 900.0})
    orbits, host, energies = prepared(system)
    body, grid, A = orbits.body, host.grid, matrix_of(orbits.body)
    size, N = body.size, 2 * body.size
    row, answer = body.rows[:size], body.answers[:size]
    state = orbits.start(np.random.default_rng(seed).normal(size=4) * np.tile([0.002, 0.1], 2))
    r, s = row @ state[:size], row @ state[size:]
    state[size - 1] += (r - 0.004) / row[size - 1] * -1.0
    state[N - 1] += (s - 0.3) / row[size - 1] * -1.0
    touch = 3, 0.25
    turn = 2.0 * math.pi * (touch[0] + touch[1]) / grid.cells
    begin = np.array([*state, math.cos(turn), math.sin(turn), 0.0])

    def rates(t, y):
        z = max(row @ y[:size] - 0.004, 0.0)
        force = K * z * math.sqrt(z)
        out = A @ y[:-1]
        out[size:N] -= answer * force
        return np.append(out, force)

    def gap(t, y):
        return row @ y[:size] - 0.004 if t > 0 else 1.0

    gap.terminal, gap.direction = True, -1.0
    exact = solve_ivp(rates, (0, 0.4), begin, "DOP853", rtol=1e-12, atol=1e-14, events=gap,
                      dense_output=True)  # fmt: skip
    took = exact.t[-1]
    states = exact.sol(np.linspace(0, took, 400)).T
    sampled = energies_of(energies, body.modes, states[:, :N])
    host.scratch.touch[:] = state
    host.scratch.begin[:] = states[-1, :N]
    at = touch[0] + touch[1] + took / grid.h
    ends = touch, (int(at), at - int(at))
    impulse = states[-1, -1] * orbits.walls.inverse[0]
    largest = sampled.max(axis=0)
    energies.peaks[:] = slack * largest
    assert is_impact_below(host, energies, 0, impulse, took, ends)
    inside = sampled[1:-1].max(axis=0)
    for q in range(2):
        if inside[q] > max(sampled[0, q], sampled[-1, q]):
            energies.peaks[:] = slack * largest
            energies.peaks[q] = 0.5 * (inside[q] + max(sampled[0, q], sampled[-1, q]))
            assert not is_impact_below(host, energies, 0, impulse, took, ends)
