"""Repeat what an archive holds, and compare the results.

As a command: `nlds-vines rerun FILE.h5`.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines.archives.provenance import SCAN
from nlds_vines.cli.command import TASKS, Command, Job, content_of
from nlds_vines.cli.options import Parser
from nlds_vines.cli.running import RunOptions, add_run_options, run_options
from nlds_vines.cli.terminal import DIFFERENT, DONE, ORBITS_FAILED, say
from nlds_vines.errors import RequestError

if TYPE_CHECKING:
    from nlds_vines.archives.archive import ArchiveView

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
    """Repeat what an archive holds, and compare; return the exit status."""
    source, how = Path(options.file), run_options(options)
    output = Path(options.output or f"{source.stem}-rerun.h5")
    job = _job(source, output, how)
    status = job.carry_out(_NAME, options.dry_run)
    if options.dry_run or how.shard is not None or status not in (DONE, ORBITS_FAILED):
        return status
    return max(status, _compared(source, output, how.quiet))


def _job(source: Path, output: Path, how: RunOptions) -> Job:
    """Return the job whose results an archive holds."""
    content = content_of(source)
    task = TASKS.get(content, TASKS[SCAN])
    if content != SCAN and task.reads and (how.shard is not None or how.scheduler is not None):
        raise RequestError(f"--shard and --scheduler are for scans: this is a {content}")
    task = task if task.reads else TASKS[SCAN]  # which says that this is none
    job: Job = task.part(task.command).Job(task.read(source).request, source, output, None, how)
    return job


def differing(one: Path, other: Path) -> list[str]:
    """Return the names of the datasets whose bits differ between two archives."""
    from nlds_vines.archives.archive import read

    with read(one) as a, read(other) as b:
        return [name for name in sorted({*a.names, *b.names}) if not _are_equal(a, b, name)]


def _are_equal(a: ArchiveView, b: ArchiveView, name: str) -> bool:
    """Return True if a dataset is in both archives with the same bits; so NaN equals NaN."""
    if name not in a or name not in b or a.shape(name) != b.shape(name):
        return False
    x, y = a[name], b[name]
    return (
        x.tolist() == y.tolist() if a.describe(name).dtype == "str" else x.tobytes() == y.tobytes()
    )


def _compared(old: Path, new: Path, quiet: bool) -> int:
    names = differing(old, new)
    if names:
        say(f"results differ: {', '.join(names)}")
    elif not quiet:
        say("the results are the same")
    return DIFFERENT if names else DONE


def _declare(parser: Parser) -> None:
    parser.add_argument("file", metavar="FILE.h5", help="the archive to repeat")
    parser.add_argument("-o", "--output", metavar="NEW.h5", help="archive [FILE-rerun.h5]")
    add_run_options(parser, cluster=True)


COMMAND = Command(
    name=_NAME,
    description="Repeat what an archive holds, and compare the results.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
