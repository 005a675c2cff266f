"""One orbit in full, as one page: histories, phase planes, forces, energies, spectrum.

As a command: `python -m nlds_vines.portrait`, or `nlds-vines portrait`.
In Python: `nlds_vines.orbit_portrait(system)`.
"""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nlds_vines.archives.archive import ArchivePath
from nlds_vines.cli import command as commands
from nlds_vines.cli import running
from nlds_vines.cli.options import SET, SYSTEM, Option, comma_separated, numbers, numbers_by_name
from nlds_vines.cli.terminal import ORBITS_FAILED, complain
from nlds_vines.errors import RequestError, shown, table, whole
from nlds_vines.model.look import USUAL_LOOK
from nlds_vines.model.setting import settings_of
from nlds_vines.model.signals import SIGNALS
from nlds_vines.model.system import System
from nlds_vines.portrait.request import (
    EXPONENTS,
    PANELS,
    PortraitRequest,
    Times,
    load_portrait,
    portrait_of,
    span,
)
from nlds_vines.runs.executors import most_threads
from nlds_vines.runs.run_options import RunOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from nlds_vines.portrait.result import Portrait

_NAME = "portrait"
_EXAMPLES = f"""\
panels: {", ".join(PANELS)}
signals: {", ".join(SIGNALS)}

examples:
  nlds-vines portrait --set omega=7.45
      SSul NES Set 6 at 7.45 rad/s, 240 periods after the first 600: portrait.png
  nlds-vines portrait --system ssbl --panels relative,force,phase2 --plot ssbl.pdf
      only these panels, as vectors
  nlds-vines portrait --set omega=7.575 --set K=2.5e7 --windows 20:60,3000:3012 \\
          --plot phases.png
      two windows of one run, side by side: before and after a chaotic transient
  nlds-vines portrait scans/figure10.toml --samples 2048
      a request file; options override it
  nlds-vines portrait --set omega=7.45 -o orbit.h5 --csv orbit.csv
      histories, section, impacts and spectrum in an archive, the histories as CSV, too
  nlds-vines portrait regimes.h5 --at omega=7.4,P=600 --start 2 --plot cell.png
      the orbit of a cell of a scan, from the third of its starts; the same to the last bit
exit status: 0 done; 1 the orbit could not be followed; 2 the request is wrong; 130 interrupted
"""


def orbit_portrait(
    source: PortraitRequest | System | str | os.PathLike[str] | Mapping[str, Any] | None = None,
    *,
    to: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    quiet: bool = False,
    **options: Any,
) -> Figure:
    """Follow an orbit and draw its portrait: histories, phase planes, forces, energies, spectrum.

    Parameters
    ----------
    source : System, str, path-like, mapping or PortraitRequest, optional
        A system or its name; the path of a request file (.toml) or its content; or the path of a
        scan's archive (.h5), with `at` and `start` among the options.  By default SSul NES Set 6.
    to : path-like, optional
        A picture (.png, .pdf, .svg) to save, or an archive (.h5) of histories, section, impacts and
        spectrum, from which the figure is then drawn.
    overwrite : bool, optional
        Replace an archive, or the picture of another request.
    quiet : bool, optional
        Do not say that kernels are compiled.
    **options
        The settings of the request:

        - `windows`, pairs (begin, end) of forcing periods, or `transient` and `periods`;
        - `panels`, `show`, `samples`, `method`, `tolerance`, `signal`, `taper`, `comb`,
          `section_phase`; `of`, the displacements of a host that are drawn;
        - `start`, (x1, v1, x2, v2) [m, m/s], of a host its components; of an archive, the
          number or the name of a start;
        - `at`, of an archive: the values of the varied parameters by name.

    Returns
    -------
    matplotlib.figure.Figure
        The page.

    Raises
    ------
    RequestError
        If an argument is invalid, before anything is computed.
    IntegrationError
        If the orbit ends early.

    See Also
    --------
    nlds_vines.simulate : The orbit as arrays.
    nlds_vines.classify : Its regime, with the evidence.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> figure = nv.orbit_portrait(
    ...     "ssul-set6", panels=["relative", "phase2"], transient=20, periods=4, quiet=True
    ... )
    >>> [axes.get_label() for axes in figure.axes]
    ['relative', 'phase2']
    """
    if isinstance(source, PortraitRequest):
        if options:
            names = ", ".join(options)
            raise RequestError(f"{names} given beside a PortraitRequest: they stand in it already")
        request = source
    else:
        sampling = {*settings_of(Times, "sampling"), *settings_of(PortraitRequest, "sampling")}
        changes: dict[str, Any] = {k: options.pop(k) for k in ("at", "start") if k in options}
        for name, value in options.items():  # what is no setting is refused in [portrait]
            table = "sampling" if name in sampling else "portrait"
            changes.setdefault(table, {})[name] = value
        request = _load(source, changes, "orbit_portrait")
    path = running.optional_path(to, "to")
    archive, plot = (path, None) if _is_archive(path) else (None, path)
    how = RunOptions(overwrite=overwrite, quiet=quiet)
    target = ArchivePath.for_result(archive, _NAME)
    result: Portrait = Job(request, running.request_path(source), target, plot, how).run()
    from nlds_vines.plotting.chosen_panels import let_figures_be_shown

    let_figures_be_shown()
    return result.page


