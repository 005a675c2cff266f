"""The methods that are compared: ours and the solvers of others, each at several settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.accuracy.cases import Case
from nlds_vines.accuracy.reference import watched
from nlds_vines.accuracy.results import EXACT, RK4, Setting
from nlds_vines.accuracy.rivals import Asked, Course, Rival
from nlds_vines.orbits.simulation import simulate

Follow = Callable[[Case, bool | Asked], Course]
"""(what to follow, whether touches and E1max are asked for, or see `Asked`) -> what was found."""


@dataclass(frozen=True)
class Contender:
    """A method at a setting, ready to run: it compiles when it first meets a system."""

    setting: Setting
    follow: Follow


def contenders(case: Case, rivals: Iterable[Rival] = ()) -> Iterator[Contender]:
    """Yield the methods on a case, from coarse to fine: ours, then `rivals` if it has a damper."""
    for tolerance in EXACT if case.system.scene.walls else EXACT[-1:]:
        words = f"tolerance {tolerance:.0e}" if case.system.scene.walls else "no contact"
        yield ours("exact", tolerance, words, tolerance=tolerance)
    for steps in RK4:
        yield ours("rk4", steps, f"{steps} steps", period_steps=float(steps))
    if case.system.scene.damper:
        for rival in rivals:
            yield from of_rival(rival)


def of_rival(rival: Rival) -> Iterator[Contender]:
    """Yield a solver of others at all its settings, prepared once for each orbit."""
    prepared: dict[tuple[int, tuple[float, ...]], tuple[Any, Any]] = {}

    def following(value: float) -> Follow:
        def follow(case: Case, observed: bool | Asked) -> Course:
            key = id(case.system), tuple(case.state)
            if key not in prepared:  # the system stays, and so its identity is no other's
                prepared[key] = case.system, rival.prepare(case.system, case.state)
            return prepared[key][1](value, case.periods, observed)

        return follow

    for value in rival.settings:
        words = words_of(rival, value)
        order = math.nan if rival.order is None else rival.order
        yield Contender(Setting(rival.name, value, words, False, order), following(value))


def ours(method: str, value: float, words: str, **keywords: Any) -> Contender:
    """Return one of our methods at a setting; timed, it records the section alone, as all do."""
    keywords = {"method": method, **keywords}

    def follow(case: Case, observed: bool | Asked) -> Course:
        if observed:
            orbit = watched(case, **keywords)
        else:
            orbit = simulate(
                case.system, case.periods, start=case.start, record=["section"], **keywords
            )
        assert orbit.section is not None
        touches = orbit.impacts["touch"] if orbit.impacts is not None else np.empty(0)
        return Course(section=orbit.section, touches=touches, E1max=orbit.E1max)

    order = 4.0 if method == "rk4" else math.nan
    return Contender(Setting(method, value, words, True, order), follow)


def words_of(rival: Rival, value: float) -> str:
    """Return a setting of a solver of others in words."""
    return f"{value:g} steps" if rival.setting == "steps" else f"rtol {value:.0e}"
