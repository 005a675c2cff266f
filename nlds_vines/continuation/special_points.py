"""Special points of a branch, and the first point of a branch that leaves one.

LP  fold              PD  period doubling         NS  torus (Neimark and Sacker)
BP  branch point      GR  grazing: an impact appears or vanishes
LIM the limit of a scene is touched
UZ  a monitor is zero
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from nlds_vines.continuation.arclength import Point, along, close, length, point_of
from nlds_vines.engine.section_map import Cycle, SectionMap, bordered, shifted

KINDS = ("LP", "PD", "NS", "BP", "GR", "LIM", "UZ")

NARROW = 1.0e-12  # weighted length of the last bracket
MOST_TRIALS = 80  # for one special point: usually 8 or 9, about 40 where the test function jumps

# Weighted distance of the first points that a branch point is extrapolated from; error at which it
# counts as located; and the most rounds.
ASIDE, ASIDE_ERROR, MOST_ROUNDS = 1.0e-3, 1.0e-12, 8

NEAREST = 1.0e-6  # weighted distance within which a period doubling is first searched for

Test = Callable[[Point], float]

# Distance along the branch of the trial with the smallest |test function|, its point, that modulus,
# and the width of the last bracket in units of the parameter. Of a BP, the last two are the
# differences of two extrapolations: in the weighted norm, and of the parameter.
Located = tuple[float, Point, float, float]


@dataclass(frozen=True, eq=False)
class Special:
    kind: str  # of `KINDS`
    point: Point
    before: str  # label along the branch
    after: str
    # (residual and bracket of a BP are those of `Located`)
    residual: float  # test function, relative to its size at the ends of the first bracket
    bracket: float  # width of the last bracket, in units of the parameter
    wall: str = ""  # of a GR whose impact is known: "near", "far" or "both"; "cell1+"
    index: int = 0  # of the preceding point of the branch
    monitor: str = ""  # of a UZ: `largest_force = 10000 N`, or the name of a function

    @property
    def value(self) -> float:  # of the parameter
        return self.point.value

    @property
    def impacts(self) -> int:
        """The impacts of its orbit; at a grazing, without the grazing one."""
        labels = (self.before, self.after)
        return min(int(label.split(",")[1].partition(" ")[0]) for label in labels)


def torus_pair(cycle: Cycle) -> tuple[complex, complex]:
    """Return the pair of multipliers with the product nearest to one; at a torus it is complex."""
    mu = cycle.multipliers.tolist()
    pairs = [(abs(mu[i] * mu[j] - 1.0), i, j) for i in range(len(mu)) for j in range(i)]
    _, i, j = min(pairs)
    return mu[i], mu[j]


def half_of(cycle: Cycle) -> np.ndarray:  # the state (size,) n/2 periods later minus the state
    return cycle.points[cycle.n // 2 - 1, : cycle.state.size] - cycle.state


def specials_between(section_map: SectionMap, a: Point, b: Point) -> list[Special]:
    """Return the special points between two neighboring points of a branch, in their order."""
    specials, far = list[tuple[float, Special]](), step_between(a, b)
    for kind in _changed(a, b):
        if kind == "BP":
            located = _branch_point(section_map, a, b)
        else:
            located = sign_change(section_map, kind, a, (a, b), (0.0, far))
        if located is None:  # a trial does not reach the branch: take the better of both points
            nearer = (0.0, a) if abs(a.tests[kind]) <= abs(b.tests[kind]) else (far, b)
            located = *nearer, 1.0, abs(b.value - a.value)
        place, point, residual, bracket = located
        if kind == "NS" and not torus_pair(point.cycle)[0].imag:
            continue  # a neutral saddle
        if kind == "BP" and not abs(point.cycle.multipliers - 1.0).min() < 0.1:
            continue  # a change of sign without a multiplier near one
        before, after = (a.cycle, b.cycle) if kind == "LP" else (point.cycle, point.cycle)
        labels = before.label, after.label
        specials.append((place, Special(kind, point, *labels, residual, bracket)))
    specials += _grazings(section_map, a, b)
    return [special for _, special in sorted(specials, key=lambda entry: entry[0])]


def _changed(a: Point, b: Point) -> Iterator[str]:
    """Yield the kinds whose test function changes its sign; of BP and LP together, BP alone."""
    branches = a.tests["BP"] * b.tests["BP"] < 0.0
    for kind in ("LP", "BP", "PD", "NS"):
        if a.tests[kind] * b.tests[kind] < 0.0 and not (kind == "LP" and branches):
            yield kind


def unexplained(a: Point, b: Point) -> bool:
    """Return True if more multipliers crossed the unit circle than the sign changes account for."""
    crossings = abs(b.cycle.unstable - a.cycle.unstable)
    kinds = set(_changed(a, b))
    explained = 2 * ("NS" in kinds) + len(kinds - {"NS"})
    return crossings > explained


def _branch_point(section_map: SectionMap, a: Point, b: Point) -> Located | None:
    """Locate a branch point between two points.

    Newton's matrix is singular there, so that Newton's method finds no sharp solution.  The point
    is the value at zero of a polynomial in the test function through points on both sides, which
    move closer until polynomials through six and four of them agree to ASIDE_ERROR.
    """
    signs = [(0.0, a.tests["BP"]), (step_between(a, b), b.tests["BP"])]
    aside, best = ASIDE, None
    for _ in range(MOST_ROUNDS):
        # the closest two pairs (distance, test function) of opposite sign
        pairs = [(p, q) for p, q in pairwise(sorted(signs)) if p[1] * q[1] < 0.0]
        (low, f_low), (high, f_high) = min(pairs, key=lambda pair: pair[1][0] - pair[0][0])
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


def sign_change(
    section_map: SectionMap,
    kind: str,
    start: Point,
    ends: tuple[Point, Point],
    between: tuple[float, float],
) -> Located | None:
    """Locate the sign change of a kind's test function between two distances from `start`."""
    size = max(abs(end.tests[kind]) for end in ends)

    def test(point: Point) -> float:
        return point.tests[kind] / size

    return narrowed_down(lambda step: along(section_map, start, step)[0], ends, between, test)


