"""Tuning of dampers on hosts: against kinds, against single orbits, places, refusals."""

import numpy as np
import pytest
from support import as_host

import nlds_vines as nv
from nlds_vines.tuning.design_space import places_of
from nlds_vines.tuning.request import load_tuning
from nlds_vines.tuning.result import STAGES
from nlds_vines.tuning.run import Objective, at_rest

FRAME = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.01)
WALLS = [nv.Wall(0.01, side, K=1e8) for side in "+-"]
CELLS = [nv.Damper("a", "roof", m=300.0, walls=WALLS), nv.Damper("b", "floor1", m=200.0, k=1e4)]
SYSTEM = nv.System.from_host(FRAME, CELLS, force={"roof": 1500.0}, omega=12.59)
FREE = {"a": {"k": {"low": 1e3, "high": 9e4}, "gap": {"low": 0.005, "high": 0.05}}}
SMALL = {"population": 5, "generations": 1, "polish": 4, "optima": 2, "within": 0.9, "apart": 0.01}
SHORT = {"transient": 30, "periods": 10}


def test_a_file_of_a_tuning_names_dampers_rows_and_places():
    changes = {
        "free": FREE, "places": {"a": ["floor1", "roof"], "b": ["floor2"]},
        "over": {"f": {"values": [1.9, 2.0]}}, "search": {"objective": "roof-floor2.x_max"},
    }  # fmt: skip
    tuning = load_tuning(SYSTEM, changes)
    assert tuning.names == ("a.k", "a.gap")
    assert [item.logarithmic for item in tuning.free] == [True, False]
    assert tuning.layouts_in_words == ["a on floor1, b on floor2", "a on roof, b on floor2"]
    assert (tuning.unit, tuning.frequency) == ("m", "omega")
    again = load_tuning(tuning.document())
    assert again.document() == tuning.document()
    assert tuning.hash == again.hash != load_tuning(SYSTEM, {"free": FREE}).hash
    assert tuning.most_evaluations > 1.9 * load_tuning(SYSTEM, {"free": FREE}).most_evaluations


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"free": {}}, "nothing is free; of kind 'host' can be: a.m, a.k"),
        ({"free": {"a.kk": {"low": 0.0, "high": 1.0}}}, "unknown free parameter 'a.kk'"),
        ({"free": {"force.roof": {"low": 0.0, "high": 1.0}}}, "unknown free parameter 'force"),
        ({"free": {"a.k": {}}}, "a.k has no default bounds: give both"),
        ({"free": {**FREE, "a.gap+": {"low": 0.0, "high": 1.0}}}, "a.gap beside a.gap+"),
        ({"free": FREE, "search": {"objective": "E3max"}}, "unknown objective 'E3max'"),
        ({"free": FREE, "search": {"objective": "roof.x"}}, "unknown objective 'roof.x'"),
        ({"free": FREE, "search": {"objective": "top.x_max"}}, "unknown displacement 'top'"),
        ({"free": FREE, "places": {"c": ["roof"]}}, "unknown parameter 'c.attached_to'"),
        ({"free": FREE, "places": {"a": ["top"]}}, "damper 'a': unknown attached_to 'top'"),
        ({"free": FREE, "places": {"a": "roof"}}, "places of a: 'roof' must be a list of places"),
        ({"free": FREE, "over": {"a.attached_to": {"values": [1.0]}}}, "unknown parameter 'a.att"),
        ({"free": FREE, "load": {"impulse": 1.0}}, "on is missing, the degree of freedom"),
    ],
)  # fmt: skip
def test_a_wrong_tuning_of_a_host_is_one_line(changes, message, error_of):
    assert message in error_of(load_tuning, SYSTEM, changes)


def test_places_of_a_kind_and_a_host_without_a_force_are_refused(error_of):
    assert "attached_to" in error_of(load_tuning, "tmd", {"places": {"a": ["roof"]}})
    system = {**SYSTEM.to_table(), "force": {"base": {"acceleration": 0.0}, "omega": 1.0}}
    assert "without a force" in error_of(load_tuning, {"system": system, "free": FREE})


@pytest.mark.kernels
def test_designs_of_a_host_of_one_degree_of_freedom_are_those_of_its_kind():
    kind = nv.load_system("ssul-set6", omega=5.5)
    both, C = [], {"C": kind.parameters["C"]}
    for system, fixed, names, worth in (
        (kind, C, ("k2", "c2"), "x1_max"),
        (as_host(kind), {}, ("u.k", "u.c"), "x.x_max"),
    ):
        free = {name: {"low": 1.0, "high": 1e4} for name in names}
        changes = {
            "free": free, "over": {"omega": {"values": [5.5, 7.9]}}, "sampling": SHORT,
            "search": {"objective": worth}, "set": fixed,
        }  # fmt: skip
        tuning = load_tuning(system, changes)
        trials = at_rest(np.array([[640.0, 81.0], [1500.0, 60.0]]))
        trials[1, 3] = 1.01  # detuned
        both.append(Objective(tuning).results(trials))
    assert both[1] == pytest.approx(both[0], rel=1e-8)


