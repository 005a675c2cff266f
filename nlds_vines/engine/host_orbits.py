"""Orbits of hosts: their systems as kernels take them, and the records of `simulate`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from nlds_vines.engine.batch import WALLS, Layout
from nlds_vines.engine.compilation import Compilation, Needed
from nlds_vines.engine.records import HOST_IMPACT, NOTED
from nlds_vines.engine.solver_settings import EFFORTS, TOLERANCE
from nlds_vines.engine.starts import DAMPER_SPREAD, FALLBACK_LENGTH, STRUCTURE_SPREAD, checked_start
from nlds_vines.errors import RequestError
from nlds_vines.kernels.cells.host_verdict import judge_host
from nlds_vines.kernels.hosts.body import Body
from nlds_vines.kernels.hosts.cell_constants import CellConstants, cell_constants
from nlds_vines.kernels.hosts.host_contact import (
    BEHIND_SERIES,
    MOTION_COLUMNS,
    ROW_OF_IMPACT,
    Impacts,
)
from nlds_vines.kernels.hosts.host_orbit import run_host
from nlds_vines.kernels.hosts.host_watch import HostRecords
from nlds_vines.kernels.hosts.modes import fill_modes
from nlds_vines.kernels.hosts.springs import COLUMNS_OF_SPRING, Springs
from nlds_vines.kernels.hosts.walls import SCALES, Contacts, Laws, Walls
from nlds_vines.kernels.impact.arc import COARSE, SETTLED, make_arc
from nlds_vines.kernels.scene import codes
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.scene.law import HIGHEST, SCRATCH
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.dampers import Damper, Spring
from nlds_vines.model.host import Host, modal_damping
from nlds_vines.model.parameters import CONSTANTS, DAMPING, SIDES
from nlds_vines.model.system import General
from nlds_vines.runs.interrupts import stoppable
from nlds_vines.runs.progress import Tell

RECORDS = ("section", "impacts", "energy", "response", "trajectory")

IMPACTS_EXPECTED = 8  # in a period, for which there is room at first

ALONE = 1.0e-10  # of a jump of a row's rate by an impact, relative to its bound: round-off

MOST_COORDINATES = 200
"""The most coordinates of a host whose orbits are computed: a flight costs their square."""

LAWS_IN_KERNELS = ("hertz", "power", "linear", "kelvin-voigt", "restitution")
"""The laws of walls in the order of the numbers of `kernels.hosts.walls`."""

_CONSTANTS = np.dtype([(name, float) for name in CONSTANTS])


class HostOrbits:
    """A host's system as kernels take it, in the coordinates of its modes."""

    def __init__(self, system: General, tolerance: float = TOLERANCE) -> None:
        host, self.system = system.host, system
        n = len(host.inertia)
        if n > MOST_COORDINATES:
            raise RequestError(
                f"a host of {n} coordinates is too large for orbits; allowed: {MOST_COORDINATES}. "
                "Reduce it: host.reduced(keep=20, statics=[...])"
            )
        squares, self.modes, damping, coupling = _modes_of(host)
        masses = np.array([damper.m for damper in system.masses])
        self.size, size = n + len(masses), n + len(masses)
        inverse = np.concatenate([np.ones(n), 1 / masses])
        self.inverse = inverse
        rows, push = self.by_mode(system.rows()), self.by_mode(system.push()[None])[0]
        walls = [(i, wall) for i, damper in enumerate(system.dampers) for wall in damper.walls]
        self.names = [(system.dampers[i].name, wall.side) for i, wall in walls]
        self.body = Body(
            modes=n,
            size=size,
            links=len(rows),
            omega=system.omega,
            period=system.period,
            begun=0.0,
            turns=1.0,
            drives=2,
            paces=np.array([-system.omega, system.omega]),
            squares=squares,
            damping=damping,
            coupling=coupling,
            coupled=coupling.size > 0,
            push=push * inverse,
            rows=rows.ravel(),
            answers=(rows * inverse).ravel(),
            stiffness=np.array([float(damper.k) for damper in system.dampers]),
            dashpots=np.array([float(damper.c) for damper in system.dampers]),
            springs=springs_of(system),
        )
        laws = [LAWS_IN_KERNELS.index("power" if wall.is_damped else wall.law) for _, wall in walls]
        constants, margins = np.zeros(len(walls), _CONSTANTS), []
        for record, (_, wall) in zip(constants, walls, strict=True):
            record["exponent"] = 1.5
            for name in CONSTANTS:
                record[name] = wall.constants.get(name, record[name])
            is_spring = wall.law == "linear"
            margins += (
                [0.0, record["kc"], record["cc"]] if is_spring else [1.0, 0.0, record[DAMPING]]
            )
        self.walls = Walls(
            number=len(walls),
            links=np.array([i for i, _ in walls], dtype=np.int64),
            signs=np.array([SIDES[wall.side] for _, wall in walls]),
            gaps=np.array([wall.gap for _, wall in walls]),
            inverse=np.array([np.sum(rows[i] * rows[i] * inverse) for i, _ in walls]),
            laws=Laws(WALLS["hertz", False], WALLS["power", True], WALLS["linear", False]),
            law=np.array(laws, dtype=np.int64),
            constants=constants.view(np.recarray),
            margins=np.array(margins, dtype=float),
        )
        self.tolerance = tolerance

    def by_mode(self, rows: np.ndarray) -> np.ndarray:
        """Return rows by modes and masses of rows by coordinates and masses."""
        n = len(self.modes)
        return np.hstack([_times(rows[:, :n], self.modes), rows[:, n:]])

    def records(
        self, energy: bool, names: Sequence[str], is_ground_known: bool = True
    ) -> HostRecords | None:
        """Return empty records of energies and of the response of rows, None if neither is wanted.

        names: as of `General.displacement`.  Where the displacement of moving ground is known,
        rows of the absolute displacements follow.
        """
        n, system = len(self.modes), self.system
        if not names and not energy:
            return None
        pairs = [system.displacement(name) for name in names]
        rows = np.array([row for row, _ in pairs]).reshape(len(names), -1 if names else self.size)
        moved = np.array([moved for _, moved in pairs])
        displacements = np.zeros(len(names))
        if is_ground_known and not system.force:
            displacements = np.append(displacements, system.displacement_of_ground * moved)
            rows = np.vstack([rows, rows])
        count = 1 + len(system.masses) if energy else 0
        m = np.concatenate([np.ones(n), [damper.m for damper in system.masses]])
        # the energy of a spring that is not linear depends on its own shortening (`add_potential`)
        stiffness = [damper.k if damper.spring is None else 0.0 for damper in system.masses]
        k = np.concatenate([self.body.squares, stiffness])
        return HostRecords(
            masses=m if count else np.zeros(0),
            springs=k if count else np.zeros(0),
            rows=self.by_mode(rows).ravel(),
            grounds=np.append(displacements, system.acceleration * moved),
            peaks=np.zeros(count + len(displacements) + len(names)),
            squares=np.zeros(len(displacements)),
        )

    def contacts(self) -> Contacts:
        """Return room for the walls in contact of one orbit."""
        count = self.walls.number
        width = 3 * self.size + MOTION_COLUMNS + self.body.drives
        arc = make_arc(min(self.tolerance, 0.5 * COARSE))  # of 12 nodes or more, for the moments
        return Contacts(
            active=np.zeros(count + 1, np.int64),
            q=np.zeros(count),
            pushes=np.ones(count),
            rows=np.full(count, -1, np.int64),
            scratch=np.zeros(count * SCRATCH),
            series=np.zeros((HIGHEST + 1) * width + BEHIND_SERIES),
            scales=np.zeros(SCALES * count),
            unit=np.ones(1),
            end=np.zeros(2 * self.size),
            forces=np.zeros(count),
            matrix=np.zeros((count, count + 1)),
            rebounds=np.zeros(count),
            compressed=np.zeros(count),
            expanded=np.zeros(count),
            joins=np.zeros(count, np.int64),
            presses=np.zeros(count),
            impulses=np.zeros(count),
            least=np.zeros(count),
            rough=np.zeros(count),
            values=np.zeros(2 * (HIGHEST + 1)),
            tolerance=self.tolerance,
            arc=arc._replace(tolerance=self.tolerance, settled=SETTLED * self.tolerance),
        )

    def follow(
        self,
        state: np.ndarray,
        span: Span,
        records: HostRecords | None = None,
        noted: int = 0,
        has_depths: bool = False,
    ) -> tuple[int, np.ndarray, Impacts]:
        """Integrate an orbit; return its status, the sections and the impacts.

        The sections are those after the transient, and before them those of `noted` periods.  The
        state and the records are advanced in place.  Largest depths and forces of impacts take time
        of their own; otherwise they have no meaning.
        """
        room, start = 64 + IMPACTS_EXPECTED * span.periods, state.copy()
        section = np.zeros(((noted + span.periods) * span.stops, 2 * self.size))
        while True:
            impacts = self.room_for(room, has_depths)
            how = self.body, self.walls, self.contacts()
            code = run_host(*how, span, state, section, impacts, records)
            if code != OK or impacts.filled[0] <= room:
                return code, section, impacts
            room = int(impacts.filled[0])
            state[:] = start
            if records is not None:
                records.peaks[:], records.squares[:] = 0.0, 0.0

    def room_for(self, count: int, has_depths: bool) -> Impacts:
        data, filled = np.zeros(count * ROW_OF_IMPACT), np.zeros(1, np.int64)
        counts = np.zeros(self.walls.number, np.int64)
        hardest = np.zeros(self.walls.number)
        slowest, began = np.full(1, np.inf), np.zeros(1)
        return Impacts(data, filled, count, counts, slowest, hardest, has_depths, began)

    def is_struck(self, records: HostRecords, impacts: Impacts) -> np.ndarray:
        """Return True for the rows (rows,) of `records` whose rates a rigid wall lets jump.

        The impulse of a wall with the row l changes the rate of a row w by w M^-1 l.  By modes that
        is 0 within round-off, where masses are those of degrees of freedom.
        """
        struck = np.flatnonzero(impacts.hardest > 0.0)
        count = len(records.grounds) - len(records.squares)
        rows = records.rows.reshape(-1, self.size)[:count]
        answers = self.body.answers.reshape(-1, self.size)[self.walls.links[struck]]
        jumps = np.abs(_times(rows, answers.T))
        inverse_masses = _times(rows * rows, self.inverse[:, np.newaxis])  # w M^-1 w
        sizes = np.sqrt(inverse_masses * self.walls.inverse[struck])
        return np.asarray((jumps > ALONE * sizes).any(axis=1))

    def follow_judged(
        self, state: np.ndarray, span: Span, effort: str, records: HostRecords | None = None
    ) -> tuple[int, np.ndarray, Impacts, np.ndarray]:
        """Integrate and judge an orbit.

        Returns the status, the sections and the impacts after the transient, and the row of
        evidence, whose `layout` it has; `state` is advanced in place to the end of the sections.
        """
        noted, size = min(span.first, NOTED), len(state)
        row = np.full(self.layout.impacts.stop, np.nan)
        ends = np.zeros((2, size + 2 * self.walls.number))  # with the contacts of each wall
        ends[:, :size] = state
        code, section, impacts = self.follow(ends[1], span, records, noted)
        state[:] = ends[1, :size]
        if code == OK:
            stages, first = np.array(EFFORTS[effort], dtype=np.int64), span.first - noted
            arguments = self.body, self.walls, self.contacts(), ends, section, first, stages, row
            code = int(judge_host(*arguments))
        return code, section[noted:], impacts, row

    @property
    def layout(self) -> Layout:
        """The layout of a row of evidence."""
        N, count = 2 * self.size, self.walls.number
        impacts = codes.EXPONENTS + N * (N + 2)
        return Layout(N, N, slice(impacts, impacts + count), tuple(self.walls.links.tolist()))

    def states(self, inner: np.ndarray) -> np.ndarray:
        """Return states (..., components) of the kernels' (..., 2 size)."""
        n, size = len(self.modes), self.size
        outer = np.empty(inner.shape)
        for part in (0, 1):
            values = inner[..., part * size : (part + 1) * size]
            outer[..., part : 2 * n : 2] = _times(values[..., :n], self.modes.T)
            outer[..., 2 * n + part :: 2] = values[..., n:]
        return outer

    def start(
        self, start: Sequence[float] | np.ndarray | None, is_put_on_walls: bool = False
    ) -> np.ndarray:
        """Return the kernels' state of a start in components; None is the system's state at rest.

        A start inside a rigid wall is refused, unless kernels may put it on the wall.
        """
        n, size = len(self.modes), self.size
        state = np.zeros(2 * size)
        if start is None:
            start = self.system.state_at_rest
            if not any(start):
                return state
        values = checked_start(start, self.system.scene.components)
        for part in (0, 1):
            on_host = _times(values[None, part : 2 * n : 2], self.system.host.M)
            state[part * size : part * size + n] = _times(on_host, self.modes)[0]
            state[part * size + n : (part + 1) * size] = values[2 * n + part :: 2]
        depths = self.body.rows.reshape(-1, size) @ state[:size]
        for link, sign, gap, law, name in zip(
            self.walls.links, self.walls.signs, self.walls.gaps, self.walls.law, self.names,
            strict=True,
        ):  # fmt: skip
            depth = sign * depths[link] - gap
            is_rigid = LAWS_IN_KERNELS[law] == "restitution"
            if is_rigid and not is_put_on_walls and depth > 1e-12 * abs(gap):
                raise RequestError(
                    f"start: {depth:.3g} m inside the rigid wall {name[1]!r} of damper {name[0]!r}"
                )
        return state

    def random_state(self, draws: np.ndarray) -> np.ndarray:
        """Return a start (components,) of draws from [-1, 1), in the order of the components.

        The displacement of a mode is 5 l times a draw, with the lesser l of its static deflection
        and its amplitude far above resonance; a damper's r is 15 l times a draw, with the sum of
        these l where it is attached, and between its walls.  Velocities are omega times as large.
        """
        n, size, body = len(self.modes), self.size, self.body
        slowest = np.maximum(body.squares, body.omega * body.omega)
        lengths = np.abs(body.push[:n]) / slowest
        if not lengths.any():
            lengths = FALLBACK_LENGTH / np.abs(self.modes).max(axis=0)
        state = np.zeros(2 * size)
        for part, unit in enumerate((1.0, body.omega)):
            values = state[part * size : (part + 1) * size]
            values[:n] = STRUCTURE_SPREAD * unit * lengths * draws[part : 2 * n : 2]
            for i, draw in enumerate(draws[2 * n + part :: 2]):
                row = body.rows.reshape(-1, size)[i, :n]
                r = DAMPER_SPREAD * unit * draw * _sum(np.abs(row) * lengths)
                if part == 0:
                    for wall in np.flatnonzero(self.walls.links == i):
                        sign = self.walls.signs[wall]
                        r = sign * min(sign * r, self.walls.gaps[wall])
                values[n + i] = _sum(row * values[:n]) - r
        return self.states(state)

    def table_of(self, impacts: Impacts) -> np.ndarray:
        """Return the impacts as rows of dtype `HOST_IMPACT`."""
        rows = rows_of(impacts)
        table = np.zeros(len(rows), HOST_IMPACT)
        for row, values in zip(table, rows, strict=True):
            row["damper"], row["wall"] = self.names[int(values[0])]
        for column, name in enumerate((HOST_IMPACT.names or ())[2:], 1):
            table[name] = rows[:, column]
        return table


