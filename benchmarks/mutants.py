"""Mutants: change a source in one place at a time, and run the tests that must notice it.

    python -m benchmarks.mutants nlds_vines/archives/files.py tests/archives
    python -m benchmarks.mutants nlds_vines/runs/executors.py tests/runs --piece 2/4

Each comparison, sign, number, condition, returned value and call of the source is changed, in a
copy of the checkout. A change that no test notices shows that a test is missing or that the code
is not needed. Kernels run as plain Python, to the same bits: compiling a change takes a minute.
Exit status: 0 all are noticed, 1 one survives, 2 the request is wrong or the tests do not pass.
"""

from __future__ import annotations

import argparse
import ast
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

CHECKOUT = Path(__file__).resolve().parents[1]
COPIED = ("nlds_vines", "benchmarks", "tests", "paper", "data", "scans", "docs", "pyproject.toml")
LONGEST = 300.0
"""Time [s] of the tests of one mutant. One that takes longer counts as noticed: a loop that never
ends is an error, too."""

_SWAPPED = (
    (ast.Lt, ast.LtE), (ast.Gt, ast.GtE), (ast.Eq, ast.NotEq), (ast.Is, ast.IsNot),
    (ast.In, ast.NotIn), (ast.And, ast.Or), (ast.Add, ast.Sub), (ast.Mult, ast.Div),
)  # fmt: skip
_OTHER: dict[Any, Any] = dict(_SWAPPED) | {b: a for a, b in _SWAPPED}


@dataclass(frozen=True)
class Mutant:
    """A source in which the bytes from `begin` to `end` are replaced by `new`."""

    name: str
    begin: int
    end: int
    new: str

    def applied_to(self, text: str) -> str:
        data = text.encode()
        return (data[: self.begin] + self.new.encode() + data[self.end :]).decode()


def mutants_of(text: str, file: str) -> list[Mutant]:
    starts = [0]
    for line in text.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    mutants = []
    for node in _code(ast.parse(text)):
        if not isinstance(node, ast.expr | ast.stmt):
            continue
        for new in _changes(node):
            begin = starts[node.lineno - 1] + node.col_offset
            end = starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)
            old = " ".join((ast.get_source_segment(text, node) or "").split())
            name = f"{file}:{node.lineno}: {' '.join(new.split())} for {old}"
            mutants.append(Mutant(name[:120], begin, end, new))
    return sorted(mutants, key=lambda mutant: (mutant.begin, mutant.new))


def _code(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes that do something: no texts, annotations, imports and decorators."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list", "type_comment"):
            continue
        for node in value if isinstance(value, list) else [value]:
            if isinstance(node, ast.AST) and not isinstance(node, ast.JoinedStr | ast.Import):
                yield node
                yield from _code(node)


def _changes(node: ast.AST) -> Iterator[str]:
    """Yield replacements of an expression or a statement that mean something else."""
    match node:
        case ast.Compare(ops=[op]) if type(op) in _OTHER:
            other = ast.Compare(node.left, [_OTHER[type(op)]()], node.comparators)
            yield f"({ast.unparse(other)})"
        case ast.BoolOp() | ast.BinOp() if type(node.op) in _OTHER:
            fields = dict(ast.iter_fields(node)) | {"op": _OTHER[type(node.op)]()}
            yield f"({ast.unparse(type(node)(**fields))})"
        case ast.UnaryOp(op=ast.Not()):
            yield f"({ast.unparse(node.operand)})"
        case ast.Constant(value=bool() as value):
            yield str(not value)
        case ast.Constant(value=int() | float() as value):
            yield repr(value + 1)
        case ast.Return(value=ast.AST() as value):
            if not (isinstance(value, ast.Constant) and value.value is None):
                yield "return None"
        case ast.Expr(value=ast.Call()):
            yield "pass"


def failure(folder: Path, tests: Sequence[str]) -> str:
    """Return the line in which pytest, in a copy of the checkout, says what failed.

    Empty if all tests passed. Raises `RuntimeError` if no test ran.
    """
    options = ["-p", "no:cacheprovider", "-o", "addopts=", "-q", "-x", "-rfE", "--tb=no"]
    options += ["-W", "ignore::RuntimeWarning"]  # NumPy warns where compiled kernels do not
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("NUMBA_", "PYTEST_"))
    }
    environment |= {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    environment |= {"NUMBA_DISABLE_JIT": "1", "COLUMNS": "1000"}
    try:
        done = subprocess.run(
            [sys.executable, "-m", "pytest", *options, *tests],
            cwd=folder,
            env=environment,
            timeout=LONGEST,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"no end after {LONGEST:g} s"
    lines = [line for line in done.stdout.splitlines() if line.strip()] or ["no output"]
    reasons = [line for line in lines if line.startswith(("ERROR", "FAILED"))]
    if done.returncode not in (0, 1, 2):
        raise RuntimeError((reasons or lines)[-1])
    return (reasons or lines)[-1] if done.returncode else ""


def piece_of(text: str) -> slice:
    """Return the slice that `i/n` means: every n-th, beginning with the i-th."""
    index, _, count = text.partition("/")
    if not (index.isdecimal() and count.isdecimal() and 1 <= int(index) <= int(count)):
        raise argparse.ArgumentTypeError(f"{text!r} must be i/n with i from 1 to n")
    return slice(int(index) - 1, None, int(count))


def main(argv: list[str] | None = None) -> int:
    """Try the mutants, print those that survive, and return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mutants", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("source", help="a file of the checkout")
    parser.add_argument("tests", nargs="+", help="files, folders or names of tests")
    parser.add_argument("--piece", type=piece_of, default="1/1", metavar="I/N", help="every n-th")
    parser.add_argument("--list", action="store_true", help="only list them")
    options = parser.parse_args(argv)
    for path in (options.source, *(test.partition("::")[0] for test in options.tests)):
        if not (CHECKOUT / path).exists():
            parser.error(f"{path!r} is not in this checkout")
    text = (CHECKOUT / options.source).read_text(encoding="utf-8")
    mutants = mutants_of(text, options.source)[options.piece]
    if options.list:
        print(*(mutant.name for mutant in mutants), sep="\n")
        return 0
    began, alive = time.perf_counter(), 0
    with tempfile.TemporaryDirectory(prefix="mutants-") as place:
        folder = Path(place).resolve()
        made = "__pycache__", "_build", "_gallery"  # where other processes may write
        ignored = shutil.ignore_patterns(*made, "archives")
        for path in (CHECKOUT / name for name in COPIED if (CHECKOUT / name).exists()):
            if path.is_dir():
                is_package = path.name == "nlds_vines"  # whose archives are code
                ignore = shutil.ignore_patterns(*made) if is_package else ignored
                shutil.copytree(path, folder / path.name, ignore=ignore)
            else:
                shutil.copy(path, folder / path.name)
        if reason := failure(folder, options.tests):
            print(f"the tests do not pass without a change: {reason}", file=sys.stderr)
            return 2
        for mutant in mutants:
            (folder / options.source).write_text(mutant.applied_to(text), encoding="utf-8")
            if not failure(folder, options.tests):
                alive += 1
                print(f"survived: {mutant.name}", flush=True)
    seconds = time.perf_counter() - began
    print(f"{len(mutants)} mutants: {len(mutants) - alive} noticed, {alive} not; {seconds:.0f} s")
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
