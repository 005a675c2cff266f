"""Pages and reports in a real browser: clicks, keys, sliders, rectangles, files, themes."""

import io
import time

import numpy as np
import pytest
from conftest import DIAGRAM, HOST_MAP, MAP, filled, made_up
from PIL import Image

from benchmarks import explore
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.engine.records import USUAL, WANTS, possible_want
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.page_state import sliders_of
from nlds_vines.model.catalog import load_system
from nlds_vines.plotting.style import HUES
from nlds_vines.portrait.request import load_portrait

pytest.importorskip("bokeh", reason="Bokeh is not installed")

pytestmark = pytest.mark.kernels  # pages follow orbits


@pytest.fixture(scope="module")
def browser():
    """Open Chromium; skip the test, with the reason, where there is none."""
    pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: no test in a browser"
    )
    if explore.browser_path() is None:
        names = ", ".join(explore.BROWSERS)
        pytest.skip(f"no browser is installed ({names}): no test in a browser")
    with explore.opened_browser() as browser:
        yield browser


def watched_page(browser, **settings):
    page = explore.new_page(browser, **settings)
    page.faults = []
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on(
        "console",
        lambda message: page.faults.append(message.text) if message.type == "error" else None,
    )
    return page


def acted(page, act):
    page.evaluate("window.drawn = undefined")
    act()
    explore.drawn(page)


def value_of(page, expression):
    """Return the value of an expression about Bokeh models, which are `m(name)`."""
    return page.evaluate(
        f"() => {{ const m = (name) => Bokeh.documents[0].get_model_by_name(name); "
        f"return {expression} }}"
    )


def place_of(page, *at):
    """Return where a point of the map or diagram, in its own coordinates, is on the screen."""
    left, top, width, height = explore.frame_of(page)
    ends = value_of(page, "[m('cells').x_range, m('cells').y_range].map((r) => [r.start, r.end])")
    (x0, x1), (y0, y1) = ends
    x, y = at
    return left + (x - x0) / (x1 - x0) * width, top + (y1 - y) / (y1 - y0) * height


def text_of(page, name):
    return page.locator(f".{name} .bk-clearfix").first.text_content() or ""


def seen_text(page):
    return page.evaluate("""() => {
        const of = (node) => node.nodeType === 3 ? node.textContent
            : ["STYLE", "SCRIPT"].includes(node.nodeName) ? ""
            : [...(node.shadowRoot?.childNodes ?? []), ...node.childNodes].map(of).join(" ")
        return of(document.body)
    }""")


def wait_for_text(page, name, words):
    page.locator(f".{name} .bk-clearfix", has_text=words).first.wait_for(state="attached")


@pytest.fixture(scope="module")
def server(small_map):
    with explore.Served(str(small_map)) as served:
        yield served
        assert served.end() == (130, "")


@pytest.fixture(scope="module")
def page(browser, server):
    page = watched_page(browser, accept_downloads=True)
    yield explore.opened_page(page, server.address)
    assert page.faults == []
    page.context.close()


@pytest.fixture
def click(page, small_map):
    axes = stored(small_map).scan.axes

    def click(*cell, page=page):
        at = [axis.values[i] for axis, i in zip(axes, cell, strict=True)]
        acted(page, lambda: page.mouse.click(*place_of(page, *at)))

    return click


def label(page):
    return page.locator(".verdict .label").text_content()


def test_clicks_keys_and_the_menu_of_starts_choose_an_orbit(page, click, small_map):
    archive = stored(small_map)
    labels, omega = archive.arrays["label"], archive.scan.axes[0].values
    for cell in ((0, 0), (4, 2), (2, 3)):
        click(*cell)
        assert label(page) == labels[(*cell, 0)]
        assert text_of(page, "trouble") == ""
    assert value_of(page, "m('history data').data.t.length") > 100
    assert "P = " in text_of(page, "readout")
    # arrow keys
    click(1, 1)
    acted(page, lambda: page.keyboard.press("ArrowRight"))
    acted(page, lambda: page.keyboard.press("ArrowUp"))
    assert text_of(page, "readout").startswith(f"ω = {omega[2]:.6g} rad/s, P = ")
    assert label(page) == labels[2, 2, 0]
    acted(page, lambda: page.keyboard.press("Shift+ArrowLeft"))
    assert text_of(page, "readout").startswith("ω = 7.3 rad/s")
    # another start
    click(4, 3)
    for name in ("random 1", "random 0"):
        acted(page, lambda name=name: page.locator("#map select").nth(1).select_option(label=name))
        assert label(page) == labels[4, 3, int(name[-1])]


