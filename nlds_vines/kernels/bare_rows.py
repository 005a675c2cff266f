"""A row of numbers as inner kernels read it: where it begins, and nothing else.

The references to an array that is handed on are counted, by instructions that lock memory and cost
as much as ten additions each. Where a function has several ways out, or hands the array on to
another, the compiler cannot do without. A bare row is not counted: it lives as long as the array it
is taken of, which an outer kernel holds. Without compiling it is that array.
"""

from __future__ import annotations

from typing import Any

from numba.core import types
from numba.extending import lower_builtin, type_callable

BARE = types.CPointer(types.float64)  # its type: read and written by index, as an array


def bare(array: Any) -> Any:
    """Return an array of numbers, one contiguous row, as a bare row; one that is bare, as it is."""
    return array


def is_row(kind: Any) -> bool:
    """Tell whether a type is that of a contiguous row of numbers."""
    return (
        isinstance(kind, types.Array)
        and kind.ndim == 1
        and kind.layout == "C"
        and kind.dtype == types.float64
    )


@type_callable(bare)
def _typed(context: Any) -> Any:
    return lambda array: BARE if array == BARE or is_row(array) else None


@lower_builtin(bare, types.Array)
def _begin(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return context.make_array(sig.args[0])(context, builder, args[0]).data


@lower_builtin(bare, types.CPointer)
def _as_it_is(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return args[0]
