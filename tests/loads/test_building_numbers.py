"""Drift ratios, units of reports, systems beside designs, and histories that round-off changes."""

import math

import numpy as np
import pytest
import scipy.linalg
import scipy.signal

import nlds_vines as nv
from nlds_vines.loads.request import load_response_history
from nlds_vines.loads.units import shown_in
from nlds_vines.model.system import warburton

FRAME = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
STEP = 0.02
BLOW = {"impulse": 2e4, "on": "roof"}


def cell(**options):
    walls = [nv.Wall(0.02, side, law="restitution", e=0.8) for side in "+-"]
    return nv.Damper("cell", "roof", **{"m": 900.0, "k": 100.0, "walls": walls, **options})


def design():
    return nv.System.from_host(FRAME, [cell()], name="design")


def quake(count=200, seed=1):
    generator = np.random.default_rng(seed)
    times = STEP * np.arange(count)
    values = 4.0 * generator.uniform(-1.0, 1.0, count) * np.sin(np.pi * times / times[-1])
    return {"record": {"times": times.tolist(), "values": values.tolist(), "unit": "m/s^2"}}


@pytest.mark.parametrize(
    ("heights", "expected"),
    [
        (3.5, {"floor1": 3.5, "floor2-floor1": 3.5, "roof-floor2": 3.5}),
        ([4.0, 3.5, 3.0], {"floor1": 4.0, "floor2-floor1": 3.5, "roof-floor2": 3.0}),
        (["4", "3.5", "3"], {"floor1": 4.0, "floor2-floor1": 3.5, "roof-floor2": 3.0}),
        ({"roof-floor1": 7.0}, {"roof-floor1": 7.0}),
    ],
)
def test_heights_are_those_of_storeys_from_below(heights, expected):
    changes = {"load": BLOW, "record": {"heights": heights}}
    request = load_response_history(design(), changes)
    assert request.heights == expected
    again = load_response_history(request.document())
    assert (again.heights, again.hash) == (request.heights, request.hash)
    plain = load_response_history(design(), {"load": BLOW})
    assert plain.heights == ()


@pytest.mark.parametrize(
    ("heights", "words"),
    [
        ([3.0, 3.0], "2 heights for 3 degrees of freedom"),
        (0.0, "heights = 0.0 must be between 0 and"),
        ([], "must have a height for each storey"),
        ("tall", "must be a number"),
        ({"attic": 3.0}, "attic"),
    ],
)
def test_heights_that_fit_no_storey_are_refused(heights, words, error_of):
    changes = {"load": BLOW, "record": {"heights": heights}}
    assert words in error_of(load_response_history, design(), changes)


def test_heights_beside_kinds_alone_are_refused(error_of):
    changes = {"load": {"impulse": 1.0}, "record": {"heights": 3.0}}
    assert "no system has storeys" in error_of(load_response_history, "tmd", changes)


def test_units_of_reports():
    assert shown_in("roof.a_max", [1.0], True) == (1.0 / 9.80665, "g")
    assert shown_in("roof.a_max", [1.0], False) == (1.0, "m/s^2")
    assert shown_in("drift_ratio_max", [0.01], False) == (100.0, "%")
    assert shown_in("cell.force_max", [9999.0, math.inf], True) == (1.0, "N")
    assert shown_in("cell.force_max", [1e4, math.nan], True) == (1e-3, "kN")
    assert shown_in("cell.impulse_max", [2e4], True) == (1e-3, "kN s")


def test_structure_alone_and_tuned_mass_stand_beside_designs(error_of):
    def names(systems, *beside):
        changes = {"load": quake(), "record": {"beside": list(beside)}}
        return [one.name for one in load_response_history(systems, changes).systems]

    assert names(design(), "alone", "tmd") == ["none", "tmd", "design"]
    assert names(design(), "tmd") == ["tmd", "design"]
    other = nv.System.from_host(FRAME, [cell(m=300.0)], name="other")
    assert names([design(), other], "alone") == ["none", "design", "other"]
    assert names([design(), other], "tmd") == ["tmd", "tmd 2", "design", "other"]
    assert names(["none", "ssul-set6"], "alone") == ["none", "ssul-set6"]
    changes = {"load": quake(), "record": {"beside": ["alone", "tmd"]}}
    request = load_response_history(design(), changes)
    again = load_response_history(request.document())
    assert again.systems == request.systems or again.hash == request.hash
    assert "unknown beside 'tuned'" in error_of(names, design(), "tuned")
    massless = nv.Damper("brace", ("roof", "floor2"), k=1e3, walls=[nv.Wall(0.1, K=1e7)])
    system = nv.System.from_host(FRAME, [massless], name="braced")
    assert "has no damper whose mass" in error_of(names, system, "tmd")


