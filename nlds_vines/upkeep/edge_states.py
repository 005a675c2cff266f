"""Edge states beside the basins of a scan: orbits of a continuation with one unstable multiplier.

The stable manifold of such an orbit may be the boundary between the basins of two attractors.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.bifurcation.result import scan_of
from nlds_vines.errors import RequestError
from nlds_vines.model.system import System
from nlds_vines.transients.basin_shares import places_of

if TYPE_CHECKING:
    from nlds_vines.archives.view import ArchiveView
    from nlds_vines.continuation.result import Continued

ALIKE = 1e-9
"""Relative difference of parameters that counts as none."""

SAME = 1e-6
"""Distance of two section points, relative to their size, that counts as none."""


@dataclass(frozen=True)
class EdgeState:
    """An nT orbit with one unstable multiplier.

    Attributes: its `label`; the `sections` (n, components), its states at phase zero in the user's
    coordinates [m, m/s]; the unstable `multiplier`; the number of its `branch`.
    """

    label: str
    sections: np.ndarray
    multiplier: float
    branch: int


def edge_states(
    view: ArchiveView, branches: str | os.PathLike[str], values: Mapping[str, float] | None = None
) -> list[EdgeState]:
    """Return the edge states of the system of a scan, each once.

    Arguments: the open archive of the scan; the path of that of a continuation of the same system
    along any parameter; the `values` of the parameters that the scan varies.

    Raises `RequestError` where the systems differ, or the branches do not reach so far.
    """
    from nlds_vines.continuation.result import continued

    found, scan = continued(branches), scan_of(view)
    where = places_of(view, dict(values or {}))
    system = scan.system.with_(**{name: float(view[name][i]) for name, i in where.items()})
    value = value_along(found, system, view, branches)
    edges: list[EdgeState] = []
    for orbit in found.edges_at(value):
        unstable = float(orbit.multipliers[0].real)  # one alone is real
        edge = EdgeState(orbit.label, orbit.sections, unstable, orbit.branch)
        if not any(_is_same(edge, other) for other in edges):
            edges.append(edge)
    return edges


def value_along(
    found: Continued, system: System, view: ArchiveView, branches: str | os.PathLike[str]
) -> float:
    """Return the value at which branches are of the system of an archive, see `edge_states`."""
    name = found.request.along.name
    if name not in system.parameters:
        raise RequestError(f"{branches}: {view.path} has no {name}, along which the branches are")
    value = float(system.parameters[name])
    refuse_other(system, found.request.system.with_(**{name: value}), str(branches))
    return value


def lines_of(edges: list[EdgeState], components: Sequence[str]) -> Iterator[str]:
    """Yield the edge states in words, one a line."""
    if not edges:
        yield "edge states: the branches have none here"
    for edge in edges:
        point = ", ".join(
            f"{name} = {value:.6g}"
            for name, value in zip(components, edge.sections[0], strict=True)
        )
        yield (
            f"edge state {edge.label} of branch {edge.branch}: unstable multiplier "
            f"{edge.multiplier:.6g}; {point}"
        )


def refuse_other(system: System, other: System, where: str) -> None:
    """Raise `RequestError` unless two systems are the same."""
    if said := difference(system, other):
        raise RequestError(f"{where} is of another system: {said}")


def difference(system: System, other: System) -> str:
    """Return in words what another system has that a system has not; empty where they are one."""
    if system.scene.key != other.scene.key:
        return f"{other.heading()}, not {system.heading()}"
    for name, value in system.parameters.items():
        theirs = other.parameters.get(name)
        if theirs is None or abs(theirs - value) > ALIKE * max(abs(value), abs(theirs)):
            return f"{name} = {theirs!r}, not {value!r}"
    return ""


def _is_same(edge: EdgeState, other: EdgeState) -> bool:
    """Tell whether two edge states are one orbit."""
    if edge.sections.shape != other.sections.shape:
        return False
    apart = np.abs(other.sections - edge.sections[0]).max(axis=1)
    return bool(apart.min() <= SAME * np.abs(edge.sections).max())
