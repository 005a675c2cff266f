"""The command `nlds-vines tuning`, also `python -m nlds_vines.tuning`, and `nlds_vines.tune`."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from nlds_vines.cli import command as commands
from nlds_vines.cli.options import (
    SET,
    SYSTEM,
    Option,
    assignments,
    comma_separated,
    ends,
    named,
    numbers,
    spaced,
)
from nlds_vines.cli.running import optional_path
from nlds_vines.cli.terminal import complain
from nlds_vines.errors import at, from_text
from nlds_vines.loads.command import LOAD
from nlds_vines.loads.request import HistoryRequest, load_table
from nlds_vines.model.catalog import any_system
from nlds_vines.model.loads.loading import Loading
from nlds_vines.model.system import System
from nlds_vines.plotting.bands import refuse_undrawable
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.tuning.request import Search, Surface, Tuning, check_installed, load_tuning

if TYPE_CHECKING:
    from nlds_vines.tuning.result import Tuned

_NAME = "tuning"
_EXAMPLES = """\
examples:
  nlds-vines tuning
      k2, c2 and C of an SSul NES, for the least E1max at 6.28 rad/s
  nlds-vines tuning --system tmd --band 5:8:61 --seeds 5 -o tmd.h5 --plot tmd.png
      a tuned mass damper for the least peak over a band, with five seeds; its surface over k2, c2
  nlds-vines tuning --free k2=100:1000 --over P=600,800,1000 --surface k2,C -o robust.h5
      the worst of three forces, k2 within narrower bounds
  nlds-vines tuning --objective a1_rms --set base_acceleration=1.0 -o shaken.h5
      the least acceleration of a structure on a moving base
  nlds-vines tuning --impulse 1000 --duration 20 --free k2=100:1500 -o struck.h5
      the least time until E1 stays below 1 % after a blow; --objective names another number
  nlds-vines tuning --system tmd --band 5:8:61 --uncertain k1=5% --quantile 0.9 -o firm.h5
      a peak that 90 % of structures with a stiffness uncertain by 5 % do not exceed
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
    """Search for the parameters of a damper that minimize an objective, by default E1max.

    Parameters
    ----------
    source : str, path-like, mapping, System or Tuning, optional
        A catalog name, the path of a tuning file, the document in one, a system or a request; by
        default SSul Set 6.
    to : path-like, optional
        The archive (`.h5`) of all evaluations.  By default it is temporary.
    plot : path-like, optional
        A picture of the surface (`.png`, `.pdf` or `.svg`).
    threads : int, optional
        Number of threads; by default that of the processors.
    resume, overwrite : bool, optional
        Continue or replace an existing archive; not both.
    quiet : bool, optional
        Whether to show no progress.
    **tables
        Tables of a tuning file merged over the source, such as
        `free={"k2": {"low": 100.0, "high": 3000.0}}`, `over={"P": {"values": [600.0, 800.0]}}`,
        `search={"seed": 1}`, `load={"impulse": 1000.0}` or the path of a record, and
        `uncertain={"k1": "5%"}`.

    Returns
    -------
    Tuned
        The optima, their robustness, and the archive.

    Raises
    ------
    RequestError
        If the request is wrong; nothing has been computed then.

    See Also
    --------
    load_tuning, response_curves

    Notes
    -----
    Differential evolution or CMA-ES searches the unit cube of the bounds, and the Nelder-Mead
    method polishes its best designs.  The objective of a design is the largest of all cases; with
    uncertain parameters, its mean or a quantile over draws.  The same request gives the same bits.

    References
    ----------
    R. Storn and K. Price, Differential evolution, J. Global Optim. 11 (1997); J. A. Nelder and R.
    Mead, A simplex method for function minimization, Computer J. 7 (1965) 308-313.

    Examples
    --------
    A tuned mass damper of 60 kg at 6.28 rad/s, with bounds near the design of the paper:

    >>> import nlds_vines as nv
    >>> small = {"population": 8, "generations": 3, "polish": 10, "optima": 1}
    >>> near = {"k2": {"low": 1000.0, "high": 3000.0}, "c2": {}}
    >>> tuned = nv.tune("tmd", free=near, search=small, quiet=True)
    >>> sorted(tuned.parameters), tuned.objective < 10.0
    (['c2', 'k2'], True)
    """
    if tables.get("load") is not None:
        tables["load"] = load_table(tables["load"])
    how = RunOptions(threads, resume, overwrite, quiet=quiet)
    request = load_tuning(source, tables, "tune")
    result: Tuned = Job.compute(request, source, to, how, plot=optional_path(plot, "plot"))
    return result


