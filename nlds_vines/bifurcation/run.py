"""The kernels of a scan, block by block, and the runs of scans and response curves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.archives.dataset import Table
from nlds_vines.archives.files import parse_toml
from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.bifurcation.response_curves import CurveRequest, load_curves, numbers_of_orbits
from nlds_vines.bifurcation.result import STEP, own_states
from nlds_vines.engine import records
from nlds_vines.engine.batch import Outputs, Wanted, agreement, impacts_per_cycle, spectra_of
from nlds_vines.engine.engine import Runner, engine_for
from nlds_vines.engine.solver_settings import most_watched
from nlds_vines.engine.spectrum import SpectralRecords
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.linear_response import energy_alone
from nlds_vines.model.quantities import recorded
from nlds_vines.runs import interrupts
from nlds_vines.runs.progress import Tell
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import Arrays
from nlds_vines.scans.block import Block
from nlds_vines.scans.run import Blocks, Computes, Further, Plan, nothing_further, run_in_blocks
from nlds_vines.scans.run_report import Report

if TYPE_CHECKING:
    from nlds_vines.bifurcation.attractors import OrbitEnds

Cached = dict[object, Arrays]
"""Arrays of blocks of response curves, by the hash of the scan and the place."""


def wanted_of(scan: Scan) -> Wanted:
    """Return the records that a scan wants of whole orbits."""
    words, scene = records.plain(scan.want), scan.system.scene
    return Wanted(scene, words, scan.method, scan.effort, scan.settings)


class Computer:
    """Computes blocks of one scan; cells, starts and kernels are prepared once."""

    def __init__(self, scan: Scan, tell: Tell | None = None, *, helped: bool = True) -> None:
        self.scan = scan
        self._cells, self._tell = scan.cells(), tell
        self._quantities = {one.name: one for one in recorded(scan.system.scene, scan.want)}
        wanted = wanted_of(scan)
        self.ends: OrbitEnds | None = None
        if records.ATTRACTOR in scan.want:
            from nlds_vines.bifurcation.attractors import OrbitEnds  # with SciPy's searches

            self.ends = OrbitEnds(scan, wanted, tell, helped=helped)
        self._engine = engine_for(scan.system)
        # of the displacements whose amplitudes are recorded
        self._rows = [scan.system.displacement(name)[0] for name in scan.of]
        of = scan.of if "response" in scan.want else ()
        self.kernels = self._engine.runner(wanted, tell, of=of, helped=helped)
        self._traced: Runner | None = None  # for the states of spectra
        if scan.spectral is not None:
            states = replace(wanted, want=("section",))
            self._traced = self._engine.runner(states, tell, of=(), helped=helped)

    @property
    def table(self) -> Table:
        return self.scan.table

    def block(self, block: Block) -> dict[str, np.ndarray]:
        """Return the datasets of a block by name, each of shape rectangle + (starts,) + tail."""
        scan = self.scan
        sides = (np.arange(first, stop) for first, stop in block.slices)
        places = np.ravel_multi_index(np.ix_(*sides), scan.shape)
        if scan.start.sweeps:
            arrays = self._swept(self._cells[block.selection], places)
        else:
            numbers = places.reshape(-1, 1) * scan.starts + np.arange(scan.starts)
            arrays = self.lanes(*self.orbits(numbers.ravel()))
        datasets = {}
        for name in scan.table.datasets:
            tail = scan.table.shape(name)[len(scan.axes) :]
            datasets[name] = arrays[name].reshape(*block.shape, *tail)
        return datasets

    def _swept(self, cells: np.ndarray, places: np.ndarray) -> dict[str, np.ndarray]:
        """Return the results (rows, cells of a row, sweeps, ...) of cells and their places.

        Each row is a chain of cells for each sweep: from rest, then each where the orbit before it
        ended.
        """
        sweeps = self.scan.start.sweeps
        rows = cells.reshape(-1, cells.shape[-1])
        chains = np.concatenate([rows[:, :: STEP[sweep]] for sweep in sweeps])
        firsts = np.tile(places.reshape(rows.shape)[:, 0], len(sweeps))
        at_rest = own_states(self.scan, chains[:, 0], {}, np.zeros(len(chains), np.int64))
        arrays = self.lanes(chains, at_rest, firsts)
        in_order: dict[str, np.ndarray] = {}
        for name, values in arrays.items():
            passes = values.reshape(len(sweeps), len(rows), *values.shape[1:])
            ascending = [passes[i][:, :: STEP[sweep]] for i, sweep in enumerate(sweeps)]
            in_order[name] = np.stack(ascending, axis=2)
        return in_order

    def lanes(
        self, chains: np.ndarray, starts: np.ndarray, places: np.ndarray | None = None
    ) -> dict[str, np.ndarray]:
        """Return the results of chains of cells (chains, links) from their starts (chains, 4).

        `places` (chains,) are the numbers of their orbits in the scan, which attractors need; they
        refuse sweeps.
        """
        scan, datasets = self.scan, self.scan.table.datasets
        arrays: dict[str, np.ndarray] = {}
        if "P" in datasets:
            arrays["P"] = chains["P"].copy()
        if scan.start.policy == "random":
            states = self._engine.user_states(chains[:, 0], starts)
            arrays["start_state"] = states[:, np.newaxis]
        if scan.spectral is not None:
            arrays |= self._spectra(scan.spectral, chains, starts)
        if self.ends is not None:
            where = np.zeros(len(chains), np.int64) if places is None else places
            arrays |= self.ends.arrays(chains[:, 0], starts, where)
        if self.kernels.records or "status" not in arrays:
            outputs = self.kernels.run(chains, starts, scan.transient, scan.periods)
            with np.errstate(all="ignore"):  # lanes that failed hold anything
                arrays |= self._recorded(outputs, chains)
        if "spectra_agree" in datasets:
            regimes, n, labels = (arrays[k] for k in ("regime", "periodicity", "spectral_label"))
            arrays["spectra_agree"] = agreement(regimes, n, labels, scan.periods)
        failed = arrays["status"] != records.OK
        for name, dataset in datasets.items():
            values = arrays[name]
            if name not in _KNOWN and failed.any():
                values[failed] = dataset.fill
            if values.dtype.kind == "f":  # the sign of a computed NaN depends on the processor
                values[np.isnan(values)] = np.nan
        return {name: arrays[name] for name in datasets}

    def _spectra(
        self, spectral: SpectralRecords, chains: np.ndarray, starts: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return spectra and `status` of orbits that are followed at more instants."""
        scan = self.scan
        assert self._traced is not None
        span = Span(scan.transient, scan.periods, spectral.samples)
        states, status = self._traced.states(chains, starts, span)
        spectra = spectra_of(spectral, states, status == records.OK, scan.transient)
        return {"status": status, **spectra}

    def _recorded(self, outputs: Outputs, chains: np.ndarray) -> dict[str, np.ndarray]:
        """Return the datasets and `status` of orbits from the buffers of the kernels."""
        scan, datasets = self.scan, self.scan.table.datasets
        buffers = outputs.buffers
        arrays: dict[str, np.ndarray] = {"status": outputs.status}
        # a verdict may need a longer section than is stored
        section = None if buffers.section is None else buffers.section[:, :, -scan.periods :]
        plain = {
            "section": section,
            "energy": buffers.energy,
            "peak": buffers.peak,
            "violation": buffers.violation,
            "touches": buffers.touches,
            "clearance": buffers.clearance,
        }
        for name in datasets:
            entry = self._quantities[name]
            values = plain.get(entry.buffer)
            if values is not None:
                arrays[name] = entry.from_buffer(values)
        if "reduction" in datasets:  # without a force nothing can be reduced: NaN
            arrays["reduction"] = 1.0 - arrays["E1max"] / energy_alone(chains)
        if "modulation" in scan.want:
            assert section is not None
            if self._rows:
                arrays |= records.amplitudes_of_rows(self._rows, section, chains["omega"])
            else:
                arrays |= records.modulation_of(section, chains["omega"], buffers.counts)
        if buffers.response is not None:
            arrays |= self.kernels.responses(outputs, chains)
        if buffers.cycle is not None:
            period = buffers.cycle[..., 0]
            impacts, by_wall = impacts_per_cycle(period, buffers.cycle[..., 1:])
            arrays["periodicity"] = period
            arrays["impact_count"] = impacts
            arrays["impacts_by_wall"] = by_wall
        if buffers.counts is not None:
            arrays["impact_rate"] = outputs.by_wall.sum(axis=-1) / scan.periods
            arrays["impact_rate_by_wall"] = outputs.by_wall / scan.periods
        if outputs.evidence is not None:
            arrays |= self.kernels.verdicts(outputs, chains)
        for name in ("impacts_by_wall", "impact_rate_by_wall"):
            if name in arrays:
                arrays[name] = scan.system.scene.by_damper(arrays[name])
        return arrays

    def orbits(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return orbits by number, cell after cell: cells (n, 1), starts (n, 4), places (n,)."""
        places, lanes = np.divmod(chosen, self.scan.starts)
        where = np.unravel_index(places, self.scan.shape)
        cells = self._cells[where]
        states = own_states(self.scan, cells, self.scan.initial(where), lanes, self._tell)
        return cells[:, np.newaxis], states, places


_KNOWN = ("status", "regime", "label", "start_state")  # what is also known of an orbit that failed


class CurveComputer:
    """Computes blocks of response curves, each by the `Computer` of its scan.

    `cached` are results of this and other requests, to which those of each block are added.
    """

    def __init__(
        self, request: CurveRequest, tell: Tell | None = None, cached: Cached | None = None
    ) -> None:
        self.request = request
        self._tell = tell
        self._cached: Cached = {} if cached is None else cached
        self._computer: Computer | None = None

    @property
    def table(self) -> Table:
        return self.request.table

    def block(self, block: Block) -> dict[str, np.ndarray]:
        """Return the datasets of a block by name, with the fill value where the case lacks one."""
        (case, _), *slices = block.slices
        scan = self.request.scans[case]
        own = self._arrays_of(scan, Block(block.index, tuple(slices)))
        arrays = dict[str, np.ndarray]()
        for name, entry in self.table.datasets.items():
            tail = self.table.shape(name)[len(block.shape) :]
            arrays[name] = np.full((*block.shape, *tail), entry.fill, entry.memory_type)
            if name in own:
                self.request.put(scan, name, own[name], arrays[name][0])
        return arrays

    def _arrays_of(self, scan: Scan, block: Block) -> Arrays:
        """Return the numbers of orbits in a block of the scan of a case."""
        key = scan.hash, block.slices
        if key not in self._cached:
            if self._computer is None or self._computer.scan is not scan:
                self._computer = Computer(scan, tell=self._tell)
            arrays = self._computer.block(block)
            names = self.table.datasets.keys() & numbers_of_orbits(scan).keys()
            self._cached[key] = {name: arrays[name] for name in names}
        return self._cached[key]


# ---- runs ----------------------------------------------------------------------------------------


def run(
    request: Scan | CurveRequest,
    output: Path,
    how: RunOptions | None = None,
    cached: Cached | None = None,
) -> Report:
    """Compute a scan or response curves into the archive `output`, as `run_in_blocks` does.

    `cached` are results of other response curves, as `CurveComputer` takes them.
    """
    how = RunOptions() if how is None else how
    return run_in_blocks(plan_of(request, cached), output, how)


def plan_of(request: Scan | CurveRequest, cached: Cached | None = None) -> Plan:
    """Return the plan of a scan, or of response curves case by case."""
    scan = request.scans[0]
    if isinstance(request, CurveRequest):
        computer: Callable[[Tell | None], Computes] = partial(CurveComputer, request, cached=cached)
        on_worker: Callable[[str], Computes] = _curves_in
        further: Callable[[Blocks], Further] = nothing_further
    else:
        computer = partial(Computer, request)
        on_worker = _scan_in
        further = partial(_attractors, request)
    return Plan(
        request=request,
        table=request.table,
        scales=request.scales,
        inputs=request.inputs,
        blocks=blocks_of(request),
        starts=scan.starts,
        computer=computer,
        on_worker=on_worker,
        further=further,
        watched=most_watched(scan.transient, scan.periods, scan.effort),
    )


def _scan_in(text: str) -> Computer:
    """Return the computer of the scan in a text, for a worker."""
    return Computer(load_scan(parse_toml(text, "the scan")), helped=False)


def _curves_in(text: str) -> CurveComputer:
    """Return the computer of the response curves in a text, for a worker."""
    return CurveComputer(load_curves(parse_toml(text, "the response curves")))


def _attractors(scan: Scan, saved: Blocks) -> Further:
    """Return the attractors on which the orbits of a scan end, if it records them."""
    if records.ATTRACTOR not in scan.want:
        return Further()
    from nlds_vines.bifurcation.attractors import AttractorTable

    ends = Computer(scan, helped=False).ends
    assert ends is not None
    attractors = AttractorTable(ends, saved(), interrupts.check)
    numbers = {records.ATTRACTOR: attractors.numbers}
    return Further(attractors.contents, attractors.scales, numbers)
