"""Pages without a browser: widgets, what is shown, what ends; the page without a server."""

import json
import re
import threading
import time
from base64 import b64decode
from collections import deque
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("bokeh", reason="Bokeh is not installed")

from bokeh.core.serialization import Deserializer
from bokeh.document import Document
from bokeh.events import DoubleTap, MouseMove, RangesUpdate, SelectionGeometry, Tap
from conftest import DIAGRAM, MAP, filled, made_up

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.errors import RequestError
from nlds_vines.explore import live_page as page_module
from nlds_vines.explore.live_page import Page
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.map_view import column, label_codes, painted, shows_of
from nlds_vines.explore.page_state import LOADING, READY, Opened
from nlds_vines.explore.report_page import MOST_BYTES, coded, report_page, rounded
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.plotting.palette import short
from nlds_vines.portrait.request import load_portrait
from nlds_vines.runs.progress import Notice, notice


class Seen:
    """A page whose browser is this test."""

    def __init__(self, opened):
        self.document = Document()
        self.calls = deque()  # in their order, as the loop of a server has them
        self.document.add_next_tick_callback = self.calls.append
        self.page = Page(self.document, opened)

    def do(self, call, *arguments):
        """Do what a callback does, and wait until its orbit is shown."""
        self.page.guarded(call, *arguments)
        self.settle()

    def event(self, model, kind, **values):
        model._trigger_event(kind(model, **values))

    def settle(self, until=None, seconds=60.0):
        """Run what threads have left for the document until a condition holds."""
        if until is None:
            followed = threading.Event()
            self.page.opened.aside(followed.set)
            until = lambda page: followed.is_set() and not self.calls  # noqa: E731
        end = time.monotonic() + seconds
        while not until(self.page) or self.calls:
            while self.calls:
                self.calls.popleft()()
            assert time.monotonic() < end, (self.page.trouble.text, self.page.progress.text)
            time.sleep(0.005)

    @property
    def label(self):
        return re.search('class="label">(.*?)<', self.page.verdict.text)[1]

    def file(self, name):
        code = re.search(f'download="{name}" href="data:[^,]*,([^"]*)"', self.page.files.text)[1]
        return b64decode(code)


@pytest.fixture
def seen(small_map):
    seen = Seen(Opened(stored(small_map)))
    seen.settle()
    yield seen
    seen.page.close()


@pytest.mark.kernels
def test_a_click_shows_the_orbit_of_the_cell_and_of_many_the_last_one(seen, small_map):
    archive, page = stored(small_map), seen.page
    page.start.value = "1"
    for cell, kind in (((0, 0), Tap), ((5, 3), DoubleTap), ((3, 2), Tap)):
        at = [axis.values[i] for axis, i in zip(archive.scan.axes, cell, strict=True)]
        seen.event(page.map.main, kind, x=at[0], y=at[1])
        seen.settle()
        assert seen.label == archive.arrays["label"][(*cell, 1)]
        assert page.sliders["omega"][2].value == pytest.approx(archive.values_of(cell)["omega"])
        assert page.map.mark.data == {"x": [at[0]], "y": [at[1]]}
        assert page.trouble.text == ""
    before = page.asked
    for i in range(20):
        page.choose((i % 6, 0))
    seen.settle()
    assert seen.label == archive.arrays["label"][1, 0, 1]
    assert page.asked == before + 20


@pytest.mark.kernels
def test_a_slider_moves_the_orbit_and_a_refused_one_nothing(seen):
    page = seen.page
    seen.do(page.choose, (2, 2))
    _, slider, exact = page.sliders["P"]
    exact.value = 333.0
    seen.settle()
    assert page.orbit.orbit.system.parameters["P"] == 333.0
    slider.value = 712.34
    seen.settle()
    assert page.orbit.orbit.system.parameters["P"] == 712.34
    page.sliders["m1"][2].value = -1.0
    assert "m1" in page.trouble.text
    assert page.sliders["m1"][2].value > 0
    assert page.sliders["m1"][1].css_classes == []
    page.sliders["C"][2].value = 0.05
    assert page.sliders["C"][1].css_classes == ["changed"]
    seen.do(page.take_original)
    original = page.chosen.results.values_of((2, 2))["P"]
    assert page.orbit.orbit.system.parameters["P"] == original
    assert page.sliders["C"][1].css_classes == []


