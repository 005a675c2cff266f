"""The table `[load]`: the sum of what acts on a structure over time, in cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from nlds_vines.errors import RequestError, number
from nlds_vines.model.loads.courses import (
    REACH,
    TERMS,
    TIME,
    Course,
    Friedlander,
    HalfSine,
    Load,
    Noise,
    Rectangular,
    Size,
    Sweep,
    Tone,
    Triangular,
    values_of,
)
from nlds_vines.model.loads.record import Record
from nlds_vines.model.setting import (
    Checked,
    Real,
    Truth,
    Whole,
    check_settings,
    entries,
    setting,
    settings_of,
)

KINDS: Mapping[str, type[Course]] = {
    one.kind: one
    for one in (HalfSine, Triangular, Rectangular, Friedlander, Record, Tone, Sweep, Noise)
}
"""The loads that are smooth between kinks, by their keys in `[load]`."""

MOST_CELLS = 10**6
"""Cells of a load: 120 MB of coefficients."""

NEAR = 8.0
"""Kinks that are so many units in the last place of the duration apart are one."""

COARSE = 0.1
"""The longest step of a record, in natural periods of the structure alone."""


@dataclass
class Cells:
    """A load as kernels take it.

    `edges` (n + 1,) [s], ascending; `rows` (n, TERMS), the coefficients of the force on m1 [N] in
    powers of x = (t - edges[j]) / (edges[j + 1] - edges[j]); `jumps` (n + 1,), of v1 [m/s] at the
    edges, or None; `share` is 1 for a force on m1 alone, and 0 where it is -m1 a of the ground's
    acceleration a, which acts on the damper as -m2 a: then x1 and x2 are relative to the ground.
    """

    edges: np.ndarray
    rows: np.ndarray
    jumps: np.ndarray | None
    share: float

    def force(self, times: np.ndarray) -> np.ndarray:
        """Return the force on m1 (m,) [N] at times (m,) [s] within the cells."""
        j = np.clip(np.searchsorted(self.edges, times, side="right") - 1, 0, len(self.rows) - 1)
        x = (times - self.edges[j]) / (self.edges[j + 1] - self.edges[j])
        return values_of(self.rows[j], x)


@dataclass(frozen=True, kw_only=True)
class Blow(Load):
    """An impulse on m1, which changes v1 at once; one or several."""

    impulse: float = setting(MISSING, Size(), "", "[N s]; either sign")
    at: float = setting(0.0, TIME, "", "when it acts [s]")
    repeat: int = setting(1, Whole(1, 10**5), "", "how many there are")
    every: float = setting(0.0, TIME, "", "time from one to the next [s]")

    kind: ClassVar[str] = "blow"

    def check(self) -> None:
        if self.repeat > 1 and self.every <= 0.0:
            raise RequestError(f"every = {self.every:g} s between {self.repeat} blows must be > 0")

    @property
    def times(self) -> np.ndarray:
        """When each acts (repeat,) [s]."""
        return self.at + self.every * np.arange(self.repeat)

    def kinks(self, end: float) -> np.ndarray:
        return self.times[(self.times > 0.0) & (self.times < end)]


def _parts(kind: str) -> Checked:
    """Return the check of a kind's tables: one, or a list of several."""

    def check(value: object) -> tuple[Load, ...]:
        of = ALL[kind].of
        if isinstance(value, list | tuple):
            return tuple(one if isinstance(one, Load) else of(one) for one in value)
        if kind == Record.kind and isinstance(value, str):
            return (of({"file": value}),)
        return (of(value),)

    return Checked(check)


ALL: Mapping[str, type[Load]] = {Blow.kind: Blow, **KINDS}
"""All loads by their keys in `[load]`."""

_WORDS = {
    "blow": "an impulse, or several",
    "half_sine": "a pulse F sin(pi t / length)",
    "triangular": "a pulse up to F and down",
    "rectangular": "a pulse of constant F",
    "friedlander": "the pulse of a blast",
    "record": "a record: the path of a file",
    "tone": "a harmonic A cos(omega t + phase)",
    "sweep": "a sine whose frequency changes",
    "noise": "band-limited noise",
}


