"""The scenes: the kinds of systems, a file each.  A new kind is a new file and a name below.

In reading order:

    base          what a scene is made of
    none          the structure alone
    tmd           tuned mass damper
    ssul          single-sided unilateral NES: one obstacle
    ssbl          single-sided bilateral NES: obstacle and structure
    ssvi_b        one obstacle; the damper must not reach the structure
    ssvi_c        one obstacle; the damper may pass the structure by a given length
    oscillator    one mass with a stop, and no damper
    oscillator_2  the same with a stop on either side
    ball          a ball on a vibrating table

NES: nonlinear energy sink.
"""

from collections.abc import Mapping

from nlds_vines.model.parameters import HERTZ
from nlds_vines.model.scenes import (
    ball,
    none,
    oscillator,
    oscillator_2,
    ssbl,
    ssul,
    ssvi_b,
    ssvi_c,
    tmd,
)
from nlds_vines.model.scenes.base import BASES, FOOT, Scene

_MODULES = (none, tmd, ssul, ssbl, ssvi_b, ssvi_c, oscillator, oscillator_2, ball)

SCENES: Mapping[str, Scene] = {module.SCENE.kind: module.SCENE for module in _MODULES}
"""All scenes by kind."""


def scene_of(key: str) -> Scene:
    """Return the scene of a `Scene.key`."""
    kind, law, law_2, *optional = [*key.split("/"), "", ""][: max(3, key.count("/") + 1)]
    names = [*optional, *BASES[:1]] if kind.endswith(FOOT) else optional
    return SCENES[kind.removesuffix(FOOT)].under(law or HERTZ.name, law_2, names)


__all__ = ["SCENES", "Scene", "scene_of"]
