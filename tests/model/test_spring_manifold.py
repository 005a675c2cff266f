"""The slow manifold of a mass on a nonlinear spring: printed numbers and independent runs."""

import re

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import nlds_vines as nv

EPS, C = 0.02, 0.002  # Dekemele, De Keyser, Loccufier (2018): m = k = 1, xi = 0.1
SPEED = 0.1


def system_of(k3=0.4, host=None, place="x1", walls=(), load=None, m=EPS, c=C, k=0.0, **spring):
    host = nv.chain([1.0], [1.0]) if host is None else host
    given = nv.Spring(k3=k3, **spring)
    damper = nv.Damper("nes", place, m=m, k=k, c=c, spring=given, walls=walls)
    return nv.System.from_host(host, [damper], **(load or {}))


def test_the_threshold_and_the_time_of_pumping_are_the_published_ones():
    k3 = nv.slow_manifold(system_of()).threshold_k3(SPEED)
    assert k3 == pytest.approx(0.404018, abs=5e-7)
    assert nv.slow_manifold(system_of(k3)).threshold == pytest.approx(SPEED, rel=1e-12)
    manifold = nv.slow_manifold(system_of(1.1 * k3))
    assert manifold.threshold < SPEED
    assert manifold.pumping_time(SPEED) == pytest.approx(63.9, abs=0.05)
    assert manifold.pumped_share(SPEED) == pytest.approx(0.940, abs=5e-4)
    assert (manifold.xi, manifold.kappa, manifold.mass_ratio) == pytest.approx((0.1, 0.0, 0.02))


def test_a_blow_above_the_threshold_leaves_the_structure_without_energy():
    """The share of the structure's energy around 100 s, by an integrator of SciPy."""
    k3 = nv.slow_manifold(system_of()).threshold_k3(SPEED)

    def left(stiffness):
        def rates(t, y):
            pull = stiffness * (y[0] - y[1]) ** 3 + C * (y[2] - y[3])
            return [y[2], y[3], -y[0] - pull, pull / EPS]

        times = np.linspace(0.0, 106.0, 4241)
        start = [0.0, 0.0, SPEED, 0.0]
        y = solve_ivp(rates, (0.0, 106.0), start, "DOP853", times, rtol=1e-8, atol=1e-11).y
        energy = y[0] ** 2 + y[2] ** 2
        return energy[times > 100.0].max() / SPEED**2

    assert left(0.9 * k3) == pytest.approx(0.742, abs=0.02)
    assert left(k3) == pytest.approx(0.008, abs=0.004)


@pytest.mark.parametrize("scale", [1.0, 30.0])
def test_the_folds_of_a_cubic_spring_have_the_closed_form(scale):
    """N^2 = (2 -+ sqrt(1 - 3 lambda^2)) / 3 under k3 = 4/3 eps, A^2 = N^2 (N^4 + lambda^2)."""
    lam, eps = 0.2, 0.05
    host = nv.chain([scale], [scale])
    load = {"force": {"x1": 0.02}, "omega": 1.0}
    system = system_of(4 / 3 * eps * scale, host, load=load, m=eps * scale, c=eps * lam * scale)
    first, last = nv.slow_manifold(system).folds
    for fold, sign, printed in ((first, -1.0, 0.2419), (last, 1.0, 0.9892)):
        square = (2.0 + sign * np.sqrt(1.0 - 3.0 * lam**2)) / 3.0
        assert fold.stroke == pytest.approx(np.sqrt(square), rel=1e-12)
        force = np.sqrt(square * (square**2 + lam**2))
        assert fold.force / (eps * scale) == pytest.approx(force, rel=1e-12)
        assert fold.force / (eps * scale) == pytest.approx(printed, abs=5e-5)


