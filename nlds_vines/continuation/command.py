"""Follow periodic orbits, stable or not, along a parameter: where and why regimes change.

As a command: `python -m nlds_vines.continuation`, or `nlds-vines continuation`.
In Python: `nlds_vines.continue_branch(system, parameter="omega", bounds=(5.0, 9.0))`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from nlds_vines.archives.provenance import CONTINUATION, SCAN
from nlds_vines.cli import command as commands
from nlds_vines.cli.options import SET, SYSTEM, Option, ends, named, numbers, numbers_by_name
from nlds_vines.cli.running import existing
from nlds_vines.continuation.branch_panels import names_of
from nlds_vines.continuation.request import (
    FUNCTION,
    STARTS,
    Begin,
    Continuation,
    Orbit,
    interval_in,
    load_continuation,
)
from nlds_vines.errors import RequestError, at, choice, number, shown
from nlds_vines.model.parameters import INITIAL
from nlds_vines.model.system import System
from nlds_vines.runs.run_options import RunOptions

if TYPE_CHECKING:
    from nlds_vines.continuation.result import Continued, Crossing
    from nlds_vines.engine.classification import Regime

    PeriodicOrbit = Regime | Crossing
    Monitor = Callable[[Crossing], float] | float | Sequence[float]

_NAME = "continuation"
ALIKE = 1e-9  # relative difference up to which two values of a parameter count as equal
_EXAMPLES = """\
examples:
  nlds-vines continuation
      the T,1 orbit of SSul NES Set 6 from 5 to 9 rad/s: folds, doublings, grazing
  nlds-vines continuation --doublings 3 --plot branches.png
      with the branches of twice, four and eight times the period
  nlds-vines continuation --system impact-oscillator --set omega=1.5 --along P=0.1:2
  nlds-vines continuation --from figure8.h5 --along omega=5:8 --over figure8.h5 --plot all.png
      the branches of all periodic orbits of a scan, drawn over its diagram
  nlds-vines continuation --plane P=400:1200 -o plane.h5 --plot plane.png
      where doublings and grazing lie in the plane of frequency and force
  nlds-vines continuation --from figure8.h5@omega=6.28 --along omega=5:8
  nlds-vines continuation --from branches.h5@omega=7.4 --orbit T,1 --along P=800:400
      from an orbit of earlier branches, downwards along another parameter
