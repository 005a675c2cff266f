"""Orbits under loads in time: a force on the structure, a polynomial in each of its cells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from nlds_vines.kernels.cells.load_numbers import (
    ORBIT_NUMBERS,
    Asked,
    LoadResults,
    Loads,
    fill_rates,
    fly_orbits,
)
from nlds_vines.kernels.cells.load_orbit import EDGE_SUMS
from nlds_vines.kernels.motion.flight import ORDER, REACH
from nlds_vines.kernels.motion.load_cells import sums_of
from nlds_vines.kernels.scene.codes import RESPONSE_COLUMNS
from nlds_vines.model.presets import cell_type
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.batch import parts_of
from nlds_vines.orbits.compilation import Compilation, Needed
from nlds_vines.orbits.kind_engine import room_for_impacts
from nlds_vines.orbits.solver_settings import chosen_settings
from nlds_vines.runs.progress import Tell

_SUMS = getattr(sums_of, "entry", sums_of)


class InCells(Protocol):
    """A force on the structure in n cells.

    In cell j it is sum_k rows[j, k] x^k with x from 0 to 1.  If the ground moves, `rows` are -m1
    times its acceleration and `jumps` minus those of its velocity; they act on both bodies, and
    positions are relative to the ground.
    """

    edges: np.ndarray  # (n + 1,) times [s]
    rows: np.ndarray  # (n, 15) coefficients of the force [N]
    jumps: np.ndarray | None  # (n + 1,) of the structure's velocity at the edges [m/s]
    share: float  # 1; 0 if the ground moves


class LoadBatch:
    """Integrates orbits of one scene under loads, in any number of threads at a time."""

    def __init__(
        self,
        scene: Scene,
        shaken: bool,
        tolerance: float | str | None = None,
        tell: Tell | None = None,
    ) -> None:
        """Prepare the constants, and compile the kernels unless the cache has them."""
        self.scene, self._shaken = scene, True if shaken else None
        self._parts = parts_of("exact", scene, chosen_settings("exact", {"tolerance": tolerance}))
        needed = Needed(scene.key, "exact", ("response history",))
        kernels = dict.fromkeys((fly_orbits, fill_rates), "orbit")
        with Compilation(needed, tell, helped=False).followed(kernels):
            nothing = np.zeros(0, cell_type(scene))
            self.longest(nothing)
            self.run(nothing, [], np.zeros((0, 4)), Asked(np.zeros(3), 0.0))

    def longest(self, cells: np.ndarray) -> np.ndarray:
        """Return the longest cell of a load [s] for each of the cells (orbits,) of the scene."""
        rates = np.zeros(len(cells))
        fill_rates(self._parts, cells.view(np.recarray), rates)
        with np.errstate(divide="ignore"):
            return REACH / rates

    def run(
        self,
        cells: np.ndarray,
        loads: Sequence[InCells],
        starts: np.ndarray,
        asked: Asked,
        histories: bool = False,
    ) -> LoadResults:
        """Integrate one orbit for each of the `cells` (orbits,), from the first edge of its load.

        Arguments: `loads` in cells no longer than `longest`; `starts` (orbits, 4), x1, v1, r, s
        before the first jump; the levels of the response quantities that are `asked`, if any;
        `histories`, whether the results include states and energies at all edges.
        """
        count, walls = len(cells), bool(self.scene.walls)
        edges = max((len(load.edges) for load in loads), default=0) if histories else 0
        shape = (count, edges) if histories else (0, 0)
        results = LoadResults(
            numbers=np.full((count, ORBIT_NUMBERS), np.nan),
            response=np.full((count, RESPONSE_COLUMNS), np.nan),
            peak=np.full((count, 2), np.nan),
            violation=None if self.scene.limit is None else np.zeros((count, 3)),
            impacts=room_for_impacts(0) if walls else None,
            states=np.full((*shape, 4), np.nan),
            sums=np.full((*shape, EDGE_SUMS), np.nan),
            status=np.zeros(count, np.int64),
        )
        # all loads after one another, those with the same rows once
        places: dict[int, int] = {}
        times, rows, jumps = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
        first, blow = np.zeros(count, np.int64), np.zeros(count, np.int64)
        end = jumped = 0
        for i, load in enumerate(loads):
            edges = len(load.edges)
            if id(load.rows) not in places:
                places[id(load.rows)] = end
                times.append(load.edges)
                rows += [load.rows.ravel(), np.zeros(ORDER + 1)]
                end += edges
            jumps.append(np.zeros(edges) if load.jumps is None else load.jumps)
            first[i], blow[i], jumped = places[id(load.rows)], jumped, jumped + edges
        after = first + np.array([len(load.edges) for load in loads], np.int64)
        flat = np.concatenate(rows)
        together = Loads(
            np.concatenate(times), flat, _SUMS(flat), np.concatenate(jumps), first, after, blow,
            self._shaken,
        )  # fmt: skip
        begun = np.ascontiguousarray(starts, dtype=float)
        records = cells.view(np.recarray)
        fly_orbits(0, count, self._parts, records, together, begun, asked, results)
        return results
