"""Compiled kernels on the disk: their folder, their files, and the sources for which these hold.

Each specialization of a kernel is a file of its own, written whole, so that any number of processes
may read and write. A damaged file is compiled and written anew. Files are run, so one is not read
unless this user or root owns it and its folder, and nobody else may write to them.

The stamp in a file's name is a hash of the syntax trees, without docstrings, of the kernel's module
and of all kernel modules that it imports, and of the laws of the walls among its arguments, which
it need not import (`by_law`). A change of a docstring or a verdict compiles no flight again.
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


@cache
def say_once(text: str) -> None:
    """Write a line to standard error, once in a process."""
    sys.stderr.write(text + "\n")


# ---- folders -------------------------------------------------------------------------------------


def _trusted(info: os.stat_result) -> bool:
    """Return True if only this user and root can have written a file or folder.

    On Windows, where files have no such owner and mode, a user's folders are the user's alone.
    """
    if not hasattr(os, "getuid"):
        return True
    return info.st_uid in (0, os.getuid()) and not info.st_mode & 0o022


def _read(path: Path) -> bytes | None:
    """Return the bytes of a file; None if it does not exist or is not trusted."""
    with suppress(OSError):
        if _trusted(path.parent.stat()):
            with path.open("rb") as file:
                if _trusted(os.fstat(file.fileno())):
                    return file.read()
        if path.exists():
            say_once(
                f"nlds_vines: compiled kernels in {path.parent} are not read, for they would be "
                "run: another user owns them or their folder, or group or others may write to them "
                "(remedy: chmod -R go-w)"
            )
    return None


def temporary_folder() -> Path:
    """Return a temporary folder that only this user can read or write; OSError if there is none."""
    folder = Path(tempfile.gettempdir(), f"nlds_vines-{getattr(os, 'getuid', str)()}")
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    info = folder.lstat()
    is_private = stat.S_ISDIR(info.st_mode) and not stat.S_IMODE(info.st_mode) & 0o077
    if not hasattr(os, "getuid") or (is_private and info.st_uid == os.getuid()):
        return folder
    return Path(tempfile.mkdtemp(prefix="nlds_vines-"))


def folder_name(kernels: Path) -> str:
    """Return the name of the folder for the kernels in a folder of sources."""
    return f"kernels-{hashlib.sha256(str(kernels).encode()).hexdigest()[:16]}"


def _places() -> Iterator[Path]:
    """Yield the permanent folders that may hold compiled kernels, by preference.

    First the folder in NUMBA_CACHE_DIR, if it is set; then the program's own; then the user's cache
    by the XDG Base Directory Specification, which ignores relative paths. There is no user's cache
    if XDG_CACHE_HOME is not an absolute path and the user has no home.
    """
    name = folder_name(KERNELS)
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(chosen, "nlds_vines", name)
    yield KERNELS / "__pycache__"
    home = Path(os.environ.get("XDG_CACHE_HOME", ""))
    with suppress(RuntimeError):  # no HOME, and no entry in the list of users
        home = home if home.is_absolute() else Path("~/.cache").expanduser()
        yield home / "nlds_vines" / name


def _obstacle(place: Path) -> str:
    """Return in words why no compiled kernels can be written to a folder; empty if they can."""
    try:
        place.mkdir(mode=0o755, parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=place).close()
        is_trusted = _trusted(place.stat())
    except (OSError, ValueError) as error:
        return getattr(error, "strerror", None) or str(error)
    return "" if is_trusted else "another user owns it, or group or others may write to it"


@lru_cache(maxsize=1)
def folder() -> Path | None:
    """Return the folder to which this process writes compiled kernels, or None.

    A line says so if it is not that in NUMBA_CACHE_DIR.
    """
    chosen, passed_over = os.environ.get("NUMBA_CACHE_DIR"), ""
    for number, place in enumerate(_places()):
        obstacle = _obstacle(place)
        if not obstacle:
            if passed_over:
                say_once(f"{passed_over}; compiled kernels go to {place}")
            return place
        if chosen and number == 0:
            passed_over = f"nlds_vines: NUMBA_CACHE_DIR = {chosen!r} is passed over: {obstacle}"
    if passed_over:
        say_once(passed_over)
    temporary = None
    with suppress(OSError):
        temporary = temporary_folder()
    where = f"go to {temporary}" if temporary else "are lost when the process ends"
    say_once(
        "nlds_vines: neither its own folder nor the cache of the user can be written: compiled "
        f"kernels {where}; set NUMBA_CACHE_DIR to a folder that can be written, and is kept"
    )
    return temporary


@lru_cache(maxsize=1)
def folder_of_numba() -> Path | None:
    """Return the folder of Numba's own cache for the present sources; remove those of others."""
    place = folder()
    if place is None:
        return None
    sources = hashlib.sha256()
    for path in sorted(KERNELS.rglob("*.py")):
        sources.update(path.read_bytes())
    present = place / f"numba-{sources.hexdigest()[:24]}"
    for stale in place.glob("numba-*"):
        if stale != present:
            shutil.rmtree(stale, ignore_errors=True)
    return present


