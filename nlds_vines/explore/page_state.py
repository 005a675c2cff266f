"""The state of a page, and what is computed for it: parts of maps, orbits, kernels.

Each scan has its own thread, and all orbits share one.  A scan asks before each block whether it
was cancelled, so a page that is closed leaves nothing running.
"""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isfinite, log10
from queue import Queue
from typing import NamedTuple

from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.result import CellStart
from nlds_vines.errors import RequestError
from nlds_vines.explore.live_orbit import live_orbit
from nlds_vines.explore.map_data import Stored, empty
from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import (
    DESCRIBED,
    INITIAL,
    PHASE,
    Parameter,
    component_of,
    split_name,
)
from nlds_vines.model.ratios import axes_of_parameters
from nlds_vines.model.system import System
from nlds_vines.runs.progress import listeners

MOST_ORBITS = 40_000  # of a part that is computed finer: about a minute on two processors
FEWEST = 3  # the fewest cells along each axis

LOADING, READY = "loading the kernels", ""  # states of the kernels, as the page writes them
LAST_SECONDS = 1.0  # seconds for which the end of the command waits for the block under way

Range = tuple[float, float]

_PART = ", a part of it"  # at the end of a title

# parameters with a logarithmic slider: their values spread over orders of magnitude
LOGARITHMIC = ("K", "E1", "E2", "A", "B", "kc", "k2", "c1", "c2", "cc", "hunt_crossley")
_DECADES = 100.0  # factor to either side of a logarithmic slider
_WIDE = 2.5  # times the value, the end of a plain slider


def finer(scan: Scan, ranges: tuple[Range, ...], settings: dict[str, float] | None = None) -> Scan:
    """Return a scan of the part in `ranges` [SI units]; `MOST_ORBITS` limit the number of cells."""
    share = min(1.0, MOST_ORBITS / scan.lanes) ** (1 / len(scan.axes))
    axes = []
    for axis, (low, high) in zip(scan.axes, ranges, strict=True):
        if not (isfinite(low) and isfinite(high) and low < high):
            raise RequestError(f"{axis.name} from {low!r} to {high!r} is no range of cells")
        entry = DESCRIBED[axis.name]
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


class Chosen:
    """The state of a page.

    Attributes: `levels`, the maps computed so far, and the `place` of the shown one; the `cell` and
    the `start` in it; `free`, the parameters set by sliders [SI units]; `begin`, a start that
    replaces that of the cell, or None.
    """

    def __init__(self, results: Stored) -> None:
        self.levels, self.place = [results], 0
        self.cell, self.start = results.middle, 0
        self.free: dict[str, float] = {}
        self.begin: CellStart | None = None

    @property
    def results(self) -> Stored:
        return self.levels[self.place]

    @property
    def scan(self) -> Scan:
        return self.results.scan

    def choose(self, cell: Sequence[int], start: int) -> None:
        """Choose a cell and a start; sliders of the axes take the cell's values."""
        (first, second), sides = cell, self.results.shape
        if not (0 <= first < sides[0] and 0 <= second < sides[1]):
            raise RequestError(f"there is no cell {first}, {second}")
        if not 0 <= start < len(self.results.starts):
            raise RequestError(f"there is no start {start}")
        self.cell, self.start, self.begin = (first, second), start, None
        for axis in self.scan.axes:
            self.free.pop(axis.name, None)

    def system(self) -> System:
        """Return the system of the cell with the sliders' values, which it may refuse."""
        free = {name: value for name, value in self.free.items() if name not in INITIAL}
        return self.results.system_of(self.cell, free)

    def begins(self, system: System) -> CellStart:
        free = {name: value for name, value in self.free.items() if name in INITIAL}
        start = self.begin or self.results.start_of(self.cell, self.start, system, free)
        moved = {component_of(name): value for name, value in free.items() if name != PHASE}
        if self.begin is None or not moved or start.state is None:
            return start
        pairs = zip(system.scene.components, start.state, strict=True)
        state = tuple(moved.get(name, value) for name, value in pairs)
        return CellStart(state, "the start of the sliders")

    def values(self) -> dict[str, float]:
        of_cell = self.results.system_of(self.cell).parameters
        return {**of_cell, **self.results.values_of(self.cell), **self.free}

    def part(self, ranges: Sequence[Range] | None = None) -> Scan:
        """Return the scan of a part of the map, or of all of it, with the sliders' values."""
        varied = {axis.name for axis in self.scan.axes}
        settings = {name: value for name, value in self.free.items() if name not in varied}
        if ranges is None and not settings:
            return self.scan
        if ranges is None:
            ranges = [(float(axis.values[0]), float(axis.values[-1])) for axis in self.scan.axes]
        return finer(self.scan, tuple(ranges), settings)

    def add(self, results: Stored) -> None:
        """Show another map, at the cell nearest to the chosen values; forget the later levels."""
        values = self.values()
        nearest = [int(abs(axis.values - values[axis.name]).argmin()) for axis in results.scan.axes]
        self.levels = [*self.levels[: self.place + 1], results]
        self.place += 1
        first, second = (*nearest, 0)[:2]
        self.cell = first, second

    def step(self, by: int) -> bool:
        """Go to an earlier or a later level; return False if there is none."""
        place = self.place + by
        if not 0 <= place < len(self.levels):
            return False
        self.place = place
        first, second = self.results.shape
        self.cell = min(self.cell[0], first - 1), min(self.cell[1], second - 1)
        self.start = min(self.start, len(self.results.starts) - 1)
        return True


