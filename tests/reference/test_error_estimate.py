"""The error that a scan tells of itself, against states of 25 digits; and labels that do not hold.

Each period begins with a reference state, so that the true error of one period is known.
"""

import numpy as np
import pytest
from support import references, system_of

from nlds_vines.bifurcation.compute import Computer
from nlds_vines.model.labels import KEPT
from nlds_vines.orbits import solver_settings
from nlds_vines.orbits.simulation import start_state
from nlds_vines.orbits.solver_settings import MOST_NODES, TOLERANCE, Settings
from scans import computed, scan_of

pytestmark = pytest.mark.kernels


def given(nodes):
    """Return what an expert may set."""
    return Settings(nodes=nodes, contact_steps=28.0)


STEEL = "ssul-set6-steel"  # whose impacts are so short that 8 nodes leave round-off alone
SSBL = "ssbl-omega6.05"
SSUL = ("ssul-set6", "ssul-set6-omega7.45", STEEL)
CASES = [
    *((name, "exact", Settings(10.0**-k)) for name in SSUL[:1] for k in (3, 5, 6, 7, 8)),
    *((SSUL[1], "exact", Settings(10.0**-k)) for k in (5, 6, 7)),
    *((SSBL, "exact", Settings(10.0**-k)) for k in (3, 5, 6, 7, 8)),
    *((name, "exact", given(nodes)) for name in SSUL[:2] for nodes in (4, 6, 8, 10)),
    *((STEEL, "exact", given(nodes)) for nodes in (2, 3, 4, 6)),
    *((SSBL, "exact", given(nodes)) for nodes in (6, 8, 10, 12)),
    *((name, "rk4", Settings.rk4(float(n))) for name in SSUL for n in (128, 256, 512, 1024)),
]
ROUND_OFF = 1e-12  # of a period; below it round-off has its share
FACTOR = 1.25


def true_and_estimated(name, method, settings):
    """Return the error of each period of a reference orbit, and what a scan says of it."""
    reference = references()[name]
    system = system_of("ssbl" if "D" in reference.numbers else "ssul", reference.numbers)
    omega, want = {"omega": [system.parameters["omega"]]}, ["section", "error"]
    table = system.to_table()
    scan = scan_of(table, want, omega, method=method, transient=0, periods=1)
    cell, begins = scan.cells(), reference.states[:-1]
    starts = np.array([start_state(system, cell["rest"][0], begin)[:4] for begin in begins])
    chains = np.repeat(cell, len(begins))[:, np.newaxis]
    found = Computer(scan, settings).lanes(chains, starts)
    true = np.abs(found["section"][:, 0, 0] - reference.states[1:]).max(axis=1)
    return true, found["error"][:, 0]


def assert_honest(true, estimated):
    seen = true > ROUND_OFF
    assert seen.sum() >= 20  # so that there is something to estimate
    ratio = estimated[seen] / true[seen]
    assert ratio.min() > 1 / FACTOR
    assert ratio.max() < FACTOR
    assert (estimated[~seen] < FACTOR * ROUND_OFF).all()


@pytest.mark.parametrize(("name", "method", "settings"), CASES)
def test_the_estimate_is_the_true_error_of_a_period(name, method, settings):
    assert_honest(*true_and_estimated(name, method, settings))


SMALL = [(name, k) for name in (*SSUL, SSBL) for k in (8, 9, 10, 12, 13)]


@pytest.mark.parametrize(("name", "k"), SMALL)
def test_a_small_estimate_is_never_far_below_the_true_error(name, k):
    """Whatever can be seen of it. Notices: refined runs with the same nodes inside an impact."""
    true, estimated = true_and_estimated(name, "exact", Settings(10.0**-k))
    assert (estimated >= true / 3 - ROUND_OFF).all()
    assert (estimated <= true * FACTOR + ROUND_OFF).all()


@pytest.mark.parametrize("k", [3, 6, 9, 12, 13])
@pytest.mark.parametrize("name", [*SSUL, SSBL])
def test_a_period_errs_by_less_than_the_tolerance_times_growth(name, k):
    """And two tolerances by less than both together, as the coarser of them says."""
    true, _ = true_and_estimated(name, "exact", Settings(10.0**-k))
    growth = references()[name].growth
    one_period = np.maximum(1.0, growth[1:] / growth[:-1])
    assert (true <= 10.0**-k * one_period + ROUND_OFF).all()


def test_an_estimate_by_settings_that_are_not_finer_is_caught(monkeypatch):
    monkeypatch.setattr(Settings, "refined", lambda self, method: self)
    with pytest.raises(AssertionError):
        assert_honest(*true_and_estimated("ssul-set6", "exact", Settings(1e-6)))


def test_refined_settings_are_those_the_documentation_names():
    assert Settings.of("exact").refined("exact") == Settings(TOLERANCE / 1000, nodes=24)
    assert Settings.of("exact", 1e-6).refined("exact") == Settings(1e-6 / 1000, nodes=24)
    assert given(12).refined("exact") == Settings(TOLERANCE / 1000, 24, 40.0)
    assert given(30).refined("exact") == Settings(TOLERANCE / 1000, 34, 40.0)
    assert given(58).refined("exact").nodes == MOST_NODES
    assert Settings.of("rk4").refined("rk4") == Settings.rk4(1024.0)


# ---- labels under refinement ---------------------------------------------------------------------

OMEGA = [6.0, 6.28, 7.45, 7.8, 7.95]


def labelled(method, want):
    sampling = {"method": method, "transient": 240, "periods": 60, "effort": "quick"}
    found = computed(scan_of("ssul-set6", want, {"omega": OMEGA}, **sampling))
    return {name: values[:, 0] for name, values in found.items()}


def test_labels_by_far_too_few_steps_are_flagged_where_they_are_wrong(monkeypatch):
    right = labelled("rk4", ["regime", "error"])
    assert (right["label_kept"] == KEPT["yes"]).all()
    monkeypatch.setattr(solver_settings, "PERIOD_STEPS", 16.0)
    found = labelled("rk4", ["regime", "error"])
    wrong = found["label"] != right["label"]
    assert wrong.any()
    assert not wrong.all()
    np.testing.assert_array_equal(found["label_kept"] == KEPT["no"], wrong)
    assert (found["refined_label"][wrong] == right["label"][wrong]).all()
    assert (found["error"] > 1e5 * right["error"]).all()


def test_settled_orbits_keep_their_labels_and_tell_small_errors():
    found = labelled("exact", ["section", "impacts", "energy", "regime", "error"])
    assert found["label"].tolist() == ["T,1", "T,1", "3T,2", "2T,1", "T,0"]
    assert found["refined_label"].tolist() == found["label"].tolist()
    assert (found["label_kept"] == KEPT["yes"]).all()
    assert (found["error"] < 1e-9).all()
    assert (found["error_at_end"] < 1e-7).all()
    assert (found["E1max_error"] < 1e-4).all()  # 3T,2 had not settled to the last digit
