"""One orbit in Python: `simulate`."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.errors import RequestError, choice, library, shown, whole
from nlds_vines.kernels.cells.cells import run_cell
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK, RESPONSE_COLUMNS
from nlds_vines.kernels.scene.scene import CellBuffers, Parts, Span
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS, Impacts
from nlds_vines.model.catalog import as_system
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System
from nlds_vines.orbits import responses
from nlds_vines.orbits.compilation import Compilation, Needed, notice
from nlds_vines.orbits.kernel_inputs import cell_of, parts_of
from nlds_vines.orbits.records import IMPACT, STATUS, Violation, refuse_impossible
from nlds_vines.orbits.solver_settings import METHODS, Settings, chosen_settings
from nlds_vines.orbits.starts import ROUND_OFF
from nlds_vines.runs.interrupts import stoppable

RECORDS = ("section", "impacts", "energy", "peak", "response", "clearance", "trajectory")
"""What `simulate` can record."""

SAMPLES = 512
"""States of a trajectory in each forcing period, by default."""

_RUN_CELL = getattr(run_cell, "entry", run_cell)
"""What is compiled where Python calls `run_cell`."""


class IntegrationError(RuntimeError):
    """An orbit could not be followed to its end; the message names the remedy.

    `code` is its `STATUS`.
    """

    code: int

    @classmethod
    def of(cls, system: System, code: int) -> IntegrationError:
        """Return the error of an orbit of a system that ended with a code."""
        error = cls(f"{system.name}: {STATUS[code].name}. {STATUS[code].remedy}")
        error.code = code
        return error


@dataclass(frozen=True, repr=False)
class Orbit(Outlined):
    """What was recorded of an orbit; None for what was not wanted.

    Attributes:
        system: what was simulated.
        section: the state at t = T, 2T, ..., shape (periods, 4) = x1, v1, x2, v2 [m, m/s]
            ((periods, 2) without a damper), counted from the end of the transient.
        state: the last state.
        impacts: one row of dtype `IMPACT` for each touch; an impact that lasts beyond the end has
            release = NaN, and the largest force and depth up to the end.  Time counts from the
            start of the transient.
        trajectory: `samples` equidistant states of each period, the last at its end, shape
            (periods samples, 4) (or 2), and their `time` [s] from the start of the transient.
        E1max, E2max: largest energies [J], eq. (6), exact in time, without the transient.
        E1peak, E2peak: the same, the transient included.
        response: largest and rms displacements, velocities and accelerations, forces and powers,
            by name (`responses.quantities_of`), without the transient.
        violation: of a scene with a limit to keep; None for other scenes.
        clearance: smallest distance [m] of an approach that did not become an impact; inf if none.
    """

    system: System
    state: np.ndarray
    section: np.ndarray | None = None
    impacts: np.ndarray | None = None
    E1max: float | None = None
    E2max: float | None = None
    E1peak: float | None = None
    E2peak: float | None = None
    clearance: float | None = None
    violation: Violation | None = None
    response: Mapping[str, Any] | None = None
    trajectory: np.ndarray | None = None
    time: np.ndarray | None = None

    def heading(self) -> str:
        """Return what was simulated."""
        return f"of {self.system.heading()}"

    def outline(self) -> Rows:
        """Return the last state and what was recorded, arrays by their shapes."""
        names = self.system.scene.components
        yield "last state [m, m/s]", numbers(dict(zip(names, self.state.tolist(), strict=True)))
        arrays = ("section", "impacts", "trajectory")
        present = {name: getattr(self, name) for name in arrays if getattr(self, name) is not None}
        if present:
            yield "recorded", ", ".join(f"{name} {array.shape}" for name, array in present.items())
        of_bodies = ("E1max", "E2max", "E1peak", "E2peak")
        if energies := {name: e for name in of_bodies if (e := getattr(self, name)) is not None}:
            yield "energies [J]", numbers(energies)
        others = {} if self.clearance is None else {"clearance [m]": self.clearance}
        if self.violation is not None:
            others |= {"violations": self.violation.number, "depth [m]": self.violation.depth}
        if others:
            yield "limits", numbers(others)

    def to_dataframe(self) -> Any:
        """Return the trajectory as a `pandas.DataFrame`; needs the extra `xarray`.

        Columns: `time` [s] from the start of the transient; the state, x1, v1, x2, v2 [m, m/s];
        `phase` of the force [rad], omega t in [0, 2 pi); `force` P cos(omega t) [N]; and for each
        wall whose force is known `contact`, or `contact_near` and `contact_far` where there are
        two [N], positive in the direction of x2, eq. (2) and (3). Units are in its `attrs`.

        Raises `RequestError` where no trajectory was recorded, or without pandas.
        """
        from nlds_vines.orbits.signals import contact_forces, harmonic_force

        if self.trajectory is None or self.time is None:
            raise RequestError("no trajectory: simulate the orbit with 'trajectory' in record")
        names, system = self.system.scene.components, self.system
        columns = dict(zip(names, self.trajectory.T, strict=True))
        turns = self.time * (system.parameters["omega"] / (2.0 * np.pi))
        phase, force = 2.0 * np.pi * (turns % 1.0), harmonic_force(system, self.time)
        contacts = contact_forces(system, self.trajectory)
        walls = ("contact_near", "contact_far") if len(contacts) == 2 else ("contact",)
        pushed = dict(zip(walls, contacts.values(), strict=False))
        frame = library("pandas").DataFrame(
            {"time": self.time, **columns, "phase": phase, "force": force, **pushed}
        )
        speeds = {name: "m/s" if name.startswith("v") else "m" for name in names}
        forces = dict.fromkeys(("force", *pushed), "N")
        frame.attrs = {"title": system.heading(), "units": {"time": "s", "phase": "rad"}}
        frame.attrs["units"] |= speeds | forces
        return frame


def simulate(
    system: System | str | os.PathLike[str],
    periods: int,
    *,
    start: Sequence[float] | np.ndarray | None = None,
    transient: int = 0,
    method: str = "exact",
    record: Collection[str] | None = None,
    tolerance: float | str | None = None,
    contact_steps: float | None = None,
    period_steps: float | None = None,
    nodes: int | None = None,
    samples: int = SAMPLES,
    quiet: bool = False,
) -> Orbit:
    """Follow one orbit over forcing periods and return what was recorded.

    Arguments:
        system: a `System`, the name of one, or the path of a TOML file.
        periods: how many to record (>= 0), after `transient` unrecorded ones.
        start: (x1, v1, x2, v2) [m, m/s] at t = 0, by default at rest; without a damper (x1, v1).
            It may lie on a wall or inside a contact, which then is not counted as an impact.
        method: `exact` (exact flight, certified touch) or `rk4` (fixed steps, refined contacts).
        record: of section, impacts, energy, peak, response, clearance, trajectory; by default
            section and, if there are walls, impacts.
        tolerance: of `exact`: relative error of each contact, 1e-13 to 1e-3, or draft (1e-6),
            standard (1e-9, the default) or fine (1e-12); flights are exact to round-off.
        contact_steps: of `exact`, for experts: Taylor steps of a contact that is stepped,
            whatever the tolerance.
        period_steps: of `rk4`: steps of a forcing period (512), four times those of a free impact.
        nodes: of `exact`, for experts: collocation nodes of every short impact, whatever the
            tolerance.
        samples: states of a trajectory in each period.
        quiet: whether not to say that something is compiled.

    Raises `RequestError` for a wrong argument, `IntegrationError` where the orbit ends early.
    Cost with the defaults: about 2 us a period for an SSul NES, once compiled.
    """
    system = as_system(system)
    whole("periods", periods, 0)
    whole("transient", transient, 0)
    whole("samples", samples, 1, 10**6)
    choice("method", method, METHODS)
    record = checked_record(system, record)
    options = {"contact_steps": contact_steps, "period_steps": period_steps, "nodes": nodes}
    settings = chosen_settings(method, {"tolerance": tolerance, **options})
    cell = cell_of(system)
    begin = Beginning(system, method, settings, cell, start_state(system, cell.rest, start))
    return begin.follow(record, transient, periods, samples, quiet=quiet)


class Beginning(NamedTuple):
    """Where an orbit begins, and how it is followed, in the numbers of the kernels.

    Fields: the `system`; `method` and its `settings`; the record of its `cell`; the `state` at
    phase zero (x1, v1, r, s, q, mode ...), shape (STATE_SIZE,).
    """

    system: System
    method: str
    settings: Settings
    cell: Any
    state: np.ndarray

    def follow(
        self,
        record: tuple[str, ...],
        transient: int,
        periods: int,
        samples: int = 1,
        *,
        quiet: bool = True,
    ) -> Orbit:
        """Follow the orbit as `simulate` does; `IntegrationError` where it ends early."""
        buffers = _Buffers.of(self.system, record, periods, samples)
        while True:
            state = self.state.copy()
            self._run(buffers, state, transient, periods, quiet)
            if buffers.enough():
                return buffers.orbit(self.system, self.cell.rest, state, transient)
            buffers = buffers.larger()  # deterministic: the second run finds as many

    def after(self, periods: int, *, quiet: bool = True) -> Beginning:
        """Return the beginning that the state after so many periods is."""
        state = self.state.copy()
        self._run(_Buffers.of(self.system, (), 0, 1), state, periods, 0, quiet)
        return self._replace(state=state)

    @stoppable
    def _run(
        self, buffers: _Buffers, state: np.ndarray, transient: int, periods: int, quiet: bool
    ) -> None:
        parts = parts_of(self.method, self.system.scene, self.settings)
        needed = Needed(self.system.scene.key, self.method, buffers.record)
        compilation = Compilation(needed, notice(quiet), helped=False)
        with compilation.followed({_RUN_CELL: "orbit"}):
            code = buffers.run(parts, self.cell, state, transient, periods)
        if code != OK:
            raise IntegrationError.of(self.system, code)


@dataclass(frozen=True)
class _Buffers:
    """What a run fills; None for what is not wanted."""

    record: tuple[str, ...]
    stops: int
    states: np.ndarray | None
    impacts: Impacts | None
    energy: np.ndarray | None
    peak: np.ndarray | None
    clearance: np.ndarray | None
    violation: np.ndarray | None
    response: np.ndarray | None
    foot: bool | None
    ground: bool | None

    @classmethod
    def of(cls, system: System, record: tuple[str, ...], periods: int, samples: int) -> _Buffers:
        """Make those that a record needs."""
        scene = system.scene
        stops = samples if "trajectory" in record else 1
        noted = "section" in record or "trajectory" in record
        return cls(
            record=record,
            stops=stops,
            states=np.empty((periods * stops, len(scene.components))) if noted else None,
            impacts=room_for_impacts(16 + 4 * periods) if "impacts" in record else None,
            energy=np.zeros(2) if "energy" in record else None,
            peak=np.zeros(2) if "peak" in record else None,
            clearance=np.full(1, np.inf) if "clearance" in record else None,
            violation=None if scene.limit is None else np.zeros(3),
            response=np.full(RESPONSE_COLUMNS, np.nan) if "response" in record else None,
            foot=responses.moving_foot(scene) if "response" in record else None,
            ground=responses.moving_ground(scene) if "response" in record else None,
        )

    def run(self, parts: Parts, cell: Any, state: np.ndarray, transient: int, periods: int) -> int:
        """Run the orbit from `state`, which becomes the last one; return a status."""
        buffers = CellBuffers(
            section=self.states,
            impacts=self.impacts,
            energy=self.energy,
            peak=self.peak,
            clearance=self.clearance,
            violation=self.violation,
            response=self.response,
            foot=self.foot,
            ground=self.ground,
        )
        return run_cell(parts, cell, state, Span(transient, periods, self.stops), buffers)

    def enough(self) -> bool:
        """Tell whether there was room for all impacts."""
        return self.impacts is None or self.impacts.filled[0] <= len(self.impacts.data)

    def larger(self) -> _Buffers:
        """Return fresh buffers with room for the impacts that were counted."""
        assert self.impacts is not None
        clearance = None if self.clearance is None else np.full(1, np.inf)
        return replace(
            self, impacts=room_for_impacts(int(self.impacts.filled[0])), clearance=clearance
        )

    def orbit(self, system: System, rest: float, state: np.ndarray, transient: int) -> Orbit:
        """Return what was recorded, in the user's coordinates."""
        stops, states, results = self.stops, self.states, dict[str, Any]()
        if states is not None and "trajectory" in self.record:
            count = transient * stops + 1 + np.arange(len(states))
            results["trajectory"], results["time"] = states, count * (system.period / stops)
        if states is not None and "section" in self.record:
            results["section"] = np.ascontiguousarray(states[stops - 1 :: stops])
        for name, energies in (("max", self.energy), ("peak", self.peak)):
            if energies is not None:
                results[f"E1{name}"] = float(energies[0])
                results[f"E2{name}"] = float(energies[1]) if system.scene.damper else None
        if self.impacts is not None:
            results["impacts"] = impacts_of(self.impacts, system.scene)
        if self.clearance is not None:
            results["clearance"] = float(self.clearance[0])
        if self.response is not None:
            results["response"] = responses.values_of(self.response, system)
        if self.violation is not None:
            time, depth, number = self.violation.tolist()
            results["violation"] = Violation(int(number), time, depth)
        return Orbit(system, _user_state(system, rest, state), **results)


