"""Many orbits in one call of the kernels: an array of cells, each lane an orbit of its own.

`Kernels` runs chains of cells with everything that is wanted of them; `Batch` runs designs; of
these a search needs only how they ended and their largest energies.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.kernels.cells import lanes
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK, RESPONSE_COLUMNS, TOUCH_COLUMNS
from nlds_vines.kernels.scene.scene import Finished, LaneBuffers, Parts, Span
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import cell_type
from nlds_vines.orbits import evidence, responses
from nlds_vines.orbits.compilation import Compilation, Needed, kernels_of
from nlds_vines.orbits.kernel_inputs import parts_of
from nlds_vines.orbits.records import JUDGED, NOTED, noted, touches_noted
from nlds_vines.orbits.solver_settings import EFFORTS, TOLERANCE, Settings
from nlds_vines.runs.executors import in_pieces
from nlds_vines.runs.interrupts import stoppable
from nlds_vines.runs.progress import Tell

PIECE_PERIODS = 1000
"""Forcing periods of a piece of lanes at least: milliseconds, beside which its cost is nothing."""


@dataclass(frozen=True)
class Wanted:
    """What is wanted of orbits of one scene, and how they are computed.

    Arguments: the `scene`; `want`, of `records.WANTS`; `method` of `settings.METHODS`; `effort` of
    `settings.EFFORTS`, which a verdict may cost; the `settings` of the method.
    """

    scene: Scene
    want: Collection[str]
    method: str
    effort: str
    settings: Settings


@dataclass(frozen=True)
class Outputs:
    """The buffers of many orbits, (chains, links, ...) each; None for what is not wanted."""

    section: np.ndarray | None
    counts: np.ndarray | None
    cycle: np.ndarray | None
    energy: np.ndarray | None
    peak: np.ndarray | None
    clearance: np.ndarray | None
    violation: np.ndarray | None
    evidence: np.ndarray | None
    ends: np.ndarray | None
    response: np.ndarray | None
    foot: bool | None
    ground: bool | None
    touches: np.ndarray | None
    status: np.ndarray

    @classmethod
    def of(cls, wanted: Wanted, shape: tuple[int, int], transient: int, periods: int) -> Outputs:
        """Allocate the buffers that a `want` needs for (chains, links) of so many periods."""
        want, scene = set(wanted.want), wanted.scene
        walls, judged = bool(scene.walls), bool(want & JUDGED)
        counted = judged or not want.isdisjoint(("impacts", "modulation"))
        periods_noted = noted(want, transient, periods)
        touches = touches_noted(want, scene, periods)

        def rows(wanted: bool, *tail: int, dtype: Any = float, value: float = 0) -> Any:
            return np.full((*shape, *tail), value, dtype) if wanted else None

        return cls(
            section=rows(periods_noted > 0, periods_noted, len(scene.components)),
            counts=rows(counted and walls, 3, dtype=np.int64),
            cycle=rows("impacts" in want and not judged, 3, dtype=np.int64),
            energy=rows("energy" in want, 2),
            peak=rows("peak" in want, 2),
            clearance=rows("clearance" in want and walls, 1, value=np.inf),
            violation=rows(scene.limit is not None, 3),
            evidence=rows(judged, evidence.COLUMNS),
            ends=rows(judged, 2, STATE_SIZE),
            response=rows("response" in want, RESPONSE_COLUMNS),
            foot=responses.moving_foot(scene) if "response" in want else None,
            ground=responses.moving_ground(scene) if "response" in want else None,
            touches=rows(touches > 0, touches, TOUCH_COLUMNS, value=np.nan),
            status=np.zeros(shape, np.int64),
        )

    @property
    def buffers(self) -> LaneBuffers:
        """The buffers that `run_lanes` fills."""
        return LaneBuffers(**{name: getattr(self, name) for name in LaneBuffers._fields})

    @property
    def by_wall(self) -> np.ndarray:
        """The impacts (chains, links, 2) at either wall after the transient; 0 without walls."""
        if self.counts is None:
            return np.zeros((*self.status.shape, 2), np.int64)
        return self.counts[..., :2]

    def verdicts(self, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return every dataset that rests on a verdict, by name, (chains, links, ...) each.

        Arguments: the `cells` (chains, links) that were run.
        """
        assert self.evidence is not None
        assert self.section is not None
        size = self.section.shape[-1]
        return evidence.arrays_of(self.status, self.evidence, self.by_wall, cells, size)


