"""Systems: the catalog, checks, K, ratios in place of parameters, axes, and numbers for kernels."""

import copy
import pickle
from math import pi, sqrt

import numpy as np
import pytest

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.response_curves import load_curves, with_structure_alone
from nlds_vines.cli.options import spaced
from nlds_vines.continuation.request import load_continuation
from nlds_vines.engine.section_map import SectionMap
from nlds_vines.errors import Reordered, RequestError
from nlds_vines.loads.request import load_response_history
from nlds_vines.model import catalog as packaged_files
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalog import any_system_from, catalog, load_system, system_names
from nlds_vines.model.parameters import CONTACT, PARAMETERS, Parameter
from nlds_vines.model.presets import CELL
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import System
from nlds_vines.plotting.bands import inner_edges, is_list, logarithmic
from nlds_vines.tuning.request import load_tuning
from nlds_vines.tuning.run import Objective, at_rest

stiffness_of_set6 = 32504566.49525256
stiffness_of_steel = 159844234214.64865

ON_SPRINGS = ["nes-cubic", "nes-bistable", "nes-vibro-impact-cubic"]
OTHERS = ["impact-oscillator", "hard-oscillator", "bilinear-oscillator", "bouncing-ball", "vi-nes"]
TABLE_1 = {  # k2, c2, C, V
    "ssul-set1": (215, 232, 0.03, 0.03),
    "ssul-set2": (215, 232, 0.05, 0.1),
    "ssul-set3": (700, 50, 0.06, 0.1),
    "ssul-set4": (753.1, 50.09, 0.08286, 0.1),
    "ssul-set5": (784.9, 50, 0.09975, 0.1),
    "ssul-set6": (668.9, 50.83, 0.06233, 0.1),
    "ssul-set6-table2": (669, 50.8, 0.062, 0.1),
}


@pytest.fixture
def set6() -> System:
    return load_system("ssul-set6")


def test_the_catalog_has_the_names_of_the_interface_and_marks_what_is_assumed(set6):
    assert list(catalog()) == ["none", "tmd", *TABLE_1, "ssbl", *OTHERS]
    assert list(system_names()) == [*catalog(), *ON_SPRINGS]
    p = load_system("tmd").parameters
    assert (p["m2"], p["k2"], p["c2"]) == (60, 600, 262)
    assert set6.assumptions.keys() == {"A", "B", "q1"}
    assert "32504566" in set6.assumptions["A"]


@pytest.mark.parametrize("name", ["none", "tmd", *TABLE_1])
def test_structure_and_force_are_the_same_for_all_and_ssul_sets_those_of_the_tables(name):
    p = load_system(name).parameters
    structure = {"m1": 1000, "k1": 39500, "c1": 452, "P": 800, "omega": 6.28}
    assert {key: p[key] for key in structure} == structure
    if name in TABLE_1:
        assert (p["k2"], p["c2"], p["C"], p["V"]) == TABLE_1[name]


def test_a_wheel_finds_its_own_files_before_those_of_a_clone(tmp_path, monkeypatch):
    clone = packaged_files.resource_text("figure8.toml")
    (tmp_path / "_data").mkdir()
    (tmp_path / "_data" / "figure8.toml").write_text("packed")
    monkeypatch.setattr(packaged_files, "files", lambda package: tmp_path)
    assert packaged_files.resource_text("figure8.toml") == "packed"
    assert [path.name for path in packaged_files.figure_files()] == ["figure8.toml"]
    (tmp_path / "_data" / "figure8.toml").unlink()
    assert packaged_files.resource_text("figure8.toml") == clone


def test_a_request_file_that_is_not_in_the_folder_is_the_packaged_one(here, error_of):
    assert load_scan("figure8.toml") == load_scan(packaged_files.resource_path("figure8.toml"))
    assert load_system("figure8.toml").parameters == load_system("ssul-set6").parameters
    (here / "figure8.toml").write_text('system = "tmd"\n[vary]\nomega = [5.0, 6.0]\n')
    assert load_scan("figure8.toml").system.kind == "tmd"
    assert load_system("figure8.toml").kind == "tmd"
    (here / "figure8.toml").unlink()
    for name in ("./figure8.toml", "folder/figure8.toml", here / "figure8.toml", "no.toml"):
        assert "No such file" in error_of(load_scan, name)


