"""The report of each set of records, opened in a browser: what a reader sees."""

import io

import numpy as np
import pytest
from browsers import browser_or_skip, seen_text, text_of, watched_page
from conftest import filled

from nlds_vines.model.catalog import load_system
from nlds_vines.orbits.records import USUAL, WANTS, possible_want

pytest.importorskip("bokeh", reason="Bokeh is not installed")

from nlds_vines.explore.report_page import report_page

pytestmark = pytest.mark.kernels  # a browser opens each page

OMEGA = {"omega": {"values": [7.11, 7.22, 7.33, 7.44, 7.55]}}
AXES = {"diagram": OMEGA, "map": OMEGA | {"P": {"values": [701.0, 802.0, 903.0]}}}

BEYOND_CENTER = np.s_[0.05:0.7, 0.6:0.95]
"""Height and width of a figure that hold data alone: no axis, no label, not the chosen cell."""


@pytest.fixture(scope="module")
def browser():
    with browser_or_skip() as browser:
        yield browser


def made_up(shape, want, system="ssul-set6"):
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


def painted(page, box):
    """Return the share of a figure's `BEYOND_CENTER` that is neither light nor gray."""
    from PIL import Image

    picture = Image.open(io.BytesIO(page.screenshot(clip=box))).convert("RGB")
    pixels = np.asarray(picture).astype(int)
    rows, columns = (
        slice(*(int(end * size) for end in (part.start, part.stop)))
        for part, size in zip(BEYOND_CENTER, pixels.shape[:2], strict=True)
    )
    part = pixels[rows, columns]
    return np.mean(part.max(-1) - part.min(-1) > 40)


def check(browser, folder, results):
    """Open the report of results, choose cells, and check what is seen."""
    path = folder / "page.html"
    path.write_text(report_page(results).html, encoding="utf-8")
    page = watched_page(browser)
    page.goto(path.as_uri())
    page.wait_for_function("document.documentElement.dataset.ready === 'yes'")
    assert "7.33" in text_of(page, "verdict")  # the middle one is chosen
    assert "a report" in seen_text(page)
    box = largest_figure(page)
    assert painted(page, box) > (0.15 if len(results.scan.axes) == 2 else 1e-4)
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
    check(browser, tmp_path, made_up(shape, want))


@pytest.mark.parametrize("system", ["impact-oscillator", "none", "tmd"])
def test_a_report_shows_every_scene(browser, tmp_path, system):
    want = [*possible_want(WANTS, load_system(system).scene)]
    check(browser, tmp_path, made_up("map", want, system))
