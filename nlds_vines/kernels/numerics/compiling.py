"""How kernels are compiled, linked and stored.

Floating point is strict (no fastmath, no contraction), so that results have the same bits from run
to run and without compiling, and NumPy's error model holds, so that no division raises in a kernel.

Numba optimizes each function with all that it calls, once on each level of calls, and makes machine
code of each. Here an inner kernel stays LLVM code of its own text. An entry, which Python calls, is
linked with all inner kernels below it, each once, and optimized once: half the time (16 instead of
31 s for one orbit), the same bits. `stored_code` keeps the results on the disk. Inner kernels of
several processes are linked together, so `symbol` names a function by its text and types alone.

This module relies on private parts of Numba: dispatchers (`registry.CPUDispatcher` and its
`_compiler`, `_cache`, `overloads`), libraries (`codegen.JITCodeLibrary` and its `_final_module`,
`_linking_libraries`), the passes of `compiler.CompilerBase`, `_reduce` and `_rebuild` of
`CompileResult`, `targetctx.subtarget` and `_dynfunc.make_function`. If one of EXPECTED is missing,
entries are compiled as Numba does it, to the same bits in twice the time, and Numba's own cache
stores them.
"""

from __future__ import annotations

import gc
import hashlib
import importlib
import pickle
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, ClassVar, NamedTuple

import llvmlite.binding as llvm
import numba
from numba import _dynfunc  # type: ignore[attr-defined] # written in C
from numba.core import (
    codegen,
    compiler,
    itanium_mangler,
    registry,
    serialize,
    sigutils,
    types,
    typing,
)
from numba.core.compiler_lock import global_compiler_lock
from numba.core.environment import Environment

from . import stored_code
from .deciding import DecidingCompiler, laws_among

EXPECTED = (
    (codegen.JITCodeLibrary, ("finalize", "_finalize_dynamic_globals", "_get_module_for_linking")),
    (codegen.CPUCodegen, ("create_library",)),
    (compiler.CompilerBase, ("_compile_bytecode", "compile_extra", "define_pipelines")),
    (compiler.CompileResult, ("_reduce", "_rebuild")),
    (_dynfunc, ("make_function",)),
)
"""Private parts of Numba without which entries are not linked."""

LINKED = all(hasattr(owner, name) for owner, names in EXPECTED for name in names)


# ---- names and libraries -------------------------------------------------------------------------


def text_of(function: Any) -> str:
    """Return the code of a function in a form that is the same in each process and at each line."""
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    names = [getattr(value, "__qualname__", repr(value)) for value in cells]
    return repr((_plain(function.__code__), names))


def _plain(code: CodeType) -> tuple[object, ...]:
    """Return the parts of a code object that do not depend on its place in the file."""
    constants = [_plain(one) if isinstance(one, CodeType) else one for one in code.co_consts]
    return code.co_code, code.co_names, code.co_varnames, constants


def symbol(name: str, function: Any, kinds: tuple[Any, ...]) -> str:
    """Return the name of a compiled function, the same in each process that compiles it.

    name: with that of its module; kinds: the types of the arguments.
    """
    key = "\n".join([text_of(function) if "<" in name else "", *map(str, kinds)])
    digest = hashlib.sha256(key.encode()).hexdigest()[:24]
    return itanium_mangler.mangle(name, (), abi_tags=(digest,))


class Need(NamedTuple):
    """An inner kernel that another one calls, as any process finds it."""

    module: str
    name: str  # of the kernel in its module, or of the function whose body it is
    kinds: tuple[Any, ...]  # types of the arguments
    symbol: str


def set_linkage(module: Any, before: tuple[Any, ...], after: str) -> None:
    """Change the linkage of the functions of a module.

    `weak_odr` functions survive linking, also before they are called. `internal` ones vanish if
    nothing calls them, and lose arguments that they do not use: orbits get 15 % faster.
    """
    for function in module.functions:
        if not function.is_declaration and function.linkage in before:
            function.linkage = after


