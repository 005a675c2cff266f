"""Section 4: how much of the tuning's effect remains when the structure or the force changes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from nlds_vines.model.catalogue import catalogue
from nlds_vines.reproduce.claims.claim import (
    Check,
    Claim,
    Data,
    Evidence,
    Finding,
    Verdict,
    decided,
)
from nlds_vines.reproduce.request import Curve, FigureRequest

ALONE = "none"
"""The system without a damper, with which every damper is compared."""

DAMPERS = ("ssul-set6", "ssbl", "tmd")
STIFFNESSES = (3.0e4, 3.3e4, 3.6e4, 3.95e4, 4.3e4, 4.6e4, 5.0e4)
"""Values of k1 [N/m], chosen here: the paper prints only that of the tuning, 3.95e4."""

LITTLE = 0.15  # of the peak at the tuning, largest change that counts as insignificant
MUCH = 0.25  # of the peak at the tuning, least change that counts as strong
HIGH = 0.5  # of the peak without damper, least reduction that counts as high


@dataclass(frozen=True)
class Retained:
    """One damper at one value of the changed parameter.

    Attributes:
        damper: its catalogue name.
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
    curves = {(c.scan.system.name, c.settings[parameter]): c for c in request.curves}

    def data(damper: str, value: float) -> Data:
        return evidence(short, curves[damper, value].name)

    rows = list(_rows(curves, parameter, data))
    order = list(catalogue())
    return sorted(rows, key=lambda row: (order.index(row.damper), row.value))


def _rows(
    curves: Mapping[tuple[str, float], Curve],
    parameter: str,
    data: Callable[[str, float], Data],
) -> Iterator[Retained]:
    """Yield a row for each (damper, value) of `curves`; `data` returns the results of one."""
    for damper, value in curves:
        tuning = catalogue()[damper].parameters
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
    same = catalogue()[damper].parameters[parameter] == value
    return damper if same else f"{damper}_{parameter}={value:g}"


def ratios(evidence: Evidence, damper: str, values: tuple[float, ...]) -> list[float]:
    """Return a damper's peaks at `values` of k1 [N/m], over its peak at the tuning."""
    base = evidence("4", damper).peak()[0]
    return [evidence("4", name(damper, "k1", k1)).peak()[0] / base for k1 in values]


def _softer() -> tuple[float, ...]:
    """Return the values of k1 below that of the tuning [N/m]."""
    return tuple(k1 for k1 in STIFFNESSES if k1 < catalogue()["none"].parameters["k1"])


def _stiffer() -> tuple[float, ...]:
    """Return the values of k1 above that of the tuning [N/m]."""
    return tuple(k1 for k1 in STIFFNESSES if k1 > catalogue()["none"].parameters["k1"])


def _by_damper(found: dict[str, list[float]]) -> str:
    """Return ratios by damper in one line."""
    rows = (f"{damper} {', '.join(f'{r:.2f}' for r in row)}" for damper, row in found.items())
    return "; ".join(rows)


def _listed(values: tuple[float, ...]) -> str:
    """Return values in one line."""
    return ", ".join(f"{value:g}" for value in values)


def _resonance(evidence: Evidence) -> Finding:
    apart = []
    for k1 in STIFFNESSES:
        data = evidence("4", name("none", "k1", k1))
        apart.append(data.peak()[1] - float(np.sqrt(k1 / data.system.parameters["m1"])))
    text = f"without damper the peak is within {max(map(abs, apart)):.3f} rad/s of sqrt(k1 / m1)"
    return decided(max(map(abs, apart)) < 0.02, text)


def _up(evidence: Evidence) -> Finding:
    found = {damper: ratios(evidence, damper, _stiffer()) for damper in DAMPERS}
    worst = max(max(row) for row in found.values())
    text = f"peak over that of the tuning at k1 = {_listed(_stiffer())} N/m: {_by_damper(found)}"
    return decided(worst <= 1 + LITTLE, text)


