"""`classify`: one verdict whatever the lengths and the effort; rows of evidence and their words."""

import itertools

import numpy as np
import pytest

from nlds_vines import classify, load_system, simulate
from nlds_vines.engine.batch import evidence_arrays, layout_of
from nlds_vines.engine.solver_settings import EFFORTS
from nlds_vines.engine.starts import user_states
from nlds_vines.kernels.cells import verdict
from nlds_vines.kernels.scene import codes
from nlds_vines.kernels.scene.codes import DIVERGED, OK
from nlds_vines.model.labels import FLAGS, flags_of, label_of, labels_of
from nlds_vines.model.labels import PERIODIC as PERIODIC_LABEL
from nlds_vines.model.presets import CELL
from nlds_vines.model.scenes import SCENES
from scans import computed, scan_of

NOTED = 4096  # periods of a transient whose section is kept


def seen(regime):
    """Return the properties of a regime that the length of the run must not change."""
    return regime.label, regime.settling, regime.impacts_by_wall


@pytest.mark.kernels
def test_a_transient_longer_than_what_is_kept_changes_nothing():
    system = load_system("ssul-set6", omega=6.28)
    expected = seen(classify(system))
    for transient in (NOTED, NOTED + 1, 6000, 10_000):
        regime = classify(system, transient=transient)
        assert seen(regime) == expected
        assert regime.watched == transient + 120


@pytest.fixture(scope="module")
def passing():
    """Return three orbits above 7.53 rad/s that settle after transient chaos."""
    systems = (load_system("ssul-set6", omega=omega) for omega in np.linspace(7.53, 7.6, 29))
    regimes = [classify(system) for system in systems]
    chosen = [r for r in regimes if r.label == "transient chaos to T,0" and r.settling < 500]
    assert len(chosen) >= 3
    return chosen[:3]


def test_a_chaotic_transient_ends_where_the_section_begins_to_obey_however_long_ago(passing):
    for regime in passing:
        long = classify(regime.system, transient=6000)
        assert seen(regime) == seen(long)
        assert regime.settling > 50
        assert f"; transient {regime.transient_lyapunov:.2g} +- " in repr(regime)
        assert regime.transient_lyapunov == long.transient_lyapunov
        assert regime.transient_lyapunov_width == long.transient_lyapunov_width
        orbit = simulate(regime.system, periods=700)
        before, after = orbit.section[: regime.settling - 1], orbit.section[regime.settling :]
        assert np.abs(after[90:] - after[-1]).max() < 1e-6
        assert np.abs(before[-40:] - after[-1]).max() > 1e-3
        # what strikes later is too soft to bend a return
        touched, speed = orbit.impacts["touch"] / regime.system.period, orbit.impacts["speed"]
        hard = touched[speed > 0.25 * np.median(speed)]
        assert regime.settling - 60 < hard.max() <= regime.settling + 1
        assert touched.max() <= regime.settling + 4


@pytest.mark.parametrize(
    ("effort", "watched", "label", "lifetime"),
    [("quick", 700, "undetermined", np.nan), ("standard", 3700, "chaos", 3700 / np.log(20))],
)
def test_chaos_is_watched_for_as_long_as_the_effort_allows(effort, watched, label, lifetime):
    regime = classify("ssul-set6", omega=7.4, K=2.5e7, effort=effort, periods=100)
    assert (regime.label, regime.watched, regime.settling) == (label, watched, -1)
    assert regime.least_lifetime == pytest.approx(lifetime, nan_ok=True)


@pytest.mark.kernels
def test_a_quick_scan_knows_how_long_it_watched():
    vary, sampling = {"omega": [6.28, 7.4]}, {"transient": 300, "periods": 60, "effort": "quick"}
    want, changes = ["energy", "regime", "evidence"], {"K": 2.5e7}
    arrays = computed(scan_of("ssul-set6", want, vary, changes=changes, **sampling))
    assert arrays["watched"].ravel().tolist() == [360, 360]
    assert list(arrays["label"].ravel()) == ["T,1", "undetermined"]


