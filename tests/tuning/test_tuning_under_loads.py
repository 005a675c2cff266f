"""Tuning under loads, and for what is uncertain: what is asked, drawn, computed and told."""

import math
import warnings

import numpy as np
import pytest
from scipy.stats import qmc, truncnorm
from support import amplitudes

import nlds_vines as nv
from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.files import parse_toml
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.errors import LeftAside
from nlds_vines.loads.request import load_response_history
from nlds_vines.orbits.records import OK, TOO_STIFF
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.tuning import run
from nlds_vines.tuning.design_space import CUT, DRAWS, Uncertain, places_of
from nlds_vines.tuning.request import load_tuning
from nlds_vines.tuning.result import Optimum, Tuned, over_finer_bands, perturbations
from nlds_vines.tuning.run import Objective, at_rest, over_draws, perturbed

FILE = """
title = "Struck"
system = "tmd"
load = { impulse = 900.0 }
free = { k2 = { low = 500.0, high = 5000.0 } }
over = { scale = { values = [0.5, 1.0] } }
sampling = { transient = 40, duration = 9.0 }
search = { seed = 3 }
uncertain = { k1 = "5%", m1 = { spread = 20.0, law = "uniform" } }
"""
BLOW = {"load": {"impulse": 1000.0}, "sampling": {"duration": 12.0}}
COARSE = {"load": {"record": {"times": [0.0, 0.05], "values": [0.0, 1.0], "unit": "g"}}}
SMALL = {"population": 5, "generations": 2, "polish": 4, "optima": 1}
DESIGN = np.array([[1500.0, 100.0]])


def test_one_file_is_a_decay_and_a_tuning_and_its_canonical_form_means_the_same(here):
    file = here / "a.toml"
    file.write_text(FILE)
    with pytest.warns(LeftAside, match=r"\[free\], \[over\], \[search\], \[uncertain\], transient"):
        history = load_response_history(file)
    tuning = load_tuning(file)
    assert (tuning.history.load, tuning.history.duration) == (history.load, 9.0)
    assert (tuning.title, tuning.names, tuning.search.objective) == ("Struck", ("k2",), "last_1")
    assert (tuning.unit, tuning.case_count, tuning.draws) == ("s", 2, DRAWS)
    again = 5 * 2 * (1024 + 1)  # optima, by fresh draws
    assert tuning.most_lanes == tuning.most_evaluations * 2 * (DRAWS + 1) + again
    # the canonical file means the same
    tuning = load_tuning(file, {"search": {"draws": 8, "quantile": 0.75}})
    again = load_tuning(parse_toml(tuning.to_toml(), "here"))
    assert again == tuning
    assert again.hash == tuning.hash
    assert load_tuning(file).hash != tuning.hash
    assert [one.words() for one in again.uncertain] == ["k1 ±5 % (normal)", "m1 ±20 (uniform)"]


def test_a_level_that_no_design_reaches_is_named(here, ask, monkeypatch):
    def too_short(_, trials):
        return np.tile([np.inf, np.nan, OK, 0.0], (len(trials), 1))

    monkeypatch.setattr(Objective, "results", too_short)
    few = "--population 5 --generations 1 --polish 0 --quiet"
    words = f"tuning --system tmd --impulse 9 --duration 3 {few} --plot a.png"
    _, error = ask(*words.split(), status=1)
    assert "no design was admissible" in error
    assert "if it is ok, E1 exceeds 1 % of its largest after 3 s" in error
    assert not (here / "a.png").exists()


