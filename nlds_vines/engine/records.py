"""What is recorded of orbits: the words of requests, rows of impacts, modulation, statuses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from nlds_vines.errors import RequestError, checked_words
from nlds_vines.kernels.scene.codes import (
    BAD_PARAMETERS,
    DIVERGED,
    NOT_COMPUTED,
    OK,
    STEP_BUDGET,
    TOO_STIFF,
)
from nlds_vines.model.quantities import QUANTITIES, RECORDS, TOUCHES, stored_in
from nlds_vines.model.scenes import HOST, LONGEST_NAME, Scene

WANTS = RECORDS  # the words that `[record] want` accepts

# the default of `want`; `classify` and start orbits record the same and share its compiled kernels
USUAL = ("section", "impacts", "energy", "regime")

# the records of one orbit, by `simulate`
SIMULATED = ("section", "impacts", "energy", "peak", "response", "clearance", "trajectory")

ATTRACTOR = "attractor"  # the word for which orbits stop when their attractor is recognized

# the words that need a verdict; those that need states at equal steps, from a run of their own
JUDGED = frozenset({"regime", "lyapunov", "settling", "evidence", ATTRACTOR})
SPECTRAL = ("spectrum", "lines", "broadband")

NOTED = 4096  # number of last transient periods in which a verdict searches for the settling time

_SAMPLED = {word for entry in stored_in("section") for word in entry.record} | {"modulation"}
_TOUCHED = {word for entry in stored_in("touches") for word in entry.record}


def checked_want(want: object) -> tuple[str, ...]:
    names = checked_words("want", want, WANTS)
    return tuple(word for word in WANTS if word in names)


def possible_want(want: Sequence[str], scene: Scene) -> tuple[str, ...]:
    """Return the records of `want` that a scene has: without walls no impacts and clearances."""
    missing = {*RECORDS}.difference(
        *(entry.record[:1] for entry in QUANTITIES if entry.has(scene))
    )  # records of `simulate` alone are not in RECORDS
    missing |= {*scene.unrecorded}
    return tuple(word for word in want if word not in missing)


def refuse_impossible(want: Sequence[str], scene: Scene) -> None:
    """Raise `RequestError` for the first record of `want` that a scene does not have."""
    possible = possible_want(want, scene)
    for word in want:
        if word not in possible:
            lacks = "such record" if scene.walls else "wall"
            raise RequestError(
                f"want {word!r} cannot be had: kind {scene.kind!r} ({scene.meaning}) has no "
                f"{lacks}; allowed: {', '.join(possible_want(WANTS, scene))}"
            )


def plain(want: Collection[str]) -> tuple[str, ...]:
    return tuple(word for word in want if word != ATTRACTOR and word not in SPECTRAL)


def spectral(want: Collection[str]) -> tuple[str, ...]:
    return tuple(word for word in want if word in SPECTRAL)


def noted(want: Collection[str], transient: int, periods: int) -> int:
    """Return the number of periods whose section is stored while an orbit is computed."""
    judged = not JUDGED.isdisjoint(want)
    sampled = periods if judged or not _SAMPLED.isdisjoint(want) else 0
    return sampled + (min(transient, NOTED) if judged else 0)


def touches_noted(want: Collection[str], scene: Scene, periods: int) -> int:
    """Return the largest number of impacts of an orbit whose touches are stored."""
    return (
        TOUCHES * max(1, len(scene.dampers)) * periods
        if scene.walls and not _TOUCHED.isdisjoint(want)
        else 0
    )


# A row of `Orbit.impacts`: the body that is struck; times of touch and release [s]; approach speed
# [m/s]; peak force [N]; depth [m]; changes of E1 and E2 from touch to release [J].
IMPACT_NUMBERS = ("touch", "release", "speed", "force", "depth", "gain1", "gain2")
IMPACT = np.dtype([("wall", f"U{LONGEST_NAME}"), *((name, float) for name in IMPACT_NUMBERS)])


HOST_IMPACT = np.dtype(
    [
        ("damper", f"U{LONGEST_NAME}"),
        ("wall", "U1"),
        *((name, float) for name in (*IMPACT_NUMBERS[:5], "impulse")),
    ]
)
"""A row of the impacts of a host: damper; side of its wall; times of touch and release [s];
approach speed [m/s]; largest force [N]; depth [m]; largest impulse of a rigid wall [N s], 0 of
other walls."""


def impact_type(scene: Scene) -> np.dtype:
    """Return the type of the rows of `Orbit.impacts`."""
    return HOST_IMPACT if scene.kind == HOST else IMPACT


class Violation(NamedTuple):
    """Violations of a scene's limit, those of the transient included."""

    number: int  # of passages beyond the limit
    time: float  # of the first one [s]
    depth: float  # of the deepest one [m]


