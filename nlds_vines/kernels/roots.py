"""The one root finder of the kernels, in pieces: a compiled loop cannot cheaply take a function.

A loop that looks for a sign change of f in [low, high] tries the place `secant`, computes f there
and goes on with the bracket that `narrowed` returns (the Illinois method: a secant that halves the
value at an end that stays). A loop that has a better guess of its own, such as Newton's, keeps it
within the bracket by `guarded`. The caller decides when to stop.
"""

from __future__ import annotations

from .compiling import jit


@jit
def secant(low, high, f_low, f_high):
    """Return where the straight line through (low, f_low) and (high, f_high) is zero."""
    return low + (high - low) * f_low / (f_low - f_high)


@jit
def narrowed(low, high, f_low, f_high, x, f):
    """Return (low, high, f_low, f_high) of the half of a bracket, cut at x, that holds the root.

    f is the value at x. The value at the end that stays is halved, so that the next secant falls
    beyond the root and the other end moves too.
    """
    if (f > 0.0) == (f_high > 0.0):
        return low, x, 0.5 * f_low, f
    return x, high, f, 0.5 * f_high


@jit
def guarded(guess, low, high):
    """Return a guess that lies in (low, high), otherwise the middle of the bracket."""
    return guess if low < guess < high else 0.5 * (low + high)
