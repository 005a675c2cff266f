"""Ratios and frequencies in place of parameters: damping ratios, mass ratio, Hz, natural periods.

Each ratio q stands for one parameter, which is q^power times a unit that follows from others:

    zeta1        c1 = zeta1 2 sqrt(k1 m1)         zeta, of an oscillator: c = zeta 2 sqrt(k m)
    zeta2        c2 = zeta2 2 sqrt(k2 m2)         mass_ratio: m2 = mass_ratio m1
    f            omega = f 2 pi                   omega_ratio: omega = omega_ratio sqrt(k1 / m1)
    f1           k1 = f1^2 (2 pi)^2 m1            T1: k1 = T1^-2 (2 pi)^2 m1
    frequency_ratio                               k2 = frequency_ratio^2 k1 m2 / m1

A parameter that is set as a ratio stays at that ratio: `System` stores the ratio, and computes the
parameter again whenever its unit changes.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cache
from math import pi
from typing import Any

import numpy as np

from nlds_vines.errors import RequestError, choice, from_text, number, shown
from nlds_vines.model import parameters
from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import PARAMETERS, Parameter
from nlds_vines.model.scenes import Scene

RAD, HZ, RATIO = UNITS = "rad/s", "Hz", "ratio"  # of axes of omega, f and omega / omega0


@dataclass(frozen=True)
class Ratio:
    """A number in place of the parameter that it `gives`: ratio^power times a unit."""

    what: Parameter
    gives: str
    needs: tuple[str, ...]
    unit: Callable[..., Any]  # from the parameters that it needs [SI], floats or arrays
    power: int  # 1, 2 or -2

    @property
    def name(self) -> str:
        return self.what.name

    def unit_of(self, values: Mapping[str, Any]) -> Any:
        """Return its unit among parameters (floats or arrays); they must be positive."""
        missing = [name for name in self.needs if name not in values]
        if missing:
            raise RequestError(f"{self.name} needs {' and '.join(missing)}, which is missing")
        needed = {name: _numbers(name, values[name]) for name in self.needs}
        if not all(np.all(value > 0.0) for value in needed.values()):
            unsuitable = ", ".join(f"{name} = {float(np.min(v))!r}" for name, v in needed.items())
            raise RequestError(f"{self.name} means nothing with {unsuitable}: give {self.gives}")
        return self.unit(*needed.values())

    def parameter(self, value: Any, values: Mapping[str, Any]) -> Any:
        """Return the parameter [SI] of a ratio (float or array) among the other `values`."""
        unit = self.unit_of(values)
        if self.power == 1:
            return value * unit
        square = value * value
        with np.errstate(divide="ignore", over="ignore"):
            return square * unit if self.power == 2 else np.divide(unit, square)

    def of(self, parameter: float, values: Mapping[str, Any]) -> float:
        relative = float(parameter / self.unit_of(values))
        if self.power == 1:
            return relative
        return float(np.sqrt(relative if self.power == 2 else 1.0 / relative))


def _numbers(name: str, value: Any) -> Any:
    return value if isinstance(value, np.ndarray) else number(name, value)


def from_percentage(name: str, value: Any) -> Any:
    """Return the number that a percentage means, "2%"; other values as they are."""
    if not isinstance(value, str):
        return value
    if not value.endswith("%"):
        raise RequestError(f"{name} = {shown(value)} must be a number, or as '2%'")
    return from_text(float, name, value[:-1]) / 100.0


def refuse_critical(name: str, ratio: float) -> None:
    """Raise `RequestError` for a damping ratio of 1 and more, which may be meant in percent."""
    if ratio >= 1.0:
        raise RequestError(
            f"{name} = {ratio:g} is {100 * ratio:g} % of critical damping; allowed: below 1. "
            f"{ratio:g} % is {ratio / 100:g} or '{ratio:g}%'"
        )


def _critical(k: Any, m: Any) -> Any:
    return 2.0 * np.sqrt(k * m)


def _stiffness(m: Any) -> Any:
    return (2.0 * pi) * (2.0 * pi) * m


RATIOS = tuple(
    Ratio(parameters.RATIOS[name], gives, needs, unit, power)
    for name, gives, needs, unit, power in (
        ("mass_ratio", "m2", ("m1",), lambda m: m, 1),
        ("f1", "k1", ("m1",), _stiffness, 2),
        ("f1", "k", ("m",), _stiffness, 2),
        ("T1", "k1", ("m1",), _stiffness, -2),
        ("T1", "k", ("m",), _stiffness, -2),
        ("frequency_ratio", "k2", ("k1", "m1", "m2"), lambda k, m1, m2: k / m1 * m2, 2),
        ("zeta1", "c1", ("k1", "m1"), _critical, 1),
        ("zeta2", "c2", ("k2", "m2"), _critical, 1),
        ("zeta", "c", ("k", "m"), _critical, 1),
        ("f", "omega", (), lambda: 2.0 * pi, 1),
        ("omega_ratio", "omega", ("k1", "m1"), lambda k, m: np.sqrt(k / m), 1),
        ("omega_ratio", "omega", ("k", "m"), lambda k, m: np.sqrt(k / m), 1),
    )
)


def frequency_unit(unit: str | None, document: Mapping[str, Any]) -> str:
    if unit is None:
        tables = (table for table in document.values() if isinstance(table, Mapping))
        return HZ if any("f" in table for table in tables) else RAD
    return choice("frequency", unit, UNITS)


def frequency_in(unit: str, value_of: Callable[[str], float]) -> tuple[str, float]:
    """Return the name of the frequency in a unit, and the omega [rad/s] at which it is 1.

    `value_of` returns the one value of a parameter, NaN if there is none or there are several.
    """
    if unit == RAD:
        return "omega", 1.0
    name = {HZ: "f", RATIO: "omega_ratio"}[unit]
    for ratio in RATIOS:
        values = {need: value_of(need) for need in ratio.needs}
        if ratio.name == name and all(value > 0.0 for value in values.values()):
            return name, float(ratio.unit_of(values))
    raise RequestError(
        "frequency = 'ratio' needs one frequency sqrt(k1 / m1) of the structure, which the results "
        "do not have: take Hz"
    )


def ratios_in(scene: Scene) -> Mapping[str, Ratio]:
    return _ratios_of(scene.parameter_names)


@cache
def _ratios_of(names: tuple[str, ...]) -> Mapping[str, Ratio]:
    return {one.name: one for one in RATIOS if {one.gives, *one.needs} <= {*names}}


def meant_by(scene: Scene, names: Collection[str]) -> list[str]:
    """Return `names` with each ratio replaced by its parameter."""
    by_name = ratios_in(scene)
    return [by_name[name].gives if name in by_name else name for name in names]


def following(scene: Scene, ratios: Collection[str], names: Collection[str]) -> set[str]:
    """Return the parameters that change with those of `names` if `ratios` stay constant."""
    changed = set(meant_by(scene, names))
    followers = set[str]()
    for name, ratio in ratios_in(scene).items():
        if name in ratios and not changed.isdisjoint(ratio.needs):
            followers.add(ratio.gives)
            changed.add(ratio.gives)
    return followers


def refuse_twice(scene: Scene, names: Collection[str]) -> None:
    """Raise `RequestError` if two of `names` determine one parameter, as c1 and zeta1."""
    order, first = [*ratios_in(scene)], dict[str, str]()
    names = sorted(names, key=lambda name: order.index(name) if name in order else -1)
    for name, meant in zip(names, meant_by(scene, names), strict=True):
        if first.setdefault(meant, name) != name:
            raise RequestError(f"{first[meant]} beside {name}: give one of them")


def still_set(
    scene: Scene, ratios: Mapping[str, float], names: Collection[str]
) -> dict[str, float]:
    """Return the `ratios` whose parameters are not determined by `names`."""
    if not ratios:
        return {}
    replaced = set(meant_by(scene, names))
    return {k: v for k, v in ratios.items() if replaced.isdisjoint(meant_by(scene, [k]))}


def without_ratios(
    scene: Scene,
    old_values: Mapping[str, Any],
    changes: Mapping[str, Any],
    ratios: Mapping[str, float],
) -> dict[str, Any]:
    """Return the changed parameters, with those that follow from them by ratios.

    `changes` holds parameters and ratios (floats or arrays); one of the `ratios` that were set
    before stays unless its parameter is changed.
    """
    by_name = ratios_in(scene)
    if not ratios and by_name.keys().isdisjoint(changes):
        return dict(changes)
    refuse_twice(scene, [*changes])
    values, stay = dict(changes), still_set(scene, ratios, changes)
    for name, ratio in by_name.items():
        if name in values:
            value = _numbers(name, values.pop(name))
            ratio.what.check(value)
        elif name in stay and not values.keys().isdisjoint(ratio.needs):
            value = stay[name]
        else:
            continue
        with np.errstate(over="ignore"):
            values[ratio.gives] = ratio.parameter(value, {**old_values, **values})
        PARAMETERS[ratio.gives].check(values[ratio.gives])
    return values


def of_parameters(scene: Scene, values: Mapping[str, float]) -> dict[str, float]:
    """Return the ratios of a scene's parameters that are defined."""
    return {
        name: ratio.of(values[ratio.gives], values)
        for name, ratio in ratios_in(scene).items()
        if ratio.gives in values
        and (ratio.power == 1 or values[ratio.gives] > 0.0)
        and all(values.get(need, 0.0) > 0.0 for need in ratio.needs)
    }


def axes_of_parameters(
    axes: tuple[Axis, ...], scene: Scene, values: Mapping[str, float], changing: Collection[str]
) -> tuple[Axis, ...]:
    """Replace each axis along a ratio by the axis along its parameter, if that is a multiple.

    It is not for f1, T1 and frequency_ratio, nor if the ratio's unit is `changing` over the orbits.
    """
    by_name, result = ratios_in(scene), []
    for axis in axes:
        ratio = by_name.get(axis.name)
        if ratio is None or ratio.power != 1 or not {*changing}.isdisjoint(ratio.needs):
            result.append(axis)
            continue
        ratio.what.check(axis.values)
        stated = None if ratio.needs else axis  # f remains f whatever else is set
        result.append(Axis(ratio.gives, axis.values * ratio.unit_of(values), stated))
    return tuple(result)