def test_options_mean_the_same_as_a_file(answer, refusal):
    words = ["--system", "tmd", "--impulse", "900", "--free", "k2=500:5000", "--duration", "9",
             "--over", "scale=0.5,1", "--uncertain", "k1=5%", "--uncertain", "m1=20:uniform",
             "--load", "tone:amplitude=3,omega=6", "--quantile", "0.9", "--draws", "4"]  # fmt: skip
    out = answer("tuning", *words, "--dry-run")
    for line in ("load:     a blow of 900 N s + tone", "draws:    m1 ±20 (uniform)",
                 "90 % quantile of the largest last_1 of all cases over 4 draws", "10 orbits each",
                 "followed: 9 s each"):  # fmt: skip
        assert line in out
    assert "must be NAME=SPREAD" in refusal("tuning", "--uncertain", "k1")
    line = refusal("tuning", "--uncertain", "k1=x")
    assert "--uncertain k1 = 'x' must be a number" in line


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({**BLOW, "sampling": {"periods": 3}}, "periods is not used under a load"),
        ({"sampling": {"duration": 3.0}}, "duration is not used without [load]"),
        ({**BLOW, "search": {"objective": "last_2"}}, "did you mean 'last_1'"),
        ({**BLOW, "search": {"objective": "balance"}}, "unknown objective 'balance'"),
        ({**BLOW, "search": {"objective": "drift_max"}}, "unknown objective 'drift_max'"),
        ({**COARSE, "over": {"k1": {"values": [40000.0, 4e6]}}}, "the natural period 0.09"),
        ({**COARSE, "over": {"f1": {"values": [1.0, 11.0]}}}, "the natural period 0.0909"),
        ({**BLOW, "over": {"noise.seed": {"values": [1]}}}, "the load has 0 of 'noise'"),
        ({"over": {"impulse": {"values": [1.0]}}}, "unknown parameter 'impulse'"),
        ({"load": {"scale": 2.0}}, "[load] is empty"),
        ({**BLOW, "uncertain": {"k1": "5"}}, "spread of k1 = '5' must be as '5%', or a number"),
        ({**BLOW, "uncertain": {"k1": "-5%"}}, "spread of k1 = -5.0 must be > 0"),
        ({"uncertain": {"k1": {"spread": 5.0, "law": "gauss"}}}, "distribution of k1 'gauss'"),
        ({**BLOW, "uncertain": {"k1": {"size": 5.0}}}, "unknown key 'size'"),
        ({"uncertain": {"k1": ""}}, "spread of k1 = ''"),
        ({**BLOW, "uncertain": {"k1": "nan%"}}, "nan"),
        ({**BLOW, "uncertain": {"k1": "40%"}}, "k1 = -7900.0 is not allowed"),
        ({**BLOW, "uncertain": {"k4": "4%"}}, "unknown uncertain parameter 'k4'"),
        ({**BLOW, "uncertain": {"friedlander.peak": "4%"}}, "the load has 0 of 'friedlander'"),
        ({"uncertain": {"omega": "4%"}, "over": {"omega": {"values": [6.0]}}}, "not both"),
        ({"uncertain": {"k1": "4%"}, "search": {"draws": 48}}, "draws = 48 must be a power of two"),
        ({"uncertain": {"k1": "4%"}, "search": {"draws": 1}}, "draws = 1 must be a power of two"),
        ({"search": {"draws": 4}}, "draws = 4: neither [uncertain] nor noise"),
        ({**BLOW, "over": {"omega": {"start": 5, "stop": 8, "num": 31}}}, "omega: the harmonic"),
        ({**BLOW, "over": {"f": {"values": [0.9, 1.0]}}}, "the harmonic force is off"),
        ({**BLOW, "uncertain": {"P": "5%"}}, "P: the harmonic force is off"),
        ({"over": {"f": {"values": [1.0]}, "omega": {"values": [5.0]}}}, "omega beside f"),
        ({"search": {"quantile": 0.5}}, "quantile = 0.5: of no draws"),
        ({"uncertain": {"k1": "4%"}, "search": {"draws": 65536}}, "allowed: up to"),
    ],
)  # fmt: skip
def test_a_wrong_request_is_one_line(changes, message, error_of):
    assert message in error_of(load_tuning, "tmd", changes)


