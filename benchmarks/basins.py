"""A plane of basins of attraction, timed against following every orbit to its end.

    python -m benchmarks.basins [SIDE [FILE.h5]]

The plane has SIDE x SIDE cells (1000): SSul NES Set 6 at 7.7 rad/s, where T,0 and 4T,2 coexist,
over displacement and velocity of the damper at t = 0.  It is computed as a scan, with its parts and
its archive.  Random cells of it are followed to their end as well, each with its own verdict: that
time, times the cells, is that of plain following, and the labels of both must be the same.  At last
random starts in the plane, not on its lattice, are followed; the shares must agree.
"""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.command import scan as compute
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.model.labels import finals
from nlds_vines.orbits.starts import given_states
from nlds_vines.transients.basin_shares import basin_measures
from nlds_vines.transients.survival import share_interval

SYSTEM, OMEGA = "ssul-set6", 7.7
RANGES = {"x2_0": (0.1, 0.26), "v2_0": (-1.0, 1.0)}
PLAIN, RANDOM = 10_000, 100_000
"""Cells that are followed to their end, and random starts."""


def main(arguments: list[str]) -> None:
    """Compute the plane, compare it, and print what was measured."""
    side = int(arguments[0]) if arguments else 1000
    ranges = {name: {"start": a, "stop": b, "num": side} for name, (a, b) in RANGES.items()}
    scan = load_scan(
        {"system": SYSTEM, "set": {"omega": OMEGA}, "vary": ranges, "start": {"policy": "rest"}}
        | {"record": {"want": ["attractor"]}}
    )
    computer, plain = Computer(scan), Computer(replace(scan, want=("regime",)))
    for one in (computer, plain):
        one.lanes(*one.orbits(np.zeros(1, np.int64)))  # compiles
    with tempfile.TemporaryDirectory() as folder:
        path = Path(arguments[1] if arguments[1:] else f"{folder}/plane.h5")
        began = time.perf_counter()
        compute(scan, to=path, quiet=True, overwrite=True)
        seconds = time.perf_counter() - began
        print(f"{side} x {side} cells: {seconds:.1f} s, {1e6 * seconds / scan.lanes:.1f} us each")
        with read(path) as view:
            labels = view["label"].ravel()
        measures = basin_measures(path)
    _compare_labels(plain, labels, seconds / scan.lanes)
    print(*measures.lines((20, 50, 100, 200)), sep="\n")
    for basin in measures.basins:
        count = int((_random(computer) == basin.number).sum())
        low, high = share_interval(count, RANDOM)
        inside = "within" if low <= basin.share <= high else "NOT within"
        print(
            f"{basin.label}: share {basin.share:.5f}, {inside} the interval {low:.5f} to "
            f"{high:.5f} of {RANDOM} random starts"
        )


def _compare_labels(plain: Computer, labels: np.ndarray, each: float) -> None:
    """Print how long plain following takes, and how many labels differ."""
    cells = plain.scan.lanes
    chosen = np.sort(np.random.default_rng(1).choice(cells, min(PLAIN, cells), replace=False))
    orbits = plain.orbits(chosen)
    began = time.perf_counter()
    found = finals(plain.lanes(*orbits)["label"])[:, 0]
    own = (time.perf_counter() - began) / len(chosen)
    print(f"followed to the end: {1e6 * own:.1f} us each, {own / each:.1f} times as long")
    print(f"labels that differ: {np.count_nonzero(found != labels[chosen])} of {len(chosen)}")


def _random(computer: Computer) -> np.ndarray:
    """Return the attractors (RANDOM,) of random starts in the plane."""
    generator = np.random.default_rng(7)
    initial = {name[:2]: generator.uniform(*ends, RANDOM) for name, ends in RANGES.items()}
    cells = np.repeat(computer.scan.cells().ravel()[:1], RANDOM)
    starts = given_states(cells, computer.scan.start, initial, computer.scan.system.scene)
    assert computer.attracted is not None
    found = computer.attracted.arrays(cells, starts, np.zeros(RANDOM, np.int64))["attractor"]
    return found[:, 0]


if __name__ == "__main__":
    main(sys.argv[1:])