@pytest.mark.kernels
def test_planes_begin_orbits_and_histories_from_the_start_last(seen):
    seen.event(seen.page.panels.planes[1][1], Tap, x=0.3, y=-0.25)
    seen.settle()
    assert seen.page.orbit.request.start[2:] == (0.3, -0.25)
    assert "from a start of your own" in seen.page.verdict.text
    # a history from the start is shown until another is chosen
    times = lambda: seen.page.panels.sources["history"].data["t"]  # noqa: E731
    seen.page.history.value = "whole"
    seen.settle()
    assert times()[0] < 1
    assert times()[-1] > 60
    seen.do(seen.page.choose, (1, 1))
    assert times()[0] < 1
    assert seen.page.panels.time.start == 0
    seen.page.history.value = "settled"
    seen.settle()
    assert times()[0] > 60
    assert seen.page.panels.time.start == 60


@pytest.mark.kernels
def test_a_rectangle_is_computed_and_one_can_go_back(seen):
    page = seen.page
    before = page.map.picture.source.data["image"][0]
    box = {"type": "rect", "x0": 7.5, "x1": 7.4, "y0": 800.0, "y1": 850.0}
    seen.event(page.map.main, SelectionGeometry, geometry=box, final=False)
    assert page.job is None
    seen.event(page.map.main, SelectionGeometry, geometry=box, final=True)
    assert page.map.beneath.source.data["image"][0] is before
    seen.settle(lambda page: page.job.share == 1.0 and not page.cancel.visible)
    assert page.chosen.scan.axes[0].values[0] == 7.4
    assert (page.chosen.results.arrays["label"] != "").all()
    assert page.map.picture.source.data["image"][0].min() > 0
    page.step(-1)
    assert page.chosen.scan.axes[0].values[0] == 7.3
    assert (page.back.disabled, page.forward.disabled) == (True, False)
    page.step(1)
    assert page.chosen.scan.axes[0].values[0] == 7.4


@pytest.mark.kernels
def test_a_map_of_starts_is_clicked_slid_along_computed_finer_and_saved(small_basin, tmp_path):
    archive, path = stored(small_basin), tmp_path / "saved.toml"
    seen = Seen(Opened(archive))
    page = seen.page
    for cell in ((0, 0), (3, 11), (12, 4), (13, 3), (13, 11), (7, 6)):
        x, v = archive.values_of(cell).values()
        seen.event(page.map.main, Tap, x=x, y=v)
        seen.settle()
        assert f"from x_0 = {x:g}, v_0 = {v:g}" in page.verdict.text
        assert seen.label == archive.arrays["label"][(*cell, 0)]
        assert page.trouble.text == ""
    # a slider moves the start alone
    page.history.value = "short"
    page.sliders["x_0"][2].value = 0.925
    seen.settle()
    assert "from the start of the sliders" in page.verdict.text
    first = lambda: page.panels.sources["history"].data["x"][0]  # noqa: E731
    assert first() == pytest.approx(0.925, abs=0.01)
    assert "--start=0.925,0.0 " in page.files.text
    assert "--set P=0.6" in page.files.text
    seen.do(page.take_original)
    assert first() == pytest.approx(archive.values_of((7, 6))["x_0"], abs=0.01)
    # a rectangle is computed finer and saved
    box = {"type": "rect", "x0": -1.5, "x1": -0.5, "y0": -2.0, "y1": 0.5}
    seen.event(page.map.main, SelectionGeometry, geometry=box, final=True)
    seen.settle(lambda page: page.job.share == 1.0 and not page.cancel.visible)
    ends = [axis.values[[0, -1]].tolist() for axis in page.chosen.scan.axes]
    assert ends == [[-1.5, -0.5], [-2.0, 0.5]]
    seen.event(page.map.main, Tap, x=-1.0, y=-1.0)
    seen.settle()
    assert seen.label in ("T,0", "T,1")
    path.write_bytes(seen.file("part.toml"))
    assert [axis.name for axis in load_scan(path).axes] == ["x_0", "v_0"]
    assert load_scan(path).shape == (14, 13)
    path.write_bytes(seen.file("portrait.toml"))
    assert load_portrait(path).start == pytest.approx((-1.0, -1.0), abs=0.1)
    page.step(-1)
    assert page.chosen.scan.axes[0].values[0] == -2.0
    page.close()


