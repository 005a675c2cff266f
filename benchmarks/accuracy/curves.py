"""What the results of one method say: order, and the cost of an error."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from nlds_vines.accuracy.measured_cases import Measured, Result
from nlds_vines.accuracy.picture import front

DECADES = tuple(10.0**-k for k in range(3, 13))
"""Errors at which costs are compared, from 1e-3 to 1e-12."""

_COARSEST, _ABOVE = 1e-2, 30.0  # errors that follow a law: below this, and above so many doubts
_FEWEST = 3  # points through which an order is fitted


@dataclass(frozen=True)
class Curve:
    """One method on one case, its results from coarse to fine; `doubt` is the reference's."""

    method: str
    results: tuple[Result, ...]
    doubt: float

    @property
    def points(self) -> list[tuple[float, float]]:
        """Error and seconds of what found every touch, errors not below the doubt."""
        done = (found for found in self.results if found.complete and found.seconds > 0.0)
        return [(max(found.error, self.doubt), found.seconds) for found in done]

    @property
    def blind(self) -> list[Result]:
        """What missed or invented touches, and so followed another orbit, however near."""
        return [found for found in self.results if not (found.failure or found.complete)]

    @property
    def order(self) -> float:
        """Observed order p of error ~ value^-p, value being steps of a period.

        For tolerances error ~ rtol^p; NaN with fewer than three points under a law.
        """
        values, errors = self._lawful()
        if values.size < _FEWEST:
            return math.nan
        slope = float(np.polyfit(np.log(values), np.log(errors), 1)[0])
        return slope if values[0] < 1.0 else -slope

    def _lawful(self) -> np.ndarray:
        """Return values and errors (2, n) of the results that follow a law: neither of the ends."""
        found = [
            (result.setting.value, result.error)
            for result in self.results
            if result.complete and _ABOVE * self.doubt < result.error < _COARSEST
        ]
        return np.array(found).reshape(-1, 2).T

    def cost(self, error: float) -> float:
        """Return the seconds of a period that this error costs; infinite where it is not reached.

        By interpolation of logarithms along the cheapest points; above the largest error the
        cheapest point.
        """
        best = front(self.points)
        if not best or best[-1][0] > error:
            return math.inf
        errors, seconds = np.log(np.array(best)).T
        return float(np.exp(np.interp(-math.log(error), -errors, seconds)))


def curves_of(case: Measured) -> dict[str, Curve]:
    """Return the curve of each method on a case."""
    found = case.by_method().items()
    return {method: Curve(method, results, case.doubt) for method, results in found}


def above(curves: Iterable[Curve], ours: Curve) -> list[tuple[str, float]]:
    """Return at which of `DECADES` a method is cheaper than ours, by name; empty if at none.

    A method that reaches an error which ours does not reach counts as cheaper.
    """
    return [
        (curve.method, error)
        for curve in curves
        for error in DECADES
        if curve.method != ours.method and curve.cost(error) < ours.cost(error)
    ]
