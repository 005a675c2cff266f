"""A headless browser for tests, where one is installed."""

import shutil
from contextlib import contextmanager

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")


@contextmanager
def browser_page(**settings):
    """Open a page in Chromium; skip the test, with the reason, where there is none."""
    sync_api = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: no test in a browser"
    )
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"no browser is installed ({', '.join(NAMES)}): no test in a browser")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        try:
            context = browser.new_context(
                viewport={"width": 1500, "height": 1100}, accept_downloads=True, **settings
            )
            page = context.new_page()
            page.set_default_timeout(60_000)
            page.faults = []
            page.on("pageerror", lambda error: page.faults.append(str(error)))
            page.on(
                "console",
                lambda told: page.faults.append(told.text) if told.type == "error" else None,
            )
            yield page
        finally:
            browser.close()
