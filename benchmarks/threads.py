"""How well the threads share a map: measured here, and simulated for more threads than there are.

    python -m benchmarks.threads [CELLS]

Every lane of a map of CELLS x CELLS cells (50) of Set 6 over frequency and force, with energies and
regimes, is timed alone, its orbit and its verdict. From these times follows the speed-up of static
shares, one for each thread; of the pieces that `runs.pool` hands out; and of such pieces where one
block of a scan follows the other. It is measured, too, for as many threads as there are processors.
"""

from __future__ import annotations

import sys
import time
from heapq import heapreplace

import numpy as np

from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.compute import wanted_of
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.kernels.scene.arguments import Span
from nlds_vines.orbits import batch
from nlds_vines.orbits.batch import Kernels, Outputs
from nlds_vines.runs.pool import size_of_piece
from nlds_vines.runs.threads import most_threads, use_threads

COUNTS = (1, 2, 4, 8, 16, 32, 64)
TRANSIENT, PERIODS = 400, 100
RECORD = {"want": ["energy", "regime"]}


HANDING = 12e-6  # s that handing out a piece takes, one at a time: Python lets one thread work


def static(times: np.ndarray, threads: int) -> float:
    """Return the time [s] of lanes in equal shares, each a run of neighbours."""
    return float(max(share.sum() for share in np.array_split(times, threads)))


def dynamic(times: np.ndarray, threads: int, most: int | None) -> float:
    """Return the time [s] of lanes in the pieces of `runs.pool`: who is free takes the next one."""
    free, begin, handed = [0.0] * threads, 0, 0.0
    while begin < len(times):
        end = begin + size_of_piece(len(times) - begin, threads, most=most)
        handed = max(free[0], handed) + HANDING
        heapreplace(free, handed + float(times[begin:end].sum()))
        begin = end
    return max(free)


def lane_times(kernels: Kernels, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the time [s] of the processor for the orbit and for the verdict of each lane alone."""
    starts, found = np.zeros((1, 4)), np.empty((len(cells), 3))
    span = Span(TRANSIENT, PERIODS, 1)
    for lane in range(len(cells)):
        chains = cells[lane : lane + 1]
        outputs = Outputs.of(kernels._wanted, (1, 1), TRANSIENT, PERIODS)
        found[lane, 0] = time.thread_time()
        outputs.status[:] = batch.run(kernels._parts, chains, starts, span, outputs.buffers)
        found[lane, 1] = time.thread_time()
        kernels._judge(outputs, chains, TRANSIENT, PERIODS)
        found[lane, 2] = time.thread_time()
    orbits, verdicts = np.diff(found).T
    return orbits, verdicts


def measured(kernels: Kernels, cells: np.ndarray, threads: int) -> float:
    """Return the least time [s] of all lanes on so many threads, of three runs."""
    use_threads(threads)
    found = []
    for _ in range(3):
        began = time.perf_counter()
        kernels.run(cells, np.zeros((len(cells), 4)), TRANSIENT, PERIODS)
        found.append(time.perf_counter() - began)
    return min(found)


def main(side: int = 50) -> None:
    """Measure and print."""
    axes = {"omega": {"start": 5.0, "stop": 8.0, "num": side}}
    axes["P"] = {"start": 400.0, "stop": 1200.0, "num": side}
    sampling = {"transient": TRANSIENT, "periods": PERIODS}
    scan = load_scan({"system": "ssul-set6", "vary": axes, "sampling": sampling, "record": RECORD})
    kernels, cells = Kernels(wanted_of(scan)), scan.cells().reshape(-1, 1)
    use_threads(1)
    kernels.run(cells[:2], np.zeros((2, 4)), TRANSIENT, PERIODS)  # compiles
    orbits, verdicts = lane_times(kernels, cells)
    total, alone = orbits.sum() + verdicts.sum(), measured(kernels, cells, 1)
    ends = np.cumsum([block.cells for block in blocks_of(scan)])[:-1]
    longest = f"{orbits.max() * 1e3:.1f} ms, verdicts {verdicts.max() * 1e3:.1f} ms at most"
    print(f"{len(cells)} lanes, {total:.2f} s: orbits {orbits.sum():.2f} s, {longest}")
    print("threads   static   pieces   in blocks   measured")
    for threads in COUNTS:
        shares = static(orbits, threads) + static(verdicts, threads)
        pieces = dynamic(orbits, threads, None) + dynamic(verdicts, threads, 1)
        in_blocks = sum(dynamic(part, threads, None) for part in np.split(orbits, ends))
        in_blocks += sum(dynamic(part, threads, 1) for part in np.split(verdicts, ends))
        line = f"{threads:7} {total / shares:8.1f} {total / pieces:8.1f} {total / in_blocks:11.1f}"
        if threads <= most_threads():
            line += f" {alone / measured(kernels, cells, threads):10.2f}"
        print(line)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
