"""A part of a map computed finer, or a scan computed for the first time, in the background.

Blocks are those of the scan.  Between two blocks the work asks whether it is still wanted, so a
page that is closed leaves nothing running.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.request import Scan
from nlds_vines.errors import RequestError
from nlds_vines.explore.map_data import Stored, empty
from nlds_vines.model.axis import Axis

MOST_ORBITS = 40_000
"""The most orbits of a part that is computed finer: a minute or so on two processors."""

FEWEST = 3
"""The fewest cells along each axis."""

Range = tuple[float, float]


def finer(scan: Scan, ranges: tuple[Range, ...], settings: dict[str, float] | None = None) -> Scan:
    """Return a scan of a part of a map with as many cells as the whole map has.

    Arguments: the scan; `ranges` of its axes, (low, high) each [SI units]; `settings`, parameters
    that are not varied and have other values than in the scan.

    There are fewer cells where there would be more than `MOST_ORBITS` orbits.  Raises
    `RequestError` for an empty range and for values that the system refuses.
    """
    share = min(1.0, MOST_ORBITS / scan.lanes) ** (1 / len(scan.axes))
    axes = []
    for axis, (low, high) in zip(scan.axes, ranges, strict=True):
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise RequestError(f"{axis.name} from {low!r} to {high!r} is no range of cells")
        low, high = _within(axis.name, low, high)
        count = max(FEWEST, round(axis.values.size * share))
        axes.append(Axis.spaced(axis.name, low, high, count))
    system = scan.system.with_(**settings) if settings else scan.system
    return replace(scan, axes=tuple(axes), system=system, title=_title(scan.title))


def _within(name: str, low: float, high: float) -> Range:
    """Return the part of a range whose values the parameter may have."""
    from nlds_vines.model.parameters import described

    entry = described(name)
    inside = max(low, entry.low), min(high, entry.high)
    if entry.above and inside[0] <= entry.low:
        inside = min(entry.low + 1e-3 * (high - entry.low), high), inside[1]
    if inside[0] >= inside[1]:
        raise RequestError(f"{name} from {low:g} to {high:g}: it must be {entry.allowed}")
    return inside


def _title(title: str) -> str:
    return title if title.endswith(", a part of it") else f"{title}, a part of it"


class Job:
    """A scan that is computed in a thread of its own, block after block."""

    def __init__(self, scan: Scan, changed: Callable[[], object]) -> None:
        """Prepare to compute `scan`; `changed` is called, in that thread, after every block."""
        self.found: Stored = empty(scan)
        self.done, self.total = 0, scan.lanes
        self.error = self.note = ""  # why it ended; what it does before the first block
        self._changed, self._stop = changed, threading.Event()
        self._thread = threading.Thread(target=self._run, name="refining", daemon=True)

    def begin(self) -> None:
        """Begin to compute."""
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether it is still at work."""
        return self._thread.is_alive()

    @property
    def cancelled(self) -> bool:
        """Whether it was asked to end early."""
        return self._stop.is_set()

    @property
    def share(self) -> float:
        """The share of the orbits that are done, from 0 to 1."""
        return self.done / self.total

    def cancel(self) -> None:
        """Ask it to end after the block that is under way."""
        self._stop.set()

    def wait(self, seconds: float | None = None) -> None:
        """Wait until it has ended."""
        if self._thread.is_alive():
            self._thread.join(seconds)

    def _tell(self, text: str, seconds: float) -> None:
        """Take what must be done first: kernels that are compiled, for so many seconds by now."""
        self.note = text
        if not self._stop.is_set():
            self._changed()

    def _run(self) -> None:
        from nlds_vines.bifurcation.run import Computer

        scan = self.found.scan
        try:
            computer = Computer(scan, tell=self._tell, helped=False)
            for block in blocks_of(scan):
                if self._stop.is_set():
                    break
                self.found.put(block, computer.block(block))
                self.done += block.cells * scan.starts
                self.note = ""
                if not self._stop.is_set():
                    self._changed()
        except (RequestError, MemoryError) as error:
            self.error = str(error) or type(error).__name__
        if not self._stop.is_set():
            self._changed()
