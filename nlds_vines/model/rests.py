"""Positions in which a system with nonlinear springs can rest, and which of them are stable.

At rest a damper's mass pulls at nothing, so that its r is a root of its own spring's force,
whatever the structure is.  A spring between two degrees of freedom deforms the structure, whose
stiffness against that stroke adds to k.  Only +, -, *, / of single numbers are used: starts at rest
have the same bits everywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from math import inf, prod
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nlds_vines.errors import RequestError
from nlds_vines.model.parameters import LAWS, SIDES
from nlds_vines.model.signals import wall_force

if TYPE_CHECKING:
    from collections.abc import Mapping

    from nlds_vines.model.dampers import Damper, Wall

MOST_RESTS = 10_000  # of one system: three of each of eight bistable dampers are 6,561
_STEPS = 512  # in which the forces beyond a wall are searched for changes of sign
_PIVOT = 1e-12  # of the largest number of a matrix: a smaller pivot is round-off, of a free mode


@dataclass(frozen=True, eq=False)
class Rest:
    """A state in which a system stays if no force acts on it.

    Attributes
    ----------
    strokes : mapping of str to float
        The displacement r [m] of each damper along its spring, by its name.
    is_stable : bool
        Whether the potential energy has a local minimum there, a well.
    state : tuple of float
        The components of the state.
    """

    strokes: Mapping[str, float]
    is_stable: bool
    state: tuple[float, ...]


class RestOfDamper(NamedTuple):
    """A position r [m] of one damper at rest, and whether it is stable."""

    r: float
    is_stable: bool


def rests_of(system: Any) -> tuple[Rest, ...]:
    """Return all rests of a system, in ascending order of r of the first damper, then the others.

    Raises `RequestError` if more than one spring between degrees of freedom is nonlinear, and for
    more than `MOST_RESTS`.
    """
    _refuse_coupled(system)
    places = [_places_of(system, i) for i in range(len(system.dampers))]
    count = prod(len(choices) for choices in places)
    if count > MOST_RESTS:
        raise RequestError(f"the system has {count} rests; allowed: {MOST_RESTS}")
    rests = []
    for choice in product(*places):
        strokes = [place.r for place in choice]
        names = dict(zip(system.damper_names, strokes, strict=True))
        is_stable = all(place.is_stable for place in choice)
        rests.append(Rest(names, is_stable, _state_of(system, strokes)))
    return tuple(rests)


def usual_strokes(system: Any) -> tuple[float, ...]:
    """Return the r [m] of each damper in the start "rest": 0 where that is stable.

    Otherwise it is the well nearest to 0 with r > 0, and if there is none the nearest one below.
    """
    strokes = []
    for i, damper in enumerate(system.dampers):
        if _is_well_at_zero(damper):
            strokes.append(0.0)
            continue
        _refuse_coupled(system)
        wells = [place.r for place in _places_of(system, i) if place.is_stable]
        above = [r for r in wells if r >= 0.0]
        strokes.append(min(above) if above else max(wells))
    return tuple(strokes)


def state_of_rest(system: Any) -> tuple[float, ...]:
    """Return the components of the start "rest"; see `usual_strokes`."""
    return _state_of(system, usual_strokes(system))


def _is_well_at_zero(damper: Damper) -> bool:
    """Return True if a damper is stable at r = 0 whatever the structure is.

    Without a nonlinear spring it is at r = 0 by convention, even if a wall is preloaded.
    """
    if damper.spring is None:
        return True
    if any(wall.gap < 0.0 for wall in damper.walls):
        return False
    if damper.k != 0.0:
        return damper.k > 0.0
    return damper.spring.k2 == 0.0 and damper.spring.k3 >= 0.0


def _refuse_coupled(system: Any) -> None:
    links = [damper.name for damper in system.dampers if damper.m is None and damper.spring]
    if len(links) > 1:
        raise RequestError(
            f"{' and '.join(links)} are nonlinear springs between degrees of freedom, and what one "
            "does at rest depends on the others: the rests of several are not computed. Give a "
            "start"
        )


# ---- one damper ----------------------------------------------------------------------------------


def _places_of(system: Any, number: int) -> list[RestOfDamper]:
    """Return the places of rest of one damper, in ascending order of r."""
    damper = system.dampers[number]
    if damper.spring is None:
        return [RestOfDamper(0.0, is_stable=True)]
    stiffness = damper.k
    if damper.m is None:
        stiffness += _stiffness_along(system, number)
    k2, k3, k5 = damper.coefficients
    coefficients = (0.0, stiffness, k2, k3, 0.0, k5)
    if not any(coefficients):
        return [RestOfDamper(0.0, is_stable=True)]

    def spring_force(r: float) -> float:
        square = r * r
        return r * stiffness + square * (k2 + r * (k3 + square * k5))

    def force(r: float) -> float:
        """Return the force [N] against r of spring and walls; infinite inside a rigid wall."""
        total = spring_force(r)
        for wall in damper.walls:
            total += _force_of_wall(wall, r)
        return total

    every = real_roots(coefficients)
    positions = []
    for r in every:
        if all(SIDES[wall.side] * r <= wall.gap for wall in damper.walls):
            positions.append(r)
    for wall in damper.walls:
        positions += _pressed(wall, every, spring_force, force)
    positions.sort()
    places = []
    for i, r in enumerate(positions):
        below = 0.5 * (positions[i - 1] + r) if i > 0 else r - 1.0 - abs(r)
        above = 0.5 * (r + positions[i + 1]) if i + 1 < len(positions) else r + 1.0 + abs(r)
        places.append(RestOfDamper(r, is_stable=force(below) < 0.0 < force(above)))
    return places


def _force_of_wall(wall: Wall, r: float) -> float:
    """Return the force [N] of a wall against r; infinite inside a rigid one."""
    sign = SIDES[wall.side]
    law = LAWS[wall.law]
    if sign * r <= wall.gap:
        return 0.0
    if law.instant:
        return sign * inf
    strokes = np.array([r])
    return float(wall_force(law, wall.constants, (sign, wall.gap), strokes, np.zeros(1))[0])


def _pressed(
    wall: Wall,
    roots: Sequence[float],
    spring_force: Callable[[float], float],
    force: Callable[[float], float],
) -> list[float]:
    """Return the places where a spring, whose force has `roots`, presses a damper on a wall."""
    sign = SIDES[wall.side]
    edge = sign * wall.gap
    if LAWS[wall.law].instant:
        return [edge] if sign * spring_force(edge) < 0.0 else []
    farthest = max(sign * r for r in roots)
    if farthest <= wall.gap:
        return []
    # beyond the last root both forces push back
    places = []
    length = farthest - wall.gap
    before = edge
    for step in range(1, _STEPS + 1):
        after = sign * (wall.gap + length * (step / _STEPS))
        if force(before) * force(after) < 0.0:
            low, high = min(before, after), max(before, after)
            places.append(_bisected(force, low, high))
        before = after
    return places


def real_roots(coefficients: Sequence[float]) -> list[float]:
    """Return the real roots, ascending, of the sum of coefficients[j] r^j, to the last bit.

    Between two roots of its derivative a polynomial is monotonic, and bisected if its sign changes.
    """
    coefficients = list(coefficients)
    while coefficients and coefficients[-1] == 0.0:
        coefficients.pop()
    if coefficients and coefficients[0] == 0.0:  # then 0 is a root, exactly
        return sorted({0.0, *real_roots(coefficients[1:])})
    degree = len(coefficients) - 1
    if degree < 1:
        return []
    lead = abs(coefficients[-1])
    bound = 1.0 + max(abs(value) / lead for value in coefficients[:-1])
    derivative = [j * coefficients[j] for j in range(1, degree + 1)]

    def value(r: float) -> float:
        total = 0.0
        for coefficient in reversed(coefficients):
            total = total * r + coefficient
        return total

    turns = [-bound, *real_roots(derivative), bound]
    roots = [r for r in turns if value(r) == 0.0]
    for low, high in pairwise(turns):
        if value(low) * value(high) < 0.0:
            roots.append(_bisected(value, low, high))
    return sorted(set(roots))


def _bisected(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where the sign of a function changes between two places, to the last bit."""
    rises = function(low) < 0.0
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return middle
        value = function(middle)
        if value == 0.0:
            return middle
        if (value < 0.0) == rises:
            low = middle
        else:
            high = middle


