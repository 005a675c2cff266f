"""How long chaos lasts before it ends, over an ensemble of starts, and where the starts end.

As a command: `python -m nlds_vines.transients`, or `nlds-vines transients`.
In Python: `nlds_vines.transients(system)`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.bifurcation.command import Job, bifurcation, carry_out
from nlds_vines.bifurcation.request import Scan, Start
from nlds_vines.cli.parser import Parser, assignments, parsed
from nlds_vines.cli.paths import check_plot
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.cli.running import DONE, LANES_FAILED, complain, run_command
from nlds_vines.errors import RequestError, at, number
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalogue import load_system
from nlds_vines.model.system import System
from nlds_vines.orbits.settings import EFFORTS, METHODS
from nlds_vines.runs.interrupts import Interrupted

if TYPE_CHECKING:
    from nlds_vines.transients.ensemble import Ensemble

_NAME = "transients"
_SYSTEM = "ssul-set6"
STARTS, TRANSIENT, PERIODS = 1000, 4000, 120
DELAY = 50.0
"""Forcing periods that random starts are given to fall on to the chaotic set, or past it."""

_WANT = ("regime", "settling", "lyapunov", "evidence")
_EXAMPLES = f"""\
examples:
  nlds-vines transients --set omega=7.575 --set K=2.5e7
      SSul NES Set 6, {STARTS} random starts: transients.h5 and transients.png
  nlds-vines transients --set omega=7.575 --set K=2.5e7 --resume --delay 200 --plot late.pdf
      the same archive looked at again, the exponential law fitted beyond 200 periods
  nlds-vines transients --system ssbl --set omega=6.3 --starts 200 --seed 1 -o ssbl.h5
exit status: 0 done; 1 finished, but some orbits failed; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on
"""


def transients(
    system: System | str | os.PathLike[str] | None = None,
    output: str | os.PathLike[str] | None = None,
    *,
    starts: int = STARTS,
    seed: int = 0,
    transient: int = TRANSIENT,
    periods: int = PERIODS,
    method: str = "exact",
    effort: str = "standard",
    delay: float = DELAY,
    plot: str | os.PathLike[str] | None = None,
    **running: Any,
) -> Ensemble:
    """Follow an ensemble of starts and return what came of it.

    Arguments:
        system: a `System` or the name of one, by default SSul NES Set 6.
        output: the archive, by default transients.h5 in the current folder.
        starts, seed: how many random starts, drawn by which seed (`starts.random_states`).
        transient, periods: forcing periods of each, discarded and sampled; what has not settled
            then is watched for as many more as the `effort` of verdicts allows.
        method: of `scan.METHODS`.
        delay: forcing periods after which lifetimes count in the exponential law.
        plot: a picture to draw as well (.png, .pdf or .svg).
        running: `threads`, `resume`, `overwrite`, `quiet`, as `bifurcation` takes them.

    Raises `RequestError` where anything asked for is wrong, before anything is computed.
    """
    sampling = {"transient": transient, "periods": periods, "method": method, "effort": effort}
    scan = _scan(system, starts, seed, sampling)
    delay, path = _checked_delay(delay), None if plot is None else Path(plot)
    if path is not None:
        check_plot(path)
    archive = bifurcation(scan, f"{_NAME}.h5" if output is None else output, **running)
    return _looked_at(archive, delay, path)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with the arguments `argv` (the process's own if None).

    Returns the exit status: 0 done, 1 some orbits failed, 2 the request is wrong, 130 interrupted,
    143 terminated.
    """
    return run_command(_NAME, _command, argv)


def _command(argv: Sequence[str]) -> int:
    options = _parser().parse_args(argv)
    sampling = {name: getattr(options, name) for name in ("transient", "periods")}
    sampling |= {name: getattr(options, name) for name in ("method", "effort")}
    with at("command line"):
        scan = _scan(_system(options), options.starts, options.seed, sampling)
        delay = _checked_delay(options.delay)
    archive = Path(options.output)
    plot = archive.with_suffix(".png") if options.plot is None else Path(options.plot)
    check_plot(plot)
    how = RunOptions(options.threads, options.resume, options.overwrite, quiet=options.quiet)
    job = Job(scan, None, archive, None, how)
    if options.dry_run:
        return carry_out(_NAME, job, dry_run=True)
    job.refuse()
    return _run(job, plot, delay)


