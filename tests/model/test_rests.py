"""Rest positions: static balance, stability beside eigenvalues, the start "rest"."""

import pickle

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.model.rests import real_roots


def system_of(host, *dampers):
    return nv.System.from_host(host, dampers, force={host.dofs[0]: 0.02}, omega=1.0)


HOST = nv.chain([1.0], [1.0])
BISTABLE = nv.Damper("nes", "x1", m=0.05, k=-0.02, spring=nv.Spring(k3=0.2))
WELL = np.sqrt(0.1)  # k + k3 r^2 = 0


def forces_at(system, places):
    """Return the force [N] on each coordinate and mass, without walls."""
    count = len(system.host.inertia)
    forces = np.zeros(len(places))
    forces[:count] = -system.host.K @ places[:count]
    for damper, row in zip(system.dampers, system.rows(), strict=True):
        r = row @ places
        nonlinear = 0.0 if damper.spring is None else damper.spring.force(r)
        forces -= row * (damper.k * r + nonlinear)
    return forces


def is_stable_by_eigenvalues(system, places):
    count = len(system.host.inertia)
    stiffness = np.zeros((len(places), len(places)))
    stiffness[:count, :count] = system.host.K
    for damper, row in zip(system.dampers, system.rows(), strict=True):
        slope = damper.k
        if damper.spring is not None:
            slope += damper.spring.slope(row @ places)
        stiffness += slope * np.outer(row, row)
    mass = np.diag([*np.diag(system.host.M), *(damper.m for damper in system.masses)])
    return np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real.min() > 0.0


def test_a_bistable_damper_has_two_wells_and_starts_in_the_one_above():
    system = system_of(HOST, BISTABLE)
    assert [rest.is_stable for rest in system.rests] == [True, False, True]
    strokes = [rest.strokes["nes"] for rest in system.rests]
    assert strokes == pytest.approx([-WELL, 0.0, WELL], rel=1e-15)
    assert system.state_at_rest == system.rests[2].state
    assert system.state_at_rest == pytest.approx([0.0, 0.0, -WELL, 0.0], rel=1e-15)
    assert system.rest_in_words == "nes at r = 0.3162 m"
    assert system.attributes()["rest"] == dict(system.outline())["rest"] == "nes at r = 0.3162 m"
    assert "rest" in system.attributes(["omega"])
    assert "rest" not in system.attributes(["nes.k"])
    assert pickle.loads(pickle.dumps(system.rests[0])).strokes == system.rests[0].strokes


def test_what_is_stable_at_zero_starts_there():
    cubic = nv.Damper("nes", "x1", m=0.05, spring=nv.Spring(k3=0.2))
    for damper in (cubic, nv.Damper("tmd", "x1", m=0.05, k=0.1)):
        system = system_of(HOST, damper)
        (rest,) = system.rests
        assert rest.is_stable
        assert rest.state == system.state_at_rest == (0.0,) * 4
        assert system.rest_in_words == ""
        assert "rest" not in system.attributes()
    (rest,) = nv.load_system("ssul-set6").rests
    assert rest.state == nv.load_system("ssul-set6").state_at_rest


def test_wells_of_several_dampers_are_combined():
    tilted = nv.Damper("b", "x2", m=0.1, k=0.1, spring=nv.Spring(k2=-1.0, k3=2.0))
    host = nv.chain([1.0, 2.0], [3.0, 4.0])
    system = system_of(host, BISTABLE, tilted, nv.Damper("tmd", "x1", m=0.01, k=0.1))
    assert len(system.rests) == 9
    assert sum(rest.is_stable for rest in system.rests) == 4
    deeper = 0.25 * (1.0 + np.sqrt(1.0 - 0.8))
    assert max(rest.strokes["b"] for rest in system.rests) == pytest.approx(deeper, rel=1e-14)
    # r = 0 of the tilted damper is a well, though not the deepest one
    assert system.rest_in_words == "nes at r = 0.3162 m"


def random_system(generator):
    floors = int(generator.integers(1, 4))
    masses = generator.uniform(0.5, 2.0, floors)
    host = nv.chain(list(masses), list(generator.uniform(0.5, 2.0, floors)))

    def nonlinear(name, place, **options):
        k, k2, k3 = generator.uniform(-1.5, 0.7, 3)
        return nv.Damper(name, place, k=k, spring=nv.Spring(k2=k2, k3=k3, k5=2.0), **options)

    link = nonlinear("link", ("x1", "ground"))
    other = nv.Damper("other", (host.dofs[-1], "ground"), k=generator.uniform(0.0, 1.0))
    return system_of(host, nonlinear("nes", host.dofs[-1], m=0.1), link, other)


