"""The time loop of a host's orbit."""

from __future__ import annotations

import numpy as np

from ..motion.flight import COEF, TERMS
from ..numerics.compiling import jit
from ..numerics.fours import bare
from ..orbit.orbit import HUGE, MOST_TOUCHES
from ..scene.codes import DIVERGED, OK, STEP_BUDGET, TOO_STIFF
from .body import along, bare_body
from .grid import bare_host_grid, host_grid
from .host_contact import PreparedHost, bare_impacts, begin, follow, strike
from .host_flight import FLOWN, LOST_TOUCH, Scratch, drive_of, fly
from .walls import IS_RIGID, bare_contacts, bare_walls, start_of


@jit(entry=True)
def run_host(body, walls, contacts, span, state, section, impacts):
    """Advance a state (2 size,) over periods; fill the sections and impacts of those after `first`.

    span: `scene.Span`; section: (stops periods, 2 size) states. Returns a status.
    """
    grid, is_fine = host_grid(body, span.stops)
    if not is_fine:
        return TOO_STIFF
    end, work = np.zeros(2 * body.size), np.zeros(3 * body.size + body.drives)
    drive = np.zeros(body.drives)
    gaps, table = np.zeros(4 * body.links), np.zeros(COEF + TERMS)
    scratch = Scratch(bare(end), bare(work), bare(drive), bare(gaps), bare(table))
    host = PreparedHost(
        bare_body(body), bare_host_grid(grid), bare_walls(walls), bare_contacts(contacts),
        bare_impacts(impacts), scratch,
    )  # fmt: skip
    return loop(host, span, bare(state), section)


@jit
def loop(host, span, y, section):
    body, grid, walls, contacts, impacts, scratch = host
    size, period = body.size, grid.h * grid.cells
    # walls inside which the orbit starts
    for wall in range(walls.number):
        r, _ = along(body, walls.links[wall], y, 0)
        depth = walls.signs[wall] * r - walls.gaps[wall]
        if depth > 0.0 and walls.law[wall] != IS_RIGID:
            contacts.active[0] += 1
            contacts.active[contacts.active[0]] = wall
            contacts.rows[wall] = -1
            contacts.pushes[wall] = 1.0
            _, contacts.q[wall] = start_of(walls, wall, 0.0, depth)
    for p in range(span.first + span.periods):
        touches = 0
        if p == span.first:  # impacts that have begun before are not recorded
            impacts.filled[0] = 0
            for wall in range(walls.number):
                contacts.rows[wall] = -1
        for part in range(span.stops):
            j, x = grid.cells // span.stops * part, 0.0
            stop = grid.cells // span.stops * (part + 1)
            while j < stop:
                if contacts.active[0] == 0:
                    wall, j, x = fly(body, grid, walls, scratch, (j, x), stop, y)
                    if wall == LOST_TOUCH or touches > MOST_TOUCHES:
                        return STEP_BUDGET
                    if wall == FLOWN:
                        break
                    touches += 1
                    time = p * period + (j + x) * grid.h
                    if walls.law[wall] == IS_RIGID:
                        drive_of(grid, j, x, scratch.drive)
                        strike(host, wall, time, scratch.drive, y)
                    else:
                        begin(body, walls, contacts, impacts, wall, time, y)
                begun = j, x, stop, p * period
                j, x = follow(host, begun, y)
                if j == LOST_TOUCH:
                    return STEP_BUDGET
            if p >= span.first:
                row = span.stops * (p - span.first) + part
                for i in range(2 * size):
                    section[row, i] = y[i]
        largest = 0.0
        for i in range(2 * size):
            largest = max(largest, abs(y[i]))
        if not largest < HUGE:
            return DIVERGED
    return OK
