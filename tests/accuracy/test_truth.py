"""What is true of a case: stored digits, witnesses that agree, and refusals where they do not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from support import references

from nlds_vines.accuracy import measure, reference
from nlds_vines.accuracy.cases import near_grazing, of_system, suite
from nlds_vines.accuracy.reference import WITNESSES, _witnessed, reference_of, stored_section
from nlds_vines.errors import RequestError
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import steady_state
from nlds_vines.orbits.simulation import simulate

SET6 = load_system("ssul-set6", omega=6.28)


def test_the_suite_has_five_cases():
    names = [case.name for case in suite()]
    assert names == ["ssul-set6", "ssul-set6-steel", "ssbl", "near-grazing", "tmd"]


def test_near_grazing_touches_slowly():
    case = near_grazing(SET6)
    hits = simulate(case.system, 1, start=case.start).impacts
    assert len(hits) >= 1
    assert hits["speed"][0] < 0.01
    apart = case.system.with_(omega=case.system.parameters["omega"] * (1 + 2e-6))
    assert len(simulate(apart, 3, start=steady_state(apart)).impacts) == 0


@pytest.mark.parametrize("name", ["ssul-set6", "ssul-set6-steel"])
def test_stored_digits_are_found_by_their_parameters(name):
    case = next(case for case in suite() if case.name == name)
    np.testing.assert_array_equal(stored_section(case), references()[name].states[:20])


def test_no_digits_are_stored_for_another_system():
    assert stored_section(of_system(SET6.with_(c2=51.0))) is None
    assert stored_section(replace(of_system(SET6), start=(0.0, 0.0, 0.2, 0.0))) is None


@pytest.mark.kernels
def test_the_reference_agrees_with_its_witnesses():
    found = reference_of(replace(of_system(SET6.with_(c2=51.0)), periods=4))
    assert found.source == "exact, refined"
    assert found.doubt < 1e-12
    assert found.independent < 1e-10
    assert found.growth >= 1.0


@pytest.mark.kernels
def test_near_grazing_all_witnesses_agree():
    """SciPy's solver finds the touches within its steps, and plain steps are shorter than them."""
    case = near_grazing(SET6)
    found = reference_of(case)
    assert found.independent < 1e-11
    distances = {name: np.abs(s[-1] - found.section[-1]).max() for name, s in _witnessed(case)}
    assert set(distances) == set(WITNESSES)
    assert max(distances.values()) < 1e-11


@pytest.mark.kernels
def test_witnesses_that_disagree_are_told(monkeypatch):
    liars = (("naive RK4", np.ones((2, 4))),)
    monkeypatch.setattr(reference, "_witnessed", lambda case: iter(liars))
    with pytest.raises(RequestError, match="two references differ"):
        reference_of(replace(of_system(SET6), periods=2))


@pytest.mark.kernels
@pytest.mark.parametrize("column", ["touch", "E1max"])
def test_a_reference_needs_touches_and_energies_that_agree(monkeypatch, column):
    followed = reference.watched

    def other(case, **settings):
        orbit = followed(case, **settings)
        if settings.get("method") != "rk4":
            return orbit
        if column == "E1max":
            return replace(orbit, E1max=orbit.E1max * 1.01)
        return replace(orbit, impacts=orbit.impacts[:-1])

    monkeypatch.setattr(reference, "watched", other)
    with pytest.raises(RequestError, match="there is no reference"):
        reference_of(replace(of_system(SET6), periods=2))


def test_what_cannot_be_followed_has_no_reference():
    case = replace(of_system(SET6.with_(omega=1e-6)), periods=2)
    with pytest.raises(RequestError, match="ssul-set6: there is no reference"):
        reference_of(case)


@pytest.mark.kernels
def test_a_label_on_which_methods_disagree_is_none(monkeypatch):
    case = replace(of_system(SET6), periods=2)

    def judged(system, start, method="exact"):
        return SimpleNamespace(label=f"by {method}", point=None)

    monkeypatch.setattr(measure, "classify", judged)
    found = measure.truth_of(case, reference_of(case))
    assert found.label == "uncertain: by exact by exact, by rk4 by rk4"
    assert found.steady is None
