"""A compiler pass that removes branches decided by the types of a kernel's arguments.

An absent part is None, and a law is the type of its wall. Whether an argument, or a field of an
argument that is a tuple, is None (`x is None`), of a type (`is_a`) or a wall of a law with a
property (`says`) is known when a kernel is compiled. The other branch is removed before type
inference, so that the two branches may differ in type, and no code of an absent part is compiled.
"""

from __future__ import annotations

import operator
import sys
from collections.abc import Iterator
from typing import Any

from numba.core import analysis, ir, ir_utils, types
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.consts import ConstantInference
from numba.core.untyped_passes import IRProcessing


def is_a(part: object, sort: type) -> bool:
    return isinstance(part, sort)


CHOSEN = tuple(
    f"{__name__.rsplit('.', 2)[0]}.{name}"
    for name in ("laws.", "hosts.host_space", "hosts.host_orbit", "hosts.host_impact")
)
"""The beginnings of the names of the modules of laws, and of those of the flow of hosts."""


def law_of(sort: Any) -> Any:
    """Return the module of the law of a sort of walls, or of hosts' flow; None of anything else."""
    name = getattr(sort, "__module__", "")
    return sys.modules[name] if name.startswith(CHOSEN) else None


def says(part: object, word: str) -> bool:
    """Return True if a part is a wall whose law has a property: a constant of that name."""
    return hasattr(law_of(type(part)), word)


def laws_among(kinds: Any) -> Iterator[Any]:
    """Yield the laws of all walls among some types, and among their fields."""
    for kind in kinds:
        if law := law_of(getattr(kind, "instance_class", None)):
            yield law
        yield from laws_among(getattr(kind, "types", ()))


def same_sort(part: object, other: object) -> bool:
    """Return True if two tuples are of one type, so that one variable can hold either."""
    if not (isinstance(part, tuple) and isinstance(other, tuple)):
        return False
    absent = [[number is None for number in numbers] for numbers in (part, other)]
    return type(part) is type(other) and absent[0] == absent[1]


@register_pass(mutates_CFG=True, analysis_only=False)
class Decide(FunctionPass):
    """Remove the branches of a kernel that the types of its arguments exclude."""

    _name = "branches that types decide"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        """Remove decided branches until none is left; return True if the kernel was changed."""
        text, changed = state.func_ir, False
        while _decided(text, state.args):
            changed = True
            for dead in analysis.compute_cfg_from_blocks(text.blocks).dead_nodes():
                del text.blocks[dead]
            text._definitions = ir_utils.build_definitions(text.blocks)
            text._consts = ConstantInference(text)
        for line in _lines(text):
            if _is_one_of(line.value, QUESTIONS):  # these functions have no type
                line.value = ir.Const(None, line.loc)
        return changed


class DecidingCompiler(CompilerBase):
    def define_pipelines(self) -> list[Any]:
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(Decide, IRProcessing)
        passes.finalize()
        return [passes]


def _decided(text: Any, kinds: tuple[Any, ...]) -> bool:
    """Replace questions and branches that types decide; return True if there were any.

    text: of a kernel, in Numba's representation; kinds: types of its arguments.
    """
    changed = False
    for line in _lines(text):
        answer = _answer(text, kinds, line.value)
        if answer is not None:
            line.value, changed = ir.Const(answer, line.loc), True
    text._definitions = ir_utils.build_definitions(text.blocks)
    for block in text.blocks.values():
        last = block.body[-1]
        if isinstance(last, ir.Branch):
            asked = _meaning(text, last.cond)
            reply = _meaning(text, asked.args[0]) if _is_call(text, asked, (bool,)) else None
            if isinstance(reply, ir.Const) and isinstance(reply.value, bool):
                target = last.truebr if reply.value else last.falsebr
                block.body[-1], changed = ir.Jump(target, last.loc), True
    return changed


def _lines(text: Any) -> list[Any]:
    lines = [line for block in text.blocks.values() for line in block.body]
    return [line for line in lines if isinstance(line, ir.Assign)]


def _meaning(text: Any, name: Any) -> Any:
    """Return the value that a variable is assigned, or None if there are several."""
    return ir_utils.guard(ir_utils.get_definition, text, name)


def _is_one_of(value: Any, functions: tuple[Any, ...]) -> bool:
    named = isinstance(value, ir.Global | ir.FreeVar)
    return named and any(value.value is function for function in functions)


def _is_call(text: Any, value: Any, functions: tuple[Any, ...]) -> bool:
    called = isinstance(value, ir.Expr) and value.op == "call"
    return called and _is_one_of(_meaning(text, value.func), functions)


def _kind(text: Any, kinds: tuple[Any, ...], name: Any) -> Any:
    """Return the type of an argument, or of a field of one; None of any other value."""
    value = _meaning(text, name)
    if isinstance(value, ir.Arg):
        kind = kinds[value.index]
        return None if isinstance(kind, types.Optional | types.Omitted) else kind
    if isinstance(value, ir.Const) and value.value is None:
        return types.none
    if isinstance(value, ir.Expr) and value.op == "getattr":
        whole: Any = _kind(text, kinds, value.value)
        if isinstance(whole, types.NamedTuple | types.NamedUniTuple):
            return dict(zip(whole.fields, whole.types, strict=True)).get(value.attr)
    if isinstance(value, ir.Expr) and value.op == "static_getitem":  # of `a, b = ...`
        whole = _meaning(text, value.value)
        if isinstance(whole, ir.Expr) and whole.op == "exhaust_iter":
            whole = _meaning(text, whole.value)
        if isinstance(whole, ir.Expr) and whole.op == "build_tuple":
            return _kind(text, kinds, whole.items[value.index])
    return None


def _answer(text: Any, kinds: tuple[Any, ...], value: Any) -> bool | None:
    """Return the answer to a question that types decide, otherwise None."""
    if isinstance(value, ir.Expr) and value.op == "binop" and value.fn in ASKED:
        sides = [_kind(text, kinds, side) for side in (value.lhs, value.rhs)]
        if types.none in sides and None not in sides:
            return bool(value.fn(sides[0], sides[1]))
    if _is_call(text, value, QUESTIONS):
        part = _kind(text, kinds, value.args[0])
        if part is not None and _is_call(text, value, (says,)):
            law = law_of(getattr(part, "instance_class", None))
            return hasattr(law, _meaning(text, value.args[1]).value)
        if part is not None and _is_call(text, value, (is_a,)):
            return getattr(part, "instance_class", None) is _meaning(text, value.args[1]).value
        other = _kind(text, kinds, value.args[1])
        if part is not None and other is not None:
            return bool(part == other)
    return None


ASKED = (operator.is_, operator.is_not)
"""Questions whether something is None."""

QUESTIONS = (is_a, same_sort, says)
"""Questions of other kinds."""
