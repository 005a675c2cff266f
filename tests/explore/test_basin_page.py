"""The page of a map over initial conditions, in a real browser."""

import pytest
from browsers import (
    acted,
    browser_or_skip,
    place_of,
    rectangle_computed,
    text_of,
    value_of,
    watched_page,
)

from benchmarks.explore import Served, opened_page
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.explore.map_data import stored
from nlds_vines.portrait.request import load_portrait

pytestmark = pytest.mark.kernels

pytest.importorskip("bokeh", reason="Bokeh is not installed")


@pytest.fixture(scope="module")
def page(small_basin):
    with browser_or_skip() as browser, Served(str(small_basin)) as served:
        page = watched_page(browser, accept_downloads=True)
        yield opened_page(page, served.address)
        assert served.end() == (130, "")
        assert page.faults == []


def clicked(page, archive, cell):
    values = archive.values_of(cell)
    acted(page, lambda: page.mouse.click(*place_of(page, values["x_0"], values["v_0"])))
    return values


@pytest.mark.parametrize("cell", [(0, 0), (7, 6), (3, 11), (12, 4), (13, 3), (13, 11)])
def test_a_click_begins_where_the_axes_say(page, small_basin, cell):
    archive = stored(small_basin)
    values = clicked(page, archive, cell)
    words = text_of(page, "verdict")
    assert f"from x_0 = {values['x_0']:g}, v_0 = {values['v_0']:g}" in words
    assert words.startswith(archive.arrays["label"][(*cell, 0)] + " ")
    assert text_of(page, "trouble") == ""


def test_a_slider_moves_the_start_alone(page, small_basin):
    archive = stored(small_basin)
    clicked(page, archive, (7, 6))
    acted(page, lambda: page.locator("#orbit select").select_option(label="the first 12 periods"))
    exact = page.locator("#parameters input").first
    acted(page, lambda: (exact.fill("0.925"), exact.press("Enter")))
    assert "from the start of the sliders" in text_of(page, "verdict")
    assert value_of(page, "m('history data').data.x1[0]") == pytest.approx(0.925, abs=0.01)
    page.locator(".files code", has_text="--start=0.925").wait_for()
    command = page.locator(".files code").text_content()
    assert "--start=0.925,0.0 " in command
    assert "--set P=0.6" in command
    acted(page, lambda: page.locator("button", has_text="as in the map").click())
    middle = archive.values_of((7, 6))["x_0"]
    assert value_of(page, "m('history data').data.x1[0]") == pytest.approx(middle, abs=0.01)


def test_a_rectangle_of_starts_is_computed_finer_and_saved(page, small_basin, tmp_path):
    rectangle_computed(page, (-1.5, -2.0), (-0.5, 0.5))
    ends = value_of(page, "[m('cells').x_range, m('cells').y_range].map((r) => [r.start, r.end])")
    assert ends == [pytest.approx([-1.5, -0.5], abs=0.06), pytest.approx([-2, 0.5], abs=0.2)]
    acted(page, lambda: page.mouse.click(*place_of(page, -1.0, -1.0)))
    assert text_of(page, "verdict")[:4] in ("T,0 ", "T,1 ")
    path = tmp_path / "saved.toml"
    for what in ("scan", "portrait"):
        with page.expect_download() as download:
            page.locator(".files a", has_text=what).click()
        download.value.save_as(path)
        if what == "scan":
            assert [axis.name for axis in load_scan(path).axes] == ["x_0", "v_0"]
            assert load_scan(path).shape == (14, 13)
        else:
            x, v = load_portrait(path).start
            assert -1.5 < x < -0.5
            assert -2 < v < 0.5
    page.locator("button", has_text="back").click()
    page.wait_for_function("Bokeh.documents[0].get_model_by_name('cells').x_range.start < -2")
