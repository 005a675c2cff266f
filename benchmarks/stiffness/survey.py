"""The survey of stiffness: error, cost, touches and the way to the rigid limit, as K grows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np

from benchmarks.rivals.rival import Course as RivalCourse
from benchmarks.rivals.rival import Rival, contenders_of
from benchmarks.stiffness.rigid import Rigid
from benchmarks.stiffness.table import COLUMNS, SHAPE, Stiffened
from nlds_vines.accuracy.measure import Contender, measured, ours
from nlds_vines.accuracy.measured_cases import Case, Course, Known, Result
from nlds_vines.accuracy.reference import Truth, truth_of
from nlds_vines.archives.record_columns import Row, row_of
from nlds_vines.errors import RequestError
from nlds_vines.kernels.impact import arc_table, impact
from nlds_vines.kernels.laws.hertz import hertz_wall_at
from nlds_vines.kernels.motion.bounds import rate_of
from nlds_vines.kernels.scene.scene import damper_in, structure_of
from nlds_vines.model.system import System
from nlds_vines.orbits.kernel_inputs import cell_of, parts_of
from nlds_vines.orbits.simulation import SAMPLES, simulate
from nlds_vines.orbits.solver_settings import PERIOD_STEPS, TOLERANCE, Settings
from nlds_vines.runs.survey import Survey, Task

MODULI = (2e5, 2e6, 2.05e7, 2e8, 2e9, 2.1e10, 2.1e11, 2.1e12, 2.1e13)
"""Young's moduli E2 of the damper's side [Pa]: soft rubber, rubber, ..., steel, beyond."""

STIFFNESSES = tuple(10.0**k for k in range(4, 17))
"""Contact stiffnesses K [N/m^1.5] given directly, to beyond any material."""

RTOL = 1e-8
"""Tolerance of the solvers of others, or the nearest of theirs."""


def stiffness(system: System, periods: int, rivals: Sequence[Rival] = ()) -> Survey:
    """Return the survey of a system whose contact is made softer and harder, from rest.

    Measured are our methods and `rivals`, which are installed.
    """
    cases = list(_cases(system, periods))
    about = {
        "cases": {case.name: case.to_table() for case in cases},
        "peers": {rival.name: rival.version() or "-" for rival in rivals},
    }
    rigid = cache(partial(_rigid_state, cases[0]))
    tasks = tuple(Task(case.name, partial(_rows, case, rigid, rivals)) for case in cases)
    title = f"Stiff contacts: {system.title or system.name}"
    return Survey(title, SHAPE, about, COLUMNS, tasks)


def _cases(system: System, periods: int) -> Iterator[Case]:
    for E2 in MODULI if "E2" in system.parameters else ():  # K itself may be given in its place
        yield Case(f"E2 = {E2:.3g}", system.with_(E2=E2), system.title, periods=periods)
    for K in STIFFNESSES:
        yield Case(f"K = {K:.0e}", system.with_(K=K), system.title, periods=periods)


def _rigid_state(case: Case) -> np.ndarray:
    """Return the state at the end with rigid walls, NaN where impacts accumulate."""
    try:
        return Rigid(case).state()
    except RequestError:
        return np.full(4, math.nan)


def _rows(case: Case, rigid: Callable[[], np.ndarray], rivals: Sequence[Rival]) -> list[Row]:
    """Measure every method on one stiffness; where there is no reference all fail."""
    contenders, E2 = list(_methods(rivals)), case.system.parameters.get("E2", math.nan)
    try:
        truth = truth_of(case)
    except RequestError as error:
        unknown = Known("", "", "", case.periods, "", math.nan, math.nan, "", math.nan)
        stiffened = Stiffened(case.system.K, E2, 0, math.nan)
        failed = (Result(entry.setting, failure=str(error)) for entry in contenders)
        return [row_of(stiffened, unknown, found.setting, found) for found in failed]
    touches = 0 if truth.touches is None else len(truth.touches)
    distance = float(np.abs(truth.section[-1] - rigid()).max())
    rows = []
    for contender in contenders:
        found, taken = _measured(truth, contender)
        stiffened = Stiffened(case.system.K, E2, touches, distance, taken)
        rows.append(row_of(stiffened, truth.known, found.setting, found))
    return rows


def _measured(truth: Truth, contender: Contender) -> tuple[Result, float]:
    """Return what is found of a contender, and the steps of a contact: set, or counted."""
    counted = []

    def follow(case: Case, observed: bool) -> Course:
        course = contender.follow(case, observed)
        if isinstance(course, RivalCourse) and course.steps_in_contact is not None:
            counted.append(course.steps_in_contact)
        return course

    found, taken = measured(truth, replace(contender, follow=follow)), steps(truth.case, contender)
    return found, counted[0] if counted else taken


def _methods(rivals: Sequence[Rival]) -> Iterator[Contender]:
    """Yield our methods as they come, and each rival at the tolerance next to `RTOL`."""
    yield ours("exact", TOLERANCE, "as it comes", tolerance=TOLERANCE)
    yield ours("rk4", PERIOD_STEPS, "as it comes", period_steps=PERIOD_STEPS)
    for rival in rivals:
        fitting = max(rival.settings) if rival.setting == "steps" else nearest(rival.settings)
        yield from contenders_of(replace(rival, settings=(fitting,)))


def nearest(tolerances: tuple[float, ...]) -> float:
    """Return the tolerance next to `RTOL` on a scale of logarithms."""
    return min(tolerances, key=lambda rtol: abs(math.log(rtol / RTOL)))


def steps(case: Case, contender: Contender) -> float:
    """Return the steps of a contact that our methods are set to, on the average; NaN for others.

    `exact` solves a short impact at once, at the nodes that its tolerance asks for; a longer one
    takes its steps, or more.  With `rk4` every contact takes a quarter of the steps of a period.
    """
    settings = Settings.of(contender.setting.method)
    if contender.setting.method == "rk4":
        return settings.steps
    if contender.setting.method != "exact":
        return math.nan
    taken = [
        settings.steps if nodes is None else nodes for nodes in nodes_of_impacts(case, settings)
    ]
    return float(np.mean(taken)) if taken else math.nan


def nodes_of_impacts(case: Case, settings: Settings) -> Iterator[int | None]:
    """Yield the nodes with which `exact` begins to solve each impact; None where it is stepped."""
    scene, cell = case.system.scene, cell_of(case.system)
    ps, damper, arc = structure_of(cell), damper_in(cell), parts_of("exact", scene, settings).arc
    rate = rate_of(ps, damper)
    for struck, speed, phase, x1, v1 in _touches(case):
        # the kernels see a touch of the far wall in a mirror
        sign, gap = (1.0, cell.near) if struck == scene.struck["near"] else (-1.0, cell.far)
        forcing = sign * math.cos(phase), sign * math.sin(phase)
        wall = hertz_wall_at(gap, damper.inv_mu, cell)
        approach = impact.approach_of(ps, damper, wall, forcing, (speed, sign * x1, sign * v1))
        lasting = rate * approach.tick * impact.LENGTH
        if approach.size < impact.LARGEST and lasting < impact.LONGEST:
            level = arc_table.level_for(arc, int(arc_table.ERROR), approach.size)
            yield arc_table.nodes_of(arc, level, int(arc_table.WHOLE)).n
        else:
            yield None


def _touches(case: Case) -> Iterator[tuple[str, float, float, float, float]]:
    """Yield of each touch what is struck, approach speed, phase of the forcing, x1 and v1.

    x1 and v1 are those of the sample before: near enough to tell how large an impact is.
    """
    system = case.system
    orbit = simulate(
        system, case.periods, start=case.start, record=["impacts", "trajectory"], samples=SAMPLES
    )
    assert orbit.impacts is not None
    assert orbit.trajectory is not None
    states = np.concatenate([case.state[np.newaxis], orbit.trajectory])
    for row in orbit.impacts:
        before = states[int(row["touch"] / system.period * SAMPLES)]
        phase = system.parameters["omega"] * row["touch"]
        yield row["wall"], float(row["speed"]), phase, float(before[0]), float(before[1])
