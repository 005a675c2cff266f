"""What pictures have in common: titles, panels and their letters, color bars, widths of text."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from math import log10
from typing import Any

from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import Bbox

from nlds_vines.plotting.notation import typeset
from nlds_vines.plotting.style import CM, LEFT

_TITLE_EDGE = 0.15 * CM  # inches between an edge of a figure and its title
_TITLE_LINE = 0.48 * CM  # inches, height of a line of a title
_CLAUSE = re.compile(r"(?<=[,;:]) ")  # where a title may be broken
_LABEL = 0.42 * CM  # inches from the edge of a figure to the foot of labels along it
_DECADE = 60  # points of a decade below which 2 and 5 have no room between 1 and 10
_FEWEST = 3  # numbers along a logarithmic axis
_BAR_GAP, _BAR_WIDTH = 0.02, 0.023  # fractions of the figure's width


def write_title(figure: Figure, text: str, left: float = LEFT, below: str = "") -> None:
    """Write the title of a picture at its top, `left` as a fraction of the figure's width.

    Arguments: the title, plain text (`notation.typeset`); a line `below` it, with formulas.  Where
    the title is too long for one line, the figure grows at its top.
    """
    parts, width = [typeset(text), *filter(None, [below])], (1 - left) * figure.get_figwidth()
    lines = [line for part in parts for line in _lines_of(part, width - _TITLE_EDGE)]
    grow(figure, _TITLE_LINE * (len(lines) - len(parts)))
    words = "\n".join(lines)
    figure.text(left, 1 - _TITLE_EDGE / figure.get_figheight(), words, va="top")


def _lines_of(text: str, width: float) -> list[str]:
    """Return the lines of a title of at most so many inches, broken after a comma or a colon."""
    size = FontProperties(size=rcParams["font.size"]).get_size_in_points()
    first, *others = _CLAUSE.split(text)
    lines = [first]
    for clause in others:
        longer = f"{lines[-1]} {clause}"
        if text_width(longer, size) <= 72 * width:
            lines[-1] = longer
        else:
            lines.append(clause)
    return lines


def grow(figure: Figure, extra: float) -> None:
    """Make a figure so many inches higher at its top; all that is in it keeps size and place."""
    if not extra:
        return
    before = figure.get_figheight()
    share = before / (before + extra)
    boxes = [axes.get_position() for axes in figure.axes]
    to_figure = figure.transFigure.inverted()
    anchors = [one.get_bbox_to_anchor().transformed(to_figure) for one in figure.legends]
    figure.set_figheight(before + extra)
    for axes, box in zip(figure.axes, boxes, strict=True):
        axes.set_position((box.x0, box.y0 * share, box.width, box.height * share))
    for legend, box in zip(figure.legends, anchors, strict=True):
        anchor = (box.x0, box.y0 * share, box.width, box.height * share)
        legend.set_bbox_to_anchor(anchor, transform=figure.transFigure)
    for words in figure.texts:
        words.set_y(words.get_position()[1] * share)


def add_panel(figure: Figure, box: Sequence[float], **options: Any) -> Axes:
    """Return new axes at `box` = (left, bottom, width, height) in inches; options of `add_axes`."""
    left, bottom, width, height = box
    wide, tall = figure.get_size_inches()
    return figure.add_axes((left / wide, bottom / tall, width / wide, height / tall), **options)


def letter(index: int) -> str:
    """Return the letter of a panel by its place, from 0: (a) ... (z), (aa) ... (zz)."""
    return f"({chr(ord('a') + index % 26) * (1 + index // 26)})"


def write_letters(panels: Sequence[Axes]) -> None:
    """Write (a), (b) ... above the left corners of panels, where they hide nothing."""
    if len(panels) < 2:
        return
    look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    for place, axes in enumerate(panels):
        axes.annotate(letter(place), (0, 1), (0, 2.5), ha="left", va="bottom", **look)


def align_labels(panels: Sequence[Axes], left: float) -> None:
    """Put the labels of ordinates into one line, near the edge `left` inches beside the panels."""
    for axes in panels:
        axes.yaxis.set_label_coords((_LABEL - left) / (size_of(axes)[0] / 72), 0.5)


def add_color_bar(
    figure: Figure, shaded: ScalarMappable, box: Bbox, label: str, **options: Any
) -> Colorbar:
    """Return a color bar to the right of panels, as high as they are.

    Arguments: the `figure`; what is `shaded`, a mesh; `box`, the place of the panel, or of all that
    share the bar, in fractions of the figure; the bar's `label`; options of `Figure.colorbar`.
    """
    axes = figure.add_axes((box.x1 + _BAR_GAP, box.y0, _BAR_WIDTH, box.height))
    bar = figure.colorbar(shaded, cax=axes, **options)
    bar.set_label(label)
    return bar


def logarithmic_ticks() -> LogLocator:
    """Return the rule for ticks at 1, 2, 5, 10, 20, ..."""
    return LogLocator(subs=(1.0, 2.0, 5.0))


def write_out_ticks(axis: Axis) -> None:
    """Mark 1, 2, 5, 10, ... on a logarithmic axis, or decades alone where there is little room.

    Where that would be fewer than three numbers, all digits of a decade are marked.
    """
    low, high = axis.get_view_interval()
    length = size_of(axis.axes)[axis is axis.axes.yaxis]
    few = length < _DECADE * log10(high / low)
    rule = LogLocator() if few else logarithmic_ticks()
    if sum(low <= value <= high for value in rule.tick_values(low, high)) < _FEWEST:
        rule = LogLocator(subs=tuple(map(float, range(1, 10))))
    axis.set_major_locator(rule)
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def size_of(axes: Axes) -> tuple[float, float]:
    """Return width and height of axes in points."""
    point = 72 / float(axes.figure.dpi)
    return point * float(axes.bbox.width), point * float(axes.bbox.height)


def text_width(text: str, size: float) -> float:
    """Return the width of a text in points, at a font size in points, without drawing it."""
    font = FontProperties(family=rcParams["font.family"], size=size)
    with warnings.catch_warnings():
        # a title may be in a script that no font here has: it is drawn as boxes
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        return float(TextPath((0, 0), text, prop=font).get_extents().width)
