"""A job: a request, where its results go and how it runs."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nlds_vines.cli.command_main import DONE, LANES_FAILED, complain, say
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import (
    check_output,
    check_plot,
    optional_path,
    refuse_begun,
    refuse_existing,
    refuse_replacing,
    request_path,
)
from nlds_vines.cli.run_options import RunOptions, run_options
from nlds_vines.cli.task_registry import TASKS
from nlds_vines.errors import at, shown


@dataclass(frozen=True)
class Job:
    """A request and its files; checked when made, before anything heavy is loaded.

    Arguments:
        request: what to compute; source: the file that it was read from, which is not to be
            replaced.
        archive, plot: the files to write; None for no picture.
        how: how the run goes.

    Each task says in words what it would do (`plan`) and what it has found (`lines`, `failure`).
    What computes, reads and draws its archive stands in `cli.task_registry`.
    """

    request: Any
    source: Path | None
    archive: Path
    plot: Path | None = None
    how: RunOptions = field(default_factory=RunOptions)

    def __post_init__(self) -> None:
        """Raise `RequestError` for files that cannot be written, and what cannot be drawn."""
        check_output(self.archive, self.source, self.plot, *self.others())
        if self.plot is not None:
            check_plot(self.plot)
            with at(f"--plot {shown(str(self.plot))}"):
                self.check_picture()

    def others(self) -> Sequence[Path | None]:
        """Return further files of the job, which it reads."""
        return ()

    def check_picture(self) -> None:
        """Raise `RequestError` where the picture cannot be drawn."""

    def refuse(self, dry_run: bool = False) -> None:
        """Raise `RequestError` where files exist; with `dry_run` for all that a run refuses."""
        refuse_existing(self.archive, self.how)
        refuse_replacing("picture", self.plot, self.how, self.request.hash)
        if dry_run:
            refuse_begun(self.archive, self.request, self.how)

    def run(self) -> Any:
        """Compute, draw, and return the results.

        Raises `RequestError` for an archive that exists, without --resume and --overwrite.
        """
        self.refuse()
        found = self.found()
        if self.plot is not None:
            self.draw(self.plot, found)
        return found

    def found(self) -> Any:
        """Compute the archive, and return what it holds."""
        task = TASKS[self.request.content]
        task.part("run").run(self.request, self.archive, self.how)
        return task.read(self.archive)

    def draw(self, plot: Path, found: Any) -> None:
        """Draw the picture of what was found."""
        TASKS[self.request.content].picture.save(self.archive, plot)

    def plan(self) -> list[str]:
        """Return what would be done, one fact a line."""
        raise NotImplementedError

    def lines(self, found: Any) -> list[str]:
        """Return what was found, one thing a line."""
        return list(found.lines())

    def inside(self) -> list[str]:
        """Return a line on starts inside a wall, if there are any."""
        return []

    def paths(self) -> list[str]:
        """Return where the results are, one line each."""
        return [str(path) for path in (self.archive, self.plot) if path is not None]

    def failure(self, found: Any) -> str:
        """Return in words what of the results has failed; empty for nothing."""
        return ""

    def carry_out(self, name: str, dry_run: bool) -> int:
        """Run for the command `name`, or only say what that would do; return the exit status."""
        if dry_run:
            self.refuse(dry_run=True)
            say(*self.plan(), *self.inside())
            return DONE
        found = self.run()
        if not self.how.quiet:
            say(*self.lines(found), *self.inside(), *self.paths())
        failure = self.failure(found)
        if failure:
            complain(name, failure)
        return LANES_FAILED if failure else DONE


def add_files(parser: Parser, source: str, words: str, archive: str) -> None:
    """Declare what a task reads, the `source`, in `words`, and what it writes: -o and --plot."""
    parser.add_argument("source", nargs="?", metavar=source, help=words)
    parser.add_argument("-o", "--output", metavar="FILE.h5", help=f"archive [{archive}]")
    parser.add_argument("--plot", metavar="FILE", help="picture: .png, .pdf or .svg")


def files_of(options: argparse.Namespace, usual: str) -> dict[str, Any]:
    """Return the files that options name, and how they say that it runs, for a `Job`.

    Arguments: `usual`, the name of the archive where none is given.
    """
    return {
        "source": request_path(options.source),
        "archive": Path(usual if options.output is None else options.output),
        "plot": optional_path(options.plot),
        "how": run_options(options),
    }


def named_after(source: str | os.PathLike[str] | None, usual: str) -> str:
    """Return the name of an archive: that of what is read with `.h5` in this folder, or `usual`."""
    return usual if source is None else f"{Path(source).stem}.h5"
