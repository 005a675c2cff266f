"""A headless browser for tests, where one is installed."""

from contextlib import contextmanager

import pytest

from benchmarks.explore import BROWSERS, browser_path, drawn, new_page, opened_browser


@contextmanager
def browser_or_skip():
    """Open Chromium; skip the test, with the reason, where there is none."""
    pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: no test in a browser"
    )
    if browser_path() is None:
        pytest.skip(f"no browser is installed ({', '.join(BROWSERS)}): no test in a browser")
    with opened_browser() as browser:
        yield browser


def watched_page(browser, **settings):
    """Return a page that notes its errors as `faults`."""
    page = new_page(browser, **settings)
    page.faults = []
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on(
        "console",
        lambda told: page.faults.append(told.text) if told.type == "error" else None,
    )
    return page


def acted(page, act):
    """Do something that asks for an orbit, and wait until it is drawn."""
    page.evaluate("window.drawn = undefined")
    act()
    drawn(page)


def place_of(page, cell):
    """Return where a cell of the map is on the screen."""
    box = page.locator("#stage .bk-Figure").first.bounding_box()
    return page.evaluate(
        """([box, cell]) => {
            const fig = NV.model("map"), view = Bokeh.index.find_one_by_id(fig.id)
            const f = view.frame, [a, b] = NV.at.meta.axes
            return [box.x + f.x_scale.compute(a.places[cell[0]]),
                    box.y + f.y_scale.compute(b.places[cell[1]])]
        }""",
        [box, list(cell)],
    )


def rectangle_computed(page, first, last):
    """Drag a rectangle from one cell to another, and wait until that part is computed."""
    (x0, y0), (x1, y1) = place_of(page, first), place_of(page, last)
    page.mouse.move(x0, y0)
    page.mouse.down()
    page.mouse.move((x0 + x1) / 2, (y0 + y1) / 2, steps=4)
    page.mouse.move(x1, y1, steps=4)
    page.mouse.up()
    page.wait_for_function("!document.getElementById('back').disabled")
    page.wait_for_function("document.getElementById('progress').hidden")