@pytest.mark.kernels
def test_the_best_of_all_places_is_the_orbit_of_its_system(tmp_path):
    tuned = nv.tune(
        SYSTEM, tmp_path / "a.h5", free=FREE, sampling=SHORT, quiet=True,
        places={"a": ["floor1", "roof"]}, search={**SMALL, "objective": "roof.x_max"},
    )  # fmt: skip
    with nv.read(tmp_path / "a.h5") as view:
        searched = view["stage"] <= STAGES["polish"]
        layouts, objectives = view["layout"][searched], view["objective"][searched]
    assert np.bincount(layouts).min() >= 14
    assert objectives[layouts == 1].min() == tuned.objective == objectives.min()
    assert tuned.best.places == {"a.attached_to": "roof"}
    assert "a on roof" in "\n".join(tuned.lines())
    system = SYSTEM.with_(**tuned.parameters, **tuned.best.places)
    how = {"transient": 30, "tolerance": tuned.tuning.tolerance, "quiet": True}
    orbit = nv.simulate(system, 10, record=["impacts", "energy", "response"], of=["roof"], **how)
    assert tuned.objective == orbit.response["roof.x_max"]
    assert tuned.best.impacts == len(orbit.impacts) / 10 > 0
    again = nv.open_archive(tmp_path / "a.h5")
    assert again.best.places == tuned.best.places


RIGID = [nv.Wall(0.01, side, law="restitution", e=0.6) for side in "+-"]
BALLS = [nv.Damper("a", "roof", m=300.0, k=1e4, c=60.0, walls=RIGID), CELLS[1]]


@pytest.mark.kernels
@pytest.mark.parametrize("load", [{}, {"impulse": 3e3, "on": "roof"}])
def test_an_objective_that_rigid_walls_make_infinite_is_explained(load, tmp_path, error_of):
    system = nv.System.from_host(FRAME, BALLS, force={"roof": 1500.0}, omega=12.59)
    tables = {"free": {"a.gap": {"low": 0.001, "high": 0.01}}, "quiet": True}
    tables["sampling"] = SHORT
    if load:
        tables |= {"load": load, "sampling": {"duration": 3.0}}
    objectives = ["roof.a_max", *(["a.force_max"] if load else [])]
    for i, name in enumerate(objectives):
        tuned = nv.tune(system, tmp_path / f"{i}.h5", search={**SMALL, "objective": name}, **tables)
        count = tuned.evaluations
        line = (
            f"all {count} designs were inadmissible: {name} is infinite where a rigid wall acts; "
            "a.impulse_max is finite"
        )
        assert [*tuned.lines()][1:] == [line]
        assert line in error_of(lambda tuned: tuned.best, tuned)
    search = {**SMALL, "objective": "a.impulse_max"}
    tuned = nv.tune(system, tmp_path / "finite.h5", search=search, **tables)
    assert tuned.tuning.unit == "N s"
    if not load:
        best, how = system.with_(**tuned.parameters), {"transient": 30, "quiet": True}
        orbit = nv.simulate(best, 10, record=["response"], **how)
        assert tuned.objective == orbit.response["a.impulse_max"] > 0.0


LINEAR = nv.System.from_host(
    nv.Host([[10.0]], [[4000.0]], [[8.0]]), [nv.Damper("t", "x1", m=0.6, k=200.0, c=2.0)]
)
STRUCK = {
    "load": {"impulse": 5.0, "on": "x1", "half_sine": {"peak": 3.0, "length": 0.2, "at": 7.0}},
    "sampling": {"duration": 8.0},
    "free": {"t.c": {"low": 1.0, "high": 30.0}},
}


def test_loads_of_hosts_may_be_uncertain_and_a_wrong_name_is_refused_in_its_table(error_of):
    for name in ("impulse", "scale", "half_sine.peak", "t.k"):
        tuning = load_tuning(LINEAR, {**STRUCK, "uncertain": {name: "20%"}})
        assert [one.name for one in tuning.uncertain] == [name]
    line = error_of(load_tuning, LINEAR, {**STRUCK, "uncertain": {"t.kk": "20%"}})
    assert "[uncertain]: unknown uncertain parameter 't.kk'" in line
    assert "impulse, scale" in line
    assert "ground" not in line
    line = error_of(load_tuning, LINEAR, {**STRUCK, "uncertain": {"ground.acceleration": "20%"}})
    assert "ground.acceleration: a system's own force is off under a load" in line


@pytest.mark.kernels
def test_an_uncertain_blow_scales_the_response_of_a_linear_host():
    """x_max is proportional to the impulse, as the mean over the draws is to their mean."""
    changes = {**STRUCK, "load": {"impulse": 5.0, "on": "x1"}}
    changes["search"] = {"objective": "x1.x_max", "draws": 8}
    trials = at_rest(np.array([[2.0], [9.0]]))
    one = Objective(load_tuning(LINEAR, {**changes, "search": {"objective": "x1.x_max"}}))
    certain = one.results(trials)[:, 0]
    both = Objective(load_tuning(LINEAR, {**changes, "uncertain": {"impulse": "20%"}}))
    tuning = load_tuning(LINEAR, {**changes, "uncertain": {"impulse": "20%"}})
    places = places_of(tuning.uncertain, 8, tuning.search.seed)[1:, 0]
    assert np.ptp(places) > 1.0
    mean = certain * np.mean(1 + 0.2 * places)
    assert both.results(trials)[:, 0] == pytest.approx(mean, rel=1e-9)
