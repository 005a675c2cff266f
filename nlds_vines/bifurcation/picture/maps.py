"""Maps of two parameters: regimes, how many coexist, shares, codes, numbers, basins of attraction.

The color of a basin is that of the attractor's regime, the same in every picture.  Of several
attractors of one regime the later ones are darker, then paler.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle, pairwise
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps, rcParams
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import NullFormatter, PercentFormatter

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.archives.provenance import SCAN
from nlds_vines.bifurcation.picture import choices
from nlds_vines.bifurcation.picture.diagram import PASSES, REDUCTION
from nlds_vines.bifurcation.request import begins_at_sections, load_scan
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import (
    TRANSIENT,
    UNKNOWN,
    by_frequency,
    coexisting,
    final,
    finals,
    most_frequent,
    share_of,
)
from nlds_vines.model.parameters import INITIAL, PARAMETERS, component_of
from nlds_vines.model.quantities import ERROR, PERIOD, SIGNED, WAIT, clause, scale_of
from nlds_vines.model.slow_manifold import free_mass_manifold
from nlds_vines.plotting import palette
from nlds_vines.plotting.bands import inner_edges, logarithmic
from nlds_vines.plotting.page import (
    TWO_COLUMNS,
    Page,
    add_legend,
    figure_of,
    finish,
    new_figure,
    size_of,
    text_width,
    write_letters,
    write_out_ticks,
)
from nlds_vines.plotting.style import CM, GRAY, NO_VALUE, ROUND_OFF, SHADES, axis_label, literal

BAR: dict[str, Any] = {"pad": 0.02, "fraction": 0.06, "aspect": 24}  # a color bar beside a map
_MOST_BELOW = 12  # names in a legend below a map, unless more regimes are large
_NAMED_SHARE = 0.005  # of the cells, above which the legend names a regime in any case
_CHAOTIC = "reached through chaos"
_PASSED = palette.PASSED, "#8b0000"  # hatch and color of cells in which the limit is passed


def regime_map(
    view: ArchiveView, show: str, page: Page, manifold: bool = False, ax: Axes | None = None
) -> Figure:
    """Return the map of a scan of two parameters; the first runs to the right, the second up."""
    if ax is not None:  # one panel alone
        fill_map(ax, view, show)
        if show == choices.REGIMES:
            name_regimes(ax, view)
        if manifold:
            draw_manifold([ax], view)
        return figure_of(ax)
    starts = view["start"].size
    if show == choices.SHARES or show.startswith(choices.SHARE):
        figure, grid, panels = _draw_shares(view, show, page)
    else:
        shown = [show]
        if show == choices.REGIMES and starts > 1:
            shown.append(choices.COEXISTING)
        figure, grid = new_figure(page, [page.map_height] * len(shown))
        panels = [figure.add_subplot(grid[row]) for row in range(grid.nrows)]
        for axes, what in zip(panels, shown, strict=True):
            fill_map(axes, view, what)
        write_letters(panels)
    title = view.text("title") + (f"; {starts} starts" if starts > 1 else "")
    if manifold:
        draw_manifold(panels, view)
        title += f"; {IN_TITLE}"
    finish(figure, grid, title)
    if show == choices.REGIMES:
        name_regimes(panels[0], view)
    return figure


def fill_map(axes: Axes, view: ArchiveView, show: str) -> None:
    """Draw one map into axes, with its legend or bar; `name_regimes` names its regions."""
    starts = view["start"].size
    frame: dict[str, Any] = {"edgecolor": GRAY, "linewidth": 0.4}  # of patches nearly white
    if show == choices.COEXISTING:
        most = len(palette.COUNTS)
        counts = np.minimum(coexisting(view["label"]), most)
        words = sorted(set(counts.ravel().tolist()))
        shades = {0: palette.OTHERS[palette.HATCHED], **dict(enumerate(palette.COUNTS, start=1))}
        fill_classes(axes, view, counts, words, [shades[word] for word in words])
        names = {0: "none known", most: f"{most} or more"}
        patches = [Patch(facecolor=shades[n], label=names.get(n, str(n)), **frame) for n in words]
        handles = [*patches, *hatch_passed(axes, view)]
        add_map_legend(axes, handles, f"regimes found by {starts} starts")
    elif show == choices.REGIMES:
        _draw_regimes(axes, view)
    elif show == choices.SHARES or show.startswith(choices.SHARE):
        raise RequestError(f"show = {show!r} cannot be drawn into given axes: leave them out")
    elif show in view and (flags := view.flags(show)):
        codes = view[show].max(axis=-1)  # of several starts the highest
        colors = dict(zip(sorted(flags), cycle(palette.COUNTS), strict=False))  # pale to dark
        present = sorted(set(codes.ravel().tolist()))
        fill_classes(axes, view, codes, present, [colors.get(n, NO_VALUE) for n in present])
        names = {code: word.partition(".")[0] for code, word in flags.items()}
        names = {n: word.replace("_to_", ":").replace("_", " ") for n, word in names.items()}
        handles = [
            Patch(facecolor=colors.get(n, NO_VALUE), label=names.get(n, "none"), **frame)
            for n in present
        ]
        several = f", highest of {starts} starts" if starts > 1 else ""
        add_map_legend(axes, handles, clause(view.long_name(show)) + several)
    else:
        _draw_number(axes, view, show)


# ---- cells ---------------------------------------------------------------------------------------


def fill_cells(axes: Axes, view: ArchiveView, values: np.ndarray, **style: Any) -> QuadMesh:
    """Draw `values` (first parameter, second parameter), the outer cells up to their values."""
    across, up = (inner_edges(view[name]) for name in view.axes)
    mesh = axes.pcolormesh(across, up, values.T, shading="flat", rasterized=True, **style)
    for name, set_scale in zip(view.axes, (axes.set_xscale, axes.set_yscale), strict=True):
        if logarithmic(view[name]):
            set_scale("log")
    axes.set(xlim=across[[0, -1]], xlabel=axis_label(view.axes[0]))
    axes.set(ylim=up[[0, -1]], ylabel=axis_label(view.axes[1]))
    return mesh


def fill_classes(
    axes: Axes, view: ArchiveView, names: np.ndarray, words: Sequence[object], shades: Sequence[str]
) -> None:
    number = {word: i for i, word in enumerate(words)}
    classes = np.vectorize(number.__getitem__, otypes=[np.int64])(names)
    norm = BoundaryNorm(np.arange(len(words) + 1) - 0.5, len(words))
    fill_cells(axes, view, classes, cmap=ListedColormap(list(shades)), norm=norm)


def hatch_cells(
    axes: Axes, view: ArchiveView, where: np.ndarray, look: tuple[str, str], text: str
) -> Patch:
    """Hatch cells in a `look`, a hatch and its color; return the legend's patch, named `text`."""
    x, y = (inner_edges(view[name]) for name in view.axes)
    steps = np.diff(np.pad(where.T, ((0, 0), (1, 1))).astype(np.int8))
    # runs of cells: in each row as many begin as end
    pairs = zip(np.argwhere(steps > 0), np.argwhere(steps < 0)[:, 1], strict=True)
    boxes = [
        [(x[a], y[row]), (x[b], y[row]), (x[b], y[row + 1]), (x[a], y[row + 1])]
        for (row, a), b in pairs
    ]
    style: dict[str, Any] = {"facecolor": "none", "edgecolor": look[1], "linewidth": 0}
    axes.add_collection(PolyCollection(boxes, hatch=look[0], **style), autolim=False)
    return Patch(hatch=look[0], label=text, **style)


