"""What a scan's archive holds: every dataset with its dimensions, type, unit and meaning.

Pure data.  The engine allocates by this table, the archive writes by it, the regimes take their
codes from it and the pictures their units: none of them can drift away from the others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from math import prod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nlds_vines.parameters import PARAMETERS
from nlds_vines.scenes import SCENES

if TYPE_CHECKING:
    from nlds_vines.scan import Scan

WANTS = (
    "section",
    "impacts",
    "energy",
    "peak",
    "regime",
    "lyapunov",
    "settling",
    "evidence",
    "clearance",
    "error",
)
"""What `[record] want` may ask for."""

JUDGED = frozenset({"regime", "lyapunov", "settling", "evidence"})
"""Of `WANTS`, what rests on a verdict."""

NOTED = 4096
"""Periods of a transient, the last ones, in which a verdict looks for the time of settling."""

RETRACED = 64
"""Sampled periods, the last ones, that refined settings trace again for the error of a period.

In a row, so that an orbit of up to so many periods shows all of its impacts."""

COMPONENTS = ("x1", "v1", "x2", "v2")
"""The state in the order in which kernels and archives hold it [m, m/s, m, m/s]."""

FLAGS: Mapping[str, int] = {
    "undetermined": 0,
    "periodic": 1,
    "quasiperiodic": 2,
    "chaotic": 3,
    "transient_chaos": 4,
    "failed": 5,
}
"""Regimes by name: the CF flags of the dataset `regime`."""

KEPT: Mapping[str, int] = {"no": 0, "yes": 1}
"""Whether a label is kept under refinement: the CF flags of the dataset `label_kept`."""


class Status(NamedTuple):
    """How the computation of one lane ended: a CF word, and the sentence that helps a user on."""

    name: str
    remedy: str

    @property
    def meaning(self) -> str:
        """Name and remedy as one CF word, `diverged.check_the_damping`: split at the dot."""
        words = self.remedy.rstrip(".").replace(",", "").replace(";", "").replace(":", "")
        return f"{self.name}.{words.replace(' ', '_')}"


OK, NOT_COMPUTED, DIVERGED, STEP_BUDGET, BAD_PARAMETERS, TOO_STIFF = range(6)

STATUS: Mapping[int, Status] = {
    OK: Status("ok", "Nothing to do."),
    NOT_COMPUTED: Status("not_computed", "Finish the scan with --resume."),
    DIVERGED: Status("diverged", "Check masses, damping and forcing: the state grows unbounded."),
    STEP_BUDGET: Status("step_budget", "Raise omega or lower K: a period took too many steps."),
    BAD_PARAMETERS: Status("bad_parameters", "Vary within the ranges that the system allows."),
    TOO_STIFF: Status(
        "too_stiff", "Raise omega, masses or the steps of rk4, or lower stiffness or damping."
    ),
}
"""Status of a lane by code: the CF flags of the dataset `status`. New codes need no other place."""


@dataclass(frozen=True)
class Dataset:
    """One dataset of an archive.

    `dims` are the names of its dimensions: the varied parameters, then `start`, then its tail
    (`cycle`, `component`).  `dtype` is a NumPy type name, or "str" for variable-length UTF-8.
    `fill` stands where nothing was computed.  `flags` maps the CF words of an enumeration to codes.
    """

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    fill: float | int | str
    flags: Mapping[str, int] | None = None

    @property
    def tail(self) -> tuple[str, ...]:
        """The dimensions after `start`: what one lane contributes."""
        return self.dims[self.dims.index("start") + 1 :]

    @property
    def flag_values(self) -> tuple[int, ...] | None:
        """The codes of an enumeration in the order of `flag_meanings`; None for anything else."""
        return None if self.flags is None else tuple(self.flags.values())

    @property
    def flag_meanings(self) -> str | None:
        """The words of an enumeration, blank-separated as CF has it; None for anything else."""
        return None if self.flags is None else " ".join(self.flags)


class Scale(NamedTuple):
    """A dimension: its values (one-dimensional; numbers or strings), their unit and meaning."""

    name: str
    values: np.ndarray
    units: str
    long_name: str


def noted(want: Collection[str], transient: int, periods: int) -> int:
    """Return for how many periods of an orbit its section is kept while it is computed.

    The error of a period needs the state at its beginning: a row before the sampled ones.
    """
    judged = not JUDGED.isdisjoint(want)
    sampled = periods if judged or "section" in want or "error" in want else 0
    before = NOTED if judged else int("error" in want)
    return sampled + min(transient, before)


def components(scan: Scan) -> tuple[str, ...]:
    """Return the names of the state's components: without a damper only x1 and v1."""
    return COMPONENTS if SCENES[scan.system.kind].damper else COMPONENTS[:2]


def _state_scales(scan: Scan) -> Iterator[Scale]:
    """Yield the dimensions that count what belongs to a state: one for each of its components."""
    count = len(components(scan))
    order = np.arange(1, count + 1, dtype=np.int32)
    yield Scale("multiplier", order, "1", "Floquet multiplier, the largest modulus first")
    yield Scale("exponent", order, "1", "Lyapunov exponent, the largest first")
    yield Scale("part", np.array(["real", "imaginary"]), "1", "part of a complex number")


