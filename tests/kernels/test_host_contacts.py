"""Contacts of hosts that overlap, hold, or begin in touch: beside laws of nature and SciPy."""

import itertools
import math

import numpy as np
import pytest
from host_flows import HostMap
from scipy.integrate import solve_ivp
from support import as_host
from test_hosts import by_scipy, matrices_of

import nlds_vines as nv

pytestmark = pytest.mark.kernels

EXPONENTS = (1.05, 1.1, 1.2, 1.3, 1.43, 1.53, 1.77, 2.0, 2.2, 2.5)
BESIDE = {
    "hertz": {"K": 3e4},
    "power": {"law": "power", "K": 2e4, "exponent": 1.37},
    "hunt-crossley": {"law": "power", "K": 2e4, "exponent": 1.6, "hunt_crossley": 1.0},
    "linear": {"law": "linear", "kc": 5e3, "cc": 5.0},
    "kelvin-voigt": {"law": "kelvin-voigt", "kc": 5e3, "cc": 5.0},
    "restitution": {"law": "restitution", "e": 0.4},
    "held": {"law": "restitution", "e": 0.0},
}
"""Laws of contacts that overlap another one."""


def overlapping(law, other, omega):
    """Return two equal dampers on one degree of freedom, whose contacts overlap."""
    host, joint = nv.Host([[3.0]], [[300.0]], [[1.0]]), {"m": 0.3, "k": 20.0, "c": 0.05}
    dampers = [
        nv.Damper("a", "x1", walls=[nv.Wall(0.006, **law)], **joint),
        nv.Damper("b", "x1", walls=[nv.Wall(0.0061, **other)], **joint),
    ]
    return nv.System.from_host(host, dampers, force={"x1": 8.0}, omega=omega)


@pytest.mark.parametrize("other", BESIDE)
def test_the_largest_force_is_that_at_the_largest_depth(other):
    """K depth^n; a damped force exceeds it by the speed of approach at most."""
    several = 0
    for exponent in EXPONENTS:
        for damping in (0.0, 0.7):
            law = {"law": "power", "K": 2e4, "exponent": exponent, "hunt_crossley": damping}
            for omega in (7.5, 9.0, 12.25):
                orbit = nv.simulate(overlapping(law, BESIDE[other], omega), 8, quiet=True)
                impacts = orbit.impacts[orbit.impacts["damper"] == "a"]
                impacts = impacts[~np.isnan(impacts["release"])]
                elastic = 2e4 * impacts["depth"] ** exponent
                if damping == 0.0:
                    assert impacts["force"] == pytest.approx(elastic, rel=1e-9)
                assert np.all(impacts["force"] >= elastic * (1 - 1e-9))
                # a host that is struck beside it can raise the speed of approach
                fastest = np.abs(orbit.impacts["speed"]).max() * 3
                assert np.all(impacts["force"] <= elastic * (1 + damping * fastest) * (1 + 1e-9))
                several += len(impacts)
    assert several > 100


