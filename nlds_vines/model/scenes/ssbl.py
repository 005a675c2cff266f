"""Single-sided bilateral NES (Figure 1a): the structure on one side, the obstacle on the other.

The spring acts on the damper with -k2 (u - D), u = x2 - x1.  The structure is touched at u = 0 and
pushes the damper in +x2; the obstacle is touched at u = D + C and pushes it in -x2.  Both contact
forces follow equation (2).
"""

from typing import Any

from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes.base import Scene, Values


def rest(p: Values) -> Any:
    """Return the spring's rest offset u = D [m]."""
    return p["D"]


def to_structure(p: Values) -> Any:
    """Return the shortening r = D - u at which the damper is at the structure, u = 0: D [m]."""
    return p["D"]


def to_obstacle(p: Values) -> Any:
    """Return the lengthening -r = u - D at which the obstacle is touched, u = D + C: C [m]."""
    return p["C"]


def obstacle(p: Values) -> dict[str, Any]:
    """Return where structure and obstacle are drawn (Figure 1a): u = 0 and u = D + C [m]."""
    return {"structure": 0.0 * p["D"], "obstacle": p["D"] + p["C"]}


SCENE = Scene(
    kind="ssbl",
    meaning="single-sided bilateral NES: strikes the structure and an obstacle",
    own=(*STRUCTURE, *DAMPER, "C", "D", *FORCING),
    rest=rest,
    gap_near=to_structure,
    gap_far=to_obstacle,
    obstacle=obstacle,
    struck={"near": "structure", "far": "obstacle"},
    second="near",
)