def test_a_stiffness_replaces_the_constants_and_they_replace_it(set6, error_of):
    # that of equation (4), and of steel on steel
    moduli = np.array([2.05e7, 2.1e11])
    stiffness = set6.cells({"E2": moduli})["K"]
    assert stiffness == pytest.approx([stiffness_of_set6, stiffness_of_steel], rel=1e-14)
    assert stiffness.tolist() == [set6.K, set6.with_(E2=2.1e11).K]
    # a given stiffness replaces the constants
    stiffer = set6.with_(K=2.5e7)
    assert stiffer.K == 2.5e7
    assert not stiffer.parameters.keys() & set(CONTACT)
    assert not stiffer.assumptions
    # all constants together replace it
    constants = {name: set6.parameters[name] for name in CONTACT}
    again = set6.with_(K=1.0).with_(**constants)
    assert again.parameters == set6.parameters
    # a scene without contact has none
    assert "'tmd' has no contact" in error_of(getattr, load_system("tmd"), "K")
    assert load_system("tmd").cells()["K"] == 0
    # a varied stiffness replaces the constants
    assert set6.cells({"K": np.array([1.0, 2.0])})["K"].tolist() == [1.0, 2.0]


def test_only_what_changes_is_checked_again_and_the_result_is_that_of_a_full_check(
    set6, monkeypatch
):
    checked = []
    check = Parameter.check
    monkeypatch.setattr(
        Parameter, "check", lambda self, values: (checked.append(self.name), check(self, values))
    )
    damped = set6.with_(zeta1=0.02)
    checked.clear()
    changed = damped.with_(k2=500.0, k1=4e4)
    assert set(checked) == {"k2", "k1", "c1"}  # the damping follows from the stiffness
    values = {**changed.parameters, "zeta1": 0.02}
    del values["c1"]
    whole = System("ssul", values, set6.name, set6.title, changed.sources, changed.assumptions)
    assert whole == changed
    assert whole.cells().tobytes() == changed.cells().tobytes()
    assert changed.sources.keys() >= {"k1", "k2", "c1"}


def test_scenes_rest_and_touch_where_their_parameters_say(set6):
    p = set6.parameters
    assert set6.rest == p["V"] + p["C"] == 0.16233
    assert set6.scene.walls == ("near",)
    r_at_touch = set6.rest - p["V"]  # u = V
    assert set6.scene.gap_near(p) == pytest.approx(r_at_touch)
    assert set6.scene.obstacle(p) == {"obstacle": p["V"]}
    tmd = load_system("tmd")
    assert tmd.rest == 0
    assert tmd.scene.damper
    assert tmd.scene.walls == ()
    assert tmd.scene.obstacle(tmd.parameters) == {}
    alone = load_system("none")
    assert alone.rest is None
    assert not alone.scene.damper
    assert set(alone.parameters) == {"m1", "k1", "c1", "P", "omega"}
    assert set6.with_(omega=2.0).period == pi


def test_scenes_have_parameters_that_exist_and_the_edges_of_ranges_are_allowed(set6):
    for kind, scene in SCENES.items():
        assert scene.kind == kind
        assert set(scene.allowed) <= PARAMETERS.keys()
    edges = {"C": -0.01, "V": -1.0, "k1": 0, "c1": 0, "P": 0, "A": 0, "nu1": 0.5}
    for name, value in edges.items():
        assert set6.with_(**{name: value}).parameters[name] == value


def test_systems_are_immutable_travel_and_copy(set6):
    with pytest.raises(TypeError):
        set6.parameters["m1"] = 1.0
    with pytest.raises(AttributeError):
        set6.kind = "tmd"
    set6.with_(m1=1.0)
    assert set6.parameters["m1"] == 1000.0
    assert pickle.loads(pickle.dumps(set6)) == set6
    assert copy.deepcopy(set6) == set6
    assert set6 != set6.with_(P=801)
    changed = set6.with_(A=0.25, P=800)
    assert changed.sources["A"] == "set by the user"
    assert changed.assumptions.keys() == {"B", "q1"}
    assert changed.sources["P"] == set6.sources["P"]  # the same value as before
    changed = set6.with_(m1=900, C=np.int64(0), P=np.float32(0.5))
    assert [type(value) for value in changed.parameters.values()] == [float] * 17
    assert changed.parameters["m1"] == 900.0


def test_cells_hold_the_numbers_of_systems_one_by_one(set6):
    cell = set6.cells()
    assert cell.shape == ()
    assert cell.dtype == CELL
    for name in ("m1", "k1", "c1", "m2", "k2", "c2", "P", "omega"):
        assert cell[name] == set6.parameters[name]
    assert cell["K"] == set6.K
    assert (cell["near"], cell["far"], cell["rest"]) == (0.06233, 0.0, 0.16233)
    omega, moduli, gaps = [5.0, 6.0, 7.0], [1e7, 2e7], [-0.01, 0.02]
    grid = dict(zip(("omega", "E2", "C"), np.ix_(omega, moduli, gaps), strict=True))
    cells = set6.cells(grid)
    assert cells.shape == (3, 2, 2)
    for index in np.ndindex(cells.shape):
        i, j, k = index
        single = set6.with_(omega=omega[i], E2=moduli[j], C=gaps[k])
        assert cells[index] == single.cells()[()]


