"""Systems: the catalog, the checks at the door, K, and the numbers for kernels."""

import copy
import pickle
from math import pi

import numpy as np
import pytest

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.errors import RequestError
from nlds_vines.model import catalog as packaged_files
from nlds_vines.model.catalog import catalog, load_system, system_from
from nlds_vines.model.parameters import CONTACT, PARAMETERS, Parameter
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import CELL, System

stiffness_of_set6 = 32504566.49525256
stiffness_of_steel = 159844234214.64865

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
        assert words in error_of(system_from, table)


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
        again = system_from(system.to_table())
        assert again == system
        assert ("law" in system.to_table()) == (system.law != "hertz")
    contact = {"law": "restitution", "e": 0.7}
    plain = {"kind": "oscillator", "m": 1, "k": 1, "c": 0.1, "C": 1, "P": 1, "omega": 1}
    assert system_from({**plain, "contact": contact}) == system_from({**plain, **contact})
    for twice, message in (
        ({"e": 0.5}, "e stands in [system.contact], and before it"),
        ({"law": "hertz"}, "law stands in [system], and law in [system.contact]"),
    ):
        assert message in error_of(system_from, {**plain, "contact": contact, **twice})
