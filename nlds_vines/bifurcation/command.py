"""Scan one parameter or two: a bifurcation diagram or a map, in an archive and a picture.

As a command: `python -m nlds_vines.bifurcation`, or `nlds-vines bifurcation`.
In Python: `nlds_vines.scan(scan)`.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from nlds_vines.archives.archive import read
from nlds_vines.bifurcation import blocks
from nlds_vines.bifurcation.picture.choices import check_show, is_map, quantities, sample_panels
from nlds_vines.bifurcation.request import Scan, load_scan
from nlds_vines.bifurcation.result import ScanArchive, scan_in
from nlds_vines.cli import command as commands
from nlds_vines.cli.options import SAMPLES, SET, SYSTEM, VARY, Option, numbers
from nlds_vines.cli.running import add_run_options
from nlds_vines.engine.starts import STATE
from nlds_vines.errors import RequestError, choice, from_text
from nlds_vines.model.axis import samples_of
from nlds_vines.model.labels import KEPT
from nlds_vines.model.system import System
from nlds_vines.plotting.bands import refuse_undrawable
from nlds_vines.runs.progress import size
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.scans.block import counted
from nlds_vines.scans.run_report import Report
from nlds_vines.scans.scan_job import ScanJob

_MOST_PAIRS = 6  # of a label and that of the spectrum, in a line
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
      a map of regimes, and of how many coexist; `nlds-vines plot regimes.h5 --show settling`
      (or shares, or share:T,0) draws another picture of the same archive
  nlds-vines bifurcation --vary omega=7.2:7.8:601 --start both --record section,regime,lyapunov \\
          -o hysteresis.h5 --plot hysteresis.png
      up and down in two colors, the largest Lyapunov exponent below
exit status: 0 done; 1 finished, but some orbits failed; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on
"""


# public: its keywords are those of the command, more than eight
def scan(
    source: Scan | System | str | os.PathLike[str] | Mapping[str, Any] | None = None,
    *,
    to: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    scheduler: str | None = None,
    executor: Executor | None = None,
    quiet: bool = False,
    samples: Any = None,
    **tables: Any,
) -> ScanArchive:
    """Compute a scan: orbits over one parameter or two, or over a plane of initial conditions.

    Parameters
    ----------
    source : System, Scan, str, path-like, mapping or None
        A system or the name of one, the path of a scan file (TOML), its document as nested tables,
        or None for Figure 8 of the paper.
    to : path-like, optional
        The archive (.h5).  Without it the archive is deleted together with the result.
    threads : int, optional
        By default one for each processor.
    resume, overwrite : bool
        Continue or replace an existing archive; not both.
    scheduler : str, optional
        `local:N` for N processes here, or the address of a Dask scheduler.
    executor : concurrent.futures.Executor, optional
        Its workers compute blocks of orbits: processes, MPI, submitit.
    quiet : bool
        Hide the progress bar.
    samples : mapping of arrays, DataFrame or path-like, optional
        Sets of parameters, one a row, in place of `vary`; results have the dimension `sample`.
        A column is a parameter, a ratio or an initial condition.
    **tables
        Tables of a scan file that override the source: `vary={"omega": {"start": 5.0, "stop": 8.0,
        "num": 1201}}`, `sampling={"transient": 600}`; `record` may be a list of names, `start` the
        name of a policy.

    Returns
    -------
    ScanArchive
        The path of the archive, which can be read, drawn and opened with xarray.

    Raises
    ------
    RequestError
        If anything in the request is wrong, before anything is computed.

    See Also
    --------
    response_curves : Several dampers along one parameter.
    continue_branch : One periodic orbit along a parameter, stable or not.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> scan = nv.scan("tmd", vary={"omega": {"values": [6.0, 6.5]}}, record=["energy"], quiet=True)
    >>> with scan.read() as results:
    ...     results["E1max"].round(1).ravel().tolist()
    [492.3, 413.8]
    """
    document = dict(tables)
    if samples is not None:
        document["samples"] = samples_of(samples).columns
    if isinstance(document.get("record"), list | tuple):
        document["record"] = {"want": list(document["record"])}
    if isinstance(document.get("start"), str):
        document["start"] = {"policy": document["start"]}
    archive = ScanArchive.for_result(to, "scan", resume, overwrite)
    how = RunOptions(threads, resume, overwrite, None, scheduler, quiet, executor)
    Job.compute(load_scan(source, document, "scan"), source, archive, how)
    return ScanArchive.of(archive)