def test_systems_of_files_come_from_a_table_of_their_own_or_with_what_is_set(tmp_path):
    flat = 'kind = "none"\ntitle = "mine"\nm1 = 1\nk1 = 2.5\nc1 = 0\nP = 1\nomega = 3\n'
    path, nested, scan = (tmp_path / f"{name}.toml" for name in ("mine", "nested", "scan"))
    path.write_text(f"[system]\n{flat}")
    system = load_system(path, P=2)
    assert dict(system.parameters) == {"m1": 1, "k1": 2.5, "c1": 0, "P": 2, "omega": 3}
    assert (system.name, system.title) == (str(path), "mine")
    nested.write_text("[system]\n" + flat.replace("m1", "[system.parameters]\nm1", 1))
    assert load_system(str(nested)).with_(P=2).parameters == system.parameters
    scan.write_text('system = "ssul-set6"\n[set]\nP = 600\n[vary]\nomega = { values = [5.0] }\n')
    assert load_system(scan).parameters == load_system("ssul-set6", P=600).parameters


CHANGES = [
    ("ssul-set6", {"E1": 1e-320}, r"K = 0\.0 is not allowed"),
    ("ssul-set6", {"E1": 1e308, "E2": 1e308, "nu1": 0.0, "q1": 1e10}, "K = inf is not allowed"),
    ("ssul-set6", {"V": 1e308, "C": 1e308}, "rest is not finite"),
    ("ssul-set6", {"omga": 1.0}, r"unknown parameter 'omga'; did you mean 'omega'.*nu1"),
    ("ssul-set6", {"self": 1.0}, "unknown parameter 'self'"),
    ("ssul-set6", {"D": 0.1}, "kind 'ssul' has no parameter 'D'"),
    # values are finite numbers in range, also where they equal those of before
    *(("ssul-set6", {"C": value}, "finite number") for value in (np.nan, np.inf, -np.inf, 10**400)),
    *(
        ("ssul-set6", {"m1": value}, "m1 = .* must be a number")
        for value in (True, "3", None, [1.0], 1j)
    ),
    *(
        ("ssul-set6", {name: value}, f"^{name} = {value!r} is not allowed")
        for names, value in (
            ("m1 m2 omega E1 E2 q1 K", 0.0), ("k1 c1 k2 c2 P nu1 A B", -1e-9), ("nu2", 0.51),
        )
        for name in names.split()
    ),
    # a law has constants of its own
    ("ssul-set6", {"law": "restitution"}, "under law 'restitution' are missing: e"),
    ("ssul-set6", {"law": "restitution", "e": 1.2}, "e = 1.2 is not allowed: e .* from 0 to 1"),
    ("ssul-set6", {"law": "restitution", "e": -0.1}, "e = -0.1 is not allowed"),
    ("ssul-set6", {"law": "restitution", "e": 0.5, "K": 1e7}, "has no parameter 'K'"),
    ("ssul-set6", {"law": "elastic"}, "unknown law 'elastic'; allowed: hertz, power, linear"),
    ("ssul-set6", {"kc": 1e6}, "law = 'linear' or 'kelvin-voigt' has it"),
    ("ssul-set6", {"e_2": 0.5}, "kind 'ssul' has no parameter 'e_2'"),
    ("ssbl", {"e_2": 0.5}, "without law_2, kind 'ssbl' has no .*law_2 = 'restitution' has it"),
    ("tmd", {"e": 0.5}, "kind 'tmd' has no parameter 'e'"),
    ("tmd", {"law": "restitution", "e": 0.5}, "kind 'tmd' has no contact"),
    ("impact-oscillator", {"m2": 1.0}, "kind 'oscillator' .* has no parameter 'm2'"),
    ("impact-oscillator", {"law": "hertz"},
     "'oscillator' are missing: E1, E2, nu1, nu2, A, B, q1; K may replace E1 to q1"),
]  # fmt: skip
GRIDS = [
    ({"m1": [1.0, -2.0]}, r"m1 = -2\.0 is not allowed"),
    ({"omega": [1.0, np.nan]}, "omega = nan is not allowed"),
    ({"m1": [1.0, np.inf]}, "m1 = inf is not allowed"),
    ({"A": [0.0, 1.0], "B": [0.0, 1.0]}, r"A \+ B"),
    ({"D": [1.0]}, "kind 'ssul' has no parameter 'D'"),
    ({"x": [1.0]}, "unknown parameter 'x'"),
    ({"K": [1.0], "E1": [1.0]}, "K beside E1"),
]


