"""What was found, as Markdown: the summary by method, who is cheaper, and advice."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from benchmarks.accuracy.curves import DECADES, Curve, above, curves_of
from nlds_vines.accuracy.measured_cases import Measured
from nlds_vines.accuracy.picture import family_of
from nlds_vines.accuracy.tables import advice, duration, head, measurements, touches
from nlds_vines.cli.markdown_tables import table

COMPARED = (1e-6, 1e-9)
"""Errors at which the summary compares costs."""

_PAGE = """\
# Error against run time

Made by the command at the end of this page. Times are those of a shared machine: read the ratios.
Costs at an error are interpolated along the cheapest settings of a method; `rtol^p` says how the
error follows the tolerance. Peers marked `events` are used well: every contact is split at touch
and release; the others are used plainly, as one would at first, and touches are looked for among
their states. Only what found every touch counts as having reached an error: near grazing, a solver
that steps over the contact is cheap and hardly wrong, and misses every touch. In the
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


def summary(case: Measured) -> Iterator[str]:
    """Yield the table by method: observed order, cost at `COMPARED` and its ratio to `exact`."""
    curves = curves_of(case)
    ours = curves["exact"]
    costs = (text for error in COMPARED for text in (f"at {error:.0e}", "× exact"))
    head = ("method", "order", "best error", *costs)
    rows = (
        (
            curve.method,
            _order(curve),
            _best(curve),
            *(text for error in COMPARED for text in _cost(curve, ours, error)),
        )
        for curve in curves.values()
    )
    yield from table(head, rows, range(1, len(head)))


def verdict(case: Measured) -> str:
    """Say whether any method is cheaper than `exact`, and which are but miss touches."""
    curves = curves_of(case)
    ours = curves["exact"]
    reached = [error for error in DECADES if math.isfinite(ours.cost(error))]
    better = above(curves.values(), ours)
    if better:
        words = ", ".join(f"{method} at {error:.0e}" for method, error in better)
        return f"Cheaper than `exact`: {words}.{_blind(case)}"
    if not reached or all(found.setting.ours for found in case.results):
        return f"Nothing can be said of `exact` beside the solvers of others.{_blind(case)}"
    first, last = DECADES[0], reached[-1]
    return f"`exact` is the cheapest at every error from {first:.0e} to {last:.0e}.{_blind(case)}"


def _blind(case: Measured) -> str:
    """Say which methods are cheaper at their error than `exact`, but miss touches."""
    curves = curves_of(case)
    ours = curves["exact"]
    found = [
        f"{curve.method} with {blind.setting.words} ({touches(blind)}, {blind.error:.0e})"
        for curve in curves.values()
        for blind in curve.blind
        if blind.seconds < ours.cost(max(blind.error, case.doubt))
    ]
    return f" Cheaper, but blind: {'; '.join(found)}." if found else ""


def ratios(case: Measured) -> Iterator[str]:
    """Yield by how much the best rival of each family costs more than `exact` at `COMPARED`."""
    curves = curves_of(case)
    ours = curves["exact"]
    for error in COMPARED:
        if math.isinf(ours.cost(error)):
            yield f"At {error:.0e}: `exact` does not get there."
            continue
        costs: dict[str, tuple[float, str]] = {}
        for curve in curves.values():
            if not curve.results[0].setting.ours and math.isfinite(curve.cost(error)):
                entry = (curve.cost(error) / ours.cost(error), curve.method)
                family = family_of(curve.method)
                costs[family] = min(costs.get(family, (math.inf, "")), entry)
        words = "; ".join(f"{method} {ratio:.3g}" for ratio, method in sorted(costs.values()))
        yield f"At {error:.0e}, times the cost of `exact`: {words or 'no peer gets there'}."


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


def page(cases: Sequence[Measured], picture: str, command: str, every: bool = False) -> str:
    """Return the page: the picture, a summary of each case or `every` measurement, the command."""
    sections = "\n\n".join("\n".join(section(case, every)) for case in cases)
    return _PAGE.format(picture=picture, sections=sections, command=command)


def section(case: Measured, every: bool) -> Iterator[str]:
    """Yield the section of a case."""
    yield from (f"## {case.name}", "", *head(case), "")
    yield from (*measurements(case), "") if every else ()
    yield from (*summary(case), "", verdict(case), *ratios(case), advice(case, COMPARED[-1]))
