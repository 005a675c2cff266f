"""The paper, figure by figure: every picture, and a report that checks every claim.

As a command, in a clone: `python -m paper`.
In Python: `paper.command.reproduce_paper(folder)`.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from nlds_vines.bifurcation.blocks import refuse_without_room
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves import CurveRequest
from nlds_vines.cli.command import Command
from nlds_vines.cli.options import Parser
from nlds_vines.cli.running import (
    PLOT_SUFFIXES,
    RunOptions,
    check_writable,
    optional_path,
    refuse_replacing,
)
from nlds_vines.cli.terminal import DONE, ORBITS_FAILED, complain, say
from nlds_vines.errors import RequestError, choice, shown, unknown
from nlds_vines.runs.interrupts import INTERRUPTED, Interrupted
from nlds_vines.runs.store import BlockStore
from nlds_vines.upkeep.explore import refuse_without_bokeh
from nlds_vines.upkeep.tasks import JOBS
from paper.request import FigureRequest, load_figure, packaged_figures, short_name

_NAME = "python -m paper"
_FOLDER = "reproduction"
_ARCHIVES = "archives"
_REPORT = "reproduction.md"
_SHOWN = "8"
_OWN_REPORT = "Made by `python -m paper`"  # stands in every report, and in no other file
FORMATS = tuple(suffix.removeprefix(".") for suffix in PLOT_SUFFIXES)
"""The formats of pictures."""

_EXAMPLES = """\
examples:
  python -m paper
      every figure and the report, in the folder `reproduction`
  python -m paper --only 2a,3,8 -o some --format pdf
      three of the figures; what is computed already is used again
  python -m paper --page paper.html
      beside all this, a page to click: Figure 8, and the claims (needs the extra `explore`)
