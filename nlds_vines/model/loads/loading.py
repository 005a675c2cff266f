"""The table `[load]`: a sum of loads, and its cells, which the kernels take.

The loads themselves are in `courses` and `record`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from nlds_vines.errors import RequestError, at, by_dof_names, dof_name, number, string, table
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
    Sweep,
    Tone,
    Triangular,
    nonzero,
)
from nlds_vines.model.loads.record import Record
from nlds_vines.model.loads.suite import Size, size_of, suite_of
from nlds_vines.model.setting import (
    Checked,
    Real,
    Setting,
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

MOST_CELLS = 10**6  # cells of a load: 120 MB of coefficients
NEAR = 8.0  # kinks closer than so many units in the last place of the duration are merged
COARSE = 0.1  # the largest step of a record, in natural periods of the structure alone


@dataclass
class Cells:
    """A load as the kernels take it."""

    edges: np.ndarray  # (n + 1,) [s], ascending
    # (n, TERMS): the force on m1 [N] in powers of x = (t - edges[j]) / (edges[j + 1] - edges[j])
    rows: np.ndarray
    jumps: np.ndarray | None  # (n + 1,): those of v1 [m/s] at the edges
    # 1 for a force on m1 alone; 0 for the force -m1 a of the ground's acceleration a: then -m2 a
    # acts on the damper, and x1 and x2 are relative to the ground
    share: float

    def struck(self, jump: float) -> Cells:
        """Return the load with a blow at t = 0 that changes v1 by `jump` [m/s]."""
        if not jump:
            return self
        jumps = np.zeros(len(self.edges)) if self.jumps is None else self.jumps.copy()
        jumps[0] += jump
        return replace(self, jumps=jumps)


@dataclass(frozen=True, kw_only=True)
class Blow(Load):
    """One or several impulses on m1, each of which changes v1 at once."""

    impulse: float = setting(MISSING, nonzero, "", "[N s]; either sign")
    at: float = setting(0.0, TIME, "", "when it acts [s]")
    repeat: int = setting(1, Whole(1, 10**5), "", "how many there are")
    every: float = setting(0.0, TIME, "", "time from one to the next [s]")

    def check(self) -> None:
        if self.repeat > 1 and self.every <= 0.0:
            raise RequestError(f"every = {self.every:g} s between {self.repeat} blows must be > 0")


ALL: Mapping[str, type[Load]] = {Blow.kind: Blow, **KINDS}
NUMBERS = ("impulse", "scale")
OPTIONS = {  # on the command line, of the keys of `[load]` itself
    "impulse": "--impulse",
    "harmonic": "--harmonic",
    "scale": "--vary scale=0.5:2:4, in a tuning --over",
}


def of_load(name: str) -> RequestError:
    kind, dot, key = name.partition(".")
    option = f"--load {kind}:{key}=VALUE" if dot else OPTIONS[name]
    return RequestError(f"{name} belongs in [load]; on the command line: {option}")


def _loads(kind: str, words: str) -> Any:
    """Return the field of the loads of a kind, given as a table, a path, or a list of these."""

    def check(value: object) -> tuple[Load, ...]:
        each = value if isinstance(value, list | tuple) else [value]
        for given in (one for one in each if isinstance(one, Mapping)):
            for key in given.keys() & OPTIONS.keys() - settings_of(ALL[kind]).keys():
                with at(f"[load.{kind}]"):
                    raise of_load(key)
        return tuple(one if isinstance(one, Load) else ALL[kind].of(one) for one in each)

    words = f"{words}; a table `[load.{kind}]`, or a list of several"
    return setting((), Checked(check), "load", words)


def _places(value: object) -> str | Mapping[str, float]:
    """Return the degree of freedom that forces act on, or the factors of several by name."""
    if isinstance(value, Mapping) and value:
        factors = table("on", by_dof_names("on", value))
        return {dof: number(f"on.{dof}", factor) for dof, factor in factors.items()}
    return string("on", dof_name("on", value))


@dataclass(frozen=True, kw_only=True)
class Loading:
    """A sum of loads: forces on m1, or accelerations of the ground, to which x is relative."""

    impulse: float = setting(
        0.0, Checked(lambda value: nonzero("impulse", value) if number("impulse", value) else 0.0),
        "load", "of a blow on m1 at t = 0 [N s]", "N_S",
    )  # fmt: skip
    harmonic: bool = setting(
        False, Truth(), "load", "whether the harmonic force P cos(omega t) acts as well",
        option="--harmonic",
    )  # fmt: skip
    scale: float = setting(
        1.0, Real(-1e9, 1e9), "load", "factor of all loads but the harmonic force",
    )  # fmt: skip
    on: str | Mapping[str, float] | None = setting(
        None, Checked(_places), "load",
        "degree of freedom of a host that forces act on; or several with factors, "
        "`{ roof = 1.0, floor2 = 0.5 }`", "DOF",
    )  # fmt: skip
    blow: tuple[Blow, ...] = _loads("blow", "an impulse, or several")
    half_sine: tuple[Course, ...] = _loads("half_sine", "a pulse F sin(pi t / length)")
    triangular: tuple[Course, ...] = _loads("triangular", "a pulse up to F and down")
    rectangular: tuple[Course, ...] = _loads("rectangular", "a pulse of constant F")
    friedlander: tuple[Course, ...] = _loads("friedlander", "the pulse of a blast")
    record: tuple[Record, ...] = _loads("record", "a record: the path of a file")
    tone: tuple[Course, ...] = _loads("tone", "a harmonic A cos(omega t + phase)")
    sweep: tuple[Sweep, ...] = _loads("sweep", "a sine whose frequency changes")
    noise: tuple[Noise, ...] = _loads("noise", "band-limited noise")
    suite: tuple[Record, ...] = setting(
        (), Checked(suite_of), "load",
        "records that act one at a time, each with the other loads: paths, folders, or tables "
        "`[load.suite]` of records, where `file` may be a list",
    )  # fmt: skip
    scale_to: Size | None = setting(
        None, Checked(size_of), "load",
        "common size of all records: `{ peak = \"0.3 g\" }`, or a pseudo-acceleration at a period, "
        "`{ Sa = \"0.5 g\", T = 0.8, zeta = 0.05 }`; without a unit in m/s^2", "peak=0.3g",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)
        if self.scale_to is not None and not (self.record or self.suite):
            raise RequestError("scale_to: there is no record; allowed: beside records")
        if self.suite:
            for place in range(len(self.suite)):
                self.member(place)  # which refuses a force beside an acceleration
            return
        if self.shaken and (self.impulse or self.blow or self.harmonic):
            what = "harmonic" if self.harmonic else "impulse"
            raise RequestError(f"{what}: a force on m1 beside an acceleration of the ground")
        if self.shaken and not all(one.is_acceleration for one in self.parts):
            one = next(one for one in self.parts if not one.is_acceleration)
            raise RequestError(
                f"{one.kind}: unit = {one.unit!r}, a force on m1, beside an acceleration of the "
                "ground"
            )

    @property
    def parts(self) -> tuple[Course, ...]:
        """All loads but impulses."""
        return tuple(one for kind in KINDS for one in getattr(self, kind))

    def member(self, place: int) -> Loading:
        """Return the loads with one record of the suite, by its place."""
        return replace(self, record=(*self.record, self.suite[place]), suite=())

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the records of the suite."""
        return tuple(one.source for one in self.suite)

    @property
    def acts(self) -> bool:
        return bool(self.impulse or self.blow or self.parts or self.harmonic or self.suite)

    @property
    def shaken(self) -> bool:
        return any(one.is_acceleration for one in (*self.parts, *self.suite))

    @property
    def blows(self) -> tuple[tuple[float, float], ...]:
        """The time [s] and the size [N s] of each impulse."""
        impulses = [(0.0, self.impulse)] if self.impulse else []
        for one in self.blow:
            times = one.at + one.every * np.arange(one.repeat)
            impulses += [(time, one.impulse) for time in times.tolist()]
        return tuple((t, self.scale * size) for t, size in impulses)

    def force_of(self, sweep: Sweep) -> float:
        return abs(sweep.amplitude * sweep.factor * self.scale)

    def to_table(self) -> dict[str, Any]:
        document = entries(self, "load")
        for kind in (ALL.keys() | {"suite"}) & document.keys():
            document[kind] = [one.entry() for one in document[kind]]
        return document

    def number(self, name: str) -> float:
        owner, entry = self._entry(name)
        return number(name, getattr(owner, entry.key))

    def is_whole(self, name: str) -> bool:
        return isinstance(self._entry(name)[1].check, Whole)

    def check_values(self, name: str, values: np.ndarray) -> None:
        _, entry = self._entry(name)
        for value in values.tolist():
            entry.check(name, _as_needed(entry, value))

    def redrawn(self, times: int) -> Loading:
        return replace(self, noise=tuple(replace(one, seed=one.seed + times) for one in self.noise))

    def with_(self, changes: Mapping[str, float]) -> Loading:
        """Return this sum with other numbers, by names such as `impulse` and `friedlander.peak`."""
        loading = self
        for name, value in changes.items():
            owner, entry = loading._entry(name)
            change: dict[str, Any] = {entry.key: _as_needed(entry, value)}
            if isinstance(owner, Load):
                change = {owner.kind: (replace(owner, **change),)}
            loading = replace(loading, **change)
        return loading

    def words_of_number(self, name: str) -> tuple[str, str]:
        owner, entry = self._entry(name)
        unit = owner.unit if isinstance(owner, Course) and "`unit`" in entry.words else "1"
        if entry.words.endswith("]"):
            unit = entry.words[:-1].rpartition("[")[2]
        of = "the loads" if name == "scale" else "a blow"
        if isinstance(owner, Load):
            of = owner.kind.replace("_", " ")
        return unit, f"{entry.key} of {of}"

    def _entry(self, name: str) -> tuple[Loading | Load, Setting]:
        kind, _, key = name.partition(".")
        if not key:
            if name not in NUMBERS:
                raise RequestError(
                    f"{name} is no number of a load; allowed: {', '.join(NUMBERS)}, or KIND.KEY as "
                    "friedlander.peak"
                )
            return self, settings_of(self)[name]
        loads: tuple[Load, ...] = getattr(self, kind) if kind in ALL else ()
        if len(loads) != 1:
            raise RequestError(f"{name}: the load has {len(loads)} of {kind!r}; allowed: one")
        settings = settings_of(loads[0])
        if key not in settings:
            raise RequestError(f"{name}: {kind} has no {key!r}; allowed: {', '.join(settings)}")
        return loads[0], settings[key]

    def check(self, duration: float, period: float) -> None:
        """Raise `RequestError` for recurring noise, too many cells, records coarse for `period`."""
        for place in range(len(self.suite)):
            self.member(place).check(duration, period)
        for noise in self.noise:
            if noise.recurrence < duration:
                raise RequestError(
                    f"noise of {noise.tones} tones repeats itself after {noise.recurrence:g} s of "
                    f"{duration:g} s: give it more tones, or a shorter duration"
                )
        for one in self.record:
            if one.step > COARSE * period * (1.0 + 1e-9):  # steps are differences
                raise RequestError(
                    f"record {one.source}: a step of {one.step:g} s is too coarse for a structure "
                    f"with the natural period {period:g} s; allowed: up to {COARSE * period:g} s"
                )
        self._divided(self.parts, duration, np.inf, np.zeros(0))

    def words(self) -> str:
        terms = [f"a blow of {self.impulse:g} N s"] if self.impulse else []
        terms += [one.words() for kind in ALL for one in getattr(self, kind)]
        terms += ["the harmonic force"] if self.harmonic else []
        terms += [f"each of {len(self.suite)} records"] if self.suite else []
        times = f" times {self.scale:g}" if self.scale != 1.0 else ""
        return " + ".join(terms) + times

    def records_in_words(self, duration: float) -> list[str]:
        return [one.summary(duration) for one in (*self.record, *self.suite)]

    def cells(self, on: Struck, duration: float, reach: float, marks: np.ndarray) -> Cells:
        """Return the sum in cells of at most `reach` [s], with further edges at `marks` [s]."""
        push = -on.mass if self.shaken else 1.0
        acting = [(one, push * one.factor * self.scale) for one in self.parts]
        if self.harmonic and on.force:
            acting.append((Tone(amplitude=on.force, omega=on.omega), 1.0))
        blows = [(time, size) for time, size in self.blows if time <= duration]
        edges, counts = self._divided([one for one, _ in acting], duration, reach, marks)
        which = np.repeat(np.arange(len(counts)), counts)
        place = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
        inner = edges[which] + (edges[which + 1] - edges[which]) * (place / counts[which])
        edges = np.append(inner, duration)
        begins, lengths = edges[:-1], np.diff(edges)
        rows = np.zeros((len(begins), TERMS))
        for one, size in acting:
            powers = one.rows(begins, lengths)
            rows[:, : powers.shape[1]] += powers * size
        jumps = np.zeros(len(edges)) if blows else None
        for time, size in blows:
            assert jumps is not None
            jumps[np.abs(edges - time).argmin()] += size / on.mass
        return Cells(edges, rows, jumps, 0.0 if self.shaken else 1.0)

    def _divided(
        self, courses: Sequence[Course], duration: float, reach: float, marks: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the times (n + 1,) between which all is smooth, and the numbers (n,) of cells."""
        blows = np.array([time for time, _ in self.blows])
        times = np.unique(np.concatenate([*(one.kinks for one in courses), marks, blows]))
        gap = NEAR * float(np.spacing(duration))
        times = times[(times > gap) & (times < duration - gap)]
        is_apart = np.ones(len(times), bool)
        is_apart[1:] = np.diff(times) > gap
        edges = np.concatenate([[0.0], times[is_apart], [duration]])
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
    """The mass [kg] that a load acts on, its harmonic force [N] and the force's omega [rad/s]."""

    mass: float
    force: float = 0.0
    omega: float = 1.0


def _as_needed(entry: Setting, value: float) -> float:
    return int(value) if isinstance(entry.check, Whole) and value == int(value) else value
