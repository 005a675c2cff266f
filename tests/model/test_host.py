"""Hosts: frequencies against closed forms, statics of reductions, files, refusals."""

import re

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
import scipy.sparse
import scipy.sparse.csgraph
import scipy.sparse.linalg

import nlds_vines as nv

FRAME = nv.shear_frame([1e4] * 10, [8e6] * 10, ratio=0.02)

BEAMS = {  # cos or sin of the wave number with its hyperbolic partner, and where it vanishes
    "clamped-free": (lambda a: np.cos(a) + 1 / np.cosh(a), [1.9, 4.7, 7.9, 11.0]),
    "clamped-clamped": (lambda a: np.cos(a) - 1 / np.cosh(a), [4.7, 7.9, 11.0, 14.1]),
    "clamped-pinned": (lambda a: np.sin(a) - np.cos(a) * np.tanh(a), [3.9, 7.1, 10.2, 13.4]),
    "pinned-pinned": (np.sin, [np.pi, 2 * np.pi, 3 * np.pi, 4 * np.pi]),
}


@pytest.mark.parametrize("ends", BEAMS)
def test_frequencies_of_beams_are_those_of_the_closed_form(ends):
    equation, near = BEAMS[ends]
    numbers = np.array([scipy.optimize.brentq(equation, a - 0.3, a + 0.3) for a in near])
    length, EI, per_length = 2.5, 70.0, 1.3
    exact = (numbers / length) ** 2 * np.sqrt(EI / per_length)
    # an element's error falls with the fourth power of its length
    errors = [
        nv.beam(length, EI, per_length, ends=ends, elements=n).frequencies[:4] / exact - 1
        for n in (20, 40)
    ]
    assert np.abs(errors[0]).max() < 2e-4
    assert errors[0][2:] / errors[1][2:] == pytest.approx(16, rel=0.05)


def test_a_free_beam_moves_without_stiffness_and_has_the_frequencies_of_a_clamped_one():
    free, clamped = (nv.beam(1, 1, 1, ends=ends) for ends in ("free-free", "clamped-clamped"))
    assert free.frequencies[:2].tolist() == [0, 0]
    assert free.frequencies[2:5] == pytest.approx(clamped.frequencies[:3], rel=2e-5)
    assert free.inertia.sum() == pytest.approx(free.inertia[::2].sum() + free.inertia[1::2].sum())
    # the ground moves all of the beam: the force is its mass times the acceleration
    across = np.tile([1.0, 0.0], 21)
    assert across @ free.inertia == pytest.approx(1.0)


def test_frequencies_of_frames_and_chains_are_those_of_the_closed_form():
    j = np.arange(1, 11)
    exact = 2 * np.sqrt(800) * np.sin((2 * j - 1) * np.pi / 42)
    assert FRAME.frequencies == pytest.approx(exact, rel=1e-12)
    assert FRAME.dofs[0] == "floor1"
    assert FRAME.dofs[-1] == "roof"
    fixed = nv.chain([1.0] * 5, [4.0] * 6)
    assert fixed.frequencies == pytest.approx(4 * np.sin(np.arange(1, 6) * np.pi / 12), rel=1e-12)
    cyclic = nv.chain([1.0] * 8, [0.5] * 8, grounds=1.0, cyclic=True)
    exact = np.sort(np.sqrt(1 + 2 * np.sin(np.pi * np.arange(8) / 8) ** 2))
    assert cyclic.frequencies == pytest.approx(exact, rel=1e-12)


def test_damping_is_that_of_the_ratios_of_rayleigh_or_of_the_matrix():
    M, K = FRAME.M, FRAME.K
    assert FRAME.damping_ratios == pytest.approx(np.full(10, 0.02), rel=1e-9)
    several = nv.Host(M, K, ratio=[0.01, 0.03])
    assert several.damping_ratios == pytest.approx([0.01] + [0.03] * 9, rel=1e-9)
    a, b, omega = 0.3, 1e-3, FRAME.frequencies
    rayleigh = nv.Host(M, K, rayleigh=(a, b))
    assert rayleigh.damping_ratios == pytest.approx((a / omega + b * omega) / 2, rel=1e-9)
    assert np.allclose(rayleigh.C, a * M + b * K, rtol=1e-14, atol=0)
    assert nv.Host(M, K).damping_ratios.max() == 0


