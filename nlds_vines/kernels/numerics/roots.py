"""Roots within a bracket, and what the ends of a piece of motion prove of what lies between.

A loop that looks for a sign change of f in [low, high] tries the place `secant`, computes f there
and goes on with the bracket that `narrowed` returns: the Pegasus method, a secant that shrinks the
value at an end that stays, of order 1.6 (Dowell and Jarratt, BIT 12 (1972) 503). A loop that has a
better guess of its own, such as Newton's, keeps it within the bracket by `guarded`. The caller
decides when to stop.

The two ends prove where there is nothing to look for. The cubic H that has the values f0, f1 and
the slopes g0, g1 of a motion f at the ends of a piece of length one errs by

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

ROOT_STEPS = 60  # of a search, which needs five to ten


@jit
def secant(low, high, f_low, f_high):
    """Return the zero of the straight line through (low, f_low) and (high, f_high)."""
    return low + (high - low) * f_low / (f_low - f_high)


@jit
def narrowed(low, high, f_low, f_high, x, f):
    """Return (low, high, f_low, f_high) of the half of a bracket, cut at x, that holds the root.

    f is the value at x. The value at the end that stays is shrunk by g / (g + f), g being that at
    the end which x replaces, so that the next secant falls beyond the root and the other end moves,
    too. Where f is far less than g that changes little, and the secant keeps its order.
    """
    if (f > 0.0) == (f_high > 0.0):
        return low, x, f_low * shrunk(f_high, f), f
    return x, high, f, f_high * shrunk(f_low, f)


@jit
def shrunk(before, f):
    """Return before / (before + f), of two numbers of one sign: 1 where both vanish."""
    return before / (before + f) if before + f != 0.0 else 1.0


@jit
def guarded(guess, low, high):
    """Return a guess that lies in (low, high), otherwise the middle of the bracket."""
    return guess if low < guess < high else 0.5 * (low + high)


# ---- what two ends prove -------------------------------------------------------------------------

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
