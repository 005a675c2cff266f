"""Scan one parameter or two: a bifurcation diagram or a map, in an archive and a picture.

As a command: `python -m nlds_vines.bifurcation`, or `nlds-vines bifurcation`.
In Python: `nlds_vines.bifurcation(scan)`.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from nlds_vines._command import (
    DONE,
    INTERRUPTED,
    LANES_FAILED,
    Parser,
    check_plot,
    check_writable,
    complain,
    run_command,
)
from nlds_vines._scan_options import add_scan_options, changes
from nlds_vines.errors import RequestError, shown, whole
from nlds_vines.record import datasets
from nlds_vines.scan import Scan, load_scan
from nlds_vines.shows import check_show

if TYPE_CHECKING:
    from nlds_vines.engine import Report

_NAME = "bifurcation"
_DEFAULT_STEM = "figure8"
_MOST_THREADS = 4096
_EXAMPLES = """\
examples:
  nlds-vines bifurcation
      Figure 8 of the paper: figure8.h5 and figure8.png
  nlds-vines bifurcation --vary omega=7.2:7.8:601 --start up -o up.h5 --plot up.png
      a part of it, each frequency begun on the attractor of the one below
  nlds-vines bifurcation --system tmd --vary omega=5:8:61 --vary k1=3e4:5e4:41 \\
          --record energy -o map.h5 --plot map.pdf
      a map of the largest energy over two parameters
  nlds-vines bifurcation --vary omega=7:8:60 --vary P=400:1200:60 --start random:8 \\
          --record regime,settling -o regimes.h5 --plot regimes.png
      a map of regimes, and of how many coexist; the same with --resume --show settling
      (or shares, or share:T,0) draws another picture of the same archive
  nlds-vines bifurcation --vary omega=7.2:7.8:601 --start both --record section,regime,lyapunov \\
          -o hysteresis.h5 --plot hysteresis.png
      up and down in two colours, the largest Lyapunov exponent below
exit status: 0 done; 1 finished, but some orbits failed; 2 the request is wrong; 130 interrupted
"""


def bifurcation(
    scan: Scan | str | os.PathLike[str] | Mapping[str, Any] | None = None,
    output: str | os.PathLike[str] | None = None,
    *,
    plot: str | os.PathLike[str] | None = None,
    show: str | None = None,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = True,
) -> Path:
    """Compute a scan and return the path of its archive.

    Arguments:
        scan: a `Scan`, the path of a scan file, the document in one, or None for Figure 8.
        output: the archive; by default the scan file's name with `.h5`, in the current folder.
        plot: a picture to draw as well (.png, .pdf or .svg).
        show: what the picture of a map shows: `regimes`, `coexisting`, `shares`, `share:LABEL` or
            a recorded number (`shows.NUMBERS`).
        threads: how many; by default as many as the machine has processors.
        resume, overwrite: continue or replace an archive that exists; not both.
        quiet: whether to show no progress.

    Raises `RequestError` where anything asked for is wrong, before anything is computed.
    """
    source = Path(scan) if isinstance(scan, str | os.PathLike) else None
    job = _Job(
        scan=load_scan(scan),
        source=source,
        archive=_archive_path(output, source),
        plot=None if plot is None else Path(plot),
        show=show,
        threads=threads,
        resume=resume,
        overwrite=overwrite,
        quiet=quiet,
    )
    job.refuse_to_overwrite()
    job.run()
    return job.archive


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with the arguments `argv` (the process's own if None).

    Returns the exit status: 0 done, 1 some orbits failed, 2 the request is wrong, 130 interrupted.
    """
    return run_command(_NAME, _command, argv)


@dataclass(frozen=True)
class _Job:
    """A scan and where it goes; checked when made, before anything heavy is loaded."""

    scan: Scan
    source: Path | None
    archive: Path
    plot: Path | None
    show: str | None
    threads: int | None
    resume: bool
    overwrite: bool
    quiet: bool

    def __post_init__(self) -> None:
        if self.resume and self.overwrite:
            raise RequestError("resume and overwrite exclude each other: give one of them")
        if self.threads is not None:
            whole("threads", self.threads, 1, _MOST_THREADS)
        check_writable("output", self.archive)
        if self.plot is not None:
            check_plot(self.plot)
            if not _can_be_drawn(self.scan):
                raise RequestError(
                    f"--plot {shown(str(self.plot))}: a map of want = ['section'] alone cannot be "
                    "drawn; record energy or regime as well"
                )
        if self.show is not None:
            names = [dataset.name for dataset in datasets(self.scan)]
            check_show(self.show, len(self.scan.axes), self.scan.starts, names)
        for path in filter(None, (self.source, self.plot)):
            if path.resolve() == self.archive.resolve():
                raise RequestError(f"output {shown(str(self.archive))} is another file of this run")

    def refuse_to_overwrite(self) -> None:
        """Raise `RequestError` where the archive exists and it was not said what to do with it."""
        if os.path.lexists(self.archive) and not (self.resume or self.overwrite):
            raise RequestError(
                f"output {shown(str(self.archive))} exists: --resume continues it, "
                "--overwrite replaces it, -o names another file"
            )

    def run(self) -> Report:
        """Compute the scan, draw the picture, and return the engine's report."""
        from nlds_vines import engine

        report = engine.run(
            self.scan,
            self.archive,
            threads=self.threads,
            resume=self.resume,
            overwrite=self.overwrite,
            quiet=self.quiet,
        )
        if self.plot is not None and not report.interrupted:
            from nlds_vines import figures

            figures.save(self.archive, self.plot, self.show)
        return report


