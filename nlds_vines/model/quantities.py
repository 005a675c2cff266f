"""The table of recorded quantities: name, unit, meaning, where it is stored, how it is drawn.

Archives, pictures, pages, objectives and `docs/datasets.md` follow from these tables: `QUANTITIES`
for scans, codes and labels included, and `OF_LOADS` for structures under a load in time.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from types import MappingProxyType
from typing import Any

import numpy as np

from nlds_vines.archives.dataset import Dataset
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.kernels.scene.codes import (
    AT_PHASE,
    AT_SPEED,
    AT_WALL,
    NOT_COMPUTED,
    OF_FORCES,
    OF_IMPULSES,
    POWERS,
)
from nlds_vines.model.scenes import BASES, Scene

STRUCTURE = "structure"  # the forced body; kinds of one mass have another one (`Scene.body`)
# where a number is drawn by default: on maps, the first recorded one first; as panels of diagrams
# without a section; in the section at impact; below the other panels of a diagram
MAPS, CURVES, TOUCHED, BELOW = "maps", "curves", "touched", "below"
# scales: symmetric about zero; logarithmic, with zero as round-off; a color for each period;
# logarithmic from one period on
SIGNED, ERROR, PERIOD, WAIT = "signed", "error", "period", "wait"
_LONGEST = 48  # characters of a label along an axis


@dataclass(frozen=True)
class Quantity:
    """One dataset of a scan: its meaning, its place in the kernels' buffers, its look."""

    name: str
    unit: str  # SI, in the notation of CF; "1" for a number without one
    # its meaning; {body} and {first}: the forced body, {x} and {v}: its coordinates, {by}: what
    # drives it, {frame}: ", relative to the ground" if that moves
    words: str
    # the records of a scan that contain it, () for every scan; a scene that has this quantity can
    # have the first of them recorded; without meaning under a load
    record: tuple[str, ...]
    label: str = ""  # on axes, by default the beginning of `words`
    symbol: str = ""
    has: Callable[[Scene], Any] = lambda scene: True  # of the scenes that have it
    # after `start`; `damper` only with several dampers, `wall` only with two walls
    dims: tuple[str, ...] = ()
    dtype: str = "float64"  # as in `archives.dataset.Dataset`
    fill: float | int | str = np.nan
    beside: str = ""  # a record that must be requested as well
    # a field of `LaneBuffers`, or "evidence", from which `bifurcation.run`, `engine.responses` or
    # `engine.batch` takes it; "" if it is made of others, as reductions are
    buffer: str = ""
    column: int | None = None  # in the buffer; None for all of it; of each wall: the first one
    of: Callable[[np.ndarray], np.ndarray] | None = None  # of the buffer, in place of a column
    reduced: bool = False  # whether it is compared with that of the structure alone
    drawn: tuple[str, ...] = ()  # of `MAPS`, `CURVES`, `TOUCHED`, `BELOW`
    scale: str = ""  # of `SIGNED`, `ERROR`, `PERIOD`, `WAIT`; by default linear over its range
    width: str = ""  # the name of the quantity that is half the width of its interval

    @cached_property
    def single(self) -> bool:
        """Whether it is one number for each orbit, neither a code nor a text."""
        return not self.dims and self.dtype in ("float64", "int32")

    def title(self, body: str = STRUCTURE) -> str:
        """Return its label with its symbol, as text; `body` as in `Scene.body`."""
        words = f"{self.label or clause(self.words)} {self.symbol}".replace("$", "").strip()
        return words.replace(STRUCTURE, body)

    def from_buffer(self, values: np.ndarray) -> np.ndarray:
        if self.of is not None:
            return self.of(values)
        return values if self.column is None else values[..., self.column]

    def dataset(
        self,
        dims: tuple[str, ...],
        scene: Scene,
        flags: Mapping[str, int] | None = None,
        prefix: str = "",
    ) -> Dataset:
        name, words = f"{prefix}{self.name}", self.words_in(scene)
        return Dataset(name, dims, self.dtype, self.unit, words, self.fill, flags)

    def words_in(self, scene: Scene) -> str:
        first = "primary structure" if scene.body == STRUCTURE else scene.body
        x, v = scene.components[:2]
        by = "the motion of the ground" if scene.shaken else "the force"
        frame = ", relative to the ground" if scene.shaken else ""
        return self.words.format(body=scene.body, first=first, x=x, v=v, by=by, frame=frame)


