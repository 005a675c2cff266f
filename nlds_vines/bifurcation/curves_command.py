"""Response curves: `nlds-vines response-curves`, `nv.response_curves(["tmd", "own.toml"])`."""

from __future__ import annotations

import os
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from nlds_vines.bifurcation.blocks import blocks_of, refuse_without_room
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves import (
    CURVE_STARTS,
    SAMPLING,
    CurveRequest,
    ResponseCurves,
    Source,
    curves_from,
    curves_in,
)
from nlds_vines.cli import command as commands
from nlds_vines.cli.options import SET, VARY, Option
from nlds_vines.cli.running import add_run_options
from nlds_vines.engine.records import failures_in, failures_in_words
from nlds_vines.errors import choice
from nlds_vines.plotting.bands import refuse_undrawable
from nlds_vines.runs.run_options import RunOptions
from nlds_vines.scans.scan_job import ScanJob

_NAME = "response-curves"
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


def response_curves(
    source: Source = None,
    *,
    to: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    scheduler: str | None = None,
    executor: Executor | None = None,
    quiet: bool = False,
    **tables: Any,
) -> ResponseCurves:
    """Compute response curves of dampers and of the structure alone.

    Parameters
    ----------
    source : list, System, str, path-like, mapping, CurveRequest or None
        Systems or their names; the structure alone is added as the first curve.  The path of a
        request file with [[curves]], or its document; None for the dampers of the paper's Table 2.
    to : path-like, optional
        The archive (.h5).  Without it the results stay in memory.
    threads : int, optional
        By default one for each processor.
    resume, overwrite : bool
        Continue or replace an existing archive; not both.
    scheduler, executor : optional
        Who computes blocks of orbits, as in `scan`.
    quiet : bool
        Hide the progress bar.
    **tables
        Tables of a request file that override the source: `set={"P": 600.0}`,
        `vary={"omega": {"start": 5.0, "stop": 7.0, "num": 201}}`.

    Returns
    -------
    ResponseCurves
        The curves by name, with peaks and reductions.

    Raises
    ------
    RequestError
        If anything in the request is wrong, before anything is computed.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> curves = nv.response_curves(["tmd"], vary={"omega": {"values": [6.0, 6.5]}}, quiet=True)
    >>> [curve.name for curve in curves.curves]
    ['without damper', 'Tuned mass damper']
    """
    request = curves_from(source, tables, "response_curves")
    how = RunOptions(threads, resume, overwrite, None, scheduler, quiet, executor)
    result: ResponseCurves = Job.compute(request, source, to, how)
    return result


class Job(ScanJob):
    """A request of response curves and where its results go."""

    default: ClassVar[str] = f"{_NAME}.h5"
    is_named_after_source: ClassVar[bool] = True

    request: CurveRequest

    def compute_archive(self) -> Any:
        from nlds_vines.bifurcation.run import run

        return run(self.request, self.archive, self.how)

    @classmethod
    def read(cls, path: Path) -> Any:
        return curves_in(path)

    @classmethod
    def picture(cls) -> Any:
        from nlds_vines.bifurcation.picture.curves import PICTURE

        return PICTURE

    def check_picture(self) -> None:
        super().check_picture()
        refuse_undrawable(self.request.axis, self.request.values)

    def refuse(self) -> None:
        super().refuse()
        for case in self.request.cases:
            refuse_without_room(case.scan, self.archive)

    def failure(self, results: Any) -> str:
        if not isinstance(results, ResponseCurves):
            return super().failure(results)
        statuses = np.concatenate([curve.numbers["status"].ravel() for curve in results.curves])
        return failures_in_words(failures_in(statuses), self.request.lanes)

    def plan(self) -> list[str]:
        request, scan = self.request, self.request.cases[0].scan
        each = scan.transient + scan.periods
        return [
            request.title,
            *(f"curve:    {name}, {scan.lanes} orbits" for name in request.names),
            *(f"axis:     {axis.heading()}" for axis in scan.axes),
            f"periods:  {scan.transient} + {scan.periods} each, {request.lanes * each} in all",
            *self.share(blocks_of(request)),
            f"archive:  {self.archive}",
            *([] if self.plot is None else [f"picture:  {self.plot}"]),
        ]


main = commands.of_task(
    _NAME,
    curves_from,
    Job,
    ("CURVES.toml", "a request file, or a damper [those of the paper's Table 2]"),
    (
        Option(
            "--system",
            "NAME",
            "a damper: of the catalog, or a TOML file; once for each curve",
            lambda names: {"systems": names},
            repeated=True,
        ),
        SET,
        VARY,
        Option(
            "--start",
            "POLICY",
            "rest, up, down or both [rest]",
            lambda text: {"start": {"policy": choice("--start", text, CURVE_STARTS)}},
        ),
    ),
    (Scan, CurveRequest),
    but=("want", "effort", "signals"),
    usual=SAMPLING,
    add_run=partial(add_run_options, cluster=True),
    description="Response against frequency: dampers and the structure alone.",
    examples=_EXAMPLES,
    common="--output --plot --system --set --vary --start --show --log",
).main
