"""Contact laws: what a wall does to the damper that meets it.  Every wall of a scene has one.

z [m] is the depth of the contact, how far the damper has come beyond the place of touch.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from nlds_vines.model.parameters import CONTACT


@dataclass(frozen=True)
class Law:
    """One contact law.

    Attributes:
        name: as in files, archives and Python.
        meaning: in words, with its formula.
        constants: the names of its parameters.
        instead: a parameter that may be given in place of all constants; "" for none.
        instant: whether an impact takes no time.
    """

    name: str
    meaning: str
    constants: tuple[str, ...]
    instead: str = ""
    instant: bool = False

    @property
    def allowed(self) -> tuple[str, ...]:
        """The names of all parameters that it may be given."""
        return self.constants + ((self.instead,) if self.instead else ())


HERTZ = Law("hertz", "elastic bodies: force K z^1.5, equations (2) and (4)", CONTACT, "K")
"""The paper's law, and that of every system which names none."""

_ALL = (
    HERTZ,
    Law(
        "restitution",
        "rigid bodies: the approach speed turns into -e times itself, at once",
        ("e",),
        instant=True,
    ),
)

LAWS: Mapping[str, Law] = {law.name: law for law in _ALL}
"""All contact laws by name."""