def clause(text: str) -> str:
    """Return the text before the first comma, semicolon or bracket, up to 48 characters."""
    clause = re.split(r"[,;:(]", text, maxsplit=1)[0].strip()
    return clause if len(clause) <= _LONGEST else clause[:_LONGEST].rpartition(" ")[0]


# ---- quantities of scans -------------------------------------------------------------------------

# impacts per sampled period up to which all touches of an orbit are recorded, in sequence
TOUCHES = 4

_ORDER = (
    "section", "impacts", "speeds", "impact_section", "modulation", "energy", "peak", "response",
    "regime", "lyapunov", "settling", "evidence", "attractor", "clearance", "spectrum",
    "lines", "broadband",
)  # fmt: skip


_walls, _damper = attrgetter("walls"), attrgetter("damper")
_has_symbols = attrgetter("has_symbols")


def _has_owners(scene: Scene) -> bool:
    return not scene.has_symbols


def _is_compared(scene: Scene) -> bool:
    """Return True if there is a damper, and the response without it is known."""
    return scene.is_alone_known and scene.damper


def _two_walls(scene: Scene) -> bool:
    return len(scene.walls) > 1 or (bool(scene.walls) and bool(scene.dampers))


def _rigid(scene: Scene) -> bool:
    return bool(scene.walls) and any(law.instant for law in scene.laws)


def _driven(scene: Scene) -> bool:
    """Return True if there are walls, and a spring about whose rest the forced body moves."""
    return bool(scene.walls) and not {"k1", "k"}.isdisjoint(scene.parameter_names)


def _energies(kind: str, word: str, which: str, **options: Any) -> Iterator[Quantity]:
    for i, (body, label) in enumerate((("{first}", STRUCTURE), ("damper", "damper"))):
        words = f"{which} of the {body}'s energy E{i + 1}{{frame}}, equation (6)"
        yield Quantity(
            f"E{i + 1}{kind}", "J", words, (word,), f"energy of the {label}", f"E{'₁₂'[i]}{kind}",
            (lambda scene: scene.damper and not scene.dampers) if i else lambda scene: True,
            buffer=word, column=i, **options,
        )  # fmt: skip


def _motion(name: str, column: int, unit: str, words: str, label: str, **options: Any) -> Any:
    """Yield the largest and the rms value of a motion, each with its reduction if it has one."""
    drawn = options.pop("drawn", ())
    for kind, which, of, shown in (("max", "largest", "", drawn), ("rms", "rms", "of the ", ())):
        yield from _response(
            f"{name}_{kind}", unit, f"{which} {of}{words}", f"{which} {label}",
            column=column + (kind == "rms"), drawn=shown, **options,
        )  # fmt: skip


def _response(
    name: str, unit: str, words: str, label: str = "", **options: Any
) -> Iterator[Quantity]:
    """Yield a quantity of a kind's response, and its reduction if it is compared."""
    has = options.pop("has", lambda scene: True)
    options["has"] = lambda scene: _has_symbols(scene) and has(scene)
    yield Quantity(name, unit, words, ("response",), label, buffer="response", **options)
    if options.get("reduced"):
        words = f"reduction by the damper, 1 - {name} / that of the structure alone"
        yield Quantity(
            f"{name}_reduction", "1", words, ("response",), f"reduction, {label}",
            has=lambda scene: _is_compared(scene) and has(scene),
        )  # fmt: skip


