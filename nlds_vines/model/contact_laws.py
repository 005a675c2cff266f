"""Contact laws: what a wall does to the damper that meets it.  Every wall of a scene has one.

z [m] is the depth of the contact, how far the damper has come beyond the place of touch.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from nlds_vines.model.parameter import Parameter


@dataclass(frozen=True)
class Law:
    """One contact law.

    Attributes:
        name: as in files, archives and Python.
        meaning: in words, with its formula.
        constants: the names of its parameters.
        instead: a parameter that may be given in place of all constants; "" for none.
        optional: parameters that may be given as well; 0 where they are not.
        own: the parameters that no law before it has.
        force: returns the force [N] at a depth z > 0 [m] that grows with dz/dt = s [m/s], from the
            constants by name and arrays of z and s; None where an impact takes no time.
    """

    name: str
    meaning: str
    constants: tuple[str, ...]
    instead: str = ""
    optional: tuple[str, ...] = ()
    own: tuple[Parameter, ...] = ()
    force: Callable[[Mapping[str, float], np.ndarray, np.ndarray], np.ndarray] | None = None

    @property
    def instant(self) -> bool:
        """Whether an impact takes no time."""
        return self.force is None

    @property
    def allowed(self) -> tuple[str, ...]:
        """The names of all parameters that it may be given."""
        return self.constants + ((self.instead,) if self.instead else ()) + self.optional

    @property
    def needed(self) -> tuple[str, ...]:
        """The names of the fewest parameters that say everything."""
        return (self.instead,) if self.instead else self.constants


DAMPING = "hunt_crossley"
"""The constant a [s/m] of Hunt and Crossley's damping, a factor max(0, 1 + a dz/dt)."""


def _of_power(p: Mapping[str, float], z: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return K z^n max(0, 1 + a s); n is 3/2 where no exponent is given."""
    force = p["K"] * z * np.sqrt(z) if "exponent" not in p else p["K"] * z ** p["exponent"]
    return force * np.maximum(0.0, 1.0 + p[DAMPING] * s) if DAMPING in p else force


def _of_joint(p: Mapping[str, float], z: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return kc z + cc s."""
    return p["kc"] * z + p.get("cc", 0.0) * s


def _of_pressed_joint(p: Mapping[str, float], z: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return the same, but no pull."""
    return np.maximum(0.0, _of_joint(p, z, s))


HERTZ = Law(
    "hertz",
    "elastic bodies: force K z^1.5, equations (2) and (4)",
    ("E1", "E2", "nu1", "nu2", "A", "B", "q1"),
    "K",
    (DAMPING,),
    own=(
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
"""The paper's law, and that of every system which names none."""

_ALL = (
    HERTZ,
    Law(
        "power",
        "force K z^n, n the exponent",
        ("K", "exponent"),
        optional=(DAMPING,),
        own=(
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
        own=(
            Parameter("kc", "kc", "N/m", "stiffness of the contact", low=0, above=True),
            Parameter("cc", "cc", "N s/m", "damping of the contact", low=0),
        ),
        force=_of_pressed_joint,
    ),
    Law(
        "kelvin-voigt",
        "spring and dashpot, which may pull: force kc z + cc dz/dt, until z is zero",
        ("kc",),
        optional=("cc",),
        force=_of_joint,
    ),
    Law(
        "restitution",
        "rigid bodies: the approach speed turns into -e times itself, at once",
        ("e",),
        own=(Parameter("e", "e", "1", "coefficient of restitution", low=0, high=1),),
    ),
)

LAWS: Mapping[str, Law] = {law.name: law for law in _ALL}
"""All contact laws by name."""

_SAY_ALL = {name for law in _ALL for name in law.needed + law.optional}

CONSTANTS = tuple(one.name for law in _ALL for one in law.own if one.name in _SAY_ALL)
"""The names of all that kernels need to know of contacts."""

SECOND = "_2"
"""The ending of the second wall's constants and law, where they are its own: K_2, e_2, law_2."""


def of_second(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of constants of a second wall."""
    return tuple(name + SECOND for name in names)
