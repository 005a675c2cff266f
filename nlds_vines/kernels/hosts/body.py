"""The linear system of a host with its dampers, and its motion over a short time.

M X'' + C X' + K X + sum over links of w (k r + c s) = F cos(omega t), r = w X and s = w X', with
M = 1 of a host's mode, so that K is the squares of its frequencies.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..motion.flight import ORDER
from ..numerics.compiling import jit
from ..numerics.fours import bare


class Body(NamedTuple):
    """The linear system; each array is one row of numbers, in inner kernels a bare row."""

    modes: int  # of the host
    size: int  # coordinates X: modes, and masses of dampers
    links: int
    omega: float  # of the force [rad/s]
    squares: Any  # (modes,) of the modes' frequencies [1/s^2]
    damping: Any  # (modes,) of each mode [1/s]
    coupling: Any  # (modes * modes,) damping by other modes [1/s]; without it no numbers
    coupled: bool
    push: Any  # (size,) acceleration by a force of cos(omega t) = 1
    rows: Any  # (links * size,) w: of r by X
    answers: Any  # (links * size,) accelerations by a unit force along r [1/kg], times -1
    stiffness: Any  # (links,) k of the links [N/m]
    dashpots: Any  # (links,) c of the links [N s/m]


@jit
def bare_body(body):
    return Body(
        body.modes, body.size, body.links, body.omega, bare(body.squares), bare(body.damping),
        bare(body.coupling), body.coupled, bare(body.push), bare(body.rows), bare(body.answers),
        bare(body.stiffness), bare(body.dashpots),
    )  # fmt: skip


@jit
def along(body, link, y, at):
    """Return (r, s) of a link, of the state that begins at y[at]."""
    r = s = 0.0
    row = link * body.size
    for i in range(body.size):
        r += body.rows[row + i] * y[at + i]
        s += body.rows[row + i] * y[at + body.size + i]
    return r, s


@jit
def push_link(body, link, force, out, at):
    """Add the accelerations by a `force` [N] that acts against r of a link."""
    row = link * body.size
    for i in range(body.size):
        out[at + i] -= force * body.answers[row + i]


@jit
def accelerate(body, y, at, drive, out, to):
    """Write the accelerations X'' of a flight to out[to : to + size]; drive: cos(omega t)."""
    n, v = body.modes, at + body.size
    for i in range(n):
        out[to + i] = (body.push[i] * drive - body.squares[i] * y[at + i]) - (
            body.damping[i] * y[v + i]
        )
    for i in range(n, body.size):
        out[to + i] = body.push[i] * drive
    if body.coupled:
        for j in range(n):
            for i in range(n):
                out[to + i] -= body.coupling[n * j + i] * y[v + j]
    for link in range(body.links):
        r, s = along(body, link, y, at)
        force = body.stiffness[link] * r + body.dashpots[link] * s
        if force != 0.0:
            push_link(body, link, force, out, to)


@jit
def move(body, phase, time, y, work):
    """Advance a state y in place by a short time [s]; return (cos, sin) of the phase after it.

    By a Taylor polynomial of degree ORDER + 1; work: (3 size,) scratch.
    """
    size, (cosine, sine) = body.size, phase
    for i in range(2 * size):
        work[i] = y[i]
    c, d = cosine, sine
    for k in range(ORDER + 1):
        g = time / (k + 1.0)
        accelerate(body, work, 0, c, work, 2 * size)
        for i in range(size):
            work[i], work[size + i] = g * work[size + i], g * work[2 * size + i]
            y[i] += work[i]
            y[size + i] += work[size + i]
        c, d = -body.omega * d * g, body.omega * c * g
        cosine, sine = cosine + c, sine + d
    return cosine, sine
