"""A struck structure: closed forms, the balance of energies, last times, archives, refusals."""

import math
from dataclasses import replace
from itertools import pairwise

import h5py
import numpy as np
import pytest
from scipy.integrate import quad
from support import linear_flow

import nlds_vines as nv
from nlds_vines.engine.records import STATUS
from nlds_vines.loads import datasets, run
from nlds_vines.loads.picture import draw
from nlds_vines.loads.request import load_response_history
from nlds_vines.loads.run import arrays_of
from nlds_vines.model.linear_response import closed_form, flow_matrix
from nlds_vines.model.quantities import HISTORIES, OF_LOADS, SHARES
from nlds_vines.plotting.page import ONE_COLUMN, TWO_COLUMNS
from nlds_vines.runs.executors import use_threads
from nlds_vines.upkeep.rerun import differing

SHORT = {"duration": 12.0, "quiet": True}


def made_up(request, cases, stop, tell=None):
    """Return invented arrays of the cases of presets: every value is 1."""
    count = len(cases)
    has_symbols = [entry for entry in OF_LOADS if entry.dims != ("displacement",)]
    arrays = {entry.name: np.ones(count, entry.dtype) for entry in has_symbols}
    if not request.vary:
        names = HISTORIES.keys() - {"x", "a", "stroke"}
        arrays |= {name: np.ones((count, len(request.times))) for name in names}
    return {**arrays, "status": np.zeros(count, int)}


def matrix(name):
    """Return A of y' = A y: of (x1, v1) of the structure alone, of (x1, v1, x2, v2) with a TMD."""
    p = nv.load_system(name).parameters
    alone = np.array([[0.0, 1.0], [-p["k1"] / p["m1"], -p["c1"] / p["m1"]]])
    return linear_flow(p)[:4, :4] if "m2" in p else alone


def free(name, times, *start):
    """Return the states (size, n) of a linear system that is set free, by the modes of A."""
    values, modes = np.linalg.eig(matrix(name))
    parts = np.linalg.solve(modes, np.array(start, complex))
    return (modes @ (parts[:, None] * np.exp(values[:, None] * times))).real


@pytest.mark.kernels
def test_the_structure_alone_and_with_a_tmd_in_closed_form():
    histories = nv.response_history(["none", "tmd"], impulse=1000.0, **SHORT)
    fall, tmd = histories["none"], histories["tmd"]
    p = nv.load_system("none").parameters

    def energy(times):
        x, v = free("none", times, 0.0, 1.0)
        return 0.5 * p["m1"] * v**2 + 0.5 * p["k1"] * x**2

    np.testing.assert_allclose(fall.E1, energy(fall.time), rtol=0, atol=1e-11 * 500)
    np.testing.assert_allclose(fall.x1, free("none", fall.time, 0.0, 1.0)[0], rtol=0, atol=1e-12)
    for share, last in zip(SHARES, fall.last, strict=True):
        assert energy(last - 1e-9) > share * 500.0
        assert (energy(np.linspace(last + 1e-9, 20.0, 20000)) < share * 500.0).all()
    # the equivalent ratio of a structure alone is its own, but for where in a swing 10 % lies
    zeta = p["c1"] / (2 * math.sqrt(p["k1"] * p["m1"]))
    assert fall.numbers["damping_ratio"] == pytest.approx(zeta, rel=0.05)
    x1, _, x2, _ = free("tmd", tmd.time, 0.0, 1.0, 0.0, 0.0)
    np.testing.assert_allclose([tmd.x1, tmd.x2], [x1, x2], rtol=0, atol=1e-12)
    # without walls a blow the other way has the mirror image
    mirrored = nv.response_history("tmd", impulse=-1000.0, **SHORT)["tmd"]
    np.testing.assert_array_equal(tmd.x1, -mirrored.x1)
    np.testing.assert_array_equal(tmd.E1, mirrored.E1)
    # a free decay
    decays = nv.response_history("none", start={"state": (0.1, 0.5)}, **SHORT)
    fall = decays["none"]
    assert decays.times == dict(zip(SHARES, fall.last, strict=True))
    np.testing.assert_allclose(fall.x1, free("none", fall.time, 0.1, 0.5)[0], rtol=0, atol=1e-13)
    assert fall.numbers["energy_in"] == 0.5 * p["m1"] * 0.25 + 0.5 * p["k1"] * 0.01
    assert fall.numbers["balance"] < 1e-13


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("impulse", "times"),
    [
        (300.0, {"none": 10.112, "tmd": 6.553, "ssbl": 7.114, "ssul-set6": 8.381}),
        (1000.0, {"none": 10.112, "tmd": 6.553, "ssbl": 7.012, "ssul-set6": 5.715}),
        (1770.0, {"none": 10.112, "tmd": 6.553, "ssbl": 6.581, "ssul-set6": 5.490}),
    ],
)
def test_the_paper_s_dampers_under_a_blow(impulse, times):
    """Computed with other programs: SciPy's DOP853 beside the twin of the tests."""
    histories = nv.response_history(impulse=impulse, **SHORT)
    assert {name: round(fall.last[0], 3) for name, fall in histories.results.items()} == times
    for fall in histories.results.values():
        assert fall.numbers["balance"] < 1e-11
        shares = [energies[-1] for energies in fall.dissipated.values()]
        assert np.nansum(shares) < fall.numbers["energy_in"]


