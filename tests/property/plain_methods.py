"""Whatever is noted of an orbit, both methods note the same: random scenes far from the paper's.

Exact flight with certified touches and fixed Runge-Kutta steps share no formula but that of a
contact. Here they are compared in everything that can be asked for: states between and at the
sections, impacts with all their columns, energies, peaks, clearances, violations of a limit.
Run by `contract/test_plain.py`.
"""

import numpy as np
import pytest
from support import references, system_of

from nlds_vines.orbits.signals import energy_of_damper, energy_of_structure
from nlds_vines.orbits.simulation import simulate

SSBL = {**references()["ssbl-omega6.05"].numbers}
WALLED = ("trajectory", "section", "impacts", "energy", "peak", "clearance")
RECORDS = {
    "none": ("trajectory", "section", "energy", "peak"),
    "tmd": ("trajectory", "section", "energy", "peak"),
    "ssul": WALLED,
    "ssbl": WALLED,
    "ssvi-b": WALLED,
    "ssvi-c": WALLED,
}
PERIODS, BEFORE = 4, 1
COLUMNS = ("touch", "release", "speed", "force", "depth", "gain1", "gain2")
BOUND = 1e-6  # of a difference, relative to the largest of its kind


def random_case(kind, rng):
    """Return a system of a kind with everything varied, and a start within its walls."""
    numbers = dict(SSBL)
    for name in ("m1", "k1", "c1", "m2", "k2", "c2", "P"):
        numbers[name] *= 3.0 ** rng.uniform(-1, 1)
    numbers["omega"], numbers["K"] = rng.uniform(3, 12), 10.0 ** rng.uniform(4, 9)
    numbers["C"], numbers["D"] = rng.uniform(0.01, 0.05), rng.uniform(0.01, 0.05)
    numbers["L"], numbers["V"] = rng.uniform(0.0, 0.05), rng.uniform(0.1, 0.3)
    numbers["c2"] *= 0.3  # so that it keeps moving
    numbers["P"] *= 2.0
    system = system_of(kind, numbers)
    x1, v1, s = rng.normal(0, 0.02), rng.normal(0, 0.1), rng.normal(0, 0.5)
    start = (x1, v1)
    if system.scene.damper:
        start = (x1, v1, x1 + system.rest - rng.uniform(-0.01, 0.01), v1 - s)
    return system, start


def assert_near(one, other, scale):
    np.testing.assert_allclose(one, other, rtol=0, atol=BOUND * scale)


def compare(system, start, transient=BEFORE, periods=PERIODS):
    """Compare all that both methods note; return the orbit by the exact one."""
    options = {"start": start, "record": RECORDS[system.kind], "samples": 4}
    options["transient"] = transient
    exact = simulate(system, periods, contact_steps=60.0, nodes=20, **options)
    steps = simulate(system, periods, method="rk4", period_steps=2048.0, **options)
    np.testing.assert_array_equal(exact.time, steps.time)
    assert_near(exact.trajectory, steps.trajectory, np.abs(exact.trajectory).max())
    np.testing.assert_array_equal(exact.section, exact.trajectory[3::4])
    for name in ("E1max", "E2max", "E1peak", "E2peak", "clearance"):
        one, other = getattr(exact, name), getattr(steps, name)
        assert (one is None) == (other is None), name
        if one is not None and np.isfinite([one, other]).any():
            least = 0.05 * BOUND if name == "clearance" else 0.0
            assert one == pytest.approx(other, rel=BOUND, abs=least), name
    for orbit in (exact, steps):
        assert orbit.E1peak >= orbit.E1max
        assert orbit.E2peak is None or orbit.E2peak >= orbit.E2max
    if exact.impacts is not None:
        law = system.K * exact.impacts["depth"] ** 1.5
        np.testing.assert_allclose(exact.impacts["force"], law, rtol=1e-12)
        assert exact.impacts["wall"].tolist() == steps.impacts["wall"].tolist()
        for name in COLUMNS:
            one, other = exact.impacts[name], steps.impacts[name]
            np.testing.assert_array_equal(np.isnan(one), np.isnan(other))
            both = (
                ~np.isnan(one)
                if name in ("touch", "speed")
                else ~np.isnan(exact.impacts["release"])
            )
            if both.any():
                assert_near(one[both], other[both], 10 * np.abs(one[both]).max())
    if exact.violation is not None:
        one, other = exact.violation, steps.violation
        assert one.number == other.number
        assert one.depth == pytest.approx(other.depth, abs=1e-8)
        np.testing.assert_allclose(one.time, other.time, rtol=1e-7)
    return exact


