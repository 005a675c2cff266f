"""The primary structure alone (Figures 2, 3, 6, 7): the reference for every damper."""

from nlds_vines.parameters import FORCING, STRUCTURE
from nlds_vines.scenes.base import Scene

SCENE = Scene(
    kind="none",
    meaning="primary structure alone, without a damper",
    own=STRUCTURE + FORCING,
)
