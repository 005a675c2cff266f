"""The parts of a scene in kernels: tuples of numbers, with None for an absent part.

The state in kernels is (x1, v1, r, s): displacement and velocity of the primary structure,
shortening of the damper's spring r = x1 - x2 + rest and its rate s = v1 - v2. The rest state is
zero, the spring pulls with k2 r, and a wall is a limit of r, so that the depth of a contact
z = r - gap has no cancellation between the two displacements.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..numerics.compiling import jit
from ..numerics.deciding import is_a
from .law import in_range


class Structure(NamedTuple):
    """Primary structure and forcing, per unit of mass m1 where that saves a division."""

    m1: float
    k1: float
    stiffness: float  # k1 / m1 [1/s^2]
    damping: float  # c1 / m1 [1/s]
    force: float  # P / m1 [m/s^2]
    omega: float  # [rad/s]
    load: Any  # constant force per mass [m/s^2] towards a near wall, or None
    # True if the force is that of a moving ground, from which x1 counts, and accelerates the damper
    # as well; None if it acts on the structure alone
    shaken: Any


class Damper(NamedTuple):
    """Damper mass on its spring and dashpot."""

    m2: float
    k2: float
    c2: float
    inv_m1: float  # 1 / m1
    inv_mu: float  # 1 / m1 + 1 / m2, mu the reduced mass [1/kg]
    share: float  # mu / m1 = m2 / (m1 + m2)
    rest: float  # x2 - x1 of the unstretched spring [m]


class Ground(Damper):
    """The immovable ground of walls that limit the structure itself.

    It is a damper of infinite mass without spring and dashpot. Then v2 = 0, r = x1 and s = v1, and
    the walls limit the structure's own motion.
    """


@jit
def finite(x):
    return abs(x) < math.inf


@jit
def near_constants(apart, cell):
    """Return the record with the near wall's constants; apart: None if both walls share them."""
    if apart is None:
        return cell
    return cell.near_contact


@jit
def allowed(parts, cell):
    """Return True if the parameters of a cell that its parts use are finite and in range.

    `model` checks them, but arrays of cells may come from elsewhere. By rk4 the force may be
    negative, and that of a ground whose acceleration is given.
    """
    near, far = parts.near, parts.far
    fine = 0.0 < cell.m1 < math.inf and 0.0 < cell.omega < math.inf
    fine = fine and 0.0 <= cell.k1 < math.inf and 0.0 <= cell.c1 < math.inf
    fine = fine and finite(cell.P)
    fine = fine and (parts.rk4 is not None or parts.ground is not None or cell.P >= 0.0)
    if parts.damper is not None and not is_a(parts.damper, Ground):
        fine = fine and 0.0 < cell.m2 < math.inf and finite(cell.rest)
        fine = fine and 0.0 <= cell.k2 < math.inf and 0.0 <= cell.c2 < math.inf
    if near is not None:
        fine = fine and in_range(near, near_constants(parts.apart, cell)) and finite(cell.near)
    if far is not None:
        fine = fine and in_range(far, cell) and finite(cell.far)
        if near is not None:
            fine = fine and cell.near + cell.far >= 0.0
    return fine


@jit
def structure_under(parts, cell):
    m1, constant = cell.m1, None if parts.load is None else cell.load
    return Structure(
        m1, cell.k1, cell.k1 / m1, cell.c1 / m1, cell.P / m1, cell.omega, constant,
        shaken_by(parts.ground, parts.damper),
    )  # fmt: skip


@jit
def shaken_by(ground, damper):
    """Return `Structure.shaken`: ground, or None without a damper that it accelerates as well."""
    if damper is None or is_a(damper, Ground):
        return None
    return ground


@jit
def with_load(ps, load):
    return Structure(
        ps.m1, ps.k1, ps.stiffness, ps.damping, ps.force, ps.omega, load, ps.shaken
    )  # fmt: skip


@jit
def damper_in(cell):
    inv_m1 = 1.0 / cell.m1
    inv_mu = inv_m1 + 1.0 / cell.m2
    return Damper(cell.m2, cell.k2, cell.c2, inv_m1, inv_mu, inv_m1 / inv_mu, cell.rest)


@jit
def damper_of(sort, cell):
    if sort is None:
        return None
    if is_a(sort, Ground):
        inv_m1 = 1.0 / cell.m1
        return Ground(0.0, 0.0, 0.0, inv_m1, inv_m1, 1.0, 0.0)
    return damper_in(cell)


@jit
def joined(damper):
    if damper is None or is_a(damper, Ground):
        return None
    return damper


@jit
def under(load, alone):
    """Return the acceleration `alone` plus that of the constant load, if any."""
    if load is None:
        return alone
    return alone + load


