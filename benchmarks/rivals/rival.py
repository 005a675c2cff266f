"""What a rival is, and what all of them share: the times to note, and what follows from them."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum
from functools import partial, wraps
from typing import Any

import numpy as np

from nlds_vines.accuracy import measured_cases as accuracy
from nlds_vines.accuracy.measure import Contender
from nlds_vines.accuracy.measured_cases import Case, Setting, SolverFailure
from nlds_vines.archives.provenance import version
from nlds_vines.model.system import System

SAMPLES = 512  # states of a period among which peaks of E1 are looked for
NEARLY = 0.05  # of the largest, which peaks are looked at more closely
LOOKS = 4096  # states of a period among which touches are looked for where a solver has no events
CLOSER, SAMPLES_OF_PEAK = 2, 64  # how often, and by how many states between its neighbours
BUDGET = 10**6  # compiled steps of a forcing period after which a rival gives up
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)  # settings, where nothing speaks against one
BUDGET_IN_PYTHON = 20_000  # the same where each step goes through Python
EVENTS = 1000  # touches and releases of a forcing period after which it gives up, too


class Asked(IntEnum):
    """What is asked for beside the section: nothing, touches and E1max, or touches alone.

    E1max costs several times the rest.
    """

    NOTHING = False
    ALL = True
    TOUCHES = 2


@dataclass(frozen=True)
class Course(accuracy.Course):
    """What a rival found of one orbit, and more than `accuracy` asks for.

    Attributes:
        E1max: largest E1 [J] over the last half of the periods; None unless watched.
        steps_in_contact: mean number of steps of a contact, where it is known at no cost: by SciPy,
            heyoka and diffrax with events, watched, once a contact has ended; else None.
    """

    E1max: float | None = None
    steps_in_contact: float | None = None


Flow = Callable[[float, int, bool | Asked], Course]
"""(setting, periods, watched) -> course; watched asks for touches and E1max, or see `Asked`.

Raises `SolverFailure` where the solver breaks down."""


@dataclass(frozen=True)
class Rival:
    """One way of solving eq. (5) that a user might choose instead.

    Attributes:
        name: as it stands in tables.
        settings: from coarse to fine; setting: what they are, `rtol` or `steps` of a period.
        events: whether contacts are split off at touch and release.
        compiled: whether the steps run without Python.
        needs: the package that it needs, empty if none but those of this program.
        prepare: (system, start (x1, v1, x2, v2) at t = 0) -> flow; compiles here or in the first
            call.
        order: of the method by the textbook, None where it varies.
        module: by which its package is imported, if not by its own name.
    """

    name: str
    settings: tuple[float, ...]
    setting: str
    events: bool
    compiled: bool
    needs: str
    prepare: Callable[[System, np.ndarray], Flow]
    order: float | None = None
    module: str = ""

    def __post_init__(self) -> None:
        """Let `prepare` and its flows raise nothing but `SolverFailure`."""
        object.__setattr__(self, "prepare", partial(_prepared, self.prepare))

    def available(self) -> bool:
        """Tell whether what it needs is installed, without importing it."""
        return not self.needs or importlib.util.find_spec(self.module or self.needs) is not None

    def version(self) -> str:
        """Return the version of what it needs; empty where it needs nothing."""
        return version(self.needs) if self.needs else ""


def contenders_of(rival: Rival) -> Iterator[Contender]:
    """Yield a rival at all its settings, prepared once for each orbit."""
    prepared: dict[tuple[int, tuple[float, ...]], tuple[System, Flow]] = {}
    order = math.nan if rival.order is None else rival.order

    def following(value: float) -> Callable[[Case, bool], Course]:
        def follow(case: Case, observed: bool) -> Course:
            key = id(case.system), tuple(case.state)
            if key not in prepared:  # the system stays, and so its identity is no other's
                prepared[key] = case.system, rival.prepare(case.system, case.state)
            return prepared[key][1](value, case.periods, Asked.TOUCHES if observed else False)

        return follow

    for value in rival.settings:
        words = f"{value:g} steps" if rival.setting == "steps" else f"rtol {value:.0e}"
        yield Contender(Setting(rival.name, value, words, False, order), following(value))


def _prepared(prepare: Callable[[System, np.ndarray], Flow], *orbit: Any) -> Flow:
    """Return the flow of an orbit; neither it nor its preparation raises but `SolverFailure`."""
    with _failing_in_words():
        flow = prepare(*orbit)

    @wraps(flow)
    def guarded(setting: float, periods: int, watched: bool | Asked) -> Course:
        with _failing_in_words():
            return flow(setting, periods, watched)

    return guarded


@contextmanager
def _failing_in_words() -> Iterator[None]:
    """Turn any exception into a `SolverFailure` of one sentence: its type and its first line."""
    try:
        yield
    except SolverFailure:
        raise
    except Exception as error:  # other people's code: there is no list of what it may raise
        words = str(error).strip().splitlines()
        kind = type(error).__name__
        raise SolverFailure(f"{kind}: {words[0]}" if words else kind) from error


@dataclass(frozen=True)
class Track:
    """States that were noted along an orbit, shape (times, 4), and what else was seen."""

    states: np.ndarray
    touches: Sequence[float] | np.ndarray | None = None
    steps_in_contact: float | None = None
    seconds: float | None = None


Follow = Callable[[float, np.ndarray, bool], Track]
"""(setting, times [s] in order, watched) -> the track of an orbit from t = 0 to the last of them.