def springs_of(system: General) -> Springs | None:
    """Return the springs of a system that are not linear, None if all are."""
    sprung = [i for i, damper in enumerate(system.dampers) if damper.spring is not None]
    if not sprung:
        return None
    count = len(sprung)
    k2, k3, k5 = np.array([system.dampers[i].coefficients for i in sprung], dtype=float).T
    return Springs(
        number=count,
        links=np.array(sprung, dtype=np.int64),
        k2=np.ascontiguousarray(k2),
        k3=np.ascontiguousarray(k3),
        k5=np.ascontiguousarray(k5),
        series=np.zeros(count * (HIGHEST + 1) * COLUMNS_OF_SPRING),
        fast=np.zeros(count),
        constants=_constants_of_cells(),
    )


def rows_of(impacts: Impacts) -> np.ndarray:
    """Return the impacts as rows of the columns of `host_contact.Impacts`."""
    return impacts.data.reshape(-1, ROW_OF_IMPACT)[: impacts.filled[0]]


@stoppable
def follow_host(
    orbits: HostOrbits,
    state: np.ndarray,
    span: Span,
    tell: Tell | None,
    records: HostRecords | None = None,
    effort: str = "",
    has_depths: bool = False,
) -> tuple[int, np.ndarray, Impacts, np.ndarray]:
    """Integrate an orbit as `HostOrbits.follow_judged` does, and report what is compiled.

    Without an effort it is not judged, and the row of evidence is empty.
    """
    needed = Needed("a host", "exact", ("regime",) if effort else ())
    kernels = {_RUN: "orbit", **({_JUDGE: "verdict"} if effort else {})}
    with Compilation(needed, tell, helped=False).followed(kernels):
        if effort:
            return orbits.follow_judged(state, span, effort, records)
        return (*orbits.follow(state, span, records, has_depths=has_depths), np.zeros(0))


