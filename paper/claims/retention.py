"""Section 4: what remains of the tuning's effect, and Section 4.1: the stiffness changes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

import numpy as np

from nlds_vines.model.catalog import catalog
from paper.claims.claim import (
    Claim,
    Finding,
    Verdict,
    by_name,
    decided,
    listed,
    weighed,
)
from paper.claims.measured import Data, Evidence
from paper.request import FigureRequest

ALONE = "none"
"""The system without a damper, with which every damper is compared."""

DAMPERS = ("ssul-set6", "ssbl", "tmd")
STIFFNESSES = (3.0e4, 3.3e4, 3.6e4, 3.95e4, 4.3e4, 4.6e4, 5.0e4)
"""Values of k1 [N/m], chosen here: the paper prints only that of the tuning, 3.95e4."""

LITTLE = 0.15  # of the peak at the tuning, largest change that counts as insignificant
MUCH = 0.25  # of the peak at the tuning, least change that counts as strong
MUCH_LESS = 0.5  # of the loss on a softer structure, largest one on a stiffer that is much less


@dataclass(frozen=True)
class Retained:
    """One damper at one value of the changed parameter.

    Attributes:
        damper: its catalog name.
        parameter, value: the changed parameter and its value [SI].
        peak, omega: the largest E1max over the frequency [J], and its frequency [rad/s].
        tuned: E1max at the frequency of tuning [J].
        relative, relative_tuned: `peak` and `tuned` over their values at the tuning.
        left: `peak` over the peak of the structure alone at the same value.
    """

    damper: str
    parameter: str
    value: float
    peak: float
    omega: float
    tuned: float
    relative: float
    relative_tuned: float
    left: float


def retained(
    request: FigureRequest, parameter: str, evidence: Evidence, short: str
) -> list[Retained]:
    """Return a row for every damper and value in a figure in which one parameter changes.

    Arguments: the `request` and its `short` name; the `parameter` that its panels or its curves
    set; the `evidence` of its curves.  The rows are sorted by damper, then by value.

    Raises `Missing` where a curve has not been computed.
    """
    cases = {
        (scan.system.name, scan.system.parameters[parameter]): case
        for case, scan in request.scans.items()
    }

    def data(damper: str, value: float) -> Data:
        return evidence(short, cases[damper, value])

    rows = list(_rows(cases, parameter, data))
    order = list(catalog())
    return sorted(rows, key=lambda row: (order.index(row.damper), row.value))


def _rows(
    cases: Collection[tuple[str, float]],
    parameter: str,
    data: Callable[[str, float], Data],
) -> Iterator[Retained]:
    """Yield a row for each (damper, value) of `cases`; `data` returns the results of one."""
    for damper, value in cases:
        tuning = catalog()[damper].parameters
        changed, base = data(damper, value), data(damper, tuning[parameter])
        alone = data(ALONE, value)
        peak, omega = changed.peak()
        tuned = changed.at(tuning["omega"])
        yield Retained(
            damper,
            parameter,
            value,
            peak,
            omega,
            tuned,
            peak / base.peak()[0],
            tuned / base.at(tuning["omega"]),
            peak / alone.peak()[0],
        )


def name(damper: str, parameter: str, value: float) -> str:
    """Return the name of the curve of a damper with one parameter changed."""
    same = catalog()[damper].parameters[parameter] == value
    return damper if same else f"{damper}_{parameter}={value:g}"


def ratios(evidence: Evidence, damper: str, values: tuple[float, ...]) -> list[float]:
    """Return a damper's peaks at `values` of k1 [N/m], over its peak at the tuning."""
    base = evidence("4", damper).peak()[0]
    return [evidence("4", name(damper, "k1", k1)).peak()[0] / base for k1 in values]


def _softer() -> tuple[float, ...]:
    """Return the values of k1 below that of the tuning [N/m]."""
    return tuple(k1 for k1 in STIFFNESSES if k1 < catalog()["none"].parameters["k1"])


def _stiffer() -> tuple[float, ...]:
    """Return the values of k1 above that of the tuning [N/m]."""
    return tuple(k1 for k1 in STIFFNESSES if k1 > catalog()["none"].parameters["k1"])


