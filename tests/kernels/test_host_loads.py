"""Hosts under loads in time: against exponentials, SciPy, harmonic orbits and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
from scipy.integrate import solve_ivp

import nlds_vines as nv
from nlds_vines.engine.host_loads import (
    cells_of,
    energies_at,
    follow_load,
    last_times,
    longest_cell,
)
from nlds_vines.engine.host_orbits import HostOrbits
from nlds_vines.model.loads.courses import Rectangular, Tone
from nlds_vines.model.loads.loading import Blow, Loading
from nlds_vines.model.loads.record import Record
from tests.kernels.test_hosts import matrices_of, random_system

pytestmark = pytest.mark.kernels


def orbit_under(system, load, duration, *, marks=(), start=None, tolerance=1e-12):
    on = system.under(load)
    orbits = HostOrbits(on, tolerance)
    cells = cells_of(load, duration, longest_cell(system, duration), np.array(marks))
    orbit = follow_load(orbits, cells, orbits.start(start))
    assert orbit.status == 0
    return orbit, cells[0]


def elastic_system(seed):
    """Return a random host whose walls all have Hertz' law."""
    system = random_system(seed)
    dampers = tuple(
        replace(damper, walls=[nv.Wall(wall.gap, wall.side, K=1e7) for wall in damper.walls])
        for damper in system.dampers
    )
    return replace(system, dampers=dampers)


def random_record(rng, step, count, **options):
    values = np.append(np.cumsum(rng.normal(size=count - 1)), 0.0)
    return Record(times=tuple(step * np.arange(count)), values=tuple(values), **options)