pages of your own: nlds-vines response-curves, bifurcation or portrait FILE.toml
exit status: 0 done; 1 finished, but some orbits failed; 2 the request is wrong;
130 interrupted, 143 terminated: the same command goes on
"""


def reproduce_paper(
    output: str | os.PathLike[str] = _FOLDER,
    *,
    only: Sequence[str] = (),
    picture: str = "png",
    threads: int | None = None,
    overwrite: bool = False,
    quiet: bool = True,
) -> Path:
    """Make the figures and the report in the folder `output`; return the report's path.

    Arguments:
        output: made if need be; archives in it are used again if they are of the same scans.
        only: figures by the names of the command line (`2a`, `8`, `stiffness`); empty for all.
        picture: of `FORMATS`.
        threads: how many; by default as many as the machine has processors.
        overwrite: whether to compute again what is there.
        quiet: whether to say nothing.

    Raises `RequestError` where anything asked for is wrong, before anything is computed.
    """
    how = _how(threads, overwrite, quiet)
    job = _Job(_chosen(only), Path(output), picture, how)
    job.run()
    return job.report_path


def _how(threads: int | None, overwrite: bool, quiet: bool) -> RunOptions:
    """Return how the scans run: what is computed already is used again unless it is replaced."""
    return RunOptions(threads, resume=not overwrite, overwrite=overwrite, quiet=quiet)


@dataclass(frozen=True)
class _Job:
    """Requests and where their pictures go; checked when made, before anything heavy is loaded."""

    requests: tuple[FigureRequest, ...]
    folder: Path
    picture: str
    how: RunOptions
    page: Path | None = None
    cached: dict[object, Any] = field(default_factory=dict)  # cases that several figures have

    def __post_init__(self) -> None:
        choice("--format", self.picture, FORMATS)
        if self.folder.exists() and not self.folder.is_dir():
            raise RequestError(f"output {shown(str(self.folder))} is a file: name a folder")
        check_writable("output", self.folder / _REPORT if self.folder.is_dir() else self._probe())
        if self.page is not None:
            self._check_page(self.page)

    def _check_page(self, page: Path) -> None:
        """Raise `RequestError` where the page cannot be made."""
        refuse_without_bokeh(_NAME)
        if not any(short_name(request.name) == _SHOWN for request in self.requests):
            raise RequestError(f"--page shows figure {_SHOWN}: --only leaves it out")
        check_writable("--page", page)

    def _probe(self) -> Path:
        """Return a file that can be written where the folder can be made."""
        return self.folder.parent / f"{self.folder.name}.probe"

    @property
    def report_path(self) -> Path:
        """Where the report goes."""
        return self.folder / _REPORT

    def picture_path(self, request: FigureRequest) -> Path:
        """Return where the picture of a request goes."""
        return self.folder / f"{request.name}.{self.picture}"

    @cached_property
    def archives(self) -> dict[Path, CurveRequest | Scan]:
        """The requests to compute, by the path of the archive."""
        folder = self.folder / _ARCHIVES
        return {folder / one.archive: one.computed for one in self.requests if one.computed}

    def refuse(self, dry_run: bool = False) -> None:
        """Raise `RequestError` for files in the folder that this program has not made.

        With `dry_run` for all that a run refuses.
        """
        for request in self.requests:
            own = "scan_hash" if request.computed else "recipe_hash"
            refuse_replacing("picture", self.picture_path(request), self.how.overwrite, own)
        refuse_replacing("report", self.report_path, self.how.overwrite, _OWN_REPORT)
        if self.page is not None:
            refuse_replacing("--page", self.page, self.how.overwrite)
        for path, computed in self.archives.items() if dry_run else ():
            BlockStore(path, computed).begin(self.how)

    def run(self) -> int:
        """Compute, draw and report; return how many orbits failed."""
        self.refuse()
        (self.folder / _ARCHIVES).mkdir(parents=True, exist_ok=True)
        for figure in self.requests:
            for scan in figure.scans.values():
                refuse_without_room(scan, self.folder / _ARCHIVES / figure.archive)
        failed = sum(self._compute(*item) for item in self.archives.items())
        failed += sum(self._draw(request) for request in self.requests)
        self._write_report()
        if self.page is not None:
            self._write_page(self.page)
        return failed

    def _write_report(self) -> None:
        from paper import report
        from paper.motion import motions_of

        archives = self.folder / _ARCHIVES
        report.write(self.report_path, archives, self.picture, motions_of)
        self._say(str(self.report_path))

    def _write_page(self, page: Path) -> None:
        from paper.claims_page import write_page

        known = packaged_figures()
        write_page(page, self.folder / _ARCHIVES, known, known[_SHOWN].archive)
        self._say(str(page))

    def _compute(self, path: Path, request: CurveRequest | Scan) -> int:
        """Compute an archive unless it is there; return how many of its orbits failed."""
        from nlds_vines.archives.archive import read
        from nlds_vines.bifurcation.run import run

        done = not self.how.overwrite and BlockStore(path, request).is_delivered()
        began = time.perf_counter()
        how = replace(self.how, quiet=True)
        run(request, path, how, self.cached)
        seconds = time.perf_counter() - began
        number = list(self.archives).index(path) + 1
        spent = "there already" if done else f"{request.lanes} orbits in {seconds:.1f} s"
        self._say(f"[{number}/{len(self.archives)}] {path.stem}: {spent}")
        with read(path) as view:
            failed = int((view["status"] > 0).sum())
        if failed:
            where = f"the dataset `status` of {path} says why"
            complain(_NAME, f"{failed} of {request.lanes} orbits failed: {where}")
        return failed

    def _draw(self, request: FigureRequest) -> int:
        """Draw the picture of a request; return how many orbits could not be followed for it."""
        path = self.picture_path(request)
        if request.computed is None:
            return self._draw_portrait(request, path)
        archive = self.folder / _ARCHIVES / request.archive
        JOBS[request.computed.content].picture().save(archive, path)
        self._say(str(path))
        return 0

    def _draw_portrait(self, request: FigureRequest, path: Path) -> int:
        """Hand the request of an orbit to the command that draws it; return 1 if it failed."""
        from nlds_vines.portrait.command import main as portrait

        status = portrait([str(request.path), "--plot", str(path), "--quiet", "--overwrite"])
        if status == INTERRUPTED:
            raise KeyboardInterrupt
        if status not in (DONE, ORBITS_FAILED):
            raise RequestError(f"{request.path} could not be drawn: see above")
        self._say(str(path))
        return int(status == ORBITS_FAILED)

    def _say(self, text: str) -> None:
        if not self.how.quiet:
            say(text)

    def plan(self) -> list[str]:
        """Return what the run would do, a line for each request and one for all of it."""
        lines = []
        for request in self.requests:
            orbits = request.computed.lanes if request.computed else 1
            lines.append(f"{self.picture_path(request)}: {request.title}; orbits: {orbits}")
        there = 0
        if not self.how.overwrite:
            there = sum(BlockStore(*item).is_delivered() for item in self.archives.items())
        scans = [scan for request in self.requests for scan in request.scans.values()]
        todo = sum(scan.lanes * (scan.transient + scan.periods) for scan in scans)
        count = f"{len(self.archives)} archives, {todo} forcing periods"
        return [*lines, f"{count}; of the archives {there} are there already"]


def _carry_out(options: argparse.Namespace) -> int:
    job = _job(options)
    if options.dry_run:
        job.refuse(dry_run=True)
        say(*job.plan())
        return DONE
    try:
        failed = job.run()
    except Interrupted as stop:
        text = "interrupted: the same command goes on from what is computed"
        raise Interrupted(text, stop.status) from stop
    return ORBITS_FAILED if failed else DONE


def _job(options: argparse.Namespace) -> _Job:
    """Return the job that the command line means."""
    if options.sources:
        raise RequestError(_moved(options.sources[0]))
    only = () if options.only is None else options.only.split(",")
    return _Job(
        requests=_chosen(only),
        folder=Path(options.output),
        picture=options.format,
        how=_how(options.threads, options.overwrite, options.quiet),
        page=optional_path(options.page),
    )


def _moved(path: str) -> str:
    """Return where a page of one's own is made, by what stands in its file."""
    computed = load_figure(Path(path)).computed
    command = "bifurcation" if isinstance(computed, Scan) else "response-curves"
    command = command if computed else "portrait"
    return (
        f"{shown(path)}: this command makes the paper's figures (--only 2a,3); "
        f"your own: nlds-vines {command} {path}"
    )


