"""The catalogue of extremes: what is promised about extreme numbers, and checks that measure it.

Every entry is a sentence a user may rely on, a number that it bounds, and a function that measures
that number afresh.  Where double precision or a budget of work allows no more, the entry says so.
The first twenty-two numbers are those that integrators with contact are commonly judged by.

Each check stands on its own, runs on one machine without a network, and gives the same number
whenever it is run; its truth comes from a closed form, from SciPy, or from a law of nature, never
from an earlier result.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from nlds_vines.extremes import (
    bounds,
    contacts,
    energy,
    flights,
    impacts,
    labels,
    proportions,
    repetition,
    scales,
)
from nlds_vines.extremes.entry import Entry, Finding
from nlds_vines.extremes.page import page

__all__ = ["CATALOGUE", "Entry", "Finding", "findings", "page"]

_MODULES = (flights, impacts, energy, scales, proportions, contacts, bounds, repetition, labels)

CATALOGUE: tuple[Entry, ...] = tuple(
    sorted(
        (entry for module in _MODULES for entry in module.ENTRIES), key=lambda entry: entry.number
    )
)
"""All entries, by number."""


def findings(entries: Iterable[Entry]) -> Iterator[tuple[Entry, Finding]]:
    """Check entries one at a time, each when it is asked for, and yield it with what was found."""
    for entry in entries:
        yield entry, entry.check()