exit status: 0 done; 1 a branch or a curve is not complete; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on
"""


# public: its keywords are those of the command, more than eight
def continue_branch(
    system: System | Continuation | str | os.PathLike[str],
    parameter: str | None = None,
    bounds: Sequence[float] | np.ndarray | None = None,
    start: PeriodicOrbit | Sequence[PeriodicOrbit | float] | np.ndarray | str | None = None,
    *,
    to: str | os.PathLike[str] | None = None,
    period: int | None = None,
    plane: tuple[str, float, float] | None = None,
    monitors: Mapping[str, Monitor] | None = None,
    doublings: int | None = None,
    starts: int = STARTS,
    seed: int = 0,
    step: float | None = None,
    unstable: int | None = None,
    points: int | None = None,
    tori: int | None = None,
    tolerance: float | str | None = None,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = False,
) -> Continued:
    """Follow branches of periodic orbits, stable or not, along a parameter.

    Parameters
    ----------
    system : System, Continuation, str or path-like
        A system or its name in the catalog; a request or the path of its TOML file, whose entries
        the other arguments override.
    parameter : str, optional
        Name of the free parameter; by default that of the request, or omega.
    bounds : (2,) array_like, optional
        Its first and last value [SI], with `parameter` only; from the larger to the smaller one,
        branches run downwards.  Start orbits are searched for at the system's own value, or at the
        nearest end.
    start : Regime, Crossing or several of them, array_like or str, optional
        By default the start of the request, or the orbit from rest; a periodic `Regime`, or an
        orbit of `Continued.orbits_at`, at its own value of the parameter; a state (x1, v1, x2, v2),
        (x, v) or of a host [m, m/s], from which the orbit is classified; a label such as "3T,3",
        searched for among random starts; "random" for the orbits of all random starts.
    to : path-like, optional
        The archive (.h5); by default none is kept.
    period : int, optional
        With a state as start, n: the nT orbit nearest to it, stable or not, which is followed as
        one of its least period.
    plane : (str, float, float), optional
        A second parameter, its smallest and its largest value around the system's own: curves of
        special points are followed in the plane of both.
    monitors : mapping of str to callable, float or sequence of floats, optional
        By the name of a quantity (``"largest_force"``, ``"E1max"``, ``"largest_multiplier"`` ...),
        the values at which it is located along branches.  By any other name, a function of an
        orbit, the `Crossing` that `Continued.orbits_at` returns, whose zeros are located; where it
        is not finite, it has none.  They are special points of kind UZ.
    doublings : int, optional
        Number of successive period doublings whose branches are followed, by default 0.
    starts, seed : int
        Number and seed of random starts.
    step : float, optional
        Longest step, relative to the orbit and the interval together, by default 0.02.
    unstable : int, optional
        Number of successive unstable points at which a branch ends, by default 3000.
    points : int, optional
        The most points of a branch, by default 3000, or a curve, by default 400, in one direction.
    tori : int, optional
        Number of cells of a scan that follows the torus of each NS, by default none.
    tolerance : float or str, optional
        Of contacts: a number, "draft", "standard" or, by default, "fine".
    resume, overwrite : bool
        Whether to continue or to replace an existing archive.
    quiet : bool
        Whether to suppress progress.

    Returns
    -------
    Continued
        Branches, special points and curves.

    Raises
    ------
    RequestError
        If an argument is wrong, or the start is not periodic.

    Notes
    -----
    The orbits are fixed points of the n-fold stroboscopic map, followed by pseudo-arclength
    continuation.  An impact may appear or vanish along a branch: with Hertz contacts the map
    stays continuously differentiable there.  Once compiled, a point of T,1 takes some 0.4 ms.

    References
    ----------
    Allgower and Georg, Introduction to Numerical Continuation Methods, chapters 2 and 6.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> branches = nv.continue_branch("ssul-set6", "omega", (7.3, 7.4), unstable=9, quiet=True)
    >>> [(str(row.kind), round(float(row.value), 6)) for row in branches.special_points]
    [('PD', 7.362158)]
    """
    if (parameter is None) != (bounds is None):
        raise RequestError("parameter and bounds belong together")
    bounds = bounds.tolist() if isinstance(bounds, np.ndarray) else bounds
    for name, value, form in (
        ("bounds", (0.0, 0.0) if bounds is None else bounds, "two numbers"),
        ("plane", ("", 0.0, 0.0) if plane is None else plane, "a name and two numbers"),
    ):
        count = 2 if name == "bounds" else 3
        listed = isinstance(value, Sequence) and not isinstance(value, str)
        if not listed or len(value) != count or not (count == 2 or isinstance(value[0], str)):
            raise RequestError(f"{name} = {shown(value)}; allowed: {form}")
    search = {
        "doublings": doublings,
        "step": step,
        "unstable": unstable,
        "points": points,
        "tori": tori,
        "tolerance": tolerance,
    }
    changes: dict[str, Any] = {"search": {k: v for k, v in search.items() if v is not None}}
    functions: dict[str, Callable[..., Any]] = {}
    for name, one in (monitors or {}).items():
        if callable(one):
            functions[name] = one
        changes.setdefault("monitors", {})[name] = FUNCTION if callable(one) else one
    if plane is not None:
        changes["plane"] = {plane[0]: {"start": plane[1], "stop": plane[2]}}
    if parameter is not None and bounds is not None:
        changes["along"] = {parameter: {"start": bounds[0], "stop": bounds[1]}}
    request = load_continuation(system, changes, "continue_branch")
    is_state = has_orbits = False
    if isinstance(start, Sequence | np.ndarray) and not isinstance(start, str):
        has_orbits = len(start) > 0 and not isinstance(start[0], Real)
        is_state = not has_orbits
    if period is not None and not is_state:
        raise RequestError(f"period = {shown(period)} belongs to a start that is a state")
    if isinstance(start, str):
        key = "policy" if start in ("rest", "random") else "label"
        begin = {key: start, "count": starts, "seed": seed}
        request = load_continuation(request, {"start": begin}, "continue_branch")
    elif start is not None:
        several: Any = start if has_orbits else [start]
        orbits = [_periodic_start(request, one, period) for one in several]
        request = load_continuation(request, {"start": _columns(orbits)}, "continue_branch")
    if functions:
        request = replace(request, functions=functions)
    how = RunOptions(None, resume, overwrite, quiet=quiet)
    result: Continued = Job.compute(request, system, to, how)
    return result


def _periodic_start(request: Continuation, start: Any, period: int | None) -> Orbit:
    """Return an orbit of a regime or of branches, or that of a state at the request's value."""
    from nlds_vines.continuation.result import Crossing
    from nlds_vines.engine.classification import Regime, classify

    parameter, value = request.along.name, request.value
    if not isinstance(start, Regime | Crossing):
        if period is not None:
            return Orbit(tuple(number("start", one) for one in start), value, period)
        start = classify(request.system.with_(**{parameter: value}), start=start)
    if isinstance(start, Crossing):
        state = start.state
    elif start.point is None:
        raise RequestError(f"the start is {start.label}: only a periodic orbit can be followed")
    else:
        state = start.point
    theirs = start.system.parameters
    if parameter not in theirs:
        raise RequestError(f"the start's system has no {parameter}")
    ours = request.system.with_(**{parameter: theirs[parameter]}).parameters
    for name in ours.keys() & theirs.keys():
        if not math.isclose(ours[name], theirs[name], rel_tol=ALIKE):
            raise RequestError(
                f"the start is an orbit at {name} = {theirs[name]!r}, not {ours[name]!r}: continue "
                "its own system, or give its state with period="
            )
    return Orbit(tuple(state.tolist()), theirs[parameter], start.period)


