"""A tolerance, wherever orbits are run: asked for in one way, kept, and held."""

import tomllib

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.run import Computer
from nlds_vines.engine.solver_settings import TOLERANCES, Settings
from nlds_vines.errors import RequestError
from nlds_vines.portrait.request import load_portrait
from nlds_vines.tuning.batch_of_designs import Batch
from nlds_vines.tuning.request import load_tuning
from nlds_vines.upkeep.rerun import differing

SMALL = {
    "system": "ssul-set6",
    "vary": {"omega": {"values": [6.28, 7.45]}},
    "sampling": {"transient": 2, "periods": 3},
    "record": {"want": ["section"]},
}
SYSTEM = nv.load_system("ssul-set6", omega=6.28)


def scan(**sampling):
    return load_scan(SMALL, {"sampling": sampling})


def section(**sampling):
    cells = load_scan(SMALL).cells()[:, np.newaxis]
    return Computer(scan(**sampling)).lanes(cells, np.zeros((len(cells), 4)))["section"]


# ---- scans ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("load", [load_scan, load_tuning, load_portrait])
def test_a_request_keeps_its_tolerance(load):
    """The usual one, too: the archive says what it was."""

    def asked_for(**sampling):
        return load("ssul-set6", {"sampling": sampling})

    assert asked_for().tolerance == 1e-9
    hashes = {}
    for name, value in TOLERANCES.items():
        asked = asked_for(tolerance=name)
        assert asked == asked_for(tolerance=value)
        assert asked.tolerance == value
        assert tomllib.loads(asked.to_toml())["sampling"]["tolerance"] == value
        again = load(tomllib.loads(asked.to_toml()))
        assert (again, again.hash) == (asked, asked.hash)
        hashes[name] = asked.hash
    assert len(set(hashes.values())) == 3
    assert asked_for().hash == hashes["standard"]
    if load is not load_tuning:  # which has no method
        rk4 = load(asked_for(tolerance=1e-6).document(), {"sampling": {"method": "rk4"}})
        assert rk4.tolerance is None
        assert "tolerance" not in rk4.document()["sampling"]


def test_experts_may_set_what_the_tolerance_would():
    assert scan(tolerance=1e-6).settings == Settings(1e-6)
    request = scan(nodes=10, contact_steps=20)
    assert request.settings == Settings(nodes=10, contact_steps=20.0)
    assert load_scan(tomllib.loads(request.to_toml())) == request
    assert request.hash != load_scan(SMALL).hash
    assert scan(method="rk4", period_steps=64).settings == Settings.rk4(64.0)


def test_a_tolerance_of_another_method_is_one_line_that_names_its_place(error_of):
    words = "[sampling]: tolerance is of method 'exact'; 'rk4' has period_steps"
    rk4 = {**SMALL, "sampling": {"method": "rk4"}}
    beside = {**SMALL, "sampling": {"method": "rk4", "tolerance": 1e-6}}
    assert error_of(load_scan, beside) == f"scan: {words}"
    assert error_of(load_scan, rk4, {"sampling": {"tolerance": 1e-6}}) == f"changes: {words}"


# ---- numbers -------------------------------------------------------------------------------------


@pytest.mark.kernels
def test_a_coarse_scan_is_coarser_and_both_are_within_their_tolerances():
    """Over a period from the same states, so that no growth comes between."""
    errors, truth = {}, section(tolerance=1e-13, transient=0, periods=4)
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        states = section(tolerance=tolerance, transient=0, periods=4)
        errors[tolerance] = np.abs(states - truth).max()
        assert errors[tolerance] <= 10 * tolerance  # growth in four periods
    assert errors[1e-6] > 10 * errors[1e-9] > 100 * errors[1e-12]


@pytest.mark.kernels
def test_the_order_in_which_tolerances_are_asked_for_changes_no_bit():
    """Notices: constants of one tolerance that another finds in a cache, and changes."""
    names = [*TOLERANCES, 1e-3, 1e-13]
    one = {name: section(tolerance=name) for name in names}
    other = {name: section(tolerance=name) for name in reversed(names)}
    for name in names:
        np.testing.assert_array_equal(one[name], other[name])
    np.testing.assert_array_equal(one["draft"], section(tolerance=1e-6))
    assert (one["draft"] != one["fine"]).any()


