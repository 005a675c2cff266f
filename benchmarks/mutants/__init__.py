"""Mutants: small changes that make the kernels wrong, each with the tests that must notice it.

    mutant      one mutant, and how it is applied to a source
    trial       a copy of the checkout in which mutants are tried
    flights     mutants of scene, flight, touch, peaks, exact
    touches     mutants of the walk to a touch, of bounds, of the depth of contacts
    contacts    mutants of contacts, impacts, and Runge-Kutta steps
    limits      mutants of a limit that is watched inside contacts
    orbits      mutants of what is noted, of orbits, cells, lanes, variations, growth
    driven      mutants of variations that parameters drive
    verdicts    mutants of shooting, recurrence, settling, verdicts, elementary functions
    by_rule     mutants of any source, by rule: nobody lists those beside the kernels
    command     the command: `python -m benchmarks.mutants`

Every list is a tuple MUTANTS of its module. A line whose change no test notices is a line that no
test needs: either a test is missing, or the line goes.
"""

from __future__ import annotations

from benchmarks.mutants import (
    contacts,
    driven,
    flights,
    limits,
    orbits,
    touches,
    verdicts,
)
from benchmarks.mutants.mutant import Mutant

__all__ = ["MUTANTS", "Mutant"]

_LISTS = (flights, touches, contacts, limits, orbits, driven, verdicts)

MUTANTS: tuple[Mutant, ...] = tuple(mutant for module in _LISTS for mutant in module.MUTANTS)
"""All mutants."""
