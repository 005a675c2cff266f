"""Messages that no page of ours sends: the page is told in one line, and goes on."""

import json

import pytest

pytest.importorskip("bokeh", reason="Bokeh is not installed")

from bokeh.document import Document
from conftest import MAP, made_up

from nlds_vines.explore import live_orbit, map_computation
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.session import Session
from nlds_vines.explore.shared_map import Opened

MESSAGES = {
    "a number": 7,
    "nothing": None,
    "a list": [1],
    "a text": "cell",
    "no word": {},
    "a list for a word": {"do": ["cell"]},
    "a table for a word": {"do": {}},
    "an unknown word": {"do": "format"},
    "no cell": {"do": "cell"},
    "a number for a cell": {"do": "cell", "cell": 3, "start": 0},
    "words for a cell": {"do": "cell", "cell": ["a", "b"], "start": 0},
    "infinity for a cell": {"do": "cell", "cell": [float("inf"), 0], "start": 0},
    "three places of a cell": {"do": "cell", "cell": [1, 2, 3], "start": 0},
    "a cell beyond the last": {"do": "cell", "cell": [6, 0], "start": 0},
    "a cell before the first": {"do": "cell", "cell": [-1, 0], "start": 0},
    "nothing for a start": {"do": "cell", "cell": [0, 0], "start": None},
    "no number of a message": {"do": "cell", "cell": [0, 0], "start": 0, "number": "x"},
    "infinity for a number": {"do": "original", "number": float("inf")},
    "a list for a parameter": {"do": "slider", "name": [1], "value": 1.0},
    "a text for a value": {"do": "slider", "name": "P", "value": "x"},
    "a huge value": {"do": "slider", "name": "P", "value": 10**400},
    "no ranges": {"do": "finer"},
    "a number for ranges": {"do": "finer", "ranges": 3},
    "one range": {"do": "finer", "ranges": [[1, 2]]},
    "huge ranges": {"do": "finer", "ranges": [[10**400, 1], [1, 2]]},
    "nothing in ranges": {"do": "finer", "ranges": [None, None]},
    "a list for a history": {"do": "history", "name": []},
    "nothing to save": {"do": "save"},
    "a list to save": {"do": "save", "what": []},
}


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    return made_up(MAP, tmp_path_factory.mktemp("messages") / "map.h5")


@pytest.fixture
def page(archive, monkeypatch):
    """A page that is told what is wrong, and computes nothing."""
    monkeypatch.setattr(live_orbit, "aside", lambda *_: None)
    monkeypatch.setattr(map_computation.Job, "begin", lambda _: None)
    session = Session(Document(), Opened(stored(archive)))
    session.troubles = []

    def note(attribute, old, new):
        told = [json.loads(text) for text in new["message"]]
        session.troubles += [each["trouble"] for each in told if "trouble" in each]

    session._data["told"].on_change("data", note)
    yield session
    session.close()


def send(page, *texts):
    page._data["asked"].data = {"message": list(texts)}


@pytest.mark.parametrize("case", MESSAGES)
def test_an_odd_message_is_answered_in_one_line(page, case):
    before = dict(page._chosen.free)
    send(page, json.dumps(MESSAGES[case]))
    assert len(page.troubles) == 1
    assert page.troubles[0]
    assert "\n" not in page.troubles[0]
    assert page._chosen.free == before
    send(page, json.dumps({"do": "cell", "cell": [1, 1], "start": 0}))
    assert len(page.troubles) == 1
    assert page._chosen.cell == (1, 1)


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, "\0", "NaN", "1" * 5000, 7, None])
def test_what_is_no_json_is_answered_in_one_line(page, text):
    send(page, text)
    assert len(page.troubles) == 1
    assert "\n" not in page.troubles[0]


@pytest.mark.parametrize("data", [{}, {"message": 3}, {"message": None}, {"other": ["x"]}])
def test_no_message_at_all_is_passed_over(page, data):
    page._hear("data", {}, data)
    assert page.troubles == []
