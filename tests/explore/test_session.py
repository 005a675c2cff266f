"""A page without a browser: what its controls do, what it is told, what ends with it."""

import json
import threading
import time
from collections import deque

import pytest

bokeh = pytest.importorskip("bokeh", reason="Bokeh is not installed")

from bokeh.document import Document  # noqa: E402

from nlds_vines.bifurcation.request import load_scan  # noqa: E402
from nlds_vines.explore.map_data import stored  # noqa: E402
from nlds_vines.explore.session import Session  # noqa: E402
from nlds_vines.explore.shared_map import COMPILING, LOADING, READY, Opened  # noqa: E402
from nlds_vines.orbits.simulation import IntegrationError  # noqa: E402
from nlds_vines.portrait.request import load_portrait  # noqa: E402


class Page:
    """A page whose browser is this test."""

    def __init__(self, opened):
        self.document = Document()
        self.calls = deque()  # in their order, as a server's loop has them
        self.document.add_next_tick_callback = self.calls.append
        self.session = Session(self.document, opened)
        self.told = {}
        self.session._data["told"].on_change("data", self._note)
        self.do("ready")

    def _note(self, attribute, old, new):
        for text in new["message"]:
            self.told |= json.loads(text)

    def ask(self, do, **more):
        self.session._data["asked"].data = {"message": [json.dumps({"do": do, **more})]}

    def do(self, what, **more):
        """Ask for something, and wait until it is done."""
        self.ask(what, **more)
        self.settle()

    def settle(self, until=lambda page: not page.session._queue.busy, seconds=60.0):
        """Run what threads have left for the document until a condition holds."""
        end = time.monotonic() + seconds
        while True:
            while self.calls:
                self.calls.popleft()()
            if until(self):
                return
            assert time.monotonic() < end, self.told
            time.sleep(0.005)


@pytest.fixture
def page(small_map):
    page = Page(Opened(stored(small_map)))
    yield page
    page.session.close()


@pytest.mark.kernels
def test_a_click_shows_the_orbit_of_the_cell(page, small_map):
    found = stored(small_map)
    for cell in ((0, 0), (5, 3), (3, 2)):
        page.do("cell", cell=cell, start=1, number=7)
        assert page.told["orbit"]["label"] == found.arrays["label"][(*cell, 1)]
        assert page.told["orbit"]["number"] == 7
        assert page.told["sliders"]["omega"] == found.values_of(cell)["omega"]
        assert page.told["trouble"] == ""


@pytest.mark.kernels
def test_of_many_clicks_the_last_one_is_shown(page, small_map):
    for number in range(20):
        page.ask("cell", cell=(number % 6, 0), start=0, number=number)
    page.settle()
    assert page.told["orbit"]["number"] == 19


@pytest.mark.kernels
def test_a_slider_moves_the_orbit_and_a_refused_one_nothing(page):
    page.do("cell", cell=(2, 2), start=0)
    page.do("slider", name="P", value=333.0)
    assert page.session._orbit.view.column.system.parameters["P"] == 333.0
    page.ask("slider", name="m1", value=-1.0)
    assert "m1" in page.told["trouble"]
    assert page.told["sliders"]["m1"] > 0
    page.do("original")
    assert (
        page.session._orbit.view.column.system.parameters["P"]
        == page.session._found.values_of((2, 2))["P"]
    )


@pytest.mark.kernels
def test_a_click_in_a_phase_plane_begins_an_orbit_there(page):
    page.do("plane", plane="phase2", x=0.3, v=-0.25)
    start = page.session._orbit.request.start
    assert start[2:] == (0.3, -0.25)
    assert page.told["orbit"]["where"] == "from a start of your own"


@pytest.mark.kernels
def test_a_history_from_the_start_is_shown_until_another_is_chosen(page):
    def times():
        first, stop = next(
            place for source, name, *place in page.told["orbit"]["layout"] if name == "t"
        )
        return page.session._data["values"].data["values"][first:stop]

    page.do("history", name="whole")
    assert times()[0] < 1
    assert times()[-1] > 60
    page.do("cell", cell=(1, 1), start=0)
    assert times()[0] < 1
    page.do("history", name="settled")
    assert times()[0] > 60
    page.ask("history", name="all of it")
    assert "history" in page.told["trouble"]