def _columns(orbits: Sequence[Orbit]) -> dict[str, list[Any]]:
    """Return the entries of [start] for orbits."""
    return {
        "states": [list(orbit.state) for orbit in orbits],
        "values": [orbit.value for orbit in orbits],
        "periods": [orbit.period for orbit in orbits],
    }


@dataclass(frozen=True)
class Job(commands.Job):
    """A continuation with its archive.

    `over` is a scan over which its branches are drawn, `show` are panels, separated by commas.
    """

    default: ClassVar[str] = "branches.h5"

    request: Continuation
    over: Path | None = None
    show: str | None = None

    def others(self) -> Sequence[Path | None]:
        return (self.over,)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.over is not None:
            object.__setattr__(self, "over", existing(self.over, "--over"))
        if self.show is not None:
            panels = names_of(self.request)
            for word in self.show.split(","):
                choice("show", word.strip(), panels)

    def compute_archive(self) -> Any:
        from nlds_vines.continuation.run import run

        return run(self.request, self.archive, self.how)

    @classmethod
    def read(cls, path: Path) -> Any:
        from nlds_vines.continuation.result import read_continuation

        return read_continuation(path)

    @classmethod
    def picture(cls) -> Any:
        from nlds_vines.continuation.picture import PICTURE

        return PICTURE

    def draw(self, plot: Path, results: Continued) -> None:
        from nlds_vines.continuation.picture import picture

        picture(self.over).save(self.archive, plot, self.show, self.frequency, self.look)

    def lines(self, results: Continued) -> list[str]:
        if self.over is None or self.request.plane is not None:
            return [*results.lines()]
        from nlds_vines.archives.archive import read
        from nlds_vines.continuation.regime_borders import borders_of, report

        with read(self.over) as scan:
            return [*results.lines(), *report(results, scan, borders_of(results, scan))]

    def failure(self, results: Continued) -> str:
        branches, curves = results.incomplete
        words = []
        if branches:
            words.append("1 branch" if branches == 1 else f"{branches} branches")
        if curves:
            words.append("1 curve" if curves == 1 else f"{curves} curves")
        verb = "is" if branches + curves == 1 else "are"
        return f"{' and '.join(words)} {verb} not complete: the ends say why" if words else ""

    def plan(self) -> list[str]:
        request = self.request
        along, begin = request.along, request.begin
        starts = {
            "rest": "the orbit from rest",
            "random": f"the periodic orbits of {begin.count} random starts, seed {begin.seed}",
            "label": f"an orbit {begin.label} among {begin.count} random starts, seed {begin.seed}",
            "orbits": f"{len(begin.orbits)} given orbits",
        }
        return [
            request.title,
            f"along:    {along.heading()}",
            *([] if request.plane is None else [f"plane:    {request.plane.heading()}"]),
            f"start:    {starts[begin.policy]}"
            + ("" if begin.policy == "orbits" else f", at {along.name} = {request.value:g}"),
            f"branches: and those of {request.doublings} period doublings one after another",
            f"archive:  {self.archive}",
        ]


def _begin(text: str) -> dict[str, Any]:
    """Return the document of --from; an archive is read after all other options."""
    if text.partition("@")[0].endswith(".h5"):
        return {"from": text}
    if text in ("rest", "random"):
        return {"start": {"policy": text}}
    return {"start": {"policy": "label", "label": text}}


