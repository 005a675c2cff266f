"""Five cases that stand for all, and what is true of them: to 25 digits where these are stored."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from nlds_vines.accuracy.measured_cases import Case
from nlds_vines.accuracy.reference import BELIEVED, Truth, truth_of
from nlds_vines.errors import RequestError
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.linear_response import response, steady_state
from nlds_vines.model.system import System

STEEL = 2.1e11
"""Young's modulus of steel [Pa], for the damper's side of the contact as for the obstacle's."""

NEAR_GRAZING = 1e-6
"""How far, as a share of omega, the case `near-grazing` lies below the frequency of grazing."""

_STORED = Path(__file__).parents[2] / "data" / "reference" / "states.json"
_SAME = 1e-14  # relative, of parameters: K is computed from moduli, in some order


def suite() -> Iterator[Case]:
    """Yield the cases that stand for all: soft, hard, two walls, grazing, no contact."""
    soft = load_system("ssul-set6", omega=6.28)
    yield Case.of(soft)
    steel = soft.with_(E2=STEEL)
    yield Case("ssul-set6-steel", steel, f"the same, damper of steel (E2 = {STEEL:.2g} Pa)")
    yield Case.of(load_system("ssbl", omega=6.05))
    yield near_grazing(soft)
    yield Case.of(load_system("tmd", omega=6.28))


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


def known_truth(case: Case) -> Truth:
    """Return what is true of a case, to all digits of double precision where they are stored.

    Raises `RequestError` where nothing is, or where the digits are others than those found.
    """
    found, section = truth_of(case), stored_section(case)
    if section is None:
        return found
    if not np.abs(section[-1] - found.section[-1]).max() <= BELIEVED * found.known.growth:
        raise RequestError(f"{case.name}: the stored digits differ from what is found")
    doubt = float(np.spacing(np.abs(section[-1])).max())
    known = replace(found.known, source="stored, 25 digits", doubt=doubt)
    return replace(found, known=known, section=section)


def stored_section(case: Case) -> np.ndarray | None:
    """Return the stored 25-digit states of a case (periods, 4), rounded; None where there are none.

    They are known for some systems, from rest.
    """
    if case.start is not None:
        return None
    for entry in _stored().values():
        states = entry["states"]
        if _same(case.system, entry["parameters"]) and len(states) >= case.periods:
            rows = [states[str(n)]["y"] for n in range(1, case.periods + 1)]
            return np.array([[float(text) for text in row] for row in rows])
    return None


@cache
def _stored() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(_STORED.read_text(encoding="utf-8"))
    return found["cases"]


def _same(system: System, numbers: dict[str, Any]) -> bool:
    """Tell whether a system has the kind and the values of a stored entry; K stands for moduli."""
    if system.kind != numbers["kind"]:
        return False
    names = [name for name in numbers if name in system.scene.own or name == "K"]
    given = {**system.parameters, **({"K": system.K} if system.scene.walls else {})}
    return all(abs(given[name] - numbers[name]) <= _SAME * abs(numbers[name]) for name in names)
