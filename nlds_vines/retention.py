"""Retention of tuning: what a damper loses when structure or force are not as tuned."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from nlds_vines.catalogue import catalogue
from nlds_vines.claims.evidence import Data, Evidence
from nlds_vines.pages import Curve, Page

ALONE = "none"
"""The system without a damper, which everything is measured against."""


@dataclass(frozen=True)
class Retained:
    """One damper at one value of what was changed.

    Arguments:
        damper: its catalogue name; `parameter` and `value` of what was changed.
        peak: largest E1max over the frequency [J], at `omega` [rad/s].
        tuned: E1max at the frequency of tuning [J].
        relative, relative_tuned: both over their values at the tuning.
        left: the peak over that of the structure alone at the same value.
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


def retained(recipe: Page, parameter: str, evidence: Evidence, short: str) -> list[Retained]:
    """Return a row for every damper and value on a page where one parameter changes.

    Arguments: the `recipe` and its `short` name, the `parameter` that its panels or its curves
    set, and the `evidence` of its curves.  Rows come by damper, then by value.

    Raises `Missing` where a curve has not been computed.
    """
    curves = {(c.scan.system.name, c.settings[parameter]): c for c in recipe.curves}

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
    for damper, value in curves:
        tuning = catalogue()[damper].parameters
        changed, base, alone = (
            data(damper, value),
            data(damper, tuning[parameter]),
            data(ALONE, value),
        )
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
