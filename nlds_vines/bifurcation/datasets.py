"""The datasets of a scan's archive: of `model.quantities` those that are recorded, its dimensions.

Blocks are checked against this table, and the archive is written by it.  `Scan.table` makes it
once.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.files import parse_toml
from nlds_vines.model.axis import Axis
from nlds_vines.model.labels import FLAGS, KEPT
from nlds_vines.model.parameters import PHASE, described
from nlds_vines.model.quantities import recorded
from nlds_vines.model.quantity import Quantity
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.records import CAPTURE_FLAGS as CAPTURE
from nlds_vines.orbits.records import STATUS_FLAGS, touches_noted
from nlds_vines.orbits.spectral_records import SpectralRecords
from nlds_vines.orbits.starts import Start


def struck(scene: Scene) -> tuple[str, ...]:
    """Return the names of the two bodies that a damper strikes; empty for a scene of one wall."""
    return scene.bodies_struck if len(scene.walls) > 1 else ()


def struck_flags(scene: Scene) -> dict[str, int]:
    """Return the code of each body that is struck, 0 at the near wall, by its name in a word."""
    return {name.replace(" ", "_"): code for code, name in enumerate(struck(scene))}


def state_scales(count: int) -> Iterator[Scale]:
    """Yield the dimensions that count what belongs to a state of so many components."""
    yield Scale.counted("multiplier", count, "Floquet multiplier, the largest modulus first", 1)
    yield Scale.counted("exponent", count, "Lyapunov exponent, the largest first", 1)
    yield Scale("part", np.array(["real", "imaginary"]), "1", "part of a complex number")


_IMPACT = "impact after the transient, counted from the first"
_FLAGS: Mapping[str, Mapping[str, int]] = {
    "regime": FLAGS,
    "spectra_agree": KEPT,
    "capture": CAPTURE,
    "status": STATUS_FLAGS,
}


@dataclass(frozen=True)
class ScanContents:
    """What the archive of a scan holds: of its axes, scene, starts, sampled periods and records.

    `spectral` says more of spectra, where any are wanted.
    """

    axes: Sequence[Axis]
    scene: Scene
    start: Start
    periods: int
    want: Collection[str]
    spectral: SpectralRecords | None = None

    def table(self) -> Table:
        """Return the datasets: those that `want` asks for, and `status`.

        Impacts and clearances exist only in scenes with a wall, the damper's energy only with a
        damper: what cannot happen in a scene takes no room in its archive.
        """
        lanes = (*(axis.name for axis in self.axes), "start")
        datasets = [
            dataset_of(entry, lanes, self.scene)
            for entry in recorded(self.scene, self.want)
            if entry.name != "start_state" or self.start.policy == "random"
        ]
        if self.spectral is not None:
            datasets = [self.spectral.in_units(dataset) for dataset in datasets]
        return Table.of(datasets, self._lengths())

    def scales(self) -> tuple[Scale, ...]:
        """Return every dimension that a dataset may have, with its values."""
        varied = (described(axis.name).scale(axis.values) for axis in self.axes)
        scene, cycle = self.scene, "sampled forcing period, counted after the transient"
        walls, starts = struck(scene), np.array(self.start.names, dtype=np.str_)
        return (
            *varied,
            Scale("start", starts, "1", "start of the orbit"),
            Scale.counted("forcing_period", self.periods, cycle, 1),
            Scale.counted("impact", self._touches, _IMPACT, 1),
            Scale("component", np.array(scene.components), "1", "component of the state"),
            *([Scale("wall", np.array(walls), "1", "what is struck")] if walls else []),
            *(state_scales(len(scene.components)) if "evidence" in self.want else ()),
            *(() if self.spectral is None else self.spectral.scales()),
        )

    @property
    def _touches(self) -> int:
        """Of how many impacts of an orbit the touch is kept."""
        return touches_noted(self.want, self.scene, self.periods)

    def _lengths(self) -> dict[str, int]:
        """Return the length of every dimension: there may be too many values to make them."""
        size, walls = len(self.scene.components), struck(self.scene)
        lengths = {axis.name: axis.values.size for axis in self.axes}
        lengths |= {"start": self.start.orbits, "forcing_period": self.periods, "component": size}
        if self._touches:
            lengths |= {"impact": self._touches}
        if walls:
            lengths |= {"wall": len(walls)}
        if "evidence" in self.want:
            lengths |= {"multiplier": size, "exponent": size, "part": 2}
        return lengths | ({} if self.spectral is None else self.spectral.lengths())


def dataset_of(entry: Quantity, lanes: tuple[str, ...], scene: Scene) -> Dataset:
    """Return the dataset of a recorded quantity; `lanes` are the dimensions of all of a scan."""
    tail = tuple(dim for dim in entry.dims if dim != "wall" or struck(scene))
    flags = struck_flags(scene) if entry.name == "impact_wall" else _FLAGS.get(entry.name)
    return entry.dataset((*lanes, *tail), scene, flags)


def begins_at_sections(view: ArchiveView) -> bool:
    """Tell whether all orbits of a scan begin at phase zero, as points of attractors lie."""
    start = parse_toml(view.text("scan"), "the attribute scan").get("start", {})
    return PHASE not in view.axes and not start.get(PHASE)