@pytest.mark.parametrize("words", ["--system tmd", "", "--vary impulse=1:9:3"])
def test_status_and_remedy_of_a_failed_damper_are_told(words, ask, refusal, here, monkeypatch):
    def failed(request, cases, *others):
        arrays = made_up(request, cases, *others)
        if request.case(cases[0])[0].name == "ssbl":
            fill = {"f": np.nan, "i": -1}
            arrays = {k: np.full_like(v, fill[v.dtype.kind]) for k, v in arrays.items()}
            arrays["status"] = np.full(len(cases), max(STATUS))
        return arrays

    monkeypatch.setattr(run, "arrays_of", failed)
    remedy = STATUS[max(STATUS)].remedy
    asked = f"response-history {words} --system ssbl --impulse 9 --duration 3 -o many.h5"
    out, err = ask(*asked.split(), status=1)
    assert remedy in out
    archive = nv.open_archive("many.h5")
    assert remedy in "\n".join(archive.lines())
    if words == "--system tmd":
        assert "1 of 2 orbits failed" in err
        assert (archive["tmd"].status, archive["ssbl"].status) == (0, max(STATUS))
        assert np.isnan(archive["ssbl"].E1).all()
    else:
        assert "orbits failed" in err
        assert remedy in refusal("plot", "many.h5")


# ---- command, archive, picture -------------------------------------------------------------------


@pytest.fixture
def drawn_and_made_again(here, answer):
    """Return a function that computes, draws and computes again, and opens the first."""

    def opened(words, panel):
        answer(*f"response-history {words} -o a.h5 --plot history.png --quiet".split())
        assert (here / "history.png").stat().st_size > 10000
        answer("plot", "a.h5", "--show", panel, "-o", "panel.pdf")
        assert "results are the same" in answer("rerun", "a.h5", "-o", "again.h5")
        return nv.open_archive("a.h5")

    return opened


@pytest.mark.kernels
def test_an_archive_is_written_drawn_opened_and_made_again(drawn_and_made_again):
    words = "--system none --system ssul-set6 --impulse 1000 --duration 5"
    histories = drawn_and_made_again(words, "energy")
    assert list(histories.results) == ["none", "ssul-set6"]
    assert histories["ssul-set6"].numbers["impact_count"] >= 1
    with nv.read("a.h5") as view:
        assert "impulse_max" not in view  # no wall is rigid


@pytest.mark.kernels
def test_a_scan_holds_what_single_decays_tell(drawn_and_made_again):
    varied = "--vary impulse=300:1000:2 --vary c1=400:452:2"
    words = f"--system tmd --system ssul-set6 {varied} --duration 12"
    histories = drawn_and_made_again(words, "x1_max")
    assert histories["last_1"].shape == (2, 2, 2)
    alone = nv.response_history("ssul-set6", impulse=1000.0, set={"c1": 400.0}, **SHORT)
    single = alone["ssul-set6"]
    for name in ("last_1", "x1_max", "share_c2", "impact_count", "stroke_max"):
        assert histories[name][1, 1, 0] == pytest.approx(single.numbers[name], rel=1e-11)
    assert (histories["impact_count"][0] == -1).all()


@pytest.mark.parametrize(
    ("words", "stopped", "resumed"),
    [
        ("--system none --system tmd --impulse 9", ["none 9", "tmd 9"], ["tmd 9"]),
        (
            "--system tmd --vary impulse=1:8:8",
            [f"tmd {impulse}" for impulse in range(1, 6)],
            [f"tmd {impulse}" for impulse in range(3, 9)],  # the first block, of two, was kept
        ),
    ],
    ids=["histories", "a scan"],
)
def test_an_interrupted_run_goes_on(words, stopped, resumed, here, answer, monkeypatch):
    seen = []

    def once(request, cases, stop, tell=None):
        pairs = [request.case(case) for case in cases]
        seen.extend(f"{system.name} {load.impulse:g}" for system, load in pairs)
        if len(seen) == len(stopped):
            raise KeyboardInterrupt
        return made_up(request, cases, stop) | {
            "x1_max": np.array([load.impulse for _, load in pairs])
        }

    monkeypatch.setattr(datasets, "BLOCK", 3)
    monkeypatch.setattr(run, "arrays_of", once)
    asked = "response-history", *words.split(), "--duration", "3", "--quiet", "-o"
    answer(*asked, "a.h5", status=130)
    answer(*asked, "a.h5", "--resume")
    afresh = len(seen)
    answer(*asked, "whole.h5")
    assert differing(here / "a.h5", here / "whole.h5") == []
    assert seen[:afresh] == [*stopped, *resumed]


