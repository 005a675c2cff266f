"""Response histories read from an archive: a result for each damper, or the numbers of a scan.

Beside them stand closed forms, for structures without walls under a blow or noise.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.archive import ArchivePath, ArchiveView, read
from nlds_vines.archives.provenance import RESPONSE_HISTORY
from nlds_vines.archives.representation import Outlined
from nlds_vines.errors import RequestError, choice
from nlds_vines.loads.request import HistoryRequest, load_response_history, struck
from nlds_vines.model.linear_response import flow_matrix
from nlds_vines.model.load_quantities import OF_LOADS, SHARES, WAYS
from nlds_vines.model.loads.courses import Noise
from nlds_vines.model.loads.loading import Loading
from nlds_vines.model.system import System
from nlds_vines.model.words import system_in_words
from nlds_vines.orbits.records import OK, STATUS
from nlds_vines.plotting.drawable import Drawable

HISTORIES = {
    "E1": ("J", "energy of the structure, its velocity relative to the ground"),
    "E2": ("J", "energy of the damper, its velocity relative to the ground"),
    "x1": ("m", "displacement of the structure, relative to the ground"),
    "x2": ("m", "displacement of the damper, relative to the ground"),
    "work": ("J", "energy that came in so far, by the start and by the load"),
}
"""What is told over time, with its unit and its meaning."""


@dataclass(frozen=True, repr=False)
class Fall(Outlined):
    """What becomes of one structure under a load.

    Arrays over `time` (n,) [s]: energies E1, E2 [J], displacements x1, x2 [m], `work`, the energy
    [J] that came in so far, and `dissipated`, what is gone so far, by `WAYS`.  What there is not
    without a damper, or without walls, is NaN.  `numbers`: those of `OF_LOADS`; `status`: how the
    orbit ended, a code of `STATUS`; all else is NaN where it failed.
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

    @property
    def last(self) -> np.ndarray:
        """The last times (3,) [s] at which E1 exceeds `SHARES` of its largest; NaN: it does."""
        return np.array([self.numbers[f"last_{100 * share:g}"] for share in SHARES])


@dataclass(frozen=True, repr=False)
class ResponseHistories(Drawable):
    """What becomes of a structure under a load with each damper.

    Attributes:
        path: of the archive.
        request: with which the same numbers are computed again.
        results: by the names of the systems, in the order of the request.

    Where there is one damper, `times` and `dissipated` are its own; of several, `found["tmd"]`
    gives one.
    """

    drawn_by = "nlds_vines.loads.picture"

    path: ArchivePath
    request: HistoryRequest
    results: Mapping[str, Fall]

    def __getitem__(self, name: str) -> Fall:
        """Return what becomes of the structure with one damper, by the name of the system."""
        return self.results[choice("damper", name, self.results)]

    @property
    def failed(self) -> int:
        """Of how many dampers the orbit could not be followed to its end."""
        return sum(fall.status != OK for fall in self.results.values())

    @property
    def times(self) -> dict[float, float]:
        """The last times [s] at which E1 exceeds shares of its largest; NaN: it still does."""
        return dict(zip(SHARES, self._only().last.tolist(), strict=True))

    @property
    def dissipated(self) -> dict[str, float]:
        """The shares of the energy that came in, which dashpots and contacts have dissipated."""
        return shares_of(self._only())

    def _only(self) -> Fall:
        if len(self.results) > 1:
            raise RequestError(
                f"name the damper: [{next(iter(self.results))!r}], of {[*self.results]}"
            )
        return next(iter(self.results.values()))

    def lines(self) -> Iterator[str]:
        """Yield the title, the records of the load, and a line for each damper."""
        yield self.request.title
        yield from self.request.load.records_in_words(self.request.duration)
        frame = " relative to the ground" if self.request.load.shaken else ""
        for system, fall in zip(self.request.systems, self.results.values(), strict=True):
            if fall.status != OK:
                status = STATUS[fall.status]
                yield f"{system_in_words(system)}: {status.name}. {status.remedy}"
                continue
            if fall.numbers["E1max"] == 0.0:
                yield f"{system_in_words(system)}: at rest for {self.request.duration:g} s"
                continue
            last = ", ".join(
                f"{share:.0%} until {time:.4g} s"
                if np.isfinite(time)
                else f"{share:.0%} to the end"
                for share, time in zip(SHARES[::-1], fall.last[::-1], strict=True)
            )
            went = ", ".join(f"{way} {share:.1%}" for way, share in shares_of(fall).items())
            most = f"x1{frame} up to {fall.numbers['x1_max']:.4g} m"
            yield f"{system_in_words(system)}: {most}; E1 above {last}; dissipated by {went}"
            if exact := _beside(fall, system, self.request):
                yield f"  in closed form: {exact}"


