"""Where the orbits of a scan begin: states at phase zero, systems and starts of a cell, sweeps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nlds_vines.model.parameters import INITIAL, PHASE, component_of
from nlds_vines.orbits.starts import (
    given_states,
    put_on_walls,
    random_states,
    start_states,
    user_states,
)
from nlds_vines.runs.progress import Tell

if TYPE_CHECKING:
    from nlds_vines.bifurcation.request import Scan
    from nlds_vines.model.system import System


def begun(
    scan: Scan, cells: np.ndarray, initial: Mapping[str, np.ndarray], tell: Tell | None = None
) -> np.ndarray:
    """Return the states (n, 4), x1, v1, r, s, from which the orbits of cells count.

    Arguments: the `cells` (n,); the `initial` conditions that are not those of the scan's start,
    (n,) each, as `Scan.initial` has them; `tell` as `batch.Kernels` takes it.

    An orbit that begins at another phase is followed to the next section.
    """
    phases = initial.get(PHASE, np.full(len(cells), scan.start.phase))
    components = {name: values for name, values in initial.items() if name != PHASE}
    states = given_states(cells, scan.start, components, scan.system.scene)
    if PHASE not in initial and not scan.start.phase:
        return states
    from nlds_vines.orbits.batch import Entries  # with kernels, which take long to load

    entries = Entries(scan.system.scene, scan.method, scan.settings, tell)
    return entries.at_section(cells, states, phases)


STEP = {"up": 1, "down": -1}
"""The step of a sweep along the last axis, whose values ascend."""

Place = tuple[int, ...]
"""The index of a cell along each axis."""


class CellStart(NamedTuple):
    """A start (x1, v1, x2, v2) [m, m/s], None for rest, and what it is, in words."""

    state: tuple[float, ...] | None
    words: str


def values_at(scan: Scan, place: Place) -> dict[str, float]:
    """Return the varied parameters and initial conditions of a cell by name [SI units]."""
    pairs = zip(scan.axes, place, strict=True)
    return {axis.name: float(axis.values[i]) for axis, i in pairs}


def system_at(scan: Scan, place: Place, settings: Mapping[str, float] | None = None) -> System:
    """Return the system of a cell; `settings` are parameters that have other values than there.

    Raises `RequestError` where the system refuses these.
    """
    values = values_at(scan, place)
    varied = {axis.name: values[axis.name] for axis in scan.parameters}
    return scan.system.with_(**{**varied, **(settings or {})})


def own_states(
    scan: Scan,
    cells: np.ndarray,
    where: Sequence[np.ndarray],
    lanes: np.ndarray,
    draws: np.ndarray | None = None,
    tell: Tell | None = None,
) -> np.ndarray:
    """Return the states in which orbits begin that follow no other one; rest for sweeps.

    Arguments: the `cells` (n,) and `where` they are along each axis, (n,) each; `lanes` (n,), which
    start of its cell each orbit is; `draws` of `start_states`, by default drawn here; `tell` as
    `batch.Kernels` takes it.

    Returns x1, v1, r = x1 - (x2 - rest), s = v1 - v2, shape (n, 4) [m, m/s].
    """
    if scan.start.policy != "random":
        return begun(scan, cells, scan.initial(where), tell)
    chosen = (start_states(scan.start) if draws is None else draws)[lanes]
    return random_states(cells, chosen[:, np.newaxis], scan.system.scene)[:, 0]


def own_state(scan: Scan, cell: np.ndarray, place: Place, lane: int) -> np.ndarray:
    """Return `own_states` of one orbit, shape (4,); `cell` has the shape (1,)."""
    return own_states(scan, cell, [np.array([i]) for i in place], np.array([lane]))[0]


def swept_before(scan: Scan, place: Place, lane: int) -> list[Place]:
    """Return the cells that a sweep passes before one, in its order; none where there is no sweep.

    The orbit of each begins where that of the one before ended, and the first at rest.
    """
    if not scan.start.sweeps:
        return []
    step = STEP[scan.start.sweeps[lane]]
    first = 0 if step > 0 else scan.shape[-1] - 1
    return [(*place[:-1], i) for i in range(first, place[-1], step)]


def recorded_start(
    scan: Scan,
    arrays: Mapping[str, np.ndarray],
    place: Place,
    lane: int,
    system: System,
    moved: Mapping[str, float] | None = None,
) -> CellStart:
    """Return where an orbit of a cell begins, of a sweep as far as its results tell.

    Arguments: the scan and its results, datasets by name; the `place` of the cell; the `lane`,
    which start of the cell; a `system` like that of the cell; `moved`, the initial conditions by
    name that are other ones than there, where they are the cell's own.

    The start in a sweep is the last state of the cell before, known where sections are recorded;
    without them, a point of the cell's own periodic orbit.
    """
    if scan.start.sweeps:
        return _swept(scan, arrays, place, lane)
    cell = np.atleast_1d(system.cells())
    if scan.start.policy == "random":
        words = f"{scan.start.names[lane]} (seed {scan.start.seed})"
        state = own_state(scan, cell, place, lane)[np.newaxis]
    else:
        values = {name: v for name, v in values_at(scan, place).items() if name in INITIAL}
        values |= moved or {}
        if not values and not scan.start.state and not scan.start.phase:
            return CellStart(None, "rest")
        shown = dict(values)
        if scan.start.phase and PHASE not in values:
            shown[PHASE] = scan.start.phase
        words = ", ".join(f"{name} = {value:g}" for name, value in shown.items())
        words = "the start of the sliders" if moved else words
        initial = {component_of(name): np.array([value]) for name, value in values.items()}
        state = begun(scan, cell, initial)
    state = put_on_walls(cell, state, system.scene)
    return _named(user_states(cell, state, system.scene)[0], words or "the given state")


def _swept(scan: Scan, arrays: Mapping[str, np.ndarray], place: Place, lane: int) -> CellStart:
    """Return the start of an orbit in a sweep."""
    sweep, before = scan.start.sweeps[lane], swept_before(scan, place, lane)
    if not before:
        return CellStart(None, f"rest, the beginning of the sweep {sweep}")
    if "section" in arrays:
        state = arrays["section"][(*before[-1], lane, -1)]
        if np.isfinite(state).all():
            return _named(state, f"the sweep {sweep}: the cell before")
    if "orbit_point" in arrays:
        state = arrays["orbit_point"][(*place, lane)]
        if np.isfinite(state).all():
            return _named(state, f"the sweep {sweep}: a point of its orbit")
    return CellStart(None, f"rest: the archive does not hold the states of the sweep {sweep}")


def _named(state: np.ndarray, words: str) -> CellStart:
    return CellStart(tuple(state.tolist()), words)
