"""Derivatives of hosts' orbits: beside differences, determinants, and kernels of one damper."""

import math

import numpy as np
import pytest
import scipy.linalg
from host_flows import HostMap
from test_hosts import matrices_of, random_system

import nlds_vines as nv
from nlds_vines.engine.classification import ALIGNING, lyapunov_spectrum
from nlds_vines.engine.host_orbits import LAWS_IN_KERNELS

pytestmark = pytest.mark.kernels

FRAME = nv.shear_frame([1000.0, 800.0], [8e4, 6e4], ratio=0.02)
LAWS = {
    "hertz": {"K": 1e7},
    "power 1": {"law": "power", "K": 3e5, "exponent": 1.0},
    "power 1.25": {"law": "power", "K": 3e5, "exponent": 1.25},
    "power 1.7": {"law": "power", "K": 3e6, "exponent": 1.7},
    "hunt-crossley": {"K": 1e7, "hunt_crossley": 5.0},
    "linear": {"law": "linear", "kc": 1e6, "cc": 500.0},
    "kelvin-voigt": {"law": "kelvin-voigt", "kc": 1e6, "cc": 500.0},
    "restitution": {"law": "restitution", "e": 0.6},
    "held": {"law": "restitution", "e": 0.0},
}
CONSERVE = ("hertz", "power 1", "power 1.25", "power 1.7")


def frame_with(one, two, omega=4.0, P=900.0):
    first = nv.Damper(
        "one",
        "roof",
        m=60.0,
        k=300.0,
        c=40.0,
        walls=[nv.Wall(0.03, **one), nv.Wall(0.05, "-", **one)],
    )
    second = nv.Damper("two", "floor1", m=30.0, k=150.0, c=20.0, walls=[nv.Wall(0.01, **two)])
    return nv.System.from_host(FRAME, [first, second], force={"roof": P}, omega=omega)


def error_of(flow, y, periods):
    """Return the orbit, and the largest error of its derivative beside differences."""
    orbit = flow(y, periods)
    scales, off, most = flow.scales(orbit.sections), 0.0, 0.0
    for c in range(flow.size):
        direction = scales[c] * np.eye(flow.size)[c]
        slope = flow.difference(y, periods, direction) / scales
        off = max(off, np.abs(orbit.matrix @ direction / scales - slope).max())
        most = max(most, np.abs(slope).max())
    return orbit, off / most


@pytest.mark.parametrize("law", LAWS)
def test_a_derivative_is_the_limit_of_differences(law):
    flow = HostMap(frame_with(LAWS[law], LAWS[law]))
    y = flow(np.zeros(flow.size), 4, False).sections[-1]
    orbit, error = error_of(flow, y, 3)
    assert min(orbit.counts) > 2
    assert error < (1e-7 if law == "power 1.7" else 1e-8)
    alone = flow(y, 3, False)
    assert np.array_equal(alone.sections, orbit.sections)
    assert np.array_equal(alone.state, orbit.state)
    sign, volume = np.linalg.slogdet(orbit.matrix)
    lost = volume - orbit.trace * 3 * flow.orbits.body.period
    is_singular = np.linalg.cond(orbit.matrix) > 1.0 / np.finfo(float).eps
    assert is_singular == (law == "held")  # walls that hold lose directions
    assert sign > 0 or is_singular
    if law in CONSERVE:
        assert orbit.shrunk == 0.0
    if is_singular:
        assert orbit.shrunk == -math.inf
    else:
        assert lost == pytest.approx(orbit.shrunk, abs=1e-9)
        assert law in CONSERVE or orbit.shrunk < -1.0


