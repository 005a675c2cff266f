"""The progress of long work: how much is done, how fast it goes, when it will end."""

from __future__ import annotations

import io
import shutil
import sys
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tqdm import tqdm

_BESIDE = 66  # characters of a bar and its numbers beside the words: counts, times, pace
LINE_EVERY = 5.0  # seconds between lines of progress where there is no terminal
TICK = 1.0  # seconds between looks at the clock while something lasts of which no part is known

# takes what is waited for, and since how many seconds; an empty text when that has ended
Tell = Callable[[str, float], object]
listeners: list[Tell] = []  # of what is under way, the innermost last


class Progress:
    """Shows a bar on a terminal and in a notebook, and a line every few seconds elsewhere.

    Of a `total` of pieces, None if unknown, `done` were done before; if the work may end earlier
    (`at_most`), no time to go is known.  Pace and time to go leave out what is waited for (`wait`).
    """

    def __init__(
        self, total: int | None, unit: str, *, done: int = 0, quiet: bool = False,
        at_most: bool = False,
    ) -> None:  # fmt: skip
        self._total, self._unit, self._done, self._quiet = total, unit, done, quiet
        self._at_most, self._is_waiting = at_most, False
        self._began = self._printed = time.perf_counter()
        self._first = 0  # done with the first piece, most of whose time is that of compiling
        self._bar: tqdm[Any] | None = None

    def __enter__(self) -> Progress:
        if not self._quiet:
            self._bar = bar(total=self._total, initial=self._done, unit=self._unit)
        listeners.append(self.wait)
        return self

    def __exit__(self, *_: object) -> None:
        listeners.remove(self.wait)
        if self._bar is not None:
            self._bar.close()

    def wait(self, text: str, seconds: float) -> None:
        if self._bar is not None:
            self._bar.set_description_str(f"{text}: {seconds:.0f} s" if text else "")
            if not text:
                self._bar.start_t += seconds
                self._bar.last_print_t += seconds
        elif text and not (self._quiet or self._is_waiting):
            print(text, file=sys.stderr, flush=True)
        if not text:
            self._began += seconds
        self._is_waiting = bool(text)

    def note(self, count: int, words: str) -> None:
        """Add `count` pieces of work; `words` say how all of them went so far."""
        self._done += count
        if self._bar is not None:
            room = (self._bar.ncols or shutil.get_terminal_size().columns) - _BESIDE
            if len(words) > room:  # as many parts of the list as fit
                parts = words.split(", ")
                while parts and len(", ".join(parts)) + 5 > room:
                    parts.pop()
                words = ", ".join([*parts, "..."]) if parts else ""
            self._bar.set_postfix_str(words, refresh=False)
            self._bar.update(count)
            return
        now = time.perf_counter()
        if self._first == 0:
            self._first, self._began = self._done, now
        elif not self._quiet and now - self._printed >= LINE_EVERY:
            self._printed = now
            text = f"{self._done} {self._unit}s"
            if self._total is not None:
                most = "at most " * self._at_most
                text = f"{self._done} of {most}{self._total} {self._unit}s"
            if self._total is not None and not self._at_most:
                rate = (self._done - self._first) / (now - self._began)
                left = duration((self._total - self._done) / rate)
                text += f", {brief(rate)} a second, {left} to go"
            print(f"{text}; {words}", file=sys.stderr, flush=True)


def notice() -> Tell:
    """Return a `Tell` for Python: that of the innermost progress under way, or a `Notice`."""
    return listeners[-1] if listeners else Notice()


class Notice:
    """A `Tell` that shows a line on a terminal or in a notebook, and prints it once elsewhere."""

    def __init__(self) -> None:
        self._text = ""
        self._bar: tqdm[Any] | None = None

    def __call__(self, text: str, seconds: float) -> None:
        if text and not self._text:
            self._bar = bar(total=0, bar_format="{desc}")
            if self._bar is None:
                print(text, file=sys.stderr, flush=True)
        if self._bar is not None:
            since = f"{seconds:.0f} s"
            words = f"{text}: {since}" if text else f"{self._text}: done in {since}"
            self._bar.set_description_str(words)
            if not text:
                self._bar.close()
                self._bar = None
        self._text = text


class Clock:
    """Tells again and again, from a thread, how long something lasts."""

    def __init__(self, tell: Tell, words: Callable[[float], str]) -> None:
        """Begin to tell: `words` returns the text after so many seconds."""
        self._tell, self._began, self._ended = tell, time.perf_counter(), threading.Event()
        tell(words(0.0), 0.0)

        def run() -> None:
            while not self._ended.wait(TICK):
                seconds = time.perf_counter() - self._began
                tell(words(seconds), seconds)

        self._thread = threading.Thread(target=run, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        self._ended.set()
        self._thread.join()
        self._tell("", time.perf_counter() - self._began)


def bar(**settings: Any) -> tqdm[Any] | None:
    """Return a bar with settings of tqdm's on a terminal or in a notebook; None elsewhere."""
    if not (in_notebook() or sys.stderr.isatty()):
        return None
    from tqdm import tqdm

    if not in_notebook():
        return tqdm(dynamic_ncols=True, **settings)
    from IPython.display import display

    class Bar(tqdm):
        """A bar of text in a cell's output, which needs no widgets and stays in the file."""

        place: Any = None

        def display(self, msg: str | None = None, pos: int | None = None) -> bool:
            shown = {"text/plain": str(self) if msg is None else msg}
            if self.place is None:
                self.place = display(shown, raw=True, display_id=True)
            else:
                self.place.update(shown, raw=True)
            return True

    return Bar(file=io.StringIO(), ncols=100, **settings)


def in_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


def size(count: int) -> str:
    value, unit = float(count), "B"
    for larger in ("kB", "MB", "GB", "TB"):
        if value < 999.5:  # which has three digits
            break
        value, unit = value / 1000, larger
    return f"{brief(value)} {unit}"


def brief(value: float) -> str:
    """Return a number with three digits, or all digits before the point: never 1.2e+03."""
    return f"{value:.3g}" if abs(value) < 999.5 else f"{value:.0f}"


def duration(seconds: float) -> str:
    if seconds < 119.5:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7170 else f"{seconds / 3600:.1f} h"
