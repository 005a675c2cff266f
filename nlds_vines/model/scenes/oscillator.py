"""Impact oscillator: one mass on a spring and a dashpot, and a stop at x = C.

m x'' + c x' + k x = P cos(omega t) for x < C.  The textbook example of an impacting system.  If
spring, dashpot and stop stand on a base that moves by Y cos(omega t), x counts from the base, and
P = m Y omega^2.  Its energy is E1.
"""

from nlds_vines.model.parameters import FORCING, OSCILLATOR
from nlds_vines.model.scenes.base import Scene

SCENE = Scene(
    kind="oscillator",
    meaning="impact oscillator: one mass with a stop",
    parameter_names=(*OSCILLATOR, "C", *FORCING),
    gap_near=lambda p: p["C"],
    struck={"near": "stop", "far": "stop"},
    obstacle=lambda p: {"stop": p["C"]},
    body="oscillator",
    components=("x", "v"),
)
