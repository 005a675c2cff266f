"""The choice of a kernel by the law of a wall.

A kernel marked `by_wall` is the general one. If the file of a law (`laws`) has a kernel of the same
name, that one is called for walls of this law; the wall is the first argument, or its field `wall`.
The choice is made when the caller is compiled. A law contains only the kernels in which it differs,
and no other module names it. Kernels marked `by_flow` give way in the same manner to those for
hosts, in `host_space`, `host_orbit` and `host_impact`: their first argument is a space, a flow or
the side of an impact.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..numerics.compiling import Inner, jit
from ..numerics.deciding import law_of


class Chosen(Inner):
    """A kernel that gives way to that of a law, if the law has one."""

    needed: bool  # whether each law must

    def own(self, wall: Any) -> Any:
        """Return the kernel of this name in the law of a sort of walls, or None."""
        return _own(law_of(wall), self.py_func.__name__, self, self.needed)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        kernel = self.own(_sort_of(args[0]))
        call = super().get_call_template if kernel is None else kernel.get_call_template
        return call(args, kws)

    def get_overload(self, sig: Any) -> Any:
        kernel = self.own(_sort_of(sig[0]))
        return super().get_overload(sig) if kernel is None else kernel.get_overload(sig)

    def __call__(self, *arguments: Any) -> Any:
        kernel = self.own(type(getattr(arguments[0], "wall", arguments[0])))
        return super().__call__(*arguments) if kernel is None else kernel(*arguments)


def _sort_of(kind: Any) -> Any:
    """Return the sort of walls by the type of a first argument."""
    inside = dict(zip(getattr(kind, "fields", ()), getattr(kind, "types", ()), strict=True))
    return getattr(inside.get("wall", kind), "instance_class", None)


def _own(law: Any, name: str, general: Any, needed: bool) -> Any:
    """Return the kernel of that name in the module of a law, or None.

    Raises TypeError where it has none and must have.
    """
    kernel = vars(law).get(name) if law else None
    if law and kernel is None and needed:
        raise TypeError(f"{law.__name__} has no kernel {name!r}, which each law must have")
    return None if kernel is general else kernel  # a law may call what holds in general


def by_wall(function: Callable[..., Any] | None = None, *, needed: bool = False) -> Any:
    """Compile a kernel that gives way to that of the same name in the law of a wall.

    needed: each law must have one; the marked function only documents it.
    """
    if function is None:
        return lambda f: by_wall(f, needed=needed)
    kernel: Any = jit(function)
    if isinstance(kernel, Inner):
        kernel.__class__, kernel.needed = Chosen, needed
        return kernel

    def chosen(*arguments: Any) -> Any:
        law = law_of(type(getattr(arguments[0], "wall", arguments[0])))
        kernel = _own(law, function.__name__, chosen, needed)
        return function(*arguments) if kernel is None else kernel(*arguments)

    return chosen


by_flow = by_wall