class InnerLibrary(codegen.JITCodeLibrary):
    """The LLVM code of an inner kernel: not optimized with what it calls, no machine code."""

    need: Need | None = None  # None if other processes cannot find it by name

    @property
    def called(self) -> list[InnerLibrary]:
        """The inner kernels that this one calls itself."""
        libraries = dict.fromkeys(self._linking_libraries)
        return [library for library in libraries if isinstance(library, InnerLibrary)]

    def finalize(self) -> None:
        """Link all but inner kernels into the code, and leave it as it is."""
        self._raise_if_finalized()
        self._finalized = True
        for library in dict.fromkeys(self._linking_libraries):
            if not isinstance(library, InnerLibrary):
                self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        linkages = llvm.Linkage.external, llvm.Linkage.linkonce_odr
        set_linkage(self._final_module, linkages, "weak_odr")

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no machine code."""
        self._ensure_finalized()
        return 0


def all_called(library: Any, seen: dict[InnerLibrary, None]) -> Iterator[InnerLibrary]:
    """Yield all inner kernels below a library, each once and after one that calls it."""
    for other in library._linking_libraries:
        if isinstance(other, InnerLibrary) and other not in seen:
            seen[other] = None
            yield other
            yield from all_called(other, seen)


class EntryLibrary(codegen.JITCodeLibrary):
    """The code of an entry, linked with all inner kernels below it, then optimized as a whole."""

    def finalize(self) -> None:
        self._raise_if_finalized()
        self.linked = list(all_called(self, {}))
        for library in self.linked:
            self._final_module.link_in(library._final_module, preserve=True)
        others = self._linking_libraries
        self._linking_libraries = [one for one in others if not isinstance(one, InnerLibrary)]
        set_linkage(self._final_module, (llvm.Linkage.weak_odr,), "internal")
        super().finalize()


# ---- Numba's passes ------------------------------------------------------------------------------


LEFT_OUT = ("InlineClosureLikes", "NopythonRewrites", "AnnotateTypes")
"""Passes for closures, array expressions and printed types, which kernels lack: 6 % of the time."""


class _Pipeline(DecidingCompiler):
    """Numba's passes, with names that are the same in each process."""

    library: type[codegen.JITCodeLibrary]
    changes: ClassVar[dict[str, Any]] = {}
    """Fields of the target context that differ."""

    def _compile_bytecode(self) -> Any:
        state = self.state
        function, kinds = state.func_id.func, state.args
        state.func_id.unique_name = state.func_id.func_qualname
        state.func_id.unique_id = None

        def mangler(name: str, types: Any, **_: Any) -> str:
            return symbol(name, function, kinds)

        state.targetctx = state.targetctx.subtarget(mangler=mangler, **self.changes)
        state.library = self.library(state.targetctx.codegen(), state.func_id.func_qualname)
        return super()._compile_bytecode()

    def define_pipelines(self) -> list[Any]:
        (passes,) = super().define_pipelines()
        passes.passes = [one for one in passes.passes if one[0].__name__ not in LEFT_OUT]
        return [passes]


class EntryPipeline(_Pipeline):
    """The passes of an entry, whose object code can be stored."""

    library = EntryLibrary

    def define_pipelines(self) -> list[Any]:
        self.state.library.enable_object_caching()
        return super().define_pipelines()


def not_executable(library: Any, fndesc: Any, env: Any) -> Any:
    """Return a stand-in for the machine code of an inner kernel."""
    library._ensure_finalized()
    name = fndesc.qualname.split(".")[-1]
    return _dynfunc.make_function(fndesc.lookup_module(), name, "", 0, env, (library,))


class InnerPipeline(_Pipeline):
    """The passes of an inner kernel, which only other kernels call."""

    library = InnerLibrary
    changes: ClassVar = {"get_executable": not_executable}


# ---- results as bytes ----------------------------------------------------------------------------


