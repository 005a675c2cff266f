"""How kernels are compiled: the only module that decides it.

Strict floating point (no fastmath, no contraction) so that results are bit-identical from run to
run and to the uncompiled code; NumPy's error model, so that no division raises inside a kernel;
and a disk cache that is invalidated by a change in *any* kernel file. Numba's own cache looks at
the decorated function's file alone and would keep stale code of the functions it calls. Where
neither the program's folder nor the user's cache can be written, it lies in a temporary folder.

Most of the time of a first run is compiling. So kernels that kernels alone call get no wrapper for
Python, and Python's garbage collector, which would look again and again through all that the
compiler holds, rests meanwhile; and Python's frames get room (`_with_room`).
"""

from __future__ import annotations

import gc
import hashlib
import os
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cached_property, lru_cache, wraps
from pathlib import Path
from types import FunctionType
from typing import Any

import numba
from numba import extending
from numba.core import caching, event, registry, types

KERNELS = Path(__file__).parent


@lru_cache(maxsize=1)
def source_stamp() -> str:
    """Return one hash of what compiled code depends on and Numba's cache does not know.

    These are all kernel sources, this one included, and how much the compiler is to optimise.
    """
    digest = hashlib.sha256(f"NUMBA_OPT={numba.config.OPT}".encode())  # type: ignore[attr-defined]
    for path in sorted(KERNELS.glob("*.py")):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


CACHE_OF = (
    "nlds_vines: neither its own folder nor the cache of the user can be written: compiled kernels "
    "{where}; set NUMBA_CACHE_DIR to a folder that can be written, and is kept"
)
"""What is said where compiled kernels have no lasting place."""


@lru_cache(maxsize=2)
def _say_once(where: str) -> None:
    """Say on standard error what becomes of compiled kernels."""
    sys.stderr.write(CACHE_OF.format(where=where) + "\n")


@lru_cache(maxsize=1)
def temporary_folder() -> Path:
    """Return a folder of this user alone among the temporary ones, made if it is not there.

    Numba runs what it finds in a cache, so a folder that others can write to is not taken.
    Raises OSError where there is none that can be written.
    """
    folder = Path(tempfile.gettempdir(), f"nlds_vines-{os.getuid()}")
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    found = folder.lstat()
    private = stat.S_ISDIR(found.st_mode) and not stat.S_IMODE(found.st_mode) & 0o077
    if not (private and found.st_uid == os.getuid()):
        folder = Path(tempfile.mkdtemp(prefix="nlds_vines-"))
    return folder


class _TemporaryLocator(caching.UserWideCacheLocator):
    """Places the cache in the temporary folder, for where no lasting one can be written."""

    def __init__(self, py_func: Any, py_file: str) -> None:
        super().__init__(py_func, py_file)
        subpath = self.get_suitable_cache_subpath(py_file)
        self._cache_path = str(temporary_folder() / subpath)

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Any:
        """Return the locator, None where there is no such folder."""
        try:
            found = super().from_function(py_func, py_file)
        except OSError:
            return None
        if found is not None:
            _say_once(f"go to {temporary_folder()}")
        return found


def _stamped(locator: type) -> type:
    """Return `locator` with the stamp of all kernel sources instead of its single file's."""
    return type(locator.__name__, (locator,), {"get_source_stamp": lambda self: source_stamp()})


class _ReadOnly(caching.FunctionCache):
    """The cache of a kernel, from which is read what another process has compiled.

    Numba numbers the files of a kernel, so that only one process may write them at a time.
    """

    def save_overload(self, sig: Any, data: Any) -> None:
        """Leave the files as they are."""


_read_only = False


def only_read_inner_kernels() -> None:
    """Let this process write no files of inner kernels; called before they are imported."""
    global _read_only
    _read_only = True


@contextmanager
def _stamped_cache() -> Iterator[None]:
    """Let Numba's cache see the stamped locators while a function is being decorated."""
    registry: Any = caching.CacheImpl
    original = registry._locator_classes
    registry._locator_classes = [_stamped(one) for one in (*original, _TemporaryLocator)]
    try:
        yield
    finally:
        registry._locator_classes = original


def _with_room(function: Callable[[Any], Any], argument: Any) -> Any:
    """Return function(argument), whose frames and those it calls lie in one piece of memory.

    Python keeps frames in chunks of 16 KiB and gives each back to the system when it is left. Where
    a loop of the compiler calls across the end of one, every call maps and unmaps memory: it did so
    half a million times, a fifth of the wait. This function asks for a frame of 1.1 MB, so that its
    chunk is of 2 MB, the rest of which is room for what it calls. (No page of it is touched.)
    """
    return function(argument)


_with_room.__code__ = _with_room.__code__.replace(co_stacksize=140_000)


class Kernel(registry.CPUDispatcher):
    """A compiled kernel."""

    def compile(self, sig: Any) -> Any:
        """Compile the kernel for arguments of these types, unless it is; return its entry."""
        return _with_room(super().compile, sig)


