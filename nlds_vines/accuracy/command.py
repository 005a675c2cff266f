"""Error against run time on a system of one's own, and what tolerance to take.

As a command: `python -m nlds_vines.accuracy`, or `nlds-vines accuracy`.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.cli.command_main import DONE, Command, say
from nlds_vines.cli.option_values import add_system_options, chosen_system, settings_of
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import (
    check_output,
    check_plot,
    file_path,
    optional_path,
    refuse_begun,
    refuse_existing,
    refuse_replacing,
)
from nlds_vines.cli.run_options import RunOptions, add_local_options, run_options
from nlds_vines.errors import RequestError, from_text, shown, whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from nlds_vines.archives.archive import ArchiveView
    from nlds_vines.model.system import System
    from nlds_vines.runs.survey import Survey

_DEFAULT = "ssul-set6"
_EXAMPLES = """\
examples:
  nlds-vines accuracy
      SSul NES Set 6 at omega = 6.28 rad/s, twenty periods from rest: both methods, and SciPy
  nlds-vines accuracy own.toml --set omega=6.9 --want 1e-6
      the same for a system of your own, and the cheapest setting that is good to 1e-6
the table is Markdown; in a clone, `python -m benchmarks.accuracy` measures the solvers of others
exit status: 0 done; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on with what it has kept
"""


def declare_system(parser: Parser) -> None:
    """Declare the options that say which system is measured."""
    parser.add_argument("scan", nargs="?", metavar="SCAN.toml", help="whose system is taken")
    add_system_options(parser, f"of the catalogue, or a TOML file [{_DEFAULT}]")


def declare(parser: Parser, archive: str = "accuracy.h5") -> None:
    """Declare the options that say what is measured, and where it goes."""
    declare_system(parser)
    parser.add_argument("--periods", metavar="N", help="after which errors are taken [20]")
    parser.add_argument("--no-peers", action="store_true", help="our own methods only")
    parser.add_argument("-o", "--output", metavar="FILE.h5", help=f"[{archive}]")
    parser.add_argument("--plot", metavar="FILE.png|pdf|svg", help="[the same, .png]")
    add_local_options(parser, threads=False)


def _declare(parser: Parser) -> None:
    declare(parser)
    parser.add_argument("--want", metavar="ERROR", help="of the setting that is advised [1e-9]")


def _carry_out(options: argparse.Namespace) -> int:
    system, periods = system_of(options), periods_of(options)
    want = from_text(float, "--want", options.want or "1e-9")
    if not 0.0 < want < 1.0:
        raise RequestError(f"--want = {want:g} must lie between 0 and 1")

    def survey() -> Survey:
        from nlds_vines.accuracy import measure
        from nlds_vines.accuracy.measured_cases import Case
        from nlds_vines.archives.provenance import version

        others = [] if options.no_peers else list(measure.scipy_contenders())
        versions = {"SciPy": version("scipy")} if others else {}
        return measure.comparison([Case.of(system, periods)], others, versions)

    def lines(view: ArchiveView) -> Iterable[str]:
        from nlds_vines.accuracy import tables
        from nlds_vines.accuracy.measured_cases import read_cases

        return (line for case in read_cases(view) for line in tables.lines(case, want))

    return Job.of(options, "accuracy.h5").run(survey, lines, options.dry_run)


def system_of(options: Any) -> System:
    """Return the system asked for: of the catalogue, or a scan's, in the middle of its axes."""
    if options.scan is None:
        return chosen_system(options, _DEFAULT)
    if options.system is not None:
        raise RequestError(
            f"{shown(options.scan)} and --system {options.system} exclude each other: give one"
        )
    scan = load_scan(options.scan)
    middle = {axis.name: float(axis.values[axis.values.size // 2]) for axis in scan.axes}
    return scan.system.with_(**(middle | settings_of(options)))


def periods_of(options: Any) -> int:
    """Return the periods asked for."""
    given = from_text(int, "--periods", options.periods or "20")
    return whole("--periods", given, 2, 10_000)


@dataclass(frozen=True)
class Job:
    """Where the results go; checked before anything heavy is loaded."""

    archive: Path
    plot: Path
    source: Path | None
    how: RunOptions

    @classmethod
    def of(cls, options: Any, default: str) -> Job:
        """Return the job that the options ask for; `default` is the name of its archive."""
        archive = file_path(options.output or default)
        plot = archive.with_suffix(".png") if options.plot is None else Path(options.plot)
        return cls(archive, plot, optional_path(options.scan), run_options(options))

    def __post_init__(self) -> None:
        """Raise `RequestError` for files that cannot be written, or are one and the same."""
        check_output(self.archive, self.source, self.plot)
        check_plot(self.plot)

    def run(
        self,
        make: Callable[[], Survey],
        lines: Callable[[ArchiveView], Iterable[str]],
        dry_run: bool,
        drawn: Callable[[ArchiveView], Figure] | None = None,
    ) -> int:
        """Measure what `make` returns, draw it, and print the `lines` of its archive.

        `drawn`: the picture, if it is another than `nlds-vines plot` draws.
        """
        refuse_existing(self.archive, self.how)
        if not self.how.resume:
            refuse_replacing("picture", self.plot, self.how)
        survey = make()
        refuse_replacing("picture", self.plot, self.how, survey.hash)
        if dry_run:
            refuse_begun(self.archive, survey, self.how)
            say(*(task.name for task in survey.tasks))
            return DONE
        from nlds_vines.accuracy.picture import draw
        from nlds_vines.archives.archive import read
        from nlds_vines.orbits.compilation import silent
        from nlds_vines.plotting.save import save_figure
        from nlds_vines.runs.survey import run

        how = self.how
        with silent(how.quiet):
            run(survey, self.archive, resume=how.resume, overwrite=how.overwrite, quiet=how.quiet)
        with read(self.archive) as view:
            digest = ("scan_hash", view.text("scan_hash"))
            save_figure((drawn or draw)(view), self.plot, view.text("title"), digest)
            say(*lines(view))
        return DONE


main = Command(
    name="accuracy",
    description="Error against run time of our methods and of SciPy on one system.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
).main
