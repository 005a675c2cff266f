"""What is known of all branches in tables: of their points, of special points, of the branches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.continuation.branch_arm import ENDS
from nlds_vines.continuation.request import Continuation
from nlds_vines.continuation.section_map import SectionMap
from nlds_vines.continuation.special_points import KINDS, label_of_cycle
from nlds_vines.continuation.start_orbits import states_of
from nlds_vines.continuation.whole_branch import Track
from nlds_vines.kernels.numerics.elementary import exp
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.quantities import BY_NAME

ORIGINS = {"start": 0, "PD": 1, "BP": 2}
"""From where a branch comes: the CF flags of the dataset `origin`."""

KIND_FLAGS = {kind: number for number, kind in enumerate(KINDS)}
END_FLAGS = {word: number for number, word in enumerate(ENDS)}
STATUS_FLAGS = {"complete": 0, "incomplete": 1}
STABLE_FLAGS = {"unstable": 0, "stable": 1}

INCOMPLETE = ("lost", "long")
"""The ends of branches that are not complete."""

Tables = dict[str, np.ndarray]
"""Arrays by the name of a dataset."""


def tables_of(request: Continuation, section_map: SectionMap, tracks: Sequence[Track]) -> Tables:
    """Return everything that is kept of branches, by the names of datasets."""
    return {
        **_points(request, section_map, tracks),
        **_specials(request, section_map, tracks),
        **_branches(tracks),
    }


def _points(request: Continuation, section_map: SectionMap, tracks: Sequence[Track]) -> Tables:
    """Return the tables of all points, branch after branch."""
    points = [point for track in tracks for point in track.points]
    cycles = [point.cycle for point in points]
    size, name = section_map.size, request.along.name
    places = np.array([cycle.place for cycle in cycles]).reshape(-1, size + 1)
    periods = np.array([cycle.n for cycle in cycles], dtype=np.int64)
    measured = section_map.measure(places, periods)
    sections = [cycle.points[:, :size] for cycle in cycles]
    values = np.repeat(places[:, size:], periods, axis=0)
    rows = np.column_stack([np.concatenate([np.empty((0, size)), *sections]), values])
    found = {
        "section": states_of(request.system, (name,), rows),
        "branch_of_point": np.repeat(np.arange(len(tracks)), [len(t.points) for t in tracks]),
        name: places[:, size],
        "state": states_of(request.system, (name,), places),
        "period": periods,
        "impacts_near": np.array([c.counts[0] for c in cycles], dtype=np.int64),
        "impacts_far": np.array([c.counts[1] for c in cycles], dtype=np.int64),
        "label": np.array([label_of_cycle(c) for c in cycles], dtype=object),
        "stable": np.array([c.unstable == 0 for c in cycles], dtype=np.int8),
        "multipliers": _pairs([c.multipliers for c in cycles], size),
        "residual": np.array([c.defect for c in cycles]),
        "determinant_error": np.array(
            [_determinant_error(c.multipliers, c.volume) for c in cycles]
        ),
        "E1max": measured.E1max,
        "clearance": np.array([c.clearance for c in cycles]),
        "softest_impact": np.array([c.slowest for c in cycles]),
        "fastest_impact": measured.fastest,
        "largest_force": measured.force,
    }
    if request.system.scene.damper:
        found["E2max"] = measured.E2max
    return found


def _pairs(multipliers: Sequence[np.ndarray], size: int) -> np.ndarray:
    """Return complex numbers as real and imaginary parts (count, size, 2)."""
    values = np.array(multipliers, dtype=complex).reshape(-1, size)
    return np.stack([values.real, values.imag], axis=-1)


def _determinant_error(multipliers: np.ndarray, volume: float) -> float:
    """Return by how much the product of multipliers differs from exp(volume), relatively.

    Where it has to be 0, as an impact with e = 0 or a damper that sticks makes it: its modulus.
    """
    product = 1.0 + 0.0j
    for mu in multipliers.tolist():
        product *= mu
    wanted = exp(volume)
    return abs(abs(product) - wanted) / (wanted if wanted > 0.0 else 1.0)


def _specials(request: Continuation, section_map: SectionMap, tracks: Sequence[Track]) -> Tables:
    found = [(i, special) for i, track in enumerate(tracks) for special in track.specials]
    cycles, size = [s.point.cycle for _, s in found], len(request.system.scene.components)
    places = np.array([cycle.place for cycle in cycles]).reshape(-1, size + 1)
    name, periods = request.along.name, np.array([cycle.n for cycle in cycles], dtype=np.int64)
    return {
        "special_branch": np.array([i for i, _ in found], dtype=np.int64),
        "kind": np.array([KIND_FLAGS[s.kind] for _, s in found], dtype=np.int8),
        f"special_{name}": places[:, size],
        "special_state": states_of(request.system, (name,), places),
        "special_period": periods,
        "special_index": np.array([s.index for _, s in found], dtype=np.int64),
        "special_E1max": section_map.measure(places, periods).E1max,
        "before": np.array([s.before for _, s in found], dtype=object),
        "after": np.array([s.after for _, s in found], dtype=object),
        "wall": np.array([s.wall for _, s in found], dtype=object),
        "special_residual": np.array([s.residual for _, s in found]),
        "special_defect": np.array([cycle.defect for cycle in cycles]),
        "bracket": np.array([s.bracket for _, s in found]),
        "special_multipliers": _pairs([c.multipliers for c in cycles], size),
    }


def _branches(tracks: Sequence[Track]) -> Tables:
    return {
        "status": np.array([any(e in INCOMPLETE for e in t.ends) for t in tracks], dtype=np.int8),
        "origin": np.array([ORIGINS[t.origin] for t in tracks], dtype=np.int8),
        "parent": np.array([t.parent for t in tracks], dtype=np.int64),
        "parent_special": np.array([t.at for t in tracks], dtype=np.int64),
        "first_end": np.array([END_FLAGS[t.ends[0]] for t in tracks], dtype=np.int8),
        "last_end": np.array([END_FLAGS[t.ends[1]] for t in tracks], dtype=np.int8),
    }


# ---- the archive ---------------------------------------------------------------------------------


def scales_of(request: Continuation, tables: Tables) -> list[Scale]:
    """Return the dimensions of an archive of branches."""
    components = request.system.scene.components

    def numbered(name: str, like: str, text: str, first: int = 0) -> Scale:
        count = len(tables[like]) if like else len(components)
        return Scale.counted(name, count, text, first)

    return [
        numbered("point", "period", "point of a branch, branch after branch"),
        numbered("row", "section", "state of an orbit, the n of one point after the other"),
        numbered("special", "kind", "special point, branch after branch"),
        numbered("branch", "status", "branch"),
        Scale("component", np.array(components), "1", "component of the state"),
        numbered("multiplier", "", "Floquet multiplier, the largest modulus first", 1),
        Scale("part", np.array(["real", "imaginary"]), "1", "part of a complex number"),
    ]


def datasets_of(request: Continuation) -> list[Dataset]:
    """Return the datasets of an archive of branches."""
    free, scene = PARAMETERS[request.along.name], request.system.scene
    point, special, branch = ("point",), ("special",), ("branch",)
    pair = ("multiplier", "part")
    si, nan = "m, m/s", np.nan

    def recorded(name: str, *dims: str, prefix: str = "") -> Dataset:
        """Return what scans record as well."""
        return BY_NAME[name].dataset(dims, scene, prefix=prefix)

    return [
        Dataset("branch_of_point", point, "int32", "1", "branch that a point belongs to", 0),
        free.dataset(point),
        Dataset("state", (*point, "component"), "float64", si, "orbit at the first of them", nan),
        Dataset("section", ("row", "component"), "float64", si, "orbits at phase zero", nan),
        Dataset("period", point, "int32", "1", "n of nT", 0),
        Dataset("impacts_near", point, "int32", "1", "impacts per nT at the near wall", 0),
        Dataset("impacts_far", point, "int32", "1", "impacts per nT at the far wall", 0),
        Dataset("label", point, "str", "1", "n and k of nT,k", ""),
        Dataset(
            "stable", point, "int8", "1", "whether all multipliers lie inside", 0, STABLE_FLAGS
        ),
        recorded("multipliers", *point, *pair),
        Dataset("residual", point, "float64", "1", "what does not close, relative", nan),
        Dataset(
            "determinant_error", point, "float64", "1", "product of multipliers, relative", nan
        ),
        recorded("E1max", *point),
        recorded("E2max", *point),
        recorded("clearance", *point),
        recorded("softest_impact", *point),
        Dataset("fastest_impact", point, "float64", "m/s", "largest approach speed", 0.0),
        Dataset("largest_force", point, "float64", "N", "largest contact force", 0.0),
        Dataset("special_branch", special, "int32", "1", "branch that it lies on", 0),
        Dataset("kind", special, "int8", "1", "kind of special point", 0, KIND_FLAGS),
        free.dataset(special, "special_"),
        Dataset("special_state", (*special, "component"), "float64", si, "orbit there", nan),
        Dataset("special_index", special, "int32", "1", "point of its branch before it", 0),
        Dataset("special_period", special, "int32", "1", "n of nT", 0),
        recorded("E1max", *special, prefix="special_"),
        Dataset("before", special, "str", "1", "label before it along the branch", ""),
        Dataset("after", special, "str", "1", "label after it along the branch", ""),
        Dataset("wall", special, "str", "1", "wall of a grazing impact", ""),
        Dataset("special_residual", special, "float64", "1", "test function there, relative", nan),
        Dataset("special_defect", special, "float64", "1", "what does not close, relative", nan),
        Dataset("bracket", special, "float64", free.unit, "width of the last bracket", nan),
        recorded("multipliers", *special, *pair, prefix="special_"),
        Dataset("status", branch, "int8", "1", "whether a branch is complete", 0, STATUS_FLAGS),
        Dataset("origin", branch, "int8", "1", "where it comes from", 0, ORIGINS),
        Dataset("parent", branch, "int32", "1", "branch that it leaves, -1: none", -1),
        Dataset("parent_special", branch, "int32", "1", "special point of that branch", -1),
        Dataset("first_end", branch, "int8", "1", "why it ends at its beginning", 0, END_FLAGS),
        Dataset("last_end", branch, "int8", "1", "why it ends at its end", 0, END_FLAGS),
    ]
