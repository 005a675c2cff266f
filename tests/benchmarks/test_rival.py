"""What all rivals share: touches among states, and failures in one sentence."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.rivals import RIVALS
from benchmarks.rivals import rival as base
from benchmarks.rivals.rival import Asked, SolverFailure, Track
from nlds_vines.accuracy.measured_cases import Case
from nlds_vines.accuracy.reference import FINEST, followed
from nlds_vines.model.catalogue import load_system
from nlds_vines.orbits.simulation import simulate

SET6 = load_system("ssul-set6", omega=6.28)
PERIODS = 3
NAIVE = RIVALS[0]


@pytest.fixture(scope="module")
def truth():
    return followed(Case.of(SET6, PERIODS), **FINEST)


def flow_between(fits):
    """Return a flow that knows the truth at the times wanted; it may fit its steps to these."""
    states = simulate(SET6, PERIODS, record=["trajectory"], samples=base.LOOKS).trajectory

    def follow(setting, times, watched):
        every = round(times[0] / SET6.period * base.LOOKS)
        return Track(states[every - 1 :: every] + (1e-9 / every if fits else 0.0))

    return base.flow_of(SET6, Case.of(SET6).state, follow)


@pytest.mark.kernels
def test_touches_are_placed_between_the_states(truth):
    found = flow_between(False)(0.0, PERIODS, Asked.TOUCHES)
    np.testing.assert_allclose(found.touches, truth.impacts["touch"], rtol=0, atol=1e-9)


@pytest.mark.kernels
def test_who_fits_the_steps_to_the_times_cannot_tell_touches():
    assert flow_between(True)(0.0, PERIODS, Asked.TOUCHES).touches is None


def broken(error):
    """Return a rival whose flow raises an exception, and one that raises it when prepared."""

    def raising(*given):
        raise error

    return (replace(NAIVE, prepare=prepare) for prepare in (lambda *orbit: raising, raising))


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (TypeError("no such thing\nas this"), "^TypeError: no such thing$"),
        (ValueError(), "^ValueError$"),
        (RuntimeError("broken"), "^RuntimeError: broken$"),
        (SolverFailure("too stiff"), "^too stiff$"),
    ],
)
def test_any_exception_is_a_failure_in_one_sentence(error, words):
    for rival in broken(error):
        with pytest.raises(SolverFailure, match=words):
            rival.prepare(SET6, np.zeros(4))(256, 1, False)


def test_an_interruption_passes():
    for rival in broken(KeyboardInterrupt()):
        with pytest.raises(KeyboardInterrupt):
            rival.prepare(SET6, np.zeros(4))(256, 1, False)
