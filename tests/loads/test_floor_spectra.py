"""Response spectra of floors in response histories, beside SciPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nlds_vines as nv
from nlds_vines.loads.floor_motion import joined

pytestmark = pytest.mark.kernels

STEP, DURATION, ZETA = 0.02, 8.0, 0.05
TIMES = STEP * np.arange(250)
GROUND = np.sin(7.0 * TIMES) * np.exp(-0.3 * TIMES)
LOAD = {"record": {"times": TIMES.tolist(), "values": GROUND.tolist(), "unit": "m/s^2"}}
MASS, STIFFNESS, DASHPOT, BALL, GAP, REBOUND = 1.0, 50.0, 0.3, 0.05, 0.02, 0.6
PERIODS = np.array([0.2, 0.9, 2.0])


def histories_with(walls, samples=400):
    host = nv.Host([[MASS]], [[STIFFNESS]], [[DASHPOT]], dofs=["floor"])
    ball = nv.Damper("ball", "floor", m=BALL, walls=walls)
    system = nv.System.from_host(host, [ball], name="house")
    sampling = {"samples": samples, "duration": DURATION}
    return nv.response_history(system, load=LOAD, sampling=sampling, quiet=True)


def rigid():
    return [nv.Wall(GAP, side, law="restitution", e=REBOUND) for side in "+-"]


def largest_by_scipy(omega, has_ball):
    """Return the largest absolute acceleration of an oscillator on the floor, struck by the ball.

    y: x and v of the floor, x and v of the ball, z and w of the oscillator, relative to its floor.
    """

    def rate(t, y):
        x, v, _, u, z, w = y
        ground = np.interp(t, TIMES, GROUND, right=0.0)
        floor = -(STIFFNESS * x + DASHPOT * v) / MASS  # absolute
        of_oscillator = -(omega**2) * z - 2 * ZETA * omega * w
        return [v, floor - ground, u, -ground, w, of_oscillator - floor]

    def touches(sign):
        def event(t, y):
            return GAP - sign * (y[0] - y[2])

        event.terminal, event.direction = True, -1
        return event

    y, now, largest, struck = np.zeros(6), 0.0, 0.0, 0
    events = [touches(1.0), touches(-1.0)] if has_ball else None
    end = DURATION + 2 * np.pi / omega
    while now < DURATION:
        piece = solve_ivp(
            rate, (now, DURATION), y, "DOP853", rtol=1e-10, atol=1e-13, max_step=0.5 * STEP,
            events=events,
        )  # fmt: skip
        accelerations = -(omega**2) * piece.y[4] - 2 * ZETA * omega * piece.y[5]
        largest = max(largest, np.abs(accelerations).max())
        now, y = piece.t[-1], piece.y[:, -1].copy()
        if piece.status == 1:
            mu = 1.0 / (1.0 / MASS + 1.0 / BALL)
            impulse = (1.0 + REBOUND) * mu * (y[1] - y[3])
            y[1] -= impulse / MASS
            y[5] += impulse / MASS
            y[3] += impulse / BALL
            struck += 1
    free = solve_ivp(
        lambda t, y: [y[1], -(omega**2) * y[0] - 2 * ZETA * omega * y[1]],
        (DURATION, end), y[4:], rtol=1e-9, atol=1e-12, max_step=0.01 / omega,
    )  # fmt: skip
    after = np.abs(-(omega**2) * free.y[0] - 2 * ZETA * omega * free.y[1])
    return max(largest, after.max()), struck


@pytest.mark.parametrize("has_ball", [False, True])
def test_a_floor_spectrum_is_that_of_oscillators_on_the_floor(has_ball):
    """Rigid impacts give the floor finite jumps of velocity, which equipment on it feels."""
    histories = histories_with(rigid() if has_ball else ())
    spectrum = nv.response_spectrum(histories, ZETA, PERIODS, of="floor.a", system="house")
    for period, mine in zip(PERIODS, spectrum.absolute_acceleration, strict=True):
        largest, struck = largest_by_scipy(2 * np.pi / period, has_ball)
        assert mine == pytest.approx(largest, rel=2e-3)
        assert (struck > 5) == has_ball
    assert "house: floor.a" in spectrum.heading()
    again = nv.response_spectrum(histories, ZETA, PERIODS, of="floor")
    assert np.array_equal(again.displacement, spectrum.displacement)


def test_a_contact_with_too_few_samples_is_refused_with_their_number(error_of):
    walls = [nv.Wall(GAP, side, K=2e5) for side in "+-"]
    few = histories_with(walls, samples=32)
    words = error_of(nv.response_spectrum, record=few, of="floor.a")
    assert "give the history sampling=" in words
    needed = int(words.rsplit(": ", 1)[1].rstrip("}"))
    enough = histories_with(walls, samples=needed)
    stiff = nv.response_spectrum(enough, ZETA, PERIODS, of="floor.a")
    rebounds = [nv.Wall(GAP, side, law="restitution", e=0.999) for side in "+-"]
    limit = nv.response_spectrum(histories_with(rebounds), ZETA, [0.9], of="floor.a")
    assert stiff.absolute_acceleration[1] == pytest.approx(limit.absolute_acceleration[0], rel=0.3)


def test_what_is_no_floor_is_refused(error_of):
    histories = histories_with(rigid(), samples=32)
    assert "floor" in error_of(nv.response_spectrum, record=histories, of="attic.a")
    assert "system" in error_of(nv.response_spectrum, record=histories, of="floor.a", system="x")
    assert "unknown floor ''" in error_of(nv.response_spectrum, record=histories)
    record = {"times": [0.0, 1.0], "values": [0.0, 1.0], "unit": "g"}
    assert "histories" in error_of(nv.response_spectrum, record=record, of="floor.a")


def test_jumps_that_are_close_are_one():
    instants, jumps = joined(np.array([0.0, 0.1, 1.0]), np.array([1.0, 2.0, -1.0]), 0.5)
    assert instants.tolist() == [0.0, 1.0]
    assert jumps.tolist() == [3.0, -1.0]
