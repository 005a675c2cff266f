"""The command of the mutants: try them one at a time, print a table of what became of them."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.mutants import MUTANTS
from benchmarks.mutants.by_rule import mutants_by_rule
from benchmarks.mutants.mutant import Mutant, StaleError, check
from benchmarks.mutants.trial import BaselineError, Outcome, Trial
from nlds_vines.cli import markdown_tables
from nlds_vines.cli.command_main import DONE, Command
from nlds_vines.cli.parser import Parser
from nlds_vines.errors import RequestError, shown

SURVIVORS = 1
"""Exit status where a mutant survives."""

CHECKOUT = Path(__file__).resolve().parents[2]

_EXAMPLES = """\
examples:
  python -m benchmarks.mutants
      try all of them
  python -m benchmarks.mutants --piece 2/4
      every fourth, beginning with the second
  python -m benchmarks.mutants --only "touch:" --only archive
      those whose name or file holds one of these texts
  python -m benchmarks.mutants --source nlds_vines/archives/durable.py --tests tests/archives
      in place of the list: each comparison, sign, number, condition or call of a source changed
exit status: 0 all are noticed; 1 one survives; 2 the request is wrong, or the list is stale
"""


def _carry_out(options: argparse.Namespace) -> int:
    mutants = _piece(_chosen(options), options.piece)
    try:
        check(mutants, CHECKOUT)
        if options.list:
            print(*(f"{m.name} ({m.file})" for m in mutants), sep="\n")
            return DONE
        began = time.perf_counter()
        found = list(_outcomes(mutants, options.quiet))
    except (StaleError, BaselineError) as error:
        raise RequestError(str(error)) from None
    print(*_table(found, time.perf_counter() - began), sep="\n")
    return DONE if all(outcome.noticed for outcome in found) else SURVIVORS


def _chosen(options: argparse.Namespace) -> list[Mutant]:
    """Return the mutants of a source, those that some texts name, or all of the list."""
    if (options.source is None) != (options.tests is None):
        raise RequestError("--source and --tests belong together")
    if options.source is None:
        return _named(options.only) if options.only else list(MUTANTS)
    for path in (options.source, options.tests.partition("::")[0]):
        if not (CHECKOUT / path).exists():
            raise RequestError(f"{shown(path)} is not in this checkout")
    return [*mutants_by_rule(options.source, CHECKOUT, options.tests)]


def _named(texts: Sequence[str]) -> list[Mutant]:
    """Return the mutants whose name or file holds one of some texts; each text must say some."""
    for text in texts:
        if not any(text in f"{m.name} {m.file}" for m in MUTANTS):
            raise RequestError(f"--only {shown(text)} is in no mutant's name; see --list")
    return [m for m in MUTANTS if any(text in f"{m.name} {m.file}" for text in texts)]


def _piece(mutants: list[Mutant], text: str) -> list[Mutant]:
    """Return the mutants of piece `i/n`: every n-th, beginning with the i-th."""
    index, _, count = text.partition("/")
    if not (index.isdecimal() and count.isdecimal() and 1 <= int(index) <= int(count)):
        raise RequestError(f"--piece {shown(text)} must be i/n with i from 1 to n")
    return mutants[int(index) - 1 :: int(count)]


def _outcomes(mutants: Sequence[Mutant], quiet: bool) -> Iterator[Outcome]:
    """Try mutants in a copy of the checkout and yield what becomes of each."""
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        trial = Trial(CHECKOUT, Path(folder))
        _say(quiet, f"{len(mutants)} mutants; first their tests without a change")
        trial.baseline(mutants)
        for number, mutant in enumerate(mutants, 1):
            outcome = trial.outcome(mutant)
            place = f"{number}/{len(mutants)} {outcome.verdict}, {outcome.seconds:.1f} s"
            _say(quiet, f"{place}: {mutant.name} {outcome.words}".rstrip())
            yield outcome


def _say(quiet: bool, text: str) -> None:
    """Print a line of progress."""
    if not quiet:
        print(text, file=sys.stderr, flush=True)


def _table(found: Sequence[Outcome], seconds: float) -> Iterator[str]:
    """Yield the lines of the report: a table of all outcomes, and their number."""
    rows = [(o.verdict, f"{o.seconds:.1f}", o.mutant.name, o.words) for o in found]
    yield from markdown_tables.table(("outcome", "s", "mutant", ""), rows, right={1}, padded=True)
    alive = sum(not outcome.noticed for outcome in found)
    yield ""
    yield f"{len(found)} mutants: {len(found) - alive} noticed, {alive} not; {seconds:.0f} s"


def _declare(parser: Parser) -> None:
    parser.add_argument("--only", action="append", metavar="TEXT", help="some of them; repeatable")
    parser.add_argument("--source", metavar="FILE", help="changes by rule of a source")
    parser.add_argument("--tests", metavar="PATH", help="what must notice these")
    parser.add_argument("--piece", default="1/1", metavar="I/N", help="the i-th of n pieces")
    parser.add_argument("--list", action="store_true", help="only list them")
    parser.add_argument("--quiet", action="store_true", help="no progress")


main = Command(
    name="python -m benchmarks.mutants",
    description="Small changes that make the sources wrong: the tests must notice each of them.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
).main
