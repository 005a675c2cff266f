"""Special points of a branch: where a test function changes its sign, or an impact appears.

    LP  fold              PD  period doubling         NS  torus (Neimark and Sacker)
    BP  branch point      GR  grazing: an impact appears or vanishes
    LIM the limit of a scene is touched

Each is bracketed between two points of the branch and narrowed down; every trial is brought onto
the branch by Newton's method, and its test function computed from its own matrix.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol, TypeVar

import numpy as np

from nlds_vines.continuation.arclength import Point, along, close, length, point_of
from nlds_vines.continuation.section_map import Cycle, SectionMap
from nlds_vines.model.labels import name_of

KINDS = ("LP", "PD", "NS", "BP", "GR", "LIM")

NARROW = 1.0e-12
"""Length of the last bracket, relative to the orbit and the interval of the parameter."""

ASIDE, ASIDE_ERROR, MOST_ROUNDS = 1.0e-3, 1.0e-12, 8
"""Distance of the first points between which a branch point is located; its error at which no
nearer ones are tried; and the most tries."""

NEAREST = 1.0e-6
"""Distance within which a doubling is looked for first, relative to the orbit and the interval."""

MOST_TRIALS = 80
"""Trials for one point; eight or nine are usual, forty where the function jumps."""

Test = Callable[[Point], float]


class Located(Protocol):
    """A point with a free parameter."""

    @property
    def value(self) -> float:
        """The parameter."""


P = TypeVar("P", bound=Located)


@dataclass(frozen=True, eq=False)
class Special:
    """One special point.

    Attributes:
        kind: of `KINDS`.
        point: of the branch.
        before, after: the labels along the branch.
        residual: the test function there, over its size at the ends of the first bracket.
        bracket: width of the last bracket, in units of the parameter.
        wall: of GR, that of the impact which appears or vanishes: "near", "far" or
            "both"; "" of others, or where it is not known.
        index: of the point of the branch that comes before it.
    """

    kind: str
    point: Point
    before: str
    after: str
    residual: float
    bracket: float
    wall: str = ""
    index: int = 0

    @property
    def value(self) -> float:
        """The parameter."""
        return self.point.value

    @property
    def impacts(self) -> int:
        """The impacts of its orbit, of the two at a grazing the fewer."""
        return min(int(label.split(",")[1]) for label in (self.before, self.after))


def is_torus(cycle: Cycle) -> bool:
    """Tell whether the pair of multipliers whose product is nearest to one is complex."""
    mu = cycle.multipliers.tolist()
    pairs = [(abs(mu[i] * mu[j] - 1.0), i) for i in range(len(mu)) for j in range(i)]
    return mu[min(pairs)[1]].imag != 0.0


def label_of_cycle(cycle: Cycle) -> str:
    """Return the label nT,k of an orbit."""
    return name_of(cycle.n, sum(cycle.counts))


def specials_between(section_map: SectionMap, a: Point, b: Point) -> list[Special]:
    """Return the special points between two neighboring points of a branch, in their order."""
    places: list[tuple[float, Special]] = []
    for kind in _changed(a, b):
        found = _located(section_map, kind, a, b)
        if found is not None:
            places.append(found)
    places.extend(_grazings(section_map, a, b))
    places.sort(key=lambda entry: entry[0])
    return [special for _, special in places]


def _changed(a: Point, b: Point) -> Iterator[str]:
    """Yield the kinds whose test functions differ in sign; of BP and LP together, BP alone."""
    branches = a.tests["BP"] * b.tests["BP"] < 0.0
    for kind in ("LP", "BP", "PD", "NS"):
        if a.tests[kind] * b.tests[kind] < 0.0 and not (kind == "LP" and branches):
            yield kind


def unexplained(a: Point, b: Point) -> bool:
    """Tell whether multipliers have crossed the unit circle unseen, as two do at one time."""
    crossings = abs(b.cycle.unstable - a.cycle.unstable)
    kinds = set(_changed(a, b))
    explained = 2 * ("NS" in kinds) + len(kinds - {"NS"})
    return crossings > explained


def _located(
    section_map: SectionMap, kind: str, a: Point, b: Point
) -> tuple[float, Special] | None:
    """Return the special point of a kind between two points, and how far from the first it is.

    Where no trial comes onto the branch, it is the nearer of the two, its bracket both.
    """
    if kind == "BP":
        found = _branch_point(section_map, a, b)
    else:
        found = _sign_change(section_map, kind, a, (a, b), (0.0, step_between(a, b)))
    if found is None:
        near = min((a, 0.0), (b, step_between(a, b)), key=lambda end: abs(end[0].tests[kind]))
        found = near[1], near[0], 1.0, abs(b.value - a.value)
    place, point, residual, bracket = found
    if kind == "NS" and not is_torus(point.cycle):
        return None  # a neutral saddle
    if kind == "BP" and not abs(point.cycle.multipliers - 1.0).min() < 0.1:
        return None
    label = label_of_cycle(a.cycle), label_of_cycle(b.cycle)
    if kind != "LP":
        label = (label_of_cycle(point.cycle),) * 2
    return place, Special(kind, point, *label, residual, bracket)


def _branch_point(
    section_map: SectionMap, a: Point, b: Point
) -> tuple[float, Point, float, float] | None:
    """Return a branch point between two points of a branch, as `narrowed_down` does.

    At it, no point of the branch is determined sharply: Newton's matrix is singular.  So it is
    extrapolated by a polynomial in the test function through points on both sides, to where that
    vanishes.  Nearer points around the last result are tried until two degrees agree to
    ASIDE_ERROR; of all tries the best counts.
    """
    signs = [(0.0, a.tests["BP"]), (step_between(a, b), b.tests["BP"])]
    aside, best = ASIDE, None
    for _ in range(MOST_ROUNDS):
        (low, f_low), (high, f_high) = _bracket(signs)
        place = low + (high - low) * f_low / (f_low - f_high)
        steps = [place + k * aside for k in (-3, 3, -2, 2, -1, 1)]
        points = [along(section_map, a, step)[0] for step in steps]
        knots = [(p.tests["BP"], p.cycle.place) for p in points if p is not None]
        signs += [(s, p.tests["BP"]) for s, p in zip(steps, points, strict=True) if p is not None]
        if len(knots) < len(steps) or not knots[4][0] * knots[5][0] < 0.0:
            aside *= 2.0 if best is None else 0.5
            continue
        at, before = limit_of(knots), limit_of(knots[2:])
        error = length(a.weights, at - before)
        if best is None or error < best[0]:
            best = error, place, at, abs(float((at - before)[-1])), knots[5][1] - knots[4][1]
        if error <= ASIDE_ERROR:
            break
        aside *= 0.5
    cycle = None if best is None else section_map.at(best[2], a.cycle.n)
    if best is None or cycle is None:
        return None
    # there are two tangents, and that of this branch is the secant of its nearest points
    error, place, _, width, ahead = best
    return place, Point(cycle, ahead / length(a.weights, ahead), a.weights, 0.0), error, width


def _bracket(signs: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the nearest two of (distance, test function) between which the sign changes."""
    ordered = sorted(signs)
    pairs = [[p, q] for p, q in pairwise(ordered) if p[1] * q[1] < 0.0]
    return min(pairs, key=lambda pair: pair[1][0] - pair[0][0])


