"""Single-sided NES with a weaker constraint (Figure 1c): one obstacle, limit x1 - x2 < L.

As the kind `ssvi-b`, but the damper may pass the structure by up to L, to the shortening r = D + L.
"""

from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes.base import Scene
from nlds_vines.model.scenes.ssbl import SCENE as SSBL

SCENE = Scene(
    kind="ssvi-c",
    meaning="single-sided NES: strikes an obstacle, may pass the structure by L at most",
    parameter_names=(*STRUCTURE, *DAMPER, "C", "D", "L", *FORCING),
    rest=SSBL.rest,
    gap_far=SSBL.gap_far,
    limit=lambda p: p["D"] + p["L"],
    obstacle=lambda p: {"limit": -p["L"], "obstacle": p["D"] + p["C"]},
)
