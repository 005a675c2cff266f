"""Many orbits in one call of the kernels, and the datasets of their verdicts and spectra."""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from importlib import import_module
from pkgutil import iter_modules
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.engine import responses
from nlds_vines.engine.compilation import Compilation, Needed, kernels_of
from nlds_vines.engine.records import JUDGED, NOTED, noted, touches_noted
from nlds_vines.engine.solver_settings import EFFORTS, Settings
from nlds_vines.engine.spectrum import LINES, UNCLEAR, SpectralRecords, spectral_label, spectrum_of
from nlds_vines.engine.starts import ROUND_OFF, checked_start, user_states
from nlds_vines.errors import RequestError
from nlds_vines.kernels import laws
from nlds_vines.kernels.cells import cells as part_period
from nlds_vines.kernels.cells import lanes
from nlds_vines.kernels.cells.cycles import NUMBERS_OF_CYCLE, Traced
from nlds_vines.kernels.cells.verdict import RESOLVED
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.numerics.deciding import says
from nlds_vines.kernels.numerics.matrices import LOG, fill_multipliers
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.orbit.repetition import REPEATS, period_of
from nlds_vines.kernels.orbit.repetition import TOLERANCE as RECURS
from nlds_vines.kernels.scene import codes
from nlds_vines.kernels.scene.scene import Finished, Ground, LaneBuffers, Parts, Span
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS, Impacts
from nlds_vines.model.labels import FLAGS, KEPT, flags_of, labels_of
from nlds_vines.model.presets import cell_type
from nlds_vines.model.quantities import stored_in
from nlds_vines.model.scenes import Scene, scene_of
from nlds_vines.model.system import Preset
from nlds_vines.runs.executors import in_pieces
from nlds_vines.runs.interrupts import stoppable
from nlds_vines.runs.progress import Tell

# least number of forcing periods that a thread takes at a time: milliseconds of work
PIECE_PERIODS = 1000

# the compiled functions that run many orbits, with the names of their kernels
LANES = {
    fill_multipliers: "orbit",  # compiled before the verdict that uses it
    lanes.run_lanes: "orbit",
    lanes.judge_lanes: "verdict",
}

COUNTED = "impact count"  # the word for impact counts without an orbit's period

# types whose numbers kernels do not read: a ground with walls that limit the structure, and walls
# by the name of the law and by whether a damping constant adds to it (`is_damped`)
GROUND = Ground(*[0.0] * len(Ground._fields))
_FILES = [import_module(f"{laws.__name__}.{file.name}") for file in iter_modules(laws.__path__)]
WALLS: dict[tuple[str, bool], Any] = {
    law: wall for file in _FILES for law, wall in getattr(file, "SORTS", {}).items()
}

_loaded: set[Needed] = set()  # the kernels that this process has compiled or loaded
TURN = 6.283185307179586  # 2 pi


def parts_of(method: str, scene: Scene, settings: Settings | None = None) -> Parts:
    """Return the `Parts` of a scene for a method, by default with the settings of scans.

    An absent part is None and absent from the machine code.
    """
    settings = Settings.of(method) if settings is None else settings
    near, far = (
        WALLS[scene.law_at(name).name, scene.is_damped(name)] if name in scene.walls else None
        for name in ("near", "far")
    )
    short = says(near, "SHORT_IMPACTS") or says(far, "SHORT_IMPACTS")
    return Parts(
        rk4=None if method == "exact" else True,
        damper=True if scene.damper else GROUND if scene.grounded else None,
        near=near,
        far=far,
        apart=None if scene.law_2 is None else True,
        load=None if scene.load is None else True,
        ground=True if scene.shaken else None,
        arc=make_arc(settings.contact_tolerance, settings.nodes) if short else None,
        contact_steps=float(settings.steps),
        contact_tolerance=float(settings.stepped_to),
        period_steps=float(settings.period_steps),
    )


def room_for(n: int, size: int, count: int, width: int = 4, walls: int = 2) -> Traced:
    """Return the buffers for one orbit of n periods and `count` free parameters.

    `width` is the number of numbers of a section.
    """
    return Traced(
        np.empty((n, width)),
        np.zeros(walls, np.int64),
        np.empty((size, size)),
        np.empty((count, width)),
        np.empty((size, 2)),
        np.empty(NUMBERS_OF_CYCLE),
    )


