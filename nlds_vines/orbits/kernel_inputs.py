"""What the kernels take: the parts of a scene and the numbers of a cell."""

from __future__ import annotations

from typing import Any

import numpy as np

from nlds_vines.kernels.arguments import Parts
from nlds_vines.kernels.cells import prepared_cell
from nlds_vines.kernels.flight import cells_of, grid_of
from nlds_vines.kernels.scene import Ground, RigidWall, Wall, damper_of, structure_of
from nlds_vines.kernels.variations import Flow, flow_of
from nlds_vines.model.laws import HERTZ
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System
from nlds_vines.orbits.hertz_arc import make_arc
from nlds_vines.orbits.settings import Settings

GROUND = Ground(*[0.0] * len(Ground._fields))
"""What walls stand on that limit the structure itself: of its numbers, kernels look at none."""

WALLS = {"hertz": Wall(0.0, 0.0, 0.0, 0.0), "restitution": RigidWall(0.0, 0.0)}
"""A wall by the name of its law: of its numbers, kernels look at none."""


def parts_of(method: str, scene: Scene, settings: Settings | None = None) -> Parts:
    """Return the `Parts` that tell the kernels which parts there are, and how fine a method is.

    What is absent is None, and then absent from the machine code. By default, the `settings` are
    those of a scan by the method.
    """
    settings = Settings.of(method) if settings is None else settings
    wall, hertz = WALLS[scene.law.name], scene.law == HERTZ and scene.walls
    return Parts(
        rk4=None if method == "exact" else True,
        damper=True if scene.damper else GROUND if scene.grounded else None,
        near=wall if "near" in scene.walls else None,
        far=wall if "far" in scene.walls else None,
        arc=make_arc(settings.contact_tolerance, settings.nodes) if hertz else None,
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
    ps, damper = structure_of(cell), damper_of(parts.damper, cell)
    n = cells_of(ps, damper)
    return flow_of(prepared_cell(parts, cell, ps, damper, n, 1), grid_of(ps, damper, n))
