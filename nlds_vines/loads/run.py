"""Response histories from request to archive: orbits of systems under loads in cells.

Without axes each system is a block, with histories; a scan has blocks of many orbits.  The
orbits of a suite without axes are those of its records alone, to the bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from nlds_vines.archives.dataset import Table
from nlds_vines.archives.files import parse_toml
from nlds_vines.engine.engine import engine_for
from nlds_vines.engine.load_task import LoadOfOrbit, LoadRunner, LoadTask
from nlds_vines.loads.datasets import (
    SENSITIVE,
    blocks_of,
    impacts_in,
    in_columns,
    owners_in,
    samples_in,
    scales_of,
    table_of,
    with_drift_ratios,
)
from nlds_vines.loads.request import LOAD, HistoryRequest, is_of_load, load_response_history
from nlds_vines.model.loads.loading import Loading
from nlds_vines.model.quantities import HISTORIES, TOUCH_COLUMNS
from nlds_vines.model.system import System
from nlds_vines.runs.progress import Tell
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import Arrays
from nlds_vines.scans.block import Block
from nlds_vines.scans.run import Blocks, Further, Plan, run_in_blocks
from nlds_vines.scans.run_report import Report

TOUCHES = "touches"  # the impacts of a block, of which there are any number


def run(request: HistoryRequest, output: Path, how: RunOptions | None = None) -> Report:
    """Compute response histories into the archive `output`, as `run_in_blocks` does."""
    how = RunOptions() if how is None else how
    return run_in_blocks(plan_of(request), output, how)


def plan_of(request: HistoryRequest) -> Plan:
    table = _table_of(request)
    return Plan(
        request=request,
        table=table,
        scales=partial(scales_of, request),
        inputs=partial(samples_in, request),
        blocks=blocks_of(request),
        starts=1,
        computer=partial(HistoryComputer, request, table),
        on_worker=_computer_in,
        further=partial(_impacts, request),
    )


def _table_of(request: HistoryRequest) -> Table:
    has_histories = not request.is_scan
    names: set[str] = set()
    for system in request.systems:
        names |= _runner_of(request, system, has_histories, None).names
    return table_of(request, names)


def _computer_in(text: str) -> HistoryComputer:
    """Return the computer of the request in a text, for a worker."""
    request = load_response_history(parse_toml(text, "the response history"))
    return HistoryComputer(request, _table_of(request))


def _impacts(request: HistoryRequest, saved: Blocks) -> Further:
    """Return the impacts of all systems, which histories record."""
    if request.is_scan:
        return Further()
    none = np.zeros((0, 1 + len(TOUCH_COLUMNS)))
    each = [arrays[TOUCHES] for _, arrays in saved() if TOUCHES in arrays]
    scales, columns = impacts_in(np.concatenate([none, *each]))
    return Further(columns, scales)


class HistoryComputer:
    """Computes blocks of orbits under loads."""

    def __init__(self, request: HistoryRequest, table: Table, tell: Tell | None = None) -> None:
        self.table = table
        self._request = request
        self._tell = tell

    def block(self, block: Block) -> dict[str, np.ndarray]:
        """Return the datasets of a block by name, filled where its system does not have one."""
        request = self._request
        shape = (len(request.systems), *request.shape)
        sides = [np.arange(first, stop) for first, stop in block.slices]
        cases = np.ravel_multi_index(np.ix_(*sides), shape).ravel()
        computed = arrays_of(request, cases.tolist(), self._tell)
        arrays: dict[str, np.ndarray] = {}
        for name, (kind, own_shape) in block.expected(self.table).items():
            if name in computed:
                arrays[name] = computed[name].reshape(own_shape)
            else:
                arrays[name] = np.full(own_shape, self.table.datasets[name].fill, kind)
        if TOUCHES in computed:
            arrays[TOUCHES] = computed[TOUCHES]
        return arrays


def arrays_of(
    request: HistoryRequest, cases: Sequence[int], tell: Tell | None = None
) -> dict[str, np.ndarray]:
    """Return the results of some orbits of one system by name: arrays (orbits, ...).

    These are the quantities of `datasets` and `status`, and without axes the histories, and the
    impacts after the number of their system, where kernels record them.
    """
    count = math.prod(request.shape)
    which = cases[0] // count
    places = [case % count for case in cases]
    system = request.systems[which]
    if request.load.suite and not request.vary:
        each = [_numbers_under(request, system, place, tell) for place in places]
        return {name: np.concatenate([one[name] for one in each]) for name in each[0]}
    values = request.values_at(np.unravel_index(places, request.shape)) if request.vary else {}
    arrays = numbers_of(request, system, values, tell)
    if not values:
        arrays[SENSITIVE] = _sensitivity(request, system, arrays, tell)
    if TOUCHES in arrays:
        arrays[TOUCHES] = np.insert(arrays[TOUCHES], 0, which, axis=1)
    return arrays


def _numbers_under(
    request: HistoryRequest, system: System, place: int, tell: Tell | None
) -> dict[str, np.ndarray]:
    """Return the quantities (1, ...) under one record of a suite, as its own history has them.

    The cells of a history end at its times, so that the bits of a host's numbers depend on them.
    """
    alone = request.with_record(place)
    arrays = numbers_of(alone, system, {}, tell)
    arrays[SENSITIVE] = _sensitivity(alone, system, arrays, tell)
    return {name: arrays[name] for name in arrays if name not in (TOUCHES, *HISTORIES)}


def _sensitivity(
    request: HistoryRequest, system: System, arrays: Arrays, tell: Tell | None
) -> np.ndarray:
    """Return [1] if loads that differ by `ROUND_OFF` give other numbers of impacts, or else [0].

    Without impacts it is [-1], and nothing is computed.
    """
    counts = arrays.get("impact_count", np.zeros(0))
    if not (counts > 0).any():
        return np.array([-1], np.int8)
    others = numbers_of(request.moved(), system, {}, tell)["impact_count"]
    return np.array([not np.array_equal(counts, others)], np.int8)


def numbers_of(
    request: HistoryRequest, system: System, values: Mapping[str, np.ndarray], tell: Tell | None
) -> dict[str, np.ndarray]:
    """Return the quantities (n, ...) that a system has under the load by name.

    The `values` (n,) are parameters, those that the system lacks left out; numbers of the load;
    `load`, the number of a record of the suite; and `draw`, by which the seeds of noise advance.
    Without values there are histories, too.
    Beside the quantities there are `status` and the `violations` of the scene's limit.
    """
    others = (LOAD, "draw")
    of_load = {name: v.tolist() for name, v in values.items() if is_of_load(name) or name in others}
    each: list[LoadOfOrbit] = []
    loads = dict[tuple[float, ...], Loading]()
    for lane in range(max((len(column) for column in values.values()), default=1)):
        changes = {name: column[lane] for name, column in of_load.items()}
        impulse = changes.pop("impulse", request.load.impulse)
        key = tuple(changes.values())
        if key not in loads:
            load = request.load
            if load.suite:
                load = load.member(int(changes.pop(LOAD)))
            draw = changes.pop("draw", 0)
            load = load.redrawn(draw) if draw and load.noise else load
            loads[key] = load.with_({"impulse": 0.0, **changes})
        each.append((loads[key], impulse * loads[key].scale))
    grid = {name: v for name, v in values.items() if system.takes(name)}
    arrays = _runner_of(request, system, not values, tell).run(grid, each)
    return dict(with_drift_ratios(request, in_columns(request, system, arrays)))


def _runner_of(
    request: HistoryRequest, system: System, has_histories: bool, tell: Tell | None
) -> LoadRunner:
    task = LoadTask(
        duration=request.duration,
        times=request.times,
        has_histories=has_histories,
        shaken=request.load.shaken,
        state=request.state,
        settle=request.settle,
        tolerance=request.tolerance,
        of=owners_in(system, request)["displacement"],
    )
    return engine_for(system).load(task, tell)
