"""Panels, marks, ends, titles and reports of branches."""

import re
from pathlib import Path

import numpy as np
import pytest
from layout import collisions
from matplotlib.figure import Figure

import nlds_vines as nv
from nlds_vines.continuation.branch_arm import ENDS
from nlds_vines.continuation.picture import plane_diagram
from nlds_vines.continuation.result import MARKS, STOPS
from nlds_vines.continuation.special_curves import ENDS as CURVE_ENDS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "branches.md"


@pytest.fixture(scope="module")
def branches(tmp_path_factory):
    """Return the branches of T,1 and 2T,2 of Set 6, which meet PD, GR and NS."""
    path = tmp_path_factory.mktemp("pictures") / "branches.h5"
    options = {"doublings": 1, "unstable": 30, "step": 0.1, "quiet": True}
    return nv.continue_branch("ssul-set6", "omega", (7.3, 7.5), to=path, **options)


def marks_of(axes, kind):
    """Return the marks of a kind of special point in axes."""
    look = MARKS[kind]
    lines = [line for line in axes.get_lines() if line.get_marker() == look["marker"]]
    return [line for line in lines if look["color"] in (line.get_color(), line.get_mec())]


def test_special_points_stand_on_all_sections_of_an_orbit(branches):
    (axes,) = branches.plot("x2").axes
    rows = branches.special_points
    for kind in ("PD", "NS", "GR"):
        periods = rows.periodicity[rows.kind == kind]
        marks = marks_of(axes, kind)
        assert len(marks) == periods.sum() > 0
        heights = sorted(float(line.get_ydata()[0]) for line in marks)
        sections = [branches.special_sections[i] for i in np.flatnonzero(rows.kind == kind)]
        np.testing.assert_allclose(heights, np.sort(np.concatenate(sections)[:, 2]))
    for row, sections in zip(rows, branches.special_sections, strict=True):
        np.testing.assert_allclose(sections[-1], row.state, atol=1e-9)
    (axes,) = branches.plot("E1max").axes
    assert len(marks_of(axes, "NS")) == (rows.kind == "NS").sum()


PANELS = {
    "x1": "structure $x_1$ [m]",
    "v2": "velocity of the damper $v_2$ [m/s]",
    "E2max": "energy of the damper",
    "multipliers": r"multiplier $|\mu|$",
    "largest_force": "largest contact force [N]",
    "clearance": "smallest near miss",
}


def test_panels_are_chosen_by_name(branches, answer, refusal):
    for name, label in PANELS.items():
        axes = Figure().add_subplot()
        branches.plot(name, ax=axes)
        assert axes.get_ylabel().startswith(label)
    listed = answer("plot", branches.path, "--show", "?")
    assert set(PANELS) < {line.split()[0] for line in listed.splitlines()}
    assert "unknown show 'x9'" in refusal("continuation", "--show", "x1,x9")
    plane = ["--plane", "P=700:900", "--show", "x1"]
    assert "unknown show 'x1'; allowed: plane" in refusal("continuation", *plane)


def test_panels_of_impacts_need_walls(refusal):
    line = refusal("continuation", "--system", "tmd", "--show", "largest_force", "--plot", "a.png")
    assert "largest_force" in line
    assert "multipliers" in line
    assert "fastest_impact" not in line


def test_a_command_draws_the_panels_that_it_shows(tmp_path, ask):
    path, drawn, again = (tmp_path / name for name in ("a.h5", "a.svg", "again.svg"))
    asked = ["--along", "omega=7:7.01", "-o", path, "--quiet"]
    ask("continuation", *asked, "--show", "multipliers", "--plot", drawn)
    ask("plot", path, "--show", "multipliers", "-o", again)
    assert again.read_bytes() == drawn.read_bytes()
    figure = nv.plot(path, "x1,multipliers")
    assert collisions(figure) == []
    assert [axes.get_ylabel()[:6] for axes in nv.plot(path).axes] == ["damper", "energy"]


def test_multipliers_are_drawn_by_their_kind(branches):
    (axes,) = branches.plot("multipliers").axes
    assert axes.get_yscale() == "linear"
    branch = branches.branches[0]
    drawn = {
        look: [] for look in (MARKS["LP"], MARKS["PD"], MARKS["NS"]) for look in [look["color"]]
    }
    for line in axes.get_lines():
        x, y = line.get_data()
        if len(x) == len(branch):
            drawn[line.get_color()].append(np.asarray(y))
    real = branch.multipliers.imag == 0.0
    for color, which in {
        MARKS["LP"]["color"]: real & (branch.multipliers.real >= 0),
        MARKS["PD"]["color"]: real & (branch.multipliers.real < 0),
        MARKS["NS"]["color"]: ~real,
    }.items():
        values = np.stack(drawn[color], axis=-1)
        np.testing.assert_array_equal(values[which], np.abs(branch.multipliers)[which])
    for line in marks_of(axes, "PD") + marks_of(axes, "NS"):
        assert line.get_ydata()[0] == pytest.approx(1.0, abs=1e-8)


