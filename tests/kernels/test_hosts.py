"""Orbits of hosts: against one damper's kernels, against SciPy, twins, held walls, round-off."""

import itertools
import math

import numpy as np
import pytest
import scipy.linalg
from scipy.integrate import solve_ivp
from support import as_host

import nlds_vines as nv
from nlds_vines.kernels.hosts.modes import fill_modes

pytestmark = pytest.mark.kernels


KINDS = [
    ("ssul-set6", {"omega": 7.39}),
    ("ssul-set6", {"omega": 1.28, "P": 3000.0}),  # pressed for long
    ("ssul-set6", {"omega": 6.28, "law": "restitution", "e": 0.7}),
    ("ssul-set6", {"omega": 2.28, "law": "restitution", "e": 0.5, "P": 3000.0}),  # held
    ("ssul-set6", {"C": -0.05, "law": "restitution", "e": 0.3}),  # begins held, rebounds, is held
]
"""Of two laws: each other one would compile a kind. SciPy follows hosts with pairs of all laws."""


RECORD = ("section", "impacts", "energy", "response")
"""Of kinds always all: each choice is compiled for itself."""


def rest_of(system):
    """Return the rest of a kind as a state of `as_host`, in which u is 0 at the relaxed spring."""
    start = nv.simulate(system, 0, record=RECORD, quiet=True).state
    start[2:3] -= system.rest or 0.0
    return start


@pytest.mark.parametrize(("name", "changes"), KINDS)
def test_a_host_of_one_degree_of_freedom_is_a_system_of_one_damper(name, changes):
    system = nv.load_system(name, **changes)
    exact = nv.simulate(system, 12, record=RECORD, tolerance=1e-12, quiet=True)
    orbit = nv.simulate(as_host(system), 12, start=rest_of(system), tolerance=1e-12, quiet=True)
    section = orbit.section[:, : exact.section.shape[1]].copy()
    if system.rest is not None:
        section[:, 2] += system.rest
    assert len(orbit.impacts) == len(exact.impacts) > 2
    scale = np.abs(exact.section).max(axis=0)
    assert np.all(np.abs(section - exact.section) < 3e-11 * scale + 1e-13)
    for column in ("touch", "speed", "depth"):
        assert orbit.impacts[column] == pytest.approx(exact.impacts[column], rel=1e-9, abs=1e-10)
    if system.law != "restitution":
        assert orbit.impacts["force"] == pytest.approx(exact.impacts["force"], rel=1e-9)
    release = orbit.impacts["release"]
    assert release == pytest.approx(exact.impacts["release"], abs=1e-10, nan_ok=True)


def matrices_of(system):
    """Return (M, C, K, force, w) of degrees of freedom and masses, assembled independently."""
    host, masses = system.host, [damper for damper in system.dampers if damper.m is not None]
    n, size = len(host.dofs), len(host.dofs) + len(masses)
    (M, C, K), force = np.zeros((3, size, size)), np.zeros(size)
    M[:n, :n], C[:n, :n], K[:n, :n] = host.M, host.C, host.K
    rows = []
    for damper in system.dampers:
        row = np.zeros(size)
        if damper.m is not None:
            row[host.dofs.index(damper.attached_to)] = 1
            i = n + masses.index(damper)
            row[i], M[i, i] = -1, damper.m
        else:
            for place, sign in zip(damper.attached_to, (1, -1), strict=True):
                if place != "ground":
                    row[host.dofs.index(place)] = sign
        K += damper.k * np.outer(row, row)
        C += damper.c * np.outer(row, row)
        rows.append(row)
    for dof, P in system.force.items():
        force[host.dofs.index(dof)] = P
    return M, C, K, force, np.array(rows)


def force_and_margin(wall, z, s):
    """Return the force of a closed wall at depth z and its rate s, and what it is switched off by.

    A force that would pull is 0 where its margin is negative.
    """
    constants = wall.constants
    if wall.law in ("linear", "kelvin-voigt"):
        force = constants["kc"] * z + constants.get("cc", 0.0) * s
        return force, force if wall.law == "linear" else 1.0
    margin = 1.0 + constants.get("hunt_crossley", 0.0) * s
    return constants.get("K", 0.0) * max(z, 0.0) ** constants.get("exponent", 1.5) * margin, margin


