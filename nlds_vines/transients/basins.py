"""The basins of attraction in a scan's archive, measured: shares, entropies, distances.

Basin entropies and the uncertainty exponent take planes of plain whole numbers, one for each cell:
the number of its attractor, -1 where it is not known.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.bifurcation.request import begins_at_sections
from nlds_vines.bifurcation.result import nearest_place, scan_of
from nlds_vines.engine.records import ATTRACTOR
from nlds_vines.errors import RequestError, number, whole
from nlds_vines.model.parameters import DESCRIBED, INITIAL, component_of
from nlds_vines.transients.ensemble import LEVEL, share_interval

BOX = 20  # cells along a box's side: 400 orbits tell its shares well (Daza et al. 2016)

FRACTAL = float(np.log(2.0))
"""A boundary entropy above ln 2 shows a fractal boundary: a smooth one parts two basins in a box
almost everywhere, and two basins have no more (Daza et al. 2016, eq. 9)."""

PARTS = 4  # parts of each side of the plane; the squares are left out in turn for an error
ERRORS = 3.0  # standard errors by which the exponent of a fractal boundary is less than one
SIDE = 32  # cells along the shorter side of a plane that has an uncertainty exponent, at least
IN_PLANE = 1e-6  # distance of an attractor's point from a plane, relative to the point


# ---- planes --------------------------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class BasinEntropy(Outlined):
    """Basin entropies of a plane [nats], after Daza et al., Sci. Rep. 6, 31416 (2016)."""

    basin: float  # S_b, the mean of -sum p ln p over all boxes, p the attractors' shares in one
    boundary: float  # S_bb, the mean over boxes with more than one attractor; NaN without any
    boxes: int
    boundary_boxes: int
    side: int  # cells along the side of a box

    @property
    def fractal(self) -> bool:
        """True if the boundary is certainly fractal; False if it may be smooth or fractal."""
        return self.boundary > FRACTAL

    def outline(self) -> Rows:
        yield "basin entropy", f"{self.basin:.4f} ({self.boxes} boxes of {self.side} x {self.side})"
        if self.boundary_boxes:
            verdict = "fractal" if self.fractal else "smooth or fractal"
            words = f"{self.boundary_boxes} boxes; ln 2 = {FRACTAL:.4f}): {verdict}"
            yield "boundary entropy", f"{self.boundary:.4f} ({words}"


@dataclass(frozen=True, repr=False)
class Uncertainty(Outlined):
    """The exponent a of f ~ d^a, f the share of uncertain pairs of starts a distance d apart.

    A smooth boundary of a plane has a = 1; a fractal one has a = 2 - D with its box dimension D.
    """

    exponent: float
    error: float  # jackknife standard error over parts of the plane
    distances: np.ndarray  # (m,), cells between the two starts of a pair, ascending
    shares: np.ndarray  # (m,), of the pairs that end on different attractors

    def outline(self) -> Rows:
        if not np.isfinite(self.exponent):
            yield "uncertainty exponent", "there is no boundary"
            return
        is_less = self.exponent + ERRORS * self.error < 1.0
        verdict = "fractal at these distances" if is_less else "no evidence that it is not smooth"
        span = f"{int(self.distances[0])} to {int(self.distances[-1])} cells apart"
        words = f"{self.exponent:.3f} +- {self.error:.3f} (1: smooth; {span}): {verdict}"
        yield "uncertainty exponent", words


def basin_entropy(plane: np.ndarray, side: int = BOX) -> BasinEntropy:
    """Return the basin entropies of a plane, divided into boxes of `side` times `side` cells.

    Cells of unknown attractors count in no box; cells at the end of a row or column that fill no
    box are ignored.
    """
    rows, columns = (length // side for length in plane.shape)
    inner = plane[: rows * side, : columns * side]
    boxes = inner.reshape(rows, side, columns, side).swapaxes(1, 2).reshape(rows * columns, -1)
    # how often each attractor occurs in each box; the first column is for cells of none
    size = int(boxes.max()) + 2
    flat = boxes + 1 + size * np.arange(len(boxes))[:, np.newaxis]
    counts = np.bincount(flat.ravel(), minlength=size * len(boxes)).reshape(-1, size)[:, 1:]
    counts = counts[counts.any(axis=1)]
    p = counts / counts.sum(axis=1, keepdims=True)
    entropy = -np.sum(p * np.log(np.where(p > 0, p, 1.0)), axis=1)
    mixed = np.count_nonzero(counts, axis=1) > 1
    return BasinEntropy(
        basin=float(entropy.mean()) if entropy.size else float("nan"),
        boundary=float(entropy[mixed].mean()) if mixed.any() else float("nan"),
        boxes=entropy.size,
        boundary_boxes=int(mixed.sum()),
        side=side,
    )


def uncertainty_exponent(plane: np.ndarray) -> Uncertainty:
    """Return the uncertainty exponent of a plane whose shorter side has `SIDE` cells or more.

    A pair is two cells of a row or of a column, d = 1, 2, 4, ... apart up to an eighth of the
    shorter side, whose attractors are known; f is the mean of the shares in rows and in columns.
    The exponent is the slope of ln f over ln d, each d weighted by its number of uncertain pairs;
    NaN without a boundary.  After McDonald, Grebogi, Ott, Yorke, Physica D 17, 125 (1985).
    """
    distances = 2 ** np.arange((min(plane.shape) // 8).bit_length())
    # numbers of differing pairs, and of pairs: in parts of the plane, by distance, along rows and
    # columns; the first cells of the pairs are the same for each distance, so that a boundary near
    # the end of the plane has the same weight for all of them
    pieces = np.zeros((PARTS * PARTS, distances.size, 2, 2))
    for direction, turned in enumerate((plane, plane.T)):
        first = turned[:, : turned.shape[1] - int(distances[-1])]
        for i, d in enumerate(distances):
            second = turned[:, d : d + first.shape[1]]
            both_attractors = (first >= 0) & (second >= 0)
            for kind, cells in enumerate((both_attractors & (first != second), both_attractors)):
                bands = np.array_split(cells, PARTS)
                parts = [part for band in bands for part in np.array_split(band, PARTS, axis=1)]
                pieces[:, i, direction, kind] = [np.count_nonzero(part) for part in parts]
    total = pieces.sum(axis=0)
    without = np.array([_slope(distances, total - piece) for piece in pieces])
    factor = (len(pieces) - 1) / len(pieces)  # of the jackknife's variance
    error = float(np.sqrt(factor * np.sum((without - without.mean()) ** 2)))
    return Uncertainty(_slope(distances, total), error, distances, _shares(total))


def _shares(pairs: np.ndarray) -> np.ndarray:
    """Return the share of uncertain pairs by distance, the mean of rows and columns, shape (m,)."""
    return (pairs[..., 0] / np.maximum(pairs[..., 1], 1)).mean(axis=-1)


def _slope(distances: np.ndarray, pairs: np.ndarray) -> float:
    """Return the weighted slope of ln f over ln d."""
    shares, weight = _shares(pairs), pairs[..., 0].sum(axis=-1)
    seen = shares > 0
    if np.count_nonzero(seen) < 2:
        return float("nan")
    x, y, weight = np.log(distances[seen]), np.log(shares[seen]), weight[seen]
    x, y = x - np.average(x, weights=weight), y - np.average(y, weights=weight)
    return float(np.sum(weight * x * y) / np.sum(weight * x * x))


# ---- archives ------------------------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class Basin(Outlined):
    """The basin of one attractor."""

    number: int  # of the attractor; -1 stands for all cells with an unknown one
    label: str
    count: int  # its cells and starts
    total: int  # all of them
    low: float  # the ends of Wilson's interval of the share for random starts; NaN for a lattice
    high: float
    # from the attractor's point, if it lies in the plane, to the nearest cell of another basin
    nearest: tuple[float, ...] = ()
    distance: float = float("nan")  # length of `nearest`, each axis divided by its range

    @property
    def share(self) -> float:
        return self.count / self.total


@dataclass(frozen=True, repr=False)
class Basins(Outlined):
    """The basins at one value of each parameter of a scan.

    Attributes
    ----------
    title : str
        The title of the scan, with these values.
    basins : tuple of Basin
        Of each attractor, by its number; unknown ones last, if there are any.
    entropy, uncertainty : BasinEntropy, Uncertainty or None
        Of a plane of two initial conditions that is large enough.
    attractor, arrival : (cells ..., starts) ndarray
        The number of the attractor, -1 if unknown; forcing periods until an orbit is near it.
    axes : tuple of str
        The axes of initial conditions.
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
        for basin in self.basins:
            name = f"attractor {basin.number}, " if basin.number >= 0 else ""
            text = f"{basin.share:.4f} ({basin.count} of {basin.total})"
            if np.isfinite(basin.low):
                text += f", {LEVEL:.0%} interval {basin.low:.4f} to {basin.high:.4f}"
            steps = [
                f"{component_of(axis)} {step:+.3g} {DESCRIBED[axis].unit}"
                for axis, step in zip(self.axes, basin.nearest, strict=False)
            ]
            if steps:
                text += f"; left by {', '.join(steps)} ({basin.distance:.3g} of the plane's sides)"
            yield name + basin.label, text
        for measure in (self.entropy, self.uncertainty):
            yield from measure.outline() if measure is not None else ()

    def arrived(self, periods: float, attractor: int | None = None) -> float:
        """Return the share of orbits near `attractor`, or near any, after so many periods."""
        periods = number("periods", periods)
        there = (self.arrival >= 0) & (self.arrival <= periods)
        if attractor is not None:
            there &= self.attractor == attractor
        return float(np.count_nonzero(there) / there.size)


