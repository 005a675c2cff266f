"""The panels of a diagram of branches: displacements at the section, energies, multipliers, forces.

Their names are known from the request, before anything is computed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.continuation.request import Continuation
from nlds_vines.plotting.style import quantity_label

if TYPE_CHECKING:
    from nlds_vines.continuation.result import Branch, Continued

ENERGY, MULTIPLIERS, SECTION = "E1max", "multipliers", "section"
PLANE = "plane"  # the only panel of a continuation in a plane

# numbers of orbits with walls, with their units and meanings
_OF_IMPACTS = {
    "largest_force": ("N", "largest contact force"),
    "fastest_impact": ("m/s", "largest approach speed"),
    "softest_impact": ("m/s", "smallest approach speed"),
    "clearance": ("m", "smallest near miss"),
}


@dataclass(frozen=True)
class Panel:
    """A quantity of the orbits of branches, drawn over the parameter."""

    name: str  # the word of `--show`
    dataset: str
    unit: str
    words: str
    column: int | None = None  # of a component of the section, or of a damper

    def label(self, body: str) -> str:
        if self.dataset == MULTIPLIERS:
            return r"multiplier $|\mu|$"
        return quantity_label(self.name, self.unit, self.words, body)

    def along(self, branch: Branch) -> np.ndarray:
        """Return the curves (curves, points) of a branch: one for each section or multiplier."""
        if self.dataset == SECTION:
            return branch.sections[:, :, self.column].T
        if self.dataset == MULTIPLIERS:
            return np.abs(branch.multipliers).T
        values = np.asarray(getattr(branch, self.dataset))
        if values.ndim > 1:
            values = values[:, self.column]
        return values[np.newaxis]

    def at_special(self, result: Continued, number: int) -> np.ndarray:
        """Return the values (n,) at a special point: of the section n, of the others one or none.

        Of multipliers, the one nearest to the unit circle counts.
        """
        if self.dataset == SECTION:
            return result.special_sections[number][:, self.column]
        name = f"special_{self.dataset}"
        if name not in result.tables:  # as in an archive of an earlier version
            return np.empty(0)
        values = np.asarray(result.tables[name][number])
        if self.dataset == MULTIPLIERS:
            moduli = np.hypot(values[:, 0], values[:, 1])
            return moduli[[np.abs(moduli - 1.0).argmin()]]
        if values.ndim:
            values = values[self.column]
        return np.atleast_1d(values)


def panels_of(request: Continuation) -> dict[str, Panel]:
    """Return all panels of branches by name, the usual ones first."""
    panels = [*_panels(request)]
    first = usual_panels(request)
    panels.sort(key=lambda panel: first.index(panel.name) if panel.name in first else len(first))
    return {panel.name: panel for panel in panels}


def usual_panels(request: Continuation) -> list[str]:
    """Return the names of the usual panels: the body that impacts, or the last one; the energy."""
    names = request.system.scene.components
    component = next((one for one in ("x2", "x", "x1") if one in names), names[-2])
    return [component, ENERGY]


def names_of(request: Continuation) -> dict[str, str]:
    """Return the names of what can be drawn, with their meanings."""
    if request.plane is not None:
        return {PLANE: "curves of special points in the plane of two parameters"}
    panels = panels_of(request).values()
    return {
        panel.name: panel.words + ("" if panel.unit == "1" else f" [{panel.unit}]")
        for panel in panels
    }


def _panels(request: Continuation) -> Iterator[Panel]:
    scene = request.system.scene
    for i, name in enumerate(scene.components):
        yield Panel(name, SECTION, ("m", "m/s")[i % 2], f"{name} at the section", i)
    yield Panel(ENERGY, ENERGY, "J", "largest energy")
    if scene.dampers:
        for i, damper in enumerate(scene.dampers):
            yield Panel(f"{damper}.E2max", "E2max", "J", f"largest energy of {damper}", i)
    elif scene.damper:
        yield Panel("E2max", "E2max", "J", "largest energy of the damper")
    yield Panel(MULTIPLIERS, MULTIPLIERS, "1", "moduli of the Floquet multipliers")
    if scene.walls or scene.counted:
        for name, (unit, words) in _OF_IMPACTS.items():
            yield Panel(name, name, unit, words)
