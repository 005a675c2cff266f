"""One browser's page: what it shows, and what happens when something on it is used.

The page's script sends one message a time through the source `asked`, and is told through `told`.
Orbits are computed aside, one at a time; of several that are asked for meanwhile only the last
one is.  When the page is closed, everything that it began ends.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from bokeh.document import Document
from bokeh.models import ColumnDataSource, CustomJS

from nlds_vines.bifurcation.request import Scan
from nlds_vines.errors import RequestError, number, shown
from nlds_vines.explore import recipes
from nlds_vines.explore.cell_columns import columns
from nlds_vines.explore.cell_start import CellStart, start_of
from nlds_vines.explore.evidence_words import evidence_of, words_of
from nlds_vines.explore.live_orbit import LiveOrbit, Sampling, live_orbit
from nlds_vines.explore.look import frame, page_file
from nlds_vines.explore.map_figure import map_figures
from nlds_vines.explore.map_meta import diagram_points, meta_of
from nlds_vines.explore.opened import READY, Opened, middle
from nlds_vines.explore.orbit_figures import WIDE, joined, orbit_figures, orbit_sources
from nlds_vines.explore.parameter_sliders import sliders_of
from nlds_vines.explore.refining import Job, finer
from nlds_vines.explore.stored import Stored
from nlds_vines.model.system import System
from nlds_vines.orbits.simulation import IntegrationError

PROGRESS_SECONDS = 0.4
"""Seconds between two pictures of a map that is being computed."""

PROGRESS_SHARE = 10.0
"""How many times longer than sending a map is computed before it is sent again."""

_DATA = ("asked", "told", "values", "lanes", "cells", "points")


class Wanted(NamedTuple):
    """An orbit that the page has asked for: its system, its start, the message's number."""

    system: System
    start: CellStart
    number: int


