"""Every parameter by name, and the contact laws with the parameters that are theirs.

The names are those of the paper's equations (1)-(6).  All values are in SI units.  z [m] is the
depth of a contact: how far the damper has moved beyond the point of touch.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, pi
from typing import Any

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.errors import RequestError


@dataclass(frozen=True, slots=True)
class Parameter:
    name: str
    symbol: str
    unit: str  # SI; "1" for none
    meaning: str
    low: float = -inf  # its range; only finite values are allowed
    high: float = inf
    above: bool = False  # excludes `low` itself

    def dataset(self, dims: tuple[str, ...], prefix: str = "") -> Dataset:
        return Dataset.real(f"{prefix}{self.name}", dims, self.unit, self.meaning)

    def scale(self, values: np.ndarray, prefix: str = "") -> Scale:
        return Scale(f"{prefix}{self.name}", values, self.unit, self.meaning)

    @property
    def allowed(self) -> str:
        """The allowed range in words, for messages and documentation: `> 0 and finite`."""
        if self.high < inf:
            return f"from {self.low:g} to {self.high:g}"
        if self.low > -inf:
            return f"{'>' if self.above else '>='} {self.low:g} and finite"
        return "finite"

    @property
    def short_symbol(self) -> str:
        """The symbol; empty if it is a word that the meaning has, the gap of a host's wall."""
        key, of, _ = self.symbol.partition(" of ")
        return "" if of and len(key.rstrip("+-")) > 2 else self.symbol

    def accepts(self, values: np.ndarray) -> np.ndarray:
        bottom = values > self.low if self.above else values >= self.low
        return bottom & (values <= self.high) & np.isfinite(values)

    def check(self, values: float | np.ndarray) -> None:
        if isinstance(values, float) and self.low < values <= self.high and values < inf:
            return
        values = np.asarray(values)
        wrong = ~self.accepts(values)
        if np.any(wrong):
            value = float(values[wrong].flat[0])
            unit = f" [{self.unit}]" if self.unit != "1" else ""
            raise RequestError(
                f"{self.name} = {value!r} is not allowed: "
                f"{self.name} ({self.meaning}){unit} must be {self.allowed}"
            )


# ---- contact laws --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Law:
    name: str
    meaning: str
    constants: tuple[str, ...]
    instead: str = ""  # a parameter that may replace all constants
    optional: tuple[str, ...] = ()  # parameters that may be added; 0 by default
    parameters: tuple[Parameter, ...] = ()  # those that no earlier law has
    # the force [N] by the constants, the depth z > 0 [m] and its rate dz/dt = s [m/s], arrays;
    # None if an impact takes no time
    force: Callable[[Mapping[str, float], np.ndarray, np.ndarray], np.ndarray] | None = None

    @property
    def instant(self) -> bool:
        return self.force is None

    @property
    def allowed(self) -> tuple[str, ...]:
        return self.constants + ((self.instead,) if self.instead else ()) + self.optional

    @property
    def needed(self) -> tuple[str, ...]:
        return (self.instead,) if self.instead else self.constants


DAMPING = "hunt_crossley"  # the constant a [s/m] of a factor max(0, 1 + a dz/dt)