def complementary(D, u):
    """Return x >= 0 with u - D x <= 0, of each pair of which one is 0, by the smallest set."""
    slack = 1e-13 * np.abs(u).max(initial=0.0)
    for count in range(len(u) + 1):
        for chosen in itertools.combinations(range(len(u)), count):
            which, x = list(chosen), np.zeros(len(u))
            x[which] = np.linalg.lstsq(D[np.ix_(which, which)], u[which], rcond=1e-12)[0]
            if np.all(x >= 0) and np.all(u - D @ x <= slack):
                return x
    raise AssertionError("no solution")


AT_ONCE = 1e-15  # distance [m] within which walls are touched at one instant, as a start may be


def by_scipy(system, periods, rtol=1e-12, start=None):
    """Return the last state (X, V), and times and speeds of touches, by DOP853 between events.

    A compliant wall pushes from its touch until its depth is zero. Rigid ones take impacts by
    Poisson's law; when the rebounds of one have nearly died out it holds, until it would pull.
    """
    M, C, K, force, rows = matrices_of(system)
    size, inverse = len(M), np.linalg.inv(M)
    walls = [wall for damper in system.dampers for wall in damper.walls]
    signs = np.array([1.0 if wall.side == "+" else -1.0 for wall in walls])
    sides = np.repeat(rows, [len(damper.walls) for damper in system.dampers], axis=0)
    sides = signs[:, None] * sides
    gaps, number = np.array([wall.gap for wall in walls]), range(len(walls))
    is_rigid = [wall.law == "restitution" for wall in walls]
    closed = [False] * len(walls)  # a rigid wall: whether it holds
    pushes = [True] * len(walls)  # whether the force of a closed wall is not switched off

    def seen(i, y):
        return force_and_margin(walls[i], sides[i] @ y[:size] - gaps[i], sides[i] @ y[size:])

    def forces_without(t, y):
        x, v = y[:size], y[size:]
        total = force * math.cos(system.omega * t) - K @ x - C @ v
        for i in number:
            if closed[i] and pushes[i] and not is_rigid[i]:
                total = total - sides[i] * seen(i, y)[0]
        return total

    def rates_and_held(t, y):
        total, held = forces_without(t, y), [i for i in number if closed[i] and is_rigid[i]]
        forces = np.zeros(0)
        if held:
            W = sides[held]
            forces = np.linalg.solve(W @ inverse @ W.T, W @ inverse @ total)
            total = total - W.T @ forces
        return np.concatenate([y[size:], inverse @ total]), dict(zip(held, forces, strict=True))

    def pressing(t, y, which):
        """Return the accelerations that press bodies to walls, none of which pulls."""
        W = sides[which]
        D = W @ inverse @ W.T
        return complementary(D, W @ inverse @ forces_without(t, y)) * np.diag(D)

    def strike(t, y, which):
        """Change the velocities by an impact, and tell which walls hold after it."""
        W = sides[which]
        D, e = W @ inverse @ W.T, np.array([walls[i].constants["e"] for i in which])
        first = complementary(D, W @ y[size:])
        rest = np.concatenate([y[:size], y[size:] - inverse @ W.T @ first])
        pressed = pressing(t, rest, which)
        stays = (pressed > 0) & (e * first * np.diag(D) < 1e-7 * pressed * system.period)
        y[size:] -= inverse @ W.T @ (first * np.where(stays, 1.0, 1.0 + e))
        y[size:] -= inverse @ W.T @ complementary(D, W @ y[size:])
        departure = 1e-12 * np.abs(W).dot(np.abs(y[size:]))
        departure = np.maximum(departure, (e < 1) * 1e-7 * pressed * system.period)
        holds = (pressed > 0) & (W @ y[size:] > -departure)
        for i, is_held in zip(which, holds, strict=True):
            closed[i] = bool(is_held)
        if holds.any():  # those that are left so slowly return at once
            W = W[holds]
            y[size:] -= inverse @ W.T @ np.linalg.lstsq(W @ inverse @ W.T, W @ y[size:])[0]

    def event(function, direction):
        function.terminal, function.direction = True, direction
        return function

    def events():
        """Return the events of touches and releases, then those of forces that are switched."""
        for i in number:
            if closed[i] and is_rigid[i]:
                yield event(lambda t, y, i=i: rates_and_held(t, y)[1][i], -1.0)
            else:
                distance = lambda t, y, i=i: sides[i] @ y[:size] - gaps[i]  # noqa: E731
                yield event(distance, -1.0 if closed[i] else 1.0)
        for i in number:
            direction = -1.0 if pushes[i] else 1.0
            yield event(lambda t, y, i=i: seen(i, y)[1] if closed[i] else 1.0, direction)

    y = np.zeros(2 * size) if start is None else np.concatenate([start[::2], start[1::2]])
    t, touches, end, stop = 0.0, [], periods * system.period, math.inf
    events_left = 20000
    resting = [i for i in number if is_rigid[i] and sides[i] @ y[:size] == gaps[i]]
    resting = [i for i in resting if sides[i] @ y[size:] == 0]
    if resting:
        for i, a in zip(resting, pressing(t, y, resting), strict=True):
            closed[i] = bool(a > 0)
    while t < end:
        piece = solve_ivp(
            lambda t, y: rates_and_held(t, y)[0], (t, min(end, stop)), y, "DOP853", rtol=rtol,
            atol=1e-15, events=list(events()), max_step=0.02 * system.period,
        )  # fmt: skip
        t, y, stop = piece.t[-1], piece.y[:, -1], math.inf
        if piece.status != 1:
            continue
        events_left -= 1
        assert events_left > 0, "SciPy goes astray"
        met = next(i for i, times in enumerate(piece.t_events) if len(times))
        if met >= len(walls):
            pushes[met - len(walls)] ^= True
            continue
        speed, is_touch = sides[met] @ y[size:], not closed[met]
        if is_touch:
            touches.append((t, speed))
        if is_rigid[met] and is_touch:
            others = [i for i in number if is_rigid[i] and i != met]
            places = {i: abs(sides[i] @ y[:size] - gaps[i]) for i in others}
            at_once = [i for i in others if not closed[i] and places[i] < AT_ONCE]
            touches += [(t, v) for v in sides[at_once] @ y[size:] if v > 0]
            strike(t, y, [met, *(i for i in others if closed[i]), *at_once])
        else:
            closed[met], pushes[met] = not closed[met], True
        held = [i for i in number if closed[i] and is_rigid[i]]
        if held and not (is_rigid[met] and is_touch):  # a force that jumps may free walls
            for i, a in zip(held, pressing(t, y, held), strict=True):
                closed[i] = bool(a > 0)
        for i in number:
            distance = abs(sides[i] @ y[:size] - gaps[i])
            if not closed[i] and distance < 1e-9 * np.abs(y[:size]).max():
                speed, outward = sides[i] @ y[size:], sides[i] @ rates_and_held(t, y)[0][size:]
                if speed < 0 < outward:
                    stop = min(stop, t - 0.5 * speed / outward)  # no step crosses the whole flight
    return y, np.array(touches).reshape(-1, 2).T


