"""Mutants that nobody lists: each comparison, sign, number, condition or call of a source changed.

For sources beside the kernels, whose changes say little by themselves; `command` tries those of a
file, or a part of them, with the tests that are named beside it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.mutants.mutant import Mutant

_SWAPPED = (
    (ast.Lt, ast.LtE), (ast.Gt, ast.GtE), (ast.Eq, ast.NotEq), (ast.Is, ast.IsNot),
    (ast.In, ast.NotIn), (ast.And, ast.Or), (ast.Add, ast.Sub), (ast.Mult, ast.Div),
)  # fmt: skip
_OTHER: dict[Any, Any] = dict(_SWAPPED) | {b: a for a, b in _SWAPPED}


@dataclass(frozen=True)
class MutantByRule(Mutant):
    """A source in which what stands between two places (of its bytes) is replaced."""

    begin: int = 0
    end: int = 0

    def applied_to(self, text: str) -> str:
        """Return a source with the change."""
        data = text.encode()
        return (data[: self.begin] + self.new.encode() + data[self.end :]).decode()


def mutants_by_rule(file: str, checkout: Path, tests: str) -> Sequence[MutantByRule]:
    """Return the mutants of a file (from the root of the checkout), in the order of its text."""
    text = (checkout / file).read_text(encoding="utf-8")
    lines = [0]
    for line in text.encode().splitlines(keepends=True):
        lines.append(lines[-1] + len(line))
    found = []
    for node in _code(ast.parse(text)):
        if not isinstance(node, ast.expr | ast.stmt):
            continue
        for new in _changes(node):
            assert node.end_lineno is not None
            assert node.end_col_offset is not None
            begin = lines[node.lineno - 1] + node.col_offset
            end = lines[node.end_lineno - 1] + node.end_col_offset
            old = ast.get_source_segment(text, node) or ""
            name = f"{file}:{node.lineno}: {' '.join(new.split())} for {' '.join(old.split())}"
            found.append(MutantByRule(name[:120], file, old, new, (tests,), begin, end))
    return sorted(found, key=lambda mutant: (mutant.begin, mutant.new))


def _code(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield what a module does: no texts, annotations, imports and decorators."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list", "type_comment"):
            continue
        for node in value if isinstance(value, list) else [value]:
            if isinstance(node, ast.AST) and not isinstance(node, ast.JoinedStr | ast.Import):
                yield node
                yield from _code(node)


def _changes(node: ast.AST) -> Iterator[str]:
    """Yield what may stand in the place of an expression or a statement, and means another thing."""
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
