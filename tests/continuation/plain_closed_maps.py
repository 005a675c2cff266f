"""Continuation of maps in closed form: special points, ends and branches are known exactly.

No equation of motion is integrated: a map stands in for that of a system, with its derivatives.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from math import acos, inf, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from nlds_vines.continuation import arclength, exploration, regime_borders, special_points
from nlds_vines.continuation.arclength import angle_of, close, length, point_of
from nlds_vines.continuation.branch_arm import Bounds, at_value, first_point, follow
from nlds_vines.engine.section_map import Cycle, SectionMap
from nlds_vines.errors import RequestError

MU = 1.0 + sqrt(6.0)
"""Where the orbit 2T of the logistic map doubles."""


@dataclass
class Map:
    """A map y -> f(y, p) of `size` numbers, a polynomial, with its derivatives by y and p.

    `touch`, if there is one, returns how deep a state goes into a wall: there is an impact where it
    is positive.
    """

    f: object
    size: int = 1
    touch: object = None
    is_rigid: bool = False
    limit: object = None
    calls: list = field(default_factory=list)
    since: int = 0
    """A map has no phase."""

    @property
    def scene(self):
        return SimpleNamespace(counted=("near", "far"), limit=self.limit)

    def speed(self, depth):
        """Return the speed of an impact: a kick moves orbits by as much, a force by its square."""
        return depth if self.is_rigid else sqrt(depth)

    def at(self, place, n):
        self.calls.append(n)
        y, p = place[: self.size].copy(), float(place[-1])
        matrix, slope, points, depths = np.eye(self.size), np.zeros(self.size), [], []
        for _ in range(n):
            aside = np.append(y, p)[:, np.newaxis] + 1e-100j * np.eye(self.size + 1)
            images = np.array(np.broadcast_arrays(*self.f(aside[:-1], aside[-1])))
            A, by_p = np.split(images.imag / 1e-100, [self.size], axis=1)
            matrix, slope = A @ matrix, A @ slope + by_p[:, 0]
            depths.append(self.touch(y, p) if self.touch else -inf)
            y = images[:, 0].real
            points.append(np.append(y, np.zeros(4 - self.size)))
        if not np.abs(y).max() < 1e6:
            return None
        mu = np.linalg.eigvals(matrix).astype(complex)
        hits, misses = [d for d in depths if d > 0.0], [-d for d in depths if d <= 0.0]
        return Cycle(
            state=place[: self.size].copy(), values=place[-1:].copy(), points=np.array(points),
            counts=(len(hits), 0), matrix=matrix, slopes=slope[np.newaxis],
            multipliers=mu[np.argsort(-np.abs(mu), kind="stable")],
            defect=float(np.abs(y - place[: self.size]).max()), span=1.0,
            clearance=min(misses, default=inf), slowest=min(map(self.speed, hits), default=inf),
            volume=0.0, norms=np.ones(self.size),
        )  # fmt: skip

    def weights(self, cycle, lengths):
        return np.append(np.ones(self.size), 1.0 / lengths)

    def place_of(self, value, state):
        return np.array([*state, value])

    def grazing_walls(self, cycle, name):
        return (0,)

    label_beyond = SectionMap.label_beyond

    def impacts(self, place, n):
        """Return no rows: an orbit has no flights, the longest of which it could be shot from."""
        return np.empty((0, 3))

    def measure(self, places, periods):
        return SimpleNamespace(violation=(places - self.limit)[:, [0, 0]])


LOGISTIC = Map(lambda y, p: p * y * (1.0 - y))
FOLD = Map(lambda y, p: y + p - y * y)
PITCHFORK = Map(lambda y, p: y + p * y - y**3)
DELAYED = Map(lambda y, p: (p * y[0] * (1.0 - y[1]), y[0]), size=2)
LOOP = Map(lambda y, p: y + 0.1 * (y * y + p * p - 0.25))
"""Its fixed points are a circle."""


def grazing(is_rigid=False, limit=None):
    """Return a map whose orbit x = p / 2 has an impact where x > 0.3."""
    return Map(
        lambda y, p: 0.5 * y + 0.25 * p,
        touch=lambda y, p: (d := float(y[0]) - 0.3) + d * d, is_rigid=is_rigid, limit=limit,
    )  # fmt: skip


def start_at(system, value, state, n=1, bounds=None, sign=1.0):
    """Return the first point of a branch, toward larger parameters or smaller ones."""
    bounds = bounds or Bounds(0.0, 1.0)
    cycle = at_value(system, np.array([*np.atleast_1d(state), value], dtype=float), n, value)
    return first_point(system, cycle, bounds, sign)


def arm_of(system, bounds, value, state, n=1, sign=1.0, **options):
    """Follow the branch of a state toward larger parameters or smaller ones, up to bounds."""
    bounds = Bounds(*bounds)
    return follow(system, start_at(system, value, state, n, bounds, sign), bounds, **options)


def explored(system, bounds, *seeds, **search):
    explorer = exploration.Explorer(system, Bounds(*bounds), **search)
    return explorer.run([(np.array(place, dtype=float), n) for place, n in seeds])


def test_newton_ends_where_there_is_no_orbit():
    row, weights = np.array([0.0, 1.0]), np.ones(2)
    nowhere = Map(lambda y, p: y + 1.0 + y * y)
    assert close(nowhere, np.array([0.1, 0.0]), 1, row, weights)[:2] == (None, inf)
    assert len(nowhere.calls) <= arclength.OF_BRANCH.most_steps
    # of steps 0.035, 0.041, 0.032 and 0.081, for there is no fixed point, the last ends it
    flat = Map(lambda y, p: y + 1e-3 + y**2)
    assert close(flat, np.array([0.05, 0.0]), 1, row, weights)[0] is None
    assert len(flat.calls) < arclength.OF_BRANCH.most_steps


def test_a_tangent_has_length_one_a_direction_and_angles_by_weights():
    for sign in (1.0, -1.0):
        point = start_at(LOGISTIC, 2.5, 0.6, bounds=Bounds(1.0, 3.0), sign=sign)
        assert length(point.weights, point.tangent) == pytest.approx(1.0, rel=1e-14)
        slope = point.tangent[0] / point.tangent[1]
        assert slope == pytest.approx(1.0 / 2.5**2, rel=1e-12)
        assert point.tangent[1] * sign > 0.0
        assert point.weights[-1] == 0.5
        falling = start_at(FOLD, 0.25, -0.5, sign=sign)
        assert falling.tangent[1] * sign > 0.0 > falling.tangent[0] * sign
    # a first point at a fold goes along the branch
    point = first_point(FOLD, FOLD.at(np.zeros(2), 1), Bounds(-1.0, 1.0), -1.0)
    assert point.tangent == pytest.approx([-1.0, 0.0], abs=1e-12)
    # the angle between tangents is measured by weights
    point = start_at(LOGISTIC, 2.5, 0.6, bounds=Bounds(1.0, 3.0))
    a = arclength.Point(point.cycle, np.array([1.0, 0.0]), np.array([1.0, 0.5]), 1.0)
    b = arclength.Point(point.cycle, np.array([1.0, 2.0]), np.array([1.0, 0.5]), 1.0)
    assert angle_of(a, b) == pytest.approx(acos(sqrt(0.5)), rel=1e-14)


def test_steps_lengthen_on_a_straight_branch_and_shorten_where_it_bends():
    straight = grazing()
    start = start_at(straight, 0.1, 0.05)
    stepper = arclength.Stepper(straight, start, 1e-4, 2e-3)
    lengths = [stepper.advance() and stepper.last_step for _ in range(8)]
    assert lengths[1] == pytest.approx(2e-4)
    assert max(lengths) == pytest.approx(2e-3)
    assert stepper.advance(1e-5)
    assert stepper.last_step == 1e-5
    start = start_at(FOLD, 0.01, 0.1, bounds=Bounds(-1.0, 1.0), sign=-1.0)
    stepper = arclength.Stepper(FOLD, start, 0.5, 0.5)
    for _ in range(20):
        before = stepper.point
        assert angle_of(before, stepper.advance()) <= arclength.SHARPEST * arclength.ANGLE


def test_special_points_are_located_with_their_kinds_labels_and_walls():
    # a fold is passed
    arm = arm_of(FOLD, (-1.0, 0.9), 0.5, sqrt(0.5), sign=-1.0)
    (fold,) = arm.specials
    assert fold.kind == "LP"
    assert abs(fold.value) < 1e-12
    assert abs(fold.point.cycle.state[0]) < 1e-9
    assert fold.bracket < 1e-11
    assert (arm.end, arm.points[-1].value) == ("bound", 0.9)
    assert arm.points[-1].cycle.state[0] == pytest.approx(-sqrt(0.9), rel=1e-12)
    # a doubling is located from both sides
    for value, sign in ((2.9, 1.0), (3.1, -1.0)):
        (doubling,) = arm_of(LOGISTIC, (2.5, 3.4), value, 1.0 - 1.0 / value, sign=sign).specials
        assert doubling.kind == "PD"
        assert abs(doubling.value - 3.0) < 1e-11
        assert doubling.residual < 1e-10
        assert (doubling.before, doubling.after) == ("T,0", "T,0")
    # a torus is located, and a neutral saddle is none
    arm = arm_of(DELAYED, (1.2, 2.2), 1.5, (1 / 3, 1 / 3))
    assert [special.kind for special in arm.specials] == ["NS"]
    assert abs(arm.specials[0].value - 2.0) < 1e-11
    saddle = Map(lambda y, p: ((2.0 + p) * y[0] + p, 0.5 * y[1] + p), size=2)
    arm = arm_of(saddle, (-0.2, 0.2), -0.1, (0.1 / 0.9, -0.2))
    assert arm.end == "bound"
    assert arm.specials == []  # at p = 0 the multipliers are 2 and 0.5
    # where two branches cross there is a branch point, and no fold
    (point,) = arm_of(PITCHFORK, (-0.5, 0.5), -0.3, 0.0).specials
    assert (point.kind, abs(point.value) < 1e-9) == ("BP", True)
    assert point.residual < 1e-8
    # a grazing has labels and a wall
    (up,) = arm_of(grazing(), (0.0, 1.0), 0.2, 0.1).specials
    (down,) = arm_of(grazing(), (0.0, 1.0), 0.9, 0.45, sign=-1.0).specials
    assert up.kind == down.kind == "GR"
    assert abs(up.value - 0.6) < 1e-11
    assert abs(down.value - 0.6) < 1e-11
    assert (up.before, up.after, up.wall, up.impacts) == ("T,0", "T,1", "near", 0)
    assert (down.before, down.after) == ("T,1", "T,0")


def test_small_tools_of_special_points():
    # the wall of a grazing is that whose impacts change
    walls = [special_points.walls_in_words(LOGISTIC, walls) for walls in ([0], [1], [0, 1])]
    assert walls == ["near", "far", "both"]
    # a null vector is hardly changed
    matrix = np.array([[2.0, -4.0], [1.0, -2.0 + 1e-14]])
    vector = special_points.null_vector(matrix)
    assert np.abs(matrix @ vector).max() < 1e-12
    assert float(vector @ vector) == pytest.approx(1.0, rel=1e-14)


def test_a_sign_change_is_narrowed_down_to_round_off():
    def test(point):
        return point.value**3 - 2.0

    tried = []

    def onto(step):
        tried.append(step)
        return SimpleNamespace(value=step)

    ends = SimpleNamespace(value=0.0), SimpleNamespace(value=4.0)
    place, point, residual, bracket = special_points.narrowed_down(onto, ends, (0.0, 4.0), test)
    assert place == point.value == pytest.approx(2.0 ** (1.0 / 3.0), abs=1e-12)
    assert 0.0 < bracket <= special_points.NARROW
    assert residual < 1e-11
    assert len(tried) <= 20
    jump = special_points.narrowed_down(
        onto, ends, (0.0, 4.0), lambda at: 1.0 if at.value < 1.2 else -1e-4
    )
    assert jump[0] == pytest.approx(1.2, abs=1e-12)
    assert jump[3] <= special_points.NARROW
    above = SimpleNamespace(value=2.0), SimpleNamespace(value=4.0)
    assert special_points.narrowed_down(onto, above, (2.0, 4.0), test) is None
    assert special_points.narrowed_down(lambda step: None, ends, (0.0, 4.0), test) is None


@pytest.mark.parametrize(
    ("system", "bounds", "start", "kind", "unstable"),
    [
        (DELAYED, (1.2, 2.2), (1.5, (1 / 3, 1 / 3)), "NS", 2),
        (LOGISTIC, (2.5, 3.4), (2.9, 1.9 / 2.9), "PD", 1),
    ],
)
def test_multipliers_that_cross_unseen_are_noticed(system, bounds, start, kind, unstable):
    points = arm_of(system, bounds, *start).points
    (pair,) = [(a, b) for a, b in pairwise(points) if a.cycle.unstable != b.cycle.unstable]
    assert pair[1].cycle.unstable == unstable
    assert not special_points.unexplained(*pair)
    for point in pair:
        point.tests[kind] = 1.0
    assert special_points.unexplained(*pair)


def logistic_2T(p):
    """Return a state of the orbit 2T of the logistic map."""
    return (p + 1.0 + sqrt((p - 3.0) * (p + 1.0))) / (2.0 * p)


def test_an_orbit_2T_ends_where_T_doubles_however_few_points_it_has():
    """It has become T there; of three points the polynomial is a straight line, 3e-5 off."""
    arm = arm_of(LOGISTIC, (2.5, 3.4), 3.2, logistic_2T(3.2), 2, -1.0)
    assert arm.end == "shorter"
    assert abs(arm.points[-1].value - 3.0) < 1e-7
    assert arm.specials == []
    arm = arm_of(LOGISTIC, (2.5, 3.45), 3.001, logistic_2T(3.001), 2, -1.0, first=0.008)
    assert (arm.end, len(arm.points)) == ("shorter", 3)
    assert abs(arm.points[-1].value - 3.0) < 1e-11
    assert arm.points[-1].cycle.defect < 1e-13


REQUEST = SimpleNamespace(along=SimpleNamespace(name="p", low=2.5, high=3.5), system=None)


@pytest.mark.parametrize(("off", "events"), [(0.0, (("PD", 3.0),)), (1e-4, ())])
def test_what_ends_an_orbit_at_a_border_is_located_or_not_said(off, events):
    """A branch 2T that has become T: the doubling is located at its end, or is not there."""
    values = np.array([3.0 + off, 3.05, 3.1])
    states = np.array([[1.0 - 1.0 / values[0]], *([logistic_2T(p)] for p in values[1:])])
    branch = SimpleNamespace(
        parameter=values, states=states, labels=np.array(["2T,0"] * 3), period=2,
        ends=("shorter", "bound"),
    )  # fmt: skip
    kinds = [("kind", "U3"), ("value", float), ("bracket", float), ("branch", int), ("index", int)]
    special = np.zeros(0, kinds).view(np.recarray)
    branches = SimpleNamespace(branches=(branch,), special_points=special, request=REQUEST)
    walk = regime_borders._walked(branches, LOGISTIC, 0, 1, 3.08, 2.9)
    assert [kind for kind, _ in walk.events] == [kind for kind, _ in events]
    assert [value for _, value in walk.events] == pytest.approx([v for _, v in events], abs=1e-11)
    assert (walk.alive, walk.is_explained) == (False, bool(events))


class Scan(dict):
    """Stands in for the open archive of a scan with two starts in each cell."""

    path, axes = "scan.h5", ("p",)

    def take(self, name, start=slice(None)):
        return self[name][:, start]


def test_borders_are_those_of_a_scans_first_start_along_its_only_axis(monkeypatch):
    monkeypatch.setattr(regime_borders, "map_of", lambda request: LOGISTIC)
    result = SimpleNamespace(request=REQUEST, branches=())
    scan = Scan(p=np.array([2.6, 2.7]))
    assert regime_borders.borders_of(result, scan) == []
    assert "holds no label" in next(regime_borders.report(result, scan, []))
    scan["label"] = np.array([["chaos", "T,0"], ["T,0", "T,0"]])
    scan["periodicity"] = np.array([[0, 1], [1, 1]])
    scan["orbit_point"] = np.full((2, 2, 1), 0.6)
    (border,) = regime_borders.borders_of(result, scan)
    assert (border.before, border.after) == ("chaos", "T,0")
    assert border.periodic == (False, True)  # the second start is periodic on both sides
    scan.axes = ("P",)
    with pytest.raises(RequestError, match="varies P, not p alone"):
        regime_borders.borders_of(result, scan)


def test_a_border_between_labels_of_one_orbit_names_the_transient():
    walk = regime_borders.Walk((), True, "T,1")
    border = regime_borders.Border(
        6.0, 6.1, "transient chaos to T,1", "T,1", walk, walk, (True, True)
    )
    assert border.words == "the same orbit: only the transient differs"


def test_a_branch_ends_at_a_bound_unstable_or_lost():
    for sign, value in ((1.0, 2.8), (-1.0, 2.2)):
        arm = arm_of(LOGISTIC, (2.2, 2.8), 2.5, 0.6, sign=sign)
        assert (arm.end, arm.points[-1].value) == ("bound", value)
        assert arm.points[-1].cycle.state[0] == pytest.approx(1.0 - 1.0 / value, rel=1e-13)
    # an unstable branch is followed no further than asked
    arm = arm_of(LOGISTIC, (2.5, 3.9), 2.9, 1.0 - 1.0 / 2.9, unstable=5)
    assert arm.end == "unstable"
    assert sum(point.cycle.unstable > 0 for point in arm.points) == 6
    # a branch that no orbit continues is lost
    cut = Map(LOGISTIC.f)
    plain = cut.at
    cut.at = lambda place, n: None if place[-1] > 2.7 else plain(place, n)
    arm = arm_of(cut, (2.2, 2.9), 2.5, 0.6)
    assert arm.end == "lost"
    assert arm.points[-1].value == pytest.approx(2.7, abs=1e-6)


def test_a_branch_ends_where_rigid_bodies_graze_or_its_limit_is_touched():
    rigid = grazing(is_rigid=True)
    for value, sign, labels in ((0.2, 1.0, ("T,0", "T,1")), (0.9, -1.0, ("T,1", "T,0"))):
        arm = arm_of(rigid, (0.0, 1.0), value, 0.5 * value, sign=sign)
        (end,) = arm.specials
        assert (arm.end, end.kind, end.wall) == ("grazing", "GR", "near")
        assert (end.before, end.after) == labels
        assert abs(end.value - 0.6) < 1e-9
        assert arm.points[-1].value == end.value
        assert end.index == len(arm.points) - 2
    # or where its limit is touched
    arm = arm_of(grazing(limit=0.4), (0.0, 1.0), 0.7, 0.35)
    (end,) = arm.specials
    assert (arm.end, end.kind) == ("limit", "LIM")
    assert abs(end.value - 0.8) < 1e-10
    assert arm.points[-1].value == end.value


def test_doublings_and_branch_points_lead_to_the_other_branch():
    cycle = LOGISTIC.at(np.array([2.0 / 3.0, 3.0]), 1)
    origin = point_of(LOGISTIC, cycle, np.array([0.0, 1.0]), np.ones(1))
    point, far = special_points.doubled(LOGISTIC, origin)
    x, p = point.cycle.place
    assert point.cycle.n == 2
    assert p > 3.0
    assert x in (pytest.approx(logistic_2T(p)), pytest.approx((p + 1.0) / p - logistic_2T(p)))
    assert 0.5 * far < abs(x - 2.0 / 3.0) < 2.0 * far
    # a doubling is looked for near a place and no farther
    for value, is_there in ((3.0 + 1e-5, True), (3.0 + 1e-3, False)):
        place = np.array([0.66, value])
        doubling = special_points.doubling_near(LOGISTIC, place, 1, np.ones(1), 1e-4)
        assert (doubling is not None) == is_there
        assert not is_there or abs(doubling.value - 3.0) < 1e-11
    # a branch point leads to the other branch
    cycle = PITCHFORK.at(np.zeros(2), 1)
    origin = arclength.Point(cycle, np.array([0.0, 1.0]), np.ones(2), 0.0)
    point, _ = special_points.other_branch(PITCHFORK, origin)
    x, p = point.cycle.place
    assert abs(x) > 1e-6
    assert p == pytest.approx(x * x, rel=1e-9)


def test_doublings_are_followed_as_often_as_asked():
    seed = (0.5, 2.0), 1
    for doublings, periods in ((0, [1]), (1, [1, 2]), (2, [1, 2, 4])):
        tracks = explored(LOGISTIC, (1.5, 3.5), seed, doublings=doublings)
        assert [track.n for track in tracks] == periods
    first, second, fourth = tracks
    assert (second.origin, second.parent, second.ends) == ("PD", 0, ("shorter", "bound"))
    assert first.specials[second.at].value == pytest.approx(3.0, abs=1e-11)
    assert second.points[0].value == first.specials[second.at].value
    assert (fourth.parent, second.specials[fourth.at].value) == (1, pytest.approx(MU, abs=1e-11))
    assert second.points[second.specials[0].index].value < MU
    assert second.points[second.specials[0].index + 1].value > MU


def test_tracks_of_both_directions_of_crossing_and_of_closed_branches():
    # both directions of a start are one track
    (track,) = explored(FOLD, (-1.0, 0.9), ((0.2, 0.04), 1))
    assert track.ends == ("bound", "bound")
    states = [point.cycle.state[0] for point in track.points]
    assert all(a < b for a, b in pairwise(states)) or all(a > b for a, b in pairwise(states))
    ahead = [float(p.tangent @ (q.cycle.place - p.cycle.place)) for p, q in pairwise(track.points)]
    assert min(ahead) > 0.0
    # a track is crossed where it has the parameter
    for state in (0.5, -0.5):
        (place,) = exploration.crossings(track, FOLD.at(np.array([state, 0.25]), 1))
        assert place == pytest.approx([state, 0.25], abs=1e-3)
    # branches that cross are both followed
    tracks = explored(PITCHFORK, (-0.5, 0.5), ((0.0, -0.3), 1))
    assert [track.origin for track in tracks] == ["start", "BP"]
    other = tracks[1]
    assert (other.parent, other.ends) == (0, ("bound", "bound"))
    assert {round(p.cycle.state[0], 6) for p in (other.points[0], other.points[-1])} == {
        round(sqrt(0.5), 6), -round(sqrt(0.5), 6)
    }  # fmt: skip
    assert other.points[0].value == other.points[-1].value == 0.5
    # a closed branch is followed once
    (track,) = explored(LOOP, (-0.52, 0.52), ((0.5, 0.0), 1))
    assert track.ends == ("closed", "closed")
    assert [special.kind for special in track.specials] == ["LP", "LP"]
    around = [np.arctan2(*p.cycle.place) for p in track.points]
    assert 2.0 * np.pi < np.abs(np.diff(np.unwrap(around))).sum() < 2.1 * np.pi


@pytest.mark.parametrize(
    ("system", "bounds", "place"),
    [
        (LOGISTIC, (1.5, 3.4), (0.5, 2.0)),
        (LOGISTIC, (1.5, 3.4), (1.0 - 1.0 / 3.2, 3.2)),
        (FOLD, (-1.0, 0.9), (0.2, 0.04)),
        (grazing(), (0.0, 1.0), (0.1, 0.2)),
        (grazing(), (0.0, 1.0), (0.4, 0.8)),
    ],
)
def test_a_special_point_lies_behind_the_point_of_its_index(system, bounds, place):
    (track,) = explored(system, bounds, (place, 1))
    assert track.specials
    for special in track.specials:
        a, b = track.points[special.index : special.index + 2]
        distances = [float(a.tangent @ (p.cycle.place - a.cycle.place)) for p in (special.point, b)]
        assert 0.0 <= distances[0] <= distances[1]
        labels = [p.cycle.label for p in (a, b)]
        assert special.kind == "LP" or [special.before, special.after] == labels


def test_a_start_on_a_known_branch_at_whatever_phase_is_not_followed_again():
    seeds = ((0.5, 2.0), 1), ((1.0 - 1.0 / 2.6, 2.6), 1), ((logistic_2T(3.2), 3.2), 2)
    other = 1.0 - logistic_2T(3.3) + 1.0 / 3.3, 3.3  # the other phase of 2T
    tracks = explored(LOGISTIC, (1.5, 3.4), *seeds, (other, 2))
    assert [track.n for track in tracks] == [1, 2]
    # orbits are one at whatever phase
    high = LOGISTIC.at(np.array([logistic_2T(3.3), 3.3]), 2)
    low = LOGISTIC.at(np.array([4.3 / 3.3 - logistic_2T(3.3), 3.3]), 2)
    fixed = LOGISTIC.at(np.array([1.0 - 1.0 / 3.3, 3.3]), 2)
    assert exploration.is_same(LOGISTIC, high, low)
    assert not exploration.is_same(LOGISTIC, high, fixed)
    # an orbit is followed as one of its least period
    for n, state, least in ((3, 0.6875, 1), (6, logistic_2T(3.2), 2)):
        (track,) = explored(LOGISTIC, (3.1, 3.3), ((state, 3.2), n))
        assert {point.cycle.n for point in track.points} == {least}


def test_a_track_is_the_same_recalled_or_from_its_arrays():
    computed = []
    arguments = LOGISTIC, Bounds(1.5, 3.5)
    seeds = [(np.array([0.5, 2.0]), 1)]

    def note(make):
        computed.append(make())
        return computed[-1]

    tracks = exploration.Explorer(*arguments, note, doublings=1).run(seeds)
    for count in range(len(computed) + 1):  # as after an interrupt at any place
        LOGISTIC.calls.clear()
        left = iter(computed[:count])
        explorer = exploration.Explorer(
            *arguments, lambda make, left=left: next(left, None) or make(), doublings=1
        )
        again = explorer.run(seeds)
        for one, other in zip(again, tracks, strict=True):
            assert one.values.tolist() == other.values.tolist()
            assert (one.origin, one.parent, one.at) == (other.origin, other.parent, other.at)
            assert one.ends == other.ends
    assert len(LOGISTIC.calls) < 40
    # from its arrays
    track = explored(LOGISTIC, (1.5, 3.5), ((0.5, 2.0), 1), doublings=1)[1]
    arrays = exploration.packed(track)
    again = exploration.packed(exploration.unpacked(arrays))
    assert all(np.array_equal(again[name], values) for name, values in arrays.items())
    for outcome in exploration.Switch:
        assert exploration.unpacked(exploration.packed(outcome)) is outcome
    assert isinstance(exploration.unpacked(arrays), exploration.Track)