def doubling_near(
    section_map: SectionMap, place: np.ndarray, n: int, lengths: np.ndarray, most: float = NEAREST
) -> Point | None:
    """Return the period doubling of the nT orbit near `place` (size + 1,), at most `most` away."""
    row = np.eye(len(place))[-1]
    cycle, *_ = close(section_map, place, n, row, np.ones(len(place)))
    start = None if cycle is None else point_of(section_map, cycle, row, lengths)
    aside = min(NEAREST, most)
    while start is not None and aside <= most:
        low, high = (along(section_map, start, side * aside)[0] for side in (-1.0, 1.0))
        if low is None or high is None:
            return None
        doubling = sign_change(section_map, "PD", start, (low, high), (-aside, aside))
        if doubling is not None:
            return doubling[1]
        aside *= 4.0
    return None


def _grazings(section_map: SectionMap, a: Point, b: Point) -> Iterator[tuple[float, Special]]:
    """Yield the grazings between two points, as pairs of the distance from `a` and the grazing."""
    before, start, ahead = a, 0.0, step_between(a, b)
    for _ in range(MOST_TRIALS):
        counts = before.cycle.counts
        if counts == b.cycle.counts:
            return
        test = _grazing(before, b)
        located = narrowed_down(
            lambda step: along(section_map, a, step)[0], (before, b), (start, ahead), test
        )
        if located is None:
            return
        at, point, residual, bracket = located
        # the first point behind it with other impacts
        beyond, start, margin = b, ahead, 2.0 * NARROW
        while at + margin < ahead:
            behind, _ = along(section_map, a, at + margin)
            if behind is not None and behind.cycle.counts != counts:
                beyond, start = behind, at + margin
                break
            margin *= 4.0
        pairs = enumerate(zip(counts, beyond.cycle.counts, strict=True))
        wall = walls_in_words(section_map, [i for i, (one, other) in pairs if one != other])
        labels = before.cycle.label, beyond.cycle.label
        yield at, Special("GR", point, *labels, residual, bracket, wall)
        before = beyond


def walls_in_words(section_map: SectionMap, walls: Sequence[int]) -> str:
    names = section_map.scene.counted
    return "both" if len(walls) == len(names) == 2 else " and ".join(names[i] for i in walls)


