"""What a user would choose instead: solvers of others, each used well and plainly.

All of them solve eq. (5) in its own variables x1, v1, x2, v2 and share no formula with the kernels.

    equation       eq. (5) and its events, compiled
    rival          what a rival is, and what all of them share
    plain          the classical Runge-Kutta method at a fixed step
    scipy_solvers  SciPy's solvers

Those that need further packages stand in `benchmarks/rivals` of a clone.
"""

from collections.abc import Iterable

from nlds_vines.accuracy.rivals import plain, scipy_solvers
from nlds_vines.accuracy.rivals.equation import constants, derivative
from nlds_vines.accuracy.rivals.rival import Asked, Course, Flow, Rival, RivalFailure

RIVALS: tuple[Rival, ...] = (*plain.RIVALS, *scipy_solvers.RIVALS)
"""Those that need nothing but what this program needs itself."""


def installed(rivals: Iterable[Rival]) -> tuple[Rival, ...]:
    """Return the rivals of which all that they need is installed."""
    return tuple(rival for rival in rivals if rival.available())


__all__ = [
    "RIVALS",
    "Asked",
    "Course",
    "Flow",
    "Rival",
    "RivalFailure",
    "constants",
    "derivative",
    "installed",
]
