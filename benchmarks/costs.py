"""What each part of a scene and each record of an orbit costs: docs/accuracy.md.

python -m benchmarks.costs                    SSul NES Set 6
python -m benchmarks.costs --system tmd --set omega=6.9
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from nlds_vines.accuracy.command import declare_system, system_of
from nlds_vines.cli.command import Command
from nlds_vines.cli.options import Parser
from nlds_vines.cli.terminal import DONE, say, table
from nlds_vines.model.catalog import load_system
from nlds_vines.model.system import System
from nlds_vines.orbits.records import possible_want

SCENES = ("none", "tmd", "ssul-set6", "ssbl", "ssvi-b")
RECORDED = ("section", "impacts", "energy", "peak", "clearance", "trajectory", "regime")
TRANSIENT = 600  # periods before those in which impacts are counted and a period is looked for
TIMED, FEWER = 20_000, 1_000  # periods to time over; a trajectory has many states
DIAGRAM = 720  # periods of an orbit of the default diagram, whose regime is judged
REPEATS = 7


@dataclass(frozen=True)
class Part:
    """Something to time: `run(periods)` follows the orbit and notes what the name says."""

    name: str
    system: System
    run: Callable[[int], object]
    periods: int


def parts(system: System) -> Iterator[Part]:
    """Yield the bare orbit of `system`, what can be recorded of it, and bare orbits of others.

    The others are other scenes at the same frequency.
    """
    start = _settled(system)
    yield Part(f"{system.name}, nothing recorded", system, _recording(system, start), TIMED)
    yield Part("+ four variations", system, _varying(system, start), TIMED)
    for word in RECORDED:
        if word == "regime":
            yield Part("+ regime", system, _judging(system), DIAGRAM * (TIMED // DIAGRAM))
        elif word == "trajectory" or word in possible_want((word,), system.scene):
            periods = FEWER if word == "trajectory" else TIMED
            yield Part(f"+ {word}", system, _recording(system, start, word), periods)
    for name in SCENES:
        other = _at_frequency(name, system.parameters["omega"])
        if other.name != system.name:
            run = _recording(other, _settled(other))
            yield Part(f"{name}, nothing recorded", other, run, TIMED)


def report(system: System) -> Iterator[str]:
    """Yield the lines of a Markdown table: CPU time per forcing period, and its ratio to bare."""
    yield f"{system.title or system.name}, omega = {system.parameters['omega']:g} rad/s, and other"
    yield "scenes: CPU time of one thread per forcing period, once the orbit has settled (with a"
    yield f"limit to keep, from rest), median of {REPEATS} runs."
    yield ""
    head = ("orbit", "impacts per period", "CPU per period", "ratio")
    yield from table(head, _rows(system), right=(1, 2, 3))


def _rows(system: System) -> Iterator[tuple[str, ...]]:
    """Yield the cells of each part, measured on one thread."""
    from nlds_vines.runs.executors import use_threads

    use_threads(1)
    bare = 0.0
    for part in parts(system):
        seconds = measured(part)
        bare = bare or seconds
        often = f"{impact_rate(part.system):.2g}"
        yield part.name, often, f"{seconds * 1e6:.2g} us", f"{seconds / bare:.2g}"


@cache
def _rate_of(kind: str, parameters: tuple[tuple[str, float], ...]) -> float:
    from nlds_vines.orbits.simulation import simulate

    system = System(kind, dict(parameters))
    impacts = simulate(system, FEWER, transient=TRANSIENT, record=("impacts",)).impacts
    assert impacts is not None
    return len(impacts) / FEWER


def impact_rate(system: System) -> float:
    """Return the impacts of a period after the transient, 0 without a wall."""
    if not system.scene.walls:
        return 0.0
    return _rate_of(system.kind, tuple(system.parameters.items()))


def measured(part: Part) -> float:
    """Return the CPU time [s] of a part per period: median of several runs, compilation apart."""
    part.run(DIAGRAM)
    times = []
    for _ in range(REPEATS):
        began = time.process_time()
        part.run(part.periods)
        times.append(time.process_time() - began)
    return statistics.median(times) / part.periods


def _at_frequency(name: str, omega: float) -> System:
    """Return a system of the catalog; `ssvi-b`, which is not in it, with the SSbl's numbers."""
    if name == "ssvi-b":
        return System(name, load_system("ssbl", omega=omega).parameters)
    return load_system(name, omega=omega)


def _recording(system: System, start: list[float] | None, *record: str) -> Callable[[int], object]:
    """Return a function that follows an orbit and records what is asked for, or nothing."""
    from nlds_vines.orbits.simulation import simulate

    return lambda periods: simulate(system, periods, start=start, record=record)


def _settled(system: System) -> list[float] | None:
    """Return the state (x1, v1, x2, v2), or (x1, v1), of an orbit from rest after the transient.

    None, which is rest, where the scene has a limit: the state may be beyond it, and then no start.
    """
    from nlds_vines.orbits.simulation import simulate

    if system.scene.limit is not None:
        return None
    state: list[float] = simulate(system, TRANSIENT, record=()).state.tolist()
    return state


def _varying(system: System, settled: list[float] | None) -> Callable[[int], object]:
    """Return a function that follows an orbit with four variations, as a verdict does."""
    from nlds_vines.kernels.cells import verdict as course
    from nlds_vines.kernels.orbit import variations
    from tests.flights import flow_on

    flow, tangent, start = flow_on(system), np.zeros(16), np.zeros(4)
    if settled is not None:
        start[: len(settled)] = settled
    if len(settled or ()) == 4:  # the spring's shortening and its rate
        start[2:] = start[:2] - start[2:]
        start[2] += flow.space.rest

    def run(periods: int) -> None:
        state, logs = variations.new_state(), np.zeros(periods)
        variations.place_state(flow, start, state)
        variations.set_identity(tangent)
        course.follow_growth(
            flow, variations.no_section(flow.space), state, tangent, logs, np.zeros(4)
        )

    return run


def _judging(system: System) -> Callable[[int], object]:
    """Return a function that follows orbits of `DIAGRAM` periods and judges each of them."""
    from nlds_vines.orbits.batch import Kernels, Wanted
    from nlds_vines.orbits.solver_settings import Settings

    wanted = Wanted(system.scene, ("regime",), "exact", "standard", Settings.of("exact"))
    kernels = Kernels(wanted)

    def run(periods: int) -> None:
        orbits = periods // DIAGRAM
        cells, starts = np.full((orbits, 1), system.cells()), np.zeros((orbits, 4))
        kernels.run(cells, starts, TRANSIENT, DIAGRAM - TRANSIENT)

    return run


def _declare(parser: Parser) -> None:
    declare_system(parser)
    parser.add_argument("--dry-run", action="store_true", help="only say what it would take")


def _carry_out(options: argparse.Namespace) -> int:
    system = system_of(options)
    if options.dry_run:
        for part in parts(system):
            say(f"{part.name}: {part.periods} periods, {REPEATS} times")
        return DONE
    for line in report(system):
        say(line)
    return DONE


main = Command(
    name="python -m benchmarks.costs",
    description="What each part of a scene and each record of an orbit costs per forcing period.",
    examples="exit status: 0 done; 2 the request is wrong",
    declare=_declare,
    carry_out=_carry_out,
).main

if __name__ == "__main__":
    sys.exit(main())
