"""The map or diagram as Bokeh figures: empty, to be painted by the page's script."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import BoxSelectTool, ColumnDataSource, CustomJS, Model, Range1d, Span

from nlds_vines.explore.page_elements import plain_figure, roled

HEIGHT, DIAGRAM_HEIGHT, STRIP = 520, 430, 14
"""Heights [pixels] of a map, of a diagram, and of the regimes of one start above a diagram."""

_EVENTS = {
    "tap": "NV.tap(cb_obj.x, cb_obj.y)",
    "doubletap": "NV.tap(cb_obj.x, cb_obj.y)",  # two quick clicks, often in two cells
    "mousemove": "NV.hover(cb_obj.x, cb_obj.y)",
    "mouseleave": "NV.leave()",
}


def image_source(name: str) -> ColumnDataSource:
    """Return the source of an image of colors (ABGR), of one clear pixel until it is painted."""
    data = {"image": [np.zeros((1, 1), np.uint32)], "x": [0.0], "y": [0.0], "dw": [1.0]}
    return ColumnDataSource({**data, "dh": [1.0]}, name=name)


def map_figures(axes: int, starts: int, labeled: bool, refining: bool) -> list[Model]:
    """Return the figures of a map (two axes) or a diagram (one), the map or diagram first.

    Arguments: the number of `axes` and of `starts`; whether regimes are recorded, which a diagram
    shows in a strip; whether a rectangle can be drawn to be computed finer.
    """
    drag = "box_select" if refining else "box_zoom"
    tools = "tap,pan,wheel_zoom,box_zoom,reset,save" + (",box_select" if refining else "")
    main = plain_figure(
        "map", HEIGHT if axes == 2 else DIAGRAM_HEIGHT, tools=tools, active_drag=drag,
        toolbar_location="above", x_range=Range1d(0, 1), y_range=Range1d(0, 1),
    )  # fmt: skip
    for name in ("beneath", "picture"):
        main.image_rgba("image", "x", "y", "dw", "dh", source=image_source(name), level="image")
    main.grid.visible = axes == 1  # lines across cells would hide them
    _add_mark(main, axes)
    for event, code in _EVENTS.items():
        main.js_on_event(event, CustomJS(code=code))
    if refining:
        box = next(tool for tool in main.tools if isinstance(tool, BoxSelectTool))
        box.description = "compute a rectangle finer"
        if axes == 1:
            box.dimensions = "width"
        code = "if (cb_obj.final) EXPLORE.rectangle(cb_obj.geometry)"
        main.js_on_event("selectiongeometry", CustomJS(code=code))
    return [main] if axes == 2 or not labeled else [main, _strip(main, starts)]


def _add_mark(main: Any, axes: int) -> None:
    """Add the mark of the chosen cell: thin lines across, and a ring in a map."""
    for name, dimension in (("cross x", "height"), ("cross y", "width"))[:axes]:
        line = Span(
            location=None, dimension=dimension, line_width=1, line_alpha=0.55, name=name,

        )  # fmt: skip
        main.add_layout(roled(line, "ink"))
    mark = ColumnDataSource({"x": [np.nan], "y": [np.nan]}, name="mark")
    rings = (("#ffffff", 4.0), ("#000000", 1.6))
    for shade, width in rings:  # seen on any color
        main.scatter(
            "x", "y", source=mark, size=13, marker="circle", fill_color=None, line_color=shade,
            line_width=width, nonselection_alpha=1.0,
        )  # fmt: skip


def _strip(main: Any, starts: int) -> Any:
    """Return the strip of regimes along the axis of a diagram."""
    strip = plain_figure(
        "strip", 10 + STRIP * min(starts, 4), tools="tap", x_range=main.x_range,
        y_range=Range1d(0, 1),
    )  # fmt: skip
    strip.image_rgba("image", "x", "y", "dw", "dh", source=image_source("regimes"))
    strip.axis.visible = False
    strip.grid.visible = False
    for event, code in _EVENTS.items():
        strip.js_on_event(event, CustomJS(code=code))
    return strip