@pytest.mark.parametrize(("name", "changes", "message"), CHANGES)
def test_changes_that_mean_nothing_are_refused(name, changes, message):
    with pytest.raises(RequestError, match=message):
        load_system(name).with_(**changes)


def test_grids_and_what_is_missing_or_unknown_are_refused(set6, error_of):
    for grid, message in GRIDS:
        with pytest.raises(RequestError, match=message):
            set6.cells({name: np.array(values) for name, values in grid.items()})
    # True equals the value of before
    assert "must be a" in error_of(load_system("ssul-set6", k2=1.0).with_, k2=True)
    assert "missing: c1, P" in error_of(System, "none", {"m1": 1, "k1": 1, "omega": 1})
    line = error_of(load_system("ssul-set6", K=1.0).with_, E2=1e9)
    assert "give also E1, nu1, nu2, A, B, q1, or K" in line
    assert "unknown kind 'ssull'; did you mean 'ssul'" in error_of(System, "ssull", {})
    for table, words in (
        ({"kind": "none", "sources": "abc"}, "[system]: sources = 'abc' must be a table"),
        ({"kind": "tmd", "law": ""}, "unknown law ''"),
        ({"kind": "ssbl", "law_2": []}, "unknown law_2 []"),
    ):
        assert words in error_of(any_system_from, table)


def test_a_law_replaces_the_constants_of_another(error_of):
    rigid = load_system("ssul-set6", law="restitution", e=0.7)
    assert not rigid.parameters.keys() & {*CONTACT, "K"}
    assert rigid.sources["e"] == "set by the user"
    assert rigid.sources["C"] == load_system("ssul-set6").sources["C"]
    elastic = rigid.with_(law="hertz", K=2e7)
    assert (elastic.K, elastic.law) == (2e7, "hertz")
    assert "e" not in elastic.parameters
    assert "law 'restitution' has no stiffness K" in error_of(getattr, rigid, "K")


def test_a_system_of_a_law_is_what_its_table_says(error_of):
    for system in (load_system("ssul-set6"), load_system("ssul-set6", law="restitution", e=0.7)):
        again = any_system_from(system.to_table())
        assert again == system
        assert ("law" in system.to_table()) == (system.law != "hertz")
    contact = {"law": "restitution", "e": 0.7}
    plain = {"kind": "oscillator", "m": 1, "k": 1, "c": 0.1, "C": 1, "P": 1, "omega": 1}
    assert any_system_from({**plain, "contact": contact}) == any_system_from({**plain, **contact})
    for twice, message in (
        ({"e": 0.5}, "e stands in [system.contact], and before it"),
        ({"law": "hertz"}, "law stands in [system], and law in [system.contact]"),
    ):
        assert message in error_of(any_system_from, {**plain, "contact": contact, **twice})


SIX = load_system("ssul-set6").parameters


def six(**changes):
    return load_system("ssul-set6", **changes).parameters


def test_each_ratio_stands_for_its_parameter():
    assert six(zeta1=0.02)["c1"] == 0.02 * (2 * sqrt(SIX["k1"] * SIX["m1"]))
    assert six(zeta2=0.1)["c2"] == 0.1 * (2 * sqrt(SIX["k2"] * SIX["m2"]))
    assert six(mass_ratio=0.05)["m2"] == 50.0
    assert six(f=1.0)["omega"] == 2 * pi
    assert six(omega_ratio=1.1)["omega"] == 1.1 * sqrt(SIX["k1"] / SIX["m1"])
    assert six(f1=1.2)["k1"] == (1.2 * 1.2) * ((2 * pi) * (2 * pi) * SIX["m1"])
    assert six(T1=0.5)["k1"] == (2 * pi) * (2 * pi) * SIX["m1"] / (0.5 * 0.5)
    assert six(frequency_ratio=0.9)["k2"] == 0.9 * 0.9 * (SIX["k1"] / SIX["m1"] * SIX["m2"])
    slow = load_system("impact-oscillator", T1=2.0).parameters
    assert sqrt(slow["k"] / slow["m"]) == pytest.approx(pi, rel=1e-15)
    oscillator = load_system("impact-oscillator", zeta=0.05, omega_ratio=2.0).parameters
    assert oscillator["c"] == 0.05 * (2 * sqrt(oscillator["k"] * oscillator["m"]))
    assert oscillator["omega"] == 2.0 * sqrt(oscillator["k"] / oscillator["m"])


