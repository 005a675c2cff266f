"""Error against run time: our methods beside what a user would try instead.

As a command: `python -m nlds_vines.accuracy`, or `nlds-vines accuracy`.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines._command import DONE, Parser, assignments, parsed, run_command
from nlds_vines.catalogue import load_system

if TYPE_CHECKING:
    from nlds_vines.system import System

_NAME = "accuracy"
_EXAMPLES = """\
examples:
  nlds-vines accuracy
      SSul NES Set 6 at omega = 6.28 rad/s, twenty periods from rest
  nlds-vines accuracy --system ssul-set6 --set omega=7.45 --set E2=2.1e11
  nlds-vines accuracy --parts
      what a wall, a limit and each record cost per forcing period
"""
PERIODS = 20  # over which the error is measured
LONG = 20_000  # periods that a fast method is timed over
REPEATS = 5
FINEST_NODES, FINEST_STEPS = 20, 80.0  # of the reference
CONFIRMING = 16384  # fixed steps of a period that must confirm the reference


@dataclass(frozen=True)
class Contender:
    """A method at one setting: `run(periods)` returns the last state, from rest."""

    method: str
    setting: str
    run: Callable[[int], np.ndarray]
    timed: int  # periods to time it over


@dataclass(frozen=True)
class Result:
    """What was measured: largest error of x1, v1, x2, v2 [m, m/s], and CPU time a period [s]."""

    contender: Contender
    error: float
    seconds: float


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with the arguments `argv` (the process's own if None)."""
    return run_command(_NAME, _command, argv)


def _command(argv: Sequence[str]) -> int:
    options = _parser().parse_args(argv)
    texts = assignments("--set", options.set, "NAME=VALUE")
    changes = {name: parsed(float, f"--set {name}", text) for name, text in texts.items()}
    system = load_system(options.system, **changes)
    if options.parts:
        return _parts(system, options.dry_run)
    if options.dry_run:
        for contender in contenders(system):
            print(f"{contender.method} {contender.setting}: {contender.timed} periods".strip())
        return DONE
    for line in report(system):
        print(line, flush=True)
    return DONE


def _parts(system: System, dry_run: bool) -> int:
    from nlds_vines import costs

    if dry_run:
        for part in costs.parts(system):
            print(f"{part.name}: {part.periods} periods, {costs.REPEATS} times")
        return DONE
    for line in costs.report(system):
        print(line, flush=True)
    return DONE


def _parser() -> Parser:
    parser = Parser(
        prog=f"nlds-vines {_NAME}",
        description="Error against run time of every method on one system, one thread.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("--system", default="ssul-set6", metavar="NAME", help="[ssul-set6]")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument(
        "--parts", action="store_true", help="what each part and each record costs, instead"
    )
    parser.add_argument("--dry-run", action="store_true", help="only say what would be run")
    return parser


def report(system: System) -> Iterator[str]:
    """Yield the lines of a Markdown table of all methods on one system."""
    reference, doubt = reference_state(system)
    yield f"{system.title or system.name}, omega = {system.parameters['omega']:g} rad/s: error of"
    yield f"the state after {PERIODS} periods from rest, CPU time of one thread per forcing period."
    yield f"Two independent references differ by {doubt:.0e}."
    yield ""
    yield "| method | setting | error | CPU per period |"
    yield "|---|---|---:|---:|"
    for contender in contenders(system):
        result = measure(contender, reference)
        error = f"{result.error:.1e}" if result.error > doubt else f"< {doubt:.0e}"
        spent = _duration(result.seconds)
        yield f"| {contender.method} | {contender.setting} | {error} | {spent} |"


def reference_state(system: System) -> tuple[np.ndarray, float]:
    """Return the reference state after `PERIODS`, and how far another method is from it."""
    from nlds_vines.simulation import simulate

    finest = simulate(
        system, PERIODS, record=["section"], nodes=FINEST_NODES, resolution=FINEST_STEPS
    ).state
    other = simulate(system, PERIODS, record=["section"], method="rk4", resolution=CONFIRMING).state
    return finest, float(np.abs(finest - other).max())


def contenders(system: System) -> Iterator[Contender]:
    """Yield the methods from the finest setting of ours to the solvers of others."""
    from nlds_vines import peers
    from nlds_vines.simulation import simulate

    def ours(method: str, **settings: float) -> Callable[[int], np.ndarray]:
        record = ["section", "impacts"] if system.scene.walls else ["section"]
        return lambda n: simulate(system, n, method=method, record=record, **settings).state  # type: ignore[arg-type]  # nodes is an int

    def plain(steps: int) -> Callable[[int], np.ndarray]:
        def run(periods: int) -> np.ndarray:
            state = np.array([0.0, 0.0, p[11], 0.0])
            peers.plain_runge_kutta(p, steps, periods, state)
            return state

        return run

    p = peers.constants(system)
    if system.scene.walls:
        for nodes in (6, 8, 10, 12, 14, 16):
            yield Contender("exact", f"{nodes} nodes", ours("exact", nodes=nodes), LONG)
    else:
        yield Contender("exact", "", ours("exact"), LONG)
    for steps in (128, 256, 512, 1024, 2048, 4096):
        yield Contender("rk4", f"{steps} steps", ours("rk4", resolution=steps), LONG // 10)
    if not system.scene.damper:
        return
    for steps in (1024, 4096, 16384, 65536):
        yield Contender("plain RK4", f"{steps} steps", plain(steps), PERIODS)
    for rtol in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        run = _scipy(system, rtol)
        yield Contender("SciPy DOP853, events", f"rtol {rtol:.0e}", run, PERIODS)


def _scipy(system: System, rtol: float) -> Callable[[int], np.ndarray]:
    from nlds_vines import peers

    return lambda periods: peers.scipy_with_events(system, periods, rtol)


def measure(contender: Contender, reference: np.ndarray) -> Result:
    """Return error and CPU time of one contender: median of several runs, compilation apart."""
    error = float(np.abs(contender.run(PERIODS) - reference).max())
    times = []
    for _ in range(REPEATS if contender.timed > PERIODS else 1):
        began = time.process_time()
        contender.run(contender.timed)
        times.append(time.process_time() - began)
    return Result(contender, error, statistics.median(times) / contender.timed)


def _duration(seconds: float) -> str:
    """Return a time in words of a table."""
    if seconds < 1e-3:
        return f"{seconds * 1e6:.3g} us"
    return f"{seconds * 1e3:.3g} ms"


if __name__ == "__main__":
    sys.exit(main())
