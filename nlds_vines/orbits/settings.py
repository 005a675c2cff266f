"""How finely an orbit is computed, and how many periods a verdict may take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from nlds_vines.errors import RequestError, number, whole

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


NODES = 12
"""Collocation nodes of a short impact, by `exact`: local errors below 1e-9."""

MOST_NODES = 64
"""Most collocation nodes: the tables of a short impact have room for so many."""

CONTACT_STEPS = 28.0
"""Runge-Kutta steps, of order eight, of a contact that `exact` steps."""

PERIOD_STEPS = 512.0
"""Runge-Kutta steps, of order four, of a forcing period, by `rk4`."""

STEPS_RATIO = 4.0
"""By `rk4`: steps of a forcing period for each step of a free impact."""


@dataclass(frozen=True)
class Settings:
    """How finely a method computes: all that it discretises.

    Attributes: collocation `nodes` of a short impact (exact alone); `contact_steps`, Runge-Kutta
    steps of a contact that is stepped; `period_steps`, those of a forcing period (rk4 alone).
    """

    nodes: int = NODES
    contact_steps: float = CONTACT_STEPS
    period_steps: float = PERIOD_STEPS

    @classmethod
    def of(cls, method: str) -> Settings:
        """Return those that a scan uses."""
        return cls() if method == "exact" else cls.rk4(PERIOD_STEPS)

    @classmethod
    def rk4(cls, period_steps: float) -> Settings:
        """Return those of rk4 with so many steps of a period, and of contacts in proportion."""
        return cls(contact_steps=period_steps / STEPS_RATIO, period_steps=period_steps)

    def refined(self, method: str) -> Settings:
        """Return finer settings: the difference of two runs is then nearly the error of these.

        Of exact: 16 nodes for 12 (the error falls fivefold or more with each) and 40 steps for 28
        (of order eight: 17 times); of rk4: twice the steps (of order four: 16 times).
        """
        if method == "exact":
            return Settings(self.nodes + 4, self.contact_steps * 10 / 7)
        return Settings.rk4(self.period_steps * 2)


def chosen_settings(
    method: str, contact_steps: float | None, period_steps: float | None, nodes: int | None
) -> Settings:
    """Return the settings of a method with those replaced that are given.

    Raises `RequestError` for one that does not belong to the method, and for steps beyond reason.
    """
    settings = Settings.of(method)
    if period_steps is not None:
        if method != "rk4":
            raise RequestError(f"period_steps is of method 'rk4'; {method!r} has contact_steps")
        settings = Settings.rk4(checked_steps("period_steps", period_steps))
    if contact_steps is not None:
        if method != "exact":
            raise RequestError(f"contact_steps is of method 'exact'; {method!r} has period_steps")
        steps = checked_steps("contact_steps", contact_steps)
        settings = replace(settings, contact_steps=steps)
    return (
        settings if nodes is None else replace(settings, nodes=whole("nodes", nodes, 2, MOST_NODES))
    )


def checked_steps(name: str, steps: float) -> float:
    """Return a number of Runge-Kutta steps that is in range, otherwise raise `RequestError`."""
    found = number(name, steps)
    if not 4 <= found <= 1e6:
        raise RequestError(f"{name} = {steps!r}; allowed: 4 to 1e6")
    return found
