"""The page in one browser: its widgets, its figures, and their callbacks.

The thread of the server computes nothing: the threads of `page_state` compute orbits and maps
and leave the results for the next tick of the document.
"""

from __future__ import annotations

import time
from base64 import b64encode
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from html import escape
from math import isfinite
from typing import Any

from bokeh import events
from bokeh.document import Document
from bokeh.layouts import column, row
from bokeh.models import Button, CustomJS, CustomJSTickFormatter, NumericInput, Select, Slider

import nlds_vines as nv
from nlds_vines.explore import figures, live_orbit, map_view
from nlds_vines.explore.live_orbit import LiveOrbit
from nlds_vines.explore.map_data import Stored
from nlds_vines.explore.page_state import (
    READY,
    CellStart,
    Chosen,
    Opened,
    Refining,
    SliderSpec,
    sliders_of,
)

# the least time between two images of a map under way: seconds, multiples of the painting time
PROGRESS_SECONDS, PROGRESS_SHARE = 0.4, 10.0
MAP_SIZE = (700, 340)  # pixels of a map or a diagram until the browser reports its size
# the text of a parameter's value, 7 digits of it: with an exponent if its field would cut it
VALUE_WIDTH = 112  # pixels, of the field
_VALUE_TEXT = "const plain = `${tick}`; return plain.length <= 10 ? plain : tick.toExponential()"


def in_words(error: Exception) -> str:
    words = "".join(letter if letter.isprintable() else " " for letter in str(error))
    is_plain = isinstance(error, nv.RequestError) and words
    return words if is_plain else f"{type(error).__name__}: {words}"