def to_bytes(result: Any) -> bytes | None:
    """Return a result of compiling as bytes, or None if it cannot be stored.

    That of an entry holds machine code; that of an inner kernel, its own code and the names of the
    inner kernels that it calls.
    """
    library = result.library
    if library.has_dynamic_globals:
        return None
    if not isinstance(library, InnerLibrary):
        return bytes(serialize.dumps(result._reduce()))
    needs = [other.need for other in library.called]
    if None in needs:
        return None
    descriptor = result.fndesc
    descriptor.typemap = descriptor.calltypes = None
    text = library._final_module.as_bitcode()
    return bytes(serialize.dumps((result.signature, descriptor, library.name, text, needs)))


def from_bytes(data: bytes, context: Any, inner: bool) -> Any:
    """Return a result of compiling from its bytes; damaged ones may raise anything.

    context: Numba's target; inner: whether it is of an inner kernel.
    """
    if not inner:
        return compiler.CompileResult._rebuild(context, *pickle.loads(data))
    signature, descriptor, name, text, needs = pickle.loads(data)
    library = InnerLibrary(context.codegen(), name)
    library._final_module = llvm.parse_bitcode(text)
    library._linking_libraries = [
        getattr(importlib.import_module(need.module), need.name).library(need) for need in needs
    ]
    library._finalized = True
    entry = not_executable(library, descriptor, Environment.from_fndesc(descriptor))
    return compiler.compile_result(
        target_context=context, typing_context=context.typing_context, library=library,
        entry_point=entry, fndesc=descriptor, signature=signature, objectmode=False, lifted=(),
    )  # fmt: skip


# ---- kernels -------------------------------------------------------------------------------------


STACK_PLACES = 1 << 16  # values


def with_room(function: Any) -> Any:
    """Let a function start a new piece of Python's stack that holds all that it calls.

    Python keeps the values of running functions in pieces of 2,048, which it allocates and frees as
    calls cross from one to the next: a sixth of the time of compiling. A function that declares a
    large stack gets a piece of its own; memory that is not touched costs nothing.
    """
    function.__code__ = function.__code__.replace(co_stacksize=STACK_PLACES)
    return function


_Dispatcher: Any = registry.CPUDispatcher


class Kernel(_Dispatcher):
    place: tuple[str, str]
    """Module and name under which other processes find it, or the function whose body it is."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return Numba's template of a call with arguments of these types; literals are numbers."""
        signature, folded = self.fold_argument_types(args, kws)
        kinds = tuple(types.unliteral(kind) for kind in folded)
        self.compile(kinds)
        signatures = [self.overloads[kinds].signature]
        name = self.py_func.__name__
        return typing.make_concrete_template(name, name, signatures), signature, kinds, {}

    def compile(self, sig: Any) -> Any:
        """Return the entry for arguments of these types, loaded or compiled."""
        kinds = tuple(sigutils.normalize_signature(sig)[0])
        with global_compiler_lock:
            if kinds not in self.overloads:
                self.add_overload(self._loaded(kinds) or self._compiled(kinds))
            return self.overloads[kinds].entry_point

    def library(self, need: Need) -> Any:
        """Return the library of an inner kernel; LookupError if it no longer is what was needed."""
        self.compile(need.kinds)
        library = self.overloads[need.kinds].library
        if library.need != need:
            raise LookupError(need)
        return library

    @with_room
    def _compiled(self, kinds: tuple[Any, ...]) -> Any:
        """Compile the kernel for arguments of these types, and store the result."""
        with _watch.compiling(self), self._compiling_counter:
            result = self._compiler.compile(kinds, None)
        if not LINKED:
            self._cache.save_overload(kinds, result)
        else:
            self._note(kinds, result)
            data, file = to_bytes(result), self.file(kinds)
            if data is not None and file is not None:
                stored_code.save(file, data)
        return result

    def _loaded(self, kinds: tuple[Any, ...]) -> Any:
        """Return the stored result for arguments of these types, or None."""
        if LINKED:
            file = self.file(kinds)
            data = None if file is None else stored_code.load(file)
            if data is None:
                return None
            self.targetctx.refresh()
            try:
                result = from_bytes(data, self.targetctx, isinstance(self, Inner))
            except Exception:  # whatever damaged data, or those of other sources, lead to
                stored_code.say_damaged()
                return None
            self._note(kinds, result)
        else:
            result = self._cache.load_overload(kinds, self.targetctx)
        if result is not None:
            self.targetctx.insert_user_function(result.entry_point, result.fndesc, [result.library])
        return result

    def _note(self, kinds: tuple[Any, ...], result: Any) -> None:
        """Note in the library of an inner kernel how other processes ask for it."""
        module, name = self.place
        if isinstance(self, Inner) and hasattr(sys.modules.get(module), name):
            result.library.need = Need(module, name, kinds, result.fndesc.mangled_name)

    def file(self, kinds: tuple[Any, ...]) -> str | None:
        """Return the file name of the result for these types; None for code without a source."""
        source = Path(self.py_func.__code__.co_filename)
        if not source.exists():
            return None
        name = self.py_func.__qualname__
        processor = self.targetctx.codegen().magic_tuple()
        laws = {Path(law.__file__) for law in laws_among(kinds)}
        key = f"{symbol(name, self.py_func, kinds)} {processor}"
        return stored_code.file_name([source, *sorted(laws)], name, key)


