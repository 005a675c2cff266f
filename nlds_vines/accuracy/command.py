"""Error against run time beside what a user would try instead; stiff contacts; what parts cost.

As a command: `python -m nlds_vines.accuracy`, or `nlds-vines accuracy`.
"""

from __future__ import annotations

import argparse
import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.accuracy.request import Mode, mode_of
from nlds_vines.archives.durable import write_text
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.cli.option_values import add_system_options, chosen_system, settings_of
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import (
    check_output,
    check_plot,
    check_writable,
    file_path,
    optional_path,
    refuse_begun,
    refuse_existing,
    refuse_replacing,
)
from nlds_vines.cli.run_options import RunOptions, add_local_options, run_options
from nlds_vines.cli.running import DONE, Command, say
from nlds_vines.errors import RequestError, shown
from nlds_vines.runs.manifest import SURVEY

if TYPE_CHECKING:
    from nlds_vines.accuracy.rivals import Rival
    from nlds_vines.model.system import System

_NAME = "accuracy"
_DEFAULT = "ssul-set6"
_EXAMPLES = """\
examples:
  nlds-vines accuracy
      SSul NES Set 6 at omega = 6.28 rad/s, twenty periods from rest: every method there is
  nlds-vines accuracy own.toml --set omega=6.9 --want 1e-6
      the same for a system of your own, and the cheapest setting that is good to 1e-6
  nlds-vines accuracy --suite -o accuracy.h5 --plot accuracy.png --markdown accuracy.md
      five cases: soft, steel, two walls, near grazing, no contact
  nlds-vines accuracy --stiff -o stiffness.h5
      Young's modulus from 2e5 to 2.1e13 Pa and K from 1e4 to 1e16 N/m^1.5
  nlds-vines accuracy --parts
      what a wall, a limit and each record cost per forcing period
peers are naive RK4 and SciPy's solvers; numbalsoda, heyoka, SUNDIALS, diffrax and Octave are
measured too by `python -m benchmarks.accuracy` in a clone, where they are installed
exit status: 0 done; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on with what writes an archive
"""


def command(rivals: tuple[Rival, ...] = (), module: str = "nlds_vines.accuracy") -> Command:
    """Return the command that measures `rivals` beside the methods of the package.

    `module` is what `python -m` runs, for the line that a page names.
    """

    def carry_out(options: argparse.Namespace) -> int:
        _refuse_ignored(options)
        system = _system(options)
        if options.parts:
            return _parts(system, options.dry_run)
        mode = mode_of(options, system, rivals)
        return _Job.of(options, mode, _command_line(module, options.argv)).run(options.dry_run)

    return Command(
        name=_NAME,
        description="Error against run time of every method on one system.",
        examples=_EXAMPLES,
        declare=_declare,
        carry_out=carry_out,
    )


def _declare(parser: Parser) -> None:
    parser.add_argument("scan", nargs="?", metavar="SCAN.toml", help="whose system is taken")
    add_system_options(parser, f"of the catalogue, or a TOML file [{_DEFAULT}]")
    parser.add_argument("--periods", metavar="N", help="after which errors are taken [20]")
    parser.add_argument("--want", metavar="ERROR", help="advise a setting with this error at most")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--suite", action="store_true", help="five cases that stand for all")
    what.add_argument("--stiff", action="store_true", help="from soft rubber to beyond steel")
    what.add_argument("--parts", action="store_true", help="what each part and record costs")
    parser.add_argument("--no-peers", action="store_true", help="our own methods only")
    parser.add_argument("-o", "--output", metavar="FILE.h5", help="[accuracy.h5 or stiffness.h5]")
    parser.add_argument("--plot", metavar="FILE.png|pdf|svg", help="[the same, .png]")
    parser.add_argument("--markdown", metavar="FILE.md", help="write the page, too")
    add_local_options(parser, threads=False)


_NOT_WITH_PARTS = (
    "periods",
    "want",
    "no_peers",
    "output",
    "plot",
    "markdown",
    "resume",
    "overwrite",
)
"""What means nothing to --parts, and would be passed over."""


def _refuse_ignored(options: Any) -> None:
    """Raise `RequestError` for an option that means nothing beside --parts."""
    for name in _NOT_WITH_PARTS if options.parts else ():
        if getattr(options, name):
            given = "-o" if name == "output" else f"--{name.replace('_', '-')}"
            raise RequestError(f"--parts has no use for {given}: leave it out")


def _system(options: Any) -> System:
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


@dataclass(frozen=True)
class _Job:
    """A survey and where it goes; checked before anything heavy is loaded."""

    mode: Mode
    command: str
    source: Path | None
    archive: Path
    plot: Path
    markdown: Path | None
    how: RunOptions

    @classmethod
    def of(cls, options: Any, mode: Mode, command: str) -> _Job:
        """Return the job that the options ask for; `command` is the line for the page."""
        archive = file_path(options.output or mode.default)
        return cls(
            mode,
            command,
            source=optional_path(options.scan),
            archive=archive,
            plot=archive.with_suffix(".png") if options.plot is None else Path(options.plot),
            markdown=None if options.markdown is None else Path(options.markdown),
            how=run_options(options),
        )

    def __post_init__(self) -> None:
        check_output(self.archive, self.source, self.plot, self.markdown)
        check_plot(self.plot)
        if self.markdown is not None:
            check_writable("--markdown", self.markdown)

    def run(self, dry_run: bool) -> int:
        """Measure, draw and print."""
        refuse_existing(self.archive, self.how)
        refuse_replacing("page", self.markdown, self.how, self.command)
        if not self.how.resume:
            refuse_replacing("picture", self.plot, self.how)
        survey = self.mode.survey()
        refuse_replacing("picture", self.plot, self.how, survey.hash)
        if dry_run:
            refuse_begun(self.archive, survey, SURVEY, self.how)
            say(*(task.name for task in survey.tasks))
            return DONE
        from nlds_vines.accuracy.survey import run

        run(survey, self.archive, self.how)
        self._report()
        return DONE

    def _report(self) -> None:
        """Draw the picture, write the page, print the tables: all from the archive."""
        from nlds_vines.archives.archive import read
        from nlds_vines.plotting.save import save_figure

        with read(self.archive) as view:
            digest = ("scan_hash", view.text("scan_hash"))
            save_figure(self.mode.draw(view), self.plot, view.text("title"), digest)
            if self.markdown is not None:
                where = os.path.relpath(self.plot, self.markdown.parent)
                text = self.mode.page(view, where, self.command)
                write_text(self.markdown, text)
            for line in self.mode.lines(view):
                say(line)


def _command_line(module: str, argv: Sequence[str]) -> str:
    """Return the command with these arguments, without those that only say how it ran."""
    passing = ("--resume", "--overwrite", "--quiet")
    given = [text for text in argv if text not in passing]
    return shlex.join(["python", "-m", module, *given])


def _parts(system: System, dry_run: bool) -> int:
    from nlds_vines.accuracy import costs

    if dry_run:
        for part in costs.parts(system):
            say(f"{part.name}: {part.periods} periods, {costs.REPEATS} times")
        return DONE
    for line in costs.report(system):
        say(line)
    return DONE


main = command().main
