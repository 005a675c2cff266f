"""How kernels are compiled: the only module that decides it.

Strict floating point (no fastmath, no contraction) so that results are bit-identical from run to
run and to the uncompiled code; NumPy's error model, so that no division raises inside a kernel;
and a disk cache that is invalidated by a change in *any* kernel file. Numba's own cache looks at
the decorated function's file alone and would keep stale code of the functions it calls.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any

import numba
from numba import extending
from numba.core import caching, types

KERNELS = Path(__file__).parent


@lru_cache(maxsize=1)
def source_stamp() -> str:
    """Return one hash over every kernel source, this one included: what the cache depends on."""
    digest = hashlib.sha256()
    for path in sorted(KERNELS.glob("*.py")):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _stamped(locator: type) -> type:
    """Return `locator` with the stamp of all kernel sources instead of its single file's."""
    return type(locator.__name__, (locator,), {"get_source_stamp": lambda self: source_stamp()})


@contextmanager
def _stamped_cache() -> Iterator[None]:
    """Let Numba's cache see the stamped locators while a function is being decorated."""
    registry: Any = caching.CacheImpl
    original = registry._locator_classes
    registry._locator_classes = [_stamped(locator) for locator in original]
    try:
        yield
    finally:
        registry._locator_classes = original


def jit(
    function: Callable[..., Any] | None = None,
    *,
    parallel: bool = False,
    dissolved: bool = False,
    inlined: bool = False,
) -> Any:
    """Compile a kernel: nopython, cached, strict floating point.

    `parallel=True` belongs to the loops over lanes and nowhere else. `dissolved=True` is for large
    functions with one caller: they become part of its text before anything is compiled. (Every
    function is compiled together with all that it calls, once on each level of calls.)
    `inlined=True` is for small functions in the hottest loops, which take or return fours: a call
    would hand these on in memory.

    With the environment variable NUMBA_DISABLE_JIT=1 the function is returned as it is: slow,
    readable, debuggable, and equal to the last bit.
    """
    if function is None:
        return lambda f: jit(f, parallel=parallel, dissolved=dissolved, inlined=inlined)
    options: Any = {"error_model": "numpy", "nogil": True, "parallel": parallel}
    if dissolved:
        options["inline"] = "always"
    if inlined:
        options["forceinline"] = True
    with _stamped_cache():
        return numba.njit(cache=True, **options)(function)


def chosen(builder: Callable[..., Callable[..., Any]]) -> Any:
    """Make a function whose body is chosen, when compiled, by which of its arguments are None.

    `builder` takes the arguments and returns the function to run on them; it may ask of each
    argument only whether it is None. Compiled, it is asked once for each set of types, and what it
    does not return is not even typed. (A plain `if part is None` is pruned by Numba only where
    the part *is* None; where it is present both branches must agree in type.)
    """

    @wraps(builder)
    def run(*arguments: Any) -> Any:
        return builder(*arguments)(*arguments)

    @wraps(builder)
    def choose(*kinds: Any) -> Callable[..., Any]:
        body = builder(*(None if isinstance(kind, types.NoneType) else kind for kind in kinds))
        return getattr(body, "py_func", body)

    options: Any = {"error_model": "numpy", "nogil": True}
    extending.overload(run, jit_options=options, strict=False)(choose)
    return run