LONG_PERIODS = [
    ("ssul-set6", 7.407055276381909, "114T,76"),
    ("ssul-set6", 7.408261306532663, "57T,38"),
    ("ssul-set6", 7.409400110773633, "162T,108"),
    ("ssbl", 6.230804020100503, "52T,94"),
    ("ssbl", 6.219723241629813, "60T,109"),
]
"""Stable orbits of long periods: system, omega, label."""


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("name", "omega", "label"),
    [*LONG_PERIODS[:3], *(pytest.param(*one, marks=pytest.mark.long) for one in LONG_PERIODS[3:])],
)
def test_a_long_period_is_found_whatever_the_window(name, omega, label):
    system = load_system(name, omega=omega)
    regimes = [classify(system, periods=periods) for periods in (60, 120, 2000)]
    assert [r.label for r in regimes] == [label] * 3
    assert len({r.settling for r in regimes}) == 1
    for r in regimes:
        assert r.residual < 1e-9
        assert abs(r.multipliers[0]) < 0.6
    # it closes, run without any verdict
    closed = simulate(system, periods=regimes[0].period, start=regimes[0].point)
    np.testing.assert_allclose(closed.section[-1], regimes[0].point, atol=1e-8)


@pytest.mark.parametrize("periods", [60, 120, 2000])
def test_a_torus_beside_the_published_3t_3(periods):
    regime = classify(load_system("ssul-set6", omega=7.375), periods=periods)
    assert regime.label == "quasiperiodic"
    assert abs(regime.lyapunov) <= regime.lyapunov_width
    assert regime.averaging >= 7.0


LIGHT = {"m2": 1e-5, "k2": 1e-4, "c2": 1e-6, "C": 1e7, "omega": 4.1}
"""A damper that weighs nothing and meets no obstacle: the structure alone is damped by c1."""


@pytest.mark.parametrize(
    ("changes", "x1", "label"),
    [
        ({"C": 10.0, "c1": 0.0, "c2": 0.0}, 0.0, "quasiperiodic"),  # nothing ever decays
        ({"C": 10.0, "c1": 1e-4, "c2": 1e-5}, 0.0, "undetermined"),
        ({**LIGHT, "c1": 1e-3}, 0.0, "undetermined"),
        ({**LIGHT, "c1": 2.0}, 1e5, "undetermined"),  # decays by e^-3.6, from 10^6 times the orbit
        ({**LIGHT, "c1": 20.0}, 0.0, "T,0"),
    ],
)
def test_a_free_oscillation_that_has_not_decayed_is_no_torus(changes, x1, label):
    system = load_system("ssul-set6", **{"omega": 4.1, **changes})
    regime = classify(system, start=(x1, 0.0, x1, 0.0) if x1 else None)
    assert (regime.label, regime.impacts) == (label, 0 if regime.period else -1)
    assert regime.impact_rate == 0.0


def test_chaos_without_damping_is_not_stationary():
    """Its energy diffuses: the exponent of a window is not that of later ones."""
    system = load_system("ssul-set6", c1=0.0, c2=0.0)
    early = classify(system)
    assert early.label == "chaos"
    assert early.lyapunov - early.lyapunov_width > 0.0
    squares = simulate(system, 30_000).section[:, 0] ** 2
    assert squares[-6000:].mean() > 4.0 * squares[:6000].mean()
    damped = simulate(load_system("ssul-set6", omega=7.4, K=2.5e7), 30_000).section[:, 0] ** 2
    assert damped[-6000:].mean() == pytest.approx(damped[6000:12000].mean(), rel=0.05)


def test_a_flight_without_impact_is_not_yet_a_periodic_orbit():
    """Some orbits fly all of period 360; T,0 predicts the next section from anywhere."""
    flying = []
    for omega in np.linspace(7.61, 7.64, 61):
        system = load_system("ssul-set6", omega=omega, P=878.0)
        orbit = simulate(system, periods=420)
        touched = orbit.impacts["touch"] / system.period
        if not np.any((touched > 360) & (touched < 361)) and touched.max() > 361:
            flying.append(system)
    assert len(flying) >= 5
    for system in flying[:5]:
        cut = classify(system, transient=300, periods=60, effort="thorough")
        whole = classify(system, transient=6000, effort="thorough")
        assert cut.label == whole.label == "transient chaos to T,0"
        assert cut.settling == whole.settling > 360


