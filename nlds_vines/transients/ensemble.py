"""An ensemble: many orbits of one cell from different starts, how long each took, where it ended.

A lifetime is the number of forcing periods before an orbit settled.  The lifetime of an orbit that
had not settled when it was last watched is censored: it is known only to be longer.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.representation import Outlined
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.result import ScanArchive
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import TRANSIENT, by_frequency, finals
from nlds_vines.plotting.drawable import Drawable

DELAY = 50.0  # forcing periods by which orbits are on the chaotic set, or past it
LEVEL = 0.95  # confidence of all intervals, by default
NEEDED = ("label", "settling", "watched")  # the datasets of regime, settling and evidence

_NO_LIFETIME = ("failed", "quasiperiodic", "")
"""Final regimes that have no known time of settling; "" is the label of an orbit not computed."""


# ---- lifetimes as plain arrays -------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class Survival(Outlined):
    """The Kaplan-Meier estimate (m,), a step function that falls where lifetimes end."""

    times: np.ndarray  # at which lifetimes ended, ascending
    share: np.ndarray  # that survives from each of these times on; before the first it is 1
    low: np.ndarray  # the ends of its interval: log-log; NaN where all or none survive
    high: np.ndarray

    def quantile(self, q: float) -> float:
        """Return the first time by which at least the share `q` has ended; NaN if there is none."""
        reached = np.flatnonzero(self.share <= 1.0 - q + 1e-12)
        return float(self.times[reached[0]]) if reached.size else float("nan")


@dataclass(frozen=True)
class Decay:
    """An exponential law of lifetimes beyond a delay: share(t) ~ exp(-rate (t - delay))."""

    rate: float  # per unit of the lifetimes
    low: float  # the ends of its interval
    high: float
    ended: int  # lifetimes that ended beyond the delay
    exposure: float  # the sum of all times watched beyond the delay
    delay: float

    @property
    def mean(self) -> float:
        """The mean lifetime beyond the delay; inf if none ended."""
        return 1.0 / self.rate if self.rate > 0.0 else float("inf")


def survival(times: Any, ended: Any, level: float = LEVEL) -> Survival:
    """Return the Kaplan-Meier estimate of lifetimes, with an interval of confidence `level`.

    `times` (n,) say how long each was watched, `ended` (n,) whether the lifetime ended then or only
    the watching; of both at the same time, the lifetime ends first.
    S(t) = prod over t_i <= t of (1 - d_i / n_i), with d_i that ended at t_i of n_i at risk; the
    interval is that of ln(-ln S) with Greenwood's variance, within 0 and 1 (`scipy.stats.ecdf`;
    Kaplan and Meier (1958), J. Am. Stat. Assoc. 53, 457-481).
    Raises `RequestError` for no lifetimes, and for times that are negative or not finite.
    """
    from scipy import stats

    times, ended = _checked(times, ended)
    data = stats.CensoredData(uncensored=times[ended], right=times[~ended])
    estimate, falls = stats.ecdf(data).sf, np.unique(times[ended])
    if not falls.size:
        return Survival(*[np.empty(0)] * 4)
    is_fall = np.isin(estimate.quantiles, falls)  # SciPy also lists the times of censoring
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", RuntimeWarning)  # about shares of 0 and 1
        ends = estimate.confidence_interval(level, method="log-log")
    curves = (estimate, ends.low, ends.high)
    return Survival(falls, *(curve.probabilities[is_fall] for curve in curves))


def decay(times: Any, ended: Any, delay: float = 0.0, level: float = LEVEL) -> Decay:
    """Return the exponential law beyond `delay` under which the lifetimes are most likely.

    With d lifetimes that ended and the exposure E, the sum of all times beyond the delay, the rate
    is d / E.  Its interval is that of a Poisson count, chi2(a/2; 2d) / 2E to
    chi2(1 - a/2; 2d + 2) / 2E with a = 1 - `level`; its confidence is at least `level`.
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


