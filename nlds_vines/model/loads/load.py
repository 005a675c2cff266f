"""What every load is: a function of time with its kinks, its rates, and its Taylor coefficients."""

from __future__ import annotations

from dataclasses import MISSING, dataclass
from typing import Any, ClassVar, TypeVar

import numpy as np

from nlds_vines.errors import RequestError, at, number, table
from nlds_vines.model.loads.series import values_of
from nlds_vines.model.setting import OneOf, Real, check_settings, entries, setting, settings_of

G = 9.80665
"""Standard gravity [m/s^2]."""

FORCES = {"N": 1.0, "kN": 1e3, "lbf": 4.4482216152605}
"""Units of a force on m1, in N."""

ACCELERATIONS = {
    "m/s^2": 1.0,
    "cm/s^2": 0.01,
    "gal": 0.01,
    "mm/s^2": 0.001,
    "in/s^2": 0.0254,
    "g": G,
}
"""Units of an acceleration of the ground, in m/s^2."""

UNIT = OneOf((*FORCES, *ACCELERATIONS), "unit")

UNIT_WORDS = (
    "`N`, `kN` or `lbf`: a force on m1; `m/s^2`, `cm/s^2`, `gal`, `mm/s^2`, `in/s^2` or `g`: "
    "the ground's acceleration"
)

Given = TypeVar("Given", bound="Load")

TIME = Real(0.0, 1e9)
LENGTH = Real(0.0, 1e9, inside=True)


@dataclass(frozen=True)
class Size:
    """A number other than zero, of either sign."""

    def __call__(self, name: str, value: Any, /) -> float:
        """Return it."""
        size = number(name, value)
        if not 0.0 < abs(size) <= 1e15:
            raise RequestError(f"{name} = {size!r}; allowed: up to 1e15 to either side, and not 0")
        return size


@dataclass(frozen=True, kw_only=True)
class Load:
    """What acts on a structure; frozen and checked when made."""

    kind: ClassVar[str]
    """The key of `[load]`."""

    table: ClassVar[str]
    """`load.` and the kind."""

    def __init_subclass__(cls) -> None:
        """Name the table of its settings."""
        cls.table = f"load.{getattr(cls, 'kind', '')}"

    def __post_init__(self) -> None:
        """Check all fields by themselves, then together."""
        check_settings(self)
        self.check()

    def check(self) -> None:
        """Raise `RequestError` where fields contradict each other."""

    def kinks(self, end: float) -> np.ndarray:
        """Return the times [s] up to `end` at which it is not smooth, ascending."""
        return np.zeros(0)

    def entry(self) -> dict[str, Any]:
        """Return its table of a request file."""
        return entries(self, self.table)

    @classmethod
    def of(cls: type[Given], entry: object) -> Given:
        """Return the load that a table means; `RequestError` for anything else."""
        settings = {setting.key: setting for setting in settings_of(cls).values()}
        with at(f"[{cls.table}]"):
            entries = table(cls.kind, entry, settings)
            for key, setting in settings.items():
                if setting.default is MISSING and key not in entries:
                    raise RequestError(f"{key} is missing: {setting.words}")
            return cls(**entries)


@dataclass(frozen=True, kw_only=True)
class Course(Load):
    """A force on m1, or an acceleration of the ground, over time."""

    unit: str = setting("N", UNIT, "", UNIT_WORDS)

    @property
    def shakes(self) -> bool:
        """Whether it is an acceleration of the ground."""
        return self.unit in ACCELERATIONS

    @property
    def factor(self) -> float:
        """Of its unit, in N or m/s^2."""
        return {**FORCES, **ACCELERATIONS}[self.unit]

    def rates(self, times: np.ndarray) -> np.ndarray:
        """Return bounds [1/s], at times without a kink, on the growth of its derivatives there.

        The n-th is at most its size times rate^n, up to the next kink.
        """
        raise NotImplementedError

    def rows(self, begins: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the Taylor coefficients (n, TERMS) in its unit, over cells without a kink within.

        Arguments: where the cells begin (n,) and how long they are (n,) [s].
        """
        raise NotImplementedError

    def value(self, times: np.ndarray) -> np.ndarray:
        """Return its values at times (n,) in its unit; of two at a jump, the later one."""
        return values_of(self.rows(times, np.zeros(len(times))), np.zeros(len(times)))
