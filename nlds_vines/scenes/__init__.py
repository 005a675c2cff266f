"""The scenes, one kind of damper per file; a new kind is a new file and a line here."""

from collections.abc import Mapping

from nlds_vines.scenes import none, ssul, tmd
from nlds_vines.scenes.base import Scene

SCENES: Mapping[str, Scene] = {module.SCENE.kind: module.SCENE for module in (none, tmd, ssul)}
"""All scenes by kind."""

__all__ = ["SCENES", "Scene"]
