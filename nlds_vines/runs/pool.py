"""Work on many lanes, handed out in pieces to the threads of this process.

Compiled kernels release the lock of Python's interpreter, so plain threads run them side by side.
Lanes take very different times: a thread that has finished its piece takes the next one, and the
pieces become smaller towards the end, where no thread may be left with a long one.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial

from nlds_vines.runs.interrupts import abandoned
from nlds_vines.runs.threads import threads_in_use

SHARE = 4
"""A piece is at most this part of one thread's share of the lanes that are left."""


def in_pieces(
    work: Callable[[int, int], object], lanes: int, least: int = 1, most: int | None = None
) -> None:
    """Call `work(begin, end)` for pieces that make up range(lanes), on the threads in use.

    Arguments: `least` lanes are worth a piece of their own; `most` lanes make a piece where a few
    lanes may take as long as all others.  Results may not depend on the pieces.

    What a piece raises is raised here, when no thread is at work any more; pieces that are not
    begun by then never are, nor where the work is abandoned (`interrupts.stoppable`).  The calling
    thread does its part.
    """
    threads = min(threads_in_use(), lanes // max(1, least))
    if threads < 2:
        work(0, lanes)
        return
    pieces = _Pieces(work, lanes, partial(size_of_piece, threads=threads, least=least, most=most))
    errors: list[BaseException] = []

    def help_out() -> None:
        try:
            pieces.run()
        except BaseException as error:
            errors.append(error)

    helpers = [threading.Thread(target=help_out, daemon=True) for _ in range(threads - 1)]
    for helper in helpers:
        helper.start()
    try:
        pieces.run()
    finally:
        for helper in helpers:
            helper.join()
    if errors:
        raise errors[0]


def size_of_piece(left: int, threads: int, least: int = 1, most: int | None = None) -> int:
    """Return how many of the lanes that are `left` make the next piece, between least and most."""
    share = left // (SHARE * threads)
    return min(left, max(least, share if most is None else min(share, most)))


class _Pieces:
    """The pieces that are left."""

    def __init__(
        self, work: Callable[[int, int], object], lanes: int, size: Callable[[int], int]
    ) -> None:
        self._work, self._lanes, self._size = work, lanes, size
        self._next, self._lock = 0, threading.Lock()
        self._abandoned = abandoned()

    def run(self) -> None:
        """Do one piece after another; an error stops the others, too."""
        try:
            while (piece := self._take()) is not None:
                self._work(*piece)
        except BaseException:
            with self._lock:
                self._next = self._lanes
            raise

    def _take(self) -> tuple[int, int] | None:
        with self._lock:
            if self._abandoned():
                self._next = self._lanes
            begin, left = self._next, self._lanes - self._next
            self._next += self._size(left)
            return (begin, self._next) if left else None
