"""Errors, touches, labels and failures of one contender are measured as they are."""

import math
from dataclasses import replace

import numpy as np
import pytest

from nlds_vines.accuracy import measure
from nlds_vines.accuracy.cases import of_system
from nlds_vines.accuracy.contenders import Contender
from nlds_vines.accuracy.reference import reference_of
from nlds_vines.accuracy.results import Setting
from nlds_vines.accuracy.rivals import Course, RivalFailure
from nlds_vines.model.catalogue import load_system

pytestmark = pytest.mark.kernels

SET6 = load_system("ssul-set6", omega=6.28)


@pytest.fixture(scope="module")
def truth():
    case = replace(of_system(SET6), periods=6)
    return measure.truth_of(case, reference_of(case))


def made_up(section=None, touches=None, E1max=100.0, failure=None):
    """Return a contender that finds what it is told to."""

    def follow(case, observed):
        if failure:
            raise RivalFailure(failure)
        return Course(section=section(case), touches=touches, E1max=E1max, seconds=0.5)

    return Contender(Setting("made up", 1.0, "", False), follow)


def test_errors_are_those_of_the_course(truth):
    off = truth.reference.section + np.array([0.0, 0.0, 2e-4, -1e-4])
    late = truth.reference.touches + 1e-5
    found = measure.measured(
        replace(truth, steady=None), made_up(lambda case: off, late, truth.reference.E1max + 3.0)
    )
    assert found.error == pytest.approx(2e-4)
    assert found.touch_error == pytest.approx(1e-5)
    assert found.energy_error == pytest.approx(3.0)
    assert found.missed == 0
    assert found.seconds == pytest.approx(0.5 / 6 / math.ceil(measure.SHORTEST / 0.5))


@pytest.mark.parametrize("change", [-1, 1])
def test_missed_and_invented_touches_are_counted(truth, change):
    touches = truth.reference.touches
    touches = touches[:change] if change < 0 else np.append(touches, touches[-1] + 0.1)
    contender = made_up(lambda case: truth.reference.section, touches)
    found = measure.measured(replace(truth, steady=None), contender)
    assert found.missed == -change
    assert math.isnan(found.touch_error)
    assert not found.complete


def test_one_missed_and_one_invented_are_not_the_right_number(truth):
    touches = truth.reference.touches.copy()
    touches[2] = touches[1] + 0.4 * (touches[2] - touches[1])
    contender = made_up(lambda case: truth.reference.section, touches)
    found = measure.measured(replace(truth, steady=None), contender)
    assert found.missed == 1
    assert not found.complete


def test_failures_become_rows(truth):
    assert measure.measured(truth, made_up(failure="step too small")).failure == "step too small"
    found = measure.measured(truth, made_up(lambda case: np.full((6, 4), np.nan)))
    assert "not finite" in found.failure


def test_a_label_needs_a_recurrence(truth):
    rng = np.random.default_rng(0)
    wild = made_up(lambda case: rng.normal(size=(case.periods, 4)), truth.reference.touches)
    assert measure._label(truth.steady, wild) == "undetermined"
    assert truth.label == "T,1"
