"""One orbit in Python: `simulate`, and its spectrum."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.errors import (
    RequestError,
    checked_names,
    choice,
    library,
    shown,
    truth,
    unknown,
    whole,
)
from nlds_vines.kernels.cells.cells import run_cell
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.kernels.scene.codes import OK, RESPONSE_COLUMNS
from nlds_vines.kernels.scene.scene import CellBuffers, Span
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS, Impacts
from nlds_vines.model.catalog import any_system, without_hosts
from nlds_vines.model.host_system import HostSystem
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System
from nlds_vines.orbits import responses
from nlds_vines.orbits.batch import parts_of
from nlds_vines.orbits.compilation import Compilation, Needed, notice
from nlds_vines.orbits.host_orbits import RECORDS as HOST_RECORDS
from nlds_vines.orbits.host_orbits import HostOrbits, energies_of, follow_host, response_of
from nlds_vines.orbits.records import IMPACT, IMPACT_NUMBERS, STATUS, Violation, refuse_impossible
from nlds_vines.orbits.responses import OF_ROWS
from nlds_vines.orbits.signals import signal_of
from nlds_vines.orbits.solver_settings import METHODS, Settings, chosen_settings
from nlds_vines.orbits.spectrum import Spectrum, spectrum_of
from nlds_vines.orbits.starts import ROUND_OFF, checked_start
from nlds_vines.runs import progress
from nlds_vines.runs.executors import free_memory
from nlds_vines.runs.interrupts import stoppable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RECORDS = ("section", "impacts", "energy", "peak", "response", "clearance", "trajectory")

_SMALL = 100_000_000  # bytes for which nobody asks how much memory is free, which takes a moment
SAMPLES = 512  # states of a trajectory in each forcing period, by default

# Up to so many periods (some milliseconds), kernels run in the calling thread.  Longer work runs in
# a second one, so that signals can end it; that costs more CPU time than a period.
SHORT = 1000

_RUN_CELL = getattr(run_cell, "entry", run_cell)  # the compiled entry of `run_cell`
_loaded: set[Needed] = set()  # the kernels that have run in this process


class IntegrationError(RuntimeError):
    """The integration of an orbit failed; the message names the remedy.

    Attributes
    ----------
    code : int
        Its status, a key of `records.STATUS`.
    """

    code: int

    @classmethod
    def of(cls, system: System | HostSystem, code: int) -> IntegrationError:
        """Return the error of a system's orbit with a status."""
        error = cls(f"{system.name}: {STATUS[code].name}. {STATUS[code].remedy}")
        error.code = code
        return error