def _command(argv: Sequence[str]) -> int:
    """Do what the arguments ask for; returns the exit status."""
    options = _parser().parse_args(argv)
    job = _job(options)
    if options.dry_run:
        return _dry_run(job)
    job.refuse_to_overwrite()
    return _run(job)


def _dry_run(job: _Job) -> int:
    from nlds_vines import engine

    print("\n".join(engine.estimate(job.scan, job.threads).lines()))
    return DONE


def _run(job: _Job) -> int:
    from nlds_vines import engine

    try:
        report = job.run()
    except engine.Interrupted as stop:
        complain(_NAME, str(stop))
        return INTERRUPTED
    if report.interrupted:
        complain(_NAME, report.summary())
        return INTERRUPTED
    if not job.quiet:
        print(report.summary())
        print(*filter(None, (job.archive, job.plot)), sep="\n")
    if report.failed_lanes:
        where = f"the dataset `status` of {job.archive} says why"
        complain(_NAME, f"{report.failed_lanes} of {job.scan.lanes} orbits failed: {where}")
        return LANES_FAILED
    return DONE


def _job(options: argparse.Namespace) -> _Job:
    """Return the job that the command line means."""
    source = None if options.scan is None else Path(options.scan)
    archive = _archive_path(options.output, source)
    scan = load_scan(source, changes(options), "command line")
    plot = options.plot
    if plot is None and source is None and _can_be_drawn(scan):
        plot = archive.parent / f"{archive.stem}.png"  # the embedded default is a figure
    return _Job(
        scan=scan,
        source=source,
        archive=archive,
        plot=None if plot is None else Path(plot),
        show=options.show,
        threads=options.threads,
        resume=options.resume,
        overwrite=options.overwrite,
        quiet=options.quiet,
    )


def _can_be_drawn(scan: Scan) -> bool:
    """Tell whether there will be something to draw: a map has no room for sections."""
    return len(scan.axes) == 1 or scan.want != ("section",)


def _archive_path(output: str | os.PathLike[str] | None, source: Path | None) -> Path:
    """Return the archive asked for, or the scan file's name with `.h5` in the current folder."""
    if output is not None:
        return Path(output)
    return Path(f"{_DEFAULT_STEM if source is None else source.stem}.h5")


def _parser() -> Parser:
    parser = Parser(
        prog=f"nlds-vines {_NAME}",
        description="Scan one parameter or two: an archive (HDF5) and a picture.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("scan", nargs="?", metavar="SCAN.toml", help="by default Figure 8")
    parser.add_argument("-o", "--output", metavar="FILE.h5", help="archive [SCAN.h5]")
    parser.add_argument("--plot", metavar="FILE", help="picture: .png, .pdf or .svg")
    parser.add_argument(
        "--show",
        metavar="WHAT",
        help="on a map: regimes, coexisting, shares, share:LABEL or a number",
    )
    add_scan_options(parser)
    _add_run_options(parser)
    return parser


def _add_run_options(parser: Parser) -> None:
    group = parser.add_argument_group("running")
    group.add_argument("--threads", type=int, metavar="N", help="by default all processors")
    existing = group.add_mutually_exclusive_group()
    existing.add_argument("--resume", action="store_true", help="continue an archive")
    existing.add_argument("--overwrite", action="store_true", help="replace an archive")
    group.add_argument("--dry-run", action="store_true", help="only say what it would take")
    group.add_argument("--quiet", action="store_true", help="show no progress")


class _CallableModule(ModuleType):
    """Module and function share the name `nlds_vines.bifurcation`: calling either is the same."""

    def __call__(self, *args: Any, **keywords: Any) -> Path:
        """Do as the function `bifurcation` does."""
        return bifurcation(*args, **keywords)


sys.modules[__name__].__class__ = _CallableModule

if __name__ == "__main__":
    sys.exit(main())
