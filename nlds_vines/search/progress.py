"""How a search is getting on: a bar on a terminal, a plain line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from tqdm import tqdm

LINE_EVERY = 5.0
"""Seconds between lines where there is no terminal."""


class Progress:
    """Tells of evaluations and of the best of them; nothing when quiet."""

    def __init__(self, most: int, quiet: bool) -> None:
        """Expect at most so many evaluations: a search that has contracted stops before."""
        self._most, self._quiet = most, quiet
        self._done, self._best = 0, np.inf
        self._spoke = time.monotonic()
        self._bar: tqdm[Any] | None = None

    def __enter__(self) -> Progress:
        """Show the bar, if there is a terminal."""
        if not self._quiet and sys.stderr.isatty():
            from tqdm import tqdm

            self._bar = tqdm(total=self._most, unit="design", dynamic_ncols=True)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the bar as it is."""
        if self._bar is not None:
            self._bar.close()

    def advance(self, objectives: np.ndarray, stage: str, seed: int) -> None:
        """Say that designs were evaluated, and in which part of the search."""
        self._done += objectives.size
        if stage in ("global", "polish"):
            self._best = min(self._best, float(objectives.min()))
        state = f"{stage}, seed {seed}, best {self._best:.5g} J"
        if self._bar is not None:
            self._bar.set_postfix_str(state, refresh=False)
            self._bar.update(objectives.size)
        elif not self._quiet and time.monotonic() - self._spoke > LINE_EVERY:
            self._spoke = time.monotonic()
            print(f"{self._done} of at most {self._most} designs: {state}", file=sys.stderr)
