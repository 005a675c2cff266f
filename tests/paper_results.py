"""Invented results that agree with the paper, others that contradict it, and their archives."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from support import unfilled

from nlds_vines.bifurcation.parts import Block, Parts
from nlds_vines.bifurcation.request import Scan
from nlds_vines.model.linear_response import response
from nlds_vines.model.system import System
from nlds_vines.reproduce.claims import Data, Missing
from nlds_vines.reproduce.claims.claim import Evidence
from nlds_vines.reproduce.request import FigureRequest
from nlds_vines.reproduce.request_file import packaged_figures

PATTERN = ((2, 2), (3, 2), (4, 2), (1, 0), (2, 1), (0, 5))  # above T,1
SPECIAL = {7.375: (3, 3), 7.4: (0, 90), 7.575: (1, 0)}
WORDS = {7.4: "chaos", 7.575: "transient chaos to T,0"}
TUNED_K1 = 3.95e4  # N/m, stiffness of the structure at the tuning


@cache
def requests() -> dict[str, FigureRequest]:
    return packaged_figures()


def bell(omega, height, centre, width=0.25):
    return height * np.exp(-(((omega - centre) / width) ** 2))


def published(system: System, omega: np.ndarray) -> np.ndarray:
    """Return E1max as the paper has it: linear systems exactly, the others as sums of bells."""
    p = system.parameters
    if not system.scene.walls:
        return response(system, omega).E1max
    softer = 1 + 4 * max(0.0, 1 - p["k1"] / TUNED_K1)
    force = (p["P"] / 800) ** 2 * (452 / p["c1"]) ** 1.2 * softer
    if system.kind == "ssbl":
        return force**0.9 * (bell(omega, 600, 6.3) + 20)
    if p["k2"] == 215:
        return force * bell(omega, 670, 6.2)
    low = 437 if abs(p["k2"] - 669) < 1 else 480
    high = 34.0 if omega.size == 1201 else 30.0
    linear = response(system, omega).E1max
    tail = np.where(omega > 7.45, linear, high)
    return force * (bell(omega, low, 5.69) + bell(omega, 239, 6.98)) * (omega <= 7.45) + tail


def motion(system: System, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return period, impacts and label as the paper has them."""
    index = np.arange(omega.size)
    n, k = np.array([PATTERN[i % 6] for i in index]).T
    calm = (omega < 7.36) if system.kind == "ssul" else np.zeros(omega.size, bool)
    n, k = np.where(calm, 1, n), np.where(calm, 1, k)
    free = ~response(system, omega).clears & (k == 0)
    k = np.where(free, 1, k)
    label = np.array(
        [f"{a}T,{b}" if a else "undetermined" for a, b in zip(n, k, strict=True)], object
    )
    for place, (a, b) in SPECIAL.items():
        here = np.abs(omega - place) < 1e-9
        n, k = np.where(here, a, n), np.where(here, b, k)
        label[here] = WORDS.get(place, "3T,3")
    return n, k, label


def without_impacts(system: System, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return motion without any impact, everywhere."""
    return np.ones(omega.size, int), np.zeros(omega.size, int), np.full(omega.size, "T,0", object)


def without_period(system: System, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return motion without a period, everywhere."""
    none = np.zeros(omega.size, int)
    return none, none + 7, np.full(omega.size, "6T,7", object)


def made_up(
    energy: Callable[[System, np.ndarray], Any] = published,
    regimes: Callable[[System, np.ndarray], tuple[np.ndarray, ...]] = motion,
    damper: float = 1.3,
    **changed: float,
) -> Evidence:
    """Return evidence with invented results.

    Arguments: `energy` returns E1max [J] and `regimes` period, impacts and label of a system by
    frequency; `damper`, the damper's energy over the structure's; parameters with other values.
    """

    @cache
    def of(figure: str, name: str) -> Data:
        curve = next((c for c in requests()[figure].curves if c.name == name), None)
        if curve is None:
            raise Missing(name)
        own = {key: value for key, value in changed.items() if key in curve.scan.system.parameters}
        return data_of(curve.scan, curve.scan.system.with_(**own), energy, regimes, damper)

    return of


def data_of(scan: Scan, system: System, energy: Any, regimes: Any, damper: float) -> Data:
    """Return invented data of a scan, the same along a second axis."""
    axes = {axis.name: axis.values for axis in scan.axes}
    omega = axes["omega"]
    E1 = energy(system, omega) + np.zeros(omega.size)
    n, k, label = regimes(system, omega)
    share = damper if system.kind == "ssul" else 0.2
    numbers = {"E1max": E1, "E2max": share * E1, "period": n, "impacts": k, "label": label}
    for name, values in numbers.items():
        if len(axes) == 2:
            numbers[name] = np.repeat(values[:, np.newaxis], scan.shape[1], axis=1)
    return Data(system, axes, numbers)


def write_archive(path: Path, scan: Scan, numbers: dict[str, np.ndarray]) -> Path:
    """Write an archive of a scan that holds these numbers for its one start."""
    found = unfilled(scan)
    for name, array in found.items():
        if name in numbers:
            array[...] = numbers[name][..., np.newaxis]
        elif name == "status":
            array[...] = 0
    block = Block(0, tuple((0, size) for size in scan.shape))
    with Parts.open(path, scan) as parts:
        parts.write(block, found)
        return parts.consolidate([block], {})
