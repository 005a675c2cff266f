"""The only parallel loop: one lane per chain of cells, each writing its own output rows.

A chain is a single cell, or, where a scan follows an attractor, the cells of an axis in the order
of the sweep, each starting from the last state of the one before. Nothing is shared between lanes,
so that results do not depend on the number of threads or on how a scan is cut into blocks.
"""

from __future__ import annotations

import numba
import numpy as np

from .._jit import chosen, jit
from .fixed_step import fixed_grid_of
from .flight import cells_of, grid_of
from .impact import Arc
from .observe import EXCESS, FIRST, LEVEL, NUMBER, note_energy
from .orbit import OK, SIZE, begin, linear_orbit, orbit
from .parts import damper_of, far_wall_of, near_wall_of, structure_of
from .recurrence import TOLERANCE, impacts_of, period_of
from .ride import ride_of
from .runge_kutta import SCRATCH
from .verdict import judge

TOO_STIFF = 5  # more cells in a period than a lane may take (`flight.MOST_CELLS`)
STABLE = 2.5  # a fixed step in units of 1/rate: beyond 2.8, errors of order four grow
STEPS_RATIO = 4.0  # fixed steps of a period to those of a free impact


@jit
def own_arc(arc):
    """Return the arc with scratch rows of this lane's own."""
    return Arc(arc.n, arc.length, arc.settled, arc.cover, arc.table.copy())


@jit
def free_cell(
    arc, classical, ps, damper, near, far, limit, grid, resolution, state,
    early, section, beats, rows, energy, peak, clearance, violation,
    transient, first, periods, stops,
):  # fmt: skip
    """Run a scene without walls (arguments as `run_cell`)."""
    start_energy(ps, damper, peak, state)
    status = linear_orbit(classical, ps, damper, None, peak, None, None, grid, 1, state, transient)
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
    start_energy(ps, damper, peak, state)
    status = orbit(
        classical, ps, damper, near, far, own, watch, early, None, None, peak, None, None, None,
        grid, 1, steps, state, k, first - transient, transient,
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
    sampled periods together, `early` (transient, components) the section of the transient;
    `violation` (3,) time of the first, depth and number of the passages
    of the limit that the scene must keep. `first` numbers the first sampled period, for times;
    `section` takes `stops` equidistant states of each period.
    """
    ps = structure_of(cell)
    damper = damper_of(has_damper, cell)
    n = cells_of(ps, damper)
    if n < 0:
        return TOO_STIFF
    grid = grid_for(classical, ps, damper, n, resolution, stops)
    if classical is not None and grid.h * grid.rate > STABLE:
        return TOO_STIFF
    return cell_orbit(
        arc, classical, ps, damper, near_wall_of(has_near, cell), far_wall_of(has_far, cell),
        cell.limit, grid, resolution, state, early, section, beats, rows, energy, peak,
        clearance, violation, transient, first, periods, stops,
    )  # fmt: skip


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


@chosen
def record_rows(evidence, damper, count):
    """Return room for the section of a lane's whole course and of what a verdict adds, or None."""
    if evidence is None:
        return lambda evidence, damper, count: None
    if damper is None:
        return lambda evidence, damper, count: np.empty((count, 2))
    return lambda evidence, damper, count: np.empty((count, 4))


@chosen
def early_rows(record, transient):
    """Return the rows for the section of the transient, or None where nobody asks."""
    if record is None:
        return lambda record, transient: None
    return lambda record, transient: record[:transient]


@chosen
def section_rows(section, cycle, record, damper, chain, link, transient, periods):
    """Return the rows for the section points of one lane: its output, scratch, or None."""

    def recorded(section, cycle, record, damper, chain, link, transient, periods):
        return record[transient : transient + periods]

    def put_out(section, cycle, record, damper, chain, link, transient, periods):
        return section[chain, link]

    def absent(section, cycle, record, damper, chain, link, transient, periods):
        return None

    def two(section, cycle, record, damper, chain, link, transient, periods):
        return np.empty((periods, 2))

    def four(section, cycle, record, damper, chain, link, transient, periods):
        return np.empty((periods, 4))

    if record is not None:
        return recorded
    if section is not None:
        return put_out
    if cycle is None:
        return absent
    return two if damper is None else four


@jit
def put_section(section, record, rows, chain, link):
    """Copy the sampled section of one lane to its output, if it stands elsewhere."""
    if section is not None and record is not None:
        section[chain, link] = rows


@chosen
def beat_rows(counts, cycle, arc, periods):
    """Return scratch for the impacts of each period and wall, or None where nobody asks."""
    if arc is None or (counts is None and cycle is None):
        return lambda counts, cycle, arc, periods: None
    return lambda counts, cycle, arc, periods: np.zeros((periods, 2), np.int64)


@chosen
def lane_of(values, chain, link):
    """Return the row of an optional output that belongs to one lane."""
    if values is None:
        return lambda values, chain, link: None
    return lambda values, chain, link: values[chain, link]


@jit
def summarise(section, beats, counts, cycle):
    """Fill the impact counts (2,) by wall and the cycle (n, k near, k far) of one lane."""
    if counts is not None:
        for wall in range(2):
            counts[wall] = 0
            for p in range(len(beats)):
                counts[wall] += beats[p, wall]
    if cycle is not None:
        cycle[0], cycle[1], cycle[2] = period_of(section, TOLERANCE), 0, 0
        if beats is not None:
            for wall in range(2):
                cycle[1 + wall] = impacts_of(beats, wall, cycle[0])


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
    origin, state, record, length, hint, stages, evidence,
):  # fmt: skip
    """Say what the orbit of one cell is (`verdict.judge`; parts as `run_cell`)."""
    ps = structure_of(cell)
    damper = damper_of(has_damper, cell)
    n = cells_of(ps, damper)
    ride = ride_for(
        arc, classical, ps, damper, near_wall_of(has_near, cell), far_wall_of(has_far, cell),
        grid_of(ps, damper, n), grid_for(classical, ps, damper, n, resolution, 1), resolution,
    )  # fmt: skip
    return judge(ride, origin, state, record, length, hint, stages, evidence)


