"""The survey of stiffness: error, cost, touches and the way to the rigid limit, as K grows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial

import numpy as np

from nlds_vines.accuracy.cases import Case
from nlds_vines.accuracy.contenders import Contender, of_peer, ours
from nlds_vines.accuracy.measure import Truth, measured
from nlds_vines.accuracy.reference import NOBODY, Reference, reference_of
from nlds_vines.accuracy.results import Result
from nlds_vines.accuracy.rigid import Rigid
from nlds_vines.accuracy.rivals import Asked, Peer, installed
from nlds_vines.accuracy.stiffness_table import COLUMNS, SHAPE
from nlds_vines.accuracy.survey import Row, Survey, Task
from nlds_vines.archives.provenance import version
from nlds_vines.errors import RequestError
from nlds_vines.kernels.flight import rate_of
from nlds_vines.kernels.impact import LONGEST
from nlds_vines.kernels.scene import damper_in, structure_of
from nlds_vines.model.system import System
from nlds_vines.orbits.kernel_inputs import cell_of
from nlds_vines.orbits.settings import CONTACT_STEPS, PERIOD_STEPS, STEPS_RATIO

MODULI = (2e5, 2e6, 2.05e7, 2e8, 2e9, 2.1e10, 2.1e11, 2.1e12, 2.1e13)
"""Young's moduli E2 of the damper's side [Pa]: soft rubber, rubber, ..., steel, beyond."""

STIFFNESSES = tuple(10.0**k for k in range(4, 17))
"""Contact stiffnesses K [N/m^1.5] given directly, to beyond any material."""

NODES = 12
"""Collocation nodes of `exact` by default."""

RTOL = 1e-8
"""Tolerance of the solvers of others, or the nearest of theirs."""


def stiffness(system: System, periods: int, peers: bool = True) -> Survey:
    """Return the survey of a system whose contact is made softer and harder, from rest."""
    there = installed() if peers else ()
    cases = list(_cases(system, periods))
    about = {
        "cases": {case.name: case.to_table() for case in cases},
        "peers": {peer.name: version(peer.needs) if peer.needs else "-" for peer in there},
    }
    rigid = cache(partial(_rigid_state, cases[0]))
    tasks = tuple(Task(case.name, partial(_rows, case, rigid, there)) for case in cases)
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


def _rows(case: Case, rigid: Callable[[], np.ndarray], peers: tuple[Peer, ...]) -> list[Row]:
    """Measure every method on one stiffness; where there is no reference all fail."""
    methods = list(_methods(peers))
    try:
        reference = reference_of(case)
    except RequestError as error:
        truth = Truth(case, NOBODY, "", None)
        results = [Result(contender.setting, failure=str(error)) for contender in methods]
        return [_row(truth, math.nan, found, math.nan) for found in results]
    distance = float(np.abs(reference.section[-1] - rigid()).max())
    truth = Truth(case, reference, "", None)
    results = [measured(truth, contender, Asked.TOUCHES) for contender in methods]
    return [
        _row(truth, distance, found, steps(case, contender, reference))
        for contender, found in zip(methods, results, strict=True)
    ]


def _methods(peers: tuple[Peer, ...]) -> Iterator[Contender]:
    """Yield our methods as they come, and each peer at the tolerance next to `RTOL`."""
    yield ours("exact", NODES, "as it comes", nodes=NODES, contact_steps=CONTACT_STEPS)
    yield ours("rk4", PERIOD_STEPS, "as it comes", period_steps=PERIOD_STEPS)
    for peer in peers:
        fitting = max(peer.settings) if peer.setting == "steps" else nearest(peer.settings)
        yield from of_peer(replace(peer, settings=(fitting,)))


def nearest(tolerances: tuple[float, ...]) -> float:
    """Return the tolerance next to `RTOL` on a scale of logarithms."""
    return min(tolerances, key=lambda rtol: abs(math.log(rtol / RTOL)))


def steps(case: Case, contender: Contender, reference: Reference) -> float:
    """Return the steps of a contact that our methods are set to, on the average; NaN for others.

    `exact` solves a short impact at once, at its nodes; one that lasts longer than `LONGEST` in
    units of the flight's own rate takes its contact steps, as all do with `rk4`: a quarter of
    those of a period.
    """
    if contender.setting.method == "rk4":
        return PERIOD_STEPS / STEPS_RATIO
    if contender.setting.method != "exact":
        return math.nan
    short = reference.durations * _rate(case.system) < LONGEST
    return float(np.where(short, NODES, CONTACT_STEPS).mean()) if short.size else math.nan


def _rate(system: System) -> float:
    cell = cell_of(system)
    return float(rate_of(structure_of(cell), damper_in(cell)))


def _row(truth: Truth, distance: float, found: Result, taken: float) -> Row:
    system, setting = truth.case.system, found.setting
    return {
        "K": system.K,
        "E2": system.parameters.get("E2", math.nan),
        "method": setting.method,
        "setting": setting.words,
        "ours": int(setting.ours),
        "error": found.error,
        "growth": truth.reference.growth,
        "doubt": truth.reference.doubt,
        "touches": 0 if truth.reference.touches is None else len(truth.reference.touches),
        "missed": found.missed,
        "touch_error": found.touch_error,
        "steps": found.steps if math.isnan(taken) else taken,
        "seconds": found.seconds,
        "rigid": distance,
        "failure": found.failure,
        "status": int(bool(found.failure)),
    }