def _wall_scale(names: tuple[str, ...]) -> tuple[Scale, ...]:
    return (Scale("wall", np.array(names), "1", "what is struck"),) if names else ()


def struck(scan: Scan) -> tuple[str, ...]:
    """Return what the walls of a scene belong to where it has two of them; otherwise nothing."""
    scene = SCENES[scan.system.kind]
    return tuple(scene.struck[wall] for wall in scene.walls) if len(scene.walls) > 1 else ()


def starts(scan: Scan) -> tuple[str, ...]:
    """Return the names of the starts: `rest`, `up`, `down`; `random 0`, `random 1` for several."""
    return scan.start.names


def scales(scan: Scan) -> tuple[Scale, ...]:
    """Return every dimension that a dataset of this scan may have, with its values."""
    axes = (
        Scale(axis.name, axis.values, PARAMETERS[axis.name].unit, PARAMETERS[axis.name].meaning)
        for axis in scan.axes
    )
    cycles = np.arange(1, scan.periods + 1, dtype=np.int32)
    return (
        *axes,
        Scale("start", np.array(starts(scan), dtype=np.str_), "1", "start of the orbit"),
        Scale("cycle", cycles, "1", "sampled forcing period, counted after the transient"),
        Scale("component", np.array(components(scan)), "1", "component of the state"),
        *_wall_scale(struck(scan)),
        *(_state_scales(scan) if "evidence" in scan.want else ()),
    )


def sizes(scan: Scan) -> dict[str, int]:
    """Return the length of every dimension that a dataset of this scan may have."""
    axes = {axis.name: axis.values.size for axis in scan.axes}
    tail = {"start": scan.starts, "cycle": scan.periods, "component": len(components(scan))}
    if struck(scan):
        tail |= {"wall": len(struck(scan))}
    if "evidence" in scan.want:
        tail |= {"multiplier": tail["component"], "exponent": tail["component"], "part": 2}
    return axes | tail


def datasets(scan: Scan) -> tuple[Dataset, ...]:
    """Return what the archive of a scan holds: what its `want` asks for, `status`, nothing else.

    Impacts and clearances exist only in scenes with a wall, the damper's energy only with a
    damper: what cannot happen in a scene takes no room in its archive.
    """
    lanes = (*(axis.name for axis in scan.axes), "start")
    scene = SCENES[scan.system.kind]
    makers = {
        "section": _section(lanes),
        "impacts": _impacts(lanes, len(scene.walls)),
        "energy": (
            *_energy(lanes, scene.damper, "max", "steady-state maximum"),
            *(_reduction(lanes) if scene.damper else ()),
        ),
        "peak": _energy(lanes, scene.damper, "peak", "maximum, the transient included,"),
        "regime": _regime(lanes, bool(scene.walls)),
        "lyapunov": _lyapunov(lanes),
        "settling": _settling(lanes),
        "evidence": _evidence(lanes, bool(scene.walls)),
        "clearance": _clearance(lanes) if scene.walls else (),
        "error": _error(lanes, scan.want),
    }
    wanted = (dataset for want in WANTS if want in scan.want for dataset in makers[want])
    always = (*(_violations(lanes) if scene.limit else ()), _status(lanes))
    by_name = {dataset.name: dataset for dataset in (*wanted, *always)}
    return tuple(by_name.values())


def most_bytes(scan: Scan) -> int:
    """Return how many bytes the results of a scan take in its archive, were nothing compressed.

    A string counts for 64, which is more than any label with its reference needs.
    """
    length = sizes(scan)
    of_results = (
        _item_bytes(entry.dtype) * prod(length[dim] for dim in entry.dims)
        for entry in datasets(scan)
    )
    return sum(of_results) + _item_bytes("str") * sum(length.values())


def filled(dataset: Dataset, shape: tuple[int, ...]) -> np.ndarray:
    """Return an array of a dataset's type and `shape`, everywhere the fill value.

    Strings come as an object array, so that labels of any length can be put in.
    """
    dtype = object if dataset.dtype == "str" else dataset.dtype
    return np.full(shape, dataset.fill, dtype=dtype)


def _item_bytes(dtype: str) -> int:
    return 64 if dtype == "str" else np.dtype(dtype).itemsize