class Inner(Kernel):
    """A kernel without the wrapper through which Python calls; Python calls its `entry` instead."""

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
        return self.entry(*arguments)


def jit(
    function: Callable[..., Any] | None = None, *, entry: bool = False, inlined: bool = False
) -> Any:
    """Compile a kernel that other kernels call.

    entry: Python calls it, and often. inlined: for small functions in the hottest loops that take
    or return fours, which a call would pass in memory.

    With the environment variable NUMBA_DISABLE_JIT=1 the function is returned as it is: slow,
    readable, debuggable, and equal to the last bit.
    """
    if function is None:
        return lambda f: jit(f, entry=entry, inlined=inlined)
    options: Any = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
    options |= {} if entry else {"no_cpython_wrapper": True}
    options |= {"forceinline": True} if inlined else {}
    pipeline = EntryPipeline if entry else InnerPipeline
    options["pipeline_class"] = pipeline if LINKED else DecidingCompiler
    kernel: Any = numba.njit(**options)(function)
    if isinstance(kernel, _Dispatcher):  # none without compilation
        kernel.__class__ = Kernel if entry else Inner
        kernel.place = function.__module__, function.__qualname__
        folder = stored_code.folder_of_numba() if entry and not LINKED else None
        if folder is not None:
            # Numba compares the source of the entry alone, so the folder belongs to all sources.
            config: Any = numba.config
            before, config.CACHE_DIR = config.CACHE_DIR, str(folder)
            try:
                kernel.enable_caching()
            finally:
                config.CACHE_DIR = before
    return kernel


# ---- who is told of compilations -----------------------------------------------------------------


class _Watch:
    """Tells of compilations, and switches the garbage collector off until nested ones end.

    The collector would look again and again through all that the compiler holds.
    """

    def __init__(self) -> None:
        self.before: list[Callable[[Any], object]] = []
        self.after: list[Callable[[Any], object]] = []

    @contextmanager
    def compiling(self, kernel: Any) -> Iterator[None]:
        """Call the listeners before and after a kernel is compiled in the block."""
        for tell in tuple(self.before):
            tell(kernel)
        outermost = gc.isenabled()
        gc.disable()
        try:
            yield
        finally:
            if outermost:
                gc.enable()
            for tell in tuple(self.after):
                tell(kernel)


_watch = _Watch()


@contextmanager
def told_of_compilations(
    tell: Callable[[Any], object], ended: Callable[[Any], object] = lambda kernel: None
) -> Iterator[None]:
    """Call `tell(kernel)` before each compilation in the block, and `ended(kernel)` after it.

    A kernel that is loaded from the disk is not compiled. An exception raised by `tell` cancels the
    compilation; `ended` is also called after one that failed.
    """
    _watch.before.append(tell)
    _watch.after.append(ended)
    try:
        yield
    finally:
        _watch.before.remove(tell)
        _watch.after.remove(ended)