@pytest.mark.parametrize("kind", RECORDS)
def test_both_methods_note_the_same(kind):
    rng = np.random.default_rng(sum(map(ord, kind)))
    orbits = [compare(*random_case(kind, rng)) for _ in range(8)]
    if orbits[0].impacts is not None:
        assert sum(len(orbit.impacts) for orbit in orbits) > 8
        assert sum(np.isfinite(orbit.clearance) for orbit in orbits) > 2
    if orbits[0].violation is not None:
        assert any(orbit.violation.number > 0 for orbit in orbits)


@pytest.mark.parametrize("method", ["exact", "rk4"])
def test_an_energy_may_be_largest_at_a_touch(method):
    """A damper on a spring that pulls it on hits a wall, and leaves it with what its dashpot left.

    The structure hardly moves, so that E2 = m2 v2^2 / 2 + k2 (x2 - rest)^2 / 2 in its flight.
    """
    numbers = {**SSBL, "m1": 1e9, "k1": 1e3, "c1": 0.0, "P": 0.0, "c2": 20.0, "K": 1e7}
    system = system_of("ssbl", {**numbers, "C": 0.05, "D": 0.05, "omega": 40.0})
    start = (0.1, 0.0, 0.1 + system.rest, 1.0)
    options = {} if method == "exact" else {"method": method, "period_steps": 2048.0}
    orbit = simulate(system, 1, start=start, record=WALLED, samples=8, **options)
    (hit,) = orbit.impacts
    assert hit["wall"] == "obstacle"
    work = 0.5 * numbers["k2"] * ((0.1 + 0.05) ** 2 - 0.1**2)
    touch = 0.5 * numbers["m2"] * hit["speed"] ** 2 + 0.5 * numbers["k2"] * 0.15**2
    assert 0.0 < work < touch
    assert orbit.E2max == pytest.approx(touch, rel=1e-5)


def highest(free, start):
    """Return the highest r [m] of a period, by a parabola; None where it lies at an end of it."""
    orbit = simulate(free, 1, start=start, record=("trajectory",), samples=256)
    r = orbit.trajectory[:, 0] - orbit.trajectory[:, 2] + free.rest
    i = int(r.argmax())
    if not 0 < i < 255:
        return None
    before, top, after = r[i - 1 : i + 2]
    return top - (after - before) ** 2 / (8 * (after - 2 * top + before))


def test_an_excursion_beyond_a_limit_may_be_short():
    """The limit lies a hair below or above the highest r of an orbit, between two samples."""
    rng, seen = np.random.default_rng(5), 0
    for _ in range(12):
        system, start = random_case("ssvi-c", rng)
        free = system.with_(L=10.0)
        top = highest(free, start)
        if top is None:
            continue
        for hair, number in ((1e-6, 1), (-1e-6, 0)):
            L = top - hair - free.rest
            if L <= 0.0 or start[0] - start[2] >= L:
                continue
            for options in ({}, {"method": "rk4", "period_steps": 1024.0}):
                violation = simulate(free.with_(L=L), 1, start=start, **options).violation
                assert violation.number == number
                assert violation.depth == pytest.approx(max(hair, 0.0), abs=3e-7)
            seen += number
    assert seen >= 3


STARTS = {
    # r - gap [m] at the near or -r - gap at the far wall, and the speed towards it [m/s]
    "on it, moving in": (0.0, 0.5),
    "on it, moving away": (0.0, -0.5),
    "inside, moving in": (0.004, 0.3),
    "inside, at rest": (0.004, 0.0),
    "inside, moving away": (0.004, -0.3),
}


@pytest.mark.parametrize("wall", ["near", "far"])
@pytest.mark.parametrize("begin", STARTS)
def test_starts_at_a_wall(begin, wall):
    """On it moving in, the first touch is that of the first instant; begun inside, none is."""
    depth, speed = STARTS[begin]
    numbers = {**SSBL, "C": 0.03125, "D": 0.0625, "K": 1e6, "m1": 1000.0, "m2": 60.0}
    system = system_of("ssbl", numbers)
    r, s = (system.rest + depth, speed) if wall == "near" else (-0.03125 - depth, -speed)
    start = (0.0, 0.0, system.rest - r, -s)
    orbit = compare(system, start, transient=0)
    first = orbit.impacts[0]
    if begin == "on it, moving in":
        assert first["touch"] == 0.0
        assert first["speed"] == 0.5
        assert first["wall"] == ("structure" if wall == "near" else "obstacle")
    else:
        assert first["touch"] > 0.01