# ---- the structure -------------------------------------------------------------------------------


def _state_of(system: Any, strokes: Sequence[float]) -> tuple[float, ...]:
    """Return the components of the state at rest in which dampers have these r [m]."""
    count = len(system.host.inertia)
    places = np.zeros(count + len(system.masses))
    for number, r in enumerate(strokes):
        if r == 0.0:
            continue
        damper = system.dampers[number]
        if damper.m is None:
            places[:count] += r * _shape_along(system, number)
        else:
            places[count + number] = -r  # its degree of freedom is at 0
    for number, damper in enumerate(system.masses):
        row = system.host.row(damper.places[0])
        for weight, place in zip(row.tolist(), places[:count].tolist(), strict=True):
            places[count + number] += weight * place
    state = np.zeros(2 * len(places))
    state[::2] = places
    return tuple(state.tolist())


def _stiffness_of_others(system: Any) -> np.ndarray:
    """Return the stiffness matrix of the structure with its linear springs without a mass."""
    count = len(system.host.inertia)
    of_host = system.host.K
    matrix = np.array(of_host if isinstance(of_host, np.ndarray) else of_host.toarray())
    for damper, row in zip(system.dampers, system.rows(), strict=True):
        if damper.m is None and damper.spring is None:
            matrix += damper.k * row[:count, np.newaxis] * row[np.newaxis, :count]
    return matrix


