"""What the free movement behind a damper is worth: the tables of Figure 1c, of invented results."""

import numpy as np
import pytest

import nlds_vines as nv
from paper.claims.free_movement import LIMITS, best_within, passage, taken_by_set_6
from paper.claims.measured import Data, Missing
from paper.request import packaged_figures


def data(axes, energy, depth):
    violations = np.where(np.isfinite(depth), 3, 0)
    numbers = {"E1max": energy, "violation_depth": depth, "violations": violations}
    return Data(nv.load_system("ssul-set6"), axes, numbers)


def test_the_best_of_the_dampers_that_keep_a_limit_is_told():
    axes = {"k2": np.array([300.0, 400.0]), "c2": np.array([25.0, 50.0])}
    map_of = data(
        axes, np.array([[40.0, 60.0], [80.0, 90.0]]), np.array([[0.7, 0.35], [0.15, np.nan]])
    )
    assert passage(map_of).tolist() == [[0.7, 0.35], [0.15, 0.0]]
    rows = {row[0]: row[1:] for row in best_within(lambda name: map_of)}
    assert len(rows) == len(LIMITS)
    assert rows["0"] == ("90.0", "400", "50", "1 of 4")
    assert rows["0.2"] == ("80.0", "400", "25", "2 of 4")
    assert rows["0.4"] == ("60.0", "300", "50", "3 of 4")
    assert rows["0.8"] == ("40.0", "300", "25", "4 of 4")


def test_what_set_6_takes_is_told_where_tuned_at_its_peak_and_at_most():
    axes = {"omega": np.array([6.0, 6.28, 7.0]), "k1": np.array([3e4])}
    energy, depth = np.array([[500.0], [90.0], [200.0]]), np.array([[0.6], [0.5], [0.7]])
    study = data(axes, energy, depth)
    assert list(taken_by_set_6(lambda name: study)) == [
        ("30000", "500.0", "6", "0.500", "0.600", "0.700")
    ]
    off = data({**axes, "omega": np.array([6.0, 6.2, 7.0])}, energy, depth)
    with pytest.raises(Missing, match=r"6\.28"):
        list(taken_by_set_6(lambda name: off))


def test_the_studies_are_those_of_set_6_in_another_place():
    six = nv.load_system("ssul-set6").parameters
    for name in ("study-model-1c", "study-free-movement"):
        (request,) = (one for one in packaged_figures().values() if one.name == name)
        (scan,) = request.scans.values()
        p = scan.system.parameters
        assert scan.system.kind == "ssvi-c"
        assert p["L"] == 0.0
        assert {key: p[key] for key in six if key in p} == {k: v for k, v in six.items() if k in p}
