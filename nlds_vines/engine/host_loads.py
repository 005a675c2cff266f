"""Orbits of hosts under loads in time: forces on degrees of freedom, or motion of the ground."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.engine import responses
from nlds_vines.engine.compilation import Compilation, Needed
from nlds_vines.engine.host_orbits import (
    HostOrbits,
    Impacts,
    energies_of,
    largest_impulses,
    response_of,
)
from nlds_vines.engine.load_task import LoadOfOrbit, LoadTask
from nlds_vines.engine.solver_settings import chosen_settings
from nlds_vines.kernels.hosts.host_load import HostLoad, run_host_under
from nlds_vines.kernels.motion.flight import REACH
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.model.loads.loading import Cells, Loading, Struck
from nlds_vines.model.parameters import SIDES
from nlds_vines.model.quantities import SHARES, TOUCH_COLUMNS
from nlds_vines.model.system import General
from nlds_vines.runs.executors import in_pieces
from nlds_vines.runs.interrupts import check, stoppable
from nlds_vines.runs.progress import Tell

NEGLIGIBLE = 1e-18  # of a load's coefficients, relative to the largest one: beyond its degree
PARTS = 32  # equal parts of a cell that is computed again
LOOKS = 3  # times that a cell is divided
MOST_LOOKS = 7  # the same at an impact, where E1 may jump: it is then known to 32^-7 of a cell
RUN_UNDER: Any = getattr(run_host_under, "entry", run_host_under)
ORBITS_AT_ONCE = 4  # that a thread takes at a time


class HostLoads:
    """The kernels for orbits of a host with dampers under loads; see `load_task.LoadRunner`.

    The numbers of the system in a grid are not checked.
    """

    def __init__(self, system: General, task: LoadTask, tell: Tell | None = None) -> None:
        self.system = system
        self._task = task
        self._tell = tell

    @property
    def names(self) -> frozenset[str]:
        system = self.system
        names = {"E1max", *responses.OF_ROWS}
        names |= {f"last_{100 * share:g}" for share in SHARES}
        if system.dampers:
            names |= {"stroke_max", "force_max", "impact_count"}
        if system.masses:
            names.add("E2max")
        if system.scene.with_rigid_walls:
            names.add("impulse_max")
        if self._task.has_histories:
            names |= {"E1", "x", "a"}
            names |= {"stroke"} if system.dampers else set()
            names |= {"E2"} if system.masses else set()
        return frozenset(names)

    @stoppable
    def run(
        self, grid: Mapping[str, np.ndarray], loads: Sequence[LoadOfOrbit]
    ) -> dict[str, np.ndarray]:
        task = self._task
        pieces = dict[int, dict[str, np.ndarray]]()
        shared = dict[tuple[int, float], tuple[Cells, int]]()
        marks = task.times[1:-1] if task.has_histories else np.zeros(0)

        def fly(begin: int, end: int) -> None:
            for lane in range(begin, end):
                check()
                values = [float(column[lane]) for column in grid.values()]
                one = self.system.with_values(grid, values)
                load, impulse = loads[lane]
                if load.acts or impulse:
                    one = one.under(load)
                else:
                    one = one.with_values(["ground.acceleration"], [-1.0])
                longest = longest_cell(one, task.duration)
                key = id(load), longest
                if key not in shared:
                    shared[key] = cells_of(load, task.duration, longest, marks)
                cells, drives = shared[key]
                in_cells = cells.struck(impulse), drives
                pieces[lane] = self._arrays(one, in_cells)

        needed = Needed("a host", "exact", ())
        with Compilation(needed, self._tell, helped=False).followed({RUN_UNDER: "orbit"}):
            in_pieces(fly, len(loads), most=ORBITS_AT_ONCE)
        lanes = [pieces[lane] for lane in range(len(loads))]
        return {name: np.concatenate([one[name] for one in lanes]) for name in lanes[0]}

    def _arrays(self, system: General, in_cells: tuple[Cells, int]) -> dict[str, np.ndarray]:
        """Return the datasets (1, ...) of an orbit of a system `under` its load."""
        task = self._task
        settings = chosen_settings("exact", {"tolerance": task.tolerance})
        orbits = HostOrbits(system, settings.stepped_to)
        start = orbits.start(task.state[: 2 * orbits.size] or None)
        strokes = [damper.stroke for damper in system.dampers]
        orbit = follow_load(orbits, in_cells, start, [*task.of, *strokes])
        quantities = self._quantities(system, orbits, in_cells, orbit)
        counts = [
            np.count_nonzero(orbit.impacts["damper"] == damper.name) if damper.walls else -1
            for damper in system.dampers
        ]
        impact_count = np.array(counts, np.int32)
        arrays = {name: np.array(values, float) for name, values in quantities.items()}
        if task.has_histories:
            places = np.searchsorted(orbit.edges, task.times * (1.0 - 1e-14))
            histories = self._histories(system, orbits, orbit)
            arrays |= {name: values[..., places] for name, values in histories.items()}
        if orbit.status != OK:
            arrays = {name: np.full_like(values, np.nan) for name, values in arrays.items()}
            impact_count[:] = -1
        if system.dampers:
            arrays["impact_count"] = impact_count
        arrays["status"] = np.array(orbit.status, np.int8)
        arrays["violations"] = np.zeros(())
        arrays = {name: values[np.newaxis] for name, values in arrays.items()}
        if task.has_histories:
            arrays["touches"] = _touches(orbit.impacts, system)
        return arrays

    def _quantities(
        self, system: General, orbits: HostOrbits, in_cells: tuple[Cells, int], orbit: LoadedOrbit
    ) -> dict[str, Any]:
        """Return the quantities `OF_LOADS` but counts: numbers, by displacement or by damper."""
        E1max, E2max = energies_of(orbit.records, system)
        quantities: dict[str, Any] = {"E1max": E1max}
        levels = [share * E1max for share in SHARES]
        if orbit.status == OK:
            times = last_times(orbits, in_cells, orbit, levels)
        else:
            times = [np.nan] * len(levels)
        for share, time in zip(SHARES, times, strict=True):
            quantities[f"last_{100 * share:g}"] = time
        count = len(self._task.of)
        for column, name in enumerate(responses.OF_ROWS):
            quantities[name] = orbit.response[:count, column]
        if system.dampers:
            damper, force = orbit.impacts["damper"], orbit.impacts["force"]
            largest = [force[damper == one.name].max(initial=0.0) for one in system.dampers]
            quantities["stroke_max"] = orbit.response[count:, 0]
            quantities["force_max"] = largest
        if system.masses:
            quantities["E2max"] = np.where([d.m is None for d in system.dampers], np.nan, E2max)
        if system.scene.with_rigid_walls:
            quantities["impulse_max"] = orbit.impulses
        return quantities

    def _histories(
        self, system: General, orbits: HostOrbits, orbit: LoadedOrbit
    ) -> dict[str, np.ndarray]:
        """Return the histories at the edges of cells."""
        count = len(orbits.modes)
        X, V, _ = np.moveaxis(orbit.section.reshape(-1, 3, orbits.size), 1, 0)
        energy, _ = energies_at(orbits, orbit.section)
        x, a = np.full((2, len(self._task.of), len(orbit.edges)), np.nan)
        for i, name in enumerate(self._task.of):
            row, moved = system.displacement(name)
            x[i] = combined(orbit.states[:, ::2], row)
            a[i] = combined(orbit.accelerations, row)
            if orbits.system.acceleration:
                a[i] += orbits.system.acceleration * moved * orbit.loads
        E2, stroke = np.full((2, len(system.dampers), len(orbit.edges)), np.nan)
        for i, (damper, row) in enumerate(zip(system.dampers, system.rows(), strict=True)):
            stroke[i] = combined(orbit.states[:, ::2], row)
            if damper.m is not None:  # dampers with a mass come first
                k = count + i
                E2[i] = 0.5 * damper.m * V[:, k] * V[:, k]
                if damper.spring is None:
                    E2[i] += 0.5 * damper.k * X[:, k] * X[:, k]
                else:
                    r = stroke[i]
                    E2[i] += 0.5 * damper.k * r * r + damper.spring.energy(r)
        histories = {"E1": energy, "x": x, "a": a}
        if system.dampers:
            histories["stroke"] = stroke
        if system.masses:
            histories["E2"] = E2
        return histories


def _touches(impacts: np.ndarray, system: General) -> np.ndarray:
    """Return the impacts (impacts, columns) as numbers, in the columns of `TOUCH_COLUMNS`."""
    columns = {name: impacts[name] for name in TOUCH_COLUMNS}
    names = system.damper_names
    columns["damper"] = np.array([names.index(name) for name in impacts["damper"]], float)
    columns["wall"] = np.array([SIDES[side] for side in impacts["wall"]], float)
    return np.array([*columns.values()], float).T


class LoadedOrbit(NamedTuple):
    """An orbit under a load."""

    status: int
    edges: np.ndarray  # (n,) times [s]
    section: np.ndarray  # (n, 3 size) X, X' and X'' by mode and mass
    states: np.ndarray  # (n, components) [m, m/s]
    accelerations: np.ndarray  # (n, coordinates and masses) relative to the ground [m/s^2]
    loads: np.ndarray  # (n,) the force on a dof of factor 1 [N], or minus the ground's acceleration
    impacts: np.ndarray  # of dtype `records.HOST_IMPACT`
    response: np.ndarray  # (displacements, 3) the quantities `OF_ROWS`
    impulses: np.ndarray  # (dampers,) the largest ones at rigid walls [N s]
    records: Any  # `HostRecords`: largest energies and the response of displacements


def longest_cell(system: General, duration: float) -> float:
    """Return the longest cell of a load on a host [s].

    It is `REACH` at the rate of the second slowest motion; the kernels halve it for faster ones.
    """
    # of a bistable damper, k < 0, the rate at which it leaves r = 0
    squares = [abs(damper.k) / damper.m for damper in system.dampers if damper.m]
    rates = np.sort(np.concatenate([system.host.frequencies[:2], np.sqrt(squares)]))
    rates = rates[rates > 0.0]
    if not rates.size:
        return duration
    # rounded down by up to an eighth: eigenvalues by LAPACK differ in their last bits, and many
    # systems share their loads
    mantissa, exponent = np.frexp(REACH / min(rates[min(1, rates.size - 1)], 2.0 * rates[0]))
    return float(np.ldexp(np.floor(16.0 * mantissa) / 16.0, exponent))


def cells_of(
    load: Loading, duration: float, longest: float, marks: np.ndarray
) -> tuple[Cells, int]:
    """Return a load in cells, with edges at `marks` [s], and the number of its drives."""
    cells = load.cells(Struck(1.0), duration, longest, marks)
    sizes = np.abs(cells.rows).max(axis=0)
    degree = int(np.flatnonzero(sizes > NEGLIGIBLE * sizes.max())[-1]) if sizes.any() else 0
    return cells, max(2, 2 * (degree // 2 + 1))


def follow_load(
    orbits: HostOrbits, in_cells: tuple[Cells, int], state: np.ndarray, names: Sequence[str] = ()
) -> LoadedOrbit:
    """Integrate an orbit of a system `under` a load from a kernels' state on, which is advanced.

    names: displacements whose largest values are recorded.
    """
    cells, drives = in_cells
    size = orbits.size
    orbits.body = orbits.body._replace(drives=drives, paces=np.zeros(drives))
    edges = cells.edges
    rows = rows_of_load(in_cells)
    jumps = np.zeros(len(edges)) if cells.jumps is None else cells.jumps
    load = HostLoad(edges, rows.ravel(), jumps, np.zeros(0))
    records: Any = orbits.records(True, names, is_ground_known=False)
    code, section, impacts = _run_under(orbits, load, state, records)
    accelerations = np.hstack([section[:, 2 * size :]] * 2)
    return LoadedOrbit(
        code,
        edges,
        section,
        orbits.states(section[:, : 2 * size]),
        orbits.states(accelerations)[:, ::2],
        np.append(rows[:, 0], rows[-1].sum()),
        orbits.table_of(impacts),
        response_of(orbits, records, impacts, edges[-1] - edges[0]),
        largest_impulses(orbits, impacts),
        records,
    )


def rows_of_load(in_cells: tuple[Cells, int]) -> np.ndarray:
    """Return the coefficients (cells, drives) of a load."""
    cells, drives = in_cells
    rows = np.zeros((len(cells.rows), max(drives, cells.rows.shape[1])))
    rows[:, : cells.rows.shape[1]] = cells.rows
    return np.ascontiguousarray(rows[:, :drives])


def _run_under(
    orbits: HostOrbits, load: HostLoad, state: np.ndarray, records: Any
) -> tuple[int, np.ndarray, Impacts]:
    """Integrate an orbit; return its status, the sections at the edges, and the impacts.

    The state, the records and the load's `tops` are advanced in place.
    """
    section, room = np.zeros((len(load.edges), 3 * orbits.size)), 1024
    start, tops, peaks = state.copy(), load.tops.copy(), records.peaks.copy()
    while True:
        impacts, how = orbits.room_for(room, True), (orbits.body, orbits.walls, orbits.contacts())
        code = RUN_UNDER(*how, load, state, section, impacts, records)
        if code != OK or impacts.filled[0] <= room:
            return code, section, impacts
        room = int(impacts.filled[0])
        state[:], load.tops[:], records.peaks[:] = start, tops, peaks
        records.squares[:] = 0.0


# ---- the last time above a level of the host's energy --------------------------------------------


def energies_at(orbits: HostOrbits, section: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the energy E1 of the host [J] and its rate [W] at the edges."""
    X, V, A = np.moveaxis(section.reshape(-1, 3, orbits.size), 1, 0)
    energy, rate = np.zeros((2, len(X)))
    for k in range(len(orbits.modes)):
        energy += 0.5 * (V[:, k] * V[:, k] + orbits.body.squares[k] * X[:, k] * X[:, k])
        rate += V[:, k] * (A[:, k] + orbits.body.squares[k] * X[:, k])
    return energy, rate


