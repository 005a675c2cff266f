"""The frame that all pages share, and their Bokeh figures: a map, a diagram, one orbit.

Colors that depend on the theme are variables of `assets/look.css`; all others suit both themes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.resources import files
from typing import Any

import numpy as np
from bokeh import models
from bokeh.document import Document
from bokeh.models import Range1d, Span
from bokeh.plotting import figure

import nlds_vines as nv
from nlds_vines.explore.live_orbit import HZ, RAD, Arrays, Curve, curves_of
from nlds_vines.explore.map_data import Stored
from nlds_vines.explore.map_view import (
    CLEAR,
    GRAY,
    HUES,
    INK,
    Picture,
    Places,
    chip,
    classes_of,
    damper_color,
    label_codes,
)

# colors of the structure, of the harmonic force, and of walls and sections
BODY, FORCE, WALL = GRAY, HUES["sky"], HUES["vermillion"]
# those of the displacements of a host, in their order
_HUES = (BODY, INK, *(HUES[name] for name in ("green", "pink", "orange", "sky")))
MAP_HEIGHT, DIAGRAM_HEIGHT, STRIP_HEIGHT = 520, 430, 14  # pixels
_LEFT, _RIGHT = 76, 12  # pixels beside the axes, so that figures one above another are aligned
_MOST_BOXES = 20_000  # hatched boxes that a browser draws at once


def page_file(name: str) -> str:
    return (files("nlds_vines.explore") / "assets" / name).read_text(encoding="utf-8")


LOOK: dict[str, Any] = {"stylesheets": [page_file("widget.css")]}
# the settings of all widgets, and of those that fill the width of their part of the page
WIDE: dict[str, Any] = {"sizing_mode": "stretch_width", **LOOK}


def text(name: str = "", **settings: Any) -> models.Div:
    """Return a line of text, by default empty, with the look of this `name`."""
    return models.Div(margin=(1, 5), css_classes=[name] if name else [], **WIDE, **settings)


def theme_button() -> models.Button:
    made = models.Button(label="◐", width=34, **LOOK)
    made.js_on_click(models.CustomJS(code="TURN()"))
    return made


def frame(
    document: Document, title: str, parts: Mapping[str, Sequence[models.Model]], **variables: Any
) -> None:
    """Put the models of each part of a page into the frame that all pages share."""
    # each has its own layout: none is drawn again because another changes its size
    with document.models.freeze():  # otherwise Bokeh counts all models again for each root
        for part, models in parts.items():
            for model in models:
                model.tags = [part, *model.css_classes]
                document.add_root(model)
    document.title = title
    document.template = page_file("frame.html")
    document.template_variables.update(
        css=page_file("look.css"), script=page_file("theme.js"), parts=[*parts], **variables
    )


def plain_figure(name: str, height: int, **settings: Any) -> Any:
    options = {
        "tools": "pan,box_zoom,wheel_zoom,reset,save", "active_drag": None, "active_scroll": None,
        "toolbar_location": None, "sizing_mode": "stretch_width", "border_fill_color": None,
        "min_border_left": _LEFT, "min_border_right": _RIGHT,
        "min_border_top": 4, "min_border_bottom": 4,
    }  # fmt: skip
    made = figure(name=name, height=height, **options | settings)
    made.toolbar.logo = None
    made.stylesheets = [".bk-events:focus:not(:focus-visible) { outline: none; }"]
    for axis in made.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = "12px"
        axis.axis_label_standoff = 4
        axis.minor_tick_line_color = None
    return made


# ---- the map -------------------------------------------------------------------------------------


class Layer:
    def __init__(self, home: Any) -> None:
        nothing = np.zeros((1, 1), np.uint8)
        data = {"image": [nothing], "x": [0.0], "y": [0.0], "dw": [1.0], "dh": [1.0]}
        self.source = models.ColumnDataSource(data)
        self.mapper = models.LinearColorMapper(palette=[CLEAR], low=-0.5, high=0.5)
        home.image(
            "image", "x", "y", "dw", "dh", source=self.source, color_mapper=self.mapper,
            level="image",
        )  # fmt: skip

    def put(self, picture: Picture, box: tuple[float, float, float, float]) -> None:
        """Show an image in a box (x0, x1, y0, y1); if the box stays, only the codes are sent."""
        x0, x1, y0, y1 = box
        data = {"x": [x0], "y": [y0], "dw": [x1 - x0], "dh": [y1 - y0]}
        before, codes = self.source.data, picture.codes
        if self.mapper.palette != picture.palette:
            high = len(picture.palette) - 0.5
            self.mapper.update(palette=picture.palette, low=-0.5, high=high)
        same = all(before[name] == value for name, value in data.items())
        old = before["image"][0]
        if same and (old.shape, old.dtype) == (codes.shape, codes.dtype):
            self.source.patch({"image": [(0, codes)]})
        else:
            self.source.data = {"image": [codes], **data}


class MapFigure:
    """The figure of a map or a diagram, with a mark at the chosen cell.

    `strip` is the figure of the regimes above a diagram; `picture` is the image of the cells,
    `beneath` the map before, visible where cells are clear.
    """

    def __init__(self, results: Stored, refining: bool) -> None:
        self.is_map = len(results.scan.axes) == 2
        drag = "box_select" if refining else "box_zoom"
        tools = "tap,pan,wheel_zoom,box_zoom,reset,save" + (",box_select" if refining else "")
        self.main = plain_figure(
            "cells", MAP_HEIGHT if self.is_map else DIAGRAM_HEIGHT, tools=tools, active_drag=drag,
            toolbar_location="above", x_range=Range1d(0, 1), y_range=Range1d(0, 1),
        )  # fmt: skip
        self.main.grid.visible = not self.is_map  # lines across cells would hide them
        words = "map" if self.is_map else "diagram"
        self.main.html_attributes = {
            "role": "img",
            "aria-label": f"{words} of {results.scan.title}, described in words below it; the "
            "arrow keys choose a cell, whose values and label the page then reads out",
        }
        self.beneath, self.picture = Layer(self.main), Layer(self.main)
        self.hatch = models.ColumnDataSource({"left": [], "right": [], "bottom": [], "top": []})
        self.main.quad(
            "left", "right", "bottom", "top", source=self.hatch, fill_color=None, line_color=None,
            hatch_pattern="/", hatch_color=GRAY, hatch_scale=6, hatch_weight=0.7, level="image",
        )  # fmt: skip
        dimensions = ("height", "width")[: len(results.scan.axes)]
        self.lines = [Span(dimension=one, line_color=GRAY, line_width=1) for one in dimensions]
        for line in self.lines:
            self.main.add_layout(line)
        self.mark = models.ColumnDataSource({"x": [], "y": []})
        for shade, width in (("#ffffff", 4.0), ("#000000", 1.6)):  # seen on any color
            self.main.scatter(
                "x", "y", source=self.mark, size=13, fill_color=None, line_color=shade,
                line_width=width, nonselection_alpha=1.0,
            )  # fmt: skip
        if refining:
            box = self.main.select_one(models.BoxSelectTool)
            box.description = "compute a rectangle finer"
            box.dimensions = "both" if self.is_map else "width"
        self.strip = self.regimes = None
        if not self.is_map and "label" in results:
            height = 10 + STRIP_HEIGHT * min(len(results.starts), 4)
            self.strip = plain_figure(
                "strip", height, tools="tap", x_range=self.main.x_range, y_range=Range1d(0, 1)
            )
            self.strip.axis.visible = self.strip.grid.visible = False
            self.regimes = Layer(self.strip)
        # cells that are not computed must differ from chaos on a dark page, too
        regimes = self.main if self.is_map else self.strip
        if regimes is not None:
            regimes.stylesheets.append(":host { --bk-background-fill-color: var(--empty); }")
            for axis in regimes.axis:
                axis.stylesheets = [":host { --bk-background-fill-color: var(--card); }"]

    @property
    def figures(self) -> list[Any]:
        return [self.main] if self.strip is None else [self.strip, self.main]

    def show_axes(self, places: Sequence[Places]) -> None:
        self.places = places
        ranges = (self.main.x_range, self.main.y_range)
        for one, span, axis in zip(
            places, ranges, (*self.main.below, *self.main.left), strict=False
        ):
            _set_range(span, one.low, one.high)
            axis.axis_label = one.label
            if not one.even:
                every = one.at[:: -(-one.at.size // 8)].astype(int).tolist()
                axis.ticker = models.FixedTicker(ticks=every)
                values = one.axis.values
                axis.major_label_overrides = {i: f"{values[i]:.4g}" for i in every}

    def show_values(self, values: np.ndarray, label: str) -> None:
        finite = values[np.isfinite(values)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
        room = 0.04 * ((high - low) or abs(high) or 1.0)
        _set_range(self.main.y_range, low - room, high + room)
        self.main.yaxis.axis_label = label

    def box(self) -> tuple[float, float, float, float]:  # (x0, x1, y0, y1), the edges of a map
        first, second = self.places
        return first.low, first.high, second.low, second.high

    def put(self, picture: Picture) -> None:
        self.picture.put(picture, self.box())
        self.hatch.data = self.hatched(picture)

    def hatched(self, picture: Picture) -> dict[str, np.ndarray]:
        """Return the edges of the hatched boxes, each a vertical run of cells; none of too many."""
        mask = np.pad(picture.codes == picture.hatched, ((1, 1), (0, 0))).astype(np.int8)
        steps = np.diff(mask, axis=0).T
        (columns, bottoms), (_, tops) = (np.nonzero(steps == step) for step in (1, -1))
        if columns.size > _MOST_BOXES:
            columns = bottoms = tops = np.empty(0, int)
        x0, x1, y0, y1 = self.box()
        wide, high = (x1 - x0) / picture.codes.shape[1], (y1 - y0) / picture.codes.shape[0]
        edges = {"left": x0 + wide * columns, "right": x0 + wide * (columns + 1)}
        edges |= {"bottom": y0 + high * bottoms, "top": y0 + high * tops}
        return {name: values.astype(np.float32) for name, values in edges.items()}

    def put_strip(self, results: Stored) -> None:
        """Show the regimes along the axis of a diagram, a row for each start, the first on top."""
        if self.regimes is not None:
            (first,) = self.places
            codes = label_codes(results)[1].T[::-1].copy()
            picture = Picture(codes, [shade for _, shade, _ in classes_of(results)], "")
            self.regimes.put(picture, (first.low, first.high, 0.0, 1.0))

    def choose(self, cell: tuple[int, int]) -> None:
        where = [float(one.at[i]) for one, i in zip(self.places, cell, strict=False)]
        for line, place in zip(self.lines, where, strict=True):
            line.location = place
        if self.is_map:
            self.mark.data = {"x": where[:1], "y": where[1:]}

    def cell_at(self, x: float, y: float) -> tuple[int, int] | None:
        where = [one.nearest(at) for one, at in zip(self.places, (x, y), strict=False)]
        first, second = (*where, 0)[:2]
        return None if first is None or second is None else (first, second)


def _set_range(span: Range1d, low: float, high: float) -> None:
    span.update(start=low, end=high, reset_start=low, reset_end=high)


# ---- one orbit -----------------------------------------------------------------------------------

_TIME, _PLANE, _LOW, _CIRCLE = 132, 230, 196, 146  # pixels


class OrbitFigures:
    """The panels that the orbit of a system can fill.

    `wide` and `narrow` are the figures of full and of half width, `planes` the phase planes, each
    with the number of its curve, `walls` the lines of the walls of each curve.
    """

    def __init__(self, system: nv.System, unit: str | None = RAD, of: Sequence[str] = ()) -> None:
        scene, curves = system.scene, curves_of(system, of)
        shades, wall, by_wall = colors_of(system, curves)
        harmonic = [f"harmonic {name}" for name in system.harmonic_forces(np.zeros(1))]
        forces: dict[str, str] = {}
        if system.force_signals:
            forces = dict.fromkeys(harmonic, FORCE)
            forces |= _colors_of_forces(system, curves, shades, wall)
        drawn = [*zip(curves, shades, strict=True)]
        self.sources: dict[str, models.ColumnDataSource] = {}
        self.walls: list[list[Span]] = []
        self.wide: list[Any] = []
        self.time = Range1d(0, 1)

        def over_time(name: str, label: str, curves: Mapping[str, str]) -> Any:
            made = plain_figure(name, _TIME, x_range=self.time)
            made.yaxis.axis_label = label
            for column, shade in curves.items():
                width = 1.0 if column in harmonic else 1.3
                self._draw(made.line, "history", "t", column, line_color=shade, line_width=width)
            self.wide.append(made)
            return made

        bodies = {curve.names[0]: shade for curve, shade in drawn if not curve.is_apart}
        label = ", ".join(curve.symbols[0] for curve in curves if not curve.is_apart)
        over_time("displacement", f"{label} [m]", bodies)
        for curve, shade in drawn:
            if curve.is_apart:
                name, label = curve.names[0], f"{curve.symbols[0]} [m]"
                over_time("relative" if name == "u" else name, label, {name: shade})
            look = {"line_width": 1.5, "line_color": wall}
            self.walls.append([Span(dimension="width", **look) for _ in curve.walls])
            for line in self.walls[-1]:
                self.wide[-1].add_layout(line)
        if forces:
            made = over_time("force", "force [kN]", forces)
            made.yaxis.formatter = models.CustomJSTickFormatter(code="return String(tick / 1000)")
        self.wide[-1].xaxis.axis_label = "t / T [forcing periods]"

        dots: dict[str, Any] = {"line_color": None, "fill_color": wall, "size": 5}
        self.planes: list[tuple[int, Any]] = []
        for i, (curve, shade) in enumerate(drawn):
            if curve.has_plane:
                name = f"phase{len(self.planes) + 1}"
                tools = "tap,pan,wheel_zoom,reset,save"
                made = phase_plane(name, _PLANE, curve.symbols, tools=tools)
                look = {"line_color": shade, "line_width": 0.9, "line_alpha": 0.8}
                self._draw(made.line, name, "x", "v", **look)
                self._draw(made.scatter, "section", *curve.names, **dots)
                self.planes.append((i, made))
        self.narrow = [made for _, made in self.planes]

        def half(name: str, height: int, across: str, up: str, **settings: Any) -> Any:
            made = plain_figure(name, height, **settings)
            made.xaxis.axis_label, made.yaxis.axis_label = across, up
            self.narrow.append(made)
            return made

        if by_wall:  # speed over the phase of the force, by wall
            turn = Range1d(0.0, 2 * np.pi)
            words = "phase at touch φ [rad]", "approach speed [m/s]"
            made = half("touches", _PLANE, *words, x_range=turn)
            for name, shade in by_wall.items():
                self._draw(made.scatter, "touches", "phase", name, **dots | {"fill_color": shade})
        across = f"frequency / {'f' if unit == HZ else 'ω'}"
        made = half("spectrum", _LOW, across, "amplitude [m]", y_axis_type="log")
        made.x_range.range_padding = 0
        made.yaxis.ticker.desired_num_ticks = 4
        color = [*bodies.values()][-1]
        self._draw(made.line, "spectrum", "order", "amplitude", line_color=color)
        ends, angle = (-1.25, 1.25), np.linspace(0, 2 * np.pi, 181)
        made = half(
            "multipliers", _LOW, "Re μ", "Im μ", x_range=Range1d(*ends), y_range=Range1d(*ends),
            sizing_mode="fixed", width=_CIRCLE + _LEFT + _RIGHT,
        )  # fmt: skip
        made.line(np.cos(angle), np.sin(angle), line_width=1.2, line_color=GRAY)
        self._draw(made.scatter, "multipliers", "re", "im", **dots | {"size": 8})
        for made in self.narrow:
            made.css_classes = ["half"]

        entries = [(shade, curve.words) for curve, shade in drawn if curve.words]
        is_any = any(self.walls)
        entries += [(wall, "walls and sections t = nT" if is_any else "section t = nT")]
        struck = scene.bodies_struck[:1]
        if len(by_wall) > 1 and by_wall.keys() >= {*struck}:
            entries += [(by_wall[name], f"impacts at the {name}") for name in struck]
        entries += [(FORCE, "P cos ωt")] if forces else []
        self.legend = "".join(chip(shade, words) for shade, words in entries)

    def _draw(self, add: Callable[..., Any], panel: str, x: str, y: str, **look: Any) -> None:
        source = self.sources.setdefault(panel, models.ColumnDataSource(name=f"{panel} data"))
        for name in (x, y):
            if name not in source.data:
                source.add(np.empty(0), name)
        add(x, y, source=source, **look).nonselection_glyph = None

    def put(self, panels: Mapping[str, Arrays], curves: Iterable[Curve]) -> None:
        """Show the arrays of an orbit, and the walls at their places; nothing without arrays."""
        if panels and len(times := panels["history"]["t"]):
            begin, end = float(np.floor(times[0])), float(np.ceil(times[-1]))
            if (begin, end) != (self.time.reset_start, self.time.reset_end):
                _set_range(self.time, begin, end)
        for name, source in self.sources.items():
            arrays = panels.get(name, {})
            with np.errstate(over="ignore"):
                data = {c: arrays.get(c, np.empty(0)).astype(np.float32) for c in source.data}
            if any(map(len, data.values())) or any(map(len, source.data.values())):
                source.data = data
        for lines, curve in zip(self.walls, curves, strict=False):
            for line, place in zip(lines, curve.walls, strict=True):
                line.location = place


def colors_of(system: nv.System, curves: Sequence[Curve]) -> tuple[list[str], str, dict[str, str]]:
    """Return the colors of curves, of walls and sections, and of the touches of each wall.

    A damper of the catalog has its color of all pictures; touches have that of their damper, if it
    has a name.
    """
    scene = system.scene
    if any(curve.owner for curve in curves):
        shades = [_HUES[i % len(_HUES)] for i in range(len(curves))]
        own = {curve.words: shade for curve, shade in zip(curves, shades, strict=True)}
        by_wall = {
            word: own.get(f"r of {damper}", GRAY)
            for word, (damper, _) in scene.dampers_and_walls.items()
        }
        return shades, WALL, by_wall
    color, wall = damper_color(system.name), WALL
    if color == HUES["black"] or not scene.damper:  # black is invisible on a dark page
        color = INK
    elif color in (HUES["vermillion"], HUES["orange"]):
        wall = HUES["blue"]
    other = HUES["blue"] if wall == WALL else WALL
    shades = [BODY if scene.damper else color, color, color][: len(curves)]
    return shades, wall, dict(zip(reversed(scene.wall_words), (wall, other), strict=False))


def _colors_of_forces(
    system: nv.System, curves: Sequence[Curve], shades: Sequence[str], wall: str
) -> dict[str, str]:
    """Return the colors of contact forces: of a damper with a name its own, else the wall's."""
    own = {curve.words: shade for curve, shade in zip(curves, shades, strict=True)}
    colors = {}
    for name in system.force_signals:
        owner = system.signal(name).owner
        colors[name] = own.get(f"r of {owner}", wall)
    return colors


def phase_plane(name: str, height: int, symbols: tuple[str, str], **settings: Any) -> Any:
    made = plain_figure(name, height, **settings)
    made.xaxis.axis_label, made.yaxis.axis_label = f"{symbols[0]} [m]", f"{symbols[1]} [m/s]"
    made.xaxis.ticker.desired_num_ticks = 4
    return made
