"""The paper's kinds as formulas: from parameters by name to the records that the kernels read.

Parameters are floats, or arrays if they vary.  `SCENES` says for each kind, ssul for one, which
parameters it has, and where its spring rests and its walls stand; `merged_parameters` checks them,
and `records_of` writes a record of numbers for each cell (`Preset.cells`), which the kernels'
constants, `engine.batch.parts_of`, tell how to read.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.errors import RequestError, choice, number, shown, table, unknown
from nlds_vines.model.parameters import (
    CONSTANTS,
    CONTACT,
    HERTZ,
    LAWS,
    PARAMETERS,
    SECOND,
    Law,
    hertz_stiffness,
)
from nlds_vines.model.ratios import (
    ratios_in,
    without_ratios,
)
from nlds_vines.model.scenes import BASES, SCENES, Scene

_FIELDS = {  # of a cell, by parameters that are copied; a single mass has names of its own
    **{name: name for name in ("m1", "k1", "c1", "m2", "k2", "c2", "P", "omega")},
    **{"m": "m1", "k": "k1", "c": "c1"},
}

CELL = np.dtype(
    [
        (name, np.float64)
        for name in (*dict.fromkeys(_FIELDS.values()), "K", "near", "far", "rest", "limit")
    ]
)
"""The record of one cell of a scan under Hertz' law, as the kernels read it, in SI units.

