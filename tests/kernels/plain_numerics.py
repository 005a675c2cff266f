"""Eigenvalues beside LAPACK, and the constants of short impacts beside forty digits."""

import mpmath
import numpy as np
import pytest

from nlds_vines.kernels.impact import arc, impact
from nlds_vines.kernels.numerics.matrices import LOG, eigenvalues, fill_multipliers, spectral_radius

SPACING = 2.0**-52
KINDS = ("plain", "unlike", "rank one", "graded", "whole", "sparse", "triangular", "defective")
SCALES = (1.0, 1e-300, 1e-150, 1e200, 1e307)


def matrix_of(kind, n, generator):
    plain = generator.standard_normal((n, n))
    if kind == "unlike":
        return plain * 10 ** generator.uniform(-8, 8, (n, n))
    if kind == "rank one":
        return np.outer(plain[0], plain[-1])
    if kind == "graded":  # as the matrix of an orbit that draws others to it strongly
        turned = np.linalg.qr(plain)[0]
        return turned @ np.diag(10.0 ** generator.uniform(-12, 0, n)) @ turned.T
    if kind == "whole":
        return np.round(plain)
    if kind == "sparse":
        return plain * (generator.random((n, n)) < 0.4)
    if kind == "triangular":
        return np.triu(plain)
    if kind == "defective":  # the critical damper: one eigenvector for two multipliers or four
        turned = np.linalg.qr(plain)[0]
        return turned @ (0.5 * np.eye(n) + np.eye(n, k=1)) @ turned.T
    return plain


def complex_of(pairs):
    return pairs[:, 0] + 1j * pairs[:, 1]


@pytest.mark.parametrize("n", [1, 2, 3, 4, 7, 16])
@pytest.mark.parametrize("kind", KINDS)
def test_each_value_makes_the_matrix_singular_to_round_off(kind, n):
    generator = np.random.default_rng(n)
    for _ in range(25 if n <= 4 else 2):
        matrix = matrix_of(kind, n, generator)
        size = max(np.linalg.norm(matrix), 1e-300)
        values = complex_of(eigenvalues(matrix))
        for value in values:
            least = np.linalg.svd((matrix - value * np.eye(n)) / size, compute_uv=False)[-1]
            assert least <= 10 * SPACING
        assert abs(values.sum() - np.trace(matrix)) <= 20 * SPACING * size
        moduli = np.abs(values)
        assert (moduli[:-1] >= moduli[1:] * (1 - SPACING)).all()
        for i in np.flatnonzero(values.imag > 0):
            assert values[i + 1] == values[i].conjugate()
        assert spectral_radius(eigenvalues(matrix)) == pytest.approx(moduli[0], rel=4 * SPACING)


@pytest.mark.parametrize("kind", ["plain", "graded", "unlike"])
def test_values_are_as_near_to_the_true_ones_as_those_of_lapack(kind):
    generator = np.random.default_rng(9)
    ours, theirs = [], []
    with mpmath.workdps(40):
        for _ in range(60):
            matrix = matrix_of(kind, 4, generator)
            true = list(mpmath.eig(mpmath.matrix(matrix.tolist()), left=False, right=False))
            for errors, values in (
                (ours, complex_of(eigenvalues(matrix))),
                (theirs, np.linalg.eigvals(matrix)),
            ):
                apart = [min(float(abs(v - t)) for t in true) for v in values.tolist()]
                errors.append(max(apart) / np.abs(matrix).max())
    assert np.median(ours) <= 2.0 * np.median(theirs)
    assert max(ours) <= 4.0 * max(theirs)


@pytest.mark.parametrize("scale", SCALES)
def test_scale_does_not_matter(scale):
    exponent = int(np.log2(scale))
    for kind in ("plain", "rank one", "whole"):
        matrix = matrix_of(kind, 4, np.random.default_rng(1))
        scaled = np.ldexp(eigenvalues(matrix), exponent)
        multipliers = eigenvalues(np.ldexp(matrix, exponent))
        np.testing.assert_allclose(multipliers, scaled, rtol=1e-13, atol=5e-324)


