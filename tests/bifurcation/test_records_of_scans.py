"""Records of scans beside closed forms: sections at impact, kinds of modulation, spectra."""

import math

import numpy as np
import pytest
from rigid import CASES, RIGID, start_of
from scipy.optimize import brentq
from support import shortening

import nlds_vines as nv
from nlds_vines.engine.records import modulation_of
from nlds_vines.engine.spectrum import LINES
from nlds_vines.model.labels import KEPT
from paper.linear import response
from scans import scan_of

pytestmark = pytest.mark.kernels

ORBITS = [(case, orbit) for case in CASES for orbit in case["orbits"]]


def sections(system, changes, vary, transient, periods, start="rest"):
    """Return speeds and phases (axes, impacts) and the impacts a period (axes,) of a scan."""
    sampling = {"changes": changes, "transient": transient, "periods": periods}
    scan = scan_of(system, ["impact_section", "impacts"], vary, start, **sampling)
    with nv.scan(scan, quiet=True).read() as view:
        rows = [view[name][..., 0, :] for name in ("impact_speed", "impact_phase")]
        return *rows, view["impact_rate"][..., 0]


@pytest.mark.plain
@pytest.mark.parametrize("pair", ORBITS, ids=lambda pair: f"{pair[0]['omega']}-{pair[1]['A']}")
def test_sections_of_rigid_orbits(pair):
    """Also of unstable ones, which are followed for a few periods from their own state."""
    case, exact = pair
    x, v = start_of(case, exact)
    changes = {"c": RIGID["c"], "P": exact["A"], "omega": case["omega"], "e": case["e"]}
    start = {"x_0": [x], "v_0": [v]}
    speeds, phases, _ = sections("impact-oscillator", changes, start, 0, 3 * case["n"])
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
    Y, period = gamma * GRAVITY / omega**2, 2 * np.pi / omega
    time, up = -math.acos(1.0 / gamma) / omega, 0.0  # cos(omega t) = 1 / gamma, on the way up
    phases, speeds = [], []

    def height(t):
        table = Y * (math.cos(omega * t) - math.cos(omega * time))
        speed = up - Y * omega * math.sin(omega * time)
        return speed * (t - time) - 0.5 * GRAVITY * (t - time) ** 2 - table

    while len(phases) < MANY:
        step = period / 400 if not phases else min(period / 400, max(up, 1e-9) / GRAVITY / 20)
        t = time + step
        while height(t) > 0.0:
            t += step
        touch = brentq(height, t - step, t, xtol=1e-16, rtol=1e-15)
        if touch - time < 1e-6 * period:
            break
        table = Y * omega * (math.sin(omega * touch) - math.sin(omega * time))
        approach = GRAVITY * (touch - time) - up - table
        phases.append(omega * touch)
        speeds.append(approach)
        time, up = touch, e * approach
    a = GRAVITY - gamma * GRAVITY * math.cos(omega * time)  # with which the table is pressed
    return np.array(phases), np.array(speeds), omega * (time + 2 * up / (a * (1 - e)))


@pytest.mark.plain
@pytest.mark.parametrize(("gamma", "e"), [(1.5, 0.3), (1.9, 0.2), (1.2, 0.6)])
def test_a_ball_that_chatters_forgets(gamma, e):
    """Its series of rebounds ends on the table; each flight begins at the same phase again."""
    omega = 30.0
    times, speed, end = bounces(gamma, e, omega)
    assert len(times) > 5
    assert end < 2 * np.pi - math.acos(1.0 / gamma)  # pressed to the table until it lets go again
    changes = {"g": GRAVITY, "omega": omega, "e": e}
    table = {"Y": [gamma * GRAVITY / omega**2]}
    speeds, phases, rate = sections("bouncing-ball", changes, table, 3, 30)
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
def test_nordmarks_square_root():
    """Behind grazing the orbit is mT,1, and m grows by one each time the distance falls by L^2.

    With L the multiplier of the flight, the speeds are a square root of the distance times a
    function of its logarithm that repeats with each such factor: there the exponent is 1/2.
    """
    size = 1.0 / abs(1.0 - OMEGA**2 + 1j * C1 * OMEGA)
    distance = 1e-3 * LARGEST ** (2 * np.arange(STEPS * DECADES) / STEPS)
    changes = {"omega": OMEGA, "e": E, "c": C1, "P": 1.0}
    vary = {"C": np.sort(size * (1 - distance))}
    speeds, _, rate = sections("impact-oscillator", changes, vary, 400, 420)
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


