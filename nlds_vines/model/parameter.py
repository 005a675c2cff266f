"""One parameter: its name, symbol, unit, meaning and allowed range."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.errors import RequestError


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter: what it means and which finite values are allowed.

    Attributes:
        name: as in files, archives and Python.
        symbol: as in formulas and pictures.
        unit: SI; "1" for a number without a unit.
        meaning: in words.
        low, high: the allowed range, `low` <= value <= `high`.
        above: whether `low` itself is excluded.
    """

    name: str
    symbol: str
    unit: str
    meaning: str
    low: float = -inf
    high: float = inf
    above: bool = False

    def dataset(self, dims: tuple[str, ...], prefix: str = "") -> Dataset:
        """Return the dataset of its values; before its name stands `prefix`."""
        return Dataset.real(f"{prefix}{self.name}", dims, self.unit, self.meaning)

    def scale(self, values: np.ndarray, prefix: str = "") -> Scale:
        """Return the dimension along which it has these values."""
        return Scale(f"{prefix}{self.name}", values, self.unit, self.meaning)

    @property
    def allowed(self) -> str:
        """The allowed range in words, for messages and documentation: `> 0 and finite`."""
        if self.high < inf:
            return f"from {self.low:g} to {self.high:g}"
        if self.low > -inf:
            return f"{'>' if self.above else '>='} {self.low:g} and finite"
        return "finite"

    def accepts(self, values: np.ndarray) -> np.ndarray:
        """Return whether `values` are allowed, element by element, in the same shape.

        NaN is never allowed.
        """
        bottom = values > self.low if self.above else values >= self.low
        return bottom & (values <= self.high) & np.isfinite(values)

    def check(self, values: np.ndarray) -> None:
        """Raise `RequestError` for the first of `values` (any shape) outside the range, if any."""
        wrong = ~self.accepts(values)
        if np.any(wrong):
            given = float(values[wrong].flat[0])
            unit = f" [{self.unit}]" if self.unit != "1" else ""
            raise RequestError(
                f"{self.name} = {given!r} is not allowed: "
                f"{self.name} ({self.meaning}){unit} must be {self.allowed}"
            )