@pytest.mark.parametrize("seeds", [range(8), pytest.param(range(8, 200), marks=pytest.mark.long)])
def test_derivatives_of_random_hosts_are_limits_of_differences(seeds):
    """Of hosts with up to four dampers and eight walls, each with a law of its own."""
    resolved = 0
    for seed in seeds:
        flow = HostMap(random_system(seed))
        begun = flow(np.zeros(flow.size), 4, False)
        walls, n = flow.orbits.walls, flow.size // 2
        y, is_closed = begun.sections[-1], begun.state[flow.size + walls.number :] != 0
        orbit, alone = flow(y, 2), flow(y, 2, False)
        assert np.array_equal(alone.sections, orbit.sections), seed
        assert np.array_equal(alone.state, orbit.state), seed
        scales = flow.scales(orbit.sections)
        direction = np.random.default_rng(seed).normal(size=flow.size) * scales
        held = walls.links[is_closed & (walls.law == LAWS_IN_KERNELS.index("restitution"))]
        rows, answers = (
            array.reshape(-1, n)[held]
            for array in (flow.orbits.body.rows, flow.orbits.body.answers)
        )
        for part in (direction[:n], direction[n:]):  # along the walls that hold
            part -= answers.T @ np.linalg.solve(rows @ answers.T, rows @ part)
        along = orbit.matrix @ direction / scales
        errors = [
            np.abs(along - flow.difference(y, 2, direction, share) / scales).max()
            for share in (1e-5, 1e-7, 1e-9)  # chaotic orbits take short ones
        ]
        growth = np.abs(orbit.matrix * scales / scales[:, None]).max()
        _, volume = np.linalg.slogdet(orbit.matrix)
        free = orbit.trace * 2 * flow.orbits.body.period
        if np.linalg.cond(orbit.matrix * scales / scales[:, None]) < 1e8:
            resolved += 1
            assert volume == pytest.approx(free + orbit.shrunk, abs=1e-6), seed
        assert min(errors) < 1e-6 * np.abs(along).max() or growth > 1e8, seed
    assert resolved > 0.4 * len(seeds)


def lost_at_rigid_walls(system, begin, end):
    """Return 2 ln e for each impact between two times."""
    orbit = nv.simulate(system, round(end / system.period), record=["impacts"], quiet=True)
    loss = 0.0
    for damper in system.dampers:
        for wall in damper.walls:
            rows = orbit.impacts[orbit.impacts["damper"] == damper.name]
            touch = rows["touch"][rows["wall"] == wall.side]
            count = np.count_nonzero((touch > begin) & (touch <= end))
            assert count > 50
            loss += 2.0 * math.log(wall.constants["e"]) * count
    return loss


def lost_in_dashpots(system, begin, end):
    """Return -cc / mu times the time of contact between two times."""
    orbit = nv.simulate(system, round(end / system.period) + 1, record=["impacts"], quiet=True)
    M, _, _, _, rows = matrices_of(system)
    loss = 0.0
    for damper, row in zip(system.dampers, rows, strict=True):
        inverse = row @ np.linalg.solve(M, row)
        for wall in damper.walls:
            own = (orbit.impacts["damper"] == damper.name) & (orbit.impacts["wall"] == wall.side)
            touch, release = orbit.impacts["touch"][own], orbit.impacts["release"][own]
            lasting = np.clip(release, begin, end) - np.clip(touch, begin, end)
            assert np.count_nonzero(lasting > 0.0) > 50
            loss -= wall.constants["cc"] * inverse * np.nansum(lasting)
    return loss


@pytest.mark.parametrize(
    ("law", "P", "lost"),
    [
        ("hertz", 900.0, lambda *times: 0.0),
        ("restitution", 900.0, lost_at_rigid_walls),
        ("kelvin-voigt", 600.0, lost_in_dashpots),  # periodic: chaos would need all digits
    ],
)
def test_exponents_sum_to_the_divergence_in_closed_form(law, P, lost):
    """Those of orthonormalized variations: -tr(M^-1 C), and what impacts or dashpots shrink."""
    system, periods = frame_with(LAWS[law], LAWS[law], P=P), 64
    begin = ALIGNING * system.period
    end = begin + periods * system.period
    spectrum = lyapunov_spectrum(system, None, periods, quiet=True)
    M, C, *_ = matrices_of(system)
    divergence = -np.trace(np.linalg.solve(M, C)) + lost(system, begin, end) / (end - begin)
    assert spectrum.divergence == pytest.approx(divergence, rel=1e-9)
    assert spectrum.exponents.sum() == pytest.approx(divergence, rel=1e-9)


