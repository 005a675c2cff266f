"""Curves of special points in the plane of two parameters: defining systems, steps, start points.

The unknowns are the state, at phase zero or in a flight between rigid impacts (`arclength`), and
both parameters; the equations are those of the orbit and one more.  For LP, PD and NS, the defining
system is minimally augmented: the further equation is g = 0, where g is the last unknown of the
singular matrix bordered by two vectors.  For GR, it is the gap of one pass, which is continuous
between a pass that misses and one that touches softly.

Under `restitution` an orbit is smooth only up to its grazing.  There the curve follows orbits whose
clearance is a small LEVEL, and the grazing orbit is extrapolated from each of them by a polynomial
in the clearance.

Sources: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, chapters 4 and 5;
Kuznetsov, Elements of Applied Bifurcation Theory, chapters 9 and 10.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from nlds_vines.continuation.arclength import (
    ANGLE,
    CLOSED,
    CONTRACTION,
    OF_CURVE,
    SHARPEST,
    Point,
    angle_of,
    best_map,
    better_map,
    close,
    length,
    place_at,
    real_product,
    seen_by,
    with_tangent,
)
from nlds_vines.continuation.special_points import (
    limit_of,
    narrowed_down,
    null_vector,
    step_between,
    torus_pair,
)
from nlds_vines.engine.section_map import Cycle, SectionMap, bordered, shifted

# relative distance in the parameter from a GR of the two orbits that calibrate its equation
BESIDE = 1.0e-7

# Clearance, relative to the orbit, of the orbits that are followed in place of those that graze
# rigid bodies; and the fractions of it from which the grazing orbit is extrapolated.
LEVEL, NEARER = 1.0e-3, (0.75, 0.5, 0.25)

SMOOTH = 1.0e-3  # largest weighted difference of two degrees of extrapolation at the grazing

# ---- defining systems ----

# Points of codimension two by the kind of the curve, with the condition that holds there.
# R1 to R4: the strong resonances 1:1 to 1:4; CP: cusp; LP-PD: fold-flip; GR-LP, GR-PD, GR-NS: a
# curve of folds, doublings or tori begins or ends on one of grazing.
CONDITIONS = {
    "LP": {"GR-LP": "grazing", "R1": "one", "LP-PD": "PD", "CP": "cusp"},
    "PD": {"GR-PD": "grazing", "R2": "minus one", "LP-PD": "LP"},
    "NS": {"GR-NS": "grazing", "R1": "0", "R2": "180", "R3": "120", "R4": "90"},
    "GR": {"GR-LP": "LP", "GR-PD": "PD", "GR-NS": "NS"},
}
COSINES = {"0": 1.0, "180": -1.0, "120": -0.5, "90": 0.0}


def singular_matrix(kind: str, cycle: Cycle) -> np.ndarray:
    if kind == "NS":
        return bialternate(cycle.matrix)
    return shifted(cycle.matrix, -1.0 if kind == "LP" else 1.0)


def bialternate(matrix: np.ndarray) -> np.ndarray:
    """Return M . M - I, where . is the bialternate product: its eigenvalues are mu_i mu_j - 1.

    Rows and columns are the pairs i > j; M . M has the minors m_ik m_jl - m_il m_jk.
    """
    pairs = [(i, j) for i in range(len(matrix)) for j in range(i)]
    product = np.empty((len(pairs), len(pairs)))
    for a, (i, j) in enumerate(pairs):
        for b, (k, m) in enumerate(pairs):
            product[a, b] = matrix[i, k] * matrix[j, m] - matrix[i, m] * matrix[j, k]
    return shifted(product, -1.0)


def augmented(kind: str, cycle: Cycle) -> Callable[[Cycle], float]:
    """Return g as a function of orbits near `cycle`, whose null vectors are the border."""
    matrix = singular_matrix(kind, cycle)
    right, left = null_vector(matrix), null_vector(matrix.T.copy())

    def function(other: Cycle) -> float:
        rows = np.append(right, 0.0)[np.newaxis]
        unit = np.eye(len(right) + 1)[-1]
        solution, _ = bordered(singular_matrix(kind, other), left[np.newaxis], rows, unit)
        return math.nan if solution is None else float(solution[-1])

    return function


# ---- along a curve ----

FIRST_STEP, LEAST_STEP, LONGEST_STEP = 1.0e-3, 1.0e-7, 2.0e-2  # weighted lengths along a curve
NEARBY = 1.0e-6  # weighted difference step of the gradient of a test function
MOST_POINTS = 400  # of a curve in one direction, by default

# reasons why a curve ends
ENDS = {
    "bound": "the end of an interval",
    "closed": "a closed curve",
    "neutral": "beyond a resonance 1:1 or 1:2 there are no tori, but neutral saddles",
    "lost": "Newton's method does not converge, or another impact grazes",
    "long": "it has more points than one curve may have",
}

Meeting = tuple[str, Point]  # a point of codimension two after its name, a key of `CONDITIONS`


@dataclass
class Curve:
    kind: str
    points: list[Point] = field(default_factory=list)
    meetings: list[Meeting] = field(default_factory=list)
    ends: tuple[str, str] = ("", "")


@dataclass
class Tracer:
    """Follows a curve of one kind; one of grazing rigid bodies on the side without the impact."""

    section_map: SectionMap  # at phase zero
    kind: str
    low: np.ndarray  # (2,) bounds of both parameters
    high: np.ndarray
    without: tuple[int, ...] = ()  # impacts without the grazing one
    touching: tuple[int, ...] = ()  # and with it
    softness: float = 0.0  # [s^2/m] depth of its free flight over its squared approach speed
    level: float = 0.0  # clearance [m] of the orbits that are followed; 0 unless bodies are rigid
    most: int = MOST_POINTS

    def _closed(
        self, cycle: Cycle, weights: np.ndarray, place: np.ndarray, row: np.ndarray, level: float
    ) -> tuple[Cycle | None, float, np.ndarray]:
        """Return the orbit of the curve in the plane through `place` normal to `row`.

        `cycle` is an orbit nearby, by which the further equation is bordered.
        """
        section_map = self.section_map.shot(cycle.since)

        def gap(orbit: Cycle) -> float:  # of the grazing pass, negative if it touches
            if orbit.counts == self.without:
                return orbit.clearance - level
            if orbit.counts == self.touching and not level:
                return -self.softness * orbit.slowest * orbit.slowest
            return math.nan

        residual = gap if self.kind == "GR" else augmented(self.kind, cycle)

        def equation(orbit: Cycle) -> tuple[float, np.ndarray] | None:
            gradient, here = np.empty(len(weights)), residual(orbit)
            for i in range(len(weights)):  # by one-sided differences
                step = NEARBY / weights[i]
                for sign in (1.0, -1.0):
                    nearby = orbit.place
                    nearby[i] += sign * step
                    other = section_map.at(nearby, orbit.n)
                    there = math.nan if other is None else residual(other)
                    if math.isfinite(there):
                        break
                gradient[i] = (there - here) / (sign * step)
            return (here, gradient) if np.isfinite(gradient).all() else None

        return close(section_map, place, cycle.n, row, weights, equation)

    def point(self, cycle: Cycle, toward: np.ndarray) -> Point | None:
        """Return the point of the curve near an orbit, its tangent turned `toward` a direction."""
        weights = self.section_map.weights(cycle, self.high - self.low)
        row = weights * weights * toward
        on_curve, _, rows = self._closed(cycle, weights, cycle.place, row, self.level)
        return None if on_curve is None else with_tangent(on_curve, rows, weights)

    def map_of(self, point: Point) -> SectionMap:
        return self.section_map.shot(point.cycle.since)

    def seen_by(self, after: SectionMap, point: Point) -> Point | None:
        """Return a point of the curve in the map `after`; None if its orbit is lost."""
        if after.since == point.cycle.since:
            return point
        seen = seen_by(self.map_of(point), after, point.cycle, point.tangent)
        if seen is None:
            return None
        cycle, direction = seen
        weights = self.section_map.weights(cycle, self.high - self.low)
        return Point(cycle, direction / length(weights, direction), weights)

    def along(self, point: Point, step: float) -> tuple[Point | None, float]:
        """Return the point of the curve a step ahead, and the contraction of Newton's method."""
        place = point.cycle.place + step * point.tangent
        near, weights = point.cycle, point.weights
        cycle, ratio, rows = self._closed(near, weights, place, point.normal, self.level)
        if cycle is None:
            return None, ratio
        weights = self.section_map.weights(cycle, self.high - self.low)
        return with_tangent(cycle, rows, weights), ratio

    def follow(self, start: Point) -> tuple[list[Point], list[Meeting], str]:
        """Follow the curve from a point along its tangent until it ends, for a reason of `ENDS`."""
        points, meetings, step = [start], list[Meeting](), FIRST_STEP
        while len(points) < self.most:
            a = points[-1]
            b, ratio = self.along(a, step)
            worst = math.inf  # the factor by which the step is too long
            if b is not None:
                # the gradient of a GR's equation has a kink, so its contraction does not count
                bent = 0.0 if self.kind == "GR" else math.sqrt(ratio / CONTRACTION)
                worst = max(bent, angle_of(a, b) / ANGLE)
            if b is None or (worst > SHARPEST and step > 2.0 * LEAST_STEP):
                step *= 0.5
                if step < LEAST_STEP:
                    return points, meetings, "lost"
                continue
            inside = (self.low <= b.cycle.values) & (b.cycle.values <= self.high)
            if not inside.all():
                end = self._on_bound(a, b)
                if end is not None:
                    meetings.extend(self.meetings(a, end, step_between(a, end)))
                    points.append(end)
                return points, meetings, "bound"
            meetings.extend(self.meetings(a, b, step))
            better = better_map(self.map_of(b), b.cycle)
            points.append(b if better is None else self.seen_by(better, b) or b)
            if self.kind == "NS" and not torus_pair(b.cycle)[0].imag:
                return points, meetings, "neutral"
            if self._is_back(points):
                return points, meetings, "closed"
            step = min(LONGEST_STEP, step * min(2.0, max(0.5, 1.0 / max(worst, 1.0e-3))))
        return points, meetings, "long"

    def _on_bound(self, a: Point, b: Point) -> Point | None:
        """Return the point of the curve on the first bound that it crosses between two points."""
        size, before, after = a.cycle.state.size, a.cycle.values, b.cycle.values
        bounds = np.where(after > self.high, self.high, self.low)
        out = np.flatnonzero((after < self.low) | (after > self.high))
        share, axis = min((float((bounds - before)[i] / (after - before)[i]), int(i)) for i in out)
        place = a.cycle.place + share * (b.cycle.place - a.cycle.place)
        place[size + axis] = bounds[axis]
        # by this row, Newton's method keeps the value of the bounded parameter
        row = np.eye(len(place))[size + axis]
        cycle, *_ = self._closed(a.cycle, a.weights, place, row, self.level)
        return None if cycle is None else Point(cycle, row / a.weights, a.weights)

    def finished(self, point: Point) -> Point | None:
        """Return a point of the curve at phase zero; None if its orbit is lost on the way there."""
        if not self.level:
            return self.seen_by(self.section_map, point)
        # an orbit beside the grazing of rigid bodies becomes the grazing one
        cycle, row = point.cycle, point.normal
        here, knots = self.map_of(point), list[tuple[float, np.ndarray]]()
        for share in (1.0, *NEARER):
            if knots:
                level = share * self.level
                nearer, *_ = self._closed(cycle, point.weights, cycle.place, row, level)
                if nearer is None:
                    return None
                cycle = nearer
            place = place_at(here, cycle.place, cycle.n)
            if place is None:
                return None
            knots.append((cycle.clearance, place))
        place, size = limit_of(knots), self.section_map.size
        if length(point.weights, place - limit_of(knots[1:])) > SMOOTH:
            return None  # between them, an impact passes phase zero
        grazes = replace(cycle, state=place[:size], values=place[size:], clearance=0.0, since=0.0)
        return Point(grazes, point.tangent, point.weights)

    def meetings(self, a: Point, b: Point, step: float) -> list[Meeting]:
        """Return the points of codimension two between two points."""
        meetings = list[Meeting]()
        # on a curve of rigid grazing there are none: other curves end on the side with the impact
        for name, condition in () if self.level else CONDITIONS[self.kind].items():

            def test(point: Point, condition: str = condition) -> float:
                if condition == "grazing":
                    return 1.0 if point.cycle.counts == a.cycle.counts else -1.0
                return self._condition(condition, point)

            if not test(a) * test(b) < 0.0:
                continue
            place = narrowed_down(lambda s: self.along(a, s)[0], (a, b), (0.0, step), test)
            if place is None:
                continue
            mu = place[1].cycle.multipliers.tolist()
            # no neutral saddle, which has no curve of tori
            if (self.kind, name) != ("GR", "GR-NS") or any(abs(m.imag) > 1.0e-6 for m in mu):
                meetings.append((name, place[1]))
        return meetings

    def _condition(self, condition: str, point: Point) -> float:
        """Return the test function of a condition of `CONDITIONS`."""
        mu = point.cycle.multipliers.tolist()
        if condition in COSINES:  # of the pair on the unit circle
            return 0.5 * sum(torus_pair(point.cycle)).real - COSINES[condition]
        if condition in ("one", "minus one"):  # without the multiplier critical on the curve
            target = 1.0 if condition == "one" else -1.0
            rest = sorted(mu, key=lambda m: abs(m - target))[1:]
            return real_product([m - target for m in rest])
        if condition == "cusp":
            return self._bend(point)
        if condition == "LP":
            return real_product([m - 1.0 for m in mu])
        return point.tests[condition]

    def _bend(self, point: Point) -> float:
        """Return the quadratic coefficient of the map along the null vector of a fold."""
        cycle = point.cycle
        matrix = singular_matrix("LP", cycle)
        right, left = null_vector(matrix), null_vector(matrix.T.copy())
        size, images = len(right), []
        unit = 1.0e-4 / length(point.weights[:size], right)
        for sign in (1.0, -1.0):
            place = cycle.place
            place[:size] += sign * unit * right
            other = self.map_of(point).at(place, cycle.n)
            if other is None:
                return math.nan
            images.append(other.points[-1, :size])
        bend = images[0] + images[1] - 2.0 * cycle.points[-1, :size]
        sign = 1.0 if float((left * right).sum()) >= 0.0 else -1.0
        return sign * float((left * bend).sum()) / (unit * unit)

    def _is_back(self, points: list[Point]) -> bool:
        """Return True if the curve is back at its first point, at any phase of the orbit."""
        if len(points) < 5:
            return False
        first, a, b = points[0], points[-2], points[-1]
        before, now = (
            place_at(self.map_of(p), p.cycle.place, p.cycle.n, first.cycle.since) for p in (a, b)
        )
        if before is None or now is None:
            return False
        size = first.cycle.state.size
        step = length(a.weights, now - before)
        for point in first.cycle.points:
            place = np.concatenate([point[:size], first.cycle.values])
            if length(a.weights, place - now) < 0.6 * step:
                return True
        return False


