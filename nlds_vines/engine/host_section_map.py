"""The n-fold stroboscopic map of a host with free parameters, and its derivatives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nlds_vines.engine.batch import room_for
from nlds_vines.engine.compilation import Compilation, Needed
from nlds_vines.engine.host_orbits import HostOrbits, energies_of, rows_of
from nlds_vines.engine.section_map import WEIGHTS, Cycle, SectionMap, bordered
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.errors import RequestError
from nlds_vines.kernels.cells import cycles
from nlds_vines.kernels.cells.host_cycles import trace_host
from nlds_vines.kernels.hosts.host_contact import OF_LARGEST, OF_SPEED, OF_TOUCH, OF_WALL
from nlds_vines.kernels.hosts.host_orbit import run_host
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.kernels.scene.scene import Span
from nlds_vines.model.labels import name_of
from nlds_vines.model.system import General
from nlds_vines.runs.progress import Tell

# Difference steps, relative to the parameter: the first one, the factor by which it is shortened,
# and the shortest; the largest difference of formulas of order four and two, relative to the
# derivative, at which a step is short enough; and the weights of that of order two.
FIRST, SHORTER, SHORTEST = 2.0**-14, 0.125, 1.0e-9
AGREEING, COARSE = 1.0e-3, (-1.5, 2.0, -0.5)
ROUND_OFF = 1.0e-11  # error of an image, relative to the orbit


class HostSectionMap(SectionMap):
    """The n-fold stroboscopic map of a host, in the coordinates of its modes.

    Derivatives with respect to the state are variations.  Those with respect to parameters are
    one-sided differences of order four of orbits with equal impacts, with steps that shrink until
    differences of order two agree; against derivatives of kinds they are exact to some 1e-8 of the
    largest number (`tests/continuation/test_branches_of_hosts.py`).  Newton's method needs no more,
    and no residual depends on them.
    """

    def __init__(
        self,
        system: General,
        names: tuple[str, ...],
        settings: Settings | None = None,
        lengths: Sequence[float] = (),
    ) -> None:
        """Prepare the map; `lengths` are units of the free parameters, as of their intervals."""
        self.system, self.names = system.with_axes(names), names
        self.scene = self.system.scene
        self.size = len(self.scene.components)
        self.since = 0.0
        walls = [wall for damper in self.system.dampers for wall in damper.walls]
        self.is_rigid = any(wall.law == "restitution" for wall in walls)
        self._lengths = tuple(lengths) or (0.0,) * len(names)
        self._tolerance = float((settings or Settings.of("exact")).stepped_to)
        self._own = HostOrbits(self.system, self._tolerance)
        self.of_gap = self._own.body.modes % self._own.body.size  # the first mass, if there is one

    def orbits(self, values: np.ndarray, turns: float = 1.0) -> HostOrbits | None:
        """Return the orbits of the map, which begin at its phase; None if values are not allowed.

        A period of theirs is `turns` of the force's.
        """
        try:
            there = self.system.with_values(self.names, values.tolist())
            orbits = HostOrbits(there, self._tolerance)
        except RequestError:  # of two parameters, of which each is allowed
            return None
        body = orbits.body
        orbits.body = body._replace(period=turns * body.period, begun=self.since % 1.0, turns=turns)
        return orbits

    def compile(self, tell: Tell | None) -> None:
        size, count = self.size, self._own.walls.number
        compilation = Compilation(Needed("a host", "exact", ()), tell, helped=False)
        kernels = (trace_host, run_host, cycles.solve_bordered)
        with compilation.followed(dict.fromkeys(kernels, "branches")):
            body, walls, room = self._own.body, self._own.walls, self._own.contacts()
            traced = room_for(0, size, 0, size, count)
            trace_host(body, walls, room, np.zeros(size), traced, np.zeros(size + 1))
            self._own.follow(np.zeros(size), Span(0, 0, 1), self._own.records(True, ()))
            self._own.follow(np.zeros(size), Span(0, 0, 1))
            bordered(np.eye(size), np.zeros((1, size)), np.ones((1, size + 1)), np.zeros(size + 1))

    def at(self, place: np.ndarray, n: int) -> Cycle | None:
        size, values = self.size, place[self.size :]
        orbits = self.orbits(values) if self.accepts(values) else None
        if orbits is None:
            return None
        state, norms = place[:size].copy(), np.zeros(size + 1)
        traced = room_for(n, size, 0, size, orbits.walls.number)
        code = trace_host(orbits.body, orbits.walls, orbits.contacts(), state, traced, norms)
        if code != OK:
            return None
        defect, span, clearance, slowest, _ = traced.numbers.tolist()
        counts, pairs = tuple(traced.counts.tolist()), traced.multipliers
        cycle = Cycle(
            state=state, values=values.copy(), points=traced.points, counts=counts,
            matrix=traced.matrix, slopes=np.zeros((len(values), size)),
            multipliers=pairs[:, 0] + 1j * pairs[:, 1], defect=defect, span=span,
            clearance=clearance, slowest=slowest, volume=np.nan, norms=norms[:-1],
            shares=self._shares(counts), nearest=int(norms[-1]) if clearance < np.inf else 0,
            since=self.since,
        )  # fmt: skip
        for i in range(len(values)):
            cycle.slopes[i] = self._slope(cycle, i)
        return cycle

    def _shares(self, counts: Sequence[int]) -> tuple[int, ...]:
        """Return the impacts by damper; () of a single one."""
        owners, names = self.scene.of_walls, self.scene.dampers
        pairs = [*zip(owners, counts, strict=True)]
        return tuple(sum(k for (owner, _), k in pairs if owner == name) for name in names)

    def _slope(self, cycle: Cycle, i: int) -> np.ndarray:
        """Return the derivative (size,) of the image by free parameter i."""
        images, best, least = [cycle.points[-1]], np.full(self.size, np.nan), np.inf
        unit = max(abs(float(cycle.values[i])), self._lengths[i])
        step = FIRST * unit
        while step >= SHORTEST * unit:
            side = step
            images[1:] = self._images(cycle, i, side)
            if len(images) < len(WEIGHTS):
                side = -step
                images[1:] = self._images(cycle, i, side)
            if len(images) == len(WEIGHTS):
                fine, coarse = (_combined(weights, images) / side for weights in (WEIGHTS, COARSE))
                size = (cycle.norms * np.abs(fine)).max()
                error = (cycle.norms * np.abs(fine - coarse)).max()
                if error <= max(AGREEING * size, ROUND_OFF * cycle.span / step):
                    return fine
                if error < least * size:
                    best, least = fine, error / size
            step *= SHORTER
        return best

    def _images(self, cycle: Cycle, i: int, step: float) -> list[np.ndarray]:
        """Return the images at one to four steps of a parameter, up to one with other impacts."""
        images = []
        for k in range(1, len(WEIGHTS)):
            values, state = cycle.values.copy(), cycle.state.copy()
            values[i] += k * step
            orbits = self.orbits(values) if self.accepts(values) else None
            if orbits is None:
                break
            code, _, impacts = orbits.follow(state, Span(0, cycle.n, 1))
            if code != OK or tuple(impacts.counts.tolist()) != cycle.counts:
                break
            images.append(state)
        return images

    def later(self, place: np.ndarray, time: float) -> np.ndarray | None:
        state = place[: self.size].copy()
        for periods, turns in ((int(time), 1.0), (1, time % 1.0)):
            orbits = self.orbits(place[self.size :], turns) if periods and turns else None
            if orbits and orbits.follow(state, Span(0, periods, 1))[0] != OK:
                return None
        return np.concatenate([state, place[self.size :]])

    def impacts(self, place: np.ndarray, n: int) -> np.ndarray:
        orbits, state = self.shot(0.0).orbits(place[self.size :]), place[: self.size].copy()
        assert orbits is not None
        _, _, impacts = orbits.follow(state, Span(0, n, 1))
        rows = rows_of(impacts)[:, : OF_SPEED + 1].copy()
        rows[:, OF_TOUCH:OF_SPEED] /= orbits.body.period
        return rows

    def measure(
        self, places: np.ndarray, periods: np.ndarray, touches: np.ndarray | None = None
    ) -> cycles.Extremes:
        dampers, zero = max(1, len(self.system.dampers)), self.shot(0.0)
        energy, strokes = np.zeros((len(places), 1 + dampers)), np.zeros((len(places), 2))
        for i, (place, n) in enumerate(zip(places, periods.tolist(), strict=True)):
            orbits, state = zero.orbits(place[self.size :]), place[: self.size].copy()
            assert orbits is not None
            watched = orbits.records(True, ())
            assert watched is not None
            _, _, impacts = orbits.follow(state, Span(0, n, 1), watched, has_depths=True)
            rows = rows_of(impacts)
            if np.isnan(rows).any():  # a contact under way at phase zero ends in the next period
                state = place[: self.size].copy()
                _, _, impacts = orbits.follow(state, Span(0, n + 1, 1), has_depths=True)
                rows = rows_of(impacts)
                rows = rows[rows[:, OF_TOUCH] < n * orbits.body.period]
            E1, E2 = energies_of(watched, orbits.system)
            energy[i, 0], energy[i, 1 : 1 + len(E2)] = E1, E2
            strokes[i] = rows[:, [OF_SPEED, OF_LARGEST]].max(axis=0, initial=0.0)
        return cycles.Extremes(energy, strokes, None, np.empty((len(places), 0, 4)))

    def grazing_walls(self, cycle: Cycle, name: str) -> tuple[int, ...]:
        if name == "clearance":
            wall = cycle.nearest
        else:
            place = self.later(cycle.place, -self.since % cycle.n)
            rows = np.empty((0, 4)) if place is None else self.impacts(place, cycle.n)
            if not len(rows):
                return ()
            wall = int(rows[rows[:, OF_SPEED].argmin(), OF_WALL])
        # at both walls of a damper, if the orbit is its own mirror image n/2 periods later
        owner = self.scene.of_walls[wall][0]
        pair = tuple(i for i, (name, _) in enumerate(self.scene.of_walls) if name == owner)
        gaps = {self._own.walls.gaps[i] for i in pair}
        if len(pair) < 2 or cycle.n % 2 == 0 or len(gaps) > 1:
            return (wall,)
        return pair if self.comes_to(cycle, -cycle.state) else (wall,)

    def label_beyond(self, cycle: Cycle, walls: Sequence[int], change: int) -> str:
        counts = list(cycle.counts)
        for wall in walls:
            counts[wall] += change
        return name_of(cycle.n, sum(counts), *self._shares(counts))

    def place_of(self, value: float, state: Sequence[float]) -> np.ndarray:
        return np.append(self._own.start(state, is_put_on_walls=True), value)

    def states_of(self, places: np.ndarray) -> np.ndarray:
        return self._own.states(places[:, : self.size])


def _combined(weights: Sequence[float], images: Sequence[np.ndarray]) -> np.ndarray:
    """Return the weighted sum of images, in one order, so that bits are the same."""
    total = np.zeros_like(images[0])
    for weight, image in zip(weights, images, strict=False):
        total += weight * image
    return total
