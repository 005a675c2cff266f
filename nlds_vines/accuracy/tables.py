"""What was measured on a case, in words: the table in Markdown, and what tolerance to take."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator

from nlds_vines.accuracy.measured_cases import Measured, Result
from nlds_vines.cli.markdown_tables import table


def lines(case: Measured, want: float) -> Iterator[str]:
    """Yield what is known of a case, all measurements, and advice."""
    yield from (*head(case), "", *measurements(case), "", advice(case, want))


def head(case: Measured) -> Iterator[str]:
    """Yield what a reader must know of a case: what is followed, and what is held to be true."""
    known = case.known
    text = (
        f"{known.title}. Error of the state after {known.periods} forcing periods, CPU time of a "
        f"period. Regime: {known.truth}. Reference: {known.source}; uncertain by "
        f"{known.doubt:.0e}; an independent witness ({known.witness}) is {known.independent:.0e} "
        f"from it. A disturbance of the start has grown {known.growth:.2g} times by then."
    )
    yield from textwrap.wrap(text, 100)


def measurements(case: Measured) -> Iterator[str]:
    """Yield the table of all measurements on a case."""
    head = ("method", "setting", "error", "touches", "CPU per period")
    yield from table(head, (_measurement(case, found) for found in case.results), (2, 3, 4))


def _measurement(case: Measured, found: Result) -> tuple[str, ...]:
    """Return a row of the table of measurements."""
    setting = found.setting
    if found.failure:
        return setting.method, setting.words, f"failed: {found.failure}"
    return (
        setting.method,
        setting.words,
        f"{found.error:.1e}" if found.error > case.known.doubt else f"< {case.known.doubt:.0e}",
        touches(found),
        duration(found.seconds),
    )


def advice(case: Measured, want: float) -> str:
    """Return a sentence with the cheapest setting of ours that reaches a wanted error.

    It is given as Python and `[sampling]` of a scan file take it.
    """
    what = f"The cheapest setting with an error of at most {want:g}"
    found = advised(case, want)
    if found is None:
        return f"{what}: none was measured."
    name = "period_steps" if found.setting.method == "rk4" else "tolerance"
    code = f'`method = "{found.setting.method}", {name} = {found.setting.value:g}`'
    return f"{what}: {code} ({found.error:.1e} at {duration(found.seconds)} a period)."


def advised(case: Measured, want: float) -> Result | None:
    """Return the cheapest of our settings that is good enough; None if none is.

    Good enough: no touch missed or invented, and an error of the state of at most `want`.
    """
    ours = (found for found in case.results if found.setting.ours and found.complete)
    enough = (found for found in ours if found.error <= want)
    return min(enough, key=lambda found: found.seconds, default=None)


def duration(seconds: float) -> str:
    """Return a time in words of a table, three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def touches(found: Result) -> str:
    """Return the error of the times of touch in words, or how many were missed or invented."""
    if found.missed > 0:
        return f"{found.missed:g} missed"
    if found.missed < 0:
        return f"{-found.missed:g} invented"
    return "" if math.isnan(found.touch_error) else f"{found.touch_error:.0e} s"
