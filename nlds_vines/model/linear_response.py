"""The motion without contact in closed form: its amplitudes, and the matrix of its flow."""

from __future__ import annotations

from typing import Any

import numpy as np

from nlds_vines.model.presets import modulus
from nlds_vines.model.system import Preset


def amplitudes(system: Preset, omega: Any) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the steady state of equation (5) without contact under the force P cos(omega t).

    x1 = Re(X1 exp(i omega t)) and x2 - rest = Re(X2 exp(i omega t)) [m].  With the joint
    j = k2 + i omega c2, the structure's s = k1 - m1 omega^2 + i omega c1 and the damper's
    d = j - m2 omega^2:  X1 = P d / ((s + j) d - j^2) and X2 = P j / ((s + j) d - j^2); without a
    damper X1 = P / s, and no X2.  The amplitudes are infinite at a resonance without damping, which
    has no steady state.
    """
    p, omega = system.parameters, np.asarray(omega, dtype=float)
    m1, k1, c1 = system.structure
    structure = k1 - m1 * omega**2 + 1j * omega * c1
    if not system.scene.damper:
        return _amplitude(system.force, structure), None
    joint = p["k2"] + 1j * omega * p["c2"]
    damper = joint - p["m2"] * omega**2
    whole = (structure + joint) * damper - joint**2
    return _amplitude(system.force * damper, whole), _amplitude(system.force * joint, whole)


def flow_matrix(system: Preset) -> np.ndarray:
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
    flow[4, 5], flow[5, 4] = -p["omega"], p["omega"]
    return flow


def energy_alone(cells: np.ndarray) -> np.ndarray:
    """Return E1max [J] of the structure without its damper, in the shape of `cells`.

    max(k1, m1 omega^2) X^2 / 2 with X = P / |k1 - m1 omega^2 + i omega c1|.
    """
    m1, k1, omega = cells["m1"], cells["k1"], cells["omega"]
    with np.errstate(all="ignore"):
        return harmonic_energy(m1, k1, omega, _amplitude_alone(cells))


def alone(cells: np.ndarray) -> dict[str, np.ndarray]:
    """Return largest and rms x1 [m], v1 and a1 of the structure without its damper, by name."""
    omega, by_name = cells["omega"], {}
    with np.errstate(all="ignore"):
        largest = _amplitude_alone(cells)
        for name in ("x1", "v1", "a1"):
            by_name[f"{name}_max"], by_name[f"{name}_rms"] = largest, largest * np.sqrt(0.5)
            largest = largest * omega
    return by_name


def foot_amplitude(cells: np.ndarray) -> np.ndarray:
    """Return the amplitude [m] of the foot's motion that exerts the force P of the cells."""
    return cells["P"] / modulus(cells["k1"], cells["c1"] * cells["omega"])


def _amplitude_alone(cells: np.ndarray) -> np.ndarray:
    m1, k1, omega = cells["m1"], cells["k1"], cells["omega"]
    return cells["P"] / modulus(k1 - m1 * omega * omega, omega * cells["c1"])


def _amplitude(force: Any, impedance: Any) -> np.ndarray:
    """Return force / impedance: infinite if only the impedance is 0, and 0 if both are."""
    force, impedance = np.broadcast_arrays(force, impedance)
    is_zero = impedance == 0
    amplitude = force / np.where(is_zero, 1, impedance)
    return np.where(is_zero, np.where(force == 0, 0, np.inf), amplitude)


def harmonic_energy(m: Any, k: Any, omega: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
    """Return the largest energy m v^2 / 2 + k x^2 / 2 of a harmonic motion [J]."""
    return np.maximum(m * omega * omega, k) * amplitude * amplitude / 2
