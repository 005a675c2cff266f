"""A headless browser for tests, where one is installed."""

from contextlib import contextmanager

import pytest

from benchmarks.explore import BROWSERS, browser_path, drawn, frame_of, new_page, opened_browser


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
    page = new_page(browser, **settings)
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
    drawn(page)


def value_of(page, expression):
    """Return the value of an expression about Bokeh models, which are `m(name)`."""
    return page.evaluate(
        f"() => {{ const m = (name) => Bokeh.documents[0].get_model_by_name(name); "
        f"return {expression} }}"
    )


def place_of(page, *at):
    """Return where a point of the map or diagram, in its own coordinates, is on the screen."""
    left, top, width, height = frame_of(page)
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


def rectangle_computed(page, first, last):
    """Drag a rectangle from one point to another, and wait until that part is computed."""
    (x0, y0), (x1, y1) = place_of(page, *first), place_of(page, *last)
    page.mouse.move(x0, y0)
    page.mouse.down()
    page.mouse.move((x0 + x1) / 2, (y0 + y1) / 2, steps=4)
    page.mouse.move(x1, y1, steps=4)
    page.mouse.up()
    page.locator("button:not([disabled])", has_text="back").wait_for()
    page.locator(".progress progress").wait_for(state="detached")
