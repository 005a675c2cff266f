"""What the program costs beside another state of it, on this machine, now.

    python -m benchmarks.speed                            CPU times of this checkout
    python -m benchmarks.speed --against ../before        ... and their ratios to another's
    python -m benchmarks.speed --only diagram rk4         some of them
    python -m benchmarks.speed --kernels                  ... and how much of it kernels do

Each checkout runs in a separate process and is called by public names only, so a checkout can be
compared if it has today's public names. Both do the same work in turn, under the same load; the
result is the median of the ratios of CPU time of such pairs. Beside it stands the ratio of the
shortest times, which other work leaves alone.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import nlds_vines as nv

HERE = Path(__file__).resolve().parents[1]
SET6 = nv.load_system("ssul-set6")
SECTIONS = ("section", "impacts")
WINDOW = {"start": 7.0, "stop": 7.8}  # [rad/s] irregular orbits among regular ones


def orbits(
    system: nv.System, count: int, record: tuple[str, ...] = SECTIONS, **sampling: Any
) -> Callable[[], object]:
    """Return a function that follows `count` orbits from random starts over 100 periods.

    A longer orbit would settle, and its periods would repeat to the bit and be copied.
    """
    tables: dict[str, Any] = {
        "vary": {"omega": [system.parameters["omega"]]},
        "start": {"policy": "random", "count": count, "seed": 1},
        "sampling": {"transient": 0, "periods": 100, **sampling},
        "record": record,
    }
    return lambda: nv.scan(system, quiet=True, **tables)


def changed(**changes: Any) -> nv.System:
    """Return Set 6 at 6.28 rad/s with some parameters or the contact law changed."""
    return nv.load_system("ssul-set6", omega=6.28, **changes)


def scanned(vary: Any, **tables: object) -> Callable[[], object]:
    """Return a function that computes a scan, and writes an archive that is deleted at once."""
    scan = nv.load_scan({"system": "ssul-set6", "vary": vary, **tables})
    return lambda: nv.scan(scan, quiet=True)


def often(times: int, call: Callable[..., object], *words: Any, **options: Any) -> Callable:
    """Return a function that calls another so many times."""
    return lambda: [call(*words, **options) for _ in range(times)]


def shaken() -> Callable[[], object]:
    """Return a function that follows a damper for 40 s of noise under a smooth envelope."""
    times = np.arange(4000) * 0.01
    noise = np.random.default_rng(1).normal(size=times.size) * np.sin(np.pi * times / 40.0)
    record = {"times": times.tolist(), "values": (3.0 * noise / np.abs(noise).max()).tolist()}
    load = {"record": {**record, "unit": "m/s^2"}}
    return partial(nv.response_history, "tmd", load=load, duration=40.0, quiet=True)


def sampled(count: int = 10_000) -> Callable[[], object]:
    """Return a function that follows Set 6 with four parameters drawn at random."""
    rng = np.random.default_rng(0)
    samples = {
        name: SET6.parameters[name] * (1.0 + 0.05 * rng.normal(size=count))
        for name in ("k1", "k2", "C", "P")
    }
    sampling: dict[str, Any] = {"transient": 200, "periods": 100}
    return lambda: nv.scan(SET6, samples=samples, record=["energy"], sampling=sampling, quiet=True)


LINE = {"omega": {**WINDOW, "num": 41}}
DESIGNS = {"k2": {"start": 300.0, "stop": 1500.0, "num": 64}}
PLANE = {"omega": {**WINDOW, "num": 9}, "P": {"start": 500.0, "stop": 900.0, "num": 5}}

BENCHMARKS: dict[str, Callable[[], Callable[[], object]]] = {
    "exact": lambda: orbits(changed(), 1000),
    "two-walls": lambda: orbits(nv.load_system("ssbl", omega=6.28), 500),
    "no-contact": lambda: orbits(nv.load_system("tmd", omega=6.28), 10_000, ("section",)),
    "rk4": lambda: orbits(changed(), 30, method="rk4"),
    "energies": lambda: orbits(changed(), 500, ("energy",)),
    "response": lambda: orbits(changed(), 500, ("response",)),
    "soft": lambda: orbits(changed(K=1e5), 500),
    "steel": lambda: orbits(changed(E2=2.1e11), 500),
    "hunt-crossley": lambda: orbits(changed(hunt_crossley=0.3), 500),
    "power": lambda: orbits(changed(law="power", K=6e6, exponent=1.2), 500),
    "linear": lambda: orbits(changed(law="linear", kc=1e6, cc=1e3), 500),
    "restitution": lambda: orbits(changed(law="restitution", e=0.7), 500),
    "diagram": lambda: scanned(LINE, record={"want": ["section", "impacts", "energy"]}),
    "verdicts": lambda: scanned(LINE, record={"want": ["regime", "lyapunov", "evidence"]}),
    "map": lambda: scanned(PLANE, record={"want": ["regime", "energy"]}),
    "branch": lambda: lambda: nv.continue_branch(SET6, "omega", (5.0, 9.0), quiet=True),
    "designs": lambda: scanned(
        DESIGNS, sampling={"transient": 200, "periods": 60}, record={"want": ["energy"]}
    ),
    "samples": sampled,
    "with_": lambda: often(1000, SET6.with_, omega=7.5),
    "simulate": lambda: often(300, nv.simulate, SET6, 1, quiet=True),
    "classify": lambda: often(50, nv.classify, SET6.with_(omega=5.5), quiet=True),
    "blow": lambda: often(20, nv.response_history, "tmd", impulse=300.0, duration=10.0, quiet=True),
    "record": shaken,
}


def spent(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began


@contextmanager
def in_kernels(kernels: Iterable[tuple[Any, str]] = ()) -> Iterator[list[float]]:
    """Collect the CPU times of the calls of kernels, each named by the module that looks for it.

    By default those that public functions call.
    """
    from nlds_vines.kernels.cells import lanes
    from nlds_vines.orbits import load_flight, simulation

    usual = (
        (simulation, "run_cell"),
        (load_flight, "fly_orbits"),
        (load_flight, "fill_rates"),
        (lanes, "run_lanes"),
        (lanes, "judge_lanes"),
    )
    times: list[float] = []

    def timed(kernel: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            began = time.thread_time()
            result = kernel(*arguments)
            times.append(time.thread_time() - began)
            return result

        return call

    before = [(module, name, getattr(module, name)) for module, name in kernels or usual]
    for module, name, kernel in before:
        setattr(module, name, timed(kernel))
    try:
        yield times
    finally:
        for module, name, kernel in before:
            setattr(module, name, kernel)


@contextmanager
def checkout(folder: Path) -> Iterator[Callable[[str], float]]:
    """Start a process of a checkout; yield a function that returns the CPU time [s] of a piece.

    It raises SystemExit where the checkout cannot do that piece of work.
    """
    with subprocess.Popen(
        [sys.executable, "-P", str(Path(__file__).resolve()), "--serve"],
        text=True,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(folder.resolve())},
    ) as process:

        def spends(name: str) -> float:
            assert process.stdin is not None
            assert process.stdout is not None
            print(name, file=process.stdin, flush=True)
            answer = process.stdout.readline()
            if not answer:
                raise SystemExit(f"{name}: the process has ended")
            return float(answer)

        try:
            yield spends
        finally:
            process.kill()


def serve() -> None:
    """Do the work that lines of standard input name, and print what each took."""
    prepared: dict[str, Callable[[], object]] = {}
    for line in sys.stdin:
        name = line.strip()
        if name not in prepared:
            prepared[name] = BENCHMARKS[name]()
            prepared[name]()  # compiles
        print(spent(prepared[name]), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="CPU times, beside those of another checkout.")
    parser.add_argument(
        "--only", nargs="+", metavar="NAME", choices=BENCHMARKS, help="some of them"
    )
    parser.add_argument("--against", type=Path, metavar="CHECKOUT", help="a folder of the project")
    parser.add_argument("--rounds", type=int, default=15, metavar="N", help="pairs (15)")
    parser.add_argument("--kernels", action="store_true", help="and how much of it kernels do")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        return serve()
    if options.kernels:
        for name in options.only or BENCHMARKS:
            work = BENCHMARKS[name]()
            work()  # compiles
            wholes, kernels = list[float](), list[float]()
            for _ in range(options.rounds):
                with in_kernels() as times:
                    wholes.append(spent(work))
                kernels.append(sum(times))
            print(f"{name:14} {median(wholes):10.6f} s, of which kernels {median(kernels):10.6f} s")
        return None
    with ExitStack() as stack:
        ours = stack.enter_context(checkout(HERE))
        other = stack.enter_context(checkout(options.against)) if options.against else None
        for name in options.only or BENCHMARKS:
            print(f"{name:14} {compared(ours, other, name, options.rounds)}", flush=True)
    return None


def compared(
    ours: Callable[[str], float], other: Callable[[str], float] | None, name: str, rounds: int
) -> str:
    """Return in words what a piece of work takes here, and beside the other checkout, if any."""
    mine, theirs = [], []
    for number in range(rounds + 1):
        if number % 2:
            mine.append(ours(name))
        if other is not None:
            theirs.append(other(name))
        if not number % 2:
            mine.append(ours(name))
    mine, theirs = mine[1:], theirs[1:]  # the first ones come after compiling
    text = f"{median(mine):8.4f} s"
    if other is not None:
        ratios = [a / b for a, b in zip(mine, theirs, strict=True)]
        text += f"   median of ratios {median(ratios):.3f}"
        text += f"   of shortest {min(mine) / min(theirs):.3f}"
    return text


if __name__ == "__main__":
    main()