def test_a_system_tells_its_ratios_and_they_give_it_back():
    system = load_system("ssul-set6", c2=90.0)
    ratios = system.ratios
    linear = {"mass_ratio", "zeta1", "zeta2", "f", "omega_ratio"}
    assert set(ratios) == linear | {"f1", "T1", "frequency_ratio"}
    for name in ("f1", "T1", "frequency_ratio", "omega_ratio"):
        parameters = load_system("ssul-set6", c2=90.0, **{name: ratios.pop(name)}).parameters
        assert parameters == pytest.approx(dict(system.parameters), rel=1e-15 * 4)
    again = load_system("ssul-set6", **ratios).parameters
    for name, value in system.parameters.items():
        assert again[name] == pytest.approx(value, rel=1e-15)
    assert set(load_system("bouncing-ball").ratios) == {"f"}


def test_a_ratio_stands_in_a_system_of_a_file(tmp_path, error_of):
    (tmp_path / "own.toml").write_text(
        '[system]\nkind = "tmd"\nm1 = 1500.0\nk1 = 6e4\nzeta1 = 0.015\nmass_ratio = 0.02\n'
        "k2 = 1200.0\nzeta2 = 0.1\nP = 800.0\nf = 1.0\n"
    )
    parameters = load_system(tmp_path / "own.toml").parameters
    assert parameters["m2"] == 30.0
    assert parameters["omega"] == 2 * pi
    assert parameters["c1"] == pytest.approx(0.015 * 2 * sqrt(6e4 * 1500.0), rel=1e-15)
    assert parameters["c2"] == pytest.approx(0.1 * 2 * sqrt(1200.0 * 30.0), rel=1e-15)
    (tmp_path / "own.toml").write_text('[system]\nkind = "none"\nm1 = 1.0\nzeta1 = 0.1\n')
    assert "zeta1 needs k1, which is missing" in error_of(load_system, tmp_path / "own.toml")


def test_a_frequency_that_was_set_stays_when_the_masses_change():
    system = load_system("ssul-set6", f1=1.0, frequency_ratio=0.9).with_(m1=2000.0, m2=90.0)
    assert system.ratios["f1"] == 1.0
    assert system.parameters["k1"] == (2 * pi) * (2 * pi) * 2000.0
    assert system.parameters["k2"] == 0.9 * 0.9 * (system.parameters["k1"] / 2000.0 * 90.0)
    assert load_scan(system).document()["system"]["parameters"]["f1"] == 1.0
    cells = system.cells({"m1": np.array([500.0, 1000.0])})
    assert np.sqrt(cells["k2"] / 90.0) == pytest.approx([0.9 * 2 * pi] * 2, rel=1e-15)


@pytest.mark.parametrize("name", ["f1", "T1", "frequency_ratio"])
def test_an_axis_along_a_frequency_keeps_its_name_and_its_values(name):
    values = [0.8, 0.9, 1.1]
    scan = load_scan("ssul-set6", {"vary": {name: values}})
    assert (scan.axes[0].name, scan.axes[0].values.tolist()) == (name, values)
    cells = scan.system.cells({name: scan.axes[0].values})
    each = [load_system("ssul-set6", **{name: value}).cells() for value in values]
    assert cells.tobytes() == np.array(each).tobytes()
    assert load_scan(scan.document()) == scan


def test_frequencies_are_free_and_uncertain_in_a_tuning():
    free = {"frequency_ratio": {}, "zeta2": {}}
    tuning = load_tuning("tmd", {"free": free, "uncertain": {"f1": "5%"}})
    assert tuning.names == ("frequency_ratio", "zeta2")
    grid = Objective(tuning)._grid(at_rest(np.array([[0.95, 0.1]])))
    cells = tuning.system.cells(grid)[0, :, 0]
    structure = np.sqrt(cells["k1"] / cells["m1"])
    assert np.ptp(structure) > 0.1
    assert np.sqrt(cells["k2"] / cells["m2"]) / structure == pytest.approx(0.95, rel=1e-14)


@pytest.mark.parametrize(("name", "ends"), [("f1", (0.9, 1.2)), ("T1", (0.8, 1.1))])
def test_branches_go_along_a_frequency_as_along_its_stiffness(name, ends):
    request = load_continuation({"along": {name: dict(zip(("start", "stop"), ends, strict=True))}})
    stiffness = sorted(six(**{name: end})["k1"] for end in ends)
    assert (request.along.name, request.along.low) == ("k1", pytest.approx(stiffness[0]))
    assert request.along.high == pytest.approx(stiffness[1])