@pytest.mark.kernels
def test_a_rectangle_is_computed_and_one_can_go_back(page):
    page.ask("finer", ranges=[[7.4, 7.5], [800.0, 850.0]])
    page.settle(lambda p: p.told["job"]["share"] == 1.0 and not p.session._queue.busy)
    assert page.told["level"]["axes"][0]["values"][0] == 7.4
    assert (page.session._found.arrays["label"] != "").all()
    assert page.told["job"]["back"]
    page.ask("back")
    assert page.told["level"]["axes"][0]["values"][0] == 7.3
    assert page.told["job"]["forward"]
    page.ask("forward")
    assert page.told["level"]["axes"][0]["values"][0] == 7.4


@pytest.mark.kernels
def test_an_orbit_that_fails_is_told_and_nothing_of_the_one_before_remains(page, monkeypatch):
    def fails(*_, **__):
        raise IntegrationError("it stuck to the wall")

    monkeypatch.setattr("nlds_vines.explore.live_orbit.live_orbit", fails)
    page.do("cell", cell=(1, 1), start=0)
    assert page.told["trouble"] == "it stuck to the wall"
    assert (page.told["orbit"]["label"], page.told["orbit"]["layout"]) == ("no orbit", [])


def test_a_closed_page_leaves_nothing_running(small_map, monkeypatch):
    monkeypatch.setattr("nlds_vines.bifurcation.blocks.BLOCK_PERIODS", 1)
    opened = Opened(stored(small_map))
    page = Page(opened)
    page.ask("finer", ranges=[[7.4, 7.5], [800.0, 850.0]])
    job = page.session._job
    assert not job.cancelled
    page.session.close()
    assert job.cancelled
    job.wait(20.0)
    assert not job.running
    assert opened.listeners == []
    assert not [t for t in threading.enumerate() if t.name == "refining"]


@pytest.mark.kernels
def test_what_is_saved_is_what_is_seen(page, tmp_path):
    page.do("cell", cell=(1, 2), start=1)
    page.ask("save", what="portrait")
    path = tmp_path / page.told["file"]["name"]
    path.write_text(page.told["file"]["text"])
    assert load_portrait(path).start == page.session._orbit.request.start
    page.do("slider", name="C", value=0.05)
    page.ask("save", what="scan")
    path.write_text(page.told["file"]["text"])
    assert load_scan(path).system.parameters["C"] == 0.05
    assert load_scan(path).shape == (6, 4)


@pytest.mark.kernels
def test_the_saved_picture_is_one(page):
    page.ask("save", what="picture")
    page.settle(lambda p: "file" in p.told)
    assert page.told["file"]["base64"].startswith("iVBOR")  # PNG


def test_the_page_says_what_the_kernels_do(small_map):
    opened = Opened(stored(small_map))
    page = Page(opened)
    assert page.told["state"] == LOADING
    opened._compiles(None)
    page.settle()
    assert page.told["state"] == COMPILING
    opened._wait(COMPILING, 7.3)
    page.settle()
    assert page.told["state"] == f"{COMPILING}: 7 s so far"
    opened._warm()
    page.settle()
    assert page.told["state"] == ""
    page.session.close()


def test_a_scan_is_computed_while_it_is_seen(small_diagram):
    scan = stored(small_diagram).scan
    opened = Opened(None, scan)
    page = Page(opened)
    opened.begin()
    page.settle(
        lambda p: opened.job.share == 1.0 and opened.kernels == READY and not opened.job.running
    )
    page.settle()
    assert set(page.told["cells"]["labels"]) == {
        "not computed", *stored(small_diagram).arrays["label"].ravel()
    }  # fmt: skip
    assert opened.close()
    page.session.close()
