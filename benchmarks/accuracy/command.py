"""Error against run time with every rival that is installed.

python -m benchmarks.accuracy own.toml --set omega=6.9
python -m benchmarks.accuracy --suite --plot docs/accuracy.png --markdown docs/accuracy.md
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import replace
from functools import partial

from benchmarks.pages import command_line, declare_page, page_writer
from nlds_vines.accuracy.command import Job, declare, periods_of, system_of
from nlds_vines.archives.archive import ArchiveView
from nlds_vines.cli.command_main import Command
from nlds_vines.cli.parser import Parser
from nlds_vines.errors import RequestError
from nlds_vines.runs.survey import Survey

_NAME = "python -m benchmarks.accuracy"
_EXAMPLES = """\
examples:
  python -m benchmarks.accuracy own.toml --set omega=6.9
  python -m benchmarks.accuracy --suite -o accuracy.h5 --plot accuracy.png --markdown accuracy.md
      five cases: soft, steel, two walls, near grazing, no contact
exit status: 0 done; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on with what it has kept
"""


def _declare(parser: Parser) -> None:
    declare(parser)
    parser.add_argument("--suite", action="store_true", help="five cases that stand for all")
    declare_page(parser)


def _carry_out(options: argparse.Namespace) -> int:
    if options.suite and (options.scan or options.system or options.set):
        raise RequestError("--suite has cases of its own: leave out the system and --set")
    system, periods = system_of(options), periods_of(options)

    def survey() -> Survey:
        from benchmarks.accuracy.cases import known_truth, suite
        from benchmarks.rivals import installed
        from benchmarks.rivals.rival import contenders_of
        from nlds_vines.accuracy.measure import comparison
        from nlds_vines.accuracy.measured_cases import Case

        cases = suite() if options.suite else [Case.of(system)]
        rivals = () if options.no_peers else installed()
        others = [entry for rival in rivals for entry in contenders_of(rival)]
        versions = {rival.name: rival.version() or "-" for rival in rivals}
        cases = [replace(case, periods=periods) for case in cases]
        return comparison(cases, others, versions, known_truth)

    job = Job.of(options, "accuracy.h5")
    written = page_writer(options, job, command_line(_NAME, options.argv))

    def lines(view: ArchiveView) -> Iterable[str]:
        from benchmarks.accuracy.page import page
        from nlds_vines.accuracy.measured_cases import read_cases

        return written(partial(page, read_cases(view), every=not options.suite))

    return job.run(survey, lines, options.dry_run)


main = Command(
    name=_NAME,
    description="Error against run time of every method and every rival that is installed.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
).main