@dataclass(frozen=True, repr=False)
class Orbit(Outlined):
    """An orbit from `simulate`; attributes that were not recorded are None.

    Attributes
    ----------
    system : System or HostSystem
        The system.
    state : (components,) ndarray
        The last state x1, v1, x2, v2 [m, m/s]; without a damper x1, v1 (or x, v); of a host its
        `scene.components`.
    section : (periods, components) ndarray
        The states at t = T, 2T, ..., counted from the end of the transient.
    impacts : ndarray of dtype `records.IMPACT`, of a host `records.HOST_IMPACT`
        One row per touch: `wall` (name of the struck body; of a host `damper`, and the side of its
        wall), times `touch` and `release` [s] from the start of the transient, approach `speed`
        [m/s], peak `force` [N], `depth` [m], changes `gain1`, `gain2` of E1 and E2 [J], but of
        hosts.  If an impact lasts beyond the end, `release` is NaN, and force and depth are the
        largest up to the end.  Of a host's rigid wall the force is infinite.
    E1max, E2max : float
        Largest energies [J], equation (6), exact in time, without the transient.  Of a host E1max
        is kinetic and of its stiffness K, and E2max (dampers,) that of each damper's mass, with its
        spring stretched by its own displacement; 0 of a damper without a mass.
    E1peak, E2peak : float
        The same, including the transient; not of hosts.
    response : mapping
        Largest and rms displacements, velocities, accelerations, forces and powers by name
        (`responses.quantities_of`), without the transient.  Of a host, for each displacement of
        `of`, `x_max` and `x_rms`, the largest and the rms one [m], and `a_max`, the largest
        absolute acceleration [m/s^2].  Largest values are exact in time; where rigid walls of hosts
        are struck accelerations are those before and after.
    clearance : float
        Smallest distance [m] of a pass that misses a wall; inf if there is none; not of hosts.
    violation : Violation
        Number, first time [s] and depth [m] of violations, if the scene has a limit.
    trajectory : (periods samples, components) ndarray
        `samples` equidistant states of each period, the last one at its end.
    time : (periods samples,) ndarray
        Their times [s] from the start of the transient.
    transient : int
        Forcing periods before those that are recorded.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> orbit = nv.simulate("ssul-set6", 2, transient=200, omega=5.5, quiet=True)
    >>> orbit.section.shape, len(orbit.impacts), str(orbit.impacts["wall"][0])
    ((2, 4), 2, 'obstacle')
    """

    system: Any
    state: np.ndarray
    section: np.ndarray | None = None
    impacts: np.ndarray | None = None
    E1max: float | None = None
    E2max: Any = None
    E1peak: float | None = None
    E2peak: float | None = None
    response: Mapping[str, Any] | None = None
    clearance: float | None = None
    violation: Violation | None = None
    trajectory: np.ndarray | None = None
    time: np.ndarray | None = None
    transient: int = 0

    def heading(self) -> str:
        """Return that of the system."""
        return f"of {self.system.heading()}"

    def outline(self) -> Rows:
        """Return the last state and the records, arrays by their shapes."""
        names, is_host = self.system.scene.components, isinstance(self.system, HostSystem)
        yield "last state [m, m/s]", numbers(dict(zip(names, self.state.tolist(), strict=True)))
        arrays = {name: getattr(self, name) for name in ("section", "impacts", "trajectory")}
        present = [f"{name} {array.shape}" for name, array in arrays.items() if array is not None]
        if present:
            yield "recorded", ", ".join(present)
        of_bodies = ("E1max", "E2max", "E1peak", "E2peak")
        energies = {name: e for name in of_bodies if (e := getattr(self, name)) is not None}
        if energies and is_host:
            dampers = [f"E2max of {damper.name}" for damper in self.system.dampers]
            energies |= dict(zip(dampers, energies.pop("E2max").tolist(), strict=True))
        if energies:
            yield "energies [J]", numbers(energies)
        for row, values in (self.response or {}).items() if is_host else ():
            yield f"{row} [m, m/s^2]", numbers(values)
        others = {} if self.clearance is None else {"clearance [m]": self.clearance}
        if self.violation is not None:
            others |= {"violations": self.violation.number, "depth [m]": self.violation.depth}
        if others:
            yield "limits", numbers(others)

    def plot(self, show: str | None = None, ax: Axes | None = None) -> Figure:
        """Draw the orbit with the panels of `nlds_vines.orbit_portrait`; nothing is computed.

        Parameters
        ----------
        show : str, optional
            Names of panels, separated by commas.  By default displacement, relative displacement,
            section and section at impact, as far as the orbit records them.
        ax : matplotlib.axes.Axes, optional
            Axes for one panel.

        Returns
        -------
        matplotlib.figure.Figure
            The picture, or the figure of `ax`.  Without a trajectory, histories are the states at
            t = nT.

        Raises
        ------
        RequestError
            If the orbit records neither section nor trajectory, or not what `show` names.

        Examples
        --------
        >>> import nlds_vines as nv
        >>> orbit = nv.simulate("ssul-set6", 9, transient=200, omega=5.5, quiet=True)
        >>> [axes.get_label() for axes in orbit.plot().axes]
        ['displacement', 'relative', 'section', 'impact-section']
        """
        figure: Figure = import_module("nlds_vines.portrait.picture").draw_orbit(self, show, ax)
        return figure

    def to_dataframe(self) -> Any:
        """Return the trajectory as a table; needs the extra `xarray`.

        Returns
        -------
        pandas.DataFrame
            Columns `time` [s] from the start of the transient; the state x1, v1, x2, v2 [m, m/s];
            `phase` of the force [rad], omega t in [0, 2 pi); `force` P cos(omega t) [N]; and the
            contact force [N] of each wall, equations (2) and (3), positive in the direction of x2:
            `contact`, or `contact_near` and `contact_far`.  Units are in `attrs`.

        Raises
        ------
        RequestError
            If there is no trajectory, or no pandas, and for a host.
        """
        if self.trajectory is None or self.time is None:
            raise RequestError("no trajectory: simulate the orbit with 'trajectory' in record")
        system = without_hosts(self.system)
        names = system.scene.components
        columns = dict(zip(names, self.trajectory.T, strict=True))
        turns = self.time * (system.parameters["omega"] / (2.0 * np.pi))
        phase, force = 2.0 * np.pi * (turns % 1.0), responses.harmonic_force(system, self.time)
        contacts = responses.contact_forces(system, self.trajectory)
        walls = ("contact_near", "contact_far") if len(contacts) == 2 else ("contact",)
        by_wall = dict(zip(walls, contacts.values(), strict=False))
        frame = library("pandas").DataFrame(
            {"time": self.time, **columns, "phase": phase, "force": force, **by_wall}
        )
        units = {name: "m/s" if name.startswith("v") else "m" for name in names}
        units |= {"time": "s", "phase": "rad", **dict.fromkeys(("force", *by_wall), "N")}
        frame.attrs = {"title": system.heading(), "units": units}
        return frame


