"""How long a scan takes and how much room it needs, estimated from a small sample of it."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from nlds_vines.bifurcation.attractors.attractor_assignment import learning_orbits
from nlds_vines.bifurcation.blocks import blocks_of, result_bytes, work_bytes
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.request import Scan
from nlds_vines.kernels.numerics.compiling import told_of_compilations
from nlds_vines.model.axis import Axis
from nlds_vines.model.words import parameters_in_words
from nlds_vines.orbits.compilation import SECONDS as COMPILING
from nlds_vines.orbits.compilation import kernels_of
from nlds_vines.orbits.records import ATTRACTOR
from nlds_vines.runs.progress import duration, size
from nlds_vines.runs.threads import use_threads

FEW = 3
"""Values of each parameter at which the attractors of the sample are learnt."""

SECONDS = 1.0
"""How long the sample runs at least, unless it comes to an end before."""

MOST_ORBITS = 50_000
"""Orbits that the sample is taken from at most."""

MOST_PERIODS = 20_000
"""Forcing periods of an orbit of the sample; a longer one is cut, and its cost drawn out."""


@dataclass(frozen=True)
class Estimate:
    """The time that a scan takes: `seconds` on so many `threads`, `learning` of it before.

    None where it cannot be known, as nothing is compiled yet.
    """

    scan: Scan
    threads: int
    seconds: float | None
    learning: float = 0.0

    def lines(self) -> list[str]:
        """Return the estimate, one fact a line."""
        scan = self.scan
        grid = " x ".join(str(n) for n in scan.shape)
        each = scan.transient + scan.periods
        return [
            scan.title,
            f"system:   {parameters_in_words(scan.system, [axis.name for axis in scan.axes])}",
            f"orbits:   {scan.lanes} ({grid} cells, {_counted(scan.starts, 'start')} each)",
            f"periods:  {scan.transient} + {scan.periods} each, {scan.lanes * each} in all",
            f"results:  {size(result_bytes(scan))} before compression",
            f"memory:   {size(work_bytes(scan))} of results at a time, "
            + _counted(len(list(blocks_of(scan))), "block"),
            *self._learning(),
            f"time:     {self._time()}",
        ]

    def _time(self) -> str:
        """Return the time in words."""
        if self.seconds is not None:
            time = duration(self.seconds)
            return f"about {time} on {self.threads} threads, from a sample run here"
        seconds = sum(COMPILING[kernel] for kernel in kernels_of(self.scan.want))
        return (
            f"not known before the first run of this kind, which compiles (about {seconds} s); "
            "after it, --dry-run tells"
        )

    def _learning(self) -> list[str]:
        """Return a line on the orbits from which attractors are learnt, where they are."""
        if not self.learning:
            return []
        orbits = _counted(learning_orbits(self.scan), "orbit")
        return [f"learning: attractors from {orbits}, about {duration(self.learning)}"]


def _counted(number: int, what: str) -> str:
    """Return a number of things in words."""
    return f"{number} {what}" + "s" * (number != 1)


def estimate(scan: Scan, threads: int | None = None) -> Estimate:
    """Return the estimate for this machine, from a run of orbits of the scan as they are.

    Nothing is compiled for it: where that would be necessary, the time is not known.
    More and more of them, spread over the cells, are run until `SECONDS` are over.  In a sweep,
    as many at once as there are chains of cells.
    """
    used = use_threads(threads)
    try:
        with told_of_compilations(_refuse):
            return _estimate(scan, used)
    except _NotCompiledError:
        return Estimate(scan, used, None)
    finally:
        use_threads(threads)


class _NotCompiledError(Exception):
    """A kernel would have to be compiled."""


def _refuse(kernel: object) -> None:
    raise _NotCompiledError


def _estimate(scan: Scan, used: int) -> Estimate:
    whole_orbit = scan.transient + scan.periods
    cut = min(1.0, MOST_PERIODS / whole_orbit)
    short = replace(
        scan, transient=int(scan.transient * cut), periods=max(1, int(scan.periods * cut))
    )
    short, learning = _thinned(short), 0.0
    computer = Computer(short)
    if computer.attracted is not None:
        computer.attracted.learn()  # loads what is compiled
        again = Computer(short).attracted
        assert again is not None
        began = time.perf_counter()
        again.learn()
        learning = (time.perf_counter() - began) * learning_orbits(scan) / learning_orbits(short)
    lanes = short.lanes
    chosen = (
        np.arange(lanes)
        if lanes <= MOST_ORBITS
        else np.linspace(0, lanes - 1, MOST_ORBITS).astype(np.int64)
    )
    chosen = np.random.default_rng(0).permutation(chosen)
    computer.lanes(*computer.orbits(chosen[:1]))  # likewise
    if scan.start.sweeps:
        use_threads(min(used, scan.lanes // scan.shape[-1]))
    seconds, done = _timed(computer, chosen, 8 * used)
    longer = whole_orbit / (short.transient + short.periods)
    learning *= longer
    return Estimate(scan, used, seconds / done * scan.lanes * longer + learning, learning)


def _thinned(scan: Scan) -> Scan:
    """Return a scan whose attractors are learnt in a moment: of each parameter a few values."""
    if ATTRACTOR not in scan.want:
        return scan
    few = {axis: np.linspace(0, axis.values.size - 1, FEW).astype(int) for axis in scan.parameters}
    axes = (
        Axis(axis.name, np.unique(axis.values[few[axis]])) if axis in few else axis
        for axis in scan.axes
    )
    return replace(scan, axes=tuple(axes))


def _timed(computer: Computer, chosen: np.ndarray, count: int) -> tuple[float, int]:
    """Run orbits in their order, `count` of them and then ever more; return seconds and orbits."""
    done, spent = 0, 0.0
    while done < len(chosen) and spent < SECONDS:
        some = computer.orbits(np.sort(chosen[done : done + count]))
        began = time.perf_counter()
        computer.lanes(*some)
        spent += time.perf_counter() - began
        done += len(some[0])
        count *= 2
    return spent, done
