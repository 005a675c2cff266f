"""What gradients would bring to a tuning under a load: the polish with them and without.

    python -m benchmarks.polish

The designs that the global search of `nlds-vines tuning` ends with are polished as there, by Nelder
and Mead's simplices, and by SciPy's sequential quadratic programming with a gradient of central
differences.  Jumps of the objective are counted along k2 through the best design.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from scipy.optimize import minimize

from benchmarks.cases import spent
from nlds_vines.runs.executors import use_threads
from nlds_vines.tuning.design_space import values_of
from nlds_vines.tuning.request import Tuning, load_tuning
from nlds_vines.tuning.run import PROMISING, Objective, at_rest, distinct, polish, search_globally

STEP = 3e-6
"""Half a central difference, in the unit cube: what it leaves out, and round-off, are some 3e-9 of
a gradient, as differences over steps from 3e-3 to 1e-6 showed."""

REACH, PLACES, HALVINGS = 0.05, 801, 18
"""A line goes so far to both sides, in so many places; a jump is what halving leaves as it is."""

LOADS = {"blow": {"impulse": 1000.0}, "half-sine": {"half_sine": {"peak": 3000.0, "length": 0.5}}}
FREE = {
    "tmd": {"k2": {}, "c2": {}},
    "ssul-set6": {"k2": {"low": 100.0, "high": 1500.0}, "c2": {}, "C": {}},
}
CASES = (("blow", "x1_rms"), ("blow", "share_c1"), ("half-sine", "E1max"), ("blow", "last_1"),
         ("half-sine", "last_1"))  # fmt: skip


class Designs:
    """The objective of a tuning, which notes the designs that it was asked for."""

    def __init__(self, tuning: Tuning) -> None:
        self._tuning, self._objective = tuning, Objective(tuning)
        self.points = np.empty((0, len(tuning.free)))
        self.values = np.empty(0)

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Return the objective (n,) of points (n, parameters) of the unit cube."""
        designs = at_rest(values_of(self._tuning.free, points))
        values = self._objective.results(designs)[:, 0]
        self.points = np.concatenate([self.points, points])
        self.values = np.concatenate([self.values, values])
        return values


def by_gradients(designs: Designs, start: np.ndarray, most: int) -> None:
    """Search around a point of the unit cube, at most `most` evaluations, differences included."""
    unit, scale = np.eye(start.size), abs(float(designs(start[np.newaxis])[0]))
    left = (most - 1) // (2 * start.size + 1)

    def both(point: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal left
        if left == 0:
            raise StopIteration
        left -= 1
        up, down = (np.clip(point + step * unit, 0.0, 1.0) for step in (STEP, -STEP))
        value, *around = designs(np.vstack([point, up, down])) / scale
        ups, downs = np.split(np.array(around), 2)
        return value, (ups - downs) / (up - down).diagonal()

    with suppress(StopIteration):
        minimize(both, start, jac=True, method="SLSQP", bounds=[(0.0, 1.0)] * start.size,
                 options={"maxiter": most, "ftol": 1e-12})  # fmt: skip


def jumps(designs: Designs, best: np.ndarray) -> float:
    """Return how often the objective jumps along the first parameter, in a unit of it."""
    line = np.linspace(max(best[0] - REACH, 0.0), min(best[0] + REACH, 1.0), PLACES)

    def at(places: np.ndarray) -> np.ndarray:
        return designs(np.column_stack([places, np.tile(best[1:], (len(places), 1))]))

    values = at(line)
    change = np.abs(np.diff(values))
    steep = np.flatnonzero(change > 4 * np.median(change))
    low, high, below, above = line[steep], line[steep + 1], values[steep], values[steep + 1]
    for _ in range(HALVINGS if steep.size else 0):
        middle = 0.5 * (low + high)
        value = at(middle)
        lower = np.abs(value - below) > np.abs(above - value)
        high, above = np.where(lower, middle, high), np.where(lower, value, above)
        low, below = np.where(lower, low, middle), np.where(lower, below, value)
    return np.count_nonzero(np.abs(above - below) > 1e-5 * values.min()) / (line[-1] - line[0])


def row(system: str, load: str, name: str) -> str:
    tuning = load_tuning(
        system,
        {"load": LOADS[load], "free": FREE[system], "sampling": {"duration": 20.0},
         "search": {"objective": name}},
    )  # fmt: skip
    search, designs = tuning.search, Designs(tuning)
    designs(np.full((1, len(tuning.free)), 0.5))  # compiles
    seconds = spent(lambda: search_globally(designs, len(tuning.free), search, search.seed))
    best = distinct(designs.points, designs.values, PROMISING, search.apart, search.optima)
    least = designs.values[best[0]]
    columns, ends = [f"{designs.values.size - 1} | {seconds:.1f} s"], [least]
    for method in (polish, by_gradients):
        counted = Designs(tuning)

        def all_of_them(method=method, counted=counted) -> None:
            for start in designs.points[best]:
                method(counted, start, search.polish)

        seconds = spent(all_of_them)
        columns.append(f"{counted.values.size} | {seconds:.1f} s")
        ends.append(min(least, counted.values.min()))
    excess = " | ".join(f"{(end - min(ends)) / min(ends):.0e}" for end in ends)
    steps = jumps(designs, designs.points[best[0]])
    return f"| {system}, {load} | {name} | {steps:.0f} | {' | '.join(columns)} | {excess} |"


def main() -> None:
    use_threads(1)
    print("| damper, load | objective | jumps | global | | simplices | | gradients | "
          "| global | simplices | gradients |")  # fmt: skip
    print("|---|---|" + "---:|" * 10)
    for system in FREE:
        for load, name in CASES:
            print(row(system, load, name), flush=True)


if __name__ == "__main__":
    main()
