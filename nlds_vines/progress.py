"""A long scan in view: what came of it so far, how fast it goes, when it will end."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.record import OK

if TYPE_CHECKING:
    from tqdm import tqdm

LINE_EVERY = 5.0  # seconds between lines of progress where there is no terminal
_MOST_LABELS = 6

COUNTED = ("status", "label")
"""The datasets that a tally looks at."""


@dataclass
class Tally:
    """What came of the orbits so far: how many, how many failed, how many of each regime."""

    lanes: int = 0
    failed: int = 0
    labels: Counter[str] = field(default_factory=Counter)

    def note(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Count the orbits of a block."""
        status = arrays["status"]
        self.lanes += status.size
        self.failed += int(np.count_nonzero(status != OK))
        if "label" in arrays:
            self.labels.update(arrays["label"].ravel().tolist())

    def regimes(self) -> str:
        """Return how many of the commonest regimes: `945 T,1, 32 3T,2`; empty if none is known."""
        common = self.labels.most_common(_MOST_LABELS)
        words = [f"{count} {label}" for label, count in common]
        others = self.labels.total() - sum(count for _, count in common)
        return ", ".join([*words, *([f"{others} of other regimes"] if others else [])])


class Progress:
    """A bar on a terminal, a plain line now and then elsewhere, nothing when quiet."""

    def __init__(self, tally: Tally, lanes: int, quiet: bool) -> None:
        """Follow a `tally`, in which there may be orbits already, up to so many `lanes`."""
        self._tally, self._lanes, self._quiet = tally, lanes, quiet
        self._began = self._spoke = time.perf_counter()
        self._first = 0  # orbits with the first block, whose time is mostly that of compiling
        self._bar: tqdm[Any] | None = None

    def __enter__(self) -> Progress:
        """Show the bar, if there is a terminal."""
        if not self._quiet and sys.stderr.isatty():
            from tqdm import tqdm

            done = self._tally.lanes
            self._bar = tqdm(total=self._lanes, initial=done, unit="orbit", dynamic_ncols=True)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the bar as it is."""
        if self._bar is not None:
            self._bar.close()

    def note(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Count the orbits of a block and show it."""
        self._tally.note(arrays)
        if self._bar is not None:
            self._bar.set_postfix_str(self._came_of_it(), refresh=False)
            self._bar.update(arrays["status"].size)
            return
        now = time.perf_counter()
        if self._first == 0:
            self._first, self._began = self._tally.lanes, now
        elif not self._quiet and now - self._spoke >= LINE_EVERY:
            self._spoke = now
            self._line((self._tally.lanes - self._first) / (now - self._began))

    def _line(self, rate: float) -> None:
        done, left = self._tally.lanes, self._lanes - self._tally.lanes
        text = f"{done} of {self._lanes} orbits, {rate:.3g} a second, {duration(left / rate)} to go"
        print(f"{text}; {self._came_of_it()}", file=sys.stderr, flush=True)

    def _came_of_it(self) -> str:
        regimes = self._tally.regimes()
        return (
            f"{regimes}; {self._tally.failed} failed" if regimes else f"{self._tally.failed} failed"
        )


def size(count: int) -> str:
    """Return bytes in words."""
    value, unit = float(count), "B"
    for larger in ("kB", "MB", "GB", "TB"):
        if value < 1000:
            break
        value, unit = value / 1000, larger
    return f"{value:.3g} {unit}"


def duration(seconds: float) -> str:
    """Return a duration in words."""
    if seconds < 120:
        return f"{seconds:.2g} s"
    if seconds < 7200:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