@pytest.mark.parametrize("load", [{}, BLOW])
@pytest.mark.parametrize(
    ("law", "law_2", "objective", "message"),
    [
        ("restitution", "", "a1_max", "under law restitution; allowed: law hertz or power or"),
        ("restitution", "", "force_max", "under law restitution; allowed: law hertz or power or"),
        ("restitution", "linear", "a1_max", "under law restitution and linear; allowed: law hertz"),
        ("hertz", "", "impulse_max", "under law hertz; allowed: law restitution, or objective"),
        ("restitution", "linear", "force_max", ""),
        ("restitution", "", "impulse_max", ""),
        ("hertz", "", "a1_max", ""),
    ],
)
def test_an_objective_that_a_contact_law_does_not_have_is_refused(
    load, law, law_2, objective, message, error_of
):
    laws = {"law": law, **({"e": 0.6} if law == "restitution" else {})}
    laws |= {"law_2": law_2, "kc_2": 1e6} if law_2 else {}
    changes = {**load, "set": laws, "search": {"objective": objective}}
    if message:
        assert f"{objective} does not exist {message}" in error_of(load_tuning, "ssbl", changes)
    else:
        assert load_tuning("ssbl", changes).search.objective == objective


STRUCTURE = {
    "kind": "tmd", "m1": 1000.0, "T1": 0.8, "zeta1": 0.02, "mass_ratio": 0.05,
    "frequency_ratio": 0.95, "zeta2": 0.1,
}  # fmt: skip


def test_a_load_needs_no_harmonic_force_and_all_else_does(error_of, here, ask):
    blow = {"system": STRUCTURE, "load": {"impulse": 100.0}}
    for load in (load_tuning, load_response_history):
        request = load(blow)
        assert load(request.document()) == request
        system = getattr(request, "system", None) or request.systems[0]
        assert (system.force, system.sources["P"][:9]) == (0.0, "not given")
    harmonic = {**blow, "load": {**blow["load"], "harmonic": True}}
    for load, document in (
        (load_tuning, {"system": STRUCTURE}), (load_tuning, harmonic),
        (load_response_history, harmonic), (load_scan, {"system": STRUCTURE}),
    ):  # fmt: skip
        assert "'tmd' are missing: P, omega" in error_of(load, document)
    parameters = {**STRUCTURE, "P": 5.0}
    assert "are missing: omega" in error_of(load_tuning, {**harmonic, "system": parameters})
    # likewise a system of a file
    entries = (f"{k} = {v!r}" for k, v in STRUCTURE.items())
    (here / "mine.toml").write_text("\n".join(["[system]", *entries]))
    words = "tuning --system mine.toml --dry-run"
    ask(*f"{words} --impulse 100".split())
    assert "are missing: P, omega" in ask(*words.split(), status=2)[1]


def test_a_band_stays_in_hertz_in_request_title_and_report():
    band = np.linspace(0.8, 1.2, 5)
    tuning = load_tuning("tmd", {"over": {"f": {"values": band.tolist()}}})
    assert tuning.document()["over"] == {"f": {"values": band.tolist()}}
    (axis,) = tuning.over
    assert axis.name == "omega"
    np.testing.assert_array_equal(axis.values, 2 * math.pi * band)
    assert load_tuning(tuning.document()).over == tuning.over
    assert tuning.title.endswith("tuned for f from 0.8 to 1.2 Hz")
    best = Optimum({"k2": 500.0, "c2": 100.0}, 80.0, {"none": 80.0}, finer=81.0)
    lines = [*Tuned(tuning, (best,), {0: 80.0}, 10, 0, ArchivePath.of("none.h5")).lines()]
    assert "E1max is the largest of 5 values of f; finer: of 33" in lines


