"""Roots within a bracket, and bounds of a motion between the two ends of a piece.

A search for a sign change of f in [low, high] evaluates f at the place `secant` and continues with
the bracket of `narrowed`. This is the Pegasus method, a secant method that shrinks the value at the
end that stays, of order 1.6 (Dowell and Jarratt, BIT 12 (1972) 503). A search with a better guess,
such as Newton's, keeps it within the bracket by `guarded`. The caller decides when to stop.

The values f0, f1 and the slopes g0, g1 of a motion f at the two ends of a piece of length one bound
it in between. The cubic H with these values and slopes errs by

    |f - H| <= M / 384    and    |f' - H'| <= sqrt(3) M / 216,

M being a bound of the fourth derivative of f over the piece (Birkhoff and Priver 1967). In the
Bernstein basis, whose polynomials are nonnegative and add up to one, H and H' lie between their
smallest and largest coefficients:

    of H     f0, f0 + g0 / 3, f1 - g1 / 3, f1
    of H'    g0, 3 (f1 - f0) - g0 - g1, g1

For a piece of another length, slopes are multiplied by it and M by its fourth power.
"""

from __future__ import annotations

from .compiling import jit

ROOT_STEPS = 60  # most iterations of a search, which needs five to ten


@jit
def secant(low, high, f_low, f_high):
    """Return the zero of the straight line through (low, f_low) and (high, f_high)."""
    return low + (high - low) * f_low / (f_low - f_high)


@jit
def narrowed(low, high, f_low, f_high, x, f):
    """Return (low, high, f_low, f_high) of the part of a bracket, cut at x, that holds the root.

    f is the value at x. The value at the end that stays is multiplied by g / (g + f), g being the
    value at the end that x replaces, so that the next secant falls beyond the root and the other
    end moves, too. If f is much smaller than g this changes little, and the secant keeps its order.
    """
    if (f > 0.0) == (f_high > 0.0):
        return low, x, f_low * shrunk(f_high, f), f
    return x, high, f, f_high * shrunk(f_low, f)


@jit
def shrunk(before, f):
    """Return before / (before + f) for numbers of one sign, 1 if both are 0."""
    return before / (before + f) if before + f != 0.0 else 1.0


@jit
def guarded(guess, low, high):
    """Return the guess if it lies in (low, high), otherwise the middle of the bracket."""
    return guess if low < guess < high else 0.5 * (low + high)


# ---- bounds from two ends ------------------------------------------------------------------------

VALUE_ERROR = 1.0 / 384.0  # error of H over M, that of x^4 / 24 in the middle
SLOPE_ERROR = 0.008018753738744805  # error of H' over M, sqrt(3) / 216


@jit
def highest(f0, f1, g0, g1, fourth):
    """Return an upper bound of f over a piece; `fourth` is M."""
    top = max(max(f0, f1), max(f0 + g0 * (1.0 / 3.0), f1 - g1 * (1.0 / 3.0)))
    return top + VALUE_ERROR * fourth


@jit
def only_rises(f0, f1, g0, g1, fourth):
    """Return True if f is proven to rise monotonically over a piece; `fourth` is M."""
    return min(min(g0, g1), 3.0 * (f1 - f0) - g0 - g1) > SLOPE_ERROR * fourth
