"""The page of a map over initial conditions, in a real browser."""

import pytest
from browsers import acted, browser_or_skip, place_of, rectangle_computed, watched_page

from benchmarks.explore import Served, drawn
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.explore.map_data import stored
from nlds_vines.portrait.request import load_portrait

pytestmark = pytest.mark.kernels

pytest.importorskip("bokeh", reason="Bokeh is not installed")


@pytest.fixture(scope="module")
def page(small_basin):
    with browser_or_skip() as browser, Served(str(small_basin)) as served:
        page = watched_page(browser, accept_downloads=True)
        page.goto(served.address)
        drawn(page)
        yield page
        assert served.end() == (130, "")
        assert page.faults == []


@pytest.mark.parametrize("cell", [(0, 0), (7, 6), (3, 11), (12, 4), (13, 3), (13, 11)])
def test_a_click_begins_where_the_axes_say(page, small_basin, cell):
    found = stored(small_basin)
    acted(page, lambda: page.mouse.click(*place_of(page, cell)))
    values = found.values_of(cell)
    where = f"from x_0 = {values['x_0']:g}, v_0 = {values['v_0']:g}"
    assert page.text_content("#where") == where
    assert page.text_content("#label") == found.arrays["label"][(*cell, 0)]
    assert page.text_content("#trouble") == ""


def test_a_slider_moves_the_start_alone(page, small_basin):
    acted(page, lambda: page.mouse.click(*place_of(page, (7, 6))))
    acted(page, lambda: page.select_option("#history", "short"))
    acted(page, lambda: page.fill("#slider-x_0", "900"))
    assert page.text_content("#where") == "from the start of the sliders"
    moved = -2.0 + 0.9 * 3.25
    assert page.evaluate("NV.model('history data').data.x1[0]") == pytest.approx(moved, abs=0.01)
    command = page.text_content("#command")
    assert "--start=0.925,0.0 " in command
    assert "--set P=0.6" in command
    acted(page, lambda: page.click("#original"))
    middle = stored(small_basin).values_of((7, 6))["x_0"]
    assert page.evaluate("NV.model('history data').data.x1[0]") == pytest.approx(middle, abs=0.01)


def test_a_rectangle_of_starts_is_computed_finer_and_saved(page, tmp_path):
    rectangle_computed(page, (2, 2), (6, 7))
    inside = page.evaluate("NV.at.meta.axes.map((a) => [a.values[0], a.values[a.n - 1]])")
    assert inside == [pytest.approx([-1.5, -0.5], abs=0.02), pytest.approx([-2, 0.5], abs=0.02)]
    labels = set(page.evaluate("Array.from(NV.at.lanes.label, (code) => NV.at.meta.labels[code])"))
    assert labels == {"T,0", "T,1"}
    acted(page, lambda: page.mouse.click(*place_of(page, (5, 5))))
    assert page.text_content("#label") in labels
    page.click("summary:has-text('Save')")
    path = tmp_path / "saved.toml"
    for what in ("scan", "portrait"):
        with page.expect_download() as download:
            page.click(f"[data-save={what}]")
        download.value.save_as(path)
        if what == "scan":
            assert [axis.name for axis in load_scan(path).axes] == ["x_0", "v_0"]
            assert load_scan(path).shape == (14, 13)
        else:
            x, v = load_portrait(path).start
            assert -1.5 < x < -0.5
            assert -2 < v < 0.5
    page.click("#back")
    page.wait_for_function("NV.at.meta.axes[0].values[0] === -2")
