"""Walls of different laws, mirrored stops, and a base that moves."""

import numpy as np
import pytest
from support import BOTH

from nlds_vines import load_system, simulate
from nlds_vines.model.system import System

STEEP = 3e7  # K of the powers


@pytest.mark.kernels
def test_each_wall_has_its_own_law():
    """The structure's contact as a power of 3/2 is that of Hertz; another changes the orbit."""
    plain = load_system("ssbl", K=STEEP)
    same = plain.with_(law_2="power", K_2=STEEP, exponent_2=1.5)
    rigid = plain.with_(law_2="restitution", e_2=1.0)
    stiff = plain.with_(law_2="hertz", K_2=1e16)
    record = BOTH
    a, b, c, d = (
        simulate(s, 10, record=record, tolerance=1e-12) for s in (plain, same, rigid, stiff)
    )
    assert set(a.impacts["wall"]) == {"structure", "obstacle"}
    np.testing.assert_allclose(b.section, a.section, rtol=0, atol=1e-9)
    assert np.abs(c.section - a.section).max() > 1e-4
    np.testing.assert_allclose(c.section[:3], d.section[:3], rtol=0, atol=1e-5)
    of = c.impacts["wall"] == "structure"
    assert np.isinf(c.impacts["force"][of]).all()
    assert np.isfinite(c.impacts["force"][~of]).all()


@pytest.mark.kernels
def test_the_second_stop_is_the_mirror_of_the_first():
    """Half a period later the force is the opposite: the mirror runs the mirrored orbit."""
    numbers = {"m": 1.0, "k": 1.0, "c": 0.1, "C": 0.4, "C_2": 0.5, "P": 0.7, "omega": 1.3}
    one = System(
        "oscillator-2", {**numbers, "e": 0.7, "kc_2": 50.0}, law="restitution", law_2="linear"
    )
    other = System(
        "oscillator-2", {**numbers, "C": 0.5, "C_2": 0.4, "kc": 50.0, "e_2": 0.7},
        law="linear", law_2="restitution",
    )  # fmt: skip
    record = (*BOTH, "trajectory")
    a = simulate(one, 40, start=(0.1, 0.2), record=record, samples=2)
    half = a.trajectory[0]  # the state at T / 2
    b = simulate(other, 39, start=-half, record=record, samples=2)
    assert set(a.impacts["wall"]) == {"stop", "second stop"}
    np.testing.assert_allclose(b.trajectory[1::2], -a.trajectory[2:-1:2], rtol=0, atol=1e-9)


def test_a_base_that_moves_is_a_force():
    numbers = {"m": 2.0, "k": 3.0, "c": 0.1, "C": 0.4, "omega": 1.3, "e": 0.7}
    shaken = System("oscillator", {**numbers, "Y": 0.2}, law="restitution")
    forced = System("oscillator", {**numbers, "P": 2.0 * 0.2 * 1.3**2}, law="restitution")
    np.testing.assert_allclose(
        simulate(shaken, 20).section, simulate(forced, 20).section, rtol=0, atol=1e-13
    )
    assert shaken.with_(P=1.0).parameters["P"] == 1.0
