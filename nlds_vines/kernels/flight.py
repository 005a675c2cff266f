"""Flight is linear, so it is exact.

A forcing period is cut into `n` equal cells. Over one cell the state is advanced by a constant
matrix and a forced response tabulated by phase: sixteen multiplications and no rounding beyond
them. Inside a cell every motion is a Taylor polynomial whose remainder lies below round-off, so
that any instant can be reached and any question about the path between samples answered.

Nothing here needs eigenvectors or a steady amplitude: a defective damper pair and an undamped
structure driven at resonance are flights like any other.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._jit import jit
from .parts import accelerations

ORDER = 14  # of the Taylor polynomials
TERMS = 4 * (ORDER + 1)  # coefficients of the four state components
REACH = 0.7  # longest cell in units of 1/rate: 0.7^15 / 15! = 4e-15, and the rate is a bound
FEWEST_CELLS = 8
MOST_CELLS = 1 << 16


class Grid(NamedTuple):
    """One period of flight, prepared: everything that depends on the parameters alone."""

    n: int  # cells in a period
    h: float  # length of a cell [s]
    rate: float  # bound on the growth of the scaled state per second [1/s]
    push: float  # P / sqrt(m1): bound on the growth of the energy scale S
    bend: float  # |d2r/dt2| <= bend * S + P / m1
    turns: tuple  # bounds of powers and of E2 (`turns_of`)
    step: np.ndarray  # (16,) transition matrix over a cell, column by column
    forced: np.ndarray  # (4 n,) forced response over each cell
    cosine: (
        np.ndarray
    )  # (n + 1,) cos of the phase at the start of each cell, and of the next period
    sine: np.ndarray  # (n + 1,)
    taylor: np.ndarray  # (6 TERMS,) coefficients answering x1, v1, r, s, cos, sin
    coef: np.ndarray  # (TERMS,) scratch: coefficients of the cell being looked at
    factor: np.ndarray  # (ORDER + 1,) scratch: those of a quantity followed through it


@jit
def rate_of(ps, damper):
    """Return a bound [1/s] on the rates of the linear motion and of the forcing.

    In energy coordinates (sqrt(k1) x1, sqrt(m1) v1, sqrt(k2) r, sqrt(m2) v2) the system's matrix is
    symmetric but for signs, so that its largest row sum bounds its norm.
    """
    on_v1 = math.sqrt(ps.stiffness) + ps.damping
    if damper is None:
        return max(on_v1, ps.omega)
    drag1 = damper.c2 * damper.inv_m1
    drag2 = damper.c2 / damper.m2
    across = math.sqrt(drag1 * drag2)
    pull1, pull2 = math.sqrt(damper.k2 * damper.inv_m1), math.sqrt(damper.k2 / damper.m2)
    on_v1 += drag1 + pull1 + across
    on_v2 = pull2 + drag2 + across
    return max(max(on_v1, on_v2), max(pull1 + pull2, ps.omega))


@jit
def bend_of(ps, damper):
    """Return the factor b with |d2r/dt2| <= b S + P/m1, S the energy scale of `scale_of`.

    The dual norm of the row of eq. (5) that gives d2r/dt2, in energy coordinates.
    """
    if damper is None:
        return 0.0
    on_v2 = damper.c2 * damper.inv_mu
    on_v1 = ps.damping + on_v2
    squares = ps.stiffness * ps.stiffness / ps.k1
    squares += on_v1 * on_v1 / ps.m1
    squares += damper.k2 * damper.inv_mu * damper.inv_mu
    squares += on_v2 * on_v2 / damper.m2
    return math.sqrt(squares)


@jit
def turns_of(ps, damper):
    """Return the largest v1, n1, v2, n2 (`observe.powers_at`) per S, and the largest 2 E2 / S^2."""
    root1 = math.sqrt(ps.m1)
    if damper is None:
        return 1.0 / root1, ps.damping * root1, 0.0, 0.0, 0.0
    root2 = math.sqrt(damper.m2)
    drag = damper.c2 * (1.0 / root1 + 1.0 / root2)
    absolute = 1.0 + math.sqrt(damper.k2 / ps.k1)  # of the damper's displacement
    return (
        1.0 / root1,
        ps.damping * root1 + math.sqrt(damper.k2) + drag,
        1.0 / root2,
        damper.k2 / math.sqrt(ps.k1) + drag,
        1.0 + absolute * absolute,
    )


@jit
def cells_of(ps, damper):
    """Return the number of cells in a period: enough for the Taylor polynomials, or -1."""
    period = 2.0 * math.pi / ps.omega
    need = math.ceil(period * rate_of(ps, damper) / REACH)
    if not need <= MOST_CELLS:
        return -1
    return max(FEWEST_CELLS, int(need))


@jit
def expand(ps, damper, h, x1, v1, r, s, cosine, sine, out, first):
    """Write the Taylor coefficients of a flight into out[first : first + TERMS].

    They belong to the time in units of h, counted from the given state and phase:
    y(x h) = sum_k out[first + 4 k + component] x^k.
    """
    out[first], out[first + 1], out[first + 2], out[first + 3] = x1, v1, r, s
    for k in range(ORDER):
        dv, ds = accelerations(ps, damper, x1, v1, r, s, cosine, 0.0)
        g = h / (k + 1.0)
        x1, v1, r, s = v1 * g, dv * g, s * g, ds * g
        cosine, sine = -ps.omega * sine * g, ps.omega * cosine * g
        at = first + 4 * k + 4
        out[at], out[at + 1], out[at + 2], out[at + 3] = x1, v1, r, s


@jit
def look(grid, x1, v1, r, s, cosine, sine):
    """Fill grid.coef with the Taylor coefficients of the flight that starts at the given state.

    The same numbers as `expand`, as one product with the prepared responses: no step waits for
    the one before.
    """
    t, coef = grid.taylor, grid.coef
    for k in range(TERMS):
        coef[k] = (
            (t[k] * x1 + t[TERMS + k] * v1)
            + (t[2 * TERMS + k] * r + t[3 * TERMS + k] * s)
            + (t[4 * TERMS + k] * cosine + t[5 * TERMS + k] * sine)
        )


@jit
def at(coef, x):
    """Return the state (x1, v1, r, s) at x cells after the start of the polynomial `coef`."""
    k = TERMS - 4
    x1, v1, r, s = coef[k], coef[k + 1], coef[k + 2], coef[k + 3]
    while k > 0:
        k -= 4
        x1 = x1 * x + coef[k]
        v1 = v1 * x + coef[k + 1]
        r = r * x + coef[k + 2]
        s = s * x + coef[k + 3]
    return x1, v1, r, s


@jit
def grid_of(ps, damper, n):
    """Prepare one period of flight in `n` cells (see `cells_of`)."""
    h = 2.0 * math.pi / ps.omega / n
    taylor = np.zeros(6 * TERMS)
    expand(ps, damper, h, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, taylor, 0)
    expand(ps, damper, h, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, taylor, TERMS)
    expand(ps, damper, h, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, taylor, 2 * TERMS)
    expand(ps, damper, h, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, taylor, 3 * TERMS)
    expand(ps, damper, h, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, taylor, 4 * TERMS)
    expand(ps, damper, h, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, taylor, 5 * TERMS)
    response = np.zeros(24)  # what each of the six unit inputs becomes after a whole cell
    for i in range(6):
        for k in range(ORDER, -1, -1):
            for c in range(4):
                response[4 * i + c] += taylor[i * TERMS + 4 * k + c]
    forced, cosine, sine = np.empty(4 * n), np.empty(n + 1), np.empty(n + 1)
    cosine[n], sine[n] = 1.0, 0.0
    for j in range(n):
        phase = 2.0 * math.pi * j / n
        cosine[j], sine[j] = math.cos(phase), math.sin(phase)
        for c in range(4):
            forced[4 * j + c] = response[16 + c] * cosine[j] + response[20 + c] * sine[j]
    return Grid(
        n,
        h,
        rate_of(ps, damper),
        ps.force * math.sqrt(ps.m1),
        bend_of(ps, damper),
        turns_of(ps, damper),
        response[:16],
        forced,
        cosine,
        sine,
        taylor,
        np.empty(TERMS),
        np.empty(ORDER + 1),
    )


@jit
def step(damper, e, forced, j, x1, v1, r, s):
    """Return the state one cell later, starting at the beginning of cell j."""
    f = 4 * j
    if damper is None:
        return (
            (e[0] * x1 + e[4] * v1) + forced[f],
            (e[1] * x1 + e[5] * v1) + forced[f + 1],
            0.0,
            0.0,
        )
    return (
        (e[0] * x1 + e[4] * v1) + (e[8] * r + e[12] * s) + forced[f],
        (e[1] * x1 + e[5] * v1) + (e[9] * r + e[13] * s) + forced[f + 1],
        (e[2] * x1 + e[6] * v1) + (e[10] * r + e[14] * s) + forced[f + 2],
        (e[3] * x1 + e[7] * v1) + (e[11] * r + e[15] * s) + forced[f + 3],
    )


@jit
def period_map(ps, damper, grid):
    """Return (matrix, shift) of a whole period without contact: y(T) = matrix y(0) + shift.

    Shapes (16,) column by column and (4,). What a scene without walls needs for its sections.
    """
    matrix, shift, y = np.zeros(16), np.zeros(4), np.zeros(4)
    silent = np.zeros(4 * grid.n)
    for i in range(5):
        y[:] = 0.0
        if i < 4:
            y[i] = 1.0
        drive = silent if i < 4 else grid.forced
        for j in range(grid.n):
            y[0], y[1], y[2], y[3] = step(damper, grid.step, drive, j, y[0], y[1], y[2], y[3])
        if i < 4:
            matrix[4 * i : 4 * i + 4] = y
        else:
            shift[:] = y
    return matrix, shift


@jit
def phase_at(ps, grid, j, x):
    """Return (cos, sin) of the forcing's phase at place x of cell j."""
    if x == 0.0:
        return grid.cosine[j], grid.sine[j]
    phase = ps.omega * grid.h * (j + x)
    return math.cos(phase), math.sin(phase)