def test_what_a_callback_raises_is_shown_in_one_line(seen, monkeypatch):
    def fails(*_):
        raise ZeroDivisionError("a <b>fault</b>\nof two lines")

    monkeypatch.setattr(page_module.map_view, "painted", fails)
    seen.page.show.value = "E1max"
    text = seen.page.trouble.text
    assert text.startswith("ZeroDivisionError: a &lt;b&gt;fault")
    assert "\n" not in text
    monkeypatch.setattr("nlds_vines.explore.live_orbit.live_orbit", fails)
    seen.do(seen.page.choose, (1, 1))
    assert "ZeroDivisionError" in seen.page.trouble.text

    def stuck(*_, **__):
        raise RequestError("it stuck to the wall")

    monkeypatch.setattr("nlds_vines.explore.live_orbit.live_orbit", stuck)
    seen.do(seen.page.choose, (1, 2))
    assert seen.page.trouble.text == "it stuck to the wall"
    # nothing of the orbit before remains
    assert seen.label == "no orbit"
    sources = seen.page.panels.sources.values()
    assert not any(len(values) for source in sources for values in source.data.values())


def test_a_closed_page_leaves_nothing_running(small_map, monkeypatch):
    monkeypatch.setattr("nlds_vines.bifurcation.blocks.BLOCK_PERIODS", 1)
    opened = Opened(stored(small_map))
    page = Seen(opened).page
    page.refine((7.4, 7.5), (800.0, 850.0))
    job = page.job
    assert not job.cancelled
    page.close()
    assert job.cancelled
    job.join(60.0)
    assert not job.is_alive()
    assert opened.listeners == []
    assert not [t for t in threading.enumerate() if t.name == "refining"]


def test_an_orbit_under_way_does_not_hold_up_the_end(small_map, monkeypatch):
    begun, gone_on = threading.Event(), threading.Event()

    def lasts(*_):
        begun.set()
        gone_on.wait(60)

    monkeypatch.setattr("nlds_vines.explore.live_orbit.live_orbit", lasts)
    opened = Opened(stored(small_map))
    page = Seen(opened).page
    assert begun.wait(60)
    assert not opened.close()  # the command then ends without waiting
    assert all(t.daemon for t in threading.enumerate() if t.name == "orbits")
    gone_on.set()
    page.close()


@pytest.mark.kernels
def test_what_is_saved_is_what_is_seen(seen, tmp_path):
    page, path = seen.page, tmp_path / "saved.toml"
    page.start.value = "1"
    seen.do(page.choose, (1, 2))
    path.write_bytes(seen.file("portrait.toml"))
    assert load_portrait(path).start == page.orbit.request.start
    page.sliders["C"][2].value = 0.05
    seen.settle()
    path.write_bytes(seen.file("part.toml"))
    assert load_scan(path).system.parameters["C"] == 0.05
    assert load_scan(path).shape == (6, 4)
    assert "nlds-vines portrait --system ssul-set6" in page.files.text
    page.draw()
    seen.settle(lambda page: "portrait.png" in page.files.text)
    assert seen.file("portrait.png").startswith(b"\x89PNG")


def test_the_page_says_what_the_kernels_do(small_map, monkeypatch):
    opened = Opened(stored(small_map))
    seen = Seen(opened)
    assert seen.page.state.text == LOADING
    states = []

    def orbit(*_):
        tell = notice()
        for words in ("compiling: about 30 s", "compiling: about 23 s to go", ""):
            tell(words, 7.3)
            seen.settle(lambda _: not seen.calls)
            states.append(seen.page.state.text)

    monkeypatch.setattr("nlds_vines.explore.page_state.live_orbit", orbit)
    opened._warm()
    assert states == ["compiling: about 30 s", "compiling: about 23 s to go", LOADING]
    seen.settle()
    assert seen.page.state.text == ""
    assert isinstance(notice(), Notice)
    seen.page.close()


def test_a_scan_is_computed_while_it_is_seen(small_diagram):
    opened = Opened(stored(small_diagram).scan)
    seen = Seen(opened)
    opened.begin()
    seen.settle(
        lambda _: opened.job.share == 1.0 and opened.kernels == READY and not opened.job.is_alive()
    )
    seen.settle()
    for label in stored(small_diagram).arrays["label"].ravel():
        assert short(label) in seen.page.legend.text
    assert opened.close()
    seen.page.close()


@pytest.fixture
def computing_nothing(monkeypatch):
    monkeypatch.setattr("nlds_vines.explore.page_state.Refining.start", lambda _: None)
    monkeypatch.setattr("nlds_vines.explore.live_orbit.live_orbit", lambda *_: 1 / 0)