def checked_record(system: System, record: Collection[str] | None) -> tuple[str, ...]:
    """Return what to record of an orbit, as `simulate` takes it; `RequestError` for anything else.

    By default section and, if there are walls, impacts.
    """
    if record is None:
        return ("section", "impacts") if system.scene.walls else ("section",)
    if isinstance(record, str):
        record = (record,)
    if not isinstance(record, Collection):
        raise RequestError(f"record = {shown(record)} must be a list of {', '.join(RECORDS)}")
    for word in record:
        choice("record", word, RECORDS)
    refuse_impossible(tuple(record), system.scene)
    return tuple(record)


def room_for_impacts(capacity: int) -> Impacts:
    """Return a table with room for so many impacts."""
    return Impacts(np.empty((capacity, IMPACT_COLUMNS)), np.zeros(1, np.int64))


def start_state(
    system: System, rest: float, start: Sequence[float] | np.ndarray | None
) -> np.ndarray:
    """Return the kernels' state (x1, v1, r, s, q, mode) of a start in the user's coordinates."""
    state = np.zeros(STATE_SIZE)
    if start is None:
        return state
    names = system.scene.components
    try:
        values = np.asarray(start, dtype=float)
    except (TypeError, ValueError):  # no numbers at all
        values = np.empty(0)
    if values.shape != (len(names),) or not np.isfinite(values).all():
        text = f"{len(names)} finite numbers {', '.join(names)}"
        raise RequestError(f"start = {shown(start)}; allowed: {text}")
    state[:2] = values[:2]
    if system.scene.damper:
        state[2], state[3] = values[0] - (values[2] - rest), values[1] - values[3]
    elif system.scene.grounded:
        state[2], state[3] = values
    _refuse_inside(system, state[2])
    limit = system.scene.limit
    if limit is not None and state[2] >= limit(system.parameters):
        raise RequestError(
            f"start = {start!r} is in violation: x1 - x2 = {values[0] - values[2]:g} m, where kind "
            f"{system.kind!r} ({system.scene.meaning}) needs less than "
            f"{limit(system.parameters) - rest:g} m"
        )
    return state


