"""How many orbits are done, how many of them failed, how many are of each regime."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from nlds_vines.orbits.status_words import OK
from nlds_vines.runs.progress import Progress

_MOST_LABELS = 6

Note = Callable[[Mapping[str, np.ndarray]], None]
"""What is told of the arrays of every block that is done."""

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

    def follow(self, progress: Progress, arrays: Mapping[str, np.ndarray]) -> None:
        """Count the orbits of a block and show what came of all so far."""
        self.note(arrays)
        regimes, failed = self.regimes(), f"{self.failed} failed"
        words = f"{regimes}; {failed}" if regimes else failed
        progress.note(arrays["status"].size, words)

    def regimes(self) -> str:
        """Return how many of the commonest regimes: `945 T,1, 32 3T,2`; empty if none is known."""
        common = self.labels.most_common(_MOST_LABELS)
        words = [f"{count} {label}" for label, count in common]
        others = self.labels.total() - sum(count for _, count in common)
        return ", ".join([*words, *([f"{others} of other regimes"] if others else [])])
