"""Edge states of a continuation beside basins: on their boundary, in report and picture."""

import numpy as np
import pytest
from planes import PLANE

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.errors import RequestError
from nlds_vines.upkeep.edge_states import edge_states

pytestmark = pytest.mark.kernels

OF_OSCILLATOR = ["--system", "impact-oscillator", "--set", "omega=1.5"]
FINER = {
    "x_0": {"start": -2.0, "stop": 1.0, "num": 60},
    "v_0": {"start": -3.0, "stop": 3.0, "num": 60},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("edges")
    nv.scan({**PLANE, "vary": FINER}, to=found / "plane.h5", quiet=True)
    along = ["--along", "P=0.35:0.7", "--from", "T,1", "-o", str(found / "branches.h5")]
    assert main(["continuation", *OF_OSCILLATOR, *along, "--quiet"]) in (0, 1)
    return found


def test_the_edge_state_divides_the_basins(folder):
    with nv.read(folder / "plane.h5") as view:
        (edge,) = edge_states(view, folder / "branches.h5")
        x, v = edge.sections[0]
        i = np.abs(view["x_0"] - x).argmin()
        column = view["attractor"][i, :, 0]
        j = np.abs(view["v_0"] - v).argmin()
    assert edge.label == "T,1"
    assert abs(edge.multiplier) > 1
    assert {0, 1} == set(column[j - 1 : j + 2].tolist())
    orbit = nv.simulate(
        nv.load_system("impact-oscillator", omega=1.5, P=0.6), 1, start=(x, v), quiet=True
    )
    assert np.allclose(orbit.section[0], [x, v], atol=1e-9)
    assert len(orbit.impacts) == 1


def test_report_and_picture_show_it(folder, answer):
    plane, branches = str(folder / "plane.h5"), str(folder / "branches.h5")
    assert "edge state T,1 of branch" in answer("basins", plane, "--edges", branches)
    figure = nv.plot(plane, marks=branches)
    texts = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert texts[-1] == "points of edge states"
    with nv.read(plane) as view:
        (edge,) = edge_states(view, branches)
    marked = [line.get_xydata()[0].tolist() for line in figure.axes[0].lines]
    assert edge.sections[0].tolist() in marked
    out = str(folder / "edges.png")
    assert main(["plot", plane, "--mark", branches, "-o", out]) == 0


def test_a_longer_orbit_has_all_its_sections():
    path = nv.continue_branch("ssul-set6", "omega", (7.75, 7.85), start="2T,1")
    edge = path.orbits_at(7.8)[0]
    assert edge.sections.shape == (2, 4)
    assert np.allclose(edge.sections[-1], edge.state, atol=1e-9)
    system = nv.load_system("ssul-set6", omega=7.8)
    orbit = nv.simulate(system, 1, start=tuple(edge.state), tolerance="fine", quiet=True)
    assert np.allclose(orbit.section[0], edge.sections[0], atol=1e-8)


def test_what_does_not_fit_is_refused(folder, tmp_path):
    branches = folder / "branches.h5"
    other = nv.scan(
        {**PLANE, "set": {"omega": 1.6, "P": 0.6}}, to=tmp_path / "other.h5", quiet=True
    )
    with nv.read(other) as view, pytest.raises(RequestError, match=r"omega = 1\.5, not 1\.6"):
        edge_states(view, branches)
    beyond = nv.scan(
        {**PLANE, "set": {"omega": 1.5, "P": 1.1}}, to=tmp_path / "beyond.h5", quiet=True
    )
    with nv.read(beyond) as view, pytest.raises(RequestError, match=r"P = 1\.1; allowed: 0\.35"):
        edge_states(view, branches)
    with pytest.raises(RequestError, match="holds a scan; in basins are marked"):
        nv.plot(other, marks=other)
    line = {**PLANE, "vary": {"v_0": PLANE["vary"]["v_0"]}}
    path = nv.scan(line, to=tmp_path / "line.h5", quiet=True)
    with pytest.raises(RequestError, match="over two initial conditions"):
        nv.plot(path, marks=branches)
    with pytest.raises(RequestError, match="holds a continuation: no orbits are marked in it"):
        nv.plot(branches, marks=branches)


def test_the_section_of_an_orbit_lies_over_the_basins(folder):
    """Of a T,1 orbit its own point, at the end of each period; of another system none."""
    plane, orbit = str(folder / "plane.h5"), str(folder / "orbit.h5")
    system = nv.load_system("impact-oscillator", omega=1.5, P=0.6)
    nv.orbit_portrait(system, to=orbit, quiet=True, windows=[(0, 40)], overwrite=True)
    section = nv.simulate(system, 40, quiet=True).section
    with nv.read(plane) as view:
        low, high = ([view[name][end] for name in view.axes] for end in (0, -1))
        known = section[((section >= low) & (section <= high)).all(axis=1)]
    assert len(known) > 30
    figure = nv.plot(plane, marks=orbit)
    texts = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert "section of an orbit" in texts
    drawn = [line.get_xydata() for line in figure.axes[0].lines]
    (dots,) = [points for points in drawn if len(points) == len(known)]
    np.testing.assert_allclose(dots, known, atol=1e-9)
    out = str(folder / "section.png")
    assert main(["plot", plane, "--mark", orbit, "-o", out, "--overwrite"]) == 0
    nv.orbit_portrait(system.with_(P=0.7), to=orbit, quiet=True, overwrite=True, windows=[(0, 4)])
    with pytest.raises(RequestError, match=r"is of another system: P = 0\.7, not 0\.6"):
        nv.plot(plane, marks=orbit)
    with pytest.raises(RequestError, match="holds a portrait, not a continuation"):
        nv.plot(orbit, marks=orbit)


def test_orbits_of_branches_are_marked_in_a_section(folder, monkeypatch):
    """Each mark is a fixed point of the section: an orbit from there comes back after a period."""
    monkeypatch.chdir(folder)
    orbit = ["portrait", *OF_OSCILLATOR, "--set", "P=0.6", "--panels", "phase1,section"]
    short = ["--transient", "200", "--periods", "20", "-o", "marked.h5", "--plot", "page.png"]
    assert main([*orbit, *short, "--quiet"]) == 0
    figure = nv.plot("marked.h5", marks="branches.h5")
    marks = [line for line in figure.axes[1].lines if line.get_marker() == "D"]
    system = nv.load_system("impact-oscillator", omega=1.5, P=0.6)
    for mark in marks:
        (start,) = mark.get_xydata().tolist()
        state = nv.simulate(system, 1, start=start, quiet=True).section[0]
        np.testing.assert_allclose(state, start, atol=1e-8)
        again = nv.simulate(system, 60, start=start, quiet=True).section[-1]
        stays = np.abs(again - start).max() < 1e-6
        assert stays == (mark.get_markerfacecolor() != "white")
    names = sorted(text.get_text() for text in figure.axes[1].texts if "T" in text.get_text())
    assert names == ["T,1", "T,1 unstable"]
    assert len(marks) == 2
    assert main(["plot", "marked.h5", "--mark", "branches.h5", "-o", "marked.png"]) == 0
    with pytest.raises(RequestError, match="is drawn in one of: section"):
        nv.plot("marked.h5", show="displacement", marks="branches.h5")
    with pytest.raises(RequestError, match="give no axes"):
        nv.plot("marked.h5", "section", ax=figure.axes[1], marks="branches.h5")
    nv.orbit_portrait("ssul-set6", to="other.h5", transient=10, periods=5, quiet=True)
    with pytest.raises(RequestError, match="is of another system"):
        nv.plot("other.h5", marks="branches.h5")
