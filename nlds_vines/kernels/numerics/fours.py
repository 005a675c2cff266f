"""Bare rows, which are pointers to arrays, and fours, which are vectors of four numbers.

References to an array that is passed on are counted by atomic instructions, which cost as much as
ten additions each. The compiler cannot remove them if a function has several exits or passes the
array on. A bare row is a pointer without a count, valid as long as the array of which it is taken,
which an outer kernel holds. Without compiling it is that array.

A four is a vector register when compiled, and an array of four numbers otherwise.

    four_at(array, i)     the numbers i to i + 3 of an array
    put_four(array, i, v) ... written into it
    four(x)               four times x
    four_of(a, b, c, d)   these four
    number_of(v, k)       one of them
    sum_of(v)             (v0 + v2) + (v1 + v3)
    largest_of(v)         the largest absolute value
    larger_of(v, w)       number by number the larger of v and |w|
    roots_of(v)           the square roots

and the operators + - * / between fours, and between a four and a number. Each of these rounds
number by number by IEEE 754, so that the bits are those of a loop, on every processor and without
compiling. (The compiler does not vectorize such loops well: it may not reorder sums, keeps them in
memory, and splits a row of twelve into a vector of eight and a rest.) An array that is read so has
rows of whole fours. A four is never changed in place: write v = v + w, not v += w.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import lower_builtin, models, register_model, type_callable

BARE = types.CPointer(types.float64)  # its type: read and written by index, as an array


def bare(part: Any) -> Any:
    """Return a contiguous row of numbers as a bare row, a named tuple with all its rows bare.

    Anything else, a table or a row of records, too, stays as it is.
    """
    return part


@type_callable(bare)
def _as_row(context: Any) -> Any:
    return _bared


def _bared(kind: Any) -> Any:
    """Return the type of a bare part."""
    if isinstance(kind, types.Array) and kind.ndim == 1 and kind.layout == "C":
        return kind if isinstance(kind.dtype, types.Record) else types.CPointer(kind.dtype)
    if isinstance(kind, types.NamedTuple | types.NamedUniTuple):
        fields = [_bared(field) for field in kind.types]
        return types.BaseTuple.from_types(fields, kind.instance_class)
    return kind


@lower_builtin(bare, types.Any)
def _begin(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return _bare_value(context, builder, sig.args[0], args[0])


def _bare_value(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    to = _bared(kind)
    if to == kind:
        context.nrt.incref(builder, kind, value)
        return value
    if isinstance(kind, types.Array):
        return context.make_array(kind)(context, builder, value).data
    fields = [
        _bare_value(context, builder, field, builder.extract_value(value, i))
        for i, field in enumerate(kind.types)
    ]
    return context.make_tuple(builder, to, fields)


def from_place(row: Any, i: int) -> Any:
    """Return the bare row that begins at number i of a bare row."""
    return row[i:]


@type_callable(from_place)
def _as_part(context: Any) -> Any:
    return lambda row, i: row if isinstance(row, types.CPointer) else None


@lower_builtin(from_place, types.CPointer, types.Integer)
def _part(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.gep(args[0], [context.cast(builder, args[1], sig.args[1], types.intp)])


# ---- four numbers --------------------------------------------------------------------------------

FOUR = 4


class Four(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Four")


_FOUR = Four()
_REAL = types.float64
_VECTOR = ir.VectorType(ir.DoubleType(), FOUR)
_INDEX = ir.IntType(32)


@register_model(Four)
class _Model(models.PrimitiveModel):
    """What holds four numbers in machine code: a vector."""

    def __init__(self, manager: Any, kind: Four) -> None:
        super().__init__(manager, kind, _VECTOR)


# ---- without compiling ---------------------------------------------------------------------------


def four_at(array: Any, i: int) -> Any:
    return array[i : i + FOUR].copy()


def put_four(array: Any, i: int, v: Any) -> None:
    array[i : i + FOUR] = v


def four(x: float) -> Any:
    return np.full(FOUR, x)


def four_of(a: float, b: float, c: float, d: float) -> Any:
    return np.array([a, b, c, d])


def number_of(v: Any, k: int) -> Any:
    return v[k]


def sum_of(v: Any) -> Any:
    return (v[0] + v[2]) + (v[1] + v[3])


def largest_of(v: Any) -> Any:
    a = np.abs(v)
    b = np.where(a[2:] > a[:2], a[2:], a[:2])
    return b[1] if b[1] > b[0] else b[0]


def larger_of(v: Any, w: Any) -> Any:
    a = np.abs(w)
    return np.where(a > v, a, v)


def roots_of(v: Any) -> Any:
    return np.sqrt(v)


# ---- compiled ------------------------------------------------------------------------------------


def _is_row(kind: Any) -> bool:
    """Return True if a type is that of a contiguous row of numbers, counted or bare."""
    if not isinstance(kind, types.Array):
        return bool(kind == BARE)
    return (kind.dtype, kind.ndim, kind.layout) == (types.float64, 1, "C")


def _typed(function: Any, rule: Callable[..., Any]) -> None:
    """Let Numba type calls of a function by a rule, None where it does not apply."""
    type_callable(function)(lambda context: rule)


def _place(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Return the pointer to four numbers of an array (argument 0) from an index (1) on."""
    begin = args[0]
    if sig.args[0] != BARE:
        begin = context.make_array(sig.args[0])(context, builder, begin).data
    index = context.cast(builder, args[1], sig.args[1], types.intp)
    return builder.bitcast(builder.gep(begin, [index]), _VECTOR.as_pointer())