def compile_host(
    system: General, tell: Tell | None, has_records: bool = False, is_judged: bool = False
) -> None:
    """Compile the kernels of hosts such as a system, unless the cache has them.

    By an orbit of no period of a host with one damper, with a spring if the system has one.
    """
    dampers = [Damper("a", "x1", m=1.0, spring=Spring(k3=1.0))] if springs_of(system) else []
    host = Host(M=[[1.0]], K=[[1.0]])
    system = General(host, tuple(dampers), {}, {"acceleration": 0.0}, 1.0)
    orbits = HostOrbits(system, 1.0)
    span, effort = (Span(0, 3, 1), "quick") if is_judged else (Span(0, 0, 1), "")
    state = np.zeros(2 * orbits.size)
    follow_host(orbits, state, span, tell, orbits.records(has_records, ()), effort)


def energies_of(records: HostRecords, system: General) -> tuple[float, np.ndarray]:
    """Return the largest energy of the host and of each damper's mass, 0 without one [J]."""
    largest = iter(records.peaks.tolist())
    host = next(largest)
    return host, np.array([0.0 if damper.m is None else next(largest) for damper in system.dampers])


def response_of(
    orbits: HostOrbits, records: HostRecords, impacts: Impacts, duration: float
) -> np.ndarray:
    """Return the quantities `of_rows` of each displacement, duration: of the records [s]."""
    rows = len(records.squares)
    count = len(records.grounds) - rows
    largest = records.peaks[len(records.peaks) - len(records.grounds) :]
    rms = np.sqrt(records.squares / duration) if duration > 0 else np.full(rows, np.nan)
    a = np.where(orbits.is_struck(records, impacts), np.inf, largest[rows:])
    columns = [largest[:count], rms[:count], a]
    if rows > count:
        columns += [largest[count:rows], rms[count:]]
    return np.stack(columns, axis=-1)


