"""A scan from request to archive: counts of orbits, one block through the kernels, all blocks.

Blocks are computed here one after the other, each on all threads, or by any executor, whose workers
return arrays; this process saves them, and makes the archive when all are there.
"""

from __future__ import annotations

import math
import platform
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives import archive, contents, provenance
from nlds_vines.archives.dataset import Table
from nlds_vines.archives.files import parse_toml
from nlds_vines.bifurcation.blocks import Block, block_bytes, blocks_of, share_in_words
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.bifurcation.response_curves import CurveRequest, numbers_of_orbits
from nlds_vines.bifurcation.result import STEP, own_states
from nlds_vines.engine import records
from nlds_vines.engine.batch import Kernels, Wanted, agreement, impacts_per_cycle, spectra_of
from nlds_vines.engine.compilation import Compilation
from nlds_vines.engine.engine import engine_for
from nlds_vines.engine.solver_settings import most_watched
from nlds_vines.errors import RequestError, option
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.labels import CHAOS, least_lifetime
from nlds_vines.model.linear_response import energy_alone
from nlds_vines.model.quantities import recorded
from nlds_vines.runs import interrupts
from nlds_vines.runs.executors import Shard, as_finished, use_threads
from nlds_vines.runs.progress import Progress, Tell
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import Arrays, BlockStore, Expected, Write

if TYPE_CHECKING:
    from nlds_vines.bifurcation.attractors import OrbitEnds

_MOST_LABELS = 6  # regimes named in a line: as many as fit beside the bar of progress


@dataclass
class Report:
    """What a run did: the orbits of a scan, or of a shard of it, counted by status and regime."""

    shard: Shard | None = None
    watched: int = 0  # forcing periods for which chaotic orbits are watched
    seconds: float = 0.0
    empty: str = ""  # the remark on a shard without blocks
    missing: int = 0  # number of blocks that other shards have to compute
    lanes: int = 0
    failures: Counter[int] = field(default_factory=Counter)
    labels: Counter[str] = field(default_factory=Counter)
    violated: int = 0  # orbits that pass the limit of their scene
    depths: tuple[float, float] = (math.inf, 0.0)  # the least and the largest by which they do [m]

    def note(self, arrays: Mapping[str, np.ndarray] | archive.ArchiveView) -> None:
        status = arrays["status"]
        self.lanes += status.size
        self.failures += records.failures_in(status)
        if "label" in arrays:
            self.labels.update(arrays["label"].ravel().tolist())
        if "violations" in arrays:
            passed, depth = arrays["violations"] > 0, arrays["violation_depth"]
            self.violated += int(np.count_nonzero(passed))
            finite, (low, high) = depth[passed & np.isfinite(depth)], self.depths
            self.depths = finite.min(initial=low), finite.max(initial=high)

    def inadmissible(self) -> list[str]:
        if not self.violated:
            return []
        low, high = (f"{depth:.2g}" for depth in self.depths)
        by = high if low == high else f"{low} to {high}"
        return [
            f"inadmissible: {self.violated} of {self.lanes} orbits pass the limit, by {by} m; they "
            "are followed as if it were not there"
        ]

    def regimes(self) -> str:
        """Return the counts of the commonest regimes, `945 T,1, 32 3T,2`; empty without labels."""
        common = self.labels.most_common(_MOST_LABELS)
        words = [f"{count} {label}" for label, count in common]
        others = self.labels.total() - sum(count for _, count in common)
        return ", ".join([*words, *([f"{others} of other regimes"] if others else [])])

    def summary(self) -> str:
        which = f"shard {self.shard}: " if self.shard else ""
        text = f"{which}{self.lanes} orbits in {self.seconds:.1f} s"
        return ": ".join(filter(None, [text, self.regimes()]))

    def remarks(self) -> list[str]:
        """Return further lines: an empty shard, passed limits, how long chaos was watched."""
        if self.empty:
            return [self.empty]
        lines = self.inadmissible()
        if CHAOS in self.labels:  # which may be transient
            lines.append(
                f"chaos: watched for {self.watched} periods each; if it is transient, its mean "
                f"lifetime is {least_lifetime(self.watched):.0f} periods or more (95 %, one orbit)"
            )
        return lines


def wanted_of(scan: Scan) -> Wanted:
    """Return the records that a scan wants of whole orbits."""
    words, scene = records.plain(scan.want), scan.system.scene
    return Wanted(scene, words, scan.method, scan.effort, scan.settings)


