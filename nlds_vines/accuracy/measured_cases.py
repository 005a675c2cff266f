"""What is measured, what came of it, and the table of an archive that holds it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.record_columns import Column, columns, record_of
from nlds_vines.model.system import System

SHAPE = "error against run time"
"""What an archive of such measurements says that it holds."""


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

    def to_table(self) -> Mapping[str, Any]:
        """Return the case as the archive keeps it: kind, all parameters, start, periods."""
        start = {} if self.start is None else {"start": list(self.start)}
        numbers = {name: float(value) for name, value in self.system.parameters.items()}
        return {"kind": self.system.kind, "periods": self.periods, **start, **numbers}


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
class Known:
    """What was followed, in words and numbers, and how well the truth about it is known.

    `doubt` is the distance of the last state from that of the other method, or of stored digits
    from themselves in double precision; `growth` is at least 1.
    """

    name: Annotated[str, Column("1", "what was followed", "case")]
    title: Annotated[str, Column("1", "the same in words")]
    truth: Annotated[str, Column("1", "regime of the orbit")]
    periods: Annotated[int, Column("1", "forcing periods after which the error is taken")]
    source: Annotated[str, Column("1", "where the reference comes from")]
    doubt: Annotated[float, Column("m, m/s", "errors below this cannot be told from none")]
    independent: Annotated[float, Column("m, m/s", "distance of the reference from its witness")]
    witness: Annotated[str, Column("1", "independent program that confirms it, and its setting")]
    growth: Annotated[float, Column("1", "growth of a disturbance of the start until the end")]


@dataclass(frozen=True)
class Setting:
    """A method at one setting; the method is one curve of the picture."""

    method: Annotated[str, Column("1", "integrator")]
    value: Annotated[float, Column("1", "its setting: tolerance, steps of a period, or rtol")]
    words: Annotated[str, Column("1", "its setting in words", "setting")]
    ours: Annotated[bool, Column("1", "1: of this program")]
    order: Annotated[
        float, Column("1", "order that the method has on smooth equations", "expected_order")
    ] = math.nan


@dataclass(frozen=True)
class Result:
    """What was measured of a method at a setting, on one case; NaN where there is no number.

    There is no `touch_error` where the numbers of touches differ or there are none, no `missed`
    where this way of using the solver cannot tell.
    """

    setting: Setting
    error: Annotated[
        float, Column("m, m/s", "of the last state, the largest of its components")
    ] = math.nan
    touch_error: Annotated[float, Column("s", "of the times of touch, the largest")] = math.nan
    missed: Annotated[float, Column("1", "touches missed; negative: invented")] = math.nan
    seconds: Annotated[float, Column("s", "CPU time per forcing period, of all threads")] = math.nan
    failure: Annotated[str, Column("1", "why there is no measurement")] = ""
    status: Annotated[
        bool, Column("1", "whether the measurement was made", flags={"ok": 0, "failed": 1})
    ] = field(init=False)

    def __post_init__(self) -> None:
        """Note whether there is a measurement."""
        object.__setattr__(self, "status", bool(self.failure))

    @property
    def complete(self) -> bool:
        """Whether no touch was missed or invented, as far as can be told."""
        return not self.failure and (math.isnan(self.missed) or self.missed == 0)


COLUMNS = columns(Known, Setting, Result)


@dataclass(frozen=True)
class Measured(Known):
    """What an archive says of one case: its words and numbers, and all results on it."""

    results: tuple[Result, ...]

    def by_method(self) -> dict[str, tuple[Result, ...]]:
        """Return the results of each method, from coarse to fine."""
        names = dict.fromkeys(found.setting.method for found in self.results)
        return {
            name: tuple(found for found in self.results if found.setting.method == name)
            for name in names
        }


def read_cases(view: ArchiveView) -> list[Measured]:
    """Return what an archive of measurements holds, case by case."""
    table = {name: view[name] for name in view.names}
    rows = [dict(zip(table, values, strict=True)) for values in zip(*table.values(), strict=True)]
    cases = []
    for name in dict.fromkeys(table["case"].tolist()):
        mine = [row for row in rows if row["case"] == name]
        results = (record_of(Result, row, setting=record_of(Setting, row)) for row in mine)
        cases.append(record_of(Measured, mine[0], results=tuple(results)))
    return cases
