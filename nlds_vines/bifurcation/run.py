"""A scan from request to archive, block after block.

Blocks are computed here one after the other, each on all threads, or by any executor, whose workers
return arrays; this process saves them, and makes the archive when all are there.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.archives import archive, provenance
from nlds_vines.archives.files import parse_toml
from nlds_vines.bifurcation.blocks import Block, block_bytes, blocks_of, share_in_words
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.observation_time import of_chaos
from nlds_vines.bifurcation.orbit_counts import COUNTED, Tally
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.cli.running import RunOptions
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import CHAOS
from nlds_vines.orbits.compilation import Compilation
from nlds_vines.orbits.records import ATTRACTOR
from nlds_vines.orbits.solver_settings import most_watched
from nlds_vines.runs import interrupts
from nlds_vines.runs.executors import Shard, as_finished, use_threads
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.store import Blocks, Write

AHEAD_BYTES = 1 << 30
"""Bytes of finished blocks (1 GB) that may wait for this process to save them."""


@dataclass
class Report:
    """The archive of a scan, or of a shard of it, how long it took, and counts of its orbits.

    `watched`: the forcing periods for which its chaotic orbits are watched; `empty`: what is to be
    said of a shard without blocks; `missing`: blocks that other shards have to compute.
    """

    path: Path
    shard: Shard | None = None
    watched: int = 0
    seconds: float = 0.0
    empty: str = ""
    missing: int = 0
    tally: Tally = field(default_factory=Tally)

    @property
    def lanes(self) -> int:
        """How many orbits there are results of."""
        return self.tally.lanes

    @property
    def failed_lanes(self) -> int:
        """How many orbits failed."""
        return self.tally.failed

    def why_failed(self) -> str:
        """Return how many orbits failed, why, and what helps; empty where none did."""
        return self.tally.why_failed()

    def note_archive(self) -> None:
        """Count the orbits of an archive that was complete already."""
        with archive.read(self.path) as view:
            self.tally.note({name: view[name] for name in COUNTED if name in view})

    def summary(self) -> str:
        """Return one line: how many orbits, how long, how many of each regime."""
        which = f"shard {self.shard}: " if self.shard else ""
        text = f"{which}{self.tally.lanes} orbits in {self.seconds:.1f} s"
        regimes = self.tally.regimes()
        return f"{text}: {regimes}" if regimes else text

    def remarks(self) -> list[str]:
        """Return what else is to be said of the results, one thing a line."""
        if self.empty:
            return [self.empty]
        chaos = [of_chaos(self.watched)] if CHAOS in self.tally.labels else []
        return [*self.tally.inadmissible(), *chaos]


def run(scan: Scan, output: Path, how: RunOptions | None = None) -> Report:
    """Compute a scan into the archive `output` and return a `Report`.

    Arguments: `how` the run goes, None for the defaults of `RunOptions`.  With a shard, only its
    blocks are computed; the shard that finds all blocks of the scan makes the archive.  Workers
    of a scheduler or an executor compute each block on `how.threads` threads, by default one.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with every finished block kept for
    --resume, and `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    began, waited = time.perf_counter(), Compilation.waited
    watched = most_watched(scan.transient, scan.periods, scan.effort)
    report = Report(Path(output), how.shard, watched)
    use_threads(how.threads)  # at once: what Numba lacks is known before anything is begun
    every, selected, store = blocks_of(scan), blocks_of(scan, how.shard), Blocks(output, scan)
    store.keys = [block.index for block in selected]
    if how.shard is not None and not selected:
        report.empty = share_in_words(scan, how.shard)

    def work() -> Write | None:
        left = []
        for block in selected:
            arrays = store.load(block.index)
            if arrays is None:
                left.append(block)
            else:
                report.tally.note(arrays)
        lanes = scan.starts * sum(block.cells for block in selected)
        with Progress(lanes, "orbit", done=report.tally.lanes, quiet=how.quiet) as progress:
            computer = Computer(scan, tell=progress.wait)
            if how.executor is None and how.scheduler is None:
                _save(store, ((b, *_timed(computer, b)) for b in left), report.tally, progress)
            elif left:
                with _pool(how) as pool:
                    results = _by_workers(scan, left, pool, how.threads or 1)
                    _save(store, results, report.tally, progress)
                use_threads(how.threads)  # workers that are threads of this process took others
        report.missing = len(store.missing(block.index for block in every))
        if report.missing and how.shard is None and not store.is_delivered():
            text = "blocks have vanished: --resume computes them again"
            raise RequestError(f"{store.folder}: {report.missing} {text}")
        return None if report.missing else writer_of(scan, store, every)

    if not store.carry_out(how, work):
        report.note_archive()
        return report
    if report.missing and store.is_delivered():
        report.missing = 0
    report.seconds = time.perf_counter() - began - (Compilation.waited - waited)
    return report


def _save(
    store: Blocks,
    results: Iterator[tuple[Block, dict[str, np.ndarray], float]],
    tally: Tally,
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
            tally.follow(progress, arrays)
        if saving is not None:
            saving.result()


def _timed(computer: Computer, block: Block) -> tuple[dict[str, np.ndarray], float]:
    """Compute a block; return its datasets as an archive has them, and the seconds it took."""
    interrupts.check()
    began, arrays = time.perf_counter(), computer.block(block)
    for name, entry in computer.scan.table.datasets.items():
        dtype = np.str_ if entry.dtype == "str" else entry.dtype
        arrays[name] = np.ascontiguousarray(arrays[name], dtype)
    return arrays, time.perf_counter() - began


# ---- on workers ----------------------------------------------------------------------------------


def _pool(how: RunOptions) -> Any:
    """Return what gives the executor within a `with` block: that of Python stays open after it."""
    if how.executor is not None:
        return nullcontext(how.executor)
    from nlds_vines.bifurcation.cluster import workers

    assert how.scheduler is not None
    return workers(how.scheduler, how.threads)


def _by_workers(
    scan: Scan, blocks: Sequence[Block], pool: Executor, threads: int
) -> Iterator[tuple[Block, dict[str, np.ndarray], float]]:
    """Yield each block with its datasets and the seconds it took, as workers finish them."""
    compute = partial(compute_block, scan.to_toml(), threads, provenance.makers())
    ahead = max(2, min(1000, AHEAD_BYTES // max(1, block_bytes(scan))))
    by_index = {block.index: block for block in blocks}
    for index, (arrays, seconds) in as_finished(pool, compute, by_index, ahead):
        yield by_index[index], arrays, seconds


def compute_block(
    toml: str, threads: int, asked_by: Mapping[str, str], index: int
) -> tuple[dict[str, np.ndarray], float]:
    """Compute a block of the scan in a text, on a worker; return it as `_timed` does.

    Arguments: the `threads` to use; the versions of who asks.

    Raises `RequestError`, before anything is computed, if other versions are here.
    """
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


# ---- the archive ---------------------------------------------------------------------------------


def writer_of(scan: Scan, store: Blocks, blocks: Sequence[Block]) -> Write:
    """Return what writes the archive of all blocks, holding one of them in memory at a time."""

    def saved() -> Iterator[tuple[Block, dict[str, np.ndarray]]]:
        for block in blocks:
            interrupts.check()
            arrays = store.load(block.index)
            if arrays is None:
                raise FileNotFoundError(f"block {block.index} is missing")
            yield block, arrays

    table, scales, attractors = scan.table, list(scan.scales()), None
    if ATTRACTOR in scan.want:
        from nlds_vines.bifurcation.attractor_table import AttractorTable

        attractors = AttractorTable(scan, saved(), interrupts.check)
        table, scales = attractors.joined(), attractors.scales()

    def pieces() -> Iterator[archive.Piece]:
        for block, arrays in saved():
            patched = arrays if attractors is None else attractors.patched(block, arrays)
            for name, array in patched.items():
                yield name, block.selection, array
        if attractors is not None:
            yield from attractors.pieces()

    def attributes() -> dict[str, provenance.Value]:
        return provenance.attributes(scan, scan.about | store.spent)

    return lambda path: archive.write(path, table, scales, pieces(), attributes)
