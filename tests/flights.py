"""Single orbits from kernels that the package calls for many at once.

`fly` follows one under a load with all that can be noted of it: states, impacts, work, clearance.
`flow_on` returns the map from section to section with its derivative.
"""

from types import SimpleNamespace

import numpy as np

from nlds_vines.engine import responses
from nlds_vines.engine.batch import parts_of, room_for_impacts, start_state
from nlds_vines.engine.kind_engine import impacts_of
from nlds_vines.engine.records import Violation
from nlds_vines.engine.solver_settings import chosen_settings
from nlds_vines.kernels.cells.cells import prepared_cell
from nlds_vines.kernels.cells.load_numbers import fill_rates
from nlds_vines.kernels.cells.load_orbit import EDGE_SUMS, PolynomialLoad, fly_under
from nlds_vines.kernels.motion.flight import PERIOD, REACH, cells_of, grid_from
from nlds_vines.kernels.motion.load_cells import sums_of
from nlds_vines.kernels.orbit.variations import flow_of
from nlds_vines.kernels.scene.codes import OK, RESPONSE_COLUMNS
from nlds_vines.kernels.scene.scene import CellBuffers, damper_of, structure_under

LOAD, C1, C2, CONTACT = range(4)
"""Columns of `work`: energies up to the edges [J], brought in, and dissipated by each."""

MOST_IMPACTS = 4000


def flow_on(system, method="exact", settings=None):
    """Return the map of a system from section to section with its derivative."""
    parts, cell = parts_of(method, system.scene, settings), system.cell
    ps, damper = structure_under(parts, cell), damper_of(parts.damper, cell)
    n = cells_of(ps, damper)
    return flow_of(
        prepared_cell(parts, cell, ps, damper, n, 1, PERIOD), grid_from(ps, damper, n, PERIOD)
    )


def longest_cell(system):
    """Return the longest cell of a load [s]: 0.7 over a bound of the rates of the motion."""
    rates, cells = np.zeros(1), np.atleast_1d(system.cells()).view(np.recarray)
    fill_rates(parts_of("exact", system.scene), cells, rates)
    return REACH / float(rates[0])


def load_of_kernels(load):
    """Return a load of `load_flight.InCells` as kernels take it."""
    rows, edges = np.ascontiguousarray(load.rows).ravel(), np.ascontiguousarray(load.edges)
    jumps = np.zeros(len(edges)) if load.jumps is None else load.jumps
    sums = getattr(sums_of, "entry", sums_of)(rows)
    return PolynomialLoad(edges, rows, jumps, sums, True if load.share == 0.0 else None)


def fly(system, load, *, start=None, tolerance=None, record=("states", "impacts")):
    """Integrate a system under a load alone, from the first edge to the last."""
    scene, cell = system.scene, system.cell
    parts = parts_of("exact", scene, chosen_settings("exact", {"tolerance": tolerance}))
    edges, limit = len(load.edges), None if scene.limit is None else np.zeros(3)
    summed, walls = "response" in record or "work" in record, bool(scene.walls)
    buffers = CellBuffers(
        section=np.empty((edges, len(scene.components))) if "states" in record else None,
        impacts=room_for_impacts(MOST_IMPACTS) if "impacts" in record and walls else None,
        peak=np.zeros(2) if "energy" in record else None,
        clearance=np.full(1, np.inf) if "clearance" in record and walls else None,
        violation=limit,
        response=np.full(RESPONSE_COLUMNS, np.nan) if summed else None,
        sums=np.empty((edges, EDGE_SUMS)) if "work" in record else None,
    )
    state = start_state(system, cell.rest, start)
    assert fly_under(parts, cell, load_of_kernels(load), state, buffers) == OK
    x1, v1, r, s = state[:4].tolist()
    damped, peak = scene.damper, buffers.peak
    if buffers.impacts is not None:
        assert buffers.impacts.filled[0] <= MOST_IMPACTS
    return SimpleNamespace(
        system=system,
        times=load.edges,
        state=np.array([x1, v1, x1 - r + cell.rest, v1 - s] if damped else [x1, v1]),
        states=buffers.section,
        work=None if buffers.sums is None else buffers.sums[:, :4],
        impacts=None if buffers.impacts is None else impacts_of(buffers.impacts, scene),
        E1max=None if peak is None else float(peak[0]),
        E2max=None if peak is None or not damped else float(peak[1]),
        response=responses.values_of(buffers.response, system) if summed else None,
        clearance=None if buffers.clearance is None else float(buffers.clearance[0]),
        violation=None if limit is None else Violation(int(limit[2]), *limit[:2].tolist()),
    )
