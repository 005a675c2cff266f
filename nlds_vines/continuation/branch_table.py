"""What is known of all branches in tables: of their points, of special points, of the branches."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.continuation.branch_arm import ENDS
from nlds_vines.continuation.request import Continuation
from nlds_vines.continuation.section_map import Cycle, SectionMap
from nlds_vines.continuation.special_points import KINDS, label_of_cycle
from nlds_vines.continuation.start_orbits import states_of
from nlds_vines.continuation.whole_branch import Switch, Track
from nlds_vines.kernels.numerics.elementary import exp
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.quantities import BY_NAME

ORIGINS = {"start": 0, "PD": 1, "BP": 2}
"""From where a branch comes: the CF flags of the dataset `origin`."""

KIND_FLAGS = {kind: number for number, kind in enumerate(KINDS)}
END_FLAGS = {word: number for number, word in enumerate(ENDS)}
SWITCH_FLAGS = {outcome.name.lower(): int(outcome) for outcome in Switch}
STATUS_FLAGS = {"complete": 0, "incomplete": 1}
STABLE_FLAGS = {"unstable": 0, "stable": 1}

SI = "m, m/s"
"""Units of the components of a state."""

INCOMPLETE = ("lost", "long")
"""The ends of branches that are not complete."""

Tables = dict[str, np.ndarray]
"""Arrays by the name of a dataset."""

Entries = Iterator[tuple[Dataset, Callable[[Any], Any] | None]]
"""Datasets, and what of a cycle, a special point or a track stands there; None: of all at once."""


def _of_points(request: Continuation) -> Entries:
    """Yield the datasets of all points, of their cycles."""
    dims, free, scene = ("point",), PARAMETERS[request.along.name], request.system.scene
    pair = ("multiplier", "part")
    yield Dataset.whole("branch_of_point", dims, "branch that a point belongs to"), None
    yield free.dataset(dims), lambda c: c.values[0]
    yield Dataset.real("state", (*dims, "component"), SI, "orbit at the first of them"), None
    yield Dataset.real("section", ("row", "component"), SI, "orbits at phase zero"), None
    yield Dataset.whole("periodicity", dims, "n of nT"), lambda c: c.n
    near, far = (f"impacts per nT at the {wall} wall" for wall in ("near", "far"))
    yield Dataset.whole("impacts_near", dims, near), lambda c: c.counts[0]
    yield Dataset.whole("impacts_far", dims, far), lambda c: c.counts[1]
    yield Dataset.text("label", dims, "n and k of nT,k"), label_of_cycle
    words = "whether all multipliers lie inside"
    yield Dataset.code("stable", dims, words, STABLE_FLAGS), lambda c: c.unstable == 0
    yield BY_NAME["multipliers"].dataset((*dims, *pair), scene), _parts
    yield Dataset.real("residual", dims, "1", "what does not close, relative"), lambda c: c.defect
    words = "product of multipliers, relative"
    yield Dataset.real("determinant_error", dims, "1", words), _determinant_error
    yield BY_NAME["E1max"].dataset(dims, scene), None
    yield BY_NAME["E2max"].dataset(dims, scene), None
    yield BY_NAME["clearance"].dataset(dims, scene), lambda c: c.clearance
    yield BY_NAME["softest_impact"].dataset(dims, scene), lambda c: c.slowest
    words = "largest approach speed"
    yield Dataset("fastest_impact", dims, "float64", "m/s", words, 0.0), None
    yield Dataset("largest_force", dims, "float64", "N", "largest contact force", 0.0), None


def _of_specials(request: Continuation) -> Entries:
    """Yield the datasets of all special points."""
    dims, free, scene = ("special",), PARAMETERS[request.along.name], request.system.scene
    pair = ("multiplier", "part")
    yield Dataset.whole("special_branch", dims, "branch that it lies on"), None
    words = "kind of special point"
    yield Dataset.code("kind", dims, words, KIND_FLAGS), lambda s: KIND_FLAGS[s.kind]
    yield free.dataset(dims, "special_"), lambda s: s.point.cycle.values[0]
    yield Dataset.real("special_state", (*dims, "component"), SI, "orbit there"), None
    yield Dataset.whole("special_index", dims, "point of its branch before it"), lambda s: s.index
    yield Dataset.whole("special_periodicity", dims, "n of nT"), lambda s: s.point.cycle.n
    yield BY_NAME["E1max"].dataset(dims, scene, prefix="special_"), None
    yield Dataset.text("before", dims, "label before it along the branch"), lambda s: s.before
    yield Dataset.text("after", dims, "label after it along the branch"), lambda s: s.after
    yield Dataset.text("wall", dims, "wall of a grazing impact"), lambda s: s.wall
    words = "test function there, relative"
    yield Dataset.real("special_residual", dims, "1", words), lambda s: s.residual
    words = "what does not close, relative"
    yield Dataset.real("special_defect", dims, "1", words), lambda s: s.point.cycle.defect
    yield Dataset.real("bracket", dims, free.unit, "width of the last bracket"), lambda s: s.bracket
    words = "what became of the branch that leaves or crosses there"
    yield Dataset.code("switch", dims, words, SWITCH_FLAGS), None
    multipliers = BY_NAME["multipliers"].dataset((*dims, *pair), scene, prefix="special_")
    yield multipliers, lambda s: _parts(s.point.cycle)


def _of_branches() -> Entries:
    """Yield the datasets of all branches, of their tracks."""
    dims = ("branch",)
    incomplete = Dataset.code("status", dims, "whether a branch is complete", STATUS_FLAGS)
    yield incomplete, lambda t: any(end in INCOMPLETE for end in t.ends)
    yield Dataset.code("origin", dims, "where it comes from", ORIGINS), lambda t: ORIGINS[t.origin]
    yield Dataset.whole("parent", dims, "branch that it leaves, -1: none", -1), lambda t: t.parent
    yield Dataset.whole("parent_special", dims, "special point of that branch", -1), lambda t: t.at
    first = Dataset.code("first_end", dims, "why it ends at its beginning", END_FLAGS)
    yield first, lambda t: END_FLAGS[t.ends[0]]
    last = Dataset.code("last_end", dims, "why it ends at its end", END_FLAGS)
    yield last, lambda t: END_FLAGS[t.ends[1]]


def datasets_of(request: Continuation) -> list[Dataset]:
    """Return the datasets of an archive of branches."""
    entries = (*_of_points(request), *_of_specials(request), *_of_branches())
    return [entry for entry, _ in entries]


def tables_of(request: Continuation, section_map: SectionMap, tracks: Sequence[Track]) -> Tables:
    """Return everything that is kept of branches, by the names of datasets."""
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
        "E1max": measured.E1max,
        **({"E2max": measured.E2max} if system.scene.damper else {}),
        "fastest_impact": measured.fastest,
        "largest_force": measured.force,
        "switch": np.array(
            [t.switches.get(at, Switch.NONE) for t in tracks for at in range(len(t.specials))],
            dtype=np.int8,
        ),
        "special_branch": np.repeat(np.arange(len(tracks)), [len(t.specials) for t in tracks]),
        "special_state": states_of(system, along, there[0]),
        "special_E1max": section_map.measure(*there).E1max,
    }


def _filled(entries: Entries, records: Sequence[Any], size: int) -> Tables:
    """Return the arrays of datasets, as far as each record tells its own value."""
    found = {}
    for entry, of in entries:
        if of is not None:
            kind: Any = object if entry.dtype == "str" else entry.dtype
            tail = (size, 2) if "part" in entry.dims else ()
            values = np.array([of(record) for record in records], dtype=kind)
            found[entry.name] = values.reshape(len(records), *tail)
    return found


def _parts(cycle: Cycle) -> np.ndarray:
    """Return the multipliers of an orbit as real and imaginary parts (size, 2)."""
    return np.stack([cycle.multipliers.real, cycle.multipliers.imag], axis=-1)


def _determinant_error(cycle: Cycle) -> float:
    """Return by how much the product of multipliers differs from exp(volume), relatively.

    Where it has to be 0, as an impact with e = 0 or a damper that sticks makes it: its modulus.
    """
    product = 1.0 + 0.0j
    for mu in cycle.multipliers.tolist():
        product *= mu
    wanted = exp(cycle.volume)
    return abs(abs(product) - wanted) / (wanted if wanted > 0.0 else 1.0)


def scales_of(request: Continuation, tables: Tables) -> list[Scale]:
    """Return the dimensions of an archive of branches."""
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