Touches need not be noted unless watched."""


def begun(system: System, start: np.ndarray) -> np.ndarray:
    """Return a start as four finite numbers x1, v1, x2, v2; without a damper x2 = v2 = 0.

    Raises `SolverFailure` where it is not finite.
    """
    state = np.zeros(4)
    given = np.asarray(start, dtype=float)
    width = 4 if system.scene.damper else 2
    state[:width] = given[:width]
    if not np.isfinite(state).all():
        raise SolverFailure(f"the start {given.tolist()} is not finite")
    return state


def flow_of(system: System, start: np.ndarray, follow: Follow) -> Flow:
    """Return the flow of a solver that notes states at given times.

    Watched, the orbit is followed once as it is otherwise, for section and touches, and again for
    E1, because many solvers fit their steps to the times at which something is noted.
    """
    width = 4 if system.scene.damper else 2

    def flow(setting: float, periods: int, watched: bool | Asked) -> Course:
        times = system.period * np.arange(1, periods + 1)
        track = follow(setting, times, bool(watched))
        section = _finite(track.states)[:, :width]
        if not watched:
            return Course(section, None, track.seconds)
        touches = touches_of(system, track.touches)
        if touches is None:
            touches = _seen(system, start, track, partial(follow, setting))
        energy = None
        if watched != Asked.TOUCHES:
            energy = _largest_energy(system, start, periods, partial(follow, setting))
        return Course(section, touches, track.seconds, energy, track.steps_in_contact)

    return flow


def most_events(system: System, times: np.ndarray) -> int:
    """Return after how many events a rival gives up on its way to the last of the times."""
    return EVENTS * math.ceil(times[-1] / system.period)


def touches_of(system: System, found: Sequence[float] | np.ndarray | None) -> np.ndarray | None:
    """Return times of touch as an array; there are none where there is no wall."""
    if not system.scene.walls:
        return np.zeros(0)
    return None if found is None else np.asarray(found, dtype=float)


def _seen(
    system: System, start: np.ndarray, track: Track, follow: Callable[..., Track]
) -> np.ndarray | None:
    """Return the times of touch [s] that show among `LOOKS` states of a period.

    Between two of these the approach is the cubic that has their depths and speeds.  None where a
    solver fits its steps to the times: more times then mean another orbit than `track`.
    """
    spacing = system.period / LOOKS
    times = spacing * np.arange(LOOKS * len(track.states) + 1)
    states = np.vstack([start, _finite(follow(times[1:], False).states)])
    if not np.array_equal(states[LOOKS::LOOKS], track.states):
        return None
    cell, found = system.cells(), []
    shortening = states[:, 0] - states[:, 2] + float(cell["rest"])
    closing = (states[:, 1] - states[:, 3]) * spacing
    for wall, sign in (("near", 1.0), ("far", -1.0)):
        if wall in system.scene.walls:
            depth, rise = sign * shortening - float(cell[wall]), sign * closing
            at = np.flatnonzero((depth[:-1] < 0.0) & (depth[1:] >= 0.0))
            place = _zero(depth[at], depth[at + 1], rise[at], rise[at + 1])
            found.append(times[at] + spacing * place)
    return np.sort(np.concatenate(found))


def _zero(before: np.ndarray, after: np.ndarray, rise: np.ndarray, later: np.ndarray) -> np.ndarray:
    """Return where in [0, 1] cubics with these ends and slopes are zero, by Newton's method."""
    change = after - before
    x = before / -change
    for _ in range(5):
        turn = 3.0 * change - 2.0 * rise - later
        twist = rise + later - 2.0 * change
        value = before + x * (rise + x * (turn + x * twist))
        slope = rise + x * (2.0 * turn + 3.0 * x * twist)
        x = np.clip(x - value / np.where(slope > 0.0, slope, np.inf), 0.0, 1.0)
    return x