def _shape_along(system: Any, number: int) -> np.ndarray:
    """Return the displacements of the structure whose stroke is held at r = 1 by its damper.

    They minimize the elastic energy x K x / 2 under w x = 1.
    """
    count = len(system.host.inertia)
    row = system.rows()[number, :count]
    matrix = np.zeros((count + 1, count + 1))
    matrix[:count, :count] = _stiffness_of_others(system)
    # of the size of the stiffness, so that one pivot serves all
    scale = float(np.abs(matrix).max()) or 1.0
    matrix[:count, count] = scale * row
    matrix[count, :count] = scale * row
    right = np.zeros(count + 1)
    right[count] = scale
    return _solved(matrix, right)[:count]


def _stiffness_along(system: Any, number: int) -> float:
    """Return the stiffness [N/m] of the structure against the stroke of a damper without a mass."""
    shape = _shape_along(system, number).tolist()
    stiffnesses = _stiffness_of_others(system)
    total = 0.0
    for i, row in enumerate(stiffnesses.tolist()):
        for j, stiffness in enumerate(row):
            total += shape[i] * stiffness * shape[j]
    # of a structure that is free to move along, round-off alone
    size = max(abs(x) for x in shape) ** 2 * float(np.abs(stiffnesses).max())
    return total if abs(total) > _PIVOT * size else 0.0


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return x of matrix x = right by elimination; 0 for unknowns that nothing determines."""
    size = len(right)
    table = np.column_stack([matrix, right])
    floor = _PIVOT * float(np.abs(matrix).max(initial=0.0))
    rows_of_unknowns: dict[int, int] = {}
    used = 0
    for column in range(size):
        candidates = np.abs(table[used:, column])
        best = used + int(np.argmax(candidates)) if used < size else used
        if used == size or abs(table[best, column]) <= floor:
            continue
        table[[used, best]] = table[[best, used]]
        table[used] = table[used] / table[used, column]
        for other in range(size):
            if other != used:
                table[other] = table[other] - table[other, column] * table[used]
        rows_of_unknowns[column] = used
        used += 1
    solution = np.zeros(size)
    for column, row in rows_of_unknowns.items():
        solution[column] = table[row, size]
    return solution