def simulate(
    system: System | HostSystem | str | os.PathLike[str],
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
    of: Sequence[str] = (),
    quiet: bool = False,
    **overrides: float | str,
) -> Orbit:
    """Integrate one orbit over forcing periods.

    Parameters
    ----------
    system : System, HostSystem, str or path-like
        A system, its name in the catalog, or the path of a TOML file.
    periods : int
        Number of forcing periods to record, >= 0.
    start : (4,) array_like, optional
        State x1, v1, x2, v2 [m, m/s] at t = 0, by default at rest; without a damper x1, v1; of a
        host its `scene.components`.  A start on a wall or inside a contact is allowed and does not
        count as an impact.
    transient : int
        Number of periods before those that are recorded.
    method : str
        "exact": exact flights and certified touches; "rk4": fixed steps, shorter in contacts.
    record : list of str, optional
        Of section, impacts, energy, peak, response, clearance, trajectory; by default section and,
        if there are walls, impacts.
    tolerance : float or str, optional
        Of "exact": relative error of each contact, 1e-13 to 1e-3, or "draft" (1e-6), "standard"
        (1e-9, the default), "fine" (1e-12).  Flights are exact to round-off.
    contact_steps : float, optional
        Of "exact": Taylor steps of a stepped contact, in place of the tolerance.
    period_steps : float, optional
        Of "rk4": steps per forcing period (512); a free impact has a quarter as many.
    nodes : int, optional
        Of "exact": collocation nodes of a short impact, in place of the tolerance.
    samples : int
        States of a trajectory per period.
    of : sequence of str, optional
        Of a host, the displacements whose response is recorded: a degree of freedom "roof", a
        damper's mass "cell1", or a difference "roof-floor2"; by default the degrees of freedom that
        dampers hang on, without dampers all.
    quiet : bool
        Whether to suppress the message about compiling.
    **overrides
        Parameters of the system that replace its own, as in `load_system`.

    Returns
    -------
    Orbit
        The last state and the records.

    Raises
    ------
    RequestError
        If an argument is wrong.
    IntegrationError
        If the integration fails.

    Notes
    -----
    Once compiled, a call of one period takes some 50 us
    (`python -m benchmarks.speed simulate`, 300 calls).

    Examples
    --------
    >>> import nlds_vines as nv
    >>> orbit = nv.simulate("ssul-set6", 3, transient=300, omega=5.5, quiet=True)
    >>> orbit.section.shape
    (3, 4)
    >>> bool(abs(orbit.section[2] - orbit.section[0]).max() < 1e-6)
    True
    """
    options = {"contact_steps": contact_steps, "period_steps": period_steps, "nodes": nodes}
    system = any_system(system)
    if overrides:
        system = system.with_(**overrides)
    whole("periods", periods, 0)
    whole("transient", transient, 0)
    whole("samples", samples, 1, 10**6)
    truth("quiet", quiet)
    of = (of,) if isinstance(of, str) else checked_names("of", of)
    is_host = isinstance(system, HostSystem)
    choice("method of a host" if is_host else "method", method, METHODS[:1] if is_host else METHODS)
    record = checked_record(system, record)
    refuse_without_room(record, periods, samples, len(system.scene.components))
    begin: Beginning | HostBeginning
    if isinstance(system, HostSystem):
        for name, value in options.items():
            if value is not None:
                allowed = "start, transient, record, tolerance, samples, of"
                raise unknown("option of a host's orbit", name, allowed.split(", "))
        settings = chosen_settings(method, {"tolerance": tolerance})
        begin = HostBeginning(system, settings, start, of=system.displacements(of, record))
    elif of:
        raise RequestError(f"of = {shown(of)} is for the response of a host")
    else:
        settings, cell = chosen_settings(method, {"tolerance": tolerance, **options}), system.cell
        begin = Beginning(system, method, settings, cell, start_state(system, cell.rest, start))
    return begin.follow(record, transient, periods, samples, quiet=quiet)