class Job(commands.Job):
    default: ClassVar[str] = f"{_NAME}.h5"

    request: Tuning

    def __post_init__(self) -> None:
        check_installed(self.request.search.method)
        names = [item.name for item in self.request.free if not item.inert]
        is_cheap = self.request.history is None and not self.request.draws
        wants_surface = self.plot is not None and self.request.surface is None
        if wants_surface and is_cheap and len(names) > 1:
            surface = Surface((names[0], names[1]))
            object.__setattr__(self, "request", replace(self.request, surface=surface))
        super().__post_init__()

    def results(self) -> Any:
        """Compute the tuning; under a load its price is told before."""
        if self.request.history is not None and not self.how.quiet:
            complain(_NAME, price_in_words(self.request))
        return super().results()

    def compute_archive(self) -> Any:
        from nlds_vines.tuning.run import run

        return run(self.request, self.archive, self.how)

    @classmethod
    def read(cls, path: Path) -> Any:
        from nlds_vines.tuning.result import tuned

        return tuned(path)

    @classmethod
    def picture(cls) -> Any:
        from nlds_vines.tuning.picture import PICTURE

        return PICTURE

    def check_picture(self) -> None:
        surface = self.request.surface
        for item in self.request.free:
            if surface is not None and item.name in surface.parameters:
                refuse_undrawable(item.name, np.array([item.low, item.high]))

    def draw(self, plot: Path, results: Tuned) -> None:
        if results.optima:
            super().draw(plot, results)

    def failure(self, results: Tuned) -> str:
        if results.optima:
            return ""
        why = f"no design was admissible: `status` of {self.archive} says why"
        history, level = self.request.history, self.request.search.objective.removeprefix("last_")
        if history is None or not level.isdecimal():
            return why
        duration = f"{history.duration:g} s"
        return f"{why}; if it is ok, E1 exceeds {level} % of its largest after {duration}"

    def plan(self) -> list[str]:
        tuning = self.request
        search, each, history = tuning.search, tuning.transient + tuning.periods, tuning.history
        cases = [f"{axis.values.size} values of {axis.as_stated.name}" for axis in tuning.over]
        if history is not None and history.load.suite:
            cases.append(f"{tuning.record_count} records")
        cases_in_words = " x ".join(cases) or "one orbit"
        from_rest = "" if history is not None and history.state else ", from rest"
        orbits = tuning.case_count * (tuning.draws + 1)
        records = [] if history is None else history.load.records_in_words(history.duration)
        inert = " (does not enter the dynamics: shifts pictures only)"
        bounds = [
            f"free:     {item.heading()}{', logarithmic' * item.logarithmic}{inert * item.inert}"
            for item in tuning.free
        ]
        return [
            tuning.title,
            *bounds,
            *([] if history is None else [f"load:     {history.load.words() or 'none'}"]),
            *(f"          {line}" for line in records),
            *(f"draws:    {one.words()}" for one in tuning.uncertain),
            f"objective: {tuning.objective_in_words}",
            *(f"places:   {words}" for words in tuning.layouts_in_words if words),
            f"judged:   by the {tuning.judged}: {cases_in_words}{from_rest}",
            *(f"axis:     {axis.heading()}" for axis in tuning.over),
            f"search:   {search.method}, {search.population} first designs and as many in each of "
            f"at most {search.generations} generations, "
            f"seeds {search.seed} to {search.all_seeds[-1]}",
            f"designs:  at most {tuning.most_evaluations}, {orbits} orbits each",
            *([f"fresh:    {tuning.fresh_draws} draws of each optimum"] if tuning.draws else []),
            f"periods:  {tuning.transient} + {tuning.periods} each, "
            f"at most {tuning.most_lanes * each} in all"
            if history is None
            else f"followed: {history.duration:g} s each, at most {tuning.most_lanes} histories",
            f"archive:  {self.archive}",
        ]


