"""Pages and reports in a real browser: clicks, keys, sliders, rectangles, files, themes."""

import io
import time

import numpy as np
import pytest
from browsers import (
    acted,
    browser_or_skip,
    place_of,
    rectangle_computed,
    seen_text,
    text_of,
    value_of,
    wait_for_text,
    watched_page,
)
from conftest import MAP, filled, made_up
from PIL import Image

from benchmarks.explore import KNOWN, Served, frame_of, opened_page
from nlds_vines.__main__ import main
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.explore.live_orbit import HISTORIES
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.page_state import sliders_of
from nlds_vines.model.catalog import load_system
from nlds_vines.orbits.records import USUAL, WANTS, possible_want
from nlds_vines.plotting.style import HUES
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
    yield opened_page(page, server.address)
    assert page.faults == []
    page.context.close()


@pytest.fixture
def click(page, small_map):
    """Return a function that clicks a cell and waits for its orbit."""
    axes = stored(small_map).scan.axes

    def click(*cell, page=page):
        at = [axis.values[i] for axis, i in zip(axes, cell, strict=True)]
        acted(page, lambda: page.mouse.click(*place_of(page, *at)))

    return click


def label(page):
    return page.locator(".verdict .label").text_content()


def test_three_cells_are_clicked(page, click, small_map):
    labels = stored(small_map).arrays["label"]
    for cell in ((0, 0), (4, 2), (2, 3)):
        click(*cell)
        assert label(page) == labels[(*cell, 0)]
        assert text_of(page, "trouble") == ""
    assert value_of(page, "m('history data').data.t.length") > 100
    assert "P = " in text_of(page, "readout")


def test_the_second_of_two_quick_clicks_counts(page, small_map):
    archive = stored(small_map)
    at = [place_of(page, archive.scan.axes[0].values[i], 800.0) for i in (1, 2)]
    page.mouse.click(*at[0])
    page.mouse.click(*at[1])
    wait_for_text(page, "readout", f"ω = {archive.scan.axes[0].values[2]:.6g}")


def test_the_arrow_keys_choose_a_cell(page, click, small_map):
    click(1, 1)
    acted(page, lambda: page.keyboard.press("ArrowRight"))
    acted(page, lambda: page.keyboard.press("ArrowUp"))
    values = stored(small_map).values_of((2, 2))
    assert text_of(page, "readout").startswith(f"ω = {values['omega']:.6g} rad/s, P = ")
    assert label(page) == stored(small_map).arrays["label"][2, 2, 0]
    acted(page, lambda: page.keyboard.press("Shift+ArrowLeft"))
    assert text_of(page, "readout").startswith("ω = 7.3 rad/s")


def test_hovering_shows_label_and_evidence(page, small_map):
    values = stored(small_map).values_of((3, 1))
    page.mouse.move(*place_of(page, values["omega"], values["P"]))
    wait_for_text(page, "tip", "E₁max")
    assert stored(small_map).arrays["label"][3, 1, 0] in text_of(page, "tip")
    assert page.locator(".tip .bk-clearfix").is_visible()
    page.mouse.move(2, 2)
    page.locator(".tip .bk-clearfix").wait_for(state="hidden")


def test_another_start_is_chosen(page, click, small_map):
    click(4, 3)
    start = page.locator("#map select").nth(1)
    acted(page, lambda: start.select_option(label="random 1"))
    assert label(page) == stored(small_map).arrays["label"][4, 3, 1]
    acted(page, lambda: start.select_option(label="random 0"))


IMAGE = "m('cells').renderers[1].data_source.data.image[0]"


@pytest.mark.parametrize(
    "show",
    [
        "how many regimes coexist", "energy of the structure E₁max", "share of the starts in T,1",
        "regimes of a start",
    ],
)  # fmt: skip
def test_every_show_is_painted(page, show):
    before = text_of(page, "legend")
    page.locator("#map select").first.select_option(label=show)
    page.locator(".legend .bk-clearfix", has_text=before).wait_for(state="detached")
    codes = value_of(page, f"Array.from(new Set({IMAGE}))")
    assert codes
    assert show.startswith("how many") or 0 not in codes  # no cell is left clear
    page.locator("#map select").first.select_option(label="regimes, most frequent")
    wait_for_text(page, "legend", before)


