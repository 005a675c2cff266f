"""What a structure without walls does under a load, in closed form, beside what was computed."""

from __future__ import annotations

import math

import numpy as np

from nlds_vines.loads.request import struck
from nlds_vines.model.linear_response import flow_matrix
from nlds_vines.model.loads.courses import Noise
from nlds_vines.model.loads.loading import Loading
from nlds_vines.model.system import System


def closed_form(system: System, load: Loading) -> dict[str, float]:
    """Return numbers of `OF_LOADS` by name; none for walls, and for loads that have none here.

    Of a blow at t = 0 on a structure at rest, in the end: E1max = I^2 / (2 m1), the energy that
    came in; the shares that dashpots dissipate, z0^T P z0 with A^T P + P A = -Q (Lyapunov), where
    z^T Q z is what a dashpot dissipates in a second; without a damper the largest displacement,
    v0 / w exp(-z arccos(z) / sqrt(1 - z^2)), z the damping ratio.

    Of noise, in the steady state: the rms of x1, sqrt(sum of rms^2 / N |H(i omega_i)|^2) over its
    tones.

    Source: A. Preumont, Random Vibration and Spectral Analysis (1994).
    """
    size = 4 if system.scene.damper else 2
    A = flow_matrix(system)[:size, :size]
    if system.scene.walls or load.harmonic or np.linalg.eigvals(A).real.max() >= 0.0:
        return {}
    blows, parts = load.blows, load.parts
    if not parts and len(blows) == 1 and blows[0][0] == 0.0:
        return _of_blow(system, A, blows[0][1] / struck(system).mass)
    if parts and not blows and all(isinstance(one, Noise) for one in parts):
        return {"x1_rms": _rms(system, A, load)}
    return {}


def _of_blow(system: System, A: np.ndarray, speed: float) -> dict[str, float]:
    """Return the numbers after a blow that made v1 `speed` [m/s]."""
    m1, k1, c1 = system.structure
    energy, start = 0.5 * m1 * speed**2, np.zeros(len(A))
    start[1] = speed
    rates = {"c1": (c1, np.array([0.0, 1.0, 0.0, 0.0]))}
    if system.scene.damper:
        rates["c2"] = (system.parameters["c2"], np.array([0.0, 1.0, 0.0, -1.0]))
    found = {"E1max": energy, "energy_in": energy}
    unit = np.eye(len(A))
    lyapunov = np.kron(A.T, unit) + np.kron(unit, A.T)
    for way, (c, relative) in rates.items():
        Q = c * np.outer(relative[: len(A)], relative[: len(A)])
        P = np.linalg.solve(lyapunov, -Q.ravel()).reshape(Q.shape)
        found[f"share_{way}"] = float(start @ P @ start) / energy
    zeta = c1 / (2.0 * math.sqrt(k1 * m1))
    if not system.scene.damper and zeta < 1.0:
        shrunk = math.exp(-zeta * math.acos(zeta) / math.sqrt(1.0 - zeta**2))
        found["x1_max"] = abs(speed) / math.sqrt(k1 / m1) * shrunk
    return found


def energy_after_blow(system: System, load: Loading, times: np.ndarray) -> np.ndarray:
    """Return E1 [J] at times [s] where `closed_form` has the E1max of a blow: z = exp(A t) z0."""
    from scipy.linalg import expm

    m1, k1, _ = system.structure
    size = 4 if system.scene.damper else 2
    flows = expm(times[:, np.newaxis, np.newaxis] * flow_matrix(system)[:size, :size])
    x1, v1 = load.blows[0][1] / struck(system).mass * flows[:, :2, 1].T
    return 0.5 * (m1 * v1**2 + k1 * x1**2)


def _rms(system: System, A: np.ndarray, load: Loading) -> float:
    """Return the rms of x1 [m] in the steady state under noise."""
    push = np.zeros(len(A))
    if load.shaken:
        push[1::2] = -1.0
    else:
        push[1] = 1.0 / struck(system).mass
    square, unit = 0.0, np.eye(len(A))
    for noise in load.noise:
        assert isinstance(noise, Noise)
        size = noise.rms * noise.factor * load.scale
        rates = 1j * noise.omegas[:, np.newaxis, np.newaxis] * unit - A
        x1 = np.linalg.inv(rates)[:, 0] @ push
        square += size**2 / noise.tones * float(np.sum(np.abs(x1) ** 2))
    return math.sqrt(square)
