"""Impact oscillator between two stops: one mass on a spring and a dashpot, -C_2 <= x <= C.

The equation and the base that may move are those of `oscillator`.  The second stop is that at -C_2.
"""

from nlds_vines.model.parameters import FORCING, OSCILLATOR
from nlds_vines.model.scenes.base import Scene

SCENE = Scene(
    kind="oscillator-2",
    meaning="impact oscillator with a stop on either side",
    parameter_names=(*OSCILLATOR, "C", "C_2", *FORCING),
    gap_near=lambda p: p["C"],
    gap_far=lambda p: p["C_2"],
    struck={"near": "stop", "far": "second stop"},
    obstacle=lambda p: {"stop": p["C"], "second stop": -p["C_2"]},
    body="oscillator",
    second="far",
    components=("x", "v"),
)
