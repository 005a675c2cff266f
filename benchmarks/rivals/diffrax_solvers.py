"""diffrax on one processor in double precision: all of an orbit is one compiled program.

With events the loop over pieces is compiled too; each piece ends at a touch or release, found by
bisection, where a state is noted, or, in flight, where x1 - x2 turns. Of a step that passes a wall
and turns beyond it, the touch is found, which comes first. Time counts from the
last event. What is compiled serves all systems with as many walls, but depends on how many states
are noted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np

from benchmarks.rivals.equation import begin, constants
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

LEAST = 8192  # samples of an orbit that are always asked for: what is compiled is of use again
PRECISE = 1e-13  # tolerance of the bisection, relative and absolute [s, m/s]


@contextmanager
def _double_precision() -> Iterator[None]:
    """Compute on the processor in double precision here, whatever is set elsewhere."""
    import jax

    with jax.enable_x64(True), jax.default_device(jax.local_devices(backend="cpu")[0]):
        yield


class Walls(NamedTuple):
    """Which walls there are: what is not there is not compiled."""

    near: bool
    far: bool


def _field(p: Any, walls: Walls, implicit: bool) -> Callable[..., Any]:
    """Return the derivative of eq. (5) at the time t after `args[0]`; p: `equation.constants`."""
    import jax.numpy as jnp

    m1, k1, c1, m2, k2, c2, P, omega, K, near, far, rest = (p[i] for i in range(12))

    def hertz(z: Any) -> Any:
        if not implicit:
            pressed = jnp.maximum(z, 0.0)
            return K * pressed * jnp.sqrt(pressed)
        pressed = jnp.where(z > 0.0, z, 1.0)  # or differentiation would meet the root of 0
        return jnp.where(z > 0.0, K * pressed * jnp.sqrt(pressed), 0.0)

    def field(t: Any, y: Any, args: Any) -> Any:
        x1, v1, x2, v2 = y[0], y[1], y[2], y[3]
        r = x1 - x2 + rest
        pull = k2 * r + c2 * (v1 - v2)
        if walls.near:
            pull = pull + hertz(r - near)
        if walls.far:
            pull = pull - hertz(-r - far)
        force = P * jnp.cos(omega * (args[0] + t)) - k1 * x1 - c1 * v1 - pull
        return jnp.stack([v1, force / m1, v2, pull / m2])

    return field


def _integrate(field: Callable[..., Any], solver: Any, rtol: Any, **settings: Any) -> Any:
    """Return what diffrax finds of one piece; nothing but its end is kept."""
    import diffrax

    return diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        solver,
        dt0=None,
        saveat=diffrax.SaveAt(t1=True),
        stepsize_controller=diffrax.PIDController(rtol=rtol, atol=1e-3 * rtol),
        adjoint=diffrax.ForwardMode(),
        max_steps=BUDGET,
        throw=False,
        **settings,
    )


def _plain(walls: Walls, solver: Any, implicit: bool) -> Callable[..., Any]:
    """Return the program that follows an orbit from one noted time to the next."""
    import diffrax
    import jax
    import jax.numpy as jnp

    def follow(p: Any, start: Any, rtol: Any, times: Any) -> Any:
        field = _field(p, walls, implicit)

        def stretch(reached: Any, ends: Any) -> Any:
            y, well = reached
            duration = jnp.where(well, ends[1] - ends[0], 0.0)  # after a failure nothing is done
            found = _integrate(field, solver, rtol, t0=0.0, t1=duration, y0=y, args=(ends[0],))
            well = well & (found.result == diffrax.RESULTS.successful)
            return (found.ys[0], well), found.ys[0]

        begin_and_end = (times[:-1], times[1:])
        (_, well), states = jax.lax.scan(stretch, (start, jnp.array(True)), begin_and_end)
        return states, well

    return follow


class _Piece(NamedTuple):
    """Where an orbit is, what kind of piece it is on, and what has been noted.

    The time is `since` + `t`; `restarted`: at `since` it was on the wall; `wall`: 0 near, 1 far;
    `heading`: 1 towards the near wall, -1 away from it; `turned`: it changed at `t`.
    """

    since: Any
    t: Any
    y: Any
    inside: Any
    wall: Any
    restarted: Any
    heading: Any
    turned: Any
    noted: Any
    states: Any
    touches: Any
    found: Any
    steps: Any  # in contact
    pieces: Any
    well: Any


def _depth(p: Any, wall: Any, y: Any) -> Any:
    """Return how deep a wall is pressed in [m]."""
    import jax.numpy as jnp

    r = y[0] - y[2] + p[11]
    return jnp.where(wall == 0, r - p[9], -r - p[10])


def _indicator(p: Any) -> Callable[..., Any]:
    """Return `equation.indicator`, counted so that it rises through zero."""
    import jax.numpy as jnp

    def rising(t: Any, y: Any, args: Any) -> Any:
        _, inside, wall, restarted, *_ = args
        near, far = _depth(p, 0, y), _depth(p, 1, y)
        z = jnp.where(inside, jnp.where(wall == 0, near, far), jnp.maximum(near, far))
        speed = jnp.where(wall == 0, 1.0, -1.0) * (y[1] - y[3])
        passed = t > 0.0
        value = jnp.where(restarted, jnp.where(passed, z / jnp.where(passed, t, 1.0), speed), z)
        return jnp.where(inside, -value, value)

    return rising


def _opening(y: Any, heading: Any) -> Any:
    """Return the speed against the heading [m/s]."""
    return heading * (y[3] - y[1])


def _ending(rising: Callable[..., Any]) -> Callable[..., Any]:
    """Return the event function: in flight it rises through zero at a touch, or at a turn before.

    A flight that has just turned begins negative, whatever round-off says.
    """
    import jax.numpy as jnp

    def ending(t: Any, y: Any, args: Any, **_: Any) -> Any:
        _, inside, _, _, heading, turned, begun = args
        value = rising(t, y, args)
        flight = jnp.maximum(value, _opening(y, heading))
        flight = jnp.where(turned & (t <= begun), -1.0, flight)
        return jnp.where(inside, value, flight)

    return ending


def _events(walls: Walls, solver: Any, room: int, most: int) -> Callable[..., Any]:
    """Return the program that follows an orbit from event to event, with room for touches.

    It gives up after so many events.
    """
    import diffrax
    import jax
    import jax.numpy as jnp
    import optimistix

    finder = optimistix.Bisection(rtol=PRECISE, atol=PRECISE, flip=False)

    def heading(y: Any) -> Any:
        return jnp.where(y[1] >= y[3], 1.0, -1.0)

    def follow(p: Any, start: Any, rtol: Any, times: Any, watch: Any) -> Any:
        field, rising = _field(p, walls, implicit=False), _indicator(p)
        event = diffrax.Event(_ending(rising), finder, direction=True)

        def going(s: _Piece) -> Any:
            return (s.noted < len(times)) & s.well & (s.pieces < len(times) + most)

        def advance(s: _Piece) -> _Piece:
            end = times[s.noted] - s.since
            args = s.since, s.inside, s.wall, s.restarted, s.heading, s.turned, s.t
            found = _integrate(field, solver, rtol, t0=s.t, t1=end, y0=s.y, args=args, event=event)
            ended, y = found.event_mask, found.ys[0]
            now = s.since + found.ts[0]
            reached = rising(found.ts[0], y, args) >= _opening(y, s.heading)
            hit = ended & (s.inside | reached)
            turned = ended & ~hit
            touched = hit & ~s.inside
            nearer = jnp.where(_depth(p, 0, y) >= _depth(p, 1, y), 0, 1)
            well = found.result == diffrax.RESULTS.successful
            for result in (
                diffrax.RESULTS.event_occurred,
                diffrax.RESULTS.nonlinear_max_steps_reached,  # bisected down to round-off
            ):
                well = well | (ended & (found.result == result))
            onward = jnp.where(turned, -s.heading, s.heading)
            return _Piece(
                since=jnp.where(hit, now, s.since),
                t=jnp.where(hit, 0.0, jnp.where(turned, found.ts[0], end)),
                y=y,
                inside=s.inside ^ hit,
                wall=jnp.where(touched, nearer, s.wall),
                restarted=s.restarted | hit,
                heading=jnp.where(hit, heading(y), onward),
                turned=turned,
                noted=jnp.where(ended, s.noted, s.noted + 1),
                states=s.states.at[s.noted].set(y),  # after an event it is written again
                touches=s.touches.at[s.found].set(now),
                found=s.found + touched,
                steps=s.steps + jnp.where(s.inside, found.stats["num_accepted_steps"], 0),
                pieces=s.pieces + 1,
                well=well,
            )

        nothing = jnp.array(0)
        first = _Piece(
            since=jnp.array(0.0), t=jnp.array(0.0), y=start, inside=watch[0] > 0.0,
            wall=watch[1].astype(nothing.dtype), restarted=~jnp.isnan(watch[2]),
            heading=heading(start), turned=jnp.array(False), noted=nothing,
            states=jnp.zeros((len(times), 4)), touches=jnp.zeros(room + 1), found=nothing,
            steps=nothing, pieces=nothing, well=jnp.array(True),
        )  # fmt: skip
        last = jax.lax.while_loop(going, advance, first)
        done = last.well & (last.noted == len(times))  # the last piece may have failed
        return last.states, done, last.touches, last.found, last.steps

    return follow


def _padded(times: np.ndarray, period: float) -> np.ndarray:
    """Return times; where there are more than periods, with the last repeated up to a power of 2.

    Other numbers of samples then seldom need another compilation.
    """
    if len(times) * period <= times[-1] * 1.5:
        return times
    return np.pad(
        times, (0, max(LEAST, 2 ** math.ceil(math.log2(len(times)))) - len(times)), mode="edge"
    )


@cache
def _program(method: str, walls: Walls, room: int, most: int) -> Callable[..., Any]:
    """Return a program that JAX compiles when it first meets a number of times.

    With `room` for touches contacts are split; with none they are not.
    """
    import diffrax
    import jax

    solver = getattr(diffrax, method)()
    if room:
        return jax.jit(_events(walls, solver, room, most))
    return jax.jit(_plain(walls, solver, method.startswith("Kvaerno")))


def _prepare(system: System, start: np.ndarray, *, method: str, split: bool) -> Flow:
    p, state, watch = constants(system), begun(system, start), np.zeros(3)
    begin(p, state, watch)
    walls = Walls(math.isfinite(p[9]), math.isfinite(p[10]))
    splitting = split and any(walls)
    program = partial(_program, method, walls)

    def follow(rtol: float, wanted: np.ndarray, watched: bool) -> Track:
        times = _padded(wanted, system.period)
        room = 64 + 16 * math.ceil(times[-1] / system.period)
        with _double_precision():
            if splitting:
                found = program(room, most_events(system, times))(p, state, rtol, times, watch)
            else:
                found = program(0, 0)(p, state, rtol, np.concatenate([[0.0], times]))
            states, well, *rest = (np.asarray(item) for item in found)
        states = states[: len(wanted)]
        if not well:
            raise SolverFailure(
                f"{method} gave up: too many steps or events, or a state that is not finite"
            )
        if not rest:
            return Track(states)
        touches, count, steps = rest
        if count > room:
            raise SolverFailure(f"more than {room} touches")
        return Track(states, touches[:count], float(steps / count) if count else None)

    return flow_of(system, state, follow)


def _rival(method: str, order: float, split: bool) -> Rival:
    return Rival(
        name=f"diffrax {method}, events" if split else f"diffrax {method}",
        settings=TOLERANCES,
        setting="rtol",
        events=split,
        compiled=True,
        needs="diffrax",
        prepare=partial(_prepare, method=method, split=split),
        order=order,
    )


RIVALS = (
    _rival("Tsit5", 5.0, True),
    _rival("Tsit5", 5.0, False),
    _rival("Dopri8", 8.0, True),
    _rival("Dopri8", 8.0, False),
    _rival("Kvaerno5", 5.0, False),
)
