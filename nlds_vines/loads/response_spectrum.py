"""Response spectra: the largest responses of oscillators of many periods to a record."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nlds_vines.archives.files import Csv
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import RequestError, library, number, shown
from nlds_vines.loads.floor_motion import Histories, floor_motion
from nlds_vines.model.loads.record import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PERIODS = 100  # default number of periods of a spectrum
LONGEST = 5.0  # default longest period [s], at least twice the shortest
PULSE = 1e-4  # width of the pulse of a rigid impact, in units of the shortest period
SUBSTEPS = 24  # evaluations in a period at least: cubics between them have a relative error of 1e-5


@dataclass(frozen=True, repr=False)
class ResponseSpectrum(Csv, Outlined):
    """The largest responses of linear oscillators to an acceleration of the ground.

    Attributes
    ----------
    record : Record
        The samples of the acceleration.
    zeta : float
        Damping ratio.
    periods : (n,) ndarray
        Undamped natural periods T [s].
    displacement : (n,) ndarray
        Largest displacement relative to the ground, Sd [m].
    absolute_acceleration : (n,) ndarray
        Largest absolute acceleration [m/s^2].
    """

    record: Record
    zeta: float
    periods: np.ndarray
    displacement: np.ndarray
    absolute_acceleration: np.ndarray

    @property
    def pseudo_velocity(self) -> np.ndarray:
        """The pseudo-velocity (n,), 2 pi Sd / T [m/s]."""
        return 2.0 * np.pi / self.periods * self.displacement

    @property
    def pseudo_acceleration(self) -> np.ndarray:
        """The pseudo-acceleration (n,), (2 pi / T)^2 Sd [m/s^2]."""
        return (2.0 * np.pi / self.periods) ** 2 * self.displacement

    def heading(self) -> str:
        """Return the name of the record and the damping ratio."""
        return f"{self.record.source or 'record'}, {100 * self.zeta:g} % of critical damping"

    def outline(self) -> Rows:
        """Return the line on the record, the range of the periods and the largest responses."""
        yield "", self.record.summary(np.inf)
        yield "periods", f"{self.periods.size}, {self.periods.min():g} to {self.periods.max():g} s"
        for name, unit in (("displacement", "m"), ("pseudo_acceleration", "m/s^2")):
            values = getattr(self, name)
            period = self.periods[values.argmax()]
            yield name.replace("_", "-"), f"up to {values.max():.4g} {unit} at {period:.4g} s"

    def to_dataframe(self) -> Any:
        """Return the spectrum as a `pandas.DataFrame` with a row for each period."""
        return library("pandas").DataFrame(self._columns())

    def csv_rows(self) -> list[Any]:
        """Return a row for each period, under the names of the columns."""
        columns = self._columns()
        return [columns, *np.column_stack([*columns.values()]).tolist()]

    def _columns(self) -> dict[str, np.ndarray]:
        names = ("displacement", "pseudo_velocity", "pseudo_acceleration", "absolute_acceleration")
        return {"period": self.periods, **{name: getattr(self, name) for name in names}}

    def plot(self, ax: Axes | None = None) -> Figure:
        """Return the picture of pseudo- and absolute acceleration over the period.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw into.
        """
        figure: Figure = import_module("nlds_vines.loads.picture").draw_spectrum(self, ax)
        return figure


def response_spectrum(
    record: str | os.PathLike[str] | Mapping[str, Any] | Record | Histories,
    zeta: float = 0.05,
    periods: ArrayLike | None = None,
    of: str = "",
    system: str = "",
) -> ResponseSpectrum:
    """Compute the response spectrum of a record, or of a floor in a response history.

    Parameters
    ----------
    record : path-like, mapping, Record or ResponseHistories
        The path of a record's file; or the table `[load.record]` of a request: `times` [s] and
        `values`, or `file`, with `dt`, `unit` and its other keys; or response histories, together
        with `of`.
    zeta : float, optional
        Damping ratio, 0 <= zeta < 1.
    periods : array_like, optional
        Undamped natural periods [s]; by default 100 from the step of the record, at least 0.01 s,
        to 5 s (or twice the shortest), geometrically spaced. Each must be positive.
    of : str, optional
        Of response histories, the absolute acceleration of a floor, ``"roof.a"``: the spectrum is
        that of equipment on this floor.
    system : str, optional
        The name of the system whose history is meant; not needed if only one has dampers.

    Returns
    -------
    ResponseSpectrum
        Displacement, pseudo-velocity, pseudo- and absolute acceleration over the period.

    Raises
    ------
    RequestError
        If the record cannot be read or is a force, or if a value is out of range; if a history has
        no such floor, or too few samples for the force of a contact.

    Notes
    -----
    Each oscillator x'' + 2 zeta w x' + w^2 x = -a(t), w = 2 pi / T, starts at rest and is followed
    exactly through the straight lines between the samples, and for one period after them.  The
    variable u = x' - conj(s) x, s = w (-zeta + i sqrt(1 - zeta^2)), obeys u' = s u - a, so that
    over a step h with a = a0 + (a1 - a0) t / h

        u(h) = exp(s h) u(0) - h a0 p1(s h) - h (a1 - a0) p2(s h),

    p1(z) = (exp(z) - 1) / z, p2(z) = (p1(z) - 1) / z.  Between the places at which it is evaluated,
    the largest value is that of a cubic, with an error of 1e-5.

    The acceleration of a floor is joined by lines between the instants of its history;
    ``sampling={"samples": 256}`` of `response_history` makes them denser.  At each impact on a
    rigid wall the velocity of the floor jumps by the wall's impulse; the oscillators take that as a
    pulse of 1e-4 of the shortest period.  The largest acceleration of the floor is then infinite,
    that of equipment is not.

    References
    ----------
    N. C. Nigam and P. C. Jennings, Calculation of response spectra from strong-motion earthquake
    records, Bulletin of the Seismological Society of America 59 (1969) 909-922.

    Examples
    --------
    >>> import numpy as np
    >>> import nlds_vines as nv
    >>> step = {"times": [0.0, 20.0], "values": [1.0, 1.0], "unit": "m/s^2"}
    >>> spectrum = nv.response_spectrum(step, zeta=0.0, periods=[1.0])
    >>> np.round(spectrum.absolute_acceleration, 4)
    array([2.])
    """
    motion = None
    if of or system or hasattr(record, "results"):
        motion = floor_motion(record, of, system)
        record = motion.record
    if not isinstance(record, Record):
        record = Record.of(os.fspath(record) if isinstance(record, os.PathLike) else record)
    if not record.is_acceleration:
        raise RequestError(f"the record is a force [{record.unit}]; needs a ground acceleration")
    if not 0.0 <= number("zeta", zeta) < 1.0:
        raise RequestError(f"zeta = {zeta!r} must be at least 0 and below 1")
    times, values = np.array(record.times), np.array(record.values) * record.factor
    if periods is None:
        shortest = max(record.step, 0.01)
        periods = np.geomspace(shortest, max(LONGEST, 2.0 * shortest), PERIODS)
    periods = np.atleast_1d(np.asarray(periods, dtype=float))
    if periods.ndim != 1 or not (np.isfinite(periods) & (periods > 0.0)).all():
        raise RequestError(f"periods = {shown(periods.tolist())} must be positive numbers [s]")
    if motion is not None:
        times, values = motion.with_pulses(PULSE * float(periods.min()))
    peaks = [_peaks(np.diff(times), values, zeta, period) for period in periods.tolist()]
    return ResponseSpectrum(record, zeta, periods, *np.array(peaks).reshape(-1, 2).T)


def _peaks(steps: np.ndarray, a: np.ndarray, zeta: float, period: float) -> tuple[float, float]:
    """Return the largest displacement and absolute acceleration; a (n + 1,) [m/s^2], steps (n,)."""
    from scipy.signal import lfilter

    omega = 2.0 * np.pi / period
    s = omega * complex(-zeta, np.sqrt(1.0 - zeta**2))
    rise, is_even = np.diff(a), np.ptp(steps) <= 1e-9 * steps[0]
    h = steps[:1] if is_even else steps

    def forced(h: np.ndarray, share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the factors of u, a0 and a1 - a0 at a share of steps `h`."""
        z = s * h * share
        p1 = np.expm1(z) / z
        return np.exp(z), -h * share * p1, -h * share**2 * (p1 - 1.0) / z

    factor, of_a, of_rise = forced(h, 1.0)
    push = of_a * a[:-1] + of_rise * rise
    if is_even:
        u = lfilter([1.0], [1.0, -factor[0]], push)
    else:
        u, now = np.empty(len(push), complex), 0.0j
        for i, (decay, change) in enumerate(zip(factor.tolist(), push.tolist(), strict=True)):
            now = decay * now + change
            u[i] = now
    u = np.concatenate([[0.0], u])
    # the states at places within the steps, then those of a free period after the record
    count = max(1, int(np.ceil(SUBSTEPS * steps.max() / period)))
    parts = [u[:-1]]
    for j in range(1, count):
        factor, of_a, of_rise = forced(h, j / count)
        parts.append(factor * u[:-1] + of_a * a[:-1] + of_rise * rise)
    inner = np.append(np.stack(parts, axis=1).ravel(), u[-1])
    shares = np.arange(count) / count
    ground = np.append((a[:-1, None] + rise[:, None] * shares).ravel(), a[-1])
    spacing = np.repeat(steps / count, count)
    after = u[-1] * np.exp(s * period * np.arange(SUBSTEPS + 1) / SUBSTEPS)
    free = np.zeros(SUBSTEPS + 1), np.full(SUBSTEPS, period / SUBSTEPS)
    largest = np.zeros(2)
    for states, acceleration, h in ((inner, ground, spacing), (after, *free)):
        x = states.imag / s.imag
        v = states.real + s.real * x
        total = -(omega**2) * x - 2.0 * zeta * omega * v
        rate = -(omega**2) * v - 2.0 * zeta * omega * (total - acceleration)
        largest = np.maximum(largest, [_largest(x, v, h), _largest(total, rate, h)])
    return largest[0], largest[1]


def _largest(y: np.ndarray, rates: np.ndarray, h: np.ndarray) -> float:
    """Return the largest |y| of the cubics with the values `y` and `rates` (n + 1,) at their ends.

    In a step, with t from 0 to 1: q = y - y0 = b t + c t^2 + d t^3, q' = b + 2 c t + 3 d t^2. An
    inner extremum is sought only where the rates at both ends differ in sign.
    """
    b, rise, end = rates[:-1] * h, np.diff(y), rates[1:] * h
    peaks = np.abs(y).max()
    turning = b * end < 0.0
    y0, b, rise, end = y[:-1][turning], b[turning], rise[turning], end[turning]
    c, d = 3.0 * rise - 2.0 * b - end, b + end - 2.0 * rise
    root = np.sqrt(np.maximum(c * c - 3.0 * b * d, 0.0))
    t = -b / (c - np.where(b > 0.0, root, -root))  # the zero of q' between 0 and 1
    inner = np.abs(y0 + t * (b + t * (c + t * d)))
    return float(max(peaks, inner.max(initial=0.0)))
