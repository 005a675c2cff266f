"""Orbits followed until it is certain to which of the known periodic attractors they are drawn.

Around the section point y of a stable nT orbit lies a region, d' P d <= radius^2 for deviations d
from y, in which every n-fold return was seen to come nearer (`approaches`). P is chosen such that
the monodromy matrix M shortens all lengths: |M d| <= rate |d| with |d| = sqrt(d' P d). An orbit
that enters the region must still return as M foretells. No orbit is taken to belong to an attractor
because it is near.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.flight import PERIOD
from ..numerics.compiling import jit
from ..orbit.variations import new_state, no_section, place_state, run_on
from ..scene.codes import OK
from .cycles import cell_flow
from .settling import TINY

NO_ATTRACTOR = -1  # the attractor of an orbit that has come to no known one


class Known(NamedTuple):
    """The known periodic attractors, a row each; those of one system stand together."""

    periods: Any  # (m,) n of nT, integers
    points: Any  # (m, 4) section points (x1, v1, r, s)
    matrices: Any  # (m, 16) monodromy matrices, column by column
    forms: Any  # (m, 16) the symmetric matrices P
    radii: Any  # (m,) of the regions; 0: none
    rates: Any  # (m,) by which M shortens lengths, less than 1
    spans: Any  # (m,) the greatest length sqrt(y' P y) of the section points


class Drawn(NamedTuple):
    """To which known attractor orbits are drawn."""

    attractor: Any  # (orbits,) its row, -1: to none within the periods
    arrival: Any  # (orbits,) the periods until the orbit was in its region, -1: never
    status: Any  # (orbits,) of `codes`


@jit
def norm_of(form, d):
    """Return sqrt(d' P d) of a deviation d (4,)."""
    square = 0.0
    for i in range(4):
        for j in range(4):
            square += form[4 * i + j] * d[i] * d[j]
    return math.sqrt(max(square, 0.0))


@jit
def less(state, point, d):
    """Let d (4,) be the deviation of a state from a point."""
    for i in range(4):
        d[i] = state[i] - point[i]


@jit
def region_with(known, first, stop, state, d):
    """Return which of the attractors `first` to `stop` - 1 has the state in its region, or -1."""
    for a in range(first, stop):
        less(state, known.points[a], d)
        if norm_of(known.forms[a], d) <= known.radii[a]:
            return a
    return int(NO_ATTRACTOR)


@jit
def foretold(known, a, before, after):
    """Tell whether a deviation `before` (4,) returned to `after` as the monodromy matrix foretells.

    The error may be half of what the matrix shortens, so that the return is nearer in any case.
    """
    far = norm_of(known.forms[a], before)
    if far <= TINY * known.spans[a]:
        return norm_of(known.forms[a], after) <= TINY * known.spans[a]
    missed = np.empty(4)
    for i in range(4):
        missed[i] = after[i]
        for j in range(4):
            missed[i] -= known.matrices[a, 4 * j + i] * before[j]
    return norm_of(known.forms[a], missed) <= 0.5 * (1.0 - known.rates[a]) * far


@jit(entry=True)
def approaches(parts, cell, known, a, directions, radius):
    """Tell whether all returns from a sphere around attractor `a` are as its matrix foretells.

    directions (count, 4) of length 1 by its P: deviations of the `radius` in each of them are
    followed for n periods.
    """
    flow, status = cell_flow(parts, cell, PERIOD)
    if status != OK:
        return False
    state, y, before, after = new_state(), np.zeros(4), np.zeros(4), np.zeros(4)
    for k in range(len(directions)):
        for i in range(4):
            y[i] = known.points[a, i] + radius * directions[k, i]
        place_state(flow, y, state)
        less(state, known.points[a], before)  # what is beyond a rigid wall is put on it
        if run_on(flow, no_section(flow.space), known.periods[a], state) != OK:
            return False
        less(state, known.points[a], after)
        if not foretold(known, a, before, after):
            return False
    return True


@jit(entry=True)
def follow_to_known(begin, end, parts, cells, starts, search, drawn):
    """Follow orbits `begin` to `end` - 1 until they belong to a known attractor of their system.

    cells (orbits,) and starts (orbits, 4) at phase zero; search: (rows, known, most), where rows
    (orbits, 2) says which rows of `known` are the attractors of that system, the first one and the
    one after the last, and an orbit is given up after `most` periods. Fills `Drawn`.
    """
    rows, known, most = search
    found, arrival, status = drawn
    now, d, after = np.zeros(4), np.zeros(4), np.zeros(4)
    for lane in range(begin, end):
        flow, code = cell_flow(parts, cells[lane], PERIOD)
        state, p = new_state(), 0
        found[lane], arrival[lane] = int(NO_ATTRACTOR), -1
        if code == OK:
            place_state(flow, starts[lane], state)
        while code == OK and p <= most:
            a = region_with(known, rows[lane, 0], rows[lane, 1], state, d)
            if a == int(NO_ATTRACTOR):
                code = run_on(flow, no_section(flow.space), 1, state)
                p += 1
                continue
            for i in range(4):
                now[i] = d[i]
            code = run_on(flow, no_section(flow.space), known.periods[a], state)
            less(state, known.points[a], after)
            if code == OK and foretold(known, a, now, after):
                found[lane], arrival[lane] = a, p
                break
            p += known.periods[a]
        status[lane] = code
