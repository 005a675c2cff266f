"""The results of a scan, cell by cell, as plain arrays: of an archive, or of a scan under way."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.archives import archive
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.bifurcation.result import CellStart, recorded_start, system_at, values_at
from nlds_vines.engine.records import NOT_COMPUTED
from nlds_vines.errors import RequestError
from nlds_vines.model.axis import Axis
from nlds_vines.model.quantities import (
    BY_NAME,
    COUNTS_PER_CYCLE,
    ERROR,
    QUANTITIES,
    TOUCHED,
    drawn_in,
)
from nlds_vines.model.ratios import frequency_in, frequency_unit, meant_by
from nlds_vines.model.signals import Motion, displaced
from nlds_vines.model.system import System
from nlds_vines.scans.block import Block

MOST_SECTION = 2**24  # numbers of sections in memory (128 MB); each of a larger map is shortened
MOST_LANES = 4_000_000  # the most orbits of a map on a page: their results take some gigabytes

PARTS = ("damper", "displacement")  # dimensions along which a host has a number for each name
# datasets with one number for each orbit or for each of its parts, the most important first
_OF_ORBITS = tuple(
    dict.fromkeys(one.name for one in QUANTITIES if one.single or not {*PARTS}.isdisjoint(one.dims))
)
TOUCHES = drawn_in(TOUCHED)  # the datasets with a number for each touch, which only diagrams show
MOST_CURVES = 6  # the most displacements of a host, and the most dampers, that are shown

_PLAIN = (*_OF_ORBITS, "capture", "status", "label", "multipliers", "orbit_point")


class Number(NamedTuple):
    """A number of each orbit: its words, and where it is in a dataset.

    `part` is the index of one damper or displacement; of impacts by wall, all walls of a damper
    are added.
    """

    title: str
    unit: str
    dataset: str
    part: tuple[Any, ...] = (...,)
    width: str = ""  # the name of the half width of its interval

    @property
    def logarithmic(self) -> bool:
        return BY_NAME[self.dataset].scale == ERROR

    def of(self, values: np.ndarray) -> np.ndarray:
        """Return the numbers (...) in values of the dataset, NaN where there is none."""
        numbers = np.where(values == BY_NAME[self.dataset].fill, np.nan, values)[self.part]
        return np.asarray(numbers if self.part[-1] != slice(None) else numbers.sum(axis=-1))


class Curve(NamedTuple):
    """A displacement w X of the states of a system, and how it is shown.

    Attributes:
        names: of the displacement and of its rate; one without a rate has no phase plane.
        symbols: of both, on axes.
        words: in legends.
        row: w, of the displacements X of a state.
        walls: their places [m].
        is_apart: whether its history has a panel of its own.
        moved: the place in the state that a click in its phase plane sets; None if it has none.
        owner: the degree of freedom or the damper that it is of, if its symbols do not say it.
    """

    names: tuple[str, str]
    symbols: tuple[str, str]
    words: str
    row: np.ndarray
    walls: tuple[float, ...] = ()
    is_apart: bool = False
    moved: int | None = None
    owner: str = ""

    @property
    def has_plane(self) -> bool:
        return bool(self.names[1])

    def of(self, states: np.ndarray, part: int = 0) -> np.ndarray:
        """Return the displacement along states (..., components), or with `part` 1 its rate."""
        return displaced(self.row, states, part)

    def put(self, state: np.ndarray, place: Sequence[float]) -> np.ndarray:
        """Return a state with another displacement and rate, by the component `moved` alone."""
        if self.moved is None:
            raise RequestError(f"{self.symbols[0]} is not of one component: no orbit begins there")
        state = state.copy()
        for part, value in enumerate(place):
            state[self.moved + part] = 0.0
            others = float(self.of(state, part))
            state[self.moved + part] = (value - others) / self.row[self.moved // 2]
        return state


def curves_of(system: System, of: Sequence[str] = ()) -> list[Curve]:
    """Return the displacements that pages show of a system, those of its bodies first.

    Of a host, these are the displacements `of`, by default those of the degrees of freedom that
    dampers hang on, and r of each damper beside its walls.
    """
    motions = system.motions(system.displacements(of) if of else ())
    curves = []
    for motion in motions.bodies[:MOST_CURVES]:
        walls = tuple(motion.walls.values()) if motion.carrier is None else ()
        curves.append(_curve(system, motion, walls, is_apart=False))
    for stroke in motions.strokes[:MOST_CURVES]:
        curves.append(_curve(system, stroke, tuple(stroke.walls.values()), is_apart=True))
    return curves


def _curve(system: System, motion: Motion, walls: tuple[float, ...], *, is_apart: bool) -> Curve:
    symbol, rate = (_plain(one) for one in motion.symbols)
    if motion.owner:
        symbol, rate = f"{symbol} of {motion.owner}", f"{rate} of {motion.owner}"
        names, words = (symbol, rate), symbol
    elif motion.component is None:
        names, words = ("u", ""), ""
    else:
        x, v = system.scene.components[motion.component : motion.component + 2]
        names, words = (x, v), f"{motion.body} {symbol}"
    symbols = symbol, rate
    place = motion.component
    return Curve(names, symbols, words, motion.row, walls, is_apart, place, motion.owner)


def _plain(symbol: str) -> str:
    """Return a symbol in LaTeX as plain text: x₁ for x_1."""
    for latex, text in _PLAIN_SYMBOLS.items():
        symbol = symbol.replace(latex, text)
    return symbol


_PLAIN_SYMBOLS = {r"\dot{x}": "ẋ", r"\dot{r}": "ṙ", "_1": "₁", "_2": "₂", "-": " − "}


@dataclass(eq=False)
class Stored:
    """The results of a scan, cell by cell.

    Attributes:
        scan: the request.
        arrays: datasets by name, shape (*cells, starts, ...) as in an archive; `section` holds
            the last sampled periods, as many as `MOST_SECTION` allows.
        about: attributes of the archive, its provenance among them; empty for a scan under way.
        path: path of the archive; None for a scan under way.
        unit: of frequencies as they are shown, one of `ratios.UNITS`; by default the request's.
        blocks: the blocks computed so far, of a scan under way.
    """

    scan: Scan
    arrays: Mapping[str, np.ndarray]
    about: Mapping[str, Any] = field(default_factory=dict)
    path: Path | None = None
    unit: str | None = None
    blocks: list[Block] = field(default_factory=list, repr=False)
    _cache: dict[str, tuple[int, Any]] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        """Raise `RequestError` for a unit that the scan does not have."""
        scan = self.scan
        self.unit = unit = frequency_unit(self.unit, scan.document())
        varied = meant_by(scan.system.scene, [axis.name for axis in scan.axes])
        changing = {*varied, *scan.system.following(varied)}
        constant = {n: v for n, v in scan.system.parameters.items() if n not in changing}
        self._omega = frequency_in(unit, lambda name: constant.get(name, np.nan))

    def shown(self, name: str) -> tuple[str, float]:
        """Return the name shown for a parameter, and the value [SI units] that is shown as 1."""
        return self._omega if name == "omega" else (name, 1.0)

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The axes as they are shown: the frequency in its unit."""
        axes = []
        for axis in self.scan.axes:
            name, one = self.shown(axis.name)
            if axis.stated is not None and axis.stated.name == name:
                axis = axis.stated
            elif name != axis.name:
                axis = Axis(name, axis.values / one)
            axes.append(axis)
        return tuple(axes)

    @property
    def shape(self) -> tuple[int, int]:  # 1 along a second axis that there is not
        first, second = (*self.scan.shape, 1)[:2]
        return first, second

    @property
    def middle(self) -> tuple[int, int]:
        return self.shape[0] // 2, self.shape[1] // 2

    @property
    def starts(self) -> tuple[str, ...]:
        return self.scan.start.names

    def __contains__(self, name: str) -> bool:
        return name in self.arrays

    @cached_property
    def numbers(self) -> dict[str, Number]:
        """The numbers of each orbit by name; those of a host's parts are `roof.x_max`."""
        scan, scene = self.scan, self.scan.system.scene
        parts = dict(zip(PARTS, (scene.dampers, scan.of), strict=True))
        numbers = dict[str, Number]()
        for name in filter(self.arrays.__contains__, _OF_ORBITS):
            entry, (first, *others) = BY_NAME[name], (*scan.table.datasets[name].tail, "")
            title = entry.title(scene.body)
            if not first:
                numbers[name] = Number(title, entry.unit, name, width=entry.width)
            for i, part in enumerate(parts.get(first, ())):
                place = (..., i, slice(None)) if others[0] else (..., i)
                numbers[f"{part}.{name}"] = Number(f"{title}, {part}", entry.unit, name, place)
        return numbers

    @cached_property
    def planes(self) -> list[Curve]:
        return [one for one in curves_of(self.scan.system, self.scan.of) if one.has_plane]

    def lanes(self, name: str) -> np.ndarray:
        """Return a dataset of shape (n, starts, ...), the n cells in C order."""
        values = self.arrays[name]
        return values.reshape(-1, *values.shape[len(self.scan.axes) :])

    def values_of(self, cell: tuple[int, int]) -> dict[str, float]:
        """Return the varied parameters and initial conditions of a cell by name [SI units]."""
        return values_at(self.scan, cell[: len(self.scan.axes)])

    def system_of(
        self, cell: tuple[int, int], settings: Mapping[str, float] | None = None
    ) -> System:
        return system_at(self.scan, cell[: len(self.scan.axes)], settings)

    def start_of(
        self, cell: tuple[int, int], start: int, system: System,
        moved: Mapping[str, float] | None = None,
    ) -> CellStart:  # fmt: skip
        """Return where the orbit number `start` of a cell begins; see `recorded_start`."""
        place = cell[: len(self.scan.axes)]
        return recorded_start(self.scan, self.arrays, place, start, system, moved)

    def cached(self, name: str, make: Callable[[], Any]) -> Any:
        """Return `make()`, called again only if results were added since."""
        count, value = self._cache.get(name, (-1, None))
        if count != len(self.blocks):
            count, value = self._cache[name] = len(self.blocks), make()
        return value

    def put(self, block: Block, arrays: Mapping[str, np.ndarray]) -> None:
        for name, values in self.arrays.items():
            computed = arrays[name]
            if name == "section":
                computed = computed[..., -values.shape[-2] :, :]
            values[block.selection] = computed
        self.blocks.append(block)