class Inner(Kernel):
    """A kernel without the wrapper through which Python calls: without one, a call would crash.

    Python that calls it all the same gets there by its `entry`.
    """

    @cached_property
    def entry(self) -> Any:
        """The same text, compiled with the wrapper; what it calls is compiled once for both."""
        text = self.py_func
        name = f"{text.__name__}_from_python"  # the cache on the disk goes by the name
        copy = FunctionType(text.__code__, text.__globals__, name, text.__defaults__)
        copy.__module__, copy.__qualname__ = text.__module__, name
        return jit(copy, entry=True)

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel from Python."""
        return self.entry(*arguments)


def jit(
    function: Callable[..., Any] | None = None,
    *,
    entry: bool = False,
    dissolved: bool = False,
    inlined: bool = False,
) -> Any:
    """Compile a kernel: nopython, cached, strict floating point, for other kernels to call.

    `entry=True` is for what only Python calls, and often. `dissolved=True` is for large functions
    with one caller: they become part of its text before anything is compiled. (Every function is
    compiled together with all that it calls, once on each level of calls.)
    `inlined=True` is for small functions in the hottest loops, which take or return fours: a call
    would hand these on in memory.

    With the environment variable NUMBA_DISABLE_JIT=1 the function is returned as it is: slow,
    readable, debuggable, and equal to the last bit.
    """
    if function is None:
        return lambda f: jit(f, entry=entry, dissolved=dissolved, inlined=inlined)
    options: Any = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
    if not entry:
        options["no_cpython_wrapper"] = True
    if dissolved:
        options["inline"] = "always"
    if inlined:
        options["forceinline"] = True
    with _stamped_cache():
        try:
            kernel = numba.njit(cache=True, **options)(function)
        except RuntimeError:  # there is no folder at all for a cache
            _say_once("are lost when the process ends")
            kernel = numba.njit(**options)(function)
    if isinstance(kernel, registry.CPUDispatcher):  # none without compilation
        kernel.__class__ = Kernel if entry else Inner
        if _read_only and not entry and kernel.stats.cache_path is not None:
            with _stamped_cache():
                kernel._cache = _ReadOnly(function)  # type: ignore[attr-defined]
    return kernel


def chosen(builder: Callable[..., Callable[..., Any]]) -> Any:
    """Make a function whose body is chosen, when compiled, by which of its arguments are None.

    `builder` takes the arguments and returns the function to run on them; it may ask of each
    argument only whether it is None, and of a tuple, of what sort it is (`is_a`). Compiled, it is
    asked once for each set of types, and what it does not return is not even typed. (A plain
    `if part is None` is pruned by Numba only where the part *is* None; where it is present both
    branches must agree in type.)
    """

    @wraps(builder)
    def run(*arguments: Any) -> Any:
        return builder(*arguments)(*arguments)

    @wraps(builder)
    def choose(*kinds: Any) -> Callable[..., Any]:
        body = builder(*(None if isinstance(kind, types.NoneType) else kind for kind in kinds))
        return getattr(body, "py_func", body)

    options: Any = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
    extending.overload(run, jit_options=options, strict=False)(choose)
    return run


def is_a(part: object, sort: type) -> bool:
    """Tell, in a builder of `chosen`, whether an argument is a tuple of this sort."""
    return isinstance(part, sort) or getattr(part, "instance_class", None) is sort


def same_sort(part: object, other: object) -> bool:
    """Tell, in a builder of `chosen`, whether two tuples are of one type, as one variable needs."""
    if isinstance(part, tuple) and isinstance(other, tuple):
        absent = [[number is None for number in numbers] for numbers in (part, other)]
        return type(part) is type(other) and absent[0] == absent[1]
    return part == other


def _remove_stale_files(folder: Path) -> None:
    """Remove what other sources have left in a folder of the cache, and note whose it is now.

    Numba would find a new entry in the list of a kernel a moment before its file is written, and
    then read the stale file of the same number.
    """
    note = folder / "nlds_vines.stamp"
    with suppress(OSError):
        if note.exists() and note.read_text("ascii") == source_stamp():
            return
        for path in folder.glob("*.nb[ic]"):
            path.unlink(missing_ok=True)
        folder.mkdir(parents=True, exist_ok=True)
        note.write_text(source_stamp(), "ascii")


class _Watch(event.Listener):
    """Sees what is compiled, and lets the garbage collector rest until nested compilations end."""

    def __init__(self) -> None:
        self.told: list[Callable[[Any], object]] = []
        self.ended: list[Callable[[Any], object]] = []
        self._outermost: Any = None  # what a compilation is of, while the collector rests for it

    def on_start(self, event: event.Event) -> None:
        """Tell of a kernel, then stop the collector, unless it rests already."""
        kernel = event.data["dispatcher"]
        for tell in tuple(self.told):
            tell(kernel)
        ours = str(kernel.py_func.__module__).startswith("nlds_vines.")  # None of made functions
        if self._outermost is None and ours and gc.isenabled():
            if kernel.stats.cache_path is not None:
                _remove_stale_files(Path(kernel.stats.cache_path))
            self._outermost = event.data
            gc.disable()

    def on_end(self, event: event.Event) -> None:
        """Let it work again after the outermost compilation, also one that has failed."""
        if self._outermost is not None and event.data is self._outermost:
            self._outermost = None
            gc.enable()
        for tell in tuple(self.ended):
            tell(event.data["dispatcher"])


_watch = _Watch()
event.register("numba:compile", _watch)


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
