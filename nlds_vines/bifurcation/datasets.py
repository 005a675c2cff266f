"""The datasets of a scan's archive: of `model.quantities` those that are recorded, its dimensions.

Blocks are checked against this table, and the archive is written by it.  `Scan.table` makes it
once.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import described
from nlds_vines.model.quantities import SPEEDS, recorded
from nlds_vines.model.quantity import Quantity
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.labels import FLAGS, KEPT
from nlds_vines.orbits.spectral_records import SpectralRecords
from nlds_vines.orbits.starts import Start
from nlds_vines.orbits.status_words import STATUS


def struck(scene: Scene) -> tuple[str, ...]:
    """Return the names of the two bodies that a damper strikes; empty for a scene of one wall."""
    return tuple(scene.struck[wall] for wall in scene.walls) if len(scene.walls) > 1 else ()


def bodies_of(scene: Scene) -> tuple[str, ...]:
    """Return what has an energy, in words."""
    first = "primary structure" if scene.body == "structure" else scene.body
    return (first, "damper") if scene.damper else (first,)


def scales_of(
    axes: Sequence[Axis],
    scene: Scene,
    start: Start,
    periods: int,
    want: Collection[str],
    spectral: SpectralRecords | None = None,
) -> tuple[Scale, ...]:
    """Return every dimension that a dataset of a scan may have, with its values."""
    varied = (
        Scale(axis.name, axis.values, described(axis.name).unit, described(axis.name).meaning)
        for axis in axes
    )
    cycles = np.arange(1, periods + 1, dtype=np.int32)
    walls = struck(scene)
    return (
        *varied,
        Scale("start", np.array(start.names, dtype=np.str_), "1", "start of the orbit"),
        Scale("cycle", cycles, "1", "sampled forcing period, counted after the transient"),
        *([_speed_scale(periods)] if scene.walls and "speeds" in want else []),
        Scale("component", np.array(scene.components), "1", "component of the state"),
        *([Scale("wall", np.array(walls), "1", "what is struck")] if walls else []),
        *(state_scales(len(scene.components)) if "evidence" in want else ()),
        *(() if spectral is None else spectral.scales()),
    )


def state_scales(count: int) -> Iterator[Scale]:
    """Yield the dimensions that count what belongs to a state of so many components."""
    order = np.arange(1, count + 1, dtype=np.int32)
    yield Scale("multiplier", order, "1", "Floquet multiplier, the largest modulus first")
    yield Scale("exponent", order, "1", "Lyapunov exponent, the largest first")
    yield Scale("part", np.array(["real", "imaginary"]), "1", "part of a complex number")


_FLAGS: Mapping[str, Mapping[str, int]] = {
    "regime": FLAGS,
    "label_kept": KEPT,
    "status": {status.meaning: code for code, status in STATUS.items()},
}


def table_of(
    axes: Sequence[Axis],
    scene: Scene,
    start: Start,
    periods: int,
    want: Collection[str],
    spectral: SpectralRecords | None = None,
) -> Table:
    """Return the datasets of a scan's archive: those that `want` asks for, and `status`.

    `spectral` says more of spectra, where any are wanted.

    Impacts and clearances exist only in scenes with a wall, the damper's energy only with a
    damper: what cannot happen in a scene takes no room in its archive.
    """
    lanes = (*(axis.name for axis in axes), "start")
    datasets = [
        dataset_of(entry, lanes, scene)
        for entry in recorded(scene, want)
        if entry.name != "start_state" or start.policy == "random"
    ]
    lengths = _lengths(axes, scene, start, periods, want)
    if spectral is not None:
        datasets = [spectral.in_units(dataset) for dataset in datasets]
        lengths |= spectral.lengths()
    return Table.of(datasets, lengths)


def dataset_of(entry: Quantity, lanes: tuple[str, ...], scene: Scene) -> Dataset:
    """Return the dataset of a recorded quantity; `lanes` are the dimensions of all of a scan."""
    own = tuple(dim for dim in entry.dims if dim != "wall" or struck(scene))
    words, flags = entry.words_in(scene), _FLAGS.get(entry.name)
    return Dataset(entry.name, (*lanes, *own), entry.dtype, entry.unit, words, entry.fill, flags)


def _lengths(
    axes: Sequence[Axis], scene: Scene, start: Start, periods: int, want: Collection[str]
) -> dict[str, int]:
    """Return the length of every dimension, without its values: there may be too many of them."""
    size = len(scene.components)
    found = {axis.name: axis.values.size for axis in axes}
    found |= {"start": start.orbits, "cycle": periods, "component": size}
    if "speeds" in want:
        found |= {"impact": SPEEDS * periods}
    if struck(scene):
        found |= {"wall": len(struck(scene))}
    if "evidence" in want:
        found |= {"multiplier": size, "exponent": size, "part": 2}
    return found


def _speed_scale(periods: int) -> Scale:
    order = np.arange(1, SPEEDS * periods + 1, dtype=np.int32)
    return Scale("impact", order, "1", "impact after the transient, counted from the first")
