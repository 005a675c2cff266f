"""Motions in portraits: what is measured for the claims."""

import numpy as np
import paper_results
import pytest

import nlds_vines as nv
from nlds_vines.orbits.simulation import IntegrationError
from nlds_vines.portrait.request import load_portrait
from nlds_vines.portrait.run import views_of
from paper import motion
from paper.claims import Missing
from paper.motion import motion_of, motions_of
from paper.request import load_figure

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