@pytest.mark.kernels
@pytest.mark.parametrize("method", ["exact", pytest.param("rk4", marks=pytest.mark.long)])
def test_what_is_recorded_changes_no_orbit(method):
    """Chaos shows it: a difference in the last bit grows to the size of the attractor."""

    def section(*want):
        sampling = {"transient": 1000, "periods": 500, "method": method}
        vary, constants = {"omega": [7.4]}, {"K": 2.5e7}
        scan = scan_of("ssul-set6", ["section", *want], vary, changes=constants, **sampling)
        return computed(scan)["section"]

    alone = section()
    for also in (["energy", "regime"], ["peak", "clearance", "impacts"]):
        np.testing.assert_array_equal(section(*also), alone)


def test_a_regime_says_in_a_few_lines_what_it_is():
    lines = str(classify("ssul-set6", omega=5.5)).splitlines()
    assert lines[0] == "Regime: T,1 (periodic)"
    assert lines[2].startswith("  orbit: 1 impact per T; obeys its multipliers from period ")
    numbers = [line.split(":")[0] for line in lines[3:]]
    assert numbers == ["  Floquet multipliers", "  Lyapunov exponents [1/s]"]
    chaotic = classify("ssul-set6", omega=7.42)
    assert "not periodic; not settled in 3720 forcing periods" in str(chaotic)
    # impacts per nT have no number without n; their rate has
    assert (chaotic.impacts, {*chaotic.impacts_by_wall.values()}) == (-1, {-1})
    orbit = simulate(load_system("ssul-set6", omega=7.42), 120, transient=600)
    assert chaotic.impact_rate == len(orbit.impacts) / 120 > 0.5


OMEGA, REST, N = 6.28, 0.3, 2
T = 2 * np.pi / OMEGA
DIAGONAL = [-0.1, 0.8, 0.2, -0.4]


PERIODIC = {
    codes.KIND: FLAGS["periodic"],
    codes.CYCLE_PERIOD: N,
    codes.NEAR_IMPACTS: 3,
    codes.FAR_IMPACTS: 1,
    codes.SETTLING: 17,
    codes.MONODROMY: np.diag(DIAGONAL).ravel(),
    codes.POINT: [0.01, 0.2, 0.05, -0.6],
}
CHAOTIC = {codes.KIND: FLAGS["chaotic"], codes.EXPONENTS: [0.3, 0.0, -0.7, -1.0]}


def test_rows_of_evidence_become_labels_multipliers_exponents_and_points():
    """Of a 2T,4 orbit, of chaos, and of a lane that failed."""
    rows = np.full((3, 1, codes.LENGTH_OF_ROW), np.nan)
    rows[..., [codes.KIND, codes.CYCLE_PERIOD, codes.SETTLING]] = 0.0, 0.0, -1.0
    for row, values in zip(rows[:, 0], (PERIODIC, CHAOTIC, PERIODIC), strict=True):
        for place, value in values.items():
            row[place : place + np.size(value)] = value
    cells = np.zeros((3, 1), CELL)
    cells["rest"] = REST
    status = np.array([[OK], [OK], [DIVERGED]])
    arrays = evidence_arrays(status, rows, np.full((3, 1), OMEGA), layout_of(4))
    arrays["orbit_point"] = user_states(cells, arrays["orbit_point"], SCENES["ssul"])
    judged = {name: values[:, 0] for name, values in arrays.items()}
    # impacts are those of a cycle: without a period there is no count
    assert judged["label"].tolist() == ["2T,4", "chaos", "failed"]
    assert judged["impacts_by_wall"].tolist() == [[3, 1], [-1, -1], [-1, -1]]
    assert judged["impact_count"].tolist() == [4, -1, -1]
    assert judged["regime"].tolist() == [FLAGS[n] for n in ("periodic", "chaotic", "failed")]
    assert judged["settling"].tolist() == [17, -1, -1]
    # multipliers come by their moduli
    np.testing.assert_allclose(judged["multipliers"][0, :, 0], [0.8, -0.4, 0.2, -0.1])
    np.testing.assert_array_equal(judged["multipliers"][0, :, 1], 0.0)
    assert np.isnan(judged["multipliers"][1:]).all()
    # exponents of a cycle are those of its multipliers
    expected = np.log([0.8, 0.4, 0.2, 0.1]) / (N * T)
    np.testing.assert_allclose(judged["exponents"][0], expected)
    np.testing.assert_array_equal(judged["exponents"][1], [0.3, 0.0, -0.7, -1.0])
    # points are in the user's coordinates
    np.testing.assert_allclose(judged["orbit_point"][0], [0.01, 0.2, 0.01 - 0.05 + REST, 0.8])
    assert np.isnan(judged["orbit_point"][1]).all()
    # a lane that failed keeps no evidence
    assert judged["periodicity"][2] == 0
    for name in ("exponents", "multipliers", "orbit_point", "lyapunov", "residual"):
        assert np.isnan(judged[name][2]).all(), name


