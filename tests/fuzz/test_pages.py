"""A thousand messages of a page, and addresses of its server, that no page of ours sends."""

import json
import random

import pytest
from fuzz.rule import CASES, STRANGE, VALUES, broken_by, short

pytest.importorskip("bokeh", reason="Bokeh is not installed")

from bokeh.document import Document
from contract.made_up import MAP, make_scan, write

from nlds_vines.explore import live_orbit, map_computation
from nlds_vines.explore.map_data import stored
from nlds_vines.explore.session import Session
from nlds_vines.explore.shared_map import Opened

pytestmark = pytest.mark.long

WORDS = ("ready", "cell", "original", "slider", "finer", "history", "save", "plane", "cancel", "x")
KEYS = ("cell", "start", "number", "name", "value", "ranges", "what", "plane", "x", "v", "do")


@pytest.fixture
def page(tmp_path, monkeypatch):
    """A page that is told what is wrong, and computes nothing."""
    monkeypatch.setattr(live_orbit, "aside", lambda *_: None)
    monkeypatch.setattr(map_computation.Job, "begin", lambda _: None)
    write(tmp_path / "map.h5", make_scan(("energy", "regime"), vary=MAP))
    session = Session(Document(), Opened(stored(tmp_path / "map.h5")))
    yield session
    session.close()


def message(rng):
    """Return a message as its text."""
    found = {key: rng.choice([*VALUES, *STRANGE]) for key in KEYS if rng.random() < 0.4}
    found["do"] = rng.choice([*WORDS, *WORDS, *WORDS, *VALUES])
    text = json.dumps(found)
    return text if rng.random() < 0.8 else text[: rng.randrange(len(text))]


def test_no_message_breaks_the_rule(page, tmp_path):
    rng, wrong = random.Random(5), []
    told = []
    page._data["told"].on_change("data", lambda _, old, new: told.extend(new["message"]))
    for number in range(CASES):
        text = message(rng)
        told.clear()

        def ask(text=text):
            page._data["asked"].data = {"message": [text]}
            troubles = [each["trouble"] for each in map(json.loads, told) if "trouble" in each]
            return (2, "\n".join(troubles)) if any(troubles) else (0, "")

        if found := broken_by(ask, tmp_path):
            wrong.append(f"case {number}: {short(text)}: {found}")
    assert not wrong, "\n".join(wrong)
