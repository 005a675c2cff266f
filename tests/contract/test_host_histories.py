"""Loads on hosts, from requests to archives."""

import math
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

import nlds_vines as nv

pytestmark = pytest.mark.kernels

FRAME = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
STEP = 0.02


def cell(name="cell", gap=0.01, **options):
    walls = [nv.Wall(gap, side, law="restitution", e=0.6) for side in "+-"]
    return nv.Damper(name, "roof", **{"m": 900.0, "k": 5e3, "c": 100.0, "walls": walls, **options})


@pytest.fixture
def quake(here):
    """An accelerogram as an engineer has it: a table of times and accelerations in g."""
    rng, times = np.random.default_rng(1), STEP * np.arange(200)
    tones = np.cos(np.outer(times, rng.uniform(4, 40, 40)) + rng.uniform(0, 6, 40)).sum(axis=1)
    values = 0.03 * tones * np.sin(np.pi * times / times[-1])
    rows = "\n".join(f"{t:.2f},{a:.5f}" for t, a in zip(times, values, strict=True))
    Path("quake.csv").write_text(f"time [s],acceleration [g]\n{rows}\n")
    return np.array([float(f"{value:.5f}") for value in values]) * 9.80665


def test_a_frame_alone_moves_under_an_earthquake_as_by_exponentials(quake):
    system = nv.System.from_host(FRAME)
    histories = nv.response_history(
        system, load="quake.csv", duration=6.0, of=["roof", "roof-floor1"], quiet=True
    )
    history, M = histories["host"], FRAME.M
    A = np.block([[np.zeros((3, 3)), np.eye(3)],
                  [-np.linalg.solve(M, FRAME.K), -np.linalg.solve(M, FRAME.C)]])  # fmt: skip
    full = np.zeros((8, 8))
    full[:6, :6], full[3:6, 6], full[6, 7] = A, -1.0, 1.0
    fine = scipy.linalg.expm(full * STEP / 42)
    ground = np.append(quake, np.zeros(301 - 200))
    y, x, a, E1 = np.zeros(8), [], [], []
    for i in range(300):
        slope = (ground[i + 1] - ground[i]) / STEP if i < 199 else 0.0
        y[6:] = ground[i] if i < 199 else 0.0, slope
        for _ in range(42):
            x.append(y[:3])
            a.append((A @ y[:6])[3:])
            E1.append(0.5 * (y[3:6] @ M @ y[3:6] + y[:3] @ FRAME.K @ y[:3]))
            y = fine @ y
    x, a, E1 = np.array(x), np.array(a), np.array(E1)
    places = np.rint(history.time[:-1] / STEP * 42).astype(int)
    assert places == pytest.approx(history.time[:-1] / STEP * 42, abs=1e-6)
    assert history.x["roof"][:-1] == pytest.approx(x[places, 2], abs=1e-11)
    assert history.x["roof-floor1"][:-1] == pytest.approx(x[places, 2] - x[places, 0], abs=1e-11)
    assert history.a["roof"][:-1] == pytest.approx(a[places, 2], abs=1e-8)
    assert history.E1[:-1] == pytest.approx(E1[places], abs=1e-6)
    numbers = history.numbers
    assert numbers["roof.x_max"] == pytest.approx(np.abs(x[:, 2]).max(), rel=1e-5)
    assert numbers["roof.a_max"] == pytest.approx(np.abs(a[:, 2]).max(), rel=1e-4)
    assert numbers["E1max"] == pytest.approx(E1.max(), rel=1e-4)
    above = np.flatnonzero(0.5 * E1.max() < E1)[-1] * STEP / 42
    assert numbers["last_50"] == pytest.approx(above, abs=STEP / 10)
    rms = np.sqrt(np.mean(x[:, 2] ** 2))
    assert numbers["roof.x_rms"] == pytest.approx(rms, rel=1e-4)


def test_dampers_without_walls_have_no_number_of_impacts(quake):
    system = nv.System.from_host(FRAME, [cell(), cell("tuned", walls=())], name="both")
    histories = nv.response_history(system, load="quake.csv", duration=6.0, quiet=True)
    numbers = histories["both"].numbers
    assert numbers["cell.impact_count"] > 0
    assert numbers["tuned.impact_count"] == -1
    assert f"impacts: {numbers['cell.impact_count']} of cell" in "\n".join(histories.lines())
    assert "of tuned" not in "\n".join(histories.lines())


