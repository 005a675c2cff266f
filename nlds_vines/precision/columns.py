"""Columns of the tables that surveys fill."""

from __future__ import annotations

import numpy as np

from nlds_vines.record import Dataset

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
