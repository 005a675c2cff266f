"""The 1:1 motion of a mass on a nonlinear spring, in closed form: its slow invariant manifold.

Structure and damper move nearly harmonically with one frequency.  The balance of the damper's
fundamental is a relation between the two amplitudes that no parameter of the structure enters.  It
folds if the damping is small: a structure that exceeds the amplitude of the first fold throws the
damper onto the outer branch, on which it takes the structure's energy until the last fold.

Sources: Dekemele, De Keyser, Loccufier: Nonlinear Dyn. 94 (2018), doi 10.1007/s11071-018-4190-5;
for forced motion Gendelman, Starosvetsky: J. Appl. Mech. 74 (2007).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.errors import RequestError, number
from nlds_vines.model.system import General

_REAL = 1e-7  # imaginary part over the modulus of a real root: a double root has half the digits


class Fold(NamedTuple):
    """A fold of the manifold, where the structure's amplitude has an extremum over the stroke.

    Attributes
    ----------
    stroke : float
        Amplitude of r [m].
    amplitude : float
        Amplitude of the structure [m].
    force : float
        Amplitude [N] of the force of frequency omega_0 under which the steady 1:1 motion is here.
    """

    stroke: float
    amplitude: float
    force: float


@dataclass(frozen=True)
class SpringManifold:
    """The manifold of 1:1 motion of a mass on a spring k r + k3 r^3 + k5 r^5.

    Attributes
    ----------
    m1, k1, c1 : float
        Mass [kg], stiffness [N/m] and damping [N s/m] of the structure.
    m2, k, c : float
        Mass, linear stiffness and damping of the damper.
    k3, k5 : float
        Coefficients of its spring [N/m^3, N/m^5].
    force, omega : float
        Amplitude [N] and frequency [rad/s] of the harmonic force.

    Notes
    -----
    With the stroke's amplitude R the balance of the damper's mass at the frequency w is
    m2 w^2 X1 = (m2 w^2 - k - 3/4 k3 R^2 - 5/8 k5 R^4 - i w c) R.
    Of a bistable damper, k < 0, it is that of motion across both wells.

    References
    ----------
    Dekemele, De Keyser and Loccufier, Nonlinear Dyn. 94 (2018), doi 10.1007/s11071-018-4190-5.
    Gendelman and Starosvetsky, J. Appl. Mech. 74 (2007), for forced motion.
    """

    m1: float
    k1: float
    c1: float
    m2: float
    k: float
    c: float
    k3: float
    k5: float
    force: float
    omega: float

    @property
    def mass_ratio(self) -> float:
        """eps = m2 / m1."""
        return self.m2 / self.m1

    @property
    def omega_0(self) -> float:
        """Natural frequency sqrt(k1 / m1) [rad/s] of the structure alone."""
        return float(np.sqrt(self.k1 / self.m1))

    @property
    def xi(self) -> float:
        """Damping c / (m2 omega_0) of the damper."""
        return self.c / (self.m2 * self.omega_0)

    @property
    def kappa(self) -> float:
        """Linear stiffness k / (m2 omega_0^2) of the damper; negative if it is bistable."""
        return self.k / (self.m2 * self.omega_0**2)

    def amplitude(self, stroke: Any, omega: float | None = None) -> Any:
        """Return the amplitude [m] of the structure at an amplitude of the stroke [m].

        Parameters
        ----------
        stroke : float or array_like
            Amplitude of r [m].
        omega : float, optional
            Frequency [rad/s], by default `omega_0`.
        """
        return np.abs(self._structure(np.asarray(stroke, dtype=float), omega))

    def force_at(self, stroke: Any, omega: float | None = None) -> Any:
        """Return the amplitude [N] of the force under which the steady 1:1 motion has a stroke.

        Parameters
        ----------
        stroke : float or array_like
            Amplitude of r [m].
        omega : float, optional
            Frequency [rad/s], by default that of the system's force.

        Notes
        -----
        P = |(k1 - m1 w^2 + i w c1) X1 - m2 w^2 (X1 - R)| with X1 of the manifold.
        """
        rate = self.omega if omega is None else omega
        stroke = np.asarray(stroke, dtype=float)
        structure = self._structure(stroke, rate)
        of_structure = (self.k1 - self.m1 * rate**2 + 1j * rate * self.c1) * structure
        return np.abs(of_structure - self.m2 * rate**2 * (structure - stroke))

    @cached_property
    def folds(self) -> tuple[Fold, ...]:
        """The folds at `omega_0` in ascending order of the stroke; none if damping is large.

        Of a cubic spring with k = 0 there are two if xi < 1 / sqrt(3).  Between the forces at the
        two folds no steady 1:1 motion is stable if the mass ratio is small: the response is
        strongly modulated.

        Notes
        -----
        They are the roots of `_rise`, where d(X1^2) / dZ = 0 with Z = R^2.
        """
        roots = self._rise.trim().roots()
        is_real = (np.abs(roots.imag) <= _REAL * np.abs(roots)) & (roots.real > 0.0)
        strokes = np.sqrt(np.sort(roots.real[is_real]))
        folds = []
        for stroke in strokes.tolist():
            amplitude = float(self.amplitude(stroke))
            folds.append(Fold(stroke, amplitude, float(self.force_at(stroke, self.omega_0))))
        return tuple(folds)

    @cached_property
    def _rise(self) -> np.polynomial.Polynomial:
        """d(X1^2) / dZ = g^2 + xi^2 + 2 Z g dg/dZ at `omega_0`, a polynomial in Z = R^2 [m^2].

        g = 1 - kappa - (3/4 k3 Z + 5/8 k5 Z^2) / (m2 omega_0^2), X1^2 = Z (g^2 + xi^2).
        """
        inertia = self.m2 * self.omega_0**2
        of_spring = [-0.75 * self.k3 / inertia, -0.625 * self.k5 / inertia]
        g = np.polynomial.Polynomial([1.0 - self.kappa, *of_spring])
        Z = np.polynomial.Polynomial([0.0, 1.0])
        return g**2 + self.xi**2 + 2.0 * Z * g * g.deriv()

    @property
    def threshold(self) -> float:
        """Amplitude [m] of the structure from which on the damper pumps its energy.

        It is that of the first fold; a blow must give the structure the speed omega_0 threshold.

        Raises
        ------
        RequestError
            If the manifold has no folds.
        """
        return self._ends[0].amplitude

    def threshold_k3(self, amplitude: float) -> float:
        """Return the k3 [N/m^3] whose `threshold` is an amplitude [m], all else unchanged.

        Parameters
        ----------
        amplitude : float
            Amplitude of the structure [m].

        Raises
        ------
        RequestError
            If the manifold has no folds, and of a spring with k5.
        """
        if self.k5 != 0.0:
            raise RequestError(f"k5 = {self.k5!r}: the threshold by k3 is that of a cubic spring")
        amplitude = number("amplitude", amplitude)
        return self.k3 * (self.threshold / amplitude) ** 2

    def pumping_time(self, amplitude: float) -> float:
        """Return the time [s] in which a free motion goes from an amplitude [m] to the last fold.

        Parameters
        ----------
        amplitude : float
            Initial amplitude of the structure [m].

        Raises
        ------
        RequestError
            If the manifold has no folds, or the amplitude is below the `threshold`.

        Notes
        -----
        The dashpots take d(X1^2) / dt = -(c R^2 + c1 X1^2) / m1 along the outer branch.
        """
        from scipy.integrate import quad

        first, last = self._outer_branch(amplitude)

        def stay(stroke: float) -> float:
            """Return the time per length of the stroke [s/m]."""
            rise = 2.0 * stroke * self._rise(stroke**2)
            loss = self.c * stroke**2 + self.c1 * self.amplitude(stroke) ** 2
            return float(self.m1 * rise / loss)

        return float(quad(stay, last.stroke, first, epsrel=1e-10)[0])

    def pumped_share(self, amplitude: float) -> float:
        """Return the share of the structure's energy that is gone when the pumping ends.

        Parameters
        ----------
        amplitude : float
            Initial amplitude of the structure [m].

        Raises
        ------
        RequestError
            If the manifold has no folds, or the amplitude is below the `threshold`.
        """
        _, last = self._outer_branch(amplitude)
        return 1.0 - (last.amplitude / amplitude) ** 2

    @property
    def _ends(self) -> tuple[Fold, Fold]:
        """The first and the last fold."""
        if not self.folds:
            raise RequestError(
                f"the manifold has no folds, with xi = c / (m2 omega_0) = {self.xi:.4g} and "
                f"kappa = k / (m2 omega_0^2) = {self.kappa:.4g}; a cubic spring has them if "
                "xi < (1 - kappa) / sqrt(3)"
            )
        return self.folds[0], self.folds[-1]

    def _outer_branch(self, amplitude: float) -> tuple[float, Fold]:
        """Return the stroke at an amplitude on the outer branch, and the fold at its end."""
        from scipy.optimize import brentq

        threshold, last = self.threshold, self._ends[1]
        amplitude = number("amplitude", amplitude)
        if not amplitude >= threshold:
            raise RequestError(
                f"amplitude = {amplitude!r}: the damper pumps from {threshold:.6g} m on"
            )
        far = 2.0 * last.stroke
        while self.amplitude(far) < amplitude:
            far *= 2.0
        stroke = brentq(lambda R: self.amplitude(R) - amplitude, last.stroke, far, xtol=1e-15)
        return float(stroke), last

    def _structure(self, stroke: np.ndarray, omega: float | None) -> np.ndarray:
        """Return the complex amplitude of the structure, relative to the phase of the stroke."""
        rate = self.omega_0 if omega is None else omega
        inertia = self.m2 * rate**2
        square = stroke**2
        stiffness = self.k + 0.75 * self.k3 * square + 0.625 * self.k5 * square**2
        return (inertia - stiffness - 1j * rate * self.c) * stroke / inertia


def spring_manifold(system: General) -> SpringManifold:
    """Return the manifold of a structure with one degree of freedom and a mass on a spring.

    Raises `RequestError` for another system, which names the difference.
    """
    what = "the slow manifold of a general system is that of one mass on a nonlinear spring"
    if len(system.dampers) != 1 or system.dampers[0].m is None:
        raise RequestError(f"{what}: give it one damper, with a mass")
    if len(system.host.inertia) != 1:
        raise RequestError(
            f"{what}, on a structure with one degree of freedom; this one has "
            f"{len(system.host.inertia)}: keep one mode"
        )
    damper = system.dampers[0]
    if damper.spring is None or not any(damper.coefficients):
        raise RequestError(f"{what}; that of {damper.name} is linear")
    if damper.walls:
        raise RequestError(f"{what}, without walls; {damper.name} has {len(damper.walls)}")
    if damper.spring.k2 != 0.0:
        raise RequestError(f"{damper.name}.k2 = {damper.spring.k2!r}: {what} that is symmetric: 0")
    if any(system.ground.values()):
        raise RequestError(f"{what}, under a force; here the ground moves")
    host: Any = system.host  # of one coordinate q: the damper hangs on x = weight q
    weight = float(host.row(damper.places[0])[0])
    square = weight * weight
    k1 = float(host.K[0, 0]) / square
    if k1 == 0.0:
        raise RequestError(f"{what}, on a structure with a stiffness; here it is 0")
    force = 0.0
    for dof, P in system.force.items():
        force += P * float(host.row(dof)[0]) / weight
    return SpringManifold(
        m1=float(host.M[0, 0]) / square,
        k1=k1,
        c1=float(host.C[0, 0]) / square,
        m2=float(damper.m or 0.0),
        k=float(damper.k),
        c=float(damper.c),
        k3=damper.spring.k3,
        k5=damper.spring.k5,
        force=abs(force),
        omega=system.omega,
    )
