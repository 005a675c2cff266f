"""What a peer is, and what all of them share: the times to note, and what follows from them."""

from __future__ import annotations

import importlib.util
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from nlds_vines.system import System

SAMPLES = 512  # states of a period among which peaks of E1 are looked for
NEARLY = 0.05  # of the largest, which peaks are looked at more closely
SAMPLES_OF_PEAK = 64  # states between the neighbours of such a peak
BUDGET = 10**6  # steps of a forcing period after which a peer gives up

_MODULES = {"scikit-sundae": "sksundae"}  # where a package is imported by another name
_PROGRAMS = {"octave": "octave-cli"}  # what is no Python package but a program


class PeerFailure(RuntimeError):
    """A peer broke down; the message is one sentence that says how."""


@dataclass(frozen=True)
class Course:
    """What a peer found of one orbit.

    Attributes:
        section: x1, v1, x2, v2 [m, m/s] at t = T, 2T, ..., shape (periods, 4); (periods, 2), x1
            and v1, without a damper.
        touches: times of touch [s] in order; None where this way of using the solver cannot tell,
            and where nobody asked. A contact in which the orbit begins is no touch.
        E1max: largest E1 [J] over the last half of the periods; None unless watched.
        steps_in_contact: mean number of steps of a contact, where it can be told cheaply.
        seconds: CPU time [s] of the time loop where it ran in another process, else None.
    """

    section: np.ndarray
    touches: np.ndarray | None
    E1max: float | None
    steps_in_contact: float | None = None
    seconds: float | None = None


Flow = Callable[[float, int, bool], Course]
"""(setting, periods, watched) -> course; watched asks for touches and E1max beside the section.

Raises `PeerFailure` where the solver breaks down."""


@dataclass(frozen=True)
class Peer:
    """One way of solving eq. (5) that a user might choose instead.

    Attributes:
        name: as it stands in tables.
        settings: from coarse to fine; setting: what they are, `rtol` or `steps` of a period.
        events: whether contacts are split off at touch and release.
        compiled: whether the steps run without Python.
        needs: the package that it needs, empty if none but ours.
        prepare: (system, start (x1, v1, x2, v2) at t = 0) -> flow; compiles here or in the first
            call.
        order: of the method by the textbook, None where it varies.
    """

    name: str
    settings: tuple[float, ...]
    setting: str
    events: bool
    compiled: bool
    needs: str
    prepare: Callable[[System, np.ndarray], Flow]
    order: float | None = None

    def available(self) -> bool:
        """Tell whether what it needs is installed, without importing it."""
        if self.needs in _PROGRAMS:
            return shutil.which(_PROGRAMS[self.needs]) is not None
        module = _MODULES.get(self.needs, self.needs.replace("-", "_"))
        return not module or importlib.util.find_spec(module) is not None


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

    Raises `PeerFailure` where it is not finite.
    """
    state = np.zeros(4)
    given = np.asarray(start, dtype=float)
    width = 4 if system.scene.damper else 2
    state[:width] = given[:width]
    if not np.isfinite(state).all():
        raise PeerFailure(f"the start {given.tolist()} is not finite")
    return state


def flow_of(system: System, start: np.ndarray, follow: Follow) -> Flow:
    """Return the flow of a solver that notes states at given times.

    Watched, the orbit is followed once as it is otherwise, for section and touches, and twice more
    for E1, because many solvers fit their steps to the times at which something is noted.
    """
    width = 4 if system.scene.damper else 2

    def flow(setting: float, periods: int, watched: bool) -> Course:
        times = system.period * np.arange(1, periods + 1)
        track = follow(setting, times, watched)
        section = _finite(track.states)[:, :width]
        if not watched:
            return Course(section, None, None, seconds=track.seconds)
        touches = touches_of(system, track.touches)
        energy = _largest_energy(system, start, periods, partial(follow, setting))
        return Course(section, touches, energy, track.steps_in_contact, track.seconds)

    return flow


def touches_of(system: System, found: Sequence[float] | np.ndarray | None) -> np.ndarray | None:
    """Return times of touch as an array; there are none where there is no wall."""
    if not system.scene.walls:
        return np.zeros(0)
    return None if found is None else np.asarray(found, dtype=float)


def _largest_energy(
    system: System, start: np.ndarray, periods: int, follow: Callable[..., Track]
) -> float:
    """Return the largest E1 [J] over the last half of the periods.

    Around each sample that is larger than its neighbours and within `NEARLY` of the largest, where
    contact makes E1 sharp, there are `SAMPLES_OF_PEAK` more and the parabola through three.
    """
    early, spacing = periods // 2, system.period / SAMPLES
    times = spacing * np.arange(SAMPLES * early, SAMPLES * periods + 1)
    before = system.period * np.arange(1, early)
    if early:
        states = follow(np.concatenate([before, times]), False).states[len(before) :]
    else:
        states = np.vstack([start, follow(times[1:], False).states])
    energies = energy_of(system, states)
    tops = _near_the_top(energies)
    if not tops.size:
        return float(energies.max())
    ahead = 2.0 * spacing * np.arange(SAMPLES_OF_PEAK + 1) / SAMPLES_OF_PEAK
    finer, places = np.unique(times[tops - 1][:, None] + ahead, return_inverse=True)
    if finer[0] == 0.0:
        noted = np.vstack([start, follow(finer[1:], False).states])
    else:
        noted = follow(finer, False).states
    rows = energy_of(system, noted)[places].reshape(len(tops), -1)
    return max(float(energies[0]), float(energies[-1]), *map(peak, rows))


def energy_of(system: System, states: np.ndarray) -> np.ndarray:
    """Return E1 = (m1 v1^2 + k1 x1^2) / 2 [J], eq. (6), of states of shape (times, 4).

    Raises `PeerFailure` where one is not finite.
    """
    m1, k1 = system.parameters["m1"], system.parameters["k1"]
    x1, v1 = _finite(states)[:, :2].T
    return 0.5 * (m1 * v1**2 + k1 * x1**2)


def _near_the_top(values: np.ndarray) -> np.ndarray:
    """Return the places of the inner maxima that are within `NEARLY` of the largest value."""
    inner = values[1:-1]
    top = (inner >= values[:-2]) & (inner >= values[2:]) & (inner >= (1 - NEARLY) * values.max())
    return 1 + np.flatnonzero(top)


def peak(values: np.ndarray) -> float:
    """Return the largest of equidistant values, refined by the parabola through its neighbours."""
    i = int(np.argmax(values))
    if i in (0, len(values) - 1):
        return float(values[i])
    left, top, right = values[i - 1 : i + 2]
    bend = 2.0 * top - left - right
    return float(top + (right - left) ** 2 / (8.0 * bend)) if bend > 0.0 else float(top)


def _finite(states: np.ndarray) -> np.ndarray:
    """Return states; raises `PeerFailure` where one is not finite."""
    if not np.isfinite(states).all():
        raise PeerFailure("the state is no longer finite")
    return states
