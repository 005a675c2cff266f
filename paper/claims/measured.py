"""What claims are checked against: the data of scans in archives, and orbits in full."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.request import Scan
from nlds_vines.model.catalog import without_hosts
from nlds_vines.model.labels import is_struck
from nlds_vines.model.system import Preset
from paper.request import FigureRequest

CLOSE = 1e-9
"""The largest distance of a frequency on a grid from the one asked for [rad/s]: round-off."""


class Missing(LookupError):
    """Raised where the data for a check have not been computed."""


@dataclass(frozen=True)
class Data:
    """The results of the first start in an archive.

    Attributes:
        system: of the scan.
        axes: the values of the varied parameters by name.
        numbers: recorded numbers and labels by name, each of the shape of the cells;
            those by wall have one more dimension, what is struck.
    """

    system: Preset
    axes: Mapping[str, np.ndarray]
    numbers: Mapping[str, np.ndarray]

    @property
    def omega(self) -> np.ndarray:
        """The frequencies of the force [rad/s], shape (n,)."""
        return self.axes["omega"]

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the values of a recorded number; raise `Missing` if it was not recorded."""
        if name not in self.numbers:
            raise Missing(f"{self.system.name}: {name} was not recorded")
        return self.numbers[name]

    @property
    def is_struck(self) -> np.ndarray:
        """Whether there are impacts, in each cell; of a periodic orbit, on its cycle."""
        names = "periodicity", "impact_count", "impact_rate"
        return is_struck({name: self[name] for name in names})

    def peak(self, name: str = "E1max") -> tuple[float, float]:
        """Return the largest value along the frequency, and the frequency where it is."""
        place = int(np.nanargmax(self[name]))
        return float(self[name][place]), float(self.omega[place])

    def at(self, omega: float, name: str = "E1max") -> float:
        """Return the value at a frequency; raise `Missing` if the grid does not have it."""
        return float(self[name][self.place(omega)])

    def place(self, omega: float) -> int:
        """Return the index of a frequency; raise `Missing` if the grid does not have it."""
        place = int(np.argmin(np.abs(self.omega - omega)))
        if abs(self.omega[place] - omega) > CLOSE:
            raise Missing(f"{omega:g} rad/s is not on the grid")
        return place

    def column(self, index: int) -> Data:
        """Return the data along the first axis at one place of the second."""
        first, second = self.axes
        changed = self.system.with_(**{second: float(self.axes[second][index])})
        numbers = {name: values[:, index] for name, values in self.numbers.items()}
        return Data(changed, {first: self.axes[first]}, numbers)


POWER = 0.99
"""The share of the power of a spectrum that is meant by most of it."""


class Breadth(NamedTuple):
    """How broad a spectrum is: the share of its power beside the lines of an nT orbit, for n =
    `comb`; the fewest bins that hold most of its power, and those in a window half as long."""

    comb: int
    share: float
    bins: int
    bins_of_half: int


@dataclass(frozen=True)
class Motion:
    """What was found in one window of an orbit.

    Attributes:
        system: that was followed.
        label: nT,k by recurrence; empty where no period was found.
        forces, durations: of the impacts of the last cycle, or of all if there is no period:
            their largest contact forces [N], and how long they last [s].
        section: the states at the whole forcing periods, shape (periods, 4).
        least, greatest: of x2 - x1 from where the spring rests [m]; an impact makes it least.
        breadths: of the spectra of x2 and of the contact `force`, by name.
    """

    system: Preset
    label: str
    forces: np.ndarray
    durations: np.ndarray
    section: np.ndarray
    least: float
    greatest: float
    breadths: Mapping[str, Breadth]


Follow = Callable[[FigureRequest], Sequence[Motion]]
"""Returns the motions in the columns of a portrait; raises `Missing` without one."""


class Evidence(Protocol):
    """What was computed for the requests; raises `Missing` for everything else."""

    def __call__(self, figure: str, name: str = "") -> Data:
        """Return the data of a curve by the short name of its request and its own.

        The curve of a diagram or map is the only one, and needs no name.
        """

    def motions(self, figure: str) -> Sequence[Motion]:
        """Return the motions in the columns of a portrait, by the short name of its request."""


def not_followed(request: FigureRequest) -> Sequence[Motion]:
    """Raise `Missing`: nothing is known of the orbits of a portrait."""
    raise Missing(f"{request.name} has not been computed")


def archived(
    requests: Mapping[str, FigureRequest], folder: Path, follow: Follow = not_followed
) -> Evidence:
    """Return the evidence in the archives of a folder.

    Arguments: the requests by short name; the `folder` of their archives; `follow` returns the
    motions of a portrait.
    """
    return _Archived(requests, folder, follow)


class _Archived:
    """Evidence in archives; what was read once is kept."""

    def __init__(self, requests: Mapping[str, FigureRequest], folder: Path, follow: Follow) -> None:
        self._requests, self._folder, self._follow = requests, folder, follow
        self._data, self._motions = cache(self._read), cache(self._of_portrait)

    def __call__(self, figure: str, name: str = "") -> Data:
        return self._data(figure, name)

    def motions(self, figure: str) -> Sequence[Motion]:
        return self._motions(figure)

    def _read(self, figure: str, name: str) -> Data:
        request = self._requests[figure]
        scan = scan_of(request, name)
        path = self._folder / request.archive
        if not path.exists():
            raise Missing(f"{request.name} has not been computed")
        return _load(path, request, scan)

    def _of_portrait(self, figure: str) -> Sequence[Motion]:
        return self._follow(self._requests[figure])


def scan_of(request: FigureRequest, name: str) -> Scan:
    """Return the scan of the case of that name, or the only one; raise `Missing` without one."""
    if not name and isinstance(request.computed, Scan):
        return request.computed
    if name not in request.scans:
        raise Missing(f"{request.name} has no curve {name}")
    return request.scans[name]


def _load(path: Path, request: FigureRequest, scan: Scan) -> Data:
    """Return the data of a scan in an archive: what has one value for each orbit, or wall."""
    axes = {axis.name: axis.values for axis in scan.axes}
    is_scan = isinstance(request.computed, Scan)
    cells = (*axes, "start") if is_scan else ("system", *axes, "start")
    case = () if is_scan else (list(request.scans.values()).index(scan),)
    with read(path) as view:
        whole = [name for name in view.names if view.dims(name) in (cells, (*cells, "wall"))]
        numbers = {name: view[name][case][(slice(None),) * len(axes) + (0,)] for name in whole}
    return Data(without_hosts(scan.system), axes, numbers)
