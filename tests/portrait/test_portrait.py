"""The portrait: requests checked once, windows of one run, pages for every scene, exit statuses."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from layout import collisions
from matplotlib.transforms import Bbox
from PIL import Image

import nlds_vines as nv
from nlds_vines.engine import records
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.system import System
from nlds_vines.portrait.command import main
from nlds_vines.portrait.panels import DEPTH, Place
from nlds_vines.portrait.picture import make_page, rows_of, write_letters
from nlds_vines.portrait.picture import portrait as draw
from nlds_vines.portrait.request import PANELS, Column, PortraitRequest, load_portrait
from nlds_vines.portrait.run import views_of

pytestmark = pytest.mark.kernels

ROOT = Path(__file__).resolve().parents[2]
SAMPLES = 128
SHORT = {"samples": SAMPLES, "transient": 600, "periods": 12}
ALL = tuple(name for name in PANELS if name not in ("exponents", "shape"))

OF_KIND = {
    "none": nv.load_system("none"),
    "tmd": nv.load_system("tmd"),
    "ssul": nv.load_system("ssul-set6"),
    "ssbl": nv.load_system("ssbl", omega=6.05),
}


CHAOS = nv.load_system("ssul-set6", omega=7.4, K=2.5e7)


def request_of(system, **portrait):
    sampling = {key: portrait.pop(key) for key in tuple(portrait) if key in (*SHORT, "windows")}
    sampling = {"samples": SAMPLES, **sampling} if "windows" in sampling else SHORT | sampling
    return load_portrait(system, {"sampling": sampling, "portrait": portrait})


def page(system, **options):
    request = request_of(system, **options)
    views = views_of(request)
    return draw(request, views), views


def figure11(**changes):
    return load_portrait(ROOT / "scans" / "figure11.toml", changes)


def headings(figure):
    return [words for axes in figure.axes if (words := axes.get_title(loc="left"))]


def drawn(axes, label):
    """Return the points of the only curve of a name."""
    (line,) = (line for line in axes.lines if line.get_label() == label)
    return line.get_xydata()


def test_windows_of_one_run_are_compared_in_one_plane_with_the_obstacle_in_both():
    system = nv.load_system("ssul-set6", omega=7.575, K=2.5e7)
    windows = [[20, 40], [1000, 1004]]
    figure, views = page(system, windows=windows, panels=("phase1", "phase2"))
    assert [view.period for view in views] == [0, 1]
    for left, right in (figure.axes[:2], figure.axes[2:]):
        assert left.get_xlim() == right.get_xlim()
        assert left.get_ylim() == right.get_ylim()
    for axes in figure.axes[2:]:
        assert "obstacle" in axes.get_legend_handles_labels()[1]


def test_a_letter_of_a_phase_plane_stands_in_a_corner_without_curves():
    figure, _ = page(OF_KIND["tmd"], panels=("phase1", "energy"))
    plane, energy = figure.axes
    assert plane.texts[0].xy == (0, 1)
    plane.plot([plane.get_xlim()[0]], [plane.get_ylim()[1]], "o", scalex=False, scaley=False)
    write_letters([[place_of("phase1", plane), place_of("energy", energy)]], False)
    assert plane.texts[-1].xy == (1, 1)


def place_of(panel, axes):
    return Place(panel, None, axes, True, True)


def test_a_limit_is_told_above_the_page_and_no_words_of_a_legend_leave_it():
    ssbl = nv.load_system("ssbl")
    allowed = System("ssvi-c", {**ssbl.parameters, "C": 0.1, "D": 0.15, "L": 5.0})
    passing = System("ssvi-c", {**ssbl.parameters, "C": 0.1, "D": 0.15, "L": 0.1})
    assert "limit" not in headings(page(allowed)[0])[0]
    figure, (view,) = page(passing)
    assert f"limit passed by {view.violation.depth:.2g} m" in headings(figure)[0]
    assert figure.texts[0].get_text().startswith("Single-sided NES (ssvi-c)")
    # no words of a legend leave the page
    stops = {**nv.load_system("hard-oscillator").parameters, "C": 0.5, "C_2": 1.0}
    figure, _ = page(System("oscillator-2", stops, law="restitution"))
    figure.draw_without_rendering()
    legends = [axes.get_legend() for axes in figure.axes if axes.get_legend()]
    assert any("C_2" in text.get_text() for legend in legends for text in legend.get_texts())
    for legend in legends:
        assert all(text.get_window_extent().x1 <= figure.bbox.x1 for text in legend.get_texts())


@pytest.mark.parametrize("kind", [kind for kind in OF_KIND if kind != "ssul"])
def test_every_scene_has_a_page_without_the_panels_it_lacks(kind):
    figure, (view,) = page(OF_KIND[kind], panels=ALL)
    labels = [axes.get_ylabel() for axes in figure.axes]
    scene = SCENES[kind]
    assert ("force [kN]" in labels) == bool(scene.walls)
    of_damper = {"$x_2-x_1$ [m]", "$E_2$ [J]", r"$\dot{x}_2$ [m/s]"}
    assert of_damper & {*labels} == (of_damper if scene.damper else set())
    assert len(labels) == len(ALL) - (0 if scene.damper else 4) - (0 if scene.walls else 2)
    assert view.label == ("T,2" if kind == "ssbl" else "T,0")
    # labels carry symbols or words, and units
    across = [axes.get_xlabel() for axes in figure.axes if axes.get_xlabel()]
    assert len(across) >= (5 if scene.walls else 3)
    assert all(label.endswith("]") for label in labels + across)
    assert figure.get_figwidth() == pytest.approx(16 / 2.54)


def test_nothing_is_written_outside_the_page_or_over_another_panel():
    windows = [[10, 20], [20, 26], [26, 29], [29, 31]]
    for options in ({}, {"windows": windows[:2]}, {"windows": windows}):
        figure, _ = page(OF_KIND["ssul"], panels=ALL, **options)
        assert collisions(figure) == []  # which draws it
        boxes = [axes.get_tightbbox(for_layout_only=True) for axes in figure.axes]
        boxes += [text.get_window_extent() for text in figure.texts]
        assert Bbox.union([figure.bbox, *boxes]).bounds == figure.bbox.bounds
        for box, other in combinations(boxes, 2):
            both = Bbox.intersection(box, other)
            # pixels, of the white around a letter
            assert both is None or min(both.width, both.height) < 3


def test_the_curves_are_the_orbit():
    """That the states are those of `simulate`, the test of windows below shows."""
    figure, (view,) = page(OF_KIND["ssul"], panels=["displacement", "relative", "phase2"], show=5)
    displacement, relative, phase = figure.axes
    x1, x2, obstacle = (line.get_ydata() for line in displacement.get_lines())
    np.testing.assert_array_equal(x1, view.states[: 5 * SAMPLES, 0])
    np.testing.assert_array_equal(x2, view.states[: 5 * SAMPLES, 2])
    np.testing.assert_allclose(obstacle - x1, 0.1, rtol=1e-12)
    assert displacement.get_xlim() == relative.get_xlim() == (600, 605)
    u, wall = relative.get_lines()
    np.testing.assert_array_equal(u.get_ydata(), x2 - x1)
    assert set(wall.get_ydata()) == {0.1}
    points = phase.get_lines()[-1]
    np.testing.assert_array_equal(points.get_xydata()[-1], view.states[-1, 2:])


def test_walls_are_drawn_by_their_own_lines_and_forces():
    figure, (view,) = page(OF_KIND["ssbl"], panels=["relative", "force"])
    relative, force = figure.axes
    assert len(relative.lines) == 3
    for name, place in (("structure", 0.0), ("obstacle", 0.42)):
        assert set(drawn(relative, name)[:, 1]) == {place}
    structure, obstacle = (drawn(force, name)[:, 1] for name in ("structure", "obstacle"))
    assert structure.min() == 0 < structure.max()
    assert obstacle.max() == 0 > obstacle.min()
    assert drawn(force, r"$P\,\cos\,\omega t$")[:, 1].max() == pytest.approx(0.8)
    assert len(view.touches) == 24


@pytest.mark.parametrize(
    ("kind", "parameters", "lines"),
    [
        ("ssvi-b", {}, {"structure": 0.0, "obstacle": 0.42}),
        ("ssvi-c", {"L": 0.1}, {"limit": -0.1, "obstacle": 0.42}),
    ],
)
def test_limits_are_lines_too_and_have_no_force(kind, parameters, lines):
    request = request_of(OF_KIND["ssbl"], panels=ALL)
    (view,) = views_of(request)
    system = System(kind, {**OF_KIND["ssbl"].parameters, **parameters})
    column = Column(system, view.column.window)  # the orbit does not matter here, the scene does
    contacts = view.contacts[view.contacts["wall"] == "obstacle"]
    passed = records.Violation(2, 1.5, 0.01)
    seen = replace(view, column=column, violation=passed, contacts=contacts)
    assert "violated 2 times, by up to 0.01 m, first at 1.5 s" in "\n".join(seen.lines())
    within = replace(seen, violation=records.Violation(0, np.nan, 0.0))
    assert "in the whole run: kept" in "\n".join(within.lines())
    figure = draw(replace(request, columns=(column,)), [seen])
    panels = {axes.get_ylabel(): axes for axes in figure.axes}
    relative = panels["$x_2-x_1$ [m]"].get_lines()[1:]
    assert {line.get_label(): line.get_ydata()[0] for line in relative} == pytest.approx(lines)
    names = [line.get_label() for line in panels["force [kN]"].get_lines()]
    assert names == [r"$P\,\cos\,\omega t$", "contact"]


def test_a_spectrum_is_cut_off_below_its_highest_line():
    figure, (view,) = page(OF_KIND["ssul"], panels=["spectrum"], signal="force")
    (axes,) = figure.axes
    assert axes.get_ylabel() == "$|F|$ [dB re 1 N]"
    highest = view.spectrum.decibels()[1:].max()
    assert axes.get_ylim()[0] == pytest.approx(highest - DEPTH)
    assert view.share < 1e-10


SECTIONS = {"transient": 300, "periods": 24, "samples": 64}


@pytest.mark.parametrize(("phase", "sample"), [(0.0, 0), (0.25, 16), (0.499, 32), (1.0, 0)])
def test_a_section_is_taken_at_any_phase_of_the_force(phase, sample):
    figure, (view,) = page("tmd", panels=["section", "section1"], section_phase=phase, **SECTIONS)
    system = view.column.system
    time = view.time[(sample - 1) % 64]
    angle = 2 * np.pi * sample / 64
    assert np.cos(system.parameters["omega"] * time) == pytest.approx(np.cos(angle), abs=1e-9)
    label = "$t=nT$" if sample == 0 else rf"$\phi={sample / 64:.3g}$"
    state = view.states[(sample - 1) % 64 :: 64][-1]
    damper, structure = figure.axes
    both = np.hstack([drawn(structure, label), drawn(damper, label)])
    assert both.tolist() == [state.tolist()]
    assert (damper.get_xlabel(), structure.get_xlabel()) == ("$x_2$ [m]", "$x_1$ [m]")


def test_the_section_at_impact_has_phase_and_speed_of_a_cycle_by_wall():
    figure, (view,) = page(OF_KIND["ssbl"], panels=["impact-section"], **SECTIONS)
    (axes,) = figure.axes
    assert view.label == "T,2"
    period = view.column.system.period
    for name in ("obstacle", "structure"):
        row = view.contacts[view.contacts["wall"] == name][-1]
        (point,) = drawn(axes, name)
        assert point == pytest.approx([row["touch"] / period % 1.0 * 2 * np.pi, row["speed"]])
    assert axes.get_xlim() == (0.0, 2 * np.pi)
    assert axes.get_ylim()[1] > view.contacts["speed"].max()


def test_windows_are_cut_from_one_run(monkeypatch):
    runs = Mock(wraps=nv.simulate)
    monkeypatch.setattr("nlds_vines.portrait.run.simulate", runs)
    _, (first, second) = page(OF_KIND["ssul"], windows=[[3, 5], [9, 20]])
    runs.assert_called_once()
    assert runs.call_args.kwargs["transient"] == 3
    T = OF_KIND["ssul"].period
    assert first.time[0] == pytest.approx(3 * T + T / SAMPLES)
    assert (first.time[-1], second.time[-1]) == (pytest.approx(5 * T), pytest.approx(20 * T))
    record = ["trajectory", "impacts"]
    whole = nv.simulate(OF_KIND["ssul"], 17, transient=3, record=record, samples=SAMPLES)
    np.testing.assert_array_equal(second.states, whole.trajectory[6 * SAMPLES :])
    touches = whole.impacts["touch"]
    assert len(first.touches) == np.count_nonzero(touches <= 5 * T)
    assert len(second.touches) == np.count_nonzero(touches > 9 * T)


def test_columns_of_other_systems_are_other_runs_beside_each_other():
    document = {
        "system": "ssul-set6",
        "sampling": {"samples": SAMPLES},
        "portrait": {"panels": ["energy1", "spectrum"], "taper": "hann"},
        "column": [
            {"name": "low", "set": {"omega": 6.0}, "window": [20, 32]},
            {"name": "high", "set": {"omega": 8.0}, "window": [300, 312]},
        ],
    }
    request = load_portrait(document)
    assert len(request.runs()) == 2
    figure = nv.orbit_portrait(document)
    low, high = figure.axes[:2]
    assert low.get_ylim() == high.get_ylim()
    assert headings(figure) == ["low, periods 20 to 32", "high, periods 300 to 312"]


def test_a_subharmonic_orbit_is_told_by_its_period():
    request = request_of(CHAOS.with_(omega=7.375), transient=1500, periods=40)
    (view,) = views_of(request)
    assert (view.label, view.comb, view.spectrum.periods) == ("3T,3", 3, 39)
    assert view.share < 1e-10
    text = "\n".join(view.lines())
    assert "3T,3: the section repeats after 3 periods" in text
    assert "impacts per period: 1 (40 in the window)" in text
    plane = PortraitRequest("", request.columns, ("phase1",), samples=SAMPLES)
    ((line, points),) = [axes.get_lines() for axes in draw(plane, [view]).axes]
    assert len(points.get_xdata()) == 3
    start, end = line.get_xydata()[[0, -1]]
    np.testing.assert_allclose(start, end, atol=1e-6)  # the curve closes


def test_what_is_not_known_is_said():
    _, (view,) = page(OF_KIND["ssul"], transient=0, periods=2, panels=["energy"])
    text = "\n".join(view.lines())
    assert "too short to tell" in text
    assert "no repetition" in headings(page(OF_KIND["ssul"], transient=0, periods=4)[0])[0]
    _, (view,) = page(OF_KIND["ssul"], transient=0, periods=1, taper="hann")
    assert view.share is None
    assert "too few periods to tell" in "\n".join(view.lines())


def test_a_start_is_where_the_orbit_begins():
    plain = request_of(OF_KIND["ssul"], transient=0)
    request = load_portrait(plain, {"start": {"state": [0.01, 0.0, 0.3, 0.0]}})
    (view,) = views_of(request)
    assert view.states[0, 2] == pytest.approx(0.3, abs=0.01)
    assert request.hash != plain.hash


CAPTIONS = {  # the kinds of panels in the order of the paper's captions, (a), (b), ...
    "figure9": ["displacement", "phase", "relative", "force"],
    "figure10": ["relative", "phase1", "phase2", "force", "spectrum"],
    "figure11": ["relative", "phase1", "phase2", "force", "spectrum", "phase", "velocity"],
}


@pytest.mark.parametrize("name", CAPTIONS)
def test_the_papers_figures_have_the_letters_of_their_captions(name):
    request = load_portrait(ROOT / "scans" / f"{name}.toml", {"sampling": {"samples": 8}})
    assert list(request.panels[: len(CAPTIONS[name])]) == CAPTIONS[name]
    views = views_of(request)
    _, _, places = make_page(request.panels, views)
    write_letters(places, len(views) > 1)
    lettered = [(p.axes.texts[0].get_text(), p.panel) for row in places for p in row]
    letters = dict(lettered)
    assert [letters[f"({'abcdefg'[i]})"] for i in range(len(CAPTIONS[name]))] == CAPTIONS[name]
    assert sorted(letters) == [letter for letter, _ in sorted(set(lettered))]  # one letter a kind


def test_panels_of_one_column_stand_side_by_side_below_its_name():
    request = figure11(sampling={"samples": 64})
    views = views_of(request)
    rows = rows_of(request.panels, views)
    rows = [[(panel, view.column.name) for panel, view in row] for row in rows]
    both = ["chaotic phase", "periodic phase"]
    assert rows[0] == [("relative", name) for name in both]
    assert rows[1] == [("phase1", "chaotic phase"), ("phase2", "chaotic phase")]
    assert rows[4] == [("phase", "periodic phase"), ("velocity", "periodic phase")]
    above = headings(draw(request, views))
    assert above.count("chaotic phase, periods 10 to 70") == 3  # above its column and over (b), (c)
    plain = figure11(portrait={"panels": ["force"]})
    assert [column.panels for column in plain.columns] == [(), ()]


@pytest.fixture
def folder(here):
    (here / "good.toml").write_text('system = "tmd"\n[sampling]\nperiods = 4\ntransient = 0\n')
    return here


def test_a_run_draws_and_says_what_was_seen(folder, answer, refusal):
    out = answer("portrait", "good.toml", "--start", "0,0,0.1,0")
    assert "periods 0 to 4" in out
    assert "largest E2" in out
    with Image.open(folder / "good.png") as image:
        assert image.width == pytest.approx(16 / 2.54 * 200, abs=1)
        assert image.info["Title"] == "Tuned mass damper, ω = 6.28 rad/s"
        started = load_portrait("good.toml", {"start": {"state": [0, 0, 0.1, 0]}})
        assert image.info["recipe_hash"] == started.hash
    assert "exists: --overwrite replaces it" in refusal("portrait", "good.toml", "--quiet")
    assert main(["good.toml", "--start", "0,0,0.1,0", "--quiet"]) == 0  # the same one
    assert answer("portrait", "good.toml", "--quiet", "--overwrite") == ""


@pytest.mark.parametrize("suffix", [".pdf", ".svg"])
def test_vectors_stay_small_and_repeat_to_the_byte(suffix, folder):
    first, second = folder / f"a{suffix}", folder / f"b{suffix}"
    options = {"transient": 100, "periods": 170, "samples": 512, "panels": ["phase1", "force"]}
    for path in (first, second):
        figure = nv.orbit_portrait(CHAOS, to=path, **options)
    assert first.read_bytes() == second.read_bytes()
    assert first.stat().st_size < 2_000_000
    lines = [line for axes in figure.axes for line in axes.get_lines()]
    vectors = [line.get_xdata().size for line in lines if not line.get_rasterized()]
    assert sum(vectors) < 20_000


def test_an_orbit_that_ends_early_is_status_1_and_no_picture(folder, ask):
    stiff = ["--method", "rk4", "--set", "k2=1e9", "--quiet"]
    out, err = ask("portrait", "good.toml", *stiff, status=1)
    assert out == ""
    assert err.count("\n") == 1
    assert "too_stiff" in err
    assert not (folder / "good.png").exists()
