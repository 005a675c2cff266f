"""Response curves of dampers beside each other, and of the structure alone.

As a command: `nlds-vines response-curves`.  In Python: `nv.curves(["tmd", "my-damper.toml"])`.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.archives.archive_path import ArchivePath
from nlds_vines.bifurcation.memory_and_disk import refuse_without_room
from nlds_vines.bifurcation.response_curves.curve_options import (
    Source,
    add_curve_options,
    changes,
    page_from,
)
from nlds_vines.bifurcation.response_curves.request import CurvePage, label_of
from nlds_vines.cli import job as jobs
from nlds_vines.cli.command_main import Command
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import (
    optional_path,
    request_path,
)
from nlds_vines.cli.run_options import RunOptions, add_local_options
from nlds_vines.errors import typed
from nlds_vines.plotting.bands import refuse_undrawable

if TYPE_CHECKING:
    from nlds_vines.bifurcation.response_curves.result import ResponseCurves

_NAME = "response-curves"
_DEFAULT = "response-curves.h5"
_EXAMPLES = """\
examples:
  nlds-vines response-curves --plot curves.png
      the dampers of the paper's Table 2 and the structure alone, from 4.5 to 8 rad/s
  nlds-vines response-curves --system tmd --system ssul-set6 --set P=600 \\
          --vary omega=5:7.5:251 -o weak.h5 --plot weak.pdf
      two dampers under a weaker force
  nlds-vines response-curves --show x1_max,a1_max,stroke_max,force_max --log --plot frf.png
      displacement, acceleration, stroke and the force in the wall
  nlds-vines response-curves --system ssul-set6 --start both --plot both.png
      sweeps up and down, shaded where they differ
  nlds-vines response-curves scans/figure2a.toml -o sets.h5 --plot sets.png
      a request file: copy one of `scans`, name your own systems in its [[curves]]
exit status: 0 done; 1 finished, but some orbits failed; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on
"""


@typed
def curves(
    source: Source = None,
    *,
    to: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = False,
    **tables: Any,
) -> ResponseCurves:
    """Compute response curves of dampers and of the structure alone, and return them.

    Arguments:
        source: a list of systems or of their names, one of these, the path of a request file with
            [[curves]], the document in one, a `CurvePage`, or None for the paper's dampers.
        to: the archive (.h5); None for one that is gone with what is returned.
        threads: how many; by default as many as the machine has processors.
        resume, overwrite: continue or replace an archive that exists; not both.
        quiet: whether to show no progress.
        tables: tables of a request file laid over the source, as `vary={"omega": {"start": 5.0,
            "stop": 7.0, "num": 201}}`, `set={"P": 600.0}`.

    Raises `RequestError` where anything asked for is wrong, before anything is computed.
    """
    page = page_from(source, (), tables, "curves")
    archive = ArchivePath.for_result(to, "curves", resume, overwrite)
    how = RunOptions(threads, resume, overwrite, quiet=quiet)
    return Job(page, request_path(source), archive, None, how).run()


@typed
def response_curves(
    source: Source = None,
    output: str | os.PathLike[str] = _DEFAULT,
    *,
    plot: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    quiet: bool = True,
    **tables: Any,
) -> ResponseCurves:
    """Compute response curves by the name that `curves` had; it goes with version 0.2.

    Arguments: as `curves`, whose `to` is called `output` here; a picture to `plot`.
    """
    page = page_from(source, (), tables, "response_curves")
    how = RunOptions(threads, resume, overwrite, quiet=quiet)
    return Job(page, request_path(source), Path(output), optional_path(plot), how).run()


class Job(jobs.Job):
    """A page of curves and where it goes."""

    request: CurvePage

    def check_picture(self) -> None:
        """Raise `RequestError` for values that cannot be drawn."""
        refuse_undrawable(self.request.axis, self.request.values)

    def refuse(self, dry_run: bool = False) -> None:
        """Raise `RequestError` as any job, and where the curves do not fit the machine."""
        super().refuse(dry_run)
        for curve in self.request.curves:
            refuse_without_room(curve.scan, self.archive)

    def failure(self, found: ResponseCurves) -> str:
        """Return how many orbits failed, why, and what helps."""
        import numpy as np

        from nlds_vines.archives.archive import read
        from nlds_vines.bifurcation.response_curves.curves_table import STATUSES
        from nlds_vines.orbits.status_words import failures_in, failures_in_words

        with read(self.archive) as view:
            names = [name for name in STATUSES if name in view.names]
            failures = failures_in(np.concatenate([view[name].ravel() for name in names]))
            return failures_in_words(failures, self.request.lanes)

    def plan(self) -> list[str]:
        """Return what would be done, one fact a line."""
        page, scan = self.request, self.request.curves[0].scan
        curves = [f"curve:    {label_of(c)}, {c.scan.lanes} orbits" for c in page.curves]
        each = scan.transient + scan.periods
        return [
            page.title,
            *curves,
            f"periods:  {scan.transient} + {scan.periods} each, {page.lanes * each} in all",
            f"archive:  {self.archive}",
            *([] if self.plot is None else [f"picture:  {self.plot}"]),
        ]


def _carry_out(options: argparse.Namespace) -> int:
    page = page_from(options.source, options.systems, changes(options), "command line")
    files = jobs.files_of(options, jobs.named_after(options.source, _DEFAULT))
    return Job(page, **files).carry_out(_NAME, options.dry_run)


def _declare(parser: Parser) -> None:
    text = "a page of curves, or a damper [those of the paper's Table 2]"
    jobs.add_files(parser, "CURVES.toml", text, _DEFAULT)
    add_curve_options(parser)
    add_local_options(parser)


COMMAND = Command(
    name=_NAME,
    description="Largest energies against frequency: dampers and the structure alone.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