def test_a_slider_moves_the_orbit(page, click, small_map):
    click(0, 0)
    state = "m('history data').data.x1[100]"
    before = value_of(page, state)
    place = [spec.name for spec in sliders_of(stored(small_map))].index("C")
    exact = page.locator("#parameters input").nth(place)
    handle = page.locator("#parameters .noUi-handle").nth(place)
    acted(page, lambda: handle.press("ArrowRight"))
    assert value_of(page, state) != before
    assert float(exact.input_value()) != pytest.approx(0.06233)
    assert page.locator(".bk-Slider.changed").count() == 1
    acted(page, lambda: page.locator("button", has_text="as in the map").click())
    assert value_of(page, state) == before
    page.keyboard.press("Escape")


def test_the_history_begins_at_the_start_if_that_is_chosen(page, click):
    click(1, 2)
    history, seen = page.locator("#orbit select"), "m('displacement').x_range"
    assert value_of(page, "m('history data').data.t[0]") > 60
    acted(page, lambda: history.select_option(label=HISTORIES["whole"]))
    assert value_of(page, f"{seen}.start") == 0
    assert value_of(page, f"{seen}.end") > 70
    acted(page, lambda: history.select_option(label=HISTORIES["settled"]))
    assert value_of(page, f"{seen}.start") == 60


def test_a_click_in_a_phase_plane_begins_there(page):
    left, top, width, height = frame_of(page, "phase2")
    acted(page, lambda: page.mouse.click(left + 0.6 * width, top + 0.4 * height))
    assert "from a start of your own" in text_of(page, "verdict")


def test_a_rectangle_is_computed_finer_and_one_goes_back(page):
    start = "Bokeh.documents[0].get_model_by_name('cells').x_range.start"
    rectangle_computed(page, (7.38, 766.0), (7.54, 834.0))
    assert 7.3 < page.evaluate(start) < 7.4
    assert 0 not in value_of(page, f"Array.from({IMAGE})")
    page.locator("button", has_text="back").click()
    page.wait_for_function(f"{start} < 7.3")
    page.locator("button", has_text="forward").click()
    page.wait_for_function(f"{start} > 7.3")
    page.locator("button", has_text="back").click()
    page.wait_for_function(f"{start} < 7.3")


def test_files_are_saved(page, tmp_path):
    path = tmp_path / "saved"
    for what, read in (("portrait", load_portrait), ("scan", load_scan)):
        with page.expect_download() as download:
            page.locator(".files a", has_text=what).click()
        download.value.save_as(path)
        assert read(path).title
    page.locator("button", has_text="as a picture").click()
    with page.expect_download() as download:
        page.locator(".files a", has_text="picture").click()
    download.value.save_as(path)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert "nlds-vines portrait" in page.locator(".files code").text_content()


def color_in(page, name="displacement", right=5):
    """Return the color of the page and that of a figure, pixels to the `right` of its left axis."""
    return page.evaluate(
        """([name, right]) => {
        const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name(name).id)
        const canvas = view.canvas_view.primary.canvas, at = view.frame.bbox
        const ratio = canvas.width / view.bbox.width
        const pixel = canvas.getContext("2d").getImageData(
            ratio * (at.left + right), ratio * (at.top + 3), 1, 1).data
        return [getComputedStyle(document.body).backgroundColor, [...pixel].slice(0, 3)]
    }""",
        [name, right],
    )


def test_both_themes_are_there(page):
    light, dark = ["rgb(247, 246, 242)", [255, 255, 255]], ["rgb(18, 21, 26)", [26, 30, 37]]
    assert color_in(page) == light
    page.locator("button", has_text="◐").click()
    assert color_in(page) == color_in(page, "cells", -20) == dark
    clear = page.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--empty')")
    assert (
        min(int(clear[i : i + 2], 16) for i in (1, 3, 5)) > 2 * 0x1A
    )  # chaos is not far from dark
    page.locator("button", has_text="◐").click()
    assert color_in(page) == light