def side_by_side(first, second, dashpot=0.0, far=None):
    """Return two equal masses with equal dampers, moved alike until the first impacts.

    first, second: e of the dampers' walls; dashpot [N s/m]: between the masses; far: e of a second
    wall of the first damper.
    """
    C = np.array([[6.0 + dashpot, -dashpot], [-dashpot, 6.0 + dashpot]])
    host = nv.Host(10.0 * np.eye(2), 400.0 * np.eye(2), C, dofs=["x", "y"])
    dampers = []
    for name, dof, e in (("a", "x", first), ("b", "y", second)):
        walls = [nv.Wall(0.05, law="restitution", e=e)]
        if far is not None and name == "a":
            walls.append(nv.Wall(0.07, "-", law="restitution", e=far))
        dampers.append(nv.Damper(name, dof, m=2.0, k=60.0, c=1.0, walls=walls))
    return nv.System.from_host(host, dampers, force={"x": 40.0, "y": 40.0}, omega=5.5)


@pytest.mark.parametrize(
    ("coefficients", "periods"),
    [((0.7, 0.7), 4), ((0.7, 0.4), 4), ((0.8, 0.6, 0.0, 0.7), 2), ((0.6, 0.0), 1)],
)
def test_walls_that_do_not_interact_are_each_struck_at_a_time_of_its_own(coefficients, periods):
    """Two oscillators side by side, from rest; the dampers part at the first impacts."""
    system = side_by_side(*coefficients)
    orbit = nv.simulate(system, periods, start=np.zeros(8), tolerance=1e-13, quiet=True)
    touches = orbit.impacts["touch"][orbit.impacts["speed"] > 0.0]
    assert touches[0] == touches[1]
    flow = HostMap(system)
    mapped, error = error_of(flow, np.zeros(flow.size), periods)
    assert min(mapped.counts[0], mapped.counts[-1]) > 0
    assert error < 1e-7
    if min(coefficients[:2]) > 0.0:
        _, volume = np.linalg.slogdet(mapped.matrix)
        free = mapped.trace * periods * flow.orbits.body.period
        e = [wall.constants["e"] for damper in system.dampers for wall in damper.walls]
        assert mapped.shrunk == pytest.approx(2.0 * mapped.counts @ np.log(e), rel=1e-13)
        assert volume == pytest.approx(free + mapped.shrunk, rel=1e-9)


def slopes_beside(flow, y, periods, direction, h):
    """Return the difference quotients towards both sides of y along a direction."""
    middle = flow(y, periods, False).sections[-1]
    return [
        (flow(y + side * h * direction, periods, False).sections[-1] - middle) / (side * h)
        for side in (1.0, -1.0)
    ]


def test_a_dashpot_between_masses_that_are_struck_at_one_instant_leaves_no_derivative():
    """The motion has a kink: the derivatives towards both sides differ."""
    for dashpot, is_smooth in ((0.0, True), (1e-9, True), (4.0, False)):
        flow = HostMap(side_by_side(0.7, 0.7, dashpot))
        y = np.zeros(flow.size)
        mapped = flow(y, 2)
        scales = flow.scales(mapped.sections)
        direction = np.zeros(flow.size)
        direction[: flow.size // 2] = flow.orbits.start(np.array([1e-2, 0.0] + 6 * [0.0]))[
            : flow.size // 2
        ]
        ahead, behind = slopes_beside(flow, y, 2, direction, 1e-6)
        differ = np.abs((ahead - behind) / scales).max() / np.abs(ahead / scales).max()
        assert (differ < 1e-3) == is_smooth
        assert np.isnan(mapped.matrix).all() == (not is_smooth)
        assert math.isnan(mapped.shrunk) == (not is_smooth)


