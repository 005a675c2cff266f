"""Several near-equal optima in place of one, and the perturbations that test their robustness."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import DESCRIBED, described
from nlds_vines.tuning.objective import Trials
from nlds_vines.tuning.request import DETUNING, SHIFT, SIZE, STARTS, STRETCH, Tuning

BAND = 5
"""Values of a parameter that stand for a range, and not for themselves."""

_FINER = 8
"""Into so many parts the steps of such a range are divided to judge an optimum between them."""


def distinct(
    units: np.ndarray, values: np.ndarray, within: float, apart: float, most: int
) -> np.ndarray:
    """Return the indices of good designs that lie apart from one another, the best first.

    Arguments: `units` (n, parameters), places in the unit cube; `values` (n,) [J]; how much worse
    than the best one, relatively, and how far from all better ones chosen a design is at least;
    the `most` there may be.  Empty where no value is finite.
    """
    limit = values.min(initial=np.inf) * (1 + within)
    candidates = np.flatnonzero(np.isfinite(values) & (values <= limit))
    left = candidates[np.argsort(values[candidates], kind="stable")]
    chosen: list[int] = []
    while left.size and len(chosen) < most:
        chosen.append(int(left[0]))
        distance = np.linalg.norm(units[left] - units[left[0]], axis=1)
        left = left[distance >= apart]
    return np.array(chosen, dtype=int)


def over_finer_bands(tuning: Tuning) -> Tuning | None:
    """Return a tuning that judges designs over finer bands; None where it has no band.

    The values of the tuning are among the finer ones.  It searches next to nothing: it is there
    for the objective.
    """
    bands = [axis for axis in tuning.over if is_band(axis)]
    if not bands:
        return None
    over = tuple(_finer(axis) if axis in bands else axis for axis in tuning.over)
    least = replace(tuning.search, population=5, generations=1, polish=0, seeds=1, optima=1)
    return replace(tuning, over=over, surface=None, search=least)


def is_band(axis: Axis) -> bool:
    """Tell whether the values of a parameter stand for a range."""
    return axis.name in DESCRIBED and axis.values.size >= BAND


def _finer(axis: Axis) -> Axis:
    """Return an axis with the values of another one, and more between them."""
    places = np.arange(axis.values.size)
    finer = np.linspace(0, places[-1], _FINER * places[-1] + 1)
    return Axis(axis.name, np.interp(finer, places, axis.values))


class Disturbance(NamedTuple):
    """One of what may be off: in words; the column of a trial, or a parameter; and its value.

    The value is a factor, but of `start`, whose value is its number.
    """

    words: str
    column: str = ""
    value: float = 1.0


def _disturbances(tuning: Tuning) -> list[Disturbance]:
    """Return all that an optimum is tested under; the first is nothing."""

    def both(words: str, column: str, share: float) -> list[Disturbance]:
        return [Disturbance(f"{words} {sign:+.0%}", column, 1.0 + sign) for sign in (-share, share)]

    shifted = [one for name in tuning.names for one in both(name, name, SHIFT)]
    if tuning.history is not None:
        off = both("natural frequency", "detuning", DETUNING)
        return [Disturbance("none"), *off, *both("load", "stretch", SIZE), *shifted]
    starts = [Disturbance(f"random start {i}", "start", i) for i in range(1, STARTS + 1)]
    longer = Disturbance(f"{STRETCH} x the periods", "stretch", STRETCH)
    off = both("omega", "detuning", DETUNING)
    return [Disturbance("none"), *off, longer, *shifted, *starts]


def perturbations(tuning: Tuning) -> tuple[str, ...]:
    """Return the perturbations of an optimum, in words; the first is none."""
    return tuple(one.words for one in _disturbances(tuning))


def perturbed(tuning: Tuning, point: np.ndarray) -> Trials:
    """Return a design [SI] under each of the `perturbations`; a band is shifted as a whole."""
    every = _disturbances(tuning)
    points = np.tile(point, (len(every), 1))
    how = {"detuning": np.ones(len(every)), "start": np.zeros(len(every)),
           "stretch": np.ones(len(every))}  # fmt: skip
    for row, one in enumerate(every):
        if one.column in how:
            how[one.column][row] = one.value
        elif one.column:
            points[row, tuning.names.index(one.column)] *= one.value
    for i, name in enumerate(tuning.names):
        # within the range of the parameter, as Poisson's ratio up to 0.5
        points[:, i] = np.clip(points[:, i], described(name).low, described(name).high)
    return Trials(points, **how)
