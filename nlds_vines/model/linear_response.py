"""The motion without contact in closed form: its amplitudes, and the matrix of its flow.

A `system` is a `Preset`, of one of the paper's kinds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nlds_vines.model.presets import modulus


def amplitudes(system: Any, omega: Any) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the steady state of equation (5) without contact, under a force or on moving ground.

    x1 = Re(X1 exp(i omega t)) and x2 - rest = Re(X2 exp(i omega t)) [m].  With the joint
    j = k2 + i omega c2, the structure's s = k1 - m1 omega^2 + i omega c1 and the damper's
    d = j - m2 omega^2:  X1 = P d / ((s + j) d - j^2) and X2 = P j / ((s + j) d - j^2); without a
    damper X1 = P / s, and no X2.  The amplitudes are infinite at a resonance without damping, which
    has no steady state.  On moving ground P acts on m1 and Q = P m2 / m1 on m2:
    X1 = (P d + Q j) / ((s + j) d - j^2) and X2 = (P j + Q (s + j)) / ((s + j) d - j^2).
    """
    p, omega = system.parameters, np.asarray(omega, dtype=float)
    m1, k1, c1 = system.structure
    structure = k1 - m1 * omega**2 + 1j * omega * c1
    # the force that displacements of the ground exert depends on the frequency
    P = system.cells({"omega": omega})["P"] if system.scene.shaken else system.force
    if not system.scene.damper:
        return _amplitude(P, structure), None
    joint = p["k2"] + 1j * omega * p["c2"]
    damper = joint - p["m2"] * omega**2
    whole = (structure + joint) * damper - joint**2
    if system.scene.shaken:
        Q = P * p["m2"] / m1
        on_structure, on_damper = P * damper + Q * joint, P * joint + Q * (structure + joint)
        return _amplitude(on_structure, whole), _amplitude(on_damper, whole)
    return _amplitude(P * damper, whole), _amplitude(P * joint, whole)


def flow_matrix(system: Any) -> np.ndarray:
    """Return the matrix A of the motion without contact, dy/dt = A y, by equation (5); (6, 6).

    y = (x1, v1, x2 - rest, v2, cos(omega t), sin(omega t)) [m, m/s] has the force among the
    unknowns: y(t) = exp(A t) y(0).  Without a damper x2 is that of a free mass of 1 kg.
    """
    p = {"m2": 1.0, "k2": 0.0, "c2": 0.0, **system.parameters}
    m1, k1, c1 = system.structure
    flow = np.zeros((6, 6))
    flow[0, 1] = flow[2, 3] = 1.0
    flow[1, :4] = -(k1 + p["k2"]), -(c1 + p["c2"]), p["k2"], p["c2"]
    flow[1, 4] = system.force
    flow[1] /= m1
    flow[3, :4] = np.array([p["k2"], p["c2"], -p["k2"], -p["c2"]]) / p["m2"]
    if system.scene.shaken:
        flow[3, 4] = flow[1, 4]
    flow[4, 5], flow[5, 4] = -p["omega"], p["omega"]
    return flow


def energy_alone(cells: np.ndarray) -> np.ndarray:
    """Return E1max [J] of the structure without its damper, in the shape of `cells`.

    max(k1, m1 omega^2) X^2 / 2 with X = P / |k1 - m1 omega^2 + i omega c1|.
    """
    m1, k1, omega = cells["m1"], cells["k1"], cells["omega"]
    with np.errstate(all="ignore"):
        return harmonic_energy(m1, k1, omega, _amplitude_alone(cells))


def alone(cells: np.ndarray, *, shaken: bool = False) -> dict[str, np.ndarray]:
    """Return largest and rms x1 [m], v1 and a1 of the structure without its damper, by name.

    If it is shaken by the ground, a1 = |P / m1| |k1 + i omega c1| / |k1 - m1 omega^2 + i omega c1|
    is absolute, and x1_abs = a1 / omega^2.
    """
    omega, by_name = cells["omega"], {}
    with np.errstate(all="ignore"):
        x1 = _amplitude_alone(cells)
        largest = {"x1": x1, "v1": x1 * omega, "a1": x1 * omega * omega}
        if shaken:
            largest["a1"] = x1 / cells["m1"] * modulus(cells["k1"], omega * cells["c1"])
            largest["x1_abs"] = largest["a1"] / (omega * omega)
        for name, value in largest.items():
            by_name[f"{name}_max"] = value
            by_name[f"{name}_rms"] = value * np.sqrt(0.5)
    return by_name


