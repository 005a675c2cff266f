"""What the kernels take: the parts of a scene and the numbers of a cell."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.model.scenes import Scene
from nlds_vines.model.system import System
from nlds_vines.orbits.hertz_arc import make_arc

if TYPE_CHECKING:
    pass


def method_parts(method: str, scene: Scene, nodes: int | None = None) -> tuple[Any, ...]:
    """Return what tells the kernels which parts exist: (classical, damper, near, far, arc).

    Each is None where there is no such part, and then absent from the machine code.  `nodes` sets
    the collocation nodes of a short impact.
    """
    arc = None
    if scene.walls:
        arc = make_arc() if nodes is None else make_arc(nodes)
    return (
        None if method == "exact" else True,
        True if scene.damper else None,
        True if "near" in scene.walls else None,
        True if "far" in scene.walls else None,
        arc,
    )


def cell_of(system: System) -> Any:
    """Return the kernels' record of one system."""
    return np.atleast_1d(system.cells()).view(np.recarray)[0]