class HostBeginning(NamedTuple):
    """A state from which kernels follow an orbit of a host."""

    system: HostSystem
    settings: Settings
    state: Any  # (components,) at phase zero, as of `simulate`
    is_put_on_walls: bool = False  # whether a state inside a rigid wall is put on it, or refused
    of: tuple[str, ...] = ()  # displacements whose response is recorded, if it is

    def follow(
        self,
        record: tuple[str, ...],
        transient: int,
        periods: int,
        samples: int = 1,
        *,
        quiet: bool = True,
    ) -> Orbit:
        """Integrate the orbit as `simulate` does; raise `IntegrationError` if that fails."""
        system, has_all = self.system, "trajectory" in record
        span = Span(transient, periods, samples if has_all else 1)
        orbits = HostOrbits(system, self.settings.stepped_to)
        state = orbits.start(self.state, self.is_put_on_walls)
        rows = self.of if "response" in record else ()
        records: Any = orbits.records("energy" in record, rows)
        code, section, impacts, _ = follow_host(orbits, state, span, notice(quiet), records)
        if code != OK:
            raise IntegrationError.of(system, code)
        states, results = orbits.states(section), dict[str, Any]()
        if "energy" in record:
            results["E1max"], results["E2max"] = energies_of(records, system)
        if "response" in record:
            table = response_of(records, periods * system.period).tolist()
            of_rows = (dict(zip(OF_ROWS, values, strict=True)) for values in table)
            results["response"] = dict(zip(rows, of_rows, strict=True))
        count = span.first * span.stops + 1 + np.arange(len(states))
        return Orbit(
            system,
            orbits.states(state),
            section=states[span.stops - 1 :: span.stops] if "section" in record else None,
            impacts=orbits.table_of(impacts) if "impacts" in record else None,
            **results,
            trajectory=states if has_all else None,
            time=count * (system.period / span.stops) if has_all else None,
            transient=span.first,
        )

    def after(self, periods: int) -> HostBeginning:
        """Return the beginning at the state after so many periods."""
        state = self.follow((), periods, 0).state
        return self._replace(state=state, is_put_on_walls=True)


