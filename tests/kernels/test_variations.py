"""The variational flow: monodromy against differences of the flow, and what is known of it exactly.

A difference quotient of this flow loses an order at every touch (the force is C^1 there), so it
is extrapolated from three steps, of which the last two also say how good it is.
"""

import numpy as np
import pytest
from flights import flow_on
from scipy.linalg import expm
from support import differences, kernel_state, linear_flow, period_map, references, system_of

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.run import Computer
from nlds_vines.engine.simulation import simulate
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.kernels.cells import verdict as course
from nlds_vines.kernels.cells.verdict import mean_and_width
from nlds_vines.kernels.numerics.matrices import eigenvalues, solve, spectral_radius
from nlds_vines.kernels.orbit import variations
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.model.catalog import load_system
from nlds_vines.model.labels import FLAGS
from nlds_vines.scans.block import Block

pytestmark = pytest.mark.kernels

SET6 = references()["ssul-set6"].numbers
SSBL = references()["ssbl-omega6.05"].numbers
FINE = {"exact": Settings(contact_steps=60.0), "rk4": Settings.rk4(8192.0)}
SCALES = np.array([0.05, 0.3, 0.05, 0.3])  # of x1, v1, r, s [m, m/s]: what is small is small beside

both_methods = pytest.mark.parametrize("method", ["exact", "rk4"])


def derivative(flow, y, periods):
    """Return the extrapolated derivative in units of `SCALES`, and how much that moved it."""
    coarse, fine = (
        differences(flow, y, step * np.diag(SCALES), periods) / step / SCALES[:, np.newaxis]
        for step in (4e-6, 2e-6)
    )
    slope = fine + (fine - coarse) / (2**2.5 - 1)
    return slope, np.abs(slope - fine).max()


PRELOADED = {**SET6, "C": -0.2, "K": 1e6, "P": 100.0}
CASES = {
    # system, periods from rest, periods followed, impacts by wall meanwhile
    "an impact a period": (system_of("ssul", SET6), 20, 2, (2, 0)),
    "it ends inside a contact": (system_of("ssul", SET6), 3, 1, (2, 0)),
    "it begins inside a contact": (system_of("ssul", SET6), 4, 1, (1, 0)),
    "a soft wall": (system_of("ssul", {**SET6, "K": 1e4}), 10, 2, None),
    "it rests on the wall": (system_of("ssul", PRELOADED), 60, 2, (0, 0)),
    "it is pressed back soon": (system_of("ssul", {**PRELOADED, "P": 250.0}), 60, 2, (4, 0)),
    "two walls": (system_of("ssbl", SSBL), 20, 1, (1, 1)),
    "no wall": (load_system("tmd"), 3, 2, None),
    "on moving ground": (load_system("ssul-set6", base_acceleration=0.8), 20, 2, (2, 0)),
    "soft on moving ground": (load_system("ssul-set6", base_acceleration=0.8, K=1e4), 10, 2, None),
}


@both_methods
@pytest.mark.parametrize("case", CASES)
def test_monodromy_is_the_derivative_of_the_flow_and_its_determinant_known(case, method):
    """The divergence of the flow is constant, contacts or not."""
    system, before, periods, expected = CASES[case]
    flow, counts = flow_on(system, method, FINE[method]), np.zeros(2, int)
    at = y = kernel_state(system, simulate(system, before).state)
    for _ in range(periods):
        at = period_map(flow, at)[0]
        counts += flow.by_period[0]
    assert expected in (None, tuple(counts))
    matrix = period_map(flow, y, periods)[1]
    volume = np.exp(divergence(system) * periods * system.period)
    assert np.linalg.det(matrix) == pytest.approx(volume, rel=1e-8)
    matrix = matrix * SCALES / SCALES[:, np.newaxis]
    difference, doubt = derivative(flow, y, periods)
    size = np.abs(matrix).max()
    assert np.abs(matrix - difference).max() <= 1e-6 * size
    assert doubt <= 1e-5 * size


def divergence(system):
    """Return the sum of all Lyapunov exponents [1/s]."""
    p = system.parameters
    return -(p["c1"] + p["c2"]) / p["m1"] - p["c2"] / p["m2"]


def test_the_divergences_of_the_named_systems():
    assert divergence(load_system("ssul-set6")) == pytest.approx(-1.349997, abs=1e-6)
    assert divergence(load_system("ssbl")) == pytest.approx(-4.550667, abs=1e-6)
    for name in ("ssul-set6", "ssbl", "tmd"):
        system = load_system(name)
        assert flow_on(system).trace == pytest.approx(divergence(system), rel=1e-14)