@pytest.fixture
def idle(tmp_path, computing_nothing):
    seen = Seen(Opened(stored(made_up(MAP, tmp_path / "map.h5"))))
    seen.settle()
    yield seen
    seen.page.close()


def test_the_pointer_and_the_chosen_cell_are_told_in_words(idle):
    page, main = idle.page, idle.page.map.main
    idle.event(main, MouseMove, x=7.3, y=700.0, sx=90, sy=30)
    assert page.tip.visible
    assert "undetermined (random 0)" in page.tip.text
    assert "ω = 7.3 rad/s, P = 700 N" in page.tip.text
    assert page.tip.text.count("<br>") <= 2  # a box of three lines hides little of the map
    assert page.tip.styles["left"] == "90px"
    idle.event(main, MouseMove, x=1.0, y=700.0, sx=0, sy=30)
    assert not page.tip.visible
    # for those who cannot see the map: values, label and numbers, in a line that is read out
    page.press("-9 9 1")
    words = page.readout.text
    assert words.startswith("ω = 7.3 rad/s, P = 900 N; undetermined (random 0); all starts: ")
    page.press("1 0 2")
    assert page.readout.text.startswith("ω = 7.38 rad/s, P = 900 N")
    words = "Map over angular frequency of the force, ω, from 7.3 to 7.7 rad/s in 6 cells and "
    assert page.described.text.startswith(words)
    assert "undetermined: 100.0% of the cells" in page.described.text
    assert ".unseen { position: absolute" in page_module.figures.page_file("look.css")
    assert page.map.main.html_attributes["role"] == "img"
    assert "arrow keys" in page.map.main.html_attributes["aria-label"]
    assert 'aria-live="polite"' in page_module.figures.page_file("frame.html")


HERTZ = {**DIAGRAM, "vary": {"f": {"start": 1.1, "stop": 1.3, "num": 9}}}


@pytest.mark.parametrize(
    ("document", "unit", "name", "one"),
    [(HERTZ, None, "f", 2 * np.pi), (MAP, "Hz", "f", 2 * np.pi),
     (MAP, "ratio", "omega_ratio", np.sqrt(39.5)), (HERTZ, "rad/s", "omega", 1.0)],
)  # fmt: skip
@pytest.mark.usefixtures("computing_nothing")
def test_a_page_has_one_unit_of_the_frequency(document, unit, name, one, tmp_path):
    """Axes, clicks, words, fields and parts have it; systems and requests have rad/s."""
    archive = stored(made_up(document, tmp_path / "a.h5"), unit)
    seen = Seen(Opened(archive))
    page, entry, omega = seen.page, DESCRIBED[name], archive.scan.axes[0].values
    unit_words = "" if entry.unit == "1" else f" {entry.unit}"
    label = f"{entry.symbol} [{entry.unit}]" if unit_words else entry.symbol
    assert page.map.main.xaxis.axis_label.endswith(label)
    at = page.map.places[1].at[0] if page.map.is_map else 0.0
    seen.event(page.map.main, Tap, x=omega[3] / one, y=at)
    assert page.chosen.cell == (3, 0)
    assert f"{entry.symbol} = {omega[3] / one:.6g}{unit_words}" in page.readout.text
    (spectrum,) = (panel for panel in page.panels.narrow if panel.name == "spectrum")
    assert spectrum.xaxis.axis_label == f"frequency / {'f' if name == 'f' else 'ω'}"
    _, slider, exact = page.sliders["omega"]
    assert slider.title.startswith(entry.symbol)
    assert exact.value == pytest.approx(omega[3] / one)
    exact.value = float(f"{omega[4] / one:.6g}")
    assert page.chosen.system().parameters["omega"] == pytest.approx(omega[4], rel=1e-5)
    page.refine((omega[2] / one, omega[5] / one), (0.0, 800.0))
    part = page.job.results
    np.testing.assert_allclose(part.scan.axes[0].values[[0, -1]], omega[[2, 5]])
    np.testing.assert_allclose(part.axes[0].values[[0, -1]], omega[[2, 5]] / one)
    assert part.scan.document()["vary"].keys() == document["vary"].keys()
    assert (part.axes[0].name, load_scan(part.scan.document()).axes) == (name, part.scan.axes)
    html = report_page(archive).html
    words = f"{entry.symbol} = {omega[1] / one:.6g}{unit_words}"
    assert json.dumps(words) in html
    page.close()