def _whole(name: str, words: str, record: tuple[str, ...], **options: Any) -> Quantity:
    options = {"fill": -1, **options}
    return Quantity(name, "1", words, record, dtype="int32", **options)


def _text(name: str, words: str, record: tuple[str, ...], **options: Any) -> Quantity:
    return Quantity(name, "1", words, record, dtype="str", fill="", **options)


def _code(name: str, words: str, record: tuple[str, ...], fill: int, **options: Any) -> Quantity:
    return Quantity(name, "1", words, record, dtype="int8", fill=fill, **options)


def _of_verdict(name: str, unit: str, words: str, column: int, **options: Any) -> Quantity:
    options = {"record": ("evidence",), **options}
    return Quantity(name, unit, words, buffer="evidence", column=column, **options)


_SPEEDS = f"approach speed of each impact; there is room for {TOUCHES} a sampled period"
_PHASES = "phase of {by} at the touch of each impact, omega t from 0 to 2 pi"
_HARMS = "reduction by the damper, 1 - E1max / E1max of the structure alone; negative: it harms"
_MISS = "least distance of a local approach that did not become an impact; inf if there was none"
_AMPLITUDE = "{} amplitude of the {{body}}, sqrt({{x}}^2 + ({{v}} / omega)^2) at t = nT"
_RATIO = "amplitude_min / amplitude_max: 1 if steady, near 0 if strongly modulated,"
_STATE = "m, m/s"

OF_SIGNALS = "{signals}"  # the unit of a quantity that has the unit of its spectrum's signal