@pytest.mark.parametrize("spring", [{"k": -0.01}, {"k": 0.005, "k5": 0.3}, {"k3": 0.0, "k5": 2.0}])
def test_folds_are_extrema_of_the_amplitude_and_bound_the_pumping(spring):
    manifold = nv.slow_manifold(system_of(**spring))
    strokes = np.linspace(1e-4, 3.0 * manifold.folds[-1].stroke, 400_001)
    amplitude = manifold.amplitude(strokes)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(amplitude)))) + 1
    assert [fold.stroke for fold in manifold.folds] == pytest.approx(strokes[turns], abs=1e-5)
    assert [fold.amplitude for fold in manifold.folds] == pytest.approx(amplitude[turns])
    # the time is that in which the dashpot takes the energy of the structure
    start = 1.2 * manifold.threshold
    outer = strokes > manifold.folds[-1].stroke
    reached = strokes[outer][np.searchsorted(amplitude[outer], start)]
    change, _ = quad(
        lambda R: manifold.amplitude(R) ** 2 / R**3, manifold.folds[-1].stroke, reached
    )
    ends = manifold.amplitude(np.array([manifold.folds[-1].stroke, reached]))
    squares = (ends / np.array([manifold.folds[-1].stroke, reached])) ** 2
    expected = (squares[1] - squares[0] + 2.0 * change) / C  # by parts
    assert manifold.pumping_time(start) == pytest.approx(expected, rel=1e-4)
    # a structure that loses energy by itself stays a shorter time
    damped = nv.slow_manifold(system_of(host=nv.chain([1.0], [1.0], ratio=0.005), **spring))
    assert damped.pumping_time(start) < manifold.pumping_time(start)


def test_a_steady_motion_balances_structure_and_damper():
    """Harmonic balance of both masses at another frequency than the structure's."""
    m1, k1, c1, omega, R = 2.0, 3.0, 0.1, 1.4, 0.3
    load = {"force": {"x1": 0.02}, "omega": omega}
    host = nv.Host(M=[[m1]], K=[[k1]], C=[[c1]])
    manifold = nv.slow_manifold(system_of(0.7, host, load=load, m=0.2, c=0.03, k=0.05))
    stiffness = 0.05 + 0.75 * 0.7 * R**2
    pull = (stiffness + 1j * omega * 0.03) * R  # on the damper
    damper = -pull / (0.2 * omega**2)
    structure = damper + R
    force = (k1 - m1 * omega**2 + 1j * omega * c1) * structure + pull
    assert manifold.amplitude(R, omega) == pytest.approx(abs(structure), rel=1e-13)
    assert manifold.force_at(R) == pytest.approx(abs(force), rel=1e-13)
    assert manifold.force == 0.02


def test_one_mode_of_a_host_is_a_structure():
    """A mode of 2 kg where the damper hangs: q is x times its root."""
    host = nv.Host.from_modes([{"f": 0.5 / np.pi, "zeta": 0.01, "shape": {"x1": 0.5**0.5}}])
    manifold = nv.slow_manifold(system_of(host=host))
    assert (manifold.m1, manifold.k1, manifold.c1) == pytest.approx((2.0, 2.0, 0.04))


WALL = nv.Wall(0.1, K=1.0)
TWO = nv.chain([1.0, 1.0], [1.0, 1.0])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: system_of(host=TWO), "one degree of freedom; this one has 2: keep one mode"),
        (lambda: system_of(walls=[WALL]), "without walls; nes has 1"),
        (lambda: system_of(k2=0.1), "nes.k2 = 0.1: .* symmetric"),
        (lambda: system_of(0.0), "that of nes is linear"),
        (lambda: nv.System.from_host(TWO, []), "give it one damper, with a mass"),
        (lambda: system_of(host=nv.chain([1.0], [0.0])), "with a stiffness; here it is 0"),
        (lambda: system_of(load={"base": {"acceleration": 1.0}, "omega": 1.0}), "ground moves"),
    ],
)
def test_other_systems_are_refused(call, message, error_of):
    assert re.search(message, error_of(nv.slow_manifold, call()))


def test_what_a_manifold_does_not_have_is_refused(error_of):
    damped = nv.slow_manifold(system_of(c=0.012))
    assert damped.folds == ()
    assert "no folds, with xi = c / (m2 omega_0) = 0.6" in error_of(lambda: damped.threshold)
    manifold = nv.slow_manifold(system_of())
    assert "the damper pumps from 0.1005" in error_of(manifold.pumping_time, 0.1)
    quintic = nv.slow_manifold(system_of(k5=1.0))
    assert "k5 = 1.0: the threshold by k3" in error_of(quintic.threshold_k3, 0.1)
