"""Bands of equal regime along an axis, and where to write their names without overlaps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class Band(NamedTuple):
    """A run of neighbouring cells of one label, from `low` to `high` on the axis."""

    label: str
    low: float
    high: float

    @property
    def width(self) -> float:
        """Extent along the axis."""
        return self.high - self.low

    @property
    def centre(self) -> float:
        """Middle of the band."""
        return (self.low + self.high) / 2


def edges(values: np.ndarray) -> np.ndarray:
    """Return where the cells around ascending `values` begin and end: one more than they are.

    Cells meet half-way; the first and the last are as wide outside as inside.
    """
    if values.size == 1:
        half = 0.5 * abs(values[0]) or 0.5
        return np.array([values[0] - half, values[0] + half])
    middle = (values[1:] + values[:-1]) / 2
    first, last = 2 * values[0] - middle[0], 2 * values[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])


def bands(values: np.ndarray, labels: np.ndarray) -> list[Band]:
    """Return the runs of equal `labels` along ascending `values`, both of shape (cells,)."""
    starts = np.flatnonzero(np.concatenate([[True], labels[1:] != labels[:-1]]))
    borders = edges(values)
    stops = np.append(starts[1:], labels.size)
    return [
        Band(str(labels[first]), float(borders[first]), float(borders[stop]))
        for first, stop in zip(starts, stops, strict=True)
    ]


def spread(wanted: Sequence[float], gap: float, low: float, high: float) -> np.ndarray:
    """Return places near the ascending `wanted` ones, at least `gap` apart within [low, high].

    They minimise the sum of the squared displacements (before the ends are respected): names that
    would collide form a group, and a group stands centred over what it names.  ValueError if
    there is no room for so many.
    """
    count = len(wanted)
    if (count - 1) * gap > high - low:
        raise ValueError(f"no room for {count} places {gap} apart within {high - low}")
    offset = gap * np.arange(count)
    level = _never_falling(np.asarray(wanted, dtype=float) - offset)
    return np.clip(level, low, high - gap * (count - 1)) + offset


def _never_falling(values: np.ndarray) -> np.ndarray:
    """Return the never-falling sequence nearest to `values`: neighbours that violate are pooled."""
    pools: list[tuple[float, int]] = []
    for value in values:
        total, count = float(value), 1
        while pools and pools[-1][0] * count > total * pools[-1][1]:
            before, members = pools.pop()
            total, count = total + before, count + members
        pools.append((total, count))
    levels = [total / count for total, count in pools]
    return np.repeat(levels, np.array([count for _, count in pools], dtype=int))