# the quantities of scans, the most important first; of two of one name, the first applies
QUANTITIES = (
    Quantity(
        "section", _STATE, "state at t = nT, the integer forcing periods{frame}", ("section",),
        dims=("forcing_period", "component"), buffer="section",
    ),
    *_energies("max", "energy", "steady-state maximum", drawn=(MAPS, CURVES)),
    *_energies("peak", "peak", "maximum, the transient included,", drawn=(MAPS,)),
    Quantity(
        "E2max", "J", "steady-state maximum of the energy of each damper{frame}, equation (6)",
        ("energy",), "energy of the damper", "E₂max", has=attrgetter("dampers"), dims=("damper",),
        buffer="energy", of=lambda energy: energy[..., 1:], drawn=(MAPS, CURVES),
    ),
    Quantity(
        "reduction", "1", _HARMS, ("energy",), has=_is_compared,
        drawn=(MAPS,), scale=SIGNED,
    ),
    *(
        Quantity(
            name, unit, f"{words} of each displacement that is recorded", ("response",), words,
            has=_has_owners, dims=("displacement",), buffer="response",
            column=column, drawn=(MAPS, CURVES) * (name != "x_rms"),
        )
        for column, (name, unit, words) in enumerate((
            ("x_max", "m", "largest displacement"),
            ("x_rms", "m", "rms displacement"),
            ("a_max", "m/s^2", "largest absolute acceleration"),
        ))
    ),
    *(
        Quantity(
            name, "m", f"{words}, that of the ground included", ("response",), words,
            has=lambda scene: _has_owners(scene) and bool(scene.shaken), dims=("displacement",),
            buffer="response", column=column, drawn=(MAPS, CURVES) * (name != "x_abs_rms"),
        )
        for column, name, words in (
            (3, "x_abs_max", "largest absolute displacement"),
            (4, "x_abs_rms", "rms absolute displacement"),
        )
    ),
    *_motion(
        "x1", 0, "m", "displacement {x} of the {body}{frame}", "displacement",
        reduced=True, drawn=(MAPS, CURVES),
    ),
    *_motion("v1", 2, "m/s", "velocity {v} of the {body}{frame}", "velocity", reduced=True),
    *_motion(
        "a1", 4, "m/s^2", "absolute acceleration of the {body}, contacts included", "acceleration",
        has=lambda scene: not _rigid(scene), reduced=True, drawn=(MAPS, CURVES),
    ),
    *_motion(
        "stroke", 6, "m", "stroke of the damper, x2 - x1 counted from where its spring rests",
        "stroke", has=_damper, drawn=(MAPS, CURVES),
    ),
    *_motion(
        "x1_abs", 8, "m", "absolute displacement of the {body}, {x} + y above the moving ground y",
        "absolute displacement", has=attrgetter("shaken"), reduced=True,
    ),
    *_response(
        "transmissibility", "1", "transmissibility: rms of the {body}'s absolute displacement / "
        "rms of the ground's", column=9, has=attrgetter("shaken"),
    ),
    *_response(
        "force_max", "N", "largest contact force", column=OF_FORCES, dims=("wall",),
        has=lambda scene: scene.walls and not all(law.instant for law in scene.laws),
    ),
    *_response(
        "impulse_max", "N s", "largest impulse of an impact", "largest impulse",
        column=OF_IMPULSES, has=_rigid, dims=("wall",),
    ),
    Quantity(
        "impulse_max", "N s", "largest impulse of each damper's rigid walls; NaN of a damper "
        "without one", ("response",), "largest impulse", dims=("damper",), drawn=(MAPS, CURVES),
        has=attrgetter("with_rigid_walls"),
    ),
    *_response(
        "power_c1", "W", "mean power dissipated by the dashpot c1", "dissipated power",
        column=POWERS, symbol="c₁",
    ),
    *_response(
        "power_c2", "W", "mean power dissipated by the dashpot c2", "dissipated power",
        column=POWERS + 1, symbol="c₂", has=_damper,
    ),
    *_response(
        "power_contact", "W", "mean power dissipated by contacts", "dissipated by contacts",
        column=POWERS + 2, has=_walls,
    ),
    *_response("power_in", "W", "mean power put in by {by}", "power put in", column=POWERS + 3),
    _whole(
        "impact_count", "impacts per nT; -1 where no period was found (`impact_rate` counts there)",
        ("impacts", "regime"), has=_walls, label="impacts per $n$T",
    ),
    Quantity(
        "impact_rate", "1", "impacts per forcing period", ("impacts", "regime"), has=_walls,
        drawn=(MAPS, CURVES),
    ),
    _whole(
        "impacts_by_wall", "impacts per nT by what is struck; -1 where no period was found",
        ("impacts",), has=_two_walls, dims=("damper", "wall"), label="impacts per $n$T",
    ),
    Quantity(
        "impact_rate_by_wall", "1", "impacts per forcing period by what is struck", ("impacts",),
        "impacts per forcing period", has=_two_walls, dims=("damper", "wall"),
    ),
    Quantity(
        "impact_speed", "m/s", _SPEEDS, ("speeds", "impact_section"), "approach speed",
        has=_walls, dims=("impact",), buffer="touches", column=AT_SPEED, drawn=(TOUCHED,),
    ),
    Quantity(
        "impact_phase", "rad", _PHASES, ("impact_section",), "phase at touch", "φ", has=_walls,
        dims=("impact",), buffer="touches", drawn=(TOUCHED,),
        of=lambda touches: 2.0 * np.pi * (touches[..., AT_PHASE] % 1.0),
    ),
    _code(
        "impact_wall", "what each impact strikes", ("impact_section",), -1, has=_two_walls,
        dims=("impact",), buffer="touches",
        of=lambda touches: np.nan_to_num(touches[..., AT_WALL], nan=-1.0).astype(np.int8),
    ),
    *(
        Quantity(
            name, unit, f"{words} of each displacement x that is recorded, with its rate v",
            ("modulation",), label, has=_has_owners, dims=("displacement",),
            drawn=(MAPS, CURVES) if unit == "1" else (CURVES,),
        )
        for name, unit, words, label in (
            ("amplitude_min", "m", "smallest amplitude sqrt(x^2 + (v / omega)^2) at t = nT",
             "smallest amplitude"),
            ("amplitude_max", "m", "largest amplitude sqrt(x^2 + (v / omega)^2) at t = nT",
             "largest amplitude"),
            ("amplitude_ratio", "1", _RATIO, "smallest over largest amplitude"),
        )
    ),
    Quantity(
        "amplitude_min", "m", _AMPLITUDE.format("smallest"), ("modulation",), "smallest amplitude",
        has=_driven, drawn=(CURVES,),
    ),
    Quantity(
        "amplitude_max", "m", _AMPLITUDE.format("largest"), ("modulation",), "largest amplitude",
        has=_driven, drawn=(CURVES,),
    ),
    Quantity(
        "two_impacts", "1", "share of the sampled periods with two impacts", ("modulation",),
        "periods with two impacts", has=_driven, drawn=(MAPS, CURVES),
    ),
    _code(
        "capture",
        "response by impacts a period: sustained 1:1 from 1.99 to 2.01, strongly modulated below",
        ("modulation",), -1, has=lambda scene: _driven(scene) and _two_walls(scene),
    ),
    Quantity(
        "amplitude_ratio", "1", f"{_RATIO} of the {{body}}", ("modulation",),
        "smallest over largest amplitude", has=_driven, drawn=(MAPS, CURVES),
    ),
    Quantity(
        "clearance", "m", _MISS, ("clearance",), "smallest near miss", "z_min", _walls,
        buffer="clearance", column=0, drawn=(MAPS, CURVES),
    ),
    _whole(
        "periodicity", "n of nT; 0 where none was found", ("regime", "impacts"), fill=0,
        label="period", symbol="n", drawn=(MAPS, CURVES), scale=PERIOD,
    ),
    _code("regime", "kind of the steady state", ("regime",), 0),
    _text("label", "regime in words: nT,k, chaos, undetermined ...", ("regime",)),
    _whole(
        "settling",
        "forcing period from which on returns obey the final orbit's multipliers; -1 if none",
        ("settling",), label="forcing periods until settled", buffer="evidence",
        column=ev.SETTLING, drawn=(MAPS,), scale=WAIT,
    ),
    _of_verdict(
        "lyapunov", "1/s", "largest Lyapunov exponent", ev.LYAPUNOV, record=("lyapunov",),
        label="Lyapunov exponent", symbol="λ₁", drawn=(MAPS, BELOW), scale=SIGNED,
        width="lyapunov_width",
    ),
    _of_verdict(
        "lyapunov_width", "1/s",
        "half the width of its 99 % interval; 0 where it follows from Floquet multipliers",
        ev.INTERVAL, record=("lyapunov",),
    ),
    _of_verdict(
        "residual", "1", "closure error of a periodic orbit, relative to its size", ev.RESIDUAL
    ),
    Quantity(
        "multipliers", "1", "Floquet multipliers of the nT orbit", ("evidence",),
        dims=("multiplier", "part"),
    ),
    Quantity("exponents", "1/s", "Lyapunov exponents", ("evidence",), dims=("exponent",)),
    Quantity(
        "orbit_point", _STATE,
        "a point of the periodic orbit's section, after the last period watched", ("evidence",),
        dims=("component",),
    ),
    _of_verdict(
        "averaging", "1", "digits to which time averages over two halves of an orbit agree",
        ev.DIGITS, label="digits to which averages agree",
    ),
    _of_verdict(
        "watched", "1", "forcing periods computed, from the start of the orbit", ev.WATCHED
    ),
    _of_verdict(
        "transient_lyapunov", "1/s", "largest exponent before settling, if it is late",
        ev.PASSING, label="exponent before settling", symbol="λ₁", drawn=(MAPS,), scale=SIGNED,
        width="transient_lyapunov_width",
    ),
    _of_verdict(
        "transient_lyapunov_width", "1/s", "half the width of its 99 % interval", ev.PASSING_WIDTH
    ),
    _of_verdict(
        "orbit_clearance", "m", "smallest near miss of the periodic orbit", ev.CLEARANCE,
        has=_walls,
    ),
    _of_verdict(
        "softest_impact", "m/s", "smallest approach speed of the periodic orbit", ev.SLOWEST,
        label="smallest approach speed", has=_walls,
    ),
    _whole("attractor", "number of the attractor of the orbit; -1 where it is not known",
           ("attractor",)),
    _whole("arrival", "forcing periods until the orbit is near its closed orbit; -1 if never",
           ("attractor",)),
    Quantity(
        "end_state", _STATE, "last state of the section; of a periodic orbit, of its closed orbit",
        ("attractor",), dims=("component",),
    ),
    _text("label", "final regime in words: nT,k, chaos ...", ("attractor",)),
    Quantity(
        "start_state", _STATE, "state at t = 0 that was drawn for the orbit", (),
        dims=("component",),
    ),
    Quantity(
        "P", "N", "force on the {body} at t = 0, minus its mass times the ground's acceleration",
        (),
        has=lambda scene: scene.shaken in BASES,
    ),
    _whole(
        "violations", "number of violations of the limit, the transient included", (),
        has=attrgetter("limit"), buffer="violation", column=2,
    ),
    Quantity(
        "first_violation", "s", "time of the first violation; NaN if there was none", (),
        has=attrgetter("limit"), buffer="violation", column=0,
    ),
    Quantity(
        "violation_depth", "m", "deepest violation", (), has=attrgetter("limit"),
        buffer="violation", column=1, drawn=(MAPS,),
    ),
    Quantity(
        "spectrum", OF_SIGNALS, "amplitude of the line in each bin; at zero frequency abs(mean)",
        ("spectrum",), "spectrum", dims=("signal", "frequency"),
    ),
    _whole(
        "line_period",
        "n of the nT orbit by recurrence, whose lines these are; 0 if none was found", ("lines",),
        fill=0,
    ),
    Quantity(
        "line_amplitude", OF_SIGNALS, "amplitude A of the line A cos(m omega t / n + phase)",
        ("lines",), "amplitudes of lines", dims=("signal", "line"), scale=ERROR,
    ),
    Quantity(
        "line_phase", "rad", "phase of the line, t from the start of the orbit", ("lines",),
        dims=("signal", "line"),
    ),
    Quantity(
        "broadband", "1", "share of the power in the background of the spectrum, outside its lines",
        ("broadband",), "broadband share", dims=("signal",), scale=ERROR,
    ),
    _text(
        "spectral_label",
        "regime by the spectra: nT by recurrence, lines, broadband or unclear", ("broadband",),
    ),
    _code(
        "spectra_agree", "whether spectral_label agrees with the regime of the verdict",
        ("broadband",), -1, beside="regime",
    ),
    _code("status", "how the computation ended, with the remedy", (), NOT_COMPUTED),
)  # fmt: skip
BY_NAME: Mapping[str, Quantity] = MappingProxyType({q.name: q for q in reversed(QUANTITIES)})
OF_SIGNALS_BY_NAME: Mapping[str, Quantity] = MappingProxyType(
    {q.name: q for q in QUANTITIES if "signal" in q.dims}
)

