"""The linear system of a host with its dampers, and its motion over a short time.

M X'' + C X' + K X + sum over links of w (k r + c s) = F f(t), r = w X and s = w X', with M = 1 of a
host's mode, so that K is the squares of its frequencies.

The force f is the first number e_0 of a drive e, which moves by itself: e_k' = paces_k e_(k + 1),
where e_0 follows on the last one. A harmonic force has e = (cos(omega t), sin(omega t)). Of a load
in time, a polynomial of the place in each period, e holds the coefficients of the powers of the
place from the instant on, so that paces_k is (k + 1) / period, and 0 of the last one.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..motion.flight import ORDER
from ..numerics.compiling import jit
from ..numerics.fours import four, four_at, put_four, sum_of

# rest of a move, relative to the state: that of the longest cell, 0.7^16 / 16!, is below it
MOVED = 2.1e-16


class Body(NamedTuple):
    """The linear system; each array is one row of numbers, in inner kernels a bare row."""

    modes: int  # of the host
    size: int  # coordinates X: modes, and masses of dampers
    links: int
    omega: float  # of the force [rad/s]; of a load in time, a rate up to that of its cells
    period: float  # [s]; shorter of orbits that are followed over a part of the force's period
    begun: float  # turns of a harmonic force before a period
    turns: float  # and within it
    drives: int  # numbers of the drive, even
    paces: Any  # (drives,) rates of the drive [1/s]
    squares: Any  # (modes,) of the modes' frequencies [1/s^2]
    damping: Any  # (modes,) of each mode [1/s]
    coupling: Any  # (modes * modes,) damping by other modes [1/s]; without it no numbers
    coupled: bool
    push: Any  # (size,) acceleration by a force of f = 1
    rows: Any  # (links * size,) w: of r by X
    answers: Any  # (links * size,) accelerations by a unit force along r [1/kg]
    stiffness: Any  # (links,) k of the links [N/m]
    dashpots: Any  # (links,) c of the links [N s/m]
    springs: Any  # `springs.Springs` of the forces beside k r, or None


@jit
def along(body, link, y, at):
    """Return (r, s) of a link, of the state that begins at y[at]."""
    row, size, R, S = link * body.size, body.size, four(0.0), four(0.0)
    whole = size // 4 * 4
    for i in range(0, whole, 4):
        w = four_at(body.rows, row + i)
        R, S = R + w * four_at(y, at + i), S + w * four_at(y, at + size + i)
    r, s = sum_of(R), sum_of(S)
    for i in range(whole, size):
        r += body.rows[row + i] * y[at + i]
        s += body.rows[row + i] * y[at + size + i]
    return r, s


@jit
def push_link(body, link, force, out, at):
    """Add the accelerations by a `force` [N] that acts against r of a link."""
    row, size = link * body.size, body.size
    whole = size // 4 * 4
    for i in range(0, whole, 4):
        put_four(out, at + i, four_at(out, at + i) - four_at(body.answers, row + i) * force)
    for i in range(whole, size):
        out[at + i] -= force * body.answers[row + i]


@jit
def accelerate(body, y, at, force, out, to):
    """Write the accelerations X'' of a flight under a force f to out[to : to + size]."""
    n, v = body.modes, at + body.size
    whole = n // 4 * 4
    for i in range(0, whole, 4):
        pushed = four_at(body.push, i) * force - four_at(body.squares, i) * four_at(y, at + i)
        put_four(out, to + i, pushed - four_at(body.damping, i) * four_at(y, v + i))
    for i in range(whole, n):
        pushed = body.push[i] * force - body.squares[i] * y[at + i]
        out[to + i] = pushed - body.damping[i] * y[v + i]
    for i in range(n, body.size):
        out[to + i] = body.push[i] * force
    if body.coupled:
        for j in range(n):
            for i in range(n):
                out[to + i] -= body.coupling[n * j + i] * y[v + j]
    for link in range(body.links):
        r, s = along(body, link, y, at)
        joint = body.stiffness[link] * r + body.dashpots[link] * s
        if joint != 0.0:
            push_link(body, link, joint, out, to)


@jit
def integrate(S, columns, weights, n, per):
    """Write coefficient n + 1 of integrals over theta of w f, f being columns of a series.

    columns: (numbers of a row, first column of f, first column of the integrals, how many);
    weights: (series of w, place of w_0, distance of the next one); per: unit of theta / (n + 1). In
    whole fours: the last one may overwrite numbers behind the integrals, of this row or the next.
    """
    (width, of, to, count), (w, first, far) = columns, weights
    for i in range(0, count, 4):
        even, odd, m, at = four(0.0), four(0.0), first, width * n + of + i
        for _ in range((n + 1) // 2):  # two sums, neither of which waits for the other
            even = even + four_at(S, at) * w[m]
            odd = odd + four_at(S, at - width) * w[m + far]
            m, at = m + 2 * far, at - 2 * width
        if n % 2 == 0:
            even = even + four_at(S, at) * w[m]
        put_four(S, width * (n + 1) + to + i, (even + odd) * per)


@jit
def put_at_theta(S, columns, highest, x, out):
    """Write X and V, which begin each row of a series, at theta = x units to out[: 2 size].

    columns: (numbers of a row, size).
    """
    width, size = columns
    whole = 2 * size // 4 * 4
    for i in range(0, whole, 4):
        total = four_at(S, width * highest + i)
        for n in range(highest - 1, -1, -1):
            total = total * x + four_at(S, width * n + i)
        put_four(out, i, total)
    for i in range(whole, 2 * size):
        rest = S[width * highest + i]
        for n in range(highest - 1, -1, -1):
            rest = rest * x + S[width * n + i]
        out[i] = rest


@jit
def differentiate(body, drive, at):
    """Replace a drive, which begins at drive[at], by its rate."""
    last = at + body.drives - 1
    first = drive[at]
    for k in range(at, last):
        drive[k] = body.paces[k - at] * drive[k + 1]
    drive[last] = body.paces[last - at] * first


@jit
def move(body, rate, drive, time, y, work):
    """Advance a state y and the drive in place by a time [s] of up to a smallest cell.

    By a Taylor polynomial, up to degree ORDER + 1. With x = `rate` times the time, term k is at
    most x^k / k! of the state (`grid`). It ends where that of the next term is below MOVED, but not
    before all powers of the drive have acted. work: (3 size + drives,) scratch.
    """
    size, at, last = body.size, 3 * body.size, 1.0  # x^k / k! of the last term
    for i in range(2 * size):
        work[i] = y[i]
    for k in range(body.drives):
        work[at + k] = drive[k]
    for n in range(ORDER + 1):
        g = time / (n + 1.0)
        accelerate(body, work, 0, work[at], work, 2 * size)
        for i in range(size):
            work[i], work[size + i] = g * work[size + i], g * work[2 * size + i]
            y[i] += work[i]
            y[size + i] += work[size + i]
        differentiate(body, work, at)
        for k in range(body.drives):
            work[at + k] *= g
            drive[k] += work[at + k]
        last *= rate * g
        if n > body.drives and last * (rate * time) <= MOVED * (n + 2.0):
            break
