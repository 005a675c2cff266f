"""Every parameter by name: symbol, unit, meaning and the range in which it makes sense.

The names are those of the paper's equations (1)-(6); SI units throughout.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

import numpy as np

from nlds_vines.errors import RequestError

STRUCTURE = ("m1", "k1", "c1")
"""The primary structure."""

DAMPER = ("m2", "k2", "c2")
"""The damper and its joint with the structure."""

FORCING = ("P", "omega")
"""The harmonic force on the structure, P cos(omega t)."""

CONTACT = ("E1", "E2", "nu1", "nu2", "A", "B", "q1")
"""The contact constants of equation (4); `K` may stand in place of all seven."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter: what it means and which finite values are allowed.

    Allowed are `low` <= value <= `high`, or `low` < value where `above` is set.
    """

    name: str
    symbol: str
    unit: str
    meaning: str
    low: float = -inf
    high: float = inf
    above: bool = False

    @property
    def allowed(self) -> str:
        """The allowed range in words, for messages and documentation."""
        if self.high < inf:
            return f"from {self.low:g} to {self.high:g}"
        if self.low > -inf:
            return f"{'>' if self.above else '>='} {self.low:g} and finite"
        return "finite"

    def accepts(self, values: np.ndarray) -> np.ndarray:
        """Return, element by element, whether `values` (any shape) are allowed; NaN never is."""
        bottom = values > self.low if self.above else values >= self.low
        return bottom & (values <= self.high) & np.isfinite(values)

    def check(self, values: np.ndarray) -> None:
        """Raise `RequestError` that quotes the first value outside the range, if there is one."""
        wrong = ~self.accepts(values)
        if np.any(wrong):
            given = float(values[wrong].flat[0])
            unit = f" [{self.unit}]" if self.unit != "1" else ""
            raise RequestError(
                f"{self.name} = {given!r} is not allowed: "
                f"{self.name} ({self.meaning}){unit} must be {self.allowed}"
            )


def _index(*parameters: Parameter) -> Mapping[str, Parameter]:
    return {parameter.name: parameter for parameter in parameters}


PARAMETERS: Mapping[str, Parameter] = _index(
    Parameter("m1", "m₁", "kg", "mass of the primary structure", low=0, above=True),
    Parameter("k1", "k₁", "N/m", "stiffness of the primary structure", low=0),
    Parameter("c1", "c₁", "N s/m", "damping of the primary structure", low=0),
    Parameter("m2", "m₂", "kg", "mass of the damper", low=0, above=True),
    Parameter("k2", "k₂", "N/m", "stiffness of the damper's spring", low=0),
    Parameter("c2", "c₂", "N s/m", "damping between damper and structure", low=0),
    Parameter("C", "C", "m", "clearance at rest; negative: preloaded"),
    Parameter("V", "V", "m", "distance of the obstacle from the structure"),
    Parameter("D", "D", "m", "distance between damper and structure at rest", low=0),
    Parameter("L", "L", "m", "how far the damper may pass the structure", low=0),
    Parameter("P", "P", "N", "amplitude of the force", low=0),
    Parameter("omega", "ω", "rad/s", "angular frequency of the force", low=0, above=True),
    Parameter("E1", "E₁", "Pa", "Young's modulus of the obstacle", low=0, above=True),
    Parameter("E2", "E₂", "Pa", "Young's modulus of the damper's surface", low=0, above=True),
    Parameter("nu1", "ν₁", "1", "Poisson's ratio of the obstacle", low=0, high=0.5),
    Parameter("nu2", "ν₂", "1", "Poisson's ratio of the damper's surface", low=0, high=0.5),
    Parameter("A", "A", "1/m", "first constant of the gap between the surfaces", low=0),
    Parameter("B", "B", "1/m", "second constant of the gap between the surfaces", low=0),
    Parameter("q1", "q₁", "1", "Hertz coefficient that belongs to A / B", low=0, above=True),
    Parameter("K", "K", "N/m^1.5", "contact stiffness", low=0, above=True),
)
"""All parameters of all scenes by name."""