# of a cycle of nT, beside `periodicity`
COUNTS_PER_CYCLE = ("impact_count", "impacts_by_wall")

# the words of `[record] want`, in the order in which a request keeps them
RECORDS = tuple(dict.fromkeys((*_ORDER, *(word for q in QUANTITIES for word in q.record))))

COORDINATES: Mapping[str, tuple[str, str]] = {  # of a section: body or meaning, and symbol
    "x": (STRUCTURE, "x"),
    "x1": (STRUCTURE, "x₁"),
    "x2": ("damper", "x₂"),
    "v": ("velocity", "v"),
    "v1": (f"velocity of the {STRUCTURE}", "v₁"),
    "v2": ("velocity of the damper", "v₂"),
}


def drawn_in(place: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(entry.name for entry in QUANTITIES if place in entry.drawn))


def scale_of(name: str) -> str:
    return BY_NAME[name].scale if name in BY_NAME else ""


def recorded(scene: Scene, want: Collection[str]) -> list[Quantity]:
    """Return the quantities that a scan records: those of `want`, then those of every scan."""
    by_name: dict[str, Quantity] = {}
    for word in (*(word for word in RECORDS if word in want), None):
        for entry in QUANTITIES:
            asked = word in entry.record if word else not entry.record
            if asked and entry.has(scene) and (not entry.beside or entry.beside in want):
                by_name.setdefault(entry.name, entry)
    return list(by_name.values())


