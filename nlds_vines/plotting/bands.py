"""Values along an axis: borders of cells, runs of equal labels, places for names, drawable ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nlds_vines.errors import RequestError

# of values that can be drawn, 0 aside: sums of larger ones overflow
LARGEST, SMALLEST = 1e300, 1e-300
_FEW, _FEW_UNEVEN = 4, 8  # the most values of a list: at any distances, at uneven ones
_EVEN = 1e-6  # relative difference of equal steps, far above round-off


class Band(NamedTuple):
    """A run of neighboring cells of one label, from `low` to `high` on the axis."""

    label: str
    low: float
    high: float

    @property
    def width(self) -> float:
        return self.high - self.low

    @property
    def center(self) -> float:
        return (self.low + self.high) / 2


def refuse_undrawable(name: str, values: np.ndarray) -> None:
    sizes = np.abs(values)
    wrong = values[(sizes > LARGEST) | ((sizes < SMALLEST) & (sizes > 0))]
    if wrong.size:
        raise RequestError(
            f"{name} = {float(wrong[0])!r} cannot be drawn; along the axis of a picture are "
            f"allowed: 0, and sizes from {SMALLEST:g} to {LARGEST:g}"
        )


def drawable(values: np.ndarray) -> np.ndarray:
    """Return numbers as floats, NaN for those that are infinite or too large to draw."""
    numbers = np.asarray(values, dtype=float)
    return np.where(np.abs(numbers) <= LARGEST, numbers, np.nan)


def evenly_spaced(values: np.ndarray) -> bool:
    steps = np.diff(values)
    return bool(np.allclose(steps, steps[0], rtol=_EVEN))


def logarithmic(values: np.ndarray) -> bool:
    """Return True if ascending `values` (n,), three or more, have equal ratios."""
    if values.size < 3 or values[0] <= 0 or evenly_spaced(values):
        return False
    return evenly_spaced(np.log(values))


def is_list(values: np.ndarray) -> bool:
    """Return True if ascending `values` (n,) are few or uneven, so that they are no range."""
    if values.size <= _FEW:
        return True
    return values.size <= _FEW_UNEVEN and not (evenly_spaced(values) or logarithmic(values))


def edges(values: np.ndarray) -> np.ndarray:
    """Return the borders (n + 1,) of the cells around ascending `values` (n,).

    Neighbors meet half-way, of logarithms if ratios are equal; the outer cells are symmetric.
    """
    if values.size == 1:
        half = 0.5 * abs(values[0]) or 0.5
        return np.array([values[0] - half, values[0] + half])
    if logarithmic(values):
        return np.exp(_borders(np.log(values)))
    return _borders(values)


def inner_edges(values: np.ndarray) -> np.ndarray:
    """Return the borders (n + 1,) of cells, of which the outer ones end at their values (n,)."""
    borders = edges(values)
    if values.size > 1:
        borders[0], borders[-1] = values[0], values[-1]
    return borders


def _borders(values: np.ndarray) -> np.ndarray:
    middle = (values[1:] + values[:-1]) / 2
    first, last = 2 * values[0] - middle[0], 2 * values[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])


def bands(values: np.ndarray, labels: np.ndarray) -> list[Band]:
    starts = np.flatnonzero(np.concatenate([[True], labels[1:] != labels[:-1]]))
    borders = edges(values)
    stops = np.append(starts[1:], labels.size)
    return [
        Band(str(labels[first]), float(borders[first]), float(borders[stop]))
        for first, stop in zip(starts, stops, strict=True)
    ]


def one_regime(values: np.ndarray, numbers: np.ndarray, labels: np.ndarray) -> list[np.ndarray]:
    """Return a curve (2, points) that joins equal neighboring labels, and the other points (2, n).

    Arguments: abscissae, ordinates and `labels`, (n,) each.  The curve has a NaN between different
    labels and beside an empty one.
    """
    joined = (labels[1:] == labels[:-1]) & (labels[1:] != "")
    alone = ~(np.append(joined, False) | np.append(False, joined))
    cuts = np.flatnonzero(~joined) + 1
    every = np.stack([values, numbers]).astype(float)
    return [np.insert(every, cuts, np.nan, axis=1), every[:, alone]]


def spread(wanted: Sequence[float], gap: float, low: float, high: float) -> np.ndarray:
    """Return places (n,) near the ascending `wanted` ones, at least `gap` apart in [low, high].

    Apart from the ends, the places minimize the sum of squared displacements: with the gaps
    subtracted, they are an isotonic regression, the nearest sequence that never falls.

    Raises ValueError if there is no room for so many.
    """
    from scipy.optimize import isotonic_regression

    count = len(wanted)
    if (count - 1) * gap > high - low:
        raise ValueError(f"no room for {count} places {gap} apart within {high - low}")
    if not count:
        return np.empty(0)
    offset = gap * np.arange(count)
    level = isotonic_regression(np.asarray(wanted, dtype=float) - offset).x
    return np.clip(level, low, high - gap * (count - 1)) + offset