def test_an_axis_along_a_ratio_is_one_along_its_parameter():
    hertz = load_scan("ssul-set6", {"vary": {"f": {"start": 0.8, "stop": 1.2, "num": 3}}})
    rad = load_scan("ssul-set6", {"vary": {"omega": 2 * pi * np.array([0.8, 1.0, 1.2])}})
    assert hertz.axes[0].name == "omega"
    assert hertz.axes[0].values == pytest.approx(rad.axes[0].values, rel=1e-15)
    assert hertz.document()["vary"] == {"f": {"values": [0.8, 1.0, 1.2]}}
    assert load_scan(hertz.document()).axes[0].values.tolist() == hertz.axes[0].values.tolist()
    damped = load_scan("ssul-set6", {"vary": {"zeta1": [0.01, 0.02]}, "set": {"f": 1.0}})
    assert "ω = 6.28319 rad/s: c₁" in damped.title
    assert load_scan(hertz.document()).hash == hertz.hash
    # what the command line varies need not be removed from a file
    file = {"system": "ssul-set6", "set": {"f": 1.0}, "vary": {"k2": {"values": [500.0]}}}
    assert load_scan(file, {"vary": {"omega": {"values": [6.0]}}}).axes[0].name == "omega"


K1 = np.array([4e3, 4e4, 4e5])


def critical(k, m):
    return 2 * np.sqrt(k * m)


def test_a_ratio_stays_when_its_unit_changes_later():
    system = load_system("tmd", zeta1=0.03, mass_ratio=0.02, zeta2=0.15, omega_ratio=0.9)
    p = system.with_(k1=5e4, k2=900.0).with_(m1=1200.0).parameters
    assert p["m2"] == pytest.approx(24.0, rel=1e-15)
    assert p["c1"] == pytest.approx(0.03 * critical(5e4, 1200.0), rel=1e-15)
    assert p["c2"] == pytest.approx(0.15 * critical(900.0, 24.0), rel=1e-15)
    assert p["omega"] == pytest.approx(0.9 * sqrt(5e4 / 1200.0), rel=1e-15)
    assert system.with_(c2=50.0).with_(k2=900.0).parameters["c2"] == 50.0
    assert system.with_(omega=6.0).with_(k1=5e4).parameters["omega"] == 6.0
    assert load_system("tmd").with_(k1=5e4).parameters["c1"] == 452.0


def test_ratios_stay_in_scans_their_files_the_structure_alone_and_maps():
    tables = {"set": {"zeta1": 0.05}, "vary": {"k1": {"values": K1.tolist()}}}
    scan = load_scan("tmd", tables)
    energy = {"record": {"want": ["energy"]}, "curves": [{}]}
    beside = with_structure_alone(load_curves({"system": "tmd", **tables, **energy}))
    alone, damped = (case.scan for case in beside.cases)
    again = load_scan(scan.document())
    for one in (scan, again, alone, damped):
        np.testing.assert_allclose(one.cells()["c1"], 0.05 * critical(K1, 1000.0), rtol=1e-15)
    for one in (scan, again):
        assert "c1" not in one.about
        assert one.about["zeta1"] == 0.05
        assert "ζ₁ = 0.05" in one.title
    # a map over a ratio and what it follows from
    axes = {"omega_ratio": {"values": [0.9, 1.1]}, "k1": {"values": K1.tolist()}}
    scan = load_scan("tmd", {"vary": axes})
    assert [axis.name for axis in scan.axes] == ["omega_ratio", "k1"]
    expected = np.multiply.outer([0.9, 1.1], np.sqrt(K1 / 1000.0))
    np.testing.assert_allclose(scan.cells()["omega"], expected, rtol=1e-15)


def test_loads_keep_ratios_and_vary_them():
    table = {"set": {"zeta1": 0.05}, "vary": {"k1": {"values": K1.tolist()}}}
    hammered = {"load": {"impulse": 1.0}}
    request = load_response_history(["none", "tmd"], {**table, **hammered})
    for number in range(request.cases):
        system, _ = request.case(number)
        assert system.ratios["zeta1"] == 0.05
        p = system.parameters
        assert p["c1"] == pytest.approx(0.05 * critical(p["k1"], p["m1"]), rel=1e-15)
    varied = load_response_history(["none", "tmd"], {"vary": {"zeta2": [0.1, 0.2]}, **hammered})
    c2 = [varied.case(i)[0].parameters.get("c2") for i in range(varied.cases)]
    p = load_system("tmd").parameters
    unit = critical(p["k2"], p["m2"])
    assert c2 == [None, None, pytest.approx(0.1 * unit), pytest.approx(0.2 * unit)]


def test_a_branch_along_a_stiffness_keeps_the_damping_ratio():
    tables = {"set": {"zeta1": 0.05}, "along": {"k1": {"start": 3e4, "stop": 5e4}}}
    request = load_continuation("ssul-set6", tables)
    along = SectionMap(request.system, (request.along.name,))
    cells = along.cells(np.array([[3e4], [5e4]]))
    np.testing.assert_allclose(cells["c1"], 0.05 * critical(cells["k1"], 1000.0), rtol=1e-15)
    slope = along._changes(np.array([4e4]))["c1"][0]
    assert slope == pytest.approx(0.05 * critical(4e4, 1000.0) / (2 * 4e4), rel=1e-8)