def basin_measures(
    archive: ArchiveView | str | os.PathLike[str], side: int = BOX, **values: float
) -> Basins:
    """Measure the basins of attraction of a scan that recorded `attractor`.

    Parameters
    ----------
    archive : ArchiveView or path-like
        The scan, with the record `attractor`.
    side : int
        Cells along the side of a box, for basin entropies.
    **values : float
        Each varied parameter, `omega=7.7`; the nearest value is used.

    Returns
    -------
    Basins
        Shares, with intervals if starts were drawn at random; for a plane of two initial conditions
        basin entropies and the uncertainty exponent, too.

    Raises
    ------
    RequestError
        If the archive holds no attractors, or for a value outside of the scan.

    References
    ----------
    Daza et al., Sci. Rep. 6, 31416 (2016); McDonald et al., Physica D 17, 125 (1985).

    Examples
    --------
    >>> import nlds_vines as nv
    >>> vary = {"P": {"values": [0.5]}, "v_0": {"values": [0.0, 3.0]}}
    >>> scan = nv.scan(
    ...     "impact-oscillator", set={"omega": 1.5}, vary=vary, record=["attractor"], quiet=True
    ... )
    >>> [(basin.label, basin.share) for basin in nv.basin_measures(scan, P=0.5).basins]
    [('T,0', 0.5), ('T,1', 0.5)]
    """
    if not isinstance(archive, ArchiveView):
        with read(archive) as view:
            return basin_measures(view, side, **values)
    if ATTRACTOR not in archive:
        raise RequestError(f"{archive.path} holds no attractor: scan with --record {ATTRACTOR}")
    scan, side = scan_of(archive), whole("side", side, 2)
    place = nearest_place(archive.path, scan, values, scan.parameters)
    where = {axis.name: i for axis, i in zip(scan.parameters, place, strict=True)}
    attractor, arrival = (archive.take(name, **where) for name in (ATTRACTOR, "arrival"))
    axes = tuple(name for name in archive.axes if name in INITIAL)
    plane = attractor[..., 0] if len(axes) == 2 else np.zeros((0, 0), int)
    chosen = ", ".join(f"{name} = {archive[name][i]:g}" for name, i in where.items())
    has_labels, basins = "attractor_label" in archive, list[Basin]()
    labels = archive.take("attractor_label", **where) if has_labels else np.zeros(0)
    for k in [*np.flatnonzero([bool(label) for label in labels]).tolist(), -1]:
        count = int(np.count_nonzero(attractor == k))
        if k < 0 and not count:
            continue
        is_random = attractor.shape[-1] > 1 and not axes  # starts that were drawn at random
        ends = share_interval(count, attractor.size) if is_random else (np.nan, np.nan)
        has_steps = k >= 0 and len(axes) == 2 and begins_at_sections(archive)
        near = _nearest(archive, attractor, where, axes, k) if has_steps else None
        label = str(labels[k]) if k >= 0 else "not known"
        basins.append(Basin(k, label, count, attractor.size, *ends, *(near or ())))
    return Basins(
        title=archive.text("title") + (f", {chosen}" if chosen else ""),
        basins=tuple(basins),
        entropy=basin_entropy(plane, side) if min(plane.shape) >= side else None,
        uncertainty=uncertainty_exponent(plane) if min(plane.shape) >= SIDE else None,
        attractor=attractor,
        arrival=arrival,
        axes=axes,
    )


