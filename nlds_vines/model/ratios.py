"""Ratios and frequencies in place of parameters: damping ratios, mass ratio, Hz.

Each stands for one parameter, which is so many times a unit that follows from others:

    zeta1        c1 = zeta1 2 sqrt(k1 m1)         zeta, of an oscillator: c = zeta 2 sqrt(k m)
    zeta2        c2 = zeta2 2 sqrt(k2 m2)         mass_ratio: m2 = mass_ratio m1
    f            omega = f 2 pi                   omega_ratio: omega = omega_ratio sqrt(k1 / m1)

They are turned into their parameters where they are given, and nothing else knows of them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import numpy as np

from nlds_vines.errors import RequestError, number
from nlds_vines.model.axis import Axis
from nlds_vines.model.parameter import Parameter
from nlds_vines.model.scenes import Scene


@dataclass(frozen=True)
class Ratio:
    """A number in place of a parameter.

    Attributes:
        what: its name, symbol, unit, meaning and range.
        gives: the name of the parameter that it stands for.
        needs: the parameters that its unit follows from.
        unit: returns, from these in their order, what the parameter is where the ratio is 1 [SI].
    """

    what: Parameter
    gives: str
    needs: tuple[str, ...]
    unit: Callable[..., float]

    @property
    def name(self) -> str:
        """As in files and Python."""
        return self.what.name

    def fits(self, scene: Scene) -> bool:
        """Return whether a scene has its parameters."""
        return {self.gives, *self.needs} <= set(scene.own)

    def unit_of(self, values: Mapping[str, Any]) -> float:
        """Return its unit among parameters.

        Raises `RequestError` where one is missing, or makes the unit zero.
        """
        missing = [name for name in self.needs if name not in values]
        if missing:
            raise RequestError(f"{self.name} needs {' and '.join(missing)}, which is missing")
        given = [number(name, values[name]) for name in self.needs]
        if not all(value > 0.0 for value in given):
            told = ", ".join(f"{n} = {v!r}" for n, v in zip(self.needs, given, strict=True))
            raise RequestError(f"{self.name} means nothing with {told}: give {self.gives}")
        return self.unit(*given)


def _critical(k: float, m: float) -> float:
    return 2.0 * sqrt(k * m)


def _own_frequency(k: float, m: float) -> float:
    return sqrt(k / m)


_OMEGA_RATIO = Parameter(
    "omega_ratio", "ω/ω₀", "1", "frequency of the force over that of the structure", 0, above=True
)

RATIOS = (
    Ratio(
        Parameter("mass_ratio", "m₂/m₁", "1", "mass of the damper over that of the structure", 0,
                  above=True),
        "m2", ("m1",), lambda m: m,
    ),
    Ratio(Parameter("zeta1", "ζ₁", "1", "damping ratio of the structure", 0), "c1", ("k1", "m1"),
          _critical),
    Ratio(Parameter("zeta2", "ζ₂", "1", "damping ratio of the damper, on a structure that is fixed",
                    0), "c2", ("k2", "m2"), _critical),
    Ratio(Parameter("zeta", "ζ", "1", "damping ratio of the oscillator", 0), "c", ("k", "m"),
          _critical),
    Ratio(Parameter("f", "f", "Hz", "frequency of the force", 0, above=True), "omega", (),
          lambda: 2.0 * pi),
    Ratio(_OMEGA_RATIO, "omega", ("k1", "m1"), _own_frequency),
    Ratio(_OMEGA_RATIO, "omega", ("k", "m"), _own_frequency),
)  # fmt: skip
"""All ratios, those first from which others may follow."""


def ratios_in(scene: Scene) -> dict[str, Ratio]:
    """Return the ratios that may be given of a scene, by name."""
    return {ratio.name: ratio for ratio in RATIOS if ratio.fits(scene)}


def meant_by(scene: Scene, names: Collection[str]) -> list[str]:
    """Return names with those of parameters in place of ratios."""
    known = ratios_in(scene)
    return [known[name].gives if name in known else name for name in names]


def without_ratios(
    scene: Scene, known: Mapping[str, Any], given: Mapping[str, Any]
) -> Mapping[str, Any]:
    """Return the parameters that are `given`, each ratio turned into the one that it stands for.

    Arguments: the scene; the parameters that are `known` before, which units follow from, too.

    Raises `RequestError` for a ratio out of its range, and beside what it stands for.
    """
    found, meant = dict(given), {name: name for name in given}
    for name, ratio in ratios_in(scene).items():
        if name not in given:
            continue
        if ratio.gives in meant:
            raise RequestError(f"{meant[ratio.gives]} beside {name}: give one of them")
        meant[ratio.gives] = name
        value = number(name, found.pop(name))
        ratio.what.check(np.asarray(value))
        found[ratio.gives] = value * ratio.unit_of({**known, **found})
    return found


def of_parameters(scene: Scene, values: Mapping[str, float]) -> dict[str, float]:
    """Return the ratios of a scene's parameters, those that mean something."""
    found = {}
    for name, ratio in ratios_in(scene).items():
        if ratio.gives in values and all(values.get(need, 0.0) > 0.0 for need in ratio.needs):
            found[name] = values[ratio.gives] / ratio.unit_of(values)
    return found


def axes_of_parameters(
    axes: tuple[Axis, ...], scene: Scene, values: Mapping[str, float]
) -> tuple[Axis, ...]:
    """Return axes along parameters in place of those along ratios.

    Raises `RequestError` where the unit of a ratio follows from a parameter that varies, too.
    """
    known = ratios_in(scene)
    varied = meant_by(scene, [axis.name for axis in axes])
    found = []
    for axis in axes:
        ratio = known.get(axis.name)
        if ratio is None:
            found.append(axis)
            continue
        both = next((name for name in ratio.needs if name in varied), None)
        if both is not None:
            raise RequestError(f"{axis.name} follows from {both}, which varies: vary {ratio.gives}")
        ratio.what.check(axis.values)
        found.append(Axis(ratio.gives, axis.values * ratio.unit_of(values)))
    return tuple(found)
