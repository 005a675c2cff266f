"""`Command` runs a command from arguments to exit status; a `Job` is a request and its files."""

from __future__ import annotations

import argparse
import atexit
import gc
import sys
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar

from nlds_vines.archives.archive import ArchivePath
from nlds_vines.cli import running
from nlds_vines.cli.options import (
    FREQUENCY,
    LOOK,
    Option,
    Parser,
    add_settings,
    comma_separated,
    look_of,
)
from nlds_vines.cli.terminal import DONE, ORBITS_FAILED, complain, exit_status_of, program, say
from nlds_vines.errors import LeftAside, RequestError, at, choice, from_text, shown
from nlds_vines.model.look import USUAL_LOOK, Look
from nlds_vines.model.ratios import UNITS
from nlds_vines.model.setting import Checked, Real, Whole, settings_of
from nlds_vines.runs import interrupts
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.runs.store import BlockStore


@dataclass(frozen=True)
class Command:
    """One command of the console script.

    The `name` is a subcommand, or `python -m MODULE` for a program of its own.  `carry_out` returns
    the exit status.  `common` are the options that --help lists, with blanks between, or else all.
    """

    name: str
    description: str
    examples: str
    declare: Callable[[Parser], None]
    carry_out: Callable[[argparse.Namespace], int]
    common: str = ""

    def main(self, argv: Sequence[str] | None = None) -> int:
        """Run the command with `argv`, by default those of the process; return the exit status."""
        # at the exit no garbage is collected, which takes a second after compiling
        atexit.unregister(gc.freeze)  # once, however many commands a process runs
        atexit.register(gc.freeze)
        arguments = list(sys.argv[1:] if argv is None else argv)

        def work() -> int:
            about, end = self.description, self.examples
            parser = Parser(
                self.common.split(), prog=program(self.name), description=about, epilog=end
            )
            self.declare(parser)
            options = parser.parse(arguments)
            with warnings.catch_warnings():
                is_quiet = getattr(options, "quiet", False)
                warnings.simplefilter("ignore" if is_quiet else "always", LeftAside)
                others = warnings.showwarning

                def show(message: Any, category: Any, *where: Any, **how: Any) -> None:
                    if issubclass(category, LeftAside):
                        complain(self.name, str(message))
                    else:
                        others(message, category, *where, **how)

                warnings.showwarning = show
                return self.carry_out(options)

        status = exit_status_of(self.name, work)
        if argv is None:  # this process is the command
            interrupts.end_with(status)
        return status


# ---- tasks ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Job:
    """A request and its files; checked when made, before anything heavy is loaded.

    The `source` was read and must not be replaced; `frequency` is the unit of axes, by default that
    of the request, `look` the page of the picture.  Further fields of a subclass are options of its
    command.
    """

    default: ClassVar[str] = ""
    """The name of the archive, if none is given; empty for one in memory."""

    is_named_after_source: ClassVar[bool] = False
    """Whether the archive has the name of the request file instead, if there is one."""

    request: Any
    source: Path | None
    archive: Path
    plot: Path | None = None
    how: RunOptions = field(default_factory=RunOptions)
    frequency: str | None = None
    look: Look = USUAL_LOOK

    def __post_init__(self) -> None:
        """Raise `RequestError` if a file cannot be written or the picture cannot be drawn."""
        if self.frequency is not None:
            choice("--frequency", self.frequency, UNITS)
        if ArchivePath.of(self.archive).named is None:  # in memory
            running.refuse_same(self.source, self.plot, *self.others())
        else:
            running.check_output(self.archive, self.source, self.plot, *self.others())
        if self.plot is not None:
            running.check_plot(self.plot)
            with at(f"--plot {shown(str(self.plot))}"):
                self.check_picture()

    @classmethod
    def from_options(cls, request: Any, options: argparse.Namespace) -> Any:
        after = cls.is_named_after_source and options.source is not None
        named = f"{Path(options.source).stem}.h5" if after else cls.default
        files: dict[str, Any] = {
            "source": running.request_path(options.source),
            "archive": ArchivePath.for_result(options.output or named or None, "archive"),
            "plot": running.optional_path(options.plot),
            "how": running.run_options(options),
            "look": look_of(options),
        }
        names = {f.name for f in fields(cls)} - files.keys()
        others = {k: v for k, v in vars(options).items() if k in names and v is not None}
        return cls(request, **files, **others)

    @classmethod
    def compute(cls, request: Any, source: Any, to: Any, how: RunOptions, **others: Any) -> Any:
        """Compute a request for Python; without `to`, the archive stays in memory."""
        archive = ArchivePath.for_result(to, Path(cls.default).stem, how.resume, how.overwrite)
        return cls(request, running.request_path(source), archive, how=how, **others).run()

    def others(self) -> Sequence[Path | None]:
        """Return further files of the job, which it reads."""
        return ()

    def check_picture(self) -> None:
        """Raise `RequestError` if the picture cannot be drawn."""

    def refuse(self) -> None:
        """Raise `RequestError` if the run would not begin, because of files that exist."""
        BlockStore(self.archive, self.request).begin(self.how)
        if self.plot is not None:
            mark = self.request.hash if self.how.resume else ""
            running.refuse_replacing("picture", self.plot, self.how.overwrite, mark)

    def run(self) -> Any:
        self.refuse()
        results = self.results()
        if self.plot is not None:
            self.draw(self.plot, results)
        return results

    def results(self) -> Any:
        self.compute_archive()
        return self.read(self.archive)

    def compute_archive(self) -> Any:
        """Compute the request into the archive, with kernels that are loaded now."""
        raise NotImplementedError

    @classmethod
    def read(cls, path: Path) -> Any:
        """Return the results in an archive of such requests."""
        raise NotImplementedError

    @classmethod
    def picture(cls) -> Any:
        """Return the `plotting.chosen_panels.Drawing` of archives of such requests."""
        raise NotImplementedError

    def draw(self, plot: Path, results: Any) -> None:
        self.picture().save(self.archive, plot, frequency=self.frequency, look=self.look)

    def plan(self) -> list[str]:
        raise NotImplementedError

    def lines(self, results: Any) -> list[str]:
        return list(results.lines())

    def paths(self) -> list[str]:
        return [str(path) for path in (self.archive, self.plot) if path is not None]

    def failure(self, results: Any) -> str:
        """Return a line that says what failed; empty if nothing did."""
        return ""

    def carry_out(self, name: str, dry_run: bool) -> int:
        """Run for the command `name`, or only say what that would do; return the exit status."""
        if dry_run:
            self.refuse()
            say(*self.plan(), *self.request.starts_inside())
            return DONE
        results = self.run()
        if not self.how.quiet:
            say(*self.lines(results), *self.request.starts_inside(), *self.paths())
        failure = self.failure(results)
        if failure:
            complain(name, failure)
        return ORBITS_FAILED if failure else DONE