# ---- the first point of a curve ----


def calibrated(tracer: Tracer, place: np.ndarray, n: int) -> Tracer | None:
    """Return the tracer of a curve of grazing, calibrated by the orbits on both sides of a GR."""
    size = tracer.section_map.size
    sides: list[Cycle] = []
    for sign in (1.0, -1.0):
        start = place.copy()
        start[size] += sign * BESIDE * max(abs(place[size]), 1.0e-3)
        cycle = _closed_at(tracer.section_map, start, n)
        if cycle is None:
            return None
        sides.append(cycle)
    without, touching = sorted(sides, key=lambda cycle: sum(cycle.counts))
    gained = [j - i for i, j in zip(without.counts, touching.counts, strict=True)]
    if sum(map(abs, gained)) != 1:
        return None
    softness = without.clearance / (touching.slowest * touching.slowest)
    return replace(tracer, without=without.counts, touching=touching.counts, softness=softness)


def _closed_at(section_map: SectionMap, place: np.ndarray, n: int) -> Cycle | None:
    """Return the orbit near a place at its parameters; None if there is none."""
    row = np.eye(section_map.size + 2)[-2:]
    for _ in range(OF_CURVE.most_steps):
        cycle = section_map.at(place, n)
        if cycle is None or cycle.defect < CLOSED:
            return cycle
        right = np.concatenate([-cycle.residual, [0.0, 0.0]])
        step, _ = bordered(cycle.closing, cycle.slopes, row, right)
        if step is None or not np.isfinite(step).all():
            return None
        place = place + step
    return None


