"""How an entry becomes one piece of machine code: the only module that knows Numba's inside.

Numba optimizes every function together with all that it calls, once on each level of calls, and
makes machine code of each.  Only entries are ever run.  So an inner kernel stays what the
compiler's front made of it, its own text alone; an entry gathers all inner kernels that it calls,
directly or not, each once, and is optimized with them once.  The bits are those of plain compiling.

Inner kernels of several processes are linked together, so their names tell nothing of a process:
`symbol` makes them of the kernel and the types of its arguments.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Iterator
from types import CodeType
from typing import Any, NamedTuple

import llvmlite.binding as llvm
from numba import _dynfunc  # type: ignore[attr-defined] # written in C
from numba.core import codegen, compiler, itanium_mangler, serialize
from numba.core.environment import Environment

from .deciding import DecidingCompiler

EXPECTED = (
    (codegen.JITCodeLibrary, ("finalize", "_finalize_dynamic_globals", "_get_module_for_linking")),
    (codegen.CPUCodegen, ("create_library",)),
    (compiler.CompilerBase, ("_compile_bytecode", "compile_extra")),
)
"""What this module takes from Numba beside what Numba documents."""


def text_of(function: Any) -> str:
    """Return the code of a function in a form that is the same in each process and at each line."""
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    named = [getattr(value, "__qualname__", repr(value)) for value in cells]
    return repr((_plain(function.__code__), named))


def _plain(code: CodeType) -> tuple[object, ...]:
    """Return the part of a code object that does not depend on its place in the file."""
    constants = [_plain(one) if isinstance(one, CodeType) else one for one in code.co_consts]
    return code.co_code, code.co_names, code.co_varnames, constants


class Need(NamedTuple):
    """An inner kernel that another one calls: by name, so that any process finds it."""

    module: str
    name: str  # of the kernel in its module, or of the function whose body it is
    kinds: tuple[Any, ...]  # types of the arguments
    symbol: str


LEFT_OUT = ("InlineClosureLikes", "NopythonRewrites", "AnnotateTypes")
"""Passes for what kernels do not have: closures, expressions of arrays, and printed types.

Each looks through the whole text; without them compiling takes 6 % less.
"""

OWN = (llvm.Linkage.external, llvm.Linkage.linkonce_odr)


def set_linkage(module: Any, before: tuple[Any, ...], after: str) -> None:
    """Give functions of a module another linkage.

    What is `weak_odr` is kept when it is linked, also before it is called. What is `internal` is
    dropped when it is called no more, and called as suits its callers: numbers that it does not
    use are not handed to it, which makes orbits 15 % faster.
    """
    for function in module.functions:
        if not function.is_declaration and function.linkage in before:
            function.linkage = after


class Inner(codegen.JITCodeLibrary):
    """What an inner kernel is compiled to: not optimized with what it calls, no machine code."""

    need: Need | None = None  # how others ask for it; None where it cannot be found by name

    @property
    def called(self) -> list[Inner]:
        """The inner kernels that this one calls itself."""
        found = dict.fromkeys(self._linking_libraries)
        return [library for library in found if isinstance(library, Inner)]

    def finalize(self) -> None:
        """Leave it as it is, once its text is complete: what is not a kernel becomes part of it."""
        self._raise_if_finalized()
        self._finalized = True
        for library in dict.fromkeys(self._linking_libraries):
            if not isinstance(library, Inner):
                self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        set_linkage(self._final_module, OWN, "weak_odr")

    def get_pointer_to_function(self, name: str) -> int:
        """Return none: there is no machine code."""
        self._ensure_finalized()
        return 0


def all_called(library: Any, seen: dict[Inner, None]) -> Iterator[Inner]:
    """Yield all inner kernels below a library, each once and after one that calls it."""
    for other in library._linking_libraries:
        if isinstance(other, Inner) and other not in seen:
            seen[other] = None
            yield other
            yield from all_called(other, seen)


class Entry(codegen.JITCodeLibrary):
    """What Python calls: linked with all inner kernels below it, then optimized as a whole."""

    linked: list[Inner]  # which these are

    def finalize(self) -> None:
        """Link, optimize, and make machine code."""
        self._raise_if_finalized()
        self.linked = list(all_called(self, {}))
        for library in self.linked:
            self._final_module.link_in(library._final_module, preserve=True)
        others = self._linking_libraries
        self._linking_libraries = [one for one in others if not isinstance(one, Inner)]
        set_linkage(self._final_module, (llvm.Linkage.weak_odr,), "internal")
        super().finalize()


class _Pipeline(DecidingCompiler):
    """Numba's own passes, on names that are the same in each process."""

    library: type[codegen.JITCodeLibrary]

    def _compile_bytecode(self) -> Any:
        state = self.state
        function, kinds = state.func_id.func, state.args
        state.func_id.unique_name = state.func_id.func_qualname
        state.func_id.unique_id = None

        def mangler(name: str, types: Any, **_: Any) -> str:
            return symbol(name, function, kinds)

        state.targetctx = state.targetctx.subtarget(mangler=mangler, **self.changes())
        state.library = self.library(state.targetctx.codegen(), state.func_id.func_qualname)
        return super()._compile_bytecode()

    def changes(self) -> dict[str, Any]:
        """Return the fields of the target that differ here."""
        return {}

    def define_pipelines(self) -> list[Any]:
        (passes,) = super().define_pipelines()
        passes.passes = [one for one in passes.passes if one[0].__name__ not in LEFT_OUT]
        return [passes]