def price_in_words(tuning: Tuning) -> str:
    """Return the most histories that a tuning computes, and their time by one design in the middle.

    That design is computed twice, of which the second time counts: the first one compiles, and
    says so.
    """
    from nlds_vines.engine.compilation import notice
    from nlds_vines.tuning.run import Objective, at_rest

    assert tuning.history is not None
    middle = [float(one.value(np.asarray(0.5))) for one in tuning.free]
    trial = at_rest(np.array([middle]))
    objective = Objective(tuning, notice())
    objective.results(trial)
    began = time.process_time()
    objective.results(trial)
    orbits = tuning.case_count * (tuning.draws + 1)
    seconds = (time.process_time() - began) / orbits
    total = seconds * tuning.most_lanes
    return (
        f"at most {tuning.most_lanes} histories of {tuning.history.duration:g} s, "
        f"{1e3 * seconds:.2g} ms each: up to {total:.2g} s of the processor"
    )


def _system(text: str) -> dict[str, Any]:
    with at("--system"):  # `load_tuning` refuses a system without a force unless there is a load
        return {"system": any_system(text, needs_force=False)}


def _spread(option: str, text: str) -> dict[str, Any]:
    size, _, law = text.partition(":")
    spread = size if size.endswith("%") else from_text(float, option, size)
    return {"spread": spread, "law": law} if law else {"spread": spread}


def _free(texts: list[str]) -> dict[str, Any]:
    complete = [text if "=" in text else f"{text}=:" for text in texts]
    pairs = assignments("--free", complete, "NAME or NAME=LOW:HIGH").items()
    bounds = {k: {} if v == ":" else ends(f"--free {k}", v, "low", "high") for k, v in pairs}
    return {"free": bounds}


def _band(text: str) -> dict[str, Any]:
    name, _, band = text.rpartition("=")
    return {"over": {name or "omega": spaced("--band", band, "LOW:HIGH:NUM")}}


def _over(option: str, text: str) -> dict[str, Any]:
    return spaced(option, text) if ":" in text else {"values": numbers(option, text)}


OPTIONS = (
    replace(SYSTEM, read=_system),
    SET,
    Option("--free", "NAME[=LOW:HIGH]", "tune this too, or within these bounds", _free, True),
    Option(
        "--band", "[f=]LOW:HIGH:NUM",
        "minimize the peak over these omega [rad/s], or f [Hz]; under a load, of its tone", _band,
    ),
    named(
        "--over", "NAME=A,B,...",
        "minimize the worst over these values, or START:STOP:NUM; several combine", "over", _over,
    ),
    named(
        "--places", "DAMPER=DOF,DOF", "of a host: try these places, by a search each", "places",
        lambda option, text: comma_separated(text),
    ),
    named(
        "--uncertain", "NAME=SPREAD[:LAW]",
        "an uncertain parameter, as k1=5%%; SPREAD is the standard deviation if LAW is `normal`, "
        "half the width if it is `uniform`; several combine", "uncertain", _spread,
    ),
    LOAD,
)  # fmt: skip


main = commands.of_task(
    _NAME,
    load_tuning,
    Job,
    ("TUNING.toml", "by default SSul"),
    OPTIONS,
    (Tuning, Loading, HistoryRequest, Search, Surface),
    description="Tune all parameters of a damper at once for the least E1max, or --objective.",
    examples=_EXAMPLES,
    common="--output --plot --system --set --free --band --objective --seed",
).main
