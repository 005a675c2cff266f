"""A system and its parameters in a few words, for titles that nobody wrote."""

from __future__ import annotations

import re
from collections.abc import Collection

import numpy as np

from nlds_vines.model.parameters import DESCRIBED, described
from nlds_vines.model.ratios import meant_by
from nlds_vines.model.scenes import SCENES, Scene
from nlds_vines.model.system import System


def system_in_words(system: System) -> str:
    """Return the title of a system, or what it is where it has none but the name of a file."""
    if system.title or not (system.name == system.kind or system.name.endswith(".toml")):
        return system.title or system.name
    name = _name(system.scene)
    alike = sum(_name(scene) == name for scene in SCENES.values())
    return name[:1].upper() + name[1:] + (f" ({system.kind})" if alike > 1 else "")


def _name(scene: Scene) -> str:
    """Return the name of a kind of system, without what explains it."""
    return re.split("[:,]", scene.meaning)[0]


def setting_in_words(name: str, value: float) -> str:
    """Return a parameter with its value and unit, in plain text: K = 2.5e+07 N/m^1.5."""
    return f"{symbol_of(name)} = {with_unit(name, f'{value:g}')}"


def parameters_in_words(system: System, varied: Collection[str] = ()) -> str:
    """Return the kind of a system, its law, and its parameters but for those that are varied."""
    varied = {*varied, *meant_by(system.scene, varied), *system.following(varied)}
    law = f" under {system.law}" if system.scene.walls else ""
    values = (
        f"{name} = {value:g}" for name, value in system.statements.items() if name not in varied
    )
    return f"{system.kind}{law}: {', '.join(values)}"


def range_in_words(name: str, values: np.ndarray) -> str:
    """Return a parameter with the first and the last of its values and their unit."""
    ends = f"{values[0]:g} to {values[-1]:g}"
    return f"{symbol_of(name)} from {with_unit(name, ends)}"


def with_unit(name: str, text: str) -> str:
    """Return a text with the unit of a parameter after it, if that has one."""
    unit = described(name).unit if name in DESCRIBED else "1"
    return text if unit == "1" else f"{text} {unit}"


def symbol_of(name: str) -> str:
    """Return the symbol of a parameter; a wrong name as it is, which is refused later."""
    return described(name).symbol if name in DESCRIBED else name
