"""The wait before the first orbit: the main command with an empty cache of compiled kernels.

    python -m benchmarks.cold                                    this package
    python -m benchmarks.cold --package ../before --package .    two checkouts, in turn
    python -m benchmarks.cold --rounds 5

The default scan is cut down to two short orbits, so that compiling is nearly all of it. Each run is
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

TINY = [
    "--vary", "omega=6:6.01:2", "--transient", "5", "--periods", "5",
    "-o", "a.h5", "--plot", "a.png", "--quiet",
]  # fmt: skip
"""What cuts the default scan down: its records and its picture are as ever."""

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


def cost(*arguments: str, package: Path | None = None) -> Cost:
    """Run Python with these arguments in an empty folder, with an empty cache; return the cost."""
    with tempfile.TemporaryDirectory() as folder:
        surroundings = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
        surroundings["NUMBA_CACHE_DIR"] = str(Path(folder) / "cache")
        if package is not None:
            surroundings["PYTHONPATH"] = str(package)
        began = time.perf_counter()
        with subprocess.Popen(
            [sys.executable, *arguments], cwd=folder, env=surroundings, stdout=subprocess.DEVNULL
        ) as process:
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        wall = time.perf_counter() - began
    if process.returncode:
        raise SystemExit(f"{' '.join(arguments[:3])}: status {process.returncode}")
    unit = 1 if sys.platform == "darwin" else 1024
    return Cost(wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * unit)


def main() -> None:
    parser = argparse.ArgumentParser(description="The wait before the first orbit.")
    parser.add_argument(
        "--package", action="append", type=Path, metavar="PATH", help="a folder with nlds_vines"
    )
    parser.add_argument("--rounds", type=int, default=3, metavar="N")
    options = parser.parse_args()
    here = Path(__file__).resolve().parents[1]
    packages = [path.resolve() for path in options.package or [here]]
    costs: list[list[tuple[Cost, Cost]]] = [[] for _ in packages]  # with the yardstick's around it
    before = cost("-c", YARDSTICK)
    for _ in range(options.rounds):
        for package, pairs in zip(packages, costs, strict=True):
            spent = cost("-m", "nlds_vines.bifurcation", *TINY, package=package)
            after = cost("-c", YARDSTICK)
            yard = Cost((before.wall + after.wall) / 2, (before.cpu + after.cpu) / 2, after.memory)
            pairs.append((spent, yard))
            before = after
    first = None
    for path, rounds in zip(packages, costs, strict=True):
        ratio = median(spent.wall / yard.wall for spent, yard in rounds)
        work = median(spent.cpu / yard.cpu for spent, yard in rounds)
        first = first or (ratio, work)
        wall, cpu = median(t.wall for t, _ in rounds), median(t.cpu for t, _ in rounds)
        memory = max(spent.memory for spent, _ in rounds)
        print(
            f"{path}: {ratio:.2f} yardsticks ({ratio / first[0]:.2f} of the first), "
            f"of CPU {work:.2f} ({work / first[1]:.2f}); {wall:.1f} s, {cpu:.1f} s of CPU, "
            f"{memory / 1e6:.0f} MB"
        )


if __name__ == "__main__":
    main()
