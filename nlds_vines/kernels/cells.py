"""One cell from its parameters to its outputs: the parts it has, then its orbit, then a verdict."""

from __future__ import annotations

import numpy as np

from .compiling import chosen, jit
from .fixed_step import fixed_grid_of
from .flight import cells_of, grid_of
from .impact import Arc
from .observe import EXCESS, FIRST, LEVEL, NUMBER, note_energy, note_violation
from .orbit import DIVERGED, OK, begin, linear_orbit, orbit, sane
from .ride import ride_of
from .runge_kutta import SCRATCH
from .scene import allowed, damper_of, far_wall_of, finite, near_wall_of, structure_of
from .verdict import judge

BAD_PARAMETERS = 4
TOO_STIFF = 5  # more cells in a period than a lane may take (`flight.MOST_CELLS`)
STABLE = 2.5  # a fixed step in units of 1/rate: beyond 2.8, errors of order four grow
STEPS_RATIO = 4.0  # fixed steps of a period to those of a free impact


@jit
def own_arc(arc):
    """Return the arc with scratch rows of this lane's own."""
    return Arc(arc.n, arc.length, arc.settled, arc.spent, arc.cover, arc.table.copy())


@jit
def free_cell(
    arc, classical, ps, damper, near, far, limit, grid, resolution, state,
    early, section, beats, rows, energy, peak, clearance, violation,
    transient, first, periods, stops,
):  # fmt: skip
    """Run a scene without walls (arguments as `run_cell`)."""
    start_energy(ps, damper, peak, state)
    noted = count_of(early)
    status = linear_orbit(
        classical, ps, damper, none_of(early), peak, None, None, grid, 1, state, transient - noted
    )
    if status == OK:
        status = linear_orbit(classical, ps, damper, early, peak, None, None, grid, 1, state, noted)
    if status == OK:
        start_energy(ps, damper, energy, state)
        status = linear_orbit(
            classical, ps, damper, section, either(energy, peak), None, None,
            grid, stops, state, periods,
        )  # fmt: skip
        raise_peak(energy, peak)
    return status


@jit
def walled_cell(
    arc, classical, ps, damper, near, far, limit, grid, resolution, state,
    early, section, beats, rows, energy, peak, clearance, violation,
    transient, first, periods, stops,
):  # fmt: skip
    """Run a scene with walls (arguments as `run_cell`)."""
    own, k = own_arc(arc), np.zeros(SCRATCH)
    steps = steps_for(classical, resolution)
    watch = watch_of(violation, limit)
    begin(near, far, state)
    begin_watch(watch, state)
    start_energy(ps, damper, peak, state)
    noted = count_of(early)
    status = orbit(
        classical, ps, damper, near, far, own, watch, none_of(early), None, None, peak, None,
        None, None, grid, 1, steps, state, k, first - transient, transient - noted,
    )  # fmt: skip
    if status == OK:
        status = orbit(
            classical, ps, damper, near, far, own, watch, early, None, None, peak, None,
            None, None, grid, 1, steps, state, k, first - noted, noted,
        )  # fmt: skip
    if status == OK:
        start_energy(ps, damper, energy, state)
        status = orbit(
            classical, ps, damper, near, far, own, watch, section, beats, rows,
            either(energy, peak), clearance, None, None,
            grid, stops, steps, state, k, first, periods,
        )  # fmt: skip
        raise_peak(energy, peak)
        report_violation(violation, watch)
    return status


@jit
def count_of(early):
    """Return how many periods of the transient are noted."""
    if early is None:
        return 0
    return len(early)


@chosen
def none_of(early):
    """Return room for no section, of the same type."""
    if early is None:
        return lambda early: None
    return lambda early: early[:0]


@chosen
def cell_orbit(
    arc, classical, ps, damper, near, far, limit, grid, resolution, state,
    early, section, beats, rows, energy, peak, clearance, violation,
    transient, first, periods, stops,
):  # fmt: skip
    """Run a scene with walls or one without: neither knows of the other."""
    return free_cell if arc is None else walled_cell


@jit
def run_cell(
    classical,
    has_damper,
    has_near,
    has_far,
    arc,
    resolution,
    cell,
    state,
    early,
    section,
    beats,
    rows,
    energy,
    peak,
    clearance,
    violation,
    transient,
    first,
    periods,
    stops,
):
    """Run one orbit: settle unobserved, then note what has a buffer. Returns a status.

    `classical` None is the exact method, True fixed steps; `has_...` and `arc` are None for parts
    the scene has not. `resolution`: Runge-Kutta steps, of a period when `classical`, otherwise of
    a contact that has to be stepped. `peak` (2,) takes the largest energies of transient and
    sampled periods together, `early` (periods, components) the section of the transient's last
    periods; `violation` (3,) time of the first, depth and number of the passages
    of the limit that the scene must keep. `first` numbers the first sampled period, for times;
    `section` takes `stops` equidistant states of each period.
    """
    fine = allowed(classical, has_damper, has_near, has_far, cell)
    if not fine or beyond_sense(violation, cell.limit):
        return BAD_PARAMETERS
    if not sane(state[0], state[1], state[2], state[3]):
        return DIVERGED
    ps = structure_of(cell)
    damper = damper_of(has_damper, cell)
    n = cells_of(ps, damper)
    if n < 0:
        return TOO_STIFF
    grid = grid_for(classical, ps, damper, n, resolution, stops)
    if classical is not None and not grid.h * grid.rate <= STABLE:
        return TOO_STIFF
    status = cell_orbit(
        arc, classical, ps, damper, near_wall_of(has_near, cell), far_wall_of(has_far, cell),
        cell.limit, grid, resolution, state, early, section, beats, rows, energy, peak,
        clearance, violation, transient, first, periods, stops,
    )  # fmt: skip
    if status == OK and (overflown(energy) or overflown(peak)):
        return DIVERGED
    return status