@pytest.mark.parametrize("band", [{"omega": [5.0, 6.0, 7.0]}, {"f": [5 / 6, 1.0, 7 / 6]}])
def test_a_band_under_a_tone_is_that_of_the_tone(band):
    tone = {"load": {"tone": {"amplitude": 3.0, "omega": 6.0}}, "over": band}
    tuning = load_tuning("tmd", tone)
    (axis,) = tuning.over
    factor = 1.0 if "omega" in band else 2 * math.pi
    assert axis.name == "tone.omega"
    assert axis.values == pytest.approx([factor * one for one in next(iter(band.values()))])
    name = "f" if "f" in band else "tone.omega"
    assert tuning.document()["over"] == {name: {"values": next(iter(band.values()))}}
    assert load_tuning(tuning.document()).over[0].values.tolist() == axis.values.tolist()
    assert over_finer_bands(tuning) is None  # three values are no range, seven are one
    tone["over"] = {name: {"start": 1.0, "stop": 7.0, "num": 7} for name in band}
    assert over_finer_bands(load_tuning("tmd", tone)).over[0].values.size == 49
    harmonic = {**tone, "load": {**tone["load"], "harmonic": True}}
    assert load_tuning("tmd", harmonic).over[0].name == "omega"


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("--band 5:8:4", "omega = 5 to 8 rad/s (0.7958 to 1.273 Hz), 4 values"),
        ("--band f=0.8:1.2:5", "f = 0.8 to 1.2 Hz (5.027 to 7.54 rad/s), 5 values"),
        ("--band f=0.8:1.2:5", "largest E1max of all cases: 5 values of f, from rest"),
        ("--load tone:amplitude=3,omega=6 --band f=1:2:4", "f = 1 to 2 Hz (6.283 to 12.57 rad/s)"),
        ("--over f=0.8:1.2:5", "f = 0.8 to 1.2 Hz (5.027 to 7.54 rad/s), 5 values"),
        ("--over P=600:1000:3 --band 5:8:4", "P = 600 to 1000 N, 3 values"),
        ("--load tone:amplitude=3,omega=6 --band 5:8:4", "tone.omega = 5 to 8, 4 values"),
        ("--generations 8", "60 first designs and as many in each of at most 8 generations"),
    ],
)
def test_a_plan_names_bands_ranges_and_generations(words, line, answer):
    assert line in answer("tuning", "--system", "tmd", *words.split(), "--dry-run")


def test_walls_loads_and_moving_grounds_bring_objectives_of_their_own():
    of_contacts = {"impact_count", "force_max"}
    assert of_contacts <= load_tuning("ssul-set6", BLOW).objectives.keys()
    assert not of_contacts & load_tuning("tmd", BLOW).objectives.keys()
    # requests of the steady state name no load
    document = load_tuning("tmd").document()
    assert document.keys() == {"title", "system", "free", "over", "sampling", "search"}
    assert "duration" not in document["sampling"]


def test_draws_are_quantiles_of_their_distributions_at_sobol_points():
    what = (Uncertain("k1", 5.0, True), Uncertain("m1", 20.0, False, "uniform"))
    places = places_of(what, 64, 7)
    points = qmc.Sobol(2, scramble=True, seed=7).random_base2(6)
    assert places[0].tolist() == [0.0, 0.0]
    np.testing.assert_allclose(places[1:, 0], truncnorm(-CUT, CUT).ppf(points[:, 0]), atol=2e-9)
    np.testing.assert_allclose(places[1:, 1], 2 * points[:, 1] - 1, atol=1e-15)
    assert places[1:].mean(axis=0) == pytest.approx([0, 0], abs=0.05)  # evenly spread
    assert places[1:].std(axis=0) == pytest.approx([0.9866, 1 / math.sqrt(3)], rel=0.03)
    assert not np.array_equal(places_of(what, 64, 8), places)
    np.testing.assert_allclose(what[0].at(200.0, places[:, 0]), 200 * (1 + 0.05 * places[:, 0]))
    np.testing.assert_allclose(what[1].at(200.0, places[:, 1]), 200 + 20 * places[:, 1])
    # one above the middle is larger also of a negative value: C where a damper presses
    for one in (Uncertain("C", 5.0, True), Uncertain("C", 0.1, False)):
        assert one.at(np.array([-2.0, 2.0]), 1.0) == pytest.approx([-1.9, 2.1], rel=1e-15)
        values = one.at(-2.0, np.array([-1.0, 0.0, 1.0]))
        assert values == pytest.approx([-2.1, -2.0, -1.9], rel=1e-15)