def test_a_second_page_of_the_same_archive_is_its_own(page, server, click):
    click(0, 0)
    words = text_of(page, "readout")
    other = page.context.new_page()
    other.set_default_timeout(60_000)
    opened_page(other, server.address)
    click(5, 3, page=other)
    assert text_of(page, "readout") == words != text_of(other, "readout")
    other.close()


@pytest.mark.skipif(not KNOWN.exists(), reason="no /proc tells processor times")
def test_a_browser_that_is_closed_in_a_computation_leaves_nothing(browser, folder):
    P = {"start": 9, "stop": 10, "num": 200}
    vary = {"omega": {"start": 5.0, "stop": 8.0, "num": 200}, "P": P}
    path = made_up({**MAP, "vary": vary}, folder / "large.h5")
    served = Served(str(path))
    page = opened_page(watched_page(browser), served.address)
    page.locator("button", has_text="seen finer").click()
    page.locator(".progress progress").wait_for()
    assert page.locator("button", has_text="cancel").is_visible()
    page.context.close()
    end = time.monotonic() + 60
    used = served.processor_seconds()
    while True:  # some thirty seconds of work are left
        time.sleep(1)
        used, before = served.processor_seconds(), used
        if used - before < 0.2:
            break
        assert time.monotonic() < end, "it goes on although nobody looks"
    opened_page(watched_page(browser), served.address).context.close()
    assert served.end() == (130, "")


@pytest.fixture(scope="module", params=["map", "diagram"])
def report(request, small_map, small_diagram, folder):
    output = folder / f"{request.param}.html"
    assert main(["report", str(folder / f"{request.param}.h5"), "-o", str(output), "--quiet"]) == 0
    return request.param, output


@pytest.fixture
def opened(browser):
    """Return a function that opens a report offline; it may request nothing else."""
    pages = []

    def opened(path, **settings):
        page = watched_page(browser, offline=True, **settings)
        page.asked = []
        page.on("request", lambda request: page.asked.append(request.url))
        page.goto(path.as_uri())
        page.wait_for_function("document.documentElement.dataset.ready === 'yes'")
        pages.append((page, path))
        return page

    yield opened
    for page, path in pages:
        assert page.asked == [path.as_uri()]
        assert page.faults == []
        page.context.close()


def test_the_report_opens_without_a_network(opened, report, small_map, small_diagram):
    name, path = report
    archive = stored({"map": small_map, "diagram": small_diagram}[name])
    page, axes = opened(path), archive.scan.axes
    low, high = value_of(page, "[m('cells').y_range.start, m('cells').y_range.end]")
    y = axes[1].values[0] if len(axes) == 2 else (low + high) / 2
    page.mouse.click(*place_of(page, axes[0].values[3], y))
    cell = (3, 0)[: len(axes)]
    wait_for_text(page, "verdict", f"ω = {axes[0].values[3]:.6g}")
    assert text_of(page, "verdict").startswith(archive.arrays["label"][(*cell, 0)])
    section = value_of(page, "m('section').data.x2")
    assert section == pytest.approx(archive.arrays["section"][(*cell, 0)][:, 2], abs=1e-4)
    page.keyboard.press("ArrowRight")
    cell = (4, 0)[: len(axes)]
    wait_for_text(page, "verdict", f"ω = {axes[0].values[4]:.6g}")
    assert text_of(page, "verdict").startswith(archive.arrays["label"][(*cell, 0)])
    assert f"{archive.arrays['E1max'][(*cell, 0)]:.4g}" in text_of(page, "verdict")
    page.mouse.move(*place_of(page, axes[0].values[1], y))
    wait_for_text(page, "tip", f"ω = {axes[0].values[1]:.6g}")
    before = text_of(page, "legend")
    page.locator("#map select").first.select_option(label="energy of the structure E₁max")
    if name == "map":
        page.locator(".legend .bk-clearfix", has_text=before).wait_for(state="detached")
        assert text_of(page, "legend").endswith("J")


