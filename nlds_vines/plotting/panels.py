"""What pictures have in common: titles, panels and their letters, colour bars, widths of text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from matplotlib.transforms import Bbox

from nlds_vines.plotting.notation import typeset
from nlds_vines.plotting.style import CM, LEFT

MAP_WIDTH = 0.665
"""Width of a single map, as a fraction of the figure's: what is left beside a legend or a bar."""

_TITLE_EDGE = 0.15 * CM  # inches between the upper edge of a figure and its title
_LETTER_OFFSET = 5  # points between the corner of a panel and its letter
_PAPER = {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.8}
"""The ground of a letter: curves below it stay visible, and the letter stays legible."""

_BAR_GAP, _BAR_WIDTH = 0.02, 0.023  # fractions of the figure's width


def write_title(figure: Figure, text: str, left: float = LEFT, below: str = "") -> None:
    """Write the title of a picture at its top, `left` as a fraction of the figure's width.

    Arguments: the title, plain text (`notation.typeset`); a line `below` it, with formulas.
    """
    lines = "\n".join(filter(None, [typeset(text), below]))
    figure.text(left, 1 - _TITLE_EDGE / figure.get_figheight(), lines, va="top")


def add_panel(figure: Figure, box: Sequence[float], **options: Any) -> Axes:
    """Return new axes at `box` = (left, bottom, width, height) in inches; options of `add_axes`."""
    left, bottom, width, height = box
    wide, tall = figure.get_size_inches()
    return figure.add_axes((left / wide, bottom / tall, width / wide, height / tall), **options)


def letter(index: int) -> str:
    """Return the letter of a panel by its place, from 0: (a) ... (z), (aa) ... (zz)."""
    return f"({chr(ord('a') + index % 26) * (1 + index // 26)})"


def write_letters(
    panels: Sequence[Axes], side: str = "left", letters: Sequence[str] | None = None
) -> None:
    """Write (a), (b) ... into the upper corners of panels; a single panel gets none.

    Arguments: `side` is "left" or "right", the corner of the panel where curves leave room; what
    is written in place of one `letter` after another.
    """
    if len(panels) < 2:
        return
    corner, step = ((0, 1), 1) if side == "left" else ((1, 1), -1)
    look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    look |= {"ha": side, "va": "top", "bbox": _PAPER, "zorder": 9}
    for text, axes in zip(letters or map(letter, range(len(panels))), panels, strict=True):
        axes.annotate(text, corner, (step * _LETTER_OFFSET, -_LETTER_OFFSET), **look)


def add_colour_bar(
    figure: Figure, shaded: ScalarMappable, box: Bbox, label: str, **options: Any
) -> Colorbar:
    """Return a colour bar to the right of panels, as high as they are.

    Arguments: the `figure`; what is `shaded`, a mesh; `box`, the place of the panel, or of all that
    share the bar, in fractions of the figure; the bar's `label`; options of `Figure.colorbar`.
    """
    axes = figure.add_axes((box.x1 + _BAR_GAP, box.y0, _BAR_WIDTH, box.height))
    bar = figure.colorbar(shaded, cax=axes, **options)
    bar.set_label(label)
    return bar


def size_of(axes: Axes) -> tuple[float, float]:
    """Return width and height of axes in points."""
    point = 72 / float(axes.figure.dpi)
    return point * float(axes.bbox.width), point * float(axes.bbox.height)


def write_letters_above(panels: Sequence[Axes]) -> None:
    """Write (a), (b) ... above the left corners of panels, where they hide nothing."""
    if len(panels) < 2:
        return
    look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    for place, axes in enumerate(panels):
        axes.annotate(letter(place), (0, 1), (0, 2.5), ha="left", va="bottom", **look)


def text_width(text: str, size: float) -> float:
    """Return the width of a text in points, at a font size in points, without drawing it."""
    font = FontProperties(family=rcParams["font.family"], size=size)
    return float(TextPath((0, 0), text, prop=font).get_extents().width)
