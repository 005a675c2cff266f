"""Pages of hosts: numbers of their parts, live orbits beside `simulate`, sliders, parts, files."""

import numpy as np
import pytest
from conftest import HOST_MAP, filled, host_system

pytest.importorskip("bokeh", reason="Bokeh is not installed")

from bokeh.events import SelectionGeometry, Tap
from test_page import Seen

import nlds_vines as nv
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.explore import map_view
from nlds_vines.explore.live_orbit import SAMPLES, live_orbit
from nlds_vines.explore.map_data import curves_of, stored
from nlds_vines.explore.page_state import Opened, sliders_of
from nlds_vines.explore.report_page import section_points
from nlds_vines.portrait.request import load_portrait
from nlds_vines.portrait.run import views_of

pytestmark = pytest.mark.kernels  # they follow orbits of hosts


@pytest.fixture(scope="module")
def archive(folder):
    return stored(nv.scan(HOST_MAP, to=folder / "host.h5"))


def test_a_number_of_each_damper_and_displacement_is_shown():
    results = filled(HOST_MAP)
    names = [show.name for show in map_view.shows_of(results)]
    assert {"x2.x_max", "x2-x1.x_max", "a.E2max", "b.E2max", "b.impacts_by_wall"} <= {*names}
    arrays, fill = results.arrays, results.scan.table.datasets["impacts_by_wall"].fill
    arrays["impacts_by_wall"][1, 0, 1] = fill
    counts = arrays["impacts_by_wall"][..., 1, :].sum(axis=-1).astype(np.float32)
    counts[1, 0, 1] = np.nan
    shown = map_view.column(results, "b.impacts_by_wall")
    np.testing.assert_array_equal(shown, counts.reshape(-1, 2))
    np.testing.assert_array_equal(
        map_view.column(results, "x2-x1.x_max").ravel(), arrays["x_max"][..., 1].ravel().astype("f")
    )
    # a report has the phase planes of displacements and of r of each damper
    names = [curve.names[0] for curve in results.planes]
    assert names == ["x of x2", "x of x2-x1", "r of a", "r of b"]
    states = arrays["section"].reshape(6 * 2, -1, 8)
    points = section_points(results)
    for place, expected in ((1, states[..., 3]), (5, states[..., 3] - states[..., 5])):
        np.testing.assert_array_equal(points[..., place], expected)


def test_every_cell_live_has_the_bits_of_simulate_and_the_label_of_the_archive(archive):
    for cell in np.ndindex(archive.shape):
        for k in range(2):
            system = archive.system_of(cell)
            start = archive.start_of(cell, k, system)
            live = live_orbit(system, start.state, archive.scan)
            assert live.label == archive.arrays["label"][(*cell, k)]
    record = ["trajectory", "impacts"]
    times = {"transient": 40, "samples": SAMPLES, "record": record}
    orbit = nv.simulate(system, 20, start=start.state, quiet=True, **times)
    assert live.orbit.trajectory.tobytes() == orbit.trajectory.tobytes()
    # r of each damper stays between its walls, which it touches
    history = live.panels["history"]
    for curve in curves_of(system)[1:]:
        low, high = sorted(curve.walls)
        r = history[curve.names[0]]
        assert low - 1e-12 <= r.min() <= r.max() <= high + 1e-12
    r = orbit.trajectory[:, 2] - orbit.trajectory[:, 4]
    np.testing.assert_array_equal(curves_of(system)[1].of(orbit.trajectory), r)
    touched = live.panels["touches"]
    assert list(touched) == ["phase", "a+", "a-", "b+", "b-"]


def test_clicks_sliders_planes_and_parts(archive, tmp_path):
    seen, path = Seen(Opened(archive)), tmp_path / "part.toml"
    page = seen.page
    at = archive.values_of((1, 1))
    seen.event(page.map.main, Tap, x=at["omega"], y=at["a.gap"])
    seen.settle()
    assert seen.label == archive.arrays["label"][1, 1, 0]
    assert [line.location for line in page.panels.walls[2]] == [at["a.gap"], -at["a.gap"]]
    # a click in the plane of r moves the damper alone
    before = page.orbit.orbit.trajectory[-1]
    seen.event(page.panels.planes[2][1], Tap, x=0.004, y=-0.25)
    seen.settle()
    state = np.array(page.chosen.begin.state)
    assert state[2] - state[4] == pytest.approx(0.004, abs=1e-15)
    assert state[3] - state[5] == pytest.approx(-0.25, abs=1e-15)
    np.testing.assert_array_equal(np.delete(state, [4, 5]), np.delete(before, [4, 5]))
    assert "from a start of your own" in page.verdict.text
    # a slider moves the orbit; one that the system refuses changes nothing
    page.sliders["force.x2"][2].value = 1.75
    seen.settle()
    assert page.orbit.orbit.system.parameters["force.x2"] == 1.75
    page.sliders["b.m"][2].value = -1.0
    assert "mass of b" in page.trouble.text
    # a part is computed with the sliders' values, and saved
    box = {"type": "rect", "x0": 1.9, "x1": 1.95, "y0": 0.01, "y1": 0.02}
    seen.event(page.map.main, SelectionGeometry, geometry=box, final=True)
    seen.settle(lambda page: page.job.share == 1.0 and not page.cancel.visible)
    assert (page.chosen.results.arrays["label"] != "").all()
    seen.do(page.choose, (0, 0))
    path.write_bytes(seen.file("part.toml"))
    saved = load_scan(path)
    assert saved.hash == page.chosen.scan.hash
    assert saved.system.parameters["force.x2"] == 1.75
    # the recipe is the orbit's, and draws it
    path.write_bytes(seen.file("portrait.toml"))
    request = load_portrait(path)
    assert request.hash == page.orbit.request.hash
    (view,) = views_of(request, quiet=True)
    assert view.states.tobytes() == page.orbit.orbit.trajectory.tobytes()
    page.close()


def test_there_is_a_slider_for_every_number_once():
    scan = load_scan({**HOST_MAP, "vary": {"a.gap": [0.01, 0.02]}})
    system = scan.system.with_(**{"a.gap+": 0.03})
    scan = load_scan({**HOST_MAP, "system": system, "vary": {"a.gap": [0.01, 0.02]}})
    names = [spec.name for spec in sliders_of(filled(scan.document()))]
    assert len(names) == len({*names})
    assert {*names} == {"a.gap", *host_system().parameters}


def test_modes_are_not_moved_by_a_click(error_of):
    beam = nv.beam(1.0, 65.6, 1.18).reduced(3, statics=["w20"])
    ball = nv.Damper("ball", attached_to="w20", m=0.06, walls=[nv.Wall(0.01, K=2e6)])
    system = nv.System.from_host(beam, [ball], force={"w20": 1.0}, omega=26.0)
    tip, r = curves_of(system)
    state = np.arange(1.0, 11.0)
    assert "x of w20" in error_of(tip.put, state, (0.0, 0.0))
    moved = r.put(state, (0.5, 0.25))
    assert (float(r.of(moved)), float(r.of(moved, 1))) == pytest.approx((0.5, 0.25))
    np.testing.assert_array_equal(moved[:8], state[:8])