def test_what_is_set_is_set_of_systems_that_have_it():
    document = {
        "systems": ["none", "tmd"], "set": {"zeta1": 0.02, "mass_ratio": 0.1, "k1": 4e4},
        "sampling": {"duration": 7.0},
    }  # fmt: skip
    request = load_response_history({**document, "load": {"impulse": 1.0}})
    assert load_response_history(request.document()) == request
    alone, damped = request.systems
    assert alone.parameters["k1"] == damped.parameters["k1"] == 4e4
    assert alone.ratios["zeta1"] == damped.ratios["zeta1"] == pytest.approx(0.02)
    assert damped.parameters["m2"] == pytest.approx(0.1 * damped.parameters["m1"])
    # a law with its constants, where there are walls
    document = BLOW | {"systems": ["tmd", "ssul-set6"], "set": {"law": "restitution", "e": 0.7}}
    tmd, ssul = load_response_history(document).systems
    assert "e" not in tmd.parameters
    assert (ssul.law, ssul.parameters["e"]) == ("restitution", 0.7)
    _, ssul = load_response_history(document, {"set": {"e": 0.8}}).systems
    assert ssul.parameters["e"] == 0.8


BLOW = {"load": {"impulse": 1.0}}


def over(**values):
    return {"vary": {name: {"values": list(few)} for name, few in values.items()}}


def record(time):
    return {"load": {"record": {"times": [0.0, time], "values": [0.0, 1.0], "unit": "g"}}}


COLUMNS = {"k1": [3.8e4, 4.0e4], "impulse": [200.0, 400.0], "zeta1": [0.01, 0.03]}


def table(**columns):
    return {"systems": ["none", "tmd"], "samples": columns}


NOISE = {"load": {"noise": {"rms": 1.0, "high": 20.0, "tones": 400}}}


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ({}, ["load", "impulse"]),
        ({"load": {"impulse": 0.0}}, ["load", "empty"]),
        (over(impulse=(0.0, 1.0)), ["load", "empty"]),
        (BLOW | over(C=(1.0, 2.0)), ["'C'", "tmd"]),
        (BLOW | over(impulse=(1.0, 2.0), k1=(1.0, 2.0), c1=(1.0, 2.0)), ["3 parameters", "or two"]),
        (BLOW | over(**{"friedlander.peak": (1.0, 2.0)}), ["friedlander.peak", "allowed: one"]),
        ({"start": {"state": [0.1, 0.0]}}, ["state", "x2, v2"]),
        (BLOW | {"systems": ["none"], "set": {"K": 1e7}}, ["K"]),
        (record(0.5), ["too coarse", "natural period"]),
        (record(0.05) | over(k1=(40000.0, 4e6)), ["too coarse", "natural period 0.09"]),
        (NOISE | over(**{"noise.high": (20.0, 80.0)}), ["400 tones", "repeats itself"]),
        (BLOW | {"systems": ["tmd", "tmd"]}, ["tmd", "twice"]),
        (BLOW | {"systems": []}, ["system"]),
        (BLOW | {"sampling": {"duration": 1e9}}, ["natural periods", "10000000"]),
        (BLOW | {"set": {"K": 1.0}}, ["K"]),
        (BLOW | {"set": {"scale": 2.0}}, ["[set]", "scale belongs in [load]", "--vary scale"]),
        (NOISE | {"set": {"noise.rms": 2.0}}, ["noise.rms belongs in [load]", "noise:rms=VALUE"]),
        (table(k1=[4e4, -1.0], impulse=[1.0, 2.0]), ["k1 = -1.0"]),
        (table(k3=[4e4], impulse=[1.0]), ["k3"]),
        (table(omega=[6.0], impulse=[1.0]), ["the harmonic force is off"]),
        (table(impulse=[1.0, float("nan")]), ["row 2: impulse = nan"]),
        (table(**COLUMNS) | over(impulse=(1.0, 2.0)), ["beside [vary]"]),
    ],
)
def test_bad_requests_get_one_line(document, words, error_of):
    message = error_of(load_response_history, {"systems": ["tmd"], **document})
    assert all(word in message for word in words), message


# ---- loads in time, starts, scans ----------------------------------------------------------------


@pytest.mark.kernels
def test_the_harmonic_force_alone_is_the_orbit_of_simulate():
    system = nv.load_system("ssul-set6")
    last = 20 * system.period
    histories = nv.response_history(system, load={"harmonic": True}, duration=last, quiet=True)
    end = nv.simulate(system, periods=20, quiet=True).state
    fall = histories[system.name]
    np.testing.assert_allclose([fall.x1[-1], fall.x2[-1]], end[[0, 2]], rtol=0, atol=1e-8)
    assert fall.numbers["balance"] < 1e-10


