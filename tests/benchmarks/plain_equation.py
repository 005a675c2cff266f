"""Eq. (5) as every rival solves it: its right-hand side, its Jacobian, its events."""

import numpy as np
import pytest

from benchmarks.rivals.equation import (
    begin,
    constants,
    derivative,
    indicator,
    jacobian,
    slope,
    switch,
)
from nlds_vines.model.catalogue import load_system

SET6 = load_system("ssul-set6", omega=6.28)
BOTH = load_system("ssbl", omega=6.05)
TMD = load_system("tmd", omega=6.28)
ALONE = load_system("none", omega=6.28)

STATES = {
    "near": (0.03, -0.4, 0.02, 1.5),  # the damper is pressed 1 cm against the structure
    "far": (-0.3, 0.2, 0.15, -0.7),  # and 3 cm against the obstacle
    "between": (0.01, 0.3, 0.1, -0.2),
}


@pytest.mark.kernels
@pytest.mark.parametrize("where", STATES)
def test_the_derivative_is_equation_5(where):
    p, (x1, v1, x2, v2) = BOTH.parameters, STATES[where]
    gap = x2 - x1
    pressed = {"near": 0.01, "far": -0.03, "between": 0.0}[where]
    assert pressed == pytest.approx(max(0.0, -gap) - max(0.0, gap - p["D"] - p["C"]))
    contact = BOTH.K * abs(pressed) ** 1.5 * np.sign(pressed)  # on the damper, towards +x2
    joint = p["k2"] * (gap - p["D"]) + p["c2"] * (v2 - v1)
    phase = 0.7
    force = p["P"] * np.cos(phase) - p["k1"] * x1 - p["c1"] * v1 + joint - contact
    by_hand = v1, force / p["m1"], v2, (contact - joint) / p["m2"]
    found = derivative(constants(BOTH), phase, x1, v1, x2, v2)
    np.testing.assert_allclose(found, by_hand, rtol=1e-12)


@pytest.mark.parametrize("system", [TMD, ALONE], ids=["tmd", "none"])
def test_the_derivative_without_a_wall(system):
    p = {"m2": 1.0, "k2": 0.0, "c2": 0.0, **system.parameters}
    x1, v1, x2, v2 = 0.02, -0.3, -0.9, 0.8
    joint = p["k2"] * (x2 - x1) + p["c2"] * (v2 - v1)
    force = p["P"] * np.cos(0.7) - p["k1"] * x1 - p["c1"] * v1 + joint
    found = derivative(constants(system), 0.7, x1, v1, x2, v2)
    np.testing.assert_allclose(found, (v1, force / p["m1"], v2, -joint / p["m2"]), rtol=1e-12)


@pytest.mark.parametrize("where", STATES)
def test_the_jacobian_is_that_of_the_slope(where):
    p, y, h = constants(BOTH), np.array(STATES[where]), 1e-7
    columns = [(slope(0.1, y + h * e, p) - slope(0.1, y - h * e, p)) / (2 * h) for e in np.eye(4)]
    np.testing.assert_allclose(jacobian(0.1, y, p), np.array(columns).T, rtol=1e-6, atol=1e-5)


def test_a_state_without_end_stops_the_solver():
    with pytest.raises(FloatingPointError, match="no longer finite"):
        slope(0.0, np.array([np.inf, 0.0, 0.0, 0.0]), constants(SET6))


@pytest.mark.parametrize(
    ("where", "inside", "wall"), [("near", 1, 0), ("far", 1, 1), ("between", 0, 0)]
)
def test_a_piece_knows_its_wall(where, inside, wall):
    p, y, watch = constants(BOTH), np.array(STATES[where]), np.zeros(3)
    begin(p, y, watch)
    assert watch[0] == inside
    assert watch[1] == wall
    assert np.isnan(watch[2])
    assert (indicator(p, watch, 0.0, y) > 0.0) == bool(inside)


def test_a_switch_forgets_the_depth_of_its_moment():
    """On the wall the sign of the depth is round-off; the indicator has that of the speed."""
    p, watch = constants(BOTH), np.array([0.0, 0.0, np.nan])
    touch = np.array([0.02, 0.5, 0.02, -0.5])  # the structure is met at 1 m/s
    assert switch(p, 2.0, touch, watch)
    assert watch.tolist() == [1.0, 0.0, 2.0]
    assert indicator(p, watch, 2.0, touch) == pytest.approx(1.0)
    deeper = touch + np.array([1e-3, 0.0, 0.0, 0.0])
    assert indicator(p, watch, 2.5, deeper) == pytest.approx(1e-3 / 0.5)
    assert not switch(p, 3.0, touch, watch)
    assert watch.tolist() == [0.0, 0.0, 3.0]
