"""heyoka's Taylor integrator, contacts split off by terminal events and regularised.

A Taylor series sees nothing of a wall ahead and has no terms for z^1.5 at z = 0, so this is the way
to use it: one integrator for flight, one for each wall. In a contact, with z = w^2 and
dt = 2 w dsigma, the equations are polynomials: dw/dsigma = dz/dt, and z^1.5 = w^3. They pass touch
and release without noticing.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from benchmarks.rivals.equation import begin, constants, depth
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

RELEASE, MOMENT = -1, -2  # outcomes of a contact: the first and the second event ended it
FAR_AWAY = 1e300  # sigma that no contact reaches


def _event(zero: Any, direction: str) -> Any:
    """Return a terminal event that is found again at once.

    By default an event is blind for a while after it was found, so as not to be found twice; here
    its direction sees to that.
    """
    import heyoka as hk

    return hk.t_event(zero, direction=getattr(hk.event_direction, direction), cooldown=0.0)


def _flight(p: list[float], tolerance: float) -> Any:
    """Return the integrator of a flight; its events are the touches of the walls that exist."""
    import heyoka as hk

    m1, k1, c1, m2, k2, c2, P, omega, _, near, far, rest = p[:12]
    x1, v1, x2, v2 = hk.make_vars("x1", "v1", "x2", "v2")
    r = x1 - x2 + rest
    pull = k2 * r + c2 * (v1 - v2)
    force = P * hk.cos(omega * hk.time) - k1 * x1 - c1 * v1 - pull
    depths = [z for z, gap in ((r - near, near), (-r - far, far)) if math.isfinite(gap)]
    return hk.taylor_adaptive(
        [(x1, v1), (v1, force / m1), (x2, v2), (v2, pull / m2)],
        [0.0] * 4,
        tol=tolerance,
        t_events=[_event(z, "positive") for z in depths],
    )


def _contact(p: list[float], wall: int, tolerance: float) -> Any:
    """Return the integrator of a contact in x1, v1, w, dz/dt and the time since its beginning.

    Parameters: time of its beginning, and the time since then at which it is to stop. Events: the
    release, and that moment.
    """
    import heyoka as hk

    m1, k1, c1, m2, k2, c2, P, omega, K, near, far = p[:11]
    x1, v1, w, speed, passed = hk.make_vars("x1", "v1", "w", "speed", "passed")
    sign, gap = (1.0, near) if wall == 0 else (-1.0, far)
    pull = sign * (k2 * (gap + w * w) + c2 * speed + K * (w * w * w))
    force = P * hk.cos(omega * (passed + hk.par[0])) - k1 * x1 - c1 * v1 - pull
    a1, a2, rate = force / m1, pull / m2, 2.0 * w
    return hk.taylor_adaptive(
        [
            (x1, rate * v1),
            (v1, rate * a1),
            (w, speed),
            (speed, rate * (sign * (a1 - a2))),
            (passed, rate),
        ],
        [0.0] * 5,
        pars=[0.0, 0.0],
        tol=tolerance,
        t_events=[_event(w, "negative"), _event(passed - hk.par[1], "positive")],
    )


class _Integrators:
    """The integrators of a system at one tolerance, and the way from one to another.

    Python is needed at touch, release and noted times only.
    """

    def __init__(self, p: np.ndarray, tolerance: float) -> None:
        import heyoka as hk

        self.p, numbers = p, p.tolist()
        self.walls = [wall for wall in (0, 1) if math.isfinite(p[9 + wall])]
        self.flight = _flight(numbers, tolerance)
        self.contacts = {wall: _contact(numbers, wall, tolerance) for wall in self.walls}
        self.reached = hk.taylor_outcome.time_limit
        self.offsets = numbers[11] - numbers[9], numbers[11] + numbers[10]  # x2 - x1 at a touch

    def follow(self, start: np.ndarray, times: np.ndarray, most: int) -> Track:
        """Follow an orbit to the last of the times, noting its states at all of them.

        Gives up after so many touches.
        """
        self.moments, self.states = [*times.tolist(), math.inf], np.empty((len(times), 4))
        self.noted, self.touches, self.releases, self.steps = 0, list[float](), 0, 0
        watch, flight, state = np.zeros(3), self.flight, self.flight.state
        begin(self.p, start, watch)
        flight.time, state[:], wall = 0.0, start, int(watch[1])
        if self.walls and watch[0] > 0.0:
            self._contact(wall, max(0.0, depth(self.p, watch[1], start[0], start[2])))
        until, reached, moments = flight.propagate_until, self.reached, self.moments
        while self.noted < len(times):
            outcome = until(moments[self.noted], BUDGET)[0]
            if outcome == reached:
                self._note(state)
                continue
            if not -len(self.walls) <= int(outcome) < 0:
                raise SolverFailure(f"in flight at t = {flight.time:.6g} s: {outcome}")
            self.touches.append(flight.time)
            if len(self.touches) > most:
                raise SolverFailure(f"more than {most} touches up to t = {flight.time:.6g} s")
            self._contact(self.walls[-1 - int(outcome)], 0.0)
        mean = self.steps / self.releases if self.releases else None
        return Track(self.states, self.touches, mean)

    def _note(self, state: Any) -> None:
        self.states[self.noted] = state
        self.noted += 1

    def _contact(self, wall: int, z: float) -> None:
        """Follow a contact of depth z [m] from where the flight ended to where the next begins."""
        flight, contact, moments = self.flight, self.contacts[wall], self.moments
        t, sign, offset = flight.time, 1.0 - 2.0 * wall, self.offsets[wall]
        while moments[self.noted] <= t:
            self._note(flight.state)
        x1, v1, _, v2 = flight.state.tolist()
        state, pars, until = contact.state, contact.pars, contact.propagate_until
        state[:] = x1, v1, math.sqrt(z), sign * (v1 - v2), 0.0
        contact.time, pars[0], pars[1] = 0.0, t, moments[self.noted] - t
        while True:
            outcome, _, _, steps = until(FAR_AWAY, BUDGET)[:4]
            x1, v1, w, speed, passed = state.tolist()
            flight.state[:] = x1, v1, x1 + offset - sign * w * w, v1 - sign * speed
            self.steps += steps
            if int(outcome) == RELEASE:
                break
            if int(outcome) != MOMENT:
                raise SolverFailure(f"in the contact at t = {t + passed:.6g} s: {outcome}")
            self._note(flight.state)
            pars[1] = moments[self.noted] - t
            if self.noted == len(self.states):
                return
        flight.time = t + passed
        self.releases += 1


def _prepare(system: System, start: np.ndarray) -> Flow:
    p, state = constants(system), begun(system, start)

    @cache
    def integrators(tolerance: float) -> _Integrators:
        return _Integrators(p, tolerance)

    def follow(tolerance: float, times: np.ndarray, watched: bool) -> Track:
        try:
            return integrators(tolerance).follow(state, times, most_events(system, times))
        except ValueError as error:  # a state that is not finite
            raise SolverFailure(str(error)) from None

    return flow_of(system, state, follow)


RIVALS = (
    Rival(
        name="heyoka Taylor, events",
        settings=(*TOLERANCES, 1e-14),
        setting="rtol",
        events=True,
        compiled=True,
        needs="heyoka",
        prepare=_prepare,
    ),
)