def test_hovering_shows_label_and_evidence(page, small_map):
    values = stored(small_map).values_of((3, 1))
    page.mouse.move(*place_of(page, values["omega"], values["P"]))
    wait_for_text(page, "tip", "E₁max")
    assert stored(small_map).arrays["label"][3, 1, 0] in text_of(page, "tip")
    assert page.locator(".tip .bk-clearfix").is_visible()
    page.mouse.move(2, 2)
    page.locator(".tip .bk-clearfix").wait_for(state="hidden")


IMAGE = "m('cells').renderers[1].data_source.data.image[0]"


def test_every_show_is_painted(page):
    before, menu = text_of(page, "legend"), page.locator("#map select").first
    for show in ("how many regimes coexist", "energy of the structure E₁max",
                 "share of the starts in T,1", "regimes of a start"):  # fmt: skip
        menu.select_option(label=show)
        page.locator(".legend .bk-clearfix", has_text=before).wait_for(state="detached")
        codes = value_of(page, f"Array.from(new Set({IMAGE}))")
        assert codes
        assert show.startswith("how many") or 0 not in codes  # no cell is left clear
        menu.select_option(label="regimes, most frequent")
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


def test_no_field_cuts_the_digits_of_a_value(page):
    fields = page.locator("#parameters input.bk-input")
    sizes = fields.evaluate_all("all => all.map((field) => [field.scrollWidth, field.clientWidth])")
    assert len(sizes) > 10
    assert all(needed <= there for needed, there in sizes)
    values = fields.evaluate_all("all => all.map((field) => field.value)")
    assert values.count("2.1e+11") == 1  # E1 [Pa]
    assert values.count("20500000") == 1  # E2 [Pa]


def test_a_click_in_a_phase_plane_begins_there(page):
    left, top, width, height = explore.frame_of(page, "phase2")
    acted(page, lambda: page.mouse.click(left + 0.6 * width, top + 0.4 * height))
    assert "from a start of your own" in text_of(page, "verdict")


def test_a_rectangle_is_computed_finer_and_one_goes_back(page):
    start = "Bokeh.documents[0].get_model_by_name('cells').x_range.start"
    (x0, y0), (x1, y1) = place_of(page, 7.38, 766.0), place_of(page, 7.54, 834.0)
    page.mouse.move(x0, y0)
    page.mouse.down()
    page.mouse.move(x1, y1, steps=8)
    page.mouse.up()
    page.locator("button:not([disabled])", has_text="back").wait_for()
    page.locator(".progress progress").wait_for(state="detached")
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
    darkest = min(int(clear[i : i + 2], 16) for i in (1, 3, 5))
    assert darkest > 2 * 0x1A  # chaos is not far from dark
    page.locator("button", has_text="◐").click()
    assert color_in(page) == light


def test_a_second_page_of_the_same_archive_is_its_own(page, server, click):
    click(0, 0)
    words = text_of(page, "readout")
    other = page.context.new_page()
    other.set_default_timeout(60_000)
    explore.opened_page(other, server.address)
    click(5, 3, page=other)
    assert text_of(page, "readout") == words != text_of(other, "readout")
    other.close()


@pytest.mark.skipif(not explore.KNOWN.exists(), reason="no /proc tells processor times")
def test_a_browser_that_is_closed_in_a_computation_leaves_nothing(browser, folder):
    vary = {"omega": np.linspace(5.0, 8.0, 200), "P": np.linspace(9.0, 10.0, 200)}
    path = made_up({**MAP, "vary": vary}, folder / "large.h5")
    served = explore.Served(str(path))
    page = explore.opened_page(watched_page(browser), served.address)
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
    explore.opened_page(watched_page(browser), served.address).context.close()
    assert served.end() == (130, "")


@pytest.fixture
def opened(browser, tmp_path):
    """Return a function that opens the report of results offline; it may request nothing else."""
    from nlds_vines.explore.report_page import report_page  # which needs Bokeh

    pages, path = [], tmp_path / "report.html"

    def opened(results, **settings):
        path.write_text(report_page(results).html, encoding="utf-8")
        page = watched_page(browser, offline=True, **settings)
        page.asked = []
        page.on("request", lambda request: page.asked.append(request.url))
        page.goto(path.as_uri())
        page.wait_for_function("document.documentElement.dataset.ready === 'yes'")
        pages.append(page)
        return page

    yield opened
    for page in pages:
        assert page.asked == [path.as_uri()]
        assert page.faults == []
        page.context.close()


