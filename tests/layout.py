"""Where the texts of a picture stand: which overlap, and which are cut."""

from itertools import combinations
from unittest import mock

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

_TOUCH = 2.4  # points by which the boxes of two texts may overlap: boxes are larger than letters


def collisions(figure):
    """Draw a figure and return a line for each text that is cut or overlaps another.

    Two texts must not overlap, and none may reach beyond the figure.
    """
    canvas, drawn, draw = FigureCanvasAgg(figure), {}, Text.draw

    def noted(text, renderer):
        if text.get_visible() and text.get_text().strip():
            drawn[text] = None
        draw(text, renderer)

    with mock.patch.object(Text, "draw", noted):
        canvas.draw()
    renderer, shrink = canvas.get_renderer(), _TOUCH * figure.dpi / 72 / 2
    boxes = [(text.get_text(), Text.get_window_extent(text, renderer)) for text in drawn]
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
