"""A headless browser for tests, where one is installed."""

from contextlib import contextmanager

import pytest

from benchmarks.explore import BROWSERS, browser_path, new_page, opened_browser


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
