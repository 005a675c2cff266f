"""One orbit in Python: `simulate`, and its spectrum."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import ArrayLike

from nlds_vines.engine.engine import engine_for
from nlds_vines.engine.one_orbit import Orbit
from nlds_vines.engine.records import SIMULATED, refuse_impossible
from nlds_vines.engine.solver_settings import chosen_settings
from nlds_vines.engine.spectrum import Spectrum, spectrum_of
from nlds_vines.errors import RequestError, checked_names, choice, shown, truth, unknown, whole
from nlds_vines.kernels.watch.observe import IMPACT_COLUMNS
from nlds_vines.model.axis import real_array
from nlds_vines.model.catalog import any_system
from nlds_vines.model.system import System
from nlds_vines.runs import progress
from nlds_vines.runs.executors import free_memory

_SMALL = 100_000_000  # bytes for which nobody asks how much memory is free, which takes a moment
SAMPLES = 512  # states of a trajectory in each forcing period, by default


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
    of: Sequence[str] = (),
    quiet: bool = False,
    **overrides: float | str,
) -> Orbit:
    """Integrate one orbit over forcing periods.

    Parameters
    ----------
    system : System, str or path-like
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
    system = any_system(system)
    if overrides:
        system = system.with_(**overrides)
    whole("periods", periods, 0)
    whole("transient", transient, 0)
    whole("samples", samples, 1, 10**6)
    truth("quiet", quiet)
    of = checked_names("of", [of] if isinstance(of, str | int) else of)
    engine, scene = engine_for(system), system.scene
    choice("method", method, scene.methods)
    words = checked_record(system, record)
    refuse_without_room(words, periods, samples, len(scene.components))
    options = {
        "tolerance": tolerance,
        "contact_steps": contact_steps,
        "period_steps": period_steps,
        "nodes": nodes,
    }
    for name, value in options.items():
        if value is not None and name not in scene.fineness:
            raise unknown(f"option for {scene.meaning}:", name, scene.fineness)
    settings = chosen_settings(method, options)
    begin = engine.begin(start, method, settings, system.displacements(of, words))
    return begin.follow(words, transient, periods, samples, quiet=quiet)


def spectrum(
    orbit: Orbit, signal: str | ArrayLike = "x1", *, window: str = "rectangular"
) -> Spectrum:
    """Return the spectrum of a signal along an orbit.

    Parameters
    ----------
    orbit : Orbit
        From `simulate` with "trajectory" in `record`.  If an nT orbit is recorded over a multiple
        of n periods, each line lies on a bin and none leaks.
    signal : str or array_like
        A component of the state, x1, v1, x2, v2 [m, m/s]; u = x2 - x1 [m]; the contact `force` on
        the damper [N]; an energy, E1 or E2 [J].  Of a host, a displacement "roof" or "roof-floor2"
        [m], its velocity "roof.v" [m/s], "cell1.stroke" [m], "cell1.force" [N], E1 or "cell1.E2".
        Or the values of any other signal at the times of the trajectory.
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
    chosen = orbit.system.signal(signal) if isinstance(signal, str) else None
    if orbit.trajectory is None or orbit.time is None:
        raise RequestError("the orbit holds no trajectory: simulate with record=['trajectory']")
    if len(orbit.time) < 2:
        raise RequestError("a trajectory of one state has no spectrum: record more periods")
    step = (orbit.time[-1] - orbit.time[0]) / (len(orbit.time) - 1)
    if chosen is None:
        values = real_array("signal", signal)
        if values.shape != orbit.time.shape:
            raise RequestError(
                f"signal has the shape {values.shape}, the trajectory {orbit.time.size} times"
            )
    else:
        values = chosen.of(orbit.trajectory)
    return spectrum_of(
        values,
        round(orbit.system.period / step),
        orbit.system.parameters["omega"],
        window=window,
        quantity="values" if chosen is None else str(signal),
        unit="1" if chosen is None else chosen.unit,
    )


def checked_record(system: System, record: Collection[str] | None) -> tuple[str, ...]:
    """Return the records of an orbit, by default the section and, if there are walls, impacts."""
    scene = system.scene
    if record is None:
        return ("section", "impacts") if scene.walls else ("section",)
    if isinstance(record, str):
        record = (record,)
    allowed = [word for word in SIMULATED if word not in scene.unrecorded]
    is_listed = record.ndim == 1 if isinstance(record, np.ndarray) else True
    if not isinstance(record, Collection) or not is_listed:
        raise RequestError(f"record = {shown(record)} must be a list of {', '.join(allowed)}")
    for word in record:
        choice("record", word, allowed)
    refuse_impossible([word for word in record if word not in scene.may_be_empty], scene)
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