def _chosen(only: Sequence[str]) -> tuple[FigureRequest, ...]:
    """Return the packaged requests of these names, in the paper's order; all for none."""
    known = packaged_figures()
    for name in only:
        if name not in known:
            raise unknown("figure", name, known)
    return tuple(request for name, request in known.items() if not only or name in only)


def _declare(parser: Parser) -> None:
    parser.add_argument("sources", nargs="*", help=argparse.SUPPRESS)  # told where it went
    parser.add_argument("--only", metavar="A,B", help="figures by name, as 2a,3,8")
    parser.add_argument("-o", "--output", metavar="FOLDER", default=_FOLDER, help=f"[{_FOLDER}]")
    parser.add_argument("--page", metavar="FILE.html", help="a page to click, with the claims")
    parser.add_argument("--format", metavar="FORM", default="png", help=f"{', '.join(FORMATS)}")
    parser.add_argument("--threads", type=int, metavar="N", help="by default all processors")
    parser.add_argument("--overwrite", action="store_true", help="compute again what is there")
    parser.add_argument("--dry-run", action="store_true", help="only say what would be done")
    parser.add_argument("--quiet", action="store_true", help="show no progress")


main = Command(
    name=_NAME,
    description="Make every figure of the paper, and a report that checks its claims.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
).main