def _section(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    text = "state at t = nT, the integer forcing periods"
    dims = (*lanes, "cycle", "component")
    return (Dataset("section", dims, "float64", "m, m/s", text, np.nan),)


def _count(lanes: tuple[str, ...]) -> Dataset:
    text = "impacts per nT; where no period was found, per sampled window"
    return Dataset("impacts", lanes, "int32", "1", text, -1)


def _impacts(lanes: tuple[str, ...], walls: int) -> Iterator[Dataset]:
    if walls:
        yield _count(lanes)
        text = "impacts per forcing period"
        yield Dataset("impact_rate", lanes, "float64", "1", text, np.nan)
    if walls > 1:
        text = "impacts by what is struck, counted as `impacts`"
        yield Dataset("impacts_by_wall", (*lanes, "wall"), "int32", "1", text, -1)


def _energy(lanes: tuple[str, ...], damper: bool, suffix: str, which: str) -> tuple[Dataset, ...]:
    text = "{} of the {}'s energy E{}, equation (6)"
    bodies = ("primary structure", "damper") if damper else ("primary structure",)
    return tuple(
        Dataset(f"E{i}{suffix}", lanes, "float64", "J", text.format(which, body, i), np.nan)
        for i, body in enumerate(bodies, start=1)
    )


def _reduction(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    text = "reduction by the damper, 1 - E1max / E1max of the structure alone; negative: it harms"
    return (Dataset("reduction", lanes, "float64", "1", text, np.nan),)


def _violations(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    """What a scene reports whose damper must not come too near the structure."""
    number = "how often the damper came where it must not, the transient included"
    first, depth = "time of the first violation; NaN if there was none", "deepest violation"
    return (
        Dataset("violations", lanes, "int32", "1", number, -1),
        Dataset("first_violation", lanes, "float64", "s", first, np.nan),
        Dataset("violation_depth", lanes, "float64", "m", depth, np.nan),
    )


def _regime(lanes: tuple[str, ...], walls: bool) -> Iterator[Dataset]:
    yield Dataset("period", lanes, "int32", "1", "n of nT; 0 where none was found", 0)
    if walls:
        yield _count(lanes)
    yield Dataset("regime", lanes, "int8", "1", "kind of the steady state", 0, FLAGS)
    yield Dataset("label", lanes, "str", "1", "regime in words: nT,k, chaos, undetermined ...", "")


def _lyapunov(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    width = "half the width of its 99 % interval; 0 where it follows from Floquet multipliers"
    return (
        Dataset("lyapunov", lanes, "float64", "1/s", "largest Lyapunov exponent", np.nan),
        Dataset("lyapunov_width", lanes, "float64", "1/s", width, np.nan),
    )


def _settling(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    text = "forcing periods until the section obeys the final orbit's own law; -1 if never"
    return (Dataset("settling", lanes, "int32", "1", text, -1),)


def _evidence(lanes: tuple[str, ...], walls: bool) -> Iterator[Dataset]:
    """What a verdict rests on; NaN where it does not apply."""

    def number(name: str, units: str, text: str) -> Dataset:
        return Dataset(name, lanes, "float64", units, text, np.nan)

    yield number("residual", "1", "what does not close of a periodic orbit, relative to it")
    dims = (*lanes, "multiplier", "part")
    text = "Floquet multipliers of the nT orbit"
    yield Dataset("multipliers", dims, "float64", "1", text, np.nan)
    text = "all Lyapunov exponents"
    yield Dataset("exponents", (*lanes, "exponent"), "float64", "1/s", text, np.nan)
    text = "a point of the periodic orbit's section, after the last period watched"
    yield Dataset("orbit_point", (*lanes, "component"), "float64", "m, m/s", text, np.nan)
    yield number("averaging", "1", "digits to which time averages of its two halves agree")
    yield number("watched", "1", "forcing periods looked at, from the start of the orbit")
    yield number("transient_lyapunov", "1/s", "largest exponent before settling, where it is late")
    yield number("transient_lyapunov_width", "1/s", "half the width of its 99 % interval")
    if walls:
        yield number("orbit_clearance", "m", "smallest near miss of the periodic orbit")
        yield number("softest_impact", "m/s", "smallest approach speed of the periodic orbit")


def _clearance(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    text = "least distance of a local approach that did not become an impact; inf if there was none"
    return (Dataset("clearance", lanes, "float64", "m", text, np.nan),)


def _error(lanes: tuple[str, ...], want: Collection[str]) -> Iterator[Dataset]:
    """What refined settings find otherwise; NaN where they fail."""

    def number(name: str, units: str, text: str) -> Dataset:
        return Dataset(name, lanes, "float64", units, text, np.nan)

    text = f"largest over the last sampled periods, up to {RETRACED}, from the same state each"
    yield number("error", "m, m/s", f"discretisation error of the state over a period: {text}")
    text = "difference of the last state from that of a refined run; in chaos of the orbit's size"
    yield number("error_at_end", "m, m/s", text)
    if "energy" in want:
        yield number("E1max_error", "J", "difference of E1max from that of a refined run")
    if "regime" in want:
        text = "regime in words that a refined run finds"
        yield Dataset("refined_label", lanes, "str", "1", text, "")
        text = "whether label and refined_label are the same words"
        yield Dataset("label_kept", lanes, "int8", "1", text, -1, KEPT)


def _status(lanes: tuple[str, ...]) -> Dataset:
    flags = {status.meaning: code for code, status in STATUS.items()}
    text = "how the computation ended, with the remedy"
    return Dataset("status", lanes, "int8", "1", text, NOT_COMPUTED, flags)
