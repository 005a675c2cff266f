"""One block of cells through the kernels: from a scan's numbers to the arrays of its archive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines import refinement
from nlds_vines.arc import NODES, make_arc
from nlds_vines.evidence import COLUMNS, arrays_of
from nlds_vines.kernels import lanes
from nlds_vines.kernels.orbit import SIZE
from nlds_vines.linear import energy_alone
from nlds_vines.record import JUDGED, NOTED, OK, Dataset, components, datasets, noted, sizes
from nlds_vines.regimes import EFFORTS
from nlds_vines.scenes import SCENES, Scene
from nlds_vines.starts import random_states, start_states
from nlds_vines.system import System

if TYPE_CHECKING:
    from nlds_vines.cut import Block
    from nlds_vines.scan import Scan

RESOLUTION: Mapping[str, float] = {"exact": 28.0, "rk4": 512.0}
"""Runge-Kutta steps: of a contact that must be stepped (exact), of a forcing period (rk4)."""


@dataclass(frozen=True)
class Settings:
    """How finely a method computes: all that it discretises.

    Attributes: collocation `nodes` of a short impact (exact alone); `resolution`, Runge-Kutta steps
    of what `RESOLUTION` says.
    """

    nodes: int
    resolution: float

    @classmethod
    def of(cls, method: str) -> Settings:
        """Return those that a scan uses."""
        return cls(NODES, RESOLUTION[method])

    def refined(self, method: str) -> Settings:
        """Return settings of so much smaller an error that the difference tells that of these.

        Of exact: 16 nodes for 12 (the error falls fivefold or more with each) and 40 steps for 28
        (of order eight: 17 times); of rk4: twice the steps (of order four: 16 times).
        """
        if method == "exact":
            return Settings(self.nodes + 4, self.resolution * 10 / 7)
        return Settings(self.nodes, self.resolution * 2)


STEP = {"up": 1, "down": -1}
"""How a sweep goes along the last axis, whose values ascend."""


def method_parts(method: str, scene: Scene, nodes: int | None = None) -> tuple[Any, ...]:
    """Return what tells the kernels which parts exist: (classical, damper, near, far, arc).

    Each is None where there is no such part, and then absent from the machine code.  `nodes` sets
    the collocation nodes of a short impact.
    """
    arc = None
    if scene.walls:
        arc = make_arc() if nodes is None else make_arc(nodes)
    return (
        None if method == "exact" else True,
        True if scene.damper else None,
        True if "near" in scene.walls else None,
        True if "far" in scene.walls else None,
        arc,
    )


def cell_of(system: System) -> Any:
    """Return the kernels' record of one system."""
    return np.atleast_1d(system.cells()).view(np.recarray)[0]


@dataclass(frozen=True)
class Outputs:
    """The buffers of a block, (chains, links, ...) each; None for what was not asked for.

    Where the error is asked for, `refined` are those of the same orbits by refined settings, and
    `retraced` the error of a period.
    """

    section: np.ndarray | None
    counts: np.ndarray | None
    cycle: np.ndarray | None
    energy: np.ndarray | None
    peak: np.ndarray | None
    clearance: np.ndarray | None
    violation: np.ndarray | None
    evidence: np.ndarray | None
    ends: np.ndarray | None
    status: np.ndarray
    retraced: np.ndarray | None = None
    refined: Outputs | None = None

    @classmethod
    def of(cls, scan: Scan, shape: tuple[int, int], transient: int, periods: int) -> Outputs:
        """Allocate the buffers that the scan's `want` needs for (chains, links) of so many periods.

        `cut.lane_bytes` tells what they take.
        """
        want, scene = set(scan.want), SCENES[scan.system.kind]
        walls, judged = bool(scene.walls), bool(want & JUDGED)
        kept = noted(want, transient, periods)

        def rows(wanted: bool, *tail: int, dtype: Any = float) -> np.ndarray | None:
            return np.zeros((*shape, *tail), dtype) if wanted else None

        return cls(
            section=rows(kept > 0, kept, len(components(scan))),
            counts=rows(("impacts" in want or judged) and walls, 2, dtype=np.int64),
            cycle=rows("impacts" in want or judged, 3, dtype=np.int64),
            energy=rows("energy" in want, 2),
            peak=rows("peak" in want, 2),
            clearance=rows("clearance" in want and walls, 1),
            violation=rows(scene.limit is not None, 3),
            evidence=rows(judged, COLUMNS),
            ends=rows(judged or "error" in want, 2, SIZE),
            status=np.zeros(shape, np.int64),
        )


