"""The curves of special points in a plane of two parameters: found, and kept in tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.continuation.branch_table import KIND_FLAGS, SI
from nlds_vines.continuation.request import Continuation
from nlds_vines.continuation.section_map import SectionMap
from nlds_vines.continuation.special_curves import ENDS, Curve, Tracer, trace_curve
from nlds_vines.continuation.special_points import KINDS, Special
from nlds_vines.continuation.start_orbits import states_of
from nlds_vines.continuation.whole_branch import Piece
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.orbits.solver_settings import Settings
from nlds_vines.runs.store import Arrays

CURVED = ("LP", "PD", "NS", "GR")
"""The special points that a plane has curves of."""

SAME = 1.0e-7
"""Relative difference of a parameter of two special points that are one."""

END_FLAGS = {word: number for number, word in enumerate(ENDS)}


def curves_through(
    request: Continuation,
    specials: Sequence[Special],
    piece: Piece,
) -> dict[str, np.ndarray]:
    """Follow the curves of special points in the plane of both parameters; return their tables.

    Arguments: the `specials` that were found along the first; `piece` as `run.compute`
    has it.  A special point on a curve that is known has no curve of its own.
    """
    plane = request.plane
    assert plane is not None
    along, own = request.along, float(request.system.parameters[plane.name])
    settings = Settings(float(request.tolerance))
    section_map = SectionMap(request.system, (along.name, plane.name), settings)
    low, high = np.array([along.low, plane.low]), np.array([along.high, plane.high])
    found: list[Arrays] = []
    for special in specials:
        if special.kind not in CURVED or any(_holds(arrays, special, own) for arrays in found):
            continue

        def follow(special: Special = special) -> Arrays:
            tracer = Tracer(section_map, special.kind, low, high)
            place = np.append(special.point.cycle.place, own)
            curve = trace_curve(tracer, place, special.point.cycle.n, special.impacts)
            return _arrays_of(request, section_map, special, curve)

        found.append(piece(follow))
    return _tables(request, [arrays for arrays in found if len(arrays["values"])])


def _holds(arrays: Arrays, special: Special, own: float) -> bool:
    """Tell whether a special point lies on a curve, where this crosses the first parameter's line.

    Between two of its points, a parabola through three is nearer than points of one branch are.
    """
    kind, n = arrays["about"][:2].tolist()
    values = arrays["values"]
    if (KINDS[kind], n) != (special.kind, special.point.cycle.n) or len(values) < 3:
        return False
    for i in np.flatnonzero((values[:-1, 1] - own) * (values[1:, 1] - own) <= 0.0):
        j = min(max(int(i) - 1, 0), len(values) - 3)
        x, y = values[j : j + 3, 1], values[j : j + 3, 0]
        value = sum(
            y[k] * np.prod([(own - x[m]) / (x[k] - x[m]) for m in range(3) if m != k])
            for k in range(3)
        )
        step = abs(values[i + 1, 0] - values[i, 0])
        if abs(value - special.value) <= max(SAME * abs(special.value), 1.0e-2 * step):
            return True
    return False


def _arrays_of(
    request: Continuation, section_map: SectionMap, special: Special, curve: Curve | None
) -> Arrays:
    """Return a curve as arrays; those of None hold no point."""
    size = section_map.size
    points = [] if curve is None else [point.cycle for point in curve.points]
    meetings = [] if curve is None else curve.meetings
    ends = (-1, -1) if curve is None else tuple(END_FLAGS[end] for end in curve.ends)
    places = np.array([cycle.place for cycle in points]).reshape(-1, size + 2)
    cycles = [meeting.point.cycle for meeting in meetings]
    mu = np.array([cycle.multipliers for cycle in points], dtype=complex).reshape(-1, size)
    about = [KIND_FLAGS[special.kind], special.point.cycle.n, *ends]
    return {
        "about": np.array(about, dtype=np.int64),
        "values": places[:, size:],
        "states": states_of(request.system, _names(request), places),
        "multipliers": np.stack([mu.real, mu.imag], axis=-1),
        "impacts": np.array([sum(cycle.counts) for cycle in points], dtype=np.int64),
        "names": np.array([meeting.name for meeting in meetings], dtype="U8"),
        "meetings": np.array([cycle.values for cycle in cycles]).reshape(-1, 2),
    }


def _tables(request: Continuation, found: Sequence[Arrays]) -> dict[str, np.ndarray]:
    """Return the tables of all curves, by the names of datasets."""
    names, size = _names(request), len(request.system.scene.components)

    def joined(key: str, *shape: int) -> np.ndarray:
        return np.concatenate([np.empty((0, *shape)), *(arrays[key] for arrays in found)])

    about = np.array([arrays["about"] for arrays in found], dtype=np.int64).reshape(-1, 4)
    counts = [len(arrays["values"]) for arrays in found]
    met = [len(arrays["meetings"]) for arrays in found]
    values, meetings = joined("values", 2), joined("meetings", 2)
    return {
        "curve_of_point": np.repeat(np.arange(len(found)), counts),
        **{f"curve_{name}": values[:, i] for i, name in enumerate(names)},
        "curve_state": joined("states", size),
        "curve_multipliers": joined("multipliers", size, 2),
        "curve_impact_count": joined("impacts").astype(np.int64),
        "curve_kind": about[:, 0].astype(np.int8),
        "curve_periodicity": about[:, 1],
        "curve_first_end": about[:, 2].astype(np.int8),
        "curve_last_end": about[:, 3].astype(np.int8),
        "curve_of_meeting": np.repeat(np.arange(len(found)), met),
        **{f"meeting_{name}": meetings[:, i] for i, name in enumerate(names)},
        "meeting": np.array([str(n) for a in found for n in a["names"]], dtype=object),
    }


def _names(request: Continuation) -> tuple[str, str]:
    assert request.plane is not None
    return request.along.name, request.plane.name


def curve_scales(tables: Mapping[str, np.ndarray]) -> list[Scale]:
    """Return the dimensions of curves in an archive."""
    texts = {
        "curve_point": ("curve_of_point", "point of a curve, curve after curve"),
        "curve": ("curve_kind", "curve of special points"),
        "meeting_point": ("meeting", "point where two kinds meet"),
    }
    return [Scale.counted(name, len(tables[like]), text) for name, (like, text) in texts.items()]


def curve_datasets(request: Continuation) -> Iterator[Dataset]:
    """Yield the datasets of curves in an archive."""
    point, curve, meeting = ("curve_point",), ("curve",), ("meeting_point",)
    yield Dataset.whole("curve_of_point", point, "curve that a point belongs to")
    for name in _names(request):
        yield PARAMETERS[name].dataset(point, "curve_")
        yield PARAMETERS[name].dataset(meeting, "meeting_")
    yield Dataset.real("curve_state", (*point, "component"), SI, "orbit at phase zero")
    pair = (*point, "multiplier", "part")
    yield Dataset.real("curve_multipliers", pair, "1", "Floquet multipliers")
    yield Dataset.whole("curve_impact_count", point, "k of nT,k")
    yield Dataset.code("curve_kind", curve, "kind of its special points", KIND_FLAGS)
    yield Dataset.whole("curve_periodicity", curve, "n of nT")
    yield Dataset.code("curve_first_end", curve, "why it ends at first", END_FLAGS)
    yield Dataset.code("curve_last_end", curve, "why it ends at last", END_FLAGS)
    yield Dataset.whole("curve_of_meeting", meeting, "curve that it lies on")
    yield Dataset.text("meeting", meeting, "the kinds that meet")