def _nearest(
    view: ArchiveView, attractor: np.ndarray, where: dict[str, int], axes: tuple[str, ...], k: int
) -> tuple[tuple[float, ...], float] | None:
    """Return the step from an attractor's point to the nearest cell of another basin, its size."""
    names, along = view["component"].tolist(), [component_of(name) for name in axes]
    point = dict(zip(names, view.take("attractor_point", number=k, **where), strict=True))
    # the components of the starts that the axes do not set
    scan = scan_of(view)
    start = scan.start.state or scan.system.state_at_rest
    off = [abs(point[n] - v) for n, v in zip(names, start, strict=True) if n not in along]
    values = [view[name] for name in axes]
    is_inside = all(v[0] <= point[n] <= v[-1] for n, v in zip(along, values, strict=True))
    span = max(abs(value) for value in point.values())
    rows, columns = np.nonzero((attractor[..., 0] != k) & (attractor[..., 0] >= 0))
    if not is_inside or max(off, default=0.0) > IN_PLANE * span or not rows.size:
        return None
    steps = [v[i] - point[n] for n, v, i in zip(along, values, (rows, columns), strict=True)]
    lengths = [step / np.ptp(v) for step, v in zip(steps, values, strict=True)]
    distances = np.sqrt(lengths[0] * lengths[0] + lengths[1] * lengths[1])
    least = int(distances.argmin())
    return tuple(float(step[least]) for step in steps), float(distances[least])
