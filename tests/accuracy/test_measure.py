"""Errors, touches, labels and failures of one contender are measured as they are."""

import math

import numpy as np
import pytest

from nlds_vines.accuracy import measure
from nlds_vines.accuracy.measure import Contender
from nlds_vines.accuracy.measured_cases import Case, Course, Setting, SolverFailure
from nlds_vines.accuracy.reference import truth_of
from nlds_vines.model.catalog import load_system

pytestmark = pytest.mark.kernels

SET6 = load_system("ssul-set6", omega=6.28)


@pytest.fixture(scope="module")
def truth():
    return truth_of(Case.of(SET6, 6))


def made_up(section=None, touches=None, failure=None):
    """Return a contender that finds what it is told to."""

    def follow(case, observed):
        if failure:
            raise SolverFailure(failure)
        return Course(section=section(case), touches=touches, seconds=0.5)

    return Contender(Setting("made up", 1.0, "", False), follow)


def test_errors_are_those_of_the_course(truth):
    off = truth.section + np.array([0.0, 0.0, 2e-4, -1e-4])
    late = truth.touches + 1e-5
    found = measure.measured(truth, made_up(lambda case: off, late))
    assert found.error == pytest.approx(2e-4)
    assert found.touch_error == pytest.approx(1e-5)
    assert found.missed == 0
    assert found.seconds == pytest.approx(0.5 / 6 / math.ceil(measure.SHORTEST / 0.5))


@pytest.mark.parametrize("change", [-1, 1])
def test_missed_and_invented_touches_are_counted(truth, change):
    touches = truth.touches
    touches = touches[:change] if change < 0 else np.append(touches, touches[-1] + 0.1)
    contender = made_up(lambda case: truth.section, touches)
    found = measure.measured(truth, contender)
    assert found.missed == -change
    assert math.isnan(found.touch_error)
    assert not found.complete


def test_one_missed_and_one_invented_are_not_the_right_number(truth):
    touches = truth.touches.copy()
    touches[2] = touches[1] + 0.4 * (touches[2] - touches[1])
    contender = made_up(lambda case: truth.section, touches)
    found = measure.measured(truth, contender)
    assert found.missed == 1
    assert not found.complete


def test_failures_become_rows(truth):
    assert measure.measured(truth, made_up(failure="step too small")).failure == "step too small"
    found = measure.measured(truth, made_up(lambda case: np.full((6, 4), np.nan)))
    assert "not finite" in found.failure