class Beginning(NamedTuple):
    """A state from which kernels follow an orbit, with the system and the method."""

    system: System
    method: str
    settings: Settings
    cell: Any  # the record of the system
    state: np.ndarray  # (STATE_SIZE,) x1, v1, r, s, q, mode ... at phase zero

    def follow(
        self,
        record: tuple[str, ...],
        transient: int,
        periods: int,
        samples: int = 1,
        *,
        quiet: bool = True,
    ) -> Orbit:
        system, scene = self.system, self.system.scene
        stops = samples if "trajectory" in record else 1
        has_states = "section" in record or "trajectory" in record
        responds = "response" in record
        cell = CellBuffers(
            section=np.empty((periods * stops, len(scene.components))) if has_states else None,
            impacts=room_for_impacts(16 + 4 * periods) if "impacts" in record else None,
            energy=np.zeros(2) if "energy" in record else None,
            peak=np.zeros(2) if "peak" in record else None,
            clearance=np.full(1, np.inf) if "clearance" in record else None,
            violation=None if scene.limit is None else np.zeros(3),
            response=np.full(RESPONSE_COLUMNS, np.nan) if responds else None,
            **(responses.moving(scene) if responds else {}),
        )
        while True:
            state, span = self.state.copy(), Span(transient, periods, stops)
            self._run(record, cell, state, span, quiet)
            impacts = cell.impacts
            if impacts is None or impacts.filled[0] <= len(impacts.data):
                break
            # run again with enough room: the same orbit has the same number of impacts
            cell = cell._replace(impacts=room_for_impacts(int(impacts.filled[0])))
            if cell.clearance is not None:
                cell = cell._replace(clearance=np.full(1, np.inf))

        # last state and records in the user's coordinates
        results = dict[str, Any]()
        if "trajectory" in record:
            count = transient * stops + 1 + np.arange(len(cell.section))
            results["trajectory"], results["time"] = cell.section, count * (system.period / stops)
        if "section" in record:
            results["section"] = np.ascontiguousarray(cell.section[stops - 1 :: stops])
        for name, energies in (("max", cell.energy), ("peak", cell.peak)):
            if energies is not None:
                results[f"E1{name}"] = float(energies[0])
                results[f"E2{name}"] = float(energies[1]) if scene.damper else None
        if cell.impacts is not None:
            results["impacts"] = impacts_of(cell.impacts, scene)
        if cell.clearance is not None:
            results["clearance"] = float(cell.clearance[0])
        if cell.response is not None:
            results["response"] = responses.values_of(cell.response, system)
        if cell.violation is not None:
            time, depth, number = cell.violation.tolist()
            results["violation"] = Violation(int(number), time, depth)
        x1, v1, r, s = state[:4].tolist()
        last = [x1, v1, x1 - r + self.cell.rest, v1 - s] if scene.damper else [x1, v1]
        return Orbit(system, np.array(last), **results, transient=transient)

    def after(self, periods: int) -> Beginning:
        state, limit = self.state.copy(), self.system.scene.limit
        cell = CellBuffers(violation=None if limit is None else np.zeros(3))
        self._run((), cell, state, Span(periods, 0, 1), quiet=True)
        return self._replace(state=state)

    def _run(
        self, record: tuple[str, ...], cell: CellBuffers, state: np.ndarray, span: Span, quiet: bool
    ) -> None:
        needed = Needed(self.system.scene.key, self.method, record)
        parts = parts_of(self.method, self.system.scene, self.settings)
        arguments = parts, self.cell, state, span, cell
        if needed in _loaded and span.first + span.periods <= SHORT:
            code = run_cell(*arguments)
        else:
            code = _run_compiling(needed, quiet, arguments)
            _loaded.add(needed)
        if code != OK:
            raise IntegrationError.of(self.system, code)


@stoppable
def _run_compiling(needed: Needed, quiet: bool, arguments: tuple[Any, ...]) -> int:
    with Compilation(needed, notice(quiet), helped=False).followed({_RUN_CELL: "orbit"}):
        return run_cell(*arguments)