@pytest.mark.kernels
def test_scans_simulations_and_batches_take_it_alike():
    for name, value in TOLERANCES.items():
        orbit = nv.simulate(SYSTEM, 3, transient=2, tolerance=name, record=["section"])
        np.testing.assert_array_equal(orbit.section, section(tolerance=value)[0, 0])
    energies = []
    for value in TOLERANCES.values():
        arrays = Batch(SYSTEM, tolerance=value).run(SYSTEM.cells(), np.zeros(4), 2, 3)
        orbit = nv.simulate(SYSTEM, 3, transient=2, tolerance=value, record=["energy"])
        assert arrays.objective == orbit.E1max
        energies.append(orbit.E1max)
    assert energies[0] != energies[1]
    assert energies == pytest.approx([energies[2]] * 3, rel=1e-5)


# ---- the other commands and functions ------------------------------------------------------------


SHORT = ["--transient", "1", "--periods", "1"]
DRY = {
    "bifurcation": [*SHORT, "--vary", "omega=6:7:2", "--record", "section"],
    "portrait": [],
    "transients": [*SHORT, "--starts", "1", "--effort", "quick"],
    "tuning": [*SHORT, "--population", "5", "--generations", "1"],
}


@pytest.mark.parametrize("command", DRY)
def test_commands_take_numbers_and_presets_and_refuse_them_beside_rk4(
    command, here, answer, refusal
):
    for text in ("1e-6", "draft"):
        answer(command, *DRY[command], "--tolerance", text, "--dry-run")
    words = " ".join(answer(command, "--help-all").split())
    assert "draft (1e-06), standard (1e-09), fine (1e-12)" in words
    if command != "tuning":  # which has no method
        line = refusal(command, "--method", "rk4", "--tolerance", "fine")
        assert "tolerance is of method 'exact'; 'rk4' has period_steps" in line
    assert list(here.iterdir()) == []


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (nv.simulate, {"periods": 1}),
        (nv.classify, {}),
        (nv.orbit_portrait, {}),
        (nv.transient_lifetimes, {"to": "a.h5"}),
    ],
)
def test_functions_refuse_it_in_one_line(function, arguments, here, error_of):
    for wrong, words in (
        ({"tolerance": -1e-9}, "tolerance = -1e-09; allowed: 1e-13 to 0.001, or draft"),
        ({"tolerance": "draft", "method": "rk4"}, "tolerance is of method 'exact'"),
    ):
        assert words in error_of(function, SYSTEM, **arguments, **wrong)
    assert list(here.iterdir()) == []


@pytest.mark.kernels
def test_a_verdict_by_a_draft_is_the_same_and_coarser():
    draft, fine = (nv.classify(SYSTEM, tolerance=name) for name in ("draft", "fine"))
    assert draft.label == fine.label == "T,1"
    assert draft.residual < 1e-4
    distance = np.abs(draft.point - fine.point).max()
    assert 0 < distance < 1e-5


@pytest.mark.kernels
def test_an_archive_keeps_the_tolerance_and_is_repeated_with_it(here, answer, ask):
    draft = {**SMALL["sampling"], "tolerance": "draft"}
    nv.scan(SMALL, to="a.h5", sampling=draft)
    with nv.read("a.h5") as view:
        assert tomllib.loads(view.text("scan"))["sampling"]["tolerance"] == 1e-6
    ask("rerun", "a.h5", "--quiet")
    assert nv.open_archive(here / "a.h5").request.tolerance == 1e-6
    with pytest.raises(RequestError, match="holds another scan: resume=True cannot continue it"):
        nv.scan(SMALL, to="a.h5", resume=True)
    nv.scan(SMALL, to="a.h5", sampling={**draft, "tolerance": 1e-6}, resume=True)
    nv.scan(SMALL, to="b.h5")
    assert "section" in differing(here / "a.h5", here / "b.h5")
    rk4 = {**SMALL, "sampling": {**SMALL["sampling"], "method": "rk4"}}
    assert nv.open_archive(nv.scan(rk4, to="r.h5")).request.settings == Settings.rk4(512.0)
