"""Measure error against run time on any system, and recommend a tolerance.

As a command: `python -m nlds_vines.accuracy`, or `nlds-vines accuracy`.
"""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.cli import running
from nlds_vines.cli.command import Command
from nlds_vines.cli.options import SET, SYSTEM, Parser
from nlds_vines.cli.terminal import DONE, say, table
from nlds_vines.errors import RequestError, at, from_text, shown, whole
from nlds_vines.model.catalog import as_preset, without_hosts
from nlds_vines.model.system import Preset
from nlds_vines.runs.progress import brief

if TYPE_CHECKING:
    from nlds_vines.accuracy.measure import Reference, Result

_DEFAULT = "ssul-set6"
_EXAMPLES = """\
examples:
  nlds-vines accuracy
      SSul NES Set 6 at omega = 6.28 rad/s, twenty periods from rest: both methods, and SciPy
  nlds-vines accuracy own.toml --set omega=6.9 --want 1e-6
      the same for the system of a scan, and the cheapest setting that is good to 1e-6
  nlds-vines accuracy --set E2=2.1e11 --plot stiff.png
      a stiff scene: the damper strikes steel
the table is Markdown; in a clone, `python -m benchmarks.accuracy` measures the solvers of others
exit status: 0 done; 2 the request is wrong; 130 interrupted, 143 terminated
"""


def declare_system(parser: Parser) -> None:
    """Declare the options that say which system is measured."""
    parser.add_argument("scan", nargs="?", metavar="SCAN.toml", help="whose system is taken")
    for option in (SYSTEM, SET):
        option.add(parser)


def system_of(options: Any) -> Preset:
    """Return the system of the options: of the catalog, or a scan's, in the middle of its axes."""
    settings = SET.read(options.set)["set"] if SET.read else {}
    if options.scan is None:
        with at("--system"):
            system = as_preset(options.system or _DEFAULT)
        with at("--set"):
            return system.with_(**settings)
    if options.system is not None:
        raise RequestError(
            f"{shown(options.scan)} and --system {options.system} exclude each other: give one"
        )
    scan = load_scan(options.scan)
    middle = {axis.name: float(axis.values[axis.values.size // 2]) for axis in scan.axes}
    return without_hosts(scan.system).with_(**(middle | settings))


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
    system = system_of(options)
    periods = whole("--periods", from_text(int, "--periods", options.periods or "20"), 2, 10_000)
    want = from_text(float, "--want", options.want or "1e-9")
    if not 0.0 < want < 1.0:
        raise RequestError(f"--want = {want:g} must lie between 0 and 1")
    plot = Path("accuracy.png" if options.plot is None else options.plot)
    running.refuse_same(running.optional_path(options.scan), plot)
    running.check_plot(plot)
    running.refuse_replacing("picture", plot, options.overwrite)
    from nlds_vines.accuracy.measure import measured, methods, reference

    contenders = methods(system, not options.no_peers)
    if options.dry_run:
        say(*(f"{system.name}: {method}" for method in contenders))
        return DONE
    from nlds_vines.accuracy.picture import draw
    from nlds_vines.engine.compilation import silent
    from nlds_vines.plotting.chosen_panels import save_figure
    from nlds_vines.runs.progress import Progress

    results: list[Result] = []
    count = sum(len(settings) for settings, _ in contenders.values())
    try:
        with silent(options.quiet):
            truth = reference(system, periods)
            with Progress(count, "setting", quiet=options.quiet) as progress:
                for result in measured(truth, contenders):
                    results.append(result)
                    progress.note(1, result.method)
    except KeyboardInterrupt as stop:
        raise type(stop)("what was measured is lost") from None
    title = f"{system.title or system.name}, ω = {system.parameters['omega']:g} rad/s, from rest"
    save_figure(draw(truth, results), plot, title, ("case", title))
    say(*lines(title, truth, results, want))
    return DONE


def lines(title: str, truth: Reference, results: Sequence[Result], want: float) -> Iterator[str]:
    """Yield the case and its reference, the table, and advice as scans and Python take it."""
    from nlds_vines.accuracy.measure import advised

    text = (
        f"{title}. Error of the state after {truth.periods} forcing periods, "
        f"CPU time of a period. Regime: {truth.label}. Reference: exact, refined; rk4 at "
        f"16384 steps is {truth.uncertainty:.0e} from it. A disturbance of the start has grown "
        f"{brief(truth.growth)} times by then."
    )
    yield from textwrap.wrap(text, 100)
    yield ""
    head = ("method", "setting", "error", "CPU per period")
    rows = []
    for one in results:
        setting = f"{one.setting:g} steps" if one.method == "rk4" else f"{one.setting:.0e}"
        numbers: tuple[str, ...] = (f"failed: {one.failure}",)
        if not one.failure:
            is_resolved = one.error > truth.uncertainty
            error = f"{one.error:.1e}" if is_resolved else f"< {truth.uncertainty:.0e}"
            numbers = error, f"{brief(1e6 * one.seconds)} us"
        rows.append((one.method, setting, *numbers))
    yield from table(head, rows, (2, 3))
    yield ""
    what, best = f"The cheapest setting with an error of at most {want:g}", advised(results, want)
    if best is None:
        yield f"{what}: none was measured."
    else:
        name = "period_steps" if best.method == "rk4" else "tolerance"
        code = f'`method = "{best.method}", {name} = {best.setting:g}`'
        yield f"{what}: {code} ({best.error:.1e} at {brief(1e6 * best.seconds)} us a period)."


main = Command(
    "accuracy",
    "Error against run time of our methods and of SciPy on one system.",
    _EXAMPLES,
    _declare,
    _carry_out,
).main