class Session:
    """A page and its state: the map that is seen, the cell, the start, the sliders."""

    def __init__(self, document: Document, opened: Opened) -> None:
        """Fill a document that shows what was opened."""
        self._document, self._opened = document, opened
        self._levels: list[Stored] = [opened.found]
        self._place = 0
        self._cell, self._start = middle(opened.found), 0
        self._free: dict[str, float] = {}  # parameters that a slider has set
        self._own: CellStart | None = None  # a start of the user's, in a phase plane
        self._job: Job | None = None
        self._orbit: LiveOrbit | None = None
        self._wanted: Wanted | None = None
        self._listens = False  # whether the page's script is there
        self._busy = self._closed = False
        self._next = 0.0  # when the map that is computed may be sent again
        self._make()
        opened.listeners.append(self._more)
        document.on_session_destroyed(lambda _: self.close())

    # ---- the document

    def _make(self) -> None:
        """Put figures and sources into the document."""
        document, found = self._document, self._opened.found
        system = found.scan.system
        figures = orbit_figures(system, orbit_sources(system))
        self._walls = (
            [wall for made in figures for wall in made.select({"name": "wall 0"})],
            [wall for made in figures for wall in made.select({"name": "wall 1"})],
        )
        self._data = {name: ColumnDataSource(name=name) for name in _DATA}
        for name in ("asked", "told"):
            self._data[name].data = {"message": []}
        self._data["asked"].on_change("data", self._hear)
        maps = map_figures(len(found.scan.axes), len(found.starts), "label" in found, True)
        for root in (*maps, *figures, *self._data.values()):
            document.add_root(root)
        document.title = found.scan.title
        document.template = frame("explore.html")
        script = page_file("page.js") + page_file("explore.js")
        document.template_variables.update(
            css=page_file("page.css"), script=script, figures=WIDE, data=_DATA
        )
        code = "EXPLORE.start(sliders)"
        document.js_on_event(
            "document_ready", CustomJS(args={"sliders": sliders_of(found.scan)}, code=code)
        )

    # ---- messages

    def _hear(self, attribute: str, old: Any, new: Mapping[str, Any]) -> None:
        """Do what a message of the page asks for; say what is wrong with it where something is."""
        for text in new["message"]:
            message = json.loads(text)
            try:
                do = _ACTIONS.get(message.get("do"))
                if do is None:
                    raise RequestError(f"the page asks for {shown(message.get('do'))}")
                do(self, message)
            except (ValueError, KeyError, TypeError, IndexError) as error:
                self._tell(trouble=str(error))

    def _tell(self, **message: Any) -> None:
        """Tell the page something."""
        self._data["told"].data = {"message": [json.dumps(message)]}

    def _later(self, call: Callable[[], object]) -> None:
        """Call something in the thread of the document, unless the page is closed by then."""
        if not self._closed:
            self._document.add_next_tick_callback(lambda: None if self._closed else call())

    @property
    def _found(self) -> Stored:
        return self._levels[self._place]

    @property
    def _scan(self) -> Scan:
        return self._found.scan

    def _ready(self, message: Mapping[str, Any]) -> None:
        self._listens = True
        self._show_level()
        self._say_state()
        self._follow(message)

    def _choose(self, message: Mapping[str, Any]) -> None:
        """Take a cell and a start, which replace what the sliders say of the axes."""
        first, second = (int(place) for place in message["cell"])
        shape = self._found.shape
        if not (0 <= first < shape[0] and 0 <= second < shape[1]):
            raise RequestError(f"there is no cell {first}, {second}")
        start = int(message["start"])
        if not 0 <= start < len(self._found.starts):
            raise RequestError(f"there is no start {start}")
        self._cell, self._start, self._own = (first, second), start, None
        for axis in self._scan.axes:
            self._free.pop(axis.name, None)
        self._follow(message)

    def _slide(self, message: Mapping[str, Any]) -> None:
        """Take the value of a parameter; one that the system refuses changes nothing."""
        name, before = str(message["name"]), dict(self._free)
        self._free[name] = number(name, message["value"])
        try:
            self._follow(message)
        except RequestError:
            self._free = before
            self._tell_sliders()
            raise

    def _original(self, message: Mapping[str, Any]) -> None:
        self._free, self._own = {}, None
        self._follow(message)

    def _plane(self, message: Mapping[str, Any]) -> None:
        """Begin an orbit where a phase plane was clicked; the other body keeps its last state."""
        if self._orbit is None:
            return
        state = self._orbit.view.section[-1].tolist()
        first = 0 if message["plane"] == "phase1" else 2
        state[first] = number("displacement", message["x"])
        state[first + 1] = number("velocity", message["v"])
        self._own = CellStart(tuple(state), "a start of your own")
        self._follow(message)

    # ---- orbits

    def _system(self) -> System:
        """Return the system of the chosen cell, with what the sliders say."""
        return self._scan.system.with_(**{**self._found.values_of(self._cell), **self._free})

    def _follow(self, message: Mapping[str, Any]) -> None:
        """Ask for the orbit of what is chosen now."""
        system = self._system()
        start = self._own or start_of(self._found, self._cell, self._start, system)
        self._wanted = Wanted(system, start, int(message.get("number", 0)))
        self._tell_sliders()
        if not self._busy:
            self._begin()

    def _begin(self) -> None:
        wanted, self._wanted, self._busy = self._wanted, None, True
        assert wanted is not None
        _aside(self._compute, wanted, Sampling.of(self._scan))

    def _compute(self, wanted: Wanted, sampling: Sampling) -> None:
        """Follow an orbit, in a thread of its own."""
        orbit, trouble = None, ""
        try:
            orbit = live_orbit(wanted.system, wanted.start.state, sampling)
        except (RequestError, IntegrationError, MemoryError) as error:
            trouble = str(error) or type(error).__name__
        self._later(partial(self._show_orbit, wanted, orbit, trouble))

    def _show_orbit(self, wanted: Wanted, orbit: LiveOrbit | None, trouble: str) -> None:
        """Show an orbit, or say why there is none, and begin with the next that is wanted."""
        self._busy = False
        if self._wanted is not None:
            self._begin()
        if orbit is None:
            self._tell(trouble=trouble, orbit=_no_orbit(wanted))
            return
        self._orbit = orbit
        layout, values = joined(orbit.panels)
        self._data["values"].data = {"values": values}
        for lines, place in zip(self._walls, _places(wanted.system).values(), strict=False):
            for line in lines:
                line.location = float(place)
        self._tell(trouble=orbit.trouble, orbit=_in_words(wanted, orbit) | {"layout": layout})

    # ---- maps

    def _show_level(self, again: bool = False) -> None:
        """Send the map that is seen; `again` where only more of it is computed."""
        self._put(self._payload(self._found), again)

    @staticmethod
    def _payload(found: Stored) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return what the page must know of a map, and its sources by name."""
        all_columns, points = columns(found), diagram_points(found)
        rows = found.scan.lanes
        lanes = {name: values for name, values in all_columns.items() if len(values) == rows}
        cells = {name: values for name, values in all_columns.items() if name not in lanes}
        count = next((len(values) // rows for values in points.values()), 0)
        return meta_of(found, count), {"lanes": lanes, "cells": cells, "points": points}

    def _put(self, payload: tuple[dict[str, Any], dict[str, Any]], again: bool) -> None:
        meta, sources = payload
        for name, data in sources.items():
            self._data[name].data = data
        if again:
            self._tell(cells=meta)
        else:
            self._tell(level={**meta, "cell": list(self._cell)})
        self._tell_job()

    def _finer(self, message: Mapping[str, Any]) -> None:
        """Begin to compute a part of the map finer."""
        ranges = tuple((float(low), float(high)) for low, high in message["ranges"])
        self._compute_map(finer(self._scan, ranges, self._settings()))

    def _recompute(self, message: Mapping[str, Any]) -> None:
        """Begin to compute the map with the parameters of the sliders."""
        ends = tuple((float(a.values[0]), float(a.values[-1])) for a in self._scan.axes)
        self._compute_map(finer(self._scan, ends, self._settings()))

    def _settings(self) -> dict[str, float]:
        """Return what the sliders say of parameters that are not varied."""
        varied = {axis.name for axis in self._scan.axes}
        return {name: value for name, value in self._free.items() if name not in varied}

    def _compute_map(self, scan: Scan) -> None:
        """Compute a map in the background, and show it while it grows."""
        if self._job is not None:
            self._job.cancel()
        job = Job(scan, self._more)
        self._job = job
        values = self._system().parameters
        self._levels = [*self._levels[: self._place + 1], job.found]
        self._place += 1
        self._cell = tuple(  # type: ignore[assignment]  # two numbers
            [int(abs(axis.values - values.get(axis.name, axis.values[0])).argmin())
             for axis in scan.axes] + [0]
        )[:2]  # fmt: skip
        self._show_level()
        job.begin()

    def _more(self) -> None:
        """Show what has been computed meanwhile; called in the threads of the work."""
        if not self._listens:
            return
        found, now = self._found, time.monotonic()
        jobs = [job for job in (self._job, self._opened.job) if job is not None]
        job = next((job for job in jobs if job.found is found), None)
        if job is not None and (job.done == job.total or now > self._next):
            payload = self._payload(found)
            took = time.monotonic() - now
            self._next = now + max(PROGRESS_SECONDS, PROGRESS_SHARE * took)
            self._later(lambda: self._put(payload, True) if self._found is found else None)
        self._later(self._say_state)

    def _step(self, by: int) -> None:
        """Go back to the map before, or forward again."""
        place = self._place + by
        if not 0 <= place < len(self._levels):
            return
        self._place = place
        shape = self._found.shape
        self._cell = min(self._cell[0], shape[0] - 1), min(self._cell[1], shape[1] - 1)
        self._start = min(self._start, len(self._found.starts) - 1)
        self._show_level()

    def _cancel(self, message: Mapping[str, Any]) -> None:
        if self._job is not None:
            self._job.cancel()
        self._tell_job()

    # ---- words

    def _say_state(self) -> None:
        opened = self._opened
        text = opened.kernels
        if opened.kernels == READY and opened.job is not None and opened.job.share < 1:
            text = opened.job.error or f"computing the map: {opened.job.share:.0%}"
        self._tell(state="" if text == READY else text)
        self._tell_job()

    def _tell_job(self) -> None:
        """Tell how the map that is computed stands."""
        job, found = self._job, self._found
        text, running, share = "", False, 0.0
        if job is not None:
            share = job.share
            running = share < 1 and not job.cancelled and not job.error
            if job.error:
                text = job.error
            elif job.cancelled and share < 1:
                text = f"cancelled at {share:.0%}" if job.found is found else ""
            elif running:
                text = f"{job.done} of {job.total} orbits"
        back, forward = self._place > 0, self._place < len(self._levels) - 1
        state = {"running": running, "share": share, "text": text}
        self._tell(job={**state, "back": back, "forward": forward})

    def _tell_sliders(self) -> None:
        values = {**self._scan.system.parameters, **self._found.values_of(self._cell)}
        self._tell(sliders=values | self._free)

    # ---- files

    def _save(self, message: Mapping[str, Any]) -> None:
        """Send what is seen as a file, which the browser saves."""
        what = message["what"]
        if what == "scan":
            ends = tuple((float(a.values[0]), float(a.values[-1])) for a in self._scan.axes)
            settings = self._settings()
            scan = finer(self._scan, ends, settings) if settings else self._scan
            self._send(recipes.SCAN, scan.to_toml())
        elif self._orbit is None:
            raise RequestError("there is no orbit to save yet")
        elif what == "portrait":
            self._send(recipes.PORTRAIT, recipes.portrait_recipe(self._orbit.request))
        elif what == "picture":
            _aside(self._draw, self._orbit)
        else:
            raise RequestError(f"the page asks to save {shown(what)}")

    def _draw(self, orbit: LiveOrbit) -> None:
        """Draw the portrait of an orbit, in a thread of its own, and send it."""
        try:
            text = recipes.picture(orbit.request, orbit.view)
        except (RequestError, OSError, MemoryError) as error:
            self._later(partial(self._tell, trouble=str(error)))
            return
        file = {"name": recipes.PICTURE, "type": "image/png", "base64": text}
        self._later(partial(self._tell, file=file))

    def _send(self, name: str, text: str) -> None:
        self._tell(file={"name": name, "type": "application/toml", "text": text})

    def close(self) -> None:
        """End everything that the page began."""
        self._closed = True
        if self._more in self._opened.listeners:
            self._opened.listeners.remove(self._more)
        if self._job is not None:
            self._job.cancel()


_ACTIONS: Mapping[str, Callable[[Session, Mapping[str, Any]], None]] = {
    "ready": Session._ready,
    "cell": Session._choose,
    "slider": Session._slide,
    "original": Session._original,
    "plane": Session._plane,
    "finer": Session._finer,
    "recompute": Session._recompute,
    "cancel": Session._cancel,
    "back": lambda session, _: session._step(-1),
    "forward": lambda session, _: session._step(1),
    "show": lambda session, _: None,
    "save": Session._save,
}
"""What a page may ask for."""


def _places(system: System) -> Mapping[str, float]:
    """Return where what is struck stands, by name."""
    return system.scene.obstacle(system.parameters)


def _aside(call: Callable[..., object], *arguments: Any) -> None:
    """Call something in a thread of its own, which does not keep the process alive."""
    threading.Thread(target=call, args=arguments, daemon=True).start()


def _in_words(wanted: Wanted, orbit: LiveOrbit) -> dict[str, Any]:
    """Return what the page says of an orbit."""
    regime = orbit.regime
    text = orbit.view._recurrence() if regime is None else words_of(regime)
    return {
        "number": wanted.number,
        "label": orbit.label,
        "words": text,
        "where": f"from {wanted.start.words}",
        "evidence": [] if regime is None else [list(pair) for pair in evidence_of(regime)],
        "command": recipes.portrait_command(orbit.request),
    }


def _no_orbit(wanted: Wanted) -> dict[str, Any]:
    words = {"label": "no orbit", "words": "", "where": f"from {wanted.start.words}", "layout": []}
    return {"number": wanted.number, **words, "evidence": [], "command": ""}
