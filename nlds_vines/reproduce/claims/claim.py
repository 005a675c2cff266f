"""A claim, the data that it is checked against, and the verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from pathlib import Path

import numpy as np

from nlds_vines.archives.archive import read
from nlds_vines.model.catalogue import catalogue
from nlds_vines.model.system import System
from nlds_vines.reproduce.request import FigureRequest

CLOSE = 1e-9
"""The largest distance of a frequency on a grid from the one asked for [rad/s]: round-off."""


class Verdict(StrEnum):
    """The possible results of a check."""

    AGREE = "agree"
    DIFFER = "differ"
    OPEN = "cannot be decided"
    NOT_RUN = "not computed"


@dataclass(frozen=True)
class Finding:
    """The result of a check: the verdict, and in one line what was measured."""

    verdict: Verdict
    text: str


class Missing(LookupError):
    """Raised where the data for a check have not been computed."""


@dataclass(frozen=True)
class Data:
    """The results of the first start in an archive.

    Attributes:
        system: of the scan.
        axes: the values of the varied parameters by name.
        numbers: recorded numbers and labels by name, each of the shape of the cells.
    """

    system: System
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


Evidence = Callable[[str, str], Data]
"""Returns the data of a curve by the short name of its request and its own; raises `Missing`."""

Check = Callable[[Evidence], Finding]


@dataclass(frozen=True)
class Claim:
    """One claim of the paper.

    Arguments:
        where: the section, table or equation of the paper.
        statement: the claim in our own words.
        figure: short name of the request whose picture shows it.
        check: measures and decides; raises `Missing` without the data.
        rule: the meaning that a vague word (similar, slight) is given here.
    """

    where: str
    statement: str
    figure: str
    check: Check
    rule: str = ""


def judge(claim: Claim, evidence: Evidence) -> Finding:
    """Return the finding of a claim's check: "not computed" where its data are missing."""
    try:
        return claim.check(evidence)
    except Missing as missing:
        return Finding(Verdict.NOT_RUN, str(missing))


def decided(holds: bool | np.bool_, text: str) -> Finding:
    """Return the finding of a check with a definite result: agree where the claim `holds`."""
    return Finding(Verdict.AGREE if holds else Verdict.DIFFER, text)


def archived(requests: Mapping[str, FigureRequest], folder: Path) -> Evidence:
    """Return the evidence in the archives of a folder.

    Arguments: the requests by short name; the `folder` of their archives.
    """

    @cache
    def of(figure: str, name: str) -> Data:
        request = requests[figure]
        curve = next((curve for curve in request.curves if curve.name == name), None)
        if curve is None:
            raise Missing(f"{request.name} has no curve {name}")
        path = folder / request.archive(curve)
        if not path.exists():
            raise Missing(f"{request.name} has not been computed")
        return _load(path, curve.scan.system)

    return of


def _load(path: Path, system: System) -> Data:
    """Return the data of an archive: everything that has one value for each orbit."""
    with read(path) as view:
        whole = [name for name in view.names if view.dims(name) == (*view.axes, "start")]
        numbers = {name: view.take(name, start=0) for name in whole}
        return Data(system, {name: view[name] for name in view.axes}, numbers)


def tuning_frequency() -> float:
    """Return the frequency for which the dampers were tuned [rad/s]."""
    return catalogue()["ssul-set6"].parameters["omega"]


def spans(omega: np.ndarray, chosen: np.ndarray) -> list[tuple[float, float]]:
    """Return the first and the last frequency of each run of `chosen` cells, both (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    pairs = zip(edges[::2], edges[1::2], strict=True)
    return [(float(omega[first]), float(omega[last - 1])) for first, last in pairs]


def maxima(values: np.ndarray, least: float) -> np.ndarray:
    """Return the indices of the local maxima of at least `least` times the highest value."""
    inner = values[1:-1]
    tops = (inner > values[:-2]) & (inner >= values[2:]) & (inner >= least * values.max())
    return np.flatnonzero(tops) + 1
