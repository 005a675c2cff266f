"""Several near-equal optima in place of one, and the perturbations that test their robustness."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.tuning.objective import Trials
from nlds_vines.tuning.request import DETUNING, SHIFT, STARTS, STRETCH, Tuning

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
    if not any(axis.values.size >= BAND for axis in tuning.over):
        return None
    over = tuple(_finer(axis) if axis.values.size >= BAND else axis for axis in tuning.over)
    least = replace(tuning.search, population=5, generations=1, polish=0, seeds=1, optima=1)
    return replace(tuning, over=over, surface=None, search=least)


def _finer(axis: Axis) -> Axis:
    """Return an axis with the values of another one, and more between them."""
    places = np.arange(axis.values.size)
    finer = np.linspace(0, places[-1], _FINER * places[-1] + 1)
    return Axis(axis.name, np.interp(finer, places, axis.values))


def perturbations(tuning: Tuning) -> tuple[str, ...]:
    """Return the perturbations of an optimum, in words; the first is none."""
    shifted = [f"{name} {sign}{SHIFT:.0%}" for name in tuning.names for sign in "-+"]
    starts = [f"random start {i}" for i in range(1, STARTS + 1)]
    detuned = [f"omega {sign}{DETUNING:.0%}" for sign in "-+"]
    return ("none", *detuned, f"{STRETCH} x the periods", *shifted, *starts)


def perturbed(tuning: Tuning, point: np.ndarray) -> Trials:
    """Return a design [SI] under each of the `perturbations`; a band is shifted as a whole."""
    count, first = len(perturbations(tuning)), 4
    points = np.tile(point, (count, 1))
    for i, name in enumerate(tuning.names):
        rows = slice(first + 2 * i, first + 2 * i + 2)
        points[rows, i] *= 1 - SHIFT, 1 + SHIFT
        # within the range of the parameter, as Poisson's ratio up to 0.5
        points[:, i] = np.clip(points[:, i], PARAMETERS[name].low, PARAMETERS[name].high)
    detuning, start, stretch = np.ones(count), np.zeros(count), np.ones(count)
    detuning[1:3] = 1 - DETUNING, 1 + DETUNING
    stretch[3] = STRETCH
    start[count - STARTS :] = np.arange(1, STARTS + 1)
    return Trials(points, detuning, start, stretch)
