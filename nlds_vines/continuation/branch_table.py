"""The datasets of a continuation: points, special points and branches; curves of special points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.continuation.branch_arm import ENDS
from nlds_vines.continuation.exploration import Piece, Switch, Track
from nlds_vines.continuation.request import Continuation
from nlds_vines.continuation.section_map import Cycle, SectionMap, states_of
from nlds_vines.continuation.special_curves import ENDS as CURVE_ENDS
from nlds_vines.continuation.special_curves import Curve, Tracer, trace_curve
from nlds_vines.continuation.special_points import KINDS, Special, label_of_cycle
from nlds_vines.kernels.numerics.elementary import exp
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.quantities import BY_NAME
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.runs.store import Arrays

ORIGINS = {"start": 0, "PD": 1, "BP": 2}
"""The origins of branches: CF flags of the dataset `origin`."""

KIND_FLAGS = {kind: number for number, kind in enumerate(KINDS)}
END_FLAGS = {word: number for number, word in enumerate(ENDS)}
SWITCH_FLAGS = {outcome.name.lower(): int(outcome) for outcome in Switch}
STATUS_FLAGS = {"complete": 0, "incomplete": 1}
STABLE_FLAGS = {"unstable": 0, "stable": 1}

SI, DEFECT = "m, m/s", "closing error of the orbit, relative"
"""Units of the components of a state; meaning of two datasets."""

INCOMPLETE = ("lost", "long")
"""The ends of branches that are not complete."""

Tables = dict[str, np.ndarray]
"""Arrays by the name of a dataset."""

Entries = Iterator[tuple[Dataset, Callable[[Any], Any] | None]]
"""Datasets, each with the function of a cycle, special point or track that gives its entry, or None
if all entries are computed at once."""


def _of_points(request: Continuation) -> Entries:
    dims, free, scene = ("point",), PARAMETERS[request.along.name], request.system.scene
    pair = ("multiplier", "part")
    yield Dataset.whole("branch_of_point", dims, "branch that a point belongs to"), None
    yield free.dataset(dims), lambda c: c.values[0]
    yield Dataset.real("state", (*dims, "component"), SI, "orbit at phase zero"), None
    yield Dataset.real("section", ("row", "component"), SI, "orbits at phase zero"), None
    yield Dataset.whole("periodicity", dims, "n of nT"), lambda c: c.n
    near, far = (f"impacts per nT at the {wall} wall" for wall in ("near", "far"))
    yield Dataset.whole("impacts_near", dims, near), lambda c: c.counts[0]
    yield Dataset.whole("impacts_far", dims, far), lambda c: c.counts[1]
    yield Dataset.text("label", dims, "n and k of nT,k"), label_of_cycle
    words = "whether all multipliers lie inside"
    yield Dataset.code("stable", dims, words, STABLE_FLAGS), lambda c: c.unstable == 0
    yield BY_NAME["multipliers"].dataset((*dims, *pair), scene), _parts
    yield Dataset.real("residual", dims, "1", DEFECT), lambda c: c.defect
    words = "error of the product of multipliers, relative"
    yield Dataset.real("determinant_error", dims, "1", words), _determinant_error
    yield BY_NAME["E1max"].dataset(dims, scene), None
    yield BY_NAME["E2max"].dataset(dims, scene), None
    yield BY_NAME["clearance"].dataset(dims, scene), lambda c: c.clearance
    yield BY_NAME["softest_impact"].dataset(dims, scene), lambda c: c.slowest
    words = "largest approach speed"
    yield Dataset("fastest_impact", dims, "float64", "m/s", words, 0.0), None
    yield Dataset("largest_force", dims, "float64", "N", "largest contact force", 0.0), None


def _of_specials(request: Continuation) -> Entries:
    dims, free, scene = ("special",), PARAMETERS[request.along.name], request.system.scene
    pair = ("multiplier", "part")
    yield Dataset.whole("special_branch", dims, "branch that it lies on"), None
    words = "kind of special point"
    yield Dataset.code("kind", dims, words, KIND_FLAGS), lambda s: KIND_FLAGS[s.kind]
    yield free.dataset(dims, "special_"), lambda s: s.point.cycle.values[0]
    yield Dataset.real("special_state", (*dims, "component"), SI, "orbit at phase zero"), None
    yield Dataset.whole("special_index", dims, "point of its branch before it"), lambda s: s.index
    yield Dataset.whole("special_periodicity", dims, "n of nT"), lambda s: s.point.cycle.n
    yield BY_NAME["E1max"].dataset(dims, scene, prefix="special_"), None
    yield Dataset.text("before", dims, "label before it along the branch"), lambda s: s.before
    yield Dataset.text("after", dims, "label after it along the branch"), lambda s: s.after
    yield Dataset.text("wall", dims, "wall of a grazing impact"), lambda s: s.wall
    words = "test function there, relative"
    yield Dataset.real("special_residual", dims, "1", words), lambda s: s.residual
    yield Dataset.real("special_defect", dims, "1", DEFECT), lambda s: s.point.cycle.defect
    yield Dataset.real("bracket", dims, free.unit, "width of the last bracket"), lambda s: s.bracket
    words = "outcome of following the branch that leaves or crosses there"
    yield Dataset.code("switch", dims, words, SWITCH_FLAGS), None
    multipliers = BY_NAME["multipliers"].dataset((*dims, *pair), scene, prefix="special_")
    yield multipliers, lambda s: _parts(s.point.cycle)


def _of_branches() -> Entries:
    dims = ("branch",)
    incomplete = Dataset.code("status", dims, "whether a branch is complete", STATUS_FLAGS)
    yield incomplete, lambda t: any(end in INCOMPLETE for end in t.ends)
    yield Dataset.code("origin", dims, "origin of the branch", ORIGINS), lambda t: ORIGINS[t.origin]
    yield Dataset.whole("parent", dims, "branch that it leaves, -1 if none", -1), lambda t: t.parent
    yield (
        Dataset.whole(
            "parent_special", dims, "special point at which it leaves that branch, -1 if none", -1
        ),
        lambda t: t.at,
    )
    first = Dataset.code("first_end", dims, "reason of its end at its beginning", END_FLAGS)
    yield first, lambda t: END_FLAGS[t.ends[0]]
    last = Dataset.code("last_end", dims, "reason of its end at its end", END_FLAGS)
    yield last, lambda t: END_FLAGS[t.ends[1]]


def datasets_of(request: Continuation) -> list[Dataset]:
    entries = (*_of_points(request), *_of_specials(request), *_of_branches())
    return [entry for entry, _ in entries]


def tables_of(request: Continuation, section_map: SectionMap, tracks: Sequence[Track]) -> Tables:
    cycles = [point.cycle for track in tracks for point in track.points]
    specials = [special for track in tracks for special in track.specials]
    size, along, system = section_map.size, (request.along.name,), request.system

    def placed(cycles: Sequence[Cycle]) -> tuple[np.ndarray, np.ndarray]:
        places = np.array([cycle.place for cycle in cycles]).reshape(-1, size + 1)
        return places, np.array([cycle.n for cycle in cycles], dtype=np.int64)

    places, periods = placed(cycles)
    measured = section_map.measure(places, periods)
    sections = [cycle.points[:, :size] for cycle in cycles]
    values = np.repeat(places[:, size:], periods, axis=0)
    rows = np.column_stack([np.concatenate([np.empty((0, size)), *sections]), values])
    there = placed([special.point.cycle for special in specials])
    return {
        **_filled(_of_points(request), cycles, size),
        **_filled(_of_specials(request), specials, size),
        **_filled(_of_branches(), tracks, size),
        "branch_of_point": np.repeat(np.arange(len(tracks)), [len(t.points) for t in tracks]),
        "state": states_of(system, along, places),
        "section": states_of(system, along, rows),
        "E1max": measured.energy[:, 0],
        **({"E2max": measured.energy[:, 1]} if system.scene.damper else {}),
        "fastest_impact": measured.strokes[:, 0],
        "largest_force": measured.strokes[:, 1],
        "switch": np.array(
            [t.switches.get(at, Switch.NONE) for t in tracks for at in range(len(t.specials))],
            dtype=np.int8,
        ),
        "special_branch": np.repeat(np.arange(len(tracks)), [len(t.specials) for t in tracks]),
        "special_state": states_of(system, along, there[0]),
        "special_E1max": section_map.measure(*there).energy[:, 0],
    }


def _filled(entries: Entries, records: Sequence[Any], size: int) -> Tables:
    """Return the arrays of the datasets that are functions of single records."""
    arrays = {}
    for entry, of in entries:
        if of is not None:
            kind: Any = object if entry.dtype == "str" else entry.dtype
            tail = (size, 2) if "part" in entry.dims else ()
            values = np.array([of(record) for record in records], dtype=kind)
            arrays[entry.name] = values.reshape(len(records), *tail)
    return arrays


def _parts(cycle: Cycle) -> np.ndarray:
    """Return the multipliers of an orbit as real and imaginary parts (size, 2)."""
    return np.stack([cycle.multipliers.real, cycle.multipliers.imag], axis=-1)


def _determinant_error(cycle: Cycle) -> float:
    """Return the relative difference of the product of multipliers and exp(volume).

    If exp(volume) is 0 (an impact with e = 0, a damper that sticks), return the modulus of the
    product.
    """
    product = 1.0 + 0.0j
    for mu in cycle.multipliers.tolist():
        product *= mu
    exact = exp(cycle.volume)
    return abs(abs(product) - exact) / (exact if exact > 0.0 else 1.0)


def scales_of(request: Continuation, tables: Tables) -> list[Scale]:
    components = request.system.scene.components

    def numbered(name: str, like: str, text: str, first: int = 0) -> Scale:
        count = len(tables[like]) if like else len(components)
        return Scale.counted(name, count, text, first)

    return [
        numbered("point", "periodicity", "point of a branch, branch after branch"),
        numbered("row", "section", "state of an orbit, the n of one point after the other"),
        numbered("special", "kind", "special point, branch after branch"),
        numbered("branch", "status", "branch"),
        Scale("component", np.array(components), "1", "component of the state"),
        numbered("multiplier", "", "Floquet multiplier, the largest modulus first", 1),
        Scale("part", np.array(["real", "imaginary"]), "1", "part of a complex number"),
    ]


# ---- curves of special points in the plane of two parameters ----

CURVED = ("LP", "PD", "NS", "GR")
"""The kinds of special points whose curves are followed."""

SAME = 1.0e-7
"""Relative difference of a parameter below which two special points are the same."""

CURVE_END_FLAGS = {word: number for number, word in enumerate(CURVE_ENDS)}


def curves_through(request: Continuation, specials: Sequence[Special], piece: Piece) -> Tables:
    """Follow the curves through `specials` in the plane of both parameters; return their tables.

    A special point on a curve that has been followed has no curve of its own.  `piece` saves each
    curve.
    """
    along, plane = request.free
    second = float(request.system.parameters[plane.name])
    settings = Settings(float(request.tolerance))
    section_map = SectionMap(request.system, (along.name, plane.name), settings)
    low, high = np.array([along.low, plane.low]), np.array([along.high, plane.high])
    curves = [_arrays_of(request, Curve("LP"))]
    for special in specials:
        if special.kind not in CURVED or any(
            _holds(request, arrays, special, second) for arrays in curves
        ):
            continue

        def follow(special: Special = special) -> Arrays:
            tracer = Tracer(section_map, special.kind, low, high)
            place = np.append(special.point.cycle.place, second)
            curve = trace_curve(tracer, place, special.point.cycle.n, special.impacts)
            return _arrays_of(request, curve if curve and curve.points else Curve(special.kind))

        curves.append(piece(follow))
    tables = {name: np.concatenate([arrays[name] for arrays in curves]) for name in curves[0]}
    numbers = np.cumsum([len(arrays["curve_kind"]) for arrays in curves]) - 1
    for name, like in (("curve_of_point", "curve_impact_count"), ("curve_of_meeting", "meeting")):
        tables[name] = np.repeat(numbers, [len(arrays[like]) for arrays in curves])
    return tables | {"meeting": tables["meeting"].astype(object)}


def _holds(request: Continuation, arrays: Arrays, special: Special, second: float) -> bool:
    """Return True if a curve passes a special point at the value `second` of its parameter.

    Between two points, the curve is interpolated by a parabola through three: its error is smaller
    than the distance of two special points of one branch.
    """
    about = arrays["curve_kind"].tolist(), arrays["curve_periodicity"].tolist()
    first, across = (arrays[f"curve_{item.name}"] for item in request.free)
    if about != ([KIND_FLAGS[special.kind]], [special.point.cycle.n]) or len(first) < 3:
        return False
    for i in np.flatnonzero((across[:-1] - second) * (across[1:] - second) <= 0.0):
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


def _arrays_of(request: Continuation, curve: Curve) -> Arrays:
    """Return the datasets of one curve; without points, all are empty."""
    names, size = [item.name for item in request.free], len(request.system.scene.components)
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
        "curve_state": states_of(request.system, names, places),
        "curve_multipliers": np.stack([mu.real, mu.imag], axis=-1),
        **{name: np.array(values, dtype=np.int64) for name, values in whole.items()},
        **{f"meeting_{name}": met[:, i] for i, name in enumerate(names)},
        "meeting": np.array([name for name, _ in curve.meetings], dtype="U8"),
    }


def curve_scales(tables: Mapping[str, np.ndarray]) -> list[Scale]:
    texts = {
        "curve_point": ("curve_of_point", "point of a curve, curve after curve"),
        "curve": ("curve_kind", "curve of special points"),
        "meeting_point": ("meeting", "point where two kinds meet"),
    }
    return [Scale.counted(name, len(tables[like]), text) for name, (like, text) in texts.items()]


def curve_datasets(request: Continuation) -> Iterator[Dataset]:
    point, curve, meeting = ("curve_point",), ("curve",), ("meeting_point",)
    yield Dataset.whole("curve_of_point", point, "curve that a point belongs to")
    for name in (item.name for item in request.free):
        yield PARAMETERS[name].dataset(point, "curve_")
        yield PARAMETERS[name].dataset(meeting, "meeting_")
    yield Dataset.real("curve_state", (*point, "component"), SI, "orbit at phase zero")
    pair = (*point, "multiplier", "part")
    yield Dataset.real("curve_multipliers", pair, "1", "Floquet multipliers")
    yield Dataset.whole("curve_impact_count", point, "k of nT,k")
    yield Dataset.code("curve_kind", curve, "kind of its special points", KIND_FLAGS)
    yield Dataset.whole("curve_periodicity", curve, "n of nT")
    yield Dataset.code("curve_first_end", curve, "reason of its first end", CURVE_END_FLAGS)
    yield Dataset.code("curve_last_end", curve, "reason of its last end", CURVE_END_FLAGS)
    yield Dataset.whole("curve_of_meeting", meeting, "curve that it lies on")
    yield Dataset.text("meeting", meeting, "the kinds that meet")
