"""From a click to the drawn orbit on the page of `nlds-vines explore`, measured in a browser.

    python -m benchmarks.explore [FILE.h5] [--clicks 50] [--history whole] [--picture PNG]

Without a file it computes Figure 8 first.  It starts the command, opens its page in a headless
Chromium, and clicks cells all over the map.  A time begins with the press of the button, and ends
with the frame after the one in which Bokeh has drawn the orbit.  Needs the extra `test` and a
Chromium.  `--picture` keeps what the page looks like, as docs/explore.png is made.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar, Self

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")  # names of a Chromium
WARM = 5  # clicks that are not counted: the page is drawn for the first time
KNOWN = Path("/proc/self/stat")  # where a system tells processor times, if it does
_SIZE = {"width": 1500, "height": 1130}
_WITHIN = 60_000  # milliseconds after which something must have gone wrong
_FRAME = """(name) => {
    const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name(name).id)
    view.el.scrollIntoView({block: "nearest"})
    const r = view.el.getBoundingClientRect(), b = view.frame.bbox
    return [r.x + b.left, r.y + b.top, b.width, b.height]
}"""
_LOADED = "window.Bokeh && Bokeh.documents.length && Bokeh.index.roots.length"
_WATCH = """() => {
    const source = Bokeh.documents[0].get_model_by_name("history data")
    const note = () => requestAnimationFrame(() => requestAnimationFrame(() => {
        window.drawn = performance.now()
    }))
    source.properties.data.change.connect(note)
    if (source.data.t.length) note()
}"""


def browser_path() -> str | None:
    return next(filter(None, map(shutil.which, BROWSERS)), None)


@contextmanager
def opened_browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    path = browser_path()
    if path is None:
        raise SystemExit(f"no browser is installed: none of {', '.join(BROWSERS)}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


def new_page(browser: Any, **settings: Any) -> Any:
    """Return a page of its own in a browser; `settings` are those of a context of Playwright."""
    page = browser.new_context(viewport=_SIZE, **settings).new_page()
    page.set_default_timeout(_WITHIN)
    return page


class Served:
    """The command `nlds-vines explore` in a process of its own."""

    program: ClassVar = ("-m", "nlds_vines")
    """What Python is to run, which takes the words of the command."""

    def __init__(self, *arguments: str) -> None:
        """Start it, and wait until it has said its address."""
        self.began = time.perf_counter()
        command = [sys.executable, *self.program, "explore", *arguments]
        root = str(Path(__file__).resolve().parents[1])
        self.process = subprocess.Popen(
            [*command, "--no-browser", "--port", "0"],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": root},
        )
        assert self.process.stdout is not None
        lines = (line for line in self.process.stdout if line.startswith("open "))
        line = next(lines, None)
        if line is None:
            raise SystemExit(self.process.communicate()[1])
        self.address = line.split()[1]
        self.seconds = time.perf_counter() - self.began

    def processor_seconds(self) -> float:
        """Return the processor time that it has used, also on a machine that others load."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self, number: int = signal.SIGINT) -> tuple[int, str]:
        """End it by a signal; return its status and what it has said of errors."""
        self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=60)
        return self.process.returncode, errors

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.returncode is None:
            self.end(signal.SIGKILL)


def opened_page(page: Any, address: str) -> Any:
    """Open the page at an address, and wait until its first orbit is drawn."""
    page.goto(address)
    page.wait_for_function(_LOADED)
    page.evaluate(_WATCH)
    drawn(page)
    return page


def drawn(page: Any) -> None:
    page.wait_for_function("window.drawn !== undefined")


def frame_of(page: Any, name: str = "cells") -> tuple[float, float, float, float]:
    """Return left, top, width and height [pixels] of the inside of a figure."""
    left, top, width, height = page.evaluate(_FRAME, name)
    return left, top, width, height


def click_times(page: Any, clicks: int) -> list[float]:
    """Return the milliseconds from the press of a button to the drawn orbit, click by click."""
    page.evaluate(
        "addEventListener('pointerdown', () => { window.down = performance.now() }, true)"
    )
    left, top, width, height = frame_of(page)
    times = []
    for number in range(WARM + clicks):
        # all over the map, in no order: multiples of irrational numbers
        x, y = (number * 0.6180339887) % 1.0, (number * 0.7548776662) % 1.0
        page.evaluate("window.drawn = undefined")
        page.mouse.click(left + (0.01 + 0.98 * x) * width, top + (0.01 + 0.98 * y) * height)
        drawn(page)
        times.append(page.evaluate("window.drawn - window.down"))
    return times[WARM:]


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.explore", description=__doc__)
    parser.add_argument("archive", nargs="?", type=Path)
    parser.add_argument("--clicks", type=int, default=50)
    parser.add_argument("--history", default="", help="as in the menu: `the first 100 periods`")
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        archive = options.archive
        if archive is None:
            import nlds_vines as nv

            archive = nv.scan(to=Path(folder) / "figure8.h5")
        with Served(str(archive)) as served, opened_browser() as browser:
            page = new_page(browser)
            opened = time.perf_counter()
            opened_page(page, served.address)
            usable = time.perf_counter() - opened
            used = f"{served.processor_seconds():.2f} s" if KNOWN.exists() else "unknown"
            if options.history:
                page.evaluate("window.drawn = undefined")
                page.locator("#orbit select").select_option(label=options.history)
                drawn(page)
            times = sorted(click_times(page, options.clicks))
            if options.picture is not None:
                page.mouse.move(2, 2)
                page.wait_for_timeout(300)
                page.screenshot(path=str(options.picture))
    load = os.getloadavg()[0] / (os.cpu_count() or 1)
    print(f"{archive.name}: {options.clicks} clicks, load {load:.1f} for each processor")
    print(
        f"  address said after {served.seconds:.2f} s; page usable {usable:.2f} s after it "
        f"opened: {served.seconds + usable:.2f} s; processor time of the command until then: "
        f"{used}"
    )
    nine = times[int(0.9 * len(times))]
    print(
        f"  click to drawn orbit: median {statistics.median(times):.0f} ms, "
        f"fastest {times[0]:.0f} ms, nine of ten within {nine:.0f} ms"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