def of_task(
    name: str,
    load: Callable[..., Any],
    job: type[Job],
    source: tuple[str, str],
    options: Sequence[Option],
    owners: Sequence[Any],
    **about: Any,
) -> Command:
    """Return the command of a task.

    `load(source, changes, place)` returns the request; `source` is the argument's metavar and help;
    `options` and the settings of `owners` become options.  `about` may also have `add_run`, which
    declares the options of a run, `but` and `usual` (`add_settings`).
    """
    add_run, but = about.pop("add_run", running.add_run_options), about.pop("but", ())
    usual = about.pop("usual", {})

    def declare(parser: Parser) -> None:
        form, words = source
        parser.add_argument("source", nargs="?", metavar=form, help=words)
        parser.add_argument("-o", "--output", metavar="FILE.h5", help=f"archive [{job.default}]")
        parser.add_argument("--plot", metavar="FILE", help="picture: .png, .pdf or .svg")
        group = parser.add_argument_group("options that override the request file")
        for option in options:
            option.add(group)
        add_settings(group, *owners, but=but, usual=usual)
        if not any("frequency" in settings_of(owner) for owner in owners):
            FREQUENCY.add(parser)
        for option in LOOK:
            option.add(parser)
        add_run(parser)

    def carry_out(chosen: argparse.Namespace) -> int:
        request = load(chosen.source, changes(chosen, options, owners), "command line")
        return int(job.from_options(request, chosen).carry_out(name, chosen.dry_run))

    return Command(name, declare=declare, carry_out=carry_out, **about)


def changes(
    chosen: argparse.Namespace, options: Sequence[Option], owners: Sequence[Any]
) -> dict[str, dict[str, Any]]:
    """Return the changes that the options make to a request, as a document."""
    document: dict[str, Any] = {}
    for option in options:
        text = getattr(chosen, option.name)
        is_read = option.read is not None and text not in (None, False, [])
        for key, entries in option.read(text).items() if option.read and is_read else ():
            if key in document and isinstance(entries, dict):
                for name in document[key].keys() & entries.keys():
                    words = f"{option.flag} and the option before it that gives {name}"
                    raise RequestError(f"{words} exclude each other: give one of them")
                entries = {**document[key], **entries}
            document[key] = entries
    for setting in (setting for owner in owners for setting in settings_of(owner).values()):
        value = getattr(chosen, f"{setting.table}.{setting.key}", None)
        if value is None:
            continue
        check = setting.check
        if isinstance(check, Checked) and check.listed:
            value = comma_separated(value)
        elif isinstance(check, Whole):
            value = from_text(int, setting.flag, value)
        elif isinstance(check, Real) or (isinstance(check, Checked) and not value[:1].isalpha()):
            value = from_text(float, setting.flag, value)
        document.setdefault(setting.table, {})[setting.key] = value
    return document
