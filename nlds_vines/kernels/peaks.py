"""The largest energies of a flight, without sampling error.

dE1/dt = v1 n1 and dE2/dt = v2 n2, where each factor is linear in the state. An energy can peak
inside a cell only where a factor vanishes; that none does is proven from its values at the two ends
and a bound of its second derivative, as for touches. Where the proof fails, the roots of the
factor's Taylor polynomial, whose coefficients bound it better, are located piece by piece.
"""

from __future__ import annotations

import math

from .compiling import jit
from .flight import BOUNDS, CELLS, COEF, FACTOR, ORDER, at
from .observe import PRECISE, alike, energies, note_energy, powers_at
from .roots import narrowed, secant

ROOT_STEPS = 40  # of the search for a root: it needs some five
ALL = 15  # every factor is suspected: bits 0 to 3
FINEST = 1.0e-6  # piece of a cell over which a factor that stays at zero changes no energy


@jit
def factor_bends(ps, grid, second):
    """Return bounds of the second derivatives of the four factors by the place in a cell."""
    w, h2 = grid.table[BOUNDS:], grid.h * grid.h
    drive = ps.m1 * ps.force * ps.omega * ps.omega
    return w[0] * second * h2, (w[1] * second + drive) * h2, w[2] * second * h2, w[3] * second * h2


@jit
def proves_no_root(f, g, bend):
    """Prove that a factor has no root between its values f and g.

    They have one sign, and the factor either changes too little to reach zero in between or, by
    the mean value theorem, so much that it is monotone.
    """
    return alike(f, g) and (min(abs(f), abs(g)) > 0.125 * bend or abs(g - f) > bend)


@jit
def bodies(damper):
    """Return how many bodies have an energy."""
    if damper is None:
        return 1
    return 2


@jit
def suspects(ps, damper, energy, grid, bends, energy_bend, j, y, z):
    """Return which factors may vanish in cell j, from y to z, so that an energy sets a record.

    Bit i for factor i of `powers_at`; `energy_bend` bounds E1's second derivative by the place.
    """
    # hot: once per cell
    f = powers_at(ps, damper, y[0], y[1], y[2], y[3], grid.table[CELLS + 6 * j + 4], 0.0)
    g = powers_at(ps, damper, z[0], z[1], z[2], z[3], grid.table[CELLS + 6 * j + 10], 0.0)
    before = energies(ps, damper, y[0], y[1], y[2], y[3])
    after = energies(ps, damper, z[0], z[1], z[2], z[3])
    found = 0
    for body in range(bodies(damper)):
        rise = 0.125 * energy_bend * grid.table[BOUNDS + 4] if body == 1 else 0.125 * energy_bend
        if max(before[body], after[body]) + rise > energy[body]:
            for i in range(2 * body, 2 * body + 2):
                if not proves_no_root(f[i], g[i], bends[i]):
                    found |= 1 << i
    return found


@jit
def factor_row(ps, damper, which):
    """Return a factor of `powers_at` as weights of x1, v1, r, s and cos."""
    if which == 0:
        return 0.0, 1.0, 0.0, 0.0, 0.0
    if damper is None:
        return 0.0, -ps.m1 * ps.damping, 0.0, 0.0, ps.m1 * ps.force
    if which == 1:
        return 0.0, -ps.m1 * ps.damping, -damper.k2, -damper.c2, ps.m1 * ps.force
    if which == 2:
        return 0.0, 1.0, 0.0, -1.0, 0.0
    return damper.k2, 0.0, 0.0, damper.c2, 0.0


@jit
def factor_polynomial(ps, damper, grid, cosine, sine, which):
    """Fill the rows FACTOR with the Taylor coefficients of one factor over the expanded cell.

    cosine, sine: of the phase at the start. Returns a bound of its second derivative in the cell.
    """
    w = grid.table
    a, b, c, d, e = factor_row(ps, damper, which)
    angle = ps.omega * grid.h
    bend = 0.0
    for k in range(ORDER + 1):
        i = COEF + 4 * k
        f = (a * w[i] + b * w[i + 1]) + (c * w[i + 2] + d * w[i + 3]) + e * cosine
        w[FACTOR + k] = f
        bend += k * (k - 1.0) * abs(f)
        g = angle / (k + 1.0)
        cosine, sine = -sine * g, cosine * g
    return bend


@jit
def horner(w, x):
    """Return the value at x of the polynomial in the rows FACTOR of the table `w`."""
    total = w[FACTOR + ORDER]
    for k in range(ORDER - 1, -1, -1):
        total = total * x + w[FACTOR + k]
    return total


@jit
def note_at(ps, damper, energy, grid, x):
    """Raise the largest energies to those at place x of the expanded cell."""
    y = at(grid.table, x)
    note_energy(ps, damper, energy, y[0], y[1], y[2], y[3])


@jit
def root(w, low, high, f0, f1):
    """Return the place between low and high where the polynomial in the rows FACTOR is zero."""
    x = low
    for _ in range(ROOT_STEPS):
        x = secant(low, high, f0, f1)
        f = horner(w, x)
        if f == 0.0 or min(x - low, high - x) < PRECISE:
            break
        low, high, f0, f1 = narrowed(low, high, f0, f1, x, f)
    return x


@jit
def note_roots(ps, damper, energy, grid, bend, end):
    """Raise the energies at all roots in [0, end] of the polynomial in the rows FACTOR."""
    x, width = 0.0, end
    f, g = grid.table[FACTOR], horner(grid.table, end)
    while x < end:
        sag = bend * width * width
        if not alike(f, g) and abs(g - f) > sag:  # monotone: one root
            note_at(ps, damper, energy, grid, root(grid.table, x, x + width, f, g))
        elif not proves_no_root(f, g, sag):
            if width > FINEST * end and 0.0 < sag < math.inf:  # not zero throughout, nor overflown
                width *= 0.5
                g = horner(grid.table, x + width)
                continue
            note_at(ps, damper, energy, grid, x + width)
        x, f = x + width, g
        width = min(2.0 * width, end - x)
        g = horner(grid.table, x + width)


@jit
def note_peaks(ps, damper, energy, grid, cosine, sine, end, suspected):
    """Raise the largest energies to their maxima over [0, end] of the expanded cell.

    cosine, sine: of the phase at its start; `suspected`: the factors that may vanish (`suspects`).
    """
    for which in range(2 * bodies(damper)):
        if suspected & (1 << which):
            bend = factor_polynomial(ps, damper, grid, cosine, sine, which)
            note_roots(ps, damper, energy, grid, bend, end)
    note_at(ps, damper, energy, grid, end)