@jit
def unloaded(ps):
    return with_load(ps, None)


@jit
def greatest_push(load, force):
    if load is None:
        return force
    return force + abs(load)


@jit
def shared(ps, push):
    """Return the part of the acceleration by the force that acts on both bodies: 0 or all of it."""
    if ps.shaken is None:
        return 0.0
    return push


@jit
def moved_mass(ps, damper):
    if ps.shaken is None:
        return ps.m1
    return ps.m1 + damper.m2


@jit
def accelerations(ps, damper, x1, v1, r, s, drive, contact):
    """Return (dv1/dt, ds/dt), eq. (5) in the kernels' coordinates, of one state or of four.

    `drive` is cos(omega t); `contact` the force [N] of a wall on the damper towards +x2.
    """
    alone = under(ps.load, ps.force * drive - ps.stiffness * x1 - ps.damping * v1)
    if damper is None:
        return alone, 0.0
    pull = damper.k2 * r + damper.c2 * s + contact
    on_r = alone - shared(ps, ps.force * drive) - pull * damper.inv_mu
    return alone - pull * damper.inv_m1, on_r


@jit
def accelerations_at(side, ps, y, drive, contact):
    """Return (dv1/dt, d2z/dt2) at a wall of depth z, whose force [N] is `contact`.

    y: (x1, v1, place, speed), the last two of the damper towards the wall: sign r = gap + z and
    sign s = dz/dt. ps: the structure of the side, or without its load.
    """
    (x1, v1, place, speed), sign, damper = y, side.sign, side.damper
    alone = under(ps.load, ps.force * drive - ps.stiffness * x1 - ps.damping * v1)
    pull = damper.k2 * place + damper.c2 * speed + contact
    outward = sign * (alone - shared(ps, ps.force * drive))
    return alone - pull * (sign * damper.inv_m1), outward - pull * damper.inv_mu


@jit
def scale_of(ps, damper, x1, v1, r, s):
    """Return S = sqrt(2 E), E the mechanical energy [J] of the structure and the damper's spring.

    Damping takes energy and the power of the force is at most P |v1|, so |dS/dt| <= P / sqrt(m1).
    The certificates of `touch` rest on this bound of the motion ahead.
    """
    energy = ps.k1 * x1 * x1 + ps.m1 * v1 * v1
    if damper is not None:
        v2 = v1 - s
        energy += damper.k2 * r * r + damper.m2 * v2 * v2
    return math.sqrt(energy)


# --------------------------------------------------------------------------------------------------
# Tuples that kernels pass on: the parts of a cell, the side of a wall, buffers of records.
#
# An absent part and a buffer that is not wanted are None. The compiler leaves out their code if the
# tuple is an argument (`deciding`).


class Parts(NamedTuple):
    """The method, the parts of a scene, and how finely contacts and periods are divided."""

    rk4: Any  # True for fixed Runge-Kutta steps, None for exact flight
    damper: Any  # True with a damper, a `Ground` if walls limit the structure, otherwise None
    near: Any  # a wall of the near wall's law, of which only the type matters, or None
    far: Any  # the same of the far wall
    apart: Any  # True if the near wall's contact has constants of its own, otherwise None
    load: Any  # True if the structure is under a constant load, otherwise None
    ground: Any  # True if the force is that of a moving ground, from which x1 counts, or None
    arc: Any  # `arc.Arc` if a law has short impacts, otherwise None
    contact_steps: float  # least number of steps of a free impact that is stepped
    contact_tolerance: float  # relative error of a stepped contact; infinite: not checked
    period_steps: float  # Runge-Kutta steps of a forcing period; `rk4` alone uses it


class Prepared(NamedTuple):
    """One cell prepared for orbits: its parts, its grid, and its own scratch."""

    rk4: Any  # as in `Parts`
    ps: Any  # `scene.Structure`
    damper: Any  # `scene.Damper`, `scene.Ground` or None
    near: Any  # a wall with the numbers of the cell, or None
    far: Any
    arc: Any  # `arc.Arc` with its own scratch, or None
    grid: Any  # `flight.Grid`, or `fixed_step.FixedGrid` of `rk4`
    contact_steps: Any  # `contact.Steps`
    scratch: Any  # (`law.SCRATCH`,) or None without a wall
    held_near: Any  # the motion on the near wall, if its law has one (`cells.held_at`), or None
    held_far: Any  # the same of the far wall


