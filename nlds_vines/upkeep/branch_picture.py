"""Orbits of branches in the sections of a portrait, stable or not."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from nlds_vines.errors import RequestError
from nlds_vines.plotting.page import styled
from nlds_vines.plotting.style import HUES
from nlds_vines.upkeep.edge_states import refuse_other

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.archives.view import ArchiveView
    from nlds_vines.continuation.result import Crossing

_BODIES: Mapping[str, int] = {"section": -1, "section1": 0, "phase1": 0, "phase2": 1}
"""The panels that show states at phase zero, and of which body: 0, 1, or the last that there is."""

_ROOM = 0.14  # of the axes, beside the outermost marks: their names stand there
_MARK: dict[str, Any] = {
    "linestyle": "none",
    "marker": "D",
    "markersize": 4.0,
    "markeredgewidth": 0.9,
    "zorder": 8,
}


@styled()
def mark_branches(
    figure: Figure, view: ArchiveView, branches: str | os.PathLike[str]
) -> list[Crossing]:
    """Mark the orbits of branches in the planes of a portrait's page, open where they are unstable.

    Arguments: the `figure` of the page; its open archive; the path of the archive of a continuation
    of the same system, along any parameter.  Returns the orbits that are marked.

    Raises `RequestError` for branches of another system, or that do not reach so far, and where no
    panel shows states at phase zero.
    """
    from nlds_vines.continuation.result import continued
    from nlds_vines.portrait.result import portrait_in

    request, found = portrait_in(view.path).drawn_from, continued(branches)
    panels = [axes for axes in figure.axes if axes.get_label() in _BODIES and axes.axison]
    if not panels:
        raise RequestError(f"{branches} is drawn in one of: {', '.join(_BODIES)}")
    if request.section_phase:
        raise RequestError(f"{branches} is for sections at phase 0")
    system, name = request.columns[0].system, found.request.along.name
    for column in request.columns:
        refuse_other(system, column.system, str(view.path))
    if name not in system.parameters:
        raise RequestError(f"{branches}: {view.path} has no {name}, along which the branches are")
    value = float(system.parameters[name])
    refuse_other(system, found.request.system.with_(**{name: value}), str(branches))
    orbits = found.orbits_at(value)
    last = len(system.scene.components) // 2 - 1
    for axes in panels:
        body = _BODIES[str(axes.get_label())]
        for orbit in orbits:
            _mark(axes, orbit, last if body < 0 else body)
        axes.margins(_ROOM)
    return orbits


def _mark(axes: Axes, orbit: Crossing, body: int) -> None:
    """Mark the section points of an orbit, and name it at the first."""
    points = orbit.sections[:, 2 * body : 2 * body + 2]
    face = HUES["vermillion"] if orbit.stable else "white"
    axes.plot(*points.T, color=HUES["vermillion"], markerfacecolor=face, **_MARK)
    words = orbit.label if orbit.stable else f"{orbit.label} unstable"
    axes.annotate(
        words, points[0], (4, 4), textcoords="offset points", fontsize=7, zorder=8,
        color=HUES["vermillion"],
    )  # fmt: skip