SAMPLES = {
    "times": (np.arange(81) * 0.05).tolist(),
    "values": np.random.default_rng(5).normal(0, 500, 81).tolist(),
    "unit": "N",
}


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["none", "tmd"])
@pytest.mark.parametrize(
    "load",
    [
        {"half_sine": {"peak": 2e4, "length": 0.2}},
        {"rectangular": {"peak": -1e4, "length": 0.1, "repeat": 3, "every": 1.0}},
        {"friedlander": {"peak": 1e5, "length": 0.05, "decay": 2.0, "suction": True}},
        {"sweep": {"amplitude": 800.0, "first": 5.0, "last": 8.0, "length": 10.0}},
        {"noise": {"rms": 500.0, "high": 15.0, "tones": 50, "seed": 4}},
        {"record": SAMPLES},
        {"record": {**SAMPLES, "interpolation": "cubic"}},
    ],
    ids=lambda load: next(iter(load)),
)
def test_a_linear_structure_under_loads_obeys_duhamel_s_integral(load, name):
    """x1 = integral of h(t - s) f(s) ds, by Gauss-Legendre between the kinks of the load."""
    histories = nv.response_history(name, load=load, **SHORT)
    fall, loading = histories[name], histories.request.load
    mass = nv.load_system(name).parameters["m1"]
    struck = [0.0, 1.0 / mass, 0.0, 0.0][: 2 if name == "none" else 4]
    (part,) = loading.parts
    nodes, weights = np.polynomial.legendre.leggauss(20)
    for i in (100, 401, 768):
        end = fall.time[i]
        edges = np.unique([*np.arange(0.0, end, 0.05), *part.kinks[part.kinks < end], end])
        half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
        s = (middle + half * nodes).ravel()
        force = part.rows(s, np.zeros(len(s)))[:, 0] * (half * weights).ravel()
        wanted = float(np.sum(free(name, end - s, *struck)[0] * force))
        assert fall.x1[i] == pytest.approx(wanted, abs=1e-11 * np.abs(fall.x1).max())
    assert fall.numbers["balance"] < 1e-13


@pytest.mark.kernels
def test_no_number_depends_on_how_many_states_are_asked_for():
    """Last times, too: E1 may exceed a level between two states, and no scan asks for states."""
    blow = {"impulse": 300.0, "half_sine": {"peak": 5e3, "length": 0.4, "repeat": 2, "every": 1.0}}
    document = {"systems": ["tmd", "ssul-set6"], "load": blow}
    scales = np.linspace(0.5, 3.0, 12).tolist()
    scan = nv.response_history({**document, **over(scale=scales)}, duration=30.0, quiet=True)
    for i, scale in enumerate(scales):
        for samples in (9, 64):
            tables = {"load": {"scale": scale}, "sampling": {"samples": samples}}
            one = nv.response_history(document, duration=30.0, quiet=True, **tables)
            for j, fall in enumerate(one.results.values()):
                for name in scan.numbers:
                    single = fall.numbers[name], scan[name][j, i]
                    np.testing.assert_array_equal(*single, err_msg=name)


@pytest.mark.kernels
def test_histories_of_any_number_of_states_are_of_one_orbit():
    """Of chaos, too, where two orbits that differ by round-off part within 100 s."""
    system = nv.load_system("ssul-set6", omega=7.4, K=2.5e7)
    document = {"systems": [system], "load": {"harmonic": True, "impulse": 300.0}}
    few, many = (
        nv.response_history(document, duration=400.0, sampling={"samples": count}, quiet=True)
        for count in (8, 64)
    )
    (few,), (many,) = few.results.values(), many.results.values()
    assert few.numbers == many.numbers
    for name in ("E1", "E2", "x1", "x2", "work"):
        one, other = getattr(few, name), getattr(many, name)[::8]
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max())
    assert 0.99 < many.E1.max() / many.numbers["E1max"] < 1.0 + 1e-9


@pytest.mark.kernels
def test_a_blow_that_brakes_counts_from_the_energy_before_it():
    none = nv.load_system("none")
    m1, period = none.parameters["m1"], none.natural_period
    blow = {"impulse": -0.4 * m1, "start": {"state": (0.0, 1.0)}, "duration": 40.0}
    fall = nv.response_history(none, **blow, quiet=True)["none"]
    assert fall.numbers["E1max"] == 0.5 * m1
    assert fall.numbers["last_50"] == 0.0
    ratio = math.log(10.0) / (4 * math.pi * fall.numbers["last_10"] / period)
    assert fall.numbers["damping_ratio"] == pytest.approx(ratio, rel=1e-14)


