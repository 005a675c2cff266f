"""From the path of a scan's archive to the path of its picture; nothing is computed here."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture import basin_map
from nlds_vines.bifurcation.picture.choices import BASINS, check_show, is_map, usual_show
from nlds_vines.bifurcation.picture.diagram import diagram, draw_into
from nlds_vines.bifurcation.picture.manifold_bounds import draw_manifold
from nlds_vines.bifurcation.picture.ordinates import quantities_in
from nlds_vines.bifurcation.picture.regime_map import fill_map, regime_map
from nlds_vines.errors import RequestError
from nlds_vines.plotting.bands import refuse_undrawable
from nlds_vines.plotting.page import TWO_COLUMNS, Page, into
from nlds_vines.plotting.save import save_drawn


def save(
    archive_path: str | os.PathLike[str],
    plot_path: str | os.PathLike[str],
    show: str | None = None,
    page: Page = TWO_COLUMNS,
) -> Path:
    """Draw a scan's archive, save the picture and return the picture's path.

    Arguments: the paths of archive and picture (`plotting.save.save_drawn`); what to `show`, and
    the `page`, as `draw` takes them.

    Raises `RequestError` as `save_drawn` does, and where the archive does not hold what to show.
    """
    return save_drawn(archive_path, plot_path, lambda view: draw(view, show, page))


def draw(
    view: ArchiveView,
    show: str | None = None,
    page: Page = TWO_COLUMNS,
    ax: Axes | None = None,
    marks: Sequence[basin_map.Marks] = (),
    manifold: bool = False,
) -> Figure:
    """Return the picture of an open archive: a diagram of one varied parameter, a map of two.

    Where one of two parameters takes only a few values (`plotting.bands.is_list`), there is no map:
    each of the values has curves and panels of its own.

    Arguments: the archive; what to `show`: of a diagram quantities separated by commas
    (`quantities.quantities`), or the words of `choices.GROUPS`, or `regimes` for the strips alone;
    of a map what `regime_map` tells; `basins` where attractors are recorded; None for what is
    usual; the `page`; axes to draw one panel into, None for a figure of its own; of basins, what
    `marks` are drawn; of maps over omega, whether the bounds of 1:1 motion in closed form are
    (`manifold`).

    Raises `RequestError` where the archive does not hold what to `show`.
    """
    for name in view.axes:
        refuse_undrawable(name, view[name])
    values = [view[name] for name in view.axes]
    labelled, known = "label" in view, quantities_in(view)
    if show is not None:
        check_show(show, values, view["start"].size, known, labelled)
    plain = len(values) == 1 or is_map(values)
    if show == BASINS or (show is None and plain and basin_map.drawable(view)):
        if ax is None:
            return basin_map.basin_picture(view, page, marks)
        return into(ax, lambda: basin_map.fill(ax, view, page, marks))
    if marks:
        raise RequestError(f"{view.path}: orbits are marked with show = 'basins' alone")
    if not is_map(values):
        if manifold:
            raise RequestError(
                f"{view.path}: the manifold is drawn over maps; curves: response-curves --manifold"
            )
        if ax is None:
            return diagram(view, show, page)
        return into(ax, lambda: draw_into(ax, view, show))
    chosen = usual_show(known, labelled) if show is None else show
    if chosen is None:
        raise RequestError(f"{view.path} holds only {', '.join(view.names)}: nothing to draw")
    if ax is None:
        return regime_map(view, chosen, page, manifold)
    return into(ax, lambda: _fill(ax, view, chosen, page, manifold))


def _fill(axes: Axes, view: ArchiveView, show: str, page: Page, manifold: bool) -> None:
    """Draw one map into axes, and over it the bounds of 1:1 motion if asked for."""
    fill_map(axes, view, show, page)
    if manifold:
        draw_manifold([axes], view)
