"""A scan from request to archive, block after block.

Blocks run on the threads of this machine, or on the workers of a cluster (`cluster`).  Here, a
block is stored while the next one is being computed.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from nlds_vines.archives import archive, provenance
from nlds_vines.bifurcation.block_files import Parts
from nlds_vines.bifurcation.blocks import Block, blocks_of, share_in_words
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.observation_time import of_chaos
from nlds_vines.bifurcation.orbit_counts import COUNTED, Note, Tally
from nlds_vines.bifurcation.request import Scan
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.model.labels import CHAOS
from nlds_vines.orbits.compilation import Compilation
from nlds_vines.orbits.solver_settings import most_watched
from nlds_vines.runs import interrupts
from nlds_vines.runs.executors import Shard, use_threads
from nlds_vines.runs.journal import resumable, tell_discarded
from nlds_vines.runs.progress import Progress


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
    parts are computed; the shard that finds all parts of the scan joins them into the archive.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with every finished block kept for
    --resume, and `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    began, waited = time.perf_counter(), Compilation.waited
    watched = most_watched(scan.transient, scan.periods, scan.effort)
    report = Report(Path(output), how.shard, watched)
    if how.scheduler is None or how.scheduler.startswith("local:"):
        use_threads(how.threads)  # at once: what Numba lacks is known before anything is begun
    opened = Parts.open(output, scan, resume=how.resume, overwrite=how.overwrite, shard=how.shard)
    with opened as parts, interrupts.stop_on_signals() as stop:
        if parts.complete:
            report.note_archive()
            return report
        blocks = blocks_of(scan, how.shard)
        if how.shard is not None and not blocks:
            report.empty = share_in_words(scan, how.shard)

        def kept() -> str:
            return f"{len(parts.files.there(blocks))} of {len(blocks)} blocks are"

        with resumable(parts, stop, kept):
            left = _left(parts, blocks, report.tally)
            lanes = scan.starts * sum(block.cells for block in blocks)
            done = report.tally.lanes
            with Progress(lanes, "orbit", done=done, quiet=how.quiet) as progress:
                note = partial(report.tally.follow, progress)
                computer = Computer(scan, tell=progress.wait)
                if how.scheduler is None:
                    _compute(parts, computer, left, how, note, stop)
                else:
                    from nlds_vines.bifurcation import cluster

                    cluster.compute(parts, left, how.scheduler, how.threads, note, stop)
            if how.shard is not None:
                whole = blocks_of(scan)
                report.missing = len(whole)
                if parts.is_alone():
                    report.missing -= len(parts.files.there(whole))
                blocks = whole
            if not report.missing:
                parts.consolidate(blocks, check=stop.check)
    report.seconds = time.perf_counter() - began - (Compilation.waited - waited)
    return report


def _left(parts: Parts, blocks: Sequence[Block], tally: Tally) -> list[Block]:
    """Return the blocks still to be computed; count the orbits of the others."""
    done = set()
    for block, part in parts.sound(blocks):
        done.add(block.index)
        tally.note(part.arrays)
    tell_discarded(parts)
    return [block for block in blocks if block.index not in done]


def _compute(
    parts: Parts,
    computer: Computer,
    blocks: list[Block],
    how: RunOptions,
    note: Note,
    stop: interrupts.Stop,
) -> None:
    """Compute the missing blocks here, one after the other, and store each."""
    used = use_threads(how.threads)
    with _Storing(parts, note) as storing:
        began = time.perf_counter()
        for block in blocks:
            stop.check()
            arrays = computer.block(block)
            now = time.perf_counter()
            storing.put(block, arrays, now - began, used)
            began = now


class _Storing:
    """Stores a block while the next one is being computed, which so does not wait for the disk."""

    def __init__(self, parts: Parts, note: Note) -> None:
        self._parts, self._note = parts, note
        self._pool = ThreadPoolExecutor(1)
        self._pending: tuple[Future[None], Mapping[str, np.ndarray]] | None = None

    def __enter__(self) -> _Storing:
        # asking git for the commit takes a moment: now, while the first block is computed
        self._pool.submit(provenance.commit)
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._settle()
        finally:
            self._pool.shutdown()

    def put(
        self, block: Block, arrays: Mapping[str, np.ndarray], seconds: float, threads: int
    ) -> None:
        """Begin to store a block once the one before is stored; raises the error of that one."""
        self._settle()
        stored = self._pool.submit(self._parts.write, block, arrays, seconds, threads)
        self._pending = stored, arrays

    def _settle(self) -> None:
        """Wait until the block before is stored, and count it as done."""
        pending, self._pending = self._pending, None
        if pending is not None:
            stored, arrays = pending
            stored.result()
            self._note(arrays)
