"""An ensemble: many orbits of one cell from different starts, how long each took, where it ended.

A lifetime is the number of forcing periods before an orbit settled.  The lifetime of an orbit that
had not settled when it was last watched is censored.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.archives.archive import ArchivePath
from nlds_vines.bifurcation.result import ScanArchive
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import TRANSIENT, by_frequency, finals
from nlds_vines.plotting.drawable import Drawable
from nlds_vines.transients.survival import LEVEL, Decay, Survival, decay, share_interval, survival

if TYPE_CHECKING:
    from nlds_vines.archives.archive import ArchiveView
    from nlds_vines.bifurcation.request import Scan

NEEDED = ("label", "settling", "watched")
"""The datasets that an archive must hold; they are those of regime, settling and evidence."""

_NO_LIFETIME = ("failed", "quasiperiodic", "")
"""Final regimes that have no known time of settling; "" is the label of an orbit not computed."""


@dataclass(frozen=True)
class Share:
    """Number of `total` starts that ended in a regime, and of those that passed through chaos.

    `low` and `high` are the ends of Wilson's interval of the share, from 0 to 1.
    """

    label: str
    count: int
    through_chaos: int
    total: int
    low: float
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
        ends, total = finals(self.labels), self.labels.size
        return tuple(
            Share(
                label,
                count,
                int((self.labels == TRANSIENT + label).sum()),
                total,
                *share_interval(count, total, self.level),
            )
            for label, count in by_frequency(ends)
        )

    def lines(self) -> Iterator[str]:
        """Yield the report of the ensemble, a line at a time."""
        yield f"{'ended in':<16}{'starts':>7}  {'share':>7}  {self.level:.0%} interval"
        for entry in self.shares:
            interval = f"{entry.low:.2%} to {entry.high:.2%}"
            passed = f"; {entry.through_chaos} through chaos" if entry.through_chaos else ""
            line = f"  {entry.label:<14}{entry.count:>7}  {entry.share:>7.2%}  {interval}{passed}"
            yield line
        yield from self._lifetimes()

    def _lifetimes(self) -> Iterator[str]:
        if not self.counted.any():
            yield "lifetimes: none, no start ended in a regime that has one"
            return
        settled, total = int(self.ended.sum()), int(self.counted.sum())
        yield f"settled: {settled} of {total}{self._censored()}"
        quantiles = (self.survival.quantile(q) for q in (0.5, 0.9, 0.99))
        words = (
            f"{q} by {time:g}" if np.isfinite(time) else f"{q} not yet"
            for q, time in zip(("half", "90%", "99%"), quantiles, strict=True)
        )
        yield f"  forcing periods until then: {', '.join(words)}"
        if self.decay is None:
            yield f"  none lasted beyond {self.delay:g} periods: no law of decay"
            return
        yield f"  beyond {self.delay:g} periods: {self._law(self.decay)}"

    def _censored(self) -> str:
        """Return the words on how long the starts that did not settle were watched."""
        open_ends = self.times[~self.ended]
        if not open_ends.size:
            return ""
        return f"; the others watched for {open_ends.min():g} to {open_ends.max():g} periods"

    def _law(self, law: Decay) -> str:
        if law.ended == 0:
            return f"none ended; mean lifetime of {1 / law.high:.4g} periods or more"
        return (
            f"mean lifetime {law.mean:.4g} periods, {self.level:.0%} interval "
            f"{1 / law.high:.4g} to {1 / law.low:.4g} ({law.ended} ended, "
            f"{law.exposure:.6g} periods watched)"
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
        from nlds_vines.archives.archive import read

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
