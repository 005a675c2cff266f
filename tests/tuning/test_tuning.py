"""Tuning: what a request means, what a design is worth, which optima are told apart."""

import math

import numpy as np
import pytest
from scipy.stats import qmc
from support import amplitudes

import nlds_vines as nv
from nlds_vines.archives.archive import ArchivePath, parse_toml
from nlds_vines.orbits.batch import Outcome
from nlds_vines.orbits.records import DIVERGED, OK, TOO_STIFF
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.store import Blocks
from nlds_vines.tuning import run
from nlds_vines.tuning.design_space import BOUNDS, Free, units_of, values_of
from nlds_vines.tuning.request import STARTS, Search, load_tuning
from nlds_vines.tuning.result import Optimum, Tuned, perturbations
from nlds_vines.tuning.run import distinct, latin_hypercube, polish, search_globally

TABLE_1_BEST = 81.8492  # J, the least E1max of the paper's sets at 6.28 rad/s: set 5


def bounds(low, high):
    return {"low": low, "high": high}


def test_all_parameters_are_free_but_what_is_set_or_varied_and_more_can_be():
    for system, names in (("ssul-set6", "k2 c2 C"), ("tmd", "k2 c2"), (None, "k2 c2 C")):
        tuning = load_tuning(system)
        assert tuning.names == tuple(names.split())
        for item in tuning.free:
            assert (item.low, item.high) == BOUNDS[item.name][:2]
    tuning = load_tuning("ssul-set6", {"set": {"c2": 50.0}, "over": {"C": {"values": [0.1]}}})
    assert tuning.names == ("k2",)
    assert tuning.system.parameters["c2"] == 50.0
    # more can be free, and bounds can be narrower
    tuning = load_tuning("ssul-set6", {"free": {"E2": {}, "k2": bounds(100, 900)}})
    assert tuning.names == ("k2", "c2", "C", "E2")
    assert (tuning.free[0].low, tuning.free[0].high) == (100.0, 900.0)
    file = {"system": "ssul-set6", "free": {"C": {}}}  # a file says what is free, exactly
    assert load_tuning(file).names == ("C",)
    assert load_tuning(file, {"set": {"C": 0.1}, "free": {"k2": {}}}).names == ("k2",)


def test_the_canonical_file_means_the_same():
    tuning = load_tuning(
        "ssul-set5",
        {
            "free": {"K": bounds(1e7, 4e7)},
            "over": {"omega": {"start": 5.0, "stop": 8.0, "num": 4}, "P": {"values": [600, 800]}},
            "search": {"seeds": 2, "within": 0.1},
            "surface": {"parameters": ["C", "k2"], "size": 7},
            "sampling": {"transient": 10},
        },
    )
    again = load_tuning(parse_toml(tuning.to_toml(), "here"))
    assert again == tuning
    assert again.hash == tuning.hash
    assert load_tuning(again, {"search": {"seed": 1}}).hash != tuning.hash
    without = load_tuning(again.document() | {"surface": {"size": 7}})
    assert without.surface.parameters == ("k2", "c2")  # the first two that are free
    assert tuning.case_count == 8
    assert tuning.cases()["P"].tolist() == [600, 800] * 4
    assert tuning.title.endswith("ω from 5 to 8 rad/s, P from 600 to 800 N")


