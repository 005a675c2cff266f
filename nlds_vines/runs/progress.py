"""The progress of long work: how much is done, how fast it goes, when it will end."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tqdm import tqdm

LINE_EVERY = 5.0
"""Seconds between lines of progress where there is no terminal."""


class Progress:
    """Shows a bar on a terminal, a line every few seconds elsewhere, nothing when quiet."""

    def __init__(
        self,
        total: int | None,
        unit: str,
        *,
        done: int = 0,
        quiet: bool = False,
        at_most: bool = False,
    ) -> None:
        """Begin to count.

        Arguments: `total` pieces of work, None where it is not known, of which some are `done`
        before; `unit` is the singular of what is counted, an orbit or a design; `at_most` where the
        work may end earlier, so that no time to go is known.
        """
        self._total, self._unit, self._done, self._quiet = total, unit, done, quiet
        self._at_most = at_most
        self._began = self._printed = time.perf_counter()
        self._first = 0  # done with the first piece, most of whose time is that of compiling
        self._bar: tqdm[Any] | None = None

    def __enter__(self) -> Progress:
        """Show the bar, if there is a terminal."""
        if not self._quiet and sys.stderr.isatty():
            from tqdm import tqdm

            self._bar = tqdm(
                total=self._total, initial=self._done, unit=self._unit, dynamic_ncols=True
            )
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the bar as it is."""
        if self._bar is not None:
            self._bar.close()

    def say(self, text: str) -> None:
        """Show a line of text beside the progress."""
        if self._bar is not None:
            self._bar.write(text, file=sys.stderr)
        elif not self._quiet:
            print(text, file=sys.stderr, flush=True)

    def note(self, count: int, words: str) -> None:
        """Add `count` pieces of work; `words` say how all of them went so far."""
        self._done += count
        if self._bar is not None:
            self._bar.set_postfix_str(words, refresh=False)
            self._bar.update(count)
            return
        now = time.perf_counter()
        if self._first == 0:
            self._first, self._began = self._done, now
        elif not self._quiet and now - self._printed >= LINE_EVERY:
            self._printed = now
            rate = (self._done - self._first) / (now - self._began)
            print(f"{self._pace(rate)}; {words}", file=sys.stderr, flush=True)

    def _pace(self, rate: float) -> str:
        """Return in words how much is done, how much a second, and how long the rest will take."""
        if self._total is None:
            return f"{self._done} {self._unit}s"
        if self._at_most:
            return f"{self._done} of at most {self._total} {self._unit}s"
        left = duration((self._total - self._done) / rate)
        return f"{self._done} of {self._total} {self._unit}s, {rate:.3g} a second, {left} to go"


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