def test_random_systems_balance_at_rest_and_are_stable_as_eigenvalues_say():
    generator = np.random.default_rng(64)
    counts = set()
    for _ in range(40):
        system = random_system(generator)
        wells = [rest for rest in system.rests if rest.is_stable]
        assert len(system.rests) > len(wells) or len(wells) == 1
        for rest in system.rests:
            places = np.array(rest.state[::2])
            assert np.abs(forces_at(system, places)).max() < 1e-13
            strokes = system.rows() @ places
            assert strokes[:2] == pytest.approx([rest.strokes["nes"], rest.strokes["link"]])
            assert rest.is_stable == is_stable_by_eigenvalues(system, places)
        assert system.state_at_rest in [rest.state for rest in wells]
        counts.add(len(system.rests))
    assert counts >= {1, 3, 9}


def test_an_oscillator_with_two_wells_needs_no_spring_of_its_structure():
    host = nv.Host(M=[[2.0]], K=[[0.0]], dofs=["x1"])
    duffing = nv.Damper("wells", ("x1", "ground"), k=-1.0, spring=nv.Spring(k3=4.0))
    system = system_of(host, duffing)
    assert [rest.state[0] for rest in system.rests] == pytest.approx([-0.5, 0.0, 0.5], rel=1e-12)
    assert system.state_at_rest == pytest.approx([0.5, 0.0], rel=1e-12)


@pytest.mark.parametrize("law", ["restitution", "hertz"])
def test_a_wall_before_a_well_holds_the_damper(law):
    constants = {"e": 0.5} if law == "restitution" else {"K": 1e4}
    walls = [nv.Wall(0.2, "+", law=law, **constants), nv.Wall(0.5, "-", law=law, **constants)]
    damper = nv.Damper("nes", "x1", m=0.05, k=-0.02, spring=nv.Spring(k3=0.2), walls=walls)
    system = system_of(HOST, damper)
    assert [rest.is_stable for rest in system.rests] == [True, False, True]
    assert system.rests[0].strokes["nes"] == pytest.approx(-WELL, rel=1e-15)
    r = system.rests[2].strokes["nes"]
    if law == "restitution":
        assert r == 0.2
    else:
        contact = 1e4 * (r - 0.2) ** 1.5
        assert contact == pytest.approx(0.02 * r - 0.2 * r**3, rel=1e-9)
    assert system.state_at_rest[2] == -r


def test_roots_of_polynomials_are_all_real_ones():
    generator = np.random.default_rng(5)
    for degree in (1, 2, 3, 5):
        for _ in range(20):
            coefficients = generator.normal(size=degree + 1).tolist()
            every = np.roots(coefficients[::-1])
            real = np.sort(every.real[np.abs(every.imag) < 1e-9])
            assert real_roots(coefficients) == pytest.approx(real.tolist(), rel=1e-9)
    assert real_roots([0.0, 0.0, 0.0, 2.0]) == [0.0]
    assert real_roots([1.0, 0.0]) == []


def test_rests_of_coupled_springs_are_refused(error_of):
    host = nv.chain([1.0, 1.0], [1.0, 1.0])
    springs = []
    for name, place in (("a", ("x1", "ground")), ("b", ("x2", "x1"))):
        springs.append(nv.Damper(name, place, k=-0.1, spring=nv.Spring(k3=1.0)))
    system = system_of(host, *springs)
    assert error_of(lambda: system.rests).startswith("a and b are nonlinear springs between")
    assert "Give a start" in error_of(lambda: system.state_at_rest)
    assert system.rest_in_words == "not computed, of several coupled nonlinear springs"
    stiff = system.with_(**{"a.k": 0.0, "b.k": 0.1})
    assert stiff.state_at_rest == (0.0,) * 4


def test_too_many_rests_are_refused(error_of):
    dampers = [
        nv.Damper(f"n{i}", "x1", m=0.05, k=-0.02, spring=nv.Spring(k3=0.2)) for i in range(9)
    ]
    system = system_of(HOST, *dampers)
    assert "19683 rests; allowed: 10000" in error_of(lambda: system.rests)
    assert system.rest_in_words.count("at r = 0.3162 m") == 9