def test_special_matrices():
    # turns without growth come in pairs
    quarter = np.roll(np.eye(4), 1, axis=0)  # its double shifts of the usual kind go in a circle
    values = complex_of(eigenvalues(quarter))
    np.testing.assert_allclose(np.sort_complex(values), [-1, -1j, 1j, 1], atol=1e-15)
    assert spectral_radius(eigenvalues(np.array([[0.0, -0.25], [1.0, 0.0]]))) == 0.5
    # zero, and what is not finite
    assert not eigenvalues(np.zeros((4, 4))).any()
    assert spectral_radius(eigenvalues(np.zeros((2, 2)))) == 0.0
    for bad in (np.nan, np.inf):
        matrix = np.eye(4)
        matrix[2, 1] = bad
        assert np.isnan(eigenvalues(matrix)).all()
        assert spectral_radius(eigenvalues(matrix)) == np.inf
    # logarithms of many
    matrices = np.array([np.diag([0.5, 0.0]), np.diag([np.nan, 1.0])])
    logarithms = np.zeros((2, 2, 3))
    fill_multipliers(matrices, logarithms)
    assert logarithms[0, :, LOG].tolist() == [np.log(0.5), -np.inf]
    assert np.isnan(logarithms[1]).all()


ROUND_OFF = 2.0**-53
ROWS, LEVEL = arc.NODES, arc.LEVEL
LENGTH = 2 * mpmath.beta(mpmath.mpf(2) / 5, 0.5) / 5  # integral of u over the impact
LOST = mpmath.beta(mpmath.mpf(2) / 5, 1.5) / 5  # what a unit of drag takes from b


@pytest.fixture(autouse=True)
def _many_digits():
    with mpmath.workdps(40):
        yield


def error(computed, true):
    pairs = zip(np.ravel(computed).tolist(), np.ravel(np.array(true, dtype=object)), strict=True)
    return max(float(abs(value - there)) for value, there in pairs)


def legendre(x, n):
    return [mpmath.legendre(k, x) for k in range(n + 1)]


@pytest.mark.parametrize("n", [2, 3, 5, 12, 16, 28])
def test_points_weights_and_integrals(n):
    """Weights, and integrals from -1 to each point and end, as sums of Legendre polynomials."""
    x, near = arc.gauss_points(n), np.polynomial.legendre.leggauss(n)[0].tolist()
    points = [mpmath.findroot(lambda x: mpmath.legendre(n, x), place) for place in near]
    assert error(x, points) <= ROUND_OFF
    assert (x == -x[::-1]).all()
    at_points = [legendre(point, n) for point in points]
    weights = [2 / mpmath.fsum((2 * k + 1) * p[k] ** 2 for k in range(n)) for p in at_points]
    assert error(arc.gauss_weights(x), weights) <= 3 * ROUND_OFF
    rows = []
    for end in (*points, 0, 1):
        e = legendre(end, n)
        rest = [mpmath.fsum((e[k + 1] - e[k - 1]) * p[k] for k in range(1, n)) for p in at_points]
        rows.append([w / 2 * (end + 1 + sum) for w, sum in zip(weights, rest, strict=True)])
    assert error(arc.integration_matrix(x, np.array([*x, 0.0, 1.0])), rows) <= 4 * ROUND_OFF


def test_constants():
    fifth = mpmath.mpf(1) / 5
    assert float(mpmath.beta(fifth, 0.5) / 5) == arc.HALF_ARC
    assert float(LENGTH) == impact.LENGTH
    assert float(mpmath.asinh(1 / mpmath.mpf(arc.MAP_STRETCH))) == arc.MAP_RATE
    end = mpmath.mpf(0.5) ** fifth
    assert pytest.approx(float(phase_at(end)), rel=1e-15) == arc.EQUAL


def phase_at(u):
    return u * mpmath.hyp2f1(0.5, mpmath.mpf(1) / 5, mpmath.mpf(6) / 5, u**5)


def test_the_arc_to_round_off():
    phi = np.concatenate([np.linspace(1e-9, 2 * arc.HALF_ARC, 83), [arc.EQUAL, arc.HALF_ARC]])
    u, S = arc.hertz_arc(phi)
    half = mpmath.beta(mpmath.mpf(1) / 5, 0.5) / 5
    for at, mine, speed in zip(phi.tolist(), u.tolist(), S.tolist(), strict=True):
        left = half - abs(at - half)
        # of the functions of u and of S that give the phase, the one that is well conditioned
        if mine < 0.87:
            assert abs(phase_at(mpmath.mpf(mine)) - left) <= 6 * ROUND_OFF
        else:
            s = abs(mpmath.mpf(speed))
            gone = 0.4 * s * mpmath.hyp2f1(mpmath.mpf(4) / 5, 0.5, 1.5, s * s)
            assert abs(gone - (half - left)) <= 6 * ROUND_OFF
        assert abs(mpmath.mpf(speed) ** 2 + mpmath.mpf(mine) ** 5 - 1) <= 6 * ROUND_OFF
        assert (speed < 0.0) == (at > arc.HALF_ARC)


