"""Axes and ratios in place of parameters: what they mean, where they are taken, refusals."""

from math import pi, sqrt

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.response_curves import load_curves, with_structure_alone
from nlds_vines.cli.options import spaced
from nlds_vines.continuation.request import load_continuation
from nlds_vines.continuation.section_map import SectionMap
from nlds_vines.errors import Reordered, RequestError
from nlds_vines.loads.request import load_response_history
from nlds_vines.model.axis import Axis
from nlds_vines.plotting.bands import inner_edges, is_list, logarithmic
from nlds_vines.tuning.request import load_tuning
from nlds_vines.tuning.run import Objective, at_rest

SIX = nv.load_system("ssul-set6").parameters


def six(**changes):
    return nv.load_system("ssul-set6", **changes).parameters


def test_each_ratio_stands_for_its_parameter():
    assert six(zeta1=0.02)["c1"] == 0.02 * (2 * sqrt(SIX["k1"] * SIX["m1"]))
    assert six(zeta2=0.1)["c2"] == 0.1 * (2 * sqrt(SIX["k2"] * SIX["m2"]))
    assert six(mass_ratio=0.05)["m2"] == 50.0
    assert six(f=1.0)["omega"] == 2 * pi
    assert six(omega_ratio=1.1)["omega"] == 1.1 * sqrt(SIX["k1"] / SIX["m1"])
    assert six(f1=1.2)["k1"] == (1.2 * 1.2) * ((2 * pi) * (2 * pi) * SIX["m1"])
    assert six(T1=0.5)["k1"] == (2 * pi) * (2 * pi) * SIX["m1"] / (0.5 * 0.5)
    assert six(frequency_ratio=0.9)["k2"] == 0.9 * 0.9 * (SIX["k1"] / SIX["m1"] * SIX["m2"])
    slow = nv.load_system("impact-oscillator", T1=2.0).parameters
    assert sqrt(slow["k"] / slow["m"]) == pytest.approx(pi, rel=1e-15)
    oscillator = nv.load_system("impact-oscillator", zeta=0.05, omega_ratio=2.0).parameters
    assert oscillator["c"] == 0.05 * (2 * sqrt(oscillator["k"] * oscillator["m"]))
    assert oscillator["omega"] == 2.0 * sqrt(oscillator["k"] / oscillator["m"])


def test_a_system_tells_its_ratios_and_they_give_it_back():
    system = nv.load_system("ssul-set6", c2=90.0)
    ratios = system.ratios
    linear = {"mass_ratio", "zeta1", "zeta2", "f", "omega_ratio"}
    assert set(ratios) == linear | {"f1", "T1", "frequency_ratio"}
    for name in ("f1", "T1", "frequency_ratio", "omega_ratio"):
        parameters = nv.load_system("ssul-set6", c2=90.0, **{name: ratios.pop(name)}).parameters
        assert parameters == pytest.approx(dict(system.parameters), rel=1e-15 * 4)
    again = nv.load_system("ssul-set6", **ratios).parameters
    for name, value in system.parameters.items():
        assert again[name] == pytest.approx(value, rel=1e-15)
    assert set(nv.load_system("bouncing-ball").ratios) == {"f"}


def test_a_ratio_stands_in_a_system_of_a_file(tmp_path, error_of):
    (tmp_path / "own.toml").write_text(
        '[system]\nkind = "tmd"\nm1 = 1500.0\nk1 = 6e4\nzeta1 = 0.015\nmass_ratio = 0.02\n'
        "k2 = 1200.0\nzeta2 = 0.1\nP = 800.0\nf = 1.0\n"
    )
    parameters = nv.load_system(tmp_path / "own.toml").parameters
    assert parameters["m2"] == 30.0
    assert parameters["omega"] == 2 * pi
    assert parameters["c1"] == pytest.approx(0.015 * 2 * sqrt(6e4 * 1500.0), rel=1e-15)
    assert parameters["c2"] == pytest.approx(0.1 * 2 * sqrt(1200.0 * 30.0), rel=1e-15)
    (tmp_path / "own.toml").write_text('[system]\nkind = "none"\nm1 = 1.0\nzeta1 = 0.1\n')
    assert "zeta1 needs k1, which is missing" in error_of(nv.load_system, tmp_path / "own.toml")


