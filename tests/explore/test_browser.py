"""The pages in a real browser: click, keys, sliders, a rectangle, files; and without a network."""

import time

import pytest
from browsers import acted, browser_or_skip, place_of, rectangle_computed, watched_page
from conftest import MAP, made_up

from benchmarks.explore import KNOWN, Served, drawn
from nlds_vines.__main__ import main
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.explore.map_data import stored
from nlds_vines.portrait.request import load_portrait

pytest.importorskip("bokeh", reason="Bokeh is not installed")

pytestmark = pytest.mark.kernels  # pages follow orbits


@pytest.fixture(scope="module")
def browser():
    with browser_or_skip() as browser:
        yield browser


@pytest.fixture(scope="module")
def server(small_map):
    with Served(str(small_map)) as served:
        yield served
        assert served.end() == (130, "")


@pytest.fixture(scope="module")
def page(browser, server):
    page = watched_page(browser, accept_downloads=True)
    page.goto(server.address)
    drawn(page)
    yield page
    assert page.faults == []
    page.context.close()


def test_three_cells_are_clicked(page, small_map):
    labels = stored(small_map).arrays["label"]
    for cell in ((0, 0), (4, 2), (2, 3)):
        acted(page, lambda cell=cell: page.mouse.click(*place_of(page, cell)))
        assert page.text_content("#label") == labels[(*cell, 0)]
        assert page.text_content("#trouble") == ""
    assert page.evaluate("NV.model('history data').data.t.length") > 100
    assert "P = " in page.text_content("#readout")


def test_the_arrow_keys_choose_a_cell(page, small_map):
    acted(page, lambda: page.mouse.click(*place_of(page, (1, 1))))
    acted(page, lambda: page.keyboard.press("ArrowRight"))
    acted(page, lambda: page.keyboard.press("ArrowUp"))
    assert page.evaluate("NV.at.cell") == [2, 2]
    assert page.text_content("#label") == stored(small_map).arrays["label"][2, 2, 0]


def test_hovering_shows_label_and_evidence(page, small_map):
    page.mouse.move(*place_of(page, (3, 1)))
    page.wait_for_function("!document.getElementById('tip').hidden")
    text = page.text_content("#tip")
    assert stored(small_map).arrays["label"][3, 1, 0] in text
    assert "E₁max" in text


def test_another_start_is_chosen(page, small_map):
    acted(page, lambda: page.mouse.click(*place_of(page, (4, 3))))
    acted(page, lambda: page.select_option("#start", "1"))
    assert page.text_content("#label") == stored(small_map).arrays["label"][4, 3, 1]
    acted(page, lambda: page.select_option("#start", "0"))


@pytest.mark.parametrize("show", ["coexisting", "E1max", "share:T,1", "regimes of a start"])
def test_every_show_is_painted(page, show):
    page.select_option("#show", show)
    pixels = page.evaluate("Array.from(new Set(NV.model('picture').data.image[0]))")
    assert pixels
    assert 0 not in pixels  # no cell is left clear
    assert page.locator("#legend li").count() >= 1
    page.select_option("#show", "regimes")


def test_a_slider_moves_the_orbit(page):
    acted(page, lambda: page.mouse.click(*place_of(page, (0, 0))))
    before = page.evaluate("NV.model('history data').data.x1[100]")
    page.evaluate("document.getElementById('slider-C').scrollIntoView()")
    acted(page, lambda: page.fill("#slider-C", "600"))
    assert page.evaluate("NV.model('history data').data.x1[100]") != before
    assert page.locator(".slider.changed").count() == 1
    acted(page, lambda: page.click("#original"))
    assert page.evaluate("NV.model('history data').data.x1[100]") == before


def test_the_history_begins_at_the_start_where_that_is_chosen(page):
    acted(page, lambda: page.mouse.click(*place_of(page, (1, 2))))
    seen = "[NV.model('displacement').x_range.start, NV.model('displacement').x_range.end]"
    assert page.evaluate("NV.model('history data').data.t[0]") > 60
    acted(page, lambda: page.select_option("#history", "whole"))
    page.wait_for_function(f"{seen}[0] < 1")
    assert page.evaluate(seen)[1] > 70
    acted(page, lambda: page.select_option("#history", "settled"))
    page.wait_for_function(f"{seen}[0] >= 60")


def test_a_click_in_a_phase_plane_begins_there(page):
    box = page.evaluate("""() => {
        const view = Bokeh.index.find_one_by_id(NV.model("phase2").id)
        view.el.scrollIntoView({block: "center"})
        const r = view.el.getBoundingClientRect(), f = view.frame.bbox
        return [r.x + f.left + 0.6 * f.width, r.y + f.top + 0.4 * f.height]
    }""")
    acted(page, lambda: page.mouse.click(*box))
    assert page.text_content("#where") == "from a start of your own"


def test_a_rectangle_is_computed_finer_and_one_goes_back(page):
    page.evaluate("scrollTo(0, 0)")
    rectangle_computed(page, (1, 1), (3, 2))
    inside = page.evaluate("NV.at.meta.axes[0].values")
    assert 7.35 < inside[0] < inside[-1] < 7.65
    assert "0" not in {str(c) for c in page.evaluate("Array.from(NV.at.lanes.label)")}
    page.click("#back")
    page.wait_for_function("NV.at.meta.axes[0].values[0] === 7.3")
    page.click("#forward")
    page.wait_for_function("NV.at.meta.axes[0].values[0] > 7.35")
    page.click("#back")
    page.wait_for_function("NV.at.meta.axes[0].values[0] === 7.3")