class Cases:
    """Computes blocks of response curves; `cached` has arrays by hash of the scan and place."""

    def __init__(
        self, request: CurveRequest, tell: Tell | None, cached: dict[object, Arrays] | None
    ) -> None:
        self.scan, self._tell = request, tell
        self._cached = {} if cached is None else cached
        self._computer: Computer | None = None

    def block(self, block: Block) -> dict[str, np.ndarray]:
        """Return the datasets of a block by name, with the fill value where the case lacks one."""
        (case, _), *slices = block.slices
        scan, datasets = self.scan.scans[case], self.scan.table.datasets
        key = scan.hash, tuple(slices)
        if key not in self._cached:
            if self._computer is None or self._computer.scan is not scan:
                self._computer = Computer(scan, tell=self._tell)
            arrays = self._computer.block(Block(block.index, tuple(slices)))
            names = datasets.keys() & numbers_of_orbits(scan).keys()
            self._cached[key] = {name: arrays[name] for name in names}
        table = dict[str, np.ndarray]()
        for name, entry in datasets.items():
            tail = self.scan.table.shape(name)[len(block.shape) :]
            kind = object if entry.dtype == "str" else entry.dtype
            table[name] = np.full((*block.shape, *tail), entry.fill, kind)
            if (array := self._cached[key].get(name)) is not None:
                self.scan.put(scan, name, array, table[name][0])
        return table


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
        self._traced: Kernels | None = None  # for the states of spectra, which hosts do not have
        if scan.spectral is not None:
            self._traced = Kernels(replace(wanted, want=("section",)), tell, helped=helped)

    def block(self, block: Block) -> dict[str, np.ndarray]:
        """Return the datasets of a block by name, each of shape rectangle + (starts,) + tail."""
        cells, scan = self._cells[block.selection], self.scan
        sides = (np.arange(first, stop) for first, stop in block.slices)
        places = np.ravel_multi_index(np.ix_(*sides), scan.shape)
        sweeps = scan.start.sweeps
        if sweeps:  # chains of cells: from rest, then each where the orbit before it ended
            rows = cells.reshape(-1, cells.shape[-1])
            chains = np.concatenate([rows[:, :: STEP[sweep]] for sweep in sweeps])
            firsts = np.tile(places.reshape(rows.shape)[:, 0], len(sweeps))
            at_rest = own_states(scan, chains[:, 0], {}, np.zeros(len(chains), np.int64))
            arrays = self.lanes(chains, at_rest, firsts)
        else:
            numbers = places.reshape(-1, 1) * scan.starts + np.arange(scan.starts)
            arrays = self.lanes(*self.orbits(numbers.ravel()))
        datasets = {}
        for name in scan.table.datasets:
            values = arrays[name]
            if sweeps:
                passes = values.reshape(len(sweeps), -1, *values.shape[1:])
                pairs = zip(passes, sweeps, strict=True)
                values = np.stack([one[:, :: STEP[sweep]] for one, sweep in pairs], axis=2)
            tail = scan.table.shape(name)[len(scan.axes) :]
            datasets[name] = values.reshape(*cells.shape, *tail)
        return datasets

    def lanes(
        self, chains: np.ndarray, starts: np.ndarray, places: np.ndarray | None = None
    ) -> dict[str, np.ndarray]:
        """Return the results of chains of cells (chains, links) from their starts (chains, 4).

        `places` (chains,) are the numbers of their orbits in the scan, which attractors need; they
        refuse sweeps.
        """
        scan, datasets = self.scan, self.scan.table.datasets
        arrays = {"P": chains["P"].copy()} if "P" in datasets else {}
        if scan.start.policy == "random":
            states = self._engine.user_states(chains[:, 0], starts)
            arrays["start_state"] = states[:, np.newaxis]
        # the same at more instants
        if (spectral := scan.spectral) is not None and self._traced is not None:
            span = Span(scan.transient, scan.periods, spectral.samples)
            states, status = self._traced.states(chains, starts, span)
            spectra = spectra_of(spectral, states, status == records.OK, scan.transient)
            arrays |= {"status": status, **spectra}
        if self.ends is not None:
            where = np.zeros(len(chains), np.int64) if places is None else places
            arrays |= self.ends.arrays(chains[:, 0], starts, where)
        if self.kernels.records or "status" not in arrays:
            outputs = self.kernels.run(chains, starts, scan.transient, scan.periods)
            buffers, arrays["status"] = outputs.buffers, outputs.status
            with np.errstate(all="ignore"):  # lanes that failed hold anything
                for name in datasets:
                    entry = self._quantities[name]
                    buffer = getattr(buffers, entry.buffer) if entry.buffer in _PLAIN else None
                    if buffer is not None and entry.buffer == "section":
                        buffer = buffer[:, :, -scan.periods :]
                    if buffer is not None:
                        arrays[name] = entry.from_buffer(buffer)
                if "reduction" in datasets:  # without a force nothing can be reduced: NaN
                    arrays["reduction"] = 1.0 - arrays["E1max"] / energy_alone(chains)
                if "modulation" in scan.want:
                    section, omega = buffers.section[:, :, -scan.periods :], chains["omega"]
                    if self._rows:
                        arrays |= records.amplitudes_of_rows(self._rows, section, omega)
                    else:
                        arrays |= records.modulation_of(section, omega, buffers.counts)
            if buffers.response is not None:
                arrays |= self.kernels.responses(outputs, chains)
            if buffers.cycle is not None:
                arrays["periodicity"] = period = buffers.cycle[..., 0]
                impacts, by_wall = impacts_per_cycle(period, buffers.cycle[..., 1:])
                arrays["impact_count"], arrays["impacts_by_wall"] = impacts, by_wall
            if buffers.counts is not None:
                arrays["impact_rate"] = outputs.by_wall.sum(axis=-1) / scan.periods
                arrays["impact_rate_by_wall"] = outputs.by_wall / scan.periods
            if outputs.evidence is not None:
                arrays |= self.kernels.verdicts(outputs, chains)
            for name in ("impacts_by_wall", "impact_rate_by_wall"):
                if name in arrays:
                    arrays[name] = scan.system.scene.by_damper(arrays[name])
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
        return arrays

    def orbits(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return orbits by number, cell after cell: cells (n, 1), starts (n, 4), places (n,)."""
        places, lanes = np.divmod(chosen, self.scan.starts)
        where = np.unravel_index(places, self.scan.shape)
        cells = self._cells[where]
        states = own_states(self.scan, cells, self.scan.initial(where), lanes, self._tell)
        return cells[:, np.newaxis], states, places


_PLAIN = ("section", "energy", "peak", "violation", "touches", "clearance")
"""The buffers of lanes whose numbers are recorded as they are."""

_KNOWN = ("status", "regime", "label", "start_state")  # what is also known of an orbit that failed


AHEAD_BYTES = 1 << 30  # bytes of finished blocks (1 GB) that may wait for this process to save them


def run(
    request: Scan | CurveRequest,
    output: Path,
    how: RunOptions | None = None,
    cached: dict[object, Arrays] | None = None,
) -> Report:
    """Compute a scan or response curves into the archive `output` and return a `Report`.

    `cached`, as `Cases` takes it, are results of other response curves.  The shard that finds all
    blocks of the scan makes the archive.  Workers of a scheduler or an executor compute each block
    on `how.threads` threads, by default one.  Raises `Interrupted` with every finished block saved
    for --resume, and `RequestError` if the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    began, waited = time.perf_counter(), Compilation.waited
    scan = request.scans[0]
    watched = most_watched(scan.transient, scan.periods, scan.effort)
    report = Report(how.shard, watched)
    use_threads(how.threads)  # at once: what Numba lacks is known before anything is begun
    every, selected = blocks_of(request), blocks_of(request, how.shard)
    store = BlockStore(output, request)
    store.keys = [block.index for block in selected]
    if how.shard is not None and not selected:
        report.empty = share_in_words(scan, how.shard)

    def work() -> Write | None:
        left = []
        for block in selected:
            arrays = store.load(block.index, expected_of(request, block))
            if arrays is None:
                left.append(block)
            else:
                report.note(arrays)
        lanes = scan.starts * sum(block.cells for block in selected)
        with Progress(lanes, "orbit", done=report.lanes, quiet=how.quiet) as progress:
            computer: Computer | Cases
            if isinstance(request, Scan):
                computer = Computer(request, tell=progress.wait)
            else:
                computer = Cases(request, progress.wait, cached)
            if how.executor is None and how.scheduler is None:
                _save(store, ((b, *_timed(computer, b)) for b in left), report, progress)
            elif left:
                assert isinstance(request, Scan)  # no command hands response curves to workers
                pool_of: Any = nullcontext(how.executor)  # which stays open
                if how.scheduler is not None:
                    from nlds_vines.bifurcation.cluster import workers

                    pool_of = workers(how.scheduler, how.threads)
                makers, by_index = provenance.makers(), {block.index: block for block in left}
                compute = partial(compute_block, request.to_toml(), how.threads or 1, makers)
                ahead = max(2, min(1000, AHEAD_BYTES // max(1, block_bytes(request))))
                with pool_of as pool:
                    pairs = as_finished(pool, compute, by_index, ahead)
                    results = ((by_index[index], *result) for index, result in pairs)
                    _save(store, results, report, progress)
                use_threads(how.threads)  # workers that are threads of this process took others
        report.missing = len(store.missing(block.index for block in every))
        if report.missing and how.shard is None and not store.is_delivered():
            text = f"blocks have vanished: {option('resume')} computes them again"
            raise RequestError(f"{store.folder}: {report.missing} {text}")
        return None if report.missing else writer_of(request, store, every)

    if not store.carry_out(how, work):
        with archive.read(output) as view:  # which was complete already
            report.note(view)
        return report
    if report.missing and store.is_delivered():
        report.missing = 0
    report.seconds = time.perf_counter() - began - (Compilation.waited - waited)
    return report


def expected_of(request: Scan | CurveRequest, block: Block) -> Expected:
    """Return the types and shapes of the datasets of a block."""
    table, shape = request.table, block.shape
    return {
        name: (entry.dtype, (*shape, *table.shape(name)[len(shape) :]))
        for name, entry in table.datasets.items()
    }


def _save(
    store: BlockStore,
    results: Iterator[tuple[Block, dict[str, np.ndarray], float]],
    report: Report,
    progress: Progress,
) -> None:
    """Save and count each block, while the next one is being computed."""
    with ThreadPoolExecutor(1) as writer:
        writer.submit(provenance.commit)  # asking git takes a moment: now, beside the first block
        saving = None
        for block, arrays, seconds in results:
            if saving is not None:
                saving.result()
            saving = writer.submit(store.save, block.index, arrays, seconds)
            report.note(arrays)
            words = [report.regimes(), f"{report.failures.total()} failed"]
            progress.note(arrays["status"].size, "; ".join(filter(None, words)))
        if saving is not None:
            saving.result()


def _timed(computer: Computer | Cases, block: Block) -> tuple[dict[str, np.ndarray], float]:
    """Compute a block; return its datasets with the types of the archive, and the seconds."""
    interrupts.check()
    began, arrays = time.perf_counter(), computer.block(block)
    for name, entry in computer.scan.table.datasets.items():
        dtype = np.str_ if entry.dtype == "str" else entry.dtype
        arrays[name] = np.ascontiguousarray(arrays[name], dtype)
    return arrays, time.perf_counter() - began


def compute_block(
    toml: str, threads: int, asked_by: Mapping[str, str], index: int
) -> tuple[dict[str, np.ndarray], float]:
    """Compute block `index` of a scan file on a worker, of the same versions as `asked_by`."""
    here = provenance.makers()
    if different := [f"{k} {here[k]}, not {v}" for k, v in asked_by.items() if here.get(k) != v]:
        text = "; ".join(different)
        raise RequestError(f"a worker on {platform.node()} is of another version: {text}")
    computer = _computer(toml)
    use_threads(threads)
    return _timed(computer, blocks_of(computer.scan)[index])


@lru_cache(maxsize=2)
def _computer(toml: str) -> Computer:
    return Computer(load_scan(parse_toml(toml, "the scan")), helped=False)


def writer_of(request: Scan | CurveRequest, store: BlockStore, blocks: Sequence[Block]) -> Write:
    """Return a function that writes the archive, with one block in memory at a time."""

    def saved() -> Iterator[tuple[Block, dict[str, np.ndarray]]]:
        for block in blocks:
            interrupts.check()
            arrays = store.load(block.index, expected_of(request, block))
            if arrays is None:
                raise FileNotFoundError(f"block {block.index} is missing")
            yield block, arrays

    table, columns, attractors = request.table, [*request.inputs()], None
    scales = {scale.name: scale for scale in request.scales()}
    if isinstance(request, Scan) and records.ATTRACTOR in request.want:
        from nlds_vines.bifurcation.attractors import AttractorTable

        ends = Computer(request, helped=False).ends
        assert ends is not None
        attractors = AttractorTable(ends, saved(), interrupts.check)
        columns += attractors.contents
        scales |= {scale.name: scale for scale in attractors.scales}
    if columns:
        datasets = [*table.datasets.values(), *(entry for entry, _ in columns)]
        lengths = {name: scale.values.size for name, scale in scales.items()}
        table = Table.of(datasets, {**table.length, **lengths})

    def pieces() -> Iterator[contents.Piece]:
        for block, arrays in saved():
            if attractors is not None:
                arrays |= {records.ATTRACTOR: attractors.numbers[block.selection]}
            for name, array in arrays.items():
                yield name, block.selection, array
        yield from contents.whole_pieces(columns)

    spent, when = store.spent, provenance.now()

    def attributes() -> dict[str, provenance.Value]:
        return provenance.attributes(request, request.about | spent, when)

    return lambda path: archive.write(path, table, scales.values(), pieces(), attributes)
