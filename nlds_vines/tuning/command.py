"""Tune all parameters of a damper at once: every evaluation in an archive, the optima in words.

As a command: `python -m nlds_vines.tuning`, or `nlds-vines tuning`.
In Python: `nlds_vines.tune(system)`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.archive_path import ArchivePath
from nlds_vines.cli import job as jobs
from nlds_vines.cli.command_main import Command
from nlds_vines.cli.option_values import (
    add_system_options,
    assignments,
    interval,
    spaced,
    system_changes,
)
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import (
    optional_path,
    request_path,
)
from nlds_vines.cli.run_options import RunOptions, add_local_options
from nlds_vines.cli.setting_options import add_settings, changed
from nlds_vines.errors import RequestError, from_text
from nlds_vines.loads.load_options import add_load_options, load_changes
from nlds_vines.model.system import System
from nlds_vines.plotting.bands import refuse_undrawable
from nlds_vines.tuning.request import Search, Surface, Tuning, load_tuning
from nlds_vines.tuning.searches import check_installed

if TYPE_CHECKING:
    from nlds_vines.tuning.result import Tuned

_NAME = "tuning"
_DEFAULT = "tuning.h5"
_EXAMPLES = """\
examples:
  nlds-vines tuning
      k2, c2 and C of an SSul NES, for the least E1max at 6.28 rad/s
  nlds-vines tuning --system tmd --band 5:8:61 --seeds 5 -o tmd.h5 --plot tmd.png
      a tuned mass damper for the least peak over a band, five times; its surface over k2 and c2
  nlds-vines tuning --free k2=100:1000 --over P=600,800,1000 --surface k2,C -o robust.h5
      the worst of three forces, k2 held in a narrower range
  nlds-vines tuning --objective a1_rms --set base_acceleration=1.0 -o shaken.h5
      the least acceleration of a structure that is shaken at its foot
  nlds-vines tuning --impulse 1000 --duration 20 --free k2=100:1500 -o struck.h5
      the least time until E1 stays below 1 % after a blow; --objective names another number
  nlds-vines tuning --system tmd --band 5:8:61 --uncertain k1=5% --quantile 0.9 -o firm.h5
      a peak that 90 % of structures do not exceed, whose stiffness is known to 5 %
V (SSul) does not enter the dynamics, only C does: V shifts pictures, and tuning it is pointless.
exit status: 0 done; 1 no design was admissible; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on
"""


def tune(
    source: str | os.PathLike[str] | Mapping[str, Any] | System | Tuning | None = None,
    to: str | os.PathLike[str] | None = None,
    *,
    plot: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = False,
    **tables: Any,
) -> Tuned:
    """Tune a damper and return what was found.

    Arguments:
        source: a name of the catalog, a `System`, a `Tuning`, the path of a tuning file, the
            document in one, or None for SSul.
        to: the archive (.h5) of all evaluations; None for one that is gone with what is returned.
        plot: a picture of the surface to draw as well (.png, .pdf or .svg).
        threads: how many; by default as many as the machine has processors.
        resume, overwrite: continue or replace an archive that exists; not both.
        quiet: whether to show no progress.
        tables: tables of a tuning file laid over the source, as `free={"k2": {"low": 100.0,
            "high": 3000.0}}`, `over={"P": {"values": [600.0, 800.0]}}`, `search={"seed": 1}`,
            `load={"impulse": 1000.0}`, `uncertain={"k1": "5%"}`; `load` may be a record's path.

    Raises `RequestError` where anything asked for is wrong, before anything is computed.
    """
    if isinstance(tables.get("load"), str | os.PathLike):
        tables["load"] = {"record": os.fspath(tables["load"])}
    job = Job(
        request=_drawable(load_tuning(source, tables, "tune"), plot),
        source=request_path(source),
        archive=ArchivePath.for_result(to, _NAME, resume, overwrite),
        plot=optional_path(plot),
        how=RunOptions(threads, resume, overwrite, quiet=quiet),
    )
    return job.run()


class Job(jobs.Job):
    """A tuning and where it goes."""

    request: Tuning

    def __post_init__(self) -> None:
        """Check everything."""
        check_installed(self.request.search.method)
        super().__post_init__()

    def check_picture(self) -> None:
        """Raise `RequestError` for bounds of the surface that cannot be drawn."""
        surface = self.request.surface
        for item in self.request.free:
            if surface is not None and item.name in surface.parameters:
                refuse_undrawable(item.name, np.array([item.low, item.high]))

    def draw(self, plot: Path, found: Tuned) -> None:
        """Draw the surface, if there is an optimum to draw it through."""
        if found.optima:
            super().draw(plot, found)

    def failure(self, found: Tuned) -> str:
        """Return where it is said why there is no design."""
        if found.optima:
            return ""
        return f"no design was admissible: `status` of {self.archive} says why"

    def inside(self) -> list[str]:
        """Return a line if the state from which designs start is inside a wall of the system."""
        history = self.request.history
        return [] if history is None else history.starts_inside()

    def plan(self) -> list[str]:
        """Return what a tuning would do, one fact a line."""
        tuning = self.request
        search, each, history = tuning.search, tuning.transient + tuning.periods, tuning.history
        cases = [f"{axis.values.size} values of {axis.name}" for axis in tuning.over]
        cases_in_words = " x ".join(cases) or "one orbit"
        from_rest = "" if history is not None and history.state else ", from rest"
        lanes = tuning.case_count * (tuning.draws + 1)
        records = [] if history is None else history.load.records_in_words(history.duration)
        bounds = [
            f"free:     {item.name} from {item.low:g} to {item.high:g}"
            f"{', logarithmic' if item.logarithmic else ''}"
            f"{' (does not enter the dynamics: shifts pictures only)' if item.inert else ''}"
            for item in tuning.free
        ]
        return [
            tuning.title,
            *bounds,
            *([] if history is None else [f"load:     {history.load.words() or 'none'}"]),
            *(f"          {line}" for line in records),
            *(f"draws:    {one.words()}" for one in tuning.uncertain),
            f"objective: {tuning.objective_in_words}",
            f"judged:   by the {tuning.judged}: {cases_in_words}{from_rest}",
            f"search:   {search.method}, {search.population} designs in each of at most "
            f"{search.generations + 1} generations, seeds {search.seed} to {search.all_seeds[-1]}",
            f"designs:  at most {tuning.most_evaluations}, {lanes} orbits each",
            f"periods:  {tuning.transient} + {tuning.periods} each, "
            f"at most {tuning.most_lanes * each} in all"
            if history is None
            else f"followed: {history.duration:g} s each",
            f"archive:  {self.archive}",
        ]


def _job(options: argparse.Namespace) -> Job:
    """Return the job that the command line means."""
    tuning = load_tuning(options.source, _changes(options), "command line")
    return Job(_drawable(tuning, options.plot), **jobs.files_of(options, _DEFAULT))


def _drawable(tuning: Tuning, plot: object) -> Tuning:
    """Return the tuning with a surface if there is to be a picture: of the first two parameters.

    A tuning of a single parameter needs none: its designs are drawn along that.
    """
    names = [item.name for item in tuning.free if not item.inert]
    if plot is None or tuning.surface is not None or len(names) == 1:
        return tuning
    return load_tuning(tuning, {"surface": {"parameters": names[:2]}})


def _add_tuning_options(parser: Parser) -> None:
    """Declare the options on a command's parser."""
    group = parser.add_argument_group("what to tune")
    add_system_options(group, settings="SI units; what is set is not tuned")
    _repeated(group, "--free", "NAME[=LOW:HIGH]", "tune this too, or within other bounds")
    group.add_argument("--band", metavar="LOW:HIGH:NUM", help="the peak over these omega [rad/s]")
    _repeated(group, "--over", "NAME=A,B,...", "the worst over these values; several combine")
    _repeated(
        group, "--uncertain", "NAME=SPREAD[:LAW]",
        "known to so much, as k1=5%%; `normal`, the spread its standard deviation, or `uniform`, "
        "half its width; several combine",
    )  # fmt: skip
    add_settings(group, Tuning)
    add_load_options(parser.add_argument_group("what acts, and how long"), but=("tolerance",))
    add_settings(parser.add_argument_group("how to search"), Search)
    add_settings(parser.add_argument_group("the objective over two free parameters"), Surface)


