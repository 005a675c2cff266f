"""The document of a page: figures and sources in their frame, empty until they are told numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

from bokeh.document import Document
from bokeh.models import ColumnDataSource, CustomJS

from nlds_vines.explore.histories import HISTORIES
from nlds_vines.explore.map_data import Stored
from nlds_vines.explore.map_figure import map_figures
from nlds_vines.explore.orbit_figures import WIDE, orbit_figures, orbit_sources, walls_of
from nlds_vines.explore.page_elements import frame, page_file
from nlds_vines.explore.parameter_sliders import sliders_of

_DATA = ("asked", "told", "values", "lanes", "cells", "points", "touched")


class Filled(NamedTuple):
    """What a page changes in its document: sources by name, the lines of what is struck."""

    data: dict[str, ColumnDataSource]
    walls: list[list[Any]]


def fill(document: Document, found: Stored) -> Filled:
    """Put the figures and sources of a map into a document.

    The page's script asks through the source `asked`, hears through `told`, and takes numbers from
    the others.
    """
    system = found.scan.system
    figures = orbit_figures(system, orbit_sources(system))
    maps = map_figures(len(found.scan.axes), len(found.starts), "label" in found, True)
    data = {name: ColumnDataSource(name=name) for name in _DATA}
    for name in ("asked", "told"):
        data[name].data = {"message": []}
    with document.models.freeze():  # each root alone would make all models be counted again
        for root in (*maps, *figures, *data.values()):
            document.add_root(root)
    document.title = found.scan.title
    document.template = frame("explore.html")
    script = page_file("page.js") + page_file("explore.js")
    document.template_variables.update(
        css=page_file("page.css"), script=script, figures=WIDE, data=_DATA, histories=HISTORIES
    )
    sliders = CustomJS(args={"sliders": sliders_of(found.scan)}, code="EXPLORE.start(sliders)")
    document.js_on_event("document_ready", sliders)
    return Filled(data, walls_of(figures))