def variance(mu, frequency, zeta, shaken):
    """Return the variance of x1 under white noise of an undamped structure, m1 = k1 = 1."""
    k2 = mu * frequency**2
    c2 = 2.0 * zeta * math.sqrt(k2 * mu)
    M, K = np.diag([1.0, mu]), np.array([[1.0 + k2, -k2], [-k2, k2]])
    C = np.array([[c2, -c2], [-c2, c2]])
    A = np.block([[np.zeros((2, 2)), np.eye(2)],
                  [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])  # fmt: skip
    b = np.array([0.0, 0.0, 1.0, 1.0 if shaken else 0.0])
    return scipy.linalg.solve_continuous_lyapunov(A, -np.outer(b, b))[0, 0]


@pytest.mark.parametrize("shaken", [False, True])
def test_tuned_masses_have_the_least_variance_of_a_structure_under_noise(shaken, error_of):
    best = warburton(0.1, shaken)
    least = variance(0.1, *best, shaken)
    for change in (0.99, 1.01):
        assert variance(0.1, best[0] * change, best[1], shaken) > least
        assert variance(0.1, best[0], best[1] * change, shaken) > least
    assert "allowed: below 1" in error_of(warburton, 1.0, shaken)


def test_tuned_masses_of_frames_and_kinds():
    tuned = design().with_tuned_mass(shaken=True)
    (damper,) = tuned.dampers
    mu = 900.0 * FRAME.modes[2, 0] ** 2
    rate = FRAME.frequencies[0] * warburton(mu, True)[0]
    assert (damper.m, damper.k) == pytest.approx((900.0, 900.0 * rate**2), rel=1e-12)
    preset = nv.load_system("ssul-set6").with_tuned_mass(shaken=False).parameters
    mu = preset["m2"] / preset["m1"]
    ratio = math.sqrt(preset["k2"] / preset["m2"] * preset["m1"] / preset["k1"])
    zeta = preset["c2"] / (2.0 * math.sqrt(preset["k2"] * preset["m2"]))
    assert (ratio, zeta) == pytest.approx(warburton(mu, False), rel=1e-12)


def test_a_larger_load_by_round_off():
    request = load_response_history(
        "tmd", {"load": {"impulse": 2.0}, "start": {"state": [1, 0, 0, 0]}}
    )
    moved = request.moved()
    assert moved.load.scale == 1.0 + 1e-12
    assert moved.state == (1.0 + 1e-12, 0.0, 0.0, 0.0)


@pytest.mark.kernels
def test_drift_ratios_of_a_frame_beside_lsim():
    system = nv.System.from_host(FRAME)
    histories = nv.response_history(
        system, load=quake(), duration=6.0, heights=[4.0, 3.5, 3.0], of="roof", quiet=True
    )
    M, C, K = FRAME.M, FRAME.C, FRAME.K
    A = np.block([[np.zeros((3, 3)), np.eye(3)],
                  [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])  # fmt: skip
    B = np.concatenate([np.zeros(3), -np.ones(3)])[:, np.newaxis]
    record = quake()["record"]
    fine = np.arange(0.0, 6.0, STEP / 64)
    ground = np.interp(fine, record["times"], record["values"], right=0.0)
    plant = scipy.signal.StateSpace(A, B, np.eye(6), np.zeros((6, 1)))
    _, states, _ = scipy.signal.lsim(plant, ground, fine)
    x = states[:, :3]
    drifts = [x[:, 0], x[:, 1] - x[:, 0], x[:, 2] - x[:, 1]]
    ratios = [np.abs(one).max() / h for one, h in zip(drifts, (4.0, 3.5, 3.0), strict=True)]
    numbers = histories["host"].numbers
    names = ("floor1", "floor2-floor1", "roof-floor2")
    mine = [numbers[f"{name}.drift_ratio"] for name in names]
    assert mine == pytest.approx(ratios, rel=1e-4)
    assert numbers["drift_ratio_max"] == max(mine)
    assert "roof.drift_ratio" not in numbers
    assert "drift_ratio_max [%]" in "\n".join(histories.lines()) or len(histories.results) == 1


@pytest.mark.kernels
def test_a_comparison_in_g_and_per_cent_says_what_rigid_walls_do():
    histories = nv.response_history(
        design(), load=quake(), duration=6.0, heights=3.5, beside=["alone", "tmd"], quiet=True
    )
    report = "\n".join(histories.lines())
    assert "roof.a_max [g]" in report
    assert "drift_ratio_max [%]" in report
    assert "roof-floor2.a_max" not in report
    assert "roof.a_max: infinite where the impulse of a rigid wall acts" in report
    rows = {row[0]: row[1:] for row in histories.rows()}
    assert rows[""] == ["none", "tmd", "design"]
    assert rows["roof.a_max [g]"][2] == "inf"
    alone = histories["none"].numbers
    assert rows["drift_ratio_max [%]"][0] == f"{100 * alone['drift_ratio_max']:.4g}"
    histories.plot("roof.a,peaks")


@pytest.mark.kernels
def test_a_history_that_round_off_changes_is_reported(here):
    walls = [nv.Wall(0.02, side, law="restitution", e=0.95) for side in "+-"]
    free = nv.System.from_host(FRAME, [cell(walls=walls)], name="free")
    histories = nv.response_history(
        free, load=quake(1200), duration=25.0, to="chaos.h5", quiet=True
    )
    assert nv.open_archive("chaos.h5")["free"].is_sensitive
    assert "the history is chaotic" in "\n".join(histories.lines())
    short = nv.response_history(free, load=quake(), duration=1.0, quiet=True)
    assert not short["free"].is_sensitive
    suite = nv.response_history(
        free, load={"suite": [quake(1200, seed)["record"] for seed in (1, 2)]}, duration=25.0,
        quiet=True,
    )  # fmt: skip
    assert suite.is_sensitive.shape == (2, 2)
    assert "records loads larger by 1e-12" in "\n".join(suite.lines())
