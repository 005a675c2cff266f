"""Tuned mass damper (Figures 3 to 7): a linear spring and a dashpot, no wall.

The joint's force on the damper is -k2 u - c2 u', u = x2 - x1, so that the spring rests at u = 0.
"""

from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes.base import Scene

SCENE = Scene(
    kind="tmd",
    meaning="tuned mass damper: linear, without contact",
    parameter_names=STRUCTURE + DAMPER + FORCING,
    rest=lambda p: 0.0,
)
