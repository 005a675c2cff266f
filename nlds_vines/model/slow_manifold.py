"""The 1:1 response of a free mass between two rigid walls in closed form: the slow manifold.

In each half period the damper strikes the other wall, and between two impacts it flies freely.  The
structure moves nearly harmonically, so that only the fundamental of the damper's zigzag acts on it,
and its own fundamental determines the times of impact.  Harmonic balance over these impacts yields
an invariant manifold that no parameter of the structure enters, and the response on it.

Source: Weidemann, Bergman, Vakakis, Krack: Nonlinear Dyn. (2025), doi 10.1007/s11071-025-10928-4.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from nlds_vines.errors import RequestError
from nlds_vines.model.catalog import any_system, without_hosts
from nlds_vines.model.spring_manifold import SpringManifold, spring_manifold
from nlds_vines.model.system import General, System

# the largest amplitude over the clearance: far beyond, the damper takes no energy
_MOST_XI = 1e3
_LEAST_XI = 1e-6  # the smallest amplitude over the clearance if e = 1, when xi_min is 0
_LEAST_S = 1e-15  # the smallest s > 0 that `best` evaluates, below the optimum of every e < 1
_REAL = 1e-7  # imaginary part over the modulus of a real root: a double root has half the digits


class BestClearance(NamedTuple):
    """The largest clearance with a 1:1 response in phase resonance, and that response.

    Attributes
    ----------
    clearance : float
        From the middle to a wall [m].
    Gamma : float
        The clearance over the amplitude P / (2 D k1) of the structure with the damper's mass.
    xi : float
        Amplitude of the structure over the clearance.
    omega, r : float
        Frequency of the response [rad/s], and that over sqrt(k1 / (m1 + m2)).
    """

    clearance: float
    Gamma: float
    xi: float
    omega: float
    r: float


class FrequencyResponse(NamedTuple):
    """A closed frequency response: the two frequencies of each amplitude.

    Attributes
    ----------
    amplitude : (n,) ndarray
        Amplitude of the structure [m].
    below, above : (n,) ndarray
        The lower and the higher frequency [rad/s]; the lower one is NaN if there is none.
    """

    amplitude: np.ndarray
    below: np.ndarray
    above: np.ndarray

    def __repr__(self) -> str:
        largest = self.amplitude.max(initial=0.0)
        return f"{type(self).__name__}: {self.amplitude.size} amplitudes up to {largest:.6g} m"

    @property
    def outline(self) -> tuple[np.ndarray, np.ndarray]:
        """Frequency [rad/s] and amplitude [m] (2 n,), up the left side of the curve, then down."""
        frequency = np.concatenate([self.below, self.above[::-1]])
        return frequency, np.concatenate([self.amplitude, self.amplitude[::-1]])


@dataclass(frozen=True)
class SlowManifold:
    """The manifold of sustained 1:1 motion, with one impact at each wall per period.

    An amplitude xi is that of the structure over the clearance, and r is the forcing frequency over
    `omega_joint`.

    Attributes
    ----------
    e : float
        Coefficient of restitution.
    damping : float
        D = c1 / (2 sqrt(k1 (m1 + m2))).
    clearance : float
        From the middle to a wall [m].
    m1, m2 : float
        The masses [kg].
    k1 : float
        Stiffness of the structure [N/m].
    force : float
        Amplitude P of the force [N].

    References
    ----------
    Weidemann, Bergman, Vakakis and Krack, Nonlinear Dyn. (2025), doi 10.1007/s11071-025-10928-4.
    """

    e: float
    damping: float
    clearance: float
    m1: float
    m2: float
    k1: float
    force: float

    @property
    def mass(self) -> float:
        """m1 + m2 [kg]."""
        return self.m1 + self.m2

    @property
    def share(self) -> float:
        """eps = m2 / (m1 + m2)."""
        return self.m2 / self.mass

    @property
    def rho(self) -> float:
        """(2 / pi) (1 - e) / (1 + e), the loss of the impacts."""
        return 2.0 / np.pi * (1.0 - self.e) / (1.0 + self.e)

    @property
    def omega_joint(self) -> float:
        """Frequency sqrt(k1 / (m1 + m2)) [rad/s] of the structure with the damper's mass."""
        return float(np.sqrt(self.k1 / self.mass))

    @property
    def least(self) -> float:
        """xi_min = rho / sqrt(1 + rho^2): below it no 1:1 motion is sustained."""
        return self.rho / float(np.sqrt(1.0 + self.rho**2))

    @property
    def alone(self) -> float:
        """Amplitude P / (2 D k1) [m] at resonance of the structure with the damper's mass."""
        if self.damping == 0.0:
            return np.inf
        return self.force / (2.0 * self.damping * self.k1)

    @property
    def Gamma(self) -> float:
        """The clearance over the amplitude `alone`."""
        return self.clearance / self.alone

    def theta(self, xi: np.ndarray) -> np.ndarray:
        """Return the amplitude of the damper's zigzag over the clearance, NaN below xi_min.

        It is the stable branch, theta = (1 + sqrt((1 + rho^2) xi^2 - rho^2)) / (1 + rho^2).
        """
        xi, one = np.asarray(xi, dtype=float), 1.0 + self.rho**2
        with np.errstate(invalid="ignore"):
            return (1.0 + np.sqrt(one * xi**2 - self.rho**2)) / one

    def _pull(self, xi: np.ndarray, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (a, b) of the structure's balance at xi: (xi - a r^2) + i (2 D r xi + b r^2)."""
        zigzag = 8.0 * self.share / np.pi**2 * theta / xi  # the fundamental of a triangle
        return (1.0 - self.share) * xi + zigzag * (theta - 1.0), zigzag * self.rho * theta

    def gamma(self, xi: np.ndarray, r: np.ndarray) -> np.ndarray:
        """Return the Gamma at which the amplitude at r is xi.

        Gamma = 2 D / |(1 - (1 - eps) r^2 + 2 i D r) xi + Pi|,
        Pi = -(8 eps / pi^2) r^2 theta ((theta - 1) - i rho theta) / xi.
        """
        a, b = self._pull(np.asarray(xi, dtype=float), self.theta(xi))
        return 2.0 * self.damping / np.hypot(xi - a * r**2, 2.0 * self.damping * r * xi + b * r**2)

    @cached_property
    def best(self) -> BestClearance:
        """The largest clearance with a 1:1 response in phase resonance.

        With a larger one, the structure reaches the amplitude of a sustained 1:1 motion at no
        frequency; with a smaller one, the damper takes less energy.  If impacts take much
        (`vi-nes`: e < 0.428), the response lies at the end of the manifold, xi = xi_min.

        Raises
        ------
        RequestError
            If c1 = 0, because Gamma is then not defined, and if e = 1, because Gamma grows without
            bound as xi goes to 0.

        Notes
        -----
        It maximizes Gamma(s) over s >= 0, s^2 = (1 + rho^2) xi^2 - rho^2: unlike Gamma(xi), this
        is smooth at xi_min.
        """
        from scipy.optimize import minimize_scalar

        if self.damping == 0.0:
            raise RequestError(
                "c1 = 0: the best clearance is a share of the amplitude at resonance"
            )
        if self.rho == 0.0:
            raise RequestError("e = 1: without loss in impacts the best clearance is unbounded")

        def resonant(s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            """Return (Gamma, xi, r) in phase resonance; Gamma is 0 if a <= 0, which allows none."""
            one = 1.0 + self.rho**2
            xi, theta = np.sqrt((s**2 + self.rho**2) / one), (1.0 + s) / one
            a, b = self._pull(xi, theta)
            r = np.sqrt(xi / np.where(a > 0.0, a, np.inf))
            loss = 2.0 * self.damping * r * xi + b * r**2
            return np.where(a > 0.0, 2.0 * self.damping / np.where(a > 0.0, loss, 1.0), 0.0), xi, r

        grid = np.append(0.0, np.geomspace(_LEAST_S, _MOST_XI, 800))
        top = int(np.argmax(resonant(grid)[0]))
        between = minimize_scalar(
            lambda s: -float(resonant(np.array(s))[0]),
            bounds=(grid[max(top - 1, 0)], grid[min(top + 1, len(grid) - 1)]),
            method="bounded",
            options={"xatol": 1e-12 * max(grid[top], grid[1])},
        )
        s = grid[top] if top == 0 else between.x  # the search never evaluates its bounds
        Gamma, xi, r = (float(number) for number in resonant(np.array(s)))
        return BestClearance(Gamma * self.alone, Gamma, xi, r * self.omega_joint, r)

    def response(self, points: int = 400) -> FrequencyResponse:
        """Return the frequency response of 1:1 motion; empty if there is none.

        Parameters
        ----------
        points : int, optional
            Number of amplitudes, densest at both ends of their range.

        Returns
        -------
        FrequencyResponse
            `amplitude` [m], `below` and `above` [rad/s].

        Notes
        -----
        At an amplitude xi, the squared balance equals that of p = P / (k1 clearance), the static
        amplitude over the clearance, a polynomial of degree four in r:
        (a^2 + b^2) r^4 + 4 D b xi r^3 + (4 D^2 xi - 2 a) xi r^2 + xi^2 - p^2 = 0.
        """
        xi = np.geomspace(max(self.least, _LEAST_XI) * (1.0 + 1e-12), _MOST_XI, 4000)
        reached = np.flatnonzero(np.isfinite(self._crossings(xi)[1]))
        if not reached.size:
            return FrequencyResponse(*np.zeros((3, 0)))
        first, last = reached[0], reached[-1]
        low = self._end(xi[first], xi[max(first - 1, 0)])
        high = self._end(xi[last], xi[min(last + 1, len(xi) - 1)])
        share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, points))
        xi = low * (high / low) ** share
        below, above = self._crossings(xi)
        keep = np.isfinite(above)
        below, above = below[keep] * self.omega_joint, above[keep] * self.omega_joint
        return FrequencyResponse(xi[keep] * self.clearance, below, above)

    def capture_time(self, xi: float) -> float:
        """Return the time [s] that a free motion from amplitude xi stays in 1:1 resonance.

        No force acts; the motion begins on the manifold and leaves it at xi_min.

        Parameters
        ----------
        xi : float
            Initial amplitude of the structure over the clearance.

        Raises
        ------
        RequestError
            If e = 1, when the motion lasts for ever, and for an amplitude below xi_min.

        Notes
        -----
        In each half period an impact takes 2 m2 (1 - e) / (1 + e) u^2 from the energy, with the
        damper's speed u = 2 omega theta clearance / pi between the walls:
        d(xi^2) / dt = -omega (8 eps rho theta^2 / pi^2 + 2 D xi^2), omega = `omega_joint`.
        The integrand is smooth in s, s^2 = (1 + rho^2) xi^2 - rho^2.
        """
        from scipy.integrate import quad

        if self.rho == 0.0:
            raise RequestError("e = 1: without loss in impacts free 1:1 motion lasts for ever")
        if not xi >= self.least:
            raise RequestError(f"xi = {xi!r}: there is 1:1 motion from xi_min = {self.least:g} on")
        one = 1.0 + self.rho**2

        def stay(s: float) -> float:
            theta, square = (1.0 + s) / one, (s**2 + self.rho**2) / one
            loss = 8.0 * self.share * self.rho / np.pi**2 * theta**2
            return 2.0 * s / one / (self.omega_joint * (loss + 2.0 * self.damping * square))

        return float(quad(stay, 0.0, np.sqrt(max(one * xi**2 - self.rho**2, 0.0)), epsabs=0.0)[0])

    def _end(self, inside: float, outside: float) -> float:
        """Bisect between a reached amplitude and one that is not; return the last reached one."""
        for _ in range(60):
            middle = 0.5 * (inside + outside)
            if np.isfinite(self._crossings(np.array([middle]))[1, 0]):
                inside = middle
            else:
                outside = middle
        return inside

    def _crossings(self, xi: np.ndarray) -> np.ndarray:
        """Return the lower and the higher r (2, n) at which each amplitude (n,) is reached.

        Both are NaN if it is not reached; only the lower one is NaN below the static amplitude.
        """
        (a, b), D = self._pull(xi, self.theta(xi)), self.damping
        push = self.force / (self.k1 * self.clearance)
        lead = a**2 + b**2
        companion = np.zeros((len(xi), 4, 4))
        companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
        companion[:, 0, 0] = -4.0 * D * b * xi / lead
        companion[:, 0, 1] = -(4.0 * D**2 * xi - 2.0 * a) * xi / lead
        companion[:, 0, 3] = -(xi**2 - push**2) / lead
        roots = np.linalg.eigvals(companion)
        positive = (abs(roots.imag) <= _REAL * abs(roots)) & (roots.real > 0.0)
        ordered = np.sort(np.where(positive, roots.real, np.nan), axis=1)  # NaN comes last
        one = np.count_nonzero(positive, axis=1) == 1
        below = np.where(one, np.nan, ordered[:, 0])
        return np.stack([below, np.where(one, ordered[:, 0], ordered[:, 1])])


