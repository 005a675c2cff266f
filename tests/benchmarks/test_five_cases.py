"""The five cases that stand for all, and the digits that are stored of some."""

from dataclasses import replace

import numpy as np
import pytest
from support import references

from benchmarks.accuracy.cases import known_truth, near_grazing, stored_section, suite
from nlds_vines.accuracy.measured_cases import Case
from nlds_vines.accuracy.reference import truth_of
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


@pytest.mark.kernels
def test_near_grazing_the_witness_sees_the_touches():
    """Its steps are short enough to meet contacts of a thousandth of a period."""
    assert truth_of(near_grazing(SET6)).known.independent < 1e-10


@pytest.mark.parametrize("name", ["ssul-set6", "ssul-set6-steel"])
def test_stored_digits_are_found_by_their_parameters(name):
    case = next(case for case in suite() if case.name == name)
    np.testing.assert_array_equal(stored_section(case), references()[name].states[:20])


def test_no_digits_are_stored_for_another_system():
    assert stored_section(Case.of(SET6.with_(c2=51.0))) is None
    assert stored_section(replace(Case.of(SET6), start=(0.0, 0.0, 0.2, 0.0))) is None


@pytest.mark.kernels
def test_stored_digits_are_the_truth():
    case = Case.of(SET6, 3)
    found = known_truth(case)
    assert found.known.source == "stored, 25 digits"
    assert found.known.doubt < 1e-15
    np.testing.assert_array_equal(found.section, stored_section(case))