def hatch_passed(axes: Axes, view: ArchiveView) -> list[Patch]:
    """Hatch the cells in which an orbit passes the limit; return the entries of the legend."""
    passed = np.asarray(choices.violated_in(view).any(axis=-1))
    return [hatch_cells(axes, view, passed, _PASSED, PASSES)] if passed.any() else []


def add_map_legend(axes: Axes, handles: Sequence[Any], title: str) -> None:
    add_legend(axes, handles, "below", title=title, handlelength=1.2, columnspacing=1.0)


_SIZE = 7  # pt, of the name of a region
_PADDING = 4  # pt between a name and the border of its region
_LONGEST = 14  # characters of a name that is written inside


def name_regions(
    axes: Axes, view: ArchiveView, names: np.ndarray, shades: Mapping[str, str]
) -> None:
    """Write each name of `shades` into the largest circle of its cells, if it fits there."""
    from scipy.ndimage import distance_transform_edt

    wide, tall = size_of(axes)
    sides = wide / names.shape[0], tall / names.shape[1]
    for word, color in shades.items():
        text = palette.short(word)
        if len(text) > _LONGEST:
            continue
        inside = np.pad(names == word, 1)
        depth = distance_transform_edt(inside, sampling=sides)[1:-1, 1:-1]
        place = np.unravel_index(np.argmax(depth), depth.shape)
        half = text_width(text, _SIZE) / 2 + _PADDING
        x, y = (view[name][index] for name, index in zip(view.axes, place, strict=True))
        left = axes.transAxes.inverted().transform(axes.transData.transform((x, y)))[0] * wide
        # depths reach to the centers of other cells, and the first and last cells end at theirs
        if half > min(depth[place] - max(sides) / 2, left, wide - left):
            continue
        ink = "white" if palette.is_dark(color) else "black"
        axes.text(x, y, text, color=ink, fontsize=_SIZE, ha="center", va="center")