def largest_impulses(orbits: HostOrbits, impacts: Impacts) -> np.ndarray:
    """Return the largest impulse [N s] at the rigid walls of each damper, NaN without one."""
    largest = np.full(len(orbits.system.dampers), np.nan)
    for wall, link in enumerate(orbits.walls.links):
        if LAWS_IN_KERNELS[orbits.walls.law[wall]] == "restitution":
            largest[link] = np.fmax(largest[link], impacts.hardest[wall])
    return largest


_JUDGE: Any = getattr(judge_host, "entry", judge_host)
_RUN: Any = getattr(run_host, "entry", run_host)


@lru_cache(maxsize=1)
def _constants_of_cells() -> CellConstants:
    return cell_constants()


@lru_cache(maxsize=16)  # as cells of a scan have one host
def _modes_of(host: Host) -> tuple[np.ndarray, ...]:
    """Return a host's modes as kernels take them, in arrays that nobody writes into.

    They are the squares of the frequencies, the modes, the damping of each mode, and that by other
    modes, an empty array under modal damping.
    """
    n = len(host.inertia)
    squares, modes = np.zeros(n), np.zeros((n, n))
    # a read-only array would be another type, for which the kernel would be compiled again
    fill_modes(host.M.copy(order="K"), host.K.copy(order="K"), squares, modes)
    if host.ratio is not None:
        return squares, modes, modal_damping(host.ratio, squares), np.zeros(0)
    damping = _times(_times(modes.T, np.asarray(host.C)), modes)
    own = np.diag(damping).copy()
    coupling = damping - np.diag(own)
    # modal damping is that of modes, but for round-off
    is_modal = np.abs(coupling).max() <= 1e-12 * max(np.abs(own).max(), 1e-300)
    return squares, modes, own, np.zeros(0) if is_modal else coupling.T.ravel().copy()


def _sum(values: np.ndarray) -> float:
    """Return a sum in one order, so that bits are the same."""
    return float(_times(values[None], np.ones((len(values), 1)))[0, 0])


def _times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product of two matrices; each sum in one order, so that bits are the same."""
    total = np.zeros((*a.shape[:-1], b.shape[1]))
    for k in range(len(b)):
        total += a[..., k, None] * b[k]
    return total
