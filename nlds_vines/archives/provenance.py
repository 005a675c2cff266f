"""Where an archive comes from: the request, the program, its libraries, the machine, the time."""

from __future__ import annotations

import hashlib
import json
import platform
import subprocess
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

# the kinds of requests, which an archive names as its `content`
SCAN, TUNING, CONTINUATION = "scan", "tuning", "continuation"
RESPONSE_CURVES, RESPONSE_HISTORY = "set of response curves", "response history"
PORTRAIT = "portrait"

Value = str | int | float  # the value of an attribute of an archive

SCHEMA = 2  # of the archive's format; it rises when older readers would misread a new archive

# the libraries whose versions may change a bit of a result or of a file
LIBRARIES = ("numba", "llvmlite", "numpy", "scipy", "h5py")
_PACKAGE = Path(__file__).parent.parent


def attributes(request: Any, about: Mapping[str, Value], time: str = "") -> dict[str, Value]:
    """Return the attributes of an archive, which `about` overrides; `time` is by default now."""
    command = " ".join(sys.argv).replace("\0", "\\0").encode("utf-8", "backslashreplace").decode()
    return {
        "Conventions": "CF-1.10",
        "title": request.title,
        "history": f"{time or now()} {about.get('command', command)}",
        "schema": SCHEMA,
        "scan": request.to_toml(),
        "scan_hash": request.hash,
        "argv": json.dumps(sys.argv),
        **({"commit": commit()} if commit() else {}),
        **makers(),
        **about,
    }


def now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


@cache
def makers() -> dict[str, str]:
    """Return all that may change a bit of a result, so that no archive holds two versions of it."""
    return {
        "source": f"nlds_vines {version('nlds-vines')}",
        "source_hash": _source_hash(),
        "python_version": platform.python_version(),
        **{f"{library}_version": version(library) for library in LIBRARIES},
        "machine": platform.machine(),
    }


@cache
def version(package: str) -> str:
    """Return the version of a package without importing it; `unknown` if it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"


@cache
def commit() -> str:
    """Return the commit of the clone that this program comes from, with `+` for changes."""
    if not (_PACKAGE.parent / ".git").exists():
        note = _PACKAGE / "_data" / "commit.txt"
        return note.read_text("ascii").strip() if note.is_file() else ""

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(_PACKAGE.parent), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
        return done.stdout.strip()

    try:
        head = git("rev-parse", "HEAD")
        changed = git("status", "--porcelain", "--untracked-files=no", "--", str(_PACKAGE))
    except (OSError, subprocess.SubprocessError):  # git is not installed, or refuses this clone
        return ""
    return head + ("+" if changed else "")


def _source_hash() -> str:
    digest = hashlib.sha256()
    for path in sorted(_PACKAGE.rglob("*.py")):
        digest.update(f"{path.relative_to(_PACKAGE).as_posix()}\0".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()
