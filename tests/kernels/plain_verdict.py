"""What a label rests on, one question at a time: minimal, attracted, stable, counted."""

import math

import numpy as np
import pytest
from flights import flow_on
from support import kernel_state, linear_flow

import nlds_vines as nv
from nlds_vines.kernels.cells import verdict
from nlds_vines.kernels.cells.verdict import attracted, cycle_through, follow_growth, note_exponents
from nlds_vines.kernels.numerics.matrices import eigenvalues, is_saddle
from nlds_vines.kernels.orbit import variations
from nlds_vines.kernels.orbit.repetition import impacts_of
from nlds_vines.kernels.scene.codes import EXPONENTS, INTERVAL, LENGTH_OF_ROW, LYAPUNOV, OK
from nlds_vines.model.system import System
from paper.linear import steady_state
from scans import computed, scan_of


def closed(name, omega, n, start=None):
    """Return flow, point, sections, impacts by wall, matrix, residual of n periods that close."""
    system = nv.load_system(name, omega=omega)
    orbit = nv.simulate(system, 1, transient=300, start=start)
    flow = flow_on(system)
    y = kernel_state(system, orbit.state)
    points, counts, tangent = np.empty((n, 4)), np.zeros(2, np.int64), np.zeros(16)
    residual, clearance, slowest = variations.polish(flow, y, points, counts, tangent)
    return flow, y, points, counts, tangent, (residual, clearance, slowest)


@pytest.mark.parametrize(("omega", "n", "impacts"), [(6.28, 1, 1), (7.8, 2, 1), (7.45, 3, 2)])
def test_only_the_least_number_of_periods_is_minimal(omega, n, impacts):
    for times in (1, 2):
        flow, y, points, counts, _, (residual, _, slowest) = closed("ssul-set6", omega, times * n)
        assert residual < 1e-12
        assert variations.is_minimal(flow.space, y, points) == (times == 1)
        assert tuple(counts) == (times * impacts, 0)
        system = nv.load_system("ssul-set6", omega=omega)
        start = [y[0], y[1], y[0] - y[2] + system.rest, y[1] - y[3]]
        rows = nv.simulate(system, times * n, start=start, record=("impacts",)).impacts
        assert slowest == pytest.approx(rows["speed"].min(), rel=1e-9)


def test_orbits_are_minimal_and_closed_until_rounding_stops_newtons_method():
    """Sections that differ by more than round-off are different points."""
    flow, y, points, *_ = closed("ssul-set6", 6.28, 2)
    for far, minimal in ((1e-12, False), (1e-5, True)):
        moved = points.copy()
        moved[0] += far * points[0]
        assert variations.is_minimal(flow.space, y, moved) == minimal
    # from a point a hundredth beside the orbit
    flow, y, points, counts, tangent, _ = closed("ssul-set6", 6.28, 1)
    moved = y * 1.01
    residual, *_ = variations.polish(flow, moved, points, counts, tangent)
    assert residual < 1e-12
    np.testing.assert_allclose(moved, y, rtol=1e-9)


def test_an_orbit_that_is_drawn_in_slowly_is_attracted():
    """Its returns are not yet at the point of the orbit, but where the matrix maps them."""
    system = nv.load_system("none", c1=2.0)
    flow, y = flow_on(system), np.zeros(4)
    y[:2] = steady_state(system)
    points, counts, tangent = np.empty((1, 4)), np.zeros(2, np.int64), np.zeros(16)
    variations.polish(flow, y, points, counts, tangent)
    assert attracted(flow, cycle_through(flow.space, y, tangent, points), y * 1.2)


def test_an_orbit_that_goes_elsewhere_is_not_attracted():
    """At 7.85 rad/s an orbit of 2T,1 and one without impacts coexist: neither draws the other's."""
    system = nv.load_system("ssul-set6", omega=7.85)
    still = nv.classify(nv.load_system("ssul-set6", omega=7.95)).point
    flow, struck, points, _, tangent, _ = closed("ssul-set6", 7.85, 2)
    _, silent, free, _, free_tangent, _ = closed("ssul-set6", 7.85, 2, start=still)
    assert nv.simulate(system, 20, transient=100, start=still).impacts.size == 0
    of_impacts = cycle_through(flow.space, struck, tangent, points)
    of_flights = cycle_through(flow.space, silent, free_tangent, free)
    assert attracted(flow, of_impacts, struck + 1e-4 * struck)
    assert attracted(flow, of_flights, silent + 1e-4 * silent)
    assert not attracted(flow, of_impacts, silent)
    assert not attracted(flow, of_flights, struck)


