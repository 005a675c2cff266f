"""What a page knows: the numbers of an archive, and live orbits as `simulate` has them."""

import shlex
import tomllib
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from conftest import DIAGRAM, MAP, made_up

import nlds_vines as nv
from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.run import Computer
from nlds_vines.engine.records import CAPTURE_FLAGS, NOT_COMPUTED, OK, STATUS
from nlds_vines.explore import live_orbit as live
from nlds_vines.explore import map_view
from nlds_vines.explore.map_data import empty, stored
from nlds_vines.explore.page_state import FEWEST, MOST_ORBITS, Refining, finer, sliders_of
from nlds_vines.explore.report_page import branches_of, report_page, section_points
from nlds_vines.plotting.palette import colors
from nlds_vines.portrait.request import load_portrait
from nlds_vines.portrait.run import views_of
from scans import archived, unfilled

SAMPLING = load_scan(None, {"sampling": MAP["sampling"]})
SCAN = load_scan(MAP)


@pytest.fixture(scope="module")
def orbit():
    return live.live_orbit(nv.load_system("ssul-set6", omega=7.1), None, SAMPLING)


def test_arrays_and_columns_are_those_of_the_archive(small_map):
    archive = stored(small_map)
    with read(small_map) as view:
        for name in ("label", "E1max", "section", "multipliers", "status"):
            np.testing.assert_array_equal(archive.arrays[name], view[name])
    assert archive.shape == (6, 4)
    assert archive.starts == ("random 0", "random 1")
    omega, P = archive.scan.axes
    assert archive.values_of((1, 2)) == {"omega": omega.values[1], "P": P.values[2]}
    # columns stand start by start and cell by cell
    words = map_view.label_codes(archive)[0]
    labels = np.array(words)[map_view.column(archive, "label")]
    np.testing.assert_array_equal(labels.reshape(6, 4, 2), archive.arrays["label"])
    E1max = map_view.column(archive, "E1max").reshape(6, 4, 2)
    np.testing.assert_array_equal(E1max, archive.arrays["E1max"].astype(np.float32))
    never = archive.lanes("settling") < 0
    np.testing.assert_array_equal(np.isnan(map_view.column(archive, "settling")), never)


@pytest.mark.kernels
def test_every_cell_live_has_the_label_of_the_archive(small_map):
    archive = stored(small_map)
    for cell in np.ndindex(archive.shape):
        for k in range(2):
            system = archive.system_of(cell)
            start = archive.start_of(cell, k, system)
            orbit = live.live_orbit(system, start.state, archive.scan)
            assert orbit.label == archive.arrays["label"][(*cell, k)]


def test_the_start_of_a_sweep_is_the_end_of_the_cell_before_if_it_is_known(small_sweeps):
    archive = stored(small_sweeps)
    for k, before in ((0, 3), (1, 5)):  # up and down, at cell 4
        start = archive.start_of((4, 0), k, archive.system_of((4, 0)))
        assert start.state == tuple(archive.arrays["section"][before, k, -1])
    edge = archive.start_of((0, 0), 0, archive.scan.system)
    assert edge.state is None
    assert "beginning" in edge.words
    bare = {name: values for name, values in archive.arrays.items() if name == "label"}
    start = type(archive)(archive.scan, bare).start_of((4, 0), 0, archive.scan.system)
    assert start.state is None
    assert "does not hold" in start.words


def test_a_long_section_keeps_its_last_states_and_without_one_the_orbit_s_point_is_shown(
    small_map, monkeypatch
):
    archive = stored(small_map)
    monkeypatch.setattr("nlds_vines.explore.map_data.MOST_SECTION", 6 * 4 * 2 * 4 * 5)
    section = archive.arrays["section"]
    np.testing.assert_array_equal(stored(small_map).arrays["section"], section[..., -5:, :])
    arrays = {n: v for n, v in archive.arrays.items() if n != "section"}
    points = section_points(type(archive)(archive.scan, arrays))
    np.testing.assert_array_equal(points[:, 0], archive.lanes("orbit_point").reshape(-1, 4))