def room_for_impacts(capacity: int) -> Impacts:
    return Impacts(np.empty((capacity, IMPACT_COLUMNS)), np.zeros(1, np.int64))


def start_state(
    system: Preset, rest: float, start: Sequence[float] | np.ndarray | None
) -> np.ndarray:
    """Return the kernels' state (x1, v1, r, s, q, mode) of a start in the user's coordinates."""
    state = np.zeros(STATE_SIZE)
    if start is None:
        return state
    values = checked_start(start, system.scene.components)
    state[:2] = values[:2]
    if system.scene.damper:
        state[2], state[3] = values[0] - (values[2] - rest), values[1] - values[3]
    elif system.scene.grounded:
        state[2], state[3] = values
    scene, p, limit = system.scene, system.parameters, system.scene.limit
    for struck, gap, sign in (("near", scene.gap_near, 1.0), ("far", scene.gap_far, -1.0)):
        law = scene.law_at(struck)
        depth = -math.inf if gap is None else sign * state[2] - gap(p)
        if law.instant and depth > ROUND_OFF * max(abs(state[2]), abs(values[0])):
            raise RequestError(
                f"start: {depth:.3g} m inside the {scene.struck[struck]}, which is rigid under law "
                f"{law.name!r}"
            )
    if limit is not None and state[2] >= limit(p):
        raise RequestError(
            f"start = {start!r} is in violation: x1 - x2 = {values[0] - values[2]:g} m, where kind "
            f"{system.kind!r} ({system.scene.meaning}) needs less than "
            f"{limit(p) - rest:g} m"
        )
    return state


def unit_norms(cell: Any, size: int) -> np.ndarray:
    """Return the energy norms sqrt(2 E) of the `size` unit states (x1, v1, r, s)."""
    with_damper = cell.k1, cell.m1 + cell.m2, cell.k2, cell.m2
    return np.sqrt(with_damper if size == 4 else (cell.k1, cell.m1))


@dataclass(frozen=True)
class Wanted:
    """The records of orbits of one scene, and the method."""

    scene: Scene
    want: Collection[str]  # words of `records.WANTS`, and `COUNTED`
    method: str
    effort: str  # of a verdict
    settings: Settings


@dataclass(frozen=True)
class Outputs:
    """The records of many orbits, arrays (sweeps, cells, ...); None for what is not recorded."""

    buffers: LaneBuffers
    evidence: np.ndarray | None  # of verdicts
    status: np.ndarray
    impulses: np.ndarray | None = None  # of hosts, the largest of each damper's rigid walls [N s]

    @classmethod
    def of(cls, wanted: Wanted, shape: tuple[int, int], transient: int, periods: int) -> Outputs:
        """Allocate the buffers for `shape` = (sweeps, cells)."""
        want, scene = set(wanted.want), wanted.scene
        walls, judged = scene.counted_walls, bool(want & JUDGED)
        has_walls = bool(scene.walls)
        counted = judged or not want.isdisjoint(("impacts", "modulation", COUNTED))
        periods_noted = noted(want, transient, periods)
        touches = touches_noted(want, scene, periods)

        def rows(wanted: bool, *tail: int, dtype: Any = float, value: float = 0) -> Any:
            return np.full((*shape, *tail), value, dtype) if wanted else None

        buffers = LaneBuffers(
            section=rows(periods_noted > 0, periods_noted, len(scene.components)),
            counts=rows(counted and has_walls, walls + 1, dtype=np.int64),
            cycle=rows("impacts" in want and not judged, walls + 1, dtype=np.int64),
            energy=rows("energy" in want, 1 + max(1, len(scene.dampers))),
            peak=rows("peak" in want, 2),
            clearance=rows("clearance" in want and has_walls, 1, value=np.inf),
            violation=rows(scene.limit is not None, 3),
            ends=rows(judged, 2, STATE_SIZE),
            response=rows("response" in want, codes.RESPONSE_COLUMNS),
            touches=rows(touches > 0, touches, codes.TOUCH_COLUMNS, value=np.nan),
        )
        return cls(buffers, rows(judged, codes.LENGTH_OF_ROW), np.zeros(shape, np.int64))

    @property
    def by_wall(self) -> np.ndarray:
        """The impacts (sweeps, cells, walls) at each wall after the transient; 0 without walls."""
        counts = self.buffers.counts
        return np.zeros((*self.status.shape, 2), np.int64) if counts is None else counts[..., :-1]


