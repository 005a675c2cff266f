"""The parameters that a search changes, with bounds and scales, and those that are uncertain.

Draws of uncertain parameters are points of a scrambled Sobol sequence, the same for every design.
Source: A. B. Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998), as
SciPy's `qmc.Sobol` implements it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.errors import RequestError, choice, from_text, number, shown, table
from nlds_vines.model.axis import Interval
from nlds_vines.model.parameters import DESCRIBED, FORCE, FORCING, GROUND, STRUCTURE, split_name
from nlds_vines.model.ratios import ratios_in
from nlds_vines.model.scenes import BASES, Scene

NORMAL, UNIFORM = "normal", "uniform"
CUT = 3.0  # standard deviations at which a normal distribution ends: no stiffness is negative
DIGITS = 9  # of a place on a normal distribution: logarithms of libraries differ in the last bit
DRAWS = 64  # the default number of draws if something is uncertain
MOST_DRAWS = 2**16  # a power of two: only then are Sobol points even
FRESH_DRAWS = 1024  # by which an optimum is judged again at least, none of them from the search
FRESH_UNDER_LOAD = 128  # the same under loads, where an orbit is a whole history
FRESH_SEED = 2**32  # offset of the seed of the fresh draws: the seeds of searches are smaller


UNITS: Mapping[str, tuple[str, float]] = {
    "m": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3),
    "kg": ("kg", 1.0), "t": ("kg", 1e3), "N": ("N", 1.0), "kN": ("N", 1e3),
    "N/m": ("N/m", 1.0), "kN/m": ("N/m", 1e3), "N/mm": ("N/m", 1e3),
    "N s/m": ("N s/m", 1.0), "kN s/m": ("N s/m", 1e3), "N s": ("N s", 1.0), "s": ("s", 1.0),
    "rad/s": ("rad/s", 1.0), "Hz": ("Hz", 1.0),
}  # fmt: skip
"""The units of a spread in words, each with its SI unit and factor."""


class Bounds(NamedTuple):
    low: float
    high: float
    logarithmic: bool  # its scale


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
    "frequency_ratio": Bounds(0.3, 2.0, True),
    "zeta2": Bounds(0.01, 1.0, True),
}
"""The default bounds (SI units), wide for a structure of a tonne as in the paper.

k2 reaches from far below the stiffness m2 omega^2 that tunes a linear damper of 60 kg to 6.28 rad/s
(2366 N/m) to far above it; c2 from a damping at which orbits still settle within the default
transient of 300 periods to ten times that of a good tuned mass damper."""

_LIKE = {"m": "m2", "k": "k2", "c": "c2"}  # of a host's damper, with the scale of this parameter

USUAL = ("k2", "c2", "C", "D")  # tuned by default, as far as the scene has them


def tunable(scene: Scene) -> tuple[str, ...]:
    """Return the names of the dampers' parameters and of the ratios that stand for them."""
    foreign = (*STRUCTURE, *FORCING, *BASES)
    drives = (f"{FORCE}.", f"{GROUND}.")
    of_damper = [
        name for name in scene.allowed if name not in foreign and not name.startswith(drives)
    ]
    ratios = ratios_in(scene).items()
    return (*of_damper, *(name for name, ratio in ratios if ratio.gives in of_damper))


@dataclass(frozen=True)
class Free(Interval):
    """A free parameter with its bounds `low` < `high` in SI units."""

    @classmethod
    def of(cls, name: str, entry: object) -> Free:
        """Return the free parameter of a table with `low` and `high`; `BOUNDS` are the defaults."""
        bounds = dict(table(name, entry, ("low", "high")))
        if name in BOUNDS:
            bounds = {"low": BOUNDS[name].low, "high": BOUNDS[name].high} | bounds
        if bounds.keys() != {"low", "high"}:
            raise RequestError(
                f"{name} has no default bounds: give both; those with: {', '.join(BOUNDS)}"
            )
        return cls(name, **bounds)

    @property
    def logarithmic(self) -> bool:
        key = split_name(self.name)[1] or self.name
        bounds = BOUNDS.get(_LIKE.get(key, key))
        return bounds is not None and bounds.logarithmic and self.low > 0

    @property
    def inert(self) -> bool:
        """Whether it does not enter the dynamics: V shifts pictures and the rest position only."""
        return self.name == "V"

    def value(self, unit: np.ndarray) -> np.ndarray:
        """Return the values [SI] at places from 0 (low) to 1 (high) on its scale."""
        if self.logarithmic:
            # NumPy's exponential depends on the processor, and a search on every bit
            from nlds_vines.kernels.numerics.elementary import exp, log

            low, high = log(self.low), log(self.high)
            exponents = np.ravel(low + unit * (high - low)).tolist()
            values = np.reshape([*map(exp, exponents)], np.shape(unit))
        else:
            values = self.low + unit * (self.high - self.low)
        return np.clip(values, self.low, self.high)  # round-off must not exceed a bound

    def unit(self, value: np.ndarray) -> np.ndarray:
        """Return the places from 0 (low) to 1 (high) of values [SI] on its scale."""
        if not self.logarithmic:
            return (value - self.low) / (self.high - self.low)
        from nlds_vines.kernels.numerics.elementary import log

        low, high = log(self.low), log(self.high)
        logarithms = [log(one) for one in np.ravel(value).tolist()]
        return (np.reshape(logarithms, np.shape(value)) - low) / (high - low)


