"""The results of a scan, cell by cell, as plain arrays: of an archive, or of a scan under way."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.archives import archive
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.blocks import Block
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.bifurcation.result import CellStart, recorded_start, system_at, values_at
from nlds_vines.errors import RequestError
from nlds_vines.model.axis import Axis
from nlds_vines.model.host_system import HostSystem
from nlds_vines.model.quantities import BY_NAME, COORDINATES, ERROR, QUANTITIES, TOUCHED, drawn_in
from nlds_vines.model.ratios import frequency_in, frequency_unit, meant_by
from nlds_vines.model.system import System
from nlds_vines.orbits.records import NOT_COMPUTED

MOST_SECTION = 2**24  # numbers of sections in memory (128 MB); each of a larger map is shortened
MOST_LANES = 4_000_000  # the most orbits of a map on a page: their results take some gigabytes

PARTS = ("damper", "displacement")  # dimensions along which a host has a number for each name
# datasets with one number for each orbit or for each of its parts, the most important first
_OF_ORBITS = tuple(
    dict.fromkeys(one.name for one in QUANTITIES if one.single or not {*PARTS}.isdisjoint(one.dims))
)
TOUCHES = drawn_in(TOUCHED)  # the datasets with a number for each touch, which only diagrams show
MOST_PLANES = 6  # the most phase planes of a host

_PLAIN = (*_OF_ORBITS, "capture", "status", "label", "multipliers", "orbit_point")


def symbols_of(name: str) -> tuple[str, str]:
    """Return the symbols of a displacement and of its rate: x₂ and ẋ₂, x of roof and ẋ of roof."""
    symbol = COORDINATES[name][1] if name in COORDINATES else f"x of {name}"
    return symbol, f"ẋ{symbol[1:]}"


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
        """The numbers of each orbit by name; those of a host's parts are `x_max:roof`."""
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
                numbers[f"{name}:{part}"] = Number(f"{title}, {part}", entry.unit, name, place)
        return numbers

    @cached_property
    def planes(self) -> tuple[str, ...]:
        """The displacements of the state whose phase planes are shown.

        Of a host, those of its dampers and of what they hang on.
        """
        system: Any = self.scan.system
        places = system.scene.components[::2]
        if not isinstance(system, HostSystem):
            return tuple(places)
        names = (*system.displacements(), *(damper.name for damper in system.dampers))
        return tuple(name for name in names if name in places)[:MOST_PLANES] or places[:1]

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
