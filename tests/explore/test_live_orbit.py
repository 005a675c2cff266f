"""A live orbit: the numbers of `simulate`, its panels, its words; recipes that give it again."""

import shlex
import tomllib
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import MAP

import nlds_vines as nv
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.run import Computer
from nlds_vines.explore.live_orbit import (
    LONG,
    MOST_POINTS,
    SHOW,
    evidence_of,
    live_orbit,
    portrait_command,
    words_of,
)
from nlds_vines.explore.map_data import empty
from nlds_vines.explore.page_state import FEWEST, MOST_ORBITS, Job, finer, sliders_of
from nlds_vines.portrait.request import load_portrait

SAMPLING = load_scan(None, {"sampling": MAP["sampling"]})
SCAN = load_scan(MAP)


@pytest.fixture(scope="module")
def orbit():
    return live_orbit(nv.load_system("ssul-set6", omega=7.1), None, SAMPLING)


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
    history, view = orbit.panels["history"], orbit.view
    assert len({len(values) for values in history.values()}) == 1
    t = history["t"]
    assert t[0] > 60
    assert t[-1] <= 60 + SHOW
    gaps = np.diff(np.flatnonzero(history["force"] > 0))
    early = view.contacts["touch"] < (60 + SHOW) * view.column.system.period
    assert early.sum() == (gaps > 1).sum() + 1


@pytest.mark.kernels
@pytest.mark.parametrize(("name", "omega"), [("ssbl", 6.05), ("ssbl", 6.3)])
def test_the_section_at_impact_is_that_of_simulate(name, omega):
    """Of one cycle, by wall: of T,2 one touch at each; of what is not periodic, all."""
    system = nv.load_system(name, omega=omega)
    orbit = live_orbit(system, None, SAMPLING)
    panel = orbit.panels["touches"]
    assert list(panel) == ["phase", *system.scene.walls]
    end = 60 + max(30, SHOW)
    impacts = nv.simulate(system, 30, transient=60, record=("impacts",)).impacts
    last = impacts[impacts["touch"] > (end - orbit.view.cycle) * system.period]
    assert len(panel["phase"]) == len(last)
    for wall in system.scene.walls:
        rows = last[last["wall"] == system.scene.struck[wall]]
        there = np.isfinite(panel[wall])
        assert len(rows) == there.sum() > 0
        np.testing.assert_allclose(panel[wall][there], rows["speed"], atol=1e-8)
        phases = rows["touch"] * system.parameters["omega"] % (2 * np.pi)
        np.testing.assert_allclose(panel["phase"][there], phases, atol=1e-7)


@pytest.mark.kernels
@pytest.mark.parametrize(("name", "periods"), [("short", SHOW), ("long", LONG), ("whole", 72)])
def test_a_history_from_the_start_begins_there_and_covers_the_orbit(name, periods):
    system, start = nv.load_system("ssul-set6", omega=7.1), (0.01, -0.2, 0.3, -0.4)
    panel = live_orbit(system, start, SAMPLING, history=name).panels["history"]
    assert len({len(values) for values in panel.values()}) == 1
    assert panel["t"][0] < 0.1
    assert panel["t"][-1] == pytest.approx(periods, abs=periods / MOST_POINTS)
    plain = nv.simulate(system, periods, start=start, record=["trajectory"], samples=256)
    for place, column in ((0, "x1"), (2, "x2")):
        values = plain.trajectory[:, place]
        ends = [values.min(), values.max()]
        np.testing.assert_allclose([panel[column].min(), panel[column].max()], ends, rtol=0.02)
    assert min(panel["x1"][:2]) <= plain.trajectory[0, 0] <= max(panel["x1"][:2])
    assert panel["force"].max() > 0
    assert len(panel["t"]) < 4 * MOST_POINTS


@pytest.mark.kernels
def test_chaos_has_words_and_no_multipliers():
    orbit = live_orbit(nv.load_system("ssul-set6", omega=7.39), None, load_scan())
    assert orbit.label == "chaos"
    assert orbit.panels["multipliers"]["re"].size == 0
    assert words_of(orbit.regime).startswith("neighboring orbits diverge")
    assert dict(evidence_of(orbit.regime))["followed for"]
    # words count the impacts of all periods
    regime = SimpleNamespace(kind="periodic", period=3, impacts=2)
    assert words_of(regime) == "repeats every 3 forcing periods with 2 impacts in this time"


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["none", "impact-oscillator", "tmd"])
def test_a_system_without_damper_or_walls_has_the_panels_it_can(name):
    system = nv.load_system(name)
    panels = live_orbit(system, None, SAMPLING).panels
    assert ("x2" in panels["history"]) == system.scene.damper
    assert (panels["phase2"]["x"].size > 100) == system.scene.damper
    assert panels["phase1"]["x"].size > 100
    assert (panels["touches"]["phase"].size > 0) == bool(system.scene.walls)
    assert list(panels["touches"]) == ["phase", *system.scene.walls]


def test_a_start_inside_a_rigid_wall_is_refused(error_of):
    system = nv.load_system("ssul-set6").with_(law="restitution", e=0.8)
    assert "rigid" in error_of(live_orbit, system, (0.5, 0.0, 0.0, 0.0), SAMPLING)


@pytest.mark.kernels
def test_the_saved_recipe_is_the_orbit_again(orbit, tmp_path):
    path = tmp_path / "portrait.toml"
    path.write_text(orbit.request.to_toml())
    assert load_portrait(path).hash == orbit.request.hash
    # a system of no catalog is drawn from its recipe
    base = nv.load_system("ssul-set6")
    system = nv.System(base.kind, dict(base.parameters), "own")
    request = live_orbit(system, None, SAMPLING).request
    assert portrait_command(request) == "nlds-vines portrait portrait.toml"


@pytest.mark.kernels
@pytest.mark.parametrize("start", [None, (0.01, -0.2, 0.3, -0.4)])
def test_the_command_line_is_the_orbit_again(start, monkeypatch, here):
    from nlds_vines.portrait import command

    system, requests = nv.load_system("ssul-set6", omega=7.1, P=750.0), []
    request = live_orbit(system, start, SAMPLING).request
    words = shlex.split(portrait_command(request))
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


def test_a_job_computes_what_the_scan_means_and_says_that_kernels_are_compiled(monkeypatch):
    class Compiling(Computer):
        def __init__(self, scan, tell, helped):
            tell("compiling the kernels of ssul", 0.0)
            super().__init__(scan, helped=helped)

    monkeypatch.setattr("nlds_vines.bifurcation.run.Computer", Compiling)
    messages = []
    job = Job(SCAN, lambda: messages.append((job.note, job.share)))
    job.start()
    job.join()
    assert messages[0][0] == "compiling the kernels of ssul"
    assert messages[-1] == ("", 1.0)
    assert (job.done, job.error) == (SCAN.lanes, "")
    assert (job.results.arrays["label"] != "").all()
    # one that is cancelled ends with its block
    monkeypatch.undo()
    monkeypatch.setattr("nlds_vines.bifurcation.blocks.BLOCK_PERIODS", 1)
    job = Job(SCAN, lambda: setattr(job, "cancelled", True))
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
