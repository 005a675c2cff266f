"""What claims are measured by: motions in portraits, the free movement behind a damper."""

import numpy as np
import paper_results
import pytest

import nlds_vines as nv
from nlds_vines.orbits.simulation import IntegrationError
from nlds_vines.portrait.request import load_portrait
from nlds_vines.portrait.run import views_of
from paper import motion
from paper.claims import Data, Missing
from paper.claims.free_movement import LIMITS, best_within, passage, taken_by_set_6
from paper.motion import motion_of, motions_of
from paper.request import load_figure, packaged_figures

SHORT = {"sampling": {"samples": 64, "transient": 2000, "periods": 48}}
SYSTEM = {"system": "ssul-set6", "set": {"omega": 7.375, "K": 2.5e7}}


@pytest.fixture(scope="module")
def view():
    (only_view,) = views_of(load_portrait({**SYSTEM, **SHORT}))
    return only_view


def test_forces_and_durations_are_those_of_the_last_cycle(view):
    motion = motion_of(view)
    system = nv.load_system("ssul-set6", omega=7.375, K=2.5e7)
    impacts = nv.simulate(system, 3, transient=2045).impacts
    assert motion.label == "3T,3"
    np.testing.assert_allclose(motion.forces, impacts["force"], rtol=1e-6)
    np.testing.assert_allclose(motion.durations, impacts["release"] - impacts["touch"], rtol=1e-6)
    assert motion.section.shape == (48, 4)
    assert -0.07 < motion.least < -0.06233  # the clearance, and the depth of the deepest impact
    assert motion.greatest > 0.2


def test_a_periodic_orbit_has_lines_only_whatever_the_window(view):
    for breadth in motion_of(view).breadths.values():
        assert breadth.comb == 3
        assert breadth.share < 1e-6
        assert breadth.bins == breadth.bins_of_half


def test_orbits_are_those_of_the_request(tmp_path):
    path = tmp_path / "orbit.toml"
    path.write_text("""
system = "ssul-set6"
[sampling]
samples = 32
[portrait]
panels = ["force"]
[[column]]
set = { omega = 6.28 }
window = [20, 32]
[[column]]
set = { omega = 7.45, K = 2.5e7 }
window = [20, 32]
""")
    first, second = motions_of(load_figure(path))
    assert first.system.parameters["omega"] == 6.28
    assert second.system.K == 2.5e7
    assert not second.label  # a transient
    assert len(second.forces) > 3  # all of the window


def test_an_orbit_that_ends_early_leaves_its_claims_open(monkeypatch):
    def fail(request):
        raise IntegrationError("too many impacts")

    monkeypatch.setattr(motion, "views_of", fail)
    with pytest.raises(Missing, match="figure9: too many impacts"):
        motions_of(paper_results.requests()["9"])


def test_the_packaged_portraits_are_those_that_claims_ask_for():
    requests = paper_results.requests().items()
    kinds = {short: "" if request.computed else "portrait" for short, request in requests}
    assert {kinds[short] for short in ("9", "10", "impact")} == {"portrait"}


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
