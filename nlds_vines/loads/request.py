"""A decay: dampers beside each other on a structure that is struck once, and how long they take."""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass
from typing import Any, ClassVar

import numpy as np

from nlds_vines.archives.provenance import Value
from nlds_vines.errors import RequestError, number, string, typed
from nlds_vines.model.setting import Checked, Real, Request, Whole, check_settings, entries, setting
from nlds_vines.model.system import System
from nlds_vines.orbits.settings import TOLERANCE, tolerance_setting
from nlds_vines.runs.manifest import DECAY

MOST_STATES = 10**7
"""States of a history: as many as a portrait may have."""

FORCES = ("P", "base_displacement", "base_acceleration")
"""The parameters of the harmonic force, which is off."""


def _blow(value: object) -> float:
    """Return the impulse of a blow [N s]; `RequestError` for none."""
    impulse = number("impulse", value)
    if not 1e-9 <= abs(impulse) <= 1e12:
        raise RequestError(f"impulse = {impulse!r}; allowed: 1e-9 to 1e12 N s, or less than -1e-9")
    return impulse


@typed
@dataclass(frozen=True, repr=False)
class Decay(Request):
    """What is struck, and how long it is watched; checked when made, immutable afterwards.

    At t = 0 the structure and the damper are at rest, and the blow gives m1 the velocity
    impulse / m1. The harmonic force is off.

    Arguments:
        title: one line for people.
        systems: one or more.

    and what the fields say of themselves.  Raises `RequestError` for anything else.
    """

    content: ClassVar[str] = DECAY

    title: str
    systems: tuple[System, ...]
    impulse: float = setting(
        MISSING, Checked(_blow), "load", "of the blow on m1 at t = 0 [N s]", "N_S"
    )
    duration: float = setting(60.0, Real(1e-6, 1e9), "sampling", "of the decay [s]", "SECONDS")
    samples: int = setting(
        64, Whole(8, 10**5), "sampling", "states in each natural period of the structure", "N"
    )
    tolerance: float | str = tolerance_setting("sampling", TOLERANCE)

    def __post_init__(self) -> None:
        """Check everything."""
        string("title", self.title)
        check_settings(self)
        still = tuple(map(self._still, self.systems))
        object.__setattr__(self, "systems", still)
        if not still:
            raise RequestError("no damper is named; allowed: one or more systems")
        names = [system.name for system in still]
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise RequestError(f"{twice} stands twice: give one of them another name")
        if self.windows * self.samples > MOST_STATES:
            raise RequestError(
                f"{self.windows} natural periods with {self.samples} states each; allowed: "
                f"{MOST_STATES} states"
            )

    def _still(self, system: System) -> System:
        """Return a system without its harmonic force."""
        off = dict.fromkeys((name for name in FORCES if name in system.parameters), 0.0)
        return system.with_(**off)

    @property
    def windows(self) -> int:
        """How many natural periods of the first structure the duration has, at least one."""
        first = self.systems[0].parameters
        period = 2 * math.pi * math.sqrt(first[mass_of(self.systems[0])] / first[spring_of(first)])
        return max(1, round(self.duration / period)) if math.isfinite(period) else 1

    @property
    def times(self) -> np.ndarray:
        """The times (windows samples + 1,) [s] of a history, the blow's first."""
        return np.linspace(0.0, self.duration, self.windows * self.samples + 1)

    @property
    def ends(self) -> np.ndarray:
        """The times (windows,) [s] up to which the dissipated energy is told."""
        return self.times[self.samples :: self.samples]

    @property
    def about(self) -> dict[str, Value]:
        """The attributes of its archive beside the request itself."""
        return {"impulse": self.impulse, "duration": self.duration}

    def document(self) -> dict[str, Any]:
        """Return the request file that means exactly this decay, complete, as nested tables."""
        return {
            "title": self.title,
            "systems": [system.to_table() for system in self.systems],
            "load": entries(self, "load"),
            "sampling": entries(self, "sampling"),
        }


def mass_of(system: System) -> str:
    """Return the name of the mass that is struck."""
    return "m1" if "m1" in system.parameters else "m"


def spring_of(parameters: Any) -> str:
    """Return the name of the spring that holds it."""
    return "k1" if "k1" in parameters else "k"
