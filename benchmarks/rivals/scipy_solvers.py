"""SciPy's solvers, each used well, with contacts split off at touch and release, and plainly.

Steps and dense output are those of `solve_ivp` without its lists, which makes them a little faster.
With events a step that ends beyond a wall is cut where its dense output crosses the wall, and the
solver begins anew there. So is a step in flight within which the approach turns beyond a wall, as
it does near grazing. Radau and BDF get the Jacobian.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from benchmarks.rivals.equation import (
    begin,
    closing,
    constants,
    indicator,
    jacobian,
    slope,
    switch,
    turns,
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
)
from nlds_vines.model.system import System

FINEST = {
    "Radau": 1e-10,  # beyond, it takes thousands of steps a contact
    "BDF": 1e-10,  # beyond, its Newton iteration asks for more digits than there are
}
_ORDERS = {"RK45": 5.0, "DOP853": 8.0, "Radau": 5.0, "BDF": None, "LSODA": None}


class _Run:
    """One orbit under way: its state, its kind of piece, and what is noted of it."""

    def __init__(
        self, p: np.ndarray, start: np.ndarray, times: np.ndarray, split: bool, watched: bool
    ) -> None:
        walls = math.isfinite(min(p[9], p[10]))
        self.p, self.times, self.split = p, times, split and walls
        self.looking = walls and (split or watched)
        self.t, self.y, self.watch, self.speed = 0.0, start, np.zeros(3), closing(start)
        begin(p, start, self.watch)
        self.states, self.noted = np.empty((len(times), 4)), 0
        self.touches: list[float] = []
        self.releases = self.inside_steps = self.steps = 0
        self.most = BUDGET_IN_PYTHON * math.ceil(times[-1] * p[7] / (2.0 * math.pi))

    def advance(self, new_solver: Callable[..., Any]) -> None:
        """Follow the orbit to the next event, if they split it, or to the end."""
        solver, self.speed = new_solver(t0=self.t, y0=self.y), closing(self.y)
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise SolverFailure(f"at t = {solver.t:.6g} s: {message}")
            self.steps += 1
            if self.steps > self.most:
                raise SolverFailure(f"more than {self.most} steps up to t = {solver.t:.6g} s")
            self.inside_steps += self.watch[0] > 0.0
            until = self._passed(solver) if self.looking else math.nan
            ended = not math.isnan(until)
            if ended or self.times[self.noted] <= solver.t:
                path = solver.dense_output()
                if ended and self._split(path, solver.t_old, until):
                    return
                self._note(solver.t, path)
        self.t, self.y = solver.t, solver.y

    def _passed(self, solver: Any) -> float:
        """Return when, within a step, the orbit is where its piece does not belong; NaN if never.

        Looked at are the end of the step and, where events split a flight, its turning point.
        """
        before, self.speed = self.speed, closing(solver.y)
        if self.split and self.watch[0] == 0.0 and turns(self.p, before, self.speed):
            path = solver.dense_output()
            turn = _zero(lambda t: closing(path(t)), solver.t_old, solver.t)
            if indicator(self.p, self.watch, turn, path(turn)) > 0.0:
                return turn
        value = indicator(self.p, self.watch, solver.t, solver.y)
        return solver.t if (value > 0.0) != (self.watch[0] > 0.0) else math.nan

    def _split(self, path: Any, before: float, after: float) -> bool:
        """Note the event between two times; return whether the orbit is to be split there."""

        def value(t: float) -> float:
            return indicator(self.p, self.watch, t, path(t))

        t = _zero(value, before, after)
        y = path(t)
        if self.split:
            self._note(t, path)
            self.t, self.y = t, y
        if switch(self.p, t, y, self.watch):
            self.touches.append(t)
        else:
            self.releases += 1
        if not self.split:
            self.watch[2] = math.nan  # no piece begins on the wall
        return self.split

    def _note(self, until: float, path: Any) -> None:
        """Write down the states at all times up to `until` that are not yet noted."""
        last = int(np.searchsorted(self.times, until, side="right"))
        if last > self.noted:
            self.states[self.noted : last] = path(self.times[self.noted : last]).T
            self.noted = last


def _zero(value: Callable[[float], float], before: float, after: float) -> float:
    """Return where a function changes its sign; an end where, by round-off, it does not."""
    from scipy.optimize import brentq

    first, last = value(before), value(after)
    if first * last >= 0.0:
        return before if abs(first) < abs(last) else after
    return brentq(value, before, after, xtol=1e-15, rtol=1e-15)


def _prepare(system: System, start: np.ndarray, *, method: str, split: bool) -> Flow:
    from scipy import integrate

    p, state = constants(system), begun(system, start)
    options: dict[str, Any] = {}
    if method in ("Radau", "BDF"):
        options["jac"] = lambda t, y: jacobian(t, y, p)
    solver = partial(getattr(integrate, method), lambda t, y: slope(t, y, p), **options)

    def follow(rtol: float, times: np.ndarray, watched: bool) -> Track:
        run = _Run(p, state, times, split, watched)
        bound = partial(solver, t_bound=times[-1], rtol=rtol, atol=1e-3 * rtol)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # of a failure, which is raised
            try:
                while run.noted < len(times):
                    run.advance(bound)
            except (ArithmeticError, ValueError) as error:
                raise SolverFailure(f"at t = {run.t:.6g} s or later: {error}") from None
        mean = run.inside_steps / run.releases if run.split and run.releases else None
        return Track(run.states, run.touches, mean)

    return flow_of(system, state, follow)


RIVALS = tuple(
    Rival(
        name=f"SciPy {method}, events" if split else f"SciPy {method}",
        settings=tuple(rtol for rtol in TOLERANCES if rtol >= FINEST.get(method, 0.0)),
        setting="rtol",
        events=split,
        compiled=False,
        needs="",
        prepare=partial(_prepare, method=method, split=split),
        order=order,
    )
    for method, order in _ORDERS.items()
    for split in (True, False)
)
