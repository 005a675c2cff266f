"""Where blocks run: the threads of this machine.

A scan is cut into blocks of cells by its own size alone, never by the machine's, so that a run can
be resumed on another one.  Every block is stored as soon as it is computed.
"""

from __future__ import annotations

import math
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise, product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from nlds_vines import archive
from nlds_vines.block import Computer, lanes_failed
from nlds_vines.parts import Block, Parts
from nlds_vines.record import datasets, sizes
from nlds_vines.scan import Scan

if TYPE_CHECKING:
    from tqdm import tqdm

BLOCK_PERIODS = 200_000  # forcing periods in a block: some tenths of a second
MOST_BLOCKS = 4000
BLOCK_BYTES = 1 << 27  # of results in one block
SAMPLE_LANES, SAMPLE_PERIODS = 32, 60  # what an estimate runs
LINE_EVERY = 5.0  # seconds between lines of progress where there is no terminal


class Interrupted(Exception):
    """A scan was stopped from outside; what is finished is kept.  The message says how to go on."""


@dataclass
class Report:
    """What came of a scan."""

    path: Path
    lanes: int
    seconds: float = 0.0
    failed_lanes: int = 0
    interrupted: bool = False
    labels: Counter[str] = field(default_factory=Counter)

    def note(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Count the failed lanes and the labels of a block, computed now or kept from before."""
        self.failed_lanes += lanes_failed(arrays["status"])
        if "label" in arrays:
            self.labels.update(arrays["label"].ravel().tolist())

    def note_archive(self) -> None:
        """Count those of an archive that was complete already."""
        with archive.read(self.path) as view:
            self.note({name: view[name] for name in ("status", "label") if name in view})

    def summary(self) -> str:
        """Return one line: how many orbits, how long, how many of each regime."""
        text = f"{self.lanes} orbits in {self.seconds:.1f} s"
        common = [f"{count} {label}" for label, count in self.labels.most_common(6)]
        return f"{text}: {', '.join(common)}" if common else text


def run(
    scan: Scan,
    output: Path,
    *,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = True,
) -> Report:
    """Compute a scan into the archive `output` and return a `Report`.

    `threads` None takes all processors.  Raises `Interrupted` on Ctrl-C, with every finished block
    kept for `resume`, and `RequestError` where the archive cannot be had.
    """
    used = use_threads(threads)
    began = time.perf_counter()
    report = Report(Path(output), scan.lanes)
    with Parts.open(output, scan, resume=resume, overwrite=overwrite) as parts:
        if parts.complete:
            report.note_archive()
            return report
        blocks = list(blocks_of(scan))
        done = parts.finished(blocks) if resume else set()
        for line in parts.discarded:
            print(line, file=sys.stderr)
        for block in blocks:
            if block.index in done:
                report.note(parts.load(block))
        try:
            _compute(scan, parts, [b for b in blocks if b.index not in done], report, quiet)
            report.seconds = time.perf_counter() - began
            parts.consolidate(blocks, {"threads": used, "seconds": round(report.seconds, 3)})
        except KeyboardInterrupt:
            kept = len(parts.finished(blocks))
            raise Interrupted(
                f"interrupted: {kept} of {len(blocks)} blocks are kept in {parts.folder}; "
                "the same command with --resume (in place of --overwrite) goes on from there"
            ) from None
    return report


def blocks_of(scan: Scan) -> Iterator[Block]:
    """Cut the grid of a scan into rectangles of cells.

    Where orbits follow an attractor along the last axis, that axis stays whole.
    """
    last = scan.shape[-1]
    along = last if scan.start.sweeps else None
    cells = _block_cells(scan)
    if along is None:
        along = min(last, cells)
    rows = max(1, cells // last) if along == last else 1
    rows_of = [_spans(n, rows) for n in scan.shape[:-1]]
    spans = product(*rows_of, _spans(last, along))
    return (Block(index, tuple(slices)) for index, slices in enumerate(spans))


def _block_cells(scan: Scan) -> int:
    """Return how many cells make a block of agreeable duration and size."""
    per_cell = scan.starts * (scan.transient + scan.periods)
    total = math.prod(scan.shape)
    by_time = max(BLOCK_PERIODS // per_cell, math.ceil(total / MOST_BLOCKS))
    by_size = BLOCK_BYTES // max(1, result_bytes(scan) // total)
    return max(1, min(by_time, by_size))


def _spans(length: int, size: int) -> list[tuple[int, int]]:
    """Return (first, last + 1) of pieces of at most `size`, as equal as can be."""
    pieces = math.ceil(length / size)
    edges = [length * i // pieces for i in range(pieces + 1)]
    return list(pairwise(edges))


def result_bytes(scan: Scan) -> int:
    """Return the size of all results of a scan before compression."""
    length = sizes(scan)
    item = {"str": 16, "int8": 1, "int32": 4, "float64": 8}
    return sum(item[d.dtype] * math.prod(length[dim] for dim in d.dims) for d in datasets(scan))


def use_threads(threads: int | None) -> int:
    """Let kernels use so many threads, at most those that there are; return how many."""
    most = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]  # set at run time
    used = most if threads is None else min(threads, most)
    numba.set_num_threads(used)
    return used


def _compute(scan: Scan, parts: Parts, blocks: list[Block], report: Report, quiet: bool) -> None:
    """Compute the missing blocks one after the other and store each."""
    computer = Computer(scan)
    with Progress(scan.starts * sum(math.prod(b.shape) for b in blocks), quiet) as progress:
        for block in blocks:
            arrays = computer.block(block)
            parts.write(block, arrays)
            report.note(arrays)
            progress.advance(arrays["status"].size)


class Progress:
    """A bar on a terminal, a plain line now and then elsewhere, nothing when quiet."""

    def __init__(self, lanes: int, quiet: bool) -> None:
        """Expect so many lanes."""
        self._lanes, self._quiet, self._done = lanes, quiet, 0
        self._began = self._spoke = time.perf_counter()
        self._first = 0  # lanes of the first block, whose time is mostly that of compiling
        self._bar: tqdm[Any] | None = None

    def __enter__(self) -> Progress:
        """Show the bar, if there is a terminal."""
        if not self._quiet and sys.stderr.isatty():
            from tqdm import tqdm

            self._bar = tqdm(total=self._lanes, unit="orbit", dynamic_ncols=True)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the bar as it is."""
        if self._bar is not None:
            self._bar.close()

    def advance(self, lanes: int) -> None:
        """Say that so many more lanes are done."""
        self._done += lanes
        if self._bar is not None:
            self._bar.update(lanes)
            return
        now = time.perf_counter()
        if self._first == 0:
            self._first, self._began = self._done, now
            return
        if self._quiet or now - self._spoke < LINE_EVERY:
            return
        self._spoke = now
        rate = (self._done - self._first) / (now - self._began)
        left = (self._lanes - self._done) / rate
        text = f"{self._done} of {self._lanes} orbits, {rate:.0f} a second, {left:.0f} s to go"
        print(text, file=sys.stderr)


@dataclass(frozen=True)
class Estimate:
    """What a scan would take."""

    scan: Scan
    threads: int
    seconds: float

    def lines(self) -> list[str]:
        """Return the estimate, one fact a line."""
        scan = self.scan
        grid = " x ".join(str(n) for n in scan.shape)
        each = scan.transient + scan.periods
        return [
            scan.title,
            f"orbits:   {scan.lanes} ({grid} cells, {scan.starts} start each)",
            f"periods:  {scan.transient} + {scan.periods} each, {scan.lanes * each} in all",
            f"results:  {_size(result_bytes(scan))} before compression",
            f"memory:   {_size(self._block_bytes())} of results at a time, "
            f"{len(list(blocks_of(scan)))} blocks",
            f"time:     about {_duration(self.seconds)} on {self.threads} threads, "
            "from a sample run here",
        ]

    def _block_bytes(self) -> int:
        cells = max(math.prod(block.shape) for block in blocks_of(self.scan))
        return result_bytes(self.scan) * cells // math.prod(self.scan.shape)


def estimate(scan: Scan, threads: int | None = None) -> Estimate:
    """Return what a scan would take on this machine, by running a small sample of its cells."""
    used = use_threads(threads)
    computer = Computer(replace(scan, periods=SAMPLE_PERIODS))
    cells = scan.cells().ravel()
    chosen = cells[np.linspace(0, cells.size - 1, min(SAMPLE_LANES, cells.size)).astype(int)]
    chains, starts = chosen[:, np.newaxis], np.zeros((chosen.size, 4))

    def cost(transient: int) -> float:
        began = time.perf_counter()
        computer.run(chains, starts, transient, SAMPLE_PERIODS)
        return (time.perf_counter() - began) / chosen.size

    cost(1)  # compiles
    both, noted = cost(SAMPLE_PERIODS), cost(0)
    settling = max(both - noted, 0.0) * scan.transient / SAMPLE_PERIODS
    per_lane = settling + noted * scan.periods / SAMPLE_PERIODS
    return Estimate(scan, used, per_lane * scan.lanes)


def _size(count: int) -> str:
    """Return bytes in words."""
    value, unit = float(count), "B"
    for larger in ("kB", "MB", "GB", "TB"):
        if value < 1000:
            break
        value, unit = value / 1000, larger
    return f"{value:.3g} {unit}"


def _duration(seconds: float) -> str:
    """Return a duration in words."""
    if seconds < 120:
        return f"{seconds:.2g} s"
    if seconds < 7200:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