def values_of(free: tuple[Free, ...], units: np.ndarray) -> np.ndarray:
    """Return the designs [SI], one column per parameter, of points in the unit cube."""
    return np.stack([item.value(units[:, i]) for i, item in enumerate(free)], axis=1)


def units_of(free: tuple[Free, ...], points: np.ndarray) -> np.ndarray:
    """Return the points in the unit cube of designs [SI], one column per parameter."""
    return np.stack([item.unit(points[:, i]) for i, item in enumerate(free)], axis=1)


@dataclass(frozen=True)
class Uncertain:
    """An uncertain parameter, or an uncertain number of a load.

    `spread` is the standard deviation of a normal distribution, or half the width of a uniform one,
    in per cent of the value if it is `relative`, otherwise in SI units.
    """

    name: str
    spread: float
    relative: bool
    law: str = NORMAL

    def __post_init__(self) -> None:
        choice(f"distribution of {self.name}", self.law, (NORMAL, UNIFORM))
        if not number(f"spread of {self.name}", self.spread) > 0.0:
            raise RequestError(f"spread of {self.name} = {self.spread!r} must be > 0")

    @classmethod
    def of(cls, name: str, entry: object) -> Uncertain:
        """Return the uncertain parameter of an entry: a spread, or a table with spread and law."""
        given = entry if isinstance(entry, Mapping) else {"spread": entry}
        settings = table(name, given, ("spread", "law"))
        spread, law = settings.get("spread"), settings.get("law", NORMAL)
        if isinstance(spread, str) and spread.endswith("%"):
            return cls(name, from_text(float, f"spread of {name}", spread[:-1]), True, law)
        if isinstance(spread, str) and " " in spread:
            return cls(name, _with_unit(name, spread), False, law)
        if isinstance(spread, str) or spread is None:
            raise RequestError(
                f"spread of {name} = {shown(spread)} must be as '5%', or a number, or as '0.5 mm'"
            )
        return cls(name, number(f"spread of {name}", spread), False, law)

    def entry(self) -> dict[str, Any]:
        return {"spread": f"{self.spread!r}%" if self.relative else self.spread, "law": self.law}

    @property
    def reach(self) -> float:
        """The farthest place of a draw, in spreads."""
        return CUT if self.law == NORMAL else 1.0

    def at(self, values: Any, places: Any) -> Any:
        """Return the parameter values at `places`, in spreads from the nominal `values`."""
        scale = np.abs(values) / 100.0 if self.relative else 1.0
        return values + places * (self.spread * scale)

    def words(self) -> str:
        return f"{self.name} ±{self.spread:g}{' %' if self.relative else ''} ({self.law})"


def _with_unit(name: str, text: str) -> float:
    """Return a spread such as "0.5 mm" in SI units; its unit must be that of the parameter."""
    size, _, unit = text.strip().partition(" ")
    si, factor = UNITS[choice(f"unit of the spread of {name}:", unit.strip(), UNITS)]
    own = DESCRIBED[name].unit if name in DESCRIBED else si
    if own != si:
        raise RequestError(f"spread of {name} = {shown(text)}: {name} is in {own}")
    return from_text(float, f"spread of {name}", size) * factor


def places_of(uncertain: tuple[Uncertain, ...], draws: int, seed: int) -> np.ndarray:
    """Return the places (draws + 1, uncertain) of all draws in spreads; the first is nominal, 0."""
    places = np.zeros((draws + 1, len(uncertain)))
    if not (draws and uncertain):
        return places
    from scipy.stats import qmc

    sobol = qmc.Sobol(len(uncertain), scramble=True, seed=seed)
    points = sobol.random_base2(draws.bit_length() - 1)
    normal = NormalDist()
    low = normal.cdf(-CUT)
    for i, one in enumerate(uncertain):
        if one.law == UNIFORM:
            places[1:, i] = 2.0 * points[:, i] - 1.0
        else:  # the quantiles of the distribution that is cut
            shares = (low + (1.0 - 2.0 * low) * points[:, i]).tolist()
            places[1:, i] = [round(normal.inv_cdf(share), DIGITS) for share in shares]
    return places