def test_histories_of_two_cells_have_the_host_alone_beside_them_and_an_archive(quake):
    light = cell("light", 0.02, m=300.0)
    system = nv.System.from_host(FRAME, [cell(), light], name="two cells")
    histories = nv.response_history(
        system, load={"record": "quake.csv", "scale": 2.0}, duration=6.0, to="q.h5", quiet=True
    )
    alone, both = histories["none"], histories["two cells"]
    assert both.numbers["cell.impact_count"] > 20 < both.numbers["light.impact_count"]
    touched = both.impacts["damper"]
    for name in ("cell", "light"):
        assert both.numbers[f"{name}.impact_count"] == np.sum(touched == name)
        gap = 0.01 if name == "cell" else 0.02
        stroke = both.stroke[name]
        assert both.numbers[f"{name}.stroke_max"] == pytest.approx(gap, rel=1e-12)
        assert np.abs(stroke).max() <= gap * (1 + 1e-12)
        signs = np.interp(both.impacts["touch"][touched == name], both.time, stroke) > 0
        assert np.array_equal(np.where(signs, "+", "-"), both.impacts["wall"][touched == name])
    assert np.isnan(alone.numbers["cell.E2max"])
    assert alone.numbers["last_50"] > 0
    assert len(alone.impacts["touch"]) == 0
    peak = next(p for p in histories.comparison() if p.system == "two cells")
    assert peak.quantity == "roof.x_max"
    assert peak.reduction == pytest.approx(
        1 - both.numbers["roof.x_max"] / alone.numbers["roof.x_max"]
    )
    blows = [p for p in histories.comparison() if p.quantity == "cell.impulse_max"]
    assert [p.system for p in blows] == ["two cells"]
    assert both.numbers["roof.a_max"] == math.inf  # where rigid walls act
    tops = {p.system: p for p in histories.comparison() if p.quantity == "roof.a_max"}
    assert tops["none"].value < tops["two cells"].value
    assert math.isnan(tops["two cells"].reduction)
    again = nv.open_archive("q.h5")
    assert np.array_equal(again["two cells"].x["roof"], both.x["roof"])
    assert again.request.hash == histories.request.hash
    report = "\n".join(again.lines())
    assert "two cells: E1 above" in report
    assert "roof.x_max [m]" in report
    again.plot("roof.x,roof.a,light.stroke,energy,peaks")


def test_a_scan_of_loads_on_a_host_has_the_numbers_of_single_histories(quake):
    system, vary = nv.System.from_host(FRAME, [cell()]), {"cell.gap": [0.01, 0.03], "scale": [1, 2]}
    scan = nv.response_history(
        system, load="quake.csv", duration=6.0, quiet=True,
        vary={name: {"values": values} for name, values in vary.items()},
    )  # fmt: skip
    assert scan["roof.x_max"].shape == (1, 2, 2)
    one = nv.response_history(
        system, load={"record": "quake.csv", "scale": 2.0}, set={"cell": {"gap": 0.03}},
        duration=6.0, quiet=True,
    )["host"]  # fmt: skip
    for name, value in one.numbers.items():
        assert scan[name][0, 1, 1] == pytest.approx(value, nan_ok=True), name
    assert scan["cell.impact_count"][0, 0, 1] > scan["cell.impact_count"][0, 1, 0] > 0
    scan.plot()
    samples = {"cell.gap": np.array([0.03, 0.01]), "scale": np.array([2.0, 1.0])}
    sampled = nv.response_history(
        system, load="quake.csv", duration=6.0, samples=samples, quiet=True
    )
    assert sampled["roof.x_max"][0].tolist() == scan["roof.x_max"][0, [1, 0], [1, 0]].tolist()
    assert sampled.to_dataframe()["cell.gap"].tolist() == [0.03, 0.01]