@pytest.mark.parametrize("e", [0.7, 0.0])
def test_walls_that_interact_and_are_struck_at_one_instant_leave_no_derivative(e):
    """Two equal dampers on one mass: the motion jumps with the order in which they strike."""
    rigid = nv.Wall(0.02, law="restitution", e=e)
    twins = [nv.Damper(name, "roof", m=60.0, k=300.0, c=40.0, walls=[rigid]) for name in "ab"]
    other = nv.Damper(
        "c", "floor1", m=30.0, k=150.0, walls=[nv.Wall(0.013, law="restitution", e=0.5)]
    )
    system = nv.System.from_host(FRAME, [*twins, other], force={"roof": 900.0}, omega=4.0)
    flow = HostMap(system)
    orbit = flow(np.zeros(flow.size), 3)
    assert orbit.counts[0] == orbit.counts[1] > 2
    assert orbit.counts[2] > 2
    assert np.isnan(orbit.matrix).all()
    assert math.isnan(orbit.shrunk)
    alone = flow(np.zeros(flow.size), 3, False)
    assert np.array_equal(alone.sections, orbit.sections)
    direction = np.zeros(flow.size)
    direction[2], direction[3] = 1.0, -1.0  # the masses of a and b
    lengths = [
        np.abs(slopes_beside(flow, np.zeros(flow.size), 1, direction, h)[0]).max()
        for h in (1e-7, 1e-9, 1e-11)
    ]
    assert lengths[1] / lengths[0] == pytest.approx(100.0, rel=1e-3)
    assert lengths[2] / lengths[1] == pytest.approx(100.0, rel=1e-3)


def test_walls_that_limit_the_same_motion_are_struck_at_one_time():
    """Two walls with one gap, of one mass against the ground: as one wall with the first's e."""
    host = nv.Host([[1.0]], [[1.0]], [[0.1]])
    walls = [nv.Wall(0.3, law="restitution", e=0.6)]
    pair = [nv.Damper(name, ("x1", "ground"), walls=walls) for name in ("a", "b")]
    one, both = (
        HostMap(nv.System.from_host(host, dampers, force={"x1": 1.0}, omega=1.3))(np.zeros(2), 3)
        for dampers in (pair[:1], pair)
    )
    assert one.counts[0] > 2
    assert both.matrix == pytest.approx(one.matrix, abs=1e-12)
    assert both.shrunk == pytest.approx(one.shrunk, rel=1e-14)


@pytest.mark.parametrize("law", [{"K": 1e6}, {"law": "linear", "kc": 1e4, "cc": 50.0}])
def test_a_wall_that_is_touched_as_another_is_struck(law):
    """Hertz' force begins without a jump; that of a dashpot depends on which comes first."""
    host = nv.Host([[10.0]], [[400.0]], [[6.0]])
    dampers = [
        nv.Damper(name, "x1", m=2.0, k=60.0, c=1.0, walls=[nv.Wall(0.05, **wall)])
        for name, wall in (("a", {"law": "restitution", "e": 0.7}), ("b", law))
    ]
    flow = HostMap(nv.System.from_host(host, dampers, force={"x1": 40.0}, omega=5.5))
    if "K" not in law:
        assert np.isnan(flow(np.zeros(6), 1).matrix).all()
        return
    mapped, error = error_of(flow, np.zeros(6), 1)
    assert min(mapped.counts) > 0
    assert error < 1e-5


@pytest.mark.parametrize("e", [0.7, 0.4])
def test_exponents_of_two_systems_side_by_side_sum_to_twice_the_divergence(e):
    """-tr(M^-1 C), and 2 ln e for each impact at each wall."""
    system, periods = side_by_side(e, e), 64
    begin = ALIGNING * system.period
    end = begin + periods * system.period
    spectrum = lyapunov_spectrum(system, None, periods, quiet=True)
    M, C, *_ = matrices_of(system)
    lost = lost_at_rigid_walls(system, begin, end)
    divergence = -np.trace(np.linalg.solve(M, C)) + lost / (end - begin)
    assert spectrum.divergence == pytest.approx(divergence, rel=1e-9)
    assert spectrum.exponents.sum() == pytest.approx(divergence, rel=1e-9)


