"""Verdicts on hosts: the labels and the evidence of kinds, twins, mirrors and several dampers."""

import numpy as np
import pytest
from support import as_host
from test_hosts import matrices_of, random_system

import nlds_vines as nv
from nlds_vines.errors import RequestError

pytestmark = pytest.mark.kernels

SET6 = "ssul-set6"


def judged(name, **changes):
    """Return the verdict on a named system of one damper, as a host."""
    return nv.classify(as_host(nv.load_system(name, **changes)), quiet=True)


@pytest.mark.parametrize(
    ("omega", "label"),
    [(7.364, "2T,2"), (7.45, "3T,2"), (7.95, "T,0")],
)
def test_a_host_of_one_degree_of_freedom_has_the_evidence_of_a_kind(omega, label):
    system = nv.load_system(SET6, omega=omega)
    kind, host = nv.classify(system, tolerance=1e-12, quiet=True), judged(SET6, omega=omega)
    assert (kind.label, host.label, host.period) == (label, label, kind.period)
    assert host.impacts_by_wall == {"u+": kind.impacts}
    assert host.residual < 1e-12
    np.testing.assert_allclose(host.multipliers, kind.multipliers, rtol=0, atol=1e-9)
    np.testing.assert_allclose(host.exponents, kind.exponents, rtol=1e-8)
    assert host.lyapunov == pytest.approx(kind.lyapunov, rel=1e-8)
    if host.impacts:
        assert host.softest == pytest.approx(kind.softest, rel=1e-8)
    # the point is one of the orbit's: the kind's u counts from the unstretched spring
    orbit = nv.simulate(system, host.period, start=kind.point, tolerance=1e-12, quiet=True)
    off = np.abs(orbit.section - [0, 0, system.rest, 0] - host.point).max(axis=1).min()
    assert off < 1e-8
    again = nv.classify(host.system, start=host.point, transient=0, quiet=True)
    assert (again.label, again.settling) == (label, 0)


# label, moduli of multipliers and impacts by wall of `nv.classify` on kinds, at tolerance 1e-12
OF_KINDS = [
    (SET6, {"omega": 6.28, "hunt_crossley": 20.0}, "T,1",
     [0.63021681, 0.591431471, 0.0309416863, 0.00448478235], (1,)),
    (SET6, {"omega": 6.28, "law": "power", "K": 3e5, "exponent": 1.7}, "T,1",
     [0.765894647, 0.765894647, 0.664560043, 0.664560043], (1,)),
    (SET6, {"omega": 6.28, "law": "linear", "kc": 1e6, "cc": 3e3}, "T,1",
     [0.597608679, 0.597608679, 0.488543054, 0.488543054], (1,)),
    (SET6, {"omega": 6.28, "law": "kelvin-voigt", "kc": 1e6, "cc": 3e3}, "T,1",
     [0.574522076, 0.574522076, 0.468321373, 0.468321373], (1,)),
    (SET6, {"omega": 6.28, "law": "restitution", "e": 0.7}, "T,1",
     [0.666904715, 0.666904715, 0.534241366, 0.534241366], (1,)),
    (SET6, {"omega": 2.28, "law": "restitution", "e": 0.5, "P": 3000.0}, "T,1",
     [0.381254341, 0.381254341, 0.204128094, 0.204128094], (1,)),
    ("ssbl", {"omega": 6.28}, "21T,33",
     [0.393093039, 0.0110044853, 1.4444318e-11, 6.43895425e-19], (18, 15)),
    ("impact-oscillator", {"P": 12.6, "omega": 0.35, "e": 0.3}, "T,10", [0.0, 0.0], (10,)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "changes", "label", "moduli", "impacts"), OF_KINDS)
def test_hosts_of_all_laws_have_the_multipliers_of_kinds(name, changes, label, moduli, impacts):
    """Beyond round-off: those below 1e-9 are growth over the cycle."""
    regime = judged(name, **changes)
    assert regime.label == label
    assert tuple(regime.impacts_by_wall.values()) == impacts
    np.testing.assert_allclose(np.abs(regime.multipliers), moduli, rtol=0, atol=1e-7)
    with np.errstate(divide="ignore"):
        exponents = np.log(moduli) / (regime.period * regime.system.period)
    is_resolved = np.array(moduli) > 1e-6
    np.testing.assert_allclose(regime.exponents[is_resolved], exponents[is_resolved], rtol=2e-5)
    if label == "21T,33":
        # of the kind, by the growth over its cycle
        exact = [-0.04443979, -0.21462696, -1.18800319, -3.10359672]
        np.testing.assert_allclose(regime.exponents, exact, rtol=1e-4)