def test_undetermined_cells_are_hatched_and_a_number_of_the_same_map_is_patched(idle):
    page = idle.page
    hatch = page.map.hatch.data
    assert len(hatch["left"]) == 6  # a box for each column
    np.testing.assert_allclose(hatch["top"] - hatch["bottom"], 4 * 200 / 3, rtol=1e-5)
    assert 'class="chip hatched"' in page.legend.text
    page.show.value = "E1max"
    assert len(page.map.hatch.data["left"]) == 0
    # a number of the same map is patched
    events = []
    page.document.on_change(events.append)
    page.show.value = "regimes of a start"
    page.show.value = "E1max"
    image = page.map.picture.source
    sent = [event for event in events if getattr(event, "column_source", event.model) is image]
    assert [type(event).__name__ for event in sent] == ["ColumnsPatchedEvent"] * 2


ODD = {
    "a key of no step": ("press", "x"),
    "a key of one number": ("press", "1"),
    "infinity for a parameter": ("set_value", "P", float("inf")),
    "nothing for a parameter": ("set_value", "P", None),
    "a parameter that there is not": ("set_value", "Q", 1.0),
    "a cell beyond the last": ("choose", (6, 0)),
    "a cell before the first": ("choose", (-1, 0)),
    "no number for a start": ("choose_start", "x"),
    "an empty part": ("refine", (7.4, 7.4), (800.0, 850.0)),
    "a picture of no orbit": ("draw",),
}


def test_odd_messages_are_answered_in_one_line(idle):
    page = idle.page
    for case, (name, *arguments) in ODD.items():
        page.say_trouble("")
        before = dict(page.chosen.free)
        if name == "choose_start":
            with page.sets():
                page.start.value = arguments[0]
        page.guarded(getattr(page, name), *arguments)
        assert page.trouble.text, case
        assert "\n" not in page.trouble.text
        assert page.chosen.free == before
        with page.sets():
            page.start.value = "0"
        page.choose((1, 1))
        assert page.chosen.cell == (1, 1)


@pytest.mark.usefixtures("computing_nothing")
def test_a_diagram_is_painted_in_the_pixels_that_are_seen(small_diagram):
    seen = Seen(Opened(stored(small_diagram)))
    page = seen.page
    page.resize(0, 500)
    page.resize(1, 300)
    image = page.map.picture.source.data["image"][0]
    assert image.shape == (300, 500)
    assert set(np.unique(image)) == {0, 1}
    whole = int((image > 0).sum())
    page.map.main.x_range.update(start=7.45, end=7.55)
    seen.event(page.map.main, RangesUpdate, x0=7.45, x1=7.55, y0=0.0, y1=1.0)
    zoomed = page.map.picture.source.data
    assert (zoomed["x"], zoomed["dw"]) == ([7.45], [pytest.approx(0.1)])
    assert 0 < (zoomed["image"][0] > 0).sum() < whole
    assert page.map.regimes.source.data["image"][0].shape == (1, 9)
    page.close()


# ---- the page without a server -------------------------------------------------------------------


def arguments_of(html):
    """Return the arguments of the script of a page by name, as Bokeh decodes them."""
    text = re.search(r'application/json" id="[^"]*">(.*?)</script>', html, re.DOTALL)[1]
    (document,) = json.loads(text).values()
    callbacks = Deserializer().decode(document)["callbacks"]["document_ready"]
    return next(act.args for act in callbacks if "shows" in act.args)


def test_numbers_keep_four_digits_and_states_sixteen_bits_of_their_range():
    values = np.array([1.0, -3.14159265, 1e-30, 1e30, 0.0, np.nan, np.inf, -np.inf], np.float32)
    rounded_values = rounded(values)
    np.testing.assert_array_equal(np.isfinite(rounded_values), np.isfinite(values))
    nonzero = np.isfinite(values) & (values != 0)
    assert (np.abs(rounded_values[nonzero] / values[nonzero] - 1) <= 2.0**-13).all()
    assert rounded_values[4] == 0
    states = np.random.default_rng(1).normal(size=(50, 3, 4))
    states[7, 1] = np.nan
    codes, low, step = coded(states)
    decoded = np.where(codes == 65535, np.nan, low + codes * step)
    np.testing.assert_allclose(decoded, states, atol=0.51 * np.max(step))


@pytest.fixture(scope="module")
def html(small_map):
    return report_page(stored(small_map)).html


