"""What an archive, or a scan under way, holds of every cell: plain arrays, no picture, no orbit."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.archives import archive
from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.blocks import Block
from nlds_vines.bifurcation.cell_orbit import (
    CellStart,
    Place,
    recorded_start,
    system_at,
    values_at,
)
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.errors import RequestError
from nlds_vines.model.quantities import QUANTITIES, TOUCHED, drawn_in
from nlds_vines.model.system import System
from nlds_vines.orbits.records import NOT_COMPUTED

MOST_SECTION = 2**24
"""The most numbers of sections that are kept (128 MB): of a larger map, fewer periods each."""

MOST_LANES = 4_000_000
"""The most orbits of a map on a page: some gigabytes of what is known of each."""

NUMBERS = tuple(dict.fromkeys(entry.name for entry in QUANTITIES if entry.single))
"""The datasets of one number for each start, the most telling first."""

TOUCHES = drawn_in(TOUCHED)
"""The datasets of each touch, which a diagram shows over its parameter."""

_PLAIN = (
    *NUMBERS,
    *("capture", "status", "label", "multipliers", "orbit_point"),
)


@dataclass(frozen=True)
class Stored:
    """The results of a scan, cell by cell.

    Attributes:
        scan: the request; its axes are those of the map.
        arrays: datasets by name, shape (cells, starts, ...) as an archive has them; `section`
            holds the last sampled periods, as many as `MOST_SECTION` allows.
        about: attributes of the archive: where it comes from; empty for a scan under way.
        path: of the archive; None for a scan under way.
    """

    scan: Scan
    arrays: Mapping[str, np.ndarray]
    about: Mapping[str, Any] = field(default_factory=dict)
    path: Path | None = None
    _known: dict[str, tuple[int, Any]] = field(default_factory=dict, compare=False, repr=False)
    puts: list[Block] = field(default_factory=list, compare=False, repr=False)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells along the first and the second axis; 1 where there is no second."""
        first, second = (*self.scan.shape, 1)[:2]
        return first, second

    @property
    def starts(self) -> tuple[str, ...]:
        """The names of the starts."""
        return self.scan.start.names

    def __contains__(self, name: str) -> bool:
        """Return whether a dataset is there."""
        return name in self.arrays

    def lanes(self, name: str) -> np.ndarray:
        """Return a dataset as (cells, starts, ...), the cells of the last axis side by side."""
        values = self.arrays[name]
        return values.reshape(-1, *values.shape[len(self.scan.axes) :])

    def values_of(self, cell: tuple[int, int]) -> dict[str, float]:
        """Return the varied parameters and initial conditions of a cell by name [SI units]."""
        return values_at(self.scan, self._place(cell))

    def system_of(
        self, cell: tuple[int, int], settings: Mapping[str, float] | None = None
    ) -> System:
        """Return the system of a cell; `settings` are parameters with other values than there."""
        return system_at(self.scan, self._place(cell), settings)

    def start_of(
        self,
        cell: tuple[int, int],
        start: int,
        system: System,
        moved: Mapping[str, float] | None = None,
    ) -> CellStart:
        """Return where the orbit number `start` of a cell begins, of a `system` like the cell's.

        Arguments: `moved`, the initial conditions that are other ones than those of the cell.
        """
        return recorded_start(self.scan, self.arrays, self._place(cell), start, system, moved)

    def _place(self, cell: tuple[int, int]) -> Place:
        return cell[: len(self.scan.axes)]

    def once(self, name: str, make: Callable[[], Any]) -> Any:
        """Return what `make` makes of the results: made again only after more of them came."""
        puts = len(self.puts)
        known = self._known.get(name)
        if known is None or known[0] != puts:
            self._known[name] = known = puts, make()
        return known[1]

    def put(self, block: Block, arrays: Mapping[str, np.ndarray]) -> None:
        """Take the results of a block of cells, of a scan under way."""
        for name, values in self.arrays.items():
            found = arrays[name]
            if name == "section":
                found = found[..., -values.shape[-2] :, :]
            values[block.selection] = found
        self.puts.append(block)


def stored(path: str | os.PathLike[str]) -> Stored:
    """Return what the archive of a scan holds.

    Raises `RequestError`, one line, where there is no such file, where it is damaged, and where it
    holds anything but a scan.
    """
    path = Path(path)
    with archive.read(path) as view:
        if view.content != SCAN:
            raise RequestError(
                f"{path} holds a {view.content}, not a scan: there is no map in it; "
                f"`nlds-vines plot {path}` draws it"
            )
        scan = view.request(SCAN, load_scan)
        _refuse_too_many(scan)
        _refuse_other_shape(path, view, scan)
        arrays = {name: view[name] for name in _held(view, scan) if name != "section"}
        if "section" in view:
            arrays["section"] = _sections(view, scan)
        return Stored(scan, arrays, view.attrs, path)


def empty(scan: Scan) -> Stored:
    """Return the place for the results of a scan under way: every cell is not computed yet."""
    _refuse_too_many(scan)
    arrays: dict[str, np.ndarray] = {}
    for name, dataset in scan.table.datasets.items():
        shape = scan.table.shape(name)
        if name == "section":
            shape = (*shape[:-2], _kept(scan), shape[-1])
        elif name not in _names(scan):
            continue
        dtype = object if dataset.dtype == "str" else dataset.dtype
        arrays[name] = np.full(shape, dataset.fill, dtype)
    arrays["status"][...] = NOT_COMPUTED
    return Stored(scan, arrays)


def _refuse_too_many(scan: Scan) -> None:
    """Raise `RequestError` for a map of more orbits than a page can hold."""
    if scan.lanes > MOST_LANES:
        raise RequestError(
            f"{scan.title} has {scan.lanes} orbits; a page shows up to {MOST_LANES}: "
            "`nlds-vines plot` draws any number, and a scan of a part of it can be explored"
        )


def _names(scan: Scan) -> tuple[str, ...]:
    """Return the datasets that a map, or a diagram, may be made of."""
    return (*_PLAIN, "section", *(TOUCHES if len(scan.axes) == 1 else ()))


def _held(view: ArchiveView, scan: Scan) -> list[str]:
    """Return the names of the datasets that a map is made of; an axis may have the name of one."""
    return [name for name in _names(scan) if name in view and name not in view.axes]


def _refuse_other_shape(path: Path, view: ArchiveView, scan: Scan) -> None:
    """Raise `RequestError` where the datasets are not of the shape that the scan says."""
    for name in _held(view, scan):
        if name not in scan.table.datasets:
            raise RequestError(f"{path}: dataset {name} does not belong to its scan: damaged")
        expected = tuple(scan.table.shape(name))
        if view.shape(name) != expected:
            raise RequestError(
                f"{path}: dataset {name} has the shape {view.shape(name)}, its scan says "
                f"{expected}: it is damaged"
            )


def _sections(view: ArchiveView, scan: Scan) -> np.ndarray:
    """Return the last periods of all sections, read in parts that fit into memory."""
    kept = _kept(scan)
    return view.take("section", forcing_period=slice(-kept, None))


def _kept(scan: Scan) -> int:
    """Return how many periods of each section are kept."""
    each = scan.lanes * len(scan.system.scene.components)
    return min(scan.periods, max(1, MOST_SECTION // each))
