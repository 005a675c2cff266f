"""What the program costs, as ratios that another machine or another load hardly changes.

    python -m benchmarks.speed                       measure, and compare with ratios.json beside it
    python -m benchmarks.speed --keep                ... and make it the new baseline
    python -m benchmarks.speed --only diagram rk4    some of them

Each benchmark is timed in turn with a yardstick: fixed Runge-Kutta steps of an impact oscillator,
compiled by the same compiler, which no change of the program touches.  What counts is CPU time over
that of the yardstick just before and after it, the median of several rounds.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import numba
import numpy as np

from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.model.catalogue import load_system
from nlds_vines.orbits.batch import Batch
from nlds_vines.orbits.simulation import simulate

BASELINE = Path(__file__).with_name("ratios.json")
ROUNDS = 9
LOUD = 1.15  # a ratio to the baseline beyond which a line is marked
SET6 = load_system("ssul-set6")
YARD = 200_000  # steps


@numba.njit
def oscillator(x: float, v: float, t: float) -> float:
    """Return the acceleration of a forced oscillator behind a Hertz contact."""
    return np.cos(t) - x - 0.05 * v - (40.0 * (x - 0.5) * np.sqrt(x - 0.5) if x > 0.5 else 0.0)


@numba.njit
def steps(count: int, h: float) -> float:
    """Return its displacement after so many classical Runge-Kutta steps from rest."""
    x = v = 0.0
    for i in range(count):
        t, g = i * h, 0.5 * h
        b1 = oscillator(x, v, t)
        a2, b2 = v + g * b1, oscillator(x + g * v, v + g * b1, t + g)
        a3, b3 = v + g * b2, oscillator(x + g * a2, v + g * b2, t + g)
        a4, b4 = v + h * b3, oscillator(x + h * a3, v + h * b3, t + h)
        x += h / 6.0 * (v + 2.0 * (a2 + a3) + a4)
        v += h / 6.0 * (b1 + 2.0 * (b2 + b3) + b4)
    return x


def yardstick() -> None:
    """Do the work that all times are divided by."""
    steps(YARD, 0.01)


def orbit(
    name: str, periods: int, record: tuple[str, ...], **settings: Any
) -> Callable[[], object]:
    """Return what follows one orbit."""
    system = load_system(name, omega=6.28)
    return lambda: simulate(system, periods, record=record, **settings)


def scanned(num: int, **tables: object) -> Callable[[], object]:
    """Return what computes a scan around the irregular window, archive and all else left out."""
    document = {"system": "ssul-set6", "vary": {"omega": {"start": 7.0, "stop": 7.8, "num": num}}}
    scan = load_scan({**document, **tables})
    computer, blocks = Computer(scan), list(blocks_of(scan))
    return lambda: [computer.block(block) for block in blocks]


def designs() -> Callable[[], object]:
    """Return what runs a generation of a search."""
    cells = np.tile(SET6.cells(), 64)
    cells["k2"] = np.linspace(300.0, 1500.0, cells.size)
    batch, starts = Batch(SET6.scene), np.zeros((cells.size, 4))
    return lambda: batch.run(cells, starts, 200, 60)


BENCHMARKS: dict[str, Callable[[], Callable[[], object]]] = {
    "exact": lambda: orbit("ssul-set6", 4000, ("section", "impacts")),
    "exact, two walls": lambda: orbit("ssbl", 2000, ("section", "impacts")),
    "exact, no contact": lambda: orbit("tmd", 200_000, ("section",)),
    "rk4": lambda: orbit("ssul-set6", 300, ("section", "impacts"), method="rk4"),
    "energies": lambda: orbit("ssul-set6", 2000, ("energy",)),
    "soft contacts": lambda: orbit_of(K=1e5),
    "steel": lambda: orbit_of(E2=2.1e11),
    "diagram": lambda: scanned(41, record={"want": ["section", "impacts", "energy"]}),
    "verdicts": lambda: scanned(41, record={"want": ["regime", "lyapunov", "evidence"]}),
    "designs": designs,
}


def orbit_of(**changes: float) -> Callable[[], object]:
    """Return what follows an orbit of Set 6 with some parameters changed."""
    system = SET6.with_(**changes)
    return lambda: simulate(system, 2000, record=("section", "impacts"))


def spent(work: Callable[[], object]) -> float:
    """Return the CPU time of some work [s]."""
    began = time.process_time()
    work()
    return time.process_time() - began


def ratio(work: Callable[[], object]) -> float:
    """Return the time of some work in yardsticks."""
    work()  # compiles
    yardstick()
    found = []
    for _ in range(ROUNDS):
        before = spent(yardstick)
        taken = spent(work)
        found.append(2 * taken / (before + spent(yardstick)))
    return median(found)


def main() -> None:
    """Measure, compare and print."""
    parser = argparse.ArgumentParser(description="Costs as ratios to a yardstick.")
    parser.add_argument(
        "--only", nargs="+", metavar="NAME", choices=BENCHMARKS, help="some of them"
    )
    parser.add_argument("--keep", action="store_true", help="make this the baseline")
    options = parser.parse_args()
    names = options.only or list(BENCHMARKS)
    known = json.loads(BASELINE.read_text()) if BASELINE.exists() else {}
    for name in names:
        found = ratio(BENCHMARKS[name]())
        line = f"{name:20} {found:8.3f} yardsticks"
        if name in known:
            change = found / known[name]
            line += f"  {change:6.3f} of before{'  <--' if change > LOUD else ''}"
        print(line, flush=True)
        known[name] = round(found, 4)
    if options.keep:
        BASELINE.write_text(json.dumps(known, indent=2) + "\n")


if __name__ == "__main__":
    main()
