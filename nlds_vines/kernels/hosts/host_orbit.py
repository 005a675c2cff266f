"""The time loop of a host's orbit, and the flow from section to section.

A state consists of y, then the q of each wall, then the place of each wall among those in contact,
counted from 1; it is 0 of a wall that is not in contact, and negative if the force is switched off.
So an orbit has the same bits in one run and in several.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..motion.flight import COEF, TERMS
from ..numerics.compiling import jit
from ..numerics.elementary import hypotenuse, log
from ..numerics.fours import bare, from_place
from ..numerics.matrices import IM, RE, eigenvalues
from ..orbit.orbit import HUGE, MOST_TOUCHES
from ..orbit.variations import LEFT_OVER, TOGETHER, matrix_of, no_section
from ..scene.codes import DIVERGED, OK, STEP_BUDGET, TOO_STIFF
from ..scene.scene import Span
from .body import along
from .grid import LONG_TERMS, host_grid
from .host_contact import (
    NOT_SHORT,
    OF_DRIVE,
    OF_TOTAL,
    Impacts,
    PreparedHost,
    begin,
    end_state,
    expand,
    put_on,
    step_contacts,
    strike,
    take_at_once,
    width_of,
)
from .host_energies import note_energies
from .host_flight import (
    FLOWN,
    LOST_TOUCH,
    Scratch,
    advance,
    carry,
    drive_of,
    expand_at_touch,
    fly,
    note_misses,
    place_at,
    put_columns,
)
from .host_impact import short_impacts
from .host_repetition import (
    CYCLE,
    begin_repetition,
    next_period,
    put_totals,
    repeat_impacts,
    repeat_integrals,
    repetition_for,
    sum_up,
)
from .host_space import HostSpace, distance
from .host_variations import varied_of, vary_flight, vary_on_hold
from .host_watch import add_squares, bound_rates, host_watch, is_quiet, note_instant, note_series
from .spring_cells import (
    ACCEPTED,
    EASY,
    LEVELS,
    PATIENCE,
    STEPPED,
    end_cell,
    is_cell_clear,
    solve_cell,
    spring_cells,
    vary_cell,
)
from .walls import AT_REST, IS_HERTZ, IS_RIGID, hold, press_now, start_of

MEASURED = 4  # exponents of an orbit without a period, as many as those of one damper's kinds
# factor by which returns grow if an orbit departs, and periods for which it is looked for
DEPARTED, LOOKED_ON = 4.0, 256


class HostFlow(NamedTuple):
    """The map of a host from a section to the next, which `advance_host` applies."""

    host: PreparedHost
    space: HostSpace
    period: float  # [s]
    trace: float  # tr A [1/s]: the sum of all Lyapunov exponents, if contacts dissipate nothing
    by_period: np.ndarray  # (TOGETHER, walls) impacts of the last periods
    clearance: np.ndarray  # (2,) smallest near miss so far [m], and its wall
    slowest: np.ndarray  # (1,) smallest approach speed of an impact so far [m/s]
    shrunk: np.ndarray  # (1,) logarithm of the factor by which contacts have changed volumes so far


# ---- preparation ---------------------------------------------------------------------------------


@jit
def no_impacts(walls):
    """Return `Impacts` that only count."""
    counts, hardest = np.zeros(walls.number, np.int64), np.zeros(walls.number)
    return Impacts(
        np.zeros(0), np.zeros(1, np.int64), 0, counts, np.full(1, np.inf), hardest, False,
        np.zeros(1),
    )  # fmt: skip


@jit
def host_flow(body, walls, contacts, impacts, stops):
    """Return the `HostFlow` of a host, and a status; stops: equidistant states of a period."""
    grid, is_fine = host_grid(body, stops)
    size, links = body.size, body.links
    scratch = Scratch(
        np.zeros(2 * size), np.zeros(2 * size), np.zeros(2 * size), np.zeros(grid.columns),
        np.zeros(grid.columns), np.zeros(3 * size + body.drives), np.zeros(body.drives),
        np.zeros(8 * links), np.zeros(COEF + TERMS), np.zeros(LONG_TERMS + 8),
    )  # fmt: skip
    short = short_impacts(body, grid, walls, contacts.arc)
    cells = spring_cells(body, grid, walls, stops)
    host = PreparedHost(body, grid, walls, contacts, impacts, scratch, short, cells)
    scales, masses, trace = np.zeros(size), np.ones(size), 0.0
    for i in range(size):
        scales[i] = max(grid.scales[i], body.omega)
    for i in range(body.modes, size):
        at = (i - body.modes) * size + i
        masses[i] = body.rows[at] / body.answers[at]
    for i in range(body.modes):
        trace -= body.damping[i]
    for link in range(links):
        for i in range(link * size, link * size + size):
            trace -= body.dashpots[link] * body.rows[i] * body.answers[i]
    space = HostSpace(2 * size, size, body.modes, body.rows, scales, masses, 0.0)
    flow = HostFlow(
        host, space, body.period, trace,
        np.zeros((TOGETHER, walls.number), np.int64), np.full(2, np.inf), impacts.slowest,
        np.zeros(1),
    )  # fmt: skip
    return flow, OK if is_fine else TOO_STIFF


# ---- states --------------------------------------------------------------------------------------


@jit
def new_host_state(flow):
    return np.zeros(flow.space.size + 2 * flow.host.walls.number)


@jit
def read_contacts(walls, contacts, state, at):
    """Take the walls in contact from the numbers of a state from `at` on; none is recorded."""
    active, count = contacts.active, walls.number
    active[0] = 0
    for wall in range(count):
        place = int(state[at + count + wall])
        contacts.q[wall], contacts.rows[wall] = state[at + wall], -1
        contacts.pushes[wall] = 0.0 if place < 0 else 1.0
        if place != 0:
            active[0] += 1
            active[abs(place)] = wall


@jit
def write_contacts(walls, contacts, state, at):
    active, count = contacts.active, walls.number
    for i in range(2 * count):
        state[at + i] = 0.0
    for c in range(1, active[0] + 1):
        wall = active[c]
        state[at + wall] = contacts.q[wall]
        state[at + count + wall] = c if contacts.pushes[wall] == 1.0 else -c


@jit
def is_at_rest(body, walls, wall, y):
    """Return True if s is 0, and r at a wall or beyond it, within round-off."""
    row, places, rates = walls.links[wall] * body.size, 0.0, 0.0
    for i in range(body.size):
        places += abs(body.rows[row + i] * y[i])
        rates += abs(body.rows[row + i] * y[body.size + i])
    r, s = along(body, walls.links[wall], y, 0)
    depth = walls.signs[wall] * r - walls.gaps[wall]
    return depth >= -AT_REST * places and abs(s) <= AT_REST * rates


@jit
def place_host_state(flow, y, state):
    """Set `state` to y (2 size,) at a section: in flight, or in contact with walls.

    A state beyond a compliant wall is a contact under way. A rigid wall is not penetrated: a state
    beyond it is put on it, and a state at rest on it is held if it is pressed.
    """
    host = bare(flow.host)
    body, walls, contacts, size = host.body, host.walls, host.contacts, host.body.size
    state[:] = 0.0
    for i in range(2 * size):
        state[i] = y[i]
    bare_state, work, drive = bare(state), host.scratch.work, host.scratch.drive
    drive_of(host.grid, 0, 0.0, drive)
    read_contacts(walls, contacts, bare_state, 2 * size)
    active = contacts.active
    for wall in range(walls.number):
        r, s = along(body, walls.links[wall], bare_state, 0)
        depth, m = walls.signs[wall] * r - walls.gaps[wall], 3 * wall
        if depth > 0.0 and walls.law[wall] != IS_RIGID:
            active[0] += 1
            active[active[0]] = wall
            _, q = start_of(walls, wall, 0.0, depth)
            margin = walls.margins[m] + walls.margins[m + 1] * q
            margin += walls.margins[m + 2] * walls.signs[wall] * s
            contacts.q[wall], contacts.pushes[wall] = q, 1.0 if margin > 0.0 else 0.0
    compliant = active[0]
    for wall in range(walls.number):
        if walls.law[wall] != IS_RIGID:
            continue
        is_held = is_at_rest(body, walls, wall, bare_state)
        r, _ = along(body, walls.links[wall], bare_state, 0)
        if is_held or walls.signs[wall] * r > walls.gaps[wall]:
            put_on(body, walls, wall, bare_state)
        if is_held:
            active[0] += 1
            active[active[0]] = wall
    if active[0] > compliant:
        press_now(body, walls, contacts, drive, bare_state, work)
        number = compliant  # of walls in contact, without those that would pull
        for c in range(compliant, active[0]):
            wall = active[1 + c]
            if contacts.pushes[wall] == 1.0 and contacts.forces[wall] > 0.0:
                number += 1
                active[number] = wall
        active[0] = number
        hold(body, walls, contacts, size, bare_state)
    write_contacts(walls, contacts, bare_state, 2 * size)


# ---- the time loop -------------------------------------------------------------------------------


@jit(entry=True)
def run_host(body, walls, contacts, span, state, section, impacts, records):
    """Advance `state` over periods; fill the last sections, and the impacts after `first`.

    state: begins with y (2 size,), and receives as much of the last state as it has room for; span:
    `scene.Span`; section: (points, 2 size) the last states, of stops periods or more; records:
    `HostRecords` of the periods after `first`, or None. Returns a status.
    """
    flow, status = host_flow(body, walls, contacts, impacts, span.stops)
    if status != OK:
        return status
    whole = new_host_state(flow)
    place_host_state(flow, state, whole)
    watch = host_watch(flow.host.body, flow.host.grid, flow.host.walls, records)
    status = run(flow, None, watch, span, whole, section)
    for i in range(len(state)):
        state[i] = whole[i]
    return status


@jit
def run(flow, varied, watch, span, state, section):
    """Call `loop` with bare rows, whose arrays the caller's variables hold until it returns."""
    if varied is None:
        repetition: Any = repetition_for(flow, watch, span.periods)
    else:
        repetition = None  # variations depend on more than the state
    return loop(
        bare(flow.host), bare(varied), bare(watch), bare(repetition), span, bare(state), section
    )