@pytest.mark.parametrize(
    ("exponent", "omega", "damping"), [(1.05, 9.0, 0.7), (1.1, 12.25, 0.0), (1.43, 7.5, 0.7)]
)
def test_the_largest_acceleration_and_force_are_those_of_scipy(exponent, omega, damping):
    law = {"law": "power", "K": 2e4, "exponent": exponent, "hunt_crossley": damping}
    system = overlapping(law, BESIDE["linear"], omega)
    orbit = nv.simulate(system, 3, record=["response", "impacts"], of=["x1"], quiet=True)
    M, C, K, force, rows = matrices_of(system)
    inverse, walls = np.linalg.inv(M), [damper.walls[0] for damper in system.dampers]

    def forces(y):
        values = []
        for row, wall in zip(rows, walls, strict=True):
            z, s = row @ y[:3] - wall.gap, row @ y[3:]
            if wall.law == "linear":
                values.append(max(5e3 * z + 5.0 * s, 0.0) if z > 0 else 0.0)
            else:
                values.append(2e4 * max(z, 0.0) ** exponent * max(1.0 + damping * s, 0.0))
        return np.array(values)

    def rates(t, y):
        push = force * math.cos(omega * t) - K @ y[:3] - C @ y[3:] - rows.T @ forces(y)
        return np.concatenate([y[3:], inverse @ push])

    end = 3 * system.period
    run = solve_ivp(
        rates, (0, end), np.zeros(6), "DOP853", rtol=1e-10, atol=1e-13, dense_output=True,
        max_step=end / 3000,
    )  # fmt: skip
    times = np.unique(np.concatenate([np.linspace(0, end, 60001), run.t]))
    states = run.sol(times).T
    pushes = np.array([forces(y)[0] for y in states])
    accelerations = np.array([rates(0.0, y)[3] for y in states])
    accelerations += (force[0] * (np.cos(omega * times) - 1.0)) / M[0, 0]
    assert orbit.impacts["force"][orbit.impacts["damper"] == "a"].max() == pytest.approx(
        pushes.max(), rel=1e-5
    )
    # a sample may miss the jump of a dashpot's force at a touch
    assert orbit.response["x1.a_max"] == pytest.approx(np.abs(accelerations).max(), rel=1e-3)


def balls(e, omega):
    host = nv.Host([[4.0]], [[400.0]], [[2.0]])
    rigid = {"law": "restitution", "e": e}
    dampers = [
        nv.Damper("a", "x1", m=0.3, walls=[nv.Wall(0.02, side, **rigid) for side in "+-"]),
        nv.Damper("b", "x1", m=0.2, walls=[nv.Wall(0.013, **rigid), nv.Wall(0.017, "-", **rigid)]),
    ]
    return nv.System.from_host(host, dampers, force={"x1": 5.0}, omega=omega)


@pytest.mark.parametrize("e", [0.0, 0.3, 0.8])
def test_a_rigid_wall_never_pulls(e):
    """As SciPy, by Poisson's law with complementarity; a ball without a spring is pushed alone."""
    for omega in (6.0, 7.0, 8.0, 9.0, 10.0):
        system = balls(e, omega)
        orbit = nv.simulate(system, 6, quiet=True, tolerance=1e-12)
        state, _ = by_scipy(system, 6)
        found = np.concatenate([orbit.state[::2], orbit.state[1::2]])
        assert found == pytest.approx(state, abs=1e-6 if e == 0.0 else 1e-4), omega


