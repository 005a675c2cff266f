"""Response curves of dampers beside each other, and of the structure alone.

As a command: `nlds-vines response-curves`; in Python: `nv.response_curves(["tmd", "own.toml"])`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.files import read_toml
from nlds_vines.bifurcation.blocks import refuse_without_room
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves.request import (
    ALONE_COLOR,
    CURVE_STARTS,
    CurvePage,
    label_of,
    turns,
    with_structure_alone,
)
from nlds_vines.bifurcation.response_curves.request_file import load_page
from nlds_vines.cli import job as jobs
from nlds_vines.cli.command_main import Command
from nlds_vines.cli.option_values import settings_of, varied
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import (
    request_path,
)
from nlds_vines.cli.run_options import RunOptions, add_local_options
from nlds_vines.cli.setting_options import add_settings, changed
from nlds_vines.errors import RequestError, at, choice, shown
from nlds_vines.model.catalog import load_system
from nlds_vines.model.parameters import PARAMETERS
from nlds_vines.model.system import System
from nlds_vines.model.words import range_in_words, setting_in_words, system_in_words
from nlds_vines.plotting.bands import refuse_undrawable

if TYPE_CHECKING:
    from nlds_vines.bifurcation.response_curves.result import ResponseCurves

USUAL = ("ssul-set6", "ssbl", "tmd")
"""The dampers that are compared unless others are named: those of the paper's Table 2."""

SAMPLING = {"transient": 600, "periods": 240}
"""Forcing periods discarded and sampled: long, for the sake of irregular regimes."""

_VARY = {"omega": {"start": 4.5, "stop": 8.0, "num": 351}}

Source = str | os.PathLike[str] | System | Sequence[Any] | Mapping[str, Any] | CurvePage | None
"""What may stand for a page: systems or their names, a file, the document in one."""


def add_curve_options(parser: Parser) -> None:
    """Declare the options that say what is computed."""
    group = parser.add_argument_group("options that override the request file")
    group.add_argument(
        "--system", action="append", default=[], metavar="NAME", dest="systems",
        help="a damper: of the catalog, or a TOML file; once for each curve",
    )  # fmt: skip
    group.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="of all curves, SI units"
    )
    group.add_argument("--vary", metavar="NAME=START:STOP:NUM", help="[omega=4.5:8:351]")
    group.add_argument("--start", metavar="POLICY", help="rest, up, down or both [rest]")
    add_settings(group, Scan, CurvePage, but=("want", "effort", "signals"), usual=SAMPLING)


def changes(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the options change in a request file, as a document of the same form."""
    if options.start is not None:
        choice("--start", options.start, CURVE_STARTS)
    found: dict[str, Any] = {
        "set": settings_of(options),
        "vary": varied([options.vary] if options.vary else [], log=False),
        "start": {} if options.start is None else {"policy": options.start},
        **changed(options, Scan, CurvePage),
    }
    return {key: value for key, value in found.items() if value}


def page_from(
    source: Source, systems: Sequence[str | System], above: Mapping[str, Any], where: str
) -> CurvePage:
    """Return the page of a source with the structure alone in each panel, checked throughout.

    Arguments: the `source`; `systems` that replace its curves; `above`, a document of changes, and
    `where` they come from, for messages.

    Raises `RequestError`, one line that names place, key, value and what is allowed.
    """
    if isinstance(source, CurvePage) and not (systems or above):
        return source
    if isinstance(source, CurvePage) or _is_document(source):
        document: Any = source.document() if isinstance(source, CurvePage) else source
        if systems:
            above = {**above, "curves": _curves(systems), "panels": [{}]}
        page = load_page(document, above, where)
    else:
        chosen = systems or _as_systems(source)
        page = load_page(_document(chosen), above, where)
        if "title" not in above:
            page = replace(page, title=_made_up_title(page, above.get("set", {})))
    return with_structure_alone(page)


def _is_document(source: Source) -> bool:
    """Tell whether a source is a page, in a file or as nested tables, and not a system."""
    if isinstance(source, Mapping):
        return True
    if not isinstance(source, str | os.PathLike) or not str(source).endswith(".toml"):
        return False
    return "curves" in read_toml(Path(source))


def _as_systems(source: Source) -> Sequence[str | System]:
    """Return the systems that a source names; the usual ones for None."""
    if source is None:
        return USUAL
    if isinstance(source, str | os.PathLike | System):
        return [source if isinstance(source, System) else str(source)]
    if isinstance(source, Sequence):
        return list(source)
    raise RequestError(f"{shown(source)} is no system, no list of systems and no page of curves")


def _document(systems: Sequence[str | System]) -> dict[str, Any]:
    """Return the request file of a page that nobody wrote."""
    return {
        "vary": _VARY,
        "sampling": SAMPLING,
        "record": {"want": ["impacts", "energy"]},
        "figure": {"reduction": True},
        "curves": _curves(systems),
    }


def _curves(systems: Sequence[str | System]) -> list[dict[str, Any]]:
    """Return the tables [[curves]] of systems, each with a color and a line of its own."""
    found = []
    for number, name in enumerate(systems):
        with at("--system"):
            system = name if isinstance(name, System) else load_system(name)
        color, line = turns(number) if system.scene.damper else (ALONE_COLOR, "solid")
        found.append(
            {
                "system": system,
                "label": system_in_words(system),
                "color": color,
                "line": line,
            }
        )
    return found


def _made_up_title(page: CurvePage, settings: Mapping[str, Any]) -> str:
    """Return a title made of what is set and of what varies."""
    words = [setting_in_words(*item) for item in settings.items() if item[0] in PARAMETERS]
    return ", ".join(["Response curves", *words, range_in_words(page.axis, page.values)])


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


def response_curves(
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
    page = page_from(source, (), tables, "response_curves")
    archive = ArchivePath.for_result(to, "response-curves", resume, overwrite)
    how = RunOptions(threads, resume, overwrite, quiet=quiet)
    return Job(page, request_path(source), archive, None, how).run()


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

    def inside(self) -> list[str]:
        """Return a line on starts inside a wall for each curve that has any."""
        return [
            f"{label_of(curve)}: {line}"
            for curve in self.request.curves
            for line in curve.scan.starts_inside()
        ]

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