def _run(job: Job, plot: Path, delay: float) -> int:
    try:
        job.run()
    except Interrupted as stop:
        complain(_NAME, str(stop))
        return stop.status
    found = _looked_at(job.archive, delay, plot)
    if not job.how.quiet:
        print(job.scan.title, *found.lines(), job.archive, plot, sep="\n")
    failed = sum(entry.count for entry in found.shares if entry.label == "failed")
    if failed:
        where = f"the dataset `status` of {job.archive} says why"
        complain(_NAME, f"{failed} of {job.scan.starts} orbits failed: {where}")
    return LANES_FAILED if failed else DONE


def _looked_at(archive: Path, delay: float, plot: Path | None) -> Ensemble:
    """Return the ensemble in an archive; draw it where there is a path."""
    from nlds_vines.archives.archive import read
    from nlds_vines.transients.ensemble import ensemble_of

    with read(archive) as view:
        found = ensemble_of(view, delay=delay)
        title, scan_hash = str(view.attrs["title"]), str(view.attrs["scan_hash"])
    if plot is not None:
        from nlds_vines.plotting.save import save_figure
        from nlds_vines.transients.picture import draw_ensemble

        origin = ("scan_hash", scan_hash)
        save_figure(draw_ensemble(found, title), plot, title, origin)
    return found


def _scan(
    system: System | str | os.PathLike[str] | None,
    starts: int,
    seed: int,
    sampling: Mapping[str, Any],
) -> Scan:
    """Return the scan of one cell that computes an ensemble."""
    if not isinstance(system, System):
        system = load_system(_SYSTEM if system is None else system)
    axis = Axis("omega", np.array([system.parameters["omega"]]))
    title = f"{_title(system)}: {starts} starts"
    return Scan(title, system, (axis,), _WANT, Start("random", starts, seed), **sampling)


def _title(system: System) -> str:
    """Return the name of a system with what tells one ensemble from another."""
    told = {name: system.parameters.get(name) for name in ("omega", "P")}
    if system.scene.walls:
        told["K"] = system.K
    numbers = ", ".join(f"{name} = {value:.6g}" for name, value in told.items())
    return f"{system.title or system.name}, {numbers}"


def _system(options: argparse.Namespace) -> System:
    """Return the system that the options name, with what they set."""
    texts = assignments("--set", options.set, "NAME=VALUE")
    given = {name: parsed(float, f"--set {name}", text) for name, text in texts.items()}
    with at("--system"):
        system = load_system(options.system)
    with at("--set"):
        return system.with_(**given)


def _checked_delay(delay: float) -> float:
    found = number("delay", delay)
    if found < 0.0:
        raise RequestError(f"delay = {found!r} must not be negative")
    return found


def _parser() -> Parser:
    parser = Parser(
        prog=f"nlds-vines {_NAME}",
        description="How long chaos lasts over an ensemble of starts, and where they end.",
        epilog=_EXAMPLES,
    )
    add = parser.add_argument
    add("-o", "--output", default=f"{_NAME}.h5", metavar="FILE.h5", help=f"archive [{_NAME}.h5]")
    add("--plot", metavar="FILE", help="picture: .png, .pdf or .svg [FILE.png]")
    add("--system", default=_SYSTEM, metavar="NAME", help="of the catalogue, or a TOML file")
    add("--set", action="append", default=[], metavar="NAME=VALUE", help="SI units")
    add("--starts", type=int, default=STARTS, metavar="N", help=f"random ones [{STARTS}]")
    add("--seed", type=int, default=0, metavar="N", help="that they are drawn by [0]")
    add("--transient", type=int, default=TRANSIENT, metavar="PERIODS", help=f"[{TRANSIENT}]")
    add("--periods", type=int, default=PERIODS, metavar="PERIODS", help=f"then sampled [{PERIODS}]")
    add("--delay", type=float, default=DELAY, metavar="PERIODS", help=f"before the law [{DELAY:g}]")
    add("--method", default="exact", metavar="METHOD", help=" or ".join(METHODS))
    add("--effort", default="standard", metavar="EFFORT", help=f"of {', '.join(EFFORTS)}")
    add("--threads", type=int, metavar="N", help="by default all processors")
    existing = parser.add_mutually_exclusive_group()
    existing.add_argument("--resume", action="store_true", help="continue an archive")
    existing.add_argument("--overwrite", action="store_true", help="replace an archive")
    add("--dry-run", action="store_true", help="only say what it would take")
    add("--quiet", action="store_true", help="say nothing")
    return parser