def test_a_design_is_judged_by_mean_or_quantile_of_the_worst_case_in_each_draw():
    draws = np.array([9.0, 1, 2, 3, 4, 5, 6, 7, 8])  # the first as given
    fine = np.column_stack([draws, 10 * draws, np.full(9, OK), draws % 3])
    failed = fine.copy()
    failed[4, [0, 2]] = np.inf, TOO_STIFF
    numbers = over_draws(np.array([fine, failed]), None, 0.75)
    assert numbers[0].tolist() == [4.5, 90, OK, 0, 9, 4.5, 6]
    assert numbers[1].tolist() == [np.inf, 90, TOO_STIFF, 0, 9, np.inf, 7]
    by_quantile = over_draws(np.array([fine, failed]), 0.75, 0.75)
    assert by_quantile[:, 0].tolist() == [6, 7]
    assert by_quantile[:, 2].tolist() == [OK, OK]
    assert np.array_equal(over_draws(fine[np.newaxis, :1], None, 0.9), fine[:1])


def test_a_winner_under_a_load_is_disturbed_in_one_way_at_a_time():
    tuning = load_tuning("tmd", {**BLOW, "uncertain": {"k1": "1%"}})
    names = [one.words for one in perturbations(tuning)]
    trials = perturbed(tuning, DESIGN[0])
    rows = dict(zip(names, trials.tolist(), strict=True))
    assert rows == {
        "none": [1500, 100, 1, 0, 1],
        "natural frequency -1%": [1500, 100, 0.99, 0, 1],
        "natural frequency +1%": [1500, 100, 1.01, 0, 1],
        "load -10%": [1500, 100, 1, 0, 0.9],
        "load +10%": [1500, 100, 1, 0, 1.1],
        "k2 -2%": [1470, 100, 1, 0, 1],
        "k2 +2%": [1530, 100, 1, 0, 1],
        "c2 -2%": [1500, 98, 1, 0, 1],
        "c2 +2%": [1500, 102, 1, 0, 1],
    }


def test_each_orbit_gets_its_parameters_its_load_and_its_noise(monkeypatch):
    seen = []

    def fly(history, system, grid, each, has_histories, tell):
        for i, (load, _) in enumerate(each):
            drawn = system.with_(**{name: values[i] for name, values in grid.items()})
            seen.append((drawn.parameters, load))
        failed, nothing = np.full(len(each), TOO_STIFF), np.zeros(len(each))
        numbers = {"last_1": nothing, "E2max": nothing}
        return {**numbers, "status": failed, "violations": nothing}

    monkeypatch.setattr("nlds_vines.loads.run._fly", fly)
    noise = {"noise": {"rms": 2.0, "high": 20.0, "seed": 5}}
    tuning = load_tuning("tmd", {
        "load": noise, "sampling": {"duration": 3.0},
        "over": {"noise.rms": {"values": [1.0, 2.0]}},
        "uncertain": {"k2": "10%", "scale": 0.01}, "search": {"draws": 2},
    })  # fmt: skip
    trials = np.array([[*DESIGN[0], 1.01, 0.0, 1.1]])
    results = Objective(tuning).results(trials)
    assert results[0].tolist()[2:4] == [TOO_STIFF, 0]
    assert results[0, 0] == np.inf
    places = places_of(tuning.uncertain, 2, 0)
    assert len(seen) == 6
    in_order = ((draw, rms) for draw in range(3) for rms in (1.0, 2.0))
    for (parameters, load), (draw, rms) in zip(seen, in_order, strict=True):
        assert parameters["k2"] == pytest.approx(1500 * (1 + 0.1 * places[draw, 0]))
        assert parameters["k1"] == pytest.approx(tuning.system.parameters["k1"] * 1.01**2)
        assert load.scale == pytest.approx(1.1 * (1 + 0.01 * places[draw, 1]))
        assert (load.noise[0].rms, load.noise[0].seed) == (rms, 5 + draw)


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["last_1", "x1_max", "share_c1"])
def test_the_objective_is_the_worst_decay(name):
    impulses, search = (300.0, 1000.0), {"objective": name}
    tuning = load_tuning("ssul-set6", {**BLOW, "over": {"impulse": impulses}, "search": search})
    points = np.array([[500.0, 80.0, 0.1], [900.0, 60.0, 0.05]])
    results = Objective(tuning).results(at_rest(points))
    for row, (k2, c2, C) in zip(results, points, strict=True):
        system = nv.load_system("ssul-set6", k2=k2, c2=c2, C=C)
        falls = [
            nv.response_history(system, impulse=i, duration=12.0, quiet=True) for i in impulses
        ]
        values = [fall["ssul-set6"].numbers[name] for fall in falls]
        assert row[0] == pytest.approx(max(values), rel=1e-11)
        assert row[3] == int(np.argmax(values))


