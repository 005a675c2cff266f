"""The parts of a scene as the kernels take them."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import numpy as np

from nlds_vines.kernels import laws
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.numerics.deciding import says
from nlds_vines.kernels.scene.scene import Ground, Parts
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.solver_settings import Settings

GROUND = Ground(*[0.0] * len(Ground._fields))
"""The type of a ground with walls that limit the structure; kernels do not read its numbers."""

_FILES = [import_module(f"{laws.__name__}.{file.name}") for file in iter_modules(laws.__path__)]

WALLS: dict[tuple[str, bool], Any] = {
    law: wall for file in _FILES for law, wall in getattr(file, "SORTS", {}).items()
}
"""The types of walls, by the name of the law and by whether a damping constant adds to it
(`is_damped`); kernels do not read their numbers."""


def parts_of(method: str, scene: Scene, settings: Settings | None = None) -> Parts:
    """Return the `Parts` of a scene for a method.

    An absent part is None and absent from the machine code.  The default `settings` are those of
    scans.
    """
    settings = Settings.of(method) if settings is None else settings
    near, far = (
        WALLS[scene.law_at(name).name, scene.is_damped(name)] if name in scene.walls else None
        for name in ("near", "far")
    )
    short = says(near, "SHORT_IMPACTS") or says(far, "SHORT_IMPACTS")
    return Parts(
        rk4=None if method == "exact" else True,
        damper=True if scene.damper else GROUND if scene.grounded else None,
        near=near,
        far=far,
        apart=None if scene.law_2 is None else True,
        load=None if scene.load is None else True,
        arc=make_arc(settings.contact_tolerance, settings.nodes) if short else None,
        contact_steps=float(settings.steps),
        contact_tolerance=float(settings.stepped_to),
        period_steps=float(settings.period_steps),
    )


def unit_norms(cell: Any, size: int) -> np.ndarray:
    """Return the energy norms sqrt(2 E) of the `size` unit states (x1, v1, r, s)."""
    with_damper = cell.k1, cell.m1 + cell.m2, cell.k2, cell.m2
    return np.sqrt(with_damper if size == 4 else (cell.k1, cell.m1))