def test_ratios_may_be_percentages_and_rayleigh_damping_two_ratios_at_two_frequencies():
    M, K = FRAME.M, FRAME.K
    assert nv.Host(M, K, ratio="2%").ratio.tolist() == [0.02]
    assert nv.Host(M, K, ratio=["1%", 0.03]).ratio.tolist() == [0.01, 0.03]
    modes = [{"f": 1.0, "zeta": "0.5%", "shape": {"tip": 1.0}}]
    assert nv.Host.from_modes(modes).damping_ratios == pytest.approx([0.005])
    # two modes of these frequencies have these ratios
    f = np.array([1.0, 8.0])
    for key, values in (("f", f), ("omega", 2 * np.pi * f)):
        table = {"ratios": ("2%", 0.03), key: values.tolist()}
        host = nv.Host(np.eye(2), np.diag((2 * np.pi * f) ** 2), rayleigh=table)
        assert host.damping_ratios == pytest.approx([0.02, 0.03], rel=1e-12)


def massless(n, gone, seed):
    """Return M without the masses of `gone`, and a random stiffness."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    masses = rng.uniform(1, 3, n)
    masses[gone] = 0.0
    return np.diag(masses), root @ root.T + n * np.eye(n)


def test_a_massless_node_between_two_springs_is_a_spring_of_half_the_stiffness():
    m, k = 3.0, 50.0
    M = np.diag([0.0, m])
    K = np.array([[2 * k, -k], [-k, k]])
    host = nv.Host(M, K, dofs=["joint", "top"], condense=True)
    assert host.frequencies == pytest.approx([np.sqrt(k / 2 / m)], rel=1e-14)
    assert (host.coordinates, host.condensed) == (("top",), ("joint",))
    assert host.shape[:, 0].tolist() == [0.5, 1.0]
    assert host.heading() == "2 degrees of freedom, 1 degree of freedom without mass condensed"
    assert "condensed: joint: without mass, they follow the others statically" in repr(host)


@pytest.mark.parametrize("large", [False, True])
def test_condensing_changes_no_response_to_forces_on_masses(large, monkeypatch):
    if large:
        monkeypatch.setattr("nlds_vines.model.host_matrices.MOST_DENSE", 8)
        monkeypatch.setattr("nlds_vines.model.host.MOST_DENSE", 8)
    gone, a, b = [1, 4, 5], 0.02, 0.003
    M, K = massless(9, gone, seed=3)
    C = a * M + b * K
    moved = np.arange(9.0)
    given = (M, K, C) if not large else tuple(map(scipy.sparse.csr_array, (M, K, C)))
    host = nv.Host(*given, influence=moved, condense=True)
    assert host.condensed == ("x2", "x5", "x6")
    force = np.zeros(9)
    force[[0, 3]] = 2.0, -1.0
    for omega in (0.0, 1.7, 6.0):
        impedance = K - omega**2 * M + 1j * omega * C
        exact = np.linalg.solve(impedance, force)
        named = {"x1": 2.0, "x4": -1.0}
        assert host.frequency_response(omega, force=named) == pytest.approx(exact, rel=1e-10)
        exact = np.linalg.solve(impedance, -0.3 * M @ moved)
        assert host.frequency_response(omega, base=0.3) == pytest.approx(exact, rel=1e-10)
    reduced = host.reduced(6)
    assert reduced.condensed == host.condensed
    assert reduced.frequency_response(1.7, force=named) == pytest.approx(
        host.frequency_response(1.7, force=named), rel=1e-9
    )
    assert nv.Host(K, K, condense=True).is_plain


def test_the_response_solves_the_equation_of_motion():
    omega = np.array([[0.0, 3.0], [8.0, 21.0]])
    X = FRAME.frequency_response(omega, force={"roof": 800.0, "floor3": -20.0})
    assert X.shape == (2, 2, 10)
    force = np.zeros(10)
    force[[9, 2]] = 800, -20
    for at in np.ndindex(omega.shape):
        w = omega[at]
        rest = (FRAME.K - w**2 * FRAME.M + 1j * w * FRAME.C) @ X[at] - force
        assert np.abs(rest).max() < 1e-9 * 800
    # far below the first mode the frame follows the ground: relative to it, -a / omega1^2
    one = nv.Host([[2.0]], [[50.0]])
    assert one.frequency_response(1e-4, base=3.0)[0] == pytest.approx(-3.0 * 2 / 50, rel=1e-6)
    assert np.isinf(one.frequency_response(5.0, force={"x1": 1.0})[0])


@pytest.mark.parametrize("large", [False, True])
def test_a_reduction_keeps_low_modes_and_the_static_response(large, monkeypatch):
    if large:
        monkeypatch.setattr("nlds_vines.model.host_matrices.MOST_DENSE", 8)
    host = nv.Host(FRAME.M, scipy.sparse.csr_array(FRAME.K), ratio=0.02, dofs=FRAME.dofs)
    assert scipy.sparse.issparse(host.M) == large
    reduced = host.reduced(3, statics=["roof"])
    assert reduced.shape.shape == (10, 4)
    assert reduced.frequencies[:3] == pytest.approx(FRAME.frequencies[:3], rel=1e-9)
    for load in ({"force": {"roof": 1e3}}, {"base": 2.0}):
        exact = FRAME.frequency_response(FRAME.frequencies[0], **load)
        assert reduced.frequency_response(FRAME.frequencies[0], **load) == pytest.approx(
            exact, rel=2e-3
        )
    at_rest = {"omega": 0.0, "force": {"roof": 1e3}}
    exact = FRAME.frequency_response(**at_rest)
    assert reduced.frequency_response(**at_rest)[9] == pytest.approx(exact[9], rel=1e-7)
    plain = host.reduced(3)
    assert abs(plain.frequency_response(**at_rest)[9] / exact[9] - 1) > 0.02
    assert plain.note == "3 of 10 modes"


def test_a_reduction_to_all_modes_changes_no_response_and_a_free_structure_can_be_reduced():
    everything = FRAME.reduced(10, statics=["roof"])
    omega = np.linspace(0, 60, 7)
    for load in ({"force": {"floor4": 1.0}}, {"base": 1.0}):
        assert everything.frequency_response(omega, **load) == pytest.approx(
            FRAME.frequency_response(omega, **load), rel=1e-9, abs=1e-18
        )
    below = FRAME.reduced(below=FRAME.frequencies[4])
    assert below.shape.shape == (10, 5)
    free = nv.chain([1.0] * 6, [0.0] + [1.0] * 5)
    reduced = free.reduced(2, statics=["x6"])
    # the kept modes and the response to a force on x6 without them
    low = np.linspace(0.05, 0.4, 5)
    load = {"force": {"x6": 1.0}}
    exact = free.frequency_response(low, **load)[:, 5]
    assert reduced.frequency_response(low, **load)[:, 5] == pytest.approx(exact, rel=3e-3)


def test_modes_are_a_host():
    modes = [
        {"f": FRAME.frequencies[i] / (2 * np.pi), "zeta": 0.02, "participation": part,
         "shape": dict(zip(FRAME.dofs, FRAME.modes[:, i], strict=True))}
        for i, part in enumerate(FRAME.modes.T @ FRAME.inertia)
    ]  # fmt: skip
    host = nv.Host.from_modes(modes[::-1])
    assert host.dofs == FRAME.dofs
    for load in ({"force": {"roof": 1.0}}, {"base": 1.0}):
        exact = FRAME.frequency_response(7.0, **load)
        assert host.frequency_response(7.0, **load) == pytest.approx(exact, rel=1e-9)
    assert nv.Host.from_modes(modes[:2], dofs=("roof",)).dofs[0] == "roof"


EYE = np.eye(2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"M": [[1, 0], [0, 0]]}, "M gives the degree of freedom 'x2' the mass 0, which must be"),
        ({"M": [[1, 2], [2, 1]]}, "M must be positive definite, but has the eigenvalue -1"),
        ({"K": [[1, 2], [2, 1]]}, "K must be positive semidefinite, but has the eigenvalue -1"),
        (
            {"K": [[1, 2], [0.25, 1]]},
            r"K is not symmetric: K\[0, 1\] = 2.0, K\[1, 0\] = 0.25$",
        ),
        ({"K": [[1, 0], [2, 1]]}, "it is its lower triangle alone; give all of it"),
        ({"K": [[1, 2], [0, 1]]}, "it is its upper triangle alone; give all of it"),
        ({"K": [[1e6, 1e6], [1e6 + 0.1, 1e6]]}, r"= 1000000.0, K\[1, 0\] = 1000000.1"),
        ({"M": 1e308 * EYE}, r"M holds a value beyond 1e\+100"),
        ({"K": 1e100 * EYE, "M": 1e-290 * EYE}, "M and K give a (frequency|mode) that is no"),
        ({"M": 5e-324 * EYE}, "M and K give"),
        ({"rayleigh": (1e308, 1e308)}, "rayleigh gives a damping that is no finite number"),
        ({"dofs": np.array("a")}, "dofs = .* must be a list"),
        ({"K": np.eye(3)}, r"K has the shape \(3, 3\), but M has \(2, 2\)"),
        ({"K": [1, 2]}, r"K has the shape \(2,\); it must be square"),
        ({"K": [[1, np.nan], [0, 1]]}, "K holds a value that is no finite real number"),
        ({"K": EYE * (1 + 0.02j)}, "K holds a value that is no finite real number"),
        ({"ratio": np.array([0.1j])}, "ratio = .* must be finite numbers"),
        ({"C": -EYE}, "C must be positive semidefinite"),
        ({"C": EYE, "ratio": 0.1}, "the damping is stated twice"),
        ({"ratio": -0.1}, "ratio = .* must be finite numbers >= 0"),
        ({"ratio": 2}, r"ratio = 2 is 200 % of critical damping; .* 2 % is 0.02 or '2%'"),
        ({"ratio": "300%"}, "ratio = 3 is 300 % of critical damping"),
        ({"ratio": "2"}, "ratio = '2' must be a number, or as '2%'"),
        ({"ratio": "nan%"}, "must be finite numbers >= 0"),
        ({"rayleigh": {"ratios": [0.02, 0.03]}}, r"give one of f \[Hz\] and omega \[rad/s\]"),
        ({"rayleigh": {"ratios": [0.02], "f": [1, 8]}}, "ratios and f must be two numbers each"),
        ({"rayleigh": {"ratios": [2, 3], "f": [1, 8]}}, "rayleigh: ratios = 2 is 200 %"),
        ({"rayleigh": {"ratios": [0.02, 0.03], "f": [0, 8]}}, r"f = \[0, 8\] must be > 0"),
        ({"rayleigh": {"ratios": [0.02, 0.001], "f": [1, 8]}}, "which must be >= 0: give ratio"),
        ({"rayleigh": {"ratio": 0.02, "f": [1, 8]}}, "did you mean 'ratios'"),
        ({"condense": "yes"}, "condense = 'yes' must be true or false"),
        ({"M": np.zeros((2, 2)), "condense": True}, "no degree of freedom has a mass"),
        (
            {"M": np.diag([1, 0]), "K": np.diag([1, 0]), "condense": True},
            "degrees of freedom without mass cannot be condensed: K leaves them free to move",
        ),
        ({"rayleigh": (1, 2, 3)}, "must be two numbers"),
        ({"dofs": ["a", "a"]}, "dofs = .* must be 2 different names"),
        ({"dofs": ["a.b", "c"]}, "dofs = 'a.b' must be a text without"),
        ({"dofs": ["ground", "c"]}, "dofs: 'ground' has another meaning"),
        (
            {"K": [[1e-300, 1], [1, 1e90]]},
            "K must be positive semidefinite, but has the eigenvalue",
        ),
        ({"influence": [1e308, 1], "M": 1e10 * EYE}, "M times the influence is no finite number"),
        ({"influence": [1]}, "influence has 1 values for 2 degrees of freedom"),
    ],
)
def test_what_is_no_host_is_refused_in_one_line(options, message, error_of):
    assert re.search(message, error_of(nv.Host, **{"M": EYE, "K": EYE, **options}))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: FRAME.reduced(), "a reduction needs one of keep and below"),
        (lambda: FRAME.reduced(11), "keep = 11 must be a whole number from 1 to 10"),
        (lambda: FRAME.reduced(below=1.0), r"below = 1 leaves no mode: .* has 4.22\d rad/s"),
        (lambda: FRAME.reduced(3, statics=["rooof"]), "did you mean 'roof'"),
        (lambda: FRAME.frequency_response(1.0), "a response needs one of force and base"),
        (lambda: FRAME.frequency_response(1.0, force={"top": 1.0}), "'top'"),
        (lambda: nv.Host.from_modes([]), "has no mode"),
        (lambda: nv.Host.from_modes([{"f": 0, "shape": {}}]), "mode 1: f = 0 must be > 0"),
        (lambda: nv.Host.from_modes([{"f": 1.0, "shapes": {}}]), "did you mean 'shape'"),
        (lambda: nv.beam(1, 1, 0), "mass_per_length = 0 must be > 0"),
        (lambda: nv.beam(1, 1, 1, ends="clamped"), "did you mean 'clamped-free'"),
        (lambda: nv.chain([1, 1], [1]), "1 springs do not fit 2 masses"),
        (lambda: nv.shear_frame([1, 1], [1, 1, 1]), "3 stiffnesses do not fit 2 masses"),
        (lambda: nv.shear_frame([1, -1], [1, 1]), "'roof' the mass -1, which must be > 0"),
        (lambda: nv.chain([1, 1], [1, -1]), "must be finite numbers >= 0"),
        (lambda: nv.chain([1, 1], [1, 1], cyclic="false"), "cyclic = 'false' must be true or"),
    ],
)
def test_wrong_requests_are_refused_in_one_line(call, message, error_of):
    assert re.search(message, error_of(call))


def test_the_arrays_of_a_host_are_read_only_and_those_it_was_made_from_are_not():
    M, K, influence = np.eye(2), np.diag([2.0, 3.0]), np.ones(2)
    host = nv.Host(M, K, ratio=0.01, influence=influence)
    modes = nv.Host.from_modes([{"f": 1.0, "shape": {"tip": 1.0}}])
    reduced = FRAME.reduced(2)
    for one in (host, modes, reduced):
        for name in ("M", "K", "C", "shape", "inertia", "influence", "ratio"):
            array = getattr(one, name)
            with pytest.raises(ValueError, match="read-only"):
                array[...] = -5.0
    for array in (M, K, influence):
        array[...] = 7.0
    assert host.frequencies == pytest.approx(np.sqrt([2.0, 3.0]))


def test_a_large_host_has_to_be_reduced_and_can_be():
    n = 3000
    K = scipy.sparse.diags_array(
        [-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1]
    )
    host = nv.Host(scipy.sparse.eye_array(n), 1e6 * K, rayleigh=(0.1, 0.0))
    with pytest.raises(nv.RequestError, match="too large for all its modes: reduce it"):
        _ = host.frequencies
    reduced = host.reduced(4, statics=["x1500"])
    exact = 2e3 * np.sin(np.arange(1, 5) * np.pi / (2 * n + 2))
    assert reduced.frequencies[:4] == pytest.approx(exact, rel=1e-7)
    assert reduced.damping_ratios[:4] == pytest.approx(0.05 / exact, rel=1e-7)
    middle = reduced.frequency_response(0.0, force={"x1500": 1.0})[1499].real
    assert middle == pytest.approx(1500 * 1501 / 3001 / 1e6, rel=1e-6)


# ---- modes whose frequencies are far below the highest -------------------------------------------

SLOW = pytest.param(200, marks=pytest.mark.slow("dense modes of 400 coordinates"))


@pytest.mark.parametrize("elements", [50, 75, SLOW])
def test_low_frequencies_of_fine_beams_are_those_of_the_closed_form(elements):
    length, EI, per_length = 1.0, 65.6, 1.18
    equation, near = BEAMS["clamped-free"]
    numbers = np.array([scipy.optimize.brentq(equation, a - 0.3, a + 0.3) for a in near])
    exact = (numbers / length) ** 2 * np.sqrt(EI / per_length)
    fine = nv.beam(length, EI, per_length, elements=elements, ratio=0.02)
    # elements err by less than (j / n)^4, round-off in the entries of K by far less
    errors = fine.frequencies[:4] / exact - 1
    assert (np.abs(errors) < (np.arange(1, 5) / elements) ** 4 + 1e-9).all()
    assert fine.frequencies[0] == pytest.approx(exact[0], rel=2e-9)
    assert fine.damping_ratios == pytest.approx(np.full(2 * elements, 0.02), rel=1e-6)
    tip = fine.frequency_response(exact[0], force={f"w{elements}": 1.0})[-2]
    # a cantilever's mode has phi(tip)^2 = 4 over its mass; the others together add 1e-3 of it
    assert abs(tip) == pytest.approx(4 / (per_length * 2 * 0.02 * exact[0] ** 2), rel=2e-3)


@pytest.mark.parametrize("elements", [50, SLOW])
def test_the_frequencies_of_a_free_beam_are_0_and_those_of_a_clamped_one(elements):
    free = nv.beam(1.0, 65.6, 1.18, ends="free-free", elements=elements)
    clamped = nv.beam(1.0, 65.6, 1.18, ends="clamped-clamped", elements=elements)
    assert free.frequencies[:2].tolist() == [0.0, 0.0]
    assert free.frequencies[2:5] == pytest.approx(clamped.frequencies[:3], rel=1e-6)


def test_a_penalty_spring_or_a_small_inertia_makes_no_frequency_0():
    # two masses on a spring each, a third mass that a stiff spring holds: 1 +- 1/2 and 3/2
    penalty = nv.Host(np.eye(3), [[1e14 + 1, -1, 0], [-1, 2, -1], [0, -1, 1]])
    held = (3 - np.sqrt(5)) / 2, (3 + np.sqrt(5)) / 2
    assert penalty.frequencies[:2] == pytest.approx(np.sqrt(held), rel=1e-12)
    # a mass of nearly 0 between two springs of 1 N/m follows: one spring of 1/2 N/m
    light = nv.Host(np.diag([1, 1e-13, 1]), [[2, -1, 0], [-1, 2, -1], [0, -1, 1]])
    exact = np.sqrt([1 - np.sqrt(0.5), 1 + np.sqrt(0.5)])
    assert light.frequencies[:2] == pytest.approx(exact, rel=1e-9)


def test_masses_of_any_size_are_compared_in_their_own_units():
    host = nv.Host(np.diag([2e5, 1e-6]), np.diag([1e7, 1.0]))
    assert host.frequencies == pytest.approx([np.sqrt(50.0), 1e3], rel=1e-12)
    coupled = nv.Host([[2e5, 0.1], [0.1, 1e-6]], np.diag([1e7, 1.0]))
    squares = np.roots([2e5 * 1e-6 - 0.01, -(2e5 + 1e7 * 1e-6), 1e7])
    assert coupled.frequencies == pytest.approx(np.sort(np.sqrt(squares)), rel=1e-9)
    with pytest.raises(nv.RequestError, match="M must be positive definite, but has the eigenv"):
        nv.Host([[2e5, 0.5], [0.5, 1e-6]], np.diag([1e7, 1.0]))


def test_what_moves_without_a_force_is_found_in_any_units():
    rng = np.random.default_rng(5)
    for _ in range(8):
        n = int(rng.integers(4, 60))
        K = np.zeros((n, n))
        for _ in range(3 * n):
            i, j = rng.choice(n, 2, replace=False)
            k = 10 ** rng.uniform(0, 6)
            K[[i, j], [i, j]] += k
            K[[i, j], [j, i]] -= k
        pieces = scipy.sparse.csgraph.connected_components(K)[0]
        units = 10 ** rng.uniform(-3, 3, n)
        host = nv.Host(np.diag(10 ** rng.uniform(-3, 3, n)), K * np.outer(units, units))
        assert np.count_nonzero(host.frequencies == 0) == pieces


@pytest.mark.parametrize(
    ("elements", "rel"), [(50, 1e-8), pytest.param(200, 1e-6, marks=SLOW.marks)]
)
def test_modes_are_those_of_lapack_and_arpack(elements, rel):
    host = nv.beam(2.0, 70.0, 1.3, elements=elements, ends="clamped-pinned")
    squares, vectors = scipy.linalg.eigh(host.K, host.M)
    # LAPACK's own error: round-off times the largest
    tolerance = 1e-15 * squares[-1]
    assert np.abs(host.frequencies**2 - squares).max() < 20 * tolerance
    assert host.frequencies[8:] == pytest.approx(np.sqrt(squares[8:]), rel=rel)
    assert np.abs(np.abs(host.modes[:, -20:] / vectors[:, -20:]) - 1).max() < 1e-4
    gram = host.modes.T @ host.M @ host.modes
    assert np.abs(gram - np.eye(len(gram))).max() < 1e-9
    energies = host.modes.T @ host.K @ host.modes
    assert np.abs(energies - np.diag(host.frequencies**2)).max() < 30 * tolerance


def test_a_structure_of_2500_degrees_of_freedom_has_the_modes_of_arpack():
    n = 50  # a grid of masses, springs along both directions: eigenvalues are sums
    rows = scipy.sparse.diags_array(
        [-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1]
    )
    eye = scipy.sparse.eye_array(n)
    K = 1e6 * scipy.sparse.kron(rows, eye) + 1.1e6 * scipy.sparse.kron(eye, rows)
    masses = scipy.sparse.diags_array(np.random.default_rng(2).uniform(1.0, 2.0, n * n))
    host = nv.Host(masses, K)
    assert scipy.sparse.issparse(host.M)
    reduced = host.reduced(12, statics=["x1275"])
    squares = scipy.sparse.linalg.eigsh(K.tocsc(), 12, masses.tocsc(), sigma=0.0)[0]
    assert reduced.frequencies[:12] == pytest.approx(np.sqrt(np.sort(squares)), rel=1e-10)
    uniform = nv.Host(eye_of(n * n), K).reduced(12)
    one = 4 * np.sin(np.arange(1, n + 1) * np.pi / (2 * n + 2)) ** 2
    exact = np.sort(np.add.outer(1e6 * one, 1.1e6 * one).ravel())[:12]
    assert uniform.frequencies**2 == pytest.approx(exact, rel=1e-11)
    free = scipy.sparse.diags_array(K.sum(axis=1))
    floating = nv.Host(masses, K - free).reduced(4)
    assert floating.frequencies[0] == 0.0
    squares = np.sort(scipy.sparse.linalg.eigsh(K - free, 4, masses, sigma=-1.0)[0])
    assert floating.frequencies[1:] == pytest.approx(np.sqrt(squares[1:]), rel=1e-8)


def test_reduced_frequencies_are_those_of_the_modes_that_are_kept():
    fine = nv.beam(1.0, 65.6, 1.18, elements=80, ratio=0.02)
    reduced = fine.reduced(3, statics=["w80", "w40"])
    assert reduced.frequencies[:3] == pytest.approx(fine.frequencies[:3], rel=1e-12)
    exact = fine.frequency_response(0.0, force={"w80": 1.0}).real
    assert exact[-2] == pytest.approx(1 / (3 * 65.6), rel=1e-6)
    static = reduced.frequency_response(0.0, force={"w80": 1.0}).real
    assert static == pytest.approx(exact, rel=1e-6)


def free_chain(count, rng):
    """Return M and K of masses in a row, of which no spring holds any."""
    K = np.zeros((count, count))
    for i, k in enumerate(rng.uniform(1e3, 9e3, count - 1)):
        K[i : i + 2, i : i + 2] += k * np.array([[1, -1], [-1, 1]])
    return np.diag(rng.uniform(1, 2, count)), K


@pytest.mark.parametrize("digits", range(7, 12))
def test_a_rigid_motion_that_rounding_made_unstable_is_rigid(here, digits, error_of):
    """Beside scipy's lowest eigenvalue, which is negative; a negative spring beyond it is one."""
    is_rounded = False
    for seed in range(6):
        rng = np.random.default_rng(seed)
        M, K = free_chain(int(rng.integers(3, 30)), rng)
        exact = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[1:])
        np.savetxt("K.txt", K, fmt=f"%.{digits}g")
        entries = np.loadtxt("K.txt")
        is_rounded |= scipy.linalg.eigvalsh(entries)[0] < -1e-12 * K.max()
        host = nv.Host(M=M, K="K.txt")
        assert host.frequencies[0] <= np.sqrt(10.0 ** (1 - digits) * K.max())
        assert host.frequencies[1:] == pytest.approx(exact, rel=10.0 ** (5 - digits))
        entries[0, 0] -= 30 * 10.0 ** (1 - digits) * K.max()
        np.savetxt("unstable.txt", entries, fmt=f"%.{digits}g")
        assert "K must be positive semidefinite" in error_of(nv.Host, M=M, K="unstable.txt")
    assert is_rounded


