"""How kernels are compiled: what all other kernels stand on.

Strict floating point (no fastmath, no contraction) so that results are bit-identical from run to
run and to the uncompiled code; NumPy's error model, so that no division raises inside a kernel.
`linking` makes one piece of machine code of an entry and all that it calls; `stored_code` keeps
what was compiled for other processes.

Where Numba's inside is not what `linking` takes it for, entries are compiled plainly, with all that
they call, to the same bits but in twice the time; Numba's own cache keeps them (`cached_by_numba`).
"""

from __future__ import annotations

import gc
import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from types import FunctionType
from typing import Any

import numba
from numba.core import registry, sigutils, types, typing
from numba.core.compiler_lock import global_compiler_lock

from . import linking, stored_code
from .deciding import DecidingCompiler, laws_among

LINKED = linking.as_expected()
"""Whether entries are linked from inner kernels; otherwise Numba compiles as it does by itself."""


STACK_PLACES = 1 << 16  # places for values


def with_room(function: Any) -> Any:
    """Give a function, and all that it calls, room for values of their own.

    Python keeps the values of running functions in pieces of memory of 2,048 places, which it asks
    the system for, and gives back, as calls cross from one to the next. Calls that do so again and
    again cost a sixth of the time of compiling. A function that says it needs much gets one piece
    for itself and all below it; memory that nobody touches costs nothing.
    """
    function.__code__ = function.__code__.replace(co_stacksize=STACK_PLACES)
    return function


_Dispatcher: Any = registry.CPUDispatcher


class Kernel(_Dispatcher):
    """A compiled kernel that Python calls."""

    place: tuple[str, str]
    """Module and name under which other processes find it, or the function whose body it is."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return Numba's template of a call with arguments of these types.

        A number that is known when compiling is a number like any other.
        """
        signature, folded = self.fold_argument_types(args, kws)
        kinds = tuple(types.unliteral(kind) for kind in folded)
        self.compile(kinds)
        found = [self.overloads[kinds].signature]
        name = self.py_func.__name__
        return typing.make_concrete_template(name, name, found), signature, kinds, {}

    def compile(self, sig: Any) -> Any:
        """Compile the kernel for arguments of these types, unless it is; return its entry."""
        kinds = tuple(sigutils.normalize_signature(sig)[0])
        with global_compiler_lock:
            if kinds not in self.overloads:
                self.add_overload(self._loaded(kinds) or self._compiled(kinds))
            return self.overloads[kinds].entry_point

    def library(self, need: linking.Need) -> Any:
        """Return the library of an inner kernel that another one is linked with.

        Raises LookupError where it is another one now.
        """
        self.compile(need.kinds)
        library = self.overloads[need.kinds].library
        if library.need != need:
            raise LookupError(need)
        return library

    @with_room
    def _compiled(self, kinds: tuple[Any, ...]) -> Any:
        """Compile the kernel for arguments of these types, and store what comes of it."""
        with _watch.compiling(self), self._compiling_counter:
            result = self._compiler.compile(kinds, None)
        if not LINKED:
            self._cache.save_overload(kinds, result)
        else:
            self._note(kinds, result)
            data, file = linking.to_bytes(result), self.file(kinds)
            if data is not None and file is not None:
                stored_code.save(file, data)
        return result

    def _loaded(self, kinds: tuple[Any, ...]) -> Any:
        """Return the stored result for arguments of these types, or None."""
        if not LINKED:
            result = self._cache.load_overload(kinds, self.targetctx)
            if result is not None:
                self.targetctx.insert_user_function(
                    result.entry_point, result.fndesc, [result.library]
                )
            return result
        file = self.file(kinds)
        data = None if file is None else stored_code.load(file)
        if data is None:
            return None
        inner = isinstance(self, Inner)
        self.targetctx.refresh()
        try:
            result = linking.from_bytes(data, self.targetctx, inner, _library)
        except Exception:  # whatever damaged data, or those of other sources, lead to
            stored_code.say_damaged()
            return None
        self._note(kinds, result)
        self.targetctx.insert_user_function(result.entry_point, result.fndesc, [result.library])
        return result

    def _note(self, kinds: tuple[Any, ...], result: Any) -> None:
        """Note in the library of an inner kernel how other processes ask for it."""
        module, name = self.place
        if isinstance(self, Inner) and hasattr(sys.modules.get(module), name):
            result.library.need = linking.Need(module, name, kinds, result.fndesc.mangled_name)

    def file(self, kinds: tuple[Any, ...]) -> str | None:
        """Return the file of what is compiled for arguments of these types; None: none."""
        source = Path(self.py_func.__code__.co_filename)
        if not source.exists():
            return None
        name = self.py_func.__qualname__
        symbol = linking.symbol(name, self.py_func, kinds)
        processor = self.targetctx.codegen().magic_tuple()
        laws = {Path(law.__file__) for law in laws_among(kinds)}
        return stored_code.file_name([source, *sorted(laws)], name, f"{symbol} {processor}")