def stored_in(buffer: str) -> tuple[Quantity, ...]:
    return tuple(entry for entry in QUANTITIES if entry.buffer == buffer)


# ---- quantities under a load ---------------------------------------------------------------------

# of absolute displacements, which an acceleration of the ground over time does not tell
OF_KNOWN_GROUND = ("x1_abs_max", "x1_abs_rms", "x_abs_max", "x_abs_rms", "transmissibility")

SHARES = (0.01, 0.1, 0.5)  # of the largest E1, above which `last_1` ... are the last times
# what dissipates energy
WAYS = {"c1": "dashpot c1", "c2": "dashpot c2", "contact": "contacts"}


def _of(name: str, unit: str, words: str, label: str, symbol: str = "", **options: Any) -> Quantity:
    return Quantity(name, unit, words, (), label, symbol, **options)


def _last(share: float) -> Quantity:
    per_cent = f"{100 * share:g}"
    words = f"last time at which E1 exceeds {per_cent} % of its largest; NaN: it does at the end"
    return _of(f"last_{per_cent}", "s", words, f"time above {per_cent} % of the largest E1")


_BY_SYMBOL: dict[str, Any] = {"has": _has_symbols}
_BY_ROW: dict[str, Any] = {"dims": ("displacement",)}
# an only damper, whose quantities have symbols, may be missing: then they are NaN
_BY_DAMPER: dict[str, Any] = {
    "dims": ("damper",),
    "has": lambda scene: scene.has_symbols or scene.damper,
}