def _sign_change(
    section_map: SectionMap,
    kind: str,
    start: Point,
    ends: tuple[Point, Point],
    between: tuple[float, float],
) -> tuple[float, Point, float, float] | None:
    """Return where the test function of a kind changes its sign, as `narrowed_down` does.

    Arguments: the point that distances along the branch are counted from; two points, and where
    they are.
    """
    size = max(abs(end.tests[kind]) for end in ends)
    return narrowed_down(
        lambda step: along(section_map, start, step)[0],
        ends,
        between,
        lambda point: point.tests[kind] / size,
    )


def doubling_near(
    section_map: SectionMap, place: np.ndarray, n: int, lengths: np.ndarray, most: float = NEAREST
) -> Point | None:
    """Return the period doubling of an nT orbit near a place; None where none is located.

    Arguments: the `place` (size + 1,) of an orbit nT, roughly; `lengths` (1,) of the parameter's
    interval; how far from there, at `most`, it may be along the branch.
    """
    row = np.zeros(len(place))
    row[-1] = 1.0
    cycle, _ = close(section_map, place, n, row, np.ones(len(place)))
    start = None if cycle is None else point_of(section_map, cycle, row, lengths)
    aside = min(NEAREST, most)
    while start is not None and aside <= most:
        low, high = (along(section_map, start, side * aside)[0] for side in (-1.0, 1.0))
        if low is None or high is None:
            return None
        found = _sign_change(section_map, "PD", start, (low, high), (-aside, aside))
        if found is not None:
            return found[1]
        aside *= 4.0
    return None