class Page:
    """A page: `chosen` is its state, `job` the map that it computes, `orbit` the shown one."""

    def __init__(self, document: Document, opened: Opened) -> None:
        self.document, self.opened = document, opened
        self.chosen = Chosen(opened.results)
        self.job: Refining | None = None
        self.orbit: LiveOrbit | None = None
        self.asked = 0  # number of the last requested orbit
        self.closed = self.setting = False
        self.next_picture = 0.0
        self.shows: dict[str, map_view.Show] = {}
        self.fitted: tuple[Any, ...] | None = None  # the values to which the ordinate was fitted
        self.size = [*MAP_SIZE]
        self.build()
        self.show_level()
        self.say_state()
        self.follow()
        opened.listeners.append(self.changed)
        document.on_session_destroyed(lambda _: self.close())

    # ---- widgets

    def build(self) -> None:
        results = self.chosen.results
        self.map = figures.MapFigure(results, True)
        self.panels = figures.OrbitFigures(results.scan.system, results.unit, results.scan.of)
        self.show = self.select("show", lambda name: self.repaint())
        self.start = self.select("start", self.choose_start)
        histories = [*live_orbit.HISTORIES.items()]
        self.history = self.select("time history", lambda name: self.follow(), histories)
        names = ("state", "legend", "readout", "progress")
        self.state, self.legend, self.readout, self.progress = map(figures.text, names)
        self.described = figures.text("unseen")
        names = ("verdict", "trouble", "evidence", "files")
        self.verdict, self.trouble, self.evidence, self.files = map(figures.text, names)
        self.tip = figures.text("tip", visible=False)
        self.key = figures.text(visible=False)
        self.on(self.key, "text", self.press)
        self.back = self.button("← back", partial(self.step, -1))
        self.forward = self.button("forward →", partial(self.step, 1))
        self.cancel = self.button("cancel", self.cancel_job, visible=False)
        here = self.button("compute what is seen finer", self.refine)
        for made in self.map.figures:
            self.on_event(made, events.Tap, self.tap)
            self.on_event(made, events.DoubleTap, self.tap)  # the second of two quick clicks
            self.on_event(made, events.MouseMove, self.hover)
            self.on_event(made, events.MouseLeave, lambda event: self.tip.update(visible=False))
        self.on_event(self.map.main, events.SelectionGeometry, self.select_rectangle)
        if not self.map.is_map:
            self.on_event(self.map.main, events.RangesUpdate, lambda event: self.repaint())
        for i, name in enumerate(("inner_width", "inner_height")):
            self.on(self.map.main, name, partial(self.resize, i))
        for curve, made in self.panels.planes:
            self.on_event(made, events.Tap, partial(self.begin_in_plane, curve))
        hint = "Click a cell or use the arrow keys; drag a rectangle to compute that part finer."
        start_here = "Click in a phase plane to start an orbit there."
        parts = {
            "map": [
                row(self.show, self.start, self.state, figures.theme_button(), **figures.WIDE),
                *self.map.figures[:-1],
                self.tip, self.map.main, self.described, self.legend, self.readout,
                row(self.back, self.forward, here, self.cancel, **figures.WIDE), self.progress,
                figures.text("hint", text=hint), self.key,
            ],
            "orbit": [
                self.verdict, self.trouble, self.evidence, self.history, *self.panels.wide,
                *self.panels.narrow, figures.text("legend", text=self.panels.legend),
                figures.text("hint", text=start_here),
                self.files, self.button("draw the orbit as a picture", self.draw),
            ],
            "parameters": self.parameters(results),
        }  # fmt: skip
        figures.frame(self.document, results.scan.title, parts)
        keys = CustomJS(args={"target": self.key}, code=figures.page_file("keys.js"))
        self.document.js_on_event(events.DocumentReady, keys)

    def parameters(self, results: Stored) -> list[Any]:
        self.sliders: dict[str, tuple[SliderSpec, Slider, NumericInput]] = {}
        for spec in sliders_of(results):
            entry = spec.entry
            title = f"{map_view.in_brackets(entry.symbol, entry.unit)} · {entry.meaning}"
            low, high, value = map(spec.position, (spec.low, spec.high, spec.value))
            slider = Slider(
                title=title, start=low, end=high, value=value, step=(high - low) / 1000,
                show_value=False, tooltips=False, **figures.WIDE,
            )  # fmt: skip
            exact = NumericInput(
                mode="float", format=CustomJSTickFormatter(code=_VALUE_TEXT), width=VALUE_WIDTH,
                height=24, align="end", **figures.LOOK,
            )  # fmt: skip
            self.on(slider, "value", partial(self.slide, spec.name))
            self.on(exact, "value", partial(self.set_value, spec.name))
            self.sliders[spec.name] = spec, slider, exact
        rows = [row(*pair, sizing_mode="stretch_width") for _, *pair in self.sliders.values()]
        sliders = column(*rows, css_classes=["sliders"], **figures.WIDE)
        original = self.button("as in the map", self.take_original)
        recompute = self.button(
            "compute the map with these", lambda: self.compute_map(self.chosen.part(), False)
        )
        head = figures.text(text="<b>Parameters</b>")
        return [head, row(original, recompute, **figures.WIDE), sliders]

    def select(self, title: str, call: Callable[[str], object], options: Any = ()) -> Select:
        made = Select(
            title=title, options=[*options], value=options[0][0] if options else "", width=260,
            **figures.LOOK,
        )  # fmt: skip
        self.on(made, "value", call)
        return made

    def button(self, label: str, call: Callable[[], object], **settings: Any) -> Button:
        made = Button(label=label, **figures.LOOK, **settings)
        self.on_event(made, events.ButtonClick, lambda event: call())
        return made

    # ---- callbacks

    def on(self, model: Any, name: str, call: Callable[[Any], object]) -> None:
        def changed(attr: str, old: Any, new: Any) -> None:
            if not self.setting:
                self.guarded(call, new)

        model.on_change(name, changed)

    def on_event(self, model: Any, event: type, call: Callable[[Any], object]) -> None:
        model.on_event(event, partial(self.guarded, call))

    def guarded(self, call: Callable[..., object], *arguments: Any) -> None:
        """Show an exception of `call` on the page."""
        try:
            call(*arguments)
        except Exception as error:
            self.say_trouble(in_words(error))

    @contextmanager
    def sets(self) -> Iterator[None]:
        before, self.setting = self.setting, True
        try:
            yield
        finally:
            self.setting = before

    def later(self, call: Callable[..., object], *arguments: Any) -> None:
        """Call something at the next tick of the document, unless the page is closed by then."""
        if not self.closed:
            self.document.add_next_tick_callback(
                lambda: None if self.closed else self.guarded(call, *arguments)
            )

    def say_trouble(self, words: str) -> None:
        self.trouble.text = escape(words)

    # ---- choosing

    def tap(self, event: Any) -> None:
        cell = self.map.cell_at(event.x, event.y)
        if cell is not None:
            self.choose(cell)

    def choose(self, cell: tuple[int, int]) -> None:
        self.chosen.choose(cell, int(self.start.value))
        self.mark()
        self.follow()

    def choose_start(self, name: str) -> None:
        self.choose(self.chosen.cell)
        self.repaint()

    def press(self, pressed: str) -> None:
        """Move by a key: `1 0 17` is a step to the right, the seventeenth key."""
        (i, j), sides = self.chosen.cell, self.chosen.results.shape
        right, up, _ = map(int, pressed.split())
        self.choose((min(max(i + right, 0), sides[0] - 1), min(max(j + up, 0), sides[1] - 1)))

    def hover(self, event: Any) -> None:
        cell = self.map.cell_at(event.x, event.y)
        if cell is None:
            self.tip.visible = False
            return
        results, start = self.chosen.results, int(self.start.value)
        show = self.shows[self.show.value]
        head, *lines = map(escape, map_view.tip_in_words(results, cell, start, show))
        self.tip.text = f"<b>{head}</b><br>{'<br>'.join(lines)}"
        is_right = event.sx > self.size[0] / 2
        self.tip.css_classes = ["tip", "left"] if is_right else ["tip"]
        top = event.sy + 16 - (0 if event.model is self.map.main else event.model.height)
        self.tip.styles = {"left": f"{event.sx:.0f}px", "top": f"{top:.0f}px"}
        self.tip.visible = True

    def slide(self, name: str, position: float) -> None:
        value = 10.0**position if self.sliders[name][0].logarithmic else position
        self.set_value(name, float(f"{value:.5g}"))

    def set_value(self, name: str, value: float | None) -> None:
        """Set a parameter to a shown value; one that the system refuses changes nothing."""
        before, spec = dict(self.chosen.free), self.sliders[name][0]
        try:
            one = self.chosen.results.shown(name)[1]
            if value is None or not isfinite(value):
                raise nv.RequestError(f"{spec.entry.name} must be a finite number")
            self.chosen.free[name] = value * one
            self.follow()
        except Exception:
            self.chosen.free = before
            self.show_values()
            raise

    def take_original(self) -> None:
        self.chosen.free, self.chosen.begin = {}, None
        self.follow()

    def begin_in_plane(self, curve: int, event: Any) -> None:
        """Begin an orbit at a click in the phase plane of a curve; other bodies stay."""
        if self.orbit is not None:
            orbit, of = self.orbit.orbit, self.chosen.scan.of
            moved = live_orbit.curves_of(orbit.system, of)[curve]
            state = moved.put(orbit.trajectory[-1], (event.x, event.y))
            self.chosen.begin = CellStart(tuple(state.tolist()), "a start of your own")
            self.follow()

    # ---- orbits

    def follow(self) -> None:
        """Request the orbit of the chosen cell; of several requests only the last is computed."""
        system = self.chosen.system()
        begin = self.chosen.begins(system)
        self.show_values()
        self.asked = number = self.asked + 1
        results, history = self.chosen.results, self.history.value

        def compute() -> None:  # in the thread of all orbits
            if number != self.asked or self.closed:
                return
            try:
                orbit = live_orbit.live_orbit(
                    system, begin.state, results.scan, history, results.unit
                )
            except Exception as error:
                self.later(self.show_nothing, in_words(error))
            else:
                self.later(self.show_orbit, begin.words, orbit)

        self.opened.aside(compute)

    def show_nothing(self, trouble: str) -> None:
        self.orbit = None
        self.verdict.text = '<span class="label">no orbit</span>'
        self.evidence.text = self.files.text = ""
        self.panels.put({}, ())
        self.say_trouble(trouble)

    def show_orbit(self, words: str, orbit: LiveOrbit) -> None:
        self.orbit, regime = orbit, orbit.regime
        is_word = "by recurrence alone" if regime is None else live_orbit.words_of(regime)
        self.verdict.text = (
            f'<span class="label">{escape(orbit.label)}</span> {escape(is_word)}'
            f'<div class="words">from {escape(words)}</div>'
        )
        pairs = [] if regime is None else live_orbit.evidence_of(regime)
        self.evidence.text = "".join(
            f"<div><dt>{escape(one)}</dt><dd>{escape(value)}</dd></div>" for one, value in pairs
        )
        self.say_trouble(orbit.trouble)
        curves = live_orbit.curves_of(orbit.orbit.system, self.chosen.scan.of)
        self.panels.put(orbit.panels, curves)
        self.later(self.offer_files)

    def show_values(self) -> None:
        results, values = self.chosen.results, self.chosen.values()
        shown = {name: value / results.shown(name)[1] for name, value in values.items()}
        with self.sets():
            for name, (spec, slider, exact) in self.sliders.items():
                position = min(max(spec.position(shown[name]), slider.start), slider.end)
                if abs(position - slider.value) > 0.6 * slider.step:
                    slider.value = position
                exact.value = float(f"{shown[name]:.7g}")
                is_changed = name in self.chosen.free and not spec.axis
                slider.css_classes = ["changed"] if is_changed else []

    # ---- maps

    def show_level(self) -> None:
        results, before = self.chosen.results, self.show.value
        self.map.show_axes(map_view.places_of(results))
        self.offer_shows()
        with self.sets():
            self.start.options = [(str(k), name) for k, name in enumerate(results.starts)]
            self.start.value = str(self.chosen.start)
        self.start.visible = len(results.starts) > 1
        if not self.map.is_map or self.show.value != before:
            self.fitted = None
        self.repaint()
        self.mark()
        self.say_job()

    def offer_shows(self) -> None:
        """Offer what the map can show by now, and keep the choice if possible."""
        self.shows = {show.name: show for show in map_view.shows_of(self.chosen.results)}
        options = [(name, show.title) for name, show in self.shows.items()]
        with self.sets():
            self.show.options = options
            if self.show.value not in self.shows:
                self.show.value = options[0][0]

    def repaint(self) -> None:
        results, show, main = self.chosen.results, self.shows[self.show.value], self.map.main
        if self.map.is_map:
            picture = map_view.painted(results, show, int(self.start.value))
            self.map.put(picture)
        else:
            fitted = results, show.name, len(results.blocks)
            if fitted != self.fitted:
                self.fitted = fitted
                self.map.show_values(
                    map_view.diagram_values(results, show),
                    map_view.in_brackets(show.title, show.unit),
                )
            x, y = main.x_range, main.y_range
            window = float(x.start), float(x.end), float(y.start), float(y.end)
            picture = map_view.painted_diagram(results, show, window, (self.size[0], self.size[1]))
            self.map.picture.put(picture, window)
            self.map.put_strip(results)
        self.legend.text = picture.legend
        words = map_view.picture_in_words(results, show, int(self.start.value))
        self.described.text = escape(words)  # the text alternative of the map

    def resize(self, side: int, pixels: float) -> None:
        self.size[side] = max(int(pixels), 100)
        if not self.map.is_map:
            self.repaint()

    def mark(self) -> None:
        """Mark the chosen cell, and describe it in the line below the map."""
        self.map.choose(self.chosen.cell)
        results, start = self.chosen.results, int(self.start.value)
        head, *lines = map_view.cell_in_words(results, self.chosen.cell, start)
        self.readout.text = escape("; ".join(filter(None, (lines[0], head, *lines[1:]))))

    def select_rectangle(self, event: Any) -> None:
        if event.final and event.geometry["type"] == "rect":
            g = event.geometry
            self.refine((g["x0"], g["x1"]), (g["y0"], g["y1"]))

    def refine(self, *sides: tuple[float, float]) -> None:
        """Begin to compute a part of the map, by default the visible one, finer."""
        if not sides:
            spans = self.map.main.x_range, self.map.main.y_range
            sides = tuple((span.start, span.end) for span in spans)
        ranges = [
            (min(map(place.parameter, side)), max(map(place.parameter, side)))
            for place, side in zip(self.map.places, sides, strict=False)
        ]
        self.compute_map(self.chosen.part(ranges), beneath=True)

    def compute_map(self, scan: nv.Scan, beneath: bool) -> None:
        """Compute a map, with the map before `beneath` it or without, and show it meanwhile."""
        if self.job is not None:
            self.job.cancelled = True
        self.job = job = Refining(scan, self.changed, self.chosen.results.unit)
        if self.map.is_map:
            source = self.map.picture.source.data if beneath else {"image": [], "x": [], "y": []}
            self.map.beneath.mapper.update(
                palette=self.map.picture.mapper.palette, high=self.map.picture.mapper.high
            )
            self.map.beneath.source.data = {"dw": [], "dh": [], **source}
        self.chosen.add(job.results)
        self.show_level()
        self.follow()
        job.start()

    def changed(self) -> None:  # in the threads of the work
        self.later(self.show_progress)

    def show_progress(self) -> None:
        """Show the state of the work, and the map unless it was just painted."""
        results, now = self.chosen.results, time.monotonic()
        jobs = [job for job in (self.job, self.opened.job) if job is not None]
        job = next((job for job in jobs if job.results is results), None)
        if job is not None and (job.share == 1 or now > self.next_picture):
            self.offer_shows()
            self.repaint()
            self.mark()
            took = time.monotonic() - now
            self.next_picture = now + max(PROGRESS_SECONDS, PROGRESS_SHARE * took)
        self.say_state()

    def step(self, by: int) -> None:
        if self.chosen.step(by):
            self.map.beneath.source.data = {name: [] for name in self.map.beneath.source.data}
            self.show_level()
            self.follow()

    def cancel_job(self) -> None:
        if self.job is not None:
            self.job.cancelled = True
        self.say_job()

    def say_state(self) -> None:
        words, job = self.opened.kernels, self.opened.job
        if words == READY and job is not None and job.share < 1:
            words = job.error or job.note or f"computing the map: {job.share:.0%}"
        self.state.text = escape(words)
        self.say_job()

    def say_job(self) -> None:
        job, line = self.job, ""
        running = job is not None and job.share < 1 and not (job.cancelled or job.error)
        if job is not None and job.error:
            line = escape(job.error)
        elif job is not None and running:
            words = job.note or f"{job.done} of {job.total} orbits"
            line = f'<progress max="1" value="{job.share:.3f}"></progress> {escape(words)}'
        elif job is not None and job.share < 1 and job.results is self.chosen.results:
            line = f"cancelled at {job.share:.0%}"
        self.progress.text = line
        self.cancel.visible = running
        self.back.disabled = self.chosen.place == 0
        self.forward.disabled = self.chosen.place == len(self.chosen.levels) - 1

    # ---- files

    def offer_files(self, picture: str = "") -> None:
        """Offer the orbit and the map as files, which the browser saves, and as a command."""
        if self.orbit is None:
            return
        request = self.orbit.request
        recipe, part = (
            b64encode(one.to_toml().encode()).decode() for one in (request, self.chosen.part())
        )
        files = [
            (live_orbit.PORTRAIT_FILE, "portrait recipe (.toml)", "application/toml", recipe),
            (live_orbit.SCAN_FILE, "scan file of the map (.toml)", "application/toml", part),
            (live_orbit.PICTURE_FILE, "picture of the orbit (.png)", "image/png", picture),
        ]
        links = "".join(
            f'<a download="{name}" href="data:{kind};base64,{code}">{words}</a>'
            for name, words, kind, code in files
            if code
        )
        command = escape(live_orbit.portrait_command(request))
        self.files.text = f"<b>Save</b> {links}<code>{command}</code>"

    def draw(self) -> None:
        if (orbit := self.orbit) is None:
            raise nv.RequestError("there is no orbit to draw yet")
        self.say_trouble("drawing the picture ...")

        def work() -> None:  # in the thread of all orbits
            try:
                picture = live_orbit.picture(orbit)
            except Exception as error:
                self.later(self.say_trouble, in_words(error))
            else:
                self.later(self.say_trouble, "")
                self.later(lambda: self.offer_files(picture) if orbit is self.orbit else None)

        self.opened.aside(work)

    def close(self) -> None:
        self.closed = True
        if self.changed in self.opened.listeners:
            self.opened.listeners.remove(self.changed)
        if self.job is not None:
            self.job.cancelled = True
