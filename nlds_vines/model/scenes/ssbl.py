"""Single-sided bilateral NES (Figure 1a): the structure on one side, the obstacle on the other.

The spring acts on the damper with -k2 (u - D), u = x2 - x1, so that it rests at u = D.  The
structure is touched at u = 0, where the spring is shorter by r = D, and pushes the damper in +x2;
the obstacle is touched at u = D + C, where it is longer by -r = C, and pushes it in -x2.  Both
contact forces follow equation (2).
"""

from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes.base import Scene

SCENE = Scene(
    kind="ssbl",
    meaning="single-sided bilateral NES: strikes the structure and an obstacle",
    parameter_names=(*STRUCTURE, *DAMPER, "C", "D", *FORCING),
    rest=lambda p: p["D"],
    gap_near=lambda p: p["D"],
    gap_far=lambda p: p["C"],
    obstacle=lambda p: {"structure": 0.0 * p["D"], "obstacle": p["D"] + p["C"]},
    struck={"near": "structure", "far": "obstacle"},
    second="near",
)
