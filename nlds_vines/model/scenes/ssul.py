"""Single-sided unilateral NES (Figure 1d): one obstacle, free to move away from it.

By equation (5) the spring acts on the damper with -k2 (u - V - C), u = x2 - x1.  By equation (3)
the contact is closed while z = V - u > 0, and pushes the damper in +x2.
"""

from typing import Any

from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes.base import Scene, Values


def rest(p: Values) -> Any:
    """Return the spring's rest offset u = V + C [m]: the start state of equation (5)."""
    return p["V"] + p["C"]


def gap_near(p: Values) -> Any:
    """Return the shortening r at touch, C [m]: equation (3) reads z = V - u = r - C."""
    return p["C"]


def obstacle(p: Values) -> dict[str, Any]:
    """Return where the obstacle is drawn: u = V [m] (Figure 1d)."""
    return {"obstacle": p["V"]}


SCENE = Scene(
    kind="ssul",
    meaning="single-sided unilateral NES: one obstacle, free to move away from it",
    own=(*STRUCTURE, *DAMPER, "C", "V", *FORCING),
    rest=rest,
    gap_near=gap_near,
    obstacle=obstacle,
)