@chosen
def judge_lane(
    evidence, record, classical, has_damper, has_near, has_far, arc, resolution, cell,
    origin, state, cycle, stages, chain, link, length,
):  # fmt: skip
    """Fill the evidence of one lane, if anyone asks for it; returns a status."""

    def judged(
        evidence, record, classical, has_damper, has_near, has_far, arc, resolution, cell,
        origin, state, cycle, stages, chain, link, length,
    ):  # fmt: skip
        return judge_cell(
            classical, has_damper, has_near, has_far, arc, resolution, cell,
            origin, state, record, length, cycle[chain, link, 0], stages, evidence[chain, link],
        )  # fmt: skip

    def unasked(
        evidence, record, classical, has_damper, has_near, has_far, arc, resolution, cell,
        origin, state, cycle, stages, chain, link, length,
    ):  # fmt: skip
        return OK

    return unasked if evidence is None else judged


@jit(parallel=True)
def run_lanes(
    classical,
    has_damper,
    has_near,
    has_far,
    arc,
    resolution,
    cells,
    starts,
    transient,
    periods,
    section,
    counts,
    cycle,
    energy,
    peak,
    clearance,
    violation,
    evidence,
    stages,
    status,
):
    """Run all chains of a block of cells (chains, links), each from its start (chains, 4).

    Outputs have the shape (chains, links, ...) or are None: `section` (periods, components),
    `counts` (2,) impacts by wall, `cycle` (3,) n and k at either wall, `energy` and `peak` (2,)
    [J], `clearance` (1,) [m], `violation` (3,) [s, m, 1], `evidence` (`verdict.COLUMNS`,), which
    needs `cycle` and may take the further periods `stages`; `status` always. A lane that fails
    keeps its fill values, starts the next link of its chain from rest, and touches nothing of its
    neighbours.
    """
    chains, links = cells.shape
    for chain in numba.prange(chains):
        state = np.zeros(SIZE)
        state[:4] = starts[chain]
        for link in range(links):
            record = record_rows(evidence, has_damper, transient + periods + stages.sum())
            rows = section_rows(section, cycle, record, has_damper, chain, link, transient, periods)
            beats = beat_rows(counts, cycle, arc, periods)
            cell = cells[chain, link]
            if link > 0:  # the displacement is carried over, wherever the new rest may be
                state[2] += cell.rest - cells[chain, link - 1].rest
            origin = state.copy()
            code = run_cell(
                classical, has_damper, has_near, has_far, arc, resolution, cell, state,
                early_rows(record, transient), rows,
                beats, None, lane_of(energy, chain, link), lane_of(peak, chain, link),
                lane_of(clearance, chain, link), lane_of(violation, chain, link),
                transient, transient, periods, 1,
            )  # fmt: skip
            if code == OK:
                summarise(rows, beats, lane_of(counts, chain, link), lane_of(cycle, chain, link))
                put_section(section, record, rows, chain, link)
                code = judge_lane(
                    evidence, record, classical, has_damper, has_near, has_far, arc, resolution,
                    cell, origin, state, cycle, stages, chain, link, transient + periods,
                )  # fmt: skip
            status[chain, link] = code
            if code != OK:
                state[:] = 0.0
