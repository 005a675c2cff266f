"""What was measured: a setting of a method, how well the truth is known, and what came of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

from nlds_vines.accuracy.columns import Column

EXACT = tuple(float(f"1e-{k}") for k in range(3, 14))
"""Settings of `exact` from coarse to fine: tolerances."""

RK4 = (64, 128, 256, 512, 1024, 2048, 4096, 8192)
"""Settings of `rk4`: steps of a period."""


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
class Known:
    """How well the truth about a case is known.

    `doubt` is the distance of the last state from that of the first witness, or of stored digits
    from themselves in double precision; `growth` is at least 1.
    """

    source: Annotated[str, Column("1", "where the reference comes from")]
    doubt: Annotated[float, Column("m, m/s", "errors below this cannot be told from none")]
    independent: Annotated[float, Column("m, m/s", "distance of the reference from its witness")]
    witness: Annotated[str, Column("1", "independent program that confirms it, and its setting")]
    growth: Annotated[float, Column("1", "growth of a disturbance of the start until the end")]


@dataclass(frozen=True)
class Result:
    """What was measured of a method at a setting, on one case; NaN where there is no number.

    There is no `touch_error` where the numbers of touches differ or there are none, no `missed`
    where this way of using the solver cannot tell, no `steps` where they are not counted.  The
    `label` is `nT,k` as a recurrence tells it; empty where the truth is not periodic.
    """

    setting: Setting
    error: Annotated[
        float, Column("m, m/s", "of the last state, the largest of its components")
    ] = math.nan
    touch_error: Annotated[float, Column("s", "of the times of touch, the largest")] = math.nan
    missed: Annotated[float, Column("1", "touches missed; negative: invented")] = math.nan
    energy_error: Annotated[float, Column("J", "of E1max over the last half of the periods")] = (
        math.nan
    )
    label: Annotated[str, Column("1", "regime by recurrence, begun on the true orbit")] = ""
    seconds: Annotated[float, Column("s", "CPU time per forcing period, of all threads")] = math.nan
    steps: Annotated[
        float, Column("1", "steps, or nodes, of a contact: ours as set, others' counted")
    ] = math.nan
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
