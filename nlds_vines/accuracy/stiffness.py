"""The survey of stiffness: error, cost, touches and the way to the rigid limit, as K grows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np

from nlds_vines.accuracy.cases import Case
from nlds_vines.accuracy.columns import Row, row_of
from nlds_vines.accuracy.contenders import Contender, of_rival, ours
from nlds_vines.accuracy.measure import Truth, measured
from nlds_vines.accuracy.reference import UNKNOWN, Reference, reference_of
from nlds_vines.accuracy.results import Result
from nlds_vines.accuracy.rigid import Rigid
from nlds_vines.accuracy.rivals import Asked, Rival
from nlds_vines.accuracy.stiffness_table import COLUMNS, SHAPE, Stiffened
from nlds_vines.accuracy.survey import Survey, Task
from nlds_vines.errors import RequestError
from nlds_vines.kernels import impact
from nlds_vines.kernels.flight import rate_of
from nlds_vines.kernels.laws.hertz import hertz_wall_at
from nlds_vines.kernels.scene import damper_in, structure_of
from nlds_vines.model.system import System
from nlds_vines.orbits.kernel_inputs import cell_of, parts_of
from nlds_vines.orbits.settings import PERIOD_STEPS, TOLERANCE, Settings
from nlds_vines.orbits.simulation import SAMPLES, simulate

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
    methods = list(_methods(rivals))
    try:
        reference = reference_of(case)
    except RequestError as error:
        results = [Result(contender.setting, failure=str(error)) for contender in methods]
        return _rows_of(case, UNKNOWN, math.nan, results)
    truth = Truth(case, reference, "", None)
    results = [_measured(truth, contender) for contender in methods]
    return _rows_of(case, reference, float(np.abs(reference.section[-1] - rigid()).max()), results)


def _measured(truth: Truth, contender: Contender) -> Result:
    """Return what is found of a contender, with the steps of a contact where they are set."""
    found = measured(truth, contender, Asked.TOUCHES)
    taken = steps(truth.case, contender)
    return found if math.isnan(taken) else replace(found, steps=taken)


def _rows_of(case: Case, reference: Reference, distance: float, results: list[Result]) -> list[Row]:
    """Return the rows of a stiffness; `distance` is that of the true state from the rigid one."""
    E2 = case.system.parameters.get("E2", math.nan)
    touches = 0 if reference.touches is None else len(reference.touches)
    stiffened = Stiffened(case.system.K, E2, touches, distance)
    return [row_of(stiffened, reference, found.setting, found) for found in results]


def _methods(rivals: Sequence[Rival]) -> Iterator[Contender]:
    """Yield our methods as they come, and each rival at the tolerance next to `RTOL`."""
    yield ours("exact", TOLERANCE, "as it comes", tolerance=TOLERANCE)
    yield ours("rk4", PERIOD_STEPS, "as it comes", period_steps=PERIOD_STEPS)
    for rival in rivals:
        fitting = max(rival.settings) if rival.setting == "steps" else nearest(rival.settings)
        yield from of_rival(replace(rival, settings=(fitting,)))


def nearest(tolerances: tuple[float, ...]) -> float:
    """Return the tolerance next to `RTOL` on a scale of logarithms."""
    return min(tolerances, key=lambda rtol: abs(math.log(rtol / RTOL)))


def steps(case: Case, contender: Contender) -> float:
    """Return the steps of a contact that our methods are set to, on the average; NaN for others.

    `exact` solves a short impact at once, at the nodes that its tolerance asks for; a longer one
    takes its steps.  With `rk4` every contact takes a quarter of the steps of a period.
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
            level = impact.level_for(arc, int(impact.ERROR), approach.size)
            yield impact.nodes_of(arc, level, int(impact.WHOLE)).n
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