def test_any_other_file_is_refused_in_one_line(small_map, tmp_path, error_of):
    path, whole = tmp_path / "other.h5", small_map.read_bytes()
    for content in (b"no archive", whole[: len(whole) // 2], whole):
        path.write_bytes(content)
        if content is whole:
            with h5py.File(path, "a") as file:
                file.attrs["content"] = "tuning"
        assert "other.h5" in error_of(stored, path)


def test_what_maps_and_diagrams_show(small_map, small_diagram):
    names = [show.name for show in map_view.shows_of(stored(small_map))]
    assert names[:3] == ["regimes", "regimes of a start", "coexisting"]
    assert {"share:T,1", "E1max", "lyapunov"} <= set(names)
    # a diagram shows its section first
    shows = map_view.shows_of(stored(small_diagram))
    assert [show.name for show in shows[:2]] == ["x2", "x1"]
    assert shows[0].points
    # colors are those of the pictures
    archive = stored(small_map)
    words = map_view.label_codes(archive)[0][1:]
    shades = colors(words)
    classes = map_view.classes_of(archive)[1:]
    assert [shade for _, shade, _ in classes] == [shades[word] for word in words]
    names = {name: shade for _, shade, name in classes}
    assert len(names) == len(set(names.values()))  # one name for each color


def test_maps_and_diagrams_show_what_is_computed_touches_and_modulation(small_map):
    # a map of sections alone shows what is computed
    archive = stored(small_map)
    arrays = {name: archive.arrays[name].copy() for name in ("section", "status")}
    failed = next(code for code in STATUS if code not in (OK, NOT_COMPUTED))
    arrays["status"][0, 0, 0], arrays["status"][1, 0, 0] = NOT_COMPUTED, failed
    bare = type(archive)(archive.scan, arrays)
    assert [show.name for show in map_view.shows_of(bare)] == ["status"]
    codes = map_view.column(bare, "computed").reshape(6, 4, 2)
    assert (codes[0, 0, 0], codes[1, 0, 0], codes[2, 2, 1]) == (0, 2, 1)
    # a diagram shows the section at impact
    want = {"want": ["section", "impact_section", "regime"]}
    archive = empty(load_scan({**DIAGRAM, "record": want}))
    speeds = archive.arrays["impact_speed"]
    assert speeds.shape == (9, 1, 4 * 30)  # room for four impacts a period
    speeds[...] = np.arange(speeds.size).reshape(speeds.shape)
    shows = {show.name: show for show in map_view.shows_of(archive)}
    assert list(shows)[:4] == ["x2", "x1", "impact_speed", "impact_phase"]
    assert (shows["impact_speed"].points, shows["impact_speed"].unit) == (True, "m/s")
    drawn = map_view.diagram_values(archive, shows["impact_speed"])
    np.testing.assert_array_equal(drawn.ravel(), np.arange(speeds.size))
    assert '"impact_speed"' not in report_page(archive).html  # it holds nothing of touches
    # a map shows the kind of modulation
    twice = {**MAP, "system": "vi-nes", "record": {"want": ["modulation", "impact_section"]}}
    archive = empty(load_scan(twice))
    codes = archive.arrays["capture"]
    codes[...] = np.arange(codes.size).reshape(codes.shape) % 5 - 1
    (show,) = [one for one in map_view.shows_of(archive) if one.name == "capture"]
    words = [word for word, *_ in show.classes]
    assert words[1:] == ["no impacts", "strongly modulated", "sustained 1:1", "more impacts"]
    assert len(words) == len(CAPTURE_FLAGS) + 1
    captures = map_view.column(archive, "capture").ravel()
    np.testing.assert_array_equal(captures, np.arange(codes.size) % 5)
    assert "impact_phase" not in archive.arrays  # a map has no room for touches


def test_chaos_has_a_rate_of_impacts_and_no_count(tmp_path):
    """Also in an archive of 0.1.0, which counts those of its window."""
    scan = load_scan(DIAGRAM)
    arrays = unfilled(scan)
    numbers = {"status": OK, "label": "chaos", "periodicity": 0, "impact_count": 97}
    for name, value in (numbers | {"impact_rate": 0.8}).items():
        arrays[name][...] = value
    archive = stored(archived(tmp_path / "x.h5", scan, arrays))
    _, *lines = map_view.cell_in_words(archive, (3, 0), 0)
    assert "impacts per forcing period: 0.8" in lines
    assert not any("per nT" in line for line in lines)


def test_branches_are_those_of_a_continuation(tmp_path, error_of):
    path = made_up(MAP, tmp_path / "map.h5")
    assert "holds a scan, not a continuation" in error_of(branches_of, path, load_scan(MAP))
    assert nv.Continued.kinds["PD"] == "period doubling"
    assert nv.Continued.marks.keys() == nv.Continued.kinds.keys()


def test_a_map_and_a_diagram_are_told_in_words():
    """Where which regimes and numbers are, for readers who do not see the picture."""
    archive = empty(load_scan(MAP))
    archive.arrays["label"][...] = "T,1"
    archive.arrays["label"][2:4, 1] = "chaos"
    archive.arrays["label"][0, 0, 1] = "T,0"
    energies = archive.arrays["E1max"]
    energies[...] = 1.0
    energies[5, 3, 1] = 4.0
    shows = {show.name: show for show in map_view.shows_of(archive)}
    words = map_view.picture_in_words(archive, shows["regimes of a start"], 1)
    assert words == (
        "Map over angular frequency of the force, ω, from 7.3 to 7.7 rad/s in 6 cells and "
        "amplitude of the force, P, from 700 to 900 N in 4 cells. "
        "Shown: regimes of a start, random 1. "
        "T,1: 87.5% of the cells, at ω = 7.3 to 7.7 rad/s, P = 700 to 900 N; "
        "chaos: 8.3% of the cells, at ω = 7.46 to 7.54 rad/s, P = 766.667 N; "
        "T,0: 4.2% of the cells, at ω = 7.3 rad/s, P = 700 N."
    )
    words = map_view.picture_in_words(archive, shows["E1max"], 1)
    assert "largest: 4 J at ω = 7.7 rad/s, P = 900 N." in words
    assert "No value is known." in map_view.picture_in_words(archive, shows["lyapunov"], 0)
    # the box at the pointer names the shown number, or else the first one
    archive.arrays["periodicity"][...] = 1
    for name, line in (("E1max", "max: 4 J"), ("regimes", "max: 4 J"), ("periodicity", "n: 1")):
        head, place, number = map_view.tip_in_words(archive, (5, 3), 1, shows[name])
        assert (head, place) == ("T,1 (random 1)", "ω = 7.7 rad/s, P = 900 N")
        assert line in number
    archive = empty(load_scan(DIAGRAM))
    archive.arrays["label"][:5] = "T,1"
    archive.arrays["label"][5:] = "chaos"
    archive.arrays["section"][...] = 0.25
    (show, *_) = map_view.shows_of(archive)
    words = map_view.picture_in_words(archive, show, 0)
    assert "Least: 0.25 m at ω = 7.3 rad/s; largest: 0.25 m at ω = 7.3 rad/s. " in words
    along = "Regimes along the axis: ω = 7.3 to 7.5 rad/s: T,1; ω = 7.55 to 7.7 rad/s: chaos."
    assert words.endswith(along)


@pytest.mark.kernels
def test_the_section_is_that_of_simulate_with_multipliers_in_the_unit_circle(orbit):
    expected = nv.simulate(nv.load_system("ssul-set6", omega=7.1), 30, transient=60).section
    section = np.stack([orbit.panels["section"][n] for n in ("x1", "v1", "x2", "v2")], axis=-1)
    np.testing.assert_allclose(section, expected, rtol=0, atol=1e-9)
    assert orbit.label == "T,1"
    panel = orbit.panels["multipliers"]
    assert len(panel["re"]) == 4
    assert (np.hypot(panel["re"], panel["im"]) < 1).all()
    # a history holds all of every contact
    history, (view,) = orbit.panels["history"], views_of(orbit.request)
    assert len({len(values) for values in history.values()}) == 1
    t = history["t"]
    assert t[0] > 60
    assert t[-1] <= 60 + live.SHOW
    gaps = np.diff(np.flatnonzero(history["force"] > 0))
    early = view.contacts["touch"] < (60 + live.SHOW) * view.column.system.period
    assert early.sum() == (gaps > 1).sum() + 1


@pytest.mark.kernels
@pytest.mark.parametrize(("name", "omega"), [("ssbl", 6.05), ("ssbl", 6.3)])
def test_the_section_at_impact_is_that_of_simulate(name, omega):
    """Of one cycle, by wall: of T,2 one touch at each; of what is not periodic, all."""
    system = nv.load_system(name, omega=omega)
    orbit = live.live_orbit(system, None, SAMPLING)
    panel = orbit.panels["touches"]
    assert list(panel) == ["phase", *system.scene.wall_words]
    end = 60 + max(30, live.SHOW)
    impacts = nv.simulate(system, 30, transient=60, record=("impacts",)).impacts
    last = impacts[impacts["touch"] > (end - views_of(orbit.request)[0].cycle) * system.period]
    assert len(panel["phase"]) == len(last)
    for wall in system.scene.wall_words:
        rows = last[last["wall"] == wall]
        there = np.isfinite(panel[wall])
        assert len(rows) == there.sum() > 0
        np.testing.assert_allclose(panel[wall][there], rows["speed"], atol=1e-8)
        phases = rows["touch"] * system.parameters["omega"] % (2 * np.pi)
        np.testing.assert_allclose(panel["phase"][there], phases, atol=1e-7)


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["short", "long", "whole"])
def test_a_history_from_the_start_begins_there_and_covers_the_orbit(name):
    periods = {"short": live.SHOW, "long": live.LONG, "whole": 72}[name]
    system, start = nv.load_system("ssul-set6", omega=7.1), (0.01, -0.2, 0.3, -0.4)
    panel = live.live_orbit(system, start, SAMPLING, history=name).panels["history"]
    assert len({len(values) for values in panel.values()}) == 1
    assert panel["t"][0] < 0.1
    assert panel["t"][-1] == pytest.approx(periods, abs=periods / live.MOST_POINTS)
    plain = nv.simulate(system, periods, start=start, record=["trajectory"], samples=256)
    for place, column in ((0, "x1"), (2, "x2")):
        values = plain.trajectory[:, place]
        ends = [values.min(), values.max()]
        np.testing.assert_allclose([panel[column].min(), panel[column].max()], ends, rtol=0.02)
    assert min(panel["x1"][:2]) <= plain.trajectory[0, 0] <= max(panel["x1"][:2])
    assert panel["force"].max() > 0
    assert len(panel["t"]) < 4 * live.MOST_POINTS


@pytest.mark.kernels
def test_chaos_has_words_and_no_multipliers():
    orbit = live.live_orbit(nv.load_system("ssul-set6", omega=7.39), None, load_scan())
    assert orbit.label == "chaos"
    assert orbit.panels["multipliers"]["re"].size == 0
    assert live.words_of(orbit.regime).startswith("neighboring orbits diverge")
    assert dict(live.evidence_of(orbit.regime))["followed for"]
    # words count the impacts of all periods
    regime = SimpleNamespace(kind="periodic", period=3, impacts=2)
    assert live.words_of(regime) == "repeats every 3 forcing periods with 2 impacts in this time"


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["none", "impact-oscillator", "tmd"])
def test_a_system_without_damper_or_walls_has_the_panels_it_can(name):
    system = nv.load_system(name)
    panels = live.live_orbit(system, None, SAMPLING).panels
    assert ("x2" in panels["history"]) == system.scene.damper
    assert ("phase2" in panels) == system.scene.damper
    assert panels["phase1"]["x"].size > 100
    assert (panels["touches"]["phase"].size > 0) == bool(system.scene.walls)
    assert list(panels["touches"]) == ["phase", *system.scene.wall_words]


