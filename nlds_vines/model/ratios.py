"""Ratios and frequencies in place of parameters: damping ratios, mass ratio, Hz.

Each stands for one parameter, which is so many times a unit that follows from others:

    zeta1        c1 = zeta1 2 sqrt(k1 m1)         zeta, of an oscillator: c = zeta 2 sqrt(k m)
    zeta2        c2 = zeta2 2 sqrt(k2 m2)         mass_ratio: m2 = mass_ratio m1
    f            omega = f 2 pi                   omega_ratio: omega = omega_ratio sqrt(k1 / m1)

What is set as a ratio stays at that ratio: `System` keeps it, and computes its parameter again
whenever a parameter changes that the unit follows from.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from nlds_vines.errors import RequestError, number
from nlds_vines.model import parameters
from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import PARAMETERS, Parameter
from nlds_vines.model.scenes import Scene


@dataclass(frozen=True)
class Ratio:
    """A number in place of a parameter.

    Attributes:
        what: its name, symbol, unit, meaning and range.
        gives: the name of the parameter that it stands for.
        needs: the parameters that its unit follows from.
        unit: returns, from these in their order (floats or arrays), the value of the parameter
            where the ratio is 1 [SI].
    """

    what: Parameter
    gives: str
    needs: tuple[str, ...]
    unit: Callable[..., Any]

    @property
    def name(self) -> str:
        """As in files and Python."""
        return self.what.name

    def fits(self, scene: Scene) -> bool:
        """Return True if a scene has its parameters."""
        return {self.gives, *self.needs} <= set(scene.own)

    def unit_of(self, values: Mapping[str, Any]) -> Any:
        """Return its unit among parameters (floats or arrays).

        Raises `RequestError` where one is missing, or makes the unit zero.
        """
        missing = [name for name in self.needs if name not in values]
        if missing:
            raise RequestError(f"{self.name} needs {' and '.join(missing)}, which is missing")
        needed = {name: _numbers(name, values[name]) for name in self.needs}
        if not all(np.all(np.asarray(value) > 0.0) for value in needed.values()):
            unsuitable = ", ".join(f"{name} = {float(np.min(v))!r}" for name, v in needed.items())
            raise RequestError(f"{self.name} means nothing with {unsuitable}: give {self.gives}")
        return self.unit(*needed.values())


def _numbers(name: str, value: Any) -> Any:
    """Return a float, or an array of floats as it is."""
    return value if isinstance(value, np.ndarray) else number(name, value)


def _critical(k: Any, m: Any) -> Any:
    return 2.0 * np.sqrt(k * m)


def _own_frequency(k: Any, m: Any) -> Any:
    return np.sqrt(k / m)


def _ratio(name: str, gives: str, needs: tuple[str, ...], unit: Callable[..., Any]) -> Ratio:
    return Ratio(parameters.RATIOS[name], gives, needs, unit)


RATIOS = (
    _ratio("mass_ratio", "m2", ("m1",), lambda m: m),
    _ratio("zeta1", "c1", ("k1", "m1"), _critical),
    _ratio("zeta2", "c2", ("k2", "m2"), _critical),
    _ratio("zeta", "c", ("k", "m"), _critical),
    _ratio("f", "omega", (), lambda: 2.0 * pi),
    _ratio("omega_ratio", "omega", ("k1", "m1"), _own_frequency),
    _ratio("omega_ratio", "omega", ("k", "m"), _own_frequency),
)
"""All ratios, those first from which others may follow."""


def ratios_in(scene: Scene) -> dict[str, Ratio]:
    """Return the ratios that may be given of a scene, by name."""
    return {ratio.name: ratio for ratio in RATIOS if ratio.fits(scene)}


def meant_by(scene: Scene, names: Collection[str]) -> list[str]:
    """Return `names` with each ratio replaced by its parameter."""
    by_name = ratios_in(scene)
    return [by_name[name].gives if name in by_name else name for name in names]


def following(scene: Scene, ratios: Collection[str], names: Collection[str]) -> set[str]:
    """Return the parameters that change with those of `names`, if `ratios` stay as they are."""
    changed = set(meant_by(scene, names))
    followers = set[str]()
    for name, ratio in ratios_in(scene).items():
        if name in ratios and changed & {*ratio.needs}:
            followers.add(ratio.gives)
            changed.add(ratio.gives)
    return followers


def refuse_twice(scene: Scene, names: Collection[str]) -> None:
    """Raise `RequestError` if two of `names` say something of one parameter, as c1 and zeta1."""
    order, first = [*ratios_in(scene)], dict[str, str]()
    names = sorted(names, key=lambda name: order.index(name) if name in order else -1)
    for name, meant in zip(names, meant_by(scene, names), strict=True):
        if first.setdefault(meant, name) != name:
            raise RequestError(f"{first[meant]} beside {name}: give one of them")


def still_set(
    scene: Scene, ratios: Mapping[str, float], names: Collection[str]
) -> dict[str, float]:
    """Return those of `ratios` whose parameters none of `names` gives another value."""
    replaced = set(meant_by(scene, names))
    return {k: v for k, v in ratios.items() if not replaced & {*meant_by(scene, [k])}}


def without_ratios(
    scene: Scene,
    old_values: Mapping[str, Any],
    changes: Mapping[str, Any],
    ratios: Mapping[str, float],
) -> dict[str, Any]:
    """Return the changed parameters, with those that follow from them by ratios.

    `changes` holds parameters and ratios (floats or arrays), `old_values` the parameters before,
    and `ratios` the ratios that were set before: each stays unless its parameter is changed.

    Raises `RequestError` for a ratio out of its range or beside the parameter that it replaces.
    """
    refuse_twice(scene, [*changes])
    values, stay = dict(changes), still_set(scene, ratios, changes)
    for name, ratio in ratios_in(scene).items():
        if name in values:
            value = _numbers(name, values.pop(name))
            ratio.what.check(np.asarray(value))
        elif name in stay and not values.keys().isdisjoint(ratio.needs):
            value = stay[name]
        else:
            continue
        with np.errstate(over="ignore"):
            values[ratio.gives] = value * ratio.unit_of({**old_values, **values})
        PARAMETERS[ratio.gives].check(np.asarray(values[ratio.gives]))
    return values


def of_parameters(scene: Scene, values: Mapping[str, float]) -> dict[str, float]:
    """Return the ratios of a scene's parameters whose units are positive."""
    ratios = {}
    for name, ratio in ratios_in(scene).items():
        if ratio.gives in values and all(values.get(need, 0.0) > 0.0 for need in ratio.needs):
            ratios[name] = float(values[ratio.gives] / ratio.unit_of(values))
    return ratios


def axes_of_parameters(
    axes: tuple[Axis, ...],
    scene: Scene,
    values: Mapping[str, float],
    changing: Collection[str],
) -> tuple[Axis, ...]:
    """Return axes along parameters in place of those along ratios whose unit stays the same.

    Arguments: the `axes`, the scene and its parameters; the names of all that is `changing`, from
    one orbit to another.  An axis along a ratio whose unit changes stays one along that ratio.

    Raises `RequestError` for a ratio out of its range.
    """
    by_name, result = ratios_in(scene), []
    for axis in axes:
        ratio = by_name.get(axis.name)
        if ratio is None or not {*changing}.isdisjoint(ratio.needs):
            result.append(axis)
            continue
        ratio.what.check(axis.values)
        result.append(Axis(ratio.gives, axis.values * ratio.unit_of(values)))
    return tuple(result)