@jit
def run_on_host(flow, rows, periods, state):
    """Advance `state` without variations by so many periods; return a status.

    rows: rows for the sections, as far as there is room.
    """
    return run(flow, None, None, Span(0, periods, 1), state, rows)


@jit
def advance_host(flow, rows, periods, tangent, state):
    """Advance `state` and variations `tangent`, of N numbers each, by up to TOGETHER periods.

    The orbit is that of `run_on_host`, to the last bit. Variation c is tangent[N c : N c + N].
    Fills flow.by_period for these periods, and flow.slowest and flow.clearance with the smallest
    values of all calls. Returns a status.
    """
    varied, status = varied_of(flow.host.body, tangent, flow.clearance, flow.shrunk), OK
    for p in range(periods):
        status = run(flow, varied, None, Span(0, 1, 1), state, rows[p:])
        if status != OK:
            break
        flow.by_period[p] = flow.host.impacts.counts
    return status


@jit
def loop(host, varied, watch, repetition, span, state, section):
    walls, contacts, impacts = host.walls, host.contacts, host.impacts
    total = span.first + span.periods
    read_contacts(walls, contacts, state, 2 * host.body.size)
    if varied is not None:
        vary_on_hold(host.body, walls, contacts, varied)
    impacts.filled[0] = impacts.room  # those before period `first` are not recorded
    ends = 0, span.first, total
    status = run_periods(host, varied, watch, repetition, ends, span.stops, state, section)
    if status != OK:
        return status
    impacts.filled[0] = 0
    for wall in range(walls.number):
        contacts.rows[wall], impacts.counts[wall], impacts.hardest[wall] = -1, 0, 0.0
    if watch is not None:
        watch.is_on[0] = 1.0
    ends = span.first, total, total
    return run_periods(host, varied, watch, repetition, ends, span.stops, state, section)