def test_a_start_inside_a_rigid_wall_is_refused(error_of):
    system = nv.load_system("ssul-set6").with_(law="restitution", e=0.8)
    assert "rigid" in error_of(live.live_orbit, system, (0.5, 0.0, 0.0, 0.0), SAMPLING)


@pytest.mark.kernels
def test_the_saved_recipe_is_the_orbit_again(orbit, tmp_path):
    path = tmp_path / "portrait.toml"
    path.write_text(orbit.request.to_toml())
    assert load_portrait(path).hash == orbit.request.hash
    # a system of no catalog is drawn from its recipe
    system = nv.System("ssul", SCAN.system.parameters, "own")
    request = live.live_orbit(system, None, SAMPLING).request
    assert live.portrait_command(request) == "nlds-vines portrait portrait.toml"


@pytest.mark.kernels
@pytest.mark.parametrize("start", [None, (0.01, -0.2, 0.3, -0.4)])
def test_the_command_line_is_the_orbit_again(start, monkeypatch, here):
    from nlds_vines.portrait import command

    system, requests = nv.load_system("ssul-set6", omega=7.1, P=750.0), []
    request = live.live_orbit(system, start, SAMPLING).request
    words = shlex.split(live.portrait_command(request))
    assert words[:2] == ["nlds-vines", "portrait"]
    monkeypatch.setattr(command.Job, "carry_out", lambda job, *_: requests.append(job.request) or 0)
    assert command.main(words[2:]) == 0
    (again,) = requests
    assert again.columns[0].system.parameters == system.parameters
    assert (again.start, again.samples, again.columns[0].window) == (
        request.start, request.samples, request.columns[0].window,
    )  # fmt: skip