def test_a_tuning_leaves_alone_what_is_set_as_a_ratio():
    assert load_tuning("tmd", {"set": {"zeta2": 0.15}}).names == ("k2",)
    assert load_tuning({"system": "tmd", "set": {"c2": 90.0}}).names == ("k2",)
    assert load_tuning("tmd", {"free": {"zeta2": {}}}).names == ("k2", "zeta2")
    assert load_tuning("tmd", {"over": {"zeta2": [0.1, 0.2]}}).names == ("k2",)


def test_ratios_are_free_and_uncertain_and_those_that_are_set_stay():
    tuning = load_tuning("tmd", {
        "set": {"omega_ratio": 0.95},
        "free": {"k2": {}, "zeta2": {"low": 0.05, "high": 0.3}, "mass_ratio": {}},
        "uncertain": {"zeta1": "10%", "k1": "5%"}, "search": {"draws": 4},
    })  # fmt: skip
    assert tuning.names == ("k2", "mass_ratio", "zeta2")
    assert tuning.free[2].low == 0.05
    grid = Objective(tuning)._grid(at_rest(np.array([[2000.0, 0.03, 0.2]])))
    cells = tuning.system.cells(grid)[0, :, 0]
    np.testing.assert_allclose(cells["m2"], 30.0, rtol=1e-15)
    np.testing.assert_allclose(cells["c2"], 0.2 * critical(2000.0, 30.0), rtol=1e-15)
    np.testing.assert_allclose(cells["omega"], 0.95 * np.sqrt(cells["k1"] / 1000.0), rtol=1e-15)
    zeta1 = cells["c1"] / critical(cells["k1"], 1000.0)
    assert zeta1[0] == pytest.approx(load_system("tmd").ratios["zeta1"], rel=1e-14)
    assert np.ptp(cells["k1"]) > 1e3
    assert np.ptp(zeta1 / zeta1[0]) > 0.02
    assert load_tuning(tuning.document()) == tuning


def test_ranges_at_equal_ratios_in_options_and_files_and_values_that_are_sorted(error_of):
    # equal ratios are rounded from exact powers
    values = Axis.spaced("K", 1e5, 1e9, 41, "log").values
    assert values[[0, 10, 20, 30, 40]].tolist() == [1e5, 1e6, 1e7, 1e8, 1e9]
    np.testing.assert_allclose(values[1:] / values[:-1], 10**0.1, rtol=1e-15 * 4)
    assert Axis.spaced("K", 2.0, 8.0, 1, "log").values.tolist() == [2.0]
    # the option and the file mean the same
    entry = spaced("--vary K", "1e5:1e9:5:log")
    scan = load_scan(None, {"vary": {"K": entry}})
    assert scan.axes[0].values.tolist() == [1e5, 1e6, 1e7, 1e8, 1e9]
    assert load_scan(scan.document()) == scan
    assert "must be START:STOP:NUM" in error_of(spaced, "--band", "1:2:log")
    # ranges and lists are told apart by their values
    assert logarithmic(Axis.spaced("K", 1e5, 1e9, 9, "log").values)
    assert not logarithmic(np.linspace(1.0, 2.0, 9))
    assert is_list(np.array([600.0, 800.0]))
    assert is_list(np.array([1.0, 2.0, 3.0, 5.0, 9.0, 10.0]))
    assert not is_list(np.arange(1.0, 6.0))
    edges = inner_edges(np.array([1.0, 2.0, 4.0, 8.0]))
    assert edges == pytest.approx([1.0, 2**0.5, 2 * 2**0.5, 4 * 2**0.5, 8.0])
    # values that are sorted are told
    with pytest.warns(Reordered, match="omega: its values are sorted, 5 to 7"):
        axis = Axis("omega", np.array([6.0, 5.0, 7.0]))
    assert axis.values.tolist() == [5.0, 6.0, 7.0]
    with pytest.warns(Reordered):
        load_scan("tmd", {"vary": {"omega": {"values": [7.0, 6.0]}}})


