"""The scenes, one kind of damper per file; a new kind is a new file and a line here."""

from collections.abc import Mapping

from nlds_vines.model.scenes import none, ssbl, ssul, ssvi_b, ssvi_c, tmd
from nlds_vines.model.scenes.base import Scene

_MODULES = (none, tmd, ssul, ssbl, ssvi_b, ssvi_c)

SCENES: Mapping[str, Scene] = {module.SCENE.kind: module.SCENE for module in _MODULES}
"""All scenes by kind."""

__all__ = ["SCENES", "Scene"]
