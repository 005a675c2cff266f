"""The kernels' own eigenvalues, beside those of LAPACK."""

import mpmath
import numpy as np
import pytest

from nlds_vines.kernels.numerics.matrices import LOG, eigenvalues, fill_multipliers, spectral_radius

ROUND_OFF = 2.0**-52
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


@pytest.mark.parametrize("n", [1, 2, 3, 4])
@pytest.mark.parametrize("kind", KINDS)
def test_each_value_makes_the_matrix_singular_to_round_off(kind, n):
    generator = np.random.default_rng(n)
    for _ in range(100):
        matrix = matrix_of(kind, n, generator)
        size = max(np.linalg.norm(matrix), 1e-300)
        values = complex_of(eigenvalues(matrix))
        for value in values:
            least = np.linalg.svd((matrix - value * np.eye(n)) / size, compute_uv=False)[-1]
            assert least <= 10 * ROUND_OFF
        assert abs(values.sum() - np.trace(matrix)) <= 20 * ROUND_OFF * size
        moduli = np.abs(values)
        assert (moduli[:-1] >= moduli[1:] * (1 - ROUND_OFF)).all()
        for i in np.flatnonzero(values.imag > 0):
            assert values[i + 1] == values[i].conjugate()
        assert spectral_radius(eigenvalues(matrix)) == pytest.approx(moduli[0], rel=4 * ROUND_OFF)


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


def test_turns_without_growth_come_in_pairs():
    quarter = np.roll(np.eye(4), 1, axis=0)  # its double shifts of the usual kind go in a circle
    values = complex_of(eigenvalues(quarter))
    np.testing.assert_allclose(np.sort_complex(values), [-1, -1j, 1j, 1], atol=1e-15)
    assert spectral_radius(eigenvalues(np.array([[0.0, -0.25], [1.0, 0.0]]))) == 0.5


def test_zero_and_what_is_not_finite():
    assert not eigenvalues(np.zeros((4, 4))).any()
    assert spectral_radius(eigenvalues(np.zeros((2, 2)))) == 0.0
    for bad in (np.nan, np.inf):
        matrix = np.eye(4)
        matrix[2, 1] = bad
        assert np.isnan(eigenvalues(matrix)).all()
        assert spectral_radius(eigenvalues(matrix)) == np.inf


def test_logarithms_of_many():
    matrices = np.array([np.diag([0.5, 0.0]), np.diag([np.nan, 1.0])])
    logarithms = np.zeros((2, 2, 3))
    fill_multipliers(matrices, logarithms)
    assert logarithms[0, :, LOG].tolist() == [np.log(0.5), -np.inf]
    assert np.isnan(logarithms[1]).all()