def test_a_soft_wall_has_the_square_root_alone():
    """The orbit goes on through grazing, and approaches with omega sqrt(R^2 - C^2)."""
    p = nv.load_system("ssul-set6").parameters
    grazing = brentq(lambda omega: shortening({**p, "omega": omega}) - p["C"], 7.2, 8.0, xtol=1e-14)
    share = np.geomspace(1e-6, 1e-10, 9)
    behind = grazing * (1 - share)
    before = grazing * (1 + np.geomspace(1e-10, 0.07, 40))
    vary = {"omega": [*behind, *before]}  # from T,0 downwards, in ever smaller steps
    speeds, _, rate = sections("ssul-set6", {}, vary, 600, 20, start="down")
    assert rate.tolist() == [1.0] * len(behind) + [0.0] * len(before)
    speed = speeds[: len(behind), 3]
    size = np.array([shortening({**p, "omega": omega}) for omega in behind])
    exact = behind * np.sqrt(size**2 - p["C"] ** 2)
    assert (np.abs(speed / exact - 1) < 2e3 * share + 1e-5).all()  # the contact adds of order share
    near = share < 1e-7
    fitted = np.polyfit(np.log((grazing - behind)[near]), np.log(speed[near]), 1)[0]
    assert fitted == pytest.approx(0.5, abs=2e-5)


RECORDED = ("amplitude_min", "amplitude_max", "amplitude_ratio", "two_impacts")


def recorded_modulation(clearance, omega, start):
    """Return the arrays (omega, starts) of a scan of `vi-nes` over omega, by name."""
    sampling = {"changes": {"C": clearance, "D": clearance}, "transient": 1500, "periods": 400}
    scan = scan_of("vi-nes", ["modulation", "impacts"], {"omega": omega}, start, **sampling)
    with nv.scan(scan, quiet=True).read() as view:
        words = view.flags("capture")
        arrays = {name: view[name] for name in RECORDED}
        captured = np.vectorize(words.get)(view["capture"])
        return arrays | {"rate": view["impact_rate"], "capture": captured}


def test_sustained_motion_is_that_of_the_closed_form():
    """Which starts all over reach, below resonance; the amplitude lies within 1 % of it."""
    omega = [0.95, 0.96, 0.97, 0.975]
    start = {"policy": "random", "count": 6, "seed": 1}
    arrays = recorded_modulation(50.0, omega, start)
    assert (arrays["capture"] == "sustained_1_to_1").all()
    assert (arrays["two_impacts"] == 1.0).all()
    np.testing.assert_allclose(arrays["amplitude_min"], arrays["amplitude_max"], rtol=1e-6)
    response = nv.slow_manifold(nv.load_system("vi-nes", C=50.0, D=50.0)).response()
    there = np.isfinite(response.below)
    exact = np.interp(omega, response.below[there], response.amplitude[there])[:, np.newaxis]
    assert np.abs(arrays["amplitude_max"] / exact - 1.0).max() < 0.01


def test_beyond_the_best_clearance_there_is_no_sustained_motion():
    """Gamma = 0.4 > Gamma_opt = 0.339: without impacts, or strongly modulated."""
    omega = np.linspace(1.0, 1.02, 5)
    arrays = recorded_modulation(200.0, omega, {"policy": "up"})
    assert set(arrays["capture"].ravel()) == {"no_impacts", "strongly_modulated"}
    assert (arrays["rate"][2:] > 0.5).all()
    strong = arrays["capture"] == "strongly_modulated"
    ratio = arrays["amplitude_min"] / arrays["amplitude_max"]
    np.testing.assert_allclose(arrays["amplitude_ratio"], ratio, rtol=1e-15)
    assert (arrays["two_impacts"][strong] < 0.9).all()
    assert (arrays["amplitude_min"][strong] < 0.1 * arrays["amplitude_max"][strong]).all()
    low, high = (arrays[name][~strong] for name in ("amplitude_min", "amplitude_max"))
    np.testing.assert_allclose(low, high, rtol=1e-2)
    # the criterion is by impacts a period
    counts = np.array([[0, 0, 0], [200, 197, 0], [200, 198, 0], [201, 201, 0], [400, 10, 0]])
    section = np.zeros((5, 1, 200, 4))
    capture = modulation_of(section, np.ones((5, 1)), counts[:, np.newaxis])["capture"]
    assert capture.ravel().tolist() == [0, 1, 2, 2, 3]


