"""What a user would choose instead: solvers of others, each used well and plainly.

All of them solve eq. (5) in its own variables x1, v1, x2, v2 and share no formula with the kernels.
The last five need further packages; each imports its own when it is used.

    equation             eq. (5) and its events, compiled
    rival                what a rival is, and what all of them share
    plain                the classical Runge-Kutta method at a fixed step
    scipy_solvers        SciPy's solvers
    numbalsoda_solvers   compiled DOP853 and LSODA
    heyoka_taylor        Taylor series
    sundials             BDF and Adams of SUNDIALS, by scikit-sundae
    diffrax_solvers      Tsit5, Dopri8 and Kvaerno5, compiled by XLA
    octave               GNU Octave's ode23s, the paper's solver

A rival whose package is not installed is listed all the same.
"""

from benchmarks.rivals import (
    diffrax_solvers,
    heyoka_taylor,
    numbalsoda_solvers,
    octave,
    plain,
    scipy_solvers,
    sundials,
)
from benchmarks.rivals.rival import Rival

RIVALS: tuple[Rival, ...] = (
    *plain.RIVALS,
    *scipy_solvers.RIVALS,
    *numbalsoda_solvers.RIVALS,
    *heyoka_taylor.RIVALS,
    *sundials.RIVALS,
    *diffrax_solvers.RIVALS,
    *octave.RIVALS,
)
"""All of them, whether installed or not."""


def installed() -> tuple[Rival, ...]:
    """Return the rivals of which all that they need is installed."""
    return tuple(rival for rival in RIVALS if rival.available())
