"""Checks of the paths that commands write to, before anything is computed."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from nlds_vines.cli.run_options import RunOptions
from nlds_vines.errors import RequestError, shown

PLOT_SUFFIXES = (".png", ".pdf", ".svg")
"""The ends of the names of pictures, by which their kinds are chosen."""


def optional_path(value: str | os.PathLike[str] | None) -> Path | None:
    """Return the path of a file that may be left out; None for None."""
    return None if value is None else Path(value)


def check_writable(what: str, path: Path) -> None:
    """Raise `RequestError` unless a file of this path can be written; nothing is left behind."""
    if os.path.isdir(path):  # unlike `Path.is_dir`, never raises
        raise RequestError(f"{what} {shown(str(path))} is a folder: name a file")
    if not path.parent.is_dir():
        raise RequestError(f"{what} {shown(str(path))}: there is no folder {str(path.parent)!r}")
    try:  # permission bits and the length of a name do not decide it on every file system
        tempfile.NamedTemporaryFile(dir=path.parent, prefix=f"{path.name}.").close()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{what} {shown(str(path))} cannot be written: {reason}") from None


def check_output(archive: Path, *others: Path | None) -> None:
    """Raise `RequestError` unless an archive of this path can be written.

    Arguments: `others` are further files of the run, None for one that there is not: the archive
    must be none of them.
    """
    check_writable("output", archive)
    if any(path.resolve() == archive.resolve() for path in others if path is not None):
        raise RequestError(f"output {shown(str(archive))} is another file of this run")


def refuse_existing(archive: Path, how: RunOptions) -> None:
    """Raise `RequestError` for an archive that exists, without --resume and --overwrite."""
    if os.path.lexists(archive) and not (how.resume or how.overwrite):
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