def test_energy_never_rises_in_impacts_on_walls_that_hold():
    """Without a force and dashpots, sections lose energy, whatever the coefficients are."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        host = nv.chain([1.0, 0.7], [30.0, 20.0], dofs=["x", "y"])
        dampers = []
        for name, dof in (("a", "x"), ("b", "x"), ("c", "y")):
            walls = [
                nv.Wall(float(rng.uniform(0, 0.02)), side, law="restitution", e=float(rng.random()))
                for side in "+-"
            ]
            dampers.append(nv.Damper(name, dof, m=float(rng.uniform(0.1, 1.0)), walls=walls))
        system = nv.System.from_host(host, dampers, force={"x": 0.0}, omega=20.0)
        M, _, K, _, _ = matrices_of(system)
        start = np.zeros(10)
        start[1:4:2] = rng.normal(size=2)
        start[5::2] = rng.normal(size=3)
        orbit = nv.simulate(system, 40, start=start, quiet=True)
        x, v = orbit.section[:, ::2], orbit.section[:, 1::2]
        energies = np.einsum("ni,ij,nj->n", v, M, v) + np.einsum("ni,ij,nj->n", x, K, x)
        assert np.all(np.diff(energies) <= 1e-12 * energies[0])
        assert len(orbit.impacts) > 5


@pytest.mark.parametrize("e", [0.0, 0.5, 0.9])
def test_a_wall_that_holds_lets_go_once(e):
    """Gaps below zero press the mass to the wall; beside the kernels of one damper."""
    for gap in np.linspace(-0.5, 0.5, 11):
        for omega in np.linspace(0.5, 2.5, 11):
            system = nv.load_system(
                "impact-oscillator", m=1.0, k=1.0, c=0.2, P=1.0, C=gap, omega=omega, e=e
            )
            host = as_host(system)
            exact = nv.simulate(system, 12, tolerance=1e-12, quiet=True)
            orbit = nv.simulate(host, 12, tolerance=1e-12, quiet=True)
            assert orbit.state[:2] == pytest.approx(exact.state[:2], abs=1e-6), (gap, omega)


LAWS_IN_TOUCH = {
    "hertz": ({"K": 1e6}, 1.5),
    "linear": ({"law": "linear", "kc": 1e4}, 1.0),
    "power 2": ({"law": "power", "K": 1e8, "exponent": 2.0}, 2.0),
    "power 1.3": ({"law": "power", "K": 1e5, "exponent": 1.3}, 1.3),
}


@pytest.mark.parametrize("law", LAWS_IN_TOUCH)
@pytest.mark.parametrize("is_dropped", [False, True])
def test_bodies_that_touch_at_rest_pass_an_impact_on(law, is_dropped):
    """A row with gaps of exactly zero, beside SciPy; the momentum of a free row is kept."""
    wall, exponent = LAWS_IN_TOUCH[law]
    K = wall.get("K", wall.get("kc"))
    for n in (3, 4, 6, 10):
        names = [f"b{i}" for i in range(n)]
        host = nv.Host(np.eye(n), np.zeros((n, n)), dofs=names)
        dampers = [
            nv.Damper(f"c{i}", (names[i], names[i + 1]), walls=[nv.Wall(0.0, **wall)])
            for i in range(n - 1)
        ]
        if is_dropped:  # the last falls on the ground first
            dampers.append(nv.Damper("floor", (names[-1], "ground"), walls=[nv.Wall(0.1, **wall)]))
        system = nv.System.from_host(host, dampers, force={names[0]: 0.0}, omega=2 * math.pi)
        start = np.zeros(2 * n)
        start[1 : None if is_dropped else 2 : 2] = 1.0
        orbit = nv.simulate(system, 1, start=start, quiet=True)

        def rates(t, y, n=n):
            z = np.maximum(y[: n - 1] - y[1:n], 0.0)
            f = np.append(K * z**exponent, K * max(y[n - 1] - 0.1, 0.0) ** exponent)
            if not is_dropped:
                f[-1] = 0.0
            a = -f
            a[1:] += f[:-1]
            return np.concatenate([y[n:], a])

        begun = np.concatenate([start[::2], start[1::2]])
        run = solve_ivp(rates, (0, 1), begun, "DOP853", rtol=1e-11, atol=1e-13, max_step=1e-3)
        found = np.concatenate([orbit.state[::2], orbit.state[1::2]])
        assert found == pytest.approx(run.y[:, -1], abs=1e-6), n
        if not is_dropped:
            assert found[n:].sum() == pytest.approx(1.0, abs=1e-12)


def test_two_rigid_walls_without_clearance_join_their_bodies():
    """A ball in a gap of zero moves with the host, as one mass; beside the exact response."""
    for e in (0.0, 0.5, 1.0):
        walls = [nv.Wall(0.0, side, law="restitution", e=e) for side in "+-"]
        host = nv.Host([[4.0]], [[400.0]], [[2.0]])
        ball = nv.Damper("ball", "x1", m=0.3, walls=walls)
        system = nv.System.from_host(host, [ball], force={"x1": 5.0}, omega=8.0)
        orbit = nv.simulate(system, 12, quiet=True)
        one = nv.System.from_host(
            nv.Host([[4.3]], [[400.0]], [[2.0]]), [], force={"x1": 5.0}, omega=8.0
        )
        joined = nv.simulate(one, 12, quiet=True)
        assert orbit.state[:2] == pytest.approx(joined.state, abs=1e-10)
        assert orbit.state[2:] == pytest.approx(joined.state, abs=1e-10)


@pytest.mark.parametrize("order", [*itertools.permutations(range(3))])
@pytest.mark.parametrize("law", [{"K": 1e6}, {"law": "linear", "kc": 1e4, "cc": 10.0}])
def test_walls_that_are_touched_at_one_instant_touch_no_others(order, law):
    """Beside a wall that holds, and another one on the far side; each system as alone."""
    rigid = {"law": "restitution", "e": 0.7}
    hold = nv.Wall(-0.5, law="restitution", e=0.0)
    parts = [
        ("h", 1.0, 1.0, 0.2, 0.4, {"attached_to": ("h", "ground"), "walls": [hold]}),
        ("x", 10.0, 400.0, 6.0, 40.0, {"m": 2.0, "k": 60.0, "c": 1.0}),
        ("y", 10.0, 400.0, 6.0, 40.0, {"m": 2.0, "k": 60.0, "c": 1.0}),
    ]
    parts[1][-1].update(attached_to="x", walls=[nv.Wall(0.05, **law)])
    walls = [nv.Wall(0.05, **rigid), nv.Wall(0.06, "-", **rigid)]
    parts[2][-1].update(attached_to="y", walls=walls)

    def orbit_of(parts):
        dofs, masses, springs, dashpots, forces, dampers = zip(*parts, strict=True)
        host = nv.Host(np.diag(masses), np.diag(springs), np.diag(dashpots), dofs=dofs)
        named = [nv.Damper(f"on {dof}", **one) for dof, one in zip(dofs, dampers, strict=True)]
        force = dict(zip(dofs, forces, strict=True))
        system = nv.System.from_host(host, named, force=force, omega=5.5)
        start = np.zeros(len(system.scene.components))
        for i, name in enumerate(system.scene.components):
            start[i] = -0.5 if name == "h" else 0.0
        orbit = nv.simulate(system, 2, start=start, tolerance=1e-12, quiet=True)
        state = dict(zip(system.scene.components, orbit.state.tolist(), strict=True))
        return state, orbit.impacts

    together, impacts = orbit_of([parts[i] for i in order])
    touches = impacts["touch"][impacts["touch"] > 0.0]
    assert touches[0] == touches[1]
    assert (impacts["speed"] >= 0.0).all()
    for part in parts:
        alone, own = orbit_of([part])
        assert {name: together[name] for name in alone} == pytest.approx(alone, abs=1e-9)
        assert np.count_nonzero(impacts["damper"] == f"on {part[0]}") == len(own)


PAIRED = [
    {"K": 1e6},
    {"law": "power", "K": 1e5, "exponent": 1.23},
    {"law": "power", "K": 3e5, "exponent": 1.5, "hunt_crossley": 0.5},
    {"law": "linear", "kc": 2e4},
    {"law": "linear", "kc": 2e4, "cc": 40.0},
    {"law": "kelvin-voigt", "kc": 2e4, "cc": 40.0},
    {"law": "restitution", "e": 0.0},
    {"law": "restitution", "e": 0.5},
]


def paired_system(seed):
    """Return a host with two to four dampers, of all pairs of laws in turn, some without a gap."""
    rng = np.random.default_rng([seed, 3])
    first, second = divmod(seed % len(PAIRED) ** 2, len(PAIRED))
    n = int(rng.integers(1, 4))
    frame = nv.shear_frame(
        rng.uniform(50, 150, n),
        rng.uniform(0.5, 1.5, n) * 4e3 * n,
        ratio=float(rng.uniform(0, 0.05)),
    )
    omega = float(frame.frequencies[0] * rng.uniform(0.6, 1.6))
    P = float(rng.uniform(10.0, 40.0))
    response = np.abs(frame.frequency_response(omega, force={"roof": P})).max()
    reach = min(response, 0.05)
    dampers = []
    for j in range(int(rng.integers(2, 5))):
        law = PAIRED[(first, second)[j % 2]]
        gap = 0.0 if rng.random() < 0.2 else float(reach * rng.uniform(0.1, 1.0))
        walls = [nv.Wall(gap, "+", **law)]
        if gap > 0.0 and rng.random() < 0.6:
            walls.append(nv.Wall(float(reach * rng.uniform(0.1, 1.0)), "-", **PAIRED[second]))
        dof = frame.dofs[0] if rng.random() < 0.6 else frame.dofs[-1]  # shared
        if rng.random() < 0.15:
            dampers.append(nv.Damper(f"d{j}", (dof, "ground"), walls=walls))
        else:
            m = float(rng.uniform(2.0, 12.0))
            k = 0.0 if len(walls) > 1 and rng.random() < 0.5 else float(m * rng.uniform(5, 60))
            c = float(0.05 * math.sqrt(m * max(k, 5.0)))
            dampers.append(nv.Damper(f"d{j}", dof, m=m, k=k, c=c, walls=walls))
    return nv.System.from_host(frame, dampers, force={"roof": P}, omega=omega)


@pytest.mark.parametrize("seeds", [range(6), pytest.param(range(6, 200), marks=pytest.mark.long)])
def test_hosts_with_all_pairs_of_laws_move_as_by_scipy(seeds):
    """With shared degrees of freedom, walls that hold, and gaps of zero."""
    touched = 0
    for seed in seeds:
        system = paired_system(seed)
        # at rest in a gap of zero, the events of SciPy are round-off
        start = np.zeros(len(system.scene.components))
        start[1::2] = 0.05 * np.random.default_rng([seed, 4]).normal(size=len(start) // 2)
        orbit = nv.simulate(system, 3, start=start, tolerance=1e-12, quiet=True)
        # ten tolerances at the start, as both methods err along the way, grow to this at the end
        scale = np.abs(orbit.state).max()
        moved = start.copy()  # its velocities, as displacements may lie on walls
        signs = np.random.default_rng([seed, 5]).choice([-1.0, 1.0], len(start) // 2)
        moved[1::2] += 1e-11 * scale * signs
        other = nv.simulate(system, 3, start=moved, tolerance=1e-12, quiet=True)
        state, (_, speeds) = by_scipy(system, 3, 1e-13, start)
        coarse, _ = by_scipy(system, 3, 1e-11, start)
        touched += np.count_nonzero(speeds > 1e-4 * speeds.max(initial=0.0))
        spread = np.abs(orbit.state - other.state).max() + 3 * np.abs(coarse - state).max()
        found = np.concatenate([orbit.state[::2], orbit.state[1::2]])
        assert np.abs(found - state).max() < 5e-9 * scale + spread, seed
        for damper in system.dampers:  # the peaks of forces, too
            for wall in damper.walls:
                own = (orbit.impacts["damper"] == damper.name) & (
                    orbit.impacts["wall"] == wall.side
                )
                impacts = orbit.impacts[own]
                if wall.law in ("hertz", "power") and not wall.is_damped:
                    n = wall.constants.get("exponent", 1.5)
                    elastic = wall.constants["K"] * impacts["depth"] ** n
                    assert impacts["force"] == pytest.approx(elastic, rel=1e-9), seed
    assert touched > 20


def test_derivatives_go_through_impacts_on_walls_that_hold():
    """One damper strikes while the other is held: beside central differences."""
    compared = 0
    for e, omega in ((0.0, 6.0), (0.0, 8.0), (0.3, 7.0), (0.3, 9.0)):
        flow = HostMap(balls(e, omega))
        y = flow(np.zeros(flow.size), 3, False).sections[-1]
        orbit = flow(y, 1)
        scales = flow.scales(orbit.sections)
        walls = flow.orbits.walls
        for c in range(2):
            direction = np.zeros(flow.size)
            direction[c * flow.size // 2] = scales[c * flow.size // 2]  # the host alone
            slope = flow.difference(y, 1, direction, 1e-6) / scales
            growth = np.abs(orbit.matrix * scales / scales[:, None]).max()
            along = orbit.matrix @ direction / scales
            assert (
                np.abs(along - slope).max() < 1e-5 * max(np.abs(along).max(), 1.0) or growth > 1e6
            )
            compared += 1
        assert walls.number == 4
    assert compared == 8