def _spread(builder: Any, x: Any) -> Any:
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, x, ir.Constant(_INDEX, 0))
    return builder.shuffle_vector(
        first, nothing, ir.Constant(ir.VectorType(_INDEX, FOUR), [0] * FOUR)
    )


def _number(builder: Any, v: Any, k: int) -> Any:
    return builder.extract_element(v, ir.Constant(_INDEX, k))


def _each(builder: Any, name: str, v: Any) -> Any:
    """Return the values of an intrinsic function for each number of a vector."""
    kind = ir.FunctionType(_VECTOR, [_VECTOR])
    function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{FOUR}f64")
    return builder.call(function, [v])


def _greater(builder: Any, v: Any, w: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", w, v), w, v)


_typed(four_at, lambda array, i: _FOUR if _is_row(array) else None)
_typed(put_four, lambda array, i, v: types.void if _is_row(array) and v == _FOUR else None)
_typed(four, lambda x: _FOUR if x == _REAL else None)
_typed(four_of, lambda a, b, c, d: _FOUR if {a, b, c, d} == {_REAL} else None)
_typed(number_of, lambda v, k: _REAL if v == _FOUR else None)
_typed(sum_of, lambda v: _REAL if v == _FOUR else None)
_typed(largest_of, lambda v: _REAL if v == _FOUR else None)
_typed(roots_of, lambda v: _FOUR if v == _FOUR else None)
_typed(larger_of, lambda v, w: _FOUR if v == w == _FOUR else None)


@lower_builtin(four_at, types.CPointer, types.Integer)
@lower_builtin(four_at, types.Array, types.Integer)
def _load(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    vector = builder.load(_place(context, builder, sig, args))
    vector.align = 8  # a row may begin at any number
    return vector


@lower_builtin(put_four, types.CPointer, types.Integer, Four)
@lower_builtin(put_four, types.Array, types.Integer, Four)
def _store(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    builder.store(args[2], _place(context, builder, sig, args)).align = 8
    return context.get_dummy_value()


@lower_builtin(four_of, types.Float, types.Float, types.Float, types.Float)
def _joined(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    vector = ir.Constant(_VECTOR, ir.Undefined)
    for k in range(FOUR):
        vector = builder.insert_element(vector, args[k], ir.Constant(_INDEX, k))
    return vector


@lower_builtin(sum_of, Four)
def _total(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    a, b, c, d = (_number(builder, args[0], k) for k in range(FOUR))
    return builder.fadd(builder.fadd(a, c), builder.fadd(b, d))


@lower_builtin(largest_of, Four)
def _largest(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    sizes = _each(builder, "fabs", args[0])
    a, b, c, d = (_number(builder, sizes, k) for k in range(FOUR))
    return _greater(builder, _greater(builder, a, c), _greater(builder, b, d))


lower_builtin(larger_of, Four, Four)(
    lambda context, builder, sig, args: _greater(builder, args[0], _each(builder, "fabs", args[1]))
)
lower_builtin(roots_of, Four)(lambda context, builder, sig, args: _each(builder, "sqrt", args[0]))
lower_builtin(four, types.Float)(lambda context, builder, sig, args: _spread(builder, args[0]))
lower_builtin(number_of, Four, types.Integer)(
    lambda context, builder, sig, args: builder.extract_element(
        args[0], builder.trunc(args[1], _INDEX)
    )
)


def _arithmetic(sign: Any, instruction: str) -> None:
    """Teach Numba an operator on fours, the `instruction` of the same name on vectors."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        sides = (
            value if kind == _FOUR else _spread(builder, value)
            for kind, value in zip(sig.args, args, strict=True)
        )
        return getattr(builder, instruction)(*sides)

    for a, b in ((_FOUR, _FOUR), (_FOUR, _REAL), (_REAL, _FOUR)):
        lower_builtin(sign, type(a), type(b))(lower)
    _typed(sign, lambda a, b: _FOUR if _FOUR in (a, b) and {a, b} <= {_FOUR, _REAL} else None)


for _sign, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _arithmetic(_sign, _instruction)