class SliderSpec(NamedTuple):
    """The slider of a parameter: the description of what it shows, its ends and its value."""

    name: str
    entry: Parameter
    low: float
    high: float
    value: float
    axis: bool
    logarithmic: bool

    def position(self, value: float) -> float:
        if not self.logarithmic:
            return value
        return log10(value) if value > 0 else log10(self.low)


def sliders_of(results: Stored) -> list[SliderSpec]:
    """Return the sliders of a scan: first those of its axes, then all other parameters."""
    scan = results.scan
    varied = {axis.name: axis.values for axis in scan.axes}
    system: System = results.system_of(results.middle)
    values = {**system.parameters, **results.values_of(results.middle)}
    follow = system.following(varied) - {*varied}  # a.gap+ and a.gap- follow a.gap
    values = {name: value for name, value in values.items() if name not in follow}
    specs = []
    for name, value in values.items():
        is_axis, logarithmic, (shown, one) = name in varied, False, results.shown(name)
        entry, value = DESCRIBED[shown], value / one
        size = abs(value) or 1.0
        if is_axis and varied[name].size > 1:
            low, high = float(varied[name][0]) / one, float(varied[name][-1]) / one
            value = min(max(value, low), high)
        elif (split_name(name)[1] or name).removesuffix("_2") in LOGARITHMIC and value > 0:
            low, high, logarithmic = value / _DECADES, value * _DECADES, True
        elif isfinite(entry.low) and isfinite(entry.high):
            low, high = entry.low, entry.high
        elif isfinite(entry.low):
            low, high = entry.low + (size / 100 if entry.above else 0), _WIDE * size
        else:
            low, high = -_WIDE * size, _WIDE * size
        specs.append(SliderSpec(name, entry, low, high, value, is_axis, logarithmic))
    return sorted(specs, key=lambda spec: not spec.axis)


# ---- threads -------------------------------------------------------------------------------------


class Refining(threading.Thread):
    """A scan computed in its own thread, block after block; `note` says what precedes."""

    def __init__(self, scan: Scan, changed: Callable[[], object], unit: str | None = None) -> None:
        """Prepare to compute `scan`; `changed` is called after every block; `unit` as `empty`."""
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
    """What all pages share: a map of an archive or under way, the thread of orbits, the kernels."""

    def __init__(self, source: Stored | Scan, unit: str | None = None) -> None:
        """Take the results in an archive, or a scan to compute; `unit` as `empty`."""
        self.listeners: list[Callable[[], object]] = []  # of new results and states of the kernels
        self.kernels = LOADING
        self.job: Refining | None = None
        if isinstance(source, Stored):
            self.results = source
        else:
            self.job = Refining(source, self._changed, unit)
            self.results = self.job.results
        self._calls: Queue[Callable[[], object]] = Queue()
        # a daemon, unlike the threads of an executor: no exit waits until it has compiled
        threading.Thread(target=self._follow, name="orbits", daemon=True).start()

    def begin(self) -> None:
        """Load or compile the kernels, then compute the scan, if there is one.

        Meanwhile garbage is not collected: the collector would search the imported modules, for a
        sixth of the time until the page can be used.
        """
        gc.disable()
        self.aside(self._warm)

    def aside(self, call: Callable[[], object]) -> None:
        """Call something in the thread that follows the orbits of all pages, one at a time."""
        self._calls.put(call)

    def _follow(self) -> None:
        while True:
            call = self._calls.get()
            try:
                call()
            finally:
                self._calls.task_done()

    def close(self) -> bool:
        """End the computation after the block under way; return True if no thread is at work."""
        if self.job is not None:
            self.job.cancelled = True
            if self.job.is_alive():
                self.job.join(LAST_SECONDS)
        is_computing = self.job is not None and self.job.is_alive()
        return not (self._calls.unfinished_tasks or is_computing)

    def _warm(self) -> None:
        """Follow one orbit, which loads or compiles the kernels, then compute the scan."""
        from nlds_vines.engine.one_orbit import IntegrationError

        listeners.append(self._tell)
        try:
            cell = self.results.middle
            system = self.results.system_of(cell)
            state = self.results.start_of(cell, 0, system).state
            live_orbit(system, state, self.results.scan)
        except (RequestError, IntegrationError):
            pass  # the page shows this error if the cell is chosen
        finally:
            listeners.remove(self._tell)
            gc.freeze()  # modules and kernels stay: no click waits until they are searched
            gc.enable()
        self.kernels = READY
        self._changed()
        if self.job is not None:
            self.job.start()

    def _tell(self, words: str, seconds: float) -> None:
        self.kernels = words or LOADING
        self._changed()

    def _changed(self) -> None:
        for listener in list(self.listeners):
            listener()
