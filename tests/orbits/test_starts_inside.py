"""Starts inside a wall are counted, with the deepest, by every command that takes starts."""

import numpy as np
import pytest

from nlds_vines import load_system
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.orbits.starts import given_states, starts_inside

PLANE = ["bifurcation", "--set", "omega=7.7", "--vary", "v2_0=-1:1:3", "--record", "attractor"]
PRELOADED = ["--system", "ssul-set6", "--set", "C=-0.01"]
TUNING = ["tuning", "--system", "ssul-set6", "--free", "k2=100:900", "--impulse", "10"]
ONE = "ssul-set6: 1 of 1 starts is inside a wall, 10 mm deep at most"


@pytest.mark.parametrize(
    ("command", "line"),
    [
        ([*PLANE, "--vary", "x2_0=-0.06:0.1:5"], "12 of 15 starts are inside a wall, 160 mm deep"),
        ([*PLANE, "--vary", "x2_0=0.1:0.26:5"], ""),
        ([*PLANE, "--start", "0,0,0.05,0"], "3 of 3 starts are inside a wall, 50 mm deep at most"),
        ([*PLANE, "--start", "0.01,0,0.1,0"], "3 of 3 starts are inside a wall, 10 mm deep"),
        (["bifurcation", "--start", "random:50"], ""),
        (
            [
                "bifurcation",
                "--vary",
                "omega=7:8:11",
                "--vary",
                "C=-0.01:0.01:3",
                "--start",
                "both",
            ],
            "11 of 22 starts are inside a wall, 10 mm deep at most",
        ),
        (
            ["bifurcation", "--system", "bouncing-ball", "--vary", "x_0=-1:1:5"],
            "2 of 5 starts are inside a wall and put on it, 1000 mm deep at most",
        ),
        (["portrait", *PRELOADED], ONE),
        (["response-history", *PRELOADED, "--impulse", "10"], ONE),
        (
            [
                "response-history",
                "--system",
                "ssul-set6",
                "--start",
                "0,0,0.09,0",
                "--vary",
                "C=0:0.02:5",
            ],
            "ssul-set6: 5 of 5 starts are inside a wall, 10 mm deep at most",
        ),
        (
            [*TUNING, "--start", "0,0,0.05,0"],
            "ssul-set6: 1 of 1 starts is inside a wall, 50 mm deep at most",
        ),
        (["response-curves", *PRELOADED, "--vary", "omega=6:7:3"], "Set 6: 3 of 3 starts are"),
    ],
)
def test_a_command_counts_starts_inside_a_wall_and_names_the_deepest(command, line, answer, here):
    lines = [one for one in answer(*command, "--dry-run").splitlines() if "inside a wall" in one]
    assert len(lines) == bool(line)
    assert line in "".join(lines)


def test_the_line_is_that_of_the_states_of_the_kernels():
    """The same depths from the states and walls that kernels have."""
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


def test_a_scene_without_a_wall_has_no_start_inside():
    system = load_system("tmd")
    assert starts_inside(system.scene, system.parameters, {"x2": 1e9}) == []
