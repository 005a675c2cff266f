"""CVODE of SUNDIALS through scikit-sundae: BDF and Adams, with its own root finding and plainly.

Each call of a Python function from within costs about 3 us, ten times what the compiled function
itself takes; there is no other way. The Jacobian is given. With events it stops at touch, release
and, in flight, where an approach to a wall turns: was the wall passed, it goes back for the touch.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from benchmarks.rivals.equation import (
    begin,
    closing,
    constants,
    depth,
    indicator,
    jacobian_into,
    slope_into,
    switch,
)
from benchmarks.rivals.rival import (
    BUDGET_IN_PYTHON,
    TOLERANCES,
    Flow,
    Rival,
    SolverFailure,
    Track,
    begun,
    flow_of,
    most_events,
)
from nlds_vines.model.system import System

ROOT = 2  # status of a step that ended at an event
RENEWED = 32  # events after which CVODE is made anew: after each step it lists all of them


def _solver(p: np.ndarray, method: str, rtol: float, **events: Any) -> Any:
    from sksundae.cvode import CVODE

    return CVODE(
        lambda t, y, dy: slope_into(p, t, y, dy),
        jacfn=lambda t, y, dy, J: jacobian_into(p, y, J),
        method=method,
        rtol=rtol,
        atol=1e-3 * rtol,
        max_num_steps=BUDGET_IN_PYTHON,
        **events,
    )


def _watching(p: np.ndarray, watch: np.ndarray) -> Callable[..., None]:
    """Return the event function: touch or release, and in flight the turn of an approach.

    Steps are longer than contacts near grazing, whose ends show nothing of them.
    """

    def event(t: float, y: np.ndarray, value: np.ndarray) -> None:
        value[0] = indicator(p, watch, t, y)
        value[1] = closing(y) if watch[0] == 0.0 else 1.0

    turn = (0 if math.isfinite(p[10]) else -1) if math.isfinite(p[9]) else 1
    event.direction = [0, turn]  # type: ignore[attr-defined]  # the library's way
    return event


class _Split:
    """One orbit under way, from event to event; CVODE interpolates at the times."""

    def __init__(
        self,
        p: np.ndarray,
        start: np.ndarray,
        times: np.ndarray,
        most: int,
        new: Callable[..., Any],
    ) -> None:
        self.p, self.times, self.most, self.new = p, times, most, new
        self.watch, self.t, self.y = np.zeros(3), 0.0, start
        begin(p, start, self.watch)
        self.states, self.noted, self.touches = np.empty((len(times), 4)), 0, list[float]()
        self.events, self.listed, self.solver = 0, 0, self._renewed()

    def _renewed(self) -> Any:
        return self.new(eventsfn=_watching(self.p, self.watch), num_events=2)

    def follow(self) -> Track:
        """Follow the orbit to the last of the times."""
        while self.noted < len(self.times):
            self._advance()
        return Track(self.states, self.touches)

    def _advance(self) -> None:
        """Follow the orbit to the next touch or release, or to the end.

        Where an approach turned beyond the wall, the piece is followed again up to that turn: CVODE
        looks for events at the time that it is asked for as well as at the ends of its steps.
        """
        if self.listed >= RENEWED:
            self.solver, self.listed = self._renewed(), 0
        solver, turn = self.solver, math.inf
        solver.init_step(self.t, self.y)
        while self.noted < len(self.times):
            found = solver.step(min(self.times[self.noted], turn), "normal", None)
            if found.status != ROOT:
                turn = self._note(found, turn)
                continue
            self._count(found.t)
            if found.i_events[-1][0] != 0:
                self._switch(found)
                return
            if indicator(self.p, self.watch, found.t, found.y) > 0.0:
                turn = found.t
                solver.init_step(self.t, self.y)
            elif self.listed >= RENEWED:
                self.t, self.y = found.t, found.y
                return

    def _note(self, found: Any, turn: float) -> float:
        """Write down the state at a time that is noted; return up to where to go on."""
        if not found.success:
            raise SolverFailure(f"at t = {found.t:.6g} s: {found.message}")
        if self.times[self.noted] > turn:  # by round-off nothing is touched before it
            return math.inf
        self.states[self.noted] = found.y
        self.noted += 1
        return turn

    def _count(self, t: float) -> None:
        """Count an event; raises `SolverFailure` where there are too many."""
        self.events, self.listed = self.events + 1, self.listed + 1
        if self.events > self.most:
            raise SolverFailure(f"more than {self.most} events up to t = {t:.6g} s")

    def _switch(self, found: Any) -> None:
        self.t, self.y = found.t, found.y
        if switch(self.p, self.t, self.y, self.watch):
            self.touches.append(self.t)


def _whole(
    p: np.ndarray, start: np.ndarray, times: np.ndarray, counting: bool, new: Callable[..., Any]
) -> Track:
    """Follow an orbit in one go; touches are noted on the way if they are to be counted."""
    walls = [wall for wall in (0.0, 1.0) if math.isfinite(p[9 + int(wall)])]

    def touch(t: float, y: np.ndarray, value: np.ndarray) -> None:
        for i, wall in enumerate(walls):
            value[i] = depth(p, wall, y[0], y[2])

    counting = counting and bool(walls)
    touch.terminal = [False] * len(walls)  # type: ignore[attr-defined]  # the library's way
    touch.direction = [1] * len(walls)  # type: ignore[attr-defined]  # likewise
    solver = new(eventsfn=touch, num_events=len(walls)) if counting else new()
    found = solver.solve(np.concatenate([[0.0], times]), start)
    if not found.success:
        raise SolverFailure(f"at t = {found.t[-1]:.6g} s: {found.message}")
    touches = [] if found.t_events is None else found.t_events
    return Track(found.y[1:], touches if counting else None)


def _prepare(system: System, start: np.ndarray, *, method: str, split: bool) -> Flow:
    p, state = constants(system), begun(system, start)

    def follow(rtol: float, times: np.ndarray, watched: bool) -> Track:
        new = partial(_solver, p, method, rtol)
        try:
            if split and system.scene.walls:
                return _Split(p, state, times, most_events(system, times), new).follow()
            return _whole(p, state, times, watched, new)
        except (ArithmeticError, RuntimeError) as error:
            raise SolverFailure(str(error)) from None

    return flow_of(system, state, follow)


RIVALS = tuple(
    Rival(
        name=f"SUNDIALS {method}, events" if split else f"SUNDIALS {method}",
        settings=TOLERANCES,
        setting="rtol",
        events=split,
        compiled=False,
        needs="scikit-sundae",
        module="sksundae",
        prepare=partial(_prepare, method=method, split=split),
    )
    for method in ("BDF", "Adams")
    for split in (True, False)
)