# ---- modulation: the amplitude of the response, and 1:1 capture ----

# Least and largest number of impacts per period of sustained 1:1 resonance, for a free mass between
# two walls.  Source: Weidemann, Bergman, Vakakis, Krack: Nonlinear Dyn. (2025), doi
# 10.1007/s11071-025-10928-4.
CAPTURED, MOST_CAPTURED = 1.99, 2.01

# the kinds of response by impacts per period, as codes
CAPTURE_FLAGS: Mapping[str, int] = {
    "no_impacts": 0, "strongly_modulated": 1, "sustained_1_to_1": 2, "more_impacts": 3,
}  # fmt: skip


def amplitudes_of(x: np.ndarray, v: np.ndarray, omega: np.ndarray) -> dict[str, np.ndarray]:
    """Return the datasets of the amplitude sqrt(x^2 + (v / omega)^2) by name, arrays (...).

    x and v (..., periods) are a displacement [m] and its rate in the section; omega (...) [rad/s].
    """
    rate = v / omega[..., np.newaxis]
    amplitude = np.sqrt(x * x + rate * rate)
    least = amplitude.min(axis=-1)
    largest = amplitude.max(axis=-1)
    ratio = np.divide(least, largest, out=np.ones_like(least), where=largest > 0.0)
    return {"amplitude_min": least, "amplitude_max": largest, "amplitude_ratio": ratio}


def amplitudes_of_rows(
    rows: Sequence[np.ndarray], section: np.ndarray, omega: np.ndarray
) -> dict[str, np.ndarray]:
    """Return `amplitudes_of` displacements w X with the `rows` w, arrays (..., displacements)."""
    columns: dict[str, list[np.ndarray]] = {}
    for row in rows:
        x = np.zeros(section.shape[:-1])
        v = np.zeros(section.shape[:-1])
        for j, weight in enumerate(row.tolist()):
            x = x + weight * section[..., 2 * j]
            v = v + weight * section[..., 2 * j + 1]
        for name, values in amplitudes_of(x, v, omega).items():
            columns.setdefault(name, []).append(values)
    return {name: np.stack(values, axis=-1) for name, values in columns.items()}


def modulation_of(
    section: np.ndarray, omega: np.ndarray, counts: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the datasets of the record `modulation` by name, arrays (...).

    The amplitude is sqrt(x^2 + (v / omega)^2), the modulus of Manevitch's variable over omega; it
    is constant for a harmonic motion at the frequency of the force.  Arguments: the `section`
    (..., periods, components) of the sampled periods; `omega` (...) [rad/s]; `counts` (..., 3),
    impacts at either wall and the periods with two of them.
    """
    periods = section.shape[-2]
    rate = counts[..., :2].sum(axis=-1) / periods
    conditions = [rate == 0.0, rate < CAPTURED, rate <= MOST_CAPTURED]
    return {
        **amplitudes_of(section[..., 0], section[..., 1], omega),
        "two_impacts": counts[..., 2] / periods,
        "capture": np.select(conditions, [0, 1, 2], 3),
    }


class Status(NamedTuple):
    """How the computation of an orbit ended."""

    name: str  # a CF word
    remedy: str  # a sentence

    @property
    def meaning(self) -> str:
        """Name and remedy as one CF word, `diverged.check_the_damping`: split at the dot."""
        words = self.remedy.rstrip(".").replace(",", "").replace(";", "").replace(":", "")
        return f"{self.name}.{words.replace(' ', '_')}"


STATUS: Mapping[int, Status] = {
    OK: Status("ok", "Nothing to do."),
    NOT_COMPUTED: Status("not_computed", "Finish the scan with --resume."),
    DIVERGED: Status("diverged", "Check masses, damping and forcing: the state grows unbounded."),
    STEP_BUDGET: Status("step_budget", "Raise omega or lower K: a period took too many steps."),
    BAD_PARAMETERS: Status("bad_parameters", "Vary within the ranges that the system allows."),
    TOO_STIFF: Status(
        "too_stiff", "Raise omega, masses or the steps of rk4, or lower stiffness or damping."
    ),
}
STATUS_FLAGS = {status.meaning: code for code, status in STATUS.items()}


def failures_in(status: np.ndarray) -> Counter[int]:
    return Counter(status[status != OK].tolist())


def failures_in_words(failures: Counter[int], orbits: int) -> str:
    """Return a sentence that counts the failures among all orbits, with remedies; "" for none."""
    if not failures:
        return ""
    reasons = (
        f"{count} {STATUS[code].name} ({STATUS[code].remedy.rstrip('.')})"
        for code, count in sorted(failures.items())
    )
    return f"{failures.total()} of {orbits} orbits failed: {'; '.join(reasons)}"
