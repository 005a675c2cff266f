"""What is told of a structure under a load in one number each: name, unit, words, symbol."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from nlds_vines.model.quantity import ERROR, Quantity

SHARES = (0.01, 0.1, 0.5)
"""The shares of the largest E1 of which the last times are told."""

WAYS = ("c1", "c2", "contact")
"""Where the energy goes: the dashpots, and what contacts dissipate."""


def _of(
    name: str, unit: str, words: str, label: str, symbol: str = "", scale: str = ""
) -> Quantity:
    return Quantity(name, unit, words, (), label, symbol, scale=scale)


def _last(share: float) -> Quantity:
    per_cent = f"{100 * share:g}"
    words = f"last time at which E1 exceeds {per_cent} % of its largest; NaN: it does at the end"
    return _of(f"last_{per_cent}", "s", words, f"time above {per_cent} % of the largest E1")


def _gone(part: str, what: str) -> Quantity:
    words = f"share of the energy that came in that {what} dissipated by the end"
    return _of(f"share_{part}", "1", words, f"share dissipated by {what}")


OF_LOADS = (
    *map(_last, SHARES),
    _of("damping_ratio", "1",
        "of a linear structure whose E1 falls from its largest to 10 % in the same time",
        "equivalent damping ratio", "ζ"),
    _of("E1max", "J", "largest energy of the structure, its velocity relative to the ground",
        "largest energy", "E₁max"),
    _of("E2max", "J", "largest energy of the damper, its velocity relative to the ground",
        "largest energy of the damper", "E₂max"),
    _of("x1_max", "m", "largest displacement of the structure, relative to the ground",
        "largest displacement"),
    _of("drift_max", "m", "largest displacement of the structure, relative to the moving ground",
        "largest drift"),
    _of("x1_rms", "m", "rms displacement of the structure, relative to the ground, without the "
        "time to settle", "rms displacement"),
    _of("v1_max", "m/s", "largest velocity of the structure, relative to the ground",
        "largest velocity"),
    _of("a1_max", "m/s^2", "largest absolute acceleration of the structure, contacts included",
        "largest absolute acceleration"),
    _of("stroke_max", "m", "largest stroke of the damper, counted from where its spring rests",
        "largest stroke"),
    _of("force_max", "N", "largest contact force", "largest contact force"),
    _of("impulse_max", "N s", "largest impulse of an impact", "largest impulse"),
    _of("impact_count", "1", "number of impacts", "impacts"),
    _of("energy_in", "J", "energy that came in, by the start and by the load", "energy brought in"),
    *(_gone(way, what)
      for way, what in zip(WAYS, ("dashpot c1", "dashpot c2", "contacts"), strict=True)),
    _of("balance", "1", "largest of abs(in - stored - dissipated) by the largest energy brought in",
        "error of the energy balance", scale=ERROR),
)  # fmt: skip
"""What is told of a structure and its damper, the most telling first."""

BY_NAME: Mapping[str, Quantity] = MappingProxyType({q.name: q for q in OF_LOADS})
"""The table by name."""
