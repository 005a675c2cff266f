"""The orbits that branches begin with: from rest, from random starts, from an archive's cells."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.continuation.exploration import Seed
from nlds_vines.continuation.request import Continuation, Orbit
from nlds_vines.errors import RequestError
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.model.system import System
from nlds_vines.orbits.batch import Kernels, Wanted
from nlds_vines.orbits.records import USUAL
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.orbits.starts import Start, random_states, start_states
from nlds_vines.runs.progress import Tell

TRANSIENT, PERIODS = 600, 120
"""Forcing periods after which a start is judged."""


def place_of(system: System, name: str, value: float, state: tuple[float, ...]) -> np.ndarray:
    """Return the place (size + 1,) of a state in the user's coordinates at a parameter's value."""
    found = list(state)
    rest = system.with_(**{name: value}).rest
    if rest is not None:
        found[2], found[3] = state[0] - (state[2] - rest), state[1] - state[3]
    return np.array([*found, value])


def states_of(system: System, names: Sequence[str], places: np.ndarray) -> np.ndarray:
    """Return the states (count, size) in the user's coordinates of places (count, size + m).

    Arguments: the `names` of the m free parameters, any of which may move the rest position.
    """
    size = len(system.scene.components)
    states = places[:, :size].copy()
    if system.scene.damper:
        rest = system.cells({name: places[:, size + i] for i, name in enumerate(names)})["rest"]
        states[:, 2] = places[:, 0] - places[:, 2] + rest
        states[:, 3] = places[:, 1] - places[:, 3]
    return states


def seeds_of(request: Continuation, tell: Tell | None = None) -> list[Seed]:
    """Return the start orbits of a continuation.

    Raises `RequestError` where none of the starts ends in a periodic orbit, or none has the label.
    """
    begin, name, system = request.begin, request.along.name, request.system
    if begin.policy == "orbits":
        return [Seed(place_of(system, name, o.value, o.state), o.period) for o in begin.orbits]
    there = system.with_(**{name: request.value})
    starts = np.zeros((1, 4))
    if begin.policy != "rest":
        draws = start_states(Start("random", begin.count, begin.seed))
        starts = random_states(there.cells(), draws, there.scene)
    found = list(_judged(there, starts, float(request.tolerance), tell))
    wanted = [(n, y) for label, n, y in found if n and label in (begin.label or label)]
    if begin.label:
        wanted = wanted[:1]
    if not wanted:
        raise RequestError(_nothing_to_follow(request, [label for label, _, _ in found]))
    size = len(there.scene.components)
    return [Seed(np.append(y[:size], request.value), n) for n, y in wanted]


def _nothing_to_follow(request: Continuation, labels: list[str]) -> str:
    """Return in words why there is no orbit to begin with."""
    where = f"{request.along.name} = {request.value:g}"
    seen = ", ".join(dict.fromkeys(labels))
    if request.begin.label:
        return f"no start at {where} ends in {request.begin.label}: {seen}"
    starts = "the orbit from rest" if request.begin.policy == "rest" else "every random start"
    return f"{starts} at {where} is {seen}: only a periodic orbit can be followed; give a start"


def _judged(
    system: System, starts: np.ndarray, tolerance: float, tell: Tell | None
) -> Iterator[tuple[str, int, np.ndarray]]:
    """Yield the label, n, and a state (4,) of the orbit at phase zero, of each start (count, 4)."""
    wanted = Wanted(system.scene, USUAL, "exact", "standard", Settings(tolerance))
    cells = np.repeat(np.atleast_1d(system.cells()), len(starts))[:, np.newaxis]
    outputs = Kernels(wanted, tell).run(cells, starts, TRANSIENT, PERIODS)
    arrays = outputs.verdicts(cells)
    for lane in range(len(starts)):
        label = str(arrays["label"][lane, 0])
        n = int(arrays["periodicity"][lane, 0]) if outputs.status[lane, 0] == OK else 0
        point = arrays["orbit_point"][lane, 0]
        state = np.zeros(4)
        state[: point.size] = point
        if system.rest is not None:
            state[2] = point[0] - (point[2] - system.rest)
            state[3] = point[1] - point[3]
        yield label, n, state


# ---- from an archive -----------------------------------------------------------------------------


def orbits_in(view: ArchiveView, name: str, cell: dict[str, float]) -> tuple[Orbit, ...]:
    """Return periodic orbits that a scan's archive holds, along a parameter that it varied.

    Arguments: the parameter's `name`; `cell`: values by the name of a varied parameter, whose
    nearest cells are looked at: of the parameter itself, that cell alone, otherwise of every run of
    one label the first, the middle and the last cell.

    Raises `RequestError` where the archive holds no periods, or no states.
    """
    if name not in view.axes:
        raise RequestError(f"{view.path} varies {', '.join(view.axes)}, not {name}")
    for dataset in ("periodicity", "label"):
        if dataset not in view:
            raise RequestError(f"{view.path} holds no {dataset}: scan with regime in --record")
    where = {}
    for other, value in cell.items():
        if other not in view.axes:
            raise RequestError(f"{view.path} varies {', '.join(view.axes)}, not {other}")
        where[other] = int(np.abs(view[other] - value).argmin())
    for axis in view.axes:
        if axis not in where and axis != name:
            where[axis] = 0
    return tuple(_orbits_of(view, name, where))


def _orbits_of(view: ArchiveView, name: str, where: dict[str, int]) -> Iterator[Orbit]:
    values = view[name]
    source = "orbit_point" if "orbit_point" in view else "section"
    if source not in view:
        raise RequestError(f"{view.path} holds no section: record section or evidence")
    chosen = {axis: index for axis, index in where.items() if axis != name}
    period, label = view.take("periodicity", **chosen), view.take("label", **chosen)
    states = view.take(source, **chosen)
    if source == "section":
        states = states[..., -1, :]
    for start in range(period.shape[1]):
        cells = [where[name]] if name in where else _of_runs(label[:, start])
        for i in cells:
            n = int(period[i, start])
            if n > 0 and np.isfinite(states[i, start]).all():
                yield Orbit(tuple(states[i, start].tolist()), float(values[i]), n)


def _of_runs(labels: np.ndarray) -> Iterator[int]:
    """Yield the first, the middle and the last index of each run of equal labels."""
    begin = 0
    for end in range(1, len(labels) + 1):
        if end == len(labels) or labels[end] != labels[begin]:
            yield from sorted({begin, (begin + end - 1) // 2, end - 1})
            begin = end


def system_in(path: Path, text: str) -> System:
    """Return the system of a scan's document."""
    from nlds_vines.archives.files import parse_toml
    from nlds_vines.bifurcation.request import load_scan

    return load_scan(parse_toml(text, str(path))).system
