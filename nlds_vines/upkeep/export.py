"""An archive as comma-separated values: `nlds-vines export FILE.h5`."""

from __future__ import annotations

import argparse
from pathlib import Path

from nlds_vines.archives.archive import read
from nlds_vines.cli import running
from nlds_vines.cli.command import Command
from nlds_vines.cli.options import Parser
from nlds_vines.cli.terminal import DONE, say
from nlds_vines.errors import RequestError, shown

SUFFIXES = (".csv", ".txt")  # the file name extensions that the command can write

_EXAMPLES = """\
examples:
  nlds-vines export figure8.h5
      figure8.csv: one row for each orbit, with every dataset that has one value for it
  nlds-vines export figure8.h5 section label -o sections.csv
      a row for each sampled period: x1, v1, x2, v2, and the label of the orbit
  nlds-vines export continuation.h5 points
      a row for each point of the branches; special: for each special point
exit status: 0 done; 2 wrong request, file error or too little memory
"""


def _carry_out(options: argparse.Namespace) -> int:
    source = running.existing(options.file)
    target = source.with_suffix(".csv") if options.output is None else Path(options.output)
    if target.suffix.lower() not in SUFFIXES:
        raise RequestError(f"output {shown(str(target))} must end in {' or '.join(SUFFIXES)}")
    running.check_writable("output", target)
    running.refuse_same(source, target)
    running.refuse_replacing("output", target, options.overwrite)
    with read(source) as view:
        view.to_csv(target, *options.dataset, overwrite=options.overwrite)
    if not options.quiet:
        say(target)
    return DONE


def _declare(parser: Parser) -> None:
    add = parser.add_argument
    add("file", metavar="FILE.h5", help="the archive")
    add(
        "dataset",
        nargs="*",
        metavar="DATASET",
        help="by default all with a value for each orbit; or points, special",
    )
    add("-o", "--output", metavar="FILE.csv", help="the table [FILE.csv]")
    add("--overwrite", action="store_true", help="replace a file")
    add("--quiet", action="store_true", help="do not print the name of the written file")


main = Command(
    "export", "Write an archive as comma-separated values.", _EXAMPLES, _declare, _carry_out
).main
