"""What travels together through the kernels: the parts of a cell, a wall's side, what notes.

A part that is absent and a buffer that is not wanted are None. The compiler knows it of an argument
and of its fields, and leaves the code out (`deciding`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..numerics.compiling import jit


class Parts(NamedTuple):
    """The method, the parts of a scene, and how finely contacts and periods are divided."""

    rk4: Any  # True for fixed Runge-Kutta steps, None for exact flight
    damper: Any  # True where the scene has a damper, a `Ground` where walls limit the structure,
    #              otherwise None
    near: Any  # a wall of its law (numbers do not matter) where the scene has a near one, or None
    far: Any  # the same of the far wall
    apart: Any  # True where the near wall's contact has constants of its own, otherwise None
    load: Any  # True where the structure is under a constant load, otherwise None
    arc: Any  # `arc_table.Arc` where a law has short impacts, otherwise None
    contact_steps: float  # least steps of a free impact that is stepped
    contact_tolerance: float  # relative error of a contact that is stepped; infinite: not checked
    period_steps: float  # Runge-Kutta steps of a forcing period; `rk4` alone uses it


class Prepared(NamedTuple):
    """One cell made ready to be run: its numbers part by part, its grid, and scratch of its own."""

    rk4: Any  # as in `Parts`
    ps: Any  # `scene.Structure`
    damper: Any  # `scene.Damper`, `scene.Ground` or None
    near: Any  # a wall by the numbers of the cell, or None
    far: Any  # the same
    arc: Any  # `arc_table.Arc` with scratch of its own, or None
    grid: Any  # `flight.Grid`, or `fixed_step.FixedGrid` of `rk4`
    contact_steps: Any  # `contact.Steps`
    scratch: Any  # (`contact_series.SCRATCH`,) or None without a wall
    held_near: Any  # the motion on the near wall, if its law has one (`cells.held_at`), or None
    held_far: Any  # the same of the far wall


class Side(NamedTuple):
    """A wall and all that a contact with it needs, which stays from touch to release."""

    rk4: Any  # as in `Parts`
    ps: Any  # `scene.Structure`
    damper: Any  # `scene.Damper` or `Ground`
    wall: Any
    sign: float  # 1 at a near wall; -1 at a far one, which sees state and phase mirrored
    arc: Any  # `arc_table.Arc` where its law has short impacts, otherwise None
    held: Any  # the motion on the wall, as in `Prepared`
    steps: Any  # `contact.Steps`
    rate: float  # the bound of `bounds.rate_of` [1/s]
    k: Any  # scratch, a bare row (`contact_series.SCRATCH`)


@jit
def side_with(side, ps, damper, wall, steps):
    """Return a side of which these are others."""
    return Side(
        side.rk4, ps, damper, wall, side.sign, side.arc, side.held, steps, side.rate, side.k
    )


class Flight(NamedTuple):
    """All that a flight needs beside its state."""

    rk4: Any  # this and the next as in `Prepared`
    ps: Any
    damper: Any
    near: Any  # the walls that it may touch, or None
    far: Any
    grid: Any


class Watch(NamedTuple):
    """What notes a motion while it is followed, each a buffer or None (`OrbitBuffers`)."""

    limit_log: Any
    energy: Any
    clearance: Any  # of flights
    impacts: Any  # `observe.Impacts`, of contacts
    tangent: Any  # four variations, or `driven.Driven`
    tally: Any  # `response_sums.Tally`


class Step(NamedTuple):
    """A step of a contact from row Y of the scratch."""

    phase: tuple[float, float]  # (cos, sin) of the forcing's at row Y
    landing: Any  # whether it ends at the release
    h: float  # of theta


class StepPiece(NamedTuple):
    """A step of a contact as a piece of motion, as a grid with an expanded cell is one."""

    table: Any  # the scratch of the contact, in which COEF and POWERS are filled
    sign: float  # of the wall: what is in the series is mirrored, what is in COEF is not


class Span(NamedTuple):
    """Forcing periods: `first`, `first` + 1, ...; a cell passes over those before as transient."""

    first: int  # number of the first period; times count from period 0
    periods: int
    stops: int  # equidistant states of each period that the section takes, the last at its end


class OrbitBuffers(NamedTuple):
    """What an orbit notes."""

    limit_log: Any = None  # (6,) a limit of r and how it is kept, see `observe`
    section: Any = None  # (stops periods or fewer, components) states in the user's coordinates
    by_period: Any = None  # (periods, 2) impacts of each period at the near and the far wall
    impacts: Any = None  # `observe.Impacts` or `Touches`, one by one
    energy: Any = None  # (2,) largest E1 and E2 so far [J]
    clearance: Any = None  # (1,) smallest near miss so far [m]
    slowest: Any = None  # (1,) smallest approach speed of an impact so far [m/s]
    tally: Any = None  # `response_sums.Tally`
    sums: Any = None  # (stops periods, 5) energies come in and gone (`response.note_sums`)


class CellBuffers(NamedTuple):
    """What a cell notes: of its transient, of the periods after it, or of both."""

    early: Any = None  # (periods, components) section of the transient's last periods
    section: Any = None  # as in `OrbitBuffers`, after the transient
    by_period: Any = None  # after the transient
    impacts: Any = None  # after the transient
    energy: Any = None  # (2,) [J] after the transient
    peak: Any = None  # (2,) largest energies [J], the transient included
    clearance: Any = None  # (1,) [m] after the transient
    violation: Any = None  # (3,) first time [s], depth [m], number of passages of the limit
    response: Any = None  # (`codes.RESPONSE_COLUMNS`,) after the transient
    foot: Any = None  # True where a response is one of a structure whose foot moves
    sums: Any = None  # as in `OrbitBuffers`, with a response
    ground: Any = None  # True where a response is one of positions counted from a moving ground


class LaneBuffers(NamedTuple):
    """What all lanes note: arrays (chains, links, ...)."""

    section: Any = (
        None  # (periods stops, components); more rows hold the transient's last periods too
    )
    counts: Any = None  # (3,) impacts by wall after the transient, periods with two of them
    cycle: Any = None  # (3,) n of nT, k at the near and at the far wall, by recurrence
    energy: Any = None  # (2,), this and the next as in `CellBuffers`
    peak: Any = None  # (2,)
    clearance: Any = None  # (1,)
    violation: Any = None  # (3,)
    ends: Any = None  # (2, SIZE) the states at the beginning and the end
    response: Any = None  # (`codes.RESPONSE_COLUMNS`,), this and the next as in `CellBuffers`
    foot: Any = None  # not an array
    touches: Any = None  # (room, `codes.TOUCH_COLUMNS`) of impacts after the transient
    ground: Any = None  # not an array, as in `CellBuffers`


class Finished(NamedTuple):
    """What lanes that have run hand on to a verdict, as in `LaneBuffers`.

    No other buffer, so that a verdict is compiled once, whatever else is recorded.
    """

    ends: Any
    section: Any  # of the transient's last periods too
    first: int  # periods before those of the section
