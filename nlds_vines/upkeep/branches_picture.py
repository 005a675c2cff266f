"""Branches of a continuation drawn over the energies of a sweep."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.provenance import RESPONSE_HISTORY
from nlds_vines.continuation.result import read_continuation
from nlds_vines.errors import RequestError
from nlds_vines.loads.picture import SWEEP_ENERGY
from nlds_vines.loads.request import load_response_history
from nlds_vines.plotting.page import add_legend, fit, styled
from nlds_vines.plotting.style import GRAY

ALIKE = 1e-9  # relative difference up to which two values of a parameter count as equal

_STABLE: dict[str, Any] = {
    "color": GRAY, "linewidth": 1.6, "alpha": 0.7, "label": "stable branches"
}  # fmt: skip
_UNSTABLE: dict[str, Any] = {
    "color": GRAY, "linewidth": 0.8, "linestyle": (0, (2, 1.5)), "label": "unstable branches"
}  # fmt: skip


@styled()
def draw_branches(
    figure: Figure, view: ArchiveView, path: str | os.PathLike[str], alone: bool = False
) -> None:
    """Draw E1max of branches over omega in a sweep's energy, `alone` in axes of the user."""
    request = view.request(RESPONSE_HISTORY, load_response_history)
    continuation = read_continuation(path)
    panels = [axes for axes in figure.axes if axes.get_label() == SWEEP_ENERGY]
    if not panels:
        raise RequestError(f"{path} is drawn beside a sweep: --show {SWEEP_ENERGY}")
    # the branches must be those of a damper of the sweep under its force
    system, sweep = continuation.request.system, request.load.sweep[0]
    if continuation.request.along.name != "omega" or request.load.shaken:
        raise RequestError(f"{path} must be along omega, and the sweep a force on m1")
    like = {"P": request.load.force_of(sweep), "omega": system.parameters["omega"]}
    difference = ""
    for damper in request.systems:
        difference = f"{system.heading()}, not {damper.heading()}"
        if damper.scene.key == system.scene.key:
            ours, theirs = damper.with_(**like).parameters, system.parameters
            wrong = [n for n in ours if not np.isclose(theirs[n], ours[n], rtol=ALIKE, atol=0.0)]
            if not wrong:
                break
            difference = ", ".join(f"{n} = {theirs[n]!r}, not {ours[n]!r}" for n in wrong)
    else:
        raise RequestError(f"{path} is of another system: {difference}")
    for axes in panels:
        for branch in continuation.branches:
            stable = np.where(branch.stable, branch.E1max, np.nan)
            for energy, look in ((branch.E1max, _UNSTABLE), (stable, _STABLE)):
                named = axes.get_legend_handles_labels()[1]
                words = None if look["label"] in named else look["label"]
                axes.plot(branch.parameter, energy, zorder=0, **{**look, "label": words})
        axes.set_xlim(min(sweep.first, sweep.last), max(sweep.first, sweep.last))
        if legend := axes.get_legend():
            legend.remove()
        handles, _ = axes.get_legend_handles_labels()
        if alone:
            axes.legend()
        else:
            add_legend(axes, handles, "above", handlelength=2.2)
    spec = panels[0].get_subplotspec()
    if spec is not None and not alone:
        fit(figure, spec.get_gridspec())