@pytest.mark.parametrize("unit", ["N", "m/s^2"])
def test_a_linear_host_moves_under_a_record_as_by_the_exponential_of_each_step(unit):
    """With coupled modes, a pause after the record, and for forces two blows."""
    rng = np.random.default_rng(3)
    chain = nv.chain([1.0, 2.0, 2.0, 1.0], [4.0, 3.0, 5.0, 3.0], dofs=["a", "b", "c", "d"])
    host = nv.Host(chain.M, chain.K, 0.1 * np.diag([1.0, 0.0, 0.0, 2.0]), dofs=chain.dofs)
    damper = nv.Damper("u", "b", m=0.5, k=0.7, c=0.2)
    system = nv.System.from_host(host, [damper], force={"a": 0.0}, omega=1.3)
    record = random_record(rng, 0.25, 30, unit=unit, at=0.5)
    blows = () if unit != "N" else (Blow(impulse=2.0, at=1.5), Blow(impulse=-1.0, at=9.1))
    on = {"on": {"a": 1.0, "c": -0.5}} if blows else {}
    load = Loading(record=(record,), blow=blows, **on)
    orbit, cells = orbit_under(system, load, 12.0)
    M, C, K, _, _ = matrices_of(system)
    A = np.block([[np.zeros((5, 5)), np.eye(5)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    push = np.linalg.solve(M, [1.0, 0.0, -0.5, 0.0, 0.0]) if blows else -np.ones(5)
    times, values = 0.5 + np.array(record.times), np.array(record.values)
    full = np.zeros((12, 12))
    full[:10, :10], full[5:10, 10], full[10, 11] = A, push, 1.0
    y = np.zeros(10)
    for i, (begin, end) in enumerate(zip(cells.edges[:-1], cells.edges[1:], strict=True)):
        y[5:] += sum(b.impulse for b in blows if abs(b.at - begin) < 1e-12) * push
        now = np.concatenate([orbit.states[i, ::2], orbit.states[i, 1::2]])
        assert now == pytest.approx(y, abs=1e-12)
        middle = 0.5 * (begin + end)
        inside = times[0] < middle < times[-1]
        f0, f1 = np.interp([begin, end], times, values) if inside else (0.0, 0.0)
        assert orbit.accelerations[i] == pytest.approx(A[5:] @ y + push * f0, abs=1e-11)
        step = end - begin
        y = (scipy.linalg.expm(full * step) @ np.concatenate([y, [f0, (f1 - f0) / step]]))[:10]
    assert orbit.edges[-1] == 12.0
    assert np.abs(y).max() > 0.1


@pytest.mark.parametrize("seed", [1, 2, 3, 5])
def test_random_hosts_with_walls_move_under_a_record_as_by_scipy(seed):
    system = elastic_system(seed)
    M, C, K, force, rows = matrices_of(system)
    duration, rng = 3 * system.period, np.random.default_rng(seed)
    record = random_record(rng, duration / 40, 36)
    record = replace(
        record, values=tuple(2 * np.array(record.values) / np.abs(record.values).max())
    )
    orbit, cells = orbit_under(system, Loading(record=(record,), on=dict(system.force)), duration)
    walls = [
        ((1 if wall.side == "+" else -1) * row, wall)
        for row, damper in zip(rows, system.dampers, strict=True)
        for wall in damper.walls
    ]
    size, inverse = len(M), np.linalg.inv(M)

    def rates(t, y):
        total = force * np.interp(t, record.times, record.values, right=0.0)
        total = total - K @ y[:size] - C @ y[size:]
        for row, wall in walls:
            z = max(row @ y[:size] - wall.gap, 0.0)
            total -= row * wall.constants["K"] * z**1.5
        return np.concatenate([y[size:], inverse @ total])

    y, depth = np.zeros(2 * size), 0.0
    for begin, end in zip(cells.edges[:-1], cells.edges[1:], strict=True):
        piece = solve_ivp(rates, (begin, end), y, "DOP853", rtol=1e-11, atol=1e-14)
        y = piece.y[:, -1]
        depth = max([depth, *(np.max(row @ piece.y[:size] - wall.gap) for row, wall in walls)])
    last = np.concatenate([orbit.states[-1, ::2], orbit.states[-1, 1::2]])
    assert last == pytest.approx(y, abs=1e-6 * np.abs(y).max())
    assert (len(orbit.impacts) > 0) == (depth > 1e-9)
    if len(orbit.impacts):
        assert orbit.impacts["depth"].max() == pytest.approx(depth, rel=0.1)


def test_a_tone_is_the_harmonic_force_of_a_system():
    """Its cells have polynomials of a degree of about ten; a frame's high modes halve them."""
    frame = nv.shear_frame([1e4] * 6, [8e6] * 6, ratio=0.02)
    walls = [nv.Wall(0.01, side, K=1e8) for side in "+-"]
    system = nv.System.from_host(
        frame, [nv.Damper("a", "roof", m=900.0, k=100.0, walls=walls)],
        force={"roof": 2500.0}, omega=float(frame.frequencies[0]),
    )  # fmt: skip
    harmonic = nv.simulate(system, 8, tolerance=1e-12, quiet=True)
    load = Loading(tone=(Tone(amplitude=2500.0, omega=system.omega),), on="roof")
    marks = system.period * np.arange(1, 8)
    orbit, cells = orbit_under(system, load, 8 * system.period, marks=marks)
    places = np.searchsorted(orbit.edges, np.append(marks, cells.edges[-1]) * (1 - 1e-14))
    assert np.abs(cells.rows[:, 5]).max() > 0
    assert orbit.states[places] == pytest.approx(harmonic.section, rel=1e-8, abs=1e-10)
    assert len(orbit.impacts) == len(harmonic.impacts) > 4
    for column in ("touch", "release", "speed", "force"):
        assert orbit.impacts[column] == pytest.approx(harmonic.impacts[column], rel=1e-8)


@pytest.mark.parametrize("impulse", [-3.0, 3.0])
def test_a_blow_leaves_or_strikes_a_rigid_wall_that_holds(impulse):
    """A mass of 2 kg is pressed on a wall at x = 0 by 4 N, and struck at 1 s."""
    host = nv.Host([[2.0]], [[0.0]], dofs=["x"])
    wall = nv.Wall(0.0, law="restitution", e=0.5)
    damper = nv.Damper("stop", ("x", "ground"), walls=[wall])
    system = nv.System.from_host(host, [damper], force={"x": 0.0}, omega=1.0)
    press = Rectangular(peak=4.0, length=10.0)
    load = Loading(rectangular=(press,), blow=(Blow(impulse=impulse, at=1.0),))
    orbit, _ = orbit_under(system, load, 1.5)
    speed = impulse / 2 if impulse < 0 else -0.5 * impulse / 2
    before = orbit.edges < 1.0
    assert np.all(orbit.states[before] == 0.0)
    assert np.all(orbit.accelerations[before] == 0.0)
    x, v = 0.5 * speed + 0.125 * 2.0, speed + 0.5 * 2.0
    assert orbit.states[-1] == pytest.approx([x, v], abs=1e-13)
    assert orbit.impacts["touch"].tolist() == ([] if impulse < 0 else [1.0])


def test_cells_of_other_lengths_give_the_same_orbit_and_complete_impacts():
    system = elastic_system(4)
    record = random_record(np.random.default_rng(1), 0.05, 30)
    load = Loading(record=(record,), on="roof", scale=2.0 * system.force["roof"])
    plain, _ = orbit_under(system, load, 2.0)
    marks = np.cumsum(np.random.default_rng(2).uniform(0.005, 0.05, 60))
    other, _ = orbit_under(system, load, 2.0, marks=marks[marks < 1.99])
    assert len(plain.impacts) == len(other.impacts) > 3
    for column in ("touch", "release", "speed", "force", "depth"):
        expected = pytest.approx(plain.impacts[column], rel=1e-6, abs=1e-9, nan_ok=True)
        assert other.impacts[column] == expected
    assert other.states[-1] == pytest.approx(plain.states[-1], rel=1e-6, abs=1e-9)
    assert math.isfinite(np.nanmax(plain.impacts["release"]))


SHARES = (0.01, 0.1, 0.5)


def struck(walls, **host):
    host = nv.Host([[10.0]], [[4000.0]], [[8.0]], **host)
    return nv.System.from_host(host, [nv.Damper("t", "x1", m=0.6, k=200.0, c=2.0, walls=walls)])


def last_times_of(system, tolerance, marks=()):
    blow = Loading(blow=(Blow(impulse=5.0),), on="x1")
    on = system.under(blow)
    orbits = HostOrbits(on, tolerance)
    cells = cells_of(blow, 20.0, longest_cell(system, 20.0), np.array(marks))
    orbit = follow_load(orbits, cells, orbits.start(None))
    largest = orbit.records.peaks[0]
    return last_times(orbits, cells, orbit, [share * largest for share in SHARES]), orbit


def test_last_times_of_a_linear_host_are_those_of_the_exponential():
    """Whatever the edges of the load's cells are; the last one is where E1 has another level."""
    system = struck([])
    M, C, K, _, _ = matrices_of(system)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    n = 20_001
    step = scipy.linalg.expm(A * (20.0 / (n - 1)))
    states = [np.array([0.0, 0.0, 0.5, 0.0])]
    for _ in range(n - 1):
        states.append(step @ states[-1])

    def energy(y):
        return 0.5 * (10.0 * y[2] ** 2 + 4000.0 * y[0] ** 2)

    energies = np.array([energy(y) for y in states])
    exact = []
    for share in SHARES:
        level, i = share * 1.25, np.flatnonzero(energies > share * 1.25)[-1]
        rest = scipy.optimize.brentq(
            lambda t, i=i, level=level: energy(scipy.linalg.expm(A * t) @ states[i]) - level,
            0.0,
            20.0 / (n - 1),
            xtol=1e-15,
        )
        exact.append(i * 20.0 / (n - 1) + rest)
    for marks in ((), np.linspace(0.0, 20.0, 38)[1:-1], np.linspace(0.0, 20.0, 4096)[1:-1]):
        assert last_times_of(system, 1e-10, marks)[0] == pytest.approx(exact, abs=2e-12)


@pytest.mark.parametrize("law", [{"K": 1e6}, {"law": "restitution", "e": 0.6}])
def test_last_times_of_a_host_with_walls_do_not_depend_on_the_edges(law):
    """Against an integration by SciPy between the impacts, for a Hertz wall."""
    walls = [nv.Wall(0.01, side, **law) for side in "+-"]
    system = struck(walls)
    times, orbit = last_times_of(system, 1e-12)
    assert len(orbit.impacts) > 4
    for count in (38, 700):
        marks = np.linspace(0.0, 20.0, count)[1:-1]
        assert last_times_of(system, 1e-12, marks)[0] == pytest.approx(times, abs=1e-8)
    if "K" not in law:
        return

    def rates(t, y):
        x, v, u, w = y
        r = x - u
        push = 200.0 * r + 2.0 * (v - w)
        push += 1e6 * (max(r - 0.01, 0.0) ** 1.5 - max(-r - 0.01, 0.0) ** 1.5)
        return [v, (-4000.0 * x - 8.0 * v - push) / 10.0, w, push / 0.6]

    run = solve_ivp(
        rates, (0.0, 20.0), [0.0, 0.5, 0.0, 0.0], "DOP853", rtol=1e-11, atol=1e-14,
        max_step=2e-3, dense_output=True,
    )  # fmt: skip
    fine = np.linspace(0.0, 20.0, 400_001)
    x, v, _, _ = run.sol(fine)
    energy = 5.0 * v**2 + 2000.0 * x**2
    for share, time in zip(SHARES, times, strict=True):
        last = fine[np.flatnonzero(energy > share * 1.25)[-1]]
        assert time == pytest.approx(last, abs=5.1e-5)
        x, v, _, _ = run.sol(time)
        assert 5.0 * v**2 + 2000.0 * x**2 == pytest.approx(share * 1.25, rel=1e-6)


def test_last_times_see_what_no_edge_does():
    """E1 of two masses exceeds levels between the edges only, as their cells are long.

    Without damping E1 is constant, so a force that lasts half a period of the mass makes it rise
    and fall to 0 again within one cell.
    """
    host = nv.Host([[2.0]], [[32.0]], dofs=["x"])
    system = nv.System.from_host(host)
    load = Loading(rectangular=(Rectangular(peak=8.0, length=math.pi / 2),), on="x")
    orbits = HostOrbits(system.under(load), 1e-10)
    cells = cells_of(load, 4.0, 4.0, np.zeros(0))
    orbit = follow_load(orbits, cells, orbits.start(None))
    # x = (1 - cos 4t) / 4, E1 = (16 sin(2t)^2) / 4: 4 J at pi / 4, with no energy at pi / 2
    assert len(orbit.edges) == 3
    assert np.abs(energies_at(orbits, orbit.section)[0]).max() < 1e-12
    assert orbit.records.peaks[0] == pytest.approx(4.0, rel=1e-9)
    levels = [0.04, 1.0, 3.0, 5.0]
    exact = [math.pi / 2 - math.asin(math.sqrt(level / 4)) / 2 for level in levels[:3]]
    assert last_times(orbits, cells, orbit, levels) == pytest.approx([*exact, 0.0], abs=1e-9)
