"""Sections at impact and the kind of modulation of scans, beside closed forms."""

import math

import numpy as np
import pytest
from rigid import CASES, RIGID, start_of
from scipy.optimize import brentq

import nlds_vines as nv
from nlds_vines.orbits.records import modulation_of
from scans import scan_of

pytestmark = pytest.mark.kernels

ORBITS = [(case, orbit) for case in CASES for orbit in case["orbits"]]


def sections(path, system, changes, vary, transient, periods, start="rest"):
    """Return speeds and phases (axes, impacts) and the impacts a period (axes,) of a scan."""
    sampling = {"transient": transient, "periods": periods}
    want = ["impact_section", "impacts"]
    nv.scan(scan_of(system, want, vary, start, changes=changes, **sampling), to=path, quiet=True)
    with nv.read(path) as view:
        rows = [view[name][..., 0, :] for name in ("impact_speed", "impact_phase")]
        return *rows, view["impact_rate"][..., 0]


@pytest.mark.plain
@pytest.mark.parametrize("pair", ORBITS, ids=lambda pair: f"{pair[0]['omega']}-{pair[1]['A']}")
def test_sections_of_rigid_orbits(pair, tmp_path):
    """Also of unstable ones, which are followed for a few periods from their own state."""
    case, exact = pair
    x, v = start_of(case, exact)
    changes = {"c": RIGID["c"], "P": exact["A"], "omega": case["omega"], "e": case["e"]}
    speeds, phases, _ = sections(
        tmp_path / "orbit.h5", "impact-oscillator", changes, {"x_0": [x], "v_0": [v]}, 0,
        3 * case["n"],
    )  # fmt: skip
    speed, at = speeds[0, 0], phases[0, 0]
    assert np.isfinite(speed).sum() == 3
    np.testing.assert_allclose(speed[:3], exact["speed"], rtol=0, atol=1e-10)
    apart = (at[:3] - exact["phase"] + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(apart, 0.0, rtol=0, atol=1e-10)


GRAVITY = 9.81
MANY = 60  # rebounds of a series at most that are followed one by one


def bounces(gamma, e, omega):
    """Return phases [rad] and speeds of a ball that was let go where the table falls faster.

    Until its rebounds are shorter than 1e-6 of a period; and the phase at which their series ends.
    Plain: a parabola over the table's own motion, each touch by bisection.
    """
    Y = gamma * GRAVITY / omega**2
    time, up = -math.acos(1.0 / gamma) / omega, 0.0  # cos(omega t) = 1 / gamma, on the way up

    def height(t, t0, up):
        along = -Y * math.cos(omega * t) + Y * math.cos(omega * t0)
        along -= Y * omega * math.sin(omega * t0) * (t - t0)
        return up * (t - t0) - 0.5 * GRAVITY * (t - t0) ** 2 + along

    def speed(t, t0, up):
        table = Y * omega * (math.sin(omega * t) - math.sin(omega * t0))
        return up - GRAVITY * (t - t0) + table

    phases, speeds = [], []
    period = 2 * np.pi / omega
    while len(phases) < MANY:
        step = period / 400 if not phases else min(period / 400, max(up, 1e-9) / GRAVITY / 20)
        t = time + step
        while height(t, time, up) > 0.0:
            t += step
        touch = brentq(height, t - step, t, args=(time, up), xtol=1e-16, rtol=1e-15)
        approach = -speed(touch, time, up)
        if touch - time < 1e-6 * period:
            break
        phases.append(omega * touch)
        speeds.append(approach)
        time, up = touch, e * approach
    a = GRAVITY - gamma * GRAVITY * math.cos(omega * time)  # with which the table is pressed
    return np.array(phases), np.array(speeds), omega * (time + 2 * up / (a * (1 - e)))


@pytest.mark.plain
@pytest.mark.parametrize(("gamma", "e"), [(1.5, 0.3), (1.9, 0.2), (1.2, 0.6)])
def test_a_ball_that_chatters_forgets(gamma, e, tmp_path):
    """Its series of rebounds ends on the table; each flight begins at the same phase again."""
    omega = 30.0
    times, speed, end = bounces(gamma, e, omega)
    assert len(times) > 5
    assert end < 2 * np.pi - math.acos(1.0 / gamma)  # pressed to the table until it lets go again
    changes = {"g": GRAVITY, "omega": omega, "e": e}
    speeds, phases, rate = sections(
        tmp_path / "ball.h5", "bouncing-ball", changes,
        {"Y": [gamma * GRAVITY / omega**2]}, 3, 30,
    )  # fmt: skip
    each = round(rate[0])
    assert rate[0] == each
    rows = speeds[0][: len(speeds[0]) // each * each].reshape(-1, each)
    turns = phases[0][: rows.size].reshape(-1, each)
    begin = int(np.argmax(rows[0]))  # the first touch after the long flight
    rows, turns = np.roll(rows, -begin, 1), np.roll(turns, -begin, 1)
    full = np.isfinite(rows).all(axis=1)
    assert full.sum() >= 2
    # the long flight and what follows, as the plain loop has it, while it can tell
    count = min(len(times), each)
    np.testing.assert_allclose(rows[full][0, :count], speed[:count], rtol=0, atol=1e-10)
    np.testing.assert_allclose(turns[full][0, :count], times[:count] % (2 * np.pi), atol=1e-9)
    # forgotten: the same in every period, whatever was before
    assert np.ptp(rows[full], axis=0).max() < 1e-12
    # the last rebounds shrink by e, and their phases go to where the geometric series ends
    ratios = rows[full][0, 1:] / rows[full][0, :-1]
    assert abs(ratios[-1] - e) < 0.02 * e
    assert turns[full][0, -1] == pytest.approx(end, abs=1e-4)


C1, OMEGA, E = 2.5, 1.8, 0.8  # an overdamped oscillator: both multipliers of its flight are real
SLOW, FAST = (C1 - math.sqrt(C1**2 - 4)) / 2, (C1 + math.sqrt(C1**2 - 4)) / 2
PERIOD = 2 * np.pi / OMEGA
LARGEST = math.exp(-SLOW * PERIOD)  # multiplier of the flight over a period
STEPS, DECADES = 4, 4  # values of the clearance for each factor of LARGEST^2; such factors


def grazing_speed(distance, size, m):
    """Return the approach speed of the mT,1 orbit at a small distance [m] behind grazing.

    The peak of the motion without impacts exceeds the stop by the distance; each earlier impact,
    which takes (1 + e) v, lowers it by what is left of that, j m periods later.  At the peak the
    acceleration is a = omega^2 size, so that v^2 = 2 a (what the peak exceeds the stop by).
    """
    ages = m * PERIOD * np.arange(1, 60)
    left = ((np.exp(-SLOW * ages) - np.exp(-FAST * ages)) / (FAST - SLOW)).sum()
    a, lowered = OMEGA**2 * size, (1 + E) * left
    return -a * lowered + math.sqrt((a * lowered) ** 2 + 2 * a * distance)


@pytest.mark.plain
def test_nordmarks_square_root(tmp_path):
    """Behind grazing the orbit is mT,1, and m grows by one each time the distance falls by L^2.

    With L the multiplier of the flight, the speeds are a square root of the distance times a
    function of its logarithm that repeats with each such factor: there the exponent is 1/2.
    """
    size = 1.0 / abs(1.0 - OMEGA**2 + 1j * C1 * OMEGA)
    distance = 1e-3 * LARGEST ** (2 * np.arange(STEPS * DECADES) / STEPS)
    changes = {"omega": OMEGA, "e": E, "c": C1, "P": 1.0}
    vary = {"C": np.sort(size * (1 - distance))}
    speeds, _, rate = sections(tmp_path / "n.h5", "impact-oscillator", changes, vary, 400, 420)
    distance, largest = 1 - vary["C"] / size, np.nanmax(speeds, axis=1)
    m = np.rint(1.0 / rate).astype(int)
    for i in range(len(m)):
        exact = grazing_speed(size * distance[i], size, m[i])
        assert largest[i] == pytest.approx(exact, rel=5 * math.sqrt(distance[i]))
        ahead = i + STEPS
        if ahead < len(m):
            assert m[ahead] == m[i] + 1
            falls = math.log(largest[ahead] / largest[i])
            exponent = falls / math.log(distance[ahead] / distance[i])
            assert exponent == pytest.approx(0.5, abs=2 * math.sqrt(distance[i]))
    # over many decades the repeating function is an error of the fitted exponent
    (fitted, _), spread = np.polyfit(np.log(distance), np.log(largest), 1, cov=True)
    assert abs(fitted - 0.5) < 3 * math.sqrt(spread[0, 0])
    assert math.sqrt(spread[0, 0]) < 0.02


def stroke_without_impacts(p, omega):
    """Return the amplitude [m] of x2 - x1 where nothing is struck."""
    one, two = (p[f"k{i}"] + 1j * omega * p[f"c{i}"] for i in (1, 2))
    inert = [p[f"m{i}"] * omega**2 for i in (1, 2)]
    x1, x2 = np.linalg.solve([[one + two - inert[0], -two], [-two, two - inert[1]]], [p["P"], 0.0])
    return abs(x1 - x2)


def test_a_soft_wall_has_the_square_root_alone(tmp_path):
    """The orbit goes on through grazing, and approaches with omega sqrt(R^2 - C^2)."""
    p = nv.load_system("ssul-set6").parameters
    grazing = brentq(lambda omega: stroke_without_impacts(p, omega) - p["C"], 7.2, 8.0, xtol=1e-14)
    share = np.geomspace(1e-6, 1e-10, 9)
    behind = grazing * (1 - share)
    before = grazing * (1 + np.geomspace(1e-10, 0.07, 40))
    vary = {"omega": [*behind, *before]}  # from T,0 downwards, in ever smaller steps
    speeds, _, rate = sections(tmp_path / "soft.h5", "ssul-set6", {}, vary, 600, 20, start="down")
    assert rate.tolist() == [1.0] * len(behind) + [0.0] * len(before)
    speed = speeds[: len(behind), 3]
    size = np.array([stroke_without_impacts(p, omega) for omega in behind])
    exact = behind * np.sqrt(size**2 - p["C"] ** 2)
    assert (np.abs(speed / exact - 1) < 2e3 * share + 1e-5).all()  # the contact adds of order share
    near = share < 1e-7
    fitted = np.polyfit(np.log((grazing - behind)[near]), np.log(speed[near]), 1)[0]
    assert fitted == pytest.approx(0.5, abs=2e-5)


def recorded_modulation(path, clearance, omega, start):
    """Return the arrays (omega, starts) of a scan of `vi-nes` over omega, by name."""
    sampling = {"changes": {"C": clearance, "D": clearance}, "transient": 1500, "periods": 400}
    scan = scan_of("vi-nes", ["modulation", "impacts"], {"omega": omega}, start, **sampling)
    nv.scan(scan, to=path, quiet=True)
    with nv.read(path) as view:
        words = view.flags("capture")
        arrays = {name: view[name] for name in ("amplitude_min", "amplitude_max", "two_impacts")}
        captured = np.vectorize(words.get)(view["capture"])
        return arrays | {"rate": view["impact_rate"], "capture": captured}


def test_sustained_motion_is_that_of_the_closed_form(tmp_path):
    """Which starts all over reach, below resonance; the amplitude lies within 1 % of it."""
    omega = [0.95, 0.96, 0.97, 0.975]
    start = {"policy": "random", "count": 6, "seed": 1}
    arrays = recorded_modulation(tmp_path / "sustained.h5", 50.0, omega, start)
    assert (arrays["capture"] == "sustained_1_to_1").all()
    assert (arrays["two_impacts"] == 1.0).all()
    np.testing.assert_allclose(arrays["amplitude_min"], arrays["amplitude_max"], rtol=1e-6)
    response = nv.slow_manifold(nv.load_system("vi-nes", C=50.0, D=50.0)).response()
    there = np.isfinite(response.below)
    exact = np.interp(omega, response.below[there], response.amplitude[there])[:, np.newaxis]
    np.testing.assert_allclose(
        arrays["amplitude_max"], np.broadcast_to(exact, arrays["rate"].shape), rtol=0.01
    )


def test_beyond_the_best_clearance_there_is_no_sustained_motion(tmp_path):
    """Gamma = 0.4 > Gamma_opt = 0.339: without impacts, or strongly modulated."""
    omega = np.linspace(1.0, 1.02, 5)
    arrays = recorded_modulation(tmp_path / "wide.h5", 200.0, omega, {"policy": "up"})
    assert set(arrays["capture"].ravel()) == {"no_impacts", "strongly_modulated"}
    assert (arrays["rate"][2:] > 0.5).all()
    strong = arrays["capture"] == "strongly_modulated"
    assert (arrays["two_impacts"][strong] < 0.9).all()
    assert (arrays["amplitude_min"][strong] < 0.1 * arrays["amplitude_max"][strong]).all()
    still = ~strong
    np.testing.assert_allclose(
        arrays["amplitude_min"][still], arrays["amplitude_max"][still], rtol=1e-2
    )


def test_the_criterion_is_by_impacts_a_period():
    section = np.zeros((5, 1, 200, 4))
    counts = np.array(
        [[[0, 0, 0]], [[200, 197, 0]], [[200, 198, 0]], [[201, 201, 0]], [[400, 10, 0]]]
    )
    capture = modulation_of(section, np.ones((5, 1)), counts)["capture"]
    assert capture.ravel().tolist() == [0, 1, 2, 2, 3]
