"""Follow periodic orbits, stable or not, along a parameter: where and why regimes change.

As a command: `python -m nlds_vines.continuation`, or `nlds-vines continuation`.
In Python: `nlds_vines.continue_branch(system, parameter="omega", bounds=(5.0, 9.0))`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.archive import ArchivePath
from nlds_vines.cli import job as jobs
from nlds_vines.cli.command_main import Command
from nlds_vines.cli.option_values import (
    add_system_options,
    assignments,
    system_changes,
)
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import (
    existing,
    optional_path,
    request_path,
)
from nlds_vines.cli.run_options import RunOptions, add_local_options
from nlds_vines.cli.setting_options import add_settings, changed
from nlds_vines.continuation.request import (
    STARTS,
    Begin,
    Continuation,
    in_parameters,
    load_continuation,
)
from nlds_vines.errors import RequestError, at, from_text, number, shown
from nlds_vines.model.catalog import as_system
from nlds_vines.model.parameters import INITIAL
from nlds_vines.model.system import System

if TYPE_CHECKING:
    from nlds_vines.continuation.result import Continued
    from nlds_vines.orbits.classification import Regime

_NAME = "continuation"
_DEFAULT = "branches.h5"
_EXAMPLES = """\
examples:
  nlds-vines continuation
      the T,1 orbit of SSul NES Set 6 from 5 to 9 rad/s: folds, doublings, grazing
  nlds-vines continuation --doublings 3 --plot branches.png
      with the branches of twice, four and eight times the period
  nlds-vines continuation --system impact-oscillator --set omega=1.5 --along P=0.1:2
  nlds-vines continuation --from figure8.h5 --along omega=5:8 --over figure8.h5 --plot all.png
      every periodic orbit that a scan has found, and their branches laid over its diagram
  nlds-vines continuation --plane P=400:1200 -o plane.h5 --plot plane.png
      where doublings and grazing lie in the plane of frequency and force
  nlds-vines continuation --from figure8.h5@omega=6.28 --along omega=5:8