@pytest.mark.kernels
def test_a_linear_damper_of_an_uncertain_structure_against_its_transfer_function():
    uncertain = {"k1": "5%", "P": {"spread": 50.0, "law": "uniform"}}
    tuning = load_tuning("tmd", {"uncertain": uncertain, "search": {"draws": 16}})
    results = Objective(tuning).results(at_rest(DESIGN))[0]
    p = {**tuning.system.parameters, "k2": DESIGN[0, 0], "c2": DESIGN[0, 1]}
    energies = []
    for of_k1, of_P in places_of(tuning.uncertain, 16, 0):
        k1, P = p["k1"] * (1 + 0.05 * of_k1), p["P"] + 50.0 * of_P
        x1 = abs(amplitudes({**p, "k1": k1, "P": P})[0])
        energies.append(0.5 * x1**2 * max(k1, p["m1"] * p["omega"] ** 2))
    mean, quantile = np.mean(energies[1:]), np.sort(energies[1:])[math.ceil(0.9 * 16) - 1]
    assert results[[0, 4, 5, 6]] == pytest.approx([mean, energies[0], mean, quantile], rel=1e-6)


@pytest.mark.kernels
def test_a_tuning_under_a_load_gives_the_same_bits_resumes_and_says_what_it_found(
    tmp_path, monkeypatch, capsys
):
    tables = {**BLOW, "uncertain": {"k1": "3%"}, "search": {**SMALL, "draws": 2}}
    first = nv.tune("tmd", tmp_path / "a.h5", threads=1, quiet=True, **tables)
    real, calls = run.outcome_under, []

    def interrupted(*arguments):
        calls.append(1)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return real(*arguments)

    monkeypatch.setattr(run, "outcome_under", interrupted)
    with pytest.raises(Interrupted, match="3 blocks are kept"):
        nv.tune("tmd", tmp_path / "b.h5", quiet=True, **tables)
    again = nv.tune("tmd", tmp_path / "b.h5", threads=2, resume=True, quiet=True, **tables)
    with nv.read(first.path) as one, nv.read(again.path) as other:
        assert other.attrs["replayed"] > 0
        for name in one.names:
            assert np.array_equal(one[name], other[name], equal_nan=True) or one[name].dtype == "O"
        assert "random_start" not in one
        assert one.long_name("stretch") == "factor on the load"
        best = one["optimum_evaluation"][0]
        columns = [one[name][best] for name in ("nominal", "mean", "quantile")]
    assert [first.best.nominal, first.best.mean, first.best.quantile] == columns
    assert first.best.searched == first.best.mean
    assert first.best.worst >= first.best.searched
    text = "\n".join(first.lines())
    assert "1024 draws that the search did not have" in text
    assert "judged by the mean of last_1 over 2 draws of k1 ±3 % (normal): as given" in text
    assert "last_1 [s]" in text
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert nv.open_archive(again.path).objective == first.objective


SHAKEN = {"rectangular": {"peak": 0.2, "length": 2.0, "unit": "g"}}


@pytest.mark.parametrize(
    ("objective", "load", "words"),
    [
        ("a1_max", {"load": SHAKEN}, "absolute acceleration"),
        ("x1_max", {"load": SHAKEN}, "relative to the ground"),
        ("drift_max", {"load": SHAKEN}, "relative to the moving ground"),
        ("x1_max", {"set": {"base_acceleration": 1.0}}, "x1 of the structure, absolute"),
        ("drift_max", {"set": {"base_acceleration": 1.0}}, "relative to its foot"),
    ],
)
def test_an_objective_says_its_frame(objective, load, words):
    tuning = load_tuning("tmd", {**load, "search": {"objective": objective}})
    assert tuning.objective_in_words.startswith(f"{objective}, largest")
    assert words in tuning.objective_in_words
