"""What other archives of the same system add to a picture: their orbits, marked.

In basins the edge states of a continuation and the section of a portrait; in a portrait the orbits
of a continuation, stable or not; beside a sweep its branches, and response curves.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.datasets import begins_at_sections
from nlds_vines.bifurcation.result import scan_of
from nlds_vines.errors import RequestError
from nlds_vines.model.parameters import INITIAL
from nlds_vines.plotting.page import styled
from nlds_vines.plotting.style import GREY, HUES
from nlds_vines.runs.manifest import CONTINUATION, DECAY, PORTRAIT, RESPONSE_CURVES
from nlds_vines.upkeep.edge_states import difference, edge_states, refuse_other, value_along

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nlds_vines.archives.view import ArchiveView
    from nlds_vines.bifurcation.picture.basin_map import Marks
    from nlds_vines.continuation.result import Crossing
    from nlds_vines.loads.request import Decay
    from nlds_vines.model.system import System

Line: TypeAlias = "tuple[np.ndarray, np.ndarray, dict[str, Any]]"
"""What is drawn beside a sweep: frequency [rad/s], E1max [J], and the look of the line."""

_BODIES: Mapping[str, int] = {"section": -1, "section1": 0, "phase1": 0, "phase2": 1}
"""The panels that show states at phase zero, and of which body: 0, 1, or the last that there is."""

_ROOM = 0.14  # of the axes, beside the outermost marks: their names stand there
_STABLE: dict[str, Any] = {
    "color": GREY, "linewidth": 1.6, "alpha": 0.7, "label": "stable branches"
}  # fmt: skip
_UNSTABLE: dict[str, Any] = {
    "color": GREY, "linewidth": 0.8, "linestyle": (0, (2, 1.5)), "label": "unstable branches"
}  # fmt: skip
_CURVE: dict[str, Any] = {
    "linestyle": "-", "linewidth": 3.5, "alpha": 0.3, "label": "response curves"
}  # fmt: skip
_MARK: dict[str, Any] = {
    "linestyle": "none",
    "marker": "D",
    "markersize": 4.0,
    "markeredgewidth": 0.9,
    "zorder": 8,
}


_EDGES: dict[str, Any] = {
    "marker": "D",
    "markersize": 4.5,
    "markerfacecolor": "#ffd700",
    "markeredgecolor": "black",
    "markeredgewidth": 0.9,
    "zorder": 6,
}
_SECTION: dict[str, Any] = {
    "marker": "o",
    "markersize": 2.0,
    "color": "black",
    "markeredgecolor": "white",
    "markeredgewidth": 0.2,
    "zorder": 4,
    "rasterized": True,
}


def marks_in_basins(view: ArchiveView, paths: Sequence[str | os.PathLike[str]]) -> list[Marks]:
    """Return what of other archives is marked in the basins of a scan.

    Arguments: its open archive; the `paths` of continuations, whose edge states are marked, and of
    portraits, whose sections are.

    Raises `RequestError` for anything else and for another system, and where the scan has no basins
    in a plane of starts at phase zero.
    """
    return [_mark_in_basins(view, path) for path in paths]


def _mark_in_basins(view: ArchiveView, path: str | os.PathLike[str]) -> Marks:
    from nlds_vines.bifurcation.picture.basin_map import Marks
    from nlds_vines.portrait.result import portrait_in

    plane = len(view.axes) == 2 and set(view.axes) <= INITIAL.keys()
    if "attractor" not in view or not plane or not begins_at_sections(view):
        raise RequestError(
            f"{view.path}: orbits are marked in basins over two initial conditions, at phase 0; "
            "on the page of a portrait; and beside a sweep"
        )
    with read(path) as other:
        content = other.content
    if content == CONTINUATION:
        found = [np.empty((0, view["component"].size))]
        found += [edge.sections for edge in edge_states(view, path)]
        return Marks(np.concatenate(found), "points of edge states", _EDGES)
    if content == PORTRAIT:
        views = portrait_in(path).views
        for one in views:
            refuse_other(scan_of(view).system, one.column.system, str(path))
        points = np.concatenate([one.section for one in views])
        return Marks(points, "section of an orbit", _SECTION)
    raise RequestError(
        f"{path} holds a {content}; in basins are marked: a continuation, a portrait"
    )


def mark_branches(
    figure: Figure,
    view: ArchiveView,
    paths: Sequence[str | os.PathLike[str]],
    own_page: bool = True,
) -> None:
    """Mark the orbits of branches on the page of a portrait, or draw them beside a sweep.

    Arguments: the `figure` and its open archive; the `paths` of continuations; whether the figure
    is a page of its own, not axes of the user's.  Raises `RequestError` for such axes.
    """
    if paths and not own_page:
        raise RequestError(f"{view.path}: orbits are marked on a page of its own: give no axes")
    for path in paths:
        (mark_in_portrait if view.content == PORTRAIT else draw_beside_sweep)(figure, view, path)


@styled()
def mark_in_portrait(
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
    system = request.columns[0].system
    for column in request.columns:
        refuse_other(system, column.system, str(view.path))
    orbits = found.orbits_at(value_along(found, system, view, branches))
    last = len(system.scene.components) // 2 - 1
    for axes in panels:
        body = _BODIES[str(axes.get_label())]
        for orbit in orbits:
            _mark(axes, orbit, last if body < 0 else body)
        axes.margins(_ROOM)
    return orbits


@styled()
def draw_beside_sweep(
    figure: Figure, view: ArchiveView, steady: str | os.PathLike[str]
) -> list[Axes]:
    """Draw E1max over omega beside the sweeps of a decay: response curves, or branches.

    Arguments: the `figure` of its picture; its open archive; the path of the archive of `steady`
    motion of one of its dampers under the force of its sweeps: of response curves, or of a
    continuation along omega.  Returns the axes.

    Raises `RequestError` for another system or along another parameter, and where no panel shows
    energies of a sweep.
    """
    from nlds_vines.loads.picture import SWEEP_ENERGY
    from nlds_vines.loads.request_file import load_decay

    request = view.request(DECAY, load_decay)
    panels = [axes for axes in figure.axes if axes.get_label() == SWEEP_ENERGY]
    if not panels:
        raise RequestError(f"{steady} is drawn beside a sweep: --show {SWEEP_ENERGY}")
    with read(steady) as other:
        lines = _curves_of if other.content == RESPONSE_CURVES else _branches_of
    drawn, first = [*lines(request, steady)], request.load.sweeps[0]
    for axes in panels:
        for omega, energy, look in drawn:
            _, named = axes.get_legend_handles_labels()
            words = None if look["label"] in named else look["label"]
            axes.plot(omega, energy, zorder=0, **{**look, "label": words})
        ends = [first.first, first.last]
        axes.set_xlim(min(ends), max(ends))
        axes.legend(loc="upper right")
    return panels


def _branches_of(request: Decay, path: str | os.PathLike[str]) -> Iterator[Line]:
    """Yield frequency [rad/s] and E1max [J] of the branches of a continuation, and their looks."""
    from nlds_vines.continuation.result import continued

    found = continued(path)
    _place_of(request, found.request.system, found.request.along.name, path)
    for branch in found.branches:
        stable = np.where(branch.stable, branch.E1max, np.nan)
        yield branch.parameter, branch.E1max, _UNSTABLE
        yield branch.parameter, stable, _STABLE


def _curves_of(request: Decay, path: str | os.PathLike[str]) -> Iterator[Line]:
    """Yield those of the response curves of its dampers, each in the damper's colour."""
    from nlds_vines.bifurcation.response_curves.result import curves_in
    from nlds_vines.loads.scan_picture import look

    page = curves_in(path)
    known = {system.scene.key for system in request.systems}
    pairs = [*zip(page.request.curves, page.curves, strict=True)]
    own = [pair for pair in pairs if pair[0].scan.system.scene.key in known]
    for asked, curve in own or pairs:
        i = _place_of(request, asked.scan.system, page.request.axis, path)
        for name in ("E1max", "E1max_down"):
            if name in curve.numbers:
                yield curve.values, curve.numbers[name], {**look(i), **_CURVE}


def _place_of(request: Decay, system: System, along: str, path: str | os.PathLike[str]) -> int:
    """Return which system of a sweep the same one is; `RequestError` where none is."""
    if along != "omega" or request.load.shaken:
        raise RequestError(f"{path} must be along omega, and the sweep a force on m1")
    like = {"P": request.load.force_of(request.load.sweeps[0]), "omega": system.parameters["omega"]}
    own = [one.with_(**like) for one in request.systems]
    alike = [i for i, one in enumerate(own) if one.scene.key == system.scene.key]
    place = next((i for i in alike if not difference(own[i], system)), (alike or [0])[0])
    refuse_other(own[place], system, str(path))
    return place


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
