"""What is true of a case: witnesses that agree, and refusals where they do not."""

from dataclasses import replace

import numpy as np
import pytest

from nlds_vines.accuracy import reference, scipy_solver
from nlds_vines.accuracy.measured_cases import Case, Course, SolverFailure
from nlds_vines.accuracy.reference import followed, truth_of
from nlds_vines.errors import RequestError
from nlds_vines.model.catalog import load_system
from nlds_vines.orbits.simulation import simulate

SET6 = load_system("ssul-set6", omega=6.28)


@pytest.mark.kernels
def test_the_reference_agrees_with_its_witnesses():
    found = truth_of(Case.of(SET6.with_(c2=51.0), 4)).known
    assert found.source == "exact, refined"
    assert found.doubt < 1e-12
    assert found.independent < 1e-10
    assert found.growth >= 1.0
    assert found.truth == "T,1"


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["ssul-set6", "ssbl", "tmd", "none"])
def test_scipy_finds_the_same_state(name):
    case = Case.of(load_system(name, omega=6.05), 3)
    truth = simulate(case.system, 3, record=["section"]).section
    errors = []
    for rtol in (1e-6, 1e-9):
        found = scipy_solver.follow(case.system, 3, case.state, rtol)
        assert found.section.shape == truth.shape
        assert found.touches is None
        errors.append(np.abs(found.section - truth).max())
    assert errors[1] < min(1e-6, errors[0] / 10)


def test_scipy_says_how_it_broke_down(monkeypatch):
    with pytest.raises(SolverFailure):
        scipy_solver.follow(SET6, 1, np.array([0.0, 0.0, -1e300, 0.0]), 1e-6)
    monkeypatch.setattr(scipy_solver, "BUDGET", 20)
    with pytest.raises(SolverFailure, match="more than 20 evaluations"):
        scipy_solver.follow(SET6, 1, Case.of(SET6).state, 1e-6)


@pytest.mark.kernels
def test_witnesses_that_disagree_are_told(monkeypatch):
    lie = Course(np.ones((2, 4)), None)
    monkeypatch.setattr(reference.scipy_solver, "follow", lambda *given: lie)
    with pytest.raises(RequestError, match="two references differ"):
        truth_of(Case.of(SET6, 2))


@pytest.mark.kernels
def test_a_reference_needs_touches_that_agree(monkeypatch):
    def other(case, **settings):
        orbit = followed(case, **settings)
        if settings.get("method") != "rk4":
            return orbit
        return replace(orbit, impacts=orbit.impacts[:-1])

    monkeypatch.setattr(reference, "followed", other)
    with pytest.raises(RequestError, match="do not find the same touches"):
        truth_of(Case.of(SET6, 2))


def test_what_cannot_be_followed_has_no_reference():
    with pytest.raises(RequestError, match="ssul-set6: there is no reference"):
        truth_of(Case.of(SET6.with_(omega=1e-6), 2))