def test_motions_of_a_host_without_a_period():
    chaos = judged(SET6, omega=7.4, K=2.5e7)
    assert chaos.label == "chaos"
    assert 0.0 < chaos.lyapunov - chaos.lyapunov_width < chaos.lyapunov < 0.06
    assert chaos.exponents.sum() == pytest.approx(-1.3499966666666667, abs=1e-8)
    assert chaos.multipliers is None
    assert (chaos.impacts, {*chaos.impacts_by_wall.values()}) == (-1, {-1})
    assert chaos.impact_rate > 0.0
    passing = judged(SET6, omega=7.572, K=2.5e7)
    assert passing.label == "transient chaos to T,0"
    assert passing.settling > 50
    assert passing.transient_lyapunov - passing.transient_lyapunov_width > 0.0
    torus = judged("ssbl", omega=7.5, c2=5.0)
    assert torus.label == "quasiperiodic"
    assert abs(torus.lyapunov) < torus.lyapunov_width
    assert torus.averaging > 7.0


def twins(system):
    """Return two equal copies of a system of one damper, without a joint, as one host."""
    m1, k1, c1 = system.structure
    (damper,) = as_host(system).dampers
    host = nv.Host(m1 * np.eye(2), k1 * np.eye(2), c1 * np.eye(2), dofs=["x", "y"])
    dampers = [
        nv.Damper(name, dof, m=damper.m, k=damper.k, c=damper.c, walls=damper.walls)
        for name, dof in (("a", "x"), ("b", "y"))
    ]
    force = {"x": system.force, "y": system.force}
    return nv.System.from_host(host, dampers, force=force, omega=system.parameters["omega"])


def test_two_equal_systems_side_by_side_have_each_multiplier_twice():
    for omega, label in ((6.28, "T,2 (1+1)"), (7.45, "3T,4 (2+2)"), (7.95, "T,0")):
        system = nv.load_system(SET6, omega=omega)
        one, both = nv.classify(system, quiet=True), nv.classify(twins(system), quiet=True)
        assert both.label == label
        assert both.multipliers.size == 8
        moduli = np.sort(np.abs(both.multipliers))
        np.testing.assert_allclose(
            moduli, np.sort(np.repeat(np.abs(one.multipliers), 2)), rtol=1e-6
        )
        assert both.impacts_by_wall == {"a+": one.impacts, "b+": one.impacts}


@pytest.mark.parametrize(("omega", "e"), [(6.28, 0.7), (6.28, 0.3), (5.5, 0.5), (7.3, 0.8)])
def test_two_equal_rigid_systems_side_by_side_have_each_multiplier_twice(omega, e):
    """All their impacts are at one instant each."""
    system = nv.load_system(SET6, omega=omega, law="restitution", e=e)
    one = nv.classify(as_host(system), quiet=True)
    both = nv.classify(twins(system), quiet=True)
    assert one.kind == both.kind == "periodic"
    assert both.period == one.period
    assert both.impacts_by_wall == {"a+": one.impacts, "b+": one.impacts}
    assert one.impacts > 0
    moduli = np.sort(np.repeat(np.abs(one.multipliers), 2))
    np.testing.assert_allclose(np.sort(np.abs(both.multipliers)), moduli, rtol=1e-7)


def test_an_orbit_that_depends_on_the_order_of_its_impacts_is_undetermined():
    """Two equal dampers on one mass: any displacement of one leads away from the joint motion."""
    wall = nv.Wall(0.02, law="restitution", e=0.7)
    pair = [nv.Damper(name, "x1", m=0.2, k=16.0, c=0.1, walls=[wall]) for name in "ab"]
    host = nv.Host([[4.0]], [[400.0]], [[2.0]])
    system = nv.System.from_host(host, pair, force={"x1": 5.0}, omega=8.0)
    regime = nv.classify(system, quiet=True)
    assert (regime.label, regime.multipliers) == ("undetermined", None)
    assert np.isnan([regime.lyapunov, *regime.exponents]).all()
    assert "order" in str(regime)
    assert "order" in str(regime.lyapunov_spectrum(16, quiet=True))
    after = nv.simulate(system, 1, start=regime.state, quiet=True).state
    for h in (1e-6, 1e-12):
        start = regime.state.copy()
        start[2] += h
        other = nv.simulate(system, 1, start=start, quiet=True).state
        assert np.abs(other - after).max() == pytest.approx(0.041592, rel=1e-3)