class Side(NamedTuple):
    """A wall and the constants of a contact with it.

    Its depth is z = sign r - gap. In a contact z, its speed s = dz/dt and the force count towards
    the wall; the structure's motion, the phase of the forcing and a load do not depend on the side.
    """

    rk4: Any  # as in `Parts`
    ps: Any  # `scene.Structure`
    damper: Any  # `scene.Damper` or `Ground`
    wall: Any
    sign: float  # 1 at a near wall, -1 at a far one
    arc: Any  # `arc.Arc` if its law has short impacts, otherwise None
    motion: Any  # the motion on the wall, as in `Prepared`
    steps: Any  # `contact.Steps`
    rate: float  # the bound of `flight.rate_of` [1/s]
    k: Any  # scratch, a bare row (`law.SCRATCH`)


@jit
def side_with(side, ps, damper, wall, steps):
    return Side(
        side.rk4, ps, damper, wall, side.sign, side.arc, side.motion, steps, side.rate, side.k
    )


class Flight(NamedTuple):
    """The constants of a flight."""

    rk4: Any  # this and the next as in `Prepared`
    ps: Any
    damper: Any
    near: Any  # the walls that it may touch, or None
    far: Any
    grid: Any


class Watch(NamedTuple):
    """The buffers of a motion while it is followed, each may be None (`OrbitBuffers`)."""

    limit_log: Any
    energy: Any
    clearance: Any  # of flights
    impacts: Any  # `observe.Impacts`, of contacts
    tangent: Any  # four variations, or `driven.Driven`
    tally: Any  # `response_sums.Tally`


class Step(NamedTuple):
    """A step of a contact from row OLD of the scratch."""

    phase: tuple[float, float]  # the instant (`drive`) at row OLD
    landing: Any  # True if it ends at the release
    h: float  # of theta


class StepPiece(NamedTuple):
    """A step of a contact as a piece of motion, like a grid with an expanded cell."""

    table: Any  # the scratch of the contact, in which COEF and POWERS are filled
    sign: float  # of the wall, towards which the series of depth and force count; COEF has r


class Span(NamedTuple):
    """Forcing periods `first`, `first` + 1, ...; those before are the transient."""

    first: Any  # number of the first period; times count from period 0
    periods: int
    stops: int  # equidistant states of each period that the section takes, the last at its end


class OrbitBuffers(NamedTuple):
    """The records of an orbit."""

    limit_log: Any = None  # (6,) a limit of r and its violations, see `observe`
    section: Any = None  # (stops periods or fewer, components) states in the user's coordinates
    by_period: Any = None  # (periods, 2) impacts of each period at the near and the far wall
    impacts: Any = None  # `observe.Impacts` or `Touches`, one by one
    energy: Any = None  # (2,) largest E1 and E2 so far [J]
    clearance: Any = None  # (1,) smallest near miss so far [m]
    slowest: Any = None  # (1,) smallest approach speed of an impact so far [m/s]
    tally: Any = None  # `response_sums.Tally`
    sums: Any = None  # (stops periods, 5) integrals of a response (`response.note_sums`)


class CellBuffers(NamedTuple):
    """The records of a cell: of its transient, of the periods after it, or of both."""

    early: Any = None  # (periods, components) section of the transient's last periods
    section: Any = None  # as in `OrbitBuffers`, after the transient
    by_period: Any = None  # after the transient
    impacts: Any = None  # after the transient
    energy: Any = None  # (2,) [J] after the transient
    peak: Any = None  # (2,) largest energies [J], the transient included
    clearance: Any = None  # (1,) [m] after the transient
    violation: Any = None  # (3,) first time [s], depth [m], number of passages of the limit
    response: Any = None  # (`codes.RESPONSE_COLUMNS`,) after the transient
    sums: Any = None  # as in `OrbitBuffers`, with a response


class LaneBuffers(NamedTuple):
    """The records of all lanes: arrays (chains, links, ...)."""

    section: Any = None  # (rows, components): periods stops, before them rows of the transient
    counts: Any = None  # (3,) impacts by wall after the transient, periods with two of them
    cycle: Any = None  # (3,) n of nT, k at the near and at the far wall, by recurrence
    energy: Any = None  # (2,), this and the next as in `CellBuffers`
    peak: Any = None  # (2,)
    clearance: Any = None  # (1,)
    violation: Any = None  # (3,)
    ends: Any = None  # (2, SIZE) the states at the beginning and the end
    response: Any = None  # (`codes.RESPONSE_COLUMNS`,) after the transient
    touches: Any = None  # (room, `codes.TOUCH_COLUMNS`) of impacts after the transient


class Finished(NamedTuple):
    """The records of finished lanes that a verdict needs, as in `LaneBuffers`.

    No other ones, so that a verdict is compiled once for all choices of records.
    """

    ends: Any
    section: Any  # of the transient's last periods too
    first: int  # periods before those of the section
