"""Curves of special points of rigid bodies, along which impacts pass phase zero."""

import numpy as np
import pytest

from nlds_vines import continue_branch, load_system

SYSTEM = load_system(
    "ssbl", law="restitution", m1=1.0, k1=1.0, P=1.0, C=1.0, D=1.0, c1=0.04, m2=0.05, k2=0.0453152,
    c2=0.0127, e=0.9, omega=1.0464736163637947,
)  # fmt: skip
T_6 = [-5.904600292051143, 1.6653780336231168, -5.836300239743613, 3.9872046900516933]
"""An orbit T,6 beside its fold at omega = 1.046565."""
T_2 = [-1.6313374820442195, 0.2828298996933553, -1.6135583166033252, -1.6467655311720084]
"""An orbit T,2 at omega = 1.224997."""

pytestmark = pytest.mark.kernels


def fold(system, low, high, start, **options):
    path = continue_branch(system, "omega", (low, high), start, period=1, quiet=True, **options)
    return path, path.special_points[path.special_points.kind == "LP"]


def test_a_curve_goes_on_where_an_impact_passes_phase_zero():
    path, points = fold(SYSTEM, 1.042, 1.051, T_6, plane=("c1", 0.02, 0.06))
    (curve,) = path.curves
    assert curve.ends == ("bound", "bound")
    at_own = np.abs(curve.values[:, 1] - 0.04).argmin()
    assert curve.values[at_own, 0] == pytest.approx(points[0].value, abs=1e-5)
    assert np.abs(curve.multipliers - 1.0).min(axis=1).max() < 1e-5
    # at c1 = 0.0368 the impact passes phase zero: beyond it, a branch has the same fold
    i = int(np.abs(curve.values[:, 1] - 0.025).argmin())
    omega, c1 = curve.values[i]
    there = SYSTEM.with_(c1=float(c1), omega=float(omega))
    state = curve.states[i] * (1.0 + 1e-7)
    path, points = fold(there, omega - 2e-3, omega + 2e-3, state)
    assert np.abs(points.value - omega).min() < 1e-8


def test_the_orbit_between_states_on_both_sides_of_an_impact_is_found():
    """That of T,2 strikes a wall at phase zero at omega = 1.212808."""
    omega, state = 1.2249972454229396, T_2
    path, _ = fold(SYSTEM.with_(omega=omega), 1.2, 1.23, state)
    (branch,) = path.branches
    speed = branch.states[:, 3]  # of the damper, which an impact turns round
    (i,) = np.flatnonzero(np.abs(np.diff(speed)) > 10.0 * np.median(np.abs(np.diff(speed))))
    assert branch.parameter[i : i + 2].min() < 1.212808 < branch.parameter[i : i + 2].max()
    for share in (0.01, 0.5, 0.99):
        value = (1.0 - share) * branch.parameter[i] + share * branch.parameter[i + 1]
        (orbit,) = path.orbits_at(float(value))
        assert (orbit.label, orbit.stable) == ("T,2", False)
        assert min(abs(orbit.state[3] - speed[i]), abs(orbit.state[3] - speed[i + 1])) < 0.2