class Kernels:
    """The kernels for orbits of one scan at one fineness, with their constants prepared."""

    def __init__(self, scan: Scan, settings: Settings) -> None:
        """Prepare the parts that the scene of `scan` has."""
        self._scan, self._resolution = scan, settings.resolution
        self._parts = method_parts(scan.method, scan.system.scene, settings.nodes)
        self._stages = np.array(EFFORTS[scan.effort], dtype=np.int64)

    def run(self, chains: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outputs:
        """Run chains of cells (chains, links) from `starts` (chains, 4), with their verdicts."""
        outputs = Outputs.of(self._scan, (len(chains), chains.shape[1]), transient, periods)
        if outputs.clearance is not None:
            outputs.clearance[:] = np.inf
        lanes.run_lanes(
            *self._parts,
            self._resolution,
            chains.view(np.recarray),
            starts,
            transient,
            periods,
            outputs.section,
            outputs.counts,
            outputs.cycle,
            outputs.energy,
            outputs.peak,
            outputs.clearance,
            outputs.violation,
            outputs.ends,
            outputs.status,
        )
        if outputs.evidence is not None:
            self._judge(chains, outputs)
        return outputs

    def after_a_period(self, cells: np.ndarray, starts: np.ndarray) -> np.ndarray:
        """Return the states (lanes, components) one period after `starts` (lanes, 4); NaN if none.

        Arguments: the `cells` (lanes,) of the starts (x1, v1, r, s), which lie at phase zero.
        """
        chains = cells[:, np.newaxis]
        section = np.zeros((*chains.shape, 1, len(components(self._scan))))
        status = np.zeros(chains.shape, np.int64)
        lanes.run_lanes(
            *self._parts, self._resolution, chains.view(np.recarray), starts, 0, 1,
            section, None, None, None, None, None, None, None, status,
        )  # fmt: skip
        section[status != OK] = np.nan
        return section[:, 0, 0]

    def _judge(self, chains: np.ndarray, outputs: Outputs) -> None:
        """Fill the evidence of lanes that have run."""
        lanes.judge_lanes(
            *self._parts,
            self._resolution,
            chains.view(np.recarray),
            outputs.ends,
            outputs.section,
            outputs.cycle,
            self._stages,
            outputs.evidence,
            outputs.status,
        )


class Computer:
    """Computes blocks of one scan; what all blocks share is prepared once."""

    def __init__(self, scan: Scan, settings: Settings | None = None) -> None:
        """Prepare the cells and starts of `scan`; by default with the settings of its method."""
        self.scan = scan
        self._cells = scan.cells()
        self._draws = start_states(scan) if scan.start.policy == "random" else None
        settings = Settings.of(scan.method) if settings is None else settings
        self._kernels = Kernels(scan, settings)
        self._finer = None
        if "error" in scan.want:
            self._finer = Kernels(scan, settings.refined(scan.method))

    def block(self, block: Block) -> dict[str, np.ndarray]:
        """Return the datasets of a block by name, each of shape rectangle + (starts,) + tail."""
        cells = self._cells[block.selection]
        arrays = self.lanes(*self._chains(cells))
        length = sizes(self.scan)
        table = {dataset.name: dataset for dataset in datasets(self.scan)}
        return {
            name: self._in_place(arrays[name], cells.shape, dataset, length)
            for name, dataset in table.items()
        }

    def lanes(self, chains: np.ndarray, starts: np.ndarray) -> dict[str, np.ndarray]:
        """Return everything found out about chains of cells (chains, links) from their starts.

        By name of the dataset, each (chains, links, tail); some may be more than the scan wants.
        """
        outputs = self.run(chains, starts, self.scan.transient, self.scan.periods)
        return self._arrays(outputs, chains)

    def run(self, chains: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outputs:
        """Run chains of cells (chains, links) from `starts` (chains, 4) on the current threads.

        And once more by refined settings, where the scan wants the error.
        """
        outputs = self._kernels.run(chains, starts, transient, periods)
        if self._finer is None:
            return outputs
        return replace(
            outputs,
            retraced=refinement.retraced(self._finer, outputs, chains, periods),
            refined=self._finer.run(chains, starts, transient, periods),
        )

    def _chains(self, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the chains of a block of cells and the start (x1, v1, r, s) of each."""
        if sweeps := self.scan.start.sweeps:
            rows = cells.reshape(-1, cells.shape[-1])
            chains = np.concatenate([rows[:, :: STEP[sweep]] for sweep in sweeps])
            return chains, np.zeros((len(chains), 4))
        chains = np.repeat(cells.ravel(), self.scan.starts)[:, np.newaxis]
        if self._draws is None:
            return chains, np.zeros((len(chains), 4))
        states = random_states(cells, self._draws, self.scan.system.scene)
        return chains, np.ascontiguousarray(states.reshape(-1, 4))

    def _arrays(self, outputs: Outputs, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return the datasets in the order of the lanes (chains, links, tail)."""
        status = outputs.status
        arrays = {"status": status}
        if outputs.section is not None:
            arrays["section"] = outputs.section[:, :, -self.scan.periods :]
        if outputs.energy is not None:
            arrays["E1max"], arrays["E2max"] = outputs.energy[..., 0], outputs.energy[..., 1]
            with np.errstate(all="ignore"):  # without a force nothing can be reduced: NaN
                arrays["reduction"] = 1.0 - arrays["E1max"] / energy_alone(cells)
        if outputs.peak is not None:
            arrays["E1peak"], arrays["E2peak"] = outputs.peak[..., 0], outputs.peak[..., 1]
        if outputs.violation is not None:
            names = ("first_violation", "violation_depth", "violations")
            arrays |= dict(zip(names, np.moveaxis(outputs.violation, -1, 0), strict=True))
        if outputs.clearance is not None:
            arrays["clearance"] = outputs.clearance[..., 0]
        if outputs.cycle is not None:
            by_wall = outputs.cycle[..., 1:]
            arrays["impacts"], arrays["impacts_by_wall"] = by_wall.sum(axis=-1), by_wall
        counts = np.zeros((*status.shape, 2), np.int64)
        if outputs.counts is not None:
            counts = outputs.counts
            arrays["impact_rate"] = counts.sum(axis=-1) / self.scan.periods
        if outputs.evidence is not None:
            size = len(components(self.scan))
            found = arrays_of(status, outputs.evidence, counts, cells, size)
            unnoted = max(self.scan.transient - NOTED, 0)
            found["settling"][found["settling"] >= 0] += unnoted
            found["watched"] += unnoted
            arrays |= found
        if outputs.refined is not None:
            arrays |= refinement.arrays_of(outputs, outputs.refined, arrays.get("label"))
        for dataset in datasets(self.scan):
            _failed_filled(arrays[dataset.name], dataset, status)
        return arrays

    def _in_place(
        self, values: np.ndarray, shape: tuple[int, ...], dataset: Dataset, length: dict[str, int]
    ) -> np.ndarray:
        """Return values of lanes in the block's shape, failed lanes at their fill value."""
        if sweeps := self.scan.start.sweeps:
            passes = values.reshape(len(sweeps), -1, *values.shape[1:])
            ordered = (one[:, :: STEP[sweep]] for one, sweep in zip(passes, sweeps, strict=True))
            values = np.stack(list(ordered), axis=2)
        tail = tuple(length[dim] for dim in dataset.tail)
        return values.reshape(*shape, self.scan.starts, *tail)


def _failed_filled(values: np.ndarray, dataset: Dataset, status: np.ndarray) -> np.ndarray:
    """Return the values with the fill value in lanes that failed, but for what says that."""
    failed = status != OK
    if dataset.name not in ("status", "regime", "label") and failed.any():
        values[failed] = dataset.fill
    return values