def _resonance(evidence: Evidence) -> Finding:
    apart = []
    for k1 in STIFFNESSES:
        data = evidence("4", name("none", "k1", k1))
        apart.append(data.peak()[1] - float(np.sqrt(k1 / data.system.parameters["m1"])))
    text = f"without damper the peak is within {max(map(abs, apart)):.3f} rad/s of sqrt(k1 / m1)"
    return decided(max(map(abs, apart)) < 0.02, text)


def _up(evidence: Evidence) -> Finding:
    found = {damper: ratios(evidence, damper, _stiffer()) for damper in DAMPERS}
    text = f"peak over that of the tuning at k1 = {listed(_stiffer())} N/m: {by_name(found)}"
    return weighed(text, *(max(row) <= 1 + LITTLE for row in found.values()))


def _up_alike(evidence: Evidence) -> Finding:
    found = {damper: ratios(evidence, damper, _stiffer()) for damper in DAMPERS}
    apart = max(max(column) - min(column) for column in zip(*found.values(), strict=True))
    text = f"the ratios of the three differ by up to {apart:.2f}: {by_name(found)}"
    return decided(apart <= LITTLE, text)


def _down(evidence: Evidence) -> Finding:
    found = {damper: ratios(evidence, damper, _softer()) for damper in DAMPERS}
    text = f"peak over that of the tuning at k1 = {listed(_softer())} N/m: {by_name(found)}"
    return weighed(text, *(row[0] >= 1 + MUCH for row in found.values()))


def _stiffer_costs_less(evidence: Evidence) -> Finding:
    losses = {
        damper: [
            max(0.0, max(ratios(evidence, damper, way)) - 1) for way in (_stiffer(), _softer())
        ]
        for damper in DAMPERS
    }
    text = f"most that a peak grows on a stiffer, on a softer structure: {by_name(losses)}"
    less = (up < down and up <= MUCH_LESS * down for up, down in losses.values())
    return weighed(text, *less)


def _any_change(evidence: Evidence) -> Finding:
    values = (*_softer(), *_stiffer())
    found = {damper: ratios(evidence, damper, values) for damper in DAMPERS}
    text = f"peak over that of the tuning at k1 = {listed(values)} N/m: {by_name(found)}"
    return weighed(text, *(ratio > 1 for row in found.values() for ratio in row))


def _down_order(evidence: Evidence) -> Finding:
    found = {damper: ratios(evidence, damper, _softer()) for damper in DAMPERS}
    worst = all(
        max(found, key=lambda d: found[d][i]) == "ssul-set6"
        and min(found, key=lambda d: found[d][i]) == "tmd"
        for i in range(len(_softer()))
    )
    return decided(worst, f"ratios {by_name(found)}")


def _values(evidence: Evidence) -> Finding:
    text = f"not printed but for the tuning's; ours are {listed((*_softer(), *_stiffer()))} N/m"
    return Finding(Verdict.OPEN, text)


STIFFNESS_CHANGED = (
    Claim("4.1", "The structure resonates at sqrt(k1 / m1).", "4", _resonance),
    Claim(
        "4.1",
        "The values of k1 that were compared.",
        "4",
        _values,
    ),
    Claim(
        "4.1",
        "Any change of the stiffness makes the tuned dampers worse.",
        "4",
        _any_change,
        "each peak higher than that of the tuning",
    ),
    Claim(
        "4.1",
        "A stiffer structure costs much less than a softer one.",
        "4",
        _stiffer_costs_less,
        f"peaks grow at most {MUCH_LESS:g} times as much",
    ),
    Claim(
        "4.1",
        "A stiffer structure costs none of the three much.",
        "4",
        _up,
        f"no peak more than {100 * LITTLE:g} % up",
    ),
    Claim("4.1", "Then the three behave alike.", "4", _up_alike, f"ratios within {LITTLE:g}"),
    Claim(
        "4.1",
        "A softer structure costs all three much.",
        "4",
        _down,
        f"each peak {100 * MUCH:g} % up at the softest",
    ),
    Claim("4.1", "Then the SSul NES loses most and the TMD least.", "5", _down_order),
)
"""The claims of Section 4.1."""