# ---- regimes and codes ---------------------------------------------------------------------------


def _regimes_of(view: ArchiveView) -> np.ndarray:
    """Return the regimes (axes) of the cells; of several starts the most frequent."""
    labels = view["label"]
    labels = most_frequent(labels) if labels.shape[-1] > 1 else labels[..., 0]
    return np.vectorize(palette.drawn_as, otypes=[object])(labels)


def name_regimes(axes: Axes, view: ArchiveView) -> None:
    """Write the names of regimes into a map of final size, except on hatched cells."""
    names = _regimes_of(view)
    free = np.where(choices.violated_in(view).any(axis=-1), "", names)
    words = palette.in_order(set(names.ravel().tolist()))
    shades = {word: palette.color_of(palette.example_of(word)) for word in words}
    name_regions(axes, view, free, {k: v for k, v in shades.items() if not palette.hatch_of(k)})


def _draw_regimes(axes: Axes, view: ArchiveView) -> None:
    """Color every cell by its regime; hatched are unknown ones and those reached through chaos."""
    names = _regimes_of(view)
    words = [word for word, _ in by_frequency(names)]
    shades = [palette.color_of(palette.example_of(word)) for word in words]
    fill_classes(axes, view, names, words, shades)
    marks: list[Patch] = []
    if (unknown := names == palette.HATCHED).any():
        hatch_cells(axes, view, unknown, (palette.hatch_of(palette.HATCHED), GRAY), "")
    late = np.vectorize(lambda name: name.startswith(TRANSIENT), otypes=[bool])(names)
    if late.any():
        marks.append(hatch_cells(axes, view, late, (palette.THROUGH_CHAOS, "black"), _CHAOTIC))
    marks += hatch_passed(axes, view)
    ends = np.vectorize(final, otypes=[object])(names)
    counts = dict(by_frequency(ends))
    large = [word for word, count in counts.items() if count > _NAMED_SHARE * names.size]
    room = _MOST_BELOW - len(marks)
    # if there is room for all, all are named
    shown = len(counts) if len(counts) <= room else max(room - 1, len(large))
    named = palette.in_order(list(counts)[:shown])
    handles = []
    for word in named:
        look = palette.patch_look(palette.example_of(word))
        handles.append(Patch(label=choices.in_legend(palette.short(word), view), **look))
    if len(counts) > len(named):
        handles.append(Patch(color="none", label=f"and {len(counts) - len(named)} more"))
    title = "most frequent regime" if view["start"].size > 1 else "regime"
    add_map_legend(axes, [*handles, *marks], title)


# ---- numbers -------------------------------------------------------------------------------------