def other_law(rng, mass):
    """Return a law that dissipates and its constants, or None in two of six cases."""
    K, kc = float(10 ** rng.uniform(5.5, 7)), float(10 ** rng.uniform(4.5, 6))
    cc = float(rng.uniform(0.05, 0.5) * math.sqrt(kc * mass))
    return [
        {"law": "restitution", "e": float(rng.uniform(0.2, 0.95))},
        {"law": "linear", "kc": kc, "cc": cc},
        {"law": "kelvin-voigt", "kc": kc, "cc": cc},
        {"law": "power", "K": K, "exponent": 1.5, "hunt_crossley": float(rng.uniform(0.1, 2))},
        None,
        None,
    ][rng.integers(6)]


def random_system(seed):
    """Return a host of 1 to 12 degrees of freedom with 1 to 4 dampers on it."""
    rng, laws = np.random.default_rng(seed), np.random.default_rng([seed, 1])
    n, m = int(rng.integers(1, 13)), int(rng.integers(1, 5))
    masses, springs = rng.uniform(500, 1500, n), rng.uniform(0.5, 1.5, n) * 4e4 * n
    frame = nv.shear_frame(masses, springs, ratio=float(rng.uniform(0, 0.05)))
    if rng.random() < 0.4:  # damping that couples modes
        C = 1e-3 * frame.K + np.diag(rng.uniform(0, 40, n))
        frame = nv.Host(frame.M, frame.K, C, dofs=frame.dofs)
    first = frame.frequencies[0]
    omega = float(first * rng.uniform(0.7, 1.6))
    P = float(rng.uniform(0.5, 2)) * 0.02 * springs.min() / n
    response = np.abs(frame.frequency_response(omega, force={"roof": P})).max()
    reach = min(response, 20 * P / springs.min() * n)
    dampers = []
    for j in range(m):
        mass = float(rng.uniform(0.01, 0.08) * masses.sum()) / m
        k = float(mass * (first * rng.uniform(0, 1.1)) ** 2)
        law = {"law": "hertz", "K": 10 ** rng.uniform(6, 8)}
        if rng.random() < 0.4:
            exponent = float(rng.choice([1.0, 1.25, 2.0]))
            law = {"law": "power", "K": 10 ** rng.uniform(5, 6.5), "exponent": exponent}
        sides = "+-" if rng.random() < 0.5 else "+"
        walls = [
            nv.Wall(float(reach * rng.uniform(0.3, 1.2)), side, **(other_law(laws, mass) or law))
            for side in sides
        ]
        dof = frame.dofs[int(rng.integers(0, n))]
        if rng.random() < 0.2:
            dampers.append(nv.Damper(f"d{j}", (dof, "ground"), walls=walls))
        else:
            c = float(0.04 * math.sqrt(mass * max(k, 0.01 * mass * first**2)))
            dampers.append(nv.Damper(f"d{j}", dof, m=mass, k=k, c=c, walls=walls))
    return nv.System.from_host(frame, dampers, force={"roof": P}, omega=omega)


