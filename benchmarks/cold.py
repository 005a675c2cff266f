"""The wait before the first orbit: commands with an empty cache of compiled kernels.

    python -m benchmarks.cold                                    this package
    python -m benchmarks.cold --package ../before --package .    two checkouts, in turn
    python -m benchmarks.cold --rounds 5

The first command computes two short orbits of the default scan, so that compiling is nearly all of
it. A portrait and a branch follow in the same folder, with the cache that it has left. Each run is
timed in turn with a yardstick: a fixed piece of Numba compiling in a fresh process, which no change
of the program touches. Wall time counts, over that of the yardstick before and after it, and CPU
time, helpers included, over the yardstick's, which a busy machine disturbs less: medians of several
rounds. The greatest memory of a process stands beside them.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median

COMMANDS = {
    "first command": [
        "-m", "nlds_vines", "bifurcation", "--vary", "omega=6:6.01:2", "--transient", "5",
        "--periods", "5", "-o", "a.h5", "--plot", "a.png", "--quiet",
    ],
    "portrait after it": [
        "-m", "nlds_vines", "portrait", "--windows", "5:10", "-o", "b.h5", "--plot", "b.png",
        "--quiet",
    ],
    "continuation after it": [
        "-m", "nlds_vines", "continuation", "--along", "omega=6.2:6.3", "-o", "c.h5",
        "--plot", "c.png", "--quiet",
    ],
}  # fmt: skip
"""The commands in their order. The first has the records and the picture of the default scan."""

YARDSTICK = """
import numba

TEXT = '''
@numba.njit(error_model="numpy")
def f{i}(x, n, a):
    s = 0.0
    for k in range(n):
        if a[k] > x:
            s += (a[k] - x) / (1.0 + s * s) + {i}
        elif a[k] < -x:
            s -= a[k] * x
        a[k] = s if s < 1e3 else {before}
    return s
'''
space = {"numba": numba}
for i in range(60):
    before = f"f{i - 1}(x, n - 1, a)" if i % 6 else "x"
    exec(TEXT.format(i=i, before=before), space)
import numpy as np
for i in range(5, 60, 6):
    space[f"f{i}"](0.5, 3, np.arange(3.0))
"""
"""Sixty functions, six deep: compiled, not cached."""


@dataclass
class Cost:
    """What a process and its helpers took: wall time and CPU time [s], memory [bytes] of one."""

    wall: float
    cpu: float
    memory: int


def cost_in(folder: Path, words: list[str], package: Path | None = None) -> Cost:
    """Run Python with these words in a folder, with the cache that lies there; return the cost."""
    surroundings = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
    surroundings["NUMBA_CACHE_DIR"] = str(folder / "cache")
    if package is not None:
        surroundings["PYTHONPATH"] = str(package)
    began = time.perf_counter()
    with subprocess.Popen(
        [sys.executable, "-P", *words], cwd=folder, env=surroundings, stdout=subprocess.DEVNULL
    ) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    wall = time.perf_counter() - began
    if process.returncode:
        raise SystemExit(f"{' '.join(words[:3])}: status {process.returncode}")
    unit = 1 if sys.platform == "darwin" else 1024
    return Cost(wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * unit)


def costs(package: Path, commands: dict[str, list[str]] = COMMANDS) -> dict[str, Cost]:
    """Run the commands of a package one after the other in an empty folder, with an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        return {name: cost_in(Path(folder), words, package) for name, words in commands.items()}


def yardstick() -> Cost:
    with tempfile.TemporaryDirectory() as folder:
        return cost_in(Path(folder), ["-c", YARDSTICK])


def main() -> None:
    parser = argparse.ArgumentParser(description="The wait before the first orbit.")
    parser.add_argument(
        "--package", action="append", type=Path, metavar="PATH", help="a folder with nlds_vines"
    )
    parser.add_argument("--rounds", type=int, default=3, metavar="N")
    options = parser.parse_args()
    here = Path(__file__).resolve().parents[1]
    packages = [path.resolve() for path in options.package or [here]]
    # of each package and command: its costs, each with the mean of the yardsticks around it
    rounds: dict[Path, dict[str, list[tuple[Cost, Cost]]]] = {
        package: {name: [] for name in COMMANDS} for package in packages
    }
    before = yardstick()
    for _ in range(options.rounds):
        for package in packages:
            spent = costs(package)
            after = yardstick()
            yard = Cost((before.wall + after.wall) / 2, (before.cpu + after.cpu) / 2, after.memory)
            for name, cost in spent.items():
                rounds[package][name].append((cost, yard))
            before = after
    for name in COMMANDS:
        first = summary(rounds[packages[0]][name])
        for package in packages:
            wall, cpu = summary(rounds[package][name])
            pairs = rounds[package][name]
            seconds = median(cost.wall for cost, _ in pairs)
            cpu_seconds = median(cost.cpu for cost, _ in pairs)
            memory = max(cost.memory for cost, _ in pairs)
            print(
                f"{package}, {name}: {wall:.2f} yardsticks ({wall / first[0]:.2f} of the first), "
                f"of CPU {cpu:.2f} ({cpu / first[1]:.2f}); {seconds:.1f} s, {cpu_seconds:.1f} s of "
                f"CPU, {memory / 1e6:.0f} MB"
            )


def summary(pairs: list[tuple[Cost, Cost]]) -> tuple[float, float]:
    """Return the medians of wall and CPU time over those of the yardstick."""
    wall = median(cost.wall / yard.wall for cost, yard in pairs)
    return wall, median(cost.cpu / yard.cpu for cost, yard in pairs)


if __name__ == "__main__":
    main()
