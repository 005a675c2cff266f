"""What pictures have in common: titles, panels and their letters, color bars, widths of text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from nlds_vines.plotting.notation import typeset
from nlds_vines.plotting.page import letter as letter
from nlds_vines.plotting.page import lines_of, size_of
from nlds_vines.plotting.page import text_width as text_width
from nlds_vines.plotting.page import write_letters as write_letters
from nlds_vines.plotting.page import write_out_ticks as write_out_ticks
from nlds_vines.plotting.style import CM, LEFT

_TITLE_EDGE = 0.15 * CM  # inches between an edge of a figure and its title
_TITLE_LINE = 0.48 * CM  # inches, height of a line of a title
_LABEL = 0.42 * CM  # inches from the edge of a figure to the foot of labels along it
_BAR_GAP, _BAR_WIDTH = 0.02, 0.023  # fractions of the figure's width


def write_title(figure: Figure, text: str, left: float = LEFT, below: str = "") -> None:
    """Write the title of a picture at its top, `left` as a fraction of the figure's width.

    Arguments: the title, plain text (`notation.typeset`); a line `below` it, with formulas.  Where
    the title is too long for one line, the figure grows at its top.
    """
    parts, width = [typeset(text), *filter(None, [below])], (1 - left) * figure.get_figwidth()
    lines = [line for part in parts for line in lines_of(part, width - _TITLE_EDGE)]
    grow(figure, _TITLE_LINE * (len(lines) - len(parts)))
    words = "\n".join(lines)
    figure.text(left, 1 - _TITLE_EDGE / figure.get_figheight(), words, va="top")


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
