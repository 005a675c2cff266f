"""Springs that are not linear: orbits, energies, walls and variations beside SciPy's DOP853."""

import numpy as np
import pytest
from host_flows import HostMap
from scipy.integrate import solve_ivp

import nlds_vines as nv

pytestmark = pytest.mark.kernels


def frame_with_sinks(rng, floors, sinks, walls=None, kind=None):
    """Return a shear frame whose floors carry sinks with k of any sign and nonlinear springs."""
    ratio = float(10 ** rng.uniform(-3, -1))
    host = nv.shear_frame([1.0] * floors, [float(floors**2)] * floors, ratio=ratio)
    first = float(host.frequencies[0])
    dampers = []
    for i in range(sinks):
        m = float(10 ** rng.uniform(-2.3, -0.7))
        k = float(rng.choice([-1, 0, 1]) * m * 10 ** rng.uniform(-1.5, 0.5))
        c = float(m * 10 ** rng.uniform(-2, 0))
        k3 = float(m * 10 ** rng.uniform(-1, 2))
        of_kind = kind or rng.choice(["cubic", "quintic", "asymmetric"])
        terms = {"k3": k3}
        if of_kind == "quintic":
            terms["k5"] = float(m * 10 ** rng.uniform(-1, 2))
        if of_kind == "asymmetric":
            terms["k2"] = float(0.5 * np.sqrt(m * k3) * rng.choice([-1, 1]))
        place = host.dofs[-1 - i % floors]
        damper = nv.Damper(
            f"sink{i}", place, m=m, k=k, c=c, spring=nv.Spring(**terms), walls=walls or ()
        )
        dampers.append(damper)
    force = {host.dofs[-1]: float(10 ** rng.uniform(-2.5, 0))}
    omega = first * float(10 ** rng.uniform(-0.4, 0.5))
    return nv.System.from_host(host, dampers, force=force, omega=omega)


class Assembled:
    """The equations of motion of a system, assembled without the package's kernels."""

    def __init__(self, system):
        host = system.host
        n = len(host.dofs)
        masses = [damper for damper in system.dampers if damper.m is not None]
        self.size = n + len(masses)
        size = self.size
        self.M, self.C, self.K = np.zeros((3, size, size))
        self.M[:n, :n] = host.M
        self.C[:n, :n] = host.C
        self.K[:n, :n] = host.K
        self.force = np.zeros(size)
        for name, amplitude in system.force.items():
            self.force[host.dofs.index(name)] = amplitude
        self.rows, self.springs = [], []
        places = [*host.dofs, *(damper.name for damper in masses)]
        for damper in system.dampers:
            row = np.zeros(size)
            row[places.index(damper.ends[0])] = 1.0
            if damper.ends[1] != "ground":
                row[places.index(damper.ends[1])] = -1.0
            self.K += damper.k * np.outer(row, row)
            self.C += damper.c * np.outer(row, row)
            self.rows.append(row)
            self.springs.append(damper.spring)
        for i, damper in enumerate(masses):
            self.M[n + i, n + i] = damper.m
        self.inverse = np.linalg.inv(self.M)
        self.omega = system.omega

    def acceleration(self, t, x, v):
        force = self.force * np.cos(self.omega * t) - self.C @ v - self.K @ x
        for row, spring in zip(self.rows, self.springs, strict=True):
            if spring is not None:
                force -= row * spring.force(row @ x)
        return self.inverse @ force

    def rate(self, t, y):
        x, v = y[::2], y[1::2]
        out = np.empty_like(y)
        out[::2] = v
        out[1::2] = self.acceleration(t, x, v)
        return out

    def follow(self, start, times, **how):
        settings = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, **how}
        return solve_ivp(self.rate, (times[0], times[-1]), start, t_eval=times, **settings)


def sensitivity_of(equations, start, times, sections):
    """Return how much a relative change of the start grows."""
    share = 1e-8
    moved = equations.follow(start * (1 + share), times).y.T
    return np.abs(moved - sections).max() / np.abs(sections).max() / share


