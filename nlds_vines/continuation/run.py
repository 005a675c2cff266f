"""A continuation from request to archive; each complete branch or curve is a block."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import count
from pathlib import Path

import numpy as np

from nlds_vines.archives.archive import ArchiveView
from nlds_vines.continuation.branch_arm import MOST_POINTS as BRANCH_POINTS
from nlds_vines.continuation.branch_arm import Bounds
from nlds_vines.continuation.exploration import Explorer, Piece, Seed
from nlds_vines.continuation.monitors import add_zeros, monitors_of, numbers_along
from nlds_vines.continuation.request import Continuation, Orbit
from nlds_vines.continuation.result import (
    CURVE_END_FLAGS,
    KIND_FLAGS,
    Continued,
    Tables,
    datasets_of,
    map_of,
    scales_of,
    tables_of,
)
from nlds_vines.continuation.special_curves import MOST_POINTS as CURVE_POINTS
from nlds_vines.continuation.special_curves import Curve, Tracer, trace_curve
from nlds_vines.continuation.special_points import Special
from nlds_vines.continuation.tori import tori_beside
from nlds_vines.engine.batch import Wanted
from nlds_vines.engine.engine import engine_for
from nlds_vines.engine.records import USUAL
from nlds_vines.engine.section_map import SectionMap
from nlds_vines.engine.solver_settings import Settings
from nlds_vines.engine.starts import Start
from nlds_vines.errors import RequestError
from nlds_vines.model.axis import Interval
from nlds_vines.model.labels import final
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.progress import Progress, Tell
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import Arrays, BlockStore, Write

# forcing periods after which a start is classified, and those that are sampled for it
TRANSIENT, PERIODS = 600, 120


def seeds_of(
    request: Continuation, section_map: SectionMap, tell: Tell | None = None
) -> list[Seed]:
    """Return the start orbits of a continuation; `RequestError` if there is none."""
    begin, name = request.begin, request.along.name
    if begin.policy == "orbits":
        return [(section_map.place_of(o.value, o.state), o.period) for o in begin.orbits]
    there, is_random = request.system.with_(**{name: request.value}), begin.policy != "rest"
    start = Start("random", begin.count, begin.seed) if is_random else Start()
    cells = np.repeat(np.atleast_1d(there.cells()), start.orbits)
    engine, how = engine_for(there), ("exact", Settings(float(request.tolerance)))
    starts = engine.states(cells, start, np.arange(len(cells)), {}, how)
    method, settings = how
    wanted = Wanted(there.scene, USUAL, method, "standard", settings)
    runner, cells = engine.runner(wanted, tell, of=(), helped=True), cells[:, np.newaxis]
    outputs = runner.run(cells, starts, TRANSIENT, PERIODS)
    arrays = {key: values[:, 0] for key, values in runner.verdicts(outputs, cells).items()}
    periods = arrays["periodicity"].tolist()
    seeds = [
        (section_map.place_of(request.value, arrays["orbit_point"][i].tolist()), n)
        for i, (n, label) in enumerate(zip(periods, arrays["label"], strict=True))
        if n and label in (begin.label or label)
    ]
    if not seeds:
        labels = ", ".join(dict.fromkeys(map(str, arrays["label"])))
        where = f"{name} = {request.value:g}"
        if begin.label:
            raise RequestError(f"no start at {where} ends in {begin.label}: {labels}")
        who = "the orbit from rest" if begin.policy == "rest" else "every random start"
        raise RequestError(
            f"{who} at {where} is {labels}: only a periodic orbit can be followed; give a start"
        )
    return seeds[:1] if begin.label else seeds


# ---- from the archive of a scan ----


def orbits_in(
    view: ArchiveView, name: str, cell: dict[str, float], starts: int | None = None
) -> dict[Orbit, str]:
    """Return periodic orbits of a scan's first `starts`, or all, with their labels.

    They lie along a parameter that it varied.  `cell` holds values of varied parameters, of which
    the nearest cells count, or else the first.  Without the parameter itself, the first, the middle
    and the last cell of each run of equal labels count.  Raises `RequestError` if the archive holds
    no periods or no states.
    """
    if name not in view.axes:
        raise RequestError(f"{view.path} varies {', '.join(view.axes)}, not {name}")
    for dataset in ("periodicity", "label"):
        if dataset not in view:
            raise RequestError(f"{view.path} holds no {dataset}: scan with regime in --record")
    where = {axis: 0 for axis in view.axes if axis != name}
    for axis, value in cell.items():
        if axis not in view.axes:
            raise RequestError(f"{view.path} varies {', '.join(view.axes)}, not {axis}")
        where[axis] = int(np.abs(view[axis] - value).argmin())
    one = where.pop(name, None)
    source = "orbit_point" if "orbit_point" in view else "section"
    if source not in view:
        raise RequestError(f"{view.path} holds no section: record section or evidence")
    values = view[name]
    period, label = view.take("periodicity", **where), view.take("label", **where)
    states = view.take(source, **where)
    if source == "section":
        states = states[..., -1, :]
    orbits: dict[Orbit, str] = {}
    for start in range(period.shape[1])[:starts]:
        runs = runs_of(label[:, start])
        inner = sorted({i for a, b in runs for i in (a, (a + b - 1) // 2, b - 1)})
        for i in inner if one is None else (one,):
            n, state = int(period[i, start]), states[i, start]
            if n > 0 and np.isfinite(state).all():
                orbit = Orbit(tuple(state.tolist()), float(values[i]), n)
                orbits[orbit] = final(str(label[i, start]))
    return orbits


def runs_of(labels: np.ndarray) -> list[tuple[int, int]]:
    """Return the first index, and the index behind the last, of each run of equal labels (n,)."""
    borders = (np.flatnonzero(labels[1:] != labels[:-1]) + 1).tolist()
    return list(zip([0, *borders], [*borders, len(labels)], strict=True))


# ---- from the archive of branches ----


def orbits_on(branches: Continued, along: Interval, cell: dict[str, float]) -> dict[Orbit, str]:
    """Return the orbits of earlier branches in an interval, with their labels.

    `cell` is empty or holds a value of the parameter of these branches: then the orbits are those
    at this value.  Without it, the interval must be of the same parameter,
    and the point in the middle of each run of equal labels counts.
    """
    name = branches.request.along.name
    for other in cell:
        if other != name:
            raise RequestError(f"its branches lie along {name}, not {other}")
    orbits: dict[Orbit, str] = {}
    if cell:
        for crossing in branches.orbits_at(cell[name]):
            value = crossing.value
            if along.name != name:
                of_system = branches.request.own(along.name)
                assert of_system is not None  # the system has what may vary
                value = of_system
            orbit = Orbit(tuple(crossing.state.tolist()), value, crossing.period)
            orbits[orbit] = crossing.label
        return orbits
    if along.name != name:
        raise RequestError(
            f"its branches lie along {name}: FILE.h5@{name}=VALUE says where those along "
            f"{along.name} begin"
        )
    for branch in branches.branches:
        inside = (along.low <= branch.parameter) & (branch.parameter <= along.high)
        labels = np.where(inside, branch.labels.astype(str), "")
        for first, behind in runs_of(labels):
            middle = (first + behind) // 2
            if labels[middle]:
                value, state = float(branch.parameter[middle]), branch.states[middle]
                orbit = Orbit(tuple(state.tolist()), value, branch.period)
                orbits[orbit] = str(labels[middle])
    return orbits


# ---- curves of special points in the plane of two parameters ----

CURVED = ("LP", "PD", "NS", "GR")  # the kinds of special points whose curves are followed
SAME = 1.0e-7  # relative difference of a parameter below which two special points are the same


def curves_through(request: Continuation, specials: Sequence[Special], piece: Piece) -> Tables:
    """Follow the curves through `specials` in the plane of both parameters; return their tables.

    A special point on a curve that has been followed has no curve of its own.
    """
    along, plane = request.free
    second = request.own(plane.name)
    assert second is not None  # as the request was validated
    section_map = map_of(request, 2)
    low, high = np.array([along.low, plane.low]), np.array([along.high, plane.high])
    curves = [_arrays_of(request, section_map, Curve("LP"))]
    for special in specials:
        if special.kind not in CURVED or any(
            _holds(request, arrays, special, second) for arrays in curves
        ):
            continue

        def follow(special: Special = special) -> Arrays:
            most = request.points or CURVE_POINTS
            tracer = Tracer(section_map, special.kind, low, high, most=most)
            place = np.append(special.point.cycle.place, second)
            curve = trace_curve(tracer, place, special.point.cycle.n, special.impacts)
            curve = curve if curve and curve.points else Curve(special.kind)
            return _arrays_of(request, section_map, curve)

        curves.append(piece(follow))
    tables = {name: np.concatenate([arrays[name] for arrays in curves]) for name in curves[0]}
    numbers = np.cumsum([len(arrays["curve_kind"]) for arrays in curves]) - 1
    for name, like in (("curve_of_point", "curve_impact_count"), ("curve_of_meeting", "meeting")):
        tables[name] = np.repeat(numbers, [len(arrays[like]) for arrays in curves])
    return tables | {"meeting": tables["meeting"].astype(object)}


def _holds(request: Continuation, arrays: Arrays, special: Special, second: float) -> bool:
    """Return True if a curve passes a special point at the value `second` of its parameter."""
    about = arrays["curve_kind"].tolist(), arrays["curve_periodicity"].tolist()
    first, across = (arrays[f"curve_{item.name}"] for item in request.free)
    if about != ([KIND_FLAGS[special.kind]], [special.point.cycle.n]) or len(first) < 3:
        return False
    for i in np.flatnonzero((across[:-1] - second) * (across[1:] - second) <= 0.0):
        # by a parabola, whose error is smaller than the distance of special points of one branch
        j = min(max(int(i) - 1, 0), len(first) - 3)
        x, y = across[j : j + 3], first[j : j + 3]
        value = sum(
            y[k] * np.prod([(second - x[m]) / (x[k] - x[m]) for m in range(3) if m != k])
            for k in range(3)
        )
        step = abs(first[i + 1] - first[i])
        if abs(value - special.value) <= max(SAME * abs(special.value), 1.0e-2 * step):
            return True
    return False


def _arrays_of(request: Continuation, section_map: SectionMap, curve: Curve) -> Arrays:
    """Return the datasets of one curve; without points, all are empty."""
    names, size = [item.name for item in request.free], section_map.size
    cycles = [point.cycle for point in curve.points]
    places = np.array([cycle.place for cycle in cycles]).reshape(-1, size + 2)
    met = np.array([point.cycle.values for _, point in curve.meetings]).reshape(-1, 2)
    mu = np.array([cycle.multipliers for cycle in cycles], dtype=complex).reshape(-1, size)
    whole = {
        "curve_impact_count": [sum(cycle.counts) for cycle in cycles],
        "curve_kind": [KIND_FLAGS[curve.kind] for _ in cycles[:1]],
        "curve_periodicity": [cycle.n for cycle in cycles[:1]],
        "curve_first_end": [CURVE_END_FLAGS[curve.ends[0]] for _ in cycles[:1]],
        "curve_last_end": [CURVE_END_FLAGS[curve.ends[1]] for _ in cycles[:1]],
    }
    return {
        **{f"curve_{name}": places[:, size + i] for i, name in enumerate(names)},
        "curve_state": section_map.states_of(places),
        "curve_multipliers": np.stack([mu.real, mu.imag], axis=-1),
        **{name: np.array(values, dtype=np.int64) for name, values in whole.items()},
        **{f"meeting_{name}": met[:, i] for i, name in enumerate(names)},
        "meeting": np.array([name for name, _ in curve.meetings], dtype="U8"),
    }


# ---- from request to archive ----


def compute(
    request: Continuation, piece: Piece = lambda make: make(), tell: Tell | None = None
) -> Tables:
    """Follow all branches and curves of a continuation, saved by `piece`; return their tables."""
    along, section_map = request.along, map_of(request)
    explorer = Explorer(
        section_map,
        Bounds(along.low, along.high),
        piece,
        request.doublings,
        request.step,
        request.unstable,
        request.points or BRANCH_POINTS,
        along.falls,
    )
    monitors = monitors_of(request, section_map)
    seeds = seeds_of(request, section_map, tell)
    section_map.compile(tell)
    tracks = explorer.run(seeds)
    if not tracks:
        raise RequestError(
            "Newton's method closed no periodic orbit from the start: give a nearer state"
        )
    add_zeros(section_map, tracks, monitors)
    tables = tables_of(request, section_map, tracks)
    tables |= numbers_along(request, section_map, tracks)
    if request.tori:
        tables |= tori_beside(request, section_map, tracks, piece)
    if request.plane is None:
        return tables
    specials = [special for track in tracks for special in track.specials]
    return tables | curves_through(request, specials, piece)


def run(request: Continuation, output: Path, how: RunOptions) -> None:
    """Compute a continuation into the archive `output`."""
    use_threads(how.threads)
    store, numbers = BlockStore(output, request), count()

    def work() -> Write:
        with Progress(None, "curve", quiet=how.quiet) as progress:

            def piece(make: Callable[[], Arrays]) -> Arrays:
                arrays = store.piece(next(numbers), make)
                progress.note(1, f"{max(map(len, arrays.values()))} points in the last one")
                return arrays

            tables = compute(request, piece, progress.wait)
        contents = [
            (entry, tables[entry.name]) for entry in datasets_of(request) if entry.name in tables
        ]
        names = [item.name for item in request.free]
        return store.writer(scales_of(request, tables), contents, names)

    store.carry_out(how, work)