@pytest.mark.parametrize(
    ("source", "changes", "message"),
    [
        ("ssul-set6", {"free": {"k3": {}}}, "did you mean 'k2'"),
        ("ssul-set6", {"free": {"nu2": {}}}, "nu2 has no default bounds"),
        ("ssul-set6", {"free": {"k2": bounds(5.0, 5.0)}}, "the first must be the lesser"),
        ("ssul-set6", {"free": {"k2": bounds(-5.0, 5.0)}}, "k2 = -5.0 is not allowed"),
        ("ssul-set6", {"free": {"k2": {"max": 5.0}}}, "unknown key 'max'"),
        ("ssul-set6", {"free": {"K": {}, "E2": {}}}, "K beside E2"),
        ("ssul-set6", {"free": {"k2": {}}, "set": {"k2": 1.0}}, "k2 is varied by changes: [free]"),
        ("ssul-set6", {"over": {"k4": {"values": [1.0]}}}, "unknown parameter 'k4'"),
        ("ssul-set6", {"over": {"P": {"values": [-1.0]}}}, "P = -1.0 is not allowed"),
        ("ssul-set6", {"set": {"k2": 1, "c2": 1, "C": 1}}, "nothing is free"),
        ("ssul-set6", {"set": {"k2": 1, "c2": 1, "C": 1}, "free": {"V": {}}}, "V alone"),
        ("ssul-set6", {"surface": {"parameters": ["k2", "V"]}}, "unknown parameter of the surface"),
        ("ssul-set6", {"surface": {"parameters": ["k2", "k2"]}}, "two different"),
        ("ssul-set6", {"search": {"generations": 10**5, "population": 10**5}}, "allowed: up to"),
        (3, {}, "must be a path"),
    ],
)
def test_a_wrong_request_is_one_line(source, changes, message, error_of):
    assert message in error_of(load_tuning, source, changes)


@pytest.mark.kernels
@pytest.mark.parametrize("free", [Free("k2", 10.0, 1e4), Free("C", -0.1, 0.5), Free("k2", 0, 9)])
def test_places_and_values_belong_together(free):
    places = np.linspace(0, 1, 101)
    values = free.value(places)
    assert (values[0], values[-1]) == pytest.approx((free.low, free.high), rel=1e-14)
    assert free.low <= values.min() <= values.max() <= free.high
    assert np.all(np.diff(values) > 0)
    assert free.unit(values) == pytest.approx(places, abs=1e-12)
    ratios = values[1:] / np.where(values[:-1] == 0, np.nan, values[:-1])
    assert free.logarithmic == bool(np.ptp(ratios[1:]) < 1e-9)
    # designs and the unit cube
    both = (free, Free("c2", 1.0, 9.0))
    units = np.random.default_rng(0).random((20, 2))
    assert units_of(both, values_of(both, units)) == pytest.approx(units, abs=1e-12)


@pytest.mark.kernels
def test_a_perturbed_trial_is_the_perturbed_system():
    tuning = load_tuning("tmd", {"over": {"P": {"values": [400.0, 800.0]}}})
    trials = np.array([[600.0, 262.0, 1.01, 2.0, 1.0]])
    results = run.Objective(tuning).results(trials)[0]
    system = nv.load_system("tmd", k2=600.0, c2=262.0, P=800.0, omega=6.28 * 1.01)
    orbit = nv.simulate(system, 2, transient=300, record=("section", "energy"))
    assert results[0] == pytest.approx(orbit.E1max, rel=1e-9)  # settled, wherever it began
    assert results[3] == 1  # the cases in ascending order of P


@pytest.mark.kernels
def test_starts_stretches_and_failures_of_trials():
    # a start of its own is used
    tuning = load_tuning("tmd", {"sampling": {"transient": 0}})
    trials = np.array([[600.0, 262.0, 1.0, start, 1.0] for start in range(STARTS + 1)])
    assert len(np.unique(run.Objective(tuning).results(trials)[:, 0])) == STARTS + 1
    # more periods tell what had not settled
    tuning = load_tuning("tmd", {"sampling": {"transient": 2, "periods": 2}})
    trials = np.array([[600.0, 262.0, 1.0, 0.0, stretch] for stretch in (50.0, 1.0)])
    settled, early = run.Objective(tuning).results(trials)[:, 0]
    assert settled == pytest.approx(635.107, abs=1e-3)
    assert early < 0.9 * settled
    # a design that fails is infinitely bad
    tuning = load_tuning("tmd", {"free": {"k2": bounds(1.0, 1e14)}})
    points = np.array([[600.0, 262.0], [1e14, 262.0], [700.0, 200.0]])
    results = run.Objective(tuning).results(run.at_rest(points))
    assert results[1, 0] == np.inf
    assert results[:, 2].tolist() == [OK, TOO_STIFF, OK]
    assert np.isfinite(results[[0, 2], 0]).all()


