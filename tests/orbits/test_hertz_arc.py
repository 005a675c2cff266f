"""The constants of short impacts, which strict loops make, beside forty digits."""

import mpmath
import numpy as np
import pytest

from nlds_vines.kernels import impact
from nlds_vines.orbits import hertz_arc as arc
from nlds_vines.orbits.quadrature import gauss_points, gauss_weights, integration_matrix, times

ROUND_OFF = 2.0**-53
NODES = (2, 3, 5, 12, 16, 28)


@pytest.fixture(autouse=True)
def _many_digits():
    with mpmath.workdps(40):
        yield


def true_points(n):
    near = np.polynomial.legendre.leggauss(n)[0]
    return [mpmath.findroot(lambda x: mpmath.legendre(n, x), float(x)) for x in near]


def true_legendre(x, n):
    found = [mpmath.mpf(1), x]
    for k in range(1, n):
        found.append(((2 * k + 1) * x * found[k] - k * found[k - 1]) / (k + 1))
    return found[: n + 1]


def true_integration(n, ends):
    """Return (weights, matrix) of Gauss points, from -1 to each of `ends`."""
    at_points = [true_legendre(x, n) for x in true_points(n)]
    weights = [2 / mpmath.fsum((2 * k + 1) * p[k] ** 2 for k in range(n)) for p in at_points]
    rows = []
    for end in ends:
        e = true_legendre(mpmath.mpf(end), n)
        rest = [mpmath.fsum((e[k + 1] - e[k - 1]) * p[k] for k in range(1, n)) for p in at_points]
        rows.append([w / 2 * (end + 1 + more) for w, more in zip(weights, rest, strict=True)])
    return weights, rows


def error(found, true):
    pairs = zip(np.ravel(found).tolist(), np.ravel(np.array(true, dtype=object)), strict=True)
    return max(float(abs(value - there)) for value, there in pairs)


@pytest.mark.parametrize("n", NODES)
def test_points_weights_and_integrals(n):
    x = gauss_points(n)
    assert error(x, true_points(n)) <= ROUND_OFF
    assert (x == -x[::-1]).all()
    ends = (*true_points(n), mpmath.mpf(0), mpmath.mpf(1))
    weights, matrix = true_integration(n, ends)
    assert error(gauss_weights(x), weights) <= 3 * ROUND_OFF
    assert error(integration_matrix(x, np.array([*x, 0.0, 1.0])), matrix) <= 4 * ROUND_OFF


def test_constants():
    fifth = mpmath.mpf(1) / 5
    assert float(mpmath.beta(fifth, 0.5) / 5) == arc.HALF
    assert float(mpmath.beta(2 * fifth, 1.5) / 5) == arc.LOST
    assert float(mpmath.asinh(1 / mpmath.mpf(arc.STRETCH))) == arc.STEEP
    end = mpmath.mpf(0.5) ** fifth
    assert pytest.approx(float(phase_at(end)), rel=1e-15) == arc.EQUAL


def phase_at(u):
    """Return the phase at which u is reached."""
    return u * mpmath.hyp2f1(0.5, mpmath.mpf(1) / 5, mpmath.mpf(6) / 5, u**5)


def left_at(S):
    """Return the phase from S > 0 to the deepest point."""
    return 0.4 * S * mpmath.hyp2f1(mpmath.mpf(4) / 5, 0.5, 1.5, S * S)


def test_the_arc_to_round_off():
    phi = np.concatenate([np.linspace(1e-9, 2 * arc.HALF, 83), [arc.EQUAL, arc.HALF]])
    u, S = arc.hertz_arc(phi)
    half = mpmath.beta(mpmath.mpf(1) / 5, 0.5) / 5
    for at, mine, speed in zip(phi.tolist(), u.tolist(), S.tolist(), strict=True):
        left = half - abs(at - half)
        # of the functions of u and of S that give the phase, the one that is well conditioned
        if mine < 0.87:
            assert abs(phase_at(mpmath.mpf(mine)) - left) <= 6 * ROUND_OFF
        else:
            assert abs(left_at(abs(mpmath.mpf(speed))) - (half - left)) <= 6 * ROUND_OFF
        assert abs(mpmath.mpf(speed) ** 2 + mpmath.mpf(mine) ** 5 - 1) <= 6 * ROUND_OFF
        assert (speed < 0.0) == (at > arc.HALF)


@pytest.mark.parametrize("n", [2, 12, 28, 64])
def test_the_free_impact_keeps_what_is_known_of_it(n):
    made = arc.make_arc(n)
    u, S, time = (made.table[row : row + n] for row in (impact.U, impact.S, impact.TIME))
    assert np.abs(u - u[::-1]).max() <= 4 * ROUND_OFF
    assert np.abs(S + S[::-1]).max() <= 8 * ROUND_OFF
    assert (np.diff(time) > 0).all()
    assert 0 < time[0] < time[-1] < made.length
    if n >= 28:  # the integral of u over the impact
        length = 2 * mpmath.beta(mpmath.mpf(2) / 5, 0.5) / 5
        assert abs(made.length - length) <= 8 * ROUND_OFF
        assert abs(made.loss_missed) <= 8 * ROUND_OFF


def test_sums_have_an_order():
    matrix = np.array([[1e16, 1.0, -1e16, 1.0], [1.0, 1e16, 1.0, -1e16]])
    assert times(matrix, np.ones(4)).tolist() == [1.0, 0.0]
