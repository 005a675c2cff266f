"""A ball on a vibrating table: no spring, gravity.

The table moves by Y cos(omega t), and x >= 0 is the height of the ball above it:

    x'' = -g + Y omega^2 cos(omega t) for x > 0

The table is the far wall, since it limits -x.  Its energy E1 is that of its motion, m v^2 / 2.
"""

from nlds_vines.model.scenes.base import Scene

SCENE = Scene(
    kind="ball",
    meaning="a ball on a vibrating table",
    parameter_names=("m", "g", "Y", "omega"),
    gap_far=lambda p: 0.0 * p["m"],
    struck={"near": "table", "far": "table"},
    obstacle=lambda p: {"table": 0.0 * p["m"]},
    load=lambda p: -p["g"],
    body="ball",
    components=("x", "v"),
)
