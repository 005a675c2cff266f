"""Response histories read from an archive: a history for each damper, or the values of a scan.

Closed forms for structures without walls, under a blow or noise, check them.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.files import Csv
from nlds_vines.archives.provenance import RESPONSE_HISTORY
from nlds_vines.archives.representation import Outlined, Rows, numbers
from nlds_vines.errors import RequestError, choice
from nlds_vines.loads.datasets import (
    HISTORIES,
    HOST_HISTORIES,
    IMPACT_COLUMNS,
    names_of_numbers,
    owners_of,
)
from nlds_vines.loads.request import HistoryRequest, load_response_history
from nlds_vines.model.catalog import without_hosts
from nlds_vines.model.linear_response import flow_matrix
from nlds_vines.model.loads.loading import Loading
from nlds_vines.model.quantities import SHARES, WAYS, of_load
from nlds_vines.model.system import General, Preset
from nlds_vines.orbits.records import OK, STATUS
from nlds_vines.plotting.drawable import Drawable


class History(Outlined):
    """The quantities of a response to a load, by name."""

    numbers: Mapping[str, float]

    @property
    def last(self) -> np.ndarray:
        """The last times (3,) [s] at which E1 exceeds 1, 10 and 50 % of its largest value.

        NaN if E1 exceeds it at the end.
        """
        return np.array([self.numbers[f"last_{100 * share:g}"] for share in SHARES])


@dataclass(frozen=True, repr=False)
class ResponseHistory(History):
    """The response of one structure to a load.

    Values that the structure does not have (without a damper, without walls) are NaN, and so is
    everything if the orbit failed.

    Attributes
    ----------
    time : (n,) ndarray
        From 0 to the duration [s].
    E1, E2 : (n,) ndarray
        Energies of structure and damper [J].
    x1, x2 : (n,) ndarray
        Displacements of structure and damper [m], relative to the ground.
    work : (n,) ndarray
        Energy supplied so far [J].
    dissipated : mapping of str to (n,) ndarray
        Energy dissipated so far [J] by `c1`, `c2` and `contact`.
    numbers : mapping of str to float
        The quantities of the response, such as `x1_max` [m] and `a1_max` [m/s^2]; all names are in
        the table of `loads-in-time`.
    status : int
        0 unless the orbit failed.
    """

    time: np.ndarray
    E1: np.ndarray
    E2: np.ndarray
    x1: np.ndarray
    x2: np.ndarray
    work: np.ndarray
    dissipated: Mapping[str, np.ndarray]
    numbers: Mapping[str, float]
    status: int = OK


@dataclass(frozen=True, repr=False)
class HostHistory(History):
    """The response of a host with dampers to a load.

    Values that the system does not have are NaN, and so is everything if the orbit failed.

    Attributes
    ----------
    time : (n,) ndarray
        From 0 to the duration [s].
    x, a : mapping of str to (n,) ndarray
        Displacements [m], relative to the ground, and absolute accelerations [m/s^2] by name.
    E1 : (n,) ndarray
        Energy of the host [J].
    E2, stroke : mapping of str to (n,) ndarray
        By damper, the energy of its mass [J] and the displacement r of its spring [m].
    numbers : mapping of str to float
        The quantities of the response by name: E1max, last_50, roof.x_max, cell.impact_count ...
    impacts : mapping of str to (impacts,) ndarray
        Columns of the impacts in the order of touches: times `touch` and `release` [s], approach
        `speed` [m/s], largest `force` [N] and `depth` [m], `impulse` [N s] of a rigid wall, the
        `damper`, the side of its `wall`.
    status : int
        0 unless the orbit failed.
    """

    time: np.ndarray
    x: Mapping[str, np.ndarray]
    a: Mapping[str, np.ndarray]
    E1: np.ndarray
    E2: Mapping[str, np.ndarray]
    stroke: Mapping[str, np.ndarray]
    numbers: Mapping[str, float]
    impacts: Mapping[str, np.ndarray]
    status: int = OK

    def heading(self) -> str:
        return f"{len(self.impacts['touch'])} impacts in {self.time[-1]:g} s"

    def outline(self) -> Rows:
        yield "numbers", numbers({k: v for k, v in self.numbers.items() if not np.isnan(v)})


PEAKS: tuple[str, ...] = ("x1_max", "a1_max", "stroke_max", "force_max", "impulse_max", "shear_max")
HOST_PEAKS = ("x_max", "a_max", "stroke_max", "force_max", "impulse_max")


class Peak(NamedTuple):
    """A largest response: whose, of what, in its unit, and 1 - value / value without a damper."""

    damper: str
    quantity: str
    value: float
    unit: str
    reduction: float


@dataclass(frozen=True, repr=False)
class ResponseHistories(Csv, Drawable):
    """The response of a structure to a load, with each damper.

    Attributes
    ----------
    path : ArchivePath
        Archive of the results.
    request : HistoryRequest
        Request that computes them again.
    results : mapping of str to ResponseHistory
        The response with each damper, by the name of its system; `histories["tmd"]` is one of them.
        Of hosts, each is a `HostHistory`.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> histories = nv.response_history("tmd", impulse=300.0, duration=2.0, quiet=True)
    >>> round(histories["tmd"].numbers["x1_max"], 4)
    0.0441
    """

    drawn_by = "nlds_vines.loads.picture"

    path: ArchivePath
    request: HistoryRequest
    results: Mapping[str, ResponseHistory | HostHistory]

    def __getitem__(self, name: str) -> Any:
        """Return the response with one damper, by the name of its system."""
        return self.results[choice("damper", name, self.results)]

    @property
    def failed(self) -> int:
        """The number of orbits that failed."""
        return sum(history.status != OK for history in self.results.values())

    @property
    def times(self) -> dict[float, float]:
        """The last times [s] at which E1 exceeds fractions of its largest value; one damper only.

        NaN if E1 exceeds it at the end.
        """
        return dict(zip(SHARES, self._only().last.tolist(), strict=True))

    @property
    def dissipated(self) -> dict[str, float]:
        """The fractions of the supplied energy dissipated by dashpots and contacts; one damper."""
        return shares_of(self._only())

    def _only(self) -> Any:
        first, *others = self.results
        if others:
            raise RequestError(f"name the damper: [{first!r}], of {[*self.results]}")
        return self.results[first]

    def comparison(self) -> list[Peak]:
        """Return the largest responses that an engineer compares, for each damper.

        Returns
        -------
        list of Peak
            Displacement (drift), absolute acceleration, stroke, contact force or impulse, and base
            shear of each damper that has them, with the reduction against the system without one.
            The contact force of a host's rigid walls is infinite, and so is the acceleration where
            their impulses act.
        """
        alone, names = next((s.name for s in self.request.systems if is_alone(s)), None), PEAKS
        if self.request.has_hosts:
            numbers = next(iter(self.results.values())).numbers
            names = tuple(name for name in numbers if name.rpartition(".")[2] in HOST_PEAKS)
        peaks = []
        for name in names:
            base = self.results[alone].numbers[name] if alone else math.nan
            for damper, history in self.results.items():
                value, reduction = history.numbers[name], math.nan
                if 0.0 < base < math.inf and damper != alone and np.isfinite(value):
                    reduction = 1.0 - value / base
                if not np.isnan(value):
                    peaks.append(Peak(damper, name, value, of_load(name).unit, reduction))
        return peaks

    def csv_rows(self) -> list[Any]:
        """Return the `comparison` under the names of its columns."""
        return [Peak._fields, *self.comparison()]

    def _table(self) -> Iterator[str]:
        cells: dict[str, dict[str, str]] = {system.name: {} for system in self.request.systems}
        for peak in self.comparison():
            change = f" ({-peak.reduction:+.1%})" if np.isfinite(peak.reduction) else ""
            cells[peak.damper][peak.quantity] = f"{peak.value:.4g}{change}"
        names = list(dict.fromkeys(peak.quantity for peak in self.comparison()))
        heads = [f"{name} [{of_load(name).unit}]" for name in names]
        rows = [["", *heads]]
        rows += [[damper, *(row.get(name, "-") for name in names)] for damper, row in cells.items()]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for first, *others in rows:
            right = (cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True))
            yield "  ".join([first.ljust(widths[0]), *right])
        systems = () if self.request.has_hosts else self.request.systems
        laws = [law for system in systems for law in system.scene.laws]
        if instant := next((law.name for law in laws if law.instant), None):
            yield (
                f"-: under law {instant} a contact has an impulse and no force, and a1_max does "
                "not exist: law linear or hertz gives both"
            )

    def lines(self) -> Iterator[str]:
        """Yield the title, the records, a line for each damper, and of several the comparison."""
        yield self.request.title
        yield from self.request.load.records_in_words(self.request.duration)
        frame = " relative to the ground" if self.request.load.shaken else ""
        for system, history in zip(self.request.systems, self.results.values(), strict=True):
            damper = system.in_words()
            if history.status != OK:
                status = STATUS[history.status]
                yield f"{damper}: {status.name}. {status.remedy}"
                continue
            if history.numbers["E1max"] == 0.0:
                yield f"{damper}: at rest for {self.request.duration:g} s"
                continue
            last = ", ".join(
                f"{share:.0%} " + (f"until {time:.4g} s" if np.isfinite(time) else "to the end")
                for share, time in zip(SHARES[::-1], history.last[::-1], strict=True)
            )
            if self.request.has_hosts:
                counts = ((n.rpartition("."), c) for n, c in history.numbers.items())
                struck = [
                    f"{c:.0f} of {n[0]}" for n, c in counts if n[2] == "impact_count" if c >= 0
                ]
                impacts = f"; impacts: {', '.join(struck)}" if struck else ""
                yield f"{damper}: E1 above {last}{impacts}"
                continue
            sinks = ", ".join(f"{sink} {share:.1%}" for sink, share in shares_of(history).items())
            most = f"x1{frame} up to {history.numbers['x1_max']:.4g} m"
            yield f"{damper}: {most}; E1 above {last}; dissipated by {sinks}"
            exact = (
                {} if self.request.state else closed_form(without_hosts(system), self.request.load)
            )
            words = [
                f"{name} {exact[name]:.6g} (here {history.numbers[name]:.6g})"
                for name in ("E1max", "x1_max", "x1_rms", "share_c1", "share_c2")
                if name in exact
            ]
            if "E1max" in exact:
                some = slice(None, None, 1 + history.time.size // 500)
                energy = energy_after_blow(
                    without_hosts(system), self.request.load, history.time[some]
                )
                error = abs(history.E1[some] - energy).max() / exact["E1max"]
                words.append(f"E1 over time (here but for {error:.0e} of E1max)")
            if words:
                yield f"  in closed form: {', '.join(words)}"
        if len(self.results) > 1 and self.failed < len(self.results):
            yield from self._table()


@dataclass(frozen=True, repr=False)
class LoadScan(Drawable):
    """Quantities of the response with each damper over parameters and numbers of the load.

    Attributes
    ----------
    path : ArchivePath
        Archive of the results.
    request : HistoryRequest
        Request that computes them again; its `vary` has the axes.
    numbers : mapping of str to ndarray
        Quantities by name, each with a dimension for the dampers and one for each axis;
        `scan["x1_max"]` is one of them.
    status : ndarray of int
        Of the same shape; 0 unless the orbit failed.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> blows = {"impulse": {"values": [100.0, 200.0]}}
    >>> scan = nv.response_history("tmd", vary=blows, duration=2.0, quiet=True)
    >>> scan["x1_max"].round(4).tolist()
    [[0.0147, 0.0294]]
    """

    drawn_by = "nlds_vines.loads.picture"

    path: ArchivePath
    request: HistoryRequest
    numbers: Mapping[str, np.ndarray]
    status: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a quantity of all orbits by its name."""
        return self.numbers[choice("number", name, self.numbers)]

    @property
    def failed(self) -> int:
        """The number of orbits that failed."""
        return int(np.count_nonzero(self.status != OK))

    def lines(self) -> Iterator[str]:
        """Yield the title, records, axes, the range of the first number, and failures."""
        yield self.request.title
        yield from self.request.load.records_in_words(self.request.duration)
        yield from (axis.heading() for axis in self.request.vary)
        for name, values in list(self.numbers.items())[:1]:
            for system, row in zip(self.request.systems, values, strict=True):
                finite = row[np.isfinite(row)]
                span = f"{finite.min():.4g} to {finite.max():.4g}" if finite.size else "none"
                orbits = f"{finite.size} of {row.size} orbits"
                yield f"{system.in_words()}: {name} from {span} in {orbits}"
        codes, counts = np.unique(self.status[self.status != OK], return_counts=True)
        for code, count in zip(codes.tolist(), counts.tolist(), strict=True):
            status = STATUS[code]
            yield f"{count} of {self.status.size} orbits: {status.name}. {status.remedy}"