@pytest.mark.plain
@pytest.mark.kernels
def test_a_mass_without_a_spring_is_followed_for_one_cell_at_least():
    p = nv.load_system("bouncing-ball").parameters
    ball = nv.response_history("bouncing-ball", impulse=0.1 * p["m"], duration=0.15, quiet=True)
    height = ball["bouncing-ball"].numbers["x1_max"]
    assert height == pytest.approx(0.1**2 / (2.0 * p["g"]), rel=1e-12)


@pytest.mark.kernels
def test_threads_and_blocks_leave_all_bits_as_they_are():
    varied = over(impulse=(300.0, 1000.0), C=(0.02, 0.047, 0.1))
    sampling = {"duration": 12.0, "settle": 2.0}
    request = load_response_history("ssul-set6", {**BLOW, **varied, "sampling": sampling})
    use_threads(1)
    whole = arrays_of(request, range(6))
    use_threads(None)
    parts = [arrays_of(request, cases) for cases in (range(1), range(1, 4), range(4, 6))]
    for name, values in whole.items():
        assert values.tobytes() == np.concatenate([part[name] for part in parts]).tobytes(), name
    assert np.isfinite(whole["last_1"]).all()
    assert len(set(whole["impact_count"].tolist())) > 1


def density_of(request):
    """Return the two-sided spectral density S0 of the noise over its band."""
    (noise,) = request.load.noise
    return noise.rms**2 / (2.0 * (noise.high - noise.low))


def rms_of_tmd(mu, ratio, zeta, high=600.0):
    """Return the rms of x1, squared in units of pi S0 / (k1 m1 omega1), of an undamped structure.

    The band ends at a hundred natural frequencies: beyond it is 1e-6 of the variance.
    """
    m1, k1 = 1000.0, 36000.0
    m2, k2 = mu * m1, mu * ratio**2 * k1
    c2, unit = 2 * zeta * math.sqrt(k2 * m2), math.pi / (k1 * math.sqrt(k1 * m1))
    request = load_response_history("tmd", {
        "set": {"m1": m1, "k1": k1, "c1": 0.0, "m2": m2, "k2": k2, "c2": c2},
        "load": {"noise": {"rms": 1.0, "high": high, "tones": 30000}},
        "sampling": {"duration": 1.0},
    })  # fmt: skip
    system, load = request.case(0)
    unit *= density_of(request)
    return closed_form(system, load)["x1_rms"] / math.sqrt(unit)


@pytest.mark.parametrize("mu", [0.01, 0.05, 0.1])
def test_the_variance_of_a_tmd_is_least_where_warburton_found_it(mu):
    """White noise on an undamped structure: frequency, damping and variance in closed form.

    Source: G. B. Warburton, Optimum absorber parameters for various combinations of response and
    excitation parameters, Earthquake Engineering and Structural Dynamics 10 (1982) 381-401.
    """
    ratio = math.sqrt(1 + mu / 2) / (1 + mu)
    zeta = math.sqrt(mu * (1 + 0.75 * mu) / (4 * (1 + mu) * (1 + mu / 2)))
    best = rms_of_tmd(mu, ratio, zeta)
    assert best**2 == pytest.approx(2 * math.sqrt((1 + 0.75 * mu) / (mu * (1 + mu))), rel=1e-4)
    for factors in ((1.02, 1.0), (0.98, 1.0), (1.0, 1.1), (1.0, 0.9)):
        assert rms_of_tmd(mu, ratio * factors[0], zeta * factors[1]) > best


@pytest.mark.kernels
@pytest.mark.parametrize("name", ["none", "tmd"])
def test_the_variance_under_noise_is_that_of_its_density(name):
    """Its mean over twenty seeds; of the structure alone it is pi S0 / (k c)."""
    system, high, seeds = nv.load_system(name), 30.0, 20
    request = load_response_history(name, {
        "load": {"noise": {"rms": 200.0, "high": high, "tones": 3000}},
        "sampling": {"duration": 600.0, "settle": 40.0, "samples": 16},
        **over(**{"noise.seed": range(1, seeds + 1)}),
    })  # fmt: skip
    arrays, density = arrays_of(request, range(seeds)), density_of(request)
    size = len(system.scene.components)
    A, b = flow_matrix(system)[:size, :size], np.eye(size)[1] / system.parameters["m1"]

    def square(omega):
        """Return |H|^2, H the first row of (i omega - A)^(-1) b."""
        return abs(np.linalg.solve(1j * omega * np.eye(size) - A, b)[0]) ** 2

    pieces = np.linspace(0.0, high, 60)
    band = 2 * density * sum(quad(square, *two, epsrel=1e-10)[0] for two in pairwise(pieces))
    if name == "none":  # on the whole axis, of white noise
        p = system.parameters
        assert band == pytest.approx(math.pi * density / (p["k1"] * p["c1"]), rel=0.02)
    squares = arrays["x1_rms"] ** 2
    assert abs(squares.mean() - band) < 3 * squares.std(ddof=1) / math.sqrt(seeds)