def _grazing(before: Point, b: Point) -> Test:
    """Return the test function of grazing: positive with the impacts of `before`, else negative.

    Its modulus is the clearance, or with the grazing impact the squared approach speed of the
    softest, which is proportional to the depth of the free flight; both are one at the ends.
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
    """Return the value at 0 of the polynomial through `knots` (v, values), by Neville's scheme."""
    rows = [values for _, values in knots]
    for order in range(1, len(knots)):
        for i in range(len(knots) - order):
            low, high = knots[i][0], knots[i + order][0]
            rows[i] = (low * rows[i + 1] - high * rows[i]) / (low - high)
    return rows[0]


def step_between(a: Point, b: Point) -> float:
    """Return the weighted distance from a to b along the tangent of a."""
    return float((a.normal * (b.cycle.place - a.cycle.place)).sum())


def narrowed_down(
    onto: Callable[[float], Point | None],
    ends: tuple[Point, Point],
    between: tuple[float, float],
    test: Test,
) -> Located | None:
    """Locate a sign change of `test` between two points of a branch or curve.

    `onto` returns the point at a distance along the branch; `ends` are the two points at the
    distances `between`.  The method is the Illinois variant of false position, with bisection where
    that is slow.  Returns None if `test` has one sign at both ends or a trial has no point.
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


# ---- from a special point onto the branch that leaves it ----

# Largest and smallest weighted distance from the branch at which another one is searched for.
FIRST_ASIDE, LEAST_ASIDE = 1.0e-2, 1.0e-6

# A branch departs from its tangent by O(s^2) at arclength s, so at a distance `far` beside the
# tangent it is met only at s = O(sqrt(far)).  A point nearer than BENT sqrt(far) therefore lies on
# the other branch, at whatever angle the two cross.  A branch of twice the period leaves along the
# direction itself and is met within far / 2; the opposite direction holds the same orbits one
# period later, so that only one direction is tried.
BENT = 0.1

# The first point of another branch, and its weighted distance from the special point.
Offshoot = tuple[Point, float]


def null_vector(matrix: np.ndarray) -> np.ndarray:
    """Return the unit null vector of a nearly singular matrix by bordered inverse iteration."""
    size = len(matrix)
    vector, column = np.ones(size), np.ones((1, size))
    for _ in range(4):
        row = np.append(vector, 0.0)[np.newaxis]
        solution, _ = bordered(matrix, column, row, np.eye(size + 1)[-1])
        if solution is None:  # the border lies in the range: take another
            column = column * np.arange(1.0, size + 1.0)
            continue
        vector = solution[:-1] / math.sqrt(float((solution[:-1] * solution[:-1]).sum()))
    return vector


def doubled(section_map: SectionMap, point: Point) -> Offshoot | None:
    """Return the first orbit of twice the period beside a period doubling, if there is one."""
    cycle = point.cycle  # whose eigenvector of the multiplier -1 is the direction
    direction = np.append(null_vector(shifted(cycle.matrix, 1.0)), np.zeros(len(cycle.values)))
    return _beside(section_map, point, direction, 2 * cycle.n)


def other_branch(section_map: SectionMap, point: Point) -> Offshoot | None:
    """Return a point of the other branch through a branch point, if there is one."""
    # both tangents are null vectors of (M - I, slopes): take the one normal to that of this branch
    rows = np.column_stack([point.cycle.closing, point.cycle.slopes[0]])
    return _beside(section_map, point, null_vector(np.vstack([rows, point.normal])), point.cycle.n)


def _beside(
    section_map: SectionMap, point: Point, direction: np.ndarray, n: int
) -> Offshoot | None:
    """Search for another branch along `direction`, and its opposite if n is the point's own."""
    weights = point.weights
    direction = direction / length(weights, direction)
    far, doubles = FIRST_ASIDE, n > point.cycle.n
    while far >= LEAST_ASIDE:
        nearest = 0.5 * far if doubles else BENT * math.sqrt(far)
        for ahead in (direction,) if doubles else (direction, -direction):
            place = point.cycle.place + far * ahead
            row = weights * weights * ahead
            cycle, *_ = close(section_map, place, n, row, weights)
            if cycle is None or length(weights, cycle.place - place) > nearest:
                continue
            other = point_of(section_map, cycle, ahead, 1.0 / weights[-1:])
            if other is None:
                continue
            # an orbit of even n may be one of n / 2, run twice
            if not doubles or length(other.weights[:-1], half_of(other.cycle)) >= 0.1 * far:
                return other, far
        far *= 0.25
    return None