def slow_manifold(system: System | str | os.PathLike[str]) -> SlowManifold | SpringManifold:
    """Return the slow manifold of a free mass between two rigid walls, or on a nonlinear spring.

    Parameters
    ----------
    system : System, str or path-like
        A system, its catalog name or its TOML file: of kind `ssbl` under the law `restitution`,
        with k2 = c2 = 0 and C = D > 0; or a structure with one degree of freedom and one damper,
        whose spring has k3 or k5 and which has no walls.

    Returns
    -------
    SlowManifold or SpringManifold
        Of a free mass, the manifold with its best clearance, frequency response and capture times;
        of a mass on a spring, the manifold with its folds, the threshold and the time of pumping.

    Raises
    ------
    RequestError
        For another system; the message names the difference.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> manifold = nv.slow_manifold("vi-nes")
    >>> round(manifold.least, 4), round(manifold.Gamma, 4), round(manifold.best.Gamma, 4)
    (0.0706, 0.15, 0.3387)
    >>> sink = nv.Damper("nes", "x1", m=0.02, c=0.002, spring=nv.Spring(k3=0.4))
    >>> system = nv.System.from_host(nv.chain([1.0], [1.0]), [sink])
    >>> round(nv.slow_manifold(system).threshold, 4)
    0.1005
    """
    system = any_system(system)
    if isinstance(system, General):
        return spring_manifold(system)
    return free_mass_manifold(system)


