"""One contender on one case: errors of state, touches, energy and label, and CPU time."""

from __future__ import annotations

import math
import statistics
import time
from dataclasses import dataclass, replace

import numpy as np

from nlds_vines.accuracy.cases import Case
from nlds_vines.accuracy.contenders import Contender
from nlds_vines.accuracy.reference import Reference
from nlds_vines.accuracy.results import Result
from nlds_vines.accuracy.rivals import Asked, Course, RivalFailure
from nlds_vines.kernels.recurrence import period_of
from nlds_vines.orbits.classification import classify
from nlds_vines.orbits.simulation import IntegrationError

REPEATS = 5
"""Runs whose median is the CPU time; one is enough where it takes `PATIENCE`."""

SHORTEST, PATIENCE = 0.05, 1.0
"""Seconds that a timed run takes at least, and from which on it is not repeated."""

LOOKED_AT = 24
"""Periods from a point of the true orbit in which a label is looked for, at least four of its n."""

RETURN = 1e-3
"""Of a recurrence, relative to the orbit: the eye of a reader of a bifurcation diagram."""


@dataclass(frozen=True)
class Truth:
    """A case, what is true of it, and a case that begins on its steady orbit."""

    case: Case
    reference: Reference
    label: str
    steady: Case | None


def truth_of(case: Case, reference: Reference) -> Truth:
    """Return a case with its label, and the point on its orbit from which labels are judged.

    Where both methods do not find the same label there is none to judge by.
    """
    try:
        regime = classify(case.system, start=case.start)
        other = classify(case.system, start=case.start, method="rk4")
    except IntegrationError:
        return Truth(case, reference, "unknown: it ends later on", None)
    if regime.label != other.label:
        words = f"uncertain: {regime.label} by exact, {other.label} by rk4"
        return Truth(case, reference, words, None)
    if regime.point is None:
        return Truth(case, reference, regime.label, None)
    periods = max(LOOKED_AT, 4 * regime.period)
    start = tuple(float(value) for value in regime.point)
    return Truth(case, reference, regime.label, replace(case, start=start, periods=periods))


def measured(truth: Truth, contender: Contender, asked: Asked = Asked.ALL) -> Result:
    """Return errors and CPU time of one contender, compilation apart.

    `asked` says whether E1max counts, which costs others several runs.
    """
    case, reference = truth.case, truth.reference
    try:
        course = contender.follow(case, asked)
        error = _largest(course.section[-1] - reference.section[-1])
        if not math.isfinite(error):
            return Result(contender.setting, failure="the state is not finite")
        missed, touch_error = _touches(course, reference)
        return Result(
            setting=contender.setting,
            error=error,
            touch_error=touch_error,
            missed=missed,
            energy_error=math.nan if not course.E1max else abs(course.E1max - reference.E1max),
            label=_label(truth.steady, contender),
            seconds=seconds_of(truth.steady or case, contender),
            steps=math.nan if course.steps_in_contact is None else course.steps_in_contact,
        )
    except (RivalFailure, IntegrationError) as failure:
        return Result(contender.setting, failure=str(failure))


def seconds_of(case: Case, contender: Contender) -> float:
    """Return the CPU time of a period [s]: median of runs that are long enough to be timed.

    On a steady orbit all periods cost the same, however many are run.  Before each timed length
    the contender runs once, so that what it compiles is compiled.
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


def _touches(course: Course, reference: Reference) -> tuple[float, float]:
    """Return how many touches were missed and the largest error of their times [s].

    One that is nearer to another's time than to its own is another: missed, though their number
    may be right.
    """
    if reference.touches is None or course.touches is None:
        return math.nan, math.nan
    missed = len(reference.touches) - len(course.touches)
    if missed or not len(reference.touches):
        return float(missed), math.nan
    late = np.abs(course.touches - reference.touches)
    others = np.count_nonzero(late > 0.5 * np.diff(reference.touches).min(initial=math.inf))
    return (float(others), math.nan) if others else (0.0, float(late.max()))


def _label(steady: Case | None, contender: Contender) -> str:
    """Return the label that the contender gives to the orbit that begins on the true one."""
    if steady is None:
        return ""
    course = contender.follow(steady, Asked.TOUCHES)
    n = int(period_of(np.ascontiguousarray(course.section), RETURN))
    if n == 0:
        return "undetermined"
    name = "T" if n == 1 else f"{n}T"
    if course.touches is None:
        return f"{name},?"
    cycles = steady.periods // (2 * n)
    since = (steady.periods - cycles * n) * steady.system.period
    return f"{name},{round(np.count_nonzero(course.touches >= since) / cycles)}"


def _largest(values: np.ndarray) -> float:
    return float(np.abs(values).max())
