"""How finely a method computes, and starts inside a wall: what may be asked for, what is told."""

import numpy as np
import pytest

from nlds_vines import load_scan, load_system
from nlds_vines.orbits.simulation import start_state
from nlds_vines.orbits.solver_settings import (
    FINENESS,
    LEAST_STEPS,
    LEAST_TOLERANCE,
    MOST_TOLERANCE,
    PERIOD_STEPS,
    SHARE,
    TOLERANCE,
    TOLERANCES,
    Settings,
    checked_tolerance,
    chosen_settings,
)
from nlds_vines.orbits.starts import given_states, starts_inside


def test_presets_are_numbers_by_another_name():
    assert TOLERANCES == {"draft": 1e-6, "standard": 1e-9, "fine": 1e-12}
    for name, value in TOLERANCES.items():
        assert checked_tolerance(name) == checked_tolerance(value) == value
    for value in (LEAST_TOLERANCE, MOST_TOLERANCE, np.float64(1e-7), 5e-4):
        assert type(checked_tolerance(value)) is float
        assert checked_tolerance(value) == value
    assert (LEAST_TOLERANCE, MOST_TOLERANCE) == (1e-13, 1e-3)
    assert chosen_settings("exact", {}).tolerance == TOLERANCE == TOLERANCES["standard"]
    # contacts are granted a share of it, as several may follow each other in a period
    settings = Settings(1e-6)
    assert settings.contact_tolerance == settings.stepped_to == SHARE * 1e-6
    assert Settings(1e-6, contact_steps=28.0).stepped_to == np.inf  # as an expert wants them
    assert {Settings(10.0**-k).steps for k in range(3, 14)} == {LEAST_STEPS}


def test_every_method_has_its_own_settings(error_of):
    settings = {"tolerance": 1e-6, "nodes": 9, "contact_steps": 20, "period_steps": 64}
    for name in FINENESS:
        method, other = ("rk4", "exact") if name == "period_steps" else ("exact", "rk4")
        assert chosen_settings(method, {name: settings[name]}) != chosen_settings(method, {})
        line = error_of(chosen_settings, other, {name: settings[name]})
        assert line.startswith(f"{name} is of method '{method}'; '{other}' has ")
        assert chosen_settings(other, {name: None}) == chosen_settings(other, {})
    assert chosen_settings("rk4", {"period_steps": 64}) == Settings.rk4(64.0)
    assert chosen_settings("rk4", {}) == Settings.rk4(PERIOD_STEPS)


@pytest.mark.parametrize(
    ("below", "above", "expected"),
    [
        ({"tolerance": 1e-6}, {}, {"tolerance": 1e-6}),
        ({"tolerance": 1e-6}, {"tolerance": 1e-12}, {"tolerance": 1e-12}),
        ({"tolerance": 1e-6, "periods": 3}, {"method": "rk4"}, {"method": "rk4", "periods": 3}),
        ({"tolerance": 1e-6}, {"method": "exact"}, {"method": "exact", "tolerance": 1e-6}),
        ({"method": "rk4", "period_steps": 64}, {"method": "exact"}, {"method": "exact"}),
        ({"nodes": 8, "contact_steps": 20}, {"tolerance": 1e-6}, {"tolerance": 1e-6}),
        ({"nodes": 8}, {"contact_steps": 20}, {"nodes": 8, "contact_steps": 20}),
        ({"nodes": 8}, {"transient": 5}, {"nodes": 8, "transient": 5}),
    ],
)
def test_what_is_asked_last_counts(below, above, expected):
    one = {"system": "tmd", "vary": {"omega": {"values": [6.0]}}}
    scan, other = (
        load_scan(one | {"sampling": low}, {"sampling": high})
        for low, high in ((below, above), (expected, {}))
    )
    assert scan.document()["sampling"] == other.document()["sampling"]
    assert (scan.method, scan.settings) == (other.method, other.settings)
    read_already = load_scan(one | {"sampling": below})
    assert load_scan(read_already, {"sampling": above}) == other


