"""Solvers of others converge to the true state, and the cost of an error is interpolated."""

import math
from importlib.util import find_spec

import numpy as np
import pytest

from benchmarks import accuracy
from benchmarks.accuracy import SOLVERS, Point, cost, points_of
from nlds_vines import load_system, simulate

INSTALLED = [solver for solver in SOLVERS if find_spec(solver.package)]


@pytest.fixture(scope="module")
def cases():
    return {case.name: case for case in accuracy.cases()}


@pytest.mark.kernels
def test_the_truth_of_each_case_is_that_of_the_finest_settings(cases):
    assert list(cases) == ["ssul-set6", "steel", "ssbl", "near-grazing", "tmd"]
    for case in cases.values():
        orbit = simulate(
            case.system, 20, start=case.start, record=(), method="rk4", period_steps=8192
        )
        assert np.abs(orbit.state - case.truth).max() < 1e-11, case.name


@pytest.mark.kernels
@pytest.mark.parametrize("solver", INSTALLED, ids=lambda solver: solver.name)
def test_a_solver_converges_to_the_truth(solver, cases, monkeypatch):
    monkeypatch.setattr(accuracy, "seconds_of", lambda follow: 1.0)
    for name in ("ssul-set6", "ssbl"):
        errors = [point.error for point in points_of(cases[name], solver)]
        assert errors[-1] < 3e-8
        assert errors[-1] < errors[0] / 10


def test_scipy_is_split_where_contacts_begin():
    system = load_system("ssul-set6", omega=6.28)
    section, touches = accuracy.scipy_orbit(system, accuracy.rest_state(system), 1e-10, 3)
    orbit = simulate(system, 3, record=("section", "impacts"))
    assert len(touches) == len(orbit.impacts) > 0
    np.testing.assert_allclose(touches, orbit.impacts["touch"], rtol=1e-8)
    np.testing.assert_allclose(section, orbit.section, atol=1e-8)


def points(*pairs):
    return [Point(SOLVERS[0], 0.0, error, seconds) for error, seconds in pairs]


def test_a_cost_is_interpolated_along_the_cheapest_settings():
    curve = points((1e-2, 1e-6), (1e-6, 1e-4), (1e-5, 1e-3), (math.inf, math.inf))
    assert cost(curve, 1e-4) == pytest.approx(1e-5)
    assert cost(curve, 1e-1) == pytest.approx(1e-6)  # the cheapest is better than asked for
    assert cost(curve, 1e-7) == math.inf


def test_a_solver_that_fails_has_an_infinite_error(cases):
    def prepare(system, start):
        def follow(setting, periods):
            raise ArithmeticError("step too small")

        return follow

    solver = SOLVERS[0]._replace(prepare=prepare, settings=(1.0,))
    (point,) = points_of(cases["tmd"], solver)
    assert point.error == point.seconds == math.inf