@pytest.mark.parametrize("name", ["map", "diagram"])
def test_the_report_opens_without_a_network(opened, name, request):
    archive = stored(request.getfixturevalue(f"small_{name}"))
    page, axes = opened(archive), archive.scan.axes
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


def test_a_diagram_of_two_sweeps_names_their_colors(opened, small_sweeps):
    page = opened(stored(small_sweeps))
    assert text_of(page, "legend").startswith("updown")
    page.locator("#map select").nth(1).select_option(label="down")
    wait_for_text(page, "verdict", "(down)")
    label = stored(small_sweeps).arrays["label"][4, 1]
    assert text_of(page, "verdict").startswith(f"{label} (down)")
    colors = value_of(page, "m('cells').renderers.map((r) => r.glyph?.fill_color?.value)")
    assert {HUES["blue"], HUES["vermillion"]} <= set(colors)


def test_a_dark_report_is_printed_light(opened, small_map):
    page = opened(stored(small_map), color_scheme="dark")
    assert color_in(page, "plane x1")[1] == [26, 30, 37]
    page.evaluate("addEventListener('beforeprint', () => { window.printed = "
                  "document.documentElement.dataset.theme })")  # fmt: skip
    assert len(page.pdf()) > 10_000
    assert page.evaluate("window.printed") == "light"
    assert color_in(page, "plane x1") == ["rgb(18, 21, 26)", [26, 30, 37]]


OMEGA = {"omega": {"values": [7.11, 7.22, 7.33, 7.44, 7.55]}}
AXES = {"diagram": OMEGA, "map": OMEGA | {"P": {"values": [701.0, 802.0, 903.0]}}}


def share_of_colors(page, box):
    """Return the share of pixels neither light nor gray, where a figure holds data alone."""
    clip = {"x": box["x"] + 0.6 * box["width"], "y": box["y"] + 0.05 * box["height"]}
    clip |= {"width": 0.35 * box["width"], "height": 0.65 * box["height"]}
    picture = Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB")
    pixels = np.asarray(picture).astype(int)
    return np.mean(pixels.max(-1) - pixels.min(-1) > 40)


def check_report(opened, shape, want, system="ssul-set6"):
    """Open a report with made-up numbers for all that `want` records, and choose cells."""
    scan = {**(MAP if shape == "map" else DIAGRAM), "system": system, "vary": AXES[shape]}
    scan |= {"sampling": {"transient": 3, "periods": 20}, "record": {"want": want}}
    check_page(opened, filled(scan), shape)


def check_page(opened, results, shape):
    page = opened(results)
    assert "7.33" in text_of(page, "verdict")  # the middle one is chosen
    assert results.scan.title in seen_text(page)
    boxes = filter(None, [canvas.bounding_box() for canvas in page.locator("canvas").all()])
    box = max(boxes, key=lambda box: box["width"] * box["height"])  # the map or diagram
    assert share_of_colors(page, box) > (0.15 if shape == "map" else 1e-4)
    page.mouse.click(box["x"] + 0.51 * box["width"], box["y"] + 0.45 * box["height"])
    page.keyboard.press("ArrowRight")
    page.locator(".verdict .bk-clearfix", has_text="7.44").wait_for()
    assert "NaN" not in seen_text(page)
    assert "undefined" not in seen_text(page)


SHOWN = [("diagram", [word]) for word in WANTS]
SHOWN += [("map", [word]) for word in ("section", "energy", "regime")]
SHOWN += [(shape, want) for shape in AXES for want in ([*USUAL], [*WANTS])]


@pytest.mark.parametrize(("shape", "want"), SHOWN, ids=lambda part: "-".join(part))
def test_a_report_shows_every_set_of_records(opened, shape, want):
    check_report(opened, shape, want)


@pytest.mark.parametrize("system", ["impact-oscillator", "none", "tmd"])
def test_a_report_shows_every_scene(opened, system):
    want = [*possible_want(WANTS, load_system(system).scene)]
    check_report(opened, "map", want, system)


def test_a_report_shows_a_host(opened):
    results = filled({**HOST_MAP, "vary": OMEGA | {"a.gap": [0.01, 0.02, 0.03]}})
    check_page(opened, results, "map")
