"""Robust designs under suites: spreads, the number over the records, price, pictures."""

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.tuning.design_space import Uncertain
from nlds_vines.tuning.request import load_tuning
from nlds_vines.tuning.run import over_records

FRAME = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
FREE = {"cell.k": {"low": 2e4, "high": 3e5}, "cell.gap": {"low": 0.005, "high": 0.05}}
SMALL = {
    "population": 6,
    "generations": 1,
    "polish": 0,
    "optima": 1,
    "objective": "drift_ratio_max",
}
STEP = 0.02


def record(seed, count=120):
    generator = np.random.default_rng(seed)
    times = STEP * np.arange(count)
    values = 4.0 * generator.uniform(-1.0, 1.0, count) * np.sin(np.pi * times / times[-1])
    return {"times": times.tolist(), "values": values.tolist(), "unit": "m/s^2"}


def system():
    walls = [nv.Wall(0.02, side, law="hertz", K=1e8) for side in "+-"]
    cell = nv.Damper("cell", "roof", m=900.0, k=1e5, c=900.0, walls=walls)
    return nv.System.from_host(FRAME, [cell], name="design")


def request(search=None, count=3, **tables):
    document = {
        "system": system(),
        "free": FREE,
        "load": {"suite": [record(seed) for seed in range(count)]},
        "record": {"heights": 3.5},
        "sampling": {"duration": 3.0},
        "search": {**SMALL, **(search or {})},
        **tables,
    }
    return load_tuning(document)


@pytest.mark.parametrize(
    ("name", "text", "spread"),
    [("cell.gap", "0.5 mm", 5e-4), ("cell.k", "2 kN/m", 2e3), ("cell.m", "0.1 t", 100.0)],
)
def test_spreads_have_units(name, text, spread):
    one = Uncertain.of(name, text)
    assert (one.spread, one.relative) == (pytest.approx(spread, rel=1e-15), False)


def test_spreads_of_other_units_are_refused(error_of):
    assert "cell.gap is in m" in error_of(Uncertain.of, "cell.gap", "1 kg")
    assert "unit of the spread of cell.gap" in error_of(Uncertain.of, "cell.gap", "1 inch")
    assert "must be a number" in error_of(Uncertain.of, "cell.gap", "half mm")
    assert "must be as '5%'" in error_of(Uncertain.of, "cell.gap", "0.5mm")


def test_numbers_of_loads_may_have_their_owner_in_front(error_of):
    spreads = {"host.K": "10%", "floor2.k": "5%", "load.scale": "20%", "cell.gap": "0.5 mm"}
    one = request(uncertain=spreads)
    assert [item.name for item in one.uncertain] == ["host.K", "floor2.k", "scale", "cell.gap"]
    inner = {key: value for key, value in spreads.items() if key != "load.scale"}
    nested = request(uncertain={**inner, "load": {"scale": "20%"}})
    assert {item.name for item in nested.uncertain} == {item.name for item in one.uncertain}
    both = {"scale": "10%", "load.scale": "20%"}
    assert "scale stands twice" in error_of(request, uncertain=both)
    axis = nv.load_response_history(
        "tmd", {"load": {"impulse": 1.0}, "vary": {"load.scale": [1, 2]}}
    )
    assert axis.vary[0].name == "scale"


def test_records_are_cases_and_their_number_is_told(error_of):
    one = request({"records": "84%"}, uncertain={"load.scale": "20%"})
    assert one.case_count == 3
    assert one.judged == "mean of the 84 % quantile of drift_ratio_max over 3 records over 64 draws"
    assert request({"records": "median"}).judged == "median of drift_ratio_max over 3 records"
    assert request().judged == "largest drift_ratio_max of all cases"
    assert one.fresh_draws == 128
    assert load_tuning(one.document()).hash == one.hash
    assert "there is no suite" in error_of(request, {"records": "mean"}, count=1)
    over = request({"records": "mean"}, over={"scale": {"values": [1.0, 2.0]}})
    assert over.judged == "largest of all cases, the mean of drift_ratio_max over 3 records"


def test_numbers_over_records():
    values = np.random.default_rng(1).normal(size=(4, 2, 7))
    for word, share in (("median", 0.5), ("84%", 0.84)):
        expected = np.quantile(values, share, axis=-1)
        np.testing.assert_allclose(over_records(values, word), expected, rtol=1e-14)
    np.testing.assert_allclose(over_records(values, "mean"), values.mean(axis=-1), rtol=1e-14)
    values[0, 0, :3] = np.inf
    assert np.isfinite(over_records(values, "median")[0, 0])
    assert over_records(values, "84%")[0, 0] == np.inf


@pytest.mark.kernels
@pytest.mark.parametrize("word", ["largest", "median", "84%", "mean"])
def test_a_design_under_a_suite_has_the_number_of_its_histories(word):
    tuned = nv.tune(request({"records": word, "generations": 1}), quiet=True)
    best = dict(tuned.parameters)
    scan = nv.response_history(
        system().with_(**best), load={"suite": [record(seed) for seed in range(3)]}, duration=3.0,
        heights=3.5, vary={"scale": [1.0]}, quiet=True,
    )  # fmt: skip
    values = scan["drift_ratio_max"][0, :, 0]
    number = {
        "largest": values.max(), "mean": values.mean(), "median": np.median(values),
        "84%": np.quantile(values, 0.84),
    }[word]  # fmt: skip
    assert tuned.objective == pytest.approx(number, rel=1e-12)


@pytest.mark.kernels
def test_a_robust_design_is_at_least_as_good_as_a_grid():
    spreads = {"host.K": "10%", "load.scale": "20%", "cell.gap": "0.5 mm"}
    search = {"records": "median", "draws": 4, "population": 12, "generations": 8, "polish": 15}
    one = request(search, count=2, uncertain=spreads)
    tuned = nv.tune(one, quiet=True)
    from nlds_vines.tuning.run import Objective, at_rest

    stiffness = np.geomspace(2e4, 3e5, 6)
    gaps = np.linspace(0.005, 0.05, 6)
    grid = np.array([[k, gap] for k in stiffness for gap in gaps])
    of_grid = Objective(one).results(at_rest(grid))[:, 0]
    assert tuned.best.searched <= of_grid.min()


@pytest.mark.kernels
def test_the_price_is_told_and_no_surface_is_computed_unasked(here, ask):
    words = ["tuning", "--system", "tmd", "--impulse", "100", "--duration", "3", "--free",
             "k2=2000:2600", "--free", "c2=50:90", "--population", "5", "--generations", "1",
             "--polish", "0", "--optima", "1", "--objective", "x1_max", "-o", "a.h5",
             "--plot", "a.png"]  # fmt: skip
    plan = ask(*words, "--dry-run").out
    assert "at most 22 histories" in plan
    err = ask(*words).err
    assert "histories of 3 s" in err
    assert "up to" in err
    with nv.read("a.h5") as view:
        assert "surface" not in view
        assert view["status"].size <= 22
    assert (here / "a.png").stat().st_size > 0