def _grazings(section_map: SectionMap, a: Point, b: Point) -> Iterator[tuple[float, Special]]:
    """Yield the grazings between two points, each with how far from `a` it is."""
    before, start = a, 0.0
    for _ in range(MOST_TRIALS):
        if before.cycle.counts == b.cycle.counts:
            return
        found = narrowed_down(
            lambda step: along(section_map, a, step)[0],
            (before, b),
            (start, step_between(a, b)),
            _grazing(before, b),
        )
        if found is None:
            return
        at, point, residual, bracket = found
        # the first symbol behind it
        beyond, start = _behind(section_map, a, b, at, before.cycle.counts)
        wall = wall_of_change(before.cycle.counts, beyond.cycle.counts)
        labels = label_of_cycle(before.cycle), label_of_cycle(beyond.cycle)
        yield at, Special("GR", point, *labels, residual, bracket, wall)
        before = beyond


def _behind(
    section_map: SectionMap, a: Point, b: Point, start: float, counts: tuple[int, int]
) -> tuple[Point, float]:
    """Return the nearest point found behind a grazing with others than `counts`, and where."""
    ahead, gap = step_between(a, b), 2.0 * NARROW
    while start + gap < ahead:
        point, _ = along(section_map, a, start + gap)
        if point is not None and point.cycle.counts != counts:
            return point, start + gap
        gap *= 4.0
    return b, ahead


def wall_of_change(before: tuple[int, int], after: tuple[int, int]) -> str:
    """Return the wall of the impact that differs."""
    if before[0] != after[0] and before[1] != after[1]:
        return "both"
    return "near" if before[0] != after[0] else "far"


def _grazing(before: Point, b: Point) -> Test:
    """Return the test function of grazing: positive with the impacts of `before`, else negative.

    On one side it is the smallest miss; on the other the depth that the softest impact would have
    on a free course, but for a factor, the square of its speed.
    """
    counts = before.cycle.counts
    gains = sum(b.cycle.counts) >= sum(counts)

    def size(cycle: Cycle, misses: bool) -> float:
        value = cycle.clearance if misses else cycle.slowest * cycle.slowest
        return value if 0.0 < value < float("inf") else 1.0

    unit = size(before.cycle, gains), size(b.cycle, not gains)

    def test(point: Point) -> float:
        if point.cycle.counts == counts:
            return size(point.cycle, gains) / unit[0]
        return -size(point.cycle, not gains) / unit[1]

    return test


def limit_of(knots: list[tuple[float, np.ndarray]]) -> np.ndarray:
    """Return the value at 0 of the polynomial through knots (v, values), by Neville's scheme."""
    rows = [values for _, values in knots]
    for order in range(1, len(knots)):
        for i in range(len(knots) - order):
            low, high = knots[i][0], knots[i + order][0]
            rows[i] = (low * rows[i + 1] - high * rows[i]) / (low - high)
    return rows[0]


def step_between(a: Point, b: Point) -> float:
    """Return how far b lies from a, along the tangent of a."""
    weights = a.weights * a.weights
    return float((weights * a.tangent * (b.cycle.place - a.cycle.place)).sum())


def narrowed_down(
    onto: Callable[[float], P | None],
    ends: tuple[P, P],
    between: tuple[float, float],
    test: Callable[[P], float],
) -> tuple[float, P, float, float] | None:
    """Return where a test function changes its sign between two points of a branch or a curve.

    Brackets are narrowed by false position (Illinois), and halved where that is slow.

    Arguments: `onto` returns the point at a distance along it, None where there is none; `ends`,
    the two points; `between` which distances they lie; the `test` function.

    Returns the distance, the point, the test function there, and the width of the bracket as the
    parameter has it; None where the function has one sign, or a trial does not come onto the
    branch.
    """
    (a, b), (low, high) = ends, between
    f_low, f_high = test(a), test(b)
    if not f_low * f_high <= 0.0:
        return None
    values = [a.value, b.value]
    best = (b, f_high, high) if abs(f_high) < abs(f_low) else (a, f_low, low)
    tried, halve, side, width = False, False, 0, high - low
    for _ in range(MOST_TRIALS):
        if high - low <= NARROW or f_low == 0.0 or f_high == 0.0:
            break
        share = 0.5 if halve else f_low / (f_low - f_high)
        trial = low + min(max(share, 1.0e-3), 1.0 - 1.0e-3) * (high - low)
        point = onto(trial)
        if point is None:
            return None
        f = test(point)
        if not tried or abs(f) <= abs(best[1]):
            best, tried = (point, f, trial), True
        if (f > 0.0) == (f_low > 0.0):
            low, f_low, values[0] = trial, f, point.value
            f_high, side = (0.5 * f_high if side < 0 else f_high), -1
        else:
            high, f_high, values[1] = trial, f, point.value
            f_low, side = (0.5 * f_low if side > 0 else f_low), 1
        halve = high - low > 0.5 * width
        width = high - low
    point, residual, place = best
    return place, point, abs(residual), abs(values[1] - values[0])
