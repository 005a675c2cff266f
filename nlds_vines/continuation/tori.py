"""A scan beside each NS: the torus that begins there, followed until it locks or breaks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nlds_vines.continuation.exploration import Piece, Track
from nlds_vines.continuation.request import Continuation
from nlds_vines.continuation.result import Tables
from nlds_vines.continuation.special_points import Special
from nlds_vines.engine.classification import Regime, classify
from nlds_vines.engine.section_map import SectionMap
from nlds_vines.model.labels import QUASIPERIODIC, UNDETERMINED
from nlds_vines.runs.interrupts import check
from nlds_vines.runs.store import Arrays

ASIDE = 1.0e-3  # distance of the first start from the unstable orbit, relative to its state
ON_TORUS = (QUASIPERIODIC, UNDETERMINED)  # regimes that end no torus: too weak a lock, or too slow
BISECTIONS = 10  # of the border at which the torus ends: it is sharp to 1/1000 of a cell


def tori_beside(
    request: Continuation, section_map: SectionMap, tracks: Sequence[Track], piece: Piece
) -> Tables:
    """Follow the torus at each NS where a stable orbit loses its stability; return its cells."""
    values, labels, numbers = list[float](), list[str](), list[int]()
    number = 0  # among the special points of all tracks
    for track in tracks:
        for special in track.specials:
            end = _far_end(request, track, special)
            if end is not None:

                def follow(special: Special = special, end: float = end) -> Arrays:
                    return _cells(request, section_map, special, end)

                cells = piece(follow)
                values += cells["value"].tolist()
                labels += cells["label"].tolist()
                numbers += [number] * len(cells["value"])
            number += 1
    return {
        "torus_special": np.array(numbers, dtype=np.int64),
        f"torus_{request.along.name}": np.array(values),
        "torus_label": np.array(labels, dtype=object),
    }


def _far_end(request: Continuation, track: Track, special: Special) -> float | None:
    """Return the value up to which the torus of an NS is searched for; None if it is not stable.

    It is that of the next NS of the branch on the side where the orbit is unstable, or the end of
    the interval.
    """
    if special.kind != "NS":
        return None
    before, after = track.points[special.index : special.index + 2]
    unstable = (before.cycle.unstable, after.cycle.unstable)
    if min(unstable) > 0 or before.value == after.value:
        return None
    upwards = (unstable[1] > 0) == (after.value > before.value)
    along = request.along
    others = [other.value for other in track.specials if other.kind == "NS"]
    if upwards:
        return min([value for value in others if value > special.value] or [along.high])
    return max([value for value in others if value < special.value] or [along.low])


def _cells(request: Continuation, section_map: SectionMap, special: Special, end: float) -> Arrays:
    """Return values and labels of the attractor that is followed from an NS to the value `end`."""
    orbit = section_map.states_of(special.point.cycle.place[np.newaxis])[0]
    name, first = request.along.name, special.value

    def regime_at(value: float, state: np.ndarray) -> Regime:
        check()
        return classify(request.system.with_(**{name: value}), start=state, quiet=True)

    cells: dict[float, str] = {}
    last, state = first, orbit * (1.0 + ASIDE)
    border: tuple[float, float, np.ndarray] | None = None
    for i in range(1, request.tori + 1):
        value = first + (end - first) * i / (request.tori + 1)
        regime = regime_at(value, state)
        if border is None and regime.kind not in ON_TORUS:
            border = last, value, state
        cells[value] = regime.label
        last, state = value, regime.state
    if border is not None and len(cells) > 1 and border[0] != first:
        near, far, state = border
        for _ in range(BISECTIONS):
            middle = 0.5 * (near + far)
            regime = regime_at(middle, state)
            cells[middle] = regime.label
            if regime.kind in ON_TORUS:
                near, state = middle, regime.state
            else:
                far = middle
    ordered = sorted(cells, key=lambda value: abs(value - first))
    return {
        "value": np.array(ordered),
        "label": np.array([cells[value] for value in ordered], dtype="U64"),
    }