READERS = {
    "system": lambda changes: six(**changes),
    "scan": lambda tables: load_scan("ssul-set6", tables),
    "history": lambda tables: load_response_history("tmd", {"load": {"impulse": 1.0}, **tables}),
    "tuning": lambda tables: load_tuning("tmd", tables),
    "axis": lambda entry: Axis.of("K", entry),
}
REFUSED = [
    # what is no ratio, two statements about one parameter
    ("system", {"zeta1": 0.1, "c1": 3.0}, "c1 beside zeta1"),
    ("system", {"f": 1.0, "omega_ratio": 1.0}, "f beside omega_ratio"),
    ("system", {"zeta1": -1.0}, "zeta1 = -1.0 is not allowed"),
    ("system", {"zeta1": "a"}, "zeta1 = 'a' must be a number"),
    ("system", {"f": 0.0}, "f = 0.0 is not allowed"),
    ("system", {"mass_ratio": float("nan")}, "mass_ratio"),
    ("system", {"omega_ratio": 1.0, "k1": 0.0}, "means nothing with k1 = 0.0"),
    ("system", {"f1": 1.0, "T1": 1.0}, "f1 beside T1"),
    ("system", {"f1": 1.0, "k1": 1.0}, "k1 beside f1"),
    ("system", {"T1": 1e-300}, "k1 = inf is not allowed"),
    ("system", {"frequency_ratio": 1.0, "k2": 1.0}, "k2 beside frequency_ratio"),
    ("system", {"zetta1": 0.1}, "unknown parameter 'zetta1'; did you mean 'zeta1'"),
    ("scan", {"vary": {"zeta1": [0.1]}, "set": {"c1": 3.0}}, "c1 is varied"),
    ("scan", {"vary": {"c1": [0.1]}, "set": {"zeta1": 3.0}}, "c1 is varied"),
    ("scan", {"vary": {"f": [0.0]}}, "f = 0.0 is not allowed"),
    ("scan", {"vary": {"f": [1.0], "omega": [6.0]}}, "omega"),
    ("scan", {"vary": {"zeta2": [0.1], "k2": [0.0, 1.0]}}, "means nothing with k2"),
    ("history", {"set": {"zeta1": 0.1}, "vary": {"c1": [1.0]}}, "zeta1 = .*: c1 is varied by"),
    ("history", {"set": {"k1": 1e4}, "vary": {"k1": [1.0]}}, "k1 = .*: k1 is varied by"),
    ("history", {"vary": {"c1": [1.0], "zeta1": [0.1]}}, "c1 beside zeta1"),
    ("history", {"vary": {"zeta": [0.1]}}, "unknown parameter 'zeta'"),
    ("tuning", {"set": {"mass_ratio": 0.03}, "free": {"m2": {}}},
     "mass_ratio = 0.03: m2 is varied by"),
    ("tuning", {"free": {"c2": {}, "zeta2": {}}}, "c2 beside zeta2"),
    ("tuning", {"free": {"c2": {}}, "over": {"zeta2": [0.1]}}, "c2 beside zeta2"),
    ("tuning", {"set": {"zeta1": 0.01}, "uncertain": {"c1": "5%"}}, "c1 beside zeta1"),
    ("tuning", {"free": {"c2": {}}, "uncertain": {"zeta2": "5%"}},
     "zeta2 is uncertain and c2 free"),
    ("tuning", {"free": {"zeta1": {"low": 0.01, "high": 0.02}}}, "unknown free parameter 'zeta1'"),
    ("tuning", {"uncertain": {"zeta": "5%"}}, "unknown uncertain parameter 'zeta'"),
    # what no scale can be
    ("axis", {"start": 0.0, "stop": 4.0, "num": 3, "scale": "log"},
     "start = 0.0 must be > 0 where"),
    ("axis", {"start": 1.0, "stop": 4.0, "num": 3, "scale": "cubic"}, "unknown scale 'cubic'"),
    ("axis", {"values": [1.0], "scale": "log"}, "allowed: start, stop and num"),
    # what is no sequence of numbers
    *(("scan", {"vary": {"omega": values}}, "omega")
      for values in ("567", b"567", np.zeros((2, 2)), 6.0, np.float64(6.0), None)),
]  # fmt: skip


@pytest.mark.parametrize(("read", "tables", "message"), REFUSED)
def test_what_means_nothing_or_is_said_twice_is_refused(read, tables, message):
    with pytest.raises(RequestError, match=message):
        READERS[read](tables)


class Column:
    """Stands for a column of a table, such as that of pandas: no sequence, but an array."""

    ndim, size = 1, 3

    def __array__(self, dtype=None, copy=None):
        return np.array([5.0, 6.0, 7.0])


@pytest.mark.parametrize(
    "values",
    [
        [5.0, 6, 7.0], (5.0, 6.0, 7.0), range(5, 8), np.linspace(5, 7, 3), np.arange(5, 8),
        np.array([5, 6, 7], dtype=np.float32), Column(),
    ],
)  # fmt: skip
def test_any_sequence_of_numbers_is_an_axis(values):
    scan = load_scan("tmd", {"vary": {"omega": values}})
    assert scan == load_scan("tmd", {"vary": {"omega": {"values": [5.0, 6.0, 7.0]}}})