def records_of(cells: np.ndarray) -> np.recarray:
    """Return cells as kernels take them; those that cannot be written to are copied.

    For Numba they are of another type: everything would be compiled once more.
    """
    return np.require(cells, requirements=("C", "W")).view(np.recarray)


def run(
    parts: Parts, chains: np.ndarray, starts: np.ndarray, span: Span, buffers: LaneBuffers
) -> np.ndarray:
    """Run chains of cells (chains, links) from `starts` (chains, 4); return their status.

    Fills the buffers.  The periods before `span` are the transient.
    """
    status = np.zeros(chains.shape, np.int64)
    cells, each = records_of(chains), chains.shape[1] * (span.first + span.periods)
    arguments = parts, cells, np.ascontiguousarray(starts), span, buffers, status
    least = max(1, PIECE_PERIODS // max(1, each))
    on_threads(lanes.run_lanes, arguments, len(chains), least)
    return status


@stoppable
def on_threads(
    kernel: Callable[..., None],
    arguments: tuple[Any, ...],
    count: int,
    least: int,
    most: int | None = None,
) -> None:
    """Run a kernel of `lanes` on so many lanes, in pieces from `least` to `most`."""
    kernel(0, 0, *arguments)  # compiled here, not by all threads at once
    in_pieces(lambda begin, end: kernel(begin, end, *arguments), count, least, most)


class Kernels:
    """The kernels for orbits of one scene at one fineness, with their constants prepared."""

    def __init__(self, wanted: Wanted, tell: Tell | None = None, *, helped: bool = True) -> None:
        """Prepare the parts that the scene has.

        Arguments: what is `wanted`; `tell` takes what is waited for where something is compiled;
        `helped` lets another process compile a part of it.
        """
        self._wanted = wanted
        self._compilation = Compilation(
            Needed(wanted.scene.key, wanted.method, tuple(wanted.want)), tell, helped
        )
        self._parts = parts_of(wanted.method, wanted.scene, wanted.settings)
        self._stages = np.array(EFFORTS[wanted.effort], dtype=np.int64)
        self._prepared = False

    @property
    def records(self) -> bool:
        """Whether anything is recorded of orbits that are run to their end."""
        return bool(self._wanted.want) or self._wanted.scene.limit is not None

    def run(self, chains: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outputs:
        """Run chains of cells (chains, links) from `starts` (chains, 4), with their verdicts."""
        self.prepare()
        outputs = Outputs.of(self._wanted, (len(chains), chains.shape[1]), transient, periods)
        span = Span(transient, periods, 1)
        outputs.status[:] = run(self._parts, chains, starts, span, outputs.buffers)
        if outputs.evidence is not None:
            self._judge(outputs, chains, transient, periods)
        return outputs

    def states(
        self, chains: np.ndarray, starts: np.ndarray, span: Span
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the states (chains, links, periods stops, components) at the stops of a span.

        And how each orbit ended.  Arguments as of `run`; nothing but a section may be wanted.
        """
        self.prepare()
        points = span.periods * span.stops
        outputs = Outputs.of(self._wanted, (len(chains), chains.shape[1]), 0, points)
        assert outputs.section is not None
        status = run(self._parts, chains, starts, span, outputs.buffers)
        return outputs.section, status

    def sections(self, chains: np.ndarray, starts: np.ndarray, periods: int) -> np.ndarray:
        """Return the section (chains, links, periods, components) of orbits without a verdict."""
        self.prepare()
        outputs = Outputs.of(self._wanted, (len(chains), chains.shape[1]), 0, periods)
        assert outputs.section is not None
        run(self._parts, chains, starts, Span(0, periods, 1), outputs.buffers)
        return outputs.section

    @stoppable
    def prepare(self) -> None:
        """Have all compiled that is wanted, unless it is; tell what is waited for."""
        if not self._prepared:
            with self._compilation.followed():
                for kernel in kernels_of(self._wanted.want):
                    if kernel == "verdict":
                        self._compilation.await_verdict()
                    self.compile(kernel)
            self._prepared = True

    def _judge(self, outputs: Outputs, chains: np.ndarray, transient: int, periods: int) -> None:
        """Judge the orbits that were run."""
        finished = Finished(outputs.ends, outputs.section, max(transient - NOTED, 0))
        cells, stages = records_of(chains), self._stages
        arguments = self._parts, cells, finished, stages, outputs.evidence, outputs.status
        # one may take longer than a hundred others: what is not periodic is followed further
        on_threads(lanes.judge_lanes, arguments, cells.size, 1, 1)

    def compile(self, kernel: str) -> None:
        """Have one of `compilation.kernels_of` compiled, unless the cache has it: for no orbit."""
        chains = np.zeros((0, 1), cell_type(self._wanted.scene))
        starts = np.zeros((0, 4))
        outputs = Outputs.of(self._wanted, chains.shape, 1, 1)
        if kernel == "orbit":
            if outputs.evidence is not None:
                evidence.compile_multipliers(len(self._wanted.scene.components))
            run(self._parts, chains, starts, Span(1, 1, 1), outputs.buffers)
        else:
            self._judge(outputs, chains, 1, 1)


METHOD = "exact"
"""The integrator of searches: rk4 is a cross-check, and too slow for them."""


@dataclass(frozen=True)
class Outcome:
    """How every lane ended: its largest energies [J] after the transient, its status; one shape.

    `other` is the number that a batch was asked for in place of E1max.
    `impacts`: how many there are, in each sampled period or under a load; None without walls.
    `violations` counts how often the damper came where its scene forbids it, from the start on.

    Energies of a lane that failed mean nothing; `inadmissible` says which may not be looked at.
    """

    E1max: np.ndarray
    E2max: np.ndarray
    status: np.ndarray
    violations: np.ndarray
    other: np.ndarray | None = None
    impacts: np.ndarray | None = None

    @property
    def objective(self) -> np.ndarray:
        """The number that is to be small: E1max, unless there is another."""
        return self.E1max if self.other is None else self.other

    @property
    def inadmissible(self) -> np.ndarray:
        """Lane by lane, whether a design is refused for it, whatever its energies.

        The one place that decides it: it failed, or broke the constraint of scenes b and c.
        """
        return (self.status != OK) | ~np.isfinite(self.objective) | (self.violations > 0)


class Batch:
    """Runs batches of cells of one scene; what all batches share is prepared once."""

    def __init__(
        self,
        scene: Scene,
        tell: Tell | None = None,
        tolerance: float = TOLERANCE,
        objective: str = "E1max",
    ) -> None:
        """Prepare for cells of `scene`; `tell` takes what is waited for meanwhile.

        Arguments: the `tolerance` of method exact; the `objective`, of `responses.objectives_of`.
        """
        self._scene, self._objective = scene, objective
        self._responds = objective not in responses.ENERGIES
        self._parts = parts_of(METHOD, scene, Settings.of(METHOD, tolerance))
        want = ("energy", "response") if self._responds else ("energy",)
        self._compilation = Compilation(Needed(scene.key, METHOD, want), tell, helped=False)

    def run(self, cells: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outcome:
        """Run one lane for each cell on the current threads, all in one call of the kernel.

        Arguments: `cells` of dtype `CELL` and any shape; `starts` (x1, v1, r, s) as
        `starts.random_states` has it, of that shape + (4,), zeros for rest; the forcing periods
        discarded and sampled.
        """
        chains = np.ascontiguousarray(cells.reshape(-1, 1))
        energy = np.zeros((*chains.shape, 2))
        violation = None if self._scene.limit is None else np.zeros((*chains.shape, 3))
        response = np.zeros((*chains.shape, RESPONSE_COLUMNS)) if self._responds else None
        counts = np.zeros((*chains.shape, 3), np.int64) if self._scene.walls else None
        buffers = LaneBuffers(counts=counts, energy=energy, violation=violation)
        if self._responds:
            foot, ground = responses.moving_foot(self._scene), responses.moving_ground(self._scene)
            buffers = buffers._replace(response=response, foot=foot, ground=ground)
        span = Span(transient, periods, 1)
        with self._compilation.followed():
            status = run(self._parts, chains, starts.reshape(-1, 4), span, buffers)
        broken = np.zeros(chains.shape) if violation is None else violation[..., 2]
        shape, other = cells.shape, energy[..., int(self._objective == "E2max")]
        if response is not None:
            values = responses.arrays_of(response, self._scene, chains)[self._objective]
            other = values if values.ndim == 2 else values.max(axis=-1)
        return Outcome(
            E1max=energy[..., 0].reshape(shape),
            E2max=energy[..., 1].reshape(shape),
            status=status.reshape(shape),
            violations=broken.reshape(shape),
            other=other.reshape(shape),
            impacts=None
            if counts is None
            else counts[..., :2].sum(axis=-1).reshape(shape) / periods,
        )
