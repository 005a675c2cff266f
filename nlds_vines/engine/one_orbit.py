"""One orbit with its records, and the error of one that cannot be followed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.engine.records import STATUS, Violation
from nlds_vines.errors import RequestError, library
from nlds_vines.model.system import System

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class IntegrationError(RuntimeError):
    """The integration of an orbit failed; the message names the remedy.

    Attributes
    ----------
    code : int
        Its status, a key of `records.STATUS`.
    """

    code: int

    @classmethod
    def of(cls, system: System, code: int) -> IntegrationError:
        """Return the error of a system's orbit with a status."""
        error = cls(f"{system.name}: {STATUS[code].name}. {STATUS[code].remedy}")
        error.code = code
        return error


@dataclass(frozen=True, repr=False)
class Orbit(Outlined):
    """An orbit from `simulate`; attributes that were not recorded are None.

    Attributes
    ----------
    system : System
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
        largest up to the end.  Of a host's rigid wall the force is infinite, and `impulse` [N s]
        is the largest one while the body stays there; it is 0 of other walls.
    E1max, E2max : float
        Largest energies [J], equation (6), exact in time, without the transient.  Of a host E1max
        is kinetic and of its stiffness K, and E2max (dampers,) that of each damper's mass, with its
        spring stretched by its own displacement; 0 of a damper without a mass.  A `Spring` counts
        by its shortening r: (m v^2 + k r^2) / 2 + k2 r^3 / 3 + k3 r^4 / 4 + k5 r^6 / 6.
    E1peak, E2peak : float
        The same, including the transient; not of hosts.
    response : mapping
        Largest and rms displacements, velocities, accelerations, forces and powers by name
        (`responses.quantities_of`), without the transient.  Of a host, for each displacement of
        `of`, `roof.x_max` and `roof.x_rms`, the largest and the rms one [m], and `roof.a_max`, the
        largest absolute acceleration [m/s^2], infinite where the impulse of a rigid wall acts, and
        on moving ground `roof.x_abs_max` and `roof.x_abs_rms` of the absolute displacement [m]; for
        each damper with rigid walls `ball.impulse_max`, their largest impulse [N s].  Largest
        values are exact in time.
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
        scene = self.system.scene
        state = dict(zip(scene.components, self.state.tolist(), strict=True))
        yield "last state [m, m/s]", numbers(state)
        arrays = {name: getattr(self, name) for name in ("section", "impacts", "trajectory")}
        present = [f"{name} {array.shape}" for name, array in arrays.items() if array is not None]
        if present:
            yield "recorded", ", ".join(present)
        energies = dict[str, float]()
        for name in ("E1max", "E2max", "E1peak", "E2peak"):
            values = getattr(self, name)
            if np.ndim(values):  # one of each of several dampers
                words = [f"{name} of {damper}" for damper in scene.dampers]
                energies |= dict(zip(words or [name], values.tolist(), strict=False))
            elif values is not None:
                energies[name] = values
        if energies:
            yield "energies [J]", numbers(energies)
        if self.response is not None:
            values = {name: v for name, v in self.response.items() if not np.ndim(v)}
            yield "response [SI]", numbers(values)
        others = {} if self.clearance is None else {"clearance [m]": self.clearance}
        if self.violation is not None:
            others |= {"violations": self.violation.number, "depth [m]": self.violation.depth}
        if others:
            yield "limits", numbers(others)

    @property
    def recurrence(self) -> int:
        """The n of an nT orbit by recurrence: the section repeats to 1e-6; 0 if it does not."""
        from nlds_vines.kernels.orbit.repetition import TOLERANCE, period_of

        section = self.section
        if section is None and self.trajectory is not None and self.time is not None:
            turns = self.time / self.system.period
            samples = round(1.0 / (turns[1] - turns[0])) if turns.size > 1 else 1
            section = self.trajectory[samples - 1 :: samples]
        if section is None:
            raise RequestError("the orbit holds no section: simulate with record=['section']")
        return int(period_of(np.ascontiguousarray(section), TOLERANCE))

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
            `contact`, or `contact_near` and `contact_far`.  Of a host, its components, each
            `force.roof` and the contact force `cell.force` on each damper.  Units are in `attrs`.

        Raises
        ------
        RequestError
            If there is no trajectory, or no pandas.
        """
        if self.trajectory is None or self.time is None:
            raise RequestError("no trajectory: simulate the orbit with 'trajectory' in record")
        system = self.system
        names = system.scene.components
        columns = dict(zip(names, self.trajectory.T, strict=True))
        turns = self.time * (system.parameters["omega"] / (2.0 * np.pi))
        phase = 2.0 * np.pi * (turns % 1.0)
        forces = system.harmonic_forces(self.time) | system.contact_columns(self.trajectory)
        frame = library("pandas").DataFrame(
            {"time": self.time, **columns, "phase": phase, **forces}
        )
        units = {"time": "s", "phase": "rad", **dict.fromkeys(forces, "N")}
        for i, name in enumerate(names):
            units[name] = "m/s" if i % 2 else "m"
        frame.attrs = {"title": system.heading(), "units": units}
        return frame