class EntryPipeline(_Pipeline):
    """For what Python calls."""

    library = Entry

    def define_pipelines(self) -> list[Any]:
        self.state.library.enable_object_caching()
        return super().define_pipelines()


class InnerPipeline(_Pipeline):
    """For what kernels alone call."""

    library = Inner

    def changes(self) -> dict[str, Any]:
        """Return that there is nothing to execute."""
        return {"get_executable": not_executable}


def not_executable(library: Any, fndesc: Any, env: Any) -> Any:
    """Return a stand-in for the machine code of an inner kernel, which has none."""
    library._ensure_finalized()
    name = fndesc.qualname.split(".")[-1]
    return _dynfunc.make_function(fndesc.lookup_module(), name, "", 0, env, (library,))


def symbol(name: str, function: Any, kinds: tuple[Any, ...]) -> str:
    """Return the name of a compiled function: the same in each process that compiles it.

    Arguments: its `name` with that of its module, the `function`, the types of its arguments.
    """
    key = "\n".join([text_of(function) if "<" in name else "", *map(str, kinds)])
    digest = hashlib.sha256(key.encode()).hexdigest()[:24]
    return itanium_mangler.mangle(name, (), abi_tags=(digest,))


def as_expected() -> bool:
    """Return True if Numba's inside is what this module takes it for."""
    return all(hasattr(owner, name) for owner, names in EXPECTED for name in names)


# ---- what is stored ------------------------------------------------------------------------------


def to_bytes(result: Any) -> bytes | None:
    """Return a result of compiling as bytes; None where it cannot be stored.

    An entry is stored as machine code, an inner kernel as its own text and the names of those that
    it calls.
    """
    library = result.library
    if library.has_dynamic_globals:
        return None
    if not isinstance(library, Inner):
        return bytes(serialize.dumps(result._reduce()))
    needs = [other.need for other in library.called]
    if None in needs:
        return None
    descriptor = result.fndesc
    descriptor.typemap = descriptor.calltypes = None
    text = library._final_module.as_bitcode()
    return bytes(serialize.dumps((result.signature, descriptor, library.name, text, needs)))


def from_bytes(data: bytes, context: Any, inner: bool, find: Callable[[Need], Inner]) -> Any:
    """Return the result of compiling that was stored.

    Arguments: the `data`; Numba's target `context`; whether it is of an `inner` kernel; `find`
    returns the library of another inner kernel.

    Raises whatever reading damaged data may raise.
    """
    if not inner:
        return compiler.CompileResult._rebuild(context, *pickle.loads(data))
    signature, descriptor, name, text, needs = pickle.loads(data)
    library = Inner(context.codegen(), name)
    library._final_module = llvm.parse_bitcode(text)
    library._linking_libraries = [find(need) for need in needs]
    library._finalized = True
    entry = not_executable(library, descriptor, Environment.from_fndesc(descriptor))
    return compiler.compile_result(
        target_context=context, typing_context=context.typing_context, library=library,
        entry_point=entry, fndesc=descriptor, signature=signature, objectmode=False, lifted=(),
    )  # fmt: skip
