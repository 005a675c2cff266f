"""Where branches begin: at orbits of earlier branches, at regimes, and downwards."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.continuation.request import load_continuation

BOUNDS = (7.3, 7.5)


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """Return the archive of branches of T,1 and 2T,2 of Set 6, which have three special points."""
    path = tmp_path_factory.mktemp("earlier") / "earlier.h5"
    options = {"doublings": 1, "unstable": 30, "step": 0.1, "quiet": True}
    nv.continue_branch("ssul-set6", "omega", BOUNDS, to=path, **options)
    return path


@pytest.fixture(scope="module")
def earlier(archive):
    return nv.open_archive(archive)


def test_a_range_that_descends_is_followed_downwards(earlier):
    """From 7.5 to 7.3, the same orbits are met in the opposite order."""
    down = nv.continue_branch("ssul-set6", "omega", BOUNDS[::-1], unstable=30, step=0.1, quiet=True)
    (branch,) = down.branches
    assert (branch.parameter[0], branch.parameter[-1]) == (7.5, 7.3)
    assert branch.labels[0] == "T,0"
    upwards = earlier.special_points[earlier.special_points.branch == 0]
    assert down.special_points.kind.tolist() == upwards.kind.tolist()[::-1] == ["GR", "PD", "PD"]
    np.testing.assert_allclose(down.special_points.value, upwards.value[::-1], rtol=1e-11)
    assert (down.special_points.before[0], down.special_points.after[0]) == ("T,0", "T,1")


def test_the_request_keeps_its_direction_also_of_a_ratio():
    for name, ends in {"omega": (9.0, 5.0), "f": (1.5, 0.5), "zeta1": (0.1, 0.01)}.items():
        table = {"along": {name: {"start": ends[0], "stop": ends[1]}}}
        request = load_continuation("ssul-set6", table)
        assert request.along.falls
        assert request.along.low < request.along.high
        assert load_continuation(request.document()) == request
    assert request.along.name == "c1"
    assert load_continuation("ssul-set6", {"along": {"f": {"start": 1.5, "stop": 0.5}}}) != (
        load_continuation("ssul-set6", {"along": {"f": {"start": 0.5, "stop": 1.5}}})
    )


def test_an_orbit_of_branches_is_a_start(earlier):
    """It needs no search: its own system goes on along another parameter."""
    orbits = earlier.orbits_at(7.4)
    unstable, doubled = sorted(orbits, key=lambda orbit: orbit.period)
    assert (unstable.label, unstable.stable, doubled.label) == ("T,1", False, "2T,2")
    assert unstable.system.parameters["omega"] == unstable.value == 7.4
    end = nv.simulate(doubled.system, 2, start=doubled.state, tolerance="fine").state
    np.testing.assert_allclose(end, doubled.state, rtol=0, atol=1e-9)
    along_force = nv.continue_branch(
        unstable.system, "P", (800, 750), unstable, step=0.2, quiet=True
    )
    (branch,) = along_force.branches
    first = np.flatnonzero(branch.parameter == 800.0)
    assert len(first)
    np.testing.assert_allclose(branch.states[first[0]], unstable.state, rtol=0, atol=1e-9)
    both = nv.continue_branch("ssul-set6", "omega", (7.39, 7.41), orbits, step=0.2, quiet=True)
    assert [branch.period for branch in both.branches] == [orbit.period for orbit in orbits]


def test_an_orbit_of_another_system_is_no_start(earlier, error_of):
    orbit = earlier.orbits_at(7.4)[0]
    words = error_of(nv.continue_branch, "ssul-set6", "P", (800, 700), orbit)
    assert "the start is an orbit at omega = 7.4, not 6.28" in words
    regime = nv.classify(nv.load_system("ssul-set6", P=700.0))
    words = error_of(nv.continue_branch, "ssul-set6", "omega", (6.0, 7.0), regime)
    assert "the start is an orbit at P = 700.0, not 800.0" in words
    # its state is one, as a guess for Newton's method
    options = {"period": regime.period, "step": 0.5, "quiet": True}
    guess = nv.continue_branch("ssul-set6", "omega", (6.27, 6.29), regime.point, **options)
    assert guess.branches[0].labels[0] == "T,1"


def test_branches_begin_at_orbits_of_an_archive(archive, tmp_path, answer, refusal):
    where = ["--from", archive, "-o", tmp_path / "b.h5", "--unstable", "20", "--overwrite"]
    lines = answer("continuation", *where, "--orbit", "2T,2")
    assert "branch 0: 2T,2" in lines
    lines = answer("continuation", *where, "--along", "omega=7.35:7.4", "--step", "0.2")
    assert "omega 7.35 to 7.4" in lines
    there = ["--from", f"{archive}@omega=7.4", *where[2:], "--along", "P=800:790"]
    lines = answer("continuation", *there, "--orbit", "T,1")
    assert "1 branch," in lines
    request = nv.open_archive(tmp_path / "b.h5").request
    assert request.system.parameters["omega"] == 7.4
    assert (request.along.heading(), request.begin.values) == ("P from 800 to 790 N", (800.0,))
    for words, asked in {
        "unknown --orbit '5T,5'; allowed: T,1, T,0, 2T,2": [*where, "--orbit", "5T,5"],
        "FILE.h5@omega=VALUE says where": [*where, "--along", "P=800:790"],
        "lie along omega, not P": ["--from", f"{archive}@P=7.4", *where[2:]],
        "allowed: 7.3 to 7.5": ["--from", f"{archive}@omega=8", *where[2:]],
        "no periodic orbit of it lies within": [*where, "--along", "omega=8:9"],
    }.items():
        assert words in refusal("continuation", *asked)
    assert "--from 3T,3 searches for it" in refusal("continuation", "--orbit", "3T,3")


@pytest.mark.kernels
def test_the_orbit_of_a_regime_of_a_scan(tmp_path, ask, answer, refusal):
    scan, path = tmp_path / "scan.h5", tmp_path / "b.h5"
    ask("bifurcation", "--vary", "omega=7.35:7.5:4", "--record", "section,regime", "-o", scan)
    where = ["--from", scan, "--along", "omega=7.35:7.5", "-o", path]
    labels = set(nv.open_archive(scan)["label"].ravel().tolist())
    assert "T,1" in labels
    asked = [*where, "--orbit", "T,1", "--unstable", "9", "--step", "0.2"]
    assert "branch 0: T,1" in answer("continuation", *asked)
    assert nv.open_archive(path).request.begin.periods == (1,)
    assert "unknown --orbit '7T,7'" in refusal("continuation", *where, "--orbit", "7T,7")


def test_an_archive_of_another_task_is_refused(tmp_path, refusal):
    path = tmp_path / "portrait.h5"
    nv.orbit_portrait("ssul-set6", to=path, quiet=True)
    assert "it holds a portrait, not a scan or branches" in refusal("continuation", "--from", path)