def rows_of(n, part=LEVEL.whole):
    """Return a reader of the rows of an arc of n nodes, and what the nodes miss."""
    nodes = impact.nodes_of(arc.make_arc(nodes=n), 0, part)
    assert nodes.n == n <= nodes.m == -(-n // 4) * 4 < n + 4
    after = nodes.at + (ROWS.matrix + n) * nodes.m
    wide = nodes.w[nodes.at : after].reshape(-1, nodes.m)
    assert not wide[:, n:].any()
    missed = nodes.w[after : after + 3 * arc.MISSED].reshape(3, -1).T
    return wide[:, :n], missed


@pytest.mark.parametrize("n", [2, 3, 4, 5, 8, 12, 16, 20, 24, 28, 60])
@pytest.mark.parametrize("part", [1, 2], ids=["whole", "half"])
def test_the_free_impact_keeps_what_is_known_of_it(n, part):
    """Notices: an arc that is not its own mirror image; a sum over nodes without what it misses."""
    rows, missed = rows_of(n, LEVEL.whole if part == 1 else LEVEL.half)
    u, S, weight, time = (rows[k] for k in (ROWS.u, ROWS.s, ROWS.weight, ROWS.t))
    assert (np.diff(time) > 0).all()
    assert 0 < time[0] < time[-1] < LENGTH / part
    force, drag = 1, 2  # places of terms; columns: of b, of time
    work = 0.25 if part == 2 else 0.0  # integral of u u' / 2 to the deepest point, or to the end
    assert abs(weight @ u + missed[0, 1] - LENGTH / part) <= 8 * ROUND_OFF
    assert abs(missed[drag, 0] - weight @ (u * S * S) / 2 + LOST / part) <= 8 * ROUND_OFF
    assert abs(weight @ (u * S) / 2 + missed[force, 0] - work) <= 4 * part * ROUND_OFF
    if part == 1:
        assert np.abs(u - u[::-1]).max() <= 4 * ROUND_OFF
        assert np.abs(S + S[::-1]).max() <= 8 * ROUND_OFF
    else:
        assert (np.diff(u) > 0).all()
        assert (np.diff(S) < 0).all()
    if n >= 28:
        assert np.abs(missed).max() <= 256 / part**2 * ROUND_OFF
        assert part == 2 or np.abs(missed[:3, :2]).max() <= 16 * ROUND_OFF


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_every_choice_of_a_tolerance_is_the_arc_of_so_many_nodes(tolerance):
    """Notices: a level that begins at another's place, errors of other nodes."""
    made, choices = arc.make_arc(tolerance), arc.choices_for(tolerance)
    assert made.levels == len(choices) == len(arc.CHOICES) - (tolerance < arc.COARSE)
    for level, (n, errors) in enumerate(choices.items()):
        row = arc.ARC.levels + arc.LEVEL_ROW * level
        assert tuple(made.table[[row + LEVEL.error, row + LEVEL.half_error]]) == errors
        for part in (LEVEL.whole, LEVEL.half):
            nodes = impact.nodes_of(made, level, part)
            assert nodes.n == n
            long = (ROWS.matrix + n) * nodes.m + 3 * arc.MISSED
            rows, missed = rows_of(n, part)
            weights = nodes.w[nodes.at : nodes.at + long]
            end = (ROWS.matrix + n) * nodes.m
            np.testing.assert_array_equal(weights[:end].reshape(-1, nodes.m)[:, :n], rows)
            np.testing.assert_allclose(weights[end:], missed.T.ravel(), rtol=0, atol=64 * ROUND_OFF)


def test_what_an_arc_takes():
    for n in (1, 61, 0, -3):
        with pytest.raises(ValueError, match=f"nodes = {n}: an arc takes 2 to 60 colloc"):
            arc.make_arc(nodes=n)
    assert arc.make_arc(1e-9).tolerance == arc.make_arc().tolerance == 1e-9
    assert arc.make_arc(1e-6).settled == 1e-6 * arc.SETTLED
    one, other = arc.make_arc(1e-6), arc.make_arc(1e-6)
    assert one.table is not other.table  # scratch of its own
    np.testing.assert_array_equal(one.table, other.table)


def test_sums_have_an_order():
    matrix = np.array([[1e16, 1.0, -1e16, 1.0], [1.0, 1e16, 1.0, -1e16]])
    assert arc.matrix_times(matrix, np.ones(4)).tolist() == [1.0, 0.0]
