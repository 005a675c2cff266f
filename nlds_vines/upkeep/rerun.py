"""Repeat a scan, a continuation or response curves from the archive, and compare the results.

As a command: `nlds-vines rerun FILE.h5`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from nlds_vines.bifurcation.archived import scan_in
from nlds_vines.bifurcation.command import Job, carry_out
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.run_options import RunOptions, add_run_options, run_options
from nlds_vines.cli.running import DIFFERENT, DONE, LANES_FAILED, Command, say
from nlds_vines.errors import RequestError
from nlds_vines.runs.manifest import CONTINUATION, RESPONSE_CURVES, SCAN

_NAME = "rerun"
_EXAMPLES = """\
examples:
  nlds-vines rerun figure8.h5
      compute it again into figure8-rerun.h5, and compare
  nlds-vines rerun map.h5 -o again.h5 --scheduler local:8
exit status: 0 done, and the results are the same; 1 they are not, or some orbits failed; 2 the
request is wrong; 130 interrupted, 143 terminated: --resume goes on
"""


def _carry_out(options: argparse.Namespace) -> int:
    """Repeat a scan and compare; return the exit status."""
    source, how = Path(options.file), run_options(options)
    output = Path(options.output or f"{source.stem}-rerun.h5")
    content = _content_of(source)
    if content == CONTINUATION:
        return _continued_again(source, output, how, options.dry_run)
    if content == RESPONSE_CURVES:
        return _curves_again(source, output, how, options.dry_run)
    job = Job(scan_in(source), source, output, None, how)
    status = carry_out(_NAME, job, options.dry_run)
    if options.dry_run or how.shard is not None or status not in (DONE, LANES_FAILED):
        return status
    return max(status, _compared(source, output, how.quiet))


def _content_of(path: Path) -> str:
    """Return the kind of request whose results an archive holds; that of a scan if it is none."""
    if not path.is_file():
        return SCAN
    from nlds_vines.archives import archive

    with archive.read(path) as view:
        return view.content


def _continued_again(source: Path, output: Path, how: RunOptions, dry_run: bool) -> int:
    """Repeat the continuation in an archive, and compare; return the exit status."""
    from nlds_vines.continuation.command import Job as Continue
    from nlds_vines.continuation.result import continued

    if how.shard is not None or how.scheduler is not None:
        raise RequestError("--shard and --scheduler are for scans: this is a continuation")
    job = Continue(continued(source).request, source, output, None, None, how)
    if dry_run:
        job.refuse(dry_run=True)
        say(*job.plan())
        return DONE
    job.run()
    return _compared(source, output, how.quiet)


def _curves_again(source: Path, output: Path, how: RunOptions, dry_run: bool) -> int:
    """Repeat the response curves in an archive, and compare; return the exit status."""
    from nlds_vines.response_curves.command import Job as Curves
    from nlds_vines.response_curves.result import curves_in

    if how.shard is not None or how.scheduler is not None:
        raise RequestError("--shard and --scheduler are for scans: these are response curves")
    job = Curves(curves_in(source).request, source, output, None, how)
    if dry_run:
        job.refuse(dry_run=True)
        say(*job.plan())
        return DONE
    job.run()
    return _compared(source, output, how.quiet)


def _compared(old: Path, new: Path, quiet: bool) -> int:
    from nlds_vines.upkeep.diff import compare

    found = compare(old, new)
    if found.different or not quiet:
        say(*found.lines())
    return DIFFERENT if found.different else DONE


def _declare(parser: Parser) -> None:
    parser.add_argument("file", metavar="FILE.h5", help="the archive to repeat")
    parser.add_argument("-o", "--output", metavar="NEW.h5", help="archive [FILE-rerun.h5]")
    add_run_options(parser)


COMMAND = Command(
    name=_NAME,
    description="Repeat a scan, a continuation or response curves, and compare the results.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