def test_a_diagram_of_two_sweeps_names_their_colors(opened, small_sweeps, folder):
    path = folder / "sweeps.html"
    assert main(["report", str(small_sweeps), "-o", str(path), "--quiet"]) == 0
    page = opened(path)
    assert text_of(page, "legend").startswith("updown")
    page.locator("#map select").nth(1).select_option(label="down")
    wait_for_text(page, "verdict", "(down)")
    label = stored(small_sweeps).arrays["label"][4, 1]
    assert text_of(page, "verdict").startswith(f"{label} (down)")
    colors = value_of(
        page, "m('cells').renderers.map((r) => r.glyph?.fill_color?.value).filter((c) => c)"
    )
    assert {HUES["blue"], HUES["vermillion"]} <= set(colors)


def test_a_dark_report_is_printed_light(opened, small_map, folder):
    path = folder / "printed.html"
    assert main(["report", str(small_map), "-o", str(path), "--quiet"]) == 0
    page = opened(path, color_scheme="dark")
    assert color_in(page, "plane x1")[1] == [26, 30, 37]
    page.evaluate("addEventListener('beforeprint', () => { window.printed = "
                  "document.documentElement.dataset.theme })")  # fmt: skip
    assert len(page.pdf()) > 10_000
    assert page.evaluate("window.printed") == "light"
    assert color_in(page, "plane x1") == ["rgb(18, 21, 26)", [26, 30, 37]]


@pytest.fixture(scope="module")
def basin(browser, small_basin):
    with Served(str(small_basin)) as served:
        basin = watched_page(browser, accept_downloads=True)
        yield opened_page(basin, served.address)
        assert served.end() == (130, "")
        assert basin.faults == []
        basin.context.close()


def clicked(basin, archive, cell):
    values = archive.values_of(cell)
    acted(basin, lambda: basin.mouse.click(*place_of(basin, values["x_0"], values["v_0"])))
    return values


@pytest.mark.parametrize("cell", [(0, 0), (7, 6), (3, 11), (12, 4), (13, 3), (13, 11)])
def test_a_click_begins_where_the_axes_say(basin, small_basin, cell):
    archive = stored(small_basin)
    values = clicked(basin, archive, cell)
    words = text_of(basin, "verdict")
    assert f"from x_0 = {values['x_0']:g}, v_0 = {values['v_0']:g}" in words
    assert words.startswith(archive.arrays["label"][(*cell, 0)] + " ")
    assert text_of(basin, "trouble") == ""


def test_a_slider_moves_the_start_alone(basin, small_basin):
    archive = stored(small_basin)
    clicked(basin, archive, (7, 6))
    acted(basin, lambda: basin.locator("#orbit select").select_option(label="the first 12 periods"))
    exact = basin.locator("#parameters input").first
    acted(basin, lambda: (exact.fill("0.925"), exact.press("Enter")))
    assert "from the start of the sliders" in text_of(basin, "verdict")
    assert value_of(basin, "m('history data').data.x1[0]") == pytest.approx(0.925, abs=0.01)
    basin.locator(".files code", has_text="--start=0.925").wait_for()
    command = basin.locator(".files code").text_content()
    assert "--start=0.925,0.0 " in command
    assert "--set P=0.6" in command
    acted(basin, lambda: basin.locator("button", has_text="as in the map").click())
    middle = archive.values_of((7, 6))["x_0"]
    assert value_of(basin, "m('history data').data.x1[0]") == pytest.approx(middle, abs=0.01)


