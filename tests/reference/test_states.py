"""Both methods against states of 25 digits, from rest, impacts counted."""

import numpy as np
import pytest
from support import counts_by_period, follow_ssbl, follow_ssul, references

from nlds_vines.orbits.settings import Settings

SSUL = ("ssul-set6", "ssul-set6-omega7.45", "ssul-set6-steel")
BILATERAL = references()["ssbl-omega6.05"]
FINE = 2048.0  # rk4 steps a period


def errors_of(reference, section):
    """Return the largest error of each state, in units of the growth of an error by then."""
    return (
        np.abs(section - reference.states[: len(section)]).max(axis=1)
        / reference.growth[: len(section)]
    )


def assert_counts(reference, touches, periods):
    found = counts_by_period(touches, reference.parameters["omega"], periods)
    np.testing.assert_array_equal(found, reference.impacts[:periods])


@pytest.mark.parametrize("name", SSUL)
def test_exact_after_20_periods(name):
    reference = references()[name]
    orbit = follow_ssul(reference.numbers, None, 20)
    assert errors_of(reference, orbit.section)[-1] <= 1e-9
    assert_counts(reference, orbit.impacts["touch"], 20)


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


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("method", "settings", "bound"),
    [("exact", Settings(), 1e-9), ("rk4", Settings.rk4(FINE), 1e-8)],
)
def test_two_walls(method, settings, bound):
    section, impacts = follow_ssbl(BILATERAL.numbers, 30, method, settings)
    assert errors_of(BILATERAL, section).max() <= bound
    assert_counts(BILATERAL, impacts[:, 1], 30)
    assert set(impacts[:, 0]) == {0.0, 1.0}  # both walls were touched
