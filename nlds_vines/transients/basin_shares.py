"""The basins of attraction in a scan's archive, measured: shares, entropies, distances.

In Python: `nlds_vines.basin_measures(archive)`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.bifurcation.datasets import begins_at_sections
from nlds_vines.bifurcation.result import scan_of
from nlds_vines.errors import RequestError, number, unknown
from nlds_vines.model.parameters import INITIAL, component_of, described
from nlds_vines.model.representation import Outlined, Rows
from nlds_vines.orbits.records import ATTRACTOR
from nlds_vines.transients.basin_measures import (
    BOX,
    FRACTAL,
    BasinEntropy,
    Uncertainty,
    basin_entropy,
    uncertainty_exponent,
)
from nlds_vines.transients.survival import LEVEL, share_interval

_ERRORS = 3.0  # standard errors by which an exponent differs from that of a smooth boundary

if TYPE_CHECKING:
    from nlds_vines.archives.archive import ArchiveView

IN_PLANE = 1e-6
"""Distance of an attractor's point from a plane, relative to the point, that counts as none."""


@dataclass(frozen=True, repr=False)
class Basin(Outlined):
    """The basin of one attractor.

    Attributes:
        number, label: of the attractor; number -1: all whose attractor is not known.
        count, total: how many of all cells and starts.
        low, high: the ends of Wilson's interval of the share where starts were drawn at random;
            NaN for a lattice, which is no sample.
        nearest: what must be added to the attractor's point, along each axis of the plane, to come
            to the nearest cell of another basin [units of the axes]; empty where the point does
            not lie in the plane.
        distance: its length, each axis divided by its own; NaN where there is none.
    """

    number: int
    label: str
    count: int
    total: int
    low: float
    high: float
    nearest: tuple[float, ...] = ()
    distance: float = float("nan")

    @property
    def share(self) -> float:
        """The share of all cells and starts, from 0 to 1."""
        return self.count / self.total


@dataclass(frozen=True, repr=False)
class Basins(Outlined):
    """The basins at one value of each parameter of a scan.

    Attributes:
        title: of the scan, with these values.
        basins: of each attractor, by its number; last what is not known, if anything is.
        entropy, uncertainty: of a plane; None where the scan has no plane, or one too small.
        attractor, arrival: (cells ..., starts) of the archive.
        axes: the names of the axes of initial conditions.
    """

    title: str
    basins: tuple[Basin, ...]
    entropy: BasinEntropy | None
    uncertainty: Uncertainty | None
    attractor: np.ndarray
    arrival: np.ndarray
    axes: tuple[str, ...]

    def outline(self) -> Rows:
        """Return the measures, one a line."""
        lines = [_in_words(basin, self.axes) for basin in self.basins]
        if self.entropy is not None:
            lines += _of_entropy(self.entropy)
        if self.uncertainty is not None:
            lines.append(_of_exponent(self.uncertainty))
        for line in lines:
            name, _, words = line.partition(": ")
            yield name, words

    def arrived(self, periods: float, attractor: int | None = None) -> float:
        """Return the share of all orbits that are drawn to an attractor after so many periods.

        Arguments: forcing `periods`; the number of the `attractor`, None for any one.
        """
        periods = number("periods", periods)
        there = (self.arrival >= 0) & (self.arrival <= periods)
        if attractor is not None:
            there &= self.attractor == attractor
        return float(np.count_nonzero(there) / there.size)


def basin_measures(
    archive: ArchiveView | str | os.PathLike[str], side: int = BOX, **values: float
) -> Basins:
    """Return the basins of attraction of a scan that recorded `attractor`, measured.

    Arguments:
        archive: open, or its path.
        side: cells along the side of a box, for basin entropies.
        values: of each varied parameter, `omega=7.7`; the nearest one is taken.

    Shares have intervals where starts were drawn at random.  A plane of two initial conditions has
    basin entropies (Daza et al. 2016) and an uncertainty exponent (McDonald et al. 1985), see
    `transients.basin_measures`.  Raises `RequestError` where the archive holds no attractors.
    """
    if isinstance(archive, str | os.PathLike):
        from nlds_vines.archives.archive import read

        with read(archive) as view:
            return basin_measures(view, side, **values)
    _refuse_without(archive)
    where = places_of(archive, values)
    attractor, arrival = (archive.take(name, **where) for name in (ATTRACTOR, "arrival"))
    axes = tuple(name for name in archive.axes if name in INITIAL)
    plane = attractor[..., 0] if len(axes) == 2 else None
    chosen = ", ".join(f"{name} = {archive[name][i]:g}" for name, i in where.items())
    return Basins(
        title=archive.text("title") + (f", {chosen}" if chosen else ""),
        basins=tuple(_basins(archive, attractor, where, axes)),
        entropy=basin_entropy(plane, side)
        if plane is not None and min(plane.shape) >= side
        else None,
        uncertainty=None if plane is None or min(plane.shape) < 32 else uncertainty_exponent(plane),
        attractor=attractor,
        arrival=arrival,
        axes=axes,
    )


def _refuse_without(view: ArchiveView) -> None:
    """Raise `RequestError` for an archive without attractors, or with an incomplete table."""
    if ATTRACTOR not in view:
        raise RequestError(f"{view.path} holds no attractor: scan with --record {ATTRACTOR}")
    names = ("attractor_label", "attractor_point", "attractor_share")
    missing = [name for name in names if name not in view]
    if missing and (view[ATTRACTOR] >= 0).any():
        raise RequestError(f"{view.path} is damaged: it holds attractors, but no {missing[0]}")
    if not missing and view[ATTRACTOR].max() >= view["number"].size:
        raise RequestError(f"{view.path} is damaged: its table lacks attractors of its cells")


