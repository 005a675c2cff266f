"""The primary structure alone (Figures 2, 3, 6, 7), with which every damper is compared."""

from nlds_vines.model.parameters import FORCING, STRUCTURE
from nlds_vines.model.scenes.base import Scene

SCENE = Scene(
    kind="none",
    meaning="primary structure alone, without a damper",
    parameter_names=STRUCTURE + FORCING,
    components=("x1", "v1"),
)