@pytest.mark.parametrize("seeds", [range(4), pytest.param(range(4, 200), marks=pytest.mark.long)])
def test_random_hosts_move_as_by_scipy(seeds):
    touched = 0
    for seed in seeds:
        system = random_system(seed)
        orbit = nv.simulate(system, 4, tolerance=1e-12, quiet=True)
        other = nv.simulate(system, 4, tolerance=1e-9, quiet=True)
        state, (touches, speeds) = by_scipy(system, 4)
        coarse, _ = by_scipy(system, 4, rtol=1e-11)
        # the last rebounds before a wall holds are counted by neither
        least = 1e-4 * speeds.max(initial=0.0)
        times = np.sort(orbit.impacts["touch"][orbit.impacts["speed"] > least])
        touches = touches[speeds > least]
        assert len(times) == len(touches), seed
        touched += len(touches)
        # impacts multiply errors; what two tolerances of each program differ by tells how much
        scale = np.abs(state).max()
        spread = 100 * np.abs(orbit.state - other.state).max() + 3 * np.abs(coarse - state).max()
        spread = 5e-9 + spread / scale
        found = np.concatenate([orbit.state[::2], orbit.state[1::2]])
        assert np.abs(found - state).max() < spread * scale, (seed, spread)
        assert times == pytest.approx(touches, abs=spread), seed
    assert touched > 20


