"""Compiled kernels on the disk: where they lie, and for which sources they hold.

Each specialization of a kernel is a file of its own, written whole, so that any number of processes
may read and write.  A file that is damaged counts as not there, and is written anew.  What is read
is run, so a file also counts as not there if another user but root owns it or its folder, or may
write to them.

What a file holds for is told by a stamp: of the syntax tree of the kernel's module, without
comments and docstrings, and of all modules of the kernels that it imports; and of the laws of the
walls among its arguments, which it need not know (`by_law`).  So a docstring may be changed, or a
verdict, or another law, and no flight is compiled again.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import secrets
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path

import llvmlite
import numba

KERNELS = Path(__file__).parents[1]

CACHE_OF = (
    "nlds_vines: neither its own folder nor the cache of the user can be written: compiled kernels "
    "{where}; set NUMBA_CACHE_DIR to a folder that can be written, and is kept"
)
"""What is said where compiled kernels have no lasting place."""


@cache
def say_once(text: str) -> None:
    """Say a line on standard error, once in a process."""
    sys.stderr.write(text + "\n")


# ---- where ---------------------------------------------------------------------------------------


NOT_TRUSTED = (
    "nlds_vines: compiled kernels in {folder} are not read, for they would be run: another user "
    "owns them or their folder, or group or others may write to them (remedy: chmod -R go-w)"
)


def _trusted(info: os.stat_result) -> bool:
    """Return True if nobody but this user and root can have written a file or folder.

    Where files have no such owner and mode, as on Windows, a user's folders are the user's alone.
    """
    if not hasattr(os, "getuid"):
        return True
    return info.st_uid in (0, os.getuid()) and not info.st_mode & 0o022


def _read(path: Path) -> bytes | None:
    """Return the bytes of a file of a cache; None if it is not there, or not trusted."""
    with suppress(OSError):
        if _trusted(path.parent.stat()):
            with path.open("rb") as file:
                if _trusted(os.fstat(file.fileno())):
                    return file.read()
        if path.exists():
            say_once(NOT_TRUSTED.format(folder=path.parent))
    return None


def _private(folder: Path) -> bool:
    """Return True if a folder is this user's, and nobody else's."""
    found = folder.lstat()
    private = stat.S_ISDIR(found.st_mode) and not stat.S_IMODE(found.st_mode) & 0o077
    return not hasattr(os, "getuid") or (private and found.st_uid == os.getuid())


def temporary_folder() -> Path:
    """Return a folder of this user alone among the temporary ones, made if it is not there.

    What lies in it is run, so a folder that others can write to is not taken.
    Raises OSError where there is none that can be written.
    """
    folder = Path(tempfile.gettempdir(), f"nlds_vines-{getattr(os, 'getuid', str)()}")
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    return folder if _private(folder) else Path(tempfile.mkdtemp(prefix="nlds_vines-"))


def _places() -> Iterator[Path]:
    """Yield the lasting folders that may hold compiled kernels, the best one first.

    The cache of the user is that of the XDG Base Directory Specification, which says to ignore a
    relative path; a user without a home has none.
    """
    name = f"kernels-{hashlib.sha256(str(KERNELS).encode()).hexdigest()[:16]}"
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(chosen, "nlds_vines", name)
    yield KERNELS / "__pycache__"
    home = Path(os.environ.get("XDG_CACHE_HOME", ""))
    with suppress(RuntimeError):  # no HOME, and no entry in the list of users
        home = home if home.is_absolute() else Path("~/.cache").expanduser()
        yield home / "nlds_vines" / name


def _writable(folder: Path) -> bool:
    """Return True if a folder is trusted and can be written; make it if it is not there."""
    try:
        folder.mkdir(mode=0o755, parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
        return _trusted(folder.stat())
    except OSError:
        return False


@lru_cache(maxsize=1)
def folder() -> Path | None:
    """Return the folder where this process keeps compiled kernels; None where there is none."""
    for place in _places():
        if _writable(place):
            return place
    with suppress(OSError):
        place = temporary_folder()
        say_once(CACHE_OF.format(where=f"go to {place}"))
        return place
    say_once(CACHE_OF.format(where="are lost when the process ends"))
    return None


@lru_cache(maxsize=1)
def folder_of_numba() -> Path | None:
    """Return the folder in which Numba keeps what it compiled from all sources as they are now.

    Those of other sources are removed.
    """
    place = folder()
    if place is None:
        return None
    sources = hashlib.sha256()
    for path in sorted(KERNELS.rglob("*.py")):
        sources.update(path.read_bytes())
    own = place / f"numba-{sources.hexdigest()[:24]}"
    for stale in place.glob("numba-*"):
        if stale != own:
            shutil.rmtree(stale, ignore_errors=True)
    return own


# ---- for which sources ---------------------------------------------------------------------------


class _WithoutDocstrings(ast.NodeTransformer):
    """Removes docstrings from a syntax tree."""

    def generic_visit(self, node: ast.AST) -> ast.AST:
        """Remove that of a node, and those below it."""
        super().generic_visit(node)
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and _is_text(body[0]):
            del body[0]
        return node


def _is_text(statement: ast.AST) -> bool:
    return isinstance(getattr(getattr(statement, "value", None), "value", None), str) and (
        isinstance(statement, ast.Expr)
    )


def read_source(text: bytes) -> tuple[str, list[str]]:
    """Return a hash of what a module does, and the names of those beside it that it may import."""
    tree = _WithoutDocstrings().visit(ast.parse(text))
    beside = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            module = f".{node.module or ''}" if node.level > 0 else node.module or ""
            if node.level > 0 or module.startswith("nlds_vines.kernels"):
                beside |= {module.rpartition(".")[2], *(alias.name for alias in node.names)}
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), sorted(beside)


@cache
def _source(path: Path) -> tuple[str, list[str]]:
    text = path.read_bytes()
    noted, key = _notes(), f"{path.stem} {sys.version} {hashlib.sha256(text).hexdigest()}"
    if key not in noted:
        stale = [old for old in noted if old.startswith(f"{path.stem} ")]
        for old in stale:
            del noted[old]
        noted[key] = read_source(text)
        _write_notes()
    code, beside = noted[key]
    return str(code), list(beside)


@lru_cache(maxsize=1)
def _notes() -> dict[str, tuple[str, list[str]]]:
    """Return the notes on sources: reading a syntax tree takes longer than a hash."""
    place = folder()
    data = _read(place / "sources.json") if place else None
    with suppress(ValueError):
        return dict(json.loads(data or b"{}"))
    return {}


def _write_notes() -> None:
    """Keep what is known of sources."""
    place = folder()
    if place is not None:
        with suppress(OSError):
            _write_whole(place / "sources.json", json.dumps(_notes()).encode())


def modules() -> dict[str, Path]:
    """Return the files of all kernels by their names, which are used once."""
    return {path.stem: path for path in KERNELS.rglob("*.py") if path.stem != "__init__"}


@cache
def stamp_of(*paths: Path) -> str:
    """Return a hash of what the compiled code of a kernel depends on.

    These are its module and those of its laws, those of the kernels that they import, and theirs;
    the versions of Python and of the compiler, and how much it is to optimize.
    """
    config = numba.config
    options = config.OPT, config.LOOP_VECTORIZE, config.SLP_VECTORIZE  # type: ignore[attr-defined]
    versions = sys.version, numba.__version__, llvmlite.__version__
    digest = hashlib.sha256(repr((versions, options)).encode())
    there, left, known = modules(), [*paths], {*paths}
    while left:
        code, beside = _source(left.pop())
        digest.update(code.encode())
        found = sorted({there[name] for name in beside if name in there} - known)
        left += found
        known |= {*found}
    return digest.hexdigest()


# ---- files ---------------------------------------------------------------------------------------


def _write_whole(path: Path, data: bytes) -> None:
    """Write a file that other processes see whole or not at all.

    Its mode is that of the umask, but for writing: `_read` does not trust what others may write to.
    """
    draft = path.with_name(f"{path.name}.{secrets.token_hex(8)}")
    number = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
    try:
        with os.fdopen(number, "wb") as file:
            file.write(data)
        os.replace(draft, path)
    except BaseException:
        draft.unlink()
        raise


def load(name: str) -> bytes | None:
    """Return the bytes that `save` has stored by this name, or None.

    A file is the SHA-256 of the data (32 bytes), then the data; a damaged one is said, and the next
    place is tried.  For which sources it holds, its name tells.  Places: the folder this process
    writes to, then the other lasting ones, which may be read-only, as in an image of a container.
    Of these, a folder that the user has chosen (NUMBA_CACHE_DIR) is the only one.
    """
    own, others = folder(), [*_places()]
    if os.environ.get("NUMBA_CACHE_DIR"):
        others = others[:1]
    for place in dict.fromkeys([*([own] if own else []), *others]):
        data = _read(place / name)
        if data is not None:
            if hashlib.sha256(data[32:]).digest() == data[:32]:
                return data[32:]
            say_damaged()
    return None


def say_damaged() -> None:
    say_once("nlds_vines: compiled kernels on the disk are damaged: they are compiled again")


def save(name: str, data: bytes) -> None:
    """Keep data in a file, and remove what the same kernels were for other sources."""
    place = folder()
    if place is not None:
        with suppress(OSError):
            _remove_stale(place)
            _write_whole(place / name, hashlib.sha256(data).digest() + data)


@lru_cache(maxsize=1)
def _remove_stale(place: Path) -> None:
    """Remove from a folder what holds for other sources of these modules."""
    there = modules()
    for path in place.glob(f"*{SUFFIX}"):
        names = path.name.partition(".")[0].split("+")
        if all(name in there for name in names):
            stamp = stamp_of(*(there[name] for name in names))
            if not path.name.endswith(f"-{stamp[:16]}{SUFFIX}"):
                path.unlink(missing_ok=True)


SUFFIX = ".compiled"


def file_name(sources: Sequence[Path], name: str, key: str) -> str:
    """Return the name of the file of a kernel: of its `name`, for a `key`.

    sources: its module, then the laws of the walls among its arguments.
    """
    digest = hashlib.sha256(key.encode()).hexdigest()[:24]
    plain = "".join(letter for letter in name if letter.isalnum() or letter in "._")
    stems, stamp = "+".join(source.stem for source in sources), stamp_of(*sources)
    return f"{stems}.{plain}-{digest}-{stamp[:16]}{SUFFIX}"
