"""The command `nlds-vines report`: the results in an archive as one page (.html) to send."""

from __future__ import annotations

import argparse
from pathlib import Path

from nlds_vines.archives.archive import read
from nlds_vines.archives.files import write_text
from nlds_vines.cli import running
from nlds_vines.cli.command import Command
from nlds_vines.cli.options import FREQUENCY, Parser
from nlds_vines.cli.terminal import DONE, say
from nlds_vines.errors import RequestError, choice
from nlds_vines.model.ratios import UNITS
from nlds_vines.upkeep.explore import holds_map, refuse_without_bokeh
from nlds_vines.upkeep.tasks import ENSEMBLE, job_for

_EXAMPLES = """\
examples:
  nlds-vines report map.h5 -o map.html
      the map of an archive: hover, click and the arrow keys show what is stored of a cell
  nlds-vines report map.h5 --branches curves.h5 -o map.html
      with the branches and special points of a continuation over it
  nlds-vines report suite.h5 -o suite.html
      of all other archives - response histories, response curves, tunings, branches, transients,
      portraits, samples: what was asked, the systems drawn, tables, pictures, assumptions
The page is one file, opens without a network, and prints.  That of a map has 5 MB at most and
needs the extra `explore`: pip install 'nlds-vines[explore]'
exit status: 0 done; 2 the request is wrong
"""


def _carry_out(options: argparse.Namespace) -> int:
    source, branches = Path(options.source), running.optional_path(options.branches)
    output = Path(options.output or f"{source.name.removesuffix('.h5')}.html")
    for path in filter(None, (source, branches)):
        running.refuse_same(running.existing(path), output)
    running.check_writable("output", output)
    running.refuse_replacing("output", output, options.overwrite)
    with read(source) as view:
        is_of_starts = job_for(view) is ENSEMBLE
    if is_of_starts or not holds_map(source):
        return _send(options, source, output)
    refuse_without_bokeh("report")
    if options.frequency is not None:
        choice("--frequency", options.frequency, UNITS)
    from nlds_vines.explore.map_data import stored

    results = stored(source, options.frequency)
    if options.dry_run:
        say(f"{results.scan.title}: {results.scan.lanes} orbits into {output}")
        return DONE
    from nlds_vines.explore.report_page import branches_of, report_page

    continued = None if branches is None else branches_of(branches, results.scan)
    report = report_page(results, continued)
    write_text(output, report.html)
    if not options.quiet:
        say(f"{output}: {report.size / 1e6:.1f} MB. {report.left_out}")
    return DONE


def _send(options: argparse.Namespace, source: Path, output: Path) -> int:
    """Write the page of an archive that is no map."""
    for option, value in (("--branches", options.branches), ("--frequency", options.frequency)):
        if value is not None:
            raise RequestError(f"{option} is for the page of a map; {source} has none")
    if options.dry_run:
        with read(source) as view:
            title = view.text("title")
        say(f"{title}: into {output}")
        return DONE
    from nlds_vines.explore.sent_page import sent_page

    page = sent_page(source)
    write_text(output, page)
    if not options.quiet:
        say(f"{output}: {len(page.encode()) / 1e6:.1f} MB")
    return DONE


def _declare(parser: Parser) -> None:
    add = parser.add_argument
    add("source", metavar="FILE.h5", help="the archive")
    add("-o", "--output", metavar="PAGE.html", help="[FILE.html]")
    add("--branches", metavar="FILE.h5", help="a continuation, drawn over the map")
    FREQUENCY.add(parser)
    add("--overwrite", action="store_true", help="replace a page")
    add("--dry-run", action="store_true", help="only say what would be done")
    add("--quiet", action="store_true", help="say nothing")


main = Command(
    "report",
    "Results as one page to send; on that of a map, clicks and keys show what every cell stores.",
    _EXAMPLES,
    _declare,
    _carry_out,
).main
