"""Error against run time on a system of one's own, and what tolerance to take.

As a command: `python -m nlds_vines.accuracy`, or `nlds-vines accuracy`.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.bifurcation.request_file import load_scan
from nlds_vines.cli.command_main import DONE, Command, say
from nlds_vines.cli.option_values import add_system_options, chosen_system, settings_of
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import check_plot, optional_path, refuse_replacing, refuse_same
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.errors import RequestError, from_text, shown, whole

if TYPE_CHECKING:
    from nlds_vines.model.system import System

_DEFAULT = "ssul-set6"
_EXAMPLES = """\
examples:
  nlds-vines accuracy
      SSul NES Set 6 at omega = 6.28 rad/s, twenty periods from rest: both methods, and SciPy
  nlds-vines accuracy own.toml --set omega=6.9 --want 1e-6
      the same for a system of your own, and the cheapest setting that is good to 1e-6
the table is Markdown; in a clone, `python -m benchmarks.accuracy` measures the solvers of others
exit status: 0 done; 2 the request is wrong; 130 interrupted, 143 terminated
"""


def declare_system(parser: Parser) -> None:
    """Declare the options that say which system is measured."""
    parser.add_argument("scan", nargs="?", metavar="SCAN.toml", help="whose system is taken")
    add_system_options(parser, f"of the catalog, or a TOML file [{_DEFAULT}]")


def _declare(parser: Parser) -> None:
    declare_system(parser)
    parser.add_argument("--periods", metavar="N", help="after which errors are taken [20]")
    parser.add_argument("--no-peers", action="store_true", help="our own methods only")
    parser.add_argument("--want", metavar="ERROR", help="of the setting that is advised [1e-9]")
    parser.add_argument("--plot", metavar="FILE.png|pdf|svg", help="[accuracy.png]")
    parser.add_argument("--overwrite", action="store_true", help="replace the picture")
    parser.add_argument("--dry-run", action="store_true", help="only list the methods")
    parser.add_argument("--quiet", action="store_true", help="show no progress")


def _carry_out(options: argparse.Namespace) -> int:
    system, periods = system_of(options), periods_of(options)
    want = from_text(float, "--want", options.want or "1e-9")
    if not 0.0 < want < 1.0:
        raise RequestError(f"--want = {want:g} must lie between 0 and 1")
    plot = Path("accuracy.png" if options.plot is None else options.plot)
    refuse_same(optional_path(options.scan), plot)
    check_plot(plot)
    refuse_replacing("picture", plot, RunOptions(overwrite=options.overwrite))
    from nlds_vines.accuracy.measure import comparison, contenders
    from nlds_vines.accuracy.measured_cases import Case

    case = Case.of(system, periods)
    methods = contenders(case, not options.no_peers)
    if options.dry_run:
        say(*(f"{case.name}: {method}" for method in methods))
        return DONE
    from nlds_vines.accuracy.picture import draw
    from nlds_vines.accuracy.tables import lines
    from nlds_vines.orbits.compilation import silent
    from nlds_vines.plotting.save import save_figure

    try:
        with silent(options.quiet):
            result = comparison(case, methods, options.quiet)
    except KeyboardInterrupt as stop:
        raise type(stop)("what was measured is lost") from None
    save_figure(draw(result), plot, case.title, ("case", case.title))
    say(*lines(result, want))
    return DONE


def system_of(options: Any) -> System:
    """Return the system asked for: of the catalog, or a scan's, in the middle of its axes."""
    if options.scan is None:
        return chosen_system(options, _DEFAULT)
    if options.system is not None:
        raise RequestError(
            f"{shown(options.scan)} and --system {options.system} exclude each other: give one"
        )
    scan = load_scan(options.scan)
    middle = {axis.name: float(axis.values[axis.values.size // 2]) for axis in scan.axes}
    return scan.system.with_(**(middle | settings_of(options)))


def periods_of(options: Any) -> int:
    """Return the periods asked for."""
    given = from_text(int, "--periods", options.periods or "20")
    return whole("--periods", given, 2, 10_000)


main = Command(
    name="accuracy",
    description="Error against run time of our methods and of SciPy on one system.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
).main
