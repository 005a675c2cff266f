"""A free parameter of a search: its bounds, and the scale on which distances are taken."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nlds_vines.errors import RequestError, table
from nlds_vines.model.axis import Interval
from nlds_vines.model.parameters import FORCING, STRUCTURE
from nlds_vines.model.ratios import ratios_in
from nlds_vines.model.scenes import Scene
from nlds_vines.model.scenes.base import BASES


class Bounds(NamedTuple):
    """The default bounds of a parameter, on a logarithmic scale or a linear one."""

    low: float
    high: float
    logarithmic: bool


BOUNDS: Mapping[str, Bounds] = {
    "m2": Bounds(10.0, 200.0, True),
    "k2": Bounds(10.0, 1e4, True),
    "c2": Bounds(10.0, 1e3, True),
    "C": Bounds(0.0, 0.5, False),
    "V": Bounds(0.0, 0.5, False),
    "D": Bounds(0.0, 0.5, False),
    "L": Bounds(0.0, 0.5, False),
    "E2": Bounds(1e6, 1e9, True),
    "K": Bounds(1e6, 1e9, True),
    "mass_ratio": Bounds(0.01, 0.2, True),
    "zeta2": Bounds(0.01, 1.0, True),
}
"""The default bounds (SI units), wide for a structure of a tonne as the paper has it.

k2 reaches from far below the stiffness m2 omega^2 that tunes a linear damper of 60 kg to 6.28 rad/s
(2366 N/m) to far above it; c2 from a damping at which orbits still settle within the default
transient of 300 periods to ten times that of a good tuned mass damper."""

USUAL = ("k2", "c2", "C", "D")
"""The parameters that are tuned by default, as far as the scene has them."""

INERT = ("V",)
"""Parameters that do not enter the dynamics: V shifts pictures and the rest position only."""


def tunable(scene: Scene) -> tuple[str, ...]:
    """Return the names of the parameters of a scene that belong to the damper, and their ratios."""
    of_damper = [name for name in scene.allowed if name not in STRUCTURE + FORCING + BASES]
    ratios = ratios_in(scene).items()
    return (*of_damper, *(name for name, ratio in ratios if ratio.gives in of_damper))


def usual(scene: Scene) -> tuple[str, ...]:
    """Return the parameters of a scene that are tuned by default."""
    return tuple(name for name in USUAL if name in scene.own)


@dataclass(frozen=True)
class Free(Interval):
    """One free parameter: its `name`, and `low` < `high` in SI units.

    Raises `RequestError` for bounds that are no numbers, in the wrong order, or outside the range
    of the parameter.
    """

    @classmethod
    def of(cls, name: str, entry: object) -> Free:
        """Return the free parameter that a table with `low` and `high` means.

        What is missing in the table is taken from `BOUNDS`; `RequestError` where that has none.
        """
        given = dict(table(name, entry, ("low", "high")))
        usual_bounds = BOUNDS.get(name)
        if usual_bounds is None and given.keys() != {"low", "high"}:
            raise RequestError(
                f"{name} has no default bounds: give both; those with: {', '.join(BOUNDS)}"
            )
        if usual_bounds is not None:
            given = {"low": usual_bounds.low, "high": usual_bounds.high} | given
        return cls(name, **given)

    @property
    def logarithmic(self) -> bool:
        """Whether ratios count rather than differences."""
        return self.name in BOUNDS and BOUNDS[self.name].logarithmic and self.low > 0

    @property
    def inert(self) -> bool:
        """Whether the dynamics do not depend on it."""
        return self.name in INERT

    def value(self, unit: np.ndarray) -> np.ndarray:
        """Return the values [SI] at places from 0 (low) to 1 (high) on its scale."""
        if self.logarithmic:
            low, high = logarithms(np.array([self.low, self.high]))
            found = exponentials(low + unit * (high - low))
        else:
            found = self.low + unit * (self.high - self.low)
        return np.clip(found, self.low, self.high)  # round-off must not exceed a bound

    def unit(self, value: np.ndarray) -> np.ndarray:
        """Return the places from 0 (low) to 1 (high) of values [SI] on its scale."""
        if self.logarithmic:
            low, high = logarithms(np.array([self.low, self.high]))
            return (logarithms(value) - low) / (high - low)
        return (value - self.low) / (self.high - self.low)


def exponentials(values: np.ndarray) -> np.ndarray:
    """Return e^x of each value; NumPy's depends on the processor, and a search on every bit."""
    from nlds_vines.kernels.numerics.elementary import exp

    return np.reshape([exp(float(x)) for x in np.ravel(values)], np.shape(values))


def logarithms(values: np.ndarray) -> np.ndarray:
    """Return the natural logarithm of each value, as `exponentials`."""
    from nlds_vines.kernels.numerics.elementary import log

    return np.reshape([log(float(x)) for x in np.ravel(values)], np.shape(values))


def values_of(free: tuple[Free, ...], units: np.ndarray) -> np.ndarray:
    """Return the designs [SI], one column per parameter, of points in the unit cube."""
    columns = [parameter.value(units[:, i]) for i, parameter in enumerate(free)]
    return np.stack(columns, axis=1)


def units_of(free: tuple[Free, ...], points: np.ndarray) -> np.ndarray:
    """Return the points in the unit cube of designs [SI], one column per parameter."""
    columns = [parameter.unit(points[:, i]) for i, parameter in enumerate(free)]
    return np.stack(columns, axis=1)
