"""CVODE of SUNDIALS through scikit-sundae: BDF and Adams, with its own root finding and plainly.

Each call of a Python function from within costs about 3 us, ten times what the compiled function
itself takes; there is no other way. The Jacobian is given.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from nlds_vines.peers.base import BUDGET, Flow, Peer, PeerFailure, Track, begun, flow_of
from nlds_vines.peers.equation import (
    begin,
    constants,
    depth,
    indicator,
    jacobian_into,
    slope_into,
    switch,
)
from nlds_vines.system import System

SETTINGS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
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
        max_num_steps=BUDGET,
        **events,
    )


def _split(p: np.ndarray, start: np.ndarray, times: np.ndarray, new: Callable[..., Any]) -> Track:
    """Follow an orbit piece by piece from event to event; CVODE interpolates at the times."""
    watch, states, noted, t, y = np.zeros(3), np.empty((len(times), 4)), 0, 0.0, start
    begin(p, start, watch)
    touches, events = list[float](), 0

    def event(t: float, y: np.ndarray, value: np.ndarray) -> None:
        value[0] = indicator(p, watch, t, y)

    most = BUDGET * math.ceil(times[-1] * p[7] / (2.0 * math.pi))
    while noted < len(times):
        if events % RENEWED == 0:
            solver = new(eventsfn=event, num_events=1)
        solver.init_step(t, y)
        while noted < len(times):
            found = solver.step(times[noted], "normal", None)
            if found.status == ROOT:
                break
            if not found.success:
                raise PeerFailure(f"at t = {found.t:.6g} s: {found.message}")
            states[noted] = found.y
            noted += 1
        t, y, events = found.t, found.y, events + 1
        if events > most:
            raise PeerFailure(f"more than {most} events up to t = {t:.6g} s")
        if found.status == ROOT and switch(p, t, y, watch):
            touches.append(t)
    return Track(states, touches)


def _whole(
    p: np.ndarray, start: np.ndarray, times: np.ndarray, counting: bool, new: Callable[..., Any]
) -> Track:
    """Follow an orbit in one go; touches are noted on the way if they are to be counted."""
    walls = [wall for wall in (0.0, 1.0) if math.isfinite(p[9 + int(wall)])]

    def touch(t: float, y: np.ndarray, value: np.ndarray) -> None:
        for i, wall in enumerate(walls):
            value[i] = depth(p, wall, y[0], y[2])

    counting = counting and bool(walls)
    touch.terminal, touch.direction = [False] * len(walls), [1] * len(walls)  # type: ignore[attr-defined]  # the library's way
    solver = new(eventsfn=touch, num_events=len(walls)) if counting else new()
    found = solver.solve(np.concatenate([[0.0], times]), start)
    if not found.success:
        raise PeerFailure(f"at t = {found.t[-1]:.6g} s: {found.message}")
    touches = [] if found.t_events is None else found.t_events
    return Track(found.y[1:], touches if counting else None)


def _prepare(system: System, start: np.ndarray, *, method: str, split: bool) -> Flow:
    p, state = constants(system), begun(system, start)

    def follow(rtol: float, times: np.ndarray, watched: bool) -> Track:
        new = partial(_solver, p, method, rtol)
        try:
            if split and system.scene.walls:
                return _split(p, state, times, new)
            return _whole(p, state, times, watched, new)
        except (ArithmeticError, RuntimeError) as error:
            raise PeerFailure(str(error)) from None

    return flow_of(system, state, follow)


PEERS = tuple(
    Peer(
        name=f"SUNDIALS {method}, events" if split else f"SUNDIALS {method}",
        settings=SETTINGS,
        setting="rtol",
        events=split,
        compiled=False,
        needs="scikit-sundae",
        prepare=partial(_prepare, method=method, split=split),
    )
    for method in ("BDF", "Adams")
    for split in (True, False)
)
