"""Methods, their tolerances and steps, and the effort of a verdict."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from nlds_vines.errors import RequestError, number, shown, whole
from nlds_vines.model.setting import Checked, OneOf, setting

METHODS = ("exact", "rk4")  # the integrators

# Forcing periods of each stage that a verdict may add to those of a scan, by effort.  A periodic
# orbit ends the search; chaos and tori go through all stages, which may show that they end.
EFFORTS: Mapping[str, tuple[int, ...]] = {
    "quick": (),
    "standard": (600, 2400),
    "thorough": (600, 2400, 9600, 38400),
}


def most_watched(transient: int, periods: int, effort: str) -> int:
    """Return the number of forcing periods after which an orbit counts as not periodic."""
    return transient + periods + sum(EFFORTS[effort])


# The presets of the tolerance, and the default: the relative error of a contact, of `exact`;
# flights are exact to round-off.
TOLERANCES: Mapping[str, float] = {"draft": 1e-6, "standard": 1e-9, "fine": 1e-12}
TOLERANCE = TOLERANCES["standard"]

# Bounds of the tolerance: the errors below are round-off; larger ones save no time.
LEAST_TOLERANCE, MOST_TOLERANCE = 1e-13, 1e-3

MOST_NODES = 60  # largest number of collocation nodes, the size of the tables of a short impact

# Least number of steps of `exact` in a contact, per free impact: a Taylor step predicts no more
# than a third of one.
LEAST_STEPS = 3.0

PERIOD_STEPS = 512.0  # default number of Runge-Kutta steps per forcing period
STEPS_RATIO = 4.0  # steps of `rk4` per forcing period for each step of a free impact
SHARE = 0.25  # share of the tolerance that one contact may use, as several may follow in a period


@dataclass(frozen=True)
class Settings:
    """The tolerance and the steps of a method; None leaves them to the tolerance."""

    tolerance: float = TOLERANCE  # of `exact`: relative error of a contact
    nodes: int | None = None  # of `exact`: collocation nodes of a short impact
    contact_steps: float | None = None  # of other contacts
    period_steps: float = PERIOD_STEPS  # of `rk4`, per forcing period

    @classmethod
    def of(cls, method: str, tolerance: float = TOLERANCE) -> Settings:
        """Return the settings of scans."""
        return cls(tolerance) if method == "exact" else cls.rk4(PERIOD_STEPS)

    @classmethod
    def rk4(cls, period_steps: float) -> Settings:
        return cls(contact_steps=period_steps / STEPS_RATIO, period_steps=period_steps)

    @property
    def contact_tolerance(self) -> float:
        return SHARE * self.tolerance

    @property
    def steps(self) -> float:
        """The steps of a contact, or the least number if the tolerance chooses them."""
        return LEAST_STEPS if self.contact_steps is None else self.contact_steps

    @property
    def stepped_to(self) -> float:
        """The tolerance of a stepped contact; inf if its steps are set."""
        return self.contact_tolerance if self.contact_steps is None else math.inf


def checked_tolerance(tolerance: object) -> float:
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
    """Return the setting of a method; overriding it drops the tolerance and steps of the file."""
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
    value = number(name, steps)
    if not 4 <= value <= 1e6:
        raise RequestError(f"{name} = {steps!r}; allowed: 4 to 1e6")
    return value


# the checks of the fields of `Settings` by name
FINENESS: Mapping[str, Callable[[Any], Any]] = {
    "tolerance": checked_tolerance,
    "nodes": lambda value: whole("nodes", value, 2, MOST_NODES),
    "contact_steps": lambda value: checked_steps("contact_steps", value),
    "period_steps": lambda value: checked_steps("period_steps", value),
}


def chosen_settings(method: str, options: Mapping[str, Any]) -> Settings:
    """Return the settings of a method with the `options` that are not None, validated."""
    present = {name: value for name, value in options.items() if value is not None}
    for name in present:
        of_rk4 = name == "period_steps"
        if of_rk4 != (method == "rk4"):
            owner, other = ("rk4", "tolerance") if of_rk4 else ("exact", "period_steps")
            raise RequestError(f"{name} is of method {owner!r}; {method!r} has {other}")
    values = {name: FINENESS[name](value) for name, value in present.items()}
    if method == "rk4":
        return Settings.rk4(values.get("period_steps", PERIOD_STEPS))
    return Settings(**values)
