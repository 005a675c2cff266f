"""What each part of a scene and each record of an orbit costs: docs/accuracy.md.

python -m benchmarks.costs                    SSul NES Set 6
python -m benchmarks.costs --system tmd --set omega=6.9
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.cases import spent
from nlds_vines.accuracy.command import declare_system, system_of
from nlds_vines.cli.command import Command
from nlds_vines.cli.terminal import DONE, say, table
from nlds_vines.engine.records import possible_want
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.catalog import load_system
from nlds_vines.model.system import Preset

RECORDED = ("section", "impacts", "energy", "peak", "clearance", "trajectory")
TRANSIENT = 600  # periods before those in which impacts are counted
COUNTED = 1000  # periods in which impacts are counted
ORBITS, PERIODS = 8000, 30  # to time over
OFF = 1e-9  # share by which these begin off the settled orbit: meanwhile none repeats to the bit
VARIED = 16_000  # periods of the one orbit with variations
JUDGED, DIAGRAM = 20, 720  # orbits whose regime is judged, and their periods in the default diagram
REPEATS = 7


@dataclass(frozen=True)
class Part:
    """Something to time: what `run` takes longer than `without`, over a number of periods."""

    name: str
    system: Preset
    run: Callable[[], object]
    without: Callable[[], object]
    periods: int
    is_added: bool = False  # to what the bare orbit takes


def parts(system: Preset) -> Iterator[Part]:
    """Yield the bare orbit of `system`, what can be recorded of it, and bare orbits of others.

    The others are other scenes at the same frequency.
    """
    yield _recording(f"{system.name}, nothing recorded", system)
    yield _varying("+ four variations", system)
    for word in RECORDED:
        if word == "trajectory" or word in possible_want((word,), system.scene):
            yield _recording(f"+ {word}", system, word)
    yield _judging("+ regime", system)
    omega = system.parameters["omega"]
    others = {name: load_system(name, omega=omega) for name in ("none", "tmd", "ssul-set6", "ssbl")}
    others["ssvi-b"] = Preset("ssvi-b", others["ssbl"].parameters, name="ssvi-b")
    for name, other in others.items():
        if name != system.name:
            yield _recording(f"{name}, nothing recorded", other)


def _rows(system: Preset) -> Iterator[tuple[str, ...]]:
    """Yield the cells of each part, measured on one thread."""
    from nlds_vines.engine.simulation import simulate
    from nlds_vines.runs.executors import use_threads

    use_threads(1)
    bare, rates = 0.0, dict[str, float]()  # impacts of a period by the name of a system
    for part in parts(system):
        seconds = measured(part) + bare * part.is_added
        bare = bare or seconds
        name, impacts = part.system.name, None
        if name not in rates:
            if part.system.scene.walls:
                run = simulate(part.system, COUNTED, transient=TRANSIENT, record=("impacts",))
                impacts = run.impacts
            rates[name] = 0.0 if impacts is None else len(impacts) / COUNTED
        yield part.name, f"{rates[name]:.2g}", f"{seconds * 1e6:.2g} us", f"{seconds / bare:.2g}"


def measured(part: Part) -> float:
    """Return the CPU time [s] of a part per period: least of several runs, compilation apart."""
    times = [(spent(part.run), spent(part.without)) for _ in range(1 + REPEATS)]
    run, without = np.min(times[1:], axis=0)  # the first ones have compiled
    return float(run - without) / part.periods


def _start_of(system: Preset) -> np.ndarray:
    """Return the kernels' state (STATE_SIZE,) of a start `OFF` the settled orbit.

    From the orbit itself periods would repeat to the bit, and be copied. With a limit to keep the
    start is at rest: the settled state may be beyond the limit.
    """
    from nlds_vines.engine.kind_engine import start_state
    from nlds_vines.engine.simulation import simulate

    if system.scene.limit is not None:
        return start_state(system, system.cell.rest, None)
    settled = simulate(system, TRANSIENT, record=()).state
    return start_state(system, system.cell.rest, (1.0 + OFF) * settled)


def _recording(name: str, system: Preset, *record: str) -> Part:
    """Return the part of orbits of which something is recorded, or nothing."""
    from nlds_vines.engine.batch import Kernels, Wanted
    from nlds_vines.engine.simulation import SAMPLES
    from nlds_vines.engine.solver_settings import Settings

    stops, orbits = (SAMPLES, max(1, ORBITS // 50)) if "trajectory" in record else (1, ORBITS)
    want = tuple("section" if word == "trajectory" else word for word in record)
    kernels = Kernels(Wanted(system.scene, want, "exact", "standard", Settings.of("exact")))
    cells = np.full((orbits, 1), system.cells())
    starts = np.tile(_start_of(system)[:4], (orbits, 1))

    def run(periods: int) -> None:
        if stops > 1:
            kernels.states(cells, starts, Span(0, periods, stops))
        else:
            kernels.run(cells, starts, 0, periods)

    return Part(name, system, lambda: run(1 + PERIODS), lambda: run(1), orbits * PERIODS)


def _varying(name: str, system: Preset) -> Part:
    """Return the part of an orbit with four variations, as a verdict follows it."""
    from nlds_vines.kernels.cells.verdict import follow_growth
    from nlds_vines.kernels.orbit import variations
    from tests.flights import flow_on

    flow, tangent, start = flow_on(system), np.zeros(16), _start_of(system)[:4]

    def run(periods: int) -> None:
        state, logs = variations.new_state(), np.zeros(periods)
        variations.place_state(flow, start, state)
        variations.set_identity(tangent)
        sections = variations.no_section(flow.space)
        follow_growth(flow, sections, state, tangent, logs, np.zeros(4))

    return Part(name, system, lambda: run(VARIED), lambda: run(0), VARIED)


def _judging(name: str, system: Preset) -> Part:
    """Return the part that judging adds to orbits of the default diagram."""
    from nlds_vines.engine.batch import Kernels, Wanted
    from nlds_vines.engine.solver_settings import Settings

    cells, starts = np.full((JUDGED, 1), system.cells()), np.zeros((JUDGED, 4))

    def run(*want: str) -> None:
        wanted = Wanted(system.scene, want, "exact", "standard", Settings.of("exact"))
        Kernels(wanted).run(cells, starts, TRANSIENT, DIAGRAM - TRANSIENT)

    return Part(name, system, lambda: run("regime"), run, JUDGED * DIAGRAM, is_added=True)


def _carry_out(options: argparse.Namespace) -> int:
    """Print a Markdown table: CPU time per forcing period, and its ratio to the bare orbit's."""
    system = system_of(options)
    say(f"{system.title or system.name}, omega = {system.parameters['omega']:g} rad/s, and other")
    say(f"scenes: CPU time of one thread per forcing period, least of {REPEATS} runs.")
    say("")
    head = ("orbit", "impacts per period", "CPU per period", "ratio")
    for line in table(head, _rows(system), right=(1, 2, 3)):
        say(line)
    return DONE


main = Command(
    name="python -m benchmarks.costs",
    description="What each part of a scene and each record of an orbit costs per forcing period.",
    examples="exit status: 0 done; 2 the request is wrong",
    declare=declare_system,
    carry_out=_carry_out,
).main

if __name__ == "__main__":
    sys.exit(main())