def is_alone(system: Any) -> bool:
    """Return True for a structure or a host without a damper."""
    return not (system.dampers if isinstance(system, General) else system.scene.damper)


def shares_of(history: History) -> dict[str, float]:
    """Return the fractions of the supplied energy that each existing sink dissipated."""
    shares = {sink: history.numbers.get(f"share_{sink}", math.nan) for sink in WAYS}
    return {sink: share for sink, share in shares.items() if np.isfinite(share)}


def histories_in(path: str | os.PathLike[str]) -> ResponseHistories | LoadScan:
    with read(path) as view:
        request = view.request(RESPONSE_HISTORY, load_response_history)
        place, codes, names = ArchivePath.of(view.path), view["status"], names_of_numbers(request)
        values = {
            name: view[dataset] if i is None else view[dataset][..., i]
            for name, (dataset, i) in names.items()
            if dataset in view
        }
        if request.vary:
            return LoadScan(place, request, values, codes)
        results: dict[str, ResponseHistory | HostHistory] = {}
        for i, system in enumerate(request.systems):
            of_system = {
                name: float(values[name][i]) if name in values else math.nan for name in names
            }
            shared: dict[str, Any] = {
                "time": request.times,
                "numbers": of_system,
                "status": int(codes[i]),
            }
            if request.has_hosts:
                results[system.name] = HostHistory(**shared, **_of_host(view, request, i))
                continue
            missing = np.full(len(request.times), np.nan)
            rows: dict[str, Any] = {
                name: view[name][i] if name in view else missing for name in HISTORIES
            }
            dissipated = {sink: rows.pop(f"dissipated_{sink}") for sink in WAYS}
            results[system.name] = ResponseHistory(**shared, **rows, dissipated=dissipated)
        return ResponseHistories(place, request, results)


