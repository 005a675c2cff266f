"""What a cell under a load costs beside one under the harmonic force, and beside SciPy.

python -m benchmarks.load_costs               a tuned mass damper, which never touches
python -m benchmarks.load_costs ssul-set6
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.cases import in_kernels
from nlds_vines.engine import simulation
from nlds_vines.model.catalog import load_system
from nlds_vines.model.system import Preset
from tests import flights

PERIODS, REPEATS, SOLVED = 100, 41, 40
SHIFT = 0.618033988749895  # of a cell, by which edges move on in a period: no record fits it
RECORDS = (["energy"], ["energy", "states"], ["energy", "response"])


def seconds_in_kernels(job: Callable[[], object]) -> float:
    """Return the CPU time [s] of the kernels of a job, median of `REPEATS` runs once compiled."""
    job()
    runs = []
    for _ in range(REPEATS):
        with in_kernels() as times:
            job()
        runs.append(sum(times))
    return statistics.median(runs)


def cells(system: Preset) -> tuple[int, np.ndarray, np.ndarray]:
    """Return how many cells a period has, edges of cells, and the harmonic force's coefficients."""
    p = system.parameters
    count = max(math.ceil(system.period / flights.longest_cell(system)), 8)
    edges = np.linspace(0.0, PERIODS * system.period, round(PERIODS * (count + SHIFT)) + 1)
    phase, angle = p["omega"] * edges[:-1], p["omega"] * np.diff(edges)
    waves = np.cos(phase), -np.sin(phase), -np.cos(phase), np.sin(phase)
    rows = np.zeros((len(phase), 15))
    for k in range(15):
        rows[:, k] = p["P"] * angle**k / math.factorial(k) * waves[k % 4]
    return count, edges, rows


def load_of(edges: np.ndarray, rows: np.ndarray, degree: int) -> SimpleNamespace:
    """Return the load with the force's values at the edges, of degree 3 with its slopes, too.

    So are records. Of degree 14 it is the force itself.
    """
    padded = rows
    if degree < 14:
        powers, padded = np.arange(15), np.zeros_like(rows)
        f0, f1 = rows[:, 0], rows.sum(axis=1)
        g0, g1 = rows[:, 1], (rows * powers).sum(axis=1)
        padded[:, 0], padded[:, 1] = f0, f1 - f0
        if degree == 3:
            padded[:, 1] = g0
            padded[:, 2], padded[:, 3] = 3 * (f1 - f0) - 2 * g0 - g1, 2 * (f0 - f1) + g0 + g1
    return SimpleNamespace(edges=edges, rows=padded, jumps=None, share=1.0)


def main(name: str = "tmd") -> None:
    """Print the time of a cell, and its ratio to that under the harmonic force."""
    system = load_system(name, omega=5.0)
    per_period, edges, rows = cells(system)
    count, walls = PERIODS * per_period, bool(system.scene.walls)
    print(f"{system.name}: {len(rows)} cells; CPU time of a cell [ns], ratio to the harmonic force")
    for record in RECORDS:
        recorded = [{"states": "trajectory"}.get(word, word) for word in record]
        recorded += ["impacts"] * walls
        harmonic = seconds_in_kernels(
            lambda recorded=recorded: simulation.simulate(  # type: ignore[misc]
                system, PERIODS, record=recorded, samples=per_period, quiet=True
            )
        )
        columns = [f"{', '.join(record):18s} harmonic {harmonic / count * 1e9:6.1f}"]
        for degree in (1, 3, 14):
            load = load_of(edges, rows, degree)
            seconds = seconds_in_kernels(
                lambda load=load, record=record: flights.fly(  # type: ignore[misc]
                    system, load, record=[*record, *["impacts"] * walls]
                )
            )
            cost, ratio = seconds / len(rows) * 1e9, seconds / len(rows) / (harmonic / count)
            columns.append(f"degree {degree:2d} {cost:6.1f} ({ratio:.2f})")
        print("   ".join(columns), flush=True)
    if not walls:
        print(f"SciPy's DOP853, 1e-9: {scipy_cell(system, edges, rows) * 1e9:.0f} ns a cell")


def scipy_cell(system: Preset, edges: np.ndarray, rows: np.ndarray) -> float:
    """Return the time [s] of a cell of SciPy's solver, which is stopped at each edge."""
    p, count = system.parameters, SOLVED

    def slope(t: float, y: np.ndarray, j: int) -> list[float]:
        x = (t - edges[j]) / (edges[j + 1] - edges[j])
        force = np.polynomial.polynomial.polyval(x, rows[j])
        joint = p.get("k2", 0.0) * (y[2] - y[0]) + p.get("c2", 0.0) * (y[3] - y[1])
        a1 = (force - p["k1"] * y[0] - p["c1"] * y[1] + joint) / p["m1"]
        return [y[1], a1, y[3], -joint / p.get("m2", 1.0)]

    y, began = np.zeros(4), time.process_time()
    for j in range(count):
        span = (edges[j], edges[j + 1])
        y = solve_ivp(slope, span, y, "DOP853", rtol=1e-9, atol=1e-12, args=(j,)).y[:, -1]
    return (time.process_time() - began) / count


if __name__ == "__main__":
    main(*sys.argv[1:])
