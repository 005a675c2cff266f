"""What is measured, and what came of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nlds_vines.model.system import System


class SolverFailure(RuntimeError):
    """A solver broke down; the message is one sentence that says how."""


@dataclass(frozen=True)
class Case:
    """An orbit to be measured on: `start` is (x1, v1, x2, v2) [m, m/s] at t = 0, None for rest."""

    name: str
    system: System
    title: str
    start: tuple[float, ...] | None = None
    periods: int = 20

    @classmethod
    def of(cls, system: System, periods: int = 20) -> Case:
        """Return the case of any system, from rest."""
        name, omega = system.name or system.kind, system.parameters["omega"]
        title = f"{system.title or name}, ω = {omega:g} rad/s, from rest"
        return cls(name, system, title, periods=periods)

    @property
    def state(self) -> np.ndarray:
        """The start as an array (4,); (2,) without a damper."""
        if self.start is not None:
            return np.array(self.start)
        return np.zeros(2) if self.system.rest is None else np.array([0, 0, self.system.rest, 0.0])


@dataclass(frozen=True)
class Course:
    """What a solver found of one orbit.

    Attributes:
        section: x1, v1, x2, v2 [m, m/s] at t = T, 2T, ..., shape (periods, 4); (periods, 2), x1
            and v1, without a damper.
        touches: times of touch [s] in order; None where this way of using the solver cannot tell,
            and where they were not asked for. A contact in which the orbit begins is no touch.
        seconds: CPU time [s] of the time loop where it ran in another process, else None.
    """

    section: np.ndarray
    touches: np.ndarray | None
    seconds: float | None = None


@dataclass(frozen=True)
class Setting:
    """A method at one setting; the method is one curve of the picture.

    Attributes: `value`, the tolerance, the steps of a period or rtol, and the same in `words`;
    `ours`, True for a method of this program.
    """

    method: str
    value: float
    words: str
    ours: bool


@dataclass(frozen=True)
class Result:
    """Errors and cost of a method at a setting on one case; NaN where there is no number.

    Attributes:
        error: of the last state, the largest of its components [m, m/s].
        touch_error: of the times of touch, the largest [s]; NaN if their numbers differ or are 0.
        missed: number of touches missed, negative for invented ones; NaN if this way of using the
            solver cannot say.
        seconds: CPU time of a forcing period [s].
        failure: why there is no measurement.
    """

    setting: Setting
    error: float = math.nan
    touch_error: float = math.nan
    missed: float = math.nan
    seconds: float = math.nan
    failure: str = ""

    @property
    def complete(self) -> bool:
        """Return True if no touch was missed or invented, as far as can be told."""
        return not self.failure and (math.isnan(self.missed) or self.missed == 0)


@dataclass(frozen=True)
class Known:
    """The orbit that is followed, and how well its true states are known.

    Attributes:
        truth: the regime of the orbit.
        periods: forcing periods after which the error is taken.
        source: of the reference.
        doubt: distance of its last state from that of the other method [m, m/s]; smaller errors
            cannot be told from none.
        independent: distance of the reference from its `witness`, an independent program.
        growth: growth of a disturbance of the start until the end, at least 1.
    """

    name: str
    title: str
    truth: str
    periods: int
    source: str
    doubt: float
    independent: float
    witness: str
    growth: float


@dataclass(frozen=True)
class Measured:
    """All results on one case."""

    known: Known
    results: tuple[Result, ...]