def test_a_part_of_a_map_has_as_many_cells_as_the_map_and_stays_small(error_of):
    part = finer(SCAN, ((7.4, 7.5), (720.0, 740.0)), {"C": 0.05})
    assert part.shape == (6, 4)
    assert part.axes[0].values[[0, -1]].tolist() == [7.4, 7.5]
    assert part.system.parameters["C"] == 0.05
    assert tomllib.loads(part.to_toml())["vary"].keys() == {"omega", "P"}
    vary = {"omega": np.linspace(5.0, 8.0, 2000), "P": np.linspace(1.0, 9.0, 1000)}
    part = finer(load_scan({**MAP, "vary": vary}), ((6.0, 7.0), (2.0, 3.0)))
    assert min(part.shape) > FEWEST
    assert part.lanes <= 1.01 * MOST_ORBITS
    # an empty one is refused
    for low_high in ((7.2, 7.1), (float("nan"), 7.0), (-3.0, -2.0)):
        assert "omega" in error_of(finer, SCAN, (low_high, (700.0, 800.0)))


def test_a_job_ends_as_the_archive_and_says_that_kernels_are_compiled(small_map, monkeypatch):
    class Compiling(Computer):
        def __init__(self, scan, tell, helped):
            tell("compiling the kernels of ssul", 0.0)
            super().__init__(scan, helped=helped)

    monkeypatch.setattr("nlds_vines.bifurcation.run.Computer", Compiling)
    messages = []
    job = Refining(SCAN, lambda: messages.append((job.note, job.share)))
    assert set(map_view.column(job.results, "label").ravel()) == {0}
    job.start()
    job.join()
    assert messages[0][0] == "compiling the kernels of ssul"
    assert messages[-1] == ("", 1.0)
    assert (job.done, job.error) == (SCAN.lanes, "")
    for name, values in stored(small_map).arrays.items():
        np.testing.assert_array_equal(job.results.arrays[name], values)
    # one that is cancelled ends with its block
    monkeypatch.undo()
    monkeypatch.setattr("nlds_vines.bifurcation.blocks.BLOCK_PERIODS", 1)
    job = Refining(SCAN, lambda: setattr(job, "cancelled", True))
    job.start()
    job.join()
    assert 0 < job.done < SCAN.lanes


def test_there_is_a_slider_for_every_parameter():
    entries = sliders_of(empty(SCAN))
    assert {entry.name for entry in entries} == set(SCAN.system.parameters)
    assert {entry.name for entry in entries[:2]} == {"P", "omega"}
    for entry in entries:
        assert entry.low <= entry.value <= entry.high, entry
        SCAN.system.with_(**{entry.name: entry.low})
        SCAN.system.with_(**{entry.name: entry.high})
    scan = load_scan({"system": "ssul-set6", "vary": {"K": {"start": 1e7, "stop": 9e7, "num": 5}}})
    names = [entry.name for entry in sliders_of(empty(scan))]
    assert names[0] == "K"
    assert "E1" not in names
