"""The catalogue of extremes: what is promised about extreme numbers, and checks that measure it.

Every entry is a sentence a user may rely on, a number that it bounds, and a function that measures
that number afresh.  Where double precision or a budget of work allows no more, the entry says so.
The first twenty-two numbers are those that integrators with contact are commonly judged by.

Each check stands on its own, runs on one machine without a network, and gives the same number
whenever it is run.  What it holds a result against is one of these:

- a closed form, or a sequence made up to have a known nature;
- SciPy: the matrix exponential, DOP853 split by events, or rigid walls by both;
- a law of nature: energy, whose ledger sums up work along a trajectory of ours, reversal, volumes;
- digits stored beforehand, by two methods in quadruple precision: orders across contacts, nodes;
- another run of ours.  That shows that two agree, no more.  Exact and rk4: critical pair with
  impacts, beyond steel, chaos by statistics.  A refinement of the same method, which SciPy
  confirms: order of stepped contacts.  The same motion in other units: scaling, overflowing
  energies, denormal states, any length.  The same run again: bad lanes and links, whatever the
  order, without the compiler; a million periods later: phase with impacts.

What ends with a status, or is refused, is counted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from benchmarks.extremes import (
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
from benchmarks.extremes.entry import Entry, Finding, broken
from benchmarks.extremes.page import page

__all__ = ["CATALOGUE", "Entry", "Finding", "findings", "page"]

_MODULES = (flights, impacts, energy, scales, proportions, contacts, bounds, repetition, labels)

CATALOGUE: tuple[Entry, ...] = tuple(
    sorted(
        (entry for module in _MODULES for entry in module.ENTRIES), key=lambda entry: entry.number
    )
)
"""All entries, by number."""


def findings(entries: Iterable[Entry]) -> Iterator[tuple[Entry, Finding]]:
    """Check entries one at a time, each when it is asked for, and yield it with what was found.

    A check that raises is a promise that is not kept, and the next one follows.
    """
    for entry in entries:
        yield entry, _found(entry)


def _found(entry: Entry) -> Finding:
    """Return what a check finds; one that raises has found that its promise is broken."""
    try:
        return entry.check()
    except Exception as error:
        return broken(error)