Its fields are the parameters of equation (5); the contact stiffness K [N/m^1.5]; `near`, the
spring's shortening, and `far`, its lengthening [m], at which the walls are touched; the rest offset
`rest` [m]; `limit`, the shortening [m] that must not be reached. A field that the scene does not
have is 0, and no kernel reads it."""

_OF_LAWS = tuple(name for name in CONSTANTS if name != "K")
NEAR = "near_contact"  # the field for the constants of the near wall, if it has its own


def cell_type(scene: Scene) -> np.dtype:
    """Return the type of the records of a scene's cells: `CELL`, and the fields of other laws.

    These are the constants of the laws, nested in `NEAR` for a near wall of its own, and `load`.
    """
    has_others = bool(scene.walls) and (scene.laws != (HERTZ,) or bool(scene.optional))
    return _cell_type(scene.load is not None, scene.law_2 is not None, has_others)


@cache
def _cell_type(has_load: bool, has_second: bool, has_others: bool) -> np.dtype:
    constants: list[Any] = [(name, np.float64) for name in _OF_LAWS]
    others: list[Any] = []
    if has_load:
        others.append(("load", np.float64))
    if has_second:
        others.append((NEAR, [("K", np.float64), *constants]))
    if has_others:
        others += constants
    # before those of CELL: Numba takes a type of records that begins with the fields of another
    # one for a subtype of it
    return np.dtype([*others, *((name, np.float64) for name in CELL.names or ())])


def records_of(scene: Scene, values: Mapping[str, Any], shape: tuple[int, ...]) -> np.ndarray:
    """Return the records (shape) of parameters that are floats or arrays."""
    cells = np.zeros(shape, cell_type(scene))
    for name, field_name in _FIELDS.items():
        if name in values:
            cells[field_name] = values[name]
    if "P" not in values:
        cells["P"] = _force(scene, values)
    for name, part in (
        ("near", scene.gap_near), ("far", scene.gap_far), ("rest", scene.rest),
        ("limit", scene.limit), ("load", scene.load),
    ):  # fmt: skip
        if part is not None:
            with np.errstate(over="ignore"):
                cells[name] = part(values)
            if not np.isfinite(cells[name]).all():
                raise RequestError(f"parameters out of proportion: {name} is not finite")
    # a damper is in one contact at a time
    if len(scene.walls) == 2 and np.any((room := cells["near"] + cells["far"]) < 0):
        raise RequestError(
            f"the walls are {float(np.min(room))!r} m apart: their distance must be >= 0"
        )
    if scene.limit is not None and np.any(cells["limit"] <= 0):
        raise RequestError(
            f"D = {float(np.min(values['D']))!r}: a damper of kind {scene.kind!r} would rest at or "
            "beyond its limit; D, or D + L, must be > 0"
        )
    for wall in scene.walls:
        ending, is_hertz = scene.ending(wall), scene.law_at(wall) == HERTZ
        constants = cells[NEAR] if scene.law_2 and wall == "near" else cells
        for name in ("K", *_OF_LAWS):
            if name + ending in values:
                constants[name] = values[name + ending]
        if is_hertz and scene.is_damped(wall):
            constants["exponent"] = 1.5
        if is_hertz and "K" + ending not in values:
            of_hertz = tuple(values[name] for name in CONTACT)
            is_one = all(isinstance(value, float) for value in of_hertz)
            stiffness = hertz_stiffness if is_one else hertz_stiffness.__wrapped__
            constants["K"] = stiffness(*of_hertz)
    return cells


def _force(scene: Scene, values: Mapping[str, Any]) -> Any:
    """Return the force [N] on the structure, relative to moving ground, at t = 0.

    It is minus the structure's mass times the ground's acceleration: m Y omega^2 for the
    displacement Y cos(omega t), and -m a for the acceleration a cos(omega t).
    """
    mass = values["m1"] if "m1" in values else values["m"]
    name = next(name for name in ("Y", *BASES) if name in values)
    with np.errstate(all="ignore"):
        if name == "base_acceleration":
            force = -mass * values[name]
        else:
            force = mass * values[name] * values["omega"] * values["omega"]
    if not np.all(np.isfinite(force)):
        raise RequestError(f"{name} out of proportion: the force on the structure is not finite")
    return force


def modulus(real: Any, imaginary: Any) -> np.ndarray:
    """Return sqrt(real^2 + imaginary^2) without overflow of the squares.

    NumPy's complex modulus, and so an archive, would depend on the processor.
    """
    one, other = np.abs(real), np.abs(imaginary)
    most = np.maximum(one, other)
    share = np.where((most > 0) & (most < np.inf), np.minimum(one, other) / most, 0.0)
    return most * np.sqrt(1 + share * share)


def check_law(kind: str, law: str, law_2: str) -> None:
    choice("law", law, LAWS)
    scene = SCENES[kind]
    if law != HERTZ.name and not scene.walls:
        raise RequestError(f"law = {law!r}: kind {kind!r} has no contact")
    if not isinstance(law_2, str) or law_2:
        choice("law_2", law_2, LAWS)
        if not scene.second:
            two = [name for name, other in SCENES.items() if other.second]
            raise RequestError(
                f"law_2 = {law_2!r}: kind {kind!r} has no second wall; of two walls: "
                f"{', '.join(two)}"
            )


def _named(scene: Scene) -> str:
    text = f"kind {scene.kind!r}" + (f" under law {scene.law.name!r}" * (scene.law != HERTZ))
    return text + (f" and law_2 {scene.law_2.name!r}" if scene.law_2 else "")


def refuse_contradiction(names: Collection[str]) -> None:
    beside = [name for name in CONTACT if name in names]
    if beside and "K" in names:
        raise RequestError(f"K beside {', '.join(beside)}: give K or the contact constants")


def refuse_foreign(scene: Scene, names: Iterable[str]) -> None:
    name = next((name for name in names if name not in scene.allowed), None)
    if name is None:
        return
    if name not in PARAMETERS:
        raise unknown("parameter", name, (*scene.allowed, *ratios_in(scene)))
    constant, key = name.removesuffix(SECOND), "law_2" if name.endswith(SECOND) else "law"
    laws = [law.name for law in LAWS.values() if constant in law.allowed]
    if laws and (scene.second if key == "law_2" else scene.walls):
        law: Law | None = scene.law_2 if key == "law_2" else scene.law
        present = f"{key} {law.name!r}" if law else f"without {key}, kind {scene.kind!r}"
        raise RequestError(
            f"{present} has no parameter {name!r} ({PARAMETERS[name].meaning}): {key} = "
            f"{' or '.join(map(repr, laws))} has it; allowed: {', '.join(scene.allowed)}"
        )
    raise RequestError(
        f"{_named(scene)} has no parameter {name!r} ({PARAMETERS[name].meaning}); "
        f"allowed: {', '.join(scene.allowed)}"
    )


def ratios_among(scene: Scene, values: Mapping[str, Any]) -> dict[str, float]:
    """Return the ratios among `values` whose unit depends on parameters."""
    ratios = ratios_in(scene).items()
    return {name: number(name, values[name]) for name, r in ratios if r.needs and name in values}


def merged_parameters(
    scene: Scene,
    before: Mapping[str, Any],
    changes: Mapping[str, Any],
    ratios: Mapping[str, float] = MappingProxyType({}),
) -> dict[str, Any]:
    """Merge `changes`, ratios among them, into the parameters `before`, in the scene's order.

    A parameter that was set as one of `ratios` follows from the changed ones.
    """
    if isinstance(changes.get("P"), Mapping):  # P = { base_displacement = Y } means that parameter
        inner = table("P", changes["P"], BASES)
        if len(inner) != 1:
            raise RequestError(f"P = {shown(dict(inner))} must have one key, of {', '.join(BASES)}")
        (name,) = inner
        if name in changes:
            raise RequestError(f"{name} stands beside P = {{ {name} = ... }}: give it once")
        changes = {key: value for key, value in changes.items() if key != "P"} | dict(inner)
    changes = without_ratios(scene, before, changes, ratios)
    refuse_foreign(scene, changes)
    refuse_contradiction(changes)
    constants = [name for name in CONTACT if name in changes]
    merged: dict[str, Any] = {**before, **changes}
    if "K" in changes:
        merged = {name: value for name, value in merged.items() if name not in CONTACT}
    elif constants:
        merged.pop("K", None)
    drives = [name for name in scene.drives if name in changes]
    if len(drives) > 1:
        raise RequestError(f"{drives[0]} beside {drives[1]}: give one of {', '.join(scene.drives)}")
    if drives:
        merged = {k: v for k, v in merged.items() if k in drives or k not in scene.drives}
    names = scene.own_of(merged) + scene.contact(merged)
    missing = ", ".join(name for name in names if name not in merged)
    if missing and "K" in before:
        raise RequestError(
            f"{', '.join(constants)} given for a system whose K is given: "
            f"give also {missing}, or K instead"
        )
    if missing:
        if HERTZ in scene.laws and not {*CONTACT}.isdisjoint(missing.split(", ")):
            missing += f"; K may replace {CONTACT[0]} to {CONTACT[-1]}"
        raise RequestError(f"parameters of {_named(scene)} are missing: {missing}")
    return {name: merged[name] for name in names}