# ---- spectra ----

ALL = ["spectrum", "lines", "broadband"]


def scanned(system, want, vary=None, sampling=None, spectrum=None):
    """Return the archive of a scan, by default over three frequencies."""
    return nv.scan(
        system,
        vary=vary or {"omega": {"values": [5.6, 6.28, 7.1]}},
        sampling={"transient": 400, "periods": 24} | (sampling or {}),
        record={"want": want},
        spectrum=spectrum or {},
        quiet=True,
    )


def test_a_sine_has_one_line_with_the_amplitude_and_phase_of_the_closed_form():
    with scanned("none", ALL, sampling={"transient": 4000}).read() as view:
        exact = response(nv.load_system("none"), view["omega"]).X1
        assert list(view["signal"]) == ["x1"]
        assert view["line_period"].ravel().tolist() == [1, 1, 1]
        amplitude, phase = view["line_amplitude"][:, 0, 0], view["line_phase"][:, 0, 0]
        assert amplitude[:, 0] == pytest.approx(abs(exact), rel=1e-13)
        assert phase[:, 0] == pytest.approx(np.angle(exact), abs=1e-12)
        assert (amplitude[:, 1:] < 1e-13 * abs(exact)[:, np.newaxis]).all()
        spectrum = view["spectrum"][:, 0, 0]
        assert view["frequency"][24] == 1.0
        assert spectrum[:, 24] == pytest.approx(abs(exact), rel=1e-13)
        assert (view["broadband"] < 1e-20).all()
        assert set(view["spectral_label"].ravel().tolist()) == {"T"}


def test_a_disagreement_of_spectra_and_labels_is_told(tmp_path, answer):
    """An orbit that settles slowly: by its multipliers T,0, but its section does not recur yet."""
    options = ["--set", "c1=2", "--vary", "omega=6:6.3:2", "--transient", "20", "--periods", "120"]
    command = ["bifurcation", "--system", "none", *options, "--record", "regime,broadband"]
    report = answer(*command, "-o", tmp_path / "slow.h5").splitlines()
    lines = [line for line in report if line.startswith("spectra")]
    with nv.read(tmp_path / "slow.h5") as view:
        labels, spectral = view["label"].ravel(), view["spectral_label"].ravel()
        agree, words = view["spectra_agree"].ravel(), view.flags("spectra_agree")
    assert set(labels.tolist()) == {"T,0"}
    assert "T" not in spectral.tolist()
    judged = agree[spectral != "unclear"]
    assert {words[code] for code in judged.tolist()} == {"no"}
    (line,) = lines
    assert line.startswith(f"spectra disagree: {len(judged)} of {len(judged)} orbits: ")


def test_the_linear_damper_has_its_closed_form_in_both_signals():
    with scanned("tmd", ["lines"], sampling={"transient": 4000}).read() as view:
        both = response(nv.load_system("tmd"), view["omega"])
        exact = np.stack([both.X1, both.X2 - both.X1], axis=1)
        assert view["line_amplitude"][:, 0, :, 0] == pytest.approx(abs(exact), rel=1e-12)
        assert view["line_phase"][:, 0, :, 0] == pytest.approx(np.angle(exact), abs=1e-11)
        assert view["line_amplitude"].shape[-1] == LINES
        assert "spectrum" not in view
        assert "broadband" not in view


def test_lines_of_a_subharmonic_orbit_make_it_again():
    """A 3T orbit is the sum of its recorded lines but for those beyond them."""
    system = nv.load_system("ssul-set6", omega=7.45)
    sampling = {"transient": 3000, "periods": 25}  # no multiple of 3
    vary = {"omega": {"values": [7.45]}}
    with scanned(system, ["lines"], vary, sampling, {"samples": 256}).read() as view:
        assert view["line_period"].item() == 3
        orbit = nv.simulate(system, 3, transient=3000, record=["trajectory"], samples=256)
        numbers = np.arange(1, LINES + 1)[:, np.newaxis]
        angle = numbers * system.parameters["omega"] * orbit.time / 3
        lines = view["line_amplitude"][0, 0, 0, :, np.newaxis]
        made = (lines * np.cos(angle + view["line_phase"][0, 0, 0, :, np.newaxis])).sum(axis=0)
        x1 = orbit.trajectory[:, 0]
        assert made == pytest.approx(x1 - x1.mean(), abs=3e-3 * np.ptp(x1))


