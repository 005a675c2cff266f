"""What is chosen on a page: the map of several, the cell, the start, what the sliders say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, log10

from nlds_vines.bifurcation.cell_orbit import CellStart
from nlds_vines.bifurcation.request import Scan
from nlds_vines.errors import RequestError
from nlds_vines.explore.live_orbit import SETTLED
from nlds_vines.explore.map_computation import Range, finer
from nlds_vines.explore.map_data import Stored
from nlds_vines.explore.shared_map import middle
from nlds_vines.model.parameters import CONTACT, INITIAL, PHASE, Parameter, component_of, described
from nlds_vines.model.system import System

LOGARITHMIC = ("K", "E1", "E2", "A", "B", "kc", "k2", "c1", "c2", "cc", "hunt_crossley")
"""Parameters that are known to an order of magnitude or spread over several."""

_DECADES = 100.0  # factor to either side of a logarithmic slider
_WIDE = 2.5  # times the value, where a plain slider ends


class Chosen:
    """The state of a page.

    Attributes: `levels`, the maps seen so far, and the `place` of the one that is seen; `cell` and
    `start` in it; the `history` of the orbit; `free`, the parameters that sliders have set [SI
    units]; `own`, a start of the user's, None for that of the cell.
    """

    def __init__(self, found: Stored) -> None:
        """Begin with the cell in the middle of a map."""
        self.levels, self.place = [found], 0
        self.cell, self.start = middle(found), 0
        self.free: dict[str, float] = {}
        self.own: CellStart | None = None
        self.history = SETTLED

    @property
    def found(self) -> Stored:
        """The map that is seen."""
        return self.levels[self.place]

    @property
    def scan(self) -> Scan:
        """Its request."""
        return self.found.scan

    def choose(self, cell: Sequence[int], start: int) -> None:
        """Take a cell and a start, which replace what sliders say of the axes."""
        (first, second), sides = cell, self.found.shape
        if not (0 <= first < sides[0] and 0 <= second < sides[1]):
            raise RequestError(f"there is no cell {first}, {second}")
        if not 0 <= start < len(self.found.starts):
            raise RequestError(f"there is no start {start}")
        self.cell, self.start, self.own = (first, second), start, None
        for axis in self.scan.axes:
            self.free.pop(axis.name, None)

    def system(self) -> System:
        """Return the system of the cell, with what sliders say.

        Raises `RequestError` if the system refuses that.
        """
        free = {name: value for name, value in self.free.items() if name not in INITIAL}
        return self.found.system_of(self.cell, free)

    def begins(self, system: System) -> CellStart:
        """Return where the orbit begins."""
        free = {name: v for name, v in self.free.items() if name in INITIAL}
        start = self.own or self.found.start_of(self.cell, self.start, system, free)
        moved = {component_of(name): v for name, v in free.items() if name != PHASE}
        if self.own is None or not moved or start.state is None:
            return start
        pairs = zip(system.scene.components, start.state, strict=True)
        return CellStart(tuple(moved.get(name, v) for name, v in pairs), "the start of the sliders")

    def slider_values(self) -> dict[str, float]:
        """Return all parameters as sliders show them."""
        return {**self.scan.system.parameters, **self.found.values_of(self.cell), **self.free}

    def part(self, ranges: Sequence[Range] | None = None) -> Scan:
        """Return the scan of a part of the map, by default of all, with what sliders say.

        Without ranges and sliders it is the very scan of the map.
        """
        varied = {axis.name for axis in self.scan.axes}
        settings = {name: value for name, value in self.free.items() if name not in varied}
        if ranges is None and not settings:
            return self.scan
        ends = [(float(axis.values[0]), float(axis.values[-1])) for axis in self.scan.axes]
        return finer(self.scan, tuple(ends if ranges is None else ranges), settings)

    def add(self, found: Stored) -> None:
        """Show another map after the one that is seen, at the cell next to the chosen values."""
        values = self.slider_values()
        nearest = [int(abs(axis.values - values[axis.name]).argmin()) for axis in found.scan.axes]
        self.levels = [*self.levels[: self.place + 1], found]
        self.place += 1
        first, second = (*nearest, 0)[:2]
        self.cell = first, second

    def step(self, by: int) -> bool:
        """Go to the map before or after; return whether there is one."""
        place = self.place + by
        if not 0 <= place < len(self.levels):
            return False
        self.place = place
        first, second = self.found.shape
        self.cell = min(self.cell[0], first - 1), min(self.cell[1], second - 1)
        self.start = min(self.start, len(self.found.starts) - 1)
        return True


@dataclass(frozen=True)
class SliderSpec:
    """The slider of a parameter: its words, its ends and its value [SI units]."""

    name: str
    symbol: str
    unit: str
    meaning: str
    low: float
    high: float
    value: float
    axis: bool
    logarithmic: bool

    def position(self, value: float) -> float:
        """Return the position on the slider that means a value."""
        if not self.logarithmic:
            return value
        return log10(value) if value > 0 else log10(self.low)

    def value_at(self, position: float) -> float:
        """Return the value that a position means."""
        return 10.0**position if self.logarithmic else position


def sliders_of(scan: Scan) -> list[SliderSpec]:
    """Return the sliders of a scan: first those of its axes, then all other parameters."""
    varied = {axis.name: axis.values for axis in scan.axes}
    known = {name: float(values[values.size // 2]) for name, values in varied.items()}
    known |= scan.system.parameters
    if "K" in varied:  # in place of the constants that it would follow from
        known = {name: value for name, value in known.items() if name not in CONTACT}
    specs = []
    for name, value in known.items():
        entry, is_axis = described(name), name in varied
        if is_axis and varied[name].size > 1:
            low, high, logarithmic = float(varied[name][0]), float(varied[name][-1]), False
            value = min(max(value, low), high)
        else:
            low, high, logarithmic = _range(entry, value)
        words = entry.symbol, entry.unit, entry.meaning
        specs.append(SliderSpec(name, *words, low, high, value, is_axis, logarithmic))
    return sorted(specs, key=lambda spec: not spec.axis)


def _range(entry: Parameter, value: float) -> tuple[float, float, bool]:
    """Return both ends of the slider of a parameter, and whether it is logarithmic."""
    if entry.name.removesuffix("_2") in LOGARITHMIC and value > 0:
        return value / _DECADES, value * _DECADES, True
    if isfinite(entry.low) and isfinite(entry.high):
        return entry.low, entry.high, False
    size = abs(value) or 1.0
    if isfinite(entry.low):
        return entry.low + (size / 100 if entry.above else 0), _WIDE * size, False
    return -_WIDE * size, _WIDE * size, False
