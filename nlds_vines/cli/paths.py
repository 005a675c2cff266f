"""Checks of the paths that commands write to, before anything is computed."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from nlds_vines.errors import RequestError, shown

PLOT_SUFFIXES = (".png", ".pdf", ".svg")
"""The kinds of pictures, by the end of their names."""


def check_writable(what: str, path: Path) -> None:
    """Raise `RequestError` unless a file of this path can be written; nothing is left behind."""
    if os.path.isdir(path):  # unlike `Path.is_dir`, never raises
        raise RequestError(f"{what} {shown(str(path))} is a folder: name a file")
    if not path.parent.is_dir():
        raise RequestError(f"{what} {shown(str(path))}: there is no folder {str(path.parent)!r}")
    try:  # neither permission bits nor the length of a name tell the truth on every file system
        tempfile.NamedTemporaryFile(dir=path.parent, prefix=f"{path.name}.").close()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{what} {shown(str(path))} cannot be written: {reason}") from None


def refuse_existing(archive: Path, *, resume: bool, overwrite: bool) -> None:
    """Raise `RequestError` where an archive exists and it was not said what to do with it."""
    if os.path.lexists(archive) and not (resume or overwrite):
        raise RequestError(
            f"output {shown(str(archive))} exists: --resume continues it, "
            "--overwrite replaces it, -o names another file"
        )


def check_plot(path: Path) -> None:
    """Raise `RequestError` unless a picture of this path can be drawn and written."""
    if path.suffix.lower() not in PLOT_SUFFIXES:
        raise RequestError(
            f"--plot {shown(str(path))} must end in one of {', '.join(PLOT_SUFFIXES)}"
        )
    check_writable("--plot", path)