exit status: 0 done; 1 a branch is not complete; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on
"""


# public: its keywords are those of the command, more than eight
def continue_branch(
    system: System | str | os.PathLike[str],
    parameter: str,
    bounds: tuple[float, float],
    start: Regime | Sequence[float] | np.ndarray | str | None = None,
    *,
    to: str | os.PathLike[str] | None = None,
    period: int | None = None,
    plane: tuple[str, float, float] | None = None,
    doublings: int = 0,
    starts: int = STARTS,
    seed: int = 0,
    step: float = 0.02,
    unstable: int = 3000,
    tolerance: float | str = "fine",
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = False,
) -> Continued:
    """Follow the branches of periodic orbits along a parameter and return them.

    Arguments:
        system: a `System`, the name of one, or the path of a TOML file; where its own value of the
            parameter lies outside the interval, the start is looked for at the nearest end.
        parameter: the free one, any one that is allowed for the system.
        bounds: its smallest and largest value [SI].
        start: None for the orbit from rest; a `Regime` that is periodic, at its own value of the
            parameter; a state (x1, v1, x2, v2) or (x, v) [m, m/s], whose orbit is judged; a label
            such as "3T,3", looked for among random starts; "random" for all their orbits.
        to: the archive (.h5); None for one that is gone with what is returned.
        period: n, with a state: the nT orbit nearest to it, stable or not, in place of the orbit
            that it ends in.
        plane: a second parameter, its smallest and its largest value, around the system's own: then
            curves of special points in the plane of both are followed, too.
        doublings: how many period doublings, one after another, are followed to their branches.
        starts, seed: how many random starts, drawn by which seed.
        step: the longest step, relative to the orbit and the interval together.
        unstable: the most points, one after another, that are followed where orbits are unstable.
        tolerance: of the contacts: a number, draft, standard or fine.
        resume, overwrite: continue or replace an archive that exists; not both.
        quiet: whether to show no progress.

    Raises `RequestError` for anything else, and where the start is no periodic orbit.

    The orbits are fixed points of the n-fold section map, by Newton's method along the branch
    (pseudo-arclength; Allgower and Georg, Introduction to Numerical Continuation Methods).  An
    impact may appear or vanish along a branch: with Hertz contacts the map stays continuously
    differentiable there.  Cost: some 0.4 ms for each point of T,1, once compiled.
    """
    how = RunOptions(None, resume, overwrite, quiet=quiet)
    request = _request_of(
        system, parameter, bounds, start, period,
        {"doublings": doublings, "step": step, "unstable": unstable, "tolerance": tolerance},
        {"count": starts, "seed": seed}, plane,
    )  # fmt: skip
    archive = ArchivePath.for_result(to, "branches", resume, overwrite)
    return Job(request, request_path(system), archive, None, how).run()


def _request_of(
    system: System | str | os.PathLike[str],
    parameter: str,
    bounds: tuple[float, float],
    start: Regime | Sequence[float] | np.ndarray | str | None,
    period: int | None,
    search: Mapping[str, Any],
    draws: dict[str, int],
    plane: tuple[str, float, float] | None,
) -> Continuation:
    """Return the request that the arguments of `continue_branch` mean."""
    known = as_system(system)
    first, last = _pair(bounds)
    free = () if plane is None else (_triple(plane)[0],)
    meant = in_parameters({parameter: {"start": first, "stop": last}}, known, free)
    ((parameter, ends),) = meant.items()
    first, last = ends["start"], ends["stop"]
    changes: dict[str, Any] = {
        "along": {parameter: {"start": first, "stop": last}},
        "start": _near(known, parameter, start, (first, last), period)
        if period is not None
        else _start_table(known, parameter, start, (first, last), draws),
        "search": search,
    }
    if plane is not None:
        name, low, high = _triple(plane)
        changes["plane"] = {name: {"start": low, "stop": high}}
    return load_continuation(known, changes, "continue_branch")


def _pair(bounds: Sequence[float]) -> tuple[float, float]:
    if not isinstance(bounds, Sequence) or isinstance(bounds, str) or len(bounds) != 2:
        raise RequestError(f"bounds = {shown(bounds)}; allowed: two numbers")
    return bounds[0], bounds[1]


def _triple(plane: Sequence[Any]) -> Sequence[Any]:
    if isinstance(plane, str) or len(plane) != 3 or not isinstance(plane[0], str):
        raise RequestError(f"plane = {shown(plane)}; allowed: a name and two numbers")
    return plane


def _near(
    system: System, parameter: str, start: object, bounds: tuple[float, float], period: int
) -> dict[str, Any]:
    """Return the table [start] of the orbit of n periods near a state."""
    if not isinstance(start, Sequence | np.ndarray) or isinstance(start, str):
        raise RequestError(f"period = {shown(period)} belongs to a start that is a state")
    low, high = bounds
    value = min(max(system.parameters.get(parameter, low), low), high)
    state = [number("start", component) for component in start]
    return {"states": [state], "values": [value], "periods": [period]}


def _start_table(
    system: System,
    parameter: str,
    start: Regime | Sequence[float] | np.ndarray | str | None,
    bounds: tuple[float, float],
    draws: dict[str, int],
) -> dict[str, Any]:
    """Return the table [start] that the start of `continue_branch` means."""
    if start is None or (isinstance(start, str) and start == "rest"):
        return {"policy": "rest"}
    if isinstance(start, str):
        return {"policy": "random", **draws} if start == "random" else {"label": start, **draws}
    from nlds_vines.orbits.classification import Regime, classify

    if isinstance(start, Regime):
        found = start
    else:
        low, high = bounds
        nearest = min(max(system.parameters.get(parameter, low), low), high)
        found = classify(system.with_(**{parameter: nearest}), start=start)
    if found.point is None:
        raise RequestError(f"the start is {found.label}: only a periodic orbit can be followed")
    if parameter not in found.system.parameters:
        raise RequestError(f"the start's system has no {parameter}")
    return {
        "states": [found.point.tolist()],
        "values": [found.system.parameters[parameter]],
        "periods": [found.period],
    }


@dataclass(frozen=True)
class Job(jobs.Job):
    """A continuation and where it goes; `over`, a scan that its branches are drawn over."""

    request: Continuation
    over: Path | None = None

    def others(self) -> Sequence[Path | None]:
        """Return the scan."""
        return (self.over,)

    def __post_init__(self) -> None:
        """Check the paths."""
        super().__post_init__()
        if self.over is not None:
            existing(self.over, "--over")

    def draw(self, plot: Path, found: Continued) -> None:
        """Draw the branches."""
        from nlds_vines.continuation.picture import picture

        picture(self.over).save(self.archive, plot)

    def lines(self, found: Continued) -> list[str]:
        """Return what was found, and what makes the borders of the scan."""
        return [*found.lines(), *self.border_lines(found)]

    def failure(self, found: Continued) -> str:
        """Return how many branches are not complete."""
        incomplete = int(found.tables["status"].sum())
        words = "1 branch is" if incomplete == 1 else f"{incomplete} branches are"
        return f"{words} not complete: the ends say why" if incomplete else ""

    def plan(self) -> list[str]:
        """Return what a continuation would do, one fact a line."""
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
            f"along:    {along.name} from {along.low:g} to {along.high:g}",
            f"start:    {starts[begin.policy]}"
            + ("" if begin.policy == "orbits" else f", at {along.name} = {request.value:g}"),
            f"branches: and those of {request.doublings} period doublings one after another",
            f"archive:  {self.archive}",
        ]

    def border_lines(self, found: Continued) -> list[str]:
        """Return what makes the borders of the scan that the branches lie over, a line each."""
        if self.over is None or self.request.plane is not None:
            return []
        from nlds_vines.archives.archive import read
        from nlds_vines.continuation.regime_borders import borders_of, report

        with read(self.over) as scan:
            return list(report(found, scan, borders_of(found, scan)))


def _job(options: argparse.Namespace) -> Job:
    """Return the job that the command line means."""
    request = load_continuation(options.source, _changes(options), "command line")
    files = jobs.files_of(options, _DEFAULT)
    return Job(request, **files, over=optional_path(options.over))


def _changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the options change in a continuation file, as a document of the same form."""
    found = system_changes(options)
    for key in ("along", "plane"):
        text = getattr(options, key)
        if text is not None:
            found[key] = _interval(f"--{key}", text)
    found |= changed(options, Begin, Continuation)
    found["start"] = _from(options, found) | found.get("start", {})
    return {key: value for key, value in found.items() if value}


