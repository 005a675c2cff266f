"""Growth rates, averages and recurrences of sequences whose nature is known beforehand."""

import math

import numpy as np
import pytest

from nlds_vines.kernels.cells.verdict import digits_of, mean_and_width
from nlds_vines.kernels.orbit.repetition import TOLERANCE, period_of

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def logistic(r, count, skip=500):
    """Return an orbit of x -> r x (1 - x) and the logarithms of its growth per iteration."""
    x, orbit = 0.3, np.empty(count)
    for i in range(skip + count):
        x = r * x * (1.0 - x)
        if i >= skip:
            orbit[i - skip] = x
    return orbit, np.log(np.abs(r * (1.0 - 2.0 * orbit)))


def torus(count):
    """Return a smooth function along a rotation by the golden mean."""
    angle = 2.0 * math.pi * GOLDEN * np.arange(count)
    return np.exp(np.cos(angle)) * np.sin(angle + 0.3)


def noise(count):
    return np.random.default_rng(1).normal(size=count)


def as_section(values):
    return np.stack([values, values**2], axis=-1)


def test_the_exponent_of_the_logistic_map_is_ln_2():
    _, logs = logistic(4.0, 6000)
    mean, width = mean_and_width(logs)
    assert abs(mean - math.log(2.0)) <= width
    assert width < 0.05


def test_a_mean_is_as_wide_as_the_means_of_sixteen_pieces_tell():
    """All but the first twentieth, in pieces of equal length that end with the sequence."""
    values = noise(1000)
    pieces = values[1000 - 16 * (950 // 16) :].reshape(16, -1).mean(axis=1)
    mean, width = mean_and_width(values)
    assert mean == pytest.approx(pieces.mean(), rel=1e-12)
    assert width == pytest.approx(2.947 * pieces.std(ddof=1) / 4.0, rel=1e-12)
    for count, is_finite in ((33, True), (32, False)):  # 32 and 31 values: two a piece, or fewer
        assert math.isfinite(mean_and_width(values[:count])[1]) == is_finite


def test_growth_that_ends_is_minus_infinity_and_sure():
    logs = np.append(np.zeros(500), np.full(500, -np.inf))
    assert mean_and_width(logs) == (-np.inf, 0.0)


@pytest.mark.parametrize(("r", "n"), [(3.2, 2), (3.5, 4), (3.55, 8), (3.83, 3)])
def test_the_exponent_of_a_periodic_window_is_that_of_its_multiplier(r, n):
    orbit, logs = logistic(r, 4800)
    mean, width = mean_and_width(logs)
    multiplier = np.prod(r * (1.0 - 2.0 * orbit[-n:]))
    assert abs(mean - math.log(abs(multiplier)) / n) <= max(width, 1e-9) + 0.01
    assert mean + width < 0.0
    assert period_of(as_section(orbit[:200]), TOLERANCE) == n


def test_the_interval_holds_the_mean_in_as_many_cases_as_it_claims():
    generator = np.random.default_rng(7)
    hits = 0
    for _ in range(400):  # a sequence whose values depend on their predecessors
        values = np.empty(1600)
        values[0] = generator.normal()
        for i in range(1, values.size):
            values[i] = 0.7 * values[i - 1] + generator.normal()
        mean, width = mean_and_width(values)
        hits += abs(mean) <= width
    assert 0.975 <= hits / 400 < 1.0  # 99 % but for three standard errors


def test_too_short_a_sequence_has_no_interval():
    mean, width = mean_and_width(np.ones(20))
    assert math.isnan(mean)
    assert width == math.inf


def test_the_beginning_of_a_sequence_does_not_count():
    """A variation aligns there; afterwards every value does, the last one included."""
    logs = np.full(1600, 0.5)
    assert mean_and_width(logs) == (0.5, 0.0)
    logs[:79] = 1e6
    assert mean_and_width(logs) == (0.5, 0.0)
    logs[-1] = 1e6
    assert mean_and_width(logs)[0] > 1.0


def test_digits_do_not_depend_on_the_unit():
    for values in (torus(600), noise(600)):
        for unit in (1e-9, 1e9):
            assert digits_of(unit * values) == pytest.approx(digits_of(values), abs=1e-3)


def test_averages_on_a_torus_agree_to_many_digits_and_others_do_not():
    assert digits_of(torus(600)) > 7.0
    assert digits_of(torus(2400)) > 10.0
    assert digits_of(logistic(4.0, 2400)[0]) < 4.0
    assert digits_of(noise(2400)) < 4.0
    assert digits_of(torus(2400) + 1e-3 * noise(2400)) < 7.0
    assert digits_of(np.ones(100)) == 15.0


@pytest.mark.parametrize("n", [1, 2, 3, 7, 40])
def test_a_period_is_found_where_there_is_one(n):
    base = np.random.default_rng(n).uniform(size=n)
    assert period_of(as_section(np.resize(base, 120)), TOLERANCE) == n


def test_a_period_is_that_of_all_components():
    one, other = np.resize([1.0, 2.0], 120), np.resize([1.0, 2.0, 3.0], 120)
    assert period_of(np.stack([one, other], axis=-1), TOLERANCE) == 6
    assert period_of(np.stack([other, one], axis=-1), TOLERANCE) == 6
    assert period_of(np.stack([one, noise(120)], axis=-1), TOLERANCE) == 0


@pytest.mark.parametrize("values", [torus(120), noise(120), logistic(4.0, 120)[0]])
def test_no_period_is_found_where_there_is_none(values):
    assert period_of(as_section(values), TOLERANCE) == 0
    assert period_of(as_section(np.resize(values[:50], 120)), TOLERANCE) == 0  # too long for 120
