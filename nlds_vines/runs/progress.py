"""The progress of long work: how much is done, how fast it goes, when it will end."""

from __future__ import annotations

import io
import sys
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tqdm import tqdm

LINE_EVERY = 5.0
"""Seconds between lines of progress where there is no terminal."""

TICK = 1.0
"""Seconds between looks at the clock while something lasts of which no part is known."""


class Progress:
    """Shows a bar on a terminal and in a notebook, a line every few seconds elsewhere.

    It shows nothing when quiet.
    """

    def __init__(
        self,
        total: int | None,
        unit: str,
        *,
        done: int = 0,
        quiet: bool = False,
        at_most: bool = False,
    ) -> None:
        """Begin to count.

        Arguments: `total` pieces of work, None where it is not known, of which some are `done`
        before; `unit` is the singular of what is counted, an orbit or a design; `at_most` where the
        work may end earlier, so that no time to go is known.
        """
        self._total, self._unit, self._done, self._quiet = total, unit, done, quiet
        self._at_most = at_most
        self._began = self._printed = time.perf_counter()
        self._first = 0  # done with the first piece, most of whose time is that of compiling
        self._bar: tqdm[Any] | None = None
        self._waits = Lines(self.say)

    def __enter__(self) -> Progress:
        """Show the bar, if there is a terminal or a notebook."""
        if not self._quiet:
            self._bar = bar(total=self._total, initial=self._done, unit=self._unit)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the bar as it is."""
        if self._bar is not None:
            self._bar.close()

    def say(self, text: str) -> None:
        """Show a line of text beside the progress."""
        if self._bar is not None:
            self._bar.write(text, file=sys.stderr)
        elif not self._quiet:
            print(text, file=sys.stderr, flush=True)

    def wait(self, text: str, seconds: float) -> None:
        """Show what is waited for, since so many seconds; an empty text where that has ended."""
        if self._bar is not None:
            self._bar.set_description_str(f"{text}: {seconds:.0f} s" if text else "")
        elif not self._quiet:
            self._waits(text, seconds)

    def note(self, count: int, words: str) -> None:
        """Add `count` pieces of work; `words` say how all of them went so far."""
        self._done += count
        if self._bar is not None:
            self._bar.set_postfix_str(words, refresh=False)
            self._bar.update(count)
            return
        now = time.perf_counter()
        if self._first == 0:
            self._first, self._began = self._done, now
        elif not self._quiet and now - self._printed >= LINE_EVERY:
            self._printed = now
            rate = (self._done - self._first) / (now - self._began)
            print(f"{self._pace(rate)}; {words}", file=sys.stderr, flush=True)

    def _pace(self, rate: float) -> str:
        """Return in words how much is done, how much a second, and how long the rest will take."""
        if self._total is None:
            return f"{self._done} {self._unit}s"
        if self._at_most:
            return f"{self._done} of at most {self._total} {self._unit}s"
        left = duration((self._total - self._done) / rate)
        return f"{self._done} of {self._total} {self._unit}s, {rate:.3g} a second, {left} to go"


Tell = Callable[[str, float], object]
"""Takes what is waited for, and since how many seconds; an empty text where that has ended."""


class Lines:
    """Prints what is waited for: one line, when the waiting begins."""

    def __init__(self, say: Callable[[str], object]) -> None:
        """Take what prints a line."""
        self._say, self._waiting = say, False

    def __call__(self, text: str, seconds: float) -> None:
        """Take what is waited for, as `Tell` has it."""
        if text and not self._waiting:
            self._say(text)
        self._waiting = bool(text)


class Notice:
    """What is waited for in Python, beside no work that is counted: one line that changes.

    Where there is neither a terminal nor a notebook, lines on standard error.
    """

    def __init__(self) -> None:
        """Show nothing yet."""
        self._text = ""
        self._bar: tqdm[Any] | None = None
        self._lines = Lines(lambda text: print(text, file=sys.stderr, flush=True))

    def __call__(self, text: str, seconds: float) -> None:
        """Take what is waited for, as `Tell` has it."""
        if text and self._bar is None:
            self._bar = bar(total=0, bar_format="{desc}")
        if self._bar is None:
            self._lines(text, seconds)
        elif text:
            self._text = text
            self._bar.set_description_str(f"{text}: {seconds:.0f} s")
        else:
            self._bar.set_description_str(f"{self._text}: done in {seconds:.0f} s")
            self._bar.close()
            self._bar = None


class Clock:
    """Tells again and again how long something lasts, from a thread of its own."""

    def __init__(self, tell: Tell, words: Callable[[float], str]) -> None:
        """Begin to tell: `words` returns what, after so many seconds."""
        self._tell, self._words = tell, words
        self._began, self._ended = time.perf_counter(), threading.Event()
        tell(words(0.0), 0.0)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._ended.wait(TICK):
            seconds = time.perf_counter() - self._began
            self._tell(self._words(seconds), seconds)

    def stop(self) -> None:
        """Tell that it has ended."""
        self._ended.set()
        self._thread.join()
        self._tell("", time.perf_counter() - self._began)


def bar(**settings: Any) -> tqdm[Any] | None:
    """Return a bar with settings of tqdm's: on a terminal or in a notebook, None elsewhere."""
    if in_notebook():
        return _notebook_bar(**settings)
    if not sys.stderr.isatty():
        return None
    from tqdm import tqdm

    return tqdm(dynamic_ncols=True, **settings)


def in_notebook() -> bool:
    """Return whether the program runs in a notebook, which shows what is displayed."""
    asked = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(asked, "kernel", None) is not None


def _notebook_bar(**settings: Any) -> tqdm[Any]:
    """Return a bar of text in a cell's output, which needs no widgets and stays in the file."""
    from IPython.display import display
    from tqdm import tqdm

    class Bar(tqdm):
        """A bar that is displayed anew in its place."""

        place: Any = None

        def display(self, msg: str | None = None, pos: int | None = None) -> bool:
            """Show the bar as it is now."""
            shown = {"text/plain": str(self) if msg is None else msg}
            if self.place is None:
                self.place = display(shown, raw=True, display_id=True)
            else:
                self.place.update(shown, raw=True)
            return True

    return Bar(file=io.StringIO(), ncols=100, **settings)


def size(count: int) -> str:
    """Return bytes in words."""
    value, unit = float(count), "B"
    for larger in ("kB", "MB", "GB", "TB"):
        if value < 1000:
            break
        value, unit = value / 1000, larger
    return f"{value:.3g} {unit}"


def duration(seconds: float) -> str:
    """Return a duration in words."""
    if seconds < 120:
        return f"{seconds:.2g} s"
    if seconds < 7200:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