def last_times(
    orbits: HostOrbits, in_cells: tuple[Cells, int], orbit: LoadedOrbit, levels: Sequence[float]
) -> list[float]:
    """Return the last times [s] at which E1 exceeds ascending levels [J], whatever the edges are.

    NaN if E1 exceeds a level at the end, 0 if it never does.

    Notes
    -----
    After the last edge above a level the orbit is computed again: the largest E1 in each cell tells
    in which one the level is exceeded last.  That cell is computed again in `PARTS`, and so is the
    last part above the level, until a cubic by the energies and rates at its ends suffices.
    """
    energy, _ = energies_at(orbits, orbit.section)
    end = len(energy) - 1
    above = [int(np.flatnonzero(energy > level)[-1]) if (energy > level).any() else -1
             for level in levels]  # fmt: skip
    cells, rows = in_cells[0], rows_of_load(in_cells)
    first = max(min(above), 0)
    tops = np.full(end - first, np.inf)
    for level, edge in zip(levels[::-1], above[::-1], strict=True):
        tops[max(edge, 0) - first :] = level
    if first < end and min(above) < end:
        load = HostLoad(cells.edges[first:], rows[first:].ravel(), _jumps(cells, first), tops)
        _highest(orbits, load, orbit.section[first])
    times = []
    for level, edge in zip(levels, above, strict=True):
        higher = first + np.flatnonzero(tops > level)
        cell = max([edge, *higher[higher >= edge].tolist()])
        if edge == end:
            times.append(np.nan)
        elif cell < 0:
            times.append(0.0)
        else:
            h = cells.edges[cell + 1] - cells.edges[cell]
            place = _last_place(orbits, rows[cell], h, orbit.section[cell], level)
            times.append(float(cells.edges[cell] + h * place))
    return times