@pytest.mark.kernels
@pytest.mark.parametrize("impulse", [500.0, 1000.0])
def test_last_times_within_long_contacts_do_not_depend_on_the_edges(impulse):
    """A cell with a contact is looked at three times; two leave 1e-10 s of its width."""
    system = nv.load_system("ssul-set6", K=1e4, C=0.005)
    blow = {"impulse": impulse, "duration": 3.0, "quiet": True}
    histories = [nv.response_history(system, sampling={"samples": n}, **blow) for n in (16, 23)]
    one, other = (history[system.name].numbers["last_50"] for history in histories)
    assert one == pytest.approx(other, abs=2e-11)


def test_loads_of_the_command_line(here, answer, refusal):
    (here / "q.csv").write_text("t [s], a [g]\n0, 0\n0.05, 1\n0.1, 0\n")
    plan = answer("response-history", "--load", "q.csv", "--dry-run")
    assert "record q.csv, 3 samples, step 0.05 s, 0.1 s, peak 1 g at 0.05 s" in plan
    (here / "1,2.txt").write_text("0\n1\n0\n")
    for path in ("./1,2.txt", str(here / "1,2.txt"), "1,2.txt"):
        keys = f"record:file={path},dt=0.05,unit=m/s2,column=1"
        plan = answer("response-history", "--load", keys, "--dry-run")
        assert "record 1,2.txt, 3 samples, step 0.05 s, 0.1 s, peak 1 m/s^2 at 0.05 s" in plan
    plan = answer("tuning", "--system", "tmd", "--load", "q.csv", "--duration", "0.05", "--dry-run")
    assert "record q.csv, 3 samples" in plan
    assert "0.1 s, of which 0.05 s are computed" in plan
    line = "response-history --dry-run --load half_sine:peak=3,length=0.5,repeat=2,every=1"
    printed = answer(*line.split(), "--load", "noise:rms=1,high=9")
    assert "half sine (peak 3, length 0.5, every 1) + noise (rms 1" in printed
    for text, word in (("half_sin:peak=3", "half_sine"), ("noise:rms", "KEY=VALUE"),
                       ("noise:rms=x,high=1", "'x'"), ("none.csv", "none.csv")):  # fmt: skip
        assert word in refusal("response-history", "--load", text, "--dry-run")
    words = refusal(*["tuning", "--impulse", "1", "--set", "scale=2", "--dry-run"])
    assert "scale belongs in [load]" in words
    assert "--over" in words


def test_a_report_says_its_frame_its_records_and_until_when(here, answer, monkeypatch):
    monkeypatch.setattr(run, "arrays_of", made_up)
    (here / "q.csv").write_text("t [s], a [g]\n3, 0\n3.05, 1\n3.1, 0\n")
    text = answer(*["response-history", "--system", "tmd", "--load", "q.csv", "-o", "quake.h5"])
    assert "record q.csv, 3 samples" in text
    assert "moved from 3 s to 0 s" in text
    assert "x1 relative to the ground up to 1 m; E1 above 50% until 1 s, 10% until 1 s" in text
    with h5py.File("quake.h5") as archive:
        words = {name: archive[name].attrs["long_name"] for name in archive}
    assert "absolute" in words["a1_max"]
    for name in ("x1_max", "v1_max", "E1max", "x1", "x2", "E1", "E2"):
        assert "relative to the" in words[name], name


def test_dampers_are_compared_in_a_table(here, monkeypatch):
    nan = math.nan
    names = "x1_max", "a1_max", "shear_max", "stroke_max", "force_max", "impulse_max"
    values = {
        "none": (0.2, 5.0, 900.0, nan, nan, nan), "tmd": (0.1, 6.0, 450.0, 0.3, nan, nan),
        "ssul-set6": (0.05, 20.0, 225.0, 0.3, 4e3, nan),
    }  # fmt: skip

    def computed(request, cases, *others):
        peaks = values[request.case(cases[0])[0].name]
        arrays = {name: np.array([peak]) for name, peak in zip(names, peaks, strict=True)}
        return {**made_up(request, cases, *others), **arrays}

    monkeypatch.setattr(run, "arrays_of", computed)
    nv.response_history([*values], impulse=9.0, duration=3.0, to="r.h5", quiet=True)
    histories = nv.open_archive("r.h5")
    rows = [*histories.lines()][-6:]
    assert [" ".join(row.split()) for row in rows] == [
        "none tmd ssul-set6",
        "x1_max [m] 0.2 0.1 (-50.0%) 0.05 (-75.0%)",
        "a1_max [m/s^2] 5 6 (+20.0%) 20 (+300.0%)",
        "stroke_max [m] - 0.3 0.3",
        "force_max [N] - - 4000",
        "shear_max [N] 900 450 (-50.0%) 225 (-75.0%)",
    ]
    assert len({len(row) for row in rows}) == 1
    histories.to_csv("table.csv")
    rows = (here / "table.csv").read_text().splitlines()
    assert rows[:3] == ["system,quantity,value,unit,reduction", "none,x1_max,0.2,m,nan",
                        "tmd,x1_max,0.1,m,0.5"]  # fmt: skip
    assert len(rows) == 1 + 3 * 3 + 2 + 1
    (axes,) = histories.plot("peaks").axes
    assert [bar.get_width() for bar in axes.patches[:3]] == pytest.approx([1.0, 0.5, 0.25])
    texts = " ".join(text.get_text() for text in axes.texts)
    assert " 0.05 m " in texts
    assert " 20 m/s" in texts


