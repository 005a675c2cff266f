"""Solvers of others that need further packages, each in one module that imports it when used.

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
    sundials,
)
from nlds_vines.accuracy.rivals import Rival

RIVALS: tuple[Rival, ...] = (
    *numbalsoda_solvers.RIVALS,
    *heyoka_taylor.RIVALS,
    *sundials.RIVALS,
    *diffrax_solvers.RIVALS,
    *octave.RIVALS,
)
"""All of them, whether installed or not."""
