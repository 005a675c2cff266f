"""What the catalogue found, as a page that reads well in a terminal and as Markdown."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator

from benchmarks.extremes.entry import Entry, Finding
from nlds_vines.cli.markdown_tables import table

_WIDTH = 100
_ABOUT = (
    "What is promised about extreme numbers, and what was measured. Each promise is a number with "
    "a bound that it must not exceed; a bound of 0 counts what went wrong. Errors of states are "
    "relative to the size of the motion. Where a promise could be greater, its section says what "
    "stands against it."
)
_HEADER = ("", "promise", "measured", "bound", "")


def page(found: Iterable[tuple[Entry, Finding]]) -> Iterator[str]:
    """Yield the lines of a page: an overview as a table, then a short section on each entry."""
    pairs = list(found)
    kept = sum(finding.passed for _, finding in pairs)
    yield from ("# Extremes", "")
    yield from textwrap.wrap(f"{_ABOUT} {kept} of {len(pairs)} promises are kept.", _WIDTH)
    yield ""
    yield from table(_HEADER, (_row(*pair) for pair in pairs), right=(0, 2, 3), padded=True)
    for entry, finding in pairs:
        yield ""
        yield from _section(entry, finding)


def _row(entry: Entry, finding: Finding) -> tuple[str, ...]:
    return (
        str(entry.number),
        entry.name,
        _number(finding.measured),
        _number(finding.bound),
        _verdict(finding),
    )


def _section(entry: Entry, finding: Finding) -> Iterator[str]:
    """Yield the promise, what was measured, and why no more is promised."""
    yield from (f"## {entry.number}. {entry.name[0].upper()}{entry.name[1:]}", "")
    yield from textwrap.wrap(entry.promise, _WIDTH)
    yield ""
    yield from textwrap.wrap(f"Measured: {finding.words} ({_verdict(finding)}).", _WIDTH)
    if entry.limit:
        yield ""
        yield from textwrap.wrap(f"Why not more: {entry.limit}", _WIDTH)


def _verdict(finding: Finding) -> str:
    return "kept" if finding.passed else "**broken**"


def _number(value: float) -> str:
    """Return a small count as such, and any other number with two digits."""
    counted = abs(value) < 1000.0 and value == round(value)
    return f"{value:.0f}" if counted else f"{value:.2g}"