def test_a_table_of_dampers_with_restitution_has_impulses_and_says_what_is_missing(
    here, monkeypatch
):
    def computed(request, cases, stop, tell=None):
        arrays, missing = made_up(request, cases, stop), ("impulse_max",)
        if request.case(cases[0])[0].scene.walls:
            missing = ("a1_max", "force_max")
        return {**arrays, **{name: np.array([math.nan]) for name in missing}}

    monkeypatch.setattr(run, "arrays_of", computed)
    rigid = nv.load_system("ssul-set6", law="restitution", e=0.7)
    histories = nv.response_history(["none", rigid], impulse=9.0, duration=3.0, quiet=True)
    *_, note = histories.lines()
    rows = {row[0]: row[1:] for row in histories.rows()}
    assert rows["impulse_max [N s]"] == ["-", "1"]
    assert [row[1] for row in rows.values()].count("-") == 1
    assert note.startswith("-: under law restitution")
    assert "a1_max" in note
    assert "linear or hertz" in note
    histories.to_csv("table.csv")
    assert "ssul-set6,impulse_max,1.0,N s,nan" in (here / "table.csv").read_text()
    soft = nv.response_history(["none", "ssul-set6"], impulse=9.0, duration=3.0, quiet=True)
    assert not [*soft.lines()][-1].startswith("-:")


@pytest.mark.parametrize("page", [ONE_COLUMN, TWO_COLUMNS])
@pytest.mark.parametrize("shown", ["energy,shares", "motion,damper,peaks"])
def test_a_legend_is_no_wider_than_the_panel_that_names_beside_bars_leave(page, shown, monkeypatch):
    monkeypatch.setattr(run, "arrays_of", made_up)
    titles = ["Structure", "With a TMD of 5 %", "Damper, design A", "Damper, design B", "Design C"]
    systems = [replace(nv.load_system("tmd"), name=t, title=t) for t in titles]
    histories = nv.response_history(systems, impulse=9.0, duration=3.0, quiet=True)
    with histories.path.read() as view:
        figure = draw(view, shown.split(","), page)
    for axes in figure.axes:
        if legend := axes.get_legend():
            assert legend.get_window_extent().x1 <= axes.bbox.x1 + 1.0, axes.get_label()
    assert figure.axes[0].bbox.width > 0.6 * figure.bbox.width


@pytest.mark.parametrize("letters", [9, 11])
def test_a_legend_wraps_by_the_width_of_its_hinted_letters(monkeypatch, letters):
    monkeypatch.setattr(run, "arrays_of", made_up)
    systems = [replace(nv.load_system("tmd"), name=a, title=letters * a) for a in "aeoun"]
    histories = nv.response_history(systems, impulse=9.0, duration=3.0, quiet=True)
    figure = histories.plot("motion,damper,peaks")
    figure.draw_without_rendering()
    legend = figure.axes[0].get_legend()
    assert len(legend.get_texts()) == 5
    assert legend.get_window_extent().x1 <= figure.axes[0].bbox.x1
    assert figure.axes[0].get_position().width > 0.75
    tops = {round(text.get_window_extent().y0) for text in legend.get_texts()}
    assert len(tops) == (1 if letters == 9 else 2)


def test_what_does_not_move_is_said_to_be_at_rest(monkeypatch):
    """Its energy is above no share of 0, and nothing dissipates any."""

    def at_rest(*arguments):
        arrays = made_up(*arguments)
        arrays[OF_LOADS[0].name][0] = np.nan
        return {**arrays, "E1max": 0.0 * arrays["E1max"]}

    monkeypatch.setattr(run, "arrays_of", at_rest)
    still = nv.response_history("none", impulse=1.0, duration=5.0, quiet=True)
    assert [*still.lines()][-1] == "Primary structure alone: at rest for 5 s"
    scan = nv.response_history("none", impulse=1.0, vary={"k1": {"values": [1e4, 2e4]}}, quiet=True)
    assert [*scan.lines()][-1].endswith("from 1 to 1 in 1 of 2 orbits")


