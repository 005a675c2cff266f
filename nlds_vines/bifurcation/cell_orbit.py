"""From a cell of a scan's archive to its orbit: `orbit_of`, the same to the last bit."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.bifurcation.cell_start import Place, own_state, swept_before, system_at
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.result import scan_of
from nlds_vines.errors import RequestError, number, unknown, whole
from nlds_vines.kernels.orbit.orbit import STATE_SIZE
from nlds_vines.model.axis import Axis
from nlds_vines.orbits.simulation import Beginning, IntegrationError, Orbit, checked_record


@dataclass(frozen=True)
class CellOrbit:
    """The orbit of one start in one cell of a scan.

    Attributes: the `scan`; `begin`, where the orbit begins; `start`, the name of it; the `label`
    that the archive has for it, empty where none is recorded.
    """

    scan: Scan
    begin: Beginning
    start: str
    label: str = ""

    def orbit(self, record: Collection[str] | None = None, quiet: bool = False) -> Orbit:
        """Return the orbit over the periods of the scan, which records what `simulate` can."""
        system = self.begin.system
        words, scan = checked_record(system, record), self.scan
        return self.begin.follow(words, scan.transient, scan.periods, quiet=quiet)

    def traced(self, begin: int, end: int, samples: int, quiet: bool = False) -> Orbit:
        """Return the orbit from one forcing period to another with states in between.

        States within a period end steps, and so would change a chaotic orbit.  So each period is
        traced by itself, from the orbit that has none: its section is that of the scan.
        """
        count, walls = end - begin, self.begin.system.scene.walls
        words = ("section", "impacts") if walls else ("section",)
        whole_orbit = self.begin.follow(words, begin, count, quiet=quiet)
        assert whole_orbit.section is not None
        states = np.empty((count, samples, whole_orbit.section.shape[1]))
        for i in range(count):
            one = self.begin.after(begin + i).follow(("trajectory",), 0, 1, samples)
            states[i] = one.trajectory
            states[i, -1] = whole_orbit.section[i]
        time = (begin * samples + 1 + np.arange(count * samples)) * (
            self.begin.system.period / samples
        )
        return Orbit(
            system=whole_orbit.system,
            state=whole_orbit.state,
            section=whole_orbit.section,
            impacts=whole_orbit.impacts,
            violation=whole_orbit.violation,
            trajectory=states.reshape(count * samples, -1),
            time=time,
        )


def orbit_of(
    archive: ArchiveView | str | os.PathLike[str],
    *,
    start: int | str = 0,
    record: Collection[str] | None = None,
    quiet: bool = False,
    **values: float,
) -> Orbit:
    """Return the orbit of a cell of a scan's archive, the same to the last bit as the scan's.

    Arguments:
        archive: open, or its path.
        start: which orbit of the cell: its number, or its name ("up", "random 3").
        record: as `simulate` takes it; by default section and, if there are walls, impacts.
        quiet: whether not to say that something is compiled.
        values: of each varied parameter, `omega=7.4, C=0.06`; the nearest cell is taken, whose
            values stand in the `system` of the orbit.

    The orbit is computed again, over the transient and the periods of the scan, from the archive
    alone; of a sweep, all cells before it are, too.  Raises `RequestError` for a parameter that did
    not vary, a value outside the scan, and a start that there is not; `IntegrationError` where the
    orbit ends early, as it did in the scan.
    """
    return cell_orbit(archive, values, start).orbit(record, quiet)


def cell_orbit(
    archive: ArchiveView | str | os.PathLike[str], values: Mapping[str, float], start: int | str = 0
) -> CellOrbit:
    """Return where the orbit of a cell begins; arguments and errors as `orbit_of`."""
    if not isinstance(archive, ArchiveView):
        with read(archive) as view:
            return cell_orbit(view, values, start)
    scan = scan_of(archive)
    place = _place(archive.path, scan, values)
    lane = _lane(scan, start)
    cells = scan.cells()
    system, cell = system_at(scan, place), _record(cells, place)
    begin = Beginning(system, scan.method, scan.settings, cell, np.zeros(STATE_SIZE))
    if scan.start.sweeps:
        begin = _swept(scan, cells, place, lane, begin)
    else:
        begin.state[:4] = own_state(scan, cells[place].reshape(1), place, lane)
    label = str(archive["label"][(*place, lane)]) if "label" in archive else ""
    return CellOrbit(scan, begin, scan.start.names[lane], label)


def _record(cells: np.ndarray, place: Place) -> Any:
    """Return the kernels' record of one cell."""
    return cells[place].reshape(1).view(np.recarray)[0]


def _place(where: object, scan: Scan, values: Mapping[str, float]) -> Place:
    """Return the index of the cell nearest to the values of the varied parameters."""
    names = [axis.name for axis in scan.axes]
    for name in values:
        if name not in names:
            raise unknown(f"varied parameter of {where}:", name, names)
    missing = [axis.name for axis in scan.axes if axis.name not in values and axis.values.size > 1]
    if missing:
        spans = ", ".join(f"{axis.name} from {_span(axis)}" for axis in scan.axes)
        raise RequestError(f"{where} varies {spans}: {', '.join(missing)} is missing")
    return tuple(_nearest(axis, values.get(axis.name, axis.values[0])) for axis in scan.axes)


def _span(axis: Axis) -> str:
    return f"{axis.values[0]:g} to {axis.values[-1]:g}"


def _nearest(axis: Axis, value: float) -> int:
    """Return the index of the nearest value of an axis, of which a cell reaches halfway."""
    value, grid = number(axis.name, value), axis.values
    edges = np.diff(grid[[0, 1, -2, -1]])[[0, 2]] / 2 if grid.size > 1 else np.zeros(2)
    slack = 1e-9 * max(abs(grid[0]), abs(grid[-1]))
    if not grid[0] - edges[0] - slack <= value <= grid[-1] + edges[1] + slack:
        raise RequestError(f"{axis.name} = {value!r} lies outside the scan: {_span(axis)}")
    return int(np.abs(grid - value).argmin())


def _lane(scan: Scan, start: int | str) -> int:
    """Return the number of a start of a cell, given as that or by its name."""
    names = scan.start.names
    if isinstance(start, str) and not start.isdecimal():
        if start not in names:
            raise unknown("start", start, names[:20])
        return names.index(start)
    return whole("start", int(start) if isinstance(start, str) else start, 0, len(names) - 1)


def _swept(scan: Scan, cells: np.ndarray, place: Place, lane: int, begin: Beginning) -> Beginning:
    """Return the beginning of an orbit that follows those of the cells before it in a sweep."""
    first, *others = *swept_before(scan, place, lane), place
    before = begin._replace(cell=_record(cells, first))
    for one in others:
        cell = _record(cells, one)
        try:
            state = before.after(scan.transient + scan.periods).state
            state[2] += cell.rest - before.cell.rest  # the displacement is carried over
            state[4:] = 0.0  # the contact follows from r and s in this cell
        except IntegrationError:
            state = np.zeros(STATE_SIZE)
        before = before._replace(cell=cell, state=state)
    return begin._replace(state=before.state)
