"""Pages of histories, suites, curves and tunings: what they say, draw and never load."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.explore.sent_page import (
    Account,
    account_of,
    assumptions_of,
    sent_page,
    shortened,
)
from nlds_vines.explore.system_drawing import dampers_in_words, drawn_system

STEP = 0.02


def frame(storeys=3):
    return nv.shear_frame([1e4] * storeys, [8e6] * storeys, ratio=0.02)


def design(storeys=3):
    walls = [nv.Wall(0.02, side, law="restitution", e=0.8) for side in "+-"]
    cell = nv.Damper("cell", "roof", m=900.0, k=100.0, walls=walls)
    brace = nv.Damper("brace", ("floor2", "floor1"), k=1e4, walls=[nv.Wall(0.01, K=1e8)])
    return nv.System.from_host(frame(storeys), [cell, brace], name="a < b")


def record(seed):
    values = np.random.default_rng(seed).uniform(-2.0, 2.0, 100)
    return {"times": (STEP * np.arange(100)).tolist(), "values": values.tolist(), "unit": "m/s^2",
            "source": f"r{seed}"}  # fmt: skip


class Checked(HTMLParser):
    """Fails for tags that are not closed, and counts all."""

    def __init__(self, text):
        super().__init__()
        self.open, self.counts = [], {}
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.counts[tag] = self.counts.get(tag, 0) + 1
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_a_drawing_has_floors_boxes_walls_and_numbers():
    system = design()
    cell, brace = dampers_in_words(system)
    assert cell["lines"][:2] == [
        "cell: 900 kg, 100 N/m",
        "gap 20 mm on side +, restitution e = 0.8",
    ]
    assert brace["places"] == ["floor2", "floor1"]
    drawing = drawn_system(system, "a < b")
    assert drawing.count("<rect") == 1
    assert ">roof</text>" in drawing
    assert "a &lt; b" in drawing
    assert "a < b" not in drawing
    assert "<rect" not in drawn_system(system.alone(), "alone")
    tall = drawn_system(design(30), "tall")
    assert ">floor2</text>" in tall  # a damper hangs there
    assert ">floor9</text>" not in tall
    preset = drawn_system(nv.load_system("ssul-set6"), "Set 6")
    assert "m2 = 60 kg" in preset
    assert ">structure</text>" in preset
    assert drawn_system(nv.load_system("none"), "alone").count("<rect") == 0


@pytest.mark.kernels
def test_pages_of_histories_and_suites(here, answer, refusal):
    task = {"duration": 3.0, "heights": 3.5, "beside": ["alone"], "quiet": True}
    nv.response_history(design(), load={"record": record(1)}, to="h.h5", **task)
    suite = nv.response_history(design(), load={"suite": [record(1), record(2)]}, to="s.h5", **task)
    for name in ("h", "s"):
        page = sent_page(here / f"{name}.h5")
        counts = Checked(page).counts
        assert counts["img"] >= 2
        assert counts["svg"] == 2
        assert "script" not in counts
        assert not re.search(r'(src|href)="(?!data:)', page)
        for words in ("What was asked", "Assumptions", "drift_ratio_max [%]", "law restitution"):
            assert words in page
        assert "a &lt; b" in page
        assert "numbers, in the archive" in page  # samples do not fill the page
    cells = suite.rows()[1]
    assert all(f"<td>{cell}</td>" in page for cell in cells)
    assert "s.html" in answer("report", "s.h5")
    assert (here / "s.html").read_text() == page
    assert "exists" in refusal("report", "s.h5")
    assert "is for the page of a map" in refusal("report", "s.h5", "-o", "b.html", "--branches",
                                                 "h.h5")  # fmt: skip
    assert "into c.html" in answer("report", "h.h5", "-o", "c.html", "--dry-run")
    assert not (here / "c.html").exists()


@pytest.mark.kernels
def test_a_page_of_a_tuning_draws_the_best_design(here):
    small = {"population": 5, "generations": 1, "polish": 0, "optima": 1, "objective": "x1_max"}
    tuned = nv.tune(
        "tmd", free={"k2": {}, "c2": {}}, load={"impulse": 100.0}, search=small, quiet=True,
        sampling={"duration": 3.0}, to="t.h5",
    )  # fmt: skip
    page = sent_page(here / "t.h5")
    Checked(page)
    assert f"k2 = {tuned.parameters['k2']:.4g} N/m" in page
    assert "free: k2 from" in page
    assert "Contacts obey" not in page


@pytest.mark.kernels
def test_every_archive_without_a_map_has_a_page(here, answer, refusal):
    """Branches, transients, portraits and samples, as histories, curves and tunings."""
    oscillator = nv.load_system("impact-oscillator", omega=1.5)
    nv.continue_branch(oscillator, "P", (0.1, 2.0), to="branches.h5", quiet=True)
    calm = nv.load_system("ssul-set6", omega=7.1)
    nv.transient_lifetimes(calm, starts=6, transient=60, to="transients.h5", quiet=True)
    nv.orbit_portrait(calm, windows=[[60, 72]], to="portrait.h5", quiet=True)
    said = {
        "branches": ("along P from 0.1 to 2", "regime along the branch", "periodic orbits under"),
        "transients": ("6 starts each", "ended in", "95% interval"),
        "portrait": ("forcing periods 60 to 72", "recurrence: T,1", "law hertz"),
    }
    for name, lines in said.items():
        archive = here / f"{name}.h5"
        page = sent_page(archive)
        counts = Checked(page).counts
        assert (counts["img"], counts["svg"]) == (1, 1)
        assert "script" not in counts
        for words in lines:
            assert words in page, (name, words)
        assert f"{name}.html" in answer("report", archive)
        assert (here / f"{name}.html").read_text() == page
    assert "--branches is for the page of a map" in refusal(
        "report", "branches.h5", "-o", "b.html", "--branches", "branches.h5"
    )


def test_long_lists_of_numbers_and_repeated_assumptions_are_shortened():
    few, many = ", ".join(["1.5"] * 50), ",\n  ".join(["-2e-3"] * 51)
    toml = f'title = "[1, 2]"\nfew = [{few}]\nmany = [\n  {many},\n]\n'
    short = shortened(toml)
    assert short == f'title = "[1, 2]"\nfew = [{few}]\nmany = "51 numbers, in the archive"\n'
    account = Account([], [(nv.load_system("ssul-set6"), "Set 6")], None)
    (repeated,) = [line for line in assumptions_of(account) if "two spheres" in line]
    assert repeated.startswith("A, B, q1: A = B = 0.5 1/m")
    with pytest.raises(nv.RequestError, match="holds no result that a page can tell"):
        account_of(3.0)