def beside(tracer: Tracer, place: np.ndarray, n: int, impacts: int) -> Tracer | None:
    """Return the tracer of a curve of rigid grazing; move `place` to an orbit beside it."""
    section_map, size = tracer.section_map, tracer.section_map.size
    unit = max(abs(place[size]), 1.0e-3)
    for step in (BESIDE * unit * 10.0**i for i in range(5)):
        for sign in (1.0, -1.0):  # the orbit without the impact exists on one side
            start = place.copy()
            start[size] += sign * step
            cycle = _closed_at(section_map, start, n)
            if cycle is None or sum(cycle.counts) != impacts or not cycle.clearance > 0.0:
                continue
            weights = section_map.weights(cycle, tracer.high - tracer.low)
            place[:] = cycle.place
            level = LEVEL / float(weights[section_map.of_gap])
            return replace(tracer, without=cycle.counts, level=level)
    return None


def trace_curve(tracer: Tracer, place: np.ndarray, n: int, impacts: int) -> Curve | None:
    """Return the curve through a special point, in both directions, if it can be followed."""
    if tracer.kind == "GR":
        place = place.copy()
        search = partial(beside, impacts=impacts) if tracer.section_map.is_rigid else calibrated
        of_grazing = search(tracer, place, n)
        if of_grazing is None:
            return None
        tracer = of_grazing
    # its first point, with one of the parameters increasing along it: the second if possible, as
    # the curve crosses the branch
    zero, size = tracer.section_map, tracer.section_map.size
    here = best_map(zero, place, n)
    there = place_at(zero, place, n, here.since)
    cycle = None if there is None else here.at(there, n)
    if cycle is None:
        return None
    starts = (tracer.point(cycle, np.eye(size + 2)[axis]) for axis in (size + 1, size))
    start = next((start for start in starts if start is not None), None)
    if start is None:
        return None
    ahead, meetings, end = tracer.follow(start)
    behind, others, other_end = [start], list[Meeting](), end
    if end != "closed":
        back = Point(start.cycle, -start.tangent, start.weights)
        behind, others, other_end = tracer.follow(back)
    points = [tracer.finished(point) for point in (*reversed(behind[1:]), *ahead)]
    whole = [point for point in points if point is not None]
    return Curve(tracer.kind, whole, [*reversed(others), *meetings], (other_end, end))
