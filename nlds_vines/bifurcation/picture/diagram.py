"""Diagrams: what one parameter does to the orbits (Figure 8), for one value of another or a few."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.picture.choices import GROUPS, rows_of
from nlds_vines.bifurcation.picture.dot_panel import (
    fill_panel,
    legend_of_panel,
    overlay_energy,
)
from nlds_vines.bifurcation.picture.ordinates import Quantity, Slice, quantities_in
from nlds_vines.bifurcation.picture.regime_strip import (
    Tier,
    draw_strip_of,
    legend_of_strips,
    strips_of,
)
from nlds_vines.errors import RequestError
from nlds_vines.model.quantities import drawn_in
from nlds_vines.model.quantity import BELOW, CURVES, TOUCHED
from nlds_vines.plotting.bands import edges
from nlds_vines.plotting.chosen_panels import several_panels
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    add_legend,
    finish,
    new_figure,
    styled,
    write_letters,
)
from nlds_vines.plotting.style import axis_label

_SMALL = 0.65  # of the height of a panel: one of small multiples
_ENERGY = "E1max"


@styled()
def diagram(view: ArchiveView, show: str | None = None, page: Page = TWO_COLUMNS) -> Figure:
    """Return the diagram of a scan along one parameter, at each of a few values of another.

    Arguments: the archive; what to `show`, as checked by `choices.check_show`: quantities separated
    by commas, `regimes` for the strips alone, None for what is usual; the `page`.

    Usually, with a recorded section: the stroboscopic coordinates of damper and structure, speeds
    and phases of impacts as unconnected dots, the structure's maximum energy in green over the
    first, or of several starts in a panel of its own.  Without one: the numbers that are recorded.
    Below them the largest Lyapunov exponent with its interval, where it is recorded.  Of a few
    values of another parameter each has a panel of dots; numbers are curves in one panel.

    Above the panels a strip names the regimes: one for each of two starts; of more starts, each
    cell shows them all, one above another.  Hatched are orbits that pass the limit of their scene.

    Raises `RequestError` where nothing is recorded to draw.
    """
    cuts, known = slices_of(view), quantities_in(view)
    shown = _usual_rows(view, cuts, known) if show is None else rows_of(show, known)
    tiers = _tiers(cuts, shown, known, page)
    if not tiers:
        raise RequestError(f"{view.path} holds only {', '.join(view.names)}: nothing to draw")
    figure, grid = new_figure(page, [tier.height for tier in tiers])
    axes: dict[int, Axes] = {}
    for place in sorted(range(len(tiers)), key=lambda place: not tiers[place].quantity):
        axes[place] = figure.add_subplot(grid[place], sharex=next(iter(axes.values()), None))
    rows = [axes[place] for place in range(len(tiers))]
    panels = _draw_tiers(tiers, rows, cuts[0]) or rows
    figure.align_ylabels([panel for panel in panels if panel.get_ylabel() and panel in rows])
    if show is None and _ENERGY in known and _has_overlay(cuts, shown, known):
        overlay_energy(panels[0], cuts[0], known[_ENERGY])
    handles = [*legend_of_panel(cuts, shown), *legend_of_strips(cuts, page)]
    if handles:
        add_legend(rows[-1], handles, "below")
    finish(figure, grid, view.text("title"))
    return figure


def slices_of(view: ArchiveView) -> list[Slice]:
    """Return the slices of a scan along its longest axis: one, or one for each value of another."""
    axes = sorted(view.axes, key=lambda name: -view[name].size)
    if len(axes) == 1:
        return [Slice(view, axes[0])]
    return [Slice(view, axes[0], {axes[1]: place}) for place in range(view[axes[1]].size)]


def draw_into(axes: Axes, view: ArchiveView, show: str | None = None) -> None:
    """Draw one quantity of a diagram into given axes, or with `regimes` the strip alone.

    Raises `RequestError` for several quantities, and for strips of several slices.
    """
    cuts, known = slices_of(view), quantities_in(view)
    rows = _usual_rows(view, cuts, known)[:1] if show is None else rows_of(show, known)
    if len(rows) > 1:
        raise several_panels(str(show), known)
    if len(cuts) > 1 and (not rows or not known[rows[0]].single):
        raise RequestError(f"show = {show!r} needs several panels: give no axes, or one number")
    axes.set_xlim(*edges(cuts[0].values)[[0, -1]])
    if rows:
        fill_panel(axes, cuts, known, rows[0])
        handles = legend_of_panel(cuts, rows)
        if handles:
            axes.legend(handles=handles)
    else:
        draw_strip_of(axes, cuts[0])
        axes.tick_params(bottom=True, labelbottom=True)
    axes.set_xlabel(axis_label(cuts[0].axis))


def _usual_rows(
    view: ArchiveView, cuts: Sequence[Slice], known: Mapping[str, Quantity]
) -> list[str]:
    """Return what the panels show by default, from the top."""
    below = [name for name in drawn_in(BELOW) if name in known]
    places = [name for name in GROUPS["displacement"] if name in known]
    places += [name for name in drawn_in(TOUCHED) if name in known]
    if not places:
        numbers = [name for name in drawn_in(CURVES) if name in known]
        if len(cuts) > 1 and len(numbers) > 1:  # the strips tell the periods
            numbers = [name for name in numbers if name != "periodicity"]
        return numbers + below
    if len(cuts) > 1:
        places = places[:1]
    alone = len(cuts) == 1 and view["start"].size == 1
    return places + [name for name in (_ENERGY,) if name in known and not alone] + below


def _has_overlay(cuts: Sequence[Slice], rows: Sequence[str], known: Mapping[str, Quantity]) -> bool:
    """Return whether the energy lies over the first panel: of one slice, one start, a section."""
    single = len(cuts) == 1 and len(cuts[0].starts) == 1
    return single and bool(rows) and not known[rows[0]].single


def _tiers(
    cuts: Sequence[Slice], rows: Sequence[str], known: Mapping[str, Quantity], page: Page
) -> list[Tier]:
    """Return the axes of a diagram from the top: strips, panels of dots, panels of numbers."""
    small = _SMALL if len(cuts) > 1 else 1.0
    found: list[Tier] = []
    for cut in cuts:
        own = [name for name in rows if len(cuts) == 1 or not known[name].single]
        if own or cut.labels() is not None:
            found += strips_of(cut)
        found += [_panel([cut], known, name, small * page.panel) for name in own]
    if len(cuts) > 1:
        numbers = [name for name in rows if known[name].single]
        found += [_panel(cuts, known, name, page.panel) for name in numbers]
    return found


def _panel(cuts: Sequence[Slice], known: Mapping[str, Quantity], name: str, height: float) -> Tier:
    draw = partial(fill_panel, cuts=cuts, known=known, name=name)
    return Tier(height, draw, name)


def _draw_tiers(tiers: Sequence[Tier], found: Sequence[Axes], cut: Slice) -> list[Axes]:
    """Draw the tiers into their axes along the values of a slice, and return the panels."""
    limits = edges(cut.values)[[0, -1]]
    for tier, axes in zip(tiers, found, strict=True):
        axes.set_xlim(*limits)
        tier.draw(axes)
        axes.set_xlim(*limits)
        axes.tick_params(top=bool(tier.quantity), labelbottom=axes is found[-1])
    found[-1].tick_params(bottom=True)
    found[-1].set_xlabel(axis_label(cut.axis))
    panels = [axes for tier, axes in zip(tiers, found, strict=True) if tier.quantity]
    _share_scales([tier for tier in tiers if tier.quantity], panels)
    write_letters(panels)
    return panels


def _share_scales(tiers: Sequence[Tier], found: Sequence[Axes]) -> None:
    """Give panels that show the same quantity the same limits."""
    for name in {tier.quantity for tier in tiers}:
        same = [axes for tier, axes in zip(tiers, found, strict=True) if tier.quantity == name]
        ends = [end for axes in same for end in axes.get_ylim()]
        for axes in same if len(same) > 1 else ():
            axes.set_ylim(min(ends), max(ends))
