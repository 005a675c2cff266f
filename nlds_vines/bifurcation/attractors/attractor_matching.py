"""The periodic attractors of a system, and orbits that are followed until they belong to one.

An attractor is a closed stable orbit, not a label: two T,1 may coexist.  Whether two orbits found
are the same is seen by following one until it belongs to the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from nlds_vines.kernels.cells import cycles as basins
from nlds_vines.kernels.cells.cycles import Known
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.kernels.scene.codes import PERIODIC, TRANSIENT_CHAOS
from nlds_vines.kernels.scene.scene import Parts
from nlds_vines.orbits.batch import on_threads, records_of

DIRECTIONS = 48
"""Deviations that are followed to see whether a sphere around an attractor comes nearer."""

SPHERES = 3
"""Spheres in a row, each of half the radius of the one before, that must come nearer."""

HALVINGS = 20
"""Most halvings of a region: a smaller one saves no periods."""

SAME = 256
"""Forcing periods within which an orbit that begins on an attractor must belong to it."""

MOST_PERIODS = 64
"""Periods of an orbit around which a region is looked for; of longer ones it is the least."""


@dataclass(frozen=True, eq=False)
class Attractor:
    """A closed stable orbit, with the region in which orbits are known to be drawn to it.

    Attributes:
        cell: the kernels' record of its system; None in a row without an orbit.
        periods: n of nT.
        point: (4,) of its section, x1, v1, r, s.
        matrix: (16,) its monodromy matrix, column by column.
        form: (16,) the matrix P of lengths sqrt(d' P d); rate: by which the matrix shortens these.
        span: the length of the point, of which a region is a part.
        radius: of the region.  The least is what round-off hides: there, the matrix is enough.
        row: (COLUMNS,) the evidence of the verdict that has found it.
    """

    cell: np.record | None
    periods: int
    point: np.ndarray
    matrix: np.ndarray
    form: np.ndarray
    rate: float
    span: float
    radius: float
    row: np.ndarray


def attractor_of(parts: Parts, cell: np.record, evidence: np.ndarray, size: int) -> Attractor:
    """Return the attractor that a verdict has found, with its region.

    Arguments: the `parts` and the `cell` of the kernels; `evidence` (COLUMNS,) of a periodic orbit,
    see `kernels.evidence_rows`; the `size` of a state, 4 or 2.

    Cost: some hundred orbits of n periods for each size of region that is tried.
    """
    matrix = evidence[ev.MONODROMY : ev.MONODROMY + 16].copy()
    radius = float(evidence[ev.RADIUS])
    rate = 0.5 * (1.0 + radius)
    form = form_of(matrix, _weights(cell, size), rate)
    point = evidence[ev.POINT : ev.POINT + 4].copy()
    span = max(_length(form, point), float(np.sqrt(np.diag(form.reshape(4, 4)).max())) * 1e-12)
    least = basins.TINY * span
    periods, row = int(evidence[ev.CYCLE_PERIOD]), evidence.copy()
    found = Attractor(cell, periods, point, matrix, form, rate, span, least, row)
    return _with_region(parts, found, size)


def is_periodic(evidence: np.ndarray) -> np.ndarray:
    """Tell which verdicts (..., COLUMNS) end on a periodic orbit, after chaos or not."""
    return (evidence[..., ev.KIND] == PERIODIC) | (evidence[..., ev.KIND] == TRANSIENT_CHAOS)


def form_of(matrix: np.ndarray, weights: Sequence[float], rate: float) -> np.ndarray:
    """Return the symmetric P (16,) by whose lengths a matrix M shortens by `rate` at least.

    P = sum over k of (M' / rate)^k W (M / rate)^k, W the diagonal matrix of the weights, so that
    M' P M = rate^2 (P - W).  The sum is doubled until it stands (Smith 1968).

    Arguments: `matrix` (16,), column by column; `weights` (4,), 0 for numbers that do not exist;
    `rate`, between the largest modulus of M's multipliers and 1.
    """
    a = [[float(matrix[4 * j + i]) / rate for j in range(4)] for i in range(4)]
    p = [[weights[i] if i == j else 0.0 for j in range(4)] for i in range(4)]
    for _ in range(64):
        more = _product(_product(_turned(a), p), a)
        p = [[p[i][j] + 0.5 * (more[i][j] + more[j][i]) for j in range(4)] for i in range(4)]
        if all(abs(more[i][i]) <= 1e-16 * p[i][i] for i in range(4)):
            break
        a = _product(a, a)
    return np.array(list(chain.from_iterable(p)))


def known_of(attractors: Iterable[Attractor | None]) -> Known:
    """Return what kernels take of attractors, in their order; of None a row without a region."""
    rows = [_NONE if attractor is None else attractor for attractor in attractors]
    return Known(
        periods=np.array([row.periods for row in rows], dtype=np.int64),
        points=np.array([row.point for row in rows], float).reshape(-1, 4),
        matrices=np.array([row.matrix for row in rows], float).reshape(-1, 16),
        forms=np.array([row.form for row in rows], float).reshape(-1, 16),
        radii=np.array([row.radius for row in rows], float),
        rates=np.array([row.rate for row in rows], float),
        spans=np.array([row.span for row in rows], float),
    )


def follow(
    parts: Parts, cells: np.ndarray, starts: np.ndarray, rows: np.ndarray, known: Known, most: int
) -> basins.Drawn:
    """Follow orbits until they belong to a known attractor of their system.

    Arguments: the kernels' `parts`; `cells` (orbits,); `starts` (orbits, 4), x1, v1, r, s at phase
    zero; `rows` (orbits, 2), the first row of `known` that counts, and the one after the last; at
    `most` so many forcing periods.

    Each orbit is on its own: neither threads nor the other orbits change a bit of it.
    """
    count = len(cells)
    drawn = basins.Drawn(*(np.empty(count, np.int64) for _ in range(3)))
    arguments = (
        parts, records_of(cells), np.ascontiguousarray(starts),
        (np.ascontiguousarray(rows), known, most), drawn,
    )  # fmt: skip
    on_threads(basins.follow_to_known, arguments, count, 16)
    return drawn


def attractors_in(
    parts: Parts, cell: np.record, evidence: np.ndarray, known: Iterable[Attractor] = ()
) -> list[Attractor]:
    """Return the different periodic attractors of one system that verdicts have found.

    Arguments: the kernels' `parts` and `cell` of the system; `evidence` (orbits, COLUMNS); those
    that are `known` already, which come first.

    Two are different where an orbit from the point of one does not come to the other.
    """
    found, size = list(known), 4 if parts.damper is True else 2
    alone, left = np.array([cell]).view(np.recarray), evidence[is_periodic(evidence)]
    if found:
        left = left[~_belong(parts, alone, left, found)]
    while len(left):
        found.append(attractor_of(parts, alone[0], left[0], size))
        left = left[1:]
        left = left[~_belong(parts, alone, left, found[-1:])]
    return found


def _belong(
    parts: Parts, alone: np.recarray, evidence: np.ndarray, known: Sequence[Attractor]
) -> np.ndarray:
    """Tell of which orbits (n,) the points belong to known attractors of a system that is alone."""
    points, rows = (
        evidence[:, ev.POINT : ev.POINT + 4],
        np.tile([0, len(known)], (len(evidence), 1)),
    )
    cells = np.repeat(alone, len(evidence))
    return follow(parts, cells, points, rows, known_of(known), SAME).attractor >= 0


def _with_region(parts: Parts, found: Attractor, size: int) -> Attractor:
    """Return the attractor with the largest region whose spheres all come nearer."""
    if found.periods > MOST_PERIODS:
        return found
    directions, known = _directions(found.form, size), known_of([found])
    held, radius = 0, found.span
    for _ in range(HALVINGS):
        nearer = basins.approaches(parts, found.cell, known, 0, directions, radius)
        held = held + 1 if nearer else 0
        if held == SPHERES:
            return replace(found, radius=radius * 2 ** (SPHERES - 1))
        radius *= 0.5
    return found


def _directions(form: np.ndarray, size: int) -> np.ndarray:
    """Return deviations (DIRECTIONS, 4) of length 1, the same from run to run."""
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (DIRECTIONS, 4))
    drawn[:, size:] = 0.0
    return np.array([row / _length(form, row) for row in drawn])


def _weights(cell: np.record, size: int) -> list[float]:
    """Return by what the squares of x1, v1, r and s count: as in an energy [J]."""
    structure = [max(float(cell.k1), float(cell.m1) * float(cell.omega) ** 2), float(cell.m1)]
    if size == 2:
        return [*structure, 0.0, 0.0]
    return [
        *structure,
        max(float(cell.k2), float(cell.m2) * float(cell.omega) ** 2),
        float(cell.m2),
    ]


_NONE = Attractor(
    None,
    0,
    np.zeros(4),
    np.zeros(16),
    np.zeros(16),
    0.0,
    0.0,
    -1.0,
    np.full(ev.LENGTH_OF_ROW, np.nan),
)
"""In the place of an attractor that is not periodic: nothing is in its region."""


def _length(form: np.ndarray, d: np.ndarray) -> float:
    return float(basins.norm_of(form, d))


def _product(a: list[list[float]], b: list[list[float]]) -> list[list[float]]:
    """Return the product of two matrices, summed in the same order on every processor."""
    rows = range(4)
    products = [[[a[i][k] * b[k][j] for k in rows] for j in rows] for i in rows]
    return [[((p[0] + p[1]) + p[2]) + p[3] for p in row] for row in products]


def _turned(a: list[list[float]]) -> list[list[float]]:
    """Return the transposed matrix."""
    return [list(row) for row in zip(*a, strict=True)]