def test_a_failed_case_or_a_broken_constraint_condemns_a_design_and_no_number_is_made_of_it():
    outcome = Outcome(
        objective=np.array([[1.0, 5.0], [9.0, np.nan], [3.0, 2.0], [1.0, 1.0]]),
        E2max=np.array([[7.0, 8.0], [1.0, 1.0], [4.0, 6.0], [1.0, 1.0]]),
        status=np.array([[OK, OK], [OK, OK], [OK, DIVERGED], [OK, OK]]),
        violations=np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 3.0]]),
    )
    worst_case = run.worst(outcome)
    assert worst_case[:, 0].tolist() == [5.0, np.inf, np.inf, np.inf]
    assert worst_case[:, 2].tolist() == [OK, OK, DIVERGED, OK]
    assert worst_case[:, 3].tolist() == [1, 1, 1, 1]
    assert worst_case[0, 1] == 8.0
    assert np.isnan(worst_case[1:, 1]).all()


def test_a_tuning_without_an_admissible_design_says_so(tmp_path, monkeypatch, error_of):
    def failed(_, trials):
        return np.tile([np.inf, np.nan, DIVERGED, 0.0], (len(trials), 1))

    monkeypatch.setattr(run.Objective, "results", failed)
    few = {"population": 5, "generations": 1, "polish": 4}
    tuned = nv.tune("tmd", tmp_path / "a.h5", search=few, surface={"size": 2}, quiet=True)
    assert tuned.optima == ()
    assert tuned.refused == tuned.evaluations >= 5
    assert "designs were inadmissible" in "\n".join(tuned.lines())
    assert "widen the bounds" in error_of(getattr, tuned, "best")


def test_a_picture_writes_ratios_without_a_unit_and_their_symbols_after_a_comma(
    tmp_path, monkeypatch
):
    def made_up(_, trials):
        return np.column_stack([1.0 + trials[:, 0], *np.zeros((3, len(trials)))])

    monkeypatch.setattr(run.Objective, "results", made_up)
    few = {"population": 5, "generations": 1, "polish": 0, "optima": 1}
    names = ["mass_ratio", "frequency_ratio", "zeta2"]
    tuned = nv.tune(
        "tmd", tmp_path / "a.h5", free={name: {} for name in names}, search=few,
        surface={"parameters": names[:2], "size": 3}, quiet=True,
    )  # fmt: skip
    figure = tuned.plot()
    zeta2 = tuned.parameters["zeta2"]
    last = figure.get_suptitle().splitlines()[-1]
    assert last == rf"with $\zeta_2$ = {zeta2:.4g} as in the best"
    assert figure.axes[0].get_ylabel().endswith(", over f1, $f_2/f_1$")


def test_near_equal_optima_lie_apart():
    units = np.array([[0.1, 0.1], [0.12, 0.1], [0.9, 0.9], [0.5, 0.5], [0.9, 0.88], [0.1, 0.9]])
    values = np.array([10.0, 10.01, 10.1, 20.0, 10.05, np.inf])
    assert distinct(units, values, 0.02, 0.1, 9).tolist() == [0, 4]
    assert distinct(units, values, 0.02, 0.01, 9).tolist() == [0, 1, 4, 2]
    assert distinct(units, values, 0.02, 0.01, 3).tolist() == [0, 1, 4]
    assert distinct(units, values, 0.99, 0.1, 9).tolist() == [0, 4]
    assert distinct(units, values + 1e3, 0.02, 0.1, 9).tolist() == [0, 4, 3]
    assert distinct(units, np.full(6, np.inf), 0.02, 0.1, 9).size == 0


