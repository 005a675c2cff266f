"""Whatever is noted of an orbit, both methods note the same: random scenes far from the paper's.

Exact flight with certified touches and fixed Runge-Kutta steps share no formula but that of a
contact. Here they are compared in everything that can be asked for: states between and at the
sections, impacts with all their columns, energies, peaks, clearances, violations of a limit.
Run by `contract/test_plain.py`.
"""

import numpy as np
import pytest
from support import references, system_of

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


def compare(system, start):
    """Compare all that both methods note; return the impacts and the violations."""
    options = {"transient": BEFORE, "start": start, "record": RECORDS[system.kind], "samples": 4}
    exact = simulate(system, PERIODS, contact_steps=60.0, nodes=20, **options)
    steps = simulate(system, PERIODS, method="rk4", period_steps=2048.0, **options)
    np.testing.assert_array_equal(exact.time, steps.time)
    assert_near(exact.trajectory, steps.trajectory, np.abs(exact.trajectory).max())
    np.testing.assert_array_equal(exact.section, exact.trajectory[3::4])
    for name in ("E1max", "E2max", "E1peak", "E2peak", "clearance"):
        one, other = getattr(exact, name), getattr(steps, name)
        assert (one is None) == (other is None), name
        if one is not None and np.isfinite([one, other]).any():
            least = 0.05 * BOUND if name == "clearance" else 0.0
            assert one == pytest.approx(other, rel=BOUND, abs=least), name
    if exact.impacts is not None:
        assert exact.impacts["wall"].tolist() == steps.impacts["wall"].tolist()
        for name in COLUMNS:
            one, other = exact.impacts[name], steps.impacts[name]
            np.testing.assert_array_equal(np.isnan(one), np.isnan(other))
            known = (
                ~np.isnan(one)
                if name in ("touch", "speed")
                else ~np.isnan(exact.impacts["release"])
            )
            if known.any():
                assert_near(one[known], other[known], 10 * np.abs(one[known]).max())
    if exact.violation is not None:
        one, other = exact.violation, steps.violation
        assert one.number == other.number
        assert one.depth == pytest.approx(other.depth, abs=1e-8)
        np.testing.assert_allclose(one.time, other.time, rtol=1e-7)
    return exact


@pytest.mark.parametrize("kind", RECORDS)
def test_both_methods_note_the_same(kind):
    rng = np.random.default_rng(sum(map(ord, kind)))
    found = [compare(*random_case(kind, rng)) for _ in range(8)]
    if found[0].impacts is not None:
        assert sum(len(orbit.impacts) for orbit in found) > 8
        assert sum(np.isfinite(orbit.clearance) for orbit in found) > 2
    if found[0].violation is not None:
        assert any(orbit.violation.number > 0 for orbit in found)