def test_presets_and_general_systems_stand_in_one_archive(quake):
    """Each has the numbers and histories that it has among its own; what it lacks is filled.

    The first system decides how many times there are, on which round-off of hosts depends.
    """
    cells = [cell(), cell("light", 0.02, m=300.0)]
    general = [nv.System.from_host(FRAME, cells, name="two"),
               nv.System.from_host(FRAME, name="bare")]  # fmt: skip
    presets = ["none", "ssul-set6"]
    task = {"load": "quake.csv", "duration": 6.0, "quiet": True}
    histories = nv.response_history([*general, *presets], **task, to="all.h5")
    with nv.read("all.h5") as view:
        assert view["system"].tolist() == ["two", "bare", "none", "ssul-set6"]
        assert view["damper"].tolist() == ["cell", "light", "damper"]
        assert view.dims("E2max") == ("system", "damper")
        assert view.dims("x1_max") == ("system",)
        assert view.dims("x") == ("system", "displacement", "time")
        counts = view["impact_count"]
        assert counts.dtype == np.int32
        assert (counts[[1, 2]] == -1).all()
        assert np.isnan(view["x1_max"][:2]).all()
        assert np.isnan(view["x_max"][2:]).all()
        assert "impulse_max" in view  # of rigid walls: of one system
        assert not np.isfinite(view["impulse_max"][2:]).any()
    of_presets = nv.response_history(presets, **task)
    of_general = nv.response_history(general, **task)
    for name in presets:
        numbers = of_presets[name].numbers
        together = {key: histories[name].numbers[key] for key in numbers}
        assert together == numbers
        assert histories[name].E2.shape == histories[name].time.shape
        assert math.isnan(histories[name].numbers["cell.stroke_max"])
        assert histories[name].numbers["light.impact_count"] == -1
    for name in ("two", "bare"):
        alone = of_general[name]
        together = histories[name]
        assert {key: together.numbers[key] for key in alone.numbers} == alone.numbers
        for key in ("touch", "damper", "wall", "speed"):
            np.testing.assert_array_equal(together.impacts[key], alone.impacts[key])
        np.testing.assert_array_equal(together.x["roof"], alone.x["roof"])
        np.testing.assert_array_equal(together.E1, alone.E1)
        assert np.isnan(together.x1).all()
    table = histories.to_dataframe()
    assert table["system"].tolist() == ["two", "bare", *presets]
    assert table["roof.x_max"][0] == histories["two"].numbers["roof.x_max"]
    assert table["light.impact_count"][0] == histories["two"].numbers["light.impact_count"]
    assert table["damper.E2max"][3] == histories["ssul-set6"].numbers["E2max"]
    assert table.attrs["units"]["roof.x_max"] == "m"
    lines = histories.to_dataframe("x", "x1")
    assert len(lines) == 4 * len(histories["two"].time)
    own = lines[lines.system == "two"]
    np.testing.assert_array_equal(own["roof.x"], histories["two"].x["roof"])
    # each is compared with what stands alone and has the quantity
    reductions = {(p.system, p.quantity): p.reduction for p in histories.comparison()}
    one, other = histories["two"].numbers, histories["bare"].numbers
    drift = 1.0 - one["roof.x_max"] / other["roof.x_max"]
    assert reductions["two", "roof.x_max"] == pytest.approx(drift)
    assert reductions["ssul-set6", "x1_max"] > 0.0
    report = [*nv.open_archive("all.h5").lines()]
    assert any(line.startswith("two: E1 above") and "of light" in line for line in report)
    assert any("x1 relative to the ground up to" in line for line in report)
    head, *rows = histories.rows()
    assert [row[head.index("bare")] for row in rows].count("-") == 11
    shown = histories.plot("motion,roof.x,light.stroke,energy,shares,peaks").axes
    assert [len(axes.get_lines()) for axes in shown[:3]] == [2, 2, 1]
    panels = histories.plot("roof.x,motion").axes
    legend = [text.get_text() for text in panels[0].get_legend().get_texts()]
    assert legend == ["two", "bare", "Primary structure alone", "SSul NES, Set 6"]
    usual = [axes.get_label() for axes in histories.plot().axes]
    assert usual == ["energy", "motion", "roof.x", "shares"]


def test_a_scan_of_presets_and_general_systems(quake):
    systems = ["tmd", nv.System.from_host(FRAME, [cell()], name="frame")]
    vary = {"scale": {"values": [1.0, 2.0]}, "cell.gap": {"values": [0.01, 0.03]}}
    scan = nv.response_history(systems, load="quake.csv", duration=6.0, vary=vary, quiet=True)
    assert scan["impact_count"].dtype == np.int32
    assert (scan["impact_count"] == -1).all()
    assert (scan["cell.impact_count"][0] == -1).all()
    assert (scan["cell.impact_count"][1] > 0).all()
    assert scan["x1_max"][0, 0, 0] == scan["x1_max"][0, 0, 1]  # a TMD has no gap
    single = nv.response_history("tmd", load="quake.csv", duration=6.0, quiet=True)["tmd"]
    assert scan["E2max"][0, 0, 0] == pytest.approx(single.numbers["E2max"], rel=1e-11)
    assert np.isnan(scan["E2max"][1]).all()
    maps = [axes for axes in scan.plot("roof.x_max").axes if axes.get_title()]
    assert [axes.get_title() for axes in maps] == ["frame"]  # no empty map
    maps = [axes for axes in scan.plot("E1max").axes if axes.get_title()]
    assert len(maps) == 2


