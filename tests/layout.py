"""Where the texts of a picture stand: which overlap, and which are cut."""

from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

_TOUCH = 2.4  # points by which the boxes of two texts may overlap: boxes are larger than letters


def collisions(figure):
    """Draw a figure and return a line for each text that is cut or overlaps another.

    Two texts must not overlap, and none may reach beyond the figure.  Numbers of ticks outside the
    limits of their axis are not drawn and do not count.
    """
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer, shrink = canvas.get_renderer(), _TOUCH * figure.dpi / 72 / 2
    boxes = []
    for text in _texts(figure):
        box = Text.get_window_extent(text, renderer)
        boxes.append((text.get_text(), box))
    page = figure.bbox.padded(0.5)
    cut = [
        f"{words!r} is cut"
        for words, box in boxes
        if box.x0 < page.x0 or box.y0 < page.y0 or box.x1 > page.x1 or box.y1 > page.y1
    ]
    return cut + [
        f"{one!r} lies over {other!r}"
        for (one, a), (other, b) in combinations(boxes, 2)
        if a.padded(-shrink).overlaps(b.padded(-shrink))
    ]


def _texts(figure):
    """Yield the texts of a figure that are drawn."""
    axes_of = [*figure.axes, *(child for axes in figure.axes for child in axes.child_axes)]
    hidden = {axes for axes in axes_of if not axes.axison}
    ticks = {}
    for axes in axes_of:
        for axis in (axes.xaxis, axes.yaxis):
            shown = axis.get_visible() and axes not in hidden
            drawn = axis._update_ticks() if shown else []
            for tick in (*axis.majorTicks, *axis.minorTicks):
                ticks[tick.label1] = ticks[tick.label2] = tick in drawn
            ticks[axis.label] = ticks[axis.offsetText] = shown
    for text in figure.findobj(Text):
        if text.get_visible() and text.get_text().strip() and ticks.get(text, True):
            yield text
