"""The parts of a scene as the kernels take them."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import numpy as np

from nlds_vines.kernels import laws
from nlds_vines.kernels.cells.cycles import NUMBERS_OF_CYCLE, Traced
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.numerics.deciding import says
from nlds_vines.kernels.scene.scene import Ground, Parts
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.solver_settings import Settings

# types whose numbers kernels do not read: a ground with walls that limit the structure, and walls
# by the name of the law and by whether a damping constant adds to it (`is_damped`)
GROUND = Ground(*[0.0] * len(Ground._fields))
_FILES = [import_module(f"{laws.__name__}.{file.name}") for file in iter_modules(laws.__path__)]
WALLS: dict[tuple[str, bool], Any] = {
    law: wall for file in _FILES for law, wall in getattr(file, "SORTS", {}).items()
}


def parts_of(method: str, scene: Scene, settings: Settings | None = None) -> Parts:
    """Return the `Parts` of a scene for a method, by default with the settings of scans.

    An absent part is None and absent from the machine code.
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


def room_for(n: int, size: int, count: int, width: int = 4, walls: int = 2) -> Traced:
    """Return the buffers for one orbit of n periods and `count` free parameters.

    `width` is the number of numbers of a section.
    """
    return Traced(
        np.empty((n, width)),
        np.zeros(walls, np.int64),
        np.empty((size, size)),
        np.empty((count, width)),
        np.empty((size, 2)),
        np.empty(NUMBERS_OF_CYCLE),
    )


def unit_norms(cell: Any, size: int) -> np.ndarray:
    """Return the energy norms sqrt(2 E) of the `size` unit states (x1, v1, r, s)."""
    with_damper = cell.k1, cell.m1 + cell.m2, cell.k2, cell.m2
    return np.sqrt(with_damper if size == 4 else (cell.k1, cell.m1))
