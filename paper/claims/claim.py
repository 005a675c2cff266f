"""A claim, and the verdict on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from nlds_vines.model.catalog import catalog
from paper.claims.measured import Evidence, Missing


class Verdict(StrEnum):
    """The possible results of a check.

    A claim agrees in part where one measure of it holds and another does not, where it holds for
    some of the dampers it is made for, or only with another contact stiffness than the assumed one.
    """

    AGREE = "agree"
    PART = "agree in part"
    DIFFER = "differ"
    OPEN = "cannot be decided"
    NOT_RUN = "not computed"


@dataclass(frozen=True)
class Finding:
    """The result of a check: the verdict, and in one line what was measured."""

    verdict: Verdict
    text: str


Check = Callable[[Evidence], Finding]


@dataclass(frozen=True)
class Claim:
    """One claim of the paper.

    Arguments:
        where: the section, table or equation of the paper.
        statement: the claim in our own words.
        figure: short name of the request whose picture shows it.
        check: measures and decides; raises `Missing` without the data.
        rule: the meaning that a vague word (similar, slight) is given here.
    """

    where: str
    statement: str
    figure: str
    check: Check
    rule: str = ""


def judge(claim: Claim, evidence: Evidence) -> Finding:
    """Return the finding of a claim's check: "not computed" where its data are missing."""
    try:
        return claim.check(evidence)
    except Missing as missing:
        return Finding(Verdict.NOT_RUN, str(missing))


def decided(holds: bool | np.bool_, text: str) -> Finding:
    """Return the finding of a check with a definite result: agree where the claim `holds`."""
    return Finding(Verdict.AGREE if holds else Verdict.DIFFER, text)


def weighed(text: str, *holds: bool | np.bool_) -> Finding:
    """Return the finding of several measures of one claim: agree in part where some hold."""
    if any(holds) and not all(holds):
        return Finding(Verdict.PART, text)
    return decided(all(holds), text)


def tuning_frequency() -> float:
    """Return the frequency for which the dampers were tuned [rad/s]."""
    return catalog()["ssul-set6"].parameters["omega"]


def spans(omega: np.ndarray, chosen: np.ndarray) -> list[tuple[float, float]]:
    """Return the first and the last frequency of each run of `chosen` cells, both (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    pairs = zip(edges[::2], edges[1::2], strict=True)
    return [(float(omega[first]), float(omega[last - 1])) for first, last in pairs]


def maxima(values: np.ndarray, least: float) -> np.ndarray:
    """Return the indices of the local maxima of at least `least` times the highest value."""
    inner = values[1:-1]
    tops = (inner > values[:-2]) & (inner >= values[2:]) & (inner >= least * values.max())
    return np.flatnonzero(tops) + 1


def listed(values: object, form: str = "g") -> str:
    """Return numbers in one line, each in a format."""
    return ", ".join(f"{value:{form}}" for value in np.ravel(np.asarray(values)).tolist())


def by_name(found: dict[str, list[float]], form: str = ".2f") -> str:
    """Return numbers by the name of a damper in one line: `ssbl 0.55, 0.61; tmd 0.65`."""
    return "; ".join(f"{name} {listed(values, form)}" for name, values in found.items())
