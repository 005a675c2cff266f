"""Laws of mechanics that hold whatever the numbers: energy, units, the direction of time."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from benchmarks.extremes import BOTH, FULL, energy_of, error_of
from nlds_vines import load_system, simulate

FINE = {"nodes": 24, "contact_steps": 200.0}
"""Settings of the exact method at which its errors lie below round-off."""

FORCES = dict.fromkeys(("m1", "k1", "c1", "m2", "k2", "c2", "P", "K"), 1)
"""Parameters that carry the unit of force (or mass): a common factor changes no motion."""

RATES = {"omega": 1, "c1": 1, "c2": 1, "k1": 2, "k2": 2, "K": 2, "P": 2}
"""Parameters that carry the unit of time, and to which power."""

FEW = settings(max_examples=40, deadline=None, derandomize=True)


def powers(low, high):
    """Numbers spread evenly over decades."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


SYSTEMS = st.builds(
    load_system,
    st.just("ssul-set6"),
    m2=powers(1.0, 3.0),
    k2=powers(1.0, 4.0),
    c2=powers(-2.0, 3.0),
    c1=powers(-2.0, 3.0),
    K=powers(3.0, 13.0),
    C=st.floats(-0.01, 0.1),
    omega=st.floats(3.0, 15.0),
)
SPEEDS = st.builds(lambda size, sign: size * sign, powers(-3.0, 0.0), st.sampled_from([-1.0, 1.0]))
"""Far above what positions in the fixed frame can tell: energies are made of these."""


FAINT = load_system("ssul-set6", m2=10.0, k2=10.0, c1=1.0, c2=1.0, K=1000.0, C=-1.1e-308, omega=3.0)
"""Begins in a contact whose depth is at the least of all numbers, and leaves it."""


def scaled(system, power, units):
    """Return a system whose unit of force, or of rates, is 2^power as large."""
    numbers = {**system.parameters, "K": system.K}
    return system.with_(**{n: numbers[n] * 2.0 ** (power * times) for n, times in units.items()})


def orbit_of(system, periods, **options):
    return simulate(system, periods, record=BOTH, **options)


def start_of(system, v1, v2):
    """Return a start in the air, or on the wall it is pressed onto."""
    return np.array([0.0, v1, system.rest - min(system.parameters["C"], 0.0), v2])


@pytest.mark.kernels
@FEW
@given(SYSTEMS, SPEEDS, SPEEDS, st.sampled_from(["exact", "rk4"]))
@example(FAINT, 1.0, 1.0, "exact")
def test_without_a_force_energy_never_rises(system, v1, v2, method):
    system = system.with_(P=0.0)
    start = start_of(system, v1, v2)
    section = simulate(system, 10, start=start, method=method).section
    energy = energy_of(system, np.vstack([start, section]))
    assert np.all(energy[1:] <= energy[:-1] + 1e-8 * energy[0])


@FEW
@given(SYSTEMS, SPEEDS, SPEEDS)
def test_without_damping_either_it_stays(system, v1, v2):
    system = system.with_(P=0.0, c1=0.0, c2=0.0)
    start = start_of(system, v1, v2)
    section = orbit_of(system, 10, start=start, **FINE).section
    energy = energy_of(system, np.vstack([start, section]))
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-10


@pytest.mark.kernels
@pytest.mark.parametrize(("units", "step"), [(FORCES, 10), (RATES, 1)], ids=["force", "time"])
@FEW
@given(SYSTEMS, st.integers(-20, 20), st.sampled_from(["exact", "rk4"]))
def test_no_unit_changes_a_bit(units, step, system, power, method):
    force, rate = (2.0 ** (step * power if units is one else 0) for one in (FORCES, RATES))
    one = simulate(system, 5, record=FULL, method=method)
    other = simulate(scaled(system, step * power, units), 5, record=FULL, method=method)
    np.testing.assert_array_equal(other.section, one.section * [1.0, rate, 1.0, rate])
    assert other.E1max == one.E1max * force * rate**2
    assert other.clearance == one.clearance
    for column, unit in (("touch", 1 / rate), ("release", 1 / rate), ("speed", rate), ("depth", 1)):
        np.testing.assert_array_equal(other.impacts[column], one.impacts[column] * unit)


@FEW
@given(SYSTEMS, SPEEDS, SPEEDS)
def test_without_damping_motion_runs_backwards(system, v1, v2):
    system = system.with_(c1=0.0, c2=0.0)
    start, mirror = start_of(system, v1, v2), np.array([1.0, -1.0, 1.0, -1.0])
    there = orbit_of(system, 1, start=start, **FINE)
    back = orbit_of(system, 1, start=there.state * mirror, **FINE)
    assert error_of(back.state * mirror, start, system.rest, there.section) < 1e-8
