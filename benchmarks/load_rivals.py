"""One blow beside the solvers of others: how long it takes, and how far off its end is.

python -m benchmarks.load_rivals              Set 6, struck to 1 m/s, for twenty natural periods
python -m benchmarks.load_rivals ssbl

Rivals begin with the speed that the blow leaves, without a force, and split contacts off by events;
what they find is compared with the end by this package at its finest. Times are the processor's, of
a second run: nothing is compiled in it.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace

import numpy as np

from benchmarks.load_costs import Clock
from benchmarks.rivals import RIVALS
from benchmarks.rivals.rival import Asked, Flow
from nlds_vines.accuracy.measured_cases import SolverFailure
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.system import System
from nlds_vines.orbits.load_flight import fly, longest_cell

PERIODS, SPEED, FINEST = 20, 1.0, 1e-12
RIVALS_SHOWN = ("SciPy DOP853, events", "SciPy Radau, events", "heyoka Taylor, events")
SETTINGS = (1e-6, 1e-8, 1e-10)


def timed(job: Callable[[], np.ndarray]) -> tuple[np.ndarray, float]:
    """Return what a job finds, and the processor's time [s] of its second run."""
    job()
    began = time.process_time()
    found = job()
    return found, time.process_time() - began


def own(system: System, tolerance: float) -> np.ndarray:
    """Return the state of this package after the blow."""
    end = PERIODS * system.period
    count = math.ceil(end / longest_cell(system))
    jumps = np.zeros(count + 1)
    jumps[0] = SPEED
    load = SimpleNamespace(
        edges=np.linspace(0.0, end, count + 1), rows=np.zeros((count, 15)), jumps=jumps, share=1.0
    )
    return fly(system, load, record=(), tolerance=tolerance, quiet=True).state


def main(name: str = "ssul-set6") -> None:
    """Print a line for each solver and setting."""
    system = load_system(name)
    p = system.parameters
    system = system.with_(P=0.0, omega=math.sqrt(p["k1"] / p["m1"]))
    start = np.array([0.0, SPEED, system.rest or 0.0, 0.0])
    true = own(system, FINEST)
    scale = np.array([1.0 / system.parameters["omega"], 1.0] * 2) * SPEED

    def tell(who: str, setting: float, job: Callable[[], np.ndarray]) -> None:
        try:
            state, seconds = timed(job)
        except SolverFailure as failure:
            print(f"{who:24s} {setting:7.0e}  failed: {failure}")
            return
        error = float(np.abs((state - true) / scale).max())
        print(f"{who:24s} {setting:7.0e}  {1e3 * seconds:10.3f} ms   error {error:.1e}", flush=True)

    print(f"{system.name}: {PERIODS} natural periods after v1 = {SPEED:g} m/s")
    for tolerance in SETTINGS:
        tell("this package", tolerance, partial(own, system, tolerance))
    clock = Clock()
    for tolerance in SETTINGS:
        seconds = clock.of(partial(own, system, tolerance))
        print(f"{'its kernel alone':24s} {tolerance:7.0e}  {1e3 * seconds:10.3f} ms")
    for rival in (one for one in RIVALS if one.name in RIVALS_SHOWN):
        if not rival.available():
            print(f"{rival.name:24s} is not installed")
            continue
        flow = rival.prepare(system, start)

        def end(setting: float, flow: Flow = flow) -> np.ndarray:
            return flow(setting, PERIODS, Asked.NOTHING).section[-1]

        for setting in SETTINGS:
            tell(rival.name, setting, partial(end, setting))


if __name__ == "__main__":
    main(*sys.argv[1:])
