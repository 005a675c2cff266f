"""Stiff contacts: error, cost and touches from soft rubber to beyond steel.

python -m benchmarks.stiffness --plot docs/stiffness.png --markdown docs/stiffness.md
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING

from benchmarks.pages import command_line, declare_page, page_writer
from nlds_vines.accuracy.command import Job, declare, periods_of, system_of
from nlds_vines.cli.command_main import Command
from nlds_vines.cli.parser import Parser
from nlds_vines.errors import RequestError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from nlds_vines.archives.archive import ArchiveView
    from nlds_vines.runs.survey import Survey

_NAME = "python -m benchmarks.stiffness"
_EXAMPLES = """\
examples:
  python -m benchmarks.stiffness -o stiffness.h5
      Young's modulus from 2e5 to 2.1e13 Pa and K from 1e4 to 1e16 N/m^1.5
exit status: 0 done; 2 the request is wrong;
130 interrupted, 143 terminated: --resume goes on with what it has kept
"""


def _declare(parser: Parser) -> None:
    declare(parser, "stiffness.h5")
    declare_page(parser)


def _carry_out(options: argparse.Namespace) -> int:
    system, periods = system_of(options), periods_of(options)
    if not system.scene.walls:
        raise RequestError(f"kind {system.kind!r} has no contact to make stiff")
    job = Job.of(options, "stiffness.h5")
    written = page_writer(options, job, command_line(_NAME, options.argv))

    def survey() -> Survey:
        from benchmarks.rivals import installed
        from benchmarks.stiffness.survey import stiffness

        return stiffness(system, periods, () if options.no_peers else installed())

    def lines(view: ArchiveView) -> Iterable[str]:
        from benchmarks.stiffness.table import page, read_stiffness

        return written(partial(page, read_stiffness(view)))

    def drawn(view: ArchiveView) -> Figure:
        from benchmarks.stiffness.table import read_stiffness, representatives
        from nlds_vines.accuracy.picture import draw

        return draw(view, methods=representatives(read_stiffness(view)))

    return job.run(survey, lines, options.dry_run, drawn)


main = Command(
    name=_NAME,
    description="Error and cost of every method and every rival as the contact gets stiffer.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
).main