def test_a_rectangle_of_starts_is_computed_finer_and_saved(basin, small_basin, tmp_path):
    rectangle_computed(basin, (-1.5, -2.0), (-0.5, 0.5))
    ends = value_of(basin, "[m('cells').x_range, m('cells').y_range].map((r) => [r.start, r.end])")
    assert ends == [pytest.approx([-1.5, -0.5], abs=0.06), pytest.approx([-2, 0.5], abs=0.2)]
    acted(basin, lambda: basin.mouse.click(*place_of(basin, -1.0, -1.0)))
    assert text_of(basin, "verdict")[:4] in ("T,0 ", "T,1 ")
    path = tmp_path / "saved.toml"
    for what in ("scan", "portrait"):
        with basin.expect_download() as download:
            basin.locator(".files a", has_text=what).click()
        download.value.save_as(path)
        if what == "scan":
            assert [axis.name for axis in load_scan(path).axes] == ["x_0", "v_0"]
            assert load_scan(path).shape == (14, 13)
        else:
            x, v = load_portrait(path).start
            assert -1.5 < x < -0.5
            assert -2 < v < 0.5
    basin.locator("button", has_text="back").click()
    basin.wait_for_function("Bokeh.documents[0].get_model_by_name('cells').x_range.start < -2")


OMEGA = {"omega": {"values": [7.11, 7.22, 7.33, 7.44, 7.55]}}
AXES = {"diagram": OMEGA, "map": OMEGA | {"P": {"values": [701.0, 802.0, 903.0]}}}

BEYOND_CENTER = np.s_[0.05:0.7, 0.6:0.95]
"""Height and width of a figure that hold data alone: no axis, no label, not the chosen cell."""


def made_up_records(shape, want, system="ssul-set6"):
    """Return a scan with made-up numbers for all that `want` records."""
    start = {"policy": "rest"} if shape == "diagram" else {"policy": "random", "count": 2}
    return filled(
        {
            "title": "a report", "system": system, "vary": AXES[shape], "start": start,
            "sampling": {"transient": 3, "periods": 20}, "record": {"want": want},
        }
    )  # fmt: skip


def largest_figure(page):
    """Return the box of the largest canvas that is seen: the map or diagram."""
    boxes = [canvas.bounding_box() for canvas in page.locator("canvas").all()]
    return max(filter(None, boxes), key=lambda box: box["width"] * box["height"])


def share_of_colors(page, box):
    """Return the share of a figure's `BEYOND_CENTER` that is neither light nor gray."""
    picture = Image.open(io.BytesIO(page.screenshot(clip=box))).convert("RGB")
    pixels = np.asarray(picture).astype(int)
    rows, columns = (
        slice(*(int(end * size) for end in (part.start, part.stop)))
        for part, size in zip(BEYOND_CENTER, pixels.shape[:2], strict=True)
    )
    part = pixels[rows, columns]
    return np.mean(part.max(-1) - part.min(-1) > 40)


def check_report(browser, folder, results):
    """Open the report of results, choose cells, and check what is seen."""
    from nlds_vines.explore.report_page import report_page  # which needs Bokeh

    path = folder / "page.html"
    path.write_text(report_page(results).html, encoding="utf-8")
    page = watched_page(browser)
    page.goto(path.as_uri())
    page.wait_for_function("document.documentElement.dataset.ready === 'yes'")
    assert "7.33" in text_of(page, "verdict")  # the middle one is chosen
    assert "a report" in seen_text(page)
    box = largest_figure(page)
    assert share_of_colors(page, box) > (0.15 if len(results.scan.axes) == 2 else 1e-4)
    page.mouse.click(box["x"] + 0.51 * box["width"], box["y"] + 0.45 * box["height"])
    page.keyboard.press("ArrowRight")
    page.locator(".verdict .bk-clearfix", has_text="7.44").wait_for()
    assert "NaN" not in seen_text(page)
    assert "undefined" not in seen_text(page)
    assert page.faults == []
    page.context.close()


@pytest.mark.parametrize("shape", AXES)
@pytest.mark.parametrize("want", [[word] for word in WANTS] + [[*USUAL], [*WANTS]], ids="-".join)
def test_a_report_shows_every_set_of_records(browser, tmp_path, want, shape):
    check_report(browser, tmp_path, made_up_records(shape, want))


@pytest.mark.parametrize("system", ["impact-oscillator", "none", "tmd"])
def test_a_report_shows_every_scene(browser, tmp_path, system):
    want = [*possible_want(WANTS, load_system(system).scene)]
    check_report(browser, tmp_path, made_up_records("map", want, system))