def test_a_cubic_sink_under_strong_modulation_follows_dop853():
    """Its orbit, its largest energies at any instant, and its response."""
    eps, lam, amplitude = 0.05, 0.2, 0.35
    host = nv.Host([[1.0]], [[1.0]], [[0.0]], dofs=["x"])
    sink = nv.Damper("nes", "x", m=eps, c=eps * lam, spring=nv.Spring(k3=4 / 3 * eps))
    system = nv.System.from_host(host, [sink], force={"x": eps * amplitude}, omega=1.0)
    start = np.array([0.3, 0.0, 0.0, 0.0])
    record = ("section", "energy", "response")
    orbit = nv.simulate(system, 20, start=start, record=record, quiet=True)
    times = 2 * np.pi * np.arange(21)
    exact = Assembled(system).follow(start, times, dense_output=True)
    assert np.abs(orbit.section - exact.y.T[1:]).max() < 1e-10
    fine = np.linspace(0.0, times[-1], 200_001)
    x, v, u, w = exact.sol(fine)
    assert orbit.E1max == pytest.approx((0.5 * (v**2 + x**2)).max(), rel=1e-7)
    stored = eps / 3 * (x - u) ** 4
    assert orbit.E2max[0] == pytest.approx((0.5 * eps * w**2 + stored).max(), rel=1e-7)
    assert orbit.response["x.x_max"] == pytest.approx(np.abs(x).max(), rel=1e-7)
    mean = np.trapezoid(x**2, fine) / fine[-1]
    assert orbit.response["x.x_rms"] == pytest.approx(np.sqrt(mean), rel=1e-7)


@pytest.mark.parametrize("seed", range(12))
def test_random_systems_follow_dop853(seed):
    """Frames of 1 to 10 floors with 1 to 3 sinks: the error over the sensitivity is below 1e-9."""
    rng = np.random.default_rng(100 + seed)
    floors, sinks = int(rng.integers(1, 11)), int(rng.integers(1, 4))
    system = frame_with_sinks(rng, floors, sinks)
    start = rng.normal(0.0, 0.3, 2 * (floors + sinks))
    times = system.period * np.arange(6)
    equations = Assembled(system)
    exact = equations.follow(start, times).y.T
    orbit = nv.simulate(system, 5, start=start, quiet=True)
    error = np.abs(orbit.section - exact[1:]).max() / np.abs(exact).max()
    assert error < 1e-9 * max(1.0, sensitivity_of(equations, start, times, exact))


MOST_STRUCK = 300  # SciPy never ends a sequence of rebounds that comes to rest


def with_rigid_walls(equations, walls, start, times):
    """Return the sections of an orbit with impacts on (row, sign, gap, e), and their number.

    SciPy looks for events at the ends of its steps, so these must be short.
    """
    count, now, state, sections = 0, times[0], start.copy(), []

    def event_of(row, sign, gap):
        def event(t, y):
            return gap - sign * (row @ y[::2])

        event.terminal, event.direction = True, -1
        return event

    events = [event_of(row, sign, gap) for row, sign, gap, _ in walls]
    for end in times[1:]:
        while now < end:
            piece = solve_ivp(
                equations.rate, (now, end), state, "DOP853", rtol=1e-13, atol=1e-15, events=events,
                max_step=0.02,
            )  # fmt: skip
            now, state = piece.t[-1], piece.y[:, -1].copy()
            if piece.status == 1:
                struck = next(i for i, at in enumerate(piece.t_events) if len(at))
                row, _, _, e = walls[struck]
                answer = equations.inverse @ row
                state[1::2] -= (1 + e) * (row @ state[1::2]) / (row @ answer) * answer
                count += 1
                assert count < MOST_STRUCK
        sections.append(state.copy())
    return np.array(sections), count


@pytest.mark.parametrize("seed", range(5))
def test_rigid_walls_beside_springs_are_struck_as_by_dop853(seed):
    """No touch is missed, and the sections agree."""
    rng = np.random.default_rng(200 + seed)
    gap, e = float(rng.uniform(0.1, 0.2)), float(rng.uniform(0.5, 0.8))
    sides = [nv.Wall(gap, side, law="restitution", e=e) for side in "+-"]
    floors, sinks = int(rng.integers(1, 4)), int(rng.integers(1, 3))
    system = frame_with_sinks(rng, floors, sinks, sides)
    start = np.zeros(2 * (floors + sinks))
    start[1::2] = rng.normal(0.0, 0.5, floors + sinks)
    times = system.period * np.arange(5)
    equations = Assembled(system)
    walls = [(row, sign, gap, e) for row in equations.rows for sign in (1, -1)]
    exact, count = with_rigid_walls(equations, walls, start, times)
    record = ("section", "impacts")
    orbit = nv.simulate(system, 4, start=start, record=record, tolerance=1e-12, quiet=True)
    assert len(orbit.impacts) == count > 0
    moved, _ = with_rigid_walls(equations, walls, start * (1 + 1e-9), times)
    scale = np.abs(exact).max()
    sensitivity = max(1.0, np.abs(moved - exact).max() / scale / 1e-9)
    assert np.abs(orbit.section - exact).max() / scale < 1e-9 * sensitivity