@jit
def beyond_sense(violation, limit):
    """Tell whether a scene has a limit to keep and that is no number to keep to."""
    if violation is None:
        return False
    return not finite(limit)


@jit
def overflown(energy):
    """Tell whether a largest energy that was asked for is beyond all numbers."""
    if energy is None:
        return False
    return not (finite(energy[0]) and finite(energy[1]))


@jit
def divisible(n, stops):
    """Return the least multiple of `stops` that is n or more."""
    return stops * ((n + stops - 1) // stops)


@chosen
def watch_of(violation, limit):
    """Return the rows of `observe.LEVEL` for a scene with a limit to keep, or None."""
    if violation is None:
        return lambda violation, limit: None

    def watch(violation, limit):
        rows = np.zeros(6)
        rows[LEVEL], rows[FIRST] = limit, np.nan
        return rows

    return watch


@jit
def begin_watch(watch, state):
    """Count a start beyond the limit, where a sweep may carry a state, as of the first instant."""
    if watch is not None and state[2] > watch[LEVEL]:
        note_violation(watch, 0.0)
        watch[EXCESS] = state[2] - watch[LEVEL]


@jit
def report_violation(violation, watch):
    """Fill the violations (3,) of one lane: time of the first [s], greatest depth [m], number."""
    if violation is not None:
        violation[0], violation[1], violation[2] = watch[FIRST], watch[EXCESS], watch[NUMBER]


@chosen
def either(energy, peak):
    """Return where energies of the sampled periods are noted."""
    if energy is None:
        return lambda energy, peak: peak
    return lambda energy, peak: energy


@jit
def raise_peak(energy, peak):
    """Let the largest energies of the whole run include those of the sampled periods."""
    if energy is not None and peak is not None:
        peak[0], peak[1] = max(peak[0], energy[0]), max(peak[1], energy[1])


@chosen
def grid_for(classical, ps, damper, n, resolution, stops):
    """Return the grid of the method: exact cells, or fixed steps, a multiple of `stops`."""
    if classical is None:
        return lambda classical, ps, damper, n, resolution, stops: grid_of(
            ps, damper, divisible(n, stops)
        )
    return lambda classical, ps, damper, n, resolution, stops: fixed_grid_of(
        ps, damper, divisible(int(resolution), stops)
    )


@jit
def steps_for(classical, resolution):
    """Return the Runge-Kutta steps of a free impact."""
    if classical is None:
        return resolution
    return resolution / STEPS_RATIO


@jit
def start_energy(ps, damper, energy, state):
    """Let the largest energies begin with the state at which noting begins."""
    if energy is not None:
        energy[0], energy[1] = 0.0, 0.0
        note_energy(ps, damper, energy, state[0], state[1], state[2], state[3])


@jit
def linear_ride(arc, classical, ps, damper, near, far, jets, grid, resolution):
    """Return the `Ride` of a scene without walls."""
    return ride_of(classical, ps, damper, None, None, None, jets, grid, 1.0)


@jit
def walled_ride(arc, classical, ps, damper, near, far, jets, grid, resolution):
    """Return the `Ride` of a scene with walls."""
    steps = steps_for(classical, resolution)
    return ride_of(classical, ps, damper, near, far, own_arc(arc), jets, grid, steps)


@chosen
def ride_for(arc, classical, ps, damper, near, far, jets, grid, resolution):
    """Return the `Ride` of a scene with walls or without."""
    return linear_ride if arc is None else walled_ride


@jit
def judge_cell(
    classical, has_damper, has_near, has_far, arc, resolution, cell,
    origin, state, section, hint, stages, evidence,
):  # fmt: skip
    """Say what the orbit of one cell is (`verdict.judge`; parts as `run_cell`)."""
    ps = structure_of(cell)
    damper = damper_of(has_damper, cell)
    n = cells_of(ps, damper)
    ride = ride_for(
        arc, classical, ps, damper, near_wall_of(has_near, cell), far_wall_of(has_far, cell),
        grid_of(ps, damper, n), grid_for(classical, ps, damper, n, resolution, 1), resolution,
    )  # fmt: skip
    return judge(ride, origin, state, section, hint, stages, evidence)