def records_of(cells: np.ndarray) -> np.recarray:
    """Return cells as kernels take them, copied if read-only, as Numba would compile anew."""
    return np.require(cells, requirements=("C", "W")).view(np.recarray)


def run(
    parts: Parts, sweeps: np.ndarray, starts: np.ndarray, span: Span, buffers: LaneBuffers
) -> np.ndarray:
    """Run sweeps (sweeps, cells) from `starts` (sweeps, 4), fill the buffers, return the status."""
    status = np.zeros(sweeps.shape, np.int64)
    cells, each = records_of(sweeps), sweeps.shape[1] * (span.first + span.periods)
    arguments = parts, cells, np.ascontiguousarray(starts), span, buffers, status
    least = max(1, PIECE_PERIODS // max(1, each))
    on_threads(lanes.run_lanes, arguments, len(sweeps), least)
    return status


@stoppable
def on_threads(
    kernel: Callable[..., None],
    arguments: tuple[Any, ...],
    count: int,
    least: int,
    most: int | None = None,
) -> None:
    """Run a kernel on `count` sweeps, in pieces of `least` to `most` of them."""
    kernel(0, 0, *arguments)  # compiles in this thread, not in all threads at once
    in_pieces(lambda begin, end: kernel(begin, end, *arguments), count, least, most)


class Kernels:
    """The kernels for orbits of one scene and one method."""

    def __init__(self, wanted: Wanted, tell: Tell | None = None, *, helped: bool = True) -> None:
        """Prepare the constants; `helped` lets another process compile the verdict."""
        self._wanted = wanted
        self._needed = Needed(wanted.scene.key, wanted.method, tuple(wanted.want))
        self._compilation = Compilation(self._needed, tell, helped)
        self._parts = parts_of(wanted.method, wanted.scene, wanted.settings)
        self._stages = np.array(EFFORTS[wanted.effort], dtype=np.int64)

    @property
    def records(self) -> bool:
        return bool(self._wanted.want) or self._wanted.scene.limit is not None

    def run(self, sweeps: np.ndarray, starts: np.ndarray, transient: int, periods: int) -> Outputs:
        """Run sweeps (sweeps, cells) from `starts` (sweeps, 4), with their verdicts."""
        self.prepare()
        outputs = Outputs.of(self._wanted, (len(sweeps), sweeps.shape[1]), transient, periods)
        span = Span(transient, periods, 1)
        outputs.status[:] = run(self._parts, sweeps, starts, span, outputs.buffers)
        if outputs.evidence is not None:
            self._judge(outputs, sweeps, transient)
        return outputs

    def verdicts(self, outputs: Outputs, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return the datasets of the verdicts on `cells` (sweeps, cells) by name."""
        assert outputs.evidence is not None
        layout = layout_of(len(self._wanted.scene.components))
        arrays = evidence_arrays(outputs.status, outputs.evidence, cells["omega"], layout)
        arrays["orbit_point"] = user_states(cells, arrays["orbit_point"], self._wanted.scene)
        return arrays

    def responses(self, outputs: Outputs, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return the datasets of the response by name; none if it is not recorded."""
        filled = outputs.buffers.response
        return {} if filled is None else responses.arrays_of(filled, self._wanted.scene, cells)

    def states(
        self, sweeps: np.ndarray, starts: np.ndarray, span: Span
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return states (sweeps, cells, periods stops, components) and status, without a verdict.

        `span` has `stops` equidistant states per period.  The section must be the only record.
        """
        self.prepare()
        points = span.periods * span.stops
        outputs = Outputs.of(self._wanted, (len(sweeps), sweeps.shape[1]), 0, points)
        status = run(self._parts, sweeps, starts, span, outputs.buffers)
        return outputs.buffers.section, status

    def sections(self, sweeps: np.ndarray, starts: np.ndarray, periods: int) -> np.ndarray:
        """Return the section (sweeps, cells, periods, components) without a verdict."""
        return self.states(sweeps, starts, Span(0, periods, 1))[0]

    def prepare(self) -> None:
        if self._needed not in _loaded:
            self._prepare()
            _loaded.add(self._needed)

    @stoppable
    def _prepare(self) -> None:
        with self._compilation.followed(LANES):
            for kernel in kernels_of(self._wanted.want):
                if kernel == "verdict":
                    self._compilation.await_verdict()
                self.compile(kernel)

    def _judge(self, outputs: Outputs, sweeps: np.ndarray, transient: int) -> None:
        ends, section = outputs.buffers.ends, outputs.buffers.section
        finished = Finished(ends, section, max(transient - NOTED, 0))
        cells, stages = records_of(sweeps), self._stages
        arguments = self._parts, cells, finished, stages, outputs.evidence, outputs.status
        # four at most: an orbit without a period is followed longer than a hundred others
        on_threads(lanes.judge_lanes, arguments, cells.size, 1, 4)

    def compile(self, kernel: str) -> None:
        """Compile one of `compilation.kernels_of`, unless the cache has it, by running no orbit."""
        sweeps = np.zeros((0, 1), cell_type(self._wanted.scene))
        outputs = Outputs.of(self._wanted, sweeps.shape, 1, 1)
        if kernel == "orbit":
            if outputs.evidence is not None:
                size = len(self._wanted.scene.components)
                multipliers_of(np.empty((0, codes.LENGTH_OF_ROW)), size)
            run(self._parts, sweeps, np.zeros((0, 4)), Span(1, 1, 1), outputs.buffers)
        else:
            self._judge(outputs, sweeps, 1)


def compile_verdict(scene: str, method: str, want: str) -> None:
    """Compile the verdict of orbits, which stays on the disk, and end the process."""

    def end_with_input() -> None:  # as when the parent is killed
        os.read(0, 1)  # unbuffered: the interpreter needs the lock of a buffer when it ends
        os._exit(1)

    threading.Thread(target=end_with_input, daemon=True).start()
    wanted = Wanted(scene_of(scene), want.split(","), method, "quick", Settings.of(method))
    Kernels(wanted, helped=False).compile("verdict")
    os._exit(0)  # without destructors, which take a second while the parent waits


# ---- from rows of evidence to datasets ----


class Layout(NamedTuple):
    """The layout of a row of evidence behind its first columns."""

    size: int  # of a state
    width: int  # numbers of a point and of a column of the monodromy matrix
    impacts: slice  # those of an nT orbit by wall
    dampers: tuple[int, ...] = ()  # of each wall, if there are several dampers


def layout_of(size: int) -> Layout:
    return Layout(size, 4, slice(codes.NEAR_IMPACTS, codes.FAR_IMPACTS + 1))


def multipliers_of(rows: np.ndarray, size: int, width: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Return the Floquet multipliers and the logarithms of their moduli, the largest first.

    Shapes (..., size, 2), real and imaginary parts, and (..., size), from rows of evidence; NaN for
    orbits without a period.
    """
    first = codes.EXPONENTS + width
    matrices = rows[..., first : first + width * width].reshape(-1, width, width)
    matrices = np.ascontiguousarray(matrices[:, :size, :size].transpose(0, 2, 1))
    triples = np.full((len(matrices), size, 3), np.nan)
    fill_multipliers(matrices, triples)
    triples = triples.reshape(*rows.shape[:-1], size, 3)
    return triples[..., :LOG], triples[..., LOG]


def evidence_arrays(
    status: np.ndarray, rows: np.ndarray, omega: np.ndarray, layout: Layout
) -> dict[str, np.ndarray]:
    """Return the datasets of verdicts by name, `orbit_point` in the kernels' coordinates.

    Arguments: `status` (...); `rows` of evidence (..., length); `omega` (...) [rad/s].
    """
    rows, (size, width) = _without_failed(status, rows), layout[:2]
    multipliers, logarithms = multipliers_of(rows, size, width)
    arrays: dict[str, Any] = {one.name: one.from_buffer(rows) for one in stored_in("evidence")}
    arrays["settling"] = np.nan_to_num(arrays["settling"], nan=-1.0).astype(np.int32)
    arrays["multipliers"] = multipliers
    # exponents [1/s] of an nT orbit are ln |mu| / nT; those of other orbits, and of orbits too long
    # for a monodromy matrix, are in the evidence
    measured = rows[..., codes.EXPONENTS : codes.EXPONENTS + size]
    with np.errstate(all="ignore"):  # failed orbits may have no period
        nT = rows[..., codes.CYCLE_PERIOD] * (2 * np.pi / omega)
        of_cycle = logarithms / nT[..., np.newaxis]
    is_resolved = (logarithms > RESOLVED) & (width > 4)  # one by one among those of a host
    arrays["exponents"] = np.where(np.isnan(measured) | is_resolved, of_cycle, measured)
    point = codes.EXPONENTS + width + width * width
    arrays["orbit_point"] = rows[..., point : point + width]
    return arrays | _regimes_of(status, rows, layout)


def _without_failed(status: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return rows of evidence with NaN for orbits that failed."""
    rows = np.where((status == codes.OK)[..., np.newaxis], rows, np.nan)
    columns = [codes.KIND, codes.CYCLE_PERIOD]
    rows[..., columns] = np.nan_to_num(rows[..., columns])
    return rows


def _regimes_of(status: np.ndarray, rows: np.ndarray, layout: Layout) -> dict[str, np.ndarray]:
    period = rows[..., codes.CYCLE_PERIOD].astype(np.int64)
    impacts, by_wall = impacts_per_cycle(period, rows[..., layout.impacts])
    names = dict.fromkeys(layout.dampers)
    by_damper = [by_wall[..., np.equal(layout.dampers, name)].sum(axis=-1) for name in names]
    regime = flags_of(status, rows[..., codes.KIND].astype(np.int64))
    return {
        "periodicity": period,
        "impact_count": impacts,
        "impacts_by_wall": by_wall,
        "regime": regime,
        "label": labels_of(regime, period, impacts, *by_damper),
    }


def impacts_per_cycle(period: np.ndarray, by_wall: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the impacts (...) per nT and those by wall, -1 where `period` n is 0."""
    is_periodic = period > 0
    impacts = np.where(is_periodic, by_wall.sum(axis=-1), -1)
    by_wall = np.where(is_periodic[..., np.newaxis], by_wall, -1)
    return impacts.astype(np.int64), by_wall.astype(np.int64)


# ---- spectra ----


def spectra_of(
    records: SpectralRecords, states: np.ndarray, sound: np.ndarray, transient: int
) -> dict[str, np.ndarray]:
    """Return the datasets by name, (sweeps, cells, ...) each.

    Arguments: `states` (sweeps, cells, periods samples, components), the last of each period at
    its end; `sound` (sweeps, cells), False for orbits that failed, which have NaN,
    `line_period` 0 and `spectral_label` ""; the `transient` before.
    """
    shape, arrays = sound.shape, dict[str, np.ndarray]()
    of_each = (*shape, len(records.signals))
    if "spectrum" in records.want:
        arrays["spectrum"] = np.full((*of_each, records.bins), np.nan)
    if "lines" in records.want:
        arrays["line_period"] = np.zeros(shape, np.int32)
        for name in ("line_amplitude", "line_phase"):
            arrays[name] = np.full((*of_each, LINES), np.nan)
    if "broadband" in records.want:
        arrays["broadband"] = np.full(of_each, np.nan)
        arrays["spectral_label"] = np.full(shape, "", "<U16")
    for lane in zip(*np.nonzero(sound), strict=True):
        of_orbit = states[lane]
        section = np.ascontiguousarray(of_orbit[records.samples - 1 :: records.samples])
        n = int(period_of(section, RECURS))
        if "lines" in records.want:
            arrays["line_period"][lane] = n
        for i, signal in enumerate(records.signals.values()):
            here = (*lane, i)
            values = np.ascontiguousarray(signal.of(of_orbit))
            if "spectrum" in records.want:
                whole = spectrum_of(values, records.samples, 1.0, window=records.window)
                arrays["spectrum"][here] = whole.amplitude[: records.bins]
            if "broadband" in records.want:
                tapered = spectrum_of(values, records.samples, 1.0, window="hann")
                arrays["broadband"][here] = tapered.background_share(records.bins)
            if "lines" in records.want and n:
                amplitude, phase = records.lines_of(values, n, transient)
                arrays["line_amplitude"][here], arrays["line_phase"][here] = amplitude, phase
        if "broadband" in records.want:
            share = arrays["broadband"][lane].max()
            arrays["spectral_label"][lane] = spectral_label(n, share, len(section))
    return arrays


def agreement(
    regime: np.ndarray, period: np.ndarray, spectral_labels: np.ndarray, periods: int
) -> np.ndarray:
    """Return whether verdicts and spectra agree: codes of `labels.KEPT`, -1 if undecided.

    An nT orbit agrees with nT, a quasiperiodic one with lines, chaos with a broadband spectrum.
    It is undecided if n exceeds a third of `periods`: `period_of` finds no such recurrence.
    """
    words = {FLAGS["quasiperiodic"]: "lines", FLAGS["chaotic"]: "broadband"}
    agreed = np.full(regime.shape, -1, np.int8)
    for place in np.ndindex(regime.shape):
        n, says = int(period[place]), str(spectral_labels[place])
        expected = spectral_label(n, 0.0, periods) if n else words.get(int(regime[place]), "")
        if REPEATS * n > periods:
            continue
        if expected and says not in ("", UNCLEAR):
            agreed[place] = KEPT["yes" if says == expected else "no"]
    return agreed


METHOD = "exact"  # the method of tunings: rk4 is a cross-check, and too slow for them


class Outcome(NamedTuple):
    """The results of a batch, arrays of one shape."""

    objective: np.ndarray
    E2max: np.ndarray  # after the transient [J]; meaningless where `inadmissible`
    status: np.ndarray  # codes of `STATUS`
    violations: np.ndarray  # passages beyond the limit of the scene, from the start on
    impacts: np.ndarray | None = None  # per sampled period, or in all under a load

    @property
    def inadmissible(self) -> np.ndarray:
        """Whether an orbit failed, or broke the limit of its scene."""
        return (self.status != codes.OK) | ~np.isfinite(self.objective) | (self.violations > 0)


def at_section(
    scene: Scene,
    how: tuple[str, Settings],
    cells: np.ndarray,
    starts: np.ndarray,
    phases: np.ndarray,
    tell: Tell | None = None,
) -> np.ndarray:
    """Integrate orbits from a phase of the force; return the states (n, 4) at the next section.

    Arguments: the method and its settings; the `cells` (n,), the `starts` (n, 4), x1, v1, r, s, and
    their `phases` (n,) [rad], 0 to 2 pi.  Starts at 0, at 2 pi, or of parameters that cannot be
    computed are returned as they are; an orbit that fails has a state of NaN, that is, diverged.
    """
    states, status = np.array(starts, float), np.zeros(len(cells), np.int64)
    begun = np.array(phases, float) / TURN
    shares = np.where((begun > 0.0) & (begun < 1.0), 1.0 - begun, 0.0)
    parts, begun = parts_of(how[0], scene, how[1]), np.stack((begun, shares), axis=1)
    arguments = parts, records_of(cells), begun, states, status
    compilation = Compilation(Needed(scene.key, how[0], ()), tell, helped=False)
    with compilation.followed({part_period.enter: "entry"}):
        on_threads(part_period.enter, arguments, 0, 16)  # compiles
    on_threads(part_period.enter, arguments, len(cells), 16)
    states[~np.isin(status, (codes.OK, codes.BAD_PARAMETERS, codes.TOO_STIFF))] = np.nan
    return states