@pytest.mark.parametrize("kind", ["ssul", "ssbl", "ssvi-b", "ssvi-c"])
def test_a_fast_damper_strikes_several_times_in_a_cell(kind):
    """A cell is an eighth of a period; the damper crosses its way in a hundredth."""
    numbers = {**SSBL, "C": 0.03, "D": 0.02, "L": 0.01, "V": 0.2, "K": 1e8, "P": 800.0}
    system = system_of(kind, {**numbers, "k2": 7000.0})
    for s in (4.0, -4.0):
        start = (0.001, 0.1, 0.001 + system.rest, 0.1 - s)
        orbit = compare(system, start, transient=0, periods=1)
        assert len(orbit.impacts) >= (3 if kind == "ssbl" else 1)
        if orbit.violation is not None:
            assert orbit.violation.number >= 1


def test_a_touch_may_be_by_a_hair():
    """The wall stands a hair below or above the largest r of an orbit, between two steps."""
    rng, seen = np.random.default_rng(6), 0
    for _ in range(12):
        system, start = random_case("ssul", rng)
        free = system.with_(C=10.0, V=0.1)
        begin = (start[0], start[1], start[0] + free.rest, start[3])
        top = highest(free, begin)
        if top is None:
            continue
        for hair, number in ((2e-6, 1), (-2e-6, 0)):
            walled = free.with_(C=top - hair)
            begin = (start[0], start[1], start[0] + walled.rest, start[3])
            for options in ({}, {"method": "rk4", "period_steps": 256.0}):
                orbit = simulate(walled, 1, start=begin, record=WALLED, samples=1, **options)
                assert len(orbit.impacts[orbit.impacts["depth"] < 1e-5]) == number
                if not number:
                    assert orbit.clearance == pytest.approx(-hair, abs=5e-7)
            seen += number
    assert seen >= 3


@pytest.mark.parametrize("method", ["exact", "rk4"])
@pytest.mark.parametrize("K", [1e3, 1e5, 1e8])
def test_the_largest_energies_are_those_of_many_samples(K, method):
    """From contacts that last most of a period, where both are largest inside one, to hard ones."""
    numbers = {**SSBL, "K": K, "C": 0.02, "V": 0.2, "D": 0.02}
    options = {} if method == "exact" else {"method": method, "period_steps": 1024.0}
    for kind in ("ssul", "ssbl"):
        system = system_of(kind, numbers)
        for start in (None, (0.0, 0.3, system.rest, -0.3)):
            dense = simulate(
                system, 2, start=start, record=("trajectory",), samples=1024, **options
            )  # fmt: skip
            orbit = simulate(system, 2, start=start, record=("energy",), **options)
            for name, energy in (("E1", energy_of_structure), ("E2", energy_of_damper)):
                sampled = energy(system, dense.trajectory).max()
                noted = getattr(orbit, f"{name}max")
                assert sampled * (1 - 1e-6) <= noted <= sampled * (1 + 1e-3), name


@pytest.mark.parametrize("kind", ["ssul", "ssbl"])
@pytest.mark.parametrize("K", [1e6, 1e8])
def test_samples_within_impacts_change_no_section(kind, K):
    """A short impact is one only if it ends before the next sample."""
    system = system_of(kind, {**SSBL, "K": K, "C": 0.02, "V": 0.2, "D": 0.02})
    few = simulate(system, 3, record=("section", "impacts"), contact_steps=60.0, nodes=20)
    many = simulate(
        system, 3, record=("trajectory", "section", "impacts"), samples=200, contact_steps=60.0,
        nodes=20,
    )  # fmt: skip
    np.testing.assert_allclose(many.section, few.section, rtol=0, atol=1e-9)
    assert len(few.impacts) > 1
    for name in COLUMNS:
        np.testing.assert_allclose(many.impacts[name], few.impacts[name], rtol=1e-7, atol=1e-9)
    inside = [
        np.count_nonzero((hit["touch"] < many.time) & (many.time < hit["release"]))
        for hit in few.impacts
    ]
    assert sum(inside) > 0
    steps = simulate(
        system, 3, record=("trajectory",), samples=200, method="rk4", period_steps=2000.0
    )  # fmt: skip
    scale = np.abs(many.trajectory).max(axis=0)
    np.testing.assert_allclose(many.trajectory / scale, steps.trajectory / scale, atol=1e-6)
