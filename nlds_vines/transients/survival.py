"""Statistics of lifetimes, some of which are censored: survival curve, exponential law, shares.

A lifetime that had not ended when watching stopped is censored: it is known only to be longer.
The functions take plain arrays and know nothing of orbits.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.archives.representation import Outlined
from nlds_vines.errors import RequestError

DELAY = 50.0
"""Forcing periods until lifetimes count: by then orbits are on the chaotic set, or past it."""

LEVEL = 0.95
"""Confidence of all intervals, by default."""


@dataclass(frozen=True, repr=False)
class Survival(Outlined):
    """The Kaplan-Meier estimate, a step function that falls where lifetimes end.

    Attributes, all of shape (m,):
        times: the different times at which lifetimes ended, ascending, in the unit of those.
        share: the surviving share from each of these times on; before the first it is 1.
        low, high: the ends of its interval (log-log; NaN where all or none survive).
        at_risk: how many were alive and watched just before each time.
        ended: how many ended at each time.
    """

    times: np.ndarray
    share: np.ndarray
    low: np.ndarray
    high: np.ndarray
    at_risk: np.ndarray
    ended: np.ndarray

    def quantile(self, q: float) -> float:
        """Return the first time by which at least the share `q` has ended; NaN if there is none."""
        reached = np.flatnonzero(self.share <= 1.0 - q + 1e-12)
        return float(self.times[reached[0]]) if reached.size else float("nan")


@dataclass(frozen=True)
class Decay:
    """An exponential law of lifetimes beyond a delay: share(t) ~ exp(-rate (t - delay)).

    Attributes:
        rate: per unit of the lifetimes; low, high: the ends of its interval.
        ended: how many lifetimes ended beyond the delay.
        exposure: the sum of all times watched beyond the delay.
        delay: the time from which the law holds.
    """

    rate: float
    low: float
    high: float
    ended: int
    exposure: float
    delay: float

    @property
    def mean(self) -> float:
        """The mean lifetime beyond the delay; inf if none ended."""
        return 1.0 / self.rate if self.rate > 0.0 else float("inf")


def survival(times: Any, ended: Any, level: float = LEVEL) -> Survival:
    """Return the Kaplan-Meier estimate of lifetimes.

    Arguments:
        times: how long each was watched, >= 0, shape (n,).
        ended: whether the lifetime ended then (True) or only the watching (False), shape (n,).  Of
            both at the same time, the lifetime ends first.
        level: the confidence of the interval.

    S(t) = prod over t_i <= t of (1 - d_i / n_i), with d_i that ended at t_i of n_i at risk.  The
    interval is that of ln(-ln S) with Greenwood's variance; it stays within 0 and 1.  Both are
    those of `scipy.stats.ecdf`.

    Source: Kaplan and Meier (1958), J. Am. Stat. Assoc. 53, 457-481.

    Raises `RequestError` for no lifetimes, and for times that are negative or not finite.
    """
    from scipy import stats

    times, ended = _checked(times, ended)
    data = stats.CensoredData(uncensored=times[ended], right=times[~ended])
    estimate = stats.ecdf(data).sf
    falls, count = np.unique(times[ended], return_counts=True)
    is_fall = np.isin(estimate.quantiles, falls)  # SciPy also lists the times of censoring
    low, high = _interval(estimate, level) if falls.size else (np.empty(0), np.empty(0))
    return Survival(
        times=falls,
        share=estimate.probabilities[is_fall],
        low=low[is_fall] if low.size else low,
        high=high[is_fall] if high.size else high,
        at_risk=times.size - np.searchsorted(np.sort(times), falls),
        ended=count,
    )


def decay(times: Any, ended: Any, delay: float = 0.0, level: float = LEVEL) -> Decay:
    """Return the exponential law under which the lifetimes are most likely.

    Arguments: `times`, `ended` and `level` as of `survival`; lifetimes that do not reach beyond
    `delay` are left out.

    With d lifetimes that ended and the exposure E, the sum of all times beyond the delay, the rate
    is d / E.  Its interval is that of a Poisson count, chi2(a/2; 2d) / 2E to
    chi2(1 - a/2; 2d + 2) / 2E with a = 1 - `level`; its confidence is at least `level`.

    Raises `RequestError` as `survival` does, and where no lifetime reaches beyond the delay.
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
    """Return the ends of Wilson's interval of the share `count` / `total`, with `total` > 0."""
    from scipy.stats import binomtest

    interval = binomtest(count, total).proportion_ci(level, method="wilson")
    return float(interval.low), float(interval.high)


def _interval(estimate: Any, level: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the log-log interval at each time; NaN where S is 0 or 1."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", RuntimeWarning)  # about these places
        ends = estimate.confidence_interval(level, method="log-log")
    return np.asarray(ends.low.probabilities), np.asarray(ends.high.probabilities)


def _checked(times: Any, ended: Any) -> tuple[np.ndarray, np.ndarray]:
    times, ended = np.asarray(times, dtype=float).ravel(), np.asarray(ended, dtype=bool).ravel()
    if times.size != ended.size:
        raise RequestError(f"{times.size} times and {ended.size} endings: must be as many")
    if not times.size:
        raise RequestError("no lifetimes given: at least one is needed")
    if not (np.isfinite(times) & (times >= 0.0)).all():
        raise RequestError("lifetimes must be finite numbers of 0 or more")
    return times, ended