def _of_power(p: Mapping[str, float], z: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return K z^n max(0, 1 + a s); n is 3/2 where no exponent is given."""
    force = p["K"] * z * np.sqrt(z) if "exponent" not in p else p["K"] * z ** p["exponent"]
    return force * np.maximum(0.0, 1.0 + p[DAMPING] * s) if DAMPING in p else force


HERTZ = Law(
    "hertz",
    "elastic bodies: force K z^1.5, equations (2) and (4)",
    ("E1", "E2", "nu1", "nu2", "A", "B", "q1"),
    "K",
    (DAMPING,),
    parameters=(
        Parameter("E1", "E₁", "Pa", "Young's modulus of the obstacle", low=0, above=True),
        Parameter("E2", "E₂", "Pa", "Young's modulus of the damper's surface", low=0, above=True),
        Parameter("nu1", "ν₁", "1", "Poisson's ratio of the obstacle", low=0, high=0.5),
        Parameter("nu2", "ν₂", "1", "Poisson's ratio of the damper's surface", low=0, high=0.5),
        Parameter("A", "A", "1/m", "first constant of the gap between the surfaces", low=0),
        Parameter("B", "B", "1/m", "second constant of the gap between the surfaces", low=0),
        Parameter("q1", "q₁", "1", "Hertz coefficient that belongs to A / B", low=0, above=True),
        Parameter("K", "K", "N/m^1.5", "contact stiffness", low=0, above=True),
    ),
    force=_of_power,
)
"""The paper's law, and the default of every system."""


@lru_cache(maxsize=64)  # of many systems with one contact, the first computes it
def hertz_stiffness(*constants: Any) -> Any:
    """Return the contact stiffness K [N/m^1.5] of two elastic bodies, by equation (4).

    K = (4/3) q1 / ((d1 + d2) sqrt(A + B)) with d_i = (1 - nu_i^2) / (pi E_i).
    """
    E1, E2, nu1, nu2, A, B, q1 = (np.asarray(value, dtype=np.float64) for value in constants)
    if np.any(A + B <= 0):
        raise RequestError("A = 0.0 and B = 0.0 are not allowed together: A + B must be > 0")
    with np.errstate(all="ignore"):
        d1 = (1 - nu1 * nu1) / (pi * E1)
        d2 = (1 - nu2 * nu2) / (pi * E2)
        stiffness = np.asarray((4 / 3) * q1 / ((d1 + d2) * np.sqrt(A + B)))
    wrong = stiffness[~(np.isfinite(stiffness) & (stiffness > 0))]
    if wrong.size:
        raise RequestError(
            f"K = {float(wrong[0])!r} is not allowed: "
            "the contact constants must give a stiffness > 0 and finite"
        )
    return stiffness


_LAWS = (
    HERTZ,
    Law(
        "power",
        "force K z^n, n the exponent",
        ("K", "exponent"),
        optional=(DAMPING,),
        parameters=(
            Parameter("exponent", "n", "1", "exponent of the contact force", low=1, high=3),
            Parameter(
                "hunt_crossley", "a", "s/m", "damping of the contact, Hunt and Crossley's", low=0
            ),
        ),
        force=_of_power,
    ),
    Law(
        "linear",
        "spring and dashpot: force kc z + cc dz/dt, until it is zero",
        ("kc",),
        optional=("cc",),
        parameters=(
            Parameter("kc", "kc", "N/m", "stiffness of the contact", low=0, above=True),
            Parameter("cc", "cc", "N s/m", "damping of the contact", low=0),
        ),
        force=lambda p, z, s: np.maximum(0.0, p["kc"] * z + p.get("cc", 0.0) * s),
    ),
    Law(
        "kelvin-voigt",
        "spring and dashpot, which may pull: force kc z + cc dz/dt, until z is zero",
        ("kc",),
        optional=("cc",),
        force=lambda p, z, s: p["kc"] * z + p.get("cc", 0.0) * s,
    ),
    Law(
        "restitution",
        "rigid bodies: the approach speed turns into -e times itself, at once",
        ("e",),
        parameters=(Parameter("e", "e", "1", "coefficient of restitution", low=0, high=1),),
    ),
)

LAWS: Mapping[str, Law] = {law.name: law for law in _LAWS}

# the names of the constants that the kernels of all laws read
_IN_KERNELS = {name for law in _LAWS for name in law.needed + law.optional}
CONSTANTS = tuple(one.name for law in _LAWS for one in law.parameters if one.name in _IN_KERNELS)

SECOND = "_2"  # ends the law and the constants of a second wall with a law of its own: K_2, law_2


def of_second(names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name + SECOND for name in names)


# ---- parameters ----------------------------------------------------------------------------------

STRUCTURE = ("m1", "k1", "c1")
DAMPER = ("m2", "k2", "c2")  # and of its joint with the structure
OSCILLATOR = ("m", "k", "c")
FORCING = ("P", "omega")
CONTACT = HERTZ.constants  # equation (4); `K` may replace all seven

_ALL = (
    Parameter("m1", "m₁", "kg", "mass of the primary structure", low=0, above=True),
    Parameter("k1", "k₁", "N/m", "stiffness of the primary structure", low=0),
    Parameter("c1", "c₁", "N s/m", "damping of the primary structure", low=0),
    Parameter("m", "m", "kg", "mass of the oscillator", low=0, above=True),
    Parameter("k", "k", "N/m", "stiffness of the oscillator's spring", low=0),
    Parameter("c", "c", "N s/m", "damping of the oscillator", low=0),
    Parameter("m2", "m₂", "kg", "mass of the damper", low=0, above=True),
    Parameter("k2", "k₂", "N/m", "stiffness of the damper's spring", low=0),
    Parameter("c2", "c₂", "N s/m", "damping between damper and structure", low=0),
    Parameter("C", "C", "m", "clearance at rest; negative: preloaded"),
    Parameter("C_2", "C₂", "m", "clearance at rest of the second stop"),
    Parameter("V", "V", "m", "distance of the obstacle from the structure"),
    Parameter("D", "D", "m", "distance between damper and structure at rest", low=0),
    Parameter("L", "L", "m", "how far the damper may pass the structure", low=0),
    Parameter("P", "P", "N", "amplitude of the force", low=0),
    Parameter("Y", "Y", "m", "amplitude of the ground's motion", low=0),
    Parameter("base_displacement", "Y", "m", "amplitude of the ground's motion", low=0),
    Parameter("base_acceleration", "a", "m/s^2", "amplitude of the ground's acceleration", low=0),
    Parameter("g", "g", "m/s^2", "acceleration of gravity", low=0, above=True),
    Parameter("omega", "ω", "rad/s", "angular frequency of the force", low=0, above=True),
)


_NAMED = {one.name: one for one in (*_ALL, *(one for law in _LAWS for one in law.parameters))}

PARAMETERS: Mapping[str, Parameter] = _NAMED | {
    name + SECOND: replace(
        _NAMED[name],
        name=name + SECOND,
        symbol=f"{_NAMED[name].symbol}₂",
        meaning=f"{_NAMED[name].meaning}, at the second wall",
    )
    for name in CONSTANTS
}

PHASE = "phase"  # the phase of the force at the start: an initial condition outside the state
_INITIAL = {
    entry.name: entry
    for entry in (
        Parameter("x1_0", "x₁(0)", "m", "initial displacement of the structure"),
        Parameter("v1_0", "v₁(0)", "m/s", "initial velocity of the structure"),
        Parameter("x2_0", "x₂(0)", "m", "initial displacement of the damper"),
        Parameter("v2_0", "v₂(0)", "m/s", "initial velocity of the damper"),
        Parameter("x_0", "x(0)", "m", "initial displacement of the mass"),
        Parameter("v_0", "v(0)", "m/s", "initial velocity of the mass"),
        Parameter(PHASE, "φ", "rad", "phase of the force at the start", low=0, high=2 * pi),
    )
}

# in place of a parameter (`model.ratios`)
RATIOS: Mapping[str, Parameter] = {
    entry.name: entry
    for entry in (
        Parameter("mass_ratio", "m₂/m₁", "1", "mass of the damper over that of the structure", 0,
                  above=True),
        Parameter("f1", "f₁", "Hz", "natural frequency of the structure alone", 0, above=True),
        Parameter("T1", "T₁", "s", "natural period of the structure alone", 0, above=True),
        Parameter("frequency_ratio", "f₂/f₁", "1",
                  "frequency of the damper, on a structure that is fixed, over f1", 0),
        Parameter("zeta1", "ζ₁", "1", "damping ratio of the structure", 0),
        Parameter("zeta2", "ζ₂", "1", "damping ratio of the damper, on a structure that is fixed",
                  0),
        Parameter("zeta", "ζ", "1", "damping ratio of the oscillator", 0),
        Parameter("f", "f", "Hz", "frequency of the force", 0, above=True),
        Parameter("omega_ratio", "ω/ω₀", "1", "frequency of the force over that of the structure",
                  0, above=True),
    )
}  # fmt: skip


# ---- parameters of hosts: cell1.k, cell1.gap+, force.roof ----------------------------------------

FORCE, GROUND = "force", "ground"
STRUCTURE_ITSELF = "host"  # the owner of the numbers of the whole structure
MOTIONS = ("acceleration", "displacement")  # of the ground, of which one is given
RESERVED = (FORCE, GROUND, STRUCTURE_ITSELF)  # no names of dampers
SIDES = {"+": 1.0, "-": -1.0}  # of walls, by the sign of r
_OF_GROUND = {
    "acceleration": Parameter(
        "acceleration", "a", "m/s^2", "amplitude of the ground's acceleration"
    ),
    "displacement": Parameter("displacement", "Y", "m", "amplitude of the ground's displacement"),
}
_AMPLITUDE = Parameter("P", "P", "N", "amplitude of the force on")
_OF_DAMPERS = {
    "m": Parameter("m", "m", "kg", "mass of", low=0, above=True),
    "k": Parameter("k", "k", "N/m", "stiffness of the spring of"),  # < 0 beside k3 or k5 > 0
    "k2": Parameter("k2", "k₂", "N/m^2", "quadratic stiffness of the spring of"),
    "k3": Parameter("k3", "k₃", "N/m^3", "cubic stiffness of the spring of"),
    "k5": Parameter("k5", "k₅", "N/m^5", "quintic stiffness of the spring of"),
    "c": Parameter("c", "c", "N s/m", "damping of", low=0),
    "f": Parameter("f", "f", "Hz", "frequency, on a structure at rest, of", low=0),
    "zeta": Parameter("zeta", "ζ", "1", "damping ratio, on a structure at rest, of", low=0),
    "frequency_ratio": Parameter(
        "frequency_ratio", "f₂/f₁", "1", "frequency over that of the host's lowest mode, of", low=0
    ),
    "gap": Parameter("gap", "gap", "m", "gap at rest of"),
    **{
        one.name: replace(one, meaning=f"{one.meaning}, at")
        for law in _LAWS
        for one in law.parameters
    },
}

_OF_STRUCTURE = {
    "M": Parameter("M", "M/M₀", "1", "factor on the mass matrix of the", low=0, above=True),
    "K": Parameter("K", "K/K₀", "1", "factor on the stiffness matrix of the", low=0),
    "C": Parameter("C", "C/C₀", "1", "factor on the damping matrix of the", low=0),
    "ratio": Parameter("ratio", "ζ", "1", "damping ratio of all modes of the", low=0, high=1),
}


def split_name(name: str) -> tuple[str, str, str]:
    """Return the owner, the key and the side in the name of a host's parameter, such as a.gap+."""
    owner, _, key = name.partition(".")
    plain = key[:-1] if key[-1:] in SIDES and owner != FORCE else key
    return owner, plain, key[len(plain) :]


def flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by name with those in a table of an owner, cell1 = { k = 300.0 }, as cell1.k.

    A table of a kind's own parameter, P = { base_displacement = 0.1 }, stays.
    """
    result: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping) and name not in PARAMETERS:
            result |= {f"{name}.{key}": inner for key, inner in value.items()}
        else:
            result[name] = value
    return result


@lru_cache(maxsize=4096)
def of_host(name: str) -> Parameter | None:
    """Return the number of a host by its name damper.key, force.dof or dof_0; None for others."""
    owner, key, side = split_name(name)
    if owner == GROUND and key in _OF_GROUND:
        return replace(_OF_GROUND[key], name=name)
    if owner == FORCE and key:
        entry, owner = _AMPLITUDE, key
    elif owner == STRUCTURE_ITSELF and key in _OF_STRUCTURE:
        entry = _OF_STRUCTURE[key]
    elif owner and key in _OF_DAMPERS:
        entry = _OF_DAMPERS[key]
    else:
        return start_of_host(name)
    place = f"{owner}, wall {side}" if side else owner
    symbol = f"{entry.symbol}{side} of {owner}"
    return replace(entry, name=name, symbol=symbol, meaning=f"{entry.meaning} {place}")


def start_of_host(name: str) -> Parameter | None:
    """Return the initial condition of a host by its name dof_0 or v_dof_0; None for others."""
    component = component_of(name)
    if component == name or "." in name:
        return None
    dof = component.removeprefix("v_")
    if dof == component:
        return Parameter(name, f"x(0) of {dof}", "m", f"initial displacement of {dof}")
    return Parameter(name, f"v(0) of {dof}", "m/s", f"initial velocity of {dof}")


class _Made(dict[str, Parameter]):
    """The parameters by name; those of hosts are made when they are asked for."""

    def __init__(
        self, entries: Mapping[str, Parameter], make: Callable[[str], Parameter | None]
    ) -> None:
        super().__init__(entries)
        self._make = make

    def __missing__(self, name: str) -> Parameter:
        entry = self._make(name)
        if entry is None:
            raise KeyError(name)
        return entry

    def __contains__(self, name: object) -> bool:
        is_known = super().__contains__(name)
        return is_known or (isinstance(name, str) and self._make(name) is not None)


INITIAL: Mapping[str, Parameter] = _Made(_INITIAL, start_of_host)
DESCRIBED: Mapping[str, Parameter] = _Made({**PARAMETERS, **_INITIAL, **RATIOS}, of_host)
"""All that may vary."""


def component_of(name: str) -> str:
    """Return the component of the state that an initial condition sets, x2 of x2_0, or `PHASE`."""
    return name.removesuffix("_0")


def symbol_of(name: str) -> str:
    return DESCRIBED[name].symbol if name in DESCRIBED else name


def with_unit(name: str, text: str) -> str:
    unit = DESCRIBED[name].unit if name in DESCRIBED else "1"
    return text if unit == "1" else f"{text} {unit}"


def ends_in_words(name: str, low: float, high: float) -> str:
    """Return the ends of a range with their unit, those of a frequency in rad/s and in Hz."""
    factor, other = {"rad/s": (0.5 / pi, "Hz"), "Hz": (2.0 * pi, "rad/s")}.get(
        DESCRIBED[name].unit if name in DESCRIBED else "1", (0.0, "")
    )
    text = with_unit(name, f"{low:g} to {high:g}")
    return f"{text} ({low * factor:.4g} to {high * factor:.4g} {other})" if other else text


def setting_in_words(name: str, value: float) -> str:
    return f"{symbol_of(name)} = {with_unit(name, f'{value:g}')}"


def range_in_words(name: str, values: np.ndarray) -> str:
    return f"{symbol_of(name)} from {with_unit(name, f'{values[0]:g} to {values[-1]:g}')}"
