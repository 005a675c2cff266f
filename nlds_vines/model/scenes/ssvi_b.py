"""Single-sided NES that must not reach the structure (Figure 1b): one obstacle, limit x1 < x2.

The kind `ssbl` without impacts on the structure: the design has to prevent them, and x1 >= x2 is
reported as a violation.
"""

from nlds_vines.model.scenes.base import Scene
from nlds_vines.model.scenes.ssbl import SCENE as SSBL

SCENE = Scene(
    kind="ssvi-b",
    meaning="single-sided NES: strikes an obstacle, must not reach the structure (x1 < x2)",
    parameter_names=SSBL.parameter_names,
    rest=SSBL.rest,
    gap_far=SSBL.gap_far,
    limit=SSBL.gap_near,
    obstacle=SSBL.obstacle,
)
