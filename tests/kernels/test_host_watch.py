"""Energies and responses of hosts: one damper's kernels, closed forms, samples, the balance."""

import math

import numpy as np
import pytest
import scipy.linalg
from scipy.integrate import solve_ivp

import nlds_vines as nv
from tests.kernels.test_hosts import KINDS, RECORD, as_host, matrices_of, random_system, rest_of

pytestmark = pytest.mark.kernels


@pytest.mark.parametrize(("name", "changes"), KINDS)
def test_a_host_of_one_degree_of_freedom_has_the_energies_of_one_damper(name, changes):
    """With impacts and held walls; without a transient, which is not recorded."""
    system, options = nv.load_system(name, **changes), {"tolerance": 1e-12, "quiet": True}
    exact = nv.simulate(system, 3, transient=4, record=RECORD, **options)
    host, options["start"] = as_host(system), rest_of(system)
    orbit = nv.simulate(host, 3, transient=4, record=RECORD, of=["x"], **options)
    plain = nv.simulate(host, 3, transient=4, **options)
    alone = nv.simulate(host, 3, transient=4, record=["section", "energy"], **options)
    for one in (orbit, alone):
        assert np.array_equal(one.section, plain.section)  # to the last bit
    assert alone.E1max == pytest.approx(exact.E1max, rel=1e-11)
    assert alone.E2max[0] == pytest.approx(exact.E2max or 0.0, rel=1e-11)
    assert orbit.E1max == pytest.approx(exact.E1max, rel=1e-11)
    assert orbit.E2max[0] == pytest.approx(exact.E2max or 0.0, rel=1e-11)
    values = orbit.response
    assert values["x.x_max"] == pytest.approx(exact.response["x1_max"], rel=1e-11)
    assert values["x.x_rms"] == pytest.approx(exact.response["x1_rms"], rel=1e-11)
    if system.law != "restitution":  # whose impacts have infinite accelerations
        assert values["x.a_max"] == pytest.approx(exact.response["a1_max"], rel=1e-11)


