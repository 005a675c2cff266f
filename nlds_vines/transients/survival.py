"""How long something lasts, from lifetimes some of which were only watched for a while.

A lifetime that had not ended when watching stopped is censored: it is known to be longer.  Nothing
here knows of orbits.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.errors import RequestError

LEVEL = 0.95
"""The default confidence of all intervals."""


@dataclass(frozen=True)
class Survival:
    """The Kaplan-Meier estimate: a step function that falls at each time at which something ended.

    Attributes:
        times: where it falls, ascending, in the unit of the lifetimes.
        share: surviving from each of them on; before the first it is 1.
        low, high: the ends of its interval (log-log; NaN where all or none survive).
        at_risk: how many were alive and watched just before each time; `ended`: how many ended.
    """

    times: np.ndarray
    share: np.ndarray
    low: np.ndarray
    high: np.ndarray
    at_risk: np.ndarray
    ended: np.ndarray

    def quantile(self, q: float) -> float:
        """Return the first time at which at least a share `q` has ended; NaN if it never did."""
        reached = np.flatnonzero(self.share <= 1.0 - q + 1e-12)
        return float(self.times[reached[0]]) if reached.size else float("nan")


@dataclass(frozen=True)
class Decay:
    """An exponential law of lifetimes beyond `delay`: share(t) ~ exp(-rate (t - delay)).

    Attributes: `rate` per unit of the lifetimes with the interval (low, high); how many `ended`;
    the `exposure`, all time watched beyond the delay; the `delay`.
    """

    rate: float
    low: float
    high: float
    ended: int
    exposure: float
    delay: float

    @property
    def mean(self) -> float:
        """The mean lifetime beyond the delay; inf where nothing ended."""
        return 1.0 / self.rate if self.rate > 0.0 else float("inf")


def survival(times: Any, ended: Any, level: float = LEVEL) -> Survival:
    """Return the Kaplan-Meier estimate of lifetimes.

    Arguments: `times` (n,) watched, >= 0; `ended` (n,), whether the life ended then (True) or only
    the watching (False); what ends and what is last watched at one time: the former comes first.

    S(t) = prod over t_i <= t of (1 - d_i / n_i), with d_i that ended at t_i of n_i at risk.  The
    interval is that of ln(-ln S) with Greenwood's variance, which stays within 0 and 1.

    Raises `RequestError` where nothing is given, or times that are no times.
    """
    from scipy import stats

    times, ended = _checked(times, ended)
    data = stats.CensoredData(uncensored=times[ended], right=times[~ended])
    estimate = stats.ecdf(data).sf
    own = np.isin(estimate.quantiles, times[ended])  # it also lists the times of censoring
    low, high = _interval(estimate, level) if ended.any() else (np.empty(0), np.empty(0))
    found = estimate.quantiles[own]
    return Survival(
        times=found,
        share=estimate.probabilities[own],
        low=low[own] if low.size else low,
        high=high[own] if high.size else high,
        at_risk=np.array([np.count_nonzero(times >= t) for t in found], dtype=np.int64),
        ended=np.array([np.count_nonzero(times[ended] == t) for t in found], dtype=np.int64),
    )


def decay(times: Any, ended: Any, delay: float = 0.0, level: float = LEVEL) -> Decay:
    """Return the exponential law that makes the lifetimes most likely (arguments as `survival`).

    Lives that do not reach beyond `delay` do not count.  With d that ended of an exposure E, the
    sum of all times beyond the delay, the rate is d / E; its interval is that of a Poisson count,
    chi2(a/2; 2d) / 2E to chi2(1 - a/2; 2d + 2) / 2E, which holds at least the `level` = 1 - a
    whatever ended the watching.

    Raises `RequestError` as `survival` does, and where nothing reaches beyond the delay.
    """
    from scipy.stats import chi2

    times, ended = _checked(times, ended)
    beyond = times > delay
    if not beyond.any():
        raise RequestError(f"delay = {delay:g}: no lifetime is longer")
    exposure, count = float((times[beyond] - delay).sum()), int(ended[beyond].sum())
    tail = (1.0 - level) / 2
    low = chi2.ppf(tail, 2 * count) / (2 * exposure) if count else 0.0
    high = chi2.ppf(1.0 - tail, 2 * count + 2) / (2 * exposure)
    return Decay(count / exposure, float(low), float(high), count, exposure, float(delay))


def share_interval(count: int, total: int, level: float = LEVEL) -> tuple[float, float]:
    """Return the ends of Wilson's interval of a share, `count` of `total` > 0."""
    from scipy.stats import binomtest

    found = binomtest(count, total).proportion_ci(level, method="wilson")
    return float(found.low), float(found.high)


def _interval(estimate: Any, level: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the log-log interval at each time; NaN, as it must be, where S is 0 or 1."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", RuntimeWarning)  # says that there are such places
        found = estimate.confidence_interval(level, method="log-log")
    return np.asarray(found.low.probabilities), np.asarray(found.high.probabilities)


def _checked(times: Any, ended: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return times as floats and `ended` as truth values, both of the same shape (n,), n > 0."""
    times, ended = np.asarray(times, dtype=float).ravel(), np.asarray(ended, dtype=bool).ravel()
    if times.size != ended.size:
        raise RequestError(f"{times.size} times and {ended.size} endings: they must be as many")
    if not times.size:
        raise RequestError("no lifetimes: nothing can be said of none")
    if not (np.isfinite(times) & (times >= 0.0)).all():
        raise RequestError("lifetimes must be finite numbers of 0 or more")
    return times, ended
