"""How well the threads share a map: measured here, and simulated for more threads than there are.

    python -m benchmarks.threads [CELLS]

Every lane of a map of CELLS x CELLS cells (30) of Set 6 over frequency and force, with energies and
regimes, is timed alone. From these times follows the speed-up of static shares, one for each
thread, and that of the pieces that `runs.pool` hands out. It is measured, too, for as many threads
as there are processors.
"""

from __future__ import annotations

import sys
import time
from heapq import heapify, heapreplace

import numpy as np

from nlds_vines.bifurcation.compute import wanted_of
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.orbits.batch import Kernels
from nlds_vines.runs.pool import size_of_piece
from nlds_vines.runs.threads import most_threads, use_threads

COUNTS = (1, 2, 4, 8, 16, 32, 64)
TRANSIENT, PERIODS = 400, 100


def static(times: np.ndarray, threads: int) -> float:
    """Return the time [s] of lanes in equal shares, each a run of neighbours."""
    return float(max(share.sum() for share in np.array_split(times, threads)))


def dynamic(times: np.ndarray, threads: int, least: int = 1) -> float:
    """Return the time [s] of lanes in the pieces of `runs.pool`: who is free takes the next one."""
    free, begin = [0.0] * threads, 0
    heapify(free)
    while begin < len(times):
        end = begin + size_of_piece(len(times) - begin, threads, least)
        heapreplace(free, free[0] + float(times[begin:end].sum()))
        begin = end
    return max(free)


def lane_times(kernels: Kernels, cells: np.ndarray) -> np.ndarray:
    """Return the time [s] of each lane alone."""
    starts, found = np.zeros((1, 4)), np.empty(len(cells))
    for lane in range(len(cells)):
        began = time.perf_counter()
        kernels.run(cells[lane : lane + 1], starts, TRANSIENT, PERIODS)
        found[lane] = time.perf_counter() - began
    return found


def measured(kernels: Kernels, cells: np.ndarray, threads: int) -> float:
    """Return the least time [s] of all lanes on so many threads, of three runs."""
    use_threads(threads)
    found = []
    for _ in range(3):
        began = time.perf_counter()
        kernels.run(cells, np.zeros((len(cells), 4)), TRANSIENT, PERIODS)
        found.append(time.perf_counter() - began)
    return min(found)


def main(side: int = 30) -> None:
    """Measure and print."""
    axes = {"omega": {"start": 5.0, "stop": 8.0, "num": side}}
    axes["P"] = {"start": 400.0, "stop": 1200.0, "num": side}
    record = {"want": ["energy", "regime"]}
    scan = load_scan({"system": "ssul-set6", "vary": axes, "record": record})
    kernels, cells = Kernels(wanted_of(scan)), scan.cells().reshape(-1, 1)
    use_threads(1)
    lane_times(kernels, cells[:2])  # compiles
    times = lane_times(kernels, cells)
    total, alone = times.sum(), measured(kernels, cells, 1)
    print(f"{len(cells)} lanes: {total:.2f} s, {np.median(times) * 1e3:.2f} ms in the median, "
          f"{times.max() * 1e3:.2f} ms at most")  # fmt: skip
    print("threads   static   pieces   measured")
    for threads in COUNTS:
        line = f"{threads:7} {total / static(times, threads):8.1f} "
        line += f"{total / dynamic(times, threads):8.1f}"
        if threads <= most_threads():
            line += f"   {alone / measured(kernels, cells, threads):8.2f}"
        print(line)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