def stored(path: str | os.PathLike[str], unit: str | None = None) -> Stored:
    """Return the results in the archive of a scan; `unit` is that of frequencies."""
    path = Path(path)
    with archive.read(path) as view:
        if view.content != SCAN:
            raise RequestError(
                f"{path} holds a {view.content}, not a scan: there is no map in it; "
                f"`nlds-vines plot {path}` draws it"
            )
        scan = view.request(SCAN, load_scan)
        arrays = {}
        for name, shape in _shapes(scan).items():
            if name not in view or name in view.axes:  # an axis may have the name of a dataset
                continue
            expected = tuple(scan.table.shape(name))
            if view.shape(name) != expected:
                raise RequestError(
                    f"{path}: dataset {name} has the shape {view.shape(name)}, its scan says "
                    f"{expected}: it is damaged"
                )
            if name == "section":
                arrays[name] = view.take(name, forcing_period=slice(-shape[-2], None))
            else:
                arrays[name] = view[name]
        for name in {*COUNTS_PER_CYCLE} & {*arrays}:
            # archives of 0.1.0 count those of the sampled window where there is no period
            arrays[name][arrays["periodicity"] == 0] = BY_NAME[name].fill
        return Stored(scan, arrays, view.attrs, path, unit)


def empty(scan: Scan, unit: str | None = None) -> Stored:
    """Return the results of a scan that begins: no cell is computed yet; `unit` as `stored`."""
    arrays: dict[str, np.ndarray] = {}
    for name, shape in _shapes(scan).items():
        dataset = scan.table.datasets[name]
        arrays[name] = np.full(shape, dataset.fill, dataset.memory_type)
    arrays["status"][...] = NOT_COMPUTED
    return Stored(scan, arrays, unit=unit)


def _shapes(scan: Scan) -> dict[str, tuple[int, ...]]:
    """Return the datasets of a scan that its page shows, with their shapes in memory."""
    if scan.lanes > MOST_LANES:
        raise RequestError(
            f"{scan.title} has {scan.lanes} orbits; a page shows up to {MOST_LANES}: "
            "`nlds-vines plot` draws any number, and a scan of a part of it can be explored"
        )
    names = (*_PLAIN, "section", *(TOUCHES if len(scan.axes) == 1 else ()))
    shapes = {name: tuple(scan.table.shape(name)) for name in names if name in scan.table.datasets}
    if "section" in shapes:
        *cells, _, components = shapes["section"]
        periods = min(scan.periods, max(1, MOST_SECTION // (scan.lanes * components)))
        shapes["section"] = (*cells, periods, components)
    return shapes
