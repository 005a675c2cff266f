"""What a survey found, as Markdown: every measurement, the summary by method, and advice."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence

from nlds_vines.accuracy.comparison_table import Measured
from nlds_vines.accuracy.curves import DECADES, Curve, above, advised
from nlds_vines.accuracy.results import Result
from nlds_vines.cli.markdown import table

COMPARED = (1e-6, 1e-9)
"""Errors at which the summary compares costs."""


_WIDTH = 100
_PAGE = """\
# Error against run time

Made by the command at the end of this page. Times are those of a shared machine: read the ratios.
Costs at an error are interpolated along the cheapest settings of a method; `rtol^p` says how the
error follows the tolerance. Peers marked `events` are used well: every contact is split at touch
and release; the others are used plainly, as one would at first, and touches are looked for among
their states. Only what found every touch counts as having reached an error: near grazing, a solver
that steps over the contact is cheap and hardly wrong, and says T,0 where T,1 is true. In the
picture, of each family of solvers only the cheapest settings are drawn; hollow marks missed or
invented touches.

A step of `naive RK4` takes no notice of touch and release. There the second derivative of the Hertz
force K z^1.5 is infinite, as z^-0.5: a step across errs by h^2.5, whatever the order of the method.
On an attracting orbit such errors die out, and those of the smooth pieces, h^4, may hide them for a
while; where h does not resolve a contact there is no order at all. `rk4` cuts its steps at touch
and release and keeps order four; `exact` has no steps in flight, and its tolerance bounds the error
of every contact.

![Error against run time]({picture})

{sections}

```sh
{command}
```
"""


def head(case: Measured) -> Iterator[str]:
    """Yield what a reader must know of a case: what is followed, and what is held to be true."""
    text = (
        f"{case.title}. Error of the state after {case.periods} forcing periods, CPU time of a "
        f"period. Regime: {case.truth}. Reference: {case.source}; uncertain by "
        f"{case.doubt:.0e}; an independent witness ({case.witness}) is {case.independent:.0e} "
        f"from it. A disturbance of the start has grown {case.growth:.2g} times by then."
    )
    yield from textwrap.wrap(text, _WIDTH)


def measurements(case: Measured) -> Iterator[str]:
    """Yield the table of all measurements on a case."""
    head = ("method", "setting", "error", "touches", "E1max", "label", "CPU per period")
    yield from table(head, (_measurement(case, found) for found in case.results), (2, 3, 4, 6))


def _measurement(case: Measured, found: Result) -> tuple[str, ...]:
    """Return a row of the table of measurements."""
    setting = found.setting
    if found.failure:
        return setting.method, setting.words, f"failed: {found.failure}"
    return (
        setting.method,
        setting.words,
        f"{found.error:.1e}" if found.error > case.doubt else f"< {case.doubt:.0e}",
        _touches(found),
        _number(found.energy_error, " J"),
        found.label,
        duration(found.seconds),
    )


def summary(case: Measured) -> Iterator[str]:
    """Yield the table by method: observed order, cost at `COMPARED` and its ratio to `exact`."""
    ours = case.curve("exact")
    costs = (text for error in COMPARED for text in (f"at {error:.0e}", "× exact"))
    head = ("method", "order", "best error", *costs)
    rows = (
        (
            curve.method,
            _order(curve),
            _best(curve),
            *(text for error in COMPARED for text in _cost(curve, ours, error)),
        )
        for curve in case.curves
    )
    yield from table(head, rows, range(1, len(head)))


def verdict(case: Measured) -> str:
    """Say whether any method is cheaper than `exact`, and which are but miss touches."""
    ours = case.curve("exact")
    reached = [error for error in DECADES if math.isfinite(ours.cost(error))]
    better = above(case.curves, ours)
    if better:
        words = ", ".join(f"{method} at {error:.0e}" for method, error in better)
        return f"Cheaper than `exact`: {words}.{_blind(case)}"
    if not reached or all(found.setting.ours for found in case.results):
        return f"Nothing can be said of `exact` beside the solvers of others.{_blind(case)}"
    first, last = DECADES[0], reached[-1]
    return f"`exact` is the cheapest at every error from {first:.0e} to {last:.0e}.{_blind(case)}"


def _blind(case: Measured) -> str:
    """Say which methods are cheaper at their error than `exact`, but miss touches."""
    ours = case.curve("exact")
    found = [
        f"{curve.method} with {blind.setting.words} ({_touches(blind)}, {blind.error:.0e})"
        for curve in case.curves
        for blind in curve.blind
        if blind.seconds < ours.cost(max(blind.error, case.doubt))
    ]
    return f" Cheaper, but blind: {'; '.join(found)}." if found else ""


def ratios(case: Measured) -> Iterator[str]:
    """Yield by how much the best rival of each family costs more than `exact` at `COMPARED`."""
    ours = case.curve("exact")
    for error in COMPARED:
        if math.isinf(ours.cost(error)):
            yield f"At {error:.0e}: `exact` does not get there."
            continue
        costs: dict[str, tuple[float, str]] = {}
        for curve in case.curves:
            if not curve.results[0].setting.ours and math.isfinite(curve.cost(error)):
                entry = (curve.cost(error) / ours.cost(error), curve.method)
                family = family_of(curve.method)
                costs[family] = min(costs.get(family, (math.inf, "")), entry)
        words = "; ".join(f"{method} {ratio:.3g}" for ratio, method in sorted(costs.values()))
        yield f"At {error:.0e}, times the cost of `exact`: {words or 'no peer gets there'}."


def advice(case: Measured, want: float | None) -> Iterator[str]:
    """Yield the cheapest setting of ours that reaches a wanted error, and that keeps the label."""
    if want is not None:
        yield _advised(case, want, f"The cheapest setting with an error of at most {want:g}")
    if any(found.label for found in case.results):
        what = f"The cheapest setting that, begun on the {case.truth} orbit, keeps its label"
        yield _advised(case, None, what)


def _advised(case: Measured, want: float | None, what: str) -> str:
    found = advised(case.results, want, case.truth)
    if found is None:
        return f"{what}: none was measured."
    code = call(found)
    return f"{what}: {code} ({found.error:.1e} at {duration(found.seconds)} a period)."


def call(found: Result) -> str:
    """Return the setting of a result of ours as Python takes it, and [sampling] of a scan file."""
    method, value = found.setting.method, found.setting.value
    name = "period_steps" if method == "rk4" else "tolerance"
    return f'`method = "{method}", {name} = {value:g}`'


def family_of(method: str) -> str:
    """Return the library that a method belongs to, and whether contacts are split by events."""
    if method in ("exact", "rk4"):
        return method
    name = method.split()[0]
    return f"{name}, events" if method.endswith("events") else name


def duration(seconds: float) -> str:
    """Return a time in words of a table, three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if seconds >= size or unit == "ns":
            return f"{seconds / size:.3g} {unit}"
    raise AssertionError("the smallest unit takes everything")


