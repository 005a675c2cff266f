"""The table of an arc: where its numbers stand, and its nodes.

`hertz_arc` makes it; `impact` and what goes with it read the constants of one choice of nodes, and
write what belongs to the impact at hand.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..numerics.compiling import jit
from .impact_series import ALL_TERMS, factors_of

# The table of an arc.
#
#   from        numbers          what
#   AMPLITUDES  8 NODE_ROW       scratch at the nodes: unknowns and their derivatives by phi
#   INSIDE      7 NODE_ROW       what is known of the last few impacts (`inside`)
#   LEVELS      8 LEVEL          a row for each choice of nodes, from few to many (`NODES` ...)
#   USED        8                level of the nodes whose unknowns are there
#   PRODUCTS    NODE_ROW         terms of the series, products of the five small numbers
#   VARIATIONS  34 NODE_ROW      scratch of variations (`impact_variations`)
#   then        for each of them, of the whole arc and of its half, m being n in whole fours:
#                 ARC_U ...      39 m       rows of constants
#                 MATRIX         n m        from touch to each node, integrand by integrand
#                 then           3 x 36     coefficients of what the nodes miss: of b, t, energy
#
#   unknowns    AMPLITUDES    b, in which z = b^4 u^2 and s = v(b) S
#               TIMES         since touch [s]
#               COMMON_X, _V  x1 and v1 without the share of z and s: the motion of both masses
#               FB ... FH     the derivatives of these four by phi
#   constants   ARC_U, ARC_S  u = sqrt(z / z_m) and S = s / v
#               ARC_WEIGHT    of an integral over the whole interval
#               CUBE          integral of u^3
#               DOUBLE        integral of u CUBE
#               GB, GT        coefficients of the series of b / b0 - 1 and of time
NODE_ROW = 64
AMPLITUDES, TIMES, COMMON_X, COMMON_V, FB, FT, FG, FH = (NODE_ROW * i for i in range(8))
INSIDE = 8 * NODE_ROW
LEVELS, LEVEL, MOST_LEVELS = 15 * NODE_ROW, 6, 8
# n, places of the constants, C_n of each, error of sums over the free arc
NODES, WHOLE, HALF, ERROR, HALF_ERROR, SUMMED = range(LEVEL)
USED = LEVELS + LEVEL * MOST_LEVELS
PRODUCTS = USED + 8
VARIATIONS = PRODUCTS + NODE_ROW
CHANGES = VARIATIONS + 7 * NODE_ROW  # what the four change of each term, 3 NODE_ROW
CONSTANTS = VARIATIONS + 34 * NODE_ROW

# terms of the guess; of what the nodes miss: 36, in whole fours
GUESSED, MISSED = 17, len(ALL_TERMS)
ARC_U, ARC_S, ARC_WEIGHT, CUBE, DOUBLE, GB = range(6)  # in rows of m numbers, as the next two
GT, MATRIX = GB + GUESSED, GB + 2 * GUESSED
# places of the five small numbers in ALL_TERMS
AT_FORCE, AT_DRAG, AT_DRIFT, AT_SPRING, AT_CURVATURE = 1, 2, 3, 7, 10
FACTORS = np.array(factors_of(ALL_TERMS)).ravel()  # places of one for each term, then of the others

SETTLED = 0.03  # share of the tolerance that the sweeps may leave


class Arc(NamedTuple):
    """The Hertz arc at collocation nodes, prepared by `hertz_arc`.

    One array holds it all: each array of a tuple costs every call that hands it on.
    """

    tolerance: float  # error of an impact: of speed and time of release, and of its depth, relative
    settled: float  # what the sweeps may leave of it
    levels: int  # choices of nodes
    table: np.ndarray  # see above; what belongs to an impact is scratch


class Nodes(NamedTuple):
    """The nodes of one choice, on the whole arc or its half."""

    n: int
    m: int  # n in whole fours
    at: int  # place of the constants
    w: np.ndarray  # the table


@jit
def nodes_of(arc, level, part):
    """Return the `Nodes` of one level; `part` is WHOLE or HALF."""
    row = LEVELS + LEVEL * level
    n = int(arc.table[row + NODES])
    return Nodes(n, (n + 3) // 4 * 4, int(arc.table[row + part]), arc.table)


@jit
def level_for(arc, error, size):
    """Return the first level with C_n e^(3/2) within the tolerance, or the finest.

    error: ERROR or HALF_ERROR, the column of C_n; size: e of the impact.
    """
    scale = size * math.sqrt(size)
    for level in range(arc.levels - 1):
        if arc.table[LEVELS + LEVEL * level + error] * scale <= arc.tolerance:
            return level
    return arc.levels - 1
