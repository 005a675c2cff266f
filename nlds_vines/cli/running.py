"""Checks of the files of a command, before anything is computed, and its options of a run."""

from __future__ import annotations

import argparse
import os
import tempfile
from dataclasses import fields
from pathlib import Path
from typing import Any

from nlds_vines.archives.files import open_regular, protection
from nlds_vines.cli.options import Parser
from nlds_vines.errors import RequestError, option, refuse_bytes, shown
from nlds_vines.runs.executors import Shard
from nlds_vines.runs.run_options import RunOptions

PLOT_SUFFIXES = (".png", ".pdf", ".svg")  # by which kinds of pictures are chosen
ARCHIVE_SUFFIXES = (".h5", ".hdf5", ".nc")  # HDF5 files, which netCDF-4 reads, too
_MOST_BYTES = 1 << 28  # of a picture or a page (256 MB): what is larger is none of ours


def add_run_options(parser: Parser, threads: bool = True, cluster: bool = False) -> None:
    """Declare the options of a run; with `cluster`, those by which blocks go to other machines."""
    group = parser.add_argument_group("running")
    if threads:
        group.add_argument("--threads", type=int, metavar="N", help="by default all processors")
    existing = group.add_mutually_exclusive_group()
    existing.add_argument("--resume", action="store_true", help="continue an archive")
    existing.add_argument("--overwrite", action="store_true", help="replace an archive")
    group.add_argument("--dry-run", action="store_true", help="only say what it would take")
    group.add_argument("--quiet", action="store_true", help="show no progress")
    if cluster:
        group.add_argument("--shard", metavar="i/n", help="only this share of the blocks; or slurm")
        group.add_argument("--scheduler", metavar="WHERE", help="Dask: an address, or local:N")


def run_options(options: argparse.Namespace) -> RunOptions:
    """Return how the options of a command say that the run goes; `RequestError` as `RunOptions`."""
    values = {f.name: getattr(options, f.name) for f in fields(RunOptions) if f.name in options}
    if values.get("shard") is not None:
        values["shard"] = Shard.parse(values["shard"])
    return RunOptions(**values)


def optional_path(value: str | os.PathLike[str] | None, what: str = "path") -> Path | None:
    if value is None:
        return None
    if not isinstance(value, str | os.PathLike):
        raise RequestError(f"{what} = {shown(value)} must be the path of a file")
    return Path(value)


def existing(text: str | os.PathLike[str], option: str = "") -> Path:
    """Return the path of a file that is there; `RequestError` without one, named by its option."""
    path = Path(text)
    if not path.is_file():
        reason = "it is no regular file" if path.exists() else "there is no such file"
        raise RequestError(f"{option} {shown(str(path))}: {reason}".strip())
    return path


def request_path(source: Any) -> Path | None:
    """Return the path of a request file, if a source is one."""
    is_path = isinstance(source, os.PathLike)
    is_name = isinstance(source, str) and source.endswith(".toml")
    return Path(source) if is_path or is_name else None


def check_writable(what: str, path: Path, *, archive: bool = False) -> None:
    """Raise `RequestError` unless a file of this path can be written; nothing is left behind.

    So must be what a symbolic link points to.  Only an `archive` has its name or replaces one.
    """
    refuse_bytes(what, str(path))
    named = f"{what} {shown(str(path))}"
    if not archive and path.suffix.lower() in ARCHIVE_SUFFIXES:
        raise RequestError(f"{named}: such a name is for archives alone")
    for place in dict.fromkeys([path, Path(os.path.realpath(path))]):
        if os.path.isdir(place):  # unlike `Path.is_dir`, never raises
            raise RequestError(f"{named} is a folder: name a file")
        if not os.path.isdir(place.parent):
            raise RequestError(f"{named}: there is no folder {str(place.parent)!r}")
        try:  # permission bits and the length of a name do not decide it on every file system
            tempfile.NamedTemporaryFile(dir=place.parent, prefix=f"{place.name}.").close()
            reason = protection(place, archive=archive)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
        if reason is not None:
            raise RequestError(f"{named} cannot be written: {reason}")


def check_output(archive: Path, *others: Path | None) -> None:
    """Raise `RequestError` unless an archive of this path, none of `others`, can be written."""
    check_writable("output", archive, archive=True)
    if archive.suffix.lower() not in ARCHIVE_SUFFIXES:
        raise RequestError(
            f"output {shown(str(archive))} must end in .h5: archives are HDF5 files, of which "
            "`nlds-vines export` makes CSV"
        )
    refuse_same(*others, archive)


def check_plot(path: Path, what: str = "--plot") -> None:
    """Raise `RequestError` unless a picture of this path can be drawn and written."""
    if path.suffix.lower() not in PLOT_SUFFIXES:
        raise RequestError(
            f"{what} {shown(str(path))} must end in one of {', '.join(PLOT_SUFFIXES)}"
        )
    check_writable(what, path)


def refuse_same(*paths: Path | None) -> None:
    """Raise `RequestError` if two files of a run are the same, links included; None is no file."""
    seen: list[Path] = []
    for path in filter(None, paths):
        for other in seen:
            try:
                same = os.path.realpath(path) == os.path.realpath(other)
                same = same or os.path.samefile(path, other)
            except (OSError, ValueError):  # one of them does not exist yet, or is none
                same = False
            if same:
                raise RequestError(f"output {shown(str(path))} is another file of this run")
        seen.append(path)


def refuse_replacing(what: str, path: Path | None, overwrite: bool, mark: str = "") -> None:
    """Raise `RequestError` for a file other than an archive that exists, without `overwrite`.

    A file that holds the text `mark` may be replaced: a picture holds the hash of its request.
    """
    if path is None or overwrite or not os.path.lexists(path):
        return
    if mark:
        try:
            with open_regular(path) as file:
                if mark.encode() in file.read(_MOST_BYTES):
                    return
        except (OSError, ValueError):
            pass
    words = f"{option('overwrite')} replaces it, another name keeps it"
    raise RequestError(f"{what} {shown(str(path))} exists: {words}")