@dataclass(frozen=True, repr=False)
class LoadScan(Drawable):
    """Numbers of each damper over parameters and numbers of the load.

    Attributes:
        path: of the archive.
        request: with which the same numbers are computed again; its `vary` has the axes.
        numbers: by name (`nlds_vines.model.load_quantities`), each (dampers, axes).
        status: (dampers, axes) how each orbit ended, a code of `STATUS`.
    """

    drawn_by = "nlds_vines.loads.picture"

    path: ArchivePath
    request: HistoryRequest
    numbers: Mapping[str, np.ndarray]
    status: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a number of all orbits, by its name."""
        return self.numbers[choice("number", name, self.numbers)]

    @property
    def failed(self) -> int:
        """How many orbits could not be followed to their end."""
        return int(np.count_nonzero(self.status != OK))

    def lines(self) -> Iterator[str]:
        """Yield the title, records, axes, the range of the first number, and failures."""
        yield self.request.title
        yield from self.request.load.records_in_words(self.request.duration)
        yield from (axis.heading() for axis in self.request.vary)
        for name, values in list(self.numbers.items())[:1]:
            for system, of_it in zip(self.request.systems, values, strict=True):
                told = of_it[np.isfinite(of_it)]
                span = f"{told.min():.4g} to {told.max():.4g}" if told.size else "none"
                orbits = f"{told.size} of {of_it.size} orbits"
                yield f"{system_in_words(system)}: {name} from {span} in {orbits}"
        codes, counts = np.unique(self.status[self.status != OK], return_counts=True)
        for code, count in zip(codes.tolist(), counts.tolist(), strict=True):
            status = STATUS[code]
            yield f"{count} of {self.status.size} orbits: {status.name}. {status.remedy}"


def _beside(fall: Fall, system: System, request: HistoryRequest) -> str:
    """Return what has a closed form, in words, with what was computed beside it."""
    exact = {} if request.state else closed_form(system, request.load)
    told = [
        f"{name} {exact[name]:.6g} (here {fall.numbers[name]:.6g})"
        for name in ("E1max", "x1_max", "x1_rms", "share_c1", "share_c2")
        if name in exact
    ]
    if "E1max" in exact:
        some = slice(None, None, 1 + fall.time.size // 500)
        found = energy_after_blow(system, request.load, fall.time[some])
        off = abs(fall.E1[some] - found).max()
        told.append(f"E1 over time (here but for {off / exact['E1max']:.0e} of E1max)")
    return ", ".join(told)


def shares_of(fall: Fall) -> dict[str, float]:
    """Return the shares of the energy that came in, dissipated by the end, of what there is."""
    found = {way: fall.numbers[f"share_{way}"] for way in WAYS}
    return {way: share for way, share in found.items() if np.isfinite(share)}


def histories_in(path: str | os.PathLike[str]) -> ResponseHistories | LoadScan:
    """Return the response history in an archive; `RequestError` for an archive of anything else."""
    with read(path) as view:
        request = view.request(RESPONSE_HISTORY, load_response_history)
        place = ArchivePath.of(view.path)
        if request.vary:
            names = [entry.name for entry in OF_LOADS if entry.name in view]
            return LoadScan(place, request, {name: view[name] for name in names}, view["status"])
        return ResponseHistories(place, request, _falls(view, request))


def _falls(view: ArchiveView, request: HistoryRequest) -> dict[str, Fall]:
    """Return what became of each damper, by its name."""
    codes, time = view["status"], request.times  # an archive without histories has no time

    def values(name: str, *more: int) -> np.ndarray:
        return view[name] if name in view else np.full((len(codes), *more), np.nan)

    numbers = {entry.name: values(entry.name) for entry in OF_LOADS}
    histories = {name: values(name, len(time)) for name in HISTORIES}
    gone = {way: values(f"dissipated_{way}", len(time)) for way in WAYS}
    return {
        system.name: Fall(
            time=time,
            dissipated={way: of_all[i] for way, of_all in gone.items()},
            numbers={name: float(of_all[i]) for name, of_all in numbers.items()},
            status=int(codes[i]),
            **{name: of_all[i] for name, of_all in histories.items()},
        )
        for i, system in enumerate(request.systems)
    }


# ---- closed forms --------------------------------------------------------------------------------


def closed_form(system: System, load: Loading) -> dict[str, float]:
    """Return numbers of `OF_LOADS` by name; none for walls, and for loads that have none here.

    Of a blow at t = 0 on a structure at rest, in the end: E1max = I^2 / (2 m1), the energy that
    came in; the shares that dashpots dissipate, z0^T P z0 with A^T P + P A = -Q (Lyapunov), where
    z^T Q z is what a dashpot dissipates in a second; without a damper the largest displacement,
    v0 / w exp(-z arccos(z) / sqrt(1 - z^2)), z the damping ratio.

    Of noise, in the steady state: the rms of x1, sqrt(sum of rms^2 / N |H(i omega_i)|^2) over its
    tones.

    Source: A. Preumont, Random Vibration and Spectral Analysis (1994).
    """
    size = 4 if system.scene.damper else 2
    A = flow_matrix(system)[:size, :size]
    if system.scene.walls or load.harmonic or np.linalg.eigvals(A).real.max() >= 0.0:
        return {}
    blows, parts = load.blows, load.parts
    if not parts and len(blows) == 1 and blows[0][0] == 0.0:
        return _of_blow(system, A, blows[0][1] / struck(system).mass)
    if parts and not blows and all(isinstance(one, Noise) for one in parts):
        return {"x1_rms": _rms(system, A, load)}
    return {}


def _of_blow(system: System, A: np.ndarray, speed: float) -> dict[str, float]:
    """Return the numbers after a blow that made v1 `speed` [m/s]."""
    m1, k1, c1 = system.structure
    energy, start = 0.5 * m1 * speed**2, np.zeros(len(A))
    start[1] = speed
    rates = {"c1": (c1, np.array([0.0, 1.0, 0.0, 0.0]))}
    if system.scene.damper:
        rates["c2"] = (system.parameters["c2"], np.array([0.0, 1.0, 0.0, -1.0]))
    found = {"E1max": energy, "energy_in": energy}
    unit = np.eye(len(A))
    lyapunov = np.kron(A.T, unit) + np.kron(unit, A.T)
    for way, (c, relative) in rates.items():
        Q = c * np.outer(relative[: len(A)], relative[: len(A)])
        P = np.linalg.solve(lyapunov, -Q.ravel()).reshape(Q.shape)
        found[f"share_{way}"] = float(start @ P @ start) / energy
    zeta = c1 / (2.0 * math.sqrt(k1 * m1))
    if not system.scene.damper and zeta < 1.0:
        shrunk = math.exp(-zeta * math.acos(zeta) / math.sqrt(1.0 - zeta**2))
        found["x1_max"] = abs(speed) / math.sqrt(k1 / m1) * shrunk
    return found


def energy_after_blow(system: System, load: Loading, times: np.ndarray) -> np.ndarray:
    """Return E1 [J] at times [s] where `closed_form` has the E1max of a blow: z = exp(A t) z0."""
    from scipy.linalg import expm

    m1, k1, _ = system.structure
    size = 4 if system.scene.damper else 2
    flows = expm(times[:, np.newaxis, np.newaxis] * flow_matrix(system)[:size, :size])
    x1, v1 = load.blows[0][1] / struck(system).mass * flows[:, :2, 1].T
    return 0.5 * (m1 * v1**2 + k1 * x1**2)


def _rms(system: System, A: np.ndarray, load: Loading) -> float:
    """Return the rms of x1 [m] in the steady state under noise."""
    push = np.zeros(len(A))
    if load.shaken:
        push[1::2] = -1.0
    else:
        push[1] = 1.0 / struck(system).mass
    square, unit = 0.0, np.eye(len(A))
    for noise in load.noise:
        assert isinstance(noise, Noise)
        size = noise.rms * noise.factor * load.scale
        rates = 1j * noise.omegas[:, np.newaxis, np.newaxis] * unit - A
        x1 = np.linalg.inv(rates)[:, 0] @ push
        square += size**2 / noise.tones * float(np.sum(np.abs(x1) ** 2))
    return math.sqrt(square)