def number_words(value: float) -> str:
    """Return a number as it is read, nothing for NaN."""
    return "" if math.isnan(value) else f"{value:g}"


def _touches(found: Result) -> str:
    if found.missed > 0:
        return f"{found.missed:g} missed"
    if found.missed < 0:
        return f"{-found.missed:g} invented"
    return _number(found.touch_error, " s")


def _number(value: float, unit: str) -> str:
    return "" if math.isnan(value) else f"{value:.0e}{unit}"


def _order(curve: Curve) -> str:
    """Return the observed order in words: a power of the steps, or of the tolerance."""
    if math.isnan(curve.order):
        return ""
    power = f"{curve.order:.2g}"
    return f"rtol^{power}" if curve.results[0].setting.value < 1.0 else power


def _best(curve: Curve) -> str:
    if all(found.failure for found in curve.results):
        return f"failed: {curve.results[-1].failure}"
    if not curve.points:
        return "misses touches"
    return f"{min(error for error, _ in curve.points):.0e}"


def _cost(curve: Curve, ours: Curve, error: float) -> tuple[str, str]:
    """Return the cost of an error in words, and its ratio to that of `ours`."""
    cost = curve.cost(error)
    if math.isinf(cost):
        return "not reached", ""
    ratio = "" if math.isinf(ours.cost(error)) else f"{cost / ours.cost(error):.3g}"
    return duration(cost), ratio


def page(cases: Sequence[Measured], picture: str, command: str, want: float | None = None) -> str:
    """Return the page of a survey of several cases: the picture, a summary of each, the command.

    `want`: the error for which a setting is advised, by default the smaller of `COMPARED`.
    """
    wanted = COMPARED[-1] if want is None else want
    sections = "\n\n".join("\n".join(_section(case, wanted)) for case in cases)
    return _PAGE.format(picture=picture, sections=sections, command=command)


def _section(case: Measured, want: float) -> Iterator[str]:
    yield from (f"## {case.name}", "", *head(case), "", *summary(case), "")
    yield from (verdict(case), *ratios(case), *advice(case, want))