@dataclass(frozen=True)
class Job(commands.Job):
    """A portrait, of which an unnamed archive is written only to export histories to `csv`."""

    request: PortraitRequest
    csv: Path | None = None
    exponents: int = 0

    @classmethod
    def from_options(cls, request: PortraitRequest, options: argparse.Namespace) -> Job:
        if options.resume and options.output is None:
            raise RequestError("--resume is for an archive: name it by -o FILE.h5")
        name = _NAME if options.source is None else Path(options.source).stem
        if _is_archive(options.source):
            start = [] if options.start is None else [f"start={options.start}"]
            cell = [name, *(comma_separated(options.at or "") or ["cell"]), *start]
            name = re.sub(r"[^\w.=+-]", "_", "-".join(cell))
        periods = options.exponents or "0"
        if periods != "0":
            whole("--exponents", int(periods) if periods.isdigit() else periods, 16, 10**7)
        options.plot = options.plot or f"{name}.png"
        options.csv, options.exponents = running.optional_path(options.csv), int(periods)
        job: Job = super().from_options(request, options)
        return job

    def carry_out(self, name: str, dry_run: bool) -> int:
        if dry_run:
            return super().carry_out(name, dry_run)
        from nlds_vines.engine.one_orbit import IntegrationError

        try:
            return super().carry_out(name, dry_run)
        except IntegrationError as error:
            complain(name, str(error))
            return ORBITS_FAILED

    def __post_init__(self) -> None:
        if ArchivePath.of(self.archive).named is None:  # the picture replaces its own earlier one
            how = replace(self.how, resume=not self.how.overwrite)
            object.__setattr__(self, "how", how)
        super().__post_init__()
        if self.exponents and EXPONENTS in self.request.panels:
            raise RequestError(
                f"--exponents {self.exponents} beside the panel exponents, which computes them, "
                "too: give one of them"
            )
        if self.csv is not None:
            if self.csv.suffix.lower() != ".csv":
                raise RequestError(f"--csv {shown(str(self.csv))} must end in .csv")
            running.check_writable("--csv", self.csv)

    def others(self) -> Sequence[Path | None]:
        return (self.csv,)

    def refuse(self) -> None:
        super().refuse()
        running.refuse_replacing("--csv", self.csv, self.how.overwrite)

    def results(self) -> Portrait:
        from nlds_vines.portrait.result import Portrait, histories_in
        from nlds_vines.portrait.run import views_of

        if ArchivePath.of(self.archive).named is None and self.csv is None:
            views = views_of(self.request, quiet=self.how.quiet)
            return Portrait(None, tuple(views), self.request)
        results: Portrait = super().results()
        if self.csv is not None:
            with results.archive.read() as view:
                view.to_csv(self.csv, *histories_in(view), overwrite=self.how.overwrite)
        return results

    def compute_archive(self) -> Any:
        from nlds_vines.portrait.run import run

        return run(self.request, self.archive, self.how)

    @classmethod
    def read(cls, path: Path) -> Any:
        from nlds_vines.portrait.result import portrait_in

        return portrait_in(path)

    @classmethod
    def picture(cls) -> Any:
        from nlds_vines.portrait.picture import PICTURE

        return PICTURE

    def lines(self, results: Portrait) -> list[str]:
        lines = super().lines(results)
        if self.exponents:
            from nlds_vines.engine.classification import lyapunov_spectrum

            ends = {view.column.system.name: view for view in results.views}  # of the last windows
            for name, view in ends.items():
                start, quiet = view.section[-1], self.how.quiet
                spectrum = lyapunov_spectrum(view.column.system, start, self.exponents, quiet)
                rows = "; ".join(f"{words} {text}" for words, text in spectrum.outline())
                lines.append(f"{name}: Lyapunov {rows}")
        return lines

    def draw(self, plot: Path, results: Portrait) -> None:
        from nlds_vines.plotting.chosen_panels import save_figure
        from nlds_vines.plotting.page import page_of, set_title
        from nlds_vines.portrait.picture import portrait

        figure = results.page
        if self.look != USUAL_LOOK:
            page = page_of(self.look.columns, self.look.width)
            figure = portrait(results.drawn_from, results.views, page)
            if self.look.title is not None:
                set_title(figure, self.look.title)
        save_figure(figure, plot, self.request.title, ("recipe_hash", self.request.hash))

    def plan(self) -> list[str]:
        lines = [self.request.title]
        for run in self.request.runs():
            begin, end = span(run)
            states = (end - begin) * self.request.samples
            windows = ", ".join(f"{c.window.begin} to {c.window.end}" for c in run)
            lines.append(
                f"{run[0].system.name}: {end} periods from "
                f"{'rest' if self.request.start is None else self.request.start}; "
                f"{states} states from period {begin} on; drawn: {windows}"
            )
        files = {"archive": ArchivePath.of(self.archive).named, "histories": self.csv}
        files |= {"picture": self.plot}
        lines.append(f"panels: {', '.join(self.request.panels)}")
        return [*lines, *(f"{name}: {path}" for name, path in files.items() if path)]

    def paths(self) -> list[str]:
        files = ArchivePath.of(self.archive).named, self.csv, self.plot
        return [str(path) for path in files if path]


