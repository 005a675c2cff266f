"""What Python adds to the compiled kernels, as CPU time on this machine, now.

    python -m benchmarks.python

Each piece of work is a call of a public function.  The time of the kernels is measured within the
same call, so that both meet the same load; what counts are medians over the calls.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import nlds_vines as nv
from benchmarks.speed import spent
from nlds_vines.cli.terminal import table
from nlds_vines.kernels.cells import lanes
from nlds_vines.orbits import load_flight, simulation
from nlds_vines.runs.executors import use_threads

KERNELS = (
    (simulation, "run_cell"),
    (load_flight, "fly_orbits"),
    (load_flight, "fill_rates"),
    (lanes, "run_lanes"),
    (lanes, "judge_lanes"),
)
"""The kernels that public functions call, by the modules in which they look for them."""

SAMPLES = 10_000
SPREAD = 0.05  # of the random parameters, relative to those of Set 6
SECONDS = 4.0  # of CPU time for one piece of work, unless one call takes longer


@contextmanager
def in_kernels(kernels: Iterable[tuple[Any, str]] = KERNELS) -> Iterator[list[float]]:
    """Collect the CPU times of the calls of kernels within the block."""
    times: list[float] = []

    def timed(kernel: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            began = time.thread_time()
            result = kernel(*arguments)
            times.append(time.thread_time() - began)
            return result

        return call

    before = [(module, name, getattr(module, name)) for module, name in kernels]
    for module, name, kernel in before:
        setattr(module, name, timed(kernel))
    try:
        yield times
    finally:
        for module, name, kernel in before:
            setattr(module, name, kernel)


def record_of_noise(folder: Path) -> Path:
    """Write a record of 40 s with 4000 samples: noise under a smooth envelope, up to 3 m/s^2."""
    times = np.arange(4000) * 0.01
    noise = np.random.default_rng(1).normal(size=len(times)) * np.sin(np.pi * times / 40.0)
    path = folder / "noise.csv"
    values = 3.0 * noise / np.abs(noise).max()
    lines = (f"{t:.2f},{value:.6f}" for t, value in zip(times, values, strict=True))
    path.write_text("\n".join(["time [s],acceleration [m/s^2]", *lines]))
    return path


def works(folder: Path) -> dict[str, Callable[[], object]]:
    system, record = nv.load_system("ssul-set6", omega=7.4), record_of_noise(folder)
    rng = np.random.default_rng(0)
    samples = {
        name: system.parameters[name] * (1.0 + SPREAD * rng.normal(size=SAMPLES))
        for name in ("k1", "k2", "C", "P")
    }
    quiet: dict[str, Any] = {"quiet": True}
    window = {"transient": 200, "periods": 100}
    return {
        "system.with_(omega=7.5)": lambda: system.with_(omega=7.5),
        "nv.simulate, 1 period": lambda: nv.simulate(system, 1, **quiet),
        "nv.classify, T,1": lambda: nv.classify(system.with_(omega=5.5), **quiet),
        "nv.response_history, blow, 10 s": lambda: nv.response_history(
            "tmd", impulse=300.0, duration=10.0, **quiet
        ),
        "nv.response_history, record, 40 s": lambda: nv.response_history(
            "tmd", load=str(record), duration=40.0, **quiet
        ),
        f"nv.scan, {SAMPLES} samples, 300 periods": lambda: nv.scan(
            system, samples=samples, record=["energy"], sampling=window, **quiet
        ),
    }


def main() -> None:
    use_threads(1)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, work in works(Path(folder)).items():
            work()  # compiles
            wholes, kernels = list[float](), list[float]()
            while sum(wholes) < SECONDS and len(wholes) < 1000:
                with in_kernels() as times:
                    wholes.append(spent(work))
                kernels.append(sum(times))
            whole, inside = 1e3 * median(wholes), 1e3 * median(kernels)
            rows.append(
                [name, f"{whole:.4g}", f"{inside:.4g}", f"{whole / inside:.3g}" if inside else ""]
            )
    print("\n".join(table(["work", "CPU [ms]", "kernels [ms]", "ratio"], rows)))


if __name__ == "__main__":
    main()