def test_codes_are_those_of_the_archive_and_labels_the_papers_words():
    kinds = ("undetermined", "periodic", "quasiperiodic", "chaotic", "transient_chaos", "failed")
    assert [FLAGS[kind] for kind in kinds] == [0, 1, 2, 3, 4, 5]
    assert [getattr(codes, kind.upper()) for kind in kinds] == [0, 1, 2, 3, 4, 5]
    rows = [
        ("periodic", 1, 1, "T,1"),
        ("periodic", 3, 2, "3T,2"),
        ("transient_chaos", 1, 0, "transient chaos to T,0"),
        ("chaotic", 0, 80, "chaos"),
        ("undetermined", 0, 80, "undetermined"),
        ("failed", 0, 0, "failed"),
    ]
    regime, period, impacts, expected = map(list, zip(*rows, strict=True))
    regime = [FLAGS[name] for name in regime]
    assert labels_of(*map(np.array, (regime, period, impacts))).tolist() == expected
    assert [label_of(*one) for one in zip(regime, period, impacts, strict=True)] == expected
    # of a host with two dampers: (period, impacts of each, label)
    shared = [(2, 2, 1, "2T,3 (2+1)"), (1, 0, 0, "T,0"), (1, 0, 1, "T,1 (0+1)")]
    period, a, b, expected = map(list, zip(*shared, strict=True))
    a, b = np.array(a), np.array(b)
    regime = np.full(len(shared), FLAGS["periodic"])
    assert labels_of(regime, np.array(period), a + b, a, b).tolist() == expected
    assert all(PERIODIC_LABEL.fullmatch(label) for label in expected)
    kinds = np.array([1, 3, 1])
    assert flags_of(np.array([OK, OK, DIVERGED]), kinds).tolist() == [1, 3, FLAGS["failed"]]


def test_a_torus_forgets_its_start_and_a_pair_of_zero_exponents_does_not():
    def forgets(trace, *exponents):
        plain = getattr(verdict.forgets, "py_func", verdict.forgets)  # which compiles nothing
        return plain(len(exponents), trace, np.array(exponents), 1.0, 600.0)

    assert forgets(-1.35, 1e-3, -0.02, -0.6, -0.731)  # an attracting torus
    assert not forgets(-1.0, 2e-3, -2e-3, -0.5, -0.5)  # a pair: a free oscillation
    assert not forgets(-1e-7, 2e-3, -2.0001e-3)
    assert forgets(-0.02, -0.01, -0.01)  # which has had the time to decay
    assert forgets(0.0, 2e-3, -2e-3)  # nothing dissipates
    assert not forgets(0.0, 2e-3, -2.1e-3)  # impacts do
    assert forgets(0.0, 0.0, -0.1)


def test_efforts_only_add_stages_and_a_wrong_request_is_refused(error_of):
    for less, longer in itertools.pairwise(EFFORTS.values()):
        assert longer[: len(less)] == less
    assert "unknown effort 'huge'" in error_of(classify, "ssul-set6", effort="huge")
    assert "periods = 0" in error_of(classify, "ssul-set6", periods=0)
    assert "start" in error_of(classify, "ssul-set6", start=(0.0, 0.0))
