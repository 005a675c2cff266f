"""From the path of a scan's archive to the path of its picture; nothing is computed here."""

from __future__ import annotations

import os
from pathlib import Path

from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.choices import check_show
from nlds_vines.bifurcation.picture.diagram import diagram
from nlds_vines.bifurcation.picture.regime_map import regime_map
from nlds_vines.plotting.save import save_drawn


def save(
    archive_path: str | os.PathLike[str],
    plot_path: str | os.PathLike[str],
    show: str | None = None,
) -> Path:
    """Draw a scan's archive, of one varied parameter or two, and return the picture's path.

    `show` says what a map shall show (see `regime_map`); the rest as `plotting.save.save_drawn`.
    """

    def draw(view: ArchiveView) -> Figure:
        if len(view.axes) == 2:
            return regime_map(view, show)
        if show is not None:
            check_show(show, len(view.axes), view["start"].size, view.names)
        return diagram(view)

    return save_drawn(archive_path, plot_path, draw)
