"""How finely an orbit is computed, and how many periods a verdict may take."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from nlds_vines.errors import RequestError, number, shown, whole
from nlds_vines.model.setting import Checked, OneOf, setting

METHODS = ("exact", "rk4")
"""The integrators."""

EFFORTS: Mapping[str, tuple[int, ...]] = {
    "quick": (),
    "standard": (600, 2400),
    "thorough": (600, 2400, 9600, 38400),
}
"""Forcing periods that a verdict may add to a scan's own, stage by stage, by name of the effort.

A periodic orbit that is found ends the search. Chaos and tori go through all stages: more effort
can find that they end."""


def most_watched(transient: int, periods: int, effort: str) -> int:
    """Return for how many forcing periods an orbit is watched that is not found to be periodic."""
    return transient + periods + sum(EFFORTS[effort])


TOLERANCES: Mapping[str, float] = {"draft": 1e-6, "standard": 1e-9, "fine": 1e-12}
"""Presets of the tolerance by name."""

TOLERANCE = TOLERANCES["standard"]
"""Relative error of a contact, by `exact`, which solves flights to round-off."""

LEAST_TOLERANCE, MOST_TOLERANCE = 1e-13, 1e-3
"""Below it is round-off; above it, nothing becomes cheaper."""

MOST_NODES = 60
"""Most collocation nodes: the tables of a short impact have room for so many."""

LEAST_STEPS = 3.0
"""Steps of a contact that `exact` takes where its tolerance would allow longer ones.

Of a free impact: beyond a third of it, what a step foresees is little."""

PERIOD_STEPS = 512.0
"""Runge-Kutta steps, of order four, of a forcing period, by `rk4`."""

STEPS_RATIO = 4.0
"""By `rk4`: steps of a forcing period for each step of a free impact."""

SHARE = 0.25
"""Of the tolerance, what one contact may take: several may follow each other in a period."""


@dataclass(frozen=True)
class Settings:
    """How finely a method computes: all that it discretizes.

    Attributes, of `exact`: relative `tolerance` of each contact; collocation `nodes` of every short
    impact and `contact_steps` of every other contact, where they are not left to the
    tolerance.  Of `rk4`: `period_steps` of a forcing period, and `contact_steps`.
    """

    tolerance: float = TOLERANCE
    nodes: int | None = None
    contact_steps: float | None = None
    period_steps: float = PERIOD_STEPS

    @classmethod
    def of(cls, method: str, tolerance: float = TOLERANCE) -> Settings:
        """Return those that a scan uses."""
        return cls(tolerance) if method == "exact" else cls.rk4(PERIOD_STEPS)

    @classmethod
    def rk4(cls, period_steps: float) -> Settings:
        """Return those of rk4 with so many steps of a period, and of contacts in proportion."""
        return cls(contact_steps=period_steps / STEPS_RATIO, period_steps=period_steps)

    @property
    def contact_tolerance(self) -> float:
        """Relative error that one contact may have."""
        return SHARE * self.tolerance

    @property
    def steps(self) -> float:
        """Steps of a contact, as set, or at least where the tolerance chooses them."""
        return LEAST_STEPS if self.contact_steps is None else self.contact_steps

    @property
    def stepped_to(self) -> float:
        """Tolerance that a stepped contact is held to; infinite where its steps are set."""
        return self.contact_tolerance if self.contact_steps is None else math.inf


def checked_tolerance(tolerance: object) -> float:
    """Return a tolerance, or that of a preset, otherwise raise `RequestError`."""
    if isinstance(tolerance, str) and tolerance in TOLERANCES:
        return TOLERANCES[tolerance]
    value = math.nan if isinstance(tolerance, str) else number("tolerance", tolerance)
    if not LEAST_TOLERANCE <= value <= MOST_TOLERANCE:
        raise RequestError(
            f"tolerance = {shown(tolerance)}; allowed: {LEAST_TOLERANCE:g} to "
            f"{MOST_TOLERANCE:g}, or {', '.join(TOLERANCES)}"
        )
    return value


_BY_HAND = ("nodes", "contact_steps", "period_steps")


def method_setting() -> Any:
    """Return the setting of a method; another one than that of a file has settings of its own."""
    words, gone = "`exact` or `rk4`", ("tolerance", *_BY_HAND)
    return setting(METHODS[0], OneOf(METHODS), "sampling", words, "METHOD", replaces=gone)


def tolerance_setting(table: str, default: float | None = None) -> Any:
    """Return the setting of a tolerance in a table of a request file."""
    presets = ", ".join(f"`{name}` ({value:g})" for name, value in TOLERANCES.items())
    words = f"of `exact`: relative error, {LEAST_TOLERANCE:g} to {MOST_TOLERANCE:g}, or {presets}"
    words += "; see [Accuracy](accuracy.md)"
    check = Checked(checked_tolerance)
    usual = "" if default is not None else "`standard`"
    return setting(default, check, table, words, "RELATIVE", usual=usual, replaces=_BY_HAND)


def checked_steps(name: str, steps: float) -> float:
    """Return a number of steps that is in range, otherwise raise `RequestError`."""
    value = number(name, steps)
    if not 4 <= value <= 1e6:
        raise RequestError(f"{name} = {steps!r}; allowed: 4 to 1e6")
    return value


FINENESS: Mapping[str, Callable[[Any], Any]] = {
    "tolerance": checked_tolerance,
    "nodes": lambda value: whole("nodes", value, 2, MOST_NODES),
    "contact_steps": lambda value: checked_steps("contact_steps", value),
    "period_steps": lambda value: checked_steps("period_steps", value),
}
"""The checks of what may be given of `Settings`, by name; all but the tolerance is for experts."""

_OF_RK4 = ("period_steps",)


def chosen_settings(method: str, options: Mapping[str, Any]) -> Settings:
    """Return the settings of a method, with the values of `options` that are not None.

    Raises `RequestError` for one that does not belong to the method, and for what is out of range.
    """
    asked = {name: value for name, value in options.items() if value is not None}
    for name in asked:
        if (name in _OF_RK4) != (method == "rk4"):
            owner, other = ("rk4", "tolerance") if name in _OF_RK4 else ("exact", "period_steps")
            raise RequestError(f"{name} is of method {owner!r}; {method!r} has {other}")
    values = {name: FINENESS[name](value) for name, value in asked.items()}
    if method == "rk4":
        return Settings.rk4(values.get("period_steps", PERIOD_STEPS))
    return Settings(**values)


def laid_over(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entries of two tables [sampling], those above first.

    What is below of `FINENESS` holds for the method it was given for, and what experts set there
    until a tolerance is asked for.
    """
    method = below.get("method", METHODS[0])
    outdated = FINENESS if "tolerance" in above or above.get("method", method) != method else ()
    return {name: value for name, value in below.items() if name not in outdated} | dict(above)