def test_a_host_of_one_floor_is_struck_beside_a_preset(here):
    """The same structure, damper and walls, from parameters and from parts, struck by one blow."""
    preset = nv.load_system("tmd")
    p = preset.parameters
    host = nv.Host(M=[[p["m1"]]], K=[[p["k1"]]], C=[[p["c1"]]], dofs=["x1"])
    damper = nv.Damper("damper", "x1", m=p["m2"], k=p["k2"], c=p["c2"])
    by_hand = nv.System.from_host(host, [damper], name="by hand")
    load = {"impulse": 300.0, "on": "x1"}
    histories = nv.response_history([preset, by_hand], load=load, duration=5.0, quiet=True)
    one, other = histories["tmd"].numbers, histories["by hand"].numbers
    assert other["x1.x_max"] == pytest.approx(one["x1_max"], rel=1e-10)
    assert other["damper.E2max"] == pytest.approx(one["E2max"], rel=1e-10)
    for name in ("E1max", "last_10", "last_50"):
        assert other[name] == pytest.approx(one[name], rel=1e-9)


@pytest.mark.parametrize("law", ["hertz", "restitution"])
def test_impacts_of_presets_are_those_of_the_same_system_from_parts(here, law):
    """One by one, under a blow: of a wall of the ground, and of two walls, one on each body."""
    if law == "hertz":
        preset = nv.load_system("ssul-set6")
        walls = [nv.Wall(preset.parameters["C"], "+", law="hertz", K=preset.K)]
    else:
        preset = nv.load_system("vi-nes", C=0.05, D=0.07, m2=0.1, k2=0.3)
        walls = [nv.Wall(0.07, "+", law=law, e=0.8), nv.Wall(0.05, "-", law=law, e=0.8)]
    p = preset.parameters
    host = nv.Host(M=[[p["m1"]]], K=[[p["k1"]]], C=[[p["c1"]]], dofs=["x1"])
    damper = nv.Damper("cell", "x1", m=p["m2"], k=p["k2"], c=p["c2"], walls=walls)
    by_hand = nv.System.from_host(host, [damper], name="by hand")
    load = {"impulse": p["m1"], "on": "x1"}
    histories = nv.response_history([preset, by_hand], load=load, duration=10.0, quiet=True)
    one, other = histories.results.values()
    assert len(one.impacts["touch"]) == one.numbers["impact_count"] > 5
    for column in ("touch", "release", "speed", "force", "depth", "impulse"):
        assert one.impacts[column] == pytest.approx(other.impacts[column], rel=1e-8), column
    assert set(one.impacts["damper"]) == {"damper"}
    assert set(other.impacts["damper"]) == {"cell"}
    words = dict(zip("+-", preset.scene.sides, strict=True))
    assert one.impacts["wall"].tolist() == [words[side] for side in other.impacts["wall"]]


def test_a_blow_from_a_file_and_a_start_decay(here, answer):
    frame = FRAME.reduced(3)
    Path("frame.toml").write_text(nv.load_response_history(
        nv.System.from_host(frame, [cell(gap=1.0)], name="tuned"),
        {"load": {"impulse": 3000.0, "on": {"roof": 1.0, "floor1": -0.5}},
         "sampling": {"duration": 5.0}, "record": {"of": ["roof"]}},
    ).to_toml())  # fmt: skip
    assert "record" not in answer("response-history", "frame.toml", "-o", "blow.h5", "--quiet")
    histories = nv.open_archive("blow.h5")
    # at once after the blow the frame has the energy of its floors' velocities
    speeds = np.array([-0.5, 0.0, 1.0]) * 3000.0 / 1e4
    assert histories["none"].E1[0] == pytest.approx(0.5 * 1e4 * speeds @ speeds)
    assert histories["none"].numbers["E1max"] == pytest.approx(0.5 * 1e4 * speeds @ speeds)
    start = [0.0] * 8
    start[4] = 0.01
    free = nv.response_history(
        nv.System.from_host(FRAME, [cell()]), start={"state": start}, duration=2.0, quiet=True
    )  # fmt: skip
    assert free["host"].E1[0] == pytest.approx(0.5 * 8e6 * 0.01**2)