@dataclass(frozen=True)
class Job(ScanJob):
    """A scan and its files; `show` is the content of the picture, None for the default."""

    default: ClassVar[str] = "figure8.h5"
    is_named_after_source: ClassVar[bool] = True

    request: Scan
    show: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.show is not None:
            datasets = self.request.table.datasets
            spectral = self.request.spectral
            signals = () if spectral is None else tuple(spectral.signals)
            sampled = self.request.sampled
            scene = self.request.system.scene
            parts = signals, scene.dampers, self.request.of
            recorded = quantities(datasets.values(), scene.components, *parts)
            if sampled is not None:
                panels = sample_panels(recorded, sampled.names, "label" in datasets)
                for word in self.show.split(","):
                    choice("show", word.strip(), panels)
                return
            values = [axis.values for axis in self.request.axes]
            check_show(self.show, values, self.request.starts, recorded, "label" in datasets)

    @classmethod
    def from_options(cls, request: Scan, options: argparse.Namespace) -> Job:
        job: Job = super().from_options(request, options)
        if options.source or job.plot or job.how.shard or not _can_be_drawn(request):
            return job
        return replace(job, plot=job.archive.with_suffix(".png"))

    def check_picture(self) -> None:
        super().check_picture()
        if not _can_be_drawn(self.request):
            raise RequestError(
                "a map of want = ['section'] alone cannot be drawn; record energy or regime as well"
            )
        for axis in self.request.axes:
            refuse_undrawable(axis.name, axis.values)

    def refuse(self) -> None:
        super().refuse()
        blocks.refuse_without_room(self.request, self.archive)

    def results(self) -> Report:
        return self.compute_archive()

    def compute_archive(self) -> Report:
        from nlds_vines.bifurcation.run import run

        return run(self.request, self.archive, self.how)

    @classmethod
    def read(cls, path: Path) -> Any:
        return scan_in(path)

    @classmethod
    def picture(cls) -> Any:
        from nlds_vines.bifurcation.picture.drawing import PICTURE

        return PICTURE

    def draw(self, plot: Path, results: Report) -> None:
        self.picture().save(self.archive, plot, self.show, self.frequency, self.look)

    def plan(self) -> list[str]:
        scan = self.request
        grid = " x ".join(str(n) for n in scan.shape)
        each = scan.transient + scan.periods
        every = blocks.blocks_of(scan)
        ranges = [f"axis:     {axis.heading()}" for axis in scan.axes]
        if scan.sampled is not None:
            ranges = [f"sampled:  {line}" for line in scan.sampled.ranges()]
        return [
            scan.title,
            f"system:   {scan.system.parameters_in_words(scan.varied)}",
            *ranges,
            f"orbits:   {scan.lanes} ({grid} cells, {counted(scan.starts, 'start')} each)",
            f"periods:  {scan.transient} + {scan.periods} each, {scan.lanes * each} in all",
            f"results:  {size(scan.table.bytes(text=16))} before compression",
            f"memory:   {size(blocks.work_bytes(scan))} of results at a time, "
            f"{counted(len(every), 'block')}",
            *self.share(every),
        ]

    def lines(self, results: Report) -> list[str]:
        lines = super().lines(results)
        if self.request.system.scene.walls and results.labels.keys() == {"T,0"}:
            values = self.request.system.parameters_in_words(self.request.varied)
            lines.append(f"no orbit has an impact; {values}")  # they may not be as expected
        if "spectra_agree" in self.request.table.datasets and not results.missing:
            with read(self.archive) as view:
                agree, labels = view["spectra_agree"], view["label"]
                spectral = view["spectral_label"]
            which = agree == KEPT["no"]
            pairs = zip(labels[which].tolist(), spectral[which].tolist(), strict=True)
            counts = Counter(f"{label} with {says}" for label, says in pairs)
            words = [f"{count} {pair}" for pair, count in counts.most_common(_MOST_PAIRS)]
            line = f"spectra disagree: {which.sum()} of {(agree >= 0).sum()} orbits"
            line += f": {', '.join(words)}" if words else ""
            lines.append(line + (", ..." if len(counts) > _MOST_PAIRS else ""))
        return lines


def _can_be_drawn(scan: Scan) -> bool:
    if scan.sampled is not None:
        return bool({*scan.want} - {"section"})
    return not is_map([axis.values for axis in scan.axes]) or scan.want != ("section",)


def start_of(text: str) -> dict[str, Any]:
    """Parse --start: rest, up, down, random:N or a state, with an optional @PHASE."""
    text, at, phase = text.partition("@")
    if at and not text:
        raise RequestError(f"--start @{phase}: a state or rest stands before the @")
    policy, _, count = text.partition(":")
    if "," in text:
        start: dict[str, Any] = {"policy": STATE, "state": numbers(f"--start {text}", text)}
    elif policy == "random":
        start = {"policy": policy, "count": from_text(int, "N of --start random:N", count)}
    else:
        start = {"policy": text}
    if at:
        start["phase"] = from_text(float, f"--start {text}@{phase}", phase)
    return {"start": start}


main = commands.of_task(
    "bifurcation",
    load_scan,
    Job,
    ("SCAN.toml", "by default Figure 8"),
    (
        Option("--show", "WHAT", "regimes, coexisting, shares, share:LABEL, numbers as x2,E1max"),
        SYSTEM,
        SET,
        VARY,
        SAMPLES,
        Option(
            "--start",
            "POLICY",
            "rest, up, down, both, random:N, x1,v1,x2,v2; @PHASE after it",
            start_of,
        ),
    ),
    (Scan,),
    add_run=partial(add_run_options, cluster=True),
    description="Scan one parameter or two: an archive (HDF5) and a picture.",
    examples=_EXAMPLES,
    common="--output --plot --system --set --vary --start --record --resume",
).main
