"""What a run did: its orbits, counted by status and regime."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.engine import records
from nlds_vines.model.labels import CHAOS, least_lifetime
from nlds_vines.runs.executors import Shard

_MOST_LABELS = 6  # regimes named in a line: as many as fit beside the bar of progress


@dataclass
class Report:
    """What a run did, or a shard of it."""

    shard: Shard | None = None
    watched: int = 0  # forcing periods for which chaotic orbits are watched
    seconds: float = 0.0
    empty: str = ""  # the remark on a shard without blocks
    missing: int = 0  # number of blocks that other shards have to compute
    lanes: int = 0
    failures: Counter[int] = field(default_factory=Counter)
    labels: Counter[str] = field(default_factory=Counter)
    violated: int = 0  # orbits that pass the limit of their scene
    depths: tuple[float, float] = (math.inf, 0.0)  # the least and the largest by which they do [m]

    @property
    def is_whole(self) -> bool:
        """Whether the archive is there: no other shard has to compute anything."""
        return not self.missing

    def note(self, arrays: Mapping[str, np.ndarray] | ArchiveView) -> None:
        status = arrays["status"]
        self.lanes += status.size
        self.failures += records.failures_in(status)
        if "label" in arrays:
            self.labels.update(arrays["label"].ravel().tolist())
        if "violations" in arrays:
            passed, depth = arrays["violations"] > 0, arrays["violation_depth"]
            self.violated += int(np.count_nonzero(passed))
            finite, (low, high) = depth[passed & np.isfinite(depth)], self.depths
            self.depths = finite.min(initial=low), finite.max(initial=high)

    def inadmissible(self) -> list[str]:
        if not self.violated:
            return []
        low, high = (f"{depth:.2g}" for depth in self.depths)
        by = high if low == high else f"{low} to {high}"
        return [
            f"inadmissible: {self.violated} of {self.lanes} orbits pass the limit, by {by} m; they "
            "are followed as if it were not there"
        ]

    def words(self) -> str:
        """Return the counts of regimes and of failures so far, for a line of progress."""
        words = [self.regimes(), f"{self.failures.total()} failed"]
        return "; ".join(filter(None, words))

    def regimes(self) -> str:
        """Return the counts of the commonest regimes, `945 T,1, 32 3T,2`; empty without labels."""
        common = self.labels.most_common(_MOST_LABELS)
        words = [f"{count} {label}" for label, count in common]
        others = self.labels.total() - sum(count for _, count in common)
        return ", ".join([*words, *([f"{others} of other regimes"] if others else [])])

    def summary(self) -> str:
        which = f"shard {self.shard}: " if self.shard else ""
        text = f"{which}{self.lanes} orbits in {self.seconds:.1f} s"
        return ": ".join(filter(None, [text, self.regimes()]))

    def remarks(self) -> list[str]:
        """Return further lines: an empty shard, passed limits, how long chaos was watched."""
        if self.empty:
            return [self.empty]
        lines = self.inadmissible()
        if CHAOS in self.labels:  # which may be transient
            lines.append(
                f"chaos: watched for {self.watched} periods each; if it is transient, its mean "
                f"lifetime is {least_lifetime(self.watched):.0f} periods or more (95 %, one orbit)"
            )
        return lines