class Inner(Kernel):
    """A kernel without the wrapper through which Python calls: without one, a call would crash.

    Python that calls it all the same gets there by its `entry`.
    """

    @cached_property
    def entry(self) -> Any:
        """The same text, compiled with the wrapper; what it calls is compiled once for both."""
        text = self.py_func
        name = f"{text.__name__}_from_python"
        copy = FunctionType(
            text.__code__, text.__globals__, name, text.__defaults__, text.__closure__
        )
        copy.__module__, copy.__qualname__ = text.__module__, name
        return jit(copy, entry=True)

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel from Python."""
        return self.entry(*arguments)


def _library(need: linking.Need) -> Any:
    """Return the library of an inner kernel that is needed, found by its name."""
    return getattr(importlib.import_module(need.module), need.name).library(need)


def jit(
    function: Callable[..., Any] | None = None, *, entry: bool = False, inlined: bool = False
) -> Any:
    """Compile a kernel: nopython, kept on the disk, strict floating point, for other kernels.

    `entry=True` is for what only Python calls, and often.
    `inlined=True` is for small functions in the hottest loops, which take or return fours: a call
    would hand these on in memory.

    With the environment variable NUMBA_DISABLE_JIT=1 the function is returned as it is: slow,
    readable, debuggable, and equal to the last bit.
    """
    if function is None:
        return lambda f: jit(f, entry=entry, inlined=inlined)
    options: Any = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
    options |= {} if entry else {"no_cpython_wrapper": True}
    options |= {"forceinline": True} if inlined else {}
    pipeline = linking.EntryPipeline if entry else linking.InnerPipeline
    options["pipeline_class"] = pipeline if LINKED else DecidingCompiler
    kernel: Any = numba.njit(**options)(function)
    if isinstance(kernel, _Dispatcher):  # none without compilation
        kernel.__class__ = Kernel if entry else Inner
        kernel.place = function.__module__, function.__qualname__
        if entry and not LINKED:
            cached_by_numba(kernel)
    return kernel


def cached_by_numba(kernel: Any) -> None:
    """Let Numba's own cache keep an entry, in a folder that belongs to the sources as they are.

    Numba compares the file of the entry alone with what it was, not those of the kernels it calls.
    """
    config: Any = numba.config
    folder, before = stored_code.folder_of_numba(), config.CACHE_DIR
    if folder is not None:
        config.CACHE_DIR = str(folder)
        try:
            kernel.enable_caching()
        finally:
            config.CACHE_DIR = before


class _Watch:
    """Sees what is compiled, and lets the garbage collector rest until nested compilations end.

    It would look again and again through all that the compiler holds.
    """

    def __init__(self) -> None:
        self.told: list[Callable[[Any], object]] = []
        self.ended: list[Callable[[Any], object]] = []

    @contextmanager
    def compiling(self, kernel: Any) -> Iterator[None]:
        """Tell of a kernel before it is compiled in the block, and after it."""
        for tell in tuple(self.told):
            tell(kernel)
        outermost = gc.isenabled()
        gc.disable()
        try:
            yield
        finally:
            if outermost:
                gc.enable()
            for tell in tuple(self.ended):
                tell(kernel)


_watch = _Watch()


@contextmanager
def told_of_compilations(
    tell: Callable[[Any], object], ended: Callable[[Any], object] = lambda kernel: None
) -> Iterator[None]:
    """Call `tell(kernel)` before a kernel is compiled, not where the cache has it, in the block.

    What `tell` raises ends the compilation before it begins. After it, also one that has failed,
    `ended(kernel)` is called.
    """
    _watch.told.append(tell)
    _watch.ended.append(ended)
    try:
        yield
    finally:
        _watch.told.remove(tell)
        _watch.ended.remove(ended)
