"""The window functions of spectra."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np


class Taper(NamedTuple):
    """A window function: its name in SciPy, and how many bins a line reaches to either side."""

    scipy: str
    reach: int


TAPERS: Mapping[str, Taper] = {"rectangular": Taper("boxcar", 0), "hann": Taper("hann", 1)}
"""Window functions.  Rectangular: a line on a bin fills that bin; one between two bins leaks far.
Hann: a line on a bin fills three bins; one between two bins leaks little."""


def weights_of(window: str, count: int) -> np.ndarray:
    """Return the window's weights, periodic ones as a discrete transform needs them.

    Performance: SciPy's signals take longer to import than the first orbit to be followed.
    """
    if window == "rectangular":
        return np.ones(count)
    from scipy.signal import windows

    make: Callable[..., np.ndarray] = getattr(windows, TAPERS[window].scipy)
    return make(count, sym=False)
