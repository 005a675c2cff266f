"""Scan one parameter or two: a bifurcation diagram or a map, in an archive and a picture.

As a command: `python -m nlds_vines.bifurcation`, or `nlds-vines bifurcation`.
In Python: `nlds_vines.bifurcation(scan)`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.bifurcation.options import add_scan_options, changes
from nlds_vines.bifurcation.picture.choices import check_show
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.bifurcation.room import refuse_without_room
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import check_plot, check_writable, refuse_existing
from nlds_vines.cli.run_options import RunOptions, add_run_options, run_options
from nlds_vines.cli.running import DONE, LANES_FAILED, complain, run_command
from nlds_vines.errors import RequestError, shown
from nlds_vines.orbits.labels import FLAGS, KEPT
from nlds_vines.orbits.status_words import OK
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.runs.shard import Shard

if TYPE_CHECKING:
    from nlds_vines.archives.archive import ArchiveView
    from nlds_vines.bifurcation.run import Report


_NAME = "bifurcation"
_DEFAULT_STEM = "figure8"
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
exit status: 0 done; 1 finished, but some orbits failed; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on
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
    shard: str | None = None,
    scheduler: str | None = None,
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
        shard: `3/7` computes the third of seven shares, into parts that `nlds-vines consolidate`
            makes an archive of.
        scheduler: `local:N`, or the address of a Dask scheduler whose workers are to compute.
        quiet: whether to show no progress.

    Raises `RequestError` where anything asked for is wrong, before anything is computed.
    """
    source = Path(scan) if isinstance(scan, str | os.PathLike) else None
    share = None if shard is None else Shard.parse(shard)
    job = Job(
        scan=load_scan(scan),
        source=source,
        archive=_archive_path(output, source),
        plot=None if plot is None else Path(plot),
        how=RunOptions(threads, resume, overwrite, share, scheduler, quiet),
        show=show,
    )
    job.refuse()
    job.run()
    return job.archive


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with the arguments `argv` (the process's own if None).

    Returns the exit status: 0 done, 1 some orbits failed, 2 the request is wrong, 130 interrupted,
    143 terminated.
    """
    return run_command(_NAME, _command, argv)


@dataclass(frozen=True)
class Job:
    """A scan, where it goes and how it runs; checked when made, before anything heavy is loaded."""

    scan: Scan
    source: Path | None
    archive: Path
    plot: Path | None
    how: RunOptions
    show: str | None = None

    def __post_init__(self) -> None:
        """Raise `RequestError` unless everything can be written where it shall go."""
        check_writable("output", self.archive)
        if self.plot is not None:
            self._check_plot(self.plot)
        if self.show is not None:
            names = list(self.scan.table.datasets)
            check_show(self.show, len(self.scan.axes), self.scan.starts, names)
        for path in filter(None, (self.source, self.plot)):
            if path.resolve() == self.archive.resolve():
                raise RequestError(f"output {shown(str(self.archive))} is another file of this run")

    def _check_plot(self, plot: Path) -> None:
        check_plot(plot)
        if self.how.shard is not None:
            raise RequestError(
                f"--plot {shown(str(plot))}: a shard makes no archive to draw; "
                "--resume --plot draws what `nlds-vines consolidate` has made"
            )
        if not _can_be_drawn(self.scan):
            raise RequestError(
                f"--plot {shown(str(plot))}: a map of want = ['section'] alone cannot be "
                "drawn; record energy or regime as well"
            )

    def refuse(self) -> None:
        """Raise `RequestError` where the archive exists and it was not said what to do with it.

        And where a scan cannot fit into memory or onto the disk.
        """
        refuse_existing(self.archive, resume=self.how.resume, overwrite=self.how.overwrite)
        refuse_without_room(self.scan, self.archive)

    def run(self) -> Report:
        """Compute the scan, draw the picture, and return its report."""
        from nlds_vines.bifurcation.run import run

        report = run(self.scan, self.archive, **vars(self.how))
        if self.plot is not None:
            from nlds_vines.bifurcation.picture.drawing import save

            save(self.archive, self.plot, self.show)
        return report


def carry_out(name: str, job: Job, dry_run: bool) -> int:
    """Do a job for the command `name`, or only say what it would take; returns the exit status."""
    if dry_run:
        return _dry_run(job)
    job.refuse()
    return _run(name, job)


def _command(argv: Sequence[str]) -> int:
    """Do what the arguments ask for; returns the exit status."""
    options = _parser().parse_args(argv)
    return carry_out(_NAME, _job(options), options.dry_run)


def _dry_run(job: Job) -> int:
    refuse_without_room(job.scan, job.archive)
    from nlds_vines.bifurcation.estimate import estimate

    print("\n".join(estimate(job.scan, job.how.threads).lines()))
    return DONE


def _run(name: str, job: Job) -> int:
    try:
        report = job.run()
    except Interrupted as stop:
        complain(name, str(stop))
        return stop.status
    if not job.how.quiet:
        print(report.summary())
        print(*_refined(job), *_made(job), sep="\n")
    if report.failed_lanes:
        where = f"the dataset `status` of {job.archive} says why"
        complain(name, f"{report.failed_lanes} of {report.lanes} orbits failed: {where}")
        return LANES_FAILED
    return DONE


def _refined(job: Job) -> list[str]:
    """Return how the results stand up to refinement, in one line, where that was asked for."""
    if "error" not in job.scan.want or job.how.shard is not None:
        return []
    from nlds_vines.archives import archive

    with archive.read(job.archive) as view:
        return [summary(view)]


def _made(job: Job) -> list[str]:
    """Return where the results are, one line each."""
    if job.how.shard is not None:
        return [f"when all shards are there: nlds-vines consolidate {job.archive}"]
    return [str(path) for path in (job.archive, job.plot) if path is not None]


def _job(options: argparse.Namespace) -> Job:
    """Return the job that the command line means."""
    source = None if options.scan is None else Path(options.scan)
    archive = _archive_path(options.output, source)
    scan, how = load_scan(source, changes(options), "command line"), run_options(options)
    plot = options.plot
    if plot is None and source is None and how.shard is None and _can_be_drawn(scan):
        plot = archive.parent / f"{archive.stem}.png"  # the embedded default is a figure
    return Job(scan, source, archive, None if plot is None else Path(plot), how, options.show)


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
    add_run_options(parser)
    return parser


_SETTLED = (FLAGS["periodic"], FLAGS["transient_chaos"])  # ends of orbits that are known


def summary(view: ArchiveView) -> str:
    """Return in one line how the results of a scan stand up to refinement."""
    sound = view["status"] == OK
    error, words = view["error"], []
    which = sound
    if "label_kept" in view:
        changed = np.count_nonzero(view["label_kept"] == KEPT["no"])
        words.append(f"{changed} of {np.count_nonzero(sound)} orbits change their label")
        which = sound & np.isin(view["regime"], _SETTLED)
    known = error[which & np.isfinite(error)]
    if known.size:
        of = " of settled ones" if "label_kept" in view else ""
        words.append(f"largest error{of} over a period {known.max():.1e} (m, m/s)")
    if lost := np.count_nonzero(sound & np.isnan(view["error_at_end"])):
        words.append(f"{lost} of them fail")
    return f"refined: {', '.join(words)}" if words else "refined: no orbit to compare"