def free_mass_manifold(system: System) -> SlowManifold:
    """Return the slow manifold of a free mass between two rigid walls; see `slow_manifold`."""
    system = without_hosts(system)
    p = system.parameters
    wanted = "a free mass between two rigid walls, each as far from the middle"
    if system.kind != "ssbl" or system.law != "restitution" or system.law_2:
        laws = " and ".join(filter(None, (system.law, system.law_2)))
        raise RequestError(
            f"the slow manifold is that of {wanted}: kind 'ssbl' with law 'restitution'; "
            f"this is {system.kind!r} with {laws!r}"
        )
    if system.scene.shaken:
        raise RequestError(f"{system.scene.shaken}: the slow manifold is that of a force P")
    for name in ("k2", "c2"):
        if p[name] != 0.0:
            raise RequestError(f"{name} = {p[name]!r}: the slow manifold is that of {wanted}: 0")
    if p["C"] != p["D"]:
        raise RequestError(
            f"C = {p['C']!r} and D = {p['D']!r}: the slow manifold is that of {wanted}: C = D"
        )
    for name, value in (("k1", p["k1"]), ("C", p["C"]), ("P", system.force)):
        if value == 0.0:
            raise RequestError(f"{name} = 0: the slow manifold needs a positive one")
    damping = p["c1"] / (2.0 * float(np.sqrt(p["k1"] * (p["m1"] + p["m2"]))))
    return SlowManifold(p["e"], damping, p["C"], p["m1"], p["m2"], p["k1"], system.force)