_TWO_SIDED = "PuOr_r"  # matplotlib's name of shades with a zero in their middle; color-blind-safe
_EXTREME = 0.5  # per cent of the cells at either end that do not stretch a two-sided scale
_NARROWEST = 1e-12  # least reach of a two-sided scale to either side
_UNEVEN = 3.0  # how much farther one side of it may reach than the other: colors have equal steps
_LIGHTER = 0.36  # of the shades above zero: their end is lighter than that below, in gray as well
_DEEPEST = 1e-4  # of the largest number: smaller ones have the darkest shade by logarithm
_WIDE = 8.0  # ratio of the largest to a small value from which shades are logarithmic by themselves
_SETTLED_LATE = 10.0  # forcing periods, least upper end of the scale of settling times
_NONE = "none found"


def _draw_number(axes: Axes, view: ArchiveView, show: str) -> None:
    """Fill cells by a recorded number: of several starts the largest, gray where there is none."""
    scale, name = choices.scale_and_quantity(show)
    quantity = choices.quantities_in(view)[name]
    values = quantity.of(view)[..., 0]
    values = np.where(np.isfinite(values), values, -np.inf).max(axis=-1)
    unsettled = np.zeros(values.shape, dtype=bool)
    if scale_of(name) == WAIT:
        unsettled |= (view[name] < 0).any(axis=-1)
    shown = np.ma.masked_where(unsettled | ~np.isfinite(values), values)
    shades, norm = _scale(quantity.dataset, shown, scale)
    mesh = fill_cells(axes, view, shown, cmap=shades.with_extremes(bad=NO_VALUE), norm=norm)
    marks: list[Any] = []
    if unsettled.any():
        covered = np.ma.masked_where(~unsettled, np.ones(values.shape))
        fill_cells(axes, view, covered, cmap=ListedColormap([palette.OTHERS["chaos"]]))
        words = "not settled, or no orbit to settle on"
        marks.append(Patch(facecolor=palette.OTHERS["chaos"], label=words))
    if np.any(~np.isfinite(values) & ~unsettled):
        marks.append(Patch(facecolor=NO_VALUE, label=_NONE))
    marks += hatch_passed(axes, view)
    if marks:
        add_legend(axes, marks, "above", handlelength=1.2)
    several = f", largest of {view['start'].size} starts" if view["start"].size > 1 else ""
    percent = PercentFormatter(1.0, decimals=0) if name == REDUCTION else None
    look = {**BAR, "label": quantity.label + several, "extend": "neither"}
    if norm.vmin is not None and norm.vmax is not None and not norm.clip and shown.count():
        beyond = bool(shown.min() < norm.vmin), bool(shown.max() > norm.vmax)
        look["extend"] = {(1, 1): "both", (1, 0): "min", (0, 1): "max"}.get(beyond, "neither")
    bar = axes.figure.colorbar(mesh, ax=axes, format=percent, **look)
    if scale_of(name) == PERIOD:
        most = len(palette.RAMP)
        bar.ax.set_yticks(range(1, most + 1), [*map(str, range(1, most)), f"{most} or more"])
        bar.ax.tick_params(which="both", length=0)
    elif isinstance(mesh.norm, LogNorm):
        write_out_ticks(bar.ax.yaxis)
    else:
        bar.ax.yaxis.set_minor_formatter(NullFormatter())
    low, high = mesh.get_clim()
    if low is not None and high is not None and low < 0.0 < high:
        bar.ax.axhline(0.0, color="black", linewidth=0.8)


