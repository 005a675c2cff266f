"""Repeat what an archive holds, and compare the results.

As a command: `nlds-vines rerun FILE.h5`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from nlds_vines.cli.command_main import DIFFERENT, DONE, LANES_FAILED, Command, say
from nlds_vines.cli.job import Job
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.run_options import RunOptions, add_run_options, run_options
from nlds_vines.errors import RequestError
from nlds_vines.runs.manifest import SCAN
from nlds_vines.runs.task_registry import TASKS, content_of

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
    if options.dry_run or how.shard is not None or status not in (DONE, LANES_FAILED):
        return status
    return max(status, _compared(source, output, how.quiet))


def _job(source: Path, output: Path, how: RunOptions) -> Job:
    """Return the job whose results an archive holds."""
    content = content_of(source)
    task = TASKS.get(content, TASKS[SCAN])
    if content != SCAN and task.reads and (how.shard is not None or how.scheduler is not None):
        raise RequestError(f"--shard and --scheduler are for scans: this is a {content}")
    task = task if task.reads else TASKS[SCAN]  # which says that this is none
    job: Job = task.part("command").Job(task.read(source).request, source, output, None, how)
    return job


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
    description="Repeat what an archive holds, and compare the results.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