RIDES = {
    "short impacts": (load_system("ssul-set6", omega=7.4), "exact"),
    "two walls, sections inside impacts": (load_system("ssbl", omega=6.28), "exact"),
    "a soft wall": (system_of("ssul", {**SET6, "K": 1e4}), "exact"),
    "rk4": (load_system("ssul-set6"), "rk4"),
    "no wall": (load_system("tmd"), "exact"),
}


@pytest.mark.parametrize("case", RIDES)
def test_variations_change_nothing_of_an_orbit(case):
    """To the last bit, what is noted of it included."""
    flow, periods = flow_on(*RIDES[case]), 60
    alone, ridden = variations.new_state(), variations.new_state()
    sections, seen = np.zeros((periods, 4)), np.zeros((periods, 4))
    assert variations.run_on(flow, sections, periods, alone) == OK
    tangent, growth = np.zeros(16), np.zeros(4)
    variations.set_identity(tangent)
    for p in range(periods):
        rows = seen[p : p + 1]
        assert variations.advance_flow(flow, rows, 1, tangent, ridden) == OK
        variations.orthonormalize(tangent, flow.space.size, growth)
    np.testing.assert_array_equal(ridden, alone)
    np.testing.assert_array_equal(seen, sections)


@both_methods
@pytest.mark.parametrize("changes", [{}, {"k2": 215.0, "c2": 232.0}, {"k2": 0.0, "c2": 0.0}])
def test_multipliers_of_a_linear_scene(changes, method):
    system = load_system("tmd", **changes)
    flow = linear_flow(system.parameters)[:4, :4]
    to_kernel = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, 0, -1, 0], [0, 1, 0, -1.0]])
    expected = to_kernel @ expm(flow * system.period) @ np.linalg.inv(to_kernel)
    matrix = period_map(flow_on(system, method), np.zeros(4))[1]
    np.testing.assert_allclose(matrix, expected, rtol=0, atol=1e-12)
    multipliers = np.exp(np.linalg.eigvals(flow) * system.period)
    largest = np.abs(multipliers).max()
    assert spectral_radius(eigenvalues(matrix)) == pytest.approx(
        largest, rel=1e-7 if changes else 1e-12
    )


def test_multipliers_of_the_structure_alone():
    system = load_system("none")
    p = system.parameters
    flow = np.array([[0, 1], [-p["k1"] / p["m1"], -p["c1"] / p["m1"]]])
    kernel = flow_on(system)
    tangent = period_map(kernel, np.zeros(4))[1].T.ravel().copy()
    matrix = variations.matrix_of(tangent, kernel.space.size)
    np.testing.assert_allclose(matrix, expm(flow * system.period), rtol=0, atol=1e-13)


def multiplied(tangent, matrix):
    tangent[:] = (matrix @ tangent.reshape(4, 4).T).T.ravel()


def test_lengths_are_those_of_triangular_matrices_and_add_up_to_determinants():
    """The rates are the logarithms of the diagonals, the greatest first."""
    rng = np.random.default_rng(3)
    frame, expected, growth, tangent = np.eye(4), np.zeros(4), np.zeros(4), np.zeros(16)
    variations.set_identity(tangent)
    for _ in range(50):
        upper = np.triu(rng.normal(size=(4, 4)))
        np.fill_diagonal(upper, 10.0 ** (np.array([3, 1, -1, -3]) + rng.uniform(0, 1, 4)))
        other = np.linalg.qr(rng.normal(size=(4, 4)))[0]
        multiplied(tangent, other @ upper @ frame.T)
        variations.orthonormalize(tangent, 4, growth)
        frame, expected = other, expected + np.log(np.diag(upper))
        vectors = tangent.reshape(4, 4)
        np.testing.assert_allclose(vectors @ vectors.T, np.eye(4), rtol=0, atol=1e-14)
    np.testing.assert_allclose(growth, expected, rtol=1e-10)
    # lengths add up to determinants
    rng = np.random.default_rng(4)
    growth, tangent, expected = np.zeros(4), np.zeros(16), 0.0
    variations.set_identity(tangent)
    for _ in range(200):
        matrix = rng.normal(size=(4, 4))
        expected += np.linalg.slogdet(matrix)[1]
        multiplied(tangent, matrix)
        variations.orthonormalize(tangent, 4, growth)
    assert growth.sum() == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize(
    ("name", "changes", "together"),
    [
        ("ssul-set6", {"omega": 7.4}, 4),
        ("ssul-set6", {"omega": 7.4, "c2": 150.0}, 2),
        ("ssul-set6", {"omega": 7.4, "c2": 300.0}, 1),
    ],
)
def test_growth_is_the_same_however_often_variations_are_projected(name, changes, together):
    """Along chaos too: the orbit is the same, and no batch of the logarithms notices."""
    flow, periods = flow_on(load_system(name, **changes)), 1030  # not a multiple of 4
    state, tangent = variations.new_state(), np.zeros(16)
    logs, growth, seen = np.zeros(periods), np.zeros(4), np.zeros((periods, 4))
    variations.place_state(flow, np.zeros(4), state)
    variations.set_identity(tangent)
    assert course.follow_growth(flow, seen, state, tangent, logs, growth) == OK
    assert len(np.unique(logs[:together])) == 1
    assert len(np.unique(logs[: together + 1])) == 2
    each, growth_once, sections = np.zeros(periods), np.zeros(4), np.zeros((periods, 4))
    variations.place_state(flow, np.zeros(4), state)
    variations.set_identity(tangent)
    for p in range(periods):
        before = growth_once[0]
        assert variations.advance_flow(flow, sections[p : p + 1], 1, tangent, state) == OK
        variations.orthonormalize(tangent, 4, growth_once)
        each[p] = growth_once[0] - before
    np.testing.assert_array_equal(seen, sections)
    np.testing.assert_allclose(growth, growth_once, rtol=0, atol=1e-7 * periods)
    assert logs.sum() == pytest.approx(growth_once[0], abs=1e-9 * periods)
    (mean, width), (other, breadth) = mean_and_width(logs), mean_and_width(each)
    assert abs(mean - other) < 0.1 * breadth
    assert width == pytest.approx(breadth, rel=0.2, abs=0.01)


