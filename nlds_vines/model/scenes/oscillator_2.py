"""Impact oscillator between two stops: one mass on a spring and a dashpot, -C_2 <= x <= C.

The equation and the base that may move are those of `oscillator`.  The second stop is that at -C_2.
"""

from typing import Any

from nlds_vines.model.parameters import FORCING, OSCILLATOR
from nlds_vines.model.scenes.base import Scene, Values
from nlds_vines.model.scenes.oscillator import gap_near


def gap_far(p: Values) -> Any:
    """Return minus the displacement at which the second stop is touched, C_2 [m]."""
    return p["C_2"]


def stops(p: Values) -> dict[str, Any]:
    """Return where the stops are drawn: x = C and x = -C_2 [m]."""
    return {"stop": p["C"], "second stop": -p["C_2"]}


SCENE = Scene(
    kind="oscillator-2",
    meaning="impact oscillator with a stop on either side",
    own=(*OSCILLATOR, "C", "C_2", *FORCING),
    gap_near=gap_near,
    gap_far=gap_far,
    struck={"near": "stop", "far": "second stop"},
    obstacle=stops,
    body="oscillator",
    second="far",
    components=("x", "v"),
)
