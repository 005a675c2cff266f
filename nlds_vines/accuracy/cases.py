"""What the methods are measured on: a system, a start, and a name for the two."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import brentq

from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import response, steady_state
from nlds_vines.model.system import System

PERIODS = 20
"""Forcing periods after which the error of the state is taken."""

STEEL = 2.1e11
"""Young's modulus of steel [Pa], for the damper's side of the contact as for the obstacle's."""

NEAR_GRAZING = 1e-6
"""How far, as a share of omega, the case `near-grazing` lies below the frequency of grazing."""


@dataclass(frozen=True)
class Case:
    """An orbit to be measured on: `start` is (x1, v1, x2, v2) [m, m/s] at t = 0, None for rest."""

    name: str
    system: System
    title: str
    start: tuple[float, ...] | None = None
    periods: int = field(default=PERIODS)

    @property
    def state(self) -> np.ndarray:
        """The start as an array (4,); (2,) without a damper."""
        if self.start is not None:
            return np.array(self.start)
        rest = np.zeros(4 if self.system.scene.damper else 2)
        if self.system.scene.rest is not None:
            rest[2] = self.system.scene.rest(self.system.parameters)
        return rest

    def to_table(self) -> Mapping[str, Any]:
        """Return the case as the archive keeps it: kind, all parameters, start, periods."""
        start = {} if self.start is None else {"start": list(self.start)}
        numbers = {name: float(value) for name, value in self.system.parameters.items()}
        return {"kind": self.system.kind, "periods": self.periods, **start, **numbers}


def of_system(system: System) -> Case:
    """Return the case of any system, from rest."""
    name = system.name or system.kind
    return Case(name, system, f"{system.title or name}, {_frequency(system)}, from rest")


def suite() -> Iterator[Case]:
    """Yield the cases that stand for all: soft, hard, two walls, grazing, no contact."""
    soft = load_system("ssul-set6", omega=6.28)
    yield of_system(soft)
    steel = soft.with_(E2=STEEL)
    yield Case("ssul-set6-steel", steel, f"the same, damper of steel (E2 = {STEEL:.2g} Pa)")
    yield of_system(load_system("ssbl", omega=6.05))
    yield near_grazing(soft)
    yield of_system(load_system("tmd", omega=6.28))


def near_grazing(system: System) -> Case:
    """Return a case of slow touches: the steady state that is just not free of impacts.

    Below the frequency at which the linear steady state grazes the wall it cannot exist; started
    on it there, the damper touches at a speed that vanishes with the distance to that frequency.
    """
    near = system.with_(omega=_grazing(system) * (1.0 - NEAR_GRAZING))
    start = tuple(float(value) for value in steady_state(near))
    title = f"{system.title or system.name}, on its steady state {NEAR_GRAZING:.0e} below grazing"
    return Case("near-grazing", near, title, start)


def _grazing(system: System) -> float:
    """Return the frequency [rad/s] above which the steady state clears the near wall for good."""
    p, gap = system.parameters, system.scene.gap_near
    assert gap is not None

    def excess(omega: np.ndarray) -> np.ndarray:
        return response(system, omega).shortening - gap(p)

    tried = np.sqrt(p["k1"] / p["m1"]) * np.linspace(0.5, 2.0, 1501)
    last = np.flatnonzero(excess(tried) > 0.0)[-1]
    return brentq(
        lambda omega: float(excess(np.array([omega]))[0]), *tried[last : last + 2], xtol=1e-14
    )


def _frequency(system: System) -> str:
    return f"ω = {system.parameters['omega']:g} rad/s"