def places_of(view: ArchiveView, values: dict[str, float]) -> dict[str, int]:
    """Return the index of the nearest value of each varied parameter."""
    names = [name for name in view.axes if name not in INITIAL]
    for name in values:
        if name not in names:
            raise unknown(f"varied parameter of {view.path}:", name, names)
    missing = [name for name in names if name not in values and view[name].size > 1]
    if missing:
        raise RequestError(
            f"{view.path} varies {', '.join(names)}: {', '.join(missing)} is missing"
        )
    return {
        name: int(np.abs(view[name] - number(name, values.get(name, view[name][0]))).argmin())
        for name in names
    }


def _basins(
    view: ArchiveView, attractor: np.ndarray, where: dict[str, int], axes: tuple[str, ...]
) -> Iterator[Basin]:
    """Yield the basins of all attractors that exist at a value of each parameter."""
    labels = np.array([], object)
    if "attractor_label" in view:
        labels = view.take("attractor_label", **where)
    plane = len(axes) == 2 and begins_at_sections(view)
    total, drawn = attractor.size, attractor.shape[-1] > 1 and not axes
    for k in [*np.flatnonzero([bool(label) for label in labels]).tolist(), -1]:
        count = int(np.count_nonzero(attractor == k))
        if k < 0 and not count:
            continue
        low, high = share_interval(count, total) if drawn else (float("nan"),) * 2
        near = _nearest(view, attractor, where, axes, k) if plane and k >= 0 else None
        label = str(labels[k]) if k >= 0 else "not known"
        yield Basin(k, label, count, total, low, high, *(near or ()))


def _nearest(
    view: ArchiveView, attractor: np.ndarray, where: dict[str, int], axes: tuple[str, ...], k: int
) -> tuple[tuple[float, ...], float] | None:
    """Return the way from an attractor's point to the nearest cell of another basin, and how far.

    None where the point is not in the plane, or no cell is in another basin.
    """
    point = dict(
        zip(view["component"], view.take("attractor_point", number=k, **where), strict=True)
    )
    along = [component_of(name) for name in axes]
    values = [view[name] for name in axes]
    rest = _off_plane(view, along)
    span = max(abs(value) for value in point.values())
    others = [abs(value - rest[name]) for name, value in point.items() if name not in along]
    inside = all(v[0] <= point[n] <= v[-1] for n, v in zip(along, values, strict=True))
    if not inside or max(others, default=0.0) > IN_PLANE * span:
        return None
    rows, columns = np.nonzero((attractor[..., 0] != k) & (attractor[..., 0] >= 0))
    if not rows.size:
        return None
    ways = [v[i] - point[n] for n, v, i in zip(along, values, (rows, columns), strict=True)]
    lengths = [way / np.ptp(v) for way, v in zip(ways, values, strict=True)]
    distances = np.sqrt(lengths[0] * lengths[0] + lengths[1] * lengths[1])
    least = int(distances.argmin())
    return tuple(float(way[least]) for way in ways), float(distances[least])


def _off_plane(view: ArchiveView, along: list[str]) -> dict[str, float]:
    """Return the components of the starts that the axes of a plane do not set."""
    scan = scan_of(view)
    names = scan.system.scene.components
    given = scan.start.state or [scan.system.rest or 0.0 if n == "x2" else 0.0 for n in names]
    return {n: v for n, v in zip(names, given, strict=True) if n not in along}


def _in_words(basin: Basin, axes: tuple[str, ...]) -> str:
    name = f"attractor {basin.number}, {basin.label}" if basin.number >= 0 else basin.label
    text = f"{name}: {basin.share:.4f} ({basin.count} of {basin.total})"
    if np.isfinite(basin.low):
        text += f", {LEVEL:.0%} interval {basin.low:.4f} to {basin.high:.4f}"
    if basin.nearest:
        steps = (
            f"{component_of(axis)} {way:+.3g} {described(axis).unit}"
            for axis, way in zip(axes, basin.nearest, strict=True)
        )
        text += f"; left by {', '.join(steps)} ({basin.distance:.3g} of the plane's sides)"
    return text


def _of_entropy(found: BasinEntropy) -> Iterator[str]:
    yield f"basin entropy: {found.basin:.4f} ({found.boxes} boxes of {found.side} x {found.side})"
    if found.boundary_boxes:
        verdict = "the boundary is fractal" if found.fractal else "this alone decides nothing"
        yield (
            f"boundary entropy: {found.boundary:.4f} ({found.boundary_boxes} boxes; ln 2 = "
            f"{FRACTAL:.4f}): {verdict}"
        )


def _of_exponent(found: Uncertainty) -> str:
    if not np.isfinite(found.exponent):
        return "uncertainty exponent: there is no boundary"
    below = found.exponent + _ERRORS * found.error < 1.0
    verdict = "fractal, as far as these cells tell" if below else "no sign that it is not smooth"
    return (
        f"uncertainty exponent: {found.exponent:.3f} +- {found.error:.3f} (1: smooth; "
        f"{int(found.distances[0])} to {int(found.distances[-1])} cells apart): {verdict}"
    )