@pytest.mark.plain
@pytest.mark.kernels
def test_the_ground_accelerates_structure_and_damper():
    """z' = A z - a (0, 1, 0, 1) in coordinates from the ground: z = (exp(A t) - 1) A^-1 b."""
    load = {"rectangular": {"peak": 0.1, "length": 20.0, "unit": "g"}}
    fall = nv.response_history("tmd", load=load, **SHORT)["tmd"]
    rest = np.linalg.solve(matrix("tmd"), -0.980665 * np.array([0.0, 1.0, 0.0, 1.0]))
    z = free("tmd", fall.time, *rest) - rest[:, None]
    for computed, exact in ((fall.x1, z[0]), (fall.x2, z[2])):
        np.testing.assert_allclose(computed, exact, rtol=0, atol=1e-11 * np.abs(exact).max())
    assert fall.numbers["balance"] < 1e-12


def test_a_sweep_stands_beside_its_closed_form(here, answer, refusal, monkeypatch):
    monkeypatch.setattr(run, "arrays_of", made_up)
    load = "--load sweep:amplitude=800,first=5,last=8,length=30"
    answer(*f"response-history --system none {load} --duration 30 --quiet -o sweep.h5".split())
    p = nv.load_system("none").parameters
    for name in ("sweep", "sweep_energy"):
        (axes,) = nv.plot("sweep.h5", name).axes
        (steady,) = (line for line in axes.get_lines() if "closed form" in str(line.get_label()))
        omega = steady.get_xdata()
        size = 800.0 / np.abs(p["k1"] - p["m1"] * omega**2 + 1j * omega * p["c1"])
        largest = 0.5 * np.maximum(p["k1"], p["m1"] * omega**2) * size**2
        np.testing.assert_allclose(steady.get_ydata(), size if name == "sweep" else largest)
    assert "sweep.h5" in refusal("plot", "sweep.h5", "--mark", "sweep.h5")


def test_each_case_has_the_parameters_and_the_load_of_its_row():
    request = load_response_history(table(**COLUMNS))
    assert (request.shape, request.cases) == ((2,), 4)
    for number in range(4):
        system, load = request.case(number)
        row = number % 2
        assert system.parameters["k1"] == COLUMNS["k1"][row]
        assert system.ratios["zeta1"] == pytest.approx(COLUMNS["zeta1"][row])
        assert load.impulse == COLUMNS["impulse"][row]
    again = load_response_history(request.document())
    assert (again.hash, again.sampled) == (request.hash, request.sampled)
    other = table(**{**COLUMNS, "impulse": [200.0, 401.0]})
    assert request.hash != load_response_history(other).hash


@pytest.mark.kernels
def test_a_table_gives_the_peaks_of_single_histories():
    scan = nv.response_history(["none", "tmd"], samples=COLUMNS, duration=3.0, quiet=True)
    for row in range(2):
        values = {name: column[row] for name, column in COLUMNS.items() if name != "impulse"}
        systems = [nv.load_system(name, **values) for name in ("none", "tmd")]
        blow = {"impulse": COLUMNS["impulse"][row], "duration": 3.0}
        alone = nv.response_history(systems, **blow, quiet=True)
        peaks = [one.numbers["E1max"] for one in alone.results.values()]
        assert scan["E1max"][:, row].tolist() == pytest.approx(peaks, rel=1e-12)
    with scan.path.read() as view:
        assert view.dims("E1max") == ("system", "sample")
        assert view["system"].tolist() == ["none", "tmd"]
        assert view["impulse"].tolist() == COLUMNS["impulse"]
    above, counted = scan.plot("E1max:exceedance,E1max").axes
    assert [axes.get_label() for axes in scan.plot().axes] == ["last_50:exceedance", "last_50"]
    assert np.array_equal(above.lines[0].get_ydata(), [1.0, 0.5])
    assert [stairs.get_data().values.sum() for stairs in counted.patches] == [1.0, 1.0]
    (axes,) = scan.plot("E1max:k1").axes
    for line, values in zip(axes.lines, scan["E1max"], strict=True):
        np.testing.assert_array_equal(line.get_xydata().T, [COLUMNS["k1"], values])


def test_two_systems_without_titles_are_told_by_their_files(here, monkeypatch):
    monkeypatch.setattr(run, "arrays_of", made_up)
    parameters = nv.load_system("tmd").parameters
    for name in ("soft", "stiff"):
        values = "\n".join(f"{key} = {value}" for key, value in parameters.items())
        (here / f"{name}.toml").write_text(
            f'[system]\nkind = "tmd"\n[system.parameters]\n{values}\n'
        )
    histories = nv.response_history(["soft.toml", "stiff.toml"], impulse=9.0, quiet=True)
    of_systems = [line for line in [*histories.lines()][1:] if ": x1 up to" in line]
    words = [line.partition(":")[0] for line in of_systems]
    assert [one.rpartition(" ")[2] for one in words] == ["(soft.toml)", "(stiff.toml)"]
    legend = histories.plot("energy").axes[0].get_legend().get_texts()
    assert [text.get_text() for text in legend][:2] == words