def _checked(times: Any, ended: Any) -> tuple[np.ndarray, np.ndarray]:
    times, ended = np.asarray(times, dtype=float).ravel(), np.asarray(ended, dtype=bool).ravel()
    if times.size != ended.size:
        raise RequestError(f"{times.size} times and {ended.size} endings: must be as many")
    if not times.size:
        raise RequestError("no lifetimes given: at least one is needed")
    if not (np.isfinite(times) & (times >= 0.0)).all():
        raise RequestError("lifetimes must be finite numbers of 0 or more")
    return times, ended


# ---- orbits --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Share:
    """The share of the starts that ended in a regime."""

    label: str
    count: int
    through_chaos: int  # those of them that passed through chaos
    total: int
    low: float  # the ends of Wilson's interval of the share, from 0 to 1
    high: float

    @property
    def share(self) -> float:
        return self.count / self.total


@dataclass(frozen=True, repr=False)
class Ensemble(Drawable):
    """The lifetimes and final regimes of the starts of one cell.

    Parameters
    ----------
    labels : (n,) object ndarray
        The regime of each start.
    settling : (n,) ndarray
        Forcing periods until it settled, -1 if it did not.
    watched : (n,) ndarray
        Forcing periods for which it was watched; NaN if it failed.
    delay : float
        Forcing periods from which the exponential law is fitted.
    level : float
        Confidence of all intervals.
    path : ArchivePath, optional
        The archive of its orbits.

    Examples
    --------
    >>> import numpy as np
    >>> import nlds_vines as nv
    >>> labels = np.array(["T,1", "transient chaos to T,1", "chaos"], dtype=object)
    >>> ensemble = nv.Ensemble(labels, np.array([10, 300, -1]), np.array([720.0, 720.0, 3720.0]))
    >>> [(share.label, share.count) for share in ensemble.shares]
    [('T,1', 2), ('chaos', 1)]
    >>> ensemble.times.tolist(), ensemble.ended.tolist()
    ([10.0, 300.0, 3720.0], [True, True, False])
    """

    drawn_by = "nlds_vines.transients.picture"

    labels: np.ndarray
    settling: np.ndarray
    watched: np.ndarray
    delay: float = 0.0
    level: float = LEVEL
    path: ArchivePath | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        """Raise `RequestError` unless there are as many of each, and at least one."""
        sizes = {np.size(self.labels), np.size(self.settling), np.size(self.watched)}
        if len(sizes) > 1 or sizes == {0}:
            raise RequestError("an ensemble needs labels, settling and watched of as many starts")

    @property
    def request(self) -> Scan:
        """The scan of its starts, with which the same is computed again."""
        return ScanArchive.of(self.archive).request

    @cached_property
    def counted(self) -> np.ndarray:
        """Which starts have a lifetime, (n,): all whose final regime has a time of settling."""
        return ~np.isin(finals(self.labels).astype(np.str_), _NO_LIFETIME)

    @property
    def times(self) -> np.ndarray:
        """Lifetimes [forcing periods] of the `counted` starts, or how long these were watched."""
        settled = self.settling >= 0
        return np.where(settled, self.settling, self.watched)[self.counted].astype(float)

    @property
    def ended(self) -> np.ndarray:
        """Which of `times` are whole lifetimes; the others are censored."""
        return (self.settling >= 0)[self.counted]

    @cached_property
    def survival(self) -> Survival:
        """The share that has not settled against time, by Kaplan and Meier."""
        return survival(self.times, self.ended, self.level)

    @cached_property
    def decay(self) -> Decay | None:
        """The exponential law beyond the delay; None where no lifetime is longer."""
        if not (self.times > self.delay).any():
            return None
        return decay(self.times, self.ended, self.delay, self.level)

    @cached_property
    def shares(self) -> tuple[Share, ...]:
        """The final regimes with their shares, the most frequent first."""
        total, shares = self.labels.size, []
        for label, count in by_frequency(finals(self.labels)):
            through = int((self.labels == TRANSIENT + label).sum())
            interval = share_interval(count, total, self.level)
            shares.append(Share(label, count, through, total, *interval))
        return tuple(shares)

    def lines(self) -> Iterator[str]:
        """Yield the report of the ensemble, a line at a time."""
        yield f"{'ended in':<16}{'starts':>7}  {'share':>7}  {self.level:.0%} interval"
        for entry in self.shares:
            interval = f"{entry.low:.2%} to {entry.high:.2%}"
            passed = f"; {entry.through_chaos} through chaos" if entry.through_chaos else ""
            yield f"  {entry.label:<14}{entry.count:>7}  {entry.share:>7.2%}  {interval}{passed}"
        if not self.counted.any():
            yield "lifetimes: none, no start ended in a regime that has one"
            return
        settled, total = int(self.ended.sum()), int(self.counted.sum())
        left, others = self.times[~self.ended], ""
        if left.size:
            others = f"; the others watched for {left.min():g} to {left.max():g} periods"
        yield f"settled: {settled} of {total}{others}"
        quantiles = (self.survival.quantile(q) for q in (0.5, 0.9, 0.99))
        words = (
            f"{q} by {time:g}" if np.isfinite(time) else f"{q} not yet"
            for q, time in zip(("half", "90%", "99%"), quantiles, strict=True)
        )
        yield f"  forcing periods until then: {', '.join(words)}"
        law = self.decay
        if law is None:
            yield f"  none lasted beyond {self.delay:g} periods: no law of decay"
        elif law.ended == 0:
            text = f"none ended; mean lifetime of {1 / law.high:.4g} periods or more"
            yield f"  beyond {self.delay:g} periods: {text}"
        else:
            yield (
                f"  beyond {self.delay:g} periods: mean lifetime {law.mean:.4g} periods, "
                f"{self.level:.0%} interval {1 / law.high:.4g} to {1 / law.low:.4g} "
                f"({law.ended} ended, {law.exposure:.6g} periods watched)"
            )


