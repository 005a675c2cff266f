"""What the kernels take: the parts of a scene and the numbers of a cell."""

from __future__ import annotations

from typing import Any

import numpy as np

from nlds_vines.kernels.arguments import Parts
from nlds_vines.kernels.cells import prepared_cell
from nlds_vines.kernels.flight import PERIOD, cells_of, grid_of
from nlds_vines.kernels.scene import (
    Damping,
    Ground,
    LinearWall,
    PowerWall,
    RigidWall,
    Wall,
    damper_of,
    structure_under,
)
from nlds_vines.kernels.variations import Flow, flow_of
from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System
from nlds_vines.orbits.hertz_arc import make_arc
from nlds_vines.orbits.settings import Settings

GROUND = Ground(*[0.0] * len(Ground._fields))
"""What walls stand on that limit the structure itself: of its numbers, kernels look at none."""

_POWER = PowerWall(0.0, 0.0, 0.0, 0.0, 0.0, 1, 1, 0.0, 0.0, 0.0, None)

WALLS: dict[str, Any] = {
    "hertz": Wall(0.0, 0.0, 0.0, 0.0),
    "power": _POWER,
    "linear": LinearWall(0.0, 0.0, 0.0, None),
    "kelvin-voigt": LinearWall(0.0, 0.0, 0.0, True),
    "restitution": RigidWall(0.0, 0.0),
}
"""A wall by the name of its law: of its numbers, kernels look at none."""

DAMPED = _POWER._replace(damping=Damping(0.0, 0.0))
"""A wall whose law, a power of the depth, has Hunt and Crossley's damping."""


def wall_of(scene: Scene, name: str) -> Any:
    """Return a wall of the law at the near or far wall of a scene, None where it has none."""
    if name not in scene.walls:
        return None
    return DAMPED if scene.is_damped(name) else WALLS[scene.law_at(name).name]


def parts_of(method: str, scene: Scene, settings: Settings | None = None) -> Parts:
    """Return the `Parts` that tell the kernels which parts there are, and how fine a method is.

    What is absent is None, and then absent from the machine code. By default, the `settings` are
    those of a scan by the method.
    """
    settings = Settings.of(method) if settings is None else settings
    near, far = wall_of(scene, "near"), wall_of(scene, "far")
    hertz = isinstance(near, Wall) or isinstance(far, Wall)
    return Parts(
        rk4=None if method == "exact" else True,
        damper=True if scene.damper else GROUND if scene.grounded else None,
        near=near,
        far=far,
        apart=None if scene.law_2 is None else True,
        load=None if scene.load is None else True,
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
    ps, damper = structure_under(parts.load, cell), damper_of(parts.damper, cell)
    n = cells_of(ps, damper)
    return flow_of(prepared_cell(parts, cell, ps, damper, n, 1, PERIOD), grid_of(ps, damper, n))
