"""A ball on a vibrating table: no spring, gravity.

The table moves by Y cos(omega t), and x >= 0 is the height of the ball above it:

    x'' = -g + Y omega^2 cos(omega t) for x > 0

The table is the far wall, since it limits -x.  Its energy E1 is that of its motion, m v^2 / 2.
"""

from typing import Any

from nlds_vines.model.scenes.base import Scene, Values


def gap_far(p: Values) -> Any:
    """Return minus the height at which the table is touched: 0 [m]."""
    return 0.0 * p["m"]


def load(p: Values) -> Any:
    """Return the weight per mass, upward: -g [m/s^2]."""
    return -p["g"]


def table(p: Values) -> dict[str, Any]:
    """Return where the table is drawn: x = 0 [m]."""
    return {"table": 0.0 * p["m"]}


SCENE = Scene(
    kind="ball",
    meaning="a ball on a vibrating table",
    own=("m", "g", "Y", "omega"),
    gap_far=gap_far,
    struck={"near": "table", "far": "table"},
    obstacle=table,
    load=load,
    body="ball",
    components=("x", "v"),
)