LAWS = [
    {"law": "hertz", "K": 20.0},
    {"law": "hertz", "K": 20.0, "hunt_crossley": 0.3},
    {"law": "power", "K": 5.0, "exponent": 2.0},
    {"law": "linear", "kc": 5.0, "cc": 0.02},
]


def pushes_of(law, depth, speed):
    if law["law"] == "linear":
        return max(law["kc"] * depth + law["cc"] * speed, 0.0) if depth > 0 else 0.0
    exponent = law.get("exponent", 1.5)
    factor = max(1 + law.get("hunt_crossley", 0.0) * speed, 0.0)
    return law["K"] * max(depth, 0.0) ** exponent * factor


@pytest.mark.parametrize("law", LAWS)
def test_compliant_walls_beside_springs_push_as_by_dop853(law):
    """A bistable sink between two walls of each law; DOP853 steps at most 0.0005 of a period."""
    gap = 0.4
    sides = [nv.Wall(gap, side, **law) for side in "+-"]
    host = nv.Host([[1.0]], [[1.0]], [[0.02]], dofs=["x"])
    sink = nv.Damper(
        "nes", "x", m=0.1, k=-0.05, c=0.01, spring=nv.Spring(k2=0.05, k3=0.5), walls=sides
    )
    system = nv.System.from_host(host, [sink], force={"x": 0.2}, omega=0.9)
    equations = Assembled(system)
    plain = equations.acceleration

    def acceleration(t, x, v):
        row = equations.rows[0]
        r, s, push = row @ x, row @ v, 0.0
        for sign in (1, -1):
            push += sign * pushes_of(law, sign * r - gap, sign * s)
        return plain(t, x, v) - equations.inverse @ row * push

    equations.acceleration = acceleration
    times = system.period * np.arange(3)
    start = np.array([0.1, 0.0, 0.0, 0.2])
    exact = equations.follow(start, times, max_step=0.0005 * system.period).y.T[1:]
    record = ("section", "impacts")
    orbit = nv.simulate(system, 2, start=start, record=record, tolerance=1e-11, quiet=True)
    assert len(orbit.impacts) > 2
    assert np.abs(orbit.section - exact).max() < 3e-10


WALLS = [(), (nv.Wall(0.1, law="restitution", e=0.7),), (nv.Wall(0.1, K=5.0),)]


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("sinks", [1, 2])
def test_variations_are_differences_and_obey_liouville(wall, sinks):
    rng = np.random.default_rng(7)
    system = frame_with_sinks(rng, 2, sinks, wall, kind="asymmetric")
    flow = HostMap(system, 1e-13)
    y = rng.normal(0.0, 0.2, flow.size)
    y[2:4] = y[4:6] = 0.0
    result = flow(y, 3)
    assert (sum(result.counts) > 0) == bool(wall)
    for direction in np.eye(flow.size)[:3]:
        difference = flow.difference(y, 3, direction, 1e-5)
        error = np.abs(result.matrix @ direction - difference).max()
        assert error < 2e-7 * np.abs(result.matrix).max()
    _, logarithm = np.linalg.slogdet(result.matrix)
    expected = result.trace * 3 * system.period + result.shrunk
    assert logarithm == pytest.approx(expected, abs=1e-9)


# ---- published sinks -----------------------------------------------------------------------------


@pytest.mark.parametrize(("share", "left"), [(0.9, 0.742), (1.0, 0.008)])
def test_energy_is_pumped_from_the_threshold_of_dekemele_on(share, left):
    """Nonlinear Dynamics 93 (2018) 1831: m = k = 1, v0 = 0.1, the sink 0.02 kg, 0.002 N s/m.

    Its k3 is 0.404018 N/m^3 at the threshold. The energy of the structure after 100 s is that of
    own runs of DOP853 at 1e-10, over the energy at the beginning.
    """
    host = nv.Host([[1.0]], [[1.0]], [[0.0]], dofs=["x"])
    sink = nv.Damper("nes", "x", m=0.02, c=0.002, spring=nv.Spring(k3=share * 0.404018))
    system = nv.System.from_host(host, [sink], force={"x": 0.0}, omega=1.0)
    start = [0.0, 0.1, 0.0, 0.0]
    orbit = nv.simulate(system, 1, transient=16, start=start, record=("energy",), quiet=True)
    assert orbit.E1max / 0.005 == pytest.approx(left, abs=1e-3)


EPS, LAMBDA = 0.05, 0.2


def gendelman(amplitude):
    """Return x1'' + x1 + eps (lambda s + 4/3 r^3) = eps A cos t with a sink of mass eps."""
    host = nv.Host([[1.0]], [[1.0]], [[0.0]], dofs=["x"])
    sink = nv.Damper("nes", "x", m=EPS, c=EPS * LAMBDA, spring=nv.Spring(k3=4 / 3 * EPS))
    return nv.System.from_host(host, [sink], force={"x": EPS * amplitude}, omega=1.0)