def _jumps(cells: Cells, first: int) -> np.ndarray:
    """Return the jumps from an edge on, without the one there, which its section has."""
    jumps = np.zeros(len(cells.edges) - first)
    if cells.jumps is not None:
        jumps[1:] = cells.jumps[first + 1 :]
    return jumps


def _highest(orbits: HostOrbits, load: HostLoad, section: np.ndarray) -> tuple[np.ndarray, int]:
    """Raise the load's `tops` to the largest E1; return its sections and number of impacts."""
    records: Any = orbits.records(True, ())
    records.peaks[1:] = np.inf  # the masses' energies are not asked for
    code, sections, impacts = _run_under(orbits, load, section[: 2 * orbits.size].copy(), records)
    if code != OK:
        load.tops[:] = np.nan
    return sections, int(impacts.filled[0])


def _last_place(
    orbits: HostOrbits, row: np.ndarray, h: float, section: np.ndarray, level: float
) -> float:
    """Return the last place in a cell of h [s], from 0 to 1, where E1 exceeds a level.

    row: coefficients of the load; section: at the beginning of the cell.
    """
    begin, width = 0.0, 1.0
    for look in range(MOST_LOOKS):
        edges = (h * width) * (np.arange(PARTS + 1) / PARTS)
        parts = _in_parts(row, begin, width / PARTS)
        load = HostLoad(edges, parts.ravel(), np.zeros(PARTS + 1), np.full(PARTS, level))
        sections, impacts = _highest(orbits, load, section)
        energy, rate = energies_at(orbits, sections)
        above = np.append(np.flatnonzero(load.tops > level), np.flatnonzero(energy > level))
        if not above.size:
            return begin
        last = int(above.max())
        if last == PARTS:
            return begin + width
        section = sections[last]
        width /= PARTS
        begin += width * last
        if look >= LOOKS - 1 and not impacts:
            break
    if not energy[last] > level:
        return begin
    step = h * width
    ends = energy[last] - level, energy[last + 1] - level
    return begin + width * _root_of_cubic(*ends, step * rate[last], step * rate[last + 1])