def test_the_page_holds_what_the_archive_does(html, small_map):
    arguments = arguments_of(html)
    archive, columns = stored(small_map), arguments["columns"].data
    assert arguments["labels"] == label_codes(archive)[0]
    np.testing.assert_array_equal(columns["label"], column(archive, "label").ravel())
    np.testing.assert_allclose(columns["E1max"], column(archive, "E1max").ravel(), rtol=2e-4)
    states = arguments["low"] + arguments["codes"].reshape(-1, 30, 4) * np.array(arguments["step"])
    expected = archive.lanes("section").reshape(-1, 30, 4)
    np.testing.assert_allclose(states, expected, atol=1.1 * max(arguments["step"]))
    images = arguments["images"].data
    (show,) = [one for one in shows_of(archive) if one.name == "E1max"]
    np.testing.assert_array_equal(images["E1max:1"][0], painted(archive, show, 1).codes)


def test_the_page_has_a_place_for_each_figure_and_asks_for_nothing_from_outside(html, small_map):
    roots = json.loads(re.search(r'"roots":(\{[^}]*\})', html)[1])
    assert (
        len(roots) == 10
    )  # controls, tip, map, its words, legend, hint, key, words, two phase planes
    assert all(f'id="{place}"' in html for place in roots.values())
    # it asks for nothing from outside
    assert "Content-Security-Policy" in html
    assert "default-src 'none'" in html
    assert not re.search(r"<(script|link|img)[^>]*(src|href)=[\"']?(https?:|//)", html)
    # it tells nothing of the machine of its author
    about = stored(small_map).about
    for name in ("machine", "history"):
        assert str(about[name]) not in html
    assert str(Path.home()) not in html
    assert str(small_map.parent) not in html


def test_words_of_an_archive_do_no_harm(folder):
    title = "</script><script>alert(1)</script><b>"
    path = made_up({**MAP, "title": title}, folder / "bad.h5")
    html = report_page(stored(path)).html
    assert "<script>alert(1)" not in html
    assert "&lt;/script&gt;" in html


@pytest.mark.slow("pages of 90,000 orbits")
def test_a_large_map_fits_into_a_mail():
    """Of random numbers, which nothing makes smaller: a real map takes less."""
    vary = {"omega": np.linspace(5.0, 8.0, 150), "P": np.linspace(400.0, 900.0, 150)}
    start, sampling = {"policy": "random", "count": 4}, {"transient": 1, "periods": 12}
    document = {**MAP, "vary": vary, "start": start, "sampling": sampling}
    report = report_page(filled(document))
    assert report.size <= MOST_BYTES
    arguments = arguments_of(report.html)
    assert arguments["columns"].data["label"].size == 90_000
    assert "E1max" in arguments["columns"].data
    assert arguments["points"] >= 1
    assert "holds" in report.left_out


def test_the_command_writes_the_page_and_says_its_size(small_map, tmp_path, answer):
    output = tmp_path / "page.html"
    assert "MB" in answer("report", small_map, "-o", output)
    assert "a small map" in output.read_text(encoding="utf-8")
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]


def test_what_are_no_branches_is_one_line(small_map, tmp_path, refusal):
    output = tmp_path / "x.html"
    line = refusal("report", small_map, "--branches", small_map, "-o", output)
    assert "not a continuation" in line
    assert not output.exists()


@pytest.fixture(scope="module")
def branches(folder):
    path = folder / "branches.h5"
    arguments = ["--along", "omega=7.3:7.6", "--doublings", "1", "--unstable", "30", "--quiet"]
    assert main(["continuation", *arguments, "-o", str(path)]) == 0
    return path


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["diagram", "map"])
def test_branches_and_special_points_are_on_the_page(
    name, branches, folder, small_map, small_diagram, ask
):
    output = folder / f"{name}-branches.html"
    assert ask("report", folder / f"{name}.h5", "--branches", branches, "-o", output).err == ""
    html = output.read_text(encoding="utf-8")
    special = nv.open_archive(branches).special_points
    assert len(special)
    for row in special:
        assert f"<td>{row.kind}</td><td>omega = {row.value:.8g}</td>" in html
    assert ('"name":"MultiLine"' in html) == (name == "diagram")
    assert html.count('"name":"Scatter"') > 2


@pytest.mark.kernels
def test_branches_of_another_parameter_are_refused(branches, folder, refusal):
    vary = {"P": [700.0, 800.0, 900.0], "C": [0.06, 0.07]}
    path, output = made_up({**MAP, "vary": vary}, folder / "PC.h5"), folder / "x.html"
    assert "continues along omega" in refusal("report", path, "--branches", branches, "-o", output)