@jit
def run_periods(host, varied, watch, repetition, ends, stops, state, section):
    """Advance a state through periods `first` to `end` - 1 of an orbit; return a status.

    ends: (first, end, periods of the orbit).
    """
    grid, walls, contacts, impacts = host.grid, host.walls, host.contacts, host.impacts
    first, end, total = ends
    size, period = host.body.size, grid.h * grid.cells
    points = min(len(section), stops * total)
    noted = total - points // stops  # the first period with rows
    cells = grid.cells // stops
    if repetition is not None:
        begin_repetition(repetition, host, watch, first, state)
    p = first
    last = end
    while p < last:
        impacts.began[0] = p * period
        for part in range(stops):
            status = run_part(host, varied, watch, (cells * part, cells * (part + 1)), state)
            if status != OK:
                return status
            row = points - stops * (total - p) + part
            if row >= 0:
                for i in range(2 * size):
                    section[row, i] = state[i]
        size_of_state = 0.0
        for i in range(2 * size):
            size_of_state += abs(state[i])
        if not size_of_state < HUGE:
            return DIVERGED
        write_contacts(walls, contacts, state, 2 * size)
        if watch is not None and watch.is_on[0] > 0.0:
            sum_up(repetition, watch, p - first)
        p += 1
        if repetition is not None and repetition.periods[CYCLE] == 0:
            p, last = next_period(repetition, host, watch, (end, noted), p, state)
    if repetition is not None and last < end:
        cycle = repetition.periods[CYCLE]
        for row in range(points - stops * (total - last), points - stops * (total - end)):
            if row >= 0:
                for i in range(2 * size):
                    section[row, i] = section[row - stops * cycle, i]
        repeat_impacts(repetition, host, period, (end - last) // cycle)
        if watch is not None and watch.is_on[0] > 0.0:
            repeat_integrals(repetition, watch, last - first, end - first)
    if watch is not None and watch.is_on[0] > 0.0:
        put_totals(repetition, watch)
    return OK


@jit
def run_part(host, varied, watch, ends, y):
    """Advance y between two smallest cells of a period."""
    if host.body.springs is not None:
        return run_part_on_springs(host, varied, watch, ends, y)
    body, grid, walls, contacts, _, scratch, _, _ = host
    (first, stop), touches = ends, 0
    is_followed = varied is not None or watch is not None
    j, x, base, shift = first, 0.0, first, 0.0
    while j < stop:
        if contacts.active[0] == 0:
            begun, left_from = (j, x), (base, shift)
            if is_followed:
                for i in range(2 * body.size):
                    scratch.begin[i] = y[i]
                carry(body, grid, scratch, left_from, begun, scratch.begin)
                put_base(watch, y, 2 * body.size)
            wall, base, shift, place = fly(
                body, grid, walls, scratch, None, (j, x, base, shift), stop, y
            )
            if wall == LOST_TOUCH or touches > MOST_TOUCHES:
                return STEP_BUDGET
            j, x = place_at(grid, base, shift, place)
            if varied is not None:
                vary_flight(body, grid, scratch, varied, begun, (j, x))
            if varied is not None and varied.clearance[0] > 0.0:
                note_misses(body, grid, walls, scratch, varied.clearance, begun, (j, x))
            if watch is not None:
                for i in range(2 * body.size):
                    scratch.touch[i] = y[i]
                carry(body, grid, scratch, (base, shift), (j, x), scratch.touch)
                note_flight(host, watch, left_from, begun, (j, x))
            if wall == FLOWN:
                return OK
            touches += 1
            left = NOT_SHORT, 0.0, 0, 0.0
            if walls.law[wall] == IS_HERTZ and place > 0.0:
                if is_followed:
                    put_columns(body, grid, (base, shift), y, scratch.columns)
                touch = base, shift, place
                left = take_at_once(host, varied, watch, wall, touch, stop, y)
            if left[0] == NOT_SHORT:
                carry(body, grid, scratch, (base, shift), (j, x), y)
            if left[0] == NOT_SHORT and walls.law[wall] == IS_HERTZ:
                # the polynomial of r from the touch on reaches farther
                expand_at_touch(body, grid, walls.links[wall], scratch, (j, x), y)
                left = take_at_once(host, varied, watch, wall, (j, x, 0.0), stop, y)
            if left[0] == LOST_TOUCH:
                return STEP_BUDGET
            if left[0] != NOT_SHORT:
                j, x, base, shift = left
                continue
            time = (j + x) * grid.h
            if walls.law[wall] == IS_RIGID:
                drive_of(grid, j, x, scratch.drive)
                strike(host, varied, wall, time, scratch.drive, y)
            else:
                begin(host, varied, wall, time, y)
        j, x = step_contacts(host, varied, watch, (j, x, stop), y)
        if j == LOST_TOUCH:
            return STEP_BUDGET
        base, shift = j, x
    return OK


@jit
def run_part_on_springs(host, varied, watch, ends, y):
    """Advance y as `run_part` does, under springs that are not linear.

    By the longest cells (`spring_cells`) that hold and are proven clear of touches; contacts, and
    short cells that are neither, are stepped. Which cells are taken follows from y alone.
    """
    body = host.body
    grid = host.grid
    walls = host.walls
    contacts = host.contacts
    cells = host.cells
    first, stop = ends
    whole = float(stop - first)
    accepted = ACCEPTED * math.sqrt(contacts.tolerance)
    place = 0.0  # in smallest cells from the first on
    level = 0
    patience = 0
    while place < whole:
        length = cells.lengths[level]
        count = place / length
        if level < LEVELS - 1 and count != math.floor(count):
            level += 1
            continue
        h = length * grid.h
        is_short = level == LEVELS - 1 or h * grid.rate <= STEPPED
        at = first + place
        doubt = math.inf
        if contacts.active[0] == 0:
            put_place(host, at, y)
            doubt = solve_cell(body, cells, level, h, contacts.tolerance)
            if not doubt <= accepted and level < LEVELS - 1:
                level += 1
                patience = PATIENCE
                continue
        is_taken = doubt <= accepted
        if is_taken:
            end_cell(body, cells, level)
            if walls.number > 0:
                is_taken = is_cell_clear(body, walls, cells, level, h, 0.0)
        if not is_taken and not is_short:
            level += 1
            continue
        if is_taken:
            if not is_varied_in_cell(host, varied, level, h) and is_noted_beside(varied, watch):
                step_beside(host, varied, watch, (at, at + length), y)
            for i in range(2 * body.size):
                y[i] = cells.end[i]
        elif not step_between(host, varied, watch, (at, at + length), y):
            return STEP_BUDGET
        place += length
        patience -= 1
        if is_taken and level > 0 and patience <= 0 and doubt <= EASY * accepted:
            count = place / cells.lengths[level - 1]
            if count == math.floor(count):
                level -= 1
    return OK


@jit
def put_place(host, at, y):
    """Write the state and the drive at a place in smallest cells to the cells' `begin`."""
    begin, size = host.cells.begin, host.body.size
    for i in range(2 * size):
        begin[i] = y[i]
    j = int(at)
    drive_of(host.grid, j, at - j, from_place(begin, 2 * size))


@jit
def is_varied_in_cell(host, varied, level, h):
    """Carry variations through a solved cell; return False if they stay as they are.

    So they do where the cell may hold a near miss that counts.
    """
    if varied is None:
        return False
    body, walls, cells, clearance = host.body, host.walls, host.cells, varied.clearance[0]
    may_be_missed = walls.number > 0 and clearance > 0.0
    if may_be_missed and not is_cell_clear(body, walls, cells, level, h, clearance):
        return False
    return vary_cell(body, cells, level, varied.rows, varied.number)


@jit
def is_noted_beside(varied, watch):
    """Return True if variations or records take the motion within a cell."""
    takes = varied is not None
    if watch is not None:
        takes = takes or watch.is_on[0] > 0.0
    return takes


@jit
def step_between(host, varied, watch, places, y):
    """Step from one place to another, in smallest cells; return False if steps are lost.

    places: (at, end).
    """
    at, end = places
    while at < end:
        j = int(at)
        whole, rest = step_contacts(host, varied, watch, (j, at - j, end), y)
        if whole == LOST_TOUCH:
            return False
        at = whole + rest
    return True


@jit
def step_beside(host, varied, watch, places, y):
    """Note the motion of a cell that is proven clear by steps that leave the orbit as it is."""
    beside = host.scratch.touch
    for i in range(2 * host.body.size):
        beside[i] = y[i]
    step_between(host, varied, watch, places, beside)
    host.contacts.active[0] = 0


@jit
def put_base(watch, y, length):
    """Keep the base of a flight for `note_energies`."""
    if watch is not None:
        for i in range(length):
            watch.alone.base[i] = y[i]


@jit
def note_flight(host, watch, base, begun, ended):
    """Note a flight without touches between two places (j, x) from `scratch.begin` on.

    base: the place of its base; `scratch.touch` is the state at its end.
    """
    if watch.is_on[0] == 0.0:
        return
    if watch.rows == 0:
        note_energies(host, watch.alone, base, begun, ended)
        return
    body, grid, walls, contacts, _, scratch, _, _ = host
    (j, x), (last, rest), y, end, drive = begun, ended, scratch.begin, scratch.end, scratch.drive
    size, behind, coarse = body.size, 2 * watch.quantities, 1 << grid.levels
    is_known = is_bounded = False  # whether the values at the beginning, and the bounds, are there
    usual = 0  # the level of the last quiet cell
    while j < last or x < rest:
        noted = 0  # smallest cells, as one quiet cell
        drive_of(grid, j, x, drive)
        if x == 0.0 and j < last:
            if not is_known:
                note_instant(body, watch, y, drive, 0)
            if not is_bounded or j % coarse == 0:
                bound_rates(body, grid, watch, y, drive)
            is_bounded = True
            for level in range(max(usual - 1, 0), grid.levels + 1):
                cells = coarse >> level
                if j % cells != 0 or j + cells > last:
                    continue
                put_columns(body, grid, (j, x), y, scratch.columns)
                advance(body, grid, level, scratch.columns, end)
                drive_of(grid, j + cells, 0.0, drive)
                note_instant(body, watch, end, drive, behind)
                drive_of(grid, j, x, drive)
                if is_quiet(body, watch, cells * grid.h, coarse * grid.h, y):
                    add_squares(body, watch, level, y, drive)
                    noted, usual = cells, level
                    break
        is_known = noted > 0
        if is_known:
            for i in range(2 * size):
                y[i] = end[i]
            for q in range(behind):
                watch.values[q] = watch.values[behind + q]
            j += noted
            continue
        # a smallest cell, or a part of it, in units of its length
        piece = (rest if j == last else 1.0) - x
        expand(body, walls, contacts, drive, piece * grid.h, y)
        layout = width_of(body), 3 * size + OF_DRIVE, 3 * size + OF_TOTAL, piece * grid.h
        note_series(body, watch, contacts.series, layout, 1.0)
        end_state(body, contacts, 1.0, y)
        j, x = (j + 1, 0.0) if j < last else (j, rest)


# ---- the kernels of `orbit.variations` that are marked `by_flow` ---------------------------------


run_on, advance_flow = run_on_host, advance_host
place_state, state_for = place_host_state, new_host_state


@jit
def has_walls(flow):
    return flow.host.walls.number > 0


@jit
def departs(flow, before, now, n):
    """Return True if the next returns after n periods are DEPARTED times as far as the last one.

    Those of an orbit that approaches a cycle become nearer. before, now: sections, n periods apart.
    They cost no variations, unlike Newton's method, which from chaos finds saddles.
    """
    state, earlier = new_host_state(flow), np.empty(flow.space.size)
    nothing = no_section(flow.space)
    place_host_state(flow, now, state)
    apart = distance(flow.space, now, before)
    for _ in range(0, LOOKED_ON, n):
        for i in range(flow.space.size):
            earlier[i] = state[i]
        if run_on_host(flow, nothing, n, state) != OK:
            return True
        if distance(flow.space, state, earlier) > DEPARTED * apart:
            return True
    return False


@jit
def variations_of(flow):
    """Return MEASURED, or N without damping, where the sum shows whether contacts dissipate."""
    size = flow.space.size
    return min(MEASURED, size) if flow.trace < 0.0 else size


@jit
def lost_of(flow):
    """Return LEFT_OVER if a wall may hold, which loses directions, otherwise 0."""
    walls, lost = flow.host.walls, 0.0
    for wall in range(walls.number):
        if walls.law[wall] == IS_RIGID:
            lost = LEFT_OVER
    return lost


@jit
def volume_of(flow, y, monodromy, n):
    """Return the least ln |mu| in place of ln |det M|: many multipliers make it small."""
    size = flow.space.size
    last = eigenvalues(matrix_of(monodromy, size, size))[size - 1]
    return log(hypotenuse(last[RE], last[IM]))
