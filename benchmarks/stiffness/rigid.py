"""The rigid elastic limit of a case: exact linear flight, velocities exchanged at an instant.

What the Hertz contact tends to as K grows without bound, with restitution 1: independent of all
kernels, slow and simple.  Flight is the matrix exponential of the autonomous system of six
variables x1, v1, x2 - rest, v2, cos(omega t), sin(omega t); an impact in between of relative
speed s changes v1 by -2 m2 s / (m1 + m2) and v2 by +2 m1 s / (m1 + m2).

The limit is approached as K^(-2/5): a contact lasts 2.94 depth / v with depth ~ K^(-2/5), and
by so much the impact is late.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from nlds_vines.accuracy.measured_cases import Case
from nlds_vines.errors import RequestError
from nlds_vines.model.linear_response import flow_matrix

LOOKS = 1024
"""Times a period at which the gap is looked at; an impact and the next are further apart."""

EXPONENT = -0.4
"""Of the distance to the rigid limit, in K."""

_MOST = 64  # impacts in one look: more is a chatter that never ends


@dataclass(frozen=True)
class Rigid:
    """A case with rigid walls."""

    case: Case

    def state(self) -> np.ndarray:
        """Return (x1, v1, x2, v2) [m, m/s] at the end of the case.

        Raises `RequestError` where impacts accumulate: the limit is no orbit of isolated impacts.
        """
        y = np.array([*self.case.state, 1.0, 0.0])
        y[2] -= self._rest
        dt = self.case.system.period / LOOKS
        for _ in range(self.case.periods * LOOKS):
            y = self._advanced(y, dt)
        return np.array([y[0], y[1], y[2] + self._rest, y[3]])

    def _advanced(self, y: np.ndarray, dt: float) -> np.ndarray:
        """Return the state a look later, all impacts in between carried out."""
        for _ in range(_MOST):
            after = (self._step if dt == self._dt else expm(self._flow * dt)) @ y
            near = int(np.argmax(self._depths(after)))
            if self._depths(after)[near] <= 0.0:
                return after
            elapsed = self._touch(y, dt, near)
            y = self._struck(expm(self._flow * elapsed) @ y)
            dt -= elapsed
        raise RequestError(f"{self.case.name}: with rigid walls impacts accumulate")

    def _touch(self, y: np.ndarray, dt: float, wall: int) -> float:
        """Return the time until a wall is touched [s], by a bracketed root of the depth."""

        def depth(time: float) -> float:
            return float(self._depths(expm(self._flow * time) @ y)[wall])

        begin = 0.0 if depth(0.0) < 0.0 else 1e-9 * dt  # it leaves the wall it has just struck
        return float(brentq(depth, begin, dt, xtol=1e-16, rtol=1e-14)) if depth(begin) < 0 else 0.0

    def _depths(self, y: np.ndarray) -> np.ndarray:
        shortening = y[0] - y[2]
        return np.array([shortening - self._gaps[0], -shortening - self._gaps[1]])

    def _struck(self, y: np.ndarray) -> np.ndarray:
        p = self.case.system.parameters
        blow = 2.0 * (y[1] - y[3]) / (p["m1"] + p["m2"])
        return y + np.array([0.0, -p["m2"] * blow, 0.0, p["m1"] * blow, 0.0, 0.0])

    @cached_property
    def _gaps(self) -> tuple[float, float]:
        scene, p = self.case.system.scene, self.case.system.parameters
        near, far = (np.inf if gap is None else gap(p) for gap in (scene.gap_near, scene.gap_far))
        return float(near), float(far)

    @cached_property
    def _rest(self) -> float:
        return float(self.case.system.rest or 0.0)

    @cached_property
    def _dt(self) -> float:
        return self.case.system.period / LOOKS

    @cached_property
    def _step(self) -> np.ndarray:
        return expm(self._flow * self._dt)

    @cached_property
    def _flow(self) -> np.ndarray:
        return flow_matrix(self.case.system)