def test_chaos_of_one_of_two_dampers_is_chaos_of_the_host():
    system = nv.load_system(SET6, omega=7.4, K=2.5e7)
    regime = nv.classify(twins(system), quiet=True)
    assert regime.label == "chaos"
    assert regime.exponents[1] > 0.0
    one = nv.classify(system, tolerance=1e-12, quiet=True)
    assert regime.lyapunov == pytest.approx(one.lyapunov, abs=one.lyapunov_width)
    assert np.isnan(regime.exponents).tolist() == [False] * 4 + [True] * 4


def test_a_motion_that_symmetry_leaves_at_rest_is_round_off_and_no_obstacle():
    """Three equal masses pushed in the middle: the outer ones move alike, but for round-off."""
    K = 4e4 * np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 2]])
    host = nv.Host(100 * np.eye(3), K, ratio=0.02, dofs=["a", "b", "c"])
    wall = nv.Wall(0.01, law="restitution", e=0.7)
    cell = nv.Damper("cell", "b", m=5.0, k=700.0, c=5.0, walls=[wall])
    system = nv.System.from_host(host, [cell], force={"b": 80.0}, omega=15.0)
    regime = nv.classify(system, transient=300, quiet=True)
    a, _, c = regime.point[:6:2]
    assert regime.kind == "periodic"
    assert regime.impacts > 0
    assert abs(a - c) < 1e-9 * abs(a)


def test_a_free_linear_host_has_the_multipliers_of_its_eigenvalues():
    frame = nv.shear_frame([1e4, 9e3, 8e3], [8e6, 7e6, 6e6], ratio=0.02)
    system = nv.System.from_host(frame, [], force={"roof": 1e3}, omega=14.0)
    regime = nv.classify(system, quiet=True)
    assert regime.label == "T,0"
    A = np.block(
        [
            [np.zeros((3, 3)), np.eye(3)],
            [-np.linalg.solve(frame.M, frame.K), -np.linalg.solve(frame.M, frame.C)],
        ]
    )
    exact = np.exp(np.linalg.eigvals(A) * system.period)
    np.testing.assert_allclose(
        np.sort(np.abs(regime.multipliers)), np.sort(np.abs(exact)), rtol=1e-9
    )
    response = frame.frequency_response(14.0, force={"roof": 1e3})
    np.testing.assert_allclose(regime.point[::2], response.real, rtol=1e-9)


@pytest.mark.parametrize(("seed", "label"), [(0, "2T,9 (4+3+2)"), (1, "T,1 (1+0+0)"), (11, "T,1")])
def test_the_evidence_of_random_hosts_is_that_of_their_orbits(seed, label):
    """Closing orbits, the divergence of the flow, and multipliers beside differences of orbits."""
    system = random_system(seed)
    regime = nv.classify(system, transient=800, tolerance=1e-12, quiet=True)
    assert regime.label == label

    def image(point):
        return nv.simulate(system, regime.period, start=point, tolerance=1e-12, quiet=True).state

    size, scale = len(regime.point), np.abs(regime.point)
    assert np.abs(image(regime.point) - regime.point).max() < 1e-12 * scale.max()
    M, C, *_ = matrices_of(system)
    divergence = -np.trace(np.linalg.solve(M, C))
    walls = [wall for damper in system.dampers for wall in damper.walls]
    is_dissipating = any(wall.is_damped or wall.law not in ("hertz", "power") for wall in walls)
    missing = divergence - regime.exponents.sum()
    assert missing > 0.01 if is_dissipating else abs(missing) < 1e-6 * abs(divergence)
    if size > 12:
        return
    slopes = []
    for h in (4e-6, 2e-6):
        sides = [
            [image(regime.point + sign * h * scale[i] * np.eye(size)[i]) for i in range(size)]
            for sign in (1, -1)
        ]
        slopes.append((np.array(sides[0]) - sides[1]).T / (2 * h * scale))
    matrix = slopes[1] + (slopes[1] - slopes[0]) / (2**2.5 - 1)
    moduli = np.sort(np.abs(np.linalg.eigvals(matrix)))
    np.testing.assert_allclose(moduli, np.sort(np.abs(regime.multipliers)), rtol=0, atol=1e-6)


def test_refusals_of_hosts():
    system = as_host(nv.load_system(SET6, omega=6.28))
    with pytest.raises(RequestError, match="method"):
        nv.classify(system, method="rk4")
    with pytest.raises(RequestError, match="start"):
        nv.classify(system, start=[0.0])
