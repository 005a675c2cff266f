"""Titles that need several lines, and letters that hide nothing."""

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from nlds_vines.plotting.page import ONE_COLUMN, TWO_COLUMNS, styled
from nlds_vines.plotting.panels import add_panel, write_letters, write_title

TITLE = "SSul NES, Set 6, omega = 6.28 rad/s, P = 800 N, K = 3.25e+07 N/m^1.5: 20 starts"


def page(width, title):
    """Return a figure of two panels with a legend, and its panels, titled."""
    figure = Figure(figsize=(width, 3.0))
    panels = [add_panel(figure, (0.5, bottom, width - 1, 1.0)) for bottom in (1.6, 0.4)]
    panels[0].plot([0, 1], [0, 1], label="a curve")
    figure.legend(loc="upper left", bbox_to_anchor=(0.2, 0.95))
    write_letters(panels)
    write_title(figure, title, 0.5 / width)
    return figure, panels


def extents(figure, artists):
    """Return where artists are drawn, in inches from the lower left corner."""
    canvas = FigureCanvasAgg(figure)
    found = [artist.get_window_extent(canvas.get_renderer()) for artist in artists]
    return [[side / figure.dpi for side in box.extents] for box in found]


@styled()
def test_a_long_title_is_broken_and_the_figure_grows_for_it():
    short, panels = page(ONE_COLUMN.width, "omega = 6 rad/s")
    assert short.get_figheight() == 3.0
    places = extents(short, [*panels, short.legends[0]])
    figure, panels = page(ONE_COLUMN.width, TITLE)
    assert figure.get_figheight() > 3.1
    for found, expected in zip(extents(figure, [*panels, *figure.legends]), places, strict=True):
        assert found == pytest.approx(expected, abs=0.01)
    (left, bottom, right, top), *_ = extents(figure, figure.texts)
    assert left == pytest.approx(0.5, abs=0.02)
    assert right < ONE_COLUMN.width
    assert figure.get_figheight() > top
    (_, lowest, *_), *_ = extents(short, short.texts)
    assert bottom == pytest.approx(lowest, abs=0.1)
    assert page(TWO_COLUMNS.width, TITLE)[0].get_figheight() == 3.0


@styled()
def test_letters_stand_above_their_panels():
    figure, panels = page(4.0, "omega = 6 rad/s")
    for axes in panels:
        (text,) = axes.texts
        (_, bottom, _, _), (_, _, _, top) = extents(figure, [text, axes])
        assert bottom > top