@pytest.mark.parametrize(
    ("c1", "label"), [(450.0, "T,0"), (20.0, "T,0"), (2.0, "T,0"), (0.01, "T,0"), (1e-4, None)]
)
def test_a_weakly_damped_structure_is_periodic_as_long_as_its_multiplier_says_so(c1, label):
    """|mu| = exp(-c1 T / 2 m1): from 0.8 to 1 - 5e-6; nearer to one, rounding could decide."""
    system = nv.load_system("none", c1=c1)
    start = steady_state(system)  # a transient would last for 1e5 periods
    regime = nv.classify(system, start=start, transient=0, periods=30, effort="quick")
    radius = math.exp(-c1 * system.period / (2 * system.parameters["m1"]))
    if label is None:
        assert regime.kind != "periodic"
        return
    assert regime.label == label
    assert abs(regime.multipliers[0]) == pytest.approx(radius, rel=1e-9)
    assert regime.lyapunov == pytest.approx(math.log(radius) / system.period, rel=1e-5)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 25])
def test_impacts_are_counted_over_whole_cycles(n):
    """An impact at the very instant of a section falls now before it and now after."""
    cycle = np.zeros((n, 2), np.int64)
    cycle[-1], cycle[0, 1] = (2, 1), 3
    rows = np.tile(cycle, (60 // n + 1, 1))[-60:]
    assert impacts_of(rows, 0, n) == 2
    assert impacts_of(rows, 1, n) == cycle[:, 1].sum()
    late = rows.copy()
    late[-1, 0] -= 1
    if n < 7:  # so many cycles that one impact less is told from a cycle with one less
        assert impacts_of(late, 0, n) == 2
    assert impacts_of(rows, 0, 0) == rows[:, 0].sum()


def test_impacts_of_a_verdict_are_told_by_wall():
    """With the far wall out of reach all impacts are at the near one, and the other way round."""
    for gaps, wall in (({"C": 5.0}, "structure"), ({"D": 5.0, "C": 0.05}, "obstacle")):
        system = nv.load_system("ssbl", omega=6.28, **gaps)
        orbit = nv.simulate(system, 10, transient=150)
        assert set(orbit.impacts["wall"]) == {wall}
        regime = nv.classify(system, transient=150, periods=30, effort="quick")
        assert regime.period > 0
        struck = [word for word, count in regime.impacts_by_wall.items() if count > 0]
        assert struck == [wall]
    # the count of a window and that of the periodic orbit are two ways to one number
    for omega, n, k in ((6.28, 1, 1), (7.45, 3, 2)):
        want, sampling = ["impacts", "regime"], {"transient": 300, "periods": 30, "effort": "quick"}
        arrays = computed(scan_of("ssul-set6", want, {"omega": [omega]}, **sampling))
        assert arrays["label"][0, 0] == f"{'' if n == 1 else n}T,{k}"
        assert arrays["impact_count"][0, 0] == k
        assert arrays["impact_rate"][0, 0] == pytest.approx(k / n, abs=0.04)


def test_a_saddle_has_one_multiplier_beyond_one():
    turned = np.linalg.qr(np.random.default_rng(2).normal(size=(4, 4)))[0]
    for one, other in ((0.5, -0.5), (1.5, -0.5), (-1.5, -0.5), (1.5, 1.2)):
        matrix = turned @ np.diag([one, other, 0.1, 0.2]) @ turned.T
        assert is_saddle(eigenvalues(matrix)) == ((one, other) == (1.5, -0.5))


def test_the_fastest_decay_of_a_cycle_is_found_once_its_variations_are_aligned():
    """Where a matrix holds too few digits: without impacts, exponents are those of the flow."""
    system = nv.load_system("tmd", c1=1.4e4, c2=300.0, k2=300.0)
    regime = nv.classify(system, transient=20, periods=60)
    flow = linear_flow(system.parameters)[:4, :4]
    exact = np.sort(np.linalg.eigvals(flow).real)[::-1]
    assert exact.sum() * system.period < -18.0
    assert regime.exponents[0] == pytest.approx(exact[0], rel=1e-12)
    assert regime.exponents[3] == pytest.approx(exact[3], rel=1e-5)  # 2e-4 after one cycle less
    assert sum(regime.exponents) == pytest.approx(exact.sum(), rel=1e-9)


def test_growth_of_a_ball_that_rests_is_minus_infinity():
    """Of an orbit that is not judged yet: no variation is left, and its growth is no NaN."""
    table = {"m": 1.0, "g": 9.81, "Y": 1.2 * 9.81 / 900.0, "omega": 30.0, "e": 0.0}
    flow = flow_on(System("ball", table, law="restitution"))
    state, tangent, evidence = variations.new_state(), np.zeros(16), np.full(LENGTH_OF_ROW, np.nan)
    logs, growth = np.zeros(64), np.zeros(4)
    variations.set_identity(tangent)
    variations.place_state(flow, np.zeros(4), state)
    section = variations.no_section(flow.space)
    assert follow_growth(flow, section, state, tangent, logs, growth) == OK
    note_exponents(verdict.evidence_in(evidence), growth, logs, 1.0, 2)
    assert (evidence[[LYAPUNOV, EXPONENTS, EXPONENTS + 1]] == -np.inf).all()
    assert evidence[INTERVAL] < 1e-5