def _is_archive(source: object) -> bool:
    return isinstance(source, str | os.PathLike) and Path(source).suffix in running.ARCHIVE_SUFFIXES


def _load(source: Any, changes: dict[str, Any], changes_from: str) -> PortraitRequest:
    """Return the request of a file, or of a cell of an archive, with `changes`.

    For an archive, `at` names the cell and `start` the orbit; otherwise `start` is a state or rest.
    """
    values = changes.pop("at", None)
    if _is_archive(source):
        most_threads()
        from nlds_vines.bifurcation.result import cell_orbit

        values = {} if values is None else table("at", values)
        cell = cell_orbit(str(source), values, changes.pop("start", "0"))
        if "f" in values:
            changes["portrait"] = {"frequency": "Hz", **changes.get("portrait", {})}
        return portrait_of(cell, changes, changes_from)
    if values is not None:
        raise RequestError(f"--at {shown(values)}: give the archive of a scan, FILE.h5, with it")
    if "start" in changes:
        start = changes["start"]
        if isinstance(start, str) and start != "rest":
            start = numbers("--start", start)
        elif isinstance(start, np.ndarray):
            start = start.tolist()
        elif isinstance(start, Collection) and not isinstance(start, str):
            start = list(start)
        is_rest = start is None or start == "rest"
        changes["start"] = {"policy": "rest"} if is_rest else {"state": start}
    return load_portrait(source, changes, changes_from)


main = commands.of_task(
    _NAME,
    _load,
    Job,
    ("FILE", "PORTRAIT.toml or SCAN.h5 [SSul NES Set 6]"),
    (
        Option(
            "--at",
            "NAME=VALUE,...",
            "of SCAN.h5: the cell nearest to these values",
            lambda text: {"at": numbers_by_name("--at", text)},
        ),
        Option("--csv", "FILE.csv", "the histories, a row for each state [none]"),
        Option("--exponents", "PERIODS", "Lyapunov spectrum over so many further periods [none]"),
        SYSTEM,
        SET,
        Option(
            "--start",
            "X1,V1,X2,V2",
            "state at t = 0 [m, m/s], or rest; of SCAN.h5: number",
            lambda text: {"start": text},
        ),
    ),
    (Times, PortraitRequest),
    add_run=partial(running.add_run_options, threads=False),
    description="One orbit in full: histories, phase planes, forces, energies, spectrum.",
    examples=_EXAMPLES,
    common="--output --plot --system --set --start --windows --panels --at",
).main