def test_a_derivative_of_a_flight_is_the_exponential():
    frame = nv.shear_frame([1e4] * 20, [8e6] * 20, ratio=0.05)
    omega = 0.9 * frame.frequencies[0]
    flow = HostMap(nv.System.from_host(frame, force={"roof": 1e3}, omega=omega))
    orbit, body, one = flow(np.zeros(40), 3), flow.orbits.body, np.eye(20)
    A = np.block([[0 * one, one], [-np.diag(body.squares), -np.diag(body.damping)]])
    exact = scipy.linalg.expm(3 * body.period * A)
    assert np.abs(orbit.matrix - exact).max() < 1e-12 * np.abs(exact).max()
    assert math.isinf(orbit.clearance)


def test_an_orbit_on_a_wall_that_holds_varies_along_it():
    """A displacement off the wall falls back to it."""
    hit = nv.Wall(0.01, law="restitution", e=0.0)
    dampers = [
        nv.Damper("g", ("roof", "ground"), walls=[nv.Wall(0.02, law="restitution", e=0.4)]),
        nv.Damper("t", ("floor1", "roof"), walls=[hit]),
        nv.Damper("m", "roof", m=60.0, k=100.0, c=10.0, walls=[nv.Wall(0.02, K=1e6)]),
    ]
    flow = HostMap(nv.System.from_host(FRAME, dampers, force={"roof": 2000.0}, omega=2.5))
    begun = flow(np.zeros(flow.size), 3)
    y, walls, n = begun.sections[-1], flow.orbits.walls.number, flow.size // 2
    assert list(begun.state[flow.size + walls :] != 0) == [False, True, False]
    orbit = flow(y, 1)
    rows = flow.orbits.body.rows.reshape(-1, n)
    row = rows[flow.orbits.walls.links[1]]
    assert row @ begun.matrix[:n] == pytest.approx(0, abs=1e-12)
    off = np.concatenate([row / (row @ row), np.zeros(n)])
    scales = flow.scales(orbit.sections)
    assert np.abs(orbit.matrix @ off).max() < 1e-12
    for c in range(flow.size):
        direction = scales * np.eye(flow.size)[c]
        for part in (direction[:n], direction[n:]):  # along the wall
            part -= row * (row @ part) / (row @ row)
        slope = flow.difference(y, 1, direction)
        assert orbit.matrix @ direction / scales == pytest.approx(slope / scales, abs=1e-7)


def test_the_smallest_near_miss_and_the_slowest_impact_are_those_of_a_sampled_orbit():
    for seed in range(12):
        system = random_system(seed)
        if any(wall.law == "restitution" for damper in system.dampers for wall in damper.walls):
            continue  # samples do not show the tops of its rebounds
        flow = HostMap(system)
        y = flow(np.zeros(flow.size), 4, False).sections[-1]
        start = flow.orbits.states(y)
        mapped = flow(y, 2)
        orbit = nv.simulate(
            system, 2, start=start, record=["trajectory", "impacts"], samples=1024, tolerance=1e-13,
            quiet=True,
        )  # fmt: skip
        assert len(orbit.impacts) == sum(mapped.counts)
        if len(orbit.impacts):
            assert mapped.slowest == pytest.approx(orbit.impacts["speed"].min(), rel=1e-6)
        inner = np.array([flow.orbits.start(state) for state in orbit.trajectory])
        rows = flow.orbits.body.rows.reshape(-1, flow.size // 2)
        misses = []
        for link, sign, gap, name in zip(*flow.orbits.walls[1:4], flow.orbits.names, strict=True):
            own = (orbit.impacts["damper"] == name[0]) & (orbit.impacts["wall"] == name[1])
            struck = np.searchsorted(orbit.time, orbit.impacts["touch"][own])
            r = sign * inner[:, : flow.size // 2] @ rows[link]
            a, b, c = r[:-2], r[1:-1], r[2:]
            is_top = (b > a) & (b >= c) & (b < gap)
            for k in (1, 2):  # an impact is no miss
                is_top[np.clip(struck - k, 0, len(is_top) - 1)] = False
            top = b + 0.125 * (a - c) ** 2 / np.where(is_top, 2 * b - a - c, 1.0)  # of a parabola
            misses += list(gap - top[is_top])
        assert mapped.clearance == pytest.approx(min(misses, default=np.inf), rel=1e-4), seed
