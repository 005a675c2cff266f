"""What is uncertain, and the draws of it: the same for every design, from one seed.

A draw is a point of a scrambled Sobol sequence, whose coordinates are places on the distributions.
Source: A. B. Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998), as
SciPy's `qmc.Sobol` has it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from nlds_vines.errors import RequestError, choice, from_text, number, shown, table

NORMAL, UNIFORM = "normal", "uniform"

CUT = 3.0
"""A normal distribution ends at so many standard deviations: no draw makes a stiffness negative."""

DRAWS = 64
"""Draws where something is uncertain and their number is not given."""

FRESH_DRAWS = 1024
"""Draws at least by which an optimum is judged again: none of those that it was chosen by."""

FRESH_SEED = 2**32
"""What the seed of the fresh draws has more than that of the search, whose seeds are below it."""

MOST_DRAWS = 2**16
"""Draws at most, a power of two as all their numbers: only then are Sobol points even."""

DIGITS = 9
"""Decimals of a place on a normal distribution: libraries' logarithms differ in the last bit."""


@dataclass(frozen=True)
class Uncertain:
    """A parameter, or a number of a load, that is not known exactly.

    Arguments: its `name`; `spread`, the standard deviation of a normal distribution, or half the
    width of a uniform one: in per cent of the value where `relative`, else in SI units; the `law`.

    Raises `RequestError` for a spread that is not positive, and another law.
    """

    name: str
    spread: float
    relative: bool
    law: str = NORMAL

    def __post_init__(self) -> None:
        """Check everything."""
        choice(f"distribution of {self.name}", self.law, (NORMAL, UNIFORM))
        if not number(f"spread of {self.name}", self.spread) > 0.0:
            raise RequestError(f"spread of {self.name} = {self.spread!r} must be > 0")

    @classmethod
    def of(cls, name: str, entry: object) -> Uncertain:
        """Return what an entry of `[uncertain]` means: a spread, or a table with `spread`, `law`.

        A spread is a text as "5%", or a number in SI units.
        """
        given = dict(table(name, entry, ("spread", "law"))) if _is_table(entry) else {}
        spread = given.get("spread") if _is_table(entry) else entry
        law = given.get("law", NORMAL)
        if isinstance(spread, str) and spread.endswith("%"):
            return cls(name, from_text(float, f"spread of {name}", spread[:-1]), True, law)
        if isinstance(spread, str) or spread is None:
            raise RequestError(f"spread of {name} = {shown(spread)} must be as '5%', or a number")
        return cls(name, number(f"spread of {name}", spread), False, law)

    def entry(self) -> dict[str, Any]:
        """Return the table that means exactly this."""
        return {"spread": f"{self.spread!r}%" if self.relative else self.spread, "law": self.law}

    @property
    def reach(self) -> float:
        """The farthest place of a draw, in spreads."""
        return CUT if self.law == NORMAL else 1.0

    def at(self, values: Any, places: Any) -> Any:
        """Return what values become at places, in spreads from the middle."""
        scale = np.abs(values) / 100.0 if self.relative else 1.0
        return values + places * (self.spread * scale)

    def words(self) -> str:
        """Return it in a few words."""
        return f"{self.name} ±{self.spread:g}{' %' if self.relative else ''} ({self.law})"


def _is_table(entry: object) -> bool:
    return isinstance(entry, Mapping)


def places_of(uncertain: tuple[Uncertain, ...], draws: int, seed: int) -> np.ndarray:
    """Return the places (draws + 1, uncertain) of all draws, the first in the middle: as given.

    In spreads: from -1 to 1 evenly for a uniform distribution, for a normal one the quantiles of it
    cut at `CUT`.
    """
    found = np.zeros((draws + 1, len(uncertain)))
    if not (draws and uncertain):
        return found
    from scipy.stats import qmc

    points = qmc.Sobol(len(uncertain), scramble=True, seed=seed).random_base2(
        draws.bit_length() - 1
    )
    bell = NormalDist()
    low = bell.cdf(-CUT)
    for i, one in enumerate(uncertain):
        if one.law == UNIFORM:
            found[1:, i] = 2.0 * points[:, i] - 1.0
        else:
            shares = (low + (1.0 - 2.0 * low) * points[:, i]).tolist()
            found[1:, i] = [round(bell.inv_cdf(share), DIGITS) for share in shares]
    return found
