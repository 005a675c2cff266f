"""Energies of equation (6): what an impact passes on, and maxima with and without the transient."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm
from support import BOTH, fitted_order, linear_flow, references, system_of

from nlds_vines.model.catalog import load_system
from nlds_vines.model.linear_response import energy_alone
from nlds_vines.orbits.simulation import simulate
from scans import computed, scan_of

SET6 = references()["ssul-set6"].numbers
STEEL = references()["ssul-set6-steel"].numbers["K"]
SSBL = references()["ssbl-omega6.05"].numbers
FREE = {"c1": 0.0, "c2": 0.0, "P": 0.0}
PEAKS = ("energy", "peak")
FINEST = {"nodes": 24, "contact_steps": 64.0}


def energies(p, state, rest):
    """Return E1 and E2 [J] of equation (6)."""
    x1, v1, x2, v2 = state
    e1 = (p["m1"] * v1**2 + p["k1"] * x1**2) / 2
    return np.array([e1, (p["m2"] * v2**2 + p["k2"] * (x2 - rest) ** 2) / 2])


# ---- what an impact passes on --------------------------------------------------------------------


def one_impact(p, v1, s):
    """Return the states at touch and release of an impact from x1 = 0, and its row.

    The start lies on the wall, and the second run has its section at the release.
    """
    start = np.array([0.0, v1, p["V"], v1 - s])
    row = simulate(system_of("ssul", p), 1, start=start, record=BOTH, **FINEST).impacts[0]
    q = {**p, "omega": 2 * np.pi / row["release"]}
    orbit = simulate(system_of("ssul", q), 1, start=start, record=BOTH, **FINEST)
    return start, orbit.section[0], row


@pytest.mark.parametrize("K", [1e5, SET6["K"], STEEL])
@pytest.mark.parametrize(("v1", "s"), [(0.4, 1.5), (-0.4, 1.5), (0.1, 0.05)])
def test_gains_are_differences_of_the_energies(K, v1, s):
    p, rest = {**SET6, **FREE, "K": K, "omega": 1.0}, SET6["V"] + SET6["C"]
    touch, release, row = one_impact(p, v1, s)
    assert row["touch"] == 0.0
    before, after = energies(p, touch, rest), energies(p, release, rest)
    scale = before.sum()
    gains = np.array([row["gain1"], row["gain2"]])
    np.testing.assert_allclose(gains, after - before, rtol=0, atol=1e-11 * scale)
    # E2 takes the absolute displacement w, not the stretch, which is the same at both ends:
    # but for that, what the one gains the other loses
    w = touch[2] - rest, release[2] - rest
    share = p["k2"] * (w[1] ** 2 - w[0] ** 2) / 2
    assert gains.sum() == pytest.approx(share, abs=1e-11 * scale)


def test_gains_of_a_rigid_impact():
    """With K to infinity, as K^(-2/5): gain1 = -gain2 = -J v1 + J^2 / 2 m1, J = 2 mu s."""
    stiffness, v1, s = SET6["K"] * 10.0 ** np.arange(2, 11, 2), 0.4, 1.5
    mu = SET6["m1"] * SET6["m2"] / (SET6["m1"] + SET6["m2"])
    rigid = -2 * mu * s * v1 + (2 * mu * s) ** 2 / (2 * SET6["m1"])
    rows = [one_impact({**SET6, **FREE, "K": K, "omega": 1.0}, v1, s)[2] for K in stiffness]
    errors = [max(abs(row["gain1"] - rigid), abs(row["gain2"] + rigid)) for row in rows]
    sums = [abs(row["gain1"] + row["gain2"]) for row in rows]
    assert fitted_order(errors, stiffness) == pytest.approx(0.4, abs=0.01)
    assert fitted_order(sums, stiffness) == pytest.approx(0.4, abs=0.01)
    assert errors[-1] < 1e-4 * abs(rigid)


@pytest.mark.kernels
@pytest.mark.parametrize(("kind", "numbers"), [("ssul", SET6), ("ssbl", SSBL)])
@pytest.mark.parametrize("options", [{}, {"method": "rk4"}], ids=["exact", "rk4"])
def test_gains_cancel_but_for_the_work_of_the_other_forces(kind, numbers, options):
    """Force, dashpots and springs have little time to work; bounds of their power times that."""
    system = system_of(kind, numbers)
    hits = simulate(system, 60, record=BOTH, **options).impacts
    hits = hits[~np.isnan(hits["release"])]
    assert len(hits) > 50
    v1, s, x = 1.0, hits["speed"].max(), 0.2  # more than any speed and displacement here
    dashpots = numbers["c1"] * v1**2 + numbers["c2"] * (1.5 * s) ** 2
    power = numbers["P"] * v1 + dashpots + numbers["k2"] * x * (v1 + 2 * s)
    lasting = hits["release"] - hits["touch"]
    total = hits["gain1"] + hits["gain2"]
    assert (np.abs(total) <= power * lasting).all()
    assert np.median(np.abs(total) / np.abs(hits["gain2"])) < 0.1


def test_an_impact_under_way_has_no_gain_yet():
    hits = simulate(system_of("ssul", SET6), 4, record=BOTH).impacts
    assert np.isnan(hits["release"][-1])
    assert np.isnan([hits["gain1"][-1], hits["gain2"][-1]]).all()
    assert np.isfinite([hits["gain1"][:-1], hits["gain2"][:-1]]).all()


# ---- maxima with and without the transient -------------------------------------------------------


@pytest.mark.kernels
def test_peaks_and_maxima():
    system = system_of("ssul", SET6)
    whole = simulate(system, 60, record=PEAKS)
    assert (whole.E1peak, whole.E2peak) == (whole.E1max, whole.E2max)
    late = simulate(system, 20, transient=40, record=PEAKS)
    assert late.E1peak == pytest.approx(whole.E1peak, rel=1e-9)
    assert late.E2peak == pytest.approx(whole.E2peak, rel=1e-9)
    assert late.E1max < 0.9 * late.E1peak  # the transient is the larger here
    sweep = [simulate(system, 2, transient=n, record=PEAKS) for n in range(0, 30, 3)]
    for one, next_one in pairwise(sweep):
        assert one.E1peak <= next_one.E1peak * (1 + 1e-9)
        assert one.E1max <= one.E1peak
        assert one.E2max <= one.E2peak


@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_the_peak_of_a_linear_transient(method):
    """Against matrix exponentials on a fine grid, a parabola through its highest samples."""
    system, n = load_system("tmd"), 4000
    options = {} if method == "exact" else {"method": method, "period_steps": 2048.0}
    orbit = simulate(system, 3, transient=40, record=PEAKS, **options)
    step = expm(linear_flow(system.parameters) * system.period / n)
    y, values = np.array([0.0, 0, 0, 0, 1, 0]), []
    for _ in range(43 * n):
        values.append(energies(system.parameters, y[:4], 0.0))
        y = step @ y
    for peak, course in zip((orbit.E1peak, orbit.E2peak), np.array(values).T, strict=True):
        i = course.argmax()
        before, top, after = course[i - 1 : i + 2]
        highest = top - (after - before) ** 2 / (8 * (after - 2 * top + before))
        assert peak == pytest.approx(highest, rel=1e-9)


@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_a_start_may_be_the_peak(method):
    """From 3 m/s the dashpot takes more than the force gives: 4500 J, then the steady 1568.00."""
    start = (0.0, 3.0)
    orbit = simulate(
        load_system("none"), 3, transient=200, start=start, record=PEAKS, method=method
    )
    assert orbit.E1peak == 4500.0
    assert round(orbit.E1max, 2) == 1568.00
    assert orbit.E2peak is None


@pytest.mark.kernels
def test_a_scan_stores_both():
    arrays = computed(scan_of("tmd", PEAKS, {"omega": [6.0, 6.28]}, transient=40, periods=3))
    for i, omega in enumerate((6.0, 6.28)):
        orbit = simulate(load_system("tmd", omega=omega), 3, transient=40, record=PEAKS)
        for name in ("E1max", "E2max", "E1peak", "E2peak"):
            assert arrays[name][i, 0] == getattr(orbit, name)
    assert (arrays["E1peak"] >= arrays["E1max"]).all()


@pytest.mark.kernels
def test_the_reduction_is_measured_by_the_structure_alone():
    vary = {"omega": [6.21, 6.28], "P": [0.0, 800.0]}
    scan = scan_of("tmd", ["energy"], vary, transient=100, periods=2)
    arrays = computed(scan)["reduction"][..., 0]
    assert arrays[1, 1] == pytest.approx(1.0 - 635.107 / 1568.00, abs=1e-6)
    assert np.isnan(arrays[:, 0]).all()  # nothing moves: there is nothing to reduce
    alone = energy_alone(scan.cells())
    assert alone[1, 1] == pytest.approx(1568.00, abs=0.01)
    assert arrays[0, 1] == pytest.approx(1.0 - 660.435 / alone[0, 1], abs=1e-6)
