"""What is computed in the background: a part of a map, a new scan, orbits, kernels.

Each scan has its own thread, and all orbits share one.  A scan asks before each block whether it
was cancelled, so a page that is closed leaves nothing running.
"""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable
from dataclasses import replace
from queue import SimpleQueue
from typing import Any

import numpy as np

from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.request import Scan
from nlds_vines.errors import RequestError
from nlds_vines.explore.live_orbit import live_orbit
from nlds_vines.explore.map_data import Stored, empty
from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import described
from nlds_vines.model.ratios import axes_of_parameters
from nlds_vines.runs.progress import Clock

MOST_ORBITS = 40_000
"""The most orbits of a part that is computed finer: about a minute on two processors."""

FEWEST = 3
"""The fewest cells along each axis."""

LOADING, READY = "loading the kernels", ""
COMPILING = "compiling the kernels, once, for half a minute or so"
"""The states of the kernels, as the page writes them."""


LAST_SECONDS = 1.0
"""Seconds for which the end of the command waits for the block under way."""

Range = tuple[float, float]

_PART = ", a part of it"  # at the end of a title


def compiling(seconds: float) -> str:
    """Return the state of the kernels after so many seconds of compiling."""
    return COMPILING if seconds < 1.0 else f"{COMPILING}: {seconds:.0f} s so far"


def finer(scan: Scan, ranges: tuple[Range, ...], settings: dict[str, float] | None = None) -> Scan:
    """Return a scan of a part of the map with as many cells as the whole map has.

    Arguments: `ranges` (low, high) of the axes [SI units]; `settings`, new values of parameters
    that are not varied.

    A part of more than `MOST_ORBITS` orbits has fewer cells.  Raises `RequestError` for an empty
    range and for values that the system refuses.
    """
    share = min(1.0, MOST_ORBITS / scan.lanes) ** (1 / len(scan.axes))
    axes = []
    for axis, (low, high) in zip(scan.axes, ranges, strict=True):
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise RequestError(f"{axis.name} from {low!r} to {high!r} is no range of cells")
        entry = described(axis.name)
        first, last = max(low, entry.low), min(high, entry.high)
        if entry.above and first <= entry.low:
            first = min(entry.low + 1e-3 * (high - entry.low), high)
        if first >= last:
            raise RequestError(f"{axis.name} from {low:g} to {high:g}: it must be {entry.allowed}")
        count = max(FEWEST, round(axis.values.size * share))
        part = Axis.spaced(axis.name, first, last, count)
        if axis.stated is not None:
            one = float(axis.values[-1] / axis.stated.values[-1])
            stated = Axis.spaced(axis.stated.name, first / one, last / one, count)
            (part,) = axes_of_parameters((stated,), scan.system.scene, scan.system.parameters, ())
        axes.append(part)
    system = scan.system.with_(**settings) if settings else scan.system
    return replace(
        scan, axes=tuple(axes), system=system, title=scan.title.removesuffix(_PART) + _PART
    )


class Job(threading.Thread):
    """A scan that is computed in its own thread, block after block.

    Attributes: the `results`; how many orbits are `done` of the `total`; the `error` that ended it;
    a `note` on what precedes the first block; whether it was `cancelled`.
    """

    def __init__(self, scan: Scan, changed: Callable[[], object], unit: str | None = None) -> None:
        """Prepare to compute `scan`, which calls `changed` after every block; `unit` as `empty`."""
        super().__init__(name="refining", daemon=True)
        self.results = empty(scan, unit)
        self.done, self.total = 0, scan.lanes
        self.error = self.note = ""
        self.cancelled = False
        self._changed = changed

    @property
    def share(self) -> float:
        return self.done / self.total

    def _tell(self, note: str, seconds: float = 0.0) -> None:
        self.note = note
        if not self.cancelled:
            self._changed()

    def run(self) -> None:
        from nlds_vines.bifurcation.run import Computer

        scan = self.results.scan
        try:
            computer = Computer(scan, tell=self._tell, helped=False)
            for block in blocks_of(scan):
                if self.cancelled:
                    break
                self.results.put(block, computer.block(block))
                self.done += block.cells * scan.starts
                self._tell("")
        except (RequestError, MemoryError) as error:
            self.error = str(error) or type(error).__name__
            self._tell(self.note)


class Opened:
    """What all pages share: a map of an archive or one under way, the orbits' thread, the kernels.

    `listeners` are called, in the threads of the work, when results are added and when the state
    of the kernels changes.
    """

    def __init__(self, source: Stored | Scan, unit: str | None = None) -> None:
        """Take the results in an archive, or a scan to compute; `unit` as `empty`."""
        self.listeners: list[Callable[[], object]] = []
        self.kernels = LOADING
        self._clock: Clock | None = None
        self.job: Job | None = None
        if isinstance(source, Stored):
            self.results = source
        else:
            self.job = Job(source, self._changed, unit)
            self.results = self.job.results
        self._calls: SimpleQueue[tuple[Callable[..., object], Any]] = SimpleQueue()
        self._follows = False
        # a daemon, unlike the threads of an executor: no exit waits until it has compiled
        threading.Thread(target=self._follow, name="orbits", daemon=True).start()
        self._warming = threading.Thread(target=self._warm, name="warming", daemon=True)

    def begin(self) -> None:
        """Load or compile the kernels, then compute the scan, if there is one.

        Meanwhile garbage is not collected: the collector would search the imported modules, for a
        sixth of the time until the page can be used.
        """
        gc.disable()
        self._warming.start()

    def aside(self, call: Callable[..., object], *arguments: object) -> None:
        """Call something in the thread that follows the orbits of all pages, one at a time."""
        self._calls.put((call, arguments))

    def _follow(self) -> None:
        while True:
            call, arguments = self._calls.get()
            self._follows = True
            try:
                call(*arguments)
            finally:
                self._follows = False

    def close(self) -> bool:
        """End the computation after the block under way; return True if no thread is at work.

        A compilation cannot be ended.
        """
        if self.job is not None:
            self.job.cancelled = True
            if self.job.is_alive():
                self.job.join(LAST_SECONDS)
        is_computing = self.job is not None and self.job.is_alive()
        return not (self._warming.is_alive() or self._follows or is_computing)

    def _warm(self) -> None:
        """Follow one orbit, which loads or compiles the kernels, then compute the scan."""
        from nlds_vines.kernels.numerics.compiling import told_of_compilations
        from nlds_vines.orbits.simulation import IntegrationError

        try:
            with told_of_compilations(self._compiles):
                cell = self.results.middle
                system = self.results.system_of(cell)
                state = self.results.start_of(cell, 0, system).state
                live_orbit(system, state, self.results.scan)
        except (RequestError, IntegrationError):
            pass  # the page shows this error if the cell is chosen
        finally:
            if self._clock is not None:
                self._clock.stop()
            gc.freeze()  # modules and kernels stay: no click waits until they are searched
            gc.enable()
        self.kernels = READY
        self._changed()
        if self.job is not None:
            self.job.start()

    def _compiles(self, kernel: object) -> None:
        if self._clock is None:
            self._clock = Clock(self._tell, compiling)

    def _tell(self, words: str, seconds: float) -> None:
        self.kernels = words
        self._changed()

    def _changed(self) -> None:
        for listener in list(self.listeners):
            listener()