OF_LOADS = (
    *map(_last, SHARES),
    _of("damping_ratio", "1",
        "of a linear structure whose E1 falls from its largest to 10 % in the same time",
        "equivalent damping ratio", "ζ", **_BY_SYMBOL),
    _of("E1max", "J", "largest energy of the structure, its velocity relative to the ground",
        "largest energy", "E₁max"),
    _of("x_max", "m", "largest displacement, relative to the ground", "largest displacement",
        **_BY_ROW),
    _of("x_rms", "m", "rms displacement, relative to the ground", "rms displacement", **_BY_ROW),
    _of("a_max", "m/s^2", "largest absolute acceleration, contacts included; infinite where the "
        "impulse of a rigid wall acts", "largest absolute acceleration", **_BY_ROW),
    _of("drift_ratio", "1", "largest drift of a storey over its height", "largest drift ratio",
        **_BY_ROW),
    _of("drift_ratio_max", "1", "largest drift of all storeys over their heights",
        "largest drift ratio of all storeys"),
    _of("E2max", "J", "largest energy of the damper, its velocity relative to the ground",
        "largest energy of the damper", "E₂max", **_BY_DAMPER),
    _of("x1_max", "m", "largest displacement of the structure, relative to the ground",
        "largest displacement", **_BY_SYMBOL),
    _of("x1_rms", "m", "rms displacement of the structure, relative to the ground, without the "
        "time to settle", "rms displacement", **_BY_SYMBOL),
    _of("v1_max", "m/s", "largest velocity of the structure, relative to the ground",
        "largest velocity", **_BY_SYMBOL),
    _of("a1_max", "m/s^2", "largest absolute acceleration of the structure, contacts included",
        "largest absolute acceleration", **_BY_SYMBOL),
    _of("stroke_max", "m", "largest stroke of the damper, counted from where its spring rests",
        "largest stroke", **_BY_DAMPER),
    _of("force_max", "N", "largest contact force", "largest contact force", **_BY_DAMPER),
    _of("shear_max", "N", "largest base shear, the force k1 x1 of the structure's spring",
        "largest base shear", **_BY_SYMBOL),
    _of("impulse_max", "N s", "largest impulse of an impact", "largest impulse", **_BY_DAMPER),
    _of("impact_count", "1", "number of impacts; -1 without walls, or of an orbit that failed",
        "impacts", dtype="int32", fill=-1, **_BY_DAMPER),
    _of("energy_in", "J", "energy brought in, by the start and by the load", "energy brought in",
        **_BY_SYMBOL),
    *(_of(f"share_{sink}", "1", f"share of the energy brought in that {what} dissipated by the end",
          f"share dissipated by {what}", **_BY_SYMBOL)
      for sink, what in WAYS.items()),
    _of("balance", "1", "largest abs(in - stored - dissipated) / largest energy brought in",
        "error of the energy balance", scale=ERROR, **_BY_SYMBOL),
)  # fmt: skip
"""The quantities of a response to a load; of displacements and named dampers by owner, roof.x_max.

Quantities of an only damper of the paper's kinds have symbols, as E2max.
"""

