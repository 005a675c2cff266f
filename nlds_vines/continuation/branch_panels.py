"""The panels of a diagram of branches: displacements at the section, energies, multipliers, forces.

Their names are known from the request, before anything is computed.  Requests name quantities, so
that this module imports neither them nor results: its arguments are a `Continuation`, a `Continued`
and its `Branch` and `Crossing`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.model.scenes import Scene
from nlds_vines.plotting.style import quantity_label

ENERGY, MULTIPLIERS, SECTION = "E1max", "multipliers", "section"
PLANE = "plane"  # the only panel of a continuation in a plane
LARGEST_MULTIPLIER = "largest_multiplier"  # the modulus of the first one, as a monitor

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

    def along(self, branch: Any) -> np.ndarray:
        """Return the curves (curves, points) of a branch: one for each section or multiplier."""
        if self.dataset == SECTION:
            return np.asarray(branch.sections[:, :, self.column].T)
        if self.dataset == MULTIPLIERS:
            return np.abs(branch.multipliers).T
        if self.name in branch.monitors:
            return np.asarray(branch.monitors[self.name])[np.newaxis]
        values = np.asarray(getattr(branch, self.dataset))
        if values.ndim > 1:
            values = values[:, self.column]
        return values[np.newaxis]

    def of_orbit(self, orbit: Any) -> float:
        """Return the value of an orbit, of a component at its state; not of multipliers."""
        if self.dataset == SECTION:
            return float(orbit.state[self.column])
        value = np.asarray(getattr(orbit, self.dataset))
        return float(value[self.column] if value.ndim else value)

    def at_special(self, result: Any, number: int) -> np.ndarray:
        """Return the values (n,) at a special point: of the section n, of the others one or none.

        Of multipliers, the one nearest to the unit circle counts.
        """
        if self.dataset == SECTION:
            return np.asarray(result.special_sections[number][:, self.column])
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


def panels_of(request: Any) -> dict[str, Panel]:
    """Return all panels of branches by name, the usual ones first."""
    panels = [*_panels(request.system.scene)]
    for one in request.monitors:
        if one.is_function:
            panels.append(Panel(one.name, one.dataset, "1", f"{one.name}, a function of the user"))
    first = usual_panels(request)
    panels.sort(key=lambda panel: first.index(panel.name) if panel.name in first else len(first))
    return {panel.name: panel for panel in panels}


def usual_panels(request: Any) -> list[str]:
    """Return the names of the usual panels: the body that impacts, or the last one; the energy."""
    names = request.system.scene.components
    component = next((one for one in ("x2", "x", "x1") if one in names), names[-2])
    return [component, ENERGY]


def names_of(request: Any) -> dict[str, str]:
    """Return the names of what can be drawn, with their meanings."""
    if request.plane is not None:
        return {PLANE: "curves of special points in the plane of two parameters"}
    panels = panels_of(request).values()
    return {
        panel.name: panel.words + ("" if panel.unit == "1" else f" [{panel.unit}]")
        for panel in panels
    }


def monitored_quantities(scene: Scene) -> list[str]:
    """Return the names of the quantities whose values can be located along branches."""
    names = [panel.name for panel in _panels(scene) if panel.name != MULTIPLIERS]
    return [*names, LARGEST_MULTIPLIER]


def _panels(scene: Scene) -> Iterator[Panel]:
    for i, name in enumerate(scene.components):
        yield Panel(name, SECTION, ("m", "m/s")[i % 2], f"{name} at the section", i)
    yield Panel(ENERGY, ENERGY, "J", "largest energy")
    if scene.dampers:
        for i, damper in enumerate(scene.dampers):
            yield Panel(f"{damper}.E2max", "E2max", "J", f"largest energy of {damper}", i)
    elif scene.damper:
        yield Panel("E2max", "E2max", "J", "largest energy of the damper")
    yield Panel(MULTIPLIERS, MULTIPLIERS, "1", "moduli of the Floquet multipliers")
    if scene.walls:
        for name, (unit, words) in _OF_IMPACTS.items():
            yield Panel(name, name, unit, words)