def spectrum(orbit: Orbit, signal: str = "x1", *, window: str = "rectangular") -> Spectrum:
    """Return the spectrum of a signal along an orbit.

    Parameters
    ----------
    orbit : Orbit
        From `simulate` with "trajectory" in `record`.  If an nT orbit is recorded over a multiple
        of n periods, each line lies on a bin and none leaks.
    signal : str
        A component of the state, x1, v1, x2, v2 [m, m/s]; u = x2 - x1 [m]; the contact `force` on
        the damper [N]; an energy, E1 or E2 [J].  Of a host, a displacement "roof" or "roof-floor2"
        [m], its velocity "roof.v" [m/s], "cell1.stroke" [m], "cell1.force" [N], E1 or "cell1.E2".
    window : str
        "rectangular" or "hann".

    Returns
    -------
    Spectrum
        Amplitude and power over the order, the frequency over that of the force.

    Raises
    ------
    RequestError
        If the orbit has no trajectory, or the scene lacks the signal.

    Notes
    -----
    512 samples per period, the default of `simulate`, suffice for states: aliasing onto their lines
    is below 1e-9 m.  A contact lasts 16 to 24 ms, a fiftieth of a period, and the spectrum of its
    force is wide: with 512 samples the error is 2e-3 of its largest line, with 1024 4e-4, with 4096
    1e-5 (SSul Set 6, 7.375 rad/s).

    Examples
    --------
    >>> import nlds_vines as nv
    >>> system = nv.load_system("ssul-set6", omega=5.5)
    >>> record = ["trajectory", "impacts"]
    >>> orbit = nv.simulate(system, 8, transient=200, record=record, quiet=True)
    >>> lines = nv.spectrum(orbit, "x1")
    >>> float(lines.order[1 + lines.amplitude[1:].argmax()])
    1.0
    """
    if not hasattr(orbit, "trajectory"):
        raise RequestError(f"orbit = {shown(orbit)} must be an Orbit, as simulate returns it")
    chosen = signal_of(orbit.system, signal)
    if orbit.trajectory is None or orbit.time is None:
        raise RequestError("the orbit holds no trajectory: simulate with record=['trajectory']")
    if len(orbit.time) < 2:
        raise RequestError("a trajectory of one state has no spectrum: record more periods")
    step = (orbit.time[-1] - orbit.time[0]) / (len(orbit.time) - 1)
    return spectrum_of(
        chosen.of(orbit.system, orbit.trajectory),
        round(orbit.system.period / step),
        orbit.system.parameters["omega"],
        window=window,
        quantity=signal,
        unit=chosen.unit,
    )


def checked_record(system: System | HostSystem, record: Collection[str] | None) -> tuple[str, ...]:
    is_host = isinstance(system, HostSystem)
    if record is None:
        return ("section", "impacts") if is_host or system.scene.walls else ("section",)
    if isinstance(record, str):
        record = (record,)
    allowed = HOST_RECORDS if is_host else RECORDS
    is_listed = record.ndim == 1 if isinstance(record, np.ndarray) else True
    if not isinstance(record, Collection) or not is_listed:
        raise RequestError(f"record = {shown(record)} must be a list of {', '.join(allowed)}")
    for word in record:
        choice("record of a host" if is_host else "record", word, allowed)
    if not is_host:
        refuse_impossible(tuple(record), system.scene)
    return tuple(record)


def refuse_without_room(record: Collection[str], periods: int, samples: int, size: int) -> None:
    """Raise `RequestError` if the records of an orbit need more memory than is free."""
    count = 0
    if "trajectory" in record:
        count += periods * samples * size
    elif "section" in record:
        count += periods * size
    if "impacts" in record:
        count += IMPACT_COLUMNS * 4 * periods
    if 8 * count < _SMALL:
        return
    free = free_memory()
    if free is not None and 8 * count > free:
        raise RequestError(
            f"periods = {periods}: the records {', '.join(record)} need {progress.size(8 * count)} "
            f"of memory, {progress.size(max(free, 0))} are free: record less, or begin later by "
            "transient"
        )


def room_for_impacts(capacity: int) -> Impacts:
    return Impacts(np.empty((capacity, IMPACT_COLUMNS)), np.zeros(1, np.int64))


def start_state(
    system: System, rest: float, start: Sequence[float] | np.ndarray | None
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


# `IMPACT` with its numbers as one array
_ROW = np.dtype([("wall", IMPACT["wall"]), ("numbers", float, len(IMPACT_NUMBERS))])


def impacts_of(impacts: Impacts, scene: Scene) -> np.ndarray:
    """Return the impacts that kernels recorded as rows of dtype `IMPACT`."""
    rows = impacts.data[: impacts.filled[0]]
    table = np.zeros(len(rows), _ROW)
    if len(rows):
        table["wall"] = np.where(rows[:, 0] == 0, scene.struck["near"], scene.struck["far"])
        values: np.ndarray = table["numbers"]
        values[:] = rows[:, 1 : 1 + values.shape[1]]
        values[np.isnan(values[:, 1]), -2:] = np.nan  # gains are complete at the release
    return table.view(IMPACT)
