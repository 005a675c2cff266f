"""Every parameter by name: symbol, unit, meaning, range; those of contacts: `contact_laws`.

The names are those of the paper's equations (1)-(6).  All values are in SI units.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import pi

from nlds_vines.model.contact_laws import CONSTANTS, HERTZ, LAWS
from nlds_vines.model.parameter import Parameter

STRUCTURE = ("m1", "k1", "c1")
"""The parameters of the primary structure: mass, stiffness, damping."""

DAMPER = ("m2", "k2", "c2")
"""The parameters of the damper and its joint with the structure: mass, stiffness, damping."""

OSCILLATOR = ("m", "k", "c")
"""The parameters of a single mass: mass, stiffness, damping."""

FORCING = ("P", "omega")
"""The parameters of the harmonic force on the structure, P cos(omega t)."""

CONTACT = HERTZ.constants
"""The constants of a Hertz contact, equation (4); `K` may be given in place of all seven."""


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


def _of_second(parameter: Parameter) -> Parameter:
    """Return the parameter of a second wall whose contact is its own."""
    return replace(
        parameter,
        name=f"{parameter.name}_2",
        symbol=f"{parameter.symbol}₂",
        meaning=f"{parameter.meaning}, at the second wall",
    )


_OWN = [constant for law in LAWS.values() for constant in law.own]

_NAMED = {parameter.name: parameter for parameter in (*_ALL, *_OWN)}

PARAMETERS: Mapping[str, Parameter] = _NAMED | {
    f"{name}_2": _of_second(_NAMED[name]) for name in CONSTANTS
}
"""All parameters of all kinds of dampers, by name."""

PHASE = "phase"
"""The phase of the force at the start, an initial condition that is no component of the state."""

INITIAL: Mapping[str, Parameter] = {
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
"""Where an orbit begins, a component each, and at which phase: no parameters, but axes."""


RATIOS: Mapping[str, Parameter] = {
    entry.name: entry
    for entry in (
        Parameter("mass_ratio", "m₂/m₁", "1", "mass of the damper over that of the structure", 0,
                  above=True),
        Parameter("zeta1", "ζ₁", "1", "damping ratio of the structure", 0),
        Parameter("zeta2", "ζ₂", "1", "damping ratio of the damper, on a structure that is fixed",
                  0),
        Parameter("zeta", "ζ", "1", "damping ratio of the oscillator", 0),
        Parameter("f", "f", "Hz", "frequency of the force", 0, above=True),
        Parameter("omega_ratio", "ω/ω₀", "1", "frequency of the force over that of the structure",
                  0, above=True),
    )
}  # fmt: skip
"""Ratios and frequencies that may stand in place of a parameter (`model.ratios`)."""

DESCRIBED: Mapping[str, Parameter] = {**PARAMETERS, **INITIAL, **RATIOS}
"""Everything that may vary: parameters, initial conditions and ratios, by name."""


def described(name: str) -> Parameter:
    """Return the description of a parameter, an initial condition or a ratio."""
    return DESCRIBED[name]


def component_of(name: str) -> str:
    """Return the component of the state that an initial condition sets, x2 of x2_0; or `PHASE`."""
    return name.removesuffix("_0")