def test_a_winner_is_disturbed_in_one_way_at_a_time_and_stays_possible():
    tuning = load_tuning("ssul-set6", {"set": {"C": 0.1}})
    names = [one.words for one in perturbations(tuning)]
    trials = run.perturbed(tuning, np.array([1000.0, 50.0]))
    rows = dict(zip(names, trials.tolist(), strict=True))
    assert rows["none"] == [1000, 50, 1, 0, 1]
    assert rows["omega -1%"] == [1000, 50, 0.99, 0, 1]
    assert rows["5 x the periods"] == [1000, 50, 1, 0, 5]
    assert rows["k2 +2%"] == [1020, 50, 1, 0, 1]
    assert rows["c2 -2%"] == [1000, 49, 1, 0, 1]
    assert rows["random start 1"] == [1000, 50, 1, 1, 1]
    assert len(rows) == 4 + 2 * 2 + STARTS
    # a disturbed design stays possible
    tuning = load_tuning("ssul-set6", {"free": {"nu2": bounds(0.1, 0.5)}})
    assert tuning.names[-1] == "nu2"
    points = run.perturbed(tuning, np.array([500.0, 50.0, 0.1, 0.5]))
    assert points[:, 3].max() == 0.5
    assert points[:, 3].min() == 0.49


def bowl(target):
    """Return an objective with its least value 3 at `target`, and the list of what was asked."""
    asked = []

    def evaluate(points):
        assert ((points >= 0) & (points <= 1)).all()
        asked.append(points.copy())
        return 3 + np.abs(points - target).sum(axis=1)

    return evaluate, asked


def test_whole_generations_are_asked_for_at_once():
    evaluate, asked = bowl([0.2, 0.7, 0.9])
    search_globally(evaluate, 3, Search(population=20, generations=30), seed=1)
    assert {len(points) for points in asked} == {20}
    assert len(asked) <= 31
    best = min(np.concatenate(asked), key=lambda p: np.abs(p - [0.2, 0.7, 0.9]).sum())
    assert best == pytest.approx([0.2, 0.7, 0.9], abs=0.02)
    # the first one fills every slice
    for column in latin_hypercube(10, 3, np.random.default_rng(0)).T:
        assert sorted((column * 10).astype(int)) == list(range(10))


@pytest.mark.parametrize("start", [[0.22, 0.68], [1.0, 1.0], [0.0, 0.7]])
def test_the_local_search_stays_inside_and_within_its_budget(start):
    evaluate, asked = bowl([0.2, 0.7])
    polish(evaluate, np.array(start), 150)
    points = np.concatenate(asked)
    assert len(points) <= 150
    best = points[np.abs(points - [0.2, 0.7]).sum(axis=1).argmin()]
    assert best == pytest.approx([0.2, 0.7], abs=1e-3)
    asked.clear()
    polish(evaluate, np.array(start), 0)
    assert asked == []


def test_cma_is_refused_where_it_is_not_installed(monkeypatch, error_of):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    line = error_of(nv.tune, "tmd", "a.h5", search={"method": "cma"})
    assert "pip install 'nlds-vines[cma]'" in line


def test_cma_finds_a_bowl_where_it_is_installed():
    pytest.importorskip("cma")
    evaluate, asked = bowl([0.2, 0.7])
    search_globally(evaluate, 2, Search(method="cma", population=8, generations=60), seed=1)
    points = np.concatenate(asked)
    assert len(points) <= 8 * 61
    assert np.abs(points - [0.2, 0.7]).sum(axis=1).min() < 1e-2


def test_blocks_that_do_not_fit_a_search_are_refused(tmp_path, error_of):
    tuning = load_tuning("tmd")
    store, trials = Blocks(tmp_path / "a.h5", tuning), run.at_rest(np.ones((2, 2)))
    states = np.zeros((2, 4))
    store.save(0, {"asked": trials, "found": states})
    with Progress(None, "design", quiet=True) as progress:
        log = run.Log(tuning, store, progress)
        assert log.evaluate(trials, "global", 0).tolist() == [0.0, 0.0]
        assert log.replayed == 2
        log, other = run.Log(tuning, store, progress), run.at_rest(2 * np.ones((2, 2)))
        assert "does not fit this search" in error_of(log.evaluate, other, "global", 0)


@pytest.mark.long
@pytest.mark.parametrize("k2", [bounds(10.0, 1e4), bounds(100.0, 1500.0)])
def test_every_seed_beats_table_1(k2, tmp_path):
    tuned = nv.tune("ssul-set1", tmp_path / "a.h5", free={"k2": k2}, search={"seeds": 5})
    assert len(tuned.spread) == 5
    assert max(tuned.spread.values()) <= TABLE_1_BEST
    assert tuned.objective == min(tuned.spread.values())


