"""The datasets of a scan's archive: each with its dimensions, type, unit and meaning.

This is the only table of them: blocks are checked against it, the archive is written by it, and
pictures take their units from it.  `Scan.table` makes it once.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.model.axis import Axis
from nlds_vines.model.parameters import described
from nlds_vines.model.scenes import Scene
from nlds_vines.orbits.labels import FLAGS, KEPT
from nlds_vines.orbits.responses import quantities_of
from nlds_vines.orbits.spectral_records import SpectralRecords
from nlds_vines.orbits.starts import Start
from nlds_vines.orbits.status_words import NOT_COMPUTED, STATUS
from nlds_vines.orbits.wants import RETRACED, SPEEDS, WANTS


def struck(scene: Scene) -> tuple[str, ...]:
    """Return the names of the two bodies that a damper strikes; empty for a scene of one wall."""
    return tuple(scene.struck[wall] for wall in scene.walls) if len(scene.walls) > 1 else ()


def bodies_of(scene: Scene) -> tuple[str, ...]:
    """Return what has an energy, in words."""
    first = "primary structure" if scene.body == "structure" else scene.body
    return (first, "damper") if scene.damper else (first,)


def scales_of(
    axes: Sequence[Axis],
    scene: Scene,
    start: Start,
    periods: int,
    want: Collection[str],
    spectral: SpectralRecords | None = None,
) -> tuple[Scale, ...]:
    """Return every dimension that a dataset of a scan may have, with its values."""
    varied = (
        Scale(axis.name, axis.values, described(axis.name).unit, described(axis.name).meaning)
        for axis in axes
    )
    cycles = np.arange(1, periods + 1, dtype=np.int32)
    walls = struck(scene)
    return (
        *varied,
        Scale("start", np.array(start.names, dtype=np.str_), "1", "start of the orbit"),
        Scale("cycle", cycles, "1", "sampled forcing period, counted after the transient"),
        *([_speed_scale(periods)] if scene.walls and "speeds" in want else []),
        Scale("component", np.array(scene.components), "1", "component of the state"),
        *([Scale("wall", np.array(walls), "1", "what is struck")] if walls else []),
        *(state_scales(len(scene.components)) if "evidence" in want else ()),
        *(() if spectral is None else spectral.scales()),
    )


def state_scales(count: int) -> Iterator[Scale]:
    """Yield the dimensions that count what belongs to a state of so many components."""
    order = np.arange(1, count + 1, dtype=np.int32)
    yield Scale("multiplier", order, "1", "Floquet multiplier, the largest modulus first")
    yield Scale("exponent", order, "1", "Lyapunov exponent, the largest first")
    yield Scale("part", np.array(["real", "imaginary"]), "1", "part of a complex number")


def table_of(
    axes: Sequence[Axis],
    scene: Scene,
    start: Start,
    periods: int,
    want: Collection[str],
    spectral: SpectralRecords | None = None,
) -> Table:
    """Return the datasets of a scan's archive: those that `want` asks for, and `status`.

    `spectral` says more of spectra, where any are wanted.

    Impacts and clearances exist only in scenes with a wall, the damper's energy only with a
    damper: what cannot happen in a scene takes no room in its archive.
    """
    lanes = (*(axis.name for axis in axes), "start")
    makers = {
        "section": _section(lanes),
        "impacts": _impacts(lanes, len(scene.walls)),
        "speeds": _speeds(lanes) if scene.walls else (),
        "energy": (
            *_energy(lanes, scene, "max", "steady-state maximum"),
            *(_reduction(lanes) if scene.damper else ()),
        ),
        "peak": _energy(lanes, scene, "peak", "maximum, the transient included,"),
        "response": _response(lanes, scene),
        "regime": _regime(lanes, bool(scene.walls)),
        "lyapunov": _lyapunov(lanes),
        "settling": _settling(lanes),
        "evidence": _evidence(lanes, bool(scene.walls)),
        "attractor": _attractor(lanes, "regime" in want),
        "clearance": _clearance(lanes) if scene.walls else (),
        "error": _error(lanes, want),
    }
    wanted = [dataset for word in WANTS if word in want for dataset in makers.get(word, ())]
    wanted += [] if spectral is None else spectral.datasets(lanes)
    drawn = _drawn(lanes) if start.policy == "random" else ()
    driven = _ground_force(lanes) if scene.shaken else ()
    always = (*drawn, *driven, *(_violations(lanes) if scene.limit else ()), _status(lanes))
    lengths = _lengths(axes, scene, start, periods, want)
    return Table.of((*wanted, *always), lengths | ({} if spectral is None else spectral.lengths()))


def _lengths(
    axes: Sequence[Axis], scene: Scene, start: Start, periods: int, want: Collection[str]
) -> dict[str, int]:
    """Return the length of every dimension, without its values: there may be too many of them."""
    size = len(scene.components)
    found = {axis.name: axis.values.size for axis in axes}
    found |= {"start": start.orbits, "cycle": periods, "component": size}
    if "speeds" in want:
        found |= {"impact": SPEEDS * periods}
    if struck(scene):
        found |= {"wall": len(struck(scene))}
    if "evidence" in want:
        found |= {"multiplier": size, "exponent": size, "part": 2}
    return found


def _section(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    text = "state at t = nT, the integer forcing periods"
    dims = (*lanes, "cycle", "component")
    return (Dataset("section", dims, "float64", "m, m/s", text, np.nan),)


def _drawn(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    text = "state at t = 0 that was drawn for the orbit"
    return (Dataset("start_state", (*lanes, "component"), "float64", "m, m/s", text, np.nan),)


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


def _speed_scale(periods: int) -> Scale:
    order = np.arange(1, SPEEDS * periods + 1, dtype=np.int32)
    return Scale("impact", order, "1", "impact after the transient, counted from the first")


def _speeds(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    text = f"approach speed of each impact; there is room for {SPEEDS} a sampled period"
    return (Dataset("impact_speed", (*lanes, "impact"), "float64", "m/s", text, np.nan),)


def _energy(lanes: tuple[str, ...], scene: Scene, suffix: str, which: str) -> tuple[Dataset, ...]:
    text = "{} of the {}'s energy E{}, equation (6)"
    return tuple(
        Dataset(f"E{i}{suffix}", lanes, "float64", "J", text.format(which, body, i), np.nan)
        for i, body in enumerate(bodies_of(scene), start=1)
    )


def _reduction(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    text = "reduction by the damper, 1 - E1max / E1max of the structure alone; negative: it harms"
    return (Dataset("reduction", lanes, "float64", "1", text, np.nan),)


def _ground_force(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    """Return the dataset of a system whose ground moves: its force follows from other numbers."""
    return (_number(lanes, "P", "N", "amplitude of the force that the ground's motion makes"),)


def _response(lanes: tuple[str, ...], scene: Scene) -> Iterator[Dataset]:
    """Yield the quantities of a response, each followed by its reduction, where there is one."""
    for entry in quantities_of(scene):
        dims = (*lanes, "wall") if entry.walls and struck(scene) else lanes
        yield Dataset(entry.name, dims, "float64", entry.unit, entry.meaning, np.nan)
        if entry.reduced and scene.damper:
            text = f"reduction by the damper, 1 - {entry.name} / that of the structure alone"
            yield Dataset(f"{entry.name}_reduction", lanes, "float64", "1", text, np.nan)


def _violations(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    """Return the datasets of a scene whose damper must not come too near the structure."""
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


def _number(lanes: tuple[str, ...], name: str, units: str, text: str) -> Dataset:
    """Return a dataset of one number for each orbit."""
    return Dataset(name, lanes, "float64", units, text, np.nan)


def _evidence(lanes: tuple[str, ...], walls: bool) -> Iterator[Dataset]:
    """Yield the evidence of a verdict; NaN where it does not apply."""

    yield _number(lanes, "residual", "1", "what does not close of a periodic orbit, relative to it")
    dims = (*lanes, "multiplier", "part")
    text = "Floquet multipliers of the nT orbit"
    yield Dataset("multipliers", dims, "float64", "1", text, np.nan)
    text = "all Lyapunov exponents"
    yield Dataset("exponents", (*lanes, "exponent"), "float64", "1/s", text, np.nan)
    text = "a point of the periodic orbit's section, after the last period watched"
    yield Dataset("orbit_point", (*lanes, "component"), "float64", "m, m/s", text, np.nan)
    yield _number(lanes, "averaging", "1", "digits to which time averages of its two halves agree")
    yield _number(lanes, "watched", "1", "forcing periods looked at, from the start of the orbit")
    yield _number(
        lanes, "transient_lyapunov", "1/s", "largest exponent before settling, where it is late"
    )
    yield _number(lanes, "transient_lyapunov_width", "1/s", "half the width of its 99 % interval")
    if walls:
        yield _number(lanes, "orbit_clearance", "m", "smallest near miss of the periodic orbit")
        yield _number(
            lanes, "softest_impact", "m/s", "smallest approach speed of the periodic orbit"
        )


def _attractor(lanes: tuple[str, ...], labelled: bool) -> Iterator[Dataset]:
    """Yield the attractor of each orbit, and its final regime unless the verdict says more."""
    text = "number of the attractor of the orbit; -1 where it is not known"
    yield Dataset("attractor", lanes, "int32", "1", text, -1)
    text = "forcing periods until the orbit is certain to be drawn to its attractor; -1 if never"
    yield Dataset("arrival", lanes, "int32", "1", text, -1)
    if not labelled:
        yield Dataset("label", lanes, "str", "1", "final regime in words: nT,k, chaos ...", "")


def _clearance(lanes: tuple[str, ...]) -> tuple[Dataset, ...]:
    text = "least distance of a local approach that did not become an impact; inf if there was none"
    return (Dataset("clearance", lanes, "float64", "m", text, np.nan),)


def _error(lanes: tuple[str, ...], want: Collection[str]) -> Iterator[Dataset]:
    """Yield the differences that refined settings make; NaN where they fail."""

    text = f"largest over the last sampled periods, up to {RETRACED}, from the same state each"
    yield _number(
        lanes, "error", "m, m/s", f"discretisation error of the state over a period: {text}"
    )
    text = "difference of the last state from that of a refined run; in chaos of the orbit's size"
    yield _number(lanes, "error_at_end", "m, m/s", text)
    if "energy" in want:
        yield _number(lanes, "E1max_error", "J", "difference of E1max from that of a refined run")
    if "regime" in want:
        text = "regime in words that a refined run finds"
        yield Dataset("refined_label", lanes, "str", "1", text, "")
        text = "whether label and refined_label are the same words"
        yield Dataset("label_kept", lanes, "int8", "1", text, -1, KEPT)


def _status(lanes: tuple[str, ...]) -> Dataset:
    flags = {status.meaning: code for code, status in STATUS.items()}
    text = "how the computation ended, with the remedy"
    return Dataset("status", lanes, "int8", "1", text, NOT_COMPUTED, flags)
