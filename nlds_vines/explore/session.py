"""One browser's page: what happens when something on it is used.

The page's script sends one message a time through the source `asked`, and is told through `told`.
When the page is closed, everything that it began ends.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from bokeh.document import Document

from nlds_vines.bifurcation.cell_start import CellStart
from nlds_vines.bifurcation.request import Scan
from nlds_vines.errors import RequestError, choice, number, printable, shown, table
from nlds_vines.explore import recipes
from nlds_vines.explore.answers import Payload, in_words, job_state, payload
from nlds_vines.explore.histories import HISTORIES
from nlds_vines.explore.live_orbit import LiveOrbit, OrbitQueue, Sampling, Wanted, aside
from nlds_vines.explore.map_computation import Job
from nlds_vines.explore.map_data import Stored
from nlds_vines.explore.orbit_figures import joined
from nlds_vines.explore.page_document import fill
from nlds_vines.explore.page_state import Chosen
from nlds_vines.explore.shared_map import COMPILING, READY, Opened

PROGRESS_SECONDS = 0.4
"""Seconds between two pictures of a map that is being computed."""

_WRONG = (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError)
"""The errors of a message that no page of ours sends; `RequestError` is a ValueError."""

PROGRESS_SHARE = 10.0
"""How many times longer than sending a map is computed before it is sent again."""


class Session:
    """A page: its document, what is chosen on it, what it has under way."""

    def __init__(self, document: Document, opened: Opened) -> None:
        """Fill a document that shows what was opened."""
        self._document, self._opened = document, opened
        self._chosen = Chosen(opened.found)
        self._job: Job | None = None
        self._orbit: LiveOrbit | None = None
        self._queue = OrbitQueue(self._later, self._show_orbit)
        self._listens = False  # whether the page's script is there
        self._closed = False
        self._next = 0.0  # when the map that is computed may be sent again
        self._data, self._walls = fill(document, opened.found)
        self._data["asked"].on_change("data", self._hear)
        opened.listeners.append(self._more)
        document.on_session_destroyed(lambda _: self.close())

    # ---- messages

    def _hear(self, attribute: str, old: Any, new: Mapping[str, Any]) -> None:
        """Do what a message of the page asks for; say what is wrong with it where something is."""
        texts = new.get("message")
        for text in texts if isinstance(texts, list) else ():
            try:
                message = table("message", json.loads(text))
                _ACTIONS[choice("do", message.get("do"), _ACTIONS)](self, message)
            except _WRONG as error:
                self._tell(trouble=printable(str(error)) or type(error).__name__)

    def _tell(self, **message: Any) -> None:
        """Tell the page something."""
        self._data["told"].data = {"message": [json.dumps(message)]}

    def _later(self, call: Callable[[], object]) -> None:
        """Call something in the thread of the document, unless the page is closed by then."""
        if not self._closed:
            self._document.add_next_tick_callback(lambda: None if self._closed else call())

    @property
    def _found(self) -> Stored:
        return self._chosen.found

    def _ready(self, message: Mapping[str, Any]) -> None:
        self._listens = True
        self._show_level()
        self._say_state()
        self._follow(message)

    def _choose(self, message: Mapping[str, Any]) -> None:
        first, second = (int(place) for place in message["cell"])
        self._chosen.choose((first, second), int(message["start"]))
        self._follow(message)

    def _slide(self, message: Mapping[str, Any]) -> None:
        """Take the value of a parameter; one that the system refuses changes nothing."""
        name, before = str(message["name"]), dict(self._chosen.free)
        self._chosen.free[name] = number(name, message["value"])
        try:
            self._follow(message)
        except _WRONG:
            self._chosen.free = before
            self._tell(sliders=self._chosen.slider_values())
            raise

    def _original(self, message: Mapping[str, Any]) -> None:
        self._chosen.free, self._chosen.own = {}, None
        self._follow(message)

    def _plane(self, message: Mapping[str, Any]) -> None:
        """Begin an orbit where a phase plane was clicked; the other body keeps its last state."""
        if self._orbit is None:
            return
        state = self._orbit.view.section[-1].tolist()
        first = 0 if message["plane"] == "phase1" else 2
        state[first] = number("displacement", message["x"])
        state[first + 1] = number("velocity", message["v"])
        self._chosen.own = CellStart(tuple(state), "a start of your own")
        self._follow(message)

    def _history(self, message: Mapping[str, Any]) -> None:
        """Show other periods of the orbit."""
        self._chosen.history = choice("history", message["name"], HISTORIES)
        self._follow(message)

    # ---- orbits

    def _follow(self, message: Mapping[str, Any]) -> None:
        """Ask for the orbit of what is chosen now."""
        system = self._chosen.system()
        begins = self._chosen.begins(system)
        self._tell(sliders=self._chosen.slider_values())
        sampling, number = Sampling.of(self._found.scan), int(message.get("number", 0))
        self._queue.ask(Wanted(system, begins, sampling, number, self._chosen.history))

    def _show_orbit(self, wanted: Wanted, orbit: LiveOrbit | None, trouble: str) -> None:
        """Show an orbit, or say why there is none."""
        words = in_words(wanted.number, wanted.start, orbit)
        if orbit is not None:
            self._orbit, trouble = orbit, orbit.trouble
            words["layout"], values = joined(orbit.panels)
            self._data["values"].data = {"values": values}
            obstacles = wanted.system.scene.obstacle(wanted.system.parameters)
            for lines, place in zip(self._walls, obstacles.values(), strict=False):
                for line in lines:
                    line.location = float(place)
        self._tell(trouble=trouble, orbit=words)

    # ---- maps

    def _show_level(self) -> None:
        """Send the map that is seen."""
        self._put(payload(self._found), "level")

    def _put(self, found: Payload, what: str) -> None:
        """Send a map: a new `level`, or only more `cells` of the one that is seen."""
        for name, data in found.sources.items():
            self._data[name].data = data
        self._tell(**{what: {**found.meta, "cell": list(self._chosen.cell)}})
        self._tell_job()

    def _finer(self, message: Mapping[str, Any]) -> None:
        """Begin to compute a part of the map finer."""
        ranges = [(float(low), float(high)) for low, high in message["ranges"]]
        self._compute_map(self._chosen.part(ranges))
        self._follow(message)

    def _recompute(self, message: Mapping[str, Any]) -> None:
        """Begin to compute the map with the parameters of the sliders."""
        self._compute_map(self._chosen.part())
        self._follow(message)

    def _compute_map(self, scan: Scan) -> None:
        """Compute a map in the background, and show it while it grows."""
        if self._job is not None:
            self._job.cancel()
        self._job = job = Job(scan, self._more)
        self._chosen.add(job.found)
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
            more = payload(found)
            took = time.monotonic() - now
            self._next = now + max(PROGRESS_SECONDS, PROGRESS_SHARE * took)
            self._later(lambda: self._put(more, "cells") if self._found is found else None)
        self._later(self._say_state)

    def _step(self, by: int, message: Mapping[str, Any]) -> None:
        """Go back to the map before, or forward again."""
        if self._chosen.step(by):
            self._show_level()
            self._follow(message)

    def _cancel(self, message: Mapping[str, Any]) -> None:
        if self._job is not None:
            self._job.cancel()
        self._tell_job()

    def _say_state(self) -> None:
        """Tell what the kernels do, and how far the map is that was to be computed first."""
        text, job = self._opened.kernels, self._opened.job
        if text == COMPILING and self._opened.waited >= 1.0:
            text = f"{text}: {self._opened.waited:.0f} s so far"
        if text == READY:
            text = ""
            if job is not None and job.share < 1:
                text = job.error or job.note or f"computing the map: {job.share:.0%}"
        self._tell(state=text)
        self._tell_job()

    def _tell_job(self) -> None:
        """Tell how the map stands that the page has begun to compute."""
        chosen = self._chosen
        ways = {"back": chosen.place > 0, "forward": chosen.place < len(chosen.levels) - 1}
        self._tell(job={**job_state(self._job, self._found), **ways})

    # ---- files

    def _save(self, message: Mapping[str, Any]) -> None:
        """Send what is seen as a file, which the browser saves."""
        what = message["what"]
        if what == "scan":
            self._send(recipes.SCAN, self._chosen.part().to_toml())
        elif self._orbit is None:
            raise RequestError("there is no orbit to save yet")
        elif what == "portrait":
            self._send(recipes.PORTRAIT, self._orbit.request.to_toml())
        elif what == "picture":
            aside(self._draw, self._orbit)
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
    "history": Session._history,
    "finer": Session._finer,
    "recompute": Session._recompute,
    "cancel": Session._cancel,
    "back": lambda session, message: session._step(-1, message),
    "forward": lambda session, message: session._step(1, message),
    "show": lambda session, _: None,
    "save": Session._save,
}
"""What a page may ask for."""