# ---- sources -------------------------------------------------------------------------------------


def read_source(text: bytes) -> tuple[str, list[str]]:
    """Return a hash of a module's code without docstrings, and the kernel modules it may import."""
    tree = ast.parse(text)
    beside = set()
    for node in ast.walk(tree):
        if isinstance(body := getattr(node, "body", None), list):
            node.body = [  # type: ignore[attr-defined]
                one
                for one in body
                if not (isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant))
            ]
        if isinstance(node, ast.ImportFrom):
            module = f".{node.module or ''}" if node.level > 0 else node.module or ""
            if node.level > 0 or module.startswith("nlds_vines.kernels"):
                beside |= {module.rpartition(".")[2], *(alias.name for alias in node.names)}
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), sorted(beside)


@cache
def _source(path: Path) -> tuple[str, list[str]]:
    text = path.read_bytes()
    notes, key = _notes(), f"{path.stem} {sys.version} {hashlib.sha256(text).hexdigest()}"
    if key not in notes:
        for old in [old for old in notes if old.startswith(f"{path.stem} ")]:
            del notes[old]
        notes[key] = read_source(text)
        place = folder()
        if place is not None:
            with suppress(OSError):
                _write_whole(place / "sources.json", json.dumps(notes).encode())
    code, beside = notes[key]
    return str(code), list(beside)


@lru_cache(maxsize=1)
def _notes() -> dict[str, tuple[str, list[str]]]:
    """Return the stored results of `read_source`, which takes longer than a hash."""
    place = folder()
    data = _read(place / "sources.json") if place else None
    with suppress(ValueError):
        return dict(json.loads(data or b"{}"))
    return {}


def modules() -> dict[str, Path]:
    """Return the files of all kernel modules by their names, each of which occurs once."""
    return {path.stem: path for path in KERNELS.rglob("*.py") if path.stem != "__init__"}


@cache
def stamp_of(*paths: Path) -> str:
    """Return a hash of all that the compiled code of a kernel depends on.

    paths: its module and those of its laws. Included are the kernel modules that they import,
    directly or not, the versions of Python and of the compiler, and its levels of optimization.
    """
    config = numba.config
    options = config.OPT, config.LOOP_VECTORIZE, config.SLP_VECTORIZE  # type: ignore[attr-defined]
    versions = sys.version, numba.__version__, llvmlite.__version__
    digest = hashlib.sha256(repr((versions, options)).encode())
    files, left, seen = modules(), [*paths], {*paths}
    while left:
        code, beside = _source(left.pop())
        digest.update(code.encode())
        further = sorted({files[name] for name in beside if name in files} - seen)
        left += further
        seen |= {*further}
    return digest.hexdigest()


# ---- files ---------------------------------------------------------------------------------------


def _write_whole(path: Path, data: bytes) -> None:
    """Write a file that other processes see whole or not at all, and only this user may write."""
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

    A file is the SHA-256 of the data (32 bytes), then the data. The folder that this process writes
    to comes first, then the other permanent ones, which may be read-only as in a container's image.
    With NUMBA_CACHE_DIR, the folder in it is the only other one. A damaged file is passed over.
    """
    chosen, others = folder(), [*_places()]
    if os.environ.get("NUMBA_CACHE_DIR"):
        others = others[:1]
    for place in dict.fromkeys([*([chosen] if chosen else []), *others]):
        data = _read(place / name)
        if data is not None:
            if hashlib.sha256(data[32:]).digest() == data[:32]:
                return data[32:]
            say_damaged()
    return None


def say_damaged() -> None:
    say_once("nlds_vines: compiled kernels on the disk are damaged: they are compiled again")


def save(name: str, data: bytes) -> None:
    """Store data in a file; remove files of the same modules for other sources."""
    place = folder()
    if place is not None:
        with suppress(OSError):
            _remove_stale(place)
            _write_whole(place / name, hashlib.sha256(data).digest() + data)


@lru_cache(maxsize=1)
def _remove_stale(place: Path) -> None:
    files = modules()
    for path in place.glob(f"*{SUFFIX}"):
        names = path.name.partition(".")[0].split("+")
        if all(name in files for name in names):
            stamp = stamp_of(*(files[name] for name in names))
            if not path.name.endswith(f"-{stamp[:16]}{SUFFIX}"):
                path.unlink(missing_ok=True)


SUFFIX = ".compiled"


def file_name(sources: Sequence[Path], name: str, key: str) -> str:
    """Return the file name of a kernel of this `name` for a `key` of its types and processor.

    sources: its module, then the laws of the walls among its arguments.
    """
    digest = hashlib.sha256(key.encode()).hexdigest()[:24]
    plain = "".join(letter for letter in name if letter.isalnum() or letter in "._")
    stems, stamp = "+".join(source.stem for source in sources), stamp_of(*sources)
    return f"{stems}.{plain}-{digest}-{stamp[:16]}{SUFFIX}"