def _scale(name: str, shown: np.ma.MaskedArray, chosen: str) -> tuple[Colormap, Normalize]:
    """Return how the values of a dataset become shades; `chosen` is one of `SCALES`, or empty."""
    values, plain, scale = shown.compressed(), colormaps[SHADES], scale_of(name)
    if scale == PERIOD:
        most = len(palette.RAMP)
        bounds = np.arange(most + 1) + 0.5
        norm = BoundaryNorm(bounds, most, extend="neither", clip=True)
        return ListedColormap(list(palette.RAMP)), norm
    if scale == ERROR:
        low = max(values[values > 0].min(initial=np.inf), ROUND_OFF)
        high = values.max(initial=0.0)
        low, high = (low, high) if low < high else (ROUND_OFF, 1.0)
        return plain, LogNorm(low, high, clip=True)
    if scale == WAIT:
        return plain, LogNorm(1, max(_SETTLED_LATE, values.max(initial=0.0)), clip=True)
    low, high = values.min(initial=0.0), values.max(initial=0.0)
    least = values.min(initial=np.inf)
    small = max(least, high * _DEEPEST) if least > 0.0 else 0.0
    if chosen == choices.LOG and not 0.0 < small < high:
        raise RequestError(f"show = '{choices.LOG}{name}': it takes numbers above 0 that differ")
    signed = scale == SIGNED or low < 0.0 < high
    if chosen == choices.LOG or (not chosen and not signed and 0.0 < small * _WIDE < high):
        return plain, LogNorm(small, high)
    if not signed or not values.size:
        return plain, Normalize()
    # a step of the number is the same step of color on either side of zero; what lies beyond an end
    # of the scale has the color of that end
    two_sided = colormaps[_TWO_SIDED]
    values = np.maximum(values, -1.0) if name == REDUCTION else values
    low, high = np.percentile(values, [_EXTREME, 100 - _EXTREME])
    if low < 0.0 < high:
        reach = max(min(max(-low, high), _UNEVEN * min(-low, high)), _NARROWEST)
        ends = max(low, -reach), min(high, reach)
        part = np.linspace(*ends, 256) / reach
        places = 0.5 + np.where(part < 0.0, 0.5, _LIGHTER) * part
        return ListedColormap(two_sided(places)), Normalize(*ends)
    shades = np.linspace(0.5, 1.0, 256) if high > 0.0 else np.linspace(0.0, 0.5, 256)
    return ListedColormap(two_sided(shades)), Normalize(min(low, 0.0), max(high, 0.0) or _NARROWEST)


_MOST, _COLUMNS = 6, 2  # small maps of one picture, and of one row
_SMALL = 5.2 * CM  # inches, height of one of them


