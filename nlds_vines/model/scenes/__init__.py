"""The scenes: the kinds of systems, a file each.  A new kind is a new file and a name below.

In reading order:

    base      what a scene is made of
    none      the structure alone
    tmd       tuned mass damper
    ssul      single-sided unilateral NES: one obstacle
    ssbl      single-sided bilateral NES: obstacle and structure
    ssvi_b    one obstacle; the damper must not reach the structure
    ssvi_c    one obstacle; the damper may pass the structure by a given length
    oscillator   one mass with a stop, and no damper

NES: nonlinear energy sink.
"""

from collections.abc import Mapping

from nlds_vines.model.scenes import none, oscillator, ssbl, ssul, ssvi_b, ssvi_c, tmd
from nlds_vines.model.scenes.base import Scene

_MODULES = (none, tmd, ssul, ssbl, ssvi_b, ssvi_c, oscillator)

SCENES: Mapping[str, Scene] = {module.SCENE.kind: module.SCENE for module in _MODULES}
"""All scenes by kind."""

__all__ = ["SCENES", "Scene"]