def _largest_energy(
    system: System, start: np.ndarray, periods: int, follow: Callable[..., Track]
) -> float:
    """Return the largest E1 [J] over the last half of the periods.

    A contact makes E1 sharp: each sample that is larger than its neighbours, and within `NEARLY`
    of the largest, is looked at twice more closely, and last by the parabola through three.
    """
    spacing = system.period / SAMPLES
    first, last = periods // 2 * SAMPLES, periods * SAMPLES
    times = spacing * np.arange(first, last + 1)

    def energies(at: np.ndarray) -> np.ndarray:
        moments, places = np.unique(np.clip(at, times[0], times[-1]), return_inverse=True)
        later = moments[moments > 0.0]  # the state at t = 0 is the start
        states = np.vstack([start] * (len(moments) - len(later)) + [follow(later, False).states])
        return _energy_of(system, states)[places].reshape(at.shape)

    rows = energies(times)[None, :]
    ends = max(rows[0, 0], rows[0, -1])
    tops = times[_near_the_top(rows[0])]
    for _ in range(CLOSER if tops.size else 0):
        windows = tops[:, None] + spacing * np.linspace(-1.0, 1.0, SAMPLES_OF_PEAK + 1)
        rows = energies(windows)
        tops = windows[np.arange(len(tops)), rows.argmax(axis=1)]
        spacing *= 2.0 / SAMPLES_OF_PEAK
    return float(max(ends, *map(_peak, rows)))


def _energy_of(system: System, states: np.ndarray) -> np.ndarray:
    """Return E1 = (m1 v1^2 + k1 x1^2) / 2 [J], eq. (6), of states of shape (times, 4).

    Raises `SolverFailure` where one is not finite.
    """
    m1, k1 = system.parameters["m1"], system.parameters["k1"]
    x1, v1 = _finite(states)[:, :2].T
    return 0.5 * (m1 * v1**2 + k1 * x1**2)


def _near_the_top(values: np.ndarray) -> np.ndarray:
    """Return the places of the inner maxima that are within `NEARLY` of the largest value."""
    inner = values[1:-1]
    top = (inner >= values[:-2]) & (inner >= values[2:]) & (inner >= (1 - NEARLY) * values.max())
    return 1 + np.flatnonzero(top)


def _peak(values: np.ndarray) -> float:
    """Return the largest of equidistant values, refined by the parabola through its neighbours."""
    i = int(np.argmax(values))
    if i in (0, len(values) - 1):
        return float(values[i])
    left, top, right = values[i - 1 : i + 2]
    bend = 2.0 * top - left - right
    return float(top + (right - left) ** 2 / (8.0 * bend)) if bend > 0.0 else float(top)


def _finite(states: np.ndarray) -> np.ndarray:
    """Return states; raises `SolverFailure` where one is not finite."""
    if not np.isfinite(states).all():
        raise SolverFailure("the state is no longer finite")
    return states