def test_a_frequency_that_was_set_stays_when_the_masses_change():
    system = nv.load_system("ssul-set6", f1=1.0, frequency_ratio=0.9).with_(m1=2000.0, m2=90.0)
    assert system.ratios["f1"] == 1.0
    assert system.parameters["k1"] == (2 * pi) * (2 * pi) * 2000.0
    assert system.parameters["k2"] == 0.9 * 0.9 * (system.parameters["k1"] / 2000.0 * 90.0)
    assert load_scan(system).document()["system"]["parameters"]["f1"] == 1.0
    cells = system.cells({"m1": np.array([500.0, 1000.0])})
    assert np.sqrt(cells["k2"] / 90.0) == pytest.approx([0.9 * 2 * pi] * 2, rel=1e-15)


@pytest.mark.parametrize("name", ["f1", "T1", "frequency_ratio"])
def test_an_axis_along_a_frequency_keeps_its_name_and_its_values(name):
    values = [0.8, 0.9, 1.1]
    scan = scan_over({name: {"values": values}})
    assert (scan.axes[0].name, scan.axes[0].values.tolist()) == (name, values)
    cells = scan.system.cells({name: scan.axes[0].values})
    each = [nv.load_system("ssul-set6", **{name: value}).cells() for value in values]
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


def scan_over(vary, **changes):
    return load_scan("ssul-set6", {"vary": vary, **changes})


def test_an_axis_along_a_ratio_is_one_along_its_parameter():
    hertz = scan_over({"f": {"start": 0.8, "stop": 1.2, "num": 3}})
    rad = scan_over({"omega": {"values": list(2 * pi * np.array([0.8, 1.0, 1.2]))}})
    assert hertz.axes[0].name == "omega"
    assert hertz.axes[0].values == pytest.approx(rad.axes[0].values, rel=1e-15)
    assert hertz.document()["vary"] == {"f": {"values": [0.8, 1.0, 1.2]}}
    assert load_scan(hertz.document()).axes[0].values.tolist() == hertz.axes[0].values.tolist()
    damped = scan_over({"zeta1": {"values": [0.01, 0.02]}}, set={"f": 1.0})
    assert "ω = 6.28319 rad/s: c₁" in damped.title
    assert load_scan(hertz.document()).hash == hertz.hash
    # what the command line varies need not be removed from a file
    file = {"system": "ssul-set6", "set": {"f": 1.0}, "vary": {"k2": {"values": [500.0]}}}
    assert load_scan(file, {"vary": {"omega": {"values": [6.0]}}}).axes[0].name == "omega"


K1 = np.array([4e3, 4e4, 4e5])


def critical(k, m):
    return 2 * np.sqrt(k * m)


def test_a_ratio_stays_when_its_unit_changes_later():
    system = nv.load_system("tmd", zeta1=0.03, mass_ratio=0.02, zeta2=0.15, omega_ratio=0.9)
    p = system.with_(k1=5e4, k2=900.0).with_(m1=1200.0).parameters
    assert p["m2"] == pytest.approx(24.0, rel=1e-15)
    assert p["c1"] == pytest.approx(0.03 * critical(5e4, 1200.0), rel=1e-15)
    assert p["c2"] == pytest.approx(0.15 * critical(900.0, 24.0), rel=1e-15)
    assert p["omega"] == pytest.approx(0.9 * sqrt(5e4 / 1200.0), rel=1e-15)
    assert system.with_(c2=50.0).with_(k2=900.0).parameters["c2"] == 50.0
    assert system.with_(omega=6.0).with_(k1=5e4).parameters["omega"] == 6.0
    assert nv.load_system("tmd").with_(k1=5e4).parameters["c1"] == 452.0


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
    p = nv.load_system("tmd").parameters
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
    assert zeta1[0] == pytest.approx(nv.load_system("tmd").ratios["zeta1"], rel=1e-14)
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