def _up_alike(evidence: Evidence) -> Finding:
    found = {damper: ratios(evidence, damper, _stiffer()) for damper in DAMPERS}
    apart = max(max(column) - min(column) for column in zip(*found.values(), strict=True))
    text = f"the ratios of the three differ by up to {apart:.2f}: {_by_damper(found)}"
    return decided(apart <= LITTLE, text)


def _down(evidence: Evidence) -> Finding:
    found = {damper: ratios(evidence, damper, _softer()) for damper in DAMPERS}
    text = f"peak over that of the tuning at k1 = {_listed(_softer())} N/m: {_by_damper(found)}"
    return decided(all(row[0] >= 1 + MUCH for row in found.values()), text)


def _down_order(evidence: Evidence) -> Finding:
    found = {damper: ratios(evidence, damper, _softer()) for damper in DAMPERS}
    worst = all(
        max(found, key=lambda d: found[d][i]) == "ssul-set6"
        and min(found, key=lambda d: found[d][i]) == "tmd"
        for i in range(len(_softer()))
    )
    return decided(worst, f"ratios {_by_damper(found)}")


def _remains(figure: str, parameter: str, values: tuple[float, ...]) -> Check:
    """Return the check that each peak stays well below that of the structure alone."""

    def check(evidence: Evidence) -> Finding:
        cut = {
            damper: [
                1
                - evidence(figure, name(damper, parameter, v)).peak()[0]
                / evidence(figure, name("none", parameter, v)).peak()[0]
                for v in values
            ]
            for damper in DAMPERS
        }
        least = min(min(row) for row in cut.values())
        spread = max(max(row) - min(row) for row in cut.values())
        text = f"part of the peak taken off at {parameter} = {_listed(values)}: {_by_damper(cut)}"
        return decided(least >= HIGH and spread <= LITTLE, text)

    return check


def _best(figure: str, parameter: str, values: tuple[float, ...]) -> Check:
    """Return the check that the SSul NES has the lowest peak at each of the values."""

    def check(evidence: Evidence) -> Finding:
        peaks = {
            damper: [evidence(figure, name(damper, parameter, v)).peak()[0] for v in values]
            for damper in DAMPERS
        }
        rows = (f"{d} {', '.join(f'{E:.0f}' for E in row)}" for d, row in peaks.items())
        text = f"peaks [J] at {parameter} = {_listed(values)}: {'; '.join(rows)}"
        others = np.min([peaks["ssbl"], peaks["tmd"]], axis=0)
        return decided(bool(np.all(np.array(peaks["ssul-set6"]) < others)), text)

    return check


def _values(evidence: Evidence) -> Finding:
    text = f"not printed but for the tuning's; ours are {_listed((*_softer(), *_stiffer()))} N/m"
    return Finding(Verdict.OPEN, text)


_STAYS = (
    f"at least {100 * HIGH:g} % off each peak, within {100 * LITTLE:g} points of each damper's own"
)
_C1, _P = (352.0, 452.0, 552.0), (600.0, 800.0, 1000.0)

RETENTION = (
    Claim("4.1", "The structure resonates at sqrt(k1 / m1).", "4", _resonance),
    Claim(
        "4.1",
        "The values of k1 that were compared.",
        "4",
        _values,
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
    Claim(
        "4.2",
        "With c1 changed, the reduction stays high and similar.",
        "6",
        _remains("6", "c1", _C1),
        _STAYS,
    ),
    Claim(
        "4.2", "The SSul NES stays the best of the three as c1 changes.", "6", _best("6", "c1", _C1)
    ),
    Claim(
        "4.3",
        "With P changed, the reduction stays high and similar.",
        "7",
        _remains("7", "P", _P),
        _STAYS,
    ),
    Claim(
        "4.3", "The SSul NES stays the best of the three as P changes.", "7", _best("7", "P", _P)
    ),
)
"""The claims of Section 4."""