def test_rounded_entries_may_be_condensed_and_few_digits_are_exact(here, error_of):
    M, K = free_chain(12, np.random.default_rng(3))
    for step in (2, 3):
        light = M.copy()
        light[1::step] = 0
        np.savetxt("K.txt", K, fmt="%.9g")
        host = nv.Host(M=light, K="K.txt", condense=True, rayleigh=(0.0, 1e-3))
        assert host.frequencies[0] < 1e-3 * host.frequencies[1]
    line = error_of(nv.Host, np.eye(2), [[1.0, -1.0], [-1.0, 0.999999]])
    assert "K must be positive semidefinite, but has the eigenvalue -5e-07" in line


def eye_of(n):
    return scipy.sparse.eye_array(n, format="csc")


@pytest.mark.parametrize("name", ["M", "K", "C"])
@pytest.mark.parametrize("is_hidden", [False, True])
def test_a_large_structure_with_a_negative_eigenvalue_is_refused(name, is_hidden, error_of):
    n = 2500
    matrices = {"M": eye_of(n), "K": 1e6 * eye_of(n), "C": 10.0 * eye_of(n)}
    matrix = matrices[name].tolil()
    if is_hidden:  # the diagonal is positive
        matrix[[1200, 1201], [1201, 1200]] = -1.5 * matrix[0, 0]
    elif name != "M":
        matrix[1200, 1200] = -matrix[0, 0]
    else:
        matrix[1200, 1201] = matrix[1201, 1200] = matrix[0, 0]  # an eigenvalue of 0
    matrices[name] = matrix.tocsc()
    line = error_of(nv.Host, **matrices)
    sign = "positive definite" if name == "M" else "positive semidefinite"
    assert f"{name} must be {sign}, but has 1 eigenvalue" in line


def test_as_many_modes_as_a_dense_host_holds_can_be_kept(error_of):
    n = 2500
    host = nv.Host(eye_of(n), eye_of(n) * 4.0)
    assert "keep = 2001 must be a whole number from 1 to 2000" in error_of(host.reduced, 2001)