DRIFT_RATIOS = ("drift_ratio", "drift_ratio_max")  # as reports and pictures show them

OF_LOADS_BY_NAME: Mapping[str, Quantity] = MappingProxyType({q.name: q for q in OF_LOADS})


def of_load(name: str) -> Quantity:
    """Return a quantity of `OF_LOADS` by its name; of roof.x_max the label has the owner."""
    owner, dot, plain = name.rpartition(".")
    entry = OF_LOADS_BY_NAME[plain]
    return replace(entry, label=f"{entry.label} of {owner}") if dot else entry


def _history(name: str, unit: str, words: str, label: str = "", *dims: str) -> Quantity:
    return Quantity(name, unit, words, (), label, dims=dims)


HISTORIES: Mapping[str, Quantity] = MappingProxyType({
    entry.name: entry
    for entry in (
        _history("E1", "J", "energy of the structure, its velocity relative to the ground"),
        _history("E2", "J", "energy of the damper, its velocity relative to the ground",
                 "energy", "damper"),
        _history("x1", "m", "displacement of the structure, relative to the ground"),
        _history("x2", "m", "displacement of the damper, relative to the ground"),
        _history("work", "J", "energy that came in so far, by the start and by the load"),
        *(_history(f"dissipated_{sink}", "J", f"energy dissipated by {what} so far")
          for sink, what in WAYS.items()),
        _history("x", "m", "displacement, relative to the ground", "displacement",
                 "displacement"),
        _history("a", "m/s^2", "absolute acceleration", "absolute acceleration", "displacement"),
        _history("stroke", "m", "displacement along the spring, positive toward its wall +",
                 "displacement along the spring", "damper"),
    )
})  # fmt: skip
"""The datasets over time of a response to a load by name."""

TOUCH_COLUMNS = {
    "touch": ("s", "time of a touch"),
    "release": ("s", "time of the release"),
    "speed": ("m/s", "approach speed"),
    "force": ("N", "largest contact force, infinite at rigid walls"),
    "depth": ("m", "largest depth"),
    "impulse": ("N s", "largest impulse of a rigid wall, 0 of other walls"),
    "damper": ("1", "number of the damper, from 0"),
    "wall": ("1", "its wall, 1 of those that limit r from above, -1 from below"),
}
"""The columns of the impacts under a load, with their units and meanings."""
