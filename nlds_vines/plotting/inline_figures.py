"""Figures in notebooks: shown as pictures, though no plotting window is ever opened."""

from __future__ import annotations

from nlds_vines.runs.progress import in_notebook


def let_figures_be_shown() -> None:
    """Let a notebook show figures that its cells return; elsewhere nothing happens.

    A notebook learns to do so when matplotlib.pyplot is loaded, which this program never does.
    """
    if in_notebook():
        from IPython import get_ipython
        from IPython.core.pylabtools import select_figure_formats

        select_figure_formats(get_ipython(), {"png"})
