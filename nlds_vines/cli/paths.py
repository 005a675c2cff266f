"""Checks of the paths that commands write to, before anything is computed."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines.archives.files import open_regular, protection
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.errors import RequestError, refuse_bytes, shown

if TYPE_CHECKING:
    from nlds_vines.archives.provenance import Request

PLOT_SUFFIXES = (".png", ".pdf", ".svg")
"""The ends of the names of pictures, by which their kinds are chosen."""


ARCHIVE_SUFFIXES = (".h5", ".hdf5", ".nc")
"""The ends of the names of archives: HDF5 files, which netCDF-4 reads, too."""


_MOST_BYTES = 1 << 28
"""Bytes of a picture or a page (256 MB): what is larger is none of ours."""


def optional_path(value: str | os.PathLike[str] | None) -> Path | None:
    """Return the path of a file that may be left out; None for None."""
    return None if value is None else Path(value)


def file_path(text: str) -> Path:
    """Return the path of a file, beside which others are named; `RequestError` for no name."""
    path = Path(text)
    if not path.name:
        raise RequestError(f"{shown(text)} is no name of a file")
    return path


def existing(text: str | os.PathLike[str], option: str = "") -> Path:
    """Return the path of a file that is there; `RequestError` without one, named by its option."""
    path = Path(text)
    if not path.is_file():
        reason = "it is no regular file" if path.exists() else "there is no such file"
        raise RequestError(f"{option} {shown(str(path))}: {reason}".strip())
    return path


def request_path(source: object) -> Path | None:
    """Return the path of the request file that a source names, if it is one."""
    is_path = isinstance(source, os.PathLike) or str(source).endswith(".toml")
    return Path(str(source)) if is_path else None


def check_writable(what: str, path: Path, *, archive: bool = False) -> None:
    """Raise `RequestError` unless a file of this path can be written; nothing is left behind.

    Of a symbolic link, what it points to must be writable as well.  Arguments: `archive` says
    whether the file is to be one: nothing else replaces an archive, or takes an archive's name.
    """
    refuse_bytes(what, str(path))
    if not archive and path.suffix.lower() in ARCHIVE_SUFFIXES:
        raise RequestError(f"{what} {shown(str(path))}: such a name is for archives alone")
    for place in dict.fromkeys([path, Path(os.path.realpath(path))]):
        parent = place.parent
        if os.path.isdir(place):  # unlike `Path.is_dir`, never raises
            raise RequestError(f"{what} {shown(str(path))} is a folder: name a file")
        if not os.path.isdir(parent):
            raise RequestError(f"{what} {shown(str(path))}: there is no folder {str(parent)!r}")
        reason = _hindrance(place, archive)
        if reason is not None:
            raise RequestError(f"{what} {shown(str(path))} cannot be written: {reason}")


def _hindrance(path: Path, archive: bool) -> str | None:
    """Return what keeps a file of this path from being written; None if nothing does."""
    try:  # permission bits and the length of a name do not decide it on every file system
        tempfile.NamedTemporaryFile(dir=path.parent, prefix=f"{path.name}.").close()
        return protection(path, archive=archive)
    except (OSError, ValueError) as error:
        return getattr(error, "strerror", None) or str(error)


def check_output(archive: Path, *others: Path | None) -> None:
    """Raise `RequestError` unless an archive of this path can be written.

    Arguments: `others` are further files of the run, None for one that there is not: no two of them
    and the archive may be the same.
    """
    check_writable("output", archive, archive=True)
    if archive.suffix.lower() not in ARCHIVE_SUFFIXES:
        raise RequestError(
            f"output {shown(str(archive))} must end in .h5: archives are HDF5 files, of which "
            "`nlds-vines export` makes CSV"
        )
    refuse_same(*others, archive)


def refuse_same(*paths: Path | None) -> None:
    """Raise `RequestError` where two files of a run are the same; None is no file."""
    seen: list[Path] = []
    for path in (path for path in paths if path is not None):
        if any(_same(path, other) for other in seen):
            raise RequestError(f"output {shown(str(path))} is another file of this run")
        seen.append(path)


def _same(one: Path, other: Path) -> bool:
    """Tell whether two paths, which may be links, mean one file."""
    try:
        return os.path.realpath(one) == os.path.realpath(other) or os.path.samefile(one, other)
    except (OSError, ValueError):  # one of them does not exist yet, or is none
        return False


def refuse_existing(archive: Path, how: RunOptions) -> None:
    """Raise `RequestError` for an archive that exists, without --resume and --overwrite."""
    if os.path.lexists(archive) and not (how.resume or how.overwrite or how.shard):
        raise RequestError(
            f"output {shown(str(archive))} exists: --resume continues it, "
            "--overwrite replaces it, -o names another file"
        )


def refuse_begun(archive: Path, request: Request, how: RunOptions) -> None:
    """Raise `RequestError` where a run would not begin, which --dry-run then says as well.

    Arguments: the `archive` to be; the `request`; `how` it runs.
    """
    refuse_existing(archive, how)
    from nlds_vines.runs.store import Blocks

    Blocks(archive, request).begin(how)


def refuse_replacing(what: str, path: Path | None, how: RunOptions, own: str = "") -> None:
    """Raise `RequestError` for a file other than an archive that exists, without --overwrite.

    With --resume one is made anew that shows the same request: it carries the text `own`, as a
    picture the hash of its request.
    Arguments: `what` file it is, its `path`, None for no such file; `how` the run goes.
    """
    if path is None or how.overwrite or not os.path.lexists(path):
        return
    if how.resume and own and _carries(path, own):
        return
    raise RequestError(
        f"{what} {shown(str(path))} exists: --overwrite replaces it, another name keeps it"
    )


def _carries(path: Path, text: str) -> bool:
    """Tell whether a file, no larger than such files are, holds a text."""
    try:
        with open_regular(path) as file:
            return text.encode() in file.read(_MOST_BYTES)
    except (OSError, ValueError):
        return False


def check_plot(path: Path, what: str = "--plot") -> None:
    """Raise `RequestError` unless a picture of this path can be drawn and written."""
    if path.suffix.lower() not in PLOT_SUFFIXES:
        raise RequestError(
            f"{what} {shown(str(path))} must end in one of {', '.join(PLOT_SUFFIXES)}"
        )
    check_writable(what, path)
