"""Many orbits under loads in one call of the kernels, each with its numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nlds_vines.kernels.cells.load_numbers import (
    ORBIT_NUMBERS,
    Asked,
    Loads,
    Told,
    fill_rates,
    fly_lanes,
)
from nlds_vines.kernels.cells.load_orbit import EDGE_SUMS
from nlds_vines.kernels.motion.flight import ORDER, REACH
from nlds_vines.kernels.motion.load_cells import sums_of
from nlds_vines.kernels.scene.codes import RESPONSE_COLUMNS
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import cell_type
from nlds_vines.orbits.compilation import Compilation, Needed
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.load_flight import InCells
from nlds_vines.orbits.simulation import room_for_impacts
from nlds_vines.orbits.solver_settings import chosen_settings
from nlds_vines.runs.progress import Tell

METHOD = "exact"

_SUMS = getattr(sums_of, "entry", sums_of)


class LoadBatch:
    """Follows orbits of one scene under loads; what all of them share is prepared once.

    Any number of threads may call `longest` and `run` at a time.
    """

    def __init__(
        self,
        scene: Scene,
        shaken: bool,
        tolerance: float | str | None = None,
        tell: Tell | None = None,
    ) -> None:
        """Prepare for cells of a `scene`, and compile what is not compiled yet.

        Arguments: whether the ground is `shaken` by the loads; the `tolerance` of contacts, as of
        `simulate`; `tell` takes what is waited for.
        """
        asked = {"tolerance": tolerance, "contact_steps": None, "nodes": None, "period_steps": None}
        self._scene, self._shaken = scene, True if shaken else None
        self._parts = parts_of(METHOD, scene, chosen_settings(METHOD, asked))
        needed = Needed(scene.key, METHOD, ("response history",))
        kernels = dict.fromkeys((fly_lanes, fill_rates), "orbit")
        with Compilation(needed, tell, helped=False).followed(kernels):
            nothing = np.zeros(0, cell_type(scene))
            self.longest(nothing)
            self.run(nothing, [], np.zeros((0, 4)), Asked(np.zeros(3), 0.0))

    def longest(self, cells: np.ndarray) -> np.ndarray:
        """Return how long a cell of a load may be (lanes,) [s] for cells (lanes,) of the scene."""
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
    ) -> Told:
        """Follow one orbit for each cell, from the first edge of its load to its last.

        Arguments:
            cells: (lanes,) of the scene, as `System.cells` returns them.
            loads: one for each, in cells no longer than `longest`.
                Those that share their `rows` are handed on once.
            starts: (lanes, 4) states x1, v1, r, s before the first jump; zeros at rest.
            asked: what is asked of each orbit beside its response.
            histories: whether the results include states and energies at all edges.

        Returns numbers, response, largest energies and status lane by lane (`load_numbers.Told`).
        """
        lanes, walls = len(cells), bool(self._scene.walls)
        edges = max((len(load.edges) for load in loads), default=0) if histories else 0
        shape = (lanes, edges) if histories else (0, 0)
        results = Told(
            numbers=np.full((lanes, ORBIT_NUMBERS), np.nan),
            response=np.full((lanes, RESPONSE_COLUMNS), np.nan),
            peak=np.full((lanes, 2), np.nan),
            violation=None if self._scene.limit is None else np.zeros((lanes, 3)),
            impacts=room_for_impacts(0) if walls else None,
            states=np.full((*shape, 4), np.nan),
            sums=np.full((*shape, EDGE_SUMS), np.nan),
            status=np.zeros(lanes, np.int64),
        )
        fly_lanes(
            0, lanes, self._parts, cells.view(np.recarray), _flat(loads, self._shaken),
            np.ascontiguousarray(starts, dtype=float), asked, results,
        )  # fmt: skip
        return results


def _flat(loads: Sequence[InCells], shaken: bool | None) -> Loads:
    """Return loads one behind the other, those with the same rows once."""
    places: dict[int, int] = {}
    edges, rows, jumps = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
    first, blow = np.zeros(len(loads), np.int64), np.zeros(len(loads), np.int64)
    end = jumped = 0
    for lane, load in enumerate(loads):
        count = len(load.edges)
        if id(load.rows) not in places:
            places[id(load.rows)] = end
            edges.append(load.edges)
            rows += [load.rows.ravel(), np.zeros(ORDER + 1)]
            end += count
        jumps.append(np.zeros(count) if load.jumps is None else load.jumps)
        first[lane], blow[lane], jumped = places[id(load.rows)], jumped, jumped + count
    after = first + np.array([len(load.edges) for load in loads], np.int64)
    flat = np.concatenate(rows)
    return Loads(
        np.concatenate(edges), flat, _SUMS(flat), np.concatenate(jumps), first, after, blow, shaken
    )
