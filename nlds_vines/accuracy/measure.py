"""One method at one setting on one case: errors of state, touches, energy and label; CPU time."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nlds_vines.accuracy import scipy_solver
from nlds_vines.accuracy.measured_cases import (
    Case,
    Course,
    Measured,
    Result,
    Setting,
    SolverFailure,
)
from nlds_vines.accuracy.reference import Truth, followed, truth_of
from nlds_vines.orbits.simulation import IntegrationError, simulate
from nlds_vines.runs.progress import Progress

EXACT = tuple(float(f"1e-{k}") for k in range(3, 14))
"""Settings of `exact` from coarse to fine: tolerances."""

RK4 = (64, 128, 256, 512, 1024, 2048, 4096, 8192)
"""Settings of `rk4`: steps of a period."""

REPEATS = 5
"""Runs whose median is the CPU time; one is enough where it takes `PATIENCE`."""

SHORTEST, PATIENCE = 0.05, 1.0
"""Seconds that a timed run takes at least, and from which on it is not repeated."""


@dataclass(frozen=True)
class Contender:
    """A method at a setting, ready to run: it compiles when it first meets a system.

    `follow` takes a case and whether touches are asked for beside the section.
    """

    setting: Setting
    follow: Callable[[Case, bool], Course]


def our_contenders(case: Case) -> Iterator[Contender]:
    """Yield our methods on a case, each from coarse to fine."""
    for tolerance in EXACT if case.system.scene.walls else EXACT[-1:]:
        words = f"tolerance {tolerance:.0e}" if case.system.scene.walls else "no contact"
        yield ours("exact", tolerance, words, tolerance=tolerance)
    for steps in RK4:
        yield ours("rk4", steps, f"{steps} steps", period_steps=float(steps))


def ours(method: str, value: float, words: str, **keywords: Any) -> Contender:
    """Return one of our methods at a setting; timed, it records the section alone, as all do."""
    keywords = {"method": method, **keywords}

    def follow(case: Case, observed: bool) -> Course:
        if observed:
            orbit = followed(case, **keywords)
        else:
            orbit = simulate(
                case.system, case.periods, start=case.start, record=["section"], **keywords
            )
        assert orbit.section is not None
        return Course(
            orbit.section, np.empty(0) if orbit.impacts is None else orbit.impacts["touch"]
        )

    return Contender(Setting(method, value, words, True), follow)


def scipy_contenders() -> Iterator[Contender]:
    """Yield SciPy's solver from coarse to fine."""
    for rtol in scipy_solver.SETTINGS:

        def follow(case: Case, observed: bool, rtol: float = rtol) -> Course:
            return scipy_solver.follow(case.system, case.periods, case.state, rtol)

        yield Contender(Setting(scipy_solver.NAME, rtol, f"rtol {rtol:.0e}", False), follow)


def contenders(case: Case, peers: bool) -> dict[str, list[Contender]]:
    """Return the contenders on a case by their method; SciPy's need `peers` and a damper."""
    methods: dict[str, list[Contender]] = {}
    others = scipy_contenders() if peers and case.system.scene.damper else ()
    for entry in (*our_contenders(case), *others):
        methods.setdefault(entry.setting.method, []).append(entry)
    return methods


def comparison(case: Case, methods: Mapping[str, Sequence[Contender]], quiet: bool) -> Measured:
    """Measure all contenders on a case; `quiet` shows no progress."""
    truth, results = truth_of(case), []
    with Progress(len(methods), "method", quiet=quiet) as progress:
        for method, entries in methods.items():
            results += [measured(truth, entry) for entry in entries]
            progress.note(1, method)
    return Measured(truth.known, tuple(results))


def measured(truth: Truth, contender: Contender) -> Result:
    """Return errors and CPU time of one contender, compilation apart."""
    try:
        course = contender.follow(truth.case, True)
        error = float(np.abs(course.section[-1] - truth.section[-1]).max())
        if not math.isfinite(error):
            return Result(contender.setting, failure="the state is not finite")
        missed, touch_error = _touches(course, truth)
        return Result(
            setting=contender.setting,
            error=error,
            touch_error=touch_error,
            missed=missed,
            seconds=seconds_of(truth.later, contender),
        )
    except (SolverFailure, IntegrationError) as failure:
        return Result(contender.setting, failure=str(failure))


def seconds_of(case: Case, contender: Contender) -> float:
    """Return the CPU time of a period [s]: median of runs that are long enough to be timed.

    Before each timed length the contender runs once, so that what it compiles is compiled.
    """
    _spent(replace(case, periods=2), contender)
    spent = _spent(case, contender)
    if spent < SHORTEST:  # once more, longer: what a call costs is spread over many periods
        longer = min(SHORTEST / max(spent, 1e-6), 1e4)
        # by powers of 2: some compile for a number of periods, and that is not to be timed
        case = replace(case, periods=case.periods * 2 ** math.ceil(math.log2(longer)))
        _spent(case, contender)
        spent = _spent(case, contender)
    times = [spent]
    if spent < PATIENCE:
        times += [_spent(case, contender) for _ in range(REPEATS)]
    return statistics.median(times) / case.periods


def _spent(case: Case, contender: Contender) -> float:
    began = time.process_time()
    course = contender.follow(case, False)
    spent = time.process_time() - began
    return course.seconds if course.seconds is not None else spent


def _touches(course: Course, truth: Truth) -> tuple[float, float]:
    """Return how many touches were missed and the largest error of their times [s].

    One that is nearer to another's time than to its own is another: missed, though their number
    may be right.
    """
    if truth.touches is None or course.touches is None:
        return math.nan, math.nan
    missed = len(truth.touches) - len(course.touches)
    if missed or not len(truth.touches):
        return float(missed), math.nan
    late = np.abs(course.touches - truth.touches)
    others = np.count_nonzero(late > 0.5 * np.diff(truth.touches).min(initial=math.inf))
    return (float(others), math.nan) if others else (0.0, float(late.max()))
