"""Orbits that a page asks for: computed aside, one at a time, the last one that is wanted."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from nlds_vines.bifurcation.cell_start import CellStart
from nlds_vines.errors import RequestError
from nlds_vines.explore.histories import SETTLED
from nlds_vines.explore.live_orbit import LiveOrbit, Sampling, live_orbit
from nlds_vines.model.system import System

Show = Callable[["Wanted", LiveOrbit | None, str], object]
"""What shows an orbit, or None and why there is none."""


class Wanted(NamedTuple):
    """An orbit that is asked for: its system, its start, how it is followed, the message's number.

    `history` is one of `histories.HISTORIES`.
    """

    system: System
    start: CellStart
    sampling: Sampling
    number: int = 0
    history: str = SETTLED


class OrbitQueue:
    """Computes orbits; of several that are asked for meanwhile only the last one.

    Attributes: `busy`, whether an orbit is under way.
    """

    def __init__(self, later: Callable[[Callable[[], object]], object], show: Show) -> None:
        """Take what calls something in the thread of the page, and what shows an orbit there."""
        self.busy = False
        self._later, self._show = later, show
        self._wanted: Wanted | None = None

    def ask(self, wanted: Wanted) -> None:
        """Compute an orbit after the one that is under way."""
        self._wanted = wanted
        if not self.busy:
            self._begin()

    def _begin(self) -> None:
        wanted, self._wanted, self.busy = self._wanted, None, True
        assert wanted is not None
        aside(self._compute, wanted)

    def _compute(self, wanted: Wanted) -> None:
        """Follow an orbit, in a thread of its own."""
        from nlds_vines.orbits.simulation import IntegrationError

        orbit, trouble = None, ""
        try:
            orbit = live_orbit(
                wanted.system, wanted.start.state, wanted.sampling, history=wanted.history
            )
        except (RequestError, IntegrationError, MemoryError) as error:
            trouble = str(error) or type(error).__name__
        self._later(partial(self._done, wanted, orbit, trouble))

    def _done(self, wanted: Wanted, orbit: LiveOrbit | None, trouble: str) -> None:
        """Show what came of an orbit, and begin with the next that is wanted."""
        self.busy = False
        if self._wanted is not None:
            self._begin()
        self._show(wanted, orbit, trouble)


def aside(call: Callable[..., object], *arguments: object) -> None:
    """Call something in a thread of its own, which does not keep the process alive."""
    threading.Thread(target=call, args=arguments, daemon=True).start()