@pytest.mark.long
def test_every_seed_finds_the_best_linear_damper_of_a_band(tmp_path):
    band = {"omega": {"start": 5.0, "stop": 8.0, "num": 61}}
    tuned = nv.tune("tmd", tmp_path / "a.h5", over=band, search={"seeds": 5})
    assert max(tuned.spread.values()) <= 161.0
    assert tuned.parameters["k2"] == pytest.approx(2083, rel=0.01)
    assert tuned.parameters["c2"] == pytest.approx(112, rel=0.03)


def test_a_value_that_a_search_left_at_its_bound_is_printed_as_the_bound():
    tuning = load_tuning({"system": "ssul-set6"})
    names = {"k2": 500.0, "c2": 1000.0 * (1 - 1e-9), "C": 8.6904e-09}
    best = Optimum({name: names[name] for name in tuning.names}, 80.0, {"none": 80.0})
    tuned = Tuned(tuning, (best,), {0: 80.0}, 10, 0, ArchivePath.of("none.h5"))
    row = next(line for line in tuned.lines() if "(none)" in line).split()
    assert dict(zip(tuning.names, row, strict=False)) == {"k2": "500", "c2": "1000", "C": "0"}
    remarks = [line for line in tuned.lines() if "bound" in line]
    assert [line.partition(":")[0] for line in remarks] == [
        "c2 stands at its bound 1000", "C stands at its bound 0"
    ]  # fmt: skip


@pytest.mark.kernels
def test_optima_are_judged_again_by_draws_that_the_search_did_not_have(tmp_path):
    search = {"draws": 8, "quantile": 0.9, "population": 8, "generations": 4, "polish": 20}
    tuned = nv.tune(
        "tmd", tmp_path / "a.h5", quiet=True, uncertain={"k1": {"spread": "5%", "law": "uniform"}},
        search={**search, "optima": 1}, sampling={"transient": 400},
    )  # fmt: skip
    p = {**nv.load_system("tmd").parameters, **tuned.parameters}
    points = qmc.Sobol(1, scramble=True, seed=2**32).random(1024)[:, 0]
    peaks = []  # of the steady state, by complex numbers
    for k1 in p["k1"] * (1 + 0.05 * (2 * points - 1)):
        size = abs(amplitudes({**p, "k1": k1})[0])
        peaks.append(0.5 * size**2 * max(k1, p["m1"] * p["omega"] ** 2))
    fresh = np.sort(peaks)[math.ceil(0.9 * 1024) - 1]
    assert tuned.objective == pytest.approx(fresh, rel=1e-5)
    assert abs(tuned.best.searched - fresh) > 1e-4 * fresh  # by eight draws
    text = "\n".join(tuned.lines())
    assert f"{fresh:.4g}" in text
    with nv.read(tuned.path) as view:
        assert view["optimum_fresh"][0] == tuned.objective


@pytest.mark.kernels
def test_impacts_of_a_design_are_those_of_its_orbit(tmp_path):
    small = {"population": 5, "generations": 1, "polish": 0, "optima": 1}
    free = {"C": {"low": 0.0, "high": 0.01}, "k2": {"low": 600.0, "high": 601.0}}
    tables = {"free": free, "search": small, "quiet": True}
    tuned = nv.tune("ssul-set6", tmp_path / "a.h5", **tables)
    system = nv.load_system("ssul-set6", **tuned.parameters)
    orbit = nv.simulate(system, 60, transient=300, quiet=True)
    assert len(orbit.impacts) > 30
    assert tuned.best.impacts == pytest.approx(len(orbit.impacts) / 60, abs=1 / 60)
    assert "impacts/T" in "\n".join(tuned.lines())
    struck = nv.tune("ssul-set6", tmp_path / "b.h5", load={"impulse": 1000.0}, **tables)
    system = nv.load_system("ssul-set6", **struck.parameters)
    fall = nv.response_history(system, impulse=1000.0, duration=60.0, quiet=True)["ssul-set6"]
    assert struck.best.impacts == fall.numbers["impact_count"] > 0
