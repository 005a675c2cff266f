"""Maps of two parameters: a color for each regime, or other code, and how many coexist."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.bifurcation.observation_time import in_legend
from nlds_vines.bifurcation.picture.choices import COEXISTING, REGIMES, SHARE, SHARES
from nlds_vines.bifurcation.picture.dot_panel import PASSES
from nlds_vines.bifurcation.picture.manifold_bounds import IN_TITLE, draw_manifold
from nlds_vines.bifurcation.picture.map_panel import (
    FOOT,
    HEAD,
    add_map_legend,
    fill_classes,
    hatch_cells,
    label_axes,
    map_panel,
    name_regions,
    single_map,
)
from nlds_vines.bifurcation.picture.ordinates import violated_in
from nlds_vines.bifurcation.picture.quantity_map import draw_number, draw_shares, fill_number
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import TRANSIENT, by_frequency, coexisting, final, most_frequent
from nlds_vines.model.quantity import clause
from nlds_vines.plotting.page import TWO_COLUMNS, Page, styled, write_letters
from nlds_vines.plotting.palette import (
    COUNTS,
    HATCHED,
    OTHERS,
    PASSED,
    THROUGH_CHAOS,
    color_of,
    drawn_as,
    example_of,
    hatch_of,
    in_order,
    patch_look,
    short,
)
from nlds_vines.plotting.panels import write_title
from nlds_vines.plotting.style import CM, GRAY, NO_VALUE

_GAP = 0.55 * CM  # inches between two maps
_LINE = 0.42 * CM  # inches, height of a name in a legend
_MOST_BELOW = 12  # names in a legend below a map
_CHAOTIC = "reached through chaos"


@styled()
def regime_map(
    view: ArchiveView, show: str, page: Page = TWO_COLUMNS, manifold: bool = False
) -> Figure:
    """Return the map of a scan of two parameters; the first runs to the right, the second up.

    Arguments: the archive; what to `show`, as checked by `choices.check_show`; the `page`:

    - `regimes`: a color for each regime; of several starts, the regime that most ended in, and in
      a second panel how many regimes coexist;
    - `coexisting`: that panel alone;
    - `share:LABEL`: the share of the starts that ended in a regime; `shares`: those of the most
      frequent regimes, side by side;
    - a recorded number: of several starts the largest; a code as `capture`: the highest.

    With `manifold` the bounds of 1:1 motion in closed form are drawn over it.
    """
    if show == SHARES or show.startswith(SHARE):
        figure = draw_shares(view, show, page)
    elif show == REGIMES and view["start"].size > 1:
        figure = _draw_both(view, page)
    elif show in (REGIMES, COEXISTING) or _is_code(view, show):
        figure, axes = single_map(view, page, 0.0 if page.beside else _below(page))
        fill_map(axes, view, show, page)
    else:
        figure = draw_number(view, show, page)
    starts = view["start"].size
    title = view.text("title") + (f"; {starts} starts" if starts > 1 else "")
    if manifold:
        draw_manifold(
            [axes for axes in figure.axes if _limits(axes) == _limits(figure.axes[0])], view
        )
        title += f"; {IN_TITLE}"
    write_title(figure, title, page.left / page.width)
    return figure


def fill_map(axes: Axes, view: ArchiveView, show: str, page: Page = TWO_COLUMNS) -> None:
    """Draw one map into axes, with its legend: regimes, how many coexist, or a number."""
    if show == COEXISTING:
        _draw_counts(axes, view, view["label"], page)
    elif show == REGIMES:
        several = view["start"].size > 1
        labels = most_frequent(view["label"]) if several else view["label"][..., 0]
        _draw_regimes(axes, view, labels, "most frequent regime" if several else "regime", page)
    elif show == SHARES or show.startswith(SHARE):
        raise RequestError(f"show = {show!r} cannot be drawn into given axes: leave them out")
    elif _is_code(view, show):
        fill_codes(axes, view, show, page)
    else:
        mesh, label, extend = fill_number(axes, view, show)
        axes.figure.colorbar(mesh, ax=axes, label=label, extend=extend)
    label_axes(axes, view)


def _limits(axes: Axes) -> tuple[Any, Any]:
    """Return the limits of both axes, which bars of colors do not share with maps."""
    return axes.get_xlim(), axes.get_ylim()


def _is_code(view: ArchiveView, show: str) -> bool:
    """Tell whether what is shown is a dataset of codes."""
    return show in view and view.is_flag(show)


def _below(page: Page) -> float:
    """Return the height in inches of a legend below a map."""
    rows = 2 + _MOST_BELOW // (page.columns + 1)
    return rows * _LINE


def _draw_both(view: ArchiveView, page: Page) -> Figure:
    """Return a figure with the most frequent regimes above how many coexist."""
    below = 0.0 if page.beside else _below(page)
    foot = 0.0 if page.beside else 3 * _LINE
    between = below + FOOT if below else _GAP
    figure = Figure(figsize=(page.width, HEAD + 2 * page.map_height + between + FOOT + foot))
    upper = map_panel(figure, FOOT + foot + page.map_height + between, page)
    lower = map_panel(figure, FOOT + foot, page)
    lower.sharex(upper)
    fill_map(upper, view, REGIMES, page)
    fill_map(lower, view, COEXISTING, page)
    if page.beside:
        upper.tick_params(labelbottom=False)
        upper.set_xlabel("")
    write_letters((upper, lower))
    return figure


def _draw_regimes(
    axes: Axes, view: ArchiveView, labels: np.ndarray, title: str, page: Page
) -> None:
    """Fill every cell with the color of its regime; the legend names the most frequent ones.

    Large regions have their names inside.  Hatched are regimes that were reached through chaos, and
    what is not known.
    """
    names = np.vectorize(drawn_as, otypes=[object])(labels)
    words = [word for word, _ in by_frequency(names)]
    shades = {word: color_of(example_of(word)) for word in words}
    fill_classes(axes, view, names, words, [shades[word] for word in words])
    marks = _hatch(axes, view, names)
    ends = list(dict.fromkeys(final(word) for word in words))
    room = _MOST_BELOW - len(marks)
    if page.beside:
        height = axes.bbox.height / axes.figure.dpi
        room = int(height / _LINE) - 1 - 2 * len(marks)  # names that fit
    named = in_order(ends if len(ends) <= room else ends[: room - 1])
    handles = [_patch(word, view) for word in named]
    if len(ends) > len(named):
        handles.append(Patch(color="none", label=f"and {len(ends) - len(named)} more"))
    add_map_legend(axes, [*handles, *marks], title, page)
    free = np.where(violated_in(view).any(axis=-1), "", names)  # where no hatch is in the way
    name_regions(axes, view, free, {word: shades[word] for word in words if not hatch_of(word)})


def _patch(word: str, view: ArchiveView) -> Patch:
    """Return the entry of a legend of a regime."""
    look = patch_look(example_of(word), color_of(example_of(word)))
    return Patch(label=in_legend(short(word), view), **look)


def _hatch(axes: Axes, view: ArchiveView, names: np.ndarray) -> list[Any]:
    """Hatch cells by their labels, and where the limit is passed; return entries of the legend."""
    found = []
    unknown = names == HATCHED
    if unknown.any():
        hatch_cells(axes, view, unknown, (hatch_of(HATCHED), GRAY), "")
    late = np.vectorize(lambda name: name.startswith(TRANSIENT), otypes=[bool])(names)
    if late.any():
        found.append(hatch_cells(axes, view, late, (THROUGH_CHAOS, "black"), _CHAOTIC))
    passed = np.asarray(violated_in(view).any(axis=-1))
    if passed.any():
        found.append(_hatch_passed(axes, view, passed))
    return found


def _hatch_passed(axes: Axes, view: ArchiveView, passed: np.ndarray) -> Patch:
    """Hatch the cells in which the limit is passed; return the entry of the legend."""
    return hatch_cells(axes, view, passed, (PASSED, "#8b0000"), PASSES)


def _draw_counts(axes: Axes, view: ArchiveView, labels: np.ndarray, page: Page) -> None:
    """Fill every cell with the color of how many of the found regimes coexist there."""
    most = len(COUNTS)
    counts = np.minimum(coexisting(labels), most)
    words = sorted(set(counts.ravel().tolist()))
    shades = {0: OTHERS[HATCHED], **dict(enumerate(COUNTS, start=1))}
    fill_classes(axes, view, counts, words, [shades[word] for word in words])
    names = {0: "none known", most: f"{most} or more"}
    frame: dict[str, Any] = {"edgecolor": GRAY, "linewidth": 0.4}  # the first is nearly white
    handles = [Patch(facecolor=shades[n], label=names.get(n, str(n)), **frame) for n in words]
    passed = np.asarray(violated_in(view).any(axis=-1))
    if passed.any():
        handles.append(_hatch_passed(axes, view, passed))
    add_map_legend(axes, handles, f"regimes found\nby {labels.shape[-1]} starts", page)


# ---- codes ---------------------------------------------------------------------------------------


def fill_codes(axes: Axes, view: ArchiveView, name: str, page: Page) -> None:
    """Fill every cell with the color of its code, of several starts the highest; with a legend.

    Colors go from pale to dark in the order of the codes, and begin anew where they are many.
    """
    codes, words = view[name].max(axis=-1), view.flags(name)
    found = sorted(set(codes.ravel().tolist()))
    shades = {code: COUNTS[i % len(COUNTS)] for i, code in enumerate(sorted(words))}
    looks = {code: shades.get(code, NO_VALUE) for code in found}
    fill_classes(axes, view, codes, found, list(looks.values()))
    frame: dict[str, Any] = {"edgecolor": GRAY, "linewidth": 0.4}  # the first is nearly white
    handles = [
        Patch(facecolor=color, label=_in_words(words.get(code, "none")), **frame)
        for code, color in looks.items()
    ]
    title = clause(view.long_name(name))
    several = f"\nhighest of {view['start'].size} starts" if view["start"].size > 1 else ""
    add_map_legend(axes, handles, _broken(title) + several, page)


def _in_words(flag: str) -> str:
    """Return a flag as a legend has it: `sustained 1:1` of `sustained_1_to_1`."""
    return flag.partition(".")[0].replace("_to_", ":").replace("_", " ")


def _broken(text: str) -> str:
    """Return a title in two lines of about one length, as a legend has room for."""
    words = text.split(" ")
    ends = np.cumsum([len(word) + 1 for word in words])
    half = int(np.argmin(np.abs(ends - ends[-1] / 2))) + 1
    return "\n".join(filter(None, (" ".join(words[:half]), " ".join(words[half:]))))
