"""Counts of orbits: how many are done, failed, and of each regime."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.model.labels import KEPT
from nlds_vines.orbits.records import failures_in, failures_in_words
from nlds_vines.runs.progress import Progress

if TYPE_CHECKING:
    from nlds_vines.archives.archive import ArchiveView

_MOST_LABELS = 6  # regimes named in a line: as many as fit beside the bar of progress

Note = Callable[[Mapping[str, np.ndarray]], None]
"""Is called with the arrays of every block that is done."""

COUNTED = ("status", "label", "violations", "violation_depth")
"""The datasets that a tally looks at."""


@dataclass
class Tally:
    """Counts of the orbits so far: all, those that failed, those of each regime.

    `failures`: how many failed, by status.
    `violated`: those that pass the limit of their scene; `depths`: the least and the largest depth
    of these [m].
    """

    lanes: int = 0
    failures: Counter[int] = field(default_factory=Counter)
    labels: Counter[str] = field(default_factory=Counter)
    violated: int = 0
    depths: tuple[float, float] = (math.inf, 0.0)

    def note(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Count the orbits of a block."""
        status = arrays["status"]
        self.lanes += status.size
        self.failures += failures_in(status)
        if "label" in arrays:
            self.labels.update(arrays["label"].ravel().tolist())
        if "violations" in arrays:
            self._note_violated(arrays["violations"] > 0, arrays["violation_depth"])

    def _note_violated(self, passed: np.ndarray, depth: np.ndarray) -> None:
        self.violated += int(np.count_nonzero(passed))
        finite = depth[passed & np.isfinite(depth)]
        low, high = self.depths
        self.depths = finite.min(initial=low), finite.max(initial=high)

    @property
    def failed(self) -> int:
        """How many orbits failed."""
        return self.failures.total()

    def why_failed(self) -> str:
        """Return how many orbits failed, why, and what helps; empty where none did."""
        return failures_in_words(self.failures, self.lanes)

    def inadmissible(self) -> list[str]:
        """Return a line that says how many orbits pass their limit, and how far; none if none."""
        if not self.violated:
            return []
        low, high = (f"{depth:.2g}" for depth in self.depths)
        by = high if low == high else f"{low} to {high}"
        return [
            f"inadmissible: {self.violated} of {self.lanes} orbits pass the limit, by {by} m; they "
            "are followed as if it were not there"
        ]

    def follow(self, progress: Progress, arrays: Mapping[str, np.ndarray]) -> None:
        """Count the orbits of a block and show the counts of all so far."""
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


def spectral_summary(view: ArchiveView) -> str:
    """Return in one line where spectra and verdicts disagree: how many orbits, and of which."""
    agree, spectral = view["spectra_agree"], view["spectral_label"]
    which = agree == KEPT["no"]
    pairs = zip(view["label"][which].tolist(), spectral[which].tolist(), strict=True)
    counts = Counter(f"{label} with {says}" for label, says in pairs)
    words = [f"{count} {pair}" for pair, count in counts.most_common(_MOST_LABELS)]
    of = f"{np.count_nonzero(which)} of {np.count_nonzero(agree >= 0)} orbits"
    ellipsis = ", ..." if len(counts) > _MOST_LABELS else ""
    return f"spectra disagree: {of}" + (f": {', '.join(words)}{ellipsis}" if words else "")
