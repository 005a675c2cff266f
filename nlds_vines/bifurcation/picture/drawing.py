"""What draws the archive of a scan: diagrams, maps, basins; nothing is computed here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture import basin_map, sample_panels
from nlds_vines.bifurcation.picture.choices import (
    BASINS,
    REGIMES,
    check_show,
    is_map,
    quantities_in,
    usual_show,
)
from nlds_vines.bifurcation.picture.diagram import diagram, draw_into
from nlds_vines.bifurcation.picture.regime_map import (
    draw_manifold,
    fill_map,
    name_regimes,
    regime_map,
)
from nlds_vines.errors import RequestError
from nlds_vines.model.samples import SAMPLE
from nlds_vines.plotting.bands import refuse_undrawable
from nlds_vines.plotting.chosen_panels import Drawing
from nlds_vines.plotting.page import TWO_COLUMNS, Page, into


@dataclass(frozen=True)
class ScanPicture(Drawing):
    """Draws scans: a diagram of one varied parameter, a map of two.

    If one of two parameters takes only a few values (`plotting.bands.is_list`), there is no map:
    each of these values has curves and panels.  `manifold` draws the bounds of 1:1 motion in closed
    form over maps of omega.
    """

    manifold: bool = False

    def names(self, view: ArchiveView) -> Mapping[str, str]:
        """Return the recorded numbers, and the codes of maps, with their units."""
        if SAMPLE in view.axes:
            return sample_panels.PICTURE.names(view)
        maps = is_map([view[name] for name in view.axes])
        shown = {n: one for n, one in quantities_in(view).items() if maps or not one.coded}
        units = {n: f" [{one.units}]" if one.units != "1" else "" for n, one in shown.items()}
        return {name: f"{one.long_name}{units[name]}" for name, one in shown.items()}

    def figure(
        self,
        view: ArchiveView,
        show: str | None = None,
        page: Page = TWO_COLUMNS,
        ax: Axes | None = None,
    ) -> Figure:
        """Return the figure of an open archive, see `Drawing`.

        `show` of a diagram: quantities separated by commas, the words of `choices.GROUPS`, or
        `regimes` for the strips alone; of a map: see `regime_map`; `basins` if attractors are
        recorded.
        """
        if SAMPLE in view.axes:
            return sample_panels.PICTURE.figure(view, show, page, ax)
        for name in view.axes:
            refuse_undrawable(name, view[name])
        values = [view[name] for name in view.axes]
        labeled, recorded = "label" in view, quantities_in(view)
        if show is not None:
            check_show(show, values, view["start"].size, recorded, labeled)
        plain = len(values) == 1 or is_map(values)
        if show == BASINS or (show is None and plain and basin_map.drawable(view)):
            if ax is None:
                return basin_map.basin_picture(view, page)
            return into(ax, lambda: basin_map.fill(ax, view))
        if not is_map(values):
            if self.manifold:
                raise RequestError(
                    f"{view.path}: the manifold is drawn over maps; "
                    "curves: response-curves --manifold"
                )
            if ax is None:
                return diagram(view, show, page)
            return into(ax, lambda: draw_into(ax, view, show))
        chosen = usual_show(recorded, labeled) if show is None else show
        if chosen is None:
            raise RequestError(f"{view.path} holds only {', '.join(view.names)}: nothing to draw")
        if ax is None:
            return regime_map(view, chosen, page, self.manifold)
        return into(ax, lambda: self._fill(ax, view, chosen))

    def _fill(self, axes: Axes, view: ArchiveView, show: str) -> None:
        fill_map(axes, view, show)
        if show == REGIMES:
            name_regimes(axes, view)
        if self.manifold:
            draw_manifold([axes], view)


PICTURE = ScanPicture()
"""What draws the archive of a scan."""