def test_files_are_saved(page, tmp_path):
    page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true })")
    for what, read in (("portrait", load_portrait), ("scan", load_scan)):
        with page.expect_download() as download:
            page.click(f"[data-save={what}]")
        path = tmp_path / download.value.suggested_filename
        download.value.save_as(path)
        assert read(path).title
    with page.expect_download() as download:
        page.click("[data-save=picture]")
    path = tmp_path / "picture.png"
    download.value.save_as(path)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert "nlds-vines portrait" in page.text_content("#command")


def test_both_themes_are_there(page):
    page.click("#theme")
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    assert page.evaluate("NV.model('map').background_fill_color") == "#1a1e25"
    page.click("#theme")
    assert page.evaluate("NV.model('map').background_fill_color") == "#ffffff"


def test_a_second_page_of_the_same_archive_is_its_own(page, server):
    acted(page, lambda: page.mouse.click(*place_of(page, (0, 0))))
    label = page.text_content("#readout")
    other = page.context.new_page()
    other.set_default_timeout(60_000)
    other.goto(server.address)
    drawn(other)
    acted(other, lambda: other.mouse.click(*place_of(other, (5, 3))))
    assert page.text_content("#readout") == label != other.text_content("#readout")
    other.close()


@pytest.mark.skipif(not KNOWN.exists(), reason="no /proc tells processor times")
def test_a_browser_that_is_closed_in_a_computation_leaves_nothing(browser, folder):
    vary = {
        "omega": {"start": 5.0, "stop": 8.0, "num": 200},
        "P": {"start": 9, "stop": 10, "num": 200},
    }
    path = made_up({**MAP, "vary": vary}, folder / "large.h5")
    served = Served(str(path))
    page = watched_page(browser)
    page.goto(served.address)
    drawn(page)
    page.evaluate("EXPLORE.ask('finer', {ranges: [[7.3, 7.7], [700, 900]]})")
    page.wait_for_function("document.getElementById('progress').value > 0")
    assert page.is_visible("#cancel")
    page.context.close()
    end = time.monotonic() + 60
    used = served.processor_seconds()
    while True:  # some thirty seconds of work are left
        time.sleep(1)
        used, before = served.processor_seconds(), used
        if used - before < 0.2:
            break
        assert time.monotonic() < end, "it goes on although nobody looks"
    again = watched_page(browser)
    again.goto(served.address)
    drawn(again)
    again.context.close()
    assert served.end() == (130, "")


@pytest.fixture(scope="module", params=["map", "diagram"])
def report(request, small_map, small_diagram, folder):
    output = folder / f"{request.param}.html"
    assert main(["report", str(folder / f"{request.param}.h5"), "-o", str(output), "--quiet"]) == 0
    return request.param, output


def test_the_report_opens_without_a_network(browser, report, small_map, small_diagram):
    name, path = report
    found = stored({"map": small_map, "diagram": small_diagram}[name])
    page = watched_page(browser, offline=True)
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(path.as_uri())
    page.wait_for_function("document.documentElement.dataset.ready === 'yes'")
    page.evaluate("NV.choose(3, 0, 0)")
    cell = (3, 0, 0)[: len(found.scan.axes)]
    assert page.text_content("#label") == found.arrays["label"][(*cell, 0)]
    section = page.evaluate("NV.model('section').data.x2")
    assert section == pytest.approx(found.arrays["section"][(*cell, 0)][:, 2], abs=1e-4)
    page.keyboard.press("ArrowRight")
    cell = (4, 0)[: len(found.scan.axes)]
    assert page.text_content("#label") == found.arrays["label"][(*cell, 0)]
    assert "from 7.3 to 7.7" in page.text_content("#text")
    energy = found.arrays["E1max"][(*cell, 0)]
    assert f"{energy:.4g}" in page.text_content("#evidence")
    assert asked == [path.as_uri()]
    assert page.faults == []


def test_a_diagram_of_two_sweeps_names_their_colors(browser, small_sweeps, folder):
    path = folder / "sweeps.html"
    assert main(["report", str(small_sweeps), "-o", str(path), "--quiet"]) == 0
    page = watched_page(browser, offline=True)
    page.goto(path.as_uri())
    page.wait_for_function("document.documentElement.dataset.ready === 'yes'")
    entries = page.locator("#legend li").all_text_contents()
    assert entries[:2] == ["up", "down"]
    page.evaluate("NV.choose(5, 0, 1)")
    assert page.input_value("#start") == "1"
    assert page.text_content("#label") == stored(small_sweeps).arrays["label"][5, 1]
    assert len(set(page.evaluate("Array.from(NV.model('picture').data.image[0])"))) == 3
    assert page.faults == []


def test_a_dark_report_is_printed_light(browser, small_map, folder):
    path = folder / "printed.html"
    assert main(["report", str(small_map), "-o", str(path), "--quiet"]) == 0
    page = watched_page(browser, color_scheme="dark")
    page.goto(path.as_uri())
    page.wait_for_function("document.documentElement.dataset.ready === 'yes'")
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.evaluate("""addEventListener("beforeprint", () => {
        const {theme} = document.documentElement.dataset
        window.printed = [theme, NV.model("map").background_fill_color]
    })""")
    assert len(page.pdf()) > 10_000
    assert page.evaluate("window.printed") == ["light", "#ffffff"]
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    assert page.faults == []
