"""How long a scan takes and how much room it needs, estimated from a small sample of it."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from nlds_vines.bifurcation.blocks import blocks_of, result_bytes, work_bytes
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.request import Scan
from nlds_vines.runs.progress import duration, size
from nlds_vines.runs.threads import use_threads

SAMPLE_LANES, SAMPLE_PERIODS = 32, 60
"""Orbits and forcing periods of the sample: a second or two after compiling."""


@dataclass(frozen=True)
class Estimate:
    """The time that a scan takes: `seconds` on so many `threads`."""

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
            f"results:  {size(result_bytes(scan))} before compression",
            f"memory:   {size(work_bytes(scan))} of results at a time, "
            f"{len(list(blocks_of(scan)))} blocks",
            f"time:     about {duration(self.seconds)} on {self.threads} threads, "
            "from a sample run here",
        ]


def estimate(scan: Scan, threads: int | None = None) -> Estimate:
    """Return the estimate for this machine, from a run of some cells of the scan."""
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
