"""What refined settings find otherwise, and how it is told."""

import numpy as np
import pytest

import nlds_vines as nv
import scans
from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.command import main
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.orbit_counts import refinement_summary
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import FLAGS, KEPT
from nlds_vines.orbits import refinement
from nlds_vines.orbits.records import possible_want
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.orbits.status_words import DIVERGED, OK
from scans import archived, scan_of, unfilled

OMEGA = {"omega": {"values": [6.0, 6.5, 7.0]}}


def free(want=("energy", "error"), transient=3, periods=5, system="tmd", start="rest"):
    """Return a scan without walls by rk4, which is compiled in no time."""
    method = {"transient": transient, "periods": periods, "method": "rk4"}
    return scan_of(system, want, OMEGA, start, **method)


def computed(scan, settings=None):
    found = scans.computed(scan, settings)
    return {name: values[:, 0] for name, values in found.items()}


# ---- numbers -------------------------------------------------------------------------------------


@pytest.mark.kernels
@pytest.mark.parametrize("system", ["none", "tmd"])
@pytest.mark.parametrize("start", ["rest", "up"])
def test_of_a_single_period_both_errors_are_the_same(system, start):
    """The last state is that after the one period, and its begin is that of the orbit."""
    found = computed(free(transient=0, periods=1, system=system, start=start))
    first = found["error"][0]
    assert first == found["error_at_end"][0] > 0
    # a sweep begins the others where the refined one is no more
    same = found["error"][1:] == found["error_at_end"][1:]
    assert same.all() if start == "rest" else not same.any()


@pytest.mark.parametrize("components", [2, 4])
@pytest.mark.parametrize("noted", [7, 8, 12])
def test_periods_begin_where_the_orbit_was(components, noted):
    """Seven periods of two chains of three cells; so much of their section is there."""
    generator = np.random.default_rng(1)
    states, rest = generator.normal(size=(2, 3, 13, 4)), generator.normal(size=(2, 3))
    states[..., components:] = 0.0
    section = states[:, :, -noted:].copy()
    if components == 4:
        section[..., 2] = section[..., 0] - section[..., 2] + rest[..., np.newaxis]
        section[..., 3] = section[..., 1] - section[..., 3]
    section = section[..., :components]
    begins = refinement.begins_of(section, states[:, :, -noted - 1], rest, 7)
    np.testing.assert_allclose(begins, states[:, :, -8:-1], rtol=1e-12, atol=1e-14)


@pytest.mark.kernels
def test_the_error_is_the_largest_of_the_periods():
    scan = free(["section", "error"], 0, 6)
    found = computed(scan, Settings.rk4(64.0))
    one_by_one = []
    for n in range(6):
        state = found["section"][:, n - 1] if n else np.zeros((3, 4))
        starts = np.stack(
            [state[:, 0], state[:, 1], state[:, 0] - state[:, 2], state[:, 1] - state[:, 3]],
            axis=-1,
        )
        single = Computer(free(["section", "error"], 0, 1), Settings.rk4(128.0))
        after = single.lanes(scan.cells()[:, np.newaxis], starts)["section"][:, 0, 0]
        one_by_one.append(np.abs(after - found["section"][:, n]).max(axis=1))
    largest = np.max(one_by_one, axis=0)
    np.testing.assert_allclose(found["error"], largest, rtol=1e-9)
    assert (np.min(one_by_one, axis=0) < 0.9 * largest).all()  # so that it matters which


@pytest.mark.kernels
def test_a_coarse_method_tells_a_larger_error():
    few, many = (computed(free(), Settings.rk4(steps))["error"] for steps in (64.0, 256.0))
    np.testing.assert_allclose(few / many, 4.0**4, rtol=0.1)  # of order four


@pytest.mark.kernels
def test_where_only_the_refined_run_fails_nothing_is_made_up(monkeypatch, tmp_path):
    monkeypatch.setattr(Settings, "refined", lambda self, method: Settings.rk4(2.0))
    scan = free(["energy", "regime", "error"])
    found = computed(scan)
    assert (found["status"] == OK).all()
    assert np.isfinite(found["E1max"]).all()
    for name in ("error", "error_at_end", "E1max_error"):
        assert np.isnan(found[name]).all()
    assert set(found["refined_label"]) == {"failed"}
    assert (found["label_kept"] == KEPT["no"]).all()
    with read(nv.scan(scan, to=tmp_path / "a.h5")) as view:
        assert (
            refinement_summary(view) == "refined: 3 of 3 orbits change their label, 3 of them fail"
        )


