"""Single-sided unilateral NES (Figure 1d): one obstacle, free to move away from it.

By equation (5) the spring acts on the damper with -k2 (u - V - C), u = x2 - x1, so that it rests at
u = V + C.  By equation (3) the contact is closed while z = V - u = r - C > 0, r being the spring's
shortening, and pushes the damper in +x2.
"""

from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes.base import Scene

SCENE = Scene(
    kind="ssul",
    meaning="single-sided unilateral NES: one obstacle, free to move away from it",
    parameter_names=(*STRUCTURE, *DAMPER, "C", "V", *FORCING),
    rest=lambda p: p["V"] + p["C"],
    gap_near=lambda p: p["C"],
    obstacle=lambda p: {"obstacle": p["V"]},
)