PLANE = "bifurcation --set omega=7.7 --vary v2_0=-1:1:3 --record attractor"
BALL = "bifurcation --system bouncing-ball --vary x_0=-1:1:5"
PRELOADED = "--system ssul-set6 --set C=-0.01"
TUNING = "tuning --system ssul-set6 --free k2=100:900 --impulse 10 --start 0,0,0.05,0"
HISTORIES = "response-history --system ssul-set6 --start 0,0,0.09,0 --vary C=0:0.02:5"
ONE = "ssul-set6: 1 of 1 starts is inside a wall, 10 mm deep at most"


@pytest.mark.parametrize(
    ("command", "line"),
    [
        (f"{PLANE} --vary x2_0=-0.06:0.1:5", "12 of 15 starts are inside a wall, 160 mm deep"),
        (f"{PLANE} --vary x2_0=0.1:0.26:5", ""),
        (f"{PLANE} --start 0,0,0.05,0", "3 of 3 starts are inside a wall, 50 mm deep at most"),
        (f"{PLANE} --start 0.01,0,0.1,0", "3 of 3 starts are inside a wall, 10 mm deep"),
        ("bifurcation --start random:50", ""),
        (
            "bifurcation --vary omega=7:8:11 --vary C=-0.01:0.01:3 --start both",
            "11 of 22 starts are inside a wall, 10 mm deep at most",
        ),
        (BALL, "2 of 5 starts are inside a wall and put on it, 1000 mm deep at most"),
        (f"portrait {PRELOADED}", ONE),
        (f"response-history {PRELOADED} --impulse 10", ONE),
        (HISTORIES, "ssul-set6: 5 of 5 starts are inside a wall, 10 mm deep at most"),
        (TUNING, "ssul-set6: 1 of 1 starts is inside a wall, 50 mm deep at most"),
        (f"response-curves {PRELOADED} --vary omega=6:7:3", "Set 6: 3 of 3 starts are"),
    ],
)
def test_a_command_counts_starts_inside_a_wall_and_names_the_deepest(command, line, answer, here):
    text = answer(*command.split(), "--dry-run")
    lines = [one for one in text.splitlines() if "inside a wall" in one]
    assert len(lines) == bool(line)
    assert line in "".join(lines)


def test_the_line_is_that_of_the_states_of_the_kernels_where_there_is_a_wall():
    axes = {name: {"start": -0.3, "stop": 0.3, "num": 7} for name in ("x1_0", "x2_0")}
    for name in ("ssul-set6", "ssbl"):
        scan = load_scan(name, {"vary": axes, "set": {"omega": 7.0}})
        cells = scan.cells().ravel()
        where = np.unravel_index(np.arange(cells.size), scan.shape)
        states = given_states(cells, scan.start, scan.initial(where), scan.system.scene)
        depth = states[:, 2] - cells["near"]
        if "far" in scan.system.scene.walls:
            depth = np.maximum(depth, -states[:, 2] - cells["far"])
        (line,) = scan.starts_inside()
        most = f"{1e3 * depth.max():.4g} mm deep at most"
        assert line == f"{(depth > 1e-12).sum()} of 49 starts are inside a wall, {most}"
    # a scene without a wall has no start inside
    system = load_system("tmd")
    assert starts_inside(system.scene, system.parameters, {"x2": 1e9}) == []


def test_a_start_on_a_rigid_wall_is_on_it_however_far_the_structure_is_displaced(error_of):
    """A gap of 0.1 mm at 5 m: r = x1 - x2 + rest has the round-off of x1."""
    system = load_system("ssbl", law="restitution", D=1e-4, e=0.0)
    near, rest = float(system.cell.near), float(system.cell.rest)
    for x1 in np.linspace(-5.0, 5.0, 101):
        on_wall = x1, 0.0, x1 - near + rest, 0.0
        start_state(system, rest, on_wall)
        state = dict(zip(system.scene.components, on_wall, strict=True))
        assert starts_inside(system.scene, system.parameters, state) == []
    inside = 5.0, 0.0, 5.0 - near + rest - 1e-9, 0.0
    assert "inside the" in error_of(start_state, system, rest, inside)
