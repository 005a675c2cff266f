"""The classical Runge-Kutta method at a fixed step, as one writes it in an afternoon.

Nothing is done about contact: a step that crosses a wall loses its order.
"""

from __future__ import annotations

import math

import numpy as np

from benchmarks.rivals.equation import constants, depth, derivative, jit
from benchmarks.rivals.rival import (
    Asked,
    Course,
    Flow,
    Rival,
    SolverFailure,
    begun,
    touches_of,
)
from nlds_vines.model.system import System


@jit
def step(p, h, phase, turn, x1, v1, x2, v2):
    """Return (x1, v1, x2, v2) a step of h [s] later; the forcing turns from `phase` by `turn`."""
    g, middle = 0.5 * h, phase + 0.5 * turn
    a1, b1, c1, d1 = derivative(p, phase, x1, v1, x2, v2)
    a2, b2, c2, d2 = derivative(p, middle, x1 + g * a1, v1 + g * b1, x2 + g * c1, v2 + g * d1)
    a3, b3, c3, d3 = derivative(p, middle, x1 + g * a2, v1 + g * b2, x2 + g * c2, v2 + g * d2)
    a4, b4, c4, d4 = derivative(p, phase + turn, x1 + h * a3, v1 + h * b3, x2 + h * c3, v2 + h * d3)
    return (
        x1 + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4),
        v1 + h / 6.0 * (b1 + 2.0 * (b2 + b3) + b4),
        x2 + h / 6.0 * (c1 + 2.0 * (c2 + c3) + c4),
        v2 + h / 6.0 * (d1 + 2.0 * (d2 + d3) + d4),
    )


@jit
def runge_kutta(p, steps, periods, start, section, touches, energy):
    """Follow an orbit from start = (x1, v1, x2, v2) by so many steps a period.

    Arguments: `p` from `constants`; `section` of shape (periods, 4) is filled. Buffers or None:
    `touches` (capacity,) for times at which one is inside a wall after a step and was not before,
    interpolated; `energy` (1,) for the largest E1 over the last half of the periods, with the
    parabola through three steps. Returns the number of touches, which may exceed the capacity.
    """
    h = 2.0 * math.pi / p[7] / steps
    turn, found = p[7] * h, 0
    x1, v1, x2, v2 = start[0], start[1], start[2], start[3]
    near, far = depth(p, 0.0, x1, x2), depth(p, 1.0, x1, x2)
    e0 = e1 = 0.0
    for n in range(periods):
        if n == periods // 2 and energy is not None:
            e0 = e1 = 0.5 * (p[0] * v1 * v1 + p[1] * x1 * x1)
            energy[0] = e1
        for j in range(steps):
            x1, v1, x2, v2 = step(p, h, turn * j, turn, x1, v1, x2, v2)
            if touches is not None:
                near0, near = near, depth(p, 0.0, x1, x2)
                far0, far = far, depth(p, 1.0, x1, x2)
                struck = far > 0.0 >= far0
                if struck or near > 0.0 >= near0:
                    z0, z = (far0, far) if struck else (near0, near)
                    if found < touches.size:
                        touches[found] = h * (n * steps + j + z0 / (z0 - z))
                    found += 1
            if energy is not None and n >= periods // 2:
                e = 0.5 * (p[0] * v1 * v1 + p[1] * x1 * x1)
                bend = 2.0 * e1 - e0 - e
                if e1 >= e0 and e1 >= e and bend > 0.0:
                    energy[0] = max(energy[0], e1 + (e - e0) ** 2 / (8.0 * bend))
                energy[0], e0, e1 = max(energy[0], e), e1, e
        section[n, 0], section[n, 1], section[n, 2], section[n, 3] = x1, v1, x2, v2
    return found


def _prepare(system: System, start: np.ndarray) -> Flow:
    p, state = constants(system), begun(system, start)
    width = 4 if system.scene.damper else 2

    def flow(setting: float, periods: int, watched: bool | Asked) -> Course:
        steps, section = int(setting), np.empty((periods, 4))
        if watched:
            touches, energy = _watched(p, steps, state, section)
        else:
            runge_kutta(p, steps, periods, state, section, None, None)
        if not np.isfinite(section).all():
            raise SolverFailure("the state is no longer finite")
        if not watched:
            return Course(section[:, :width], None)
        return Course(section[:, :width], touches_of(system, touches), None, energy)

    return flow


def _watched(
    p: np.ndarray, steps: int, start: np.ndarray, section: np.ndarray
) -> tuple[np.ndarray, float]:
    """Fill the section; return the touches and the largest E1."""
    room, energy = 16 + 4 * len(section), np.zeros(1)
    while True:
        touches = np.empty(room)
        room = runge_kutta(p, steps, len(section), start, section, touches, energy)
        if room <= touches.size:
            return touches[:room], float(energy[0])
        # the next run finds as many


RIVALS = (
    Rival(
        name="naive RK4",
        settings=(256, 1024, 4096, 16384, 65536),
        setting="steps",
        events=False,
        compiled=True,
        needs="",
        prepare=_prepare,
        order=4,
    ),
)
