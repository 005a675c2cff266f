"""The state of a page, a map, a cell, a start and parameters, and the sliders that set these."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, log10
from typing import NamedTuple

from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.result import CellStart
from nlds_vines.errors import RequestError
from nlds_vines.explore.live_orbit import SETTLED
from nlds_vines.explore.map_computation import Range, finer
from nlds_vines.explore.map_data import Stored
from nlds_vines.model.parameters import (
    CONTACT,
    INITIAL,
    PHASE,
    Parameter,
    component_of,
    described,
)
from nlds_vines.model.system import System

LOGARITHMIC = ("K", "E1", "E2", "A", "B", "kc", "k2", "c1", "c2", "cc", "hunt_crossley")
"""Parameters with a logarithmic slider: their values spread over orders of magnitude."""

_DECADES = 100.0  # factor to either side of a logarithmic slider
_WIDE = 2.5  # times the value, the end of a plain slider


class Chosen:
    """The state of a page.

    Attributes: `levels`, the maps computed so far, and the `place` of the shown one; the `cell` and
    the `start` in it; the `history` of the orbit; `free`, the parameters set by sliders [SI units];
    `begin`, a start that replaces that of the cell, or None.
    """

    def __init__(self, results: Stored) -> None:
        self.levels, self.place = [results], 0
        self.cell, self.start = results.middle, 0
        self.free: dict[str, float] = {}
        self.begin: CellStart | None = None
        self.history = SETTLED

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
        """Return the system of the cell with the sliders' values.

        Raises `RequestError` if the system refuses them.
        """
        free = {name: value for name, value in self.free.items() if name not in INITIAL}
        return self.results.system_of(self.cell, free)

    def begins(self, system: System) -> CellStart:
        """Return where the orbit of a `system` begins."""
        free = {name: value for name, value in self.free.items() if name in INITIAL}
        start = self.begin or self.results.start_of(self.cell, self.start, system, free)
        moved = {component_of(name): value for name, value in free.items() if name != PHASE}
        if self.begin is None or not moved or start.state is None:
            return start
        pairs = zip(system.scene.components, start.state, strict=True)
        state = tuple(moved.get(name, value) for name, value in pairs)
        return CellStart(state, "the start of the sliders")

    def values(self) -> dict[str, float]:
        """Return the values that sliders show [SI units]."""
        return {**self.scan.system.parameters, **self.results.values_of(self.cell), **self.free}

    def part(self, ranges: Sequence[Range] | None = None) -> Scan:
        """Return the scan of a part of the map, or of all of it, with the sliders' values.

        Without ranges and changed sliders it is the scan of the map itself.
        """
        varied = {axis.name for axis in self.scan.axes}
        settings = {name: value for name, value in self.free.items() if name not in varied}
        if ranges is None and not settings:
            return self.scan
        ends = [(float(axis.values[0]), float(axis.values[-1])) for axis in self.scan.axes]
        return finer(self.scan, tuple(ends if ranges is None else ranges), settings)

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
    values = {name: float(cells[cells.size // 2]) for name, cells in varied.items()}
    values |= scan.system.parameters
    if "K" in varied:  # it replaces the constants from which it would follow
        values = {name: value for name, value in values.items() if name not in CONTACT}
    specs = []
    for name, value in values.items():
        is_axis, logarithmic, (shown, one) = name in varied, False, results.shown(name)
        entry, value = described(shown), value / one
        size = abs(value) or 1.0
        if is_axis and varied[name].size > 1:
            low, high = float(varied[name][0]) / one, float(varied[name][-1]) / one
            value = min(max(value, low), high)
        elif name.removesuffix("_2") in LOGARITHMIC and value > 0:
            low, high, logarithmic = value / _DECADES, value * _DECADES, True
        elif isfinite(entry.low) and isfinite(entry.high):
            low, high = entry.low, entry.high
        elif isfinite(entry.low):
            low, high = entry.low + (size / 100 if entry.above else 0), _WIDE * size
        else:
            low, high = -_WIDE * size, _WIDE * size
        specs.append(SliderSpec(name, entry, low, high, value, is_axis, logarithmic))
    return sorted(specs, key=lambda spec: not spec.axis)