def is_ensemble(view: ArchiveView) -> bool:
    """Return True if a scan is an ensemble of starts in one cell, as `transients` makes it."""
    one = all(view[name].size == 1 for name in view.axes)
    return one and view["start"].size > 2 and all(name in view for name in NEEDED)


def ensemble_of(
    source: ArchiveView | str | os.PathLike[str],
    *cell: int,
    delay: float = 0.0,
    level: float = LEVEL,
) -> Ensemble:
    """Return the ensemble of one cell of an archive.

    Parameters
    ----------
    source : ArchiveView or path-like
        A scan of several starts.
    *cell : int
        The index of the cell along each varied parameter, by default 0.
    delay, level : float
        See `Ensemble`.

    Returns
    -------
    Ensemble
        Lifetimes and final regimes of the orbits of the cell.

    Raises
    ------
    RequestError
        If the archive lacks labels, settling or watched.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> system = nv.load_system("ssul-set6", omega=7.575)
    >>> archive = nv.transient_lifetimes(system, starts=5, transient=200, quiet=True).archive
    >>> nv.ensemble_of(archive).labels.size
    5
    """
    if isinstance(source, str | os.PathLike):
        with read(source) as opened:
            return ensemble_of(opened, *cell, delay=delay, level=level)
    view = source
    missing = [name for name in NEEDED if name not in view]
    if missing:
        wants = "want = ['regime', 'settling', 'evidence']"
        raise RequestError(f"{view.path} holds no {', '.join(missing)}: record {wants}")
    where = dict(zip(view.axes, cell or (0,) * len(view.axes), strict=True))
    labels, settling, watched = (view.take(name, **where) for name in NEEDED)
    path = ArchivePath.of(view.path) if all(view[name].size == 1 for name in view.axes) else None
    return Ensemble(labels, settling, watched, delay, level, path)
