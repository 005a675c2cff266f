"""How finely an orbit is computed, and how many periods a verdict may take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    pass


METHODS = ("exact", "rk4")
"""The integrators."""

EFFORTS: Mapping[str, tuple[int, ...]] = {
    "quick": (),
    "standard": (600, 2400),
    "thorough": (600, 2400, 9600, 38400),
}
"""Forcing periods that a verdict may add to a scan's own, stage by stage, by name of the effort.

Only what a stage could not tell goes on to the next: more effort never changes a label, it can only
find one."""
NODES = 12

RESOLUTION: Mapping[str, float] = {"exact": 28.0, "rk4": 512.0}
"""Runge-Kutta steps: of a contact that must be stepped (exact), of a forcing period (rk4)."""


@dataclass(frozen=True)
class Settings:
    """How finely a method computes: all that it discretises.

    Attributes: collocation `nodes` of a short impact (exact alone); `resolution`, Runge-Kutta steps
    of what `RESOLUTION` says.
    """

    nodes: int
    resolution: float

    @classmethod
    def of(cls, method: str) -> Settings:
        """Return those that a scan uses."""
        return cls(NODES, RESOLUTION[method])

    def refined(self, method: str) -> Settings:
        """Return settings of so much smaller an error that the difference tells that of these.

        Of exact: 16 nodes for 12 (the error falls fivefold or more with each) and 40 steps for 28
        (of order eight: 17 times); of rk4: twice the steps (of order four: 16 times).
        """
        if method == "exact":
            return Settings(self.nodes + 4, self.resolution * 10 / 7)
        return Settings(self.nodes, self.resolution * 2)
