"""Lifetimes: against a textbook, closed forms, and laws that are known beforehand."""

import numpy as np
import pytest

from nlds_vines.errors import RequestError
from nlds_vines.transients.ensemble import decay, share_interval, survival

WEEKS = (6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35)
RELAPSED = (1, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0)
"""Remissions under 6-MP, Freireich and others (1963): the example of every textbook."""


def test_the_textbook_example():
    curve = survival(WEEKS, RELAPSED)
    assert curve.times.tolist() == [6, 7, 10, 13, 16, 22, 23]
    printed = [0.8571, 0.8067, 0.7529, 0.6902, 0.6275, 0.5378, 0.4482]
    np.testing.assert_allclose(curve.share, printed, atol=5e-5)
    assert curve.quantile(0.5) == 23
    assert np.isnan(curve.quantile(0.9))


def test_the_interval_is_that_of_log_minus_log_with_greenwoods_variance():
    curve = survival(WEEKS, RELAPSED, level=0.95)
    at_risk, ended = np.array([21, 17, 15, 12, 11, 7, 6]), np.array([3, 1, 1, 1, 1, 1, 1])
    terms = ended / (at_risk * (at_risk - ended))
    width = 1.959964 * np.sqrt(np.cumsum(terms)) / np.abs(np.log(curve.share))
    np.testing.assert_allclose(curve.low, curve.share ** np.exp(width), rtol=1e-6)
    np.testing.assert_allclose(curve.high, curve.share ** np.exp(-width), rtol=1e-6)


def test_without_censoring_it_is_the_share_that_is_left():
    times = np.array([3.0, 1.0, 2.0, 2.0, 5.0])
    curve = survival(times, np.ones(5, dtype=bool))
    np.testing.assert_allclose(curve.share, [0.8, 0.4, 0.2, 0.0], atol=1e-15)
    assert [curve.quantile(q) for q in (0.2, 0.5, 1.0)] == [1.0, 2.0, 5.0]


def test_what_ends_and_what_is_last_watched_at_one_time():
    curve = survival([2.0, 2.0, 3.0], [True, False, True])
    np.testing.assert_allclose(curve.share, [2 / 3, 0.0], atol=1e-15)


def test_nothing_that_ended_leaves_everything():
    curve = survival([4.0, 7.0], [False, False])
    assert curve.times.size == curve.low.size == 0
    assert np.isnan(curve.quantile(0.1))
    law = decay([4.0, 7.0], [False, False])
    assert (law.rate, law.low, law.ended, law.mean) == (0.0, 0.0, 0, np.inf)
    assert law.high == pytest.approx(-np.log(0.025) / 11)


def test_the_rate_is_deaths_over_exposure_beyond_the_delay():
    law = decay([1.0, 4.0, 6.0, 10.0], [True, True, True, False], delay=3.0)
    assert (law.ended, law.exposure) == (2, 11.0)
    assert law.rate == pytest.approx(2 / 11)
    # of a Poisson count of 2, textbook: 0.2422 to 7.2247
    assert (11 * law.low, 11 * law.high) == pytest.approx((0.2422, 7.2247), abs=1e-4)


@pytest.mark.parametrize("watched", [50.0, 200.0, 2000.0])
def test_a_known_rate_is_recovered_and_covered(watched):
    generator, covered, rates = np.random.default_rng(7), 0, []
    for _ in range(400):
        times = generator.exponential(100.0, 80) + 20.0
        law = decay(np.minimum(times, watched), times <= watched, delay=20.0)
        rates.append(law.rate)
        covered += law.low <= 0.01 <= law.high
    assert np.mean(rates) == pytest.approx(0.01, rel=0.05)
    assert 0.93 <= covered / 400 <= 0.995


def test_the_curve_covers_a_known_one():
    generator, covered = np.random.default_rng(8), 0
    for _ in range(300):
        times = generator.exponential(100.0, 80)
        watched = generator.uniform(50.0, 300.0, 80)
        curve = survival(np.minimum(times, watched), times <= watched)
        place = np.searchsorted(curve.times, 60.0) - 1
        covered += curve.low[place] <= np.exp(-0.6) <= curve.high[place]
    assert 0.92 <= covered / 300 <= 0.98


def test_wilsons_interval():
    # Newcombe (1998), table I
    assert share_interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)
    assert share_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=1e-4)


@pytest.mark.parametrize(
    ("times", "ended", "message"),
    [
        ([], [], "no lifetimes"),
        ([1.0], [True, False], "as many"),
        ([-1.0], [True], "0 or more"),
        ([np.nan], [True], "finite"),
    ],
)
def test_what_is_no_lifetime_is_refused(times, ended, message):
    for estimate in (survival, decay):
        with pytest.raises(RequestError, match=message):
            estimate(times, ended)


def test_a_delay_beyond_all_lifetimes_is_refused():
    with pytest.raises(RequestError, match="delay = 9"):
        decay([1.0, 9.0], [True, True], delay=9.0)