def _interval(option: str, text: str) -> dict[str, dict[str, float]]:
    """Return the table of an interval that a text NAME=START:STOP means."""
    form = "NAME=START:STOP"
    ((name, ends),) = assignments(option, [text], form).items()
    first, colon, last = ends.partition(":")
    if not colon or ":" in last:
        raise RequestError(f"{option} {shown(text)} must be {form}")
    where = f"{option} {name}"
    return {name: {"start": from_text(float, where, first), "stop": from_text(float, where, last)}}


def _from(options: argparse.Namespace, found: dict[str, Any]) -> dict[str, Any]:
    """Return the table [start] that --from means; an archive brings its system with it."""
    text = options.begin
    if text is None:
        return {"policy": "random"} if options.everything else {}
    file, _, cell = text.partition("@")
    if file.endswith(".h5"):
        return _from_archive(Path(file), cell, options, found)
    if text in ("rest", "random"):
        return {"policy": text}
    return {"policy": "label", "label": text}


def _from_archive(
    path: Path, cell: str, options: argparse.Namespace, found: dict[str, Any]
) -> dict[str, Any]:
    """Return the table [start] of the orbits in an archive; put its system into the request."""
    from nlds_vines.archives.archive import read
    from nlds_vines.continuation.start_orbits import orbits_in, system_in

    pairs = assignments("--from", [item for item in cell.split(",") if item], "FILE.h5@NAME=VALUE")
    values = {name: from_text(float, f"--from {name}", text) for name, text in pairs.items()}
    with at(f"--from {path}"), read(path) as view:
        if view.content != "scan":
            raise RequestError(f"it holds a {view.content}, not a scan")
        along = found.get("along") or load_continuation(options.source).document()["along"]
        found["along"] = along = in_parameters(along, system_in(path, view.text("scan")))
        (name,) = along
        orbits = orbits_in(view, name, values)
        if "system" not in found and options.source is None:
            others = {
                axis: values.get(axis, view[axis][0])
                for axis in view.axes
                if axis != name and axis not in INITIAL
            }
            others = {
                axis: float(view[axis][abs(view[axis] - v).argmin()]) for axis, v in others.items()
            }
            found["system"] = system_in(path, view.text("scan")).with_(**others)
        low, high = (float(along[name][end]) for end in ("start", "stop"))
    inside = [orbit for orbit in orbits if low <= orbit.value <= high]
    if not inside:
        raise RequestError(f"--from {path}: no periodic orbit of it lies within the interval")
    return {
        "policy": "orbits",
        "states": [list(orbit.state) for orbit in inside],
        "values": [orbit.value for orbit in inside],
        "periods": [orbit.period for orbit in inside],
    }


def _declare(parser: Parser) -> None:
    add = parser.add_argument
    jobs.add_files(parser, "CONTINUATION.toml", "by default SSul Set 6", _DEFAULT)
    add("--over", metavar="SCAN.h5", help="a scan: draw them over it, explain its borders")
    group = parser.add_argument_group("what to follow")
    add_system_options(group)
    add = group.add_argument
    add("--along", metavar="NAME=START:STOP", help="the free parameter [omega=5:9]")
    add("--plane", metavar="NAME=START:STOP", help="a second one: curves of special points")
    add(
        "--from", dest="begin", metavar="WHAT",
        help="rest, random, a label, or a scan's archive FILE.h5[@NAME=VALUE,...] [rest]",
    )  # fmt: skip
    add("--all", dest="everything", action="store_true", help="all orbits of random starts")
    add_settings(group, Begin, Continuation)
    add_local_options(parser)


COMMAND = Command(
    name=_NAME,
    description="Follow periodic orbits, stable or not, along a parameter, with what changes them.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=lambda options: _job(options).carry_out(_NAME, options.dry_run),
)
main = COMMAND.main
