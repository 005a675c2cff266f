"""What the command was given, shared by all pages: the map, its computation, the kernels."""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

from nlds_vines.bifurcation.request import Scan
from nlds_vines.errors import RequestError
from nlds_vines.explore.live_orbit import Sampling, live_orbit
from nlds_vines.explore.map_computation import Job
from nlds_vines.explore.map_data import Stored
from nlds_vines.runs.progress import Clock

LOADING, READY = "loading the kernels", "ready"
COMPILING = "compiling the kernels, once, for half a minute or so"
"""What the kernels are doing, for the page."""

LAST_SECONDS = 1.0
"""Seconds that a block under way has to end when everything ends."""


class Opened:
    """A map that pages show: an archive's, or one that is computed now.

    `listeners` are called, in threads of the work, whenever more is computed or the kernels change
    their state.
    """

    def __init__(self, found: Stored | None, scan: Scan | None = None) -> None:
        """Take what an archive holds, or a `scan` to be computed."""
        self.listeners: list[Callable[[], object]] = []
        self.kernels = LOADING
        self.waited = 0.0  # seconds since they began to be compiled
        self._clock: Clock | None = None
        self.job: Job | None = None
        if found is None:
            assert scan is not None
            self.job = Job(scan, self._changed)
            found = self.job.found
        self.found = found
        self._calls: SimpleQueue[tuple[Callable[..., object], Any]] = SimpleQueue()
        self._follows = False
        # a daemon, unlike the threads of an executor: no exit waits until it has compiled
        threading.Thread(target=self._follow, name="orbits", daemon=True).start()
        self._warming = threading.Thread(target=self._warm, name="warming", daemon=True)

    def begin(self) -> None:
        """Load the kernels, or compile them, and then compute what is to be computed.

        Meanwhile the collector of garbage rests: it would search the modules that are imported,
        for a sixth of the time until the page can be used.
        """
        gc.disable()
        self._warming.start()

    def aside(self, call: Callable[..., object], *arguments: object) -> None:
        """Call something in the thread in which all pages follow orbits, one at a time."""
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
        """End the computation after the block that is under way; return whether all is at rest.

        Compiling cannot be ended: what is compiled by then is in the cache.
        """
        jobs = [self.job] if self.job is not None else []
        for job in jobs:
            job.cancel()
            job.wait(LAST_SECONDS)
        at_work = self._warming.is_alive(), self._follows, *(job.running for job in jobs)
        return not any(at_work)

    def _warm(self) -> None:
        """Load the kernels, and compute what is to be computed."""
        try:
            self._follow_one()
        finally:
            if self._clock is not None:
                self._clock.stop()
            gc.freeze()  # modules and kernels stay: no click waits until they are searched
            gc.enable()
        self.kernels = READY
        self._changed()
        if self.job is not None:
            self.job.begin()

    def _follow_one(self) -> None:
        """Follow one orbit, so that the next one is there at once."""
        from nlds_vines.kernels.numerics.compiling import told_of_compilations
        from nlds_vines.orbits.simulation import IntegrationError

        found = self.found
        cell = middle(found)
        with told_of_compilations(self._compiles):
            try:
                system = found.system_of(cell)
                state = found.start_of(cell, 0, system).state
                live_orbit(system, state, Sampling.of(found.scan))
            except (RequestError, IntegrationError):
                pass  # the page says it where this cell is chosen

    def _compiles(self, kernel: object) -> None:
        if self._clock is None:
            self.kernels = COMPILING
            self._clock = Clock(self._wait, lambda seconds: COMPILING)

    def _wait(self, text: str, seconds: float) -> None:
        """Take for how long kernels are compiled by now."""
        self.waited = seconds
        self._changed()

    def _changed(self) -> None:
        for listener in list(self.listeners):
            listener()


def middle(found: Stored) -> tuple[int, int]:
    """Return the cell in the middle of a map."""
    first, second = found.shape
    return first // 2, second // 2
