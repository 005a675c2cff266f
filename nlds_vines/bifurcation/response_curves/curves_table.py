"""The datasets of an archive of response curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves.request import SHOWN, CurvePage, alone, label_of
from nlds_vines.model.labels import FLAGS
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.orbits.status_words import STATUS_FLAGS

Content = tuple[Dataset, np.ndarray]
"""A dataset's description and its values."""

_RESPONSE = tuple(name for name in SHOWN if "response" in BY_NAME[name].record)

ARRAYS = (
    "status",
    "E1max",
    "E2max",
    "reduction",
    "impact_count",
    "periodicity",
    "regime",
    *_RESPONSE,
)
"""The datasets along a curve."""

DOWN = "_down"
ENDINGS = ("", DOWN)
STATUSES = ("status", "status" + DOWN)
"""The endings of the names of those of the first start, and of the second: the sweep down."""


def scales_of(page: CurvePage) -> list[Scale]:
    """Return the dimensions of the archive: the curves, and the parameter along them."""
    return [
        Scale.counted("curve", len(page.curves), "curve, panel by panel"),
        PARAMETERS[page.axis].scale(page.values),
    ]


def contents(page: CurvePage, found: Sequence[Mapping[str, np.ndarray]]) -> list[Content]:
    """Return the datasets of the archive with their values.

    Arguments: the page; the arrays (n,) of `ARRAYS` of every curve, by name; those that a system
    lacks are absent.
    """
    return [*_along(page, found), *_peaks(page, found), *_systems(page)]


def _along(page: CurvePage, found: Sequence[Mapping[str, np.ndarray]]) -> list[Content]:
    """Return the datasets along the curves; cells that a system lacks keep the fill value."""
    dims = ("curve", page.axis)
    table = [
        Dataset.code("status", dims, "how an orbit ended", STATUS_FLAGS),
        *(_recorded(name, dims, page) for name in ("E1max", "E2max", "reduction")),
        Dataset.whole("impact_count", dims, "impacts per nT; -1: not recorded", -1),
        Dataset.whole("periodicity", dims, BY_NAME["periodicity"].words),
        Dataset.code("regime", dims, "kind of the steady state", FLAGS),
        *(_recorded(name, dims, page) for name in _RESPONSE),
    ]
    swept = [
        replace(entry, name=entry.name + DOWN, long_name=f"{entry.long_name}; of the sweep down")
        for entry in table
    ]
    return [
        (entry, np.array([_filled(arrays, entry, page.values.size) for arrays in found]))
        for entry in (*table, *swept)
        if any(entry.name in arrays for arrays in found)
    ]


def _recorded(name: str, dims: tuple[str, ...], page: CurvePage) -> Dataset:
    """Return the dataset of what scans record as well; of two walls, the larger."""
    scenes = [curve.scan.system.scene for curve in page.curves]
    scene = next((scene for scene in scenes if scene.damper), scenes[0])
    found = BY_NAME[name].dataset(dims, scene)
    larger = "; of two walls the larger" if BY_NAME[name].dims else ""
    return replace(found, long_name=found.long_name + larger)


def _filled(arrays: Mapping[str, np.ndarray], entry: Dataset, size: int) -> np.ndarray:
    return arrays[entry.name] if entry.name in arrays else np.full(size, entry.fill)


def _peaks(page: CurvePage, found: Sequence[Mapping[str, np.ndarray]]) -> list[Content]:
    """Return the highest value of every curve, where it lies, and the reduction of that."""
    heights, places = np.array([_peak(_highest(arrays), page.values) for arrays in found]).T
    by_hash = {curve.scan.hash: height for curve, height in zip(page.curves, heights, strict=True)}
    bare = np.array([by_hash.get(_hash_alone(curve.scan), np.nan) for curve in page.curves])
    dims, entry = ("curve",), PARAMETERS[page.axis]
    with np.errstate(all="ignore"):
        reduction = 1.0 - heights / bare
    text = "reduction of the peak, 1 - peak / peak of the structure alone"
    return [
        (Dataset.real("peak", dims, "J", "highest E1max of the curve"), heights),
        (Dataset.real("peak_at", dims, entry.unit, f"{entry.meaning} there"), places),
        (Dataset.real("peak_reduction", dims, "1", text), reduction),
    ]


def _highest(arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the largest energies of a curve, of two sweeps the higher."""
    return np.fmax(arrays["E1max"], arrays.get("E1max" + DOWN, np.nan))


def _hash_alone(scan: Scan) -> str:
    """Return the hash of the scan of the structure alone; "" where there is none."""
    found = alone(scan)
    return "" if found is None else found.hash


def _peak(energy: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Return the highest of the energies [J] and its place; NaN where there is none."""
    if not np.isfinite(energy).any():
        return np.nan, np.nan
    place = int(np.nanargmax(energy))
    return float(energy[place]), float(values[place])


def _systems(page: CurvePage) -> list[Content]:
    """Return what tells the curves apart: panel, label, system, and every parameter that is fixed.

    A parameter that a system does not have is NaN.
    """
    dims, curves = ("curve",), page.curves
    texts = {
        "system": ("name of the system", [curve.scan.system.name for curve in curves]),
        "kind": ("kind of damper", [curve.scan.system.kind for curve in curves]),
        "label": ("label of the curve", [label_of(curve) for curve in curves]),
    }
    found: list[Content] = [
        (Dataset.text(name, dims, text), np.array(values, dtype=object))
        for name, (text, values) in texts.items()
    ]
    panels = np.array([i for i, _ in page.places], dtype=np.int32)
    found.append((Dataset.whole("panel", dims, "panel of the page, from 0"), panels))
    names = [
        name
        for name in PARAMETERS
        if name != page.axis and any(name in curve.scan.system.parameters for curve in curves)
    ]
    for name in names:
        values = np.array([c.scan.system.parameters.get(name, np.nan) for c in curves])
        found.append((PARAMETERS[name].dataset(dims), values))
    return found