def _draw_shares(view: ArchiveView, show: str, page: Page) -> tuple[Figure, GridSpec, list[Axes]]:
    """Return figure, grid and panels; `RequestError` if no start ended in a known regime."""
    labels = view["label"]
    text = f"share of {labels.shape[-1]} starts"
    if show.startswith(choices.SHARE):
        wanted = [show.removeprefix(choices.SHARE)]
        text += f" in {literal(wanted[0])}"
    else:
        ends = [label for label, _ in by_frequency(finals(labels)) if label not in UNKNOWN]
        wanted = ends[:_MOST]
    if not wanted:
        raise RequestError(f"{view.path}: no start ended in a known regime, so there is no share")
    columns = 1 if len(wanted) == 1 or not page.beside else _COLUMNS
    height = _SMALL if len(wanted) > 1 else page.map_height
    figure, grid = new_figure(page, [height] * -(-len(wanted) // columns), columns)
    panels: list[Axes] = []
    for place, name in enumerate(wanted):
        first = panels[0] if panels else None
        axes = figure.add_subplot(grid[divmod(place, columns)], sharex=first, sharey=first)
        shares = share_of(labels, name)
        mesh = fill_cells(axes, view, shares, cmap=SHADES, norm=Normalize(0, 1))
        if len(wanted) > 1:
            axes.set_title(name, fontsize=rcParams["font.size"], pad=3)
        panels.append(axes)
        axes.label_outer()
    # the lowest panel of each column, which is in the row above if the last row is not full
    for axes in panels[-columns:]:
        axes.set_xlabel(axis_label(view.axes[0]))
        axes.tick_params(labelbottom=True)
    percent = PercentFormatter(1.0, decimals=0)
    bar = {**BAR, "aspect": BAR["aspect"] * grid.nrows}
    figure.colorbar(mesh, ax=panels, label=text, format=percent, **bar)
    return figure, grid, panels


# ---- the 1:1 response in closed form -------------------------------------------------------------


IN_TITLE = "dashed: bounds of 1:1 motion in closed form"  # of the lines of `draw_manifold`
_HALVED = 14  # times, the step between two values, to find where the response ends
_MOST_VALUES = 120  # values of the other parameter at which the bounds are computed


def draw_manifold(panels: list[Axes], view: ArchiveView) -> None:
    """Draw the lowest and the highest frequency of the 1:1 response into the panels of a map."""
    values, *bounds = manifold_bounds(view)
    look: dict[str, Any] = {"color": "white", "linewidth": 0.9, "linestyle": (0, (5, 2))}
    look |= {"path_effects": [Stroke(linewidth=1.9, foreground="black"), Normal()]}
    for axes in panels:
        for bound in bounds:
            line = (bound, values) if view.axes[0] == "omega" else (values, bound)
            axes.plot(*line, scalex=False, scaley=False, **look)


def manifold_bounds(view: ArchiveView) -> np.ndarray:
    """Return values of the other parameter and the bounds of omega [rad/s], or NaN: (3, n)."""
    if "omega" not in view.axes or not all(name in PARAMETERS for name in view.axes):
        over = " and ".join(view.axes)
        raise RequestError(f"manifold: for maps of omega and another parameter; this is of {over}")
    (other,) = (name for name in view.axes if name != "omega")
    values = view[other]
    if values.size > _MOST_VALUES:
        values = np.interp(np.linspace(0, 1, _MOST_VALUES), np.linspace(0, 1, values.size), values)
    system = view.request(SCAN, load_scan).system

    def bounds(value: float) -> tuple[float, float]:
        manifold = free_mass_manifold(system.with_(**{other: float(value)}))
        outline, _ = manifold.response().outline
        frequencies = outline[np.isfinite(outline)]
        return (frequencies.min(), frequencies.max()) if frequencies.size else (np.nan, np.nan)

    rows = [(value, *bounds(value)) for value in values]
    ends = []  # the last values at which there is a response, by bisection
    for before, after in pairwise(rows):
        if np.isnan(before[1]) != np.isnan(after[1]):
            inside, outside = (after, before[0]) if np.isnan(before[1]) else (before, after[0])
            for _ in range(_HALVED):
                middle = 0.5 * (inside[0] + outside)
                row = (middle, *bounds(middle))
                inside, outside = (inside, middle) if np.isnan(row[1]) else (row, outside)
            ends.append(inside)
    return np.array(sorted([*rows, *ends])).T


# ---- basins of attraction ------------------------------------------------------------------------


_SHADES = (("#000000", 0.0), ("#000000", 0.35), ("#ffffff", 0.45), ("#000000", 0.6))
"""What is mixed into the color of a regime, by how much: of its first attractor, the second ..."""


class _Look(NamedTuple):
    name: str  # of an attractor
    color: str
    label: str  # its regime; empty if not known


_UNKNOWN = _Look("not known", palette.OTHERS[palette.HATCHED], "")


def why_no_basins(view: ArchiveView) -> str:
    """Return why an archive has no basins to draw, as a remedy; empty if it has."""
    if "attractor" not in view:
        return "scan with --record attractor"
    if "attractor_share" not in view:
        return "no attractor was found"
    varied = _parameters(view)
    if len(varied) == 1 or (len(view.axes) == 2 and not varied):
        return ""
    return "vary two initial conditions, or one parameter"


def _parameters(view: ArchiveView) -> list[str]:
    return [name for name in view.axes if name not in INITIAL]


def draw_basins(view: ArchiveView, page: Page = TWO_COLUMNS, ax: Axes | None = None) -> Figure:
    """Return the figure of a scan's basins: a map, shares along a parameter, or both."""
    varied, has_map = _parameters(view), len(view.axes) == 2
    grid, panels = None, [ax] if ax is not None else []
    if not panels:
        figure, grid = new_figure(page, [page.map_height] * (has_map + len(varied)))
        panels = [figure.add_subplot(grid[row]) for row in range(grid.nrows)]
    if has_map:
        handles, names, shades = fill_basins(panels[0], view)
    if varied and (grid is not None or not has_map):
        handles = fill_shares(panels[-1], view)
    add_map_legend(panels[-1], handles, "attractor")
    if grid is not None:
        if len(panels) > 1 and view.axes[0] == varied[0]:
            panels[1].set_xlim(panels[0].get_xlim())
        write_letters(panels)
        finish(figure, grid, view.text("title"))
    if has_map:
        name_regions(panels[0], view, names, shades)
    return figure_of(panels[0])


def fill_basins(axes: Axes, view: ArchiveView) -> tuple[list[Any], np.ndarray, dict[str, str]]:
    """Color cells by attractor; return legend handles, names of the cells and colors of names."""
    (looks, table), varied = _looks(view), _parameters(view)
    numbers = view["attractor"][..., 0]
    places = zip(view.axes, np.indices(numbers.shape), strict=True)
    where = [place for name, place in places if name in varied]
    codes = np.where(numbers >= 0, table[(*where, np.maximum(numbers, 0))], 0)
    present = np.unique(codes).tolist()
    fill_classes(axes, view, codes, present, [looks[code].color for code in present])
    handles = _patches_of([looks[code] for code in present])
    names = np.array([look.name for look in looks], object)[codes]
    shades = {looks[code].name: looks[code].color for code in present if code}
    if varied or not begins_at_sections(view):
        return handles, names, shades
    style: dict[str, Any] = {"marker": "o", "linestyle": "none", "markeredgecolor": "black"}
    style |= {"markersize": 5.0, "markeredgewidth": 0.9}
    components = view["component"].tolist()
    columns = [components.index(component_of(name)) for name in view.axes]
    spans = np.array([view[name][[0, -1]] for name in view.axes]).T
    points = view["attractor_point"][:, columns]
    inside = np.flatnonzero(((points >= spans[0]) & (points <= spans[1])).all(axis=1))
    for k in inside.tolist():
        color = palette.mixed(looks[table[k]].color, "#ffffff", 0.5)
        axes.plot(*points[k], markerfacecolor=color, zorder=5, **style)
    if inside.size:
        text = "points of attractors" + (",\nprojected" if len(components) > 2 else "")
        handles.append(Line2D([], [], markerfacecolor="white", label=text, **style))
    return handles, names, shades


def fill_shares(axes: Axes, view: ArchiveView) -> list[Any]:
    """Draw the attractors' shares along the parameter as stacked bars; return legend handles."""
    (name,), (looks, table), shares = _parameters(view), _looks(view), view["attractor_share"]
    edges, floor = inner_edges(view[name]), np.zeros(len(shares))
    style: dict[str, Any] = {"align": "edge", "lw": 0}
    for column, codes in zip(np.nan_to_num(shares).T, table.T, strict=True):
        colors = [looks[code].color if code else "none" for code in codes]
        axes.bar(edges[:-1], column, np.diff(edges), floor, color=colors, **style)
        floor += column
    axes.bar(edges[:-1], 1 - floor, np.diff(edges), floor, color=_UNKNOWN.color, **style)
    axes.set(xlim=(edges[0], edges[-1]), ylim=(0, 1))
    axes.set(xlabel=axis_label(name), ylabel="share of the starts")
    return _patches_of(looks if (floor < 1 - 1e-12).any() else looks[1:])


def _looks(view: ArchiveView) -> tuple[list[_Look], np.ndarray]:
    """Return the different looks, `_UNKNOWN` first, and the index of each row of the table."""
    labels = view["attractor_label"]
    looks, table = [_UNKNOWN], np.zeros(labels.shape, int)
    for label in sorted({str(label) for label in labels.flat if label}):
        numbers = [k for k in range(labels.shape[-1]) if (labels[..., k] == label).any()]
        is_long = palette.drawn_as(label) != label
        for i, k in enumerate(numbers):
            name = palette.drawn_as(label) if is_long or len(numbers) == 1 else f"{label} ({k})"
            shade = _SHADES[0 if is_long else i % len(_SHADES)]
            look = _Look(
                name, palette.mixed(palette.color_of(label), *shade), palette.drawn_as(label)
            )
            looks += [look] * (look not in looks)
            table[..., k][labels[..., k] == label] = looks.index(look)
    return looks, table


def _patches_of(looks: Iterable[_Look]) -> list[Any]:
    """Return the handles of a legend, by period, cells without a known attractor last."""
    order = [*palette.in_order({look.label for look in looks if look.label}), ""]
    handles = []
    for look in sorted(looks, key=lambda look: (order.index(look.label), look.name)):
        style = palette.patch_look(palette.example_of(look.label), look.color)
        handles.append(Patch(label=look.name, **style))
    return handles