BLOW = {"load": {"impulse": 1.0, "on": "roof"}}
QUAKE = {"record": {"times": [0.0, 0.1], "values": [0.0, 1.0], "unit": "g"}}
FINE = {"record": {"times": [0.0, 0.02], "values": [0.0, 1.0], "unit": "g"}}


@pytest.mark.parametrize(
    ("source", "changes", "words"),
    [
        (None, {"load": {"impulse": 1.0}}, "on is missing, the degree of freedom of the force"),
        (None, {"load": {"impulse": 1.0, "on": "rooof"}}, "did you mean 'roof'"),
        (None, {"load": {**QUAKE, "on": "roof"}}, "on: the loads move the ground"),
        (None, {**BLOW, "record": {"of": ["rooof"]}}, "did you mean 'roof'"),
        (None, {"load": {"impulse": 1.0, "on": "roof", "harmonic": True}}, "a host takes a tone"),
        (None, {**BLOW, "vary": {"omega": {"values": [1.0, 2.0]}}}, "own force is off"),
        (None, {**BLOW, "vary": {"cell.q": {"values": [1.0, 2.0]}}}, "unknown parameter 'q'"),
        (None, {**BLOW, "sampling": {"settle": 1.0}}, "the rms of hosts is over all times"),
        (None, {**BLOW, "start": {"state": [1.0]}}, "must be floor1, v_floor1"),
        ("tmd", BLOW, "on = 'roof': kind 'tmd' takes forces on its structure, x1"),
        ("tmd", {"load": {"impulse": 1.0}, "record": {"of": ["roof"]}}, "kind 'tmd' names no"),
        (["tmd", None], BLOW, "on = 'roof': kind 'tmd' takes forces on its structure, x1"),
        (["tmd", None], {"load": {"impulse": 1.0}}, "on is missing, the degree of freedom"),
        (["tmd", None], {"load": FINE, "record": {"of": ["rooof"]}}, "did you mean 'roof'"),
        (["tmd", None], {"load": FINE, "sampling": {"settle": 1.0}}, "the rms of hosts is over"),
        (["tmd", None], {"load": FINE, "start": {"state": [0.0] * 8}}, "must be x1, v1, x2, v2"),
        (None, {}, "[load] is empty"),
    ],
)  # fmt: skip
def test_wrong_requests_for_hosts_are_refused_in_one_line(source, changes, words, error_of):
    host = nv.System.from_host(FRAME, [cell()])
    named = [one or host for one in source] if isinstance(source, list) else source or host
    assert words in error_of(nv.load_response_history, named, changes)


def test_a_damper_on_a_host_is_tuned_under_an_earthquake(quake):
    """Its objective, and that with a stiffer host, are those of response histories."""
    system = nv.System.from_host(FRAME, [cell()])
    tables = {
        "load": {"record": "quake.csv"},
        "sampling": {"duration": 4.0},
        "record": {"of": ["roof"]},
    }
    tuned = nv.tune(
        {
            "system": system,
            **tables,
            "free": {"cell.gap": {"low": 0.005, "high": 0.05}, "cell.k": {"low": 0.0, "high": 2e5}},
            "search": {"objective": "roof.x_max", "population": 5, "generations": 1, "polish": 4},
        },
        quiet=True,
    )
    best = tuned.best
    at_best = {
        "set": {"cell": {"gap": best.parameters["cell.gap"], "k": best.parameters["cell.k"]}}
    }
    stiff = nv.Host(FRAME.M, FRAME.K * 1.01**2, ratio=0.02, dofs=FRAME.dofs)
    for name, host in (("none", FRAME), ("natural frequency +1%", stiff)):
        one = nv.System.from_host(host, [cell()])
        history = nv.response_history(one, **tables, **at_best, quiet=True)["host"]
        assert best.robustness[name] == pytest.approx(history.numbers["roof.x_max"], rel=1e-9)
    assert best.objective == best.robustness["none"]
