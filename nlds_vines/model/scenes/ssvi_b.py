"""Single-sided NES that must not reach the structure (Figure 1b): one obstacle, limit x1 < x2.

The kind `ssbl` without impacts on the structure: the design has to prevent them, and x1 >= x2 is
reported as a violation.
"""

from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes.base import Scene
from nlds_vines.model.scenes.ssbl import obstacle, rest, to_obstacle, to_structure

SCENE = Scene(
    kind="ssvi-b",
    meaning="single-sided NES: strikes an obstacle, must not reach the structure (x1 < x2)",
    own=(*STRUCTURE, *DAMPER, "C", "D", *FORCING),
    rest=rest,
    gap_far=to_obstacle,
    limit=to_structure,
    obstacle=obstacle,
)