def test_parseval_with_the_recorded_rms():
    spectrum = {"window": "rectangular", "samples": 512, "highest": 255.0, "signals": ["x1", "v1"]}
    want = ["response", "spectrum"]
    with scanned("ssul-set6", want, spectrum=spectrum).read() as view:
        amplitude = view["spectrum"][:, 0]
        for i, (name, bound) in enumerate((("x1_rms", 1e-9), ("v1_rms", 1e-5))):
            squares = amplitude[:, i, 0] ** 2 + 0.5 * (amplitude[:, i, 1:] ** 2).sum(axis=1)
            assert squares == pytest.approx(view[name][:, 0] ** 2, rel=bound)
        assert view.units("spectrum") == "m, m/s"


def test_the_broadband_share_tells_periodic_quasiperiodic_and_chaotic_apart():
    vary = {"omega": {"values": [7.0, 7.38125, 7.3825, 7.385, 7.4175, 7.42, 7.45]}}
    sampling = {"transient": 1500, "periods": 240}
    with scanned("ssul-set6", ["regime", "broadband"], vary, sampling).read() as view:
        labels, share = view["label"][:, 0], view["broadband"][:, 0].max(axis=1)
        chaos = share[labels == "chaos"]
        lines = share[labels == "quasiperiodic"]
        periodic = share[np.char.find(labels.astype(str), "T,") > 0]
        assert min(map(len, (chaos, lines, periodic))) >= 1
        assert periodic.max() < 1e-20
        assert lines.min() > 1e-9
        assert lines.max() < 2e-4
        assert chaos.min() > 2e-3


@pytest.mark.parametrize(("periods", "judged"), [(60, 0), (120, 4), (240, 4)])
def test_no_quasiperiodic_motion_is_called_broadband(periods, judged):
    """With 60 periods all four have shares above 1e-3, because their lines crowd."""
    vary = {"omega": {"values": [7.368, 7.416, 7.42, 7.423]}}
    sampling = {"transient": 1500, "periods": periods}
    with scanned("ssul-set6", ["regime", "broadband"], vary, sampling).read() as view:
        assert set(view["label"].ravel().tolist()) == {"quasiperiodic"}
        assert "broadband" not in view["spectral_label"]
        assert KEPT["no"] not in view["spectra_agree"]
        assert np.count_nonzero(view["spectra_agree"] == KEPT["yes"]) == judged


def test_a_waterfall_shows_amplitudes_in_decades():
    archive = scanned("tmd", ALL)
    with archive.read() as view:
        amplitude = view["spectrum"][:, 0, 0, 1:]
    figure = nv.plot(archive, "spectrum:x1,broadband:u,line_amplitude:x1")
    waterfall, broadband, lines = (axes for axes in figure.axes if axes.get_ylabel())
    (mesh,) = waterfall.collections
    values = np.asarray(mesh.get_array())
    assert values.shape == amplitude.T.shape
    assert values.max() == amplitude.max()
    assert mesh.norm.vmin == pytest.approx(1e-6 * amplitude.max())
    assert waterfall.get_ylabel() == r"spectrum of $x_1$, $\Omega/\omega$"
    assert broadband.get_ylabel() == "broadband share, $x_2-x_1$"
    assert lines.get_ylabel() == "amplitudes of lines, $x_1$ [m]"
    assert lines.get_yscale() == "log"


def test_a_failed_orbit_has_no_spectrum():
    vary = {"omega": {"values": [1e-7, 6.28]}}  # too stiff: millions of cells
    with scanned("ssul-set6", ["impacts", *ALL], vary).read() as view:
        assert view["status"][0, 0] != 0
        assert np.isnan(view["spectrum"][0]).all()
        assert np.isnan(view["broadband"][0]).all()
        assert view["spectral_label"][0, 0] == ""
        assert np.isfinite(view["spectrum"][1]).all()