def _changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the options change in a tuning file, as a document of the same form.

    Raises `RequestError` for an option that cannot be read as its form demands.
    """
    found: dict[str, Any] = {
        **system_changes(options),
        "free": _free(options.free),
        "over": _over(options.over, options.band),
        "uncertain": _uncertain(options.uncertain),
        **changed(options, Tuning, Search, Surface),
    }
    for key, entries in load_changes(options).items():
        found[key] = {**found.get(key, {}), **entries}
    return {key: value for key, value in found.items() if value}


def _repeated(group: Any, option: str, form: str, text: str) -> None:
    group.add_argument(option, action="append", default=[], metavar=form, help=text)


def _free(texts: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the entries of `[free]` in a list of NAME or NAME=LOW:HIGH."""
    complete = [text if "=" in text else f"{text}=:" for text in texts]
    pairs = assignments("--free", complete, "NAME or NAME=LOW:HIGH")
    return {
        name: {} if text == ":" else interval(f"--free {name}", text)
        for name, text in pairs.items()
    }


def _uncertain(texts: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return the entries of `[uncertain]` in a list of NAME=SPREAD or NAME=SPREAD:LAW."""
    found = {}
    for name, text in assignments("--uncertain", texts, "NAME=SPREAD[:LAW]").items():
        spread, _, law = text.partition(":")
        number = partial(from_text, float, f"--uncertain {name}")
        size = spread if spread.endswith("%") else number(spread)
        found[name] = {"spread": size, **({"law": law} if law else {})}
    return found


def _over(texts: Sequence[str], band: str | None) -> dict[str, dict[str, Any]]:
    """Return the entries of `[over]` in a list of NAME=A,B,... and a band LOW:HIGH:NUM of omega."""
    found: dict[str, dict[str, Any]] = {
        name: {"values": [from_text(float, f"--over {name}", item) for item in text.split(",")]}
        for name, text in assignments("--over", texts, "NAME=A,B,...").items()
    }
    if band is None:
        return found
    if "omega" in found:
        raise RequestError("--band and --over omega exclude each other: give one of them")
    return found | {"omega": spaced("--band", band, "LOW:HIGH:NUM")}


def _declare(parser: Parser) -> None:
    jobs.add_files(parser, "TUNING.toml", "by default SSul", _DEFAULT)
    _add_tuning_options(parser)
    add_local_options(parser)


COMMAND = Command(
    name=_NAME,
    description="Tune all parameters of a damper at once for the least E1max, or --objective.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=lambda options: _job(options).carry_out(_NAME, options.dry_run),
)
main = COMMAND.main
