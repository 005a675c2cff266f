"""Single-sided NES with a weaker constraint (Figure 1c): one obstacle, limit x1 - x2 < L.

As the kind `ssvi-b`, but the damper may pass the structure by up to L.
"""

from typing import Any

from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes import ssbl
from nlds_vines.model.scenes.base import Scene, Values


def limit(p: Values) -> Any:
    """Return the shortening r = D - u at which x1 - x2 = L: D + L [m]."""
    return p["D"] + p["L"]


def obstacle(p: Values) -> dict[str, Any]:
    """Return where limit and obstacle are drawn (Figure 1c): u = -L and u = D + C [m]."""
    return {"limit": -p["L"], "obstacle": p["D"] + p["C"]}


SCENE = Scene(
    kind="ssvi-c",
    meaning="single-sided NES: strikes an obstacle, may pass the structure by L at most",
    own=(*STRUCTURE, *DAMPER, "C", "D", "L", *FORCING),
    rest=ssbl.rest,
    gap_far=ssbl.to_obstacle,
    limit=limit,
    obstacle=obstacle,
)