@pytest.mark.parametrize("amplitude", [0.228881, 0.961626])
def test_tori_are_born_near_the_folds_of_the_slow_manifold(amplitude):
    """Own values by DOP853, for eps = 0.05; the folds are at A = 0.2419 and 0.9892 for eps = 0.

    The T orbit begins at the solution of one harmonic, N^2 (N^4 + lambda^2) = A^2.
    """
    squares = np.roots([1.0, 0.0, LAMBDA**2, -(amplitude**2)])
    N2 = squares[np.abs(squares.imag) < 1e-9].real.max()
    stroke = amplitude / (N2 + 1j * LAMBDA)
    x = stroke * (1.0 - N2 - 1j * LAMBDA)
    u = x - stroke
    y = np.array([x.real, u.real, -x.imag, -u.imag])
    flow = HostMap(gendelman(amplitude), 1e-12)
    for _ in range(12):
        result = flow(y, 1)
        y = y + np.linalg.solve(np.eye(4) - result.matrix, result.sections[-1] - y)
    multipliers = np.linalg.eigvals(flow(y, 1).matrix)
    largest = multipliers[np.abs(multipliers).argmax()]
    assert abs(abs(largest) - 1.0) < 2e-6
    assert abs(largest.imag) > 0.01


def test_between_the_folds_the_response_is_strongly_modulated():
    orbit = nv.simulate(gendelman(0.26), 2000, transient=500, start=[0.3, 0, 0, 0], quiet=True)
    amplitudes = np.hypot(orbit.section[:, 0], orbit.section[:, 1])
    assert amplitudes.min() == pytest.approx(0.07, abs=0.01)
    assert amplitudes.max() == pytest.approx(0.43, abs=0.01)


def test_labels_count_impacts_alone():
    calm = nv.classify(gendelman(0.1), start=[0.3, 0, 0, 0], quiet=True)
    assert calm.label == "T,0"
    assert np.abs(calm.multipliers).max() == pytest.approx(0.938125, abs=1e-5)


def weakly_forced_well():
    return nv.load_system("nes-bistable").with_(**{"force.x1": 2e-5})


@pytest.mark.parametrize("make", [lambda: gendelman(0.1), weakly_forced_well])
def test_multipliers_are_those_of_differences(make):
    """Cells carry variations by the derivative of what they compute."""
    system = make()
    orbit = nv.classify(system, quiet=True)
    assert orbit.label == "T,0"
    flow = HostMap(system, 1e-13)
    y = flow.orbits.start(orbit.state)
    columns = [flow.difference(y, 1, direction, 1e-4) for direction in np.eye(flow.size)]
    expected = np.linalg.eigvals(np.array(columns).T)
    largest = np.abs(expected).max()
    assert largest > 0.5
    assert np.abs(orbit.multipliers[0]) == pytest.approx(largest, abs=1e-8)
    assert np.abs(flow(y, 1).sections[0] - y).max() < 1e-9


def test_wells_are_attractors():
    """Under a weak force an orbit from each well stays in it; under a strong one it does not."""
    weak = weakly_forced_well()
    wells = [rest for rest in weak.rests if rest.is_stable]
    assert [np.sign(rest.strokes["nes"]) for rest in wells] == [-1.0, 1.0]
    for rest in wells:
        orbit = nv.classify(weak, start=rest.state, quiet=True)
        assert orbit.label == "T,0"
        r = orbit.state[0] - orbit.state[2]
        assert abs(r - rest.strokes["nes"]) < 0.1 * abs(rest.strokes["nes"])
    strong = weak.with_(**{"force.x1": 0.02})
    orbit = nv.simulate(strong, 50, start=wells[0].state, quiet=True)
    r = orbit.section[:, 0] - orbit.section[:, 2]
    assert r.min() < 0.0 < r.max()


def test_basins_tell_wells_apart():
    """The starts of a mass at the bottoms of both wells, and far outside: two attractors."""
    plane = {
        "system": weakly_forced_well(),
        "vary": {"nes_0": {"values": [-0.15, 0.15, 0.6]}},
        "start": {"policy": "rest"},
        "sampling": {"transient": 400, "periods": 20},
        "record": {"want": ["attractor"]},
    }
    found = nv.scan(plane, quiet=True)
    numbers = np.asarray(found["attractor"]).ravel()
    assert numbers[0] != numbers[1]
    assert numbers[2] in numbers[:2]
