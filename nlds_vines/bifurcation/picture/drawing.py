"""From the path of a scan's archive to the path of its picture; nothing is computed here."""

from __future__ import annotations

import os
from pathlib import Path

from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.choices import check_show, usual_show
from nlds_vines.bifurcation.picture.diagram import diagram
from nlds_vines.bifurcation.picture.regime_map import regime_map
from nlds_vines.errors import RequestError
from nlds_vines.plotting.bands import refuse_undrawable
from nlds_vines.plotting.save import save_drawn


def save(
    archive_path: str | os.PathLike[str],
    plot_path: str | os.PathLike[str],
    show: str | None = None,
) -> Path:
    """Draw a scan's archive, save the picture and return the picture's path.

    Arguments: the paths of archive and picture (`plotting.save.save_drawn`); what a map is to
    `show` (`regime_map`), by default its regimes or the first recorded number.

    Raises `RequestError` as `save_drawn` does, and where the archive does not hold what to show.
    """
    return save_drawn(archive_path, plot_path, lambda view: draw(view, show))


def draw(view: ArchiveView, show: str | None = None) -> Figure:
    """Return the picture of an open archive: a diagram of one varied parameter, a map of two.

    Raises `RequestError` where the archive does not hold what to `show`.
    """
    for name in view.axes:
        refuse_undrawable(name, view[name])
    if show is not None:
        check_show(show, len(view.axes), view["start"].size, view.names)
    if len(view.axes) == 1:
        return diagram(view)
    chosen = usual_show(view.names) if show is None else show
    if chosen is None:
        raise RequestError(f"{view.path} holds only {', '.join(view.names)}: nothing to draw")
    return regime_map(view, chosen)