@pytest.mark.parametrize(
    "law",
    [{"K": 1e7}, {"law": "restitution", "e": 0.6}, {"law": "restitution", "e": 0.0},
     {"law": "linear", "kc": 1e6, "cc": 500.0}],
)  # fmt: skip
def test_equal_twins_are_one_damper_of_twice_the_mass(law):
    """Two walls are touched at one instant, and rigid ones hold both masses at once."""
    frame = nv.shear_frame([1000.0, 800.0], [8e4, 6e4], ratio=0.02)
    double = {
        name: 2 * value if name in ("K", "kc", "cc") else value for name, value in law.items()
    }
    one = nv.Damper("one", "roof", m=60.0, k=300.0, c=40.0, walls=[nv.Wall(0.03, **double)])
    twins = [
        nv.Damper(name, "roof", m=30.0, k=150.0, c=20.0, walls=[nv.Wall(0.03, **law)])
        for name in ("a", "b")
    ]
    force = {"force": {"roof": 900.0}, "omega": 4.0}
    single = nv.simulate(nv.System.from_host(frame, [one], **force), 6, tolerance=1e-12, quiet=True)
    pair = nv.simulate(nv.System.from_host(frame, twins, **force), 6, tolerance=1e-12, quiet=True)
    assert len(pair.impacts) == 2 * len(single.impacts) > 6
    assert pair.section[:, :6] == pytest.approx(single.section, rel=1e-7, abs=1e-9)
    assert pair.section[:, 4:6] == pytest.approx(pair.section[:, 6:8], rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("c", [0.0269, 40.0])
def test_flights_are_exact_where_two_pairs_of_eigenvalues_meet_and_with_much_damping(c):
    """Eigenvectors fail where they meet: at mass ratio 0.06, k2/mu 0.89, c2 0.0269."""
    m2 = 0.06
    host = nv.Host([[1.0]], [[1.0]])
    damper = nv.Damper("u", "x1", m=m2, k=m2 * 0.8900, c=c)
    system = nv.System.from_host(host, [damper], force={"x1": 0.0}, omega=1.0)
    start = [0.3, -0.2, 0.5, 0.1]
    orbit = nv.simulate(system, 5, start=start, quiet=True)
    M, C, K, _, _ = matrices_of(system)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    after = scipy.linalg.expm(A * 5 * system.period) @ np.array(start)[[0, 2, 1, 3]]
    # much damping takes 2^10 smallest cells, whose propagators are squared
    assert orbit.state == pytest.approx(after[[0, 2, 1, 3]], abs=2e-14 if c < 1 else 5e-12)


def test_a_structure_that_moves_freely_flies_as_by_its_exponential():
    """It has a mode without stiffness, and dashpots that couple its modes."""
    chain = nv.chain([1.0, 2.0, 2.0, 1.0], [0.0, 3.0, 5.0, 3.0])
    C = 0.1 * np.diag([1.0, 0.0, 0.0, 2.0])
    host = nv.Host(chain.M, chain.K, C)
    damper = nv.Damper("u", "x2", m=0.5, k=0.7, c=0.2)
    system = nv.System.from_host(host, [damper], force={"x1": 0.0}, omega=1.3)
    start = np.array([0.3, -0.2, 0.5, 0.1, -0.4, 0.2, 1.0, -0.3, 0.2, 0.6])
    orbit = nv.simulate(system, 4, start=start, quiet=True)
    M, C, K, _, _ = matrices_of(system)
    A = np.block([[np.zeros((5, 5)), np.eye(5)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    after = scipy.linalg.expm(A * 4 * system.period) @ np.concatenate([start[::2], start[1::2]])
    found = np.concatenate([orbit.state[::2], orbit.state[1::2]])
    assert found == pytest.approx(after, abs=1e-12)


def test_a_stiff_host_in_steady_motion_moves_as_its_frequency_response():
    """The highest mode is 26 times as fast as the force; nothing is touched."""
    frame = nv.shear_frame([1e4] * 20, [8e6] * 20, ratio=0.05)
    omega = frame.frequencies[0] * 0.9
    X = frame.frequency_response(omega, force={"roof": 1e3})
    start = np.ravel(np.column_stack([X.real, (1j * omega * X).real]))
    system = nv.System.from_host(frame, force={"roof": 1e3}, omega=omega)
    orbit = nv.simulate(system, 50, start=start, quiet=True)
    scale = np.abs(X).max() * np.array([1, omega] * 20)
    assert np.all(np.abs(orbit.section - start) < 1e-12 * scale)


def test_motion_of_the_ground_is_a_force_on_all_masses():
    frame = nv.shear_frame([1000.0, 800.0], [8e4, 6e4], ratio=0.02)
    cell = nv.Damper("cell", "roof", m=30.0, k=150.0, c=5.0, walls=[nv.Wall(1.0, K=1e7)])
    system = nv.System.from_host(frame, [cell], base={"acceleration": 0.2}, omega=5.0)
    M, C, K, _, _ = matrices_of(system)
    X = np.linalg.solve(K - 25 * M + 5j * C, -0.2 * M @ np.ones(3))
    start = np.ravel(np.column_stack([X.real, (5j * X).real]))
    orbit = nv.simulate(system, 3, start=start, quiet=True)
    assert orbit.state == pytest.approx(start, abs=1e-13)


def test_a_reduced_host_follows_the_whole_one_and_continues_bit_for_bit():
    frame = nv.shear_frame([1000.0] * 8, [9e5] * 8, ratio=0.02)
    cell = nv.Damper("cell", "roof", m=120.0, k=900.0, c=60.0, walls=[nv.Wall(0.01, K=2e6)])
    load = {"force": {"roof": 400.0}, "omega": 5.5}
    whole = nv.simulate(nv.System.from_host(frame, [cell], **load), 10, quiet=True)
    reduced = nv.System.from_host(frame.reduced(6, statics=["roof"]), [cell], **load)
    assert reduced.scene.components[0] == "mode1"
    orbit = nv.simulate(reduced, 10, quiet=True)
    roof = orbit.section[:, :14:2] @ reduced.host.row("roof")
    assert len(orbit.impacts) == len(whole.impacts) > 5
    assert np.abs(roof - whole.section[:, 14]).max() < 2e-3 * np.abs(roof).max()
    half = nv.simulate(reduced, 3, transient=7, quiet=True)
    assert np.array_equal(half.section, orbit.section[7:])
    assert np.array_equal(nv.simulate(reduced, 10, quiet=True).state, orbit.state)


@pytest.mark.parametrize(
    "law",
    [{"K": 1e4}, {"law": "linear", "kc": 1e3}, {"law": "linear", "kc": 1e3, "cc": 10.0},
     {"law": "restitution", "e": 0.0}],
)  # fmt: skip
@pytest.mark.parametrize("dof", ["a", "b"])
def test_a_mass_that_rests_on_its_wall_moves_as_from_a_tiny_gap(law, dof):
    """Where the force acts elsewhere, r begins with the fourth power of the time."""
    host = nv.chain([1.0, 0.3], [4.0, 2.0], dofs=["a", "b"])
    states = []
    for gap in (0.0, 1e-11):
        stop = nv.Damper("stop", ("b", "ground"), walls=[nv.Wall(gap, **law)])
        system = nv.System.from_host(host, [stop], force={dof: 1.0}, omega=1.3)
        states.append(nv.simulate(system, 1, quiet=True).state)
    assert states[0] == pytest.approx(states[1], abs=1e-7)


@pytest.mark.parametrize("ends", ["clamped-free", "free-free"])
def test_modes_in_kernels_have_low_frequencies(ends):
    """A lowest omega^2 that is round-off beside the largest: 3e-11, and 0 of a free beam."""
    beam = nv.beam(1.0, 65.6, 1.18, elements=100, ends=ends)
    n = len(beam.inertia)
    squares, modes = np.zeros(n), np.zeros((n, n))
    fill_modes(beam.M, beam.K, squares, modes)
    # cos(a) cosh(a) = -1 and 1
    numbers = {
        "clamped-free": [1.8751040687119611, 4.694091132974175],
        "free-free": [0.0, 0.0, 4.730040744862704, 7.853204624095838],
    }[ends]
    exact = np.array(numbers) ** 2 * np.sqrt(65.6 / 1.18)
    assert squares[squares == 0].size == numbers.count(0.0)
    assert np.sqrt(squares[: len(exact)]) == pytest.approx(exact, rel=1e-7)
