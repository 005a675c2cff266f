"""What was measured, as plain data: a setting of a method, and what came of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives.dataset import Dataset

DIMS = ("row",)
"""The one dimension of a table."""


def column(name: str, dtype: str, units: str, long_name: str) -> Dataset:
    """Return a column of a table: NaN, 0 or nothing where there is no value."""
    fills: dict[str, float | int | str] = {"str": "", "float64": np.nan}
    return Dataset(name, DIMS, dtype, units, long_name, fills.get(dtype, 0))


def status_column() -> Dataset:
    """Return the column that every table has: whether there is a measurement in the row."""
    flags = {"ok": 0, "failed": 1}
    return Dataset("status", DIMS, "int8", "1", "whether the measurement was made", 0, flags)


EXACT = (
    (4, 4),
    (5, 8),
    (6, 14),
    (7, 18),
    (8, 20),
    (9, 22),
    (10, 24),
    (11, 26),
    (12, 28),
    (13, 32),
    (14, 36),
    (16, 44),
    (18, 56),
    (20, 72),
)
"""Settings of `exact` from coarse to fine: nodes of a short impact, steps of a stepped contact."""

RK4 = (64, 128, 256, 512, 1024, 2048, 4096, 8192)
"""Settings of `rk4`: steps of a period."""


@dataclass(frozen=True)
class Setting:
    """A method at one setting.

    Attributes:
        method: its name, one curve of the picture.
        value: the setting as a number: nodes, steps of a period, or rtol.
        words: the same in words.
        ours: whether it is of this program.
        order: the method's on smooth equations, NaN where it has none.
    """

    method: str
    value: float
    words: str
    ours: bool
    order: float = math.nan


@dataclass(frozen=True)
class Result:
    """What was measured of a method at a setting, on one case.

    Attributes:
        error: of the last state, largest of x1, v1, x2, v2 [m, m/s].
        touch_error: of the times of touch, the largest [s]; NaN where their numbers differ, or
            where there are none.
        missed: touches of the truth less those found: negative where some were invented; NaN
            where this way of using the solver cannot tell.
        energy_error: of E1max over the last half of the periods [J].
        label: `nT,k` as a recurrence over some periods from a point of the true orbit tells it;
            empty where the truth is not periodic.
        seconds: CPU time per forcing period [s], of all threads.
        steps: of a contact, as the method itself counts them; NaN where it does not.
        failure: why there is nothing of all this; empty where there is.
    """

    setting: Setting
    error: float = math.nan
    touch_error: float = math.nan
    missed: float = math.nan
    energy_error: float = math.nan
    label: str = ""
    seconds: float = math.nan
    steps: float = math.nan
    failure: str = ""

    @property
    def complete(self) -> bool:
        """Whether no touch was missed or invented, as far as can be told."""
        return not self.failure and (math.isnan(self.missed) or self.missed == 0)
