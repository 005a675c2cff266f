"""The datasets of response histories: quantities, histories, and impacts, of all systems."""

from __future__ import annotations

import math
from collections.abc import Collection
from contextlib import suppress

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.engine.records import STATUS_FLAGS
from nlds_vines.errors import RequestError
from nlds_vines.kernels.scene.codes import NOT_COMPUTED
from nlds_vines.loads.request import LOAD, HistoryRequest, axis_words
from nlds_vines.model.axis import SAMPLE, sample_scale
from nlds_vines.model.quantities import (
    DRIFT_RATIOS,
    HISTORIES,
    OF_LOADS,
    TOUCH_COLUMNS,
    Quantity,
)
from nlds_vines.model.system import System
from nlds_vines.runs.store import Arrays
from nlds_vines.scans.block import MOST_BLOCKS, Block, rectangles, sides_of_blocks

BLOCK = 256  # orbits of a block: tenths of a second, which an interruption may lose
SENSITIVE = "sensitive"  # the dataset that says whether round-off changes the number of impacts


def owners_of(request: HistoryRequest) -> dict[str, tuple[str, ...]]:
    """Return the displacements and the dampers that quantities are named after, of all systems.

    By default displacements are those where dampers hang.  There are no dampers if each system has
    one at most and calls its quantities by symbols.
    """
    systems = request.systems
    rows = request.of
    storeys = tuple(request.heights)
    if not rows:
        rows = tuple(row for one in systems if one.owning_dampers for row in one.displacements())
    if not rows:
        rows = next((one.displacements() for one in systems if one.displacements()), ())
    rows = (*rows, *storeys)
    dampers: tuple[str, ...] = ()
    if any(one.owning_dampers for one in systems):
        dampers = tuple(name for one in systems for name in one.damper_names)
    names = {"displacement": rows, "damper": dampers}
    return {dim: tuple(dict.fromkeys(each)) for dim, each in names.items()}


def owners_in(system: System, request: HistoryRequest) -> dict[str, tuple[str, ...]]:
    """Return the displacements of a request that a system has, and all dampers of the system."""
    rows: list[str] = []
    for name in owners_of(request)["displacement"]:
        with suppress(RequestError):
            rows += system.displacements([name])
    return {"displacement": tuple(rows), "damper": system.damper_names}


def named_owners(request: HistoryRequest) -> dict[str, tuple[str, ...]]:
    """Return the displacements and the dampers by whose names quantities are called."""
    dampers = (name for system in request.systems for name in system.owning_dampers)
    return {**owners_of(request), "damper": tuple(dict.fromkeys(dampers))}


def names_of_numbers(request: HistoryRequest) -> dict[str, tuple[str, int | None]]:
    """Return the datasets of all quantities by name, roof.x_max or x1_max, and the columns in them.

    The column is None in a dataset without owners.  The only damper of a system that calls its
    quantities by symbols, E2max, has a column beside the dampers of other systems.
    """
    owners = owners_of(request)
    named = named_owners(request)
    with_symbols = [system for system in request.systems if system.scene.has_symbols]
    by_symbol = {name for system in with_symbols for name in system.damper_names}
    names: dict[str, tuple[str, int | None]] = {}
    for entry in OF_LOADS:
        if not any(entry.has(system.scene) for system in request.systems):
            continue
        if entry.name in DRIFT_RATIOS and not request.heights:
            continue
        if not entry.dims or (with_symbols and entry.dims == ("damper",) and not owners["damper"]):
            names[entry.name] = entry.name, None
            continue
        (dim,) = entry.dims
        for column, owner in enumerate(owners[dim]):
            if dim == "damper" and owner in by_symbol:
                names[entry.name] = entry.name, column
            if entry.name in DRIFT_RATIOS and owner not in request.heights:
                continue
            if owner in named[dim]:
                names[f"{owner}.{entry.name}"] = entry.name, column
    return names


def in_columns(request: HistoryRequest, system: System, arrays: Arrays) -> dict[str, np.ndarray]:
    """Return the datasets of orbits of a system with a column for each owner of the request.

    Those of displacements and dampers that the system does not have are filled.
    """
    columns = dict(arrays)
    owners = owners_of(request)
    own = owners_in(system, request)
    places = {dim: [owners[dim].index(name) for name in own[dim] if owners[dim]] for dim in owners}
    for entry in (*OF_LOADS, *HISTORIES.values()):
        if not entry.dims or entry.name not in arrays:
            continue
        (dim,) = entry.dims
        values = arrays[entry.name]
        if not owners[dim]:
            columns[entry.name] = values[:, 0]  # of the only damper
        elif owners[dim] != own[dim]:
            shape = (len(values), len(owners[dim]), *values.shape[2:])
            filled = np.full(shape, entry.fill, values.dtype)
            filled[:, places[dim]] = values
            columns[entry.name] = filled
    if "touches" in arrays and len(arrays["touches"]) and owners["damper"] and own["damper"]:
        touches = arrays["touches"].copy()
        damper = [*TOUCH_COLUMNS].index("damper")
        touches[:, damper] = np.array(places["damper"])[touches[:, damper].astype(int)]
        columns["touches"] = touches
    return columns


