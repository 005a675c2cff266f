"""numbalsoda: LSODA and DOP853 in compiled code, with compiled right-hand sides.

Plain LSODA and DOP853 are `numbalsoda.lsoda` and `numbalsoda.dop853`. With events it is the DOP853
behind `numbalsoda.solve_ivp`, called as `solve_ivp` itself calls it: that function spends a quarter
of the time on the text of a message.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from benchmarks.rivals.equation import (
    begin,
    constants,
    derivative,
    indicator,
    switch,
    turning,
)
from benchmarks.rivals.rival import (
    BUDGET,
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

CONSTANTS, WATCH = 13, 4  # numbers of `constants`; of `begin`, and since when it has turned
SWITCH, TURN = 0, 1  # events by their number: touch or release, and turn of an approach
WINDOW = 16  # forcing periods that one call may follow: it makes room for all that is noted


@cache
def _compiled() -> tuple[Any, Any]:
    """Compile right-hand side and event function to what C can call."""
    import numba
    from numbalsoda import lsoda_sig

    def rates(t, y, dy, data):
        p = numba.carray(data, (CONSTANTS,))
        dy[0], dy[1], dy[2], dy[3] = derivative(p, p[7] * t, y[0], y[1], y[2], y[3])

    def event(t, y, value, data):
        numbers = numba.carray(data, (CONSTANTS + WATCH,))
        state = numba.carray(y, (4,))
        p, watch = numbers[:CONSTANTS], numbers[CONSTANTS:]
        value[0] = indicator(p, watch, t, state)
        value[1] = 1.0 if watch[0] > 0.0 else turning(p, watch[3], t, state)

    return numba.cfunc(lsoda_sig)(rates), numba.cfunc(lsoda_sig)(event)


@cache
def _piece() -> Callable[..., Any]:
    """Compile one call of DOP853: to the end of a window, or to the event before."""
    import numba
    from numbalsoda import driver_solve_ivp

    solve, result = (  # named here: compiled code takes them as constants
        driver_solve_ivp.dop853_solve_ivp_wrapper,
        driver_solve_ivp.dop853_solve_ivp_result,
    )

    def piece(rates, event, data, span, y, rtol, times, when, states, end, message):
        sizes, handle = np.zeros(3, np.int32), np.zeros(1, np.int64)
        counts, flags = np.zeros(2, np.int32), np.zeros(2, np.bool_)
        solve(
            rates, span.ctypes.data, 4, y.ctypes.data, times.size, times.ctypes.data,
            2, event, data.ctypes.data, 0.0, 0.0, rtol, 1e-3 * rtol, sizes.ctypes.data,
            sizes[1:].ctypes.data, sizes[2:].ctypes.data, handle.ctypes.data,
        )  # fmt: skip
        result(
            handle[0], 4, sizes[0], sizes[1], message.ctypes.data, flags.ctypes.data,
            counts.ctypes.data, when.ctypes.data, states.ctypes.data, flags[1:].ctypes.data,
            counts[1:].ctypes.data, end.ctypes.data, end[1:].ctypes.data,
        )  # fmt: skip
        return flags[0], counts[1] if flags[1] else -1, sizes[1]

    return numba.njit(piece)


@cache
def _splitting() -> Callable[..., Any]:
    """Compile the loop over pieces between events."""
    import numba

    piece = _piece()

    def follow(rates, event, p, start, rtol, times, longest, states, touches, most):
        data = np.empty(CONSTANTS + WATCH)
        data[:CONSTANTS], watch = p, data[CONSTANTS:]
        y, span, end, unused = start.copy(), np.zeros(2), np.zeros(5), np.empty((1, 4))
        when, message = np.empty(times.size), np.empty(256, np.uint8)
        begin(p, y, watch)
        watch[3] = np.nan
        noted = found = pieces = 0
        while noted < times.size:
            last = max(np.searchsorted(times, span[0] + longest, "right"), noted + 1)
            span[1], wanted = times[last - 1], times[noted:last]
            well, struck, got = piece(
                rates, event, data, span, y, rtol, wanted, when, states[noted:], end, message
            )
            noted += got
            if well and struck == TURN and indicator(p, watch, end[0], end[1:]) > 0.0:
                span[1] = end[0]  # again, up to there: where a step ends it looks for a touch
                turned = end.copy()
                well, struck, _ = piece(
                    rates, event, data, span, y, rtol, span[1:], when, unused, end, message
                )
                if struck != SWITCH:  # by round-off nothing is touched before it
                    struck, end[:] = TURN, turned
            pieces += 1
            if not well or pieces > most:
                return -1
            if struck == TURN:
                span[0], y[:], watch[3] = end[0], end[1:], end[0]
            elif struck == SWITCH:
                span[0], y[:], watch[3] = end[0], end[1:], np.nan
                if switch(p, span[0], y, watch):
                    if found < touches.size:
                        touches[found] = span[0]
                    found += 1
            else:
                span[0], y[:] = span[1], states[noted - 1]
        return found

    return numba.njit(follow)


def _events(system: System, start: np.ndarray) -> Flow:
    p, state = constants(system), begun(system, start)
    if not system.scene.walls:
        return _plain(system, start, method="dop853")
    rates, event = _compiled()
    split = _splitting()

    def follow(rtol: float, times: np.ndarray, watched: bool) -> Track:
        periods = math.ceil(times[-1] / system.period)
        states, room = np.empty((len(times), 4)), 64 + 16 * periods
        while True:
            touches = np.empty(room)
            room = split(
                rates.address, event.address, p, state, rtol, times, WINDOW * system.period,
                states, touches, len(times) + most_events(system, times),
            )  # fmt: skip
            if room < 0:
                raise SolverFailure("DOP853 gave up: too many steps or events, or steps too small")
            if room <= touches.size:
                return Track(states, touches[:room])

    return flow_of(system, state, follow)


def _plain(system: System, start: np.ndarray, *, method: str) -> Flow:
    import numbalsoda

    p, state = constants(system), begun(system, start)
    rates, _ = _compiled()
    solve = getattr(numbalsoda, method)

    def follow(rtol: float, times: np.ndarray, watched: bool) -> Track:
        grid = np.concatenate([[0.0], times])
        states, well = solve(rates.address, state, grid, p, rtol, 1e-3 * rtol, BUDGET)
        if not well:
            raise SolverFailure(f"{method.upper()} gave up: too many steps, or steps too small")
        return Track(states[1:])

    return flow_of(system, state, follow)


def _rival(name: str, prepare: Callable[..., Flow], order: float | None) -> Rival:
    return Rival(
        name=f"numbalsoda {name}",
        settings=TOLERANCES,
        setting="rtol",
        events=name.endswith("events"),
        compiled=True,
        needs="numbalsoda",
        prepare=prepare,
        order=order,
    )


RIVALS = (
    _rival("DOP853, events", _events, 8.0),
    _rival("DOP853", partial(_plain, method="dop853"), 8.0),
    _rival("LSODA", partial(_plain, method="lsoda"), None),
)
