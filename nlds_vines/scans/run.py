"""A run in blocks, from request to archive.

Blocks are computed here one after the other, each on all threads, or by any executor, whose workers
return arrays; this process saves them, and makes the archive when all are there.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from nlds_vines.archives import archive, contents, provenance
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.engine.compilation import Compilation
from nlds_vines.errors import RequestError, option
from nlds_vines.runs import interrupts
from nlds_vines.runs.executors import as_finished, use_threads
from nlds_vines.runs.progress import Progress, Tell
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import Arrays, BlockStore, Write
from nlds_vines.scans.block import Block, share_in_words
from nlds_vines.scans.run_report import Report

AHEAD_BYTES = 1 << 30  # bytes of finished blocks (1 GB) that may wait for this process to save them
MOST_AHEAD = 1000  # blocks that may be under way: enough for any number of workers


class Computes(Protocol):
    """What computes blocks: cells, starts and kernels are prepared once."""

    @property
    def table(self) -> Table:
        """The datasets of the archive."""

    def block(self, block: Block) -> dict[str, np.ndarray]:
        """Return the arrays of a block: its part of each dataset of the table, and others."""


Column = tuple[Dataset, np.ndarray]
"""A dataset with its values."""

Blocks = Callable[[], Iterable[tuple[Block, Arrays]]]
"""Loads all blocks with their arrays, one after the other, each time that it is called."""


@dataclass(frozen=True)
class Further:
    """What is known only when all blocks are there.

    Attributes:
        columns: datasets with their values.
        scales: their dimensions.
        parts: datasets of the table with values for all cells, which no block has.
    """

    columns: Sequence[Column] = ()
    scales: Sequence[Scale] = ()
    parts: Mapping[str, np.ndarray] = field(default_factory=dict)


def nothing_further(_: Blocks) -> Further:
    return Further()


@dataclass(frozen=True)
class Plan:
    """What a run computes, and how.

    Attributes:
        request: what is asked, with its `about`.
        table: the datasets of its archive that blocks have.
        scales: returns the dimensions of its archive.
        inputs: returns datasets of what is asked, with their values.
        blocks: all of them, in the order of their numbers.
        starts: orbits in each cell.
        computer: makes what computes blocks here, which tells what it waits for.
        on_worker: makes the same in another process, of the request's text; a function of a module.
        further: returns what is known only when all blocks are there.
        watched: forcing periods for which chaotic orbits are watched; 0 without verdicts.
    """

    request: Any
    table: Table
    scales: Callable[[], Iterable[Scale]]
    inputs: Callable[[], Iterable[Column]]
    blocks: Sequence[Block]
    starts: int
    computer: Callable[[Tell | None], Computes]
    on_worker: Callable[[str], Computes]
    further: Callable[[Blocks], Further] = nothing_further
    watched: int = 0

    @property
    def block_bytes(self) -> int:
        """The bytes of the results of a block, 16 for a string, if all are as large."""
        return self.table.bytes(text=16) // max(1, len(self.blocks))


def run_in_blocks(plan: Plan, output: Path, how: RunOptions) -> Report:
    """Compute a plan into the archive `output` and return a `Report`.

    The shard that finds all blocks makes the archive.  Workers of a scheduler or an executor
    compute each block on `how.threads` threads, by default one.  Raises `Interrupted` with every
    finished block saved for --resume, and `RequestError` if the archive cannot be written.
    """
    began, waited = time.perf_counter(), Compilation.waited
    report = Report(how.shard, plan.watched)
    use_threads(how.threads)  # at once: what Numba lacks is known before anything is begun
    every = plan.blocks
    selected = every if how.shard is None else every[how.shard.blocks]
    store = BlockStore(output, plan.request)
    store.keys = [block.index for block in selected]
    if how.shard is not None and not selected:
        report.empty = share_in_words(every, how.shard)

    def work() -> Write | None:
        left: list[Block] = []
        for block in selected:
            arrays = store.load(block.index, block.expected(plan.table))
            if arrays is None:
                left.append(block)
            else:
                report.note(arrays)
        orbits = plan.starts * sum(block.cells for block in selected)
        with Progress(orbits, "orbit", done=report.lanes, quiet=how.quiet) as progress:
            if left:
                _save(store, _results(plan, left, how, progress.wait), report, progress)
        report.missing = len(store.missing(block.index for block in every))
        if report.missing and how.shard is None and not store.is_delivered():
            text = f"blocks have vanished: {option('resume')} computes them again"
            raise RequestError(f"{store.folder}: {report.missing} {text}")
        return None if report.missing else writer_of(plan, store)

    if not store.carry_out(how, work):
        with archive.read(output) as view:  # which was complete already
            report.note(view)
        return report
    if report.missing and store.is_delivered():
        report.missing = 0
    report.seconds = time.perf_counter() - began - (Compilation.waited - waited)
    return report


Result = tuple[Block, dict[str, np.ndarray], float]
"""A block, its arrays, and the seconds that it took."""


def _results(plan: Plan, blocks: Sequence[Block], how: RunOptions, tell: Tell) -> Iterator[Result]:
    """Yield the results of blocks as they are computed, here or by the workers of `how`."""
    if how.executor is None and how.scheduler is None:
        computer = plan.computer(tell)
        for block in blocks:
            yield block, *_timed(computer, block)
        return
    pool_of: Any = nullcontext(how.executor)  # which stays open
    if how.scheduler is not None:
        from nlds_vines.scans.cluster import workers

        pool_of = workers(how.scheduler, how.threads)
    ahead = max(2, min(MOST_AHEAD, AHEAD_BYTES // max(1, plan.block_bytes)))
    text, makers = plan.request.to_toml(), provenance.makers()
    compute = partial(compute_block, plan.on_worker, text, how.threads or 1, makers)
    with pool_of as pool:
        for block, (arrays, seconds) in as_finished(pool, compute, blocks, ahead):
            yield block, arrays, seconds
    use_threads(how.threads)  # workers that are threads of this process took others


def _save(store: BlockStore, results: Iterator[Result], report: Report, progress: Progress) -> None:
    """Save and count each block; on the disk while the next one is being computed."""
    if store.is_in_memory:
        for block, arrays, seconds in results:
            store.save(block.index, arrays, seconds)
            _note(arrays, report, progress)
        return
    with ThreadPoolExecutor(1) as writer:
        writer.submit(provenance.commit)  # asking git takes a moment: now, beside the first block
        saving = None
        for block, arrays, seconds in results:
            if saving is not None:
                saving.result()
            saving = writer.submit(store.save, block.index, arrays, seconds)
            _note(arrays, report, progress)
        if saving is not None:
            saving.result()


def _note(arrays: Arrays, report: Report, progress: Progress) -> None:
    report.note(arrays)
    progress.note(arrays["status"].size, report.words())


def _timed(computer: Computes, block: Block) -> tuple[dict[str, np.ndarray], float]:
    """Compute a block; return its datasets with the types of the archive, and the seconds."""
    interrupts.check()
    began, arrays = time.perf_counter(), computer.block(block)
    for name, entry in computer.table.datasets.items():
        dtype = np.str_ if entry.dtype == "str" else entry.dtype
        arrays[name] = np.ascontiguousarray(arrays[name], dtype)
    return arrays, time.perf_counter() - began


def compute_block(
    on_worker: Callable[[str], Computes],
    text: str,
    threads: int,
    asked_by: Mapping[str, str],
    block: Block,
) -> tuple[dict[str, np.ndarray], float]:
    """Compute a block of the request in `text` on a worker, of the same versions as `asked_by`."""
    here = provenance.makers()
    if different := [f"{k} {here[k]}, not {v}" for k, v in asked_by.items() if here.get(k) != v]:
        words = "; ".join(different)
        raise RequestError(f"a worker on {platform.node()} is of another version: {words}")
    computer = _prepared(on_worker, text)
    use_threads(threads)
    return _timed(computer, block)


@lru_cache(maxsize=2)
def _prepared(on_worker: Callable[[str], Computes], text: str) -> Computes:
    return on_worker(text)


def writer_of(plan: Plan, store: BlockStore) -> Write:
    """Return a function that writes the archive, with one block in memory at a time."""
    request, table = plan.request, plan.table

    def saved() -> Iterator[tuple[Block, dict[str, np.ndarray]]]:
        for block in plan.blocks:
            interrupts.check()
            arrays = store.load(block.index, block.expected(table))
            if arrays is None:
                raise FileNotFoundError(f"block {block.index} is missing")
            yield block, arrays

    further = plan.further(saved)
    columns = [*plan.inputs(), *further.columns]
    scales = {scale.name: scale for scale in (*plan.scales(), *further.scales)}
    whole = table
    if columns:
        datasets = [*table.datasets.values(), *(entry for entry, _ in columns)]
        lengths = {name: scale.values.size for name, scale in scales.items()}
        whole = Table.of(datasets, {**table.length, **lengths})

    def pieces() -> Iterator[contents.Piece]:
        for block, arrays in saved():
            for name in table.datasets:
                array = arrays[name]
                if name in further.parts:
                    array = further.parts[name][block.selection]
                yield name, block.selection, array
        yield from contents.whole_pieces(columns)

    spent, when = store.spent, provenance.now()

    def attributes() -> dict[str, provenance.Value]:
        return provenance.attributes(request, request.about | spent, when)

    return lambda path: archive.write(path, whole, scales.values(), pieces(), attributes)