def ground_amplitude(cells: np.ndarray) -> np.ndarray:
    """Return the amplitude [m] of the ground's displacement, |P| / (m1 omega^2)."""
    return np.abs(cells["P"]) / (cells["m1"] * cells["omega"] * cells["omega"])


def _amplitude_alone(cells: np.ndarray) -> np.ndarray:
    m1, k1, omega = cells["m1"], cells["k1"], cells["omega"]
    return np.abs(cells["P"]) / modulus(k1 - m1 * omega * omega, omega * cells["c1"])


def _amplitude(force: Any, impedance: Any) -> np.ndarray:
    """Return force / impedance: infinite if only the impedance is 0, and 0 if both are."""
    force, impedance = np.broadcast_arrays(force, impedance)
    is_zero = impedance == 0
    amplitude = force / np.where(is_zero, 1, impedance)
    return np.where(is_zero, np.where(force == 0, 0, np.inf), amplitude)


def harmonic_energy(m: Any, k: Any, omega: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
    """Return the largest energy m v^2 / 2 + k x^2 / 2 of a harmonic motion [J]."""
    return np.maximum(m * omega * omega, k) * amplitude * amplitude / 2


# ---- under loads in time ----


def closed_form(system: Any, load: Any) -> dict[str, float]:
    """Return quantities of `OF_LOADS` in closed form by name; none with walls or other loads.

    After a blow at t = 0 on a structure at rest, E1max = I^2 / (2 m1) is the energy supplied.  The
    share that a dashpot dissipates is z0^T P z0 / E1max with A^T P + P A = -Q (Lyapunov), where
    z^T Q z is the power of the dashpot.  Without a damper, the largest displacement is
    v0 / w exp(-z arccos(z) / sqrt(1 - z^2)), where z is the damping ratio.

    Under noise, the stationary rms of x1 is sqrt(sum of rms^2 / N |H(i omega_i)|^2) over its tones.

    Source: A. Preumont, Random Vibration and Spectral Analysis (1994).
    """
    size = 4 if system.scene.damper else 2
    A, (m1, k1, c1) = flow_matrix(system)[:size, :size], system.structure
    if system.scene.walls or load.harmonic or np.linalg.eigvals(A).real.max() >= 0.0:
        return {}
    blows, parts = load.blows, load.parts
    if parts and not blows and len(parts) == len(load.noise):
        push, square = np.zeros(len(A)), 0.0
        if load.shaken:
            push[1::2] = -1.0
        else:
            push[1] = 1.0 / m1
        for noise in load.noise:
            rates = 1j * noise.omegas[:, np.newaxis, np.newaxis] * np.eye(len(A)) - A
            x1 = np.linalg.inv(rates)[:, 0] @ push
            size_of_tones = (noise.rms * noise.factor * load.scale) ** 2 / noise.tones
            square += size_of_tones * float(np.sum(np.abs(x1) ** 2))
        return {"x1_rms": math.sqrt(square)}
    if parts or len(blows) != 1 or blows[0][0] != 0.0:
        return {}
    from scipy.linalg import solve_continuous_lyapunov

    speed = blows[0][1] / m1
    energy, start = 0.5 * m1 * speed**2, np.zeros(len(A))
    start[1] = speed
    rates = {"c1": (c1, np.array([0.0, 1.0, 0.0, 0.0]))}
    if system.scene.damper:
        rates["c2"] = (system.parameters["c2"], np.array([0.0, 1.0, 0.0, -1.0]))
    quantities = {"E1max": energy, "energy_in": energy}
    for dashpot, (c, relative) in rates.items():
        Q = c * np.outer(relative[: len(A)], relative[: len(A)])
        P = solve_continuous_lyapunov(A.T, -Q)
        quantities[f"share_{dashpot}"] = float(start @ P @ start) / energy
    zeta = c1 / (2.0 * math.sqrt(k1 * m1))
    if not system.scene.damper and zeta < 1.0:
        decay = math.exp(-zeta * math.acos(zeta) / math.sqrt(1.0 - zeta**2))
        quantities["x1_max"] = abs(speed) / math.sqrt(k1 / m1) * decay
    return quantities


def energy_after_blow(system: Any, load: Any, times: np.ndarray) -> np.ndarray:
    """Return E1 [J] at `times` (n,) [s] after a blow on a structure without walls: exp(A t) z0."""
    from scipy.linalg import expm

    m1, k1, _ = system.structure
    size = 4 if system.scene.damper else 2
    flows = expm(times[:, np.newaxis, np.newaxis] * flow_matrix(system)[:size, :size])
    x1, v1 = load.blows[0][1] / system.structure[0] * flows[:, :2, 1].T
    return 0.5 * (m1 * v1**2 + k1 * x1**2)
