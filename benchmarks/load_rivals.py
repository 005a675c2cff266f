"""One blow beside the solvers of others: how long it takes, and how far off its end is.

python -m benchmarks.load_rivals              Set 6, struck to 1 m/s, for twenty natural periods
python -m benchmarks.load_rivals ssbl

Rivals begin with the speed that the blow leaves, without a force. Their last state is compared with
that of this package at its finest tolerance. Times are the processor's, of a second run: nothing is
compiled in it.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np

from benchmarks.accuracy import SOLVERS
from benchmarks.cases import spent
from benchmarks.load_costs import seconds_in_kernels
from nlds_vines.model.catalog import load_system
from nlds_vines.model.system import Preset
from tests.flights import fly, longest_cell

PERIODS, SPEED, FINEST = 20, 1.0, 1e-12
RIVALS = ("SciPy DOP853, events", "SciPy Radau", "heyoka Taylor, events")
SETTINGS = (1e-6, 1e-8, 1e-10)


def last_state(system: Preset, tolerance: float) -> np.ndarray:
    end = PERIODS * system.period
    count = math.ceil(end / longest_cell(system))
    jumps = np.zeros(count + 1)
    jumps[0] = SPEED
    load = SimpleNamespace(
        edges=np.linspace(0.0, end, count + 1), rows=np.zeros((count, 15)), jumps=jumps, share=1.0
    )
    return fly(system, load, record=(), tolerance=tolerance).state


def main(name: str = "ssul-set6") -> None:
    system = load_system(name)
    p = system.parameters
    system = system.with_(P=0.0, omega=math.sqrt(p["k1"] / p["m1"]))
    start = np.array([0.0, SPEED, system.rest or 0.0, 0.0])
    true = last_state(system, FINEST)
    scale = np.array([1.0 / system.parameters["omega"], 1.0] * 2) * SPEED

    def tell(who: str, setting: float, job: Callable[[], np.ndarray]) -> None:
        try:
            state, seconds = job(), spent(job)  # compiled by then
        except ArithmeticError as failure:
            print(f"{who:24s} {setting:7.0e}  failed: {failure}")
            return
        error = float(np.abs((state - true) / scale).max())
        print(f"{who:24s} {setting:7.0e}  {1e3 * seconds:10.3f} ms   error {error:.1e}", flush=True)

    print(f"{system.name}: {PERIODS} natural periods after v1 = {SPEED:g} m/s")
    for tolerance in SETTINGS:
        tell("this package", tolerance, partial(last_state, system, tolerance))
    for tolerance in SETTINGS:
        seconds = seconds_in_kernels(partial(last_state, system, tolerance))
        print(f"{'its kernel alone':24s} {tolerance:7.0e}  {1e3 * seconds:10.3f} ms")
    for solver in (one for one in SOLVERS if one.name in RIVALS):
        if find_spec(solver.package) is None:
            print(f"{solver.name:24s} is not installed")
            continue
        follow = solver.prepare(system, start)
        for setting in SETTINGS:
            tell(solver.name, setting, partial(follow, setting, PERIODS))


if __name__ == "__main__":
    main(*sys.argv[1:])