def with_drift_ratios(request: HistoryRequest, arrays: Arrays) -> Arrays:
    """Return the datasets of orbits with the drift ratios of storeys, if heights are given."""
    if not request.heights or "x_max" not in arrays:
        return arrays
    names = owners_of(request)["displacement"]
    heights = np.array([request.heights.get(name, np.nan) for name in names])
    ratios = arrays["x_max"] / heights
    largest = np.fmax.reduce(ratios, axis=1)
    return {**arrays, "drift_ratio": ratios, "drift_ratio_max": largest}


def table_of(request: HistoryRequest, names: Collection[str]) -> Table:
    """Return the datasets of a request whose systems have quantities and histories of these names.

    They are known before anything is computed.
    """
    owners = {dim: each for dim, each in owners_of(request).items() if each}
    dims = ("system", *request.dims)
    if request.heights and "x_max" in names:
        names = {*names, *DRIFT_RATIOS}
    datasets: list[Dataset] = []

    def add(entry: Quantity, *tail: str) -> None:
        own = tuple(dim for dim in entry.dims if dim in owners)
        every = (*dims, *own, *tail)
        about = entry.dtype, entry.unit, entry.words, entry.fill
        datasets.append(Dataset(entry.name, every, *about))

    for entry in OF_LOADS:
        if entry.name in names:
            add(entry)
    for entry in HISTORIES.values():
        if entry.name in names:
            add(entry, "time")
    if not request.vary:
        words = "1 if loads larger by 1e-12 of themselves give other numbers of impacts; -1: none"
        datasets.append(Dataset(SENSITIVE, dims, "int8", "1", words, -1))
    words = "how an orbit ended"
    datasets.append(Dataset("status", dims, "int8", "1", words, NOT_COMPUTED, STATUS_FLAGS))
    lengths = {scale.name: scale.values.size for scale in scales_of(request)}
    return Table.of(datasets, lengths)


def blocks_of(request: HistoryRequest) -> list[Block]:
    """Return the blocks, each of one system: all of it with histories, else so many orbits."""
    shape = (len(request.systems), *request.shape)
    most = max(BLOCK, math.ceil(math.prod(shape) / MOST_BLOCKS))
    sides = [1, *sides_of_blocks(request.shape, most)]
    return [Block(index, slices) for index, slices in enumerate(rectangles(shape, sides))]


def scales_of(request: HistoryRequest) -> list[Scale]:
    """Return the dimensions of an archive with their values."""
    names = np.array([system.name for system in request.systems], dtype=object)
    scales = [Scale("system", names, "1", "system"), Scale("time", request.times, "s", "time")]
    if request.load.suite:
        records = np.array(request.load.names, dtype=object)
        scales.append(Scale(LOAD, records, "1", "record of the suite"))
    if request.sampled is None:
        for axis in request.vary:
            scales.append(Scale(axis.name, axis.values, *axis_words(request, axis.name)))
    else:
        scales.append(sample_scale(request.sampled.count))
    for dim, each in owners_of(request).items():
        if each:
            scales.append(Scale(dim, np.array(each, dtype=object), "1", dim))
    return scales


def samples_in(request: HistoryRequest) -> list[tuple[Dataset, np.ndarray]]:
    """Return the columns of a table of samples as datasets; none without such a table."""
    columns = request.columns if request.sampled else {}
    return [
        (Dataset.real(name, (SAMPLE,), *axis_words(request, name)), values)
        for name, values in columns.items()
    ]


def impacts_in(touches: np.ndarray) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the dimension and the datasets of impacts (impacts, columns) of all systems.

    The first column is the number of the system, the others are `TOUCH_COLUMNS`.
    """
    if not len(touches):
        return [], []
    columns = {"system": ("1", "number of the system, from 0"), **TOUCH_COLUMNS}
    datasets = [
        (Dataset.real(f"impact_{name}", ("contact",), *about), values)
        for (name, about), values in zip(columns.items(), touches.T, strict=True)
    ]
    return [Scale.counted("contact", len(touches), "impact, of all systems", 1)], datasets
