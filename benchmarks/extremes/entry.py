"""What an entry of the catalogue is, and what a check of it finds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """What was seen: the number `measured`, which must not exceed `bound`, and one sentence.

    A count of what went wrong has the bound 0.  NaN never passes.
    """

    measured: float
    bound: float
    passed: bool
    words: str


@dataclass(frozen=True)
class Entry:
    """A promise about extreme numbers, and the check that holds the program to it.

    Attributes:
        number: of the catalogue; several entries may share it.
        name: two or three words.
        promise: one sentence: what the program promises.
        check: measures it; takes no arguments and is the same from run to run.
        limit: why double precision, or a budget of work, allows no more; empty where nothing does.
        long: whether the check takes more than about ten seconds, once compiled.
    """

    number: int
    name: str
    promise: str
    check: Callable[[], Finding]
    limit: str = ""
    long: bool = False


def within(measured: float, bound: float, words: str) -> Finding:
    """Return the finding that `measured` should not exceed `bound`."""
    return Finding(float(measured), float(bound), bool(measured <= bound), words)


def broken(error: Exception) -> Finding:
    """Return the finding of a check that raised: no number, and the first line of the error."""
    first = next(iter(str(error).strip().splitlines()), "")
    words = f"{type(error).__name__}: {first}" if first else type(error).__name__
    return Finding(math.nan, math.nan, False, words.rstrip("."))