def _of(kind: str) -> Any:
    words = f"{_WORDS[kind]}; a table `[load.{kind}]`, or a list of several"
    return setting((), _parts(kind), "load", words)


@dataclass(frozen=True, kw_only=True)
class Loading:
    """The sum of loads: forces on m1, or accelerations of the ground, not both.

    Coordinates are relative to the ground where it is shaken.
    """

    impulse: float = setting(
        0.0, Checked(lambda value: value and Size()("impulse", value)), "load",
        "of a blow on m1 at t = 0 [N s]", "N_S",
    )  # fmt: skip
    harmonic: bool = setting(
        False, Truth(), "load", "whether the harmonic force P cos(omega t) acts as well",
        option="--harmonic",
    )  # fmt: skip
    scale: float = setting(
        1.0, Real(-1e9, 1e9), "load", "by which all loads but the harmonic force are multiplied",
    )  # fmt: skip
    blow: tuple[Load, ...] = _of("blow")
    half_sine: tuple[Course, ...] = _of("half_sine")
    triangular: tuple[Course, ...] = _of("triangular")
    rectangular: tuple[Course, ...] = _of("rectangular")
    friedlander: tuple[Course, ...] = _of("friedlander")
    record: tuple[Course, ...] = _of("record")
    tone: tuple[Course, ...] = _of("tone")
    sweep: tuple[Course, ...] = _of("sweep")
    noise: tuple[Course, ...] = _of("noise")

    def __post_init__(self) -> None:
        check_settings(self)
        if self.shaken and (self.impulse or self.blow or self.harmonic):
            what = "harmonic" if self.harmonic else "impulse"
            raise RequestError(f"{what}: a force on m1 beside an acceleration of the ground")
        if self.shaken and not all(one.shakes for one in self.parts):
            one = next(one for one in self.parts if not one.shakes)
            raise RequestError(
                f"{one.kind}: unit = {one.unit!r}, a force on m1, beside an acceleration of the "
                "ground"
            )

    @property
    def parts(self) -> tuple[Course, ...]:
        """All loads but impulses."""
        return tuple(one for kind in KINDS for one in getattr(self, kind))

    @property
    def acts(self) -> bool:
        """Whether it is the sum of anything."""
        return bool(self.impulse or self.blow or self.parts or self.harmonic)

    @property
    def shaken(self) -> bool:
        """Whether the ground is accelerated."""
        return any(one.shakes for one in self.parts)

    @property
    def blows(self) -> tuple[tuple[float, float], ...]:
        """The impulses: each its time [s] and its size [N s]."""
        found = [(0.0, self.impulse)] if self.impulse else []
        for one in self.blow:
            assert isinstance(one, Blow)
            found += [(float(t), one.impulse) for t in one.times]
        return tuple((t, self.scale * size) for t, size in found)

    @property
    def sweeps(self) -> tuple[Sweep, ...]:
        return tuple(one for one in self.sweep if isinstance(one, Sweep))

    def force_of(self, sweep: Sweep) -> float:
        """Return the amplitude [N] of a sweep that is a force on m1."""
        return abs(sweep.amplitude * sweep.factor * self.scale)

    def to_table(self) -> dict[str, Any]:
        """Return the table `[load]` that means exactly this sum."""
        found = entries(self, "load")
        for kind in ALL.keys() & found.keys():
            found[kind] = [one.entry() for one in found[kind]]
        return found

    def number(self, name: str) -> float:
        """Return a number by its name, as `with_` takes it; `RequestError` where there is none."""
        owner, key = self._owner(name)
        return number(name, getattr(owner, key))

    def is_whole(self, name: str) -> bool:
        """Return True if a number is a whole one, as a count or a seed."""
        owner, key = self._owner(name)
        return isinstance(getattr(owner, key), int)

    def check_values(self, name: str, values: np.ndarray) -> None:
        """Raise `RequestError` for the first of the values (n,) that a number may not take."""
        owner, key = self._owner(name)
        check = next(said.check for said in settings_of(owner).values() if said.key == key)
        whole = self.is_whole(name)
        for value in values.tolist():
            check(name, int(value) if whole and value == int(value) else value)

    def redrawn(self, times: int) -> Loading:
        """Return the sum with its noise drawn again: each seed raised by so many."""
        drawn = (one for one in self.noise if isinstance(one, Noise))
        return replace(self, noise=tuple(replace(one, seed=one.seed + times) for one in drawn))

    def with_(self, changes: Mapping[str, float]) -> Loading:
        """Return this sum with other numbers, by names as `impulse` and `friedlander.peak`.

        Raises `RequestError` for a name that it does not have, or has several of.
        """
        loading = self
        for name, value in changes.items():
            owner, key = loading._owner(name)
            if isinstance(owner, Loading):
                one: dict[str, Any] = {name: value}
            else:
                given: Any = getattr(owner, key)
                exact = int(value) if isinstance(given, int) and value == int(value) else value
                one = {owner.kind: (replace(owner, **{key: exact}),)}
            loading = replace(loading, **one)
        return loading

    def _owner(self, name: str) -> tuple[Loading | Load, str]:
        """Return what a number belongs to, and its key; `RequestError` where there is none."""
        kind, _, key = name.partition(".")
        if not key:
            if name not in NUMBERS:
                raise RequestError(
                    f"{name} is no number of a load; allowed: {', '.join(NUMBERS)}, or KIND.KEY as "
                    "friedlander.peak"
                )
            return self, name
        held = getattr(self, kind, None) if kind in ALL else None
        if not held or len(held) > 1:
            raise RequestError(f"{name}: the load has {len(held or ())} of {kind!r}; allowed: one")
        known = [said.key for said in settings_of(held[0]).values()]
        if key not in known:
            raise RequestError(f"{name}: {kind} has no {key!r}; allowed: {', '.join(known)}")
        return held[0], key

    def check(self, duration: float, period: float) -> None:
        """Refuse what repeats itself within a duration [s], too coarse records, too many cells.

        Arguments: `period`, the natural one of the structure [s].
        """
        for noise in self.noise:
            assert isinstance(noise, Noise)
            if noise.lasts < duration:
                raise RequestError(
                    f"noise of {noise.tones} tones repeats itself after {noise.lasts:g} s of "
                    f"{duration:g} s: give it more tones, or a shorter duration"
                )
        for one in self.record:
            assert isinstance(one, Record)
            if one.step > COARSE * period * (1.0 + 1e-9):  # steps are differences
                raise RequestError(
                    f"record {one.source}: a step of {one.step:g} s is too coarse for a structure "
                    f"with the natural period {period:g} s; allowed: up to {COARSE * period:g} s"
                )
        self._parted(self.parts, duration, np.inf, np.zeros(0))

    def words(self) -> str:
        """Return the sum in a few words."""
        found = [f"a blow of {self.impulse:g} N s"] if self.impulse else []
        found += [_words_of(one) for kind in ALL for one in getattr(self, kind)]
        found += ["the harmonic force"] if self.harmonic else []
        times = f" times {self.scale:g}" if self.scale != 1.0 else ""
        return " + ".join(found) + times

    def records_in_words(self, duration: float) -> list[str]:
        """Return a line for each record: its size, and how much acts within a duration [s]."""
        return [one.summary(duration) for one in self.record if isinstance(one, Record)]

    def cells(self, on: Struck, duration: float, reach: float, marks: np.ndarray) -> Cells:
        """Return the cells of what acts on a structure.

        Arguments: `on`, its mass and its harmonic force; `duration` [s]; `reach`, the longest cell
        [s] that its flight allows; `marks`, times that are to be edges.

        Raises `RequestError` for more than `MOST_CELLS`.
        """
        push = -on.mass if self.shaken else 1.0
        acting = [(one, push * one.factor * self.scale) for one in self.parts]
        if self.harmonic and on.force:
            acting.append((Tone(amplitude=on.force, omega=on.omega), 1.0))
        blows = [(time, size) for time, size in self.blows if time <= duration]
        courses = [one for one, _ in acting]
        edges = _divided(*self._parted(courses, duration, reach, marks))
        begins, lengths = edges[:-1], np.diff(edges)
        rows = np.zeros((len(begins), TERMS))
        for one, size in acting:
            rows += one.rows(begins, lengths) * size
        jumps = np.zeros(len(edges)) if blows else None
        for time, size in blows:
            assert jumps is not None
            jumps[np.abs(edges - time).argmin()] += size / on.mass
        return Cells(edges, rows, jumps, 0.0 if self.shaken else 1.0)

    def _parted(
        self, courses: Sequence[Course], duration: float, reach: float, marks: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the edges at which anything is not smooth, and the number of cells between them.

        Raises `RequestError` for more than `MOST_CELLS`.
        """
        kinks = [one.kinks(duration) for one in courses]
        times = np.array([time for time, _ in self.blows if time <= duration])
        edges = _merged(duration, np.concatenate([*kinks, marks, times]))
        middles = 0.5 * (edges[:-1] + edges[1:])
        rates = np.max([one.rates(middles) for one in courses], axis=0, initial=REACH / reach)
        counts = np.maximum(np.ceil(np.diff(edges) * rates / REACH), 1.0)
        if (total := counts.sum()) > MOST_CELLS:
            raise RequestError(
                f"{total:.0f} cells of time; allowed: {MOST_CELLS}; a shorter duration, or "
                "loads of lower frequency"
            )
        return edges, counts.astype(np.int64)


class Struck(NamedTuple):
    """The structure that a load acts on: its mass [kg], its harmonic force [N] of omega [rad/s]."""

    mass: float
    force: float = 0.0
    omega: float = 1.0


NUMBERS = ("impulse", "scale")
"""The numbers of `[load]` itself."""


def words_of_number(load: Loading, name: str) -> tuple[str, str]:
    """Return the unit and the name in words of a number of a load, as `with_` takes it."""
    kind, _, key = name.rpartition(".")
    owner: Any = getattr(load, kind)[0] if kind else load
    said = next(said for said in settings_of(owner).values() if said.key == key)
    unit = owner.unit if "`unit`" in said.words else "1"
    if said.words.endswith("]"):
        unit = said.words[:-1].rpartition("[")[2]
    of = "the loads" if name == "scale" else "a blow" if not kind else kind.replace("_", " ")
    return unit, f"{key} of {of}"


def _words_of(one: Load) -> str:
    if isinstance(one, Record):
        return f"record {one.source or len(one.values)}"
    told = {key: value for key, value in one.entry().items() if isinstance(value, float) and value}
    if isinstance(one, Sweep):
        span = f"{one.first:g} to {one.last:g} rad/s in {one.length:g} s"
        return f"sweep ({span}, amplitude {one.amplitude:g} {one.unit})"
    return f"{one.kind.replace('_', ' ')} ({', '.join(f'{k} {v:g}' for k, v in told.items())})"


def _merged(duration: float, times: np.ndarray) -> np.ndarray:
    """Return edges from 0 to the duration, of times that are one to round-off the first alone."""
    inner = np.unique(times)
    gap = NEAR * float(np.spacing(duration))
    inner = inner[(inner > gap) & (inner < duration - gap)]
    apart = np.ones(len(inner), bool)
    apart[1:] = np.diff(inner) > gap
    return np.concatenate([[0.0], inner[apart], [duration]])


def _divided(edges: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return edges with each interval divided into equal cells, `counts` (n,) of them."""
    which = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    inner = edges[which] + (edges[which + 1] - edges[which]) * (place / counts[which])
    return np.concatenate([inner, edges[-1:]])
