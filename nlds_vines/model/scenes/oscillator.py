"""Impact oscillator: one mass on a spring and a dashpot, and a stop at x = C.

m x'' + c x' + k x = P cos(omega t) for x < C.  The textbook example of an impacting system.  Where
spring, dashpot and stop stand on a base that moves by Y cos(omega t), x counts from the base, and
P = m Y omega^2.  Its energy is E1.
"""

from typing import Any

from nlds_vines.model.parameters import FORCING, OSCILLATOR
from nlds_vines.model.scenes.base import Scene, Values


def gap_near(p: Values) -> Any:
    """Return the displacement at touch, C [m]."""
    return p["C"]


def stop(p: Values) -> dict[str, Any]:
    """Return where the stop is drawn: x = C [m]."""
    return {"stop": p["C"]}


SCENE = Scene(
    kind="oscillator",
    meaning="impact oscillator: one mass with a stop",
    own=(*OSCILLATOR, "C", *FORCING),
    gap_near=gap_near,
    struck={"near": "stop", "far": "stop"},
    obstacle=stop,
    body="oscillator",
    components=("x", "v"),
)
