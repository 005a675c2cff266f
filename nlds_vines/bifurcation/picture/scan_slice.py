"""The results of a scan along one of its parameters, the other one held at one of its values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.ordinates import Quantity
from nlds_vines.model.labels import KEPT
from nlds_vines.plotting.notation import setting_label
from nlds_vines.plotting.palette import INADMISSIBLE


@dataclass(frozen=True)
class Slice:
    """Results along one varied parameter.

    Attributes:
        view: the open archive; axis: the parameter that runs to the right.
        at: the place of the value of the other parameter, by its name; empty where there is none.
    """

    view: ArchiveView
    axis: str
    at: Mapping[str, int] = field(default_factory=dict)

    @property
    def values(self) -> np.ndarray:
        """The values (cells,) of the parameter."""
        return self.view[self.axis]

    @property
    def starts(self) -> list[str]:
        """The names of the starts of each cell."""
        return list(self.view["start"])

    @property
    def held(self) -> str:
        """The parameter that is held, its value and unit, in LaTeX; empty for none."""
        pairs = ((name, float(self.view[name][place])) for name, place in self.at.items())
        return ", ".join(setting_label(*pair) for pair in pairs)

    def of(self, quantity: Quantity) -> np.ndarray:
        """Return the values of a quantity, (cells, starts, many), NaN where there is none."""
        return quantity.of(self.view, self.at)

    def labels(self) -> np.ndarray | None:
        """Return the labels (cells, starts) of the orbits; None where they are not recorded."""
        return self.view.take("label", **self.at) if "label" in self.view else None

    def marked_labels(self) -> np.ndarray | None:
        """Return the labels, those of orbits that pass a limit with a word that says so."""
        found = self.labels()
        if found is None:
            return None
        return np.where(self.violated(), found + INADMISSIBLE, found)

    def violated(self) -> np.ndarray:
        """Return of which orbits (cells, starts) pass the limit of their scene, if it has one."""
        return violated_in(self.view, self.at)

    def flagged(self) -> np.ndarray:
        """Return of which orbits (cells, starts) the label is not kept under refinement."""
        if "label_kept" not in self.view:
            return np.zeros((self.values.size, len(self.starts)), dtype=bool)
        return np.asarray(self.view.take("label_kept", **self.at) == KEPT["no"])


def violated_in(view: ArchiveView, at: Mapping[str, int] | None = None) -> np.ndarray:
    """Return which orbits (axes, starts) of an archive pass the limit; none without a limit."""
    if "violations" not in view:
        return np.zeros(view.take("status", **(at or {})).shape, dtype=bool)
    return np.asarray(view.take("violations", **(at or {})) > 0)
