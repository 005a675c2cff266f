"""What a row of measurements says: order, cost of an error, advice."""

import math

import pytest
from made_up_curves import curve, of_order, result

from benchmarks.accuracy.curves import Curve, above
from nlds_vines.accuracy.measured_cases import Result
from nlds_vines.accuracy.picture import front


@pytest.mark.parametrize("p", [1.5, 2.5, 4.0])
def test_the_order_is_the_slope(p):
    assert of_order(p).order == pytest.approx(p, rel=1e-9)


def test_the_order_of_a_tolerance_has_its_own_sign():
    found = curve([(rtol, 3 * rtol**0.8, 1.0) for rtol in (1e-4, 1e-6, 1e-8, 1e-10)])
    assert found.order == pytest.approx(0.8)


def test_the_ends_are_no_part_of_the_law():
    """Neither round-off nor errors as large as the orbit belong to the fit."""
    lawful = [(n, 10.0 * n**-4.0, 1.0) for n in (16, 32, 64, 128)]
    spoiled = [(2, 0.5, 1.0), *lawful, (1e5, 2e-15, 1.0)]
    assert curve(spoiled).order == pytest.approx(4.0)


def test_no_order_from_two_points():
    assert math.isnan(curve([(16, 1e-4, 1.0), (32, 1e-5, 1.0)]).order)


def test_costs_are_interpolated_by_logarithms():
    found = of_order(4.0)
    n = 100.0
    assert found.cost(0.1 * n**-4.0) == pytest.approx(1e-6 * n)


def test_costs_beyond_the_ends():
    found = curve([(1, 1e-3, 2.0), (2, 1e-6, 4.0)])
    assert found.cost(1.0) == pytest.approx(2.0)
    assert math.isinf(found.cost(1e-7))


def test_the_front_leaves_out_what_is_beaten():
    points = [(1e-3, 2.0), (1e-4, 1.0), (1e-6, 3.0), (1e-5, 5.0)]
    assert front(points) == [(1e-4, 1.0), (1e-6, 3.0)]


def test_above_names_who_is_cheaper():
    ours = curve([(1, 1e-3, 2.0), (2, 1e-13, 4.0)], "exact")
    quick = curve([(1, 1e-3, 1.0), (2, 2e-5, 8.0)], "quick")
    assert above([ours], ours) == []
    assert above([ours, quick], ours) == [("quick", 1e-3)]


def test_what_misses_touches_is_no_point():
    blind = result(8, 1e-9, 1e-9, missed=2.0)
    found = Curve("rk4", (*of_order(4.0).results, blind), 1e-15)
    assert found.points == of_order(4.0).points
    assert found.blind == [blind]
    assert found.order == pytest.approx(4.0)


def test_failures_are_no_points():
    found = curve([(1, 1e-3, 2.0)])
    failed = Curve("rk4", (*found.results, Result(found.results[0].setting, failure="no")), 1e-15)
    assert failed.points == found.points
