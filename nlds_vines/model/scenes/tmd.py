"""Tuned mass damper (Figures 3 to 7): a linear spring and a dashpot, no wall."""

from nlds_vines.model.parameters import DAMPER, FORCING, STRUCTURE
from nlds_vines.model.scenes.base import Scene, Values


def rest(p: Values) -> float:
    """Return the spring's rest offset u = x2 - x1 = 0 [m]; the joint's force is -k2 u - c2 u'."""
    return 0.0


SCENE = Scene(
    kind="tmd",
    meaning="tuned mass damper: linear, without contact",
    own=STRUCTURE + DAMPER + FORCING,
    rest=rest,
)
