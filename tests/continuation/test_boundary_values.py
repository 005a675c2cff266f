"""SciPy's `solve_bvp` finds a branch's special points too, from the equation of motion alone."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks import boundary_values
from benchmarks.boundary_values import OFF_VALUE, SOFT, Motion, own_points, solve

TOLERANCE = 1e-8  # of the residual, which the mesh follows; the parameter then agrees to 2e-12
AGREE = 1e-10


@pytest.fixture(scope="module")
def points():
    return own_points()[0]


@pytest.mark.kernels
@pytest.mark.parametrize("kind", ["LP", "PD", "NS"])
def test_special_points_are_found_again_and_elsewhere_for_a_contact_stiffer_by_a_thousandth(
    points, kind
):
    chosen, motion = [point for point in points if point.kind == kind], Motion.of(SOFT)
    assert len(chosen) == 2
    for point in chosen:
        solved = solve(motion, point, TOLERANCE)
        assert solved.first == pytest.approx(point.omega * (1.0 + OFF_VALUE), rel=1e-12)
        assert solved.residual <= TOLERANCE
        assert solved.omega == pytest.approx(point.omega, rel=AGREE)
    solved = solve(replace(motion, K=1.001 * motion.K), chosen[0], 1e-6)
    assert 1e-7 < abs(solved.omega / chosen[0].omega - 1.0) < 1e-3


def test_the_rates_of_vectors_are_derivatives_of_the_rate():
    motion, omega, step = Motion.of(SOFT), 6.0, 1e-6
    y, v = np.array([0.02, 0.1, 0.09, -0.2]), np.array([0.3, -0.5, 0.7, 0.2])
    for closed in (True, False):
        s = np.asarray(0.3)
        ahead = motion.rate(s, y + step * v, omega, closed)
        behind = motion.rate(s, y - step * v, omega, closed)
        expected = motion.vector_rate(y, v, omega, closed)
        assert (ahead - behind) / (2.0 * step) == pytest.approx(expected, rel=1e-7)


def test_another_number_of_contacts_is_refused():
    motion = Motion.of(SOFT)
    open_state = np.array([0.0, 0.0, motion.V + 0.01, 0.0] + [0.0] * 4)[:, np.newaxis]
    with pytest.raises(ArithmeticError, match="number of contacts"):
        boundary_values.check_sides(motion, np.vstack((open_state, open_state)))