def _of_host(view: ArchiveView, request: HistoryRequest, number: int) -> dict[str, Any]:
    """Return the histories and the impacts of a host by its number in the request."""
    owners, columns = owners_of(request), dict[str, Any]()
    for name, (dims, *_) in HOST_HISTORIES.items():
        shape = [len(owners[dim]) for dim in dims]
        missing = np.full((*shape, len(request.times)), np.nan)
        rows = view[name][number] if name in view else missing
        columns[name] = dict(zip(owners[dims[0]], rows, strict=True)) if dims else rows
    touches = dict.fromkeys(IMPACT_COLUMNS, np.zeros(0))
    if "impact_system" in view:
        own = view["impact_system"] == number
        for name in IMPACT_COLUMNS:
            if f"impact_{name}" in view:
                touches[name] = view[f"impact_{name}"][own]
            else:  # impulses, in archives of earlier versions
                touches[name] = np.full(np.count_nonzero(own), np.nan)
    touches["damper"] = np.array(owners["damper"], dtype=str)[touches["damper"].astype(int)]
    touches["wall"] = np.where(touches["wall"] > 0.0, "+", "-")
    return {**columns, "impacts": touches}


def closed_form(system: Preset, load: Loading) -> dict[str, float]:
    """Return quantities of `OF_LOADS` in closed form by name; none with walls or other loads.

    After a blow at t = 0 on a structure at rest, E1max = I^2 / (2 m1) is the energy supplied.  The
    share that a dashpot dissipates is z0^T P z0 / E1max with A^T P + P A = -Q (Lyapunov), where
    z^T Q z is the power of the dashpot.  Without a damper, the largest displacement is
    v0 / w exp(-z arccos(z) / sqrt(1 - z^2)), where z is the damping ratio.

    Under noise, the stationary rms of x1 is sqrt(sum of rms^2 / N |H(i omega_i)|^2) over its tones.

    Source: A. Preumont, Random Vibration and Spectral Analysis (1994).
    """
    size = 4 if system.scene.damper else 2
    A, (m1, k1, c1) = flow_matrix(system)[:size, :size], system.structure
    if system.scene.walls or load.harmonic or np.linalg.eigvals(A).real.max() >= 0.0:
        return {}
    blows, parts = load.blows, load.parts
    if parts and not blows and len(parts) == len(load.noise):
        push, square = np.zeros(len(A)), 0.0
        if load.shaken:
            push[1::2] = -1.0
        else:
            push[1] = 1.0 / m1
        for noise in load.noise:
            rates = 1j * noise.omegas[:, np.newaxis, np.newaxis] * np.eye(len(A)) - A
            x1 = np.linalg.inv(rates)[:, 0] @ push
            size_of_tones = (noise.rms * noise.factor * load.scale) ** 2 / noise.tones
            square += size_of_tones * float(np.sum(np.abs(x1) ** 2))
        return {"x1_rms": math.sqrt(square)}
    if parts or len(blows) != 1 or blows[0][0] != 0.0:
        return {}
    from scipy.linalg import solve_continuous_lyapunov

    speed = blows[0][1] / m1
    energy, start = 0.5 * m1 * speed**2, np.zeros(len(A))
    start[1] = speed
    rates = {"c1": (c1, np.array([0.0, 1.0, 0.0, 0.0]))}
    if system.scene.damper:
        rates["c2"] = (system.parameters["c2"], np.array([0.0, 1.0, 0.0, -1.0]))
    quantities = {"E1max": energy, "energy_in": energy}
    for dashpot, (c, relative) in rates.items():
        Q = c * np.outer(relative[: len(A)], relative[: len(A)])
        P = solve_continuous_lyapunov(A.T, -Q)
        quantities[f"share_{dashpot}"] = float(start @ P @ start) / energy
    zeta = c1 / (2.0 * math.sqrt(k1 * m1))
    if not system.scene.damper and zeta < 1.0:
        decay = math.exp(-zeta * math.acos(zeta) / math.sqrt(1.0 - zeta**2))
        quantities["x1_max"] = abs(speed) / math.sqrt(k1 / m1) * decay
    return quantities


def energy_after_blow(system: Preset, load: Loading, times: np.ndarray) -> np.ndarray:
    """Return E1 [J] at `times` (n,) [s] after a blow on a structure without walls: exp(A t) z0."""
    from scipy.linalg import expm

    m1, k1, _ = system.structure
    size = 4 if system.scene.damper else 2
    flows = expm(times[:, np.newaxis, np.newaxis] * flow_matrix(system)[:size, :size])
    x1, v1 = load.blows[0][1] / system.structure[0] * flows[:, :2, 1].T
    return 0.5 * (m1 * v1**2 + k1 * x1**2)