def _in_parts(row: np.ndarray, begin: float, width: float) -> np.ndarray:
    """Return the coefficients (PARTS, drives) of a polynomial in parts of its cell."""
    places = begin + width * np.arange(PARTS)
    parts = np.repeat(row[np.newaxis], PARTS, axis=0)
    degree = len(row) - 1
    for k in range(degree):  # Horner's scheme, once for each power
        for j in range(degree - 1, k - 1, -1):
            parts[:, j] += places * parts[:, j + 1]
    factor = 1.0
    for k in range(degree + 1):
        parts[:, k] *= factor
        factor *= width
    return parts


def _root_of_cubic(f0: float, f1: float, g0: float, g1: float) -> float:
    """Return where the cubic with values f0 > 0 >= f1 and slopes g0, g1 at 0 and 1 is 0."""
    low, high = 0.0, 1.0
    while high - low > 1e-15:
        x = 0.5 * (low + high)
        y = 1.0 - x
        f = y * y * ((1.0 + 2.0 * x) * f0 + x * g0) + x * x * ((1.0 + 2.0 * y) * f1 - y * g1)
        if f > 0.0:
            low = x
        else:
            high = x
    return 0.5 * (low + high)


def combined(values: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Return the sums (n,) of `values` (n, m) times a row (m,), each in one order."""
    total = np.zeros(len(values))
    for k in np.flatnonzero(row):
        total += values[:, k] * row[k]
    return total
