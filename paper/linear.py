"""The steady state without contact: energies, gaps that it fills, and its state at t = 0."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nlds_vines.model.linear_response import amplitudes, harmonic_energy
from nlds_vines.model.system import Preset


@dataclass(frozen=True)
class Response:
    """The steady state without contact by the frequency of the force."""

    system: Preset
    omega: np.ndarray  # [rad/s], of any shape
    X1: np.ndarray  # [m]: x1 = Re(X1 exp(i omega t))
    X2: np.ndarray | None  # [m]: x2 - rest = Re(X2 exp(i omega t))

    @property
    def E1max(self) -> np.ndarray:
        """Largest energy of the structure over a period [J], equation (6), by frequency."""
        m1, k1, _ = self.system.structure
        return harmonic_energy(m1, k1, self.omega, np.abs(self.X1))

    @property
    def shortening(self) -> np.ndarray:
        """Amplitude of the spring's shortening [m], or of a structure that walls limit, or 0."""
        if self.X2 is None:
            return np.abs(self.X1) * self.system.scene.grounded
        with np.errstate(invalid="ignore"):  # two infinite amplitudes have no difference
            return np.abs(self.X2 - self.X1)

    @property
    def clears(self) -> np.ndarray:
        """Whether the damper reaches no wall, by frequency, so that this motion exists."""
        scene, p = self.system.scene, self.system.parameters
        gaps = [gap(p) for gap in (scene.gap_near, scene.gap_far) if gap is not None]
        if not gaps:
            return np.ones(self.omega.shape, dtype=bool)
        return self.shortening <= min(gaps)


def response(system: Preset, omega: np.ndarray) -> Response:
    omega = np.asarray(omega, dtype=float)
    return Response(system, omega, *amplitudes(system, omega))


def steady_state(system: Preset) -> np.ndarray:
    """Return the state (2,) or (4,) of the steady motion without contact at t = 0."""
    omega = system.parameters["omega"]
    phasors = [X[0] for X in amplitudes(system, [omega]) if X is not None]
    state = np.array([x for X in phasors for x in (X.real, (1j * omega * X).real)])
    if len(state) == 4:
        state[2] += system.rest
    return state
