"""The files of a page: style, script, frame; and the settings that all of its figures share."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

from bokeh.models import Model
from bokeh.plotting import figure
from jinja2 import Environment, FunctionLoader, Template

FONT = "system-ui, -apple-system, 'Segoe UI', Helvetica, Arial, sans-serif"
"""The font of figures: that of the page."""

LEFT, RIGHT = 76, 12
"""Room [pixels] beside the axes, fixed so that figures above one another are aligned."""


def page_file(name: str) -> str:
    """Return the text of a file of the pages: `page.css`, `page.js` ..."""
    return (files("nlds_vines.explore") / "page" / name).read_text(encoding="utf-8")


def frame(name: str) -> Template:
    """Return the frame of a page, which Bokeh fills; it may include other files of the pages."""
    return Environment(autoescape=False, loader=FunctionLoader(page_file)).get_template(name)


def plain_figure(name: str, height: int, **settings: Any) -> Any:
    """Return an empty figure in the style of the page, with a name and a height [pixels].

    Its colors are the page's, which the browser sets, so that both themes suit it.
    """
    options = {
        "tools": "pan,box_zoom,wheel_zoom,reset,save",
        "active_drag": None,
        "active_scroll": None,
        "toolbar_location": None,
        "sizing_mode": "stretch_width",
        "output_backend": "canvas",
        "border_fill_color": None,
        "min_border_left": LEFT,
        "min_border_right": RIGHT,
    } | settings
    made = figure(name=name, height=height, **options)
    made.toolbar.logo = None
    made.toolbar.stylesheets = [":host { --divider-color: var(--line); }"]
    made.min_border_top = made.min_border_bottom = 4
    for axis in made.axis:
        axis.axis_label_text_font = axis.major_label_text_font = FONT
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = "12px"
        axis.major_label_text_font_size = "11px"
        axis.axis_label_standoff = 4
        axis.minor_tick_line_color = None
    return made


def roled(model: Model, role: str, *more: str) -> Any:
    """Return a model that takes its color from the page: ink, body, wall, blue, green, pink."""
    model.tags = [role, *more]
    return model
