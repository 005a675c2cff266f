"""What an archive holds repeated, and the results compared: `nlds-vines rerun FILE.h5`."""

from __future__ import annotations

import argparse
from pathlib import Path

from nlds_vines.archives.archive import ArchiveView, read
from nlds_vines.archives.provenance import SCAN
from nlds_vines.cli.command import Command
from nlds_vines.cli.options import Parser
from nlds_vines.cli.running import add_run_options, run_options
from nlds_vines.cli.terminal import DIFFERENT, DONE, ORBITS_FAILED, say
from nlds_vines.errors import RequestError
from nlds_vines.scans.scan_job import ScanJob
from nlds_vines.upkeep.tasks import JOBS

_EXAMPLES = """\
examples:
  nlds-vines rerun figure8.h5
      compute it again into figure8-rerun.h5, and compare
  nlds-vines rerun map.h5 -o again.h5 --scheduler local:8
exit status: 0 done, and the results are the same; 1 they are not, or some orbits failed; 2 the
request is wrong; 130 interrupted, 143 terminated: --resume goes on
"""


def _carry_out(options: argparse.Namespace) -> int:
    source, how = Path(options.file), run_options(options)
    output, content = Path(options.output or f"{source.stem}-rerun.h5"), SCAN
    if source.is_file():
        with read(source) as view:
            content = view.content
    make_job = JOBS.get(content, JOBS[SCAN])  # a scan's says that anything else is none
    is_shared = how.shard is not None or how.scheduler is not None
    if is_shared and not issubclass(make_job, ScanJob):
        raise RequestError(f"--shard and --scheduler are for scans: this is a {content}")
    job = make_job(make_job.read(source).request, source, output, None, how)
    status = job.carry_out("rerun", options.dry_run)
    if options.dry_run or how.shard is not None or status not in (DONE, ORBITS_FAILED):
        return status
    names = differing(source, output)
    if names:
        say(f"results differ: {', '.join(names)}")
        return max(status, DIFFERENT)
    if not how.quiet:
        say("the results are the same")
    return status


def differing(one: Path, other: Path) -> list[str]:
    """Return the names of the datasets whose bits differ between two archives."""

    def bits(view: ArchiveView, name: str) -> object:
        values = view[name]
        return values.tolist() if view.describe(name).dtype == "str" else values.tobytes()

    with read(one) as a, read(other) as b:
        names = {*a.names, *b.names}
        alike = {name for name in {*a.names} & {*b.names} if a.shape(name) == b.shape(name)}
        return sorted(names - {name for name in alike if bits(a, name) == bits(b, name)})


def _declare(parser: Parser) -> None:
    parser.add_argument("file", metavar="FILE.h5", help="the archive to repeat")
    parser.add_argument("-o", "--output", metavar="NEW.h5", help="archive [FILE-rerun.h5]")
    add_run_options(parser, cluster=True)


main = Command(
    "rerun",
    "Repeat what an archive holds, and compare the results.",
    _EXAMPLES,
    _declare,
    _carry_out,
).main