def test_an_end_before_its_time_is_told_shown_and_in_the_exit_status(tmp_path, ask, branches):
    path = tmp_path / "short.h5"
    asked = ["--along", "omega=7:7.3", "--points", "9", "-o", path]  # begins at 7
    out, err = ask("continuation", *asked, status=1)
    assert "ends: bound, long\n  long: it has more points than one branch may have" in out
    assert "; --points allows more" in out
    assert "1 branch is not complete" in err
    (axes,) = nv.plot(path, "x2").axes
    stops = [line for line in axes.get_lines() if line.get_marker() == STOPS["long"]]
    short = nv.open_archive(path).branches[0]
    assert [float(line.get_xdata()[0]) for line in stops] == [short.parameter[-1]]
    figure = nv.plot(path)
    legend = next(axes.get_legend() for axes in figure.axes if axes.get_legend())
    assert "ends: long" in [text.get_text() for text in legend.get_texts()]
    # what was asked for is complete, but seen
    assert branches.incomplete == (0, 0)
    assert "unstable" in {end for branch in branches.branches for end in branch.ends}
    legend = next(axes.get_legend() for axes in branches.plot().axes if axes.get_legend())
    assert "ends: unstable" in [text.get_text() for text in legend.get_texts()]


def test_the_page_explains_every_end():
    page = PAGE.read_text()
    for end in {**ENDS, **CURVE_ENDS}:
        assert re.search(rf"^\| `{end}` \|", page, re.MULTILINE), end


@pytest.mark.kernels
def test_curves_beside_one_of_grazing_are_seen_and_a_long_one_is_not_complete(tmp_path, ask):
    path = tmp_path / "plane.h5"
    asked = ["--along", "f=1.1:1.25", "--plane", "C=0.04:0.07", "--set", "m2=80", "--set", "C=0.05"]
    out, err = ask("continuation", *asked, "--step", "0.2", "--points", "60", "-o", path, status=1)
    assert "curve of PD, 1T: f " in out
    assert re.search(r"  PD  f = 1\.1246609\d+ Hz  T,1", out)
    assert "  long: it has more points than one curve may have; --points allows more" in out
    assert re.search(r"curves? (is|are) not complete", err)
    figure = plane_diagram(nv.open_archive(path))
    (axes,) = figure.axes
    by_color = {line.get_color(): line for line in axes.get_lines()}
    grazing, doubling = by_color[MARKS["GR"]["color"]], by_color[MARKS["PD"]["color"]]
    assert grazing.get_zorder() < doubling.get_zorder()
    assert grazing.get_linewidth() > 2 * doubling.get_linewidth()
    assert figure.texts[0].get_text().startswith("SSul NES, Set 6, $m_2$ = 80 kg: ")


def test_titles_name_what_is_set_and_the_report_has_units():
    request = nv.load_continuation("ssul-set6", {"set": {"m2": 80.0, "C": 0.05}})
    assert request.title == "SSul NES, Set 6, C = 0.05 m, m₂ = 80 kg: branches along ω"
    assert nv.load_continuation(request.document()).title == request.title
    near = {"along": {"f": {"start": 1.17, "stop": 1.18}}}
    assert nv.load_continuation("ssul-set6", near).title == "SSul NES, Set 6: branches along f"
    hertz = nv.continue_branch("ssul-set6", "f", (1.17, 1.18), step=0.1, unstable=9, quiet=True)
    lines = list(hertz.lines())
    assert "; f 1.17 to " in lines[2]
    assert lines[2].count(" Hz; ") == 1
    (row,) = hertz.special_points
    assert lines[3].startswith(f"  PD  f = {row.value / (2 * np.pi):.12g} Hz  T,1")


def test_the_rotation_number_is_that_of_sections_beside_the_torus(branches):
    """Where the pair is on the unit circle, small deviations turn by it in every n periods.

    A component y of them obeys y(k+1) - 2 cos(2 pi rho) y(k) + y(k-1) = 0, once the other
    multipliers have acted; rho follows by least squares, without any multiplier.
    """
    row = branches.special_points[branches.special_points.kind == "NS"][0]
    assert 0 < row.rotation < 0.5
    there = nv.load_system("ssul-set6", omega=row.value)
    n = int(row.periodicity)
    beside = row.state + np.array([1e-6, 0, 0, 0])
    orbit = nv.simulate(there, 300 * n, start=beside, tolerance="fine")
    y = orbit.section[n - 1 :: n, 0][60:] - row.state[0]
    middle, sums = y[1:-1], y[2:] + y[:-2]
    cosine = (middle * sums).sum() / (middle * middle).sum() / 2.0
    assert np.arccos(cosine) / (2 * np.pi) == pytest.approx(row.rotation, abs=2e-6)
    (line,) = [line for line in branches.lines() if line.startswith("  NS")][:1]
    assert line.endswith(f"rotation number {row.rotation:.8g}")
    others = branches.special_points[branches.special_points.kind != "NS"]
    assert np.isnan(others.rotation).all()
    assert (
        np.isfinite(branches.tables["rotation"]).sum()
        == (branches.special_points.kind == "NS").sum()
    )