@pytest.mark.parametrize("base", [False, True])
def test_a_linear_host_responds_as_its_frequency_response(base):
    """Twelve storeys, the highest of which move 25 times as fast as the lowest, and a damper."""
    frame, omega, n = nv.shear_frame([1e4] * 12, [8e6] * 12, ratio=0.05), 5.0, 12
    cell = nv.Damper("cell", "roof", m=3e3, k=3e3 * 9.0, c=4e3)
    forces = {"base": {"acceleration": 0.4}} if base else {"force": {"roof": 7e3, "floor3": -2e3}}
    system = nv.System.from_host(frame, [cell], omega=omega, **forces)
    names = ["roof", "roof-floor11", "floor3", "cell", "cell-roof"]
    orbit = nv.simulate(
        system, 3, transient=150, record=["energy", "response"], of=names, quiet=True
    )
    M, C, K, force, _ = matrices_of(system)
    ground = 0.4 if base else 0.0
    force = force - ground * M @ np.ones(n + 1)
    X = np.linalg.solve(K - omega**2 * M + 1j * omega * C, force)
    places = dict(zip([*frame.dofs, "cell"], range(n + 1), strict=True))
    for name in names:
        one, _, other = name.partition("-")
        x = X[places[one]] - (X[places[other]] if other else 0.0)
        a = -(omega**2) * x + (0.0 if other else ground)
        values = orbit.response
        assert values[f"{name}.x_max"] == pytest.approx(abs(x), rel=1e-10)
        assert values[f"{name}.x_rms"] == pytest.approx(abs(x) / math.sqrt(2), rel=1e-10)
        assert values[f"{name}.a_max"] == pytest.approx(abs(a), rel=1e-10)
        if base:
            above = x - (0.0 if other else ground / omega**2)
            assert values[f"{name}.x_abs_max"] == pytest.approx(abs(above), rel=1e-10)
            assert values[f"{name}.x_abs_rms"] == pytest.approx(
                abs(above) / math.sqrt(2), rel=1e-10
            )
        assert (f"{name}.x_abs_max" in values) == base

    def largest(mass, stiffness, part):
        """Return the largest energy of an amplitude: a constant and a part of twice omega."""
        kinetic, elastic = omega**2 * part @ mass @ part, part @ stiffness @ part
        mean = omega**2 * (part.conj() @ mass @ part).real + (part.conj() @ stiffness @ part).real
        return 0.25 * (mean + abs(elastic - kinetic))

    host = frame
    assert orbit.E1max == pytest.approx(largest(host.M, host.K, X[:n]), rel=1e-10)
    own = largest(np.diag([cell.m]), np.diag([cell.k]), X[n:])
    assert orbit.E2max == pytest.approx([own], rel=1e-10)


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 5, 8])
def test_largest_values_are_those_of_many_samples(seed):
    """They lie above all samples, by no more than a peak between samples can."""
    system = random_system(seed)
    names = [*system.host.dofs[-2:], *[d.name for d in system.dampers if d.m][:1]]
    options = {"transient": 5, "tolerance": 1e-12, "quiet": True}
    record = [*RECORD, "trajectory"]
    orbit = nv.simulate(system, 2, record=record, of=names, samples=4096, **options)
    M, C, K, force, _ = matrices_of(system)
    n, x, v = len(system.host.dofs), orbit.trajectory[:, ::2], orbit.trajectory[:, 1::2]

    def between(samples, largest, slack=1e-12):
        """Check a largest value; a peak between samples exceeds them by 1/8 of second differences,
        or at a corner by the larger of two first ones."""
        top = np.abs(samples).max()
        step = np.abs(np.diff(samples)).max()
        assert top * (1 - slack) <= largest <= top + step, (top, largest, step)
        assert largest == pytest.approx(top, rel=3e-3)

    host = system.host
    own = 0.5 * (np.einsum("ti,ij,tj->t", v[:, :n], host.M, v[:, :n])
                 + np.einsum("ti,ij,tj->t", x[:, :n], host.K, x[:, :n]))  # fmt: skip
    between(own, orbit.E1max)
    alone = nv.simulate(system, 2, record=["energy"], **options)  # in other cells
    assert alone.E1max == pytest.approx(orbit.E1max, rel=1e-10)
    assert alone.E2max == pytest.approx(orbit.E2max, rel=1e-10)
    place = n
    for damper, largest in zip(system.dampers, orbit.E2max, strict=True):
        if damper.m is None:
            assert largest == 0.0
            continue
        between(0.5 * (damper.m * v[:, place] ** 2 + damper.k * x[:, place] ** 2), largest)
        place += 1
    for name in dict.fromkeys(names):
        row = x[:, list(system.scene.components).index(name) // 2]
        between(row, orbit.response[f"{name}.x_max"])
        rms = math.sqrt(np.mean(row**2))
        assert orbit.response[f"{name}.x_rms"] == pytest.approx(rms, rel=2e-4)
    # a flight's accelerations follow from its states
    free = -(x @ K + v @ C) + np.cos(system.omega * orbit.time)[:, None] * force
    free = np.abs(np.linalg.solve(M, free.T))
    away = np.ones(len(x), bool)
    for touch, release in zip(orbit.impacts["touch"], orbit.impacts["release"], strict=True):
        end = math.inf if math.isnan(release) else release
        away &= (orbit.time < touch) | (orbit.time > end)
    away &= orbit.time > (orbit.impacts["release"][:1] if len(orbit.impacts) else 0.0)
    for name in dict.fromkeys(names):
        place = list(system.scene.components).index(name) // 2
        assert orbit.response[f"{name}.a_max"] >= free[place, away].max() * (1 - 1e-9)


def test_forces_do_the_work_that_energies_gain_and_dashpots_take():
    """In flights by exponentials at Gauss points; in contacts by DOP853, from samples before."""
    frame = nv.shear_frame([1000.0, 800.0, 900.0], [8e4, 6e4, 9e4], ratio=0.03)
    walls = {side: nv.Wall(0.03, side, K=3e6) for side in "+-"}
    dampers = [
        nv.Damper("a", "roof", m=60.0, k=300.0, c=40.0, walls=list(walls.values())),
        nv.Damper("b", "floor2", m=40.0, walls=[nv.Wall(0.02, law="power", K=2e5, exponent=1.25)]),
    ]
    system = nv.System.from_host(frame, dampers, force={"roof": 900.0}, omega=4.0)
    samples, periods = 256, 3
    orbit = nv.simulate(
        system, periods, transient=5, samples=samples, record=["trajectory", "impacts"],
        tolerance=1e-13, quiet=True,
    )  # fmt: skip
    M, C, K, force, rows = matrices_of(system)
    size, inverse, omega = len(M), np.linalg.inv(M), system.omega
    sides = [
        (sign * row, wall)
        for row, damper in zip(rows, dampers, strict=True)
        for wall in damper.walls
        for sign in ((1 if wall.side == "+" else -1),)
    ]

    def energy(y):
        total = 0.5 * (y[size:] @ M @ y[size:] + y[:size] @ K @ y[:size])
        for row, wall in sides:
            p = wall.constants.get("exponent", 1.5)
            total += wall.constants["K"] * max(row @ y[:size] - wall.gap, 0.0) ** (p + 1) / (p + 1)
        return total

    def rates(t, y):
        """Return the rates of (X, V, the work of the force less what dashpots take)."""
        total = force * math.cos(omega * t) - K @ y[:size] - C @ y[size : 2 * size]
        for row, wall in sides:
            z = max(row @ y[:size] - wall.gap, 0.0)
            total = total - row * wall.constants["K"] * z ** wall.constants.get("exponent", 1.5)
        v = y[size : 2 * size]
        gain = force @ v * math.cos(omega * t) - v @ C @ v
        return np.concatenate([v, inverse @ total, [gain]])

    A = np.zeros((2 * size + 2, 2 * size + 2))
    A[:size, size : 2 * size] = np.eye(size)
    A[size : 2 * size, :size], A[size : 2 * size, size : 2 * size] = -inverse @ K, -inverse @ C
    A[size : 2 * size, 2 * size] = inverse @ force
    A[2 * size, 2 * size + 1], A[2 * size + 1, 2 * size] = -omega, omega
    nodes, weights = np.polynomial.legendre.leggauss(8)
    h = system.period / samples
    flights = [scipy.linalg.expm(A * 0.5 * h * (1 + node)) for node in nodes]

    states = np.concatenate([orbit.trajectory[:, ::2], orbit.trajectory[:, 1::2]], axis=1)
    gain, size_of_gain, contacts, touches = 0.0, 0.0, 0, orbit.impacts["touch"]
    for k in range(len(states) - 1):
        t0, t1 = orbit.time[k], orbit.time[k + 1]
        is_deep = any((row @ states[k, :size]) > wall.gap for row, wall in sides)
        if is_deep or np.any((touches >= t0) & (touches < t1)):
            contacts += 1
            start = np.append(states[k], 0.0)
            piece = solve_ivp(rates, (t0, t1), start, "DOP853", rtol=1e-13, atol=1e-16,
                              max_step=h / 8)  # fmt: skip
            part = piece.y[-1, -1]
        else:
            begin = np.append(states[k], [math.cos(omega * t0), math.sin(omega * t0)])
            part = 0.0
            for flight, weight in zip(flights, weights, strict=True):
                y = flight @ begin
                v = y[size : 2 * size]
                part += 0.5 * h * weight * (force @ v * y[2 * size] - v @ C @ v)
        gain += part
        size_of_gain += abs(part)
    assert contacts > 20
    assert energy(states[-1]) - energy(states[0]) == pytest.approx(gain, abs=1e-11 * size_of_gain)


def test_what_is_not_there_is_refused(error_of):
    frame = nv.shear_frame([1.0, 1.0], [4.0, 4.0], ratio=0.1)
    cell = nv.Damper("cell-1", "roof", m=0.1, k=0.1)
    system = nv.System.from_host(frame, [cell], force={"roof": 1.0}, omega=1.0)
    assert system.displacement("roof-cell-1")[0].tolist() == [0.0, 1.0, -1.0]
    for options, message in (
        ({"record": ["energy"], "of": ["roof"]}, "of = ['roof']: the response is not recorded"),
        ({"record": ["response"], "of": ["attic"]}, "unknown displacement 'attic'"),
        ({"record": ["response"], "of": ["roof-attic"]}, "unknown displacement 'roof-attic'"),
        ({"record": ["clearance"]}, "unknown record 'clearance'"),
        ({"method": "rk4"}, "unknown method 'rk4'"),
        ({"nodes": 3}, "unknown option for a host with dampers: 'nodes'; allowed: tolerance"),
        ({"start": [1, 2]}, "allowed: 6 finite numbers floor1, v_floor1"),
    ):
        assert message in error_of(nv.simulate, system, 1, **options)
    line = error_of(nv.simulate, "ssul-set6", 1, of=["x1"])
    assert "names no displacements" in line


def test_a_rigid_wall_makes_accelerations_infinite_where_its_impulse_acts():
    """A blow between the ball and the roof, two free masses for its instant, moves no other floor.

    It turns the approach speed v into -e v by the impulse (1 + e) v / (1 / m + 1 / M).
    """
    frame, e = nv.shear_frame([1000.0, 800.0, 900.0], [8e4, 6e4, 9e4], ratio=0.03), 0.6
    walls = [nv.Wall(0.01, side, law="restitution", e=e) for side in "+-"]
    ball = nv.Damper("ball", "roof", m=60.0, walls=walls)
    soft = nv.Damper("soft", "floor1", m=60.0, k=3000.0, walls=[nv.Wall(0.01, K=1e7)])
    force, omega = {"roof": 800.0}, frame.frequencies[0]
    system = nv.System.from_host(frame, [ball, soft], force=force, omega=omega)
    free = ["floor2", "floor1", "floor2-floor1", "soft"]
    names = ["roof", "ball", "roof-floor2", *free]
    options = {"record": ["impacts", "response"], "of": names, "quiet": True}
    orbit = nv.simulate(system, 5, transient=20, **options)
    for name in ("roof", "ball", "roof-floor2"):
        assert orbit.response[f"{name}.a_max"] == math.inf
    for name in free:
        assert 0.0 < orbit.response[f"{name}.a_max"] < 100.0
    fastest = orbit.impacts["speed"][orbit.impacts["damper"] == "ball"].max()
    impulse = (1.0 + e) * fastest / (1.0 / 60.0 + 1.0 / 900.0)
    assert orbit.response["ball.impulse_max"] == pytest.approx(impulse, rel=1e-12)
    assert "soft.impulse_max" not in orbit.response  # its wall has a force
    is_rigid = orbit.impacts["damper"] == "ball"
    rigid = orbit.impacts[is_rigid]
    returned = np.where(rigid["release"] == rigid["touch"], e, 0.0)  # of others the ball stays
    impulses = (1.0 + returned) * rigid["speed"] / (1.0 / 60.0 + 1.0 / 900.0)
    np.testing.assert_allclose(rigid["impulse"], impulses, rtol=1e-10)
    assert (orbit.impacts["impulse"][~is_rigid] == 0.0).all()
    assert 0 < np.count_nonzero(is_rigid) < len(is_rigid)

    load = {"impulse": 500.0, "on": "roof"}
    histories = nv.response_history(system, load=load, duration=10.0, of=names, quiet=True)
    numbers = histories.results[system.name].numbers
    assert numbers["roof.a_max"] == numbers["ball.a_max"] == math.inf
    assert 0.0 < numbers["floor2.a_max"] < 100.0
    touches = histories.results[system.name].impacts
    fastest = touches["speed"][touches["damper"] == "ball"].max()
    impulse = (1.0 + e) * fastest / (1.0 / 60.0 + 1.0 / 900.0)
    assert numbers["ball.impulse_max"] == pytest.approx(impulse, rel=1e-12)
    assert touches["impulse"].max() == numbers["ball.impulse_max"]
    assert math.isnan(numbers["soft.impulse_max"])


def test_a_blow_goes_on_to_a_rigid_wall_that_holds():
    """A ball strikes a mass that a force presses against a stop, which has to take the blow.

    The mass cannot move, so that the ball turns round as at a wall, by the impulse (1 + e) m v.
    """
    host = nv.Host(M=[[4.0]], K=[[400.0]], C=[[2.0]], dofs=["x"])
    stop = nv.Damper("stop", ("x", "ground"), walls=[nv.Wall(0.0, law="restitution", e=0.0)])
    ball = nv.Damper("ball", "x", m=0.2, walls=[nv.Wall(0.01, "-", law="restitution", e=0.5)])
    system = nv.System.from_host(host, [ball, stop], force={"x": 100.0}, omega=0.5)
    orbit = nv.simulate(
        system, 1, start=[0.0, 0.0, 0.0, 4.0], record=["impacts", "response"], quiet=True
    )
    first, *others = orbit.impacts
    assert (first["damper"], first["speed"]) == ("ball", pytest.approx(4.0))
    assert {impact["damper"] for impact in others} == {"stop"}
    assert max(impact["speed"] for impact in others) < 0.2
    assert orbit.response["ball.impulse_max"] == pytest.approx(1.5 * 0.2 * 4.0, rel=1e-12)
    assert orbit.response["stop.impulse_max"] == pytest.approx(1.5 * 0.2 * 4.0, rel=1e-12)
    assert first["impulse"] == orbit.response["ball.impulse_max"]
