"""Measure the basins of attraction in an archive.

As a command: `nlds-vines basins FILE.h5`.  In Python: `nlds_vines.basin_measures(archive)`.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from nlds_vines.cli.command_main import DONE, Command, say
from nlds_vines.cli.option_values import comma_separated, numbers_by_name
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import existing
from nlds_vines.errors import from_text

if TYPE_CHECKING:
    from nlds_vines.archives.view import ArchiveView

_NAME = "basins"
_SIDE = 20
_EXAMPLES = """\
examples:
  nlds-vines bifurcation --set omega=7.7 --vary x2_0=0.1:0.26:300 --vary v2_0=-1:1:300 \\
          --record attractor -o plane.h5
  nlds-vines basins plane.h5 --by 50,100
      shares, basin entropies and uncertainty exponent of the plane; who has arrived by 50 T
  nlds-vines bifurcation --vary omega=7.2:7.9:71 --start random:200 --record attractor -o shares.h5
  nlds-vines basins shares.h5
      the shares at each frequency; --at omega=7.7 gives their intervals
  nlds-vines continuation --along omega=7.2:7.9 -o branches.h5
  nlds-vines basins plane.h5 --edges branches.h5
      edge states as well: orbits with one unstable multiplier, between two basins
exit status: 0 done; 2 the request is wrong
"""


def _carry_out(options: argparse.Namespace) -> int:
    path, values = existing(options.archive), numbers_by_name("--at", options.at)
    times = [from_text(float, "--by", word) for word in comma_separated(options.by) or ()]
    from nlds_vines.archives.archive import read
    from nlds_vines.model.parameters import INITIAL
    from nlds_vines.transients.basin_shares import basin_measures, shares_along

    with read(path) as view:
        varied = [name for name in view.axes if name not in INITIAL and view[name].size > 1]
        if len(varied) == 1 and not values and options.edges is None:
            say(view.text("title"), *shares_along(view))
            return DONE
        found = basin_measures(view, options.box, **values)
        edges = [] if options.edges is None else _of_edges(view, options.edges, values)
    say(found.title, *found.lines(tuple(times)), *edges)
    return DONE


def _of_edges(view: ArchiveView, path: str, values: dict[str, float]) -> list[str]:
    """Return the lines on the edge states of a continuation."""
    from nlds_vines.upkeep.edge_states import edge_states, lines_of

    return [*lines_of(edge_states(view, path, values), view["component"].tolist())]


def _declare(parser: Parser) -> None:
    add = parser.add_argument
    add("archive", metavar="FILE.h5", help="of a scan that recorded attractor")
    add("--at", metavar="NAME=VALUE,...", help="the values of varied parameters")
    add("--box", type=int, default=_SIDE, metavar="CELLS", help=f"side of a box [{_SIDE}]")
    add("--edges", metavar="BRANCHES.h5", help="a continuation: its orbits on basin boundaries")
    add("--by", metavar="PERIODS,...", help="forcing periods by which orbits have arrived")


COMMAND = Command(
    name=_NAME,
    description="Measure the basins of attraction in an archive.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
