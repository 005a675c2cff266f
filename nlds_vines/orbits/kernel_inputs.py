"""What the kernels take: the parts of a scene and the numbers of a cell."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import numpy as np

from nlds_vines.kernels import laws
from nlds_vines.kernels.cells.cells import prepared_cell
from nlds_vines.kernels.impact.arc import make_arc
from nlds_vines.kernels.motion.flight import PERIOD, cells_of, grid_of
from nlds_vines.kernels.numerics.deciding import says
from nlds_vines.kernels.orbit.variations import Flow, flow_of
from nlds_vines.kernels.scene.scene import Ground, Parts, damper_of, structure_under
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System
from nlds_vines.orbits.solver_settings import Settings

GROUND = Ground(*[0.0] * len(Ground._fields))
"""What walls stand on that limit the structure itself: of its numbers, kernels look at none."""

_FILES = [import_module(f"{laws.__name__}.{file.name}") for file in iter_modules(laws.__path__)]

WALLS: dict[tuple[str, bool], Any] = {
    law: wall for file in _FILES for law, wall in getattr(file, "SORTS", {}).items()
}
"""A wall by the name of its law, and by whether that is damped by a constant more (`is_damped`).

Of its numbers, kernels look at none.
"""


def wall_of(scene: Scene, name: str) -> Any:
    """Return a wall of the law at the near or far wall of a scene, None where it has none."""
    if name not in scene.walls:
        return None
    return WALLS[scene.law_at(name).name, scene.is_damped(name)]


def parts_of(method: str, scene: Scene, settings: Settings | None = None) -> Parts:
    """Return the `Parts` that tell the kernels which parts there are, and how fine a method is.

    What is absent is None, and then absent from the machine code. By default, the `settings` are
    those of a scan by the method.
    """
    settings = Settings.of(method) if settings is None else settings
    near, far = wall_of(scene, "near"), wall_of(scene, "far")
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


def cell_of(system: System) -> Any:
    """Return the kernels' record of one system."""
    return np.atleast_1d(system.cells()).view(np.recarray)[0]


def flow_on(system: System, method: str = "exact", settings: Settings | None = None) -> Flow:
    """Return the `Flow` of one system: its map from section to section, with the derivative."""
    parts, cell = parts_of(method, system.scene, settings), cell_of(system)
    ps, damper = structure_under(parts.load, cell), damper_of(parts.damper, cell)
    n = cells_of(ps, damper)
    return flow_of(prepared_cell(parts, cell, ps, damper, n, 1, PERIOD), grid_of(ps, damper, n))