def _refuse_inside(system: System, r: float) -> None:
    """Raise `RequestError` for a start inside a rigid body, where nothing can be."""
    scene, p = system.scene, system.parameters
    for struck, gap, sign in (("near", scene.gap_near, 1.0), ("far", scene.gap_far, -1.0)):
        if gap is not None and scene.law.instant and sign * r - gap(p) > ROUND_OFF * abs(r):
            raise RequestError(
                f"start: {sign * r - gap(p):.3g} m inside the {scene.struck[struck]}, which is "
                f"rigid under law {scene.law.name!r}"
            )


def _user_state(system: System, rest: float, state: np.ndarray) -> np.ndarray:
    """Return (x1, v1, x2, v2) of the kernels' state."""
    x1, v1, r, s = state[:4]
    if not system.scene.damper:
        return np.array([x1, v1])
    return np.array([x1, v1, x1 - r + rest, v1 - s])


def impacts_of(noted: Impacts, scene: Scene) -> np.ndarray:
    """Return impacts as users see them, one row of dtype `IMPACT` for each."""
    rows = noted.data[: noted.filled[0]]
    table = np.empty(len(rows), IMPACT)
    table["wall"] = np.where(rows[:, 0] == 0, scene.struck["near"], scene.struck["far"])
    for column, name in enumerate(IMPACT.names[1:], start=1):  # type: ignore[index]  # has fields
        table[name] = rows[:, column]
    for name in ("gain1", "gain2"):  # known from the release on
        table[name][np.isnan(table["release"])] = np.nan
    return table