def test_multipliers_and_exponents_of_every_labeled_orbit():
    want = ["energy", "regime", "lyapunov", "evidence"]  # with energies: kernels of many tests
    scan = load_scan(None, {"record": {"want": want}})
    request = Computer(scan).block(Block(0, ((0, scan.lanes),)))
    omega, n = scan.axes[0].values, request["periodicity"][:, 0]
    periodic = n > 0
    assert periodic.mean() > 0.9
    trace = divergence(scan.system)
    multipliers = request["multipliers"][:, 0] @ [1, 1j]
    expected = trace * n * 2 * np.pi / omega
    # the matrix of a longer orbit holds no smaller product
    resolved = periodic & (expected > -18.0)
    assert 0.98 * periodic.sum() < resolved.sum() < periodic.sum()
    product = multipliers[resolved].prod(axis=-1)
    assert np.abs(product / np.exp(expected[resolved]) - 1).max() <= 1e-8
    total = request["exponents"][:, 0].sum(axis=-1)
    assert np.isfinite(total).all()
    np.testing.assert_allclose(total, trace, rtol=0, atol=1e-8)
    largest = request["exponents"][periodic, 0, 0]
    np.testing.assert_allclose(largest, request["lyapunov"][periodic, 0], rtol=0, atol=1e-6)
    stable = request["regime"][:, 0] == FLAGS["periodic"]
    assert (np.abs(multipliers[stable]) < 1).all()


@pytest.mark.parametrize("size", [2, 4])
def test_elimination(size):
    rng = np.random.default_rng(size)
    for i in range(20):
        matrix, right = rng.normal(size=(size, size)), rng.normal(size=(4, 3))
        matrix[0, 0] = 1e-20 * (i % 2)  # as a pivot it would leave no digit
        expected = np.linalg.solve(matrix, right[:size])
        determinant = solve(matrix.copy(), right)
        assert determinant == pytest.approx(np.linalg.det(matrix), rel=1e-12)
        np.testing.assert_allclose(right[:size], expected, rtol=1e-9)
    assert not solve(np.zeros((size, size)), np.ones((4, 1)))
    assert not solve(np.full((size, size), np.nan), np.ones((4, 1)))


def test_a_wrong_monodromy_is_seen():
    """The comparison with the flow tells a stepped contact's stiffness off by one per cent."""
    system, before, periods, _ = CASES["a soft wall"]
    flow = flow_on(system, "exact", FINE["exact"])
    y = kernel_state(system, simulate(system, before).state)
    matrix = period_map(flow, y, periods)[1] * SCALES / SCALES[:, np.newaxis]
    wall = flow.prepared.near
    harder = flow.prepared._replace(near=wall._replace(K=1.01 * wall.K))
    stiffer = flow._replace(prepared=harder)
    other = period_map(stiffer, y, periods)[1] * SCALES / SCALES[:, np.newaxis]
    assert np.abs(other - matrix).max() > 1e-4 * np.abs(matrix).max()