# ---- labels --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("T,1", "T,1", True),
        ("3T,2", "3T,3", False),
        ("2T,2", "4T,4", False),
        ("chaos", "chaos", True),
        ("chaos", "transient chaos to T,0", False),
        ("transient chaos to T,0", "transient chaos to T,0", True),
        ("transient chaos to T,0", "transient chaos to 3T,2", False),
        ("transient chaos to T,0", "T,0", False),
        ("undetermined", "quasiperiodic", False),
    ],
)
def test_a_label_is_kept_where_kind_and_final_orbit_are(one, other, same):
    labels = (np.array([[label]], dtype=object) for label in (one, other))
    code = refinement.kept(*labels)
    assert code.dtype == np.int8
    assert code.tolist() == [[KEPT["yes" if same else "no"]]]


# ---- in words ------------------------------------------------------------------------------------


def archive_of(path, want=("energy", "regime", "error"), fill=None):
    """Write an archive of five orbits: four settled, one of them unkept, and one that failed."""
    scan = scan_of("ssul-set6", want, {"omega": [5.0, 6.0, 7.0, 7.5, 8.0]})
    found = unfilled(scan)
    found["status"][:, 0] = [OK, OK, OK, OK, DIVERGED]
    found["error"][:4, 0] = [1e-12, 3e-11, 2e-9, 5e-13]
    found["error_at_end"][:4] = 1e-9
    if "regime" in want:
        words = ("periodic", "transient_chaos", "chaotic", "periodic", "failed")
        found["regime"][:, 0] = [FLAGS[word] for word in words]
        found["label_kept"][:4, 0] = [KEPT[word] for word in ("yes", "yes", "no", "no")]
    if fill is not None:
        fill(found)
    return archived(path, scan, found)


def told(path):
    with read(path) as view:
        return refinement_summary(view)


def test_the_summary_counts_changed_labels_and_looks_at_settled_orbits(tmp_path):
    assert told(archive_of(tmp_path / "a.h5")) == (
        "refined: 2 of 4 orbits change their label, "
        "largest error of settled ones over a period 3.0e-11 (m, m/s)"
    )


def test_without_regimes_the_summary_looks_at_all_orbits(tmp_path):
    path = archive_of(tmp_path / "a.h5", ("error",))
    assert told(path) == "refined: largest error over a period 2.0e-09 (m, m/s)"


def test_where_every_orbit_failed_there_is_nothing_to_tell(tmp_path):
    def fail(found):
        found["status"][:] = DIVERGED
        found["error"][:] = found["error_at_end"][:] = np.nan

    path = archive_of(tmp_path / "a.h5", ("error",), fail)
    assert told(path) == "refined: no orbit to compare"


@pytest.mark.kernels
def test_the_command_ends_with_the_summary(here, answer):
    options = ["--system", "tmd", "--vary", "omega=6:7:3", "--transient", "3", "--periods", "5"]
    options += ["--method", "rk4", "-o", "a.h5"]
    assert "\nrefined: largest error over a period " in answer(
        "bifurcation", *options, "--record", "energy,error"
    )
    assert "\nrefined: largest error over a period " in answer(
        "bifurcation", *options, "--record", "energy,error", "--resume"
    )
    assert main([*options, "--record", "energy,error", "--overwrite", "--quiet"]) == 0
    assert main([*options, "--record", "energy", "--overwrite"]) == 0
    assert "refined" not in answer(
        "bifurcation", *options, "--record", "energy,error", "-o", "b.h5", "--shard", "1/1"
    )


# ---- what cannot be had --------------------------------------------------------------------------


def test_what_is_exact_has_no_error_to_ask_for():
    document = {"system": "tmd", "vary": OMEGA, "record": {"want": ["error"]}}
    message = "want 'error' cannot be had: kind 'tmd' .* has no wall: method 'exact' discretises"
    with pytest.raises(RequestError, match=message) as refused:
        load_scan(document)
    assert "\n" not in str(refused.value)
    by_steps = {**document, "sampling": {"method": "rk4"}}
    assert load_scan(by_steps).want == ("error",)
    with pytest.raises(RequestError, match="cannot be had"):
        load_scan(by_steps, {"sampling": {"method": "exact"}})
    both = {**document, "record": {"want": ["energy", "error"]}}
    assert load_scan(both).want == ("energy",)
    assert load_scan({**both, "system": "ssul-set6"}).want == ("energy", "error")


def test_a_scan_made_by_hand_is_checked_too():
    scan = free()
    with pytest.raises(RequestError, match="'error' cannot be had"):
        nv.Scan(scan.title, scan.system, scan.axes, ("error",))
    assert possible_want(("error", "impacts"), scan.system.scene, "rk4") == ("error",)
