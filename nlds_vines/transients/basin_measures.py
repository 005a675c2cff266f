"""How a plane of basins is divided: shares, entropies, uncertainty exponent.

The functions take plain arrays of whole numbers, one per cell: the number of the attractor that
the orbit from there ends on, and -1 where that is not known.  They know nothing of orbits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.errors import RequestError, whole
from nlds_vines.model.representation import Outlined

BOX = 20
"""Cells along the side of a box by default: 400 orbits tell its shares well (Daza et al. 2016)."""

FRACTAL = float(np.log(2.0))
"""A boundary entropy above ln 2 shows a fractal boundary: a smooth one parts two basins in a box
almost everywhere, and two basins have no more (Daza et al. 2016, eq. 9)."""

PARTS = 4
"""Parts of each side of the plane; the squares between them are left out in turn for an error."""


@dataclass(frozen=True)
class BasinEntropy:
    """Basin entropies of a plane [nats], after Daza et al., Sci. Rep. 6, 31416 (2016).

    Attributes:
        basin: S_b, the mean of -sum p ln p over all boxes, p the shares of the attractors in one.
        boundary: S_bb, the mean over the boxes with more than one attractor; NaN without any.
        boxes, boundary_boxes: how many there are.
        side: cells along the side of a box.
    """

    basin: float
    boundary: float
    boxes: int
    boundary_boxes: int
    side: int

    @property
    def fractal(self) -> bool:
        """Whether the boundary is fractal for certain; where False, it may be smooth or fractal."""
        return self.boundary > FRACTAL


@dataclass(frozen=True, repr=False)
class Uncertainty(Outlined):
    """The exponent a of f ~ d^a, f the share of uncertain pairs of starts a distance d apart.

    A smooth boundary of a plane has a = 1; a fractal one has a = 2 - D with its box dimension D.

    Attributes:
        exponent, error: a and its standard error, from leaving out parts of the plane in turn.
        distances: cells between the two starts of a pair, ascending, shape (m,).
        shares: of the pairs that end on different attractors, shape (m,).
    """

    exponent: float
    error: float
    distances: np.ndarray
    shares: np.ndarray


def basin_entropy(attractor: Any, side: int = BOX) -> BasinEntropy:
    """Return the basin entropies of a plane, divided into boxes of `side` times `side` cells.

    Arguments: `attractor`, whole numbers (rows, columns), -1 where the attractor is not known;
    those cells count in no box.  Cells at the end of a row or column that fill no box are left out.

    Raises `RequestError` for no plane, and for one that is smaller than a box.
    """
    plane = checked_plane(attractor)
    side = whole("side", side, 2)
    rows, columns = (length // side for length in plane.shape)
    if not rows * columns:
        sides = " x ".join(map(str, plane.shape))
        raise RequestError(f"the plane has {sides} cells; a box of side {side} needs at least that")
    inner = plane[: rows * side, : columns * side]
    boxes = inner.reshape(rows, side, columns, side).swapaxes(1, 2).reshape(rows * columns, -1)
    counts = _counts(boxes)
    known = counts.sum(axis=1)
    counts, known = counts[known > 0], known[known > 0]
    p = counts / np.maximum(known, 1)[:, np.newaxis]
    entropy = -np.sum(p * np.log(np.where(p > 0, p, 1.0)), axis=1)
    mixed = np.count_nonzero(counts, axis=1) > 1
    return BasinEntropy(
        basin=float(entropy.mean()) if entropy.size else float("nan"),
        boundary=float(entropy[mixed].mean()) if mixed.any() else float("nan"),
        boxes=entropy.size,
        boundary_boxes=int(mixed.sum()),
        side=side,
    )


def uncertainty_exponent(attractor: Any, longest: int | None = None) -> Uncertainty:
    """Return the uncertainty exponent of a plane of basins.

    Arguments: `attractor` as `basin_entropy` takes it; `longest`, the greatest distance of two
    starts in cells, by default an eighth of the shorter side of the plane.

    A pair is two cells of a row or of a column, d = 1, 2, 4, ... apart, whose attractors are known;
    f is the mean of the shares in rows and in columns.  The exponent is the slope of ln f over
    ln d, each d weighted by its number of uncertain pairs.  Where no pair differs there is no
    boundary, and the exponent is NaN.  After McDonald, Grebogi, Ott, Yorke, Physica D 17, 125
    (1985).

    Raises `RequestError` for no plane, or where fewer than three distances fit.
    """
    plane = checked_plane(attractor)
    short = min(plane.shape)
    most = short // 8 if longest is None else whole("longest", longest, 4)
    if not 4 <= most < short:
        raise RequestError(
            f"distances up to {most} cells in a plane whose shorter side has {short}; "
            "allowed: from 4 to less than that side (by default an eighth of it)"
        )
    distances = 2 ** np.arange(most.bit_length())
    pieces = _pairs(plane, distances)
    total = pieces.sum(axis=0)
    exponent = _slope(distances, total)
    without = np.array([_slope(distances, total - piece) for piece in pieces])
    count = len(pieces)  # the jackknife's error
    error = np.sqrt((count - 1) / count * np.sum((without - without.mean()) ** 2))
    return Uncertainty(exponent, float(error), distances, _shares(total))


def checked_plane(attractor: Any) -> np.ndarray:
    """Return a plane of attractors' numbers; raise `RequestError` for anything else."""
    plane = np.asarray(attractor)
    if plane.ndim != 2 or plane.dtype.kind not in "iu" or not plane.size:
        raise RequestError(
            f"attractor has dtype {plane.dtype} and shape {plane.shape}; "
            "allowed: whole numbers (rows, columns)"
        )
    if plane.min() < -1:
        raise RequestError(f"attractor is {plane.min()} somewhere; allowed: -1 and more")
    return plane


def _counts(boxes: np.ndarray) -> np.ndarray:
    """Return how often each attractor occurs in each box: (boxes, cells) to (boxes, attractors)."""
    size = int(boxes.max()) + 2  # the first column is for what is not known
    flat = boxes + 1 + size * np.arange(len(boxes))[:, np.newaxis]
    return np.bincount(flat.ravel(), minlength=size * len(boxes)).reshape(-1, size)[:, 1:]


def _pairs(plane: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Return of rows and columns how many pairs differ and how many there are: (parts, m, 2, 2).

    The first cells of the pairs are the same for each distance, so that a boundary near the end of
    the plane has no other weight for one than for the other.
    """
    most = int(distances[-1])
    found = np.zeros((PARTS * PARTS, distances.size, 2, 2))
    for direction, turned in enumerate((plane, plane.T)):
        first = turned[:, : turned.shape[1] - most]
        for i, d in enumerate(distances):
            second = turned[:, d : d + first.shape[1]]
            known = (first >= 0) & (second >= 0)
            found[:, i, direction, 0] = _by_part(known & (first != second))
            found[:, i, direction, 1] = _by_part(known)
    return found


def _by_part(cells: np.ndarray) -> np.ndarray:
    """Return how many cells are True in each part of a plane."""
    bands = np.array_split(cells, PARTS)
    parts = [part for band in bands for part in np.array_split(band, PARTS, axis=1)]
    return np.array([np.count_nonzero(part) for part in parts])


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
