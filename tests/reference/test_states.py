"""Both methods against states of 25 digits, from rest, impacts counted."""

import numpy as np
import pytest
from support import counts_by_period, follow_ssul, references

SSUL = ("ssul-set6", "ssul-set6-omega7.45", "ssul-set6-steel")
FINE = 2048.0  # rk4 steps a period


def errors_of(reference, section):
    """Return the largest error of each state, in units of the growth of an error by then."""
    return (
        np.abs(section - reference.states[: len(section)]).max(axis=1)
        / reference.growth[: len(section)]
    )


def assert_counts(reference, touches, periods):
    counts = counts_by_period(touches, reference.parameters["omega"], periods)
    np.testing.assert_array_equal(counts, reference.impacts[:periods])


@pytest.mark.parametrize("name", SSUL)
def test_exact_up_to_100_periods(name):
    reference = references()[name]
    orbit = follow_ssul(reference.numbers, None, 100)
    assert errors_of(reference, orbit.section).max() <= 1e-9
    assert_counts(reference, orbit.impacts["touch"], 100)


@pytest.mark.kernels
@pytest.mark.parametrize("name", SSUL)
def test_rk4_up_to_100_periods(name):
    reference = references()[name]
    orbit = follow_ssul(reference.numbers, None, 100, method="rk4", period_steps=FINE)
    assert errors_of(reference, orbit.section).max() <= 1e-8
    assert_counts(reference, orbit.impacts["touch"], 100)
