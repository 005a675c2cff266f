"""How the response of a structure to an impact damper is modulated: its amplitude, and 1:1 capture.

The amplitude is the modulus of Manevitch's variable over omega, sqrt(x^2 + (v / omega)^2): of a
harmonic motion of the frequency of the force it is constant.

Source: the criterion by impacts a period is that of Weidemann, Bergman, Vakakis, Krack: Nonlinear
Dyn. (2025), doi 10.1007/s11071-025-10928-4, for a free mass between two walls.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

CAPTURED, MORE = 1.99, 2.01
"""Impacts a period from which on the motion counts as sustained 1:1 resonance, and up to which."""

FLAGS: Mapping[str, int] = {
    "no_impacts": 0, "strongly_modulated": 1, "sustained_1_to_1": 2, "more_impacts": 3,
}  # fmt: skip
"""The kinds of response by impacts a period, as codes."""


def arrays_of(section: np.ndarray, omega: np.ndarray, counts: np.ndarray) -> dict[str, np.ndarray]:
    """Return the datasets of the record `modulation` by name, arrays (...).

    Arguments: the `section` (..., periods, components) of the sampled periods; `omega` (...)
    [rad/s]; `counts` (..., 3), impacts at either wall and the periods with two of them.
    """
    x, v = section[..., 0], section[..., 1] / omega[..., np.newaxis]
    amplitude, periods = np.sqrt(x * x + v * v), section.shape[-2]
    rate = counts[..., :2].sum(axis=-1) / periods
    return {
        "amplitude_min": amplitude.min(axis=-1),
        "amplitude_max": amplitude.max(axis=-1),
        "two_impacts": counts[..., 2] / periods,
        "capture": np.select([rate == 0.0, rate < CAPTURED, rate <= MORE], [0, 1, 2], 3),
    }
