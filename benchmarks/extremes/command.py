"""The command of the catalogue: check its entries, print the page of what was found."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from benchmarks import extremes
from benchmarks.pages import command_line, declare_page
from nlds_vines.archives.durable import write_text
from nlds_vines.cli.command_main import DONE, Command
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import check_writable

BROKEN = 1
"""Exit status where a promise is not kept."""

_NAME = "python -m benchmarks.extremes"
_EXAMPLES = """\
examples:
  python -m benchmarks.extremes
      what is promised about extreme numbers, and what was measured
  python -m benchmarks.extremes --long --markdown docs/extremes.md
      also what takes long, and the page of all of it
exit status: 0 every promise is kept; 1 one is not; 2 the request is wrong
"""


def _carry_out(options: argparse.Namespace) -> int:
    path = None if options.markdown is None else Path(options.markdown)
    if path is not None:
        check_writable("--markdown", path)
    entries = [entry for entry in extremes.CATALOGUE if options.long or not entry.long]
    if options.dry_run:
        print(*(f"{entry.number} {entry.name}" for entry in entries), sep="\n")
        return DONE
    found = []
    for entry, finding in extremes.findings(entries):
        found.append((entry, finding))
        if not options.quiet:
            place = f"{len(found)}/{len(entries)} {entry.number} {entry.name}"
            print(f"{place}: {finding.words}", file=sys.stderr, flush=True)
    lines = list(extremes.page(found))
    print(*lines, sep="\n")
    if path is not None:
        write_text(
            path, "\n".join([*lines, "", "```sh", command_line(_NAME, options.argv), "```", ""])
        )
    return DONE if all(finding.passed for _, finding in found) else BROKEN


def _declare(parser: Parser) -> None:
    parser.add_argument("--long", action="store_true", help="also what takes long")
    declare_page(parser)
    parser.add_argument("--dry-run", action="store_true", help="only say what would be checked")
    parser.add_argument("--quiet", action="store_true", help="no progress")


main = Command(
    name=_NAME,
    description="The catalogue of extremes: what is promised, and what was measured.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
).main
