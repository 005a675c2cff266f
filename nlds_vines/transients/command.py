"""How long chaos lasts before it ends, over an ensemble of starts, and where the starts end.

As a command: `python -m nlds_vines.transients`, or `nlds-vines transients`.
In Python: `nlds_vines.transient_lifetimes(system)`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.bifurcation import command as bifurcation
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.result import ScanArchive
from nlds_vines.cli.command_main import Command
from nlds_vines.cli.option_values import (
    add_system_options,
    chosen_system,
)
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import (
    file_path,
    request_path,
)
from nlds_vines.cli.run_options import RunOptions, add_local_options, run_options
from nlds_vines.cli.setting_options import add_settings, changed
from nlds_vines.errors import RequestError, at, number
from nlds_vines.model.axis import Axis
from nlds_vines.model.catalog import as_system
from nlds_vines.model.contact_laws import HERTZ
from nlds_vines.model.parameters import CONTACT
from nlds_vines.model.scenes.base import BASES
from nlds_vines.model.setting import settings_of
from nlds_vines.model.system import System
from nlds_vines.model.words import setting_in_words, system_in_words
from nlds_vines.orbits.starts import Start
from nlds_vines.transients.survival import DELAY

if TYPE_CHECKING:
    from nlds_vines.bifurcation.run import Report
    from nlds_vines.transients.ensemble import Ensemble

_NAME = "transients"
_SYSTEM = "ssul-set6"
STARTS, TRANSIENT, PERIODS = 1000, 4000, 120
"""Random starts; forcing periods of each that are discarded, and that are sampled then."""

_SAMPLING = {"transient": TRANSIENT, "periods": PERIODS}

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


# public: its keywords are those of the command, more than eight
def transient_lifetimes(
    system: System | str | os.PathLike[str] | None = None,
    *,
    to: str | os.PathLike[str] | None = None,
    starts: int = STARTS,
    seed: int = 0,
    transient: int = TRANSIENT,
    periods: int = PERIODS,
    method: str = "exact",
    effort: str = "standard",
    tolerance: float | str | None = None,
    delay: float = DELAY,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = False,
) -> Ensemble:
    """Follow an ensemble of starts; return how long each took to settle, and where.

    Arguments:
        system: a `System`, the name of one or the path of a TOML file, by default SSul NES Set 6.
        to: the archive (.h5); None for one that is gone with what is returned.
        starts, seed: how many random starts, drawn by which seed (`orbits.starts.random_states`).
        transient, periods: forcing periods of each, discarded and sampled; what has not settled
            then is watched for as many more as the `effort` of verdicts allows.
        method: of `orbits.solver_settings.METHODS`; effort: of `orbits.solver_settings.EFFORTS`.
        tolerance: of method exact: a number, draft, standard (the default) or fine.
        delay: forcing periods after which lifetimes count in the exponential law.
        threads: how many; by default as many as the machine has processors.
        resume, overwrite: continue or replace an archive that exists; not both.
        quiet: whether to show no progress.

    Raises `RequestError` where anything asked for is wrong, before anything is computed.
    """
    sampling = {"transient": transient, "periods": periods, "method": method, "effort": effort}
    scan = _scan(system, starts, seed, {**sampling, "tolerance": tolerance})
    delay = _checked_delay(delay)
    archive = ScanArchive.for_result(to, _NAME, resume, overwrite)
    how = RunOptions(threads, resume, overwrite, quiet=quiet)
    job = Job(scan, request_path(system), archive, None, how, delay=delay)
    job.run()
    return job.ensemble()


@dataclass(frozen=True)
class Job(bifurcation.Job):
    """The scan of an ensemble and where it goes; `delay`, before lifetimes count in the law."""

    delay: float = DELAY

    def ensemble(self) -> Ensemble:
        """Return the ensemble in the archive."""
        from nlds_vines.transients.ensemble import ensemble_of

        return ensemble_of(self.archive, delay=self.delay)

    def draw(self, plot: Path, found: Report) -> None:
        """Draw the ensemble."""
        from nlds_vines.transients.picture import picture

        picture(self.delay).save(self.archive, plot)

    def lines(self, found: Report) -> list[str]:
        """Return how long the starts took and where they ended."""
        return [self.request.title, *self.ensemble().lines(), *found.tally.inadmissible()]


def _job(options: argparse.Namespace) -> Job:
    """Return the job that the command line means."""
    sampling = _SAMPLING | changed(options, Scan).get("sampling", {})
    with at("command line"):
        scan = _scan(chosen_system(options, _SYSTEM), options.starts, options.seed, sampling)
        delay = _checked_delay(options.delay)
    archive = file_path(options.output)
    plot = archive.with_suffix(".png") if options.plot is None else Path(options.plot)
    return Job(scan, None, archive, plot, run_options(options), delay=delay)


def _scan(
    system: System | str | os.PathLike[str] | None,
    starts: int,
    seed: int,
    sampling: Mapping[str, Any],
) -> Scan:
    """Return the scan of one cell that computes an ensemble."""
    system = as_system(_SYSTEM if system is None else system)
    axis = Axis("omega", np.array([system.parameters["omega"]]))
    title = f"{_title(system)}: {starts} starts"
    return Scan(title, system, (axis,), _WANT, Start("random", starts, seed), **sampling)


def _title(system: System) -> str:
    """Return the name of a system with what tells one ensemble from another."""
    p = system.parameters
    values = {name: p[name] for name in ("omega", "P", "Y", *BASES) if name in p}
    if system.scene.law == HERTZ and system.scene.walls:
        values["K"] = system.K
    values |= {name: p[name] for name in system.scene.contact(p) if name not in CONTACT}
    numbers = ", ".join(setting_in_words(*item) for item in values.items())
    return f"{system_in_words(system)}, {numbers}"


def _checked_delay(delay: float) -> float:
    found = number("delay", delay)
    if found < 0.0:
        raise RequestError(f"delay = {found!r} must not be negative")
    return found


def _declare(parser: Parser) -> None:
    add = parser.add_argument
    add("-o", "--output", default=f"{_NAME}.h5", metavar="FILE.h5", help=f"archive [{_NAME}.h5]")
    add("--plot", metavar="FILE", help="picture: .png, .pdf or .svg [FILE.png]")
    add_system_options(parser)
    add("--starts", type=int, default=STARTS, metavar="N", help=f"random ones [{STARTS}]")
    add("--seed", type=int, default=0, metavar="N", help="that they are drawn by [0]")
    add("--delay", type=float, default=DELAY, metavar="PERIODS", help=f"before the law [{DELAY:g}]")
    others = [said.key for said in settings_of(Scan).values() if said.table != "sampling"]
    add_settings(parser, Scan, but=others, usual=_SAMPLING)
    add_local_options(parser)


COMMAND = Command(
    name=_NAME,
    description="How long chaos lasts over an ensemble of starts, and where they end.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=lambda options: _job(options).carry_out(_NAME, options.dry_run),
)
main = COMMAND.main