def _load(source: Any, changes: dict[str, Any], changes_from: str) -> Continuation:
    """Return the request of a file and of options; an archive gives start orbits and a system."""
    text, label = changes.pop("from", None), changes.pop("orbit", None)
    if text is None:
        if label is not None:
            raise RequestError(
                f"--orbit {label} is one of an archive, --from FILE.h5; --from {label} searches "
                "for it among random starts"
            )
        return load_continuation(source, changes, changes_from)
    from nlds_vines.archives.archive import read
    from nlds_vines.archives.files import parse_toml
    from nlds_vines.bifurcation.request import load_scan
    from nlds_vines.continuation.result import read_continuation
    from nlds_vines.continuation.run import orbits_in, orbits_on

    file, _, cell = text.partition("@")
    path, values = Path(file), numbers_by_name("--from", cell)
    with at(f"--from {path}"), read(path) as view:
        if view.content == CONTINUATION:
            earlier = read_continuation(path)
            usual = earlier.request.along if source is None else load_continuation(source).along
            system = earlier.request.system
            along = interval_in(changes.get("along") or usual.entry(), system)
            orbits = orbits_on(earlier, along, values)
            near = {n: value for n, value in values.items() if n != along.name}
        elif view.content == SCAN:
            system = load_scan(parse_toml(view.text("scan"), str(path))).system
            entry = changes.get("along") or load_continuation(source).along.entry()
            along = interval_in(entry, system)
            orbits = orbits_in(view, along.name, values)
            others = [axis for axis in view.axes if axis != along.name and axis not in INITIAL]
            cells = {n: abs(view[n] - values.get(n, view[n][0])).argmin() for n in others}
            near = {n: float(view[n][i]) for n, i in cells.items()}
        else:
            raise RequestError(f"it holds a {view.content}, not a scan or branches")
    changes["along"] = along.entry()
    if "system" not in changes and source is None:
        changes["system"] = system
        changes["set"] = {**near, **changes.get("set", {})}
    inside = [orbit for orbit in orbits if along.low <= orbit.value <= along.high]
    if not inside:
        raise RequestError(f"--from {path}: no periodic orbit of it lies within the interval")
    if label is not None:
        labels = dict.fromkeys(orbits[orbit] for orbit in inside)
        with at(f"--from {path}"):
            choice("--orbit", label, labels)
        inside = [orbit for orbit in inside if orbits[orbit] == label]
    changes["start"] = {"policy": "orbits", **_columns(inside), **changes.get("start", {})}
    return load_continuation(source, changes, changes_from)


def _values(option: str, text: str) -> float | list[float]:
    """Return the number, or the numbers between commas, of a text."""
    values = numbers(option, text)
    return values[0] if len(values) == 1 else values


def _interval(option: str, text: str) -> dict[str, float]:
    return ends(option, text, "start", "stop")


_INTERVAL = "NAME=START:STOP"
main = commands.of_task(
    _NAME,
    _load,
    Job,
    ("CONTINUATION.toml", "by default SSul Set 6"),
    (
        Option("--show", "WHAT", "panels: x1, E1max, multipliers, largest_force ..."),
        Option("--over", "SCAN.h5", "a scan: draw them over it, explain its borders"),
        SYSTEM,
        SET,
        named("--along", _INTERVAL, "the free parameter [omega=5:9]", "along", _interval, False),
        named(
            "--plane",
            _INTERVAL,
            "a second one: curves of special points",
            "plane",
            _interval,
            False,
        ),
        named(
            "--monitor",
            "NAME=VALUE",
            "where a quantity has a value: largest_force=1e4, E1max=50,100",
            "monitors",
            _values,
        ),
        Option(
            "--from",
            "WHAT",
            "rest, random, a label, or a scan or branches FILE.h5[@NAME=VALUE,...] [rest]",
            _begin,
        ),
        Option(
            "--orbit",
            "LABEL",
            "of an archive's orbits, those of this regime alone",
            lambda text: {"orbit": text},
        ),
        Option(
            "--all", "", "all orbits of random starts", lambda _: {"start": {"policy": "random"}}
        ),
    ),
    (Begin, Continuation),
    description="Follow periodic orbits, stable or not, and their bifurcations along a parameter.",
    examples=_EXAMPLES,
    common="--output --plot --system --set --along --from --over --doublings",
).main
