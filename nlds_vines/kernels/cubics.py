"""What values and slopes at the two ends of a piece prove of the motion between them.

The cubic H that has the values f0, f1 and the slopes g0, g1 of a motion f at the ends of a piece of
length one errs by

    |f - H| <= M / 384    and    |f' - H'| <= sqrt(3) M / 216,

M being a bound of the fourth derivative of f over the piece (Birkhoff and Priver 1967). Written in
Bernstein's polynomials, which are nowhere negative and add up to one, H and H' lie between the
least and the largest of their coefficients:

    of H     f0, f0 + g0 / 3, f1 - g1 / 3, f1
    of H'    g0, 3 (f1 - f0) - g0 - g1, g1

For a piece of another length, slopes are multiplied by it and M by its fourth power.
"""

from __future__ import annotations

from .compiling import jit

VALUE_ERROR = 1.0 / 384.0  # of H per M: that of x^4 / 24 in the middle
SLOPE_ERROR = 0.008018753738744805  # of H' per M, sqrt(3) / 216


@jit
def highest(f0, f1, g0, g1, fourth):
    """Return a bound of f over a piece; `fourth` is M."""
    top = max(max(f0, f1), max(f0 + g0 * (1.0 / 3.0), f1 - g1 * (1.0 / 3.0)))
    return top + VALUE_ERROR * fourth


@jit
def only_rises(f0, f1, g0, g1, fourth):
    """Prove that f rises all along a piece; `fourth` is M."""
    return min(min(g0, g1), 3.0 * (f1 - f0) - g0 - g1) > SLOPE_ERROR * fourth
