"""The same numbers again: neighbours, threads, blocks, and no compiler (entries 15, 16 and 17)."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import nlds_vines
from benchmarks.extremes.cases import BOTH, FULL, LINEAR
from benchmarks.extremes.entry import Entry, Finding, within
from nlds_vines import simulate
from nlds_vines.bifurcation.blocks import Block, blocks_of
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.model.catalogue import load_system
from nlds_vines.orbits import batch
from nlds_vines.orbits.status_words import BAD_PARAMETERS, OK
from nlds_vines.runs.shard import Shard
from nlds_vines.runs.threads import use_threads

CELLS = 8
SCAN: Mapping[str, Any] = {
    "system": "ssul-set6",
    "vary": {"omega": {"start": 7.3, "stop": 7.6, "num": CELLS}},
    "sampling": {"transient": 16, "periods": 24},
    "record": {"want": ["section", "impacts", "energy", "regime"]},
}
"""Orbits of several labels, with all that a scan usually records."""

MUST_BE_POSITIVE = ("m1", "m2", "omega", "K")
MUST_NOT_BE_NEGATIVE = (*MUST_BE_POSITIVE, "k1", "c1", "k2", "c2", "P")
MUST_BE_FINITE = (*MUST_NOT_BE_NEGATIVE, "near", "rest")

Arrays = Mapping[str, np.ndarray]


def _bits(values: np.ndarray) -> Any:
    return values.tolist() if values.dtype == object else values.tobytes()


def _differing(one: Arrays, other: Arrays) -> int:
    """Count the arrays that are not the same to the last bit."""
    return sum(_bits(one[name]) != _bits(other[name]) for name in one)


def bad_lanes() -> Finding:
    """Put bad numbers into one lane of a batch and look at its status and at its neighbours."""
    computer = Computer(load_scan(dict(SCAN)))
    cells, starts = computer.scan.cells()[:, np.newaxis], np.zeros((CELLS, 4))
    others, bad, wrong, tried = np.arange(CELLS) != 3, [], 0, 0
    bad += [(name, value) for name in MUST_BE_FINITE for value in (math.nan, math.inf, -math.inf)]
    bad += [(name, -1.0) for name in MUST_NOT_BE_NEGATIVE]
    bad += [(name, 0.0) for name in MUST_BE_POSITIVE]
    alone = computer.lanes(cells[others], starts[others])
    for name, value in bad:
        spoilt = cells.copy()
        spoilt[name][3] = value
        found = computer.lanes(spoilt, starts)
        rest = {key: np.ascontiguousarray(values[others]) for key, values in found.items()}
        wrong += _differing(alone, rest) + int(found["status"][3, 0] != BAD_PARAMETERS)
        tried += 1
    words = f"{tried} bad numbers beside {CELLS - 1} good lanes: {wrong} statuses or arrays differ"
    return within(wrong, 0.0, words)


def bad_links() -> Finding:
    """Put NaN into a link of a sweep: its own lane goes on from rest, the other is untouched."""
    computer = Computer(load_scan(dict(SCAN)))
    cells, starts = computer.scan.cells().reshape(2, -1), np.zeros((2, 4))
    plain, wrong = computer.lanes(cells, starts), 0
    spoilt = cells.copy()
    spoilt["rest"][0, 1] = math.nan
    found = computer.lanes(spoilt, starts)
    afresh = computer.lanes(cells[:1, 2:], starts[:1])
    wrong += found["status"][0].tolist() != [OK, BAD_PARAMETERS, OK, OK]
    for name in plain:
        wrong += _bits(found[name][1]) != _bits(plain[name][1])
        wrong += _bits(found[name][0, 2:]) != _bits(afresh[name][0])
    return within(wrong, 0.0, f"a sweep of 4 cells, the second one bad: {wrong} arrays differ")


def _in_pieces(computer: Computer, size: int) -> Arrays:
    """Return the datasets of a scan computed in blocks of so many cells, the last block first."""
    edges = range(0, CELLS, size)
    blocks = [Block(i, ((low, min(low + size, CELLS)),)) for i, low in enumerate(edges)]
    found = {block.index: computer.block(block) for block in reversed(blocks)}
    return _joined(found)


def _by_shards(computer: Computer, shards: int) -> Arrays:
    """Return the datasets of a scan computed shard by shard."""
    found = {}
    for index in range(shards, 0, -1):
        for block in blocks_of(computer.scan, Shard(index, shards)):
            found[block.index] = computer.block(block)
    return _joined(found)


def _joined(found: Mapping[int, Arrays]) -> Arrays:
    pieces = [found[index] for index in sorted(found)]
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


THREADS = (1, 2, 8)
"""Tried as far as there may be so many: `NUMBA_NUM_THREADS`, by default the number of cores."""


def whatever_the_order() -> Finding:
    """Compute a scan on several numbers of threads, in blocks of sizes, in shards, backwards."""
    computer, differing, ways = Computer(load_scan(dict(SCAN))), 0, 0
    counts = sorted({use_threads(threads) for threads in THREADS})
    usual, batch.PIECE_PERIODS = batch.PIECE_PERIODS, 1  # however short, every lane is a piece
    try:
        use_threads(1)
        plain = _in_pieces(computer, CELLS)
        for threads in counts:
            use_threads(threads)
            for found in (
                _in_pieces(computer, 1),
                _in_pieces(computer, 3),
                _in_pieces(computer, CELLS),
                _by_shards(computer, 2),
            ):
                differing += _differing(plain, found)
                ways += 1
        differing += _backwards(computer)
    finally:
        batch.PIECE_PERIODS = usual
        use_threads(None)
    words = (
        f"{ways} ways to compute {CELLS} orbits (threads: {', '.join(map(str, counts))}), and "
        f"lanes backwards: {differing} arrays differ"
    )
    return within(differing, 0.0, words)


def _backwards(computer: Computer) -> int:
    """Count the arrays that depend on the order of the lanes."""
    cells, starts = computer.scan.cells()[:, np.newaxis], np.zeros((CELLS, 4))
    one, other = computer.lanes(cells, starts), computer.lanes(cells[::-1].copy(), starts)
    return _differing(one, {k: np.ascontiguousarray(v[::-1]) for k, v in other.items()})


def sample() -> Arrays:
    """Return what must not depend on compilation: some orbits by both methods, with everything."""
    runs = {
        "short impacts": (load_system("ssul-set6", omega=7.45), FULL),
        "stepped contacts": (load_system("ssul-set6", K=1e5), BOTH),
        "two walls": (load_system("ssbl", omega=6.05), BOTH),
        "no wall": (load_system("tmd"), LINEAR),
    }
    found = {}
    for name, (system, record) in runs.items():
        for method, steps in (("exact", None), ("rk4", 64.0)):
            orbit = simulate(system, 3, record=record, method=method, period_steps=steps)
            assert orbit.section is not None
            scalars = np.array([orbit.E1max, orbit.E2max, orbit.clearance], dtype=float)
            numbers = [orbit.section.ravel(), scalars]
            if orbit.impacts is not None:
                columns = (orbit.impacts[key] for key in (orbit.impacts.dtype.names or ())[1:])
                numbers += [np.concatenate(list(columns))]
            found[f"{name}, {method}"] = np.concatenate(numbers)
    return found


def without_the_compiler() -> Finding:
    """Run `sample` as plain Python in another process; compare every bit."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plain.npz"
        code = (
            "import numpy; from benchmarks.extremes.repetition import sample; "
            f"numpy.savez({str(path)!r}, **sample())"
        )
        homes = Path(nlds_vines.__path__[0]).parent, Path(__file__).parents[2]
        known = (*map(str, homes), os.environ.get("PYTHONPATH", ""))
        paths = os.pathsep.join(filter(None, known))
        surroundings = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": paths}
        subprocess.run([sys.executable, "-c", code], env=surroundings, check=True)
        with np.load(path) as stored:
            plain = dict(stored)
    compiled = sample()
    differing = _differing(compiled, plain)
    numbers = sum(values.size for values in compiled.values())
    words = f"{numbers} numbers of {len(compiled)} orbits: {differing} orbits differ"
    return within(differing, 0.0, words)


ENTRIES = (
    Entry(
        15,
        "bad lanes",
        "A bad number inside a batch gives its lane the status bad_parameters and leaves every bit "
        "of its neighbours.",
        bad_lanes,
    ),
    Entry(
        15,
        "bad links",
        "A bad cell within a sweep ends there; the next one starts from rest.",
        bad_links,
    ),
    Entry(
        16,
        "whatever the order",
        "Blocks of 1, 3 and 8 cells or two shards, computed backwards, and lanes in reverse order "
        "change no bit of what a scan records, on 1, 2 or 8 threads.",
        whatever_the_order,
        "There are no more threads than NUMBA_NUM_THREADS: fewer are tried where that is less.",
    ),
    Entry(
        17,
        "without the compiler",
        "Compiled kernels and the same text run as plain Python agree to the last bit.",
        without_the_compiler,
        long=True,
    ),
)
