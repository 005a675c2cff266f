"""Check archives, and the parts of runs under way, from end to end.

As a command: `nlds-vines verify FILE...`.  In Python: `nlds_vines.verify(path)` for an archive.
"""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.cli.command_main import DAMAGED, DONE, WRONG_REQUEST, Command, complain, say
from nlds_vines.cli.parser import Parser
from nlds_vines.errors import RequestError, shown

if TYPE_CHECKING:
    from nlds_vines.runs.manifest import Manifest

_NAME = "verify"
_EXAMPLES = """\
examples:
  nlds-vines verify figure8.h5
      every dataset is read, every seal is checked
  nlds-vines verify map.h5.parts
      likewise for the parts of a scan or tuning under way, or of one that was interrupted
exit status: 0 all sound; 1 something is damaged; 2 the request is wrong
"""


def problems(path: Path) -> list[str]:
    """Return what is wrong with an archive or with a folder of parts; empty if it is sound.

    Each line names the dataset or the part that is damaged.  Raises `RequestError` if there is
    neither file nor folder.
    """
    if path.is_dir():
        return list(_of_parts(path))
    if not path.exists():
        raise RequestError(f"{shown(str(path))}: there is no such file")
    from nlds_vines.archives import archive

    return archive.verify(path)


def _of_parts(folder: Path) -> Iterator[str]:
    """Yield what is wrong with the parts in a folder, the manifest first."""
    from nlds_vines.runs.manifest import NAME, SCAN, Manifest
    from nlds_vines.runs.partfile import PATTERN

    names = {path.name for path in folder.glob(PATTERN)}
    try:
        manifest = Manifest.read(folder)
    except RequestError as error:
        yield str(error)
        return
    if manifest is None and not names:
        raise RequestError(f"{shown(str(folder))} is a folder without parts")
    if manifest is None:
        yield f"{folder / NAME} is missing: the request of these parts is not known"
        return
    yield from (_of_scan if manifest.content == SCAN else _of_numbered_parts)(
        folder, manifest, names
    )


def _of_scan(folder: Path, manifest: Manifest, names: AbstractSet[str]) -> Iterator[str]:
    """Yield what is wrong with the parts of a scan, of these names."""
    from nlds_vines.bifurcation.block_files import PartFiles, scan_of
    from nlds_vines.runs.manifest import NAME
    from nlds_vines.runs.partfile import LEARNT, UNSOUND

    try:
        scan = scan_of(manifest)
    except RequestError as error:
        yield f"{folder / NAME}: {error}"
        return
    files = PartFiles(folder, scan)
    if scan.hash != manifest.scan_hash:
        yield f"{folder / NAME} holds another scan than it says, or one of another version"
        return
    try:
        files.learnt()
    except (*UNSOUND, OSError) as error:
        yield f"part {LEARNT} is damaged: {error}"
    blocks = list(blocks_of(scan))
    for block in files.there(blocks):
        try:
            files.load(block)
        except (*UNSOUND, OSError) as error:
            yield f"part {files.path(block).name} is damaged: {error}"
    for name in sorted(names - {files.path(block).name for block in blocks}):
        yield f"part {name} belongs to no block of this scan"


def _of_numbered_parts(folder: Path, manifest: Manifest, names: AbstractSet[str]) -> Iterator[str]:
    """Yield what is wrong with the parts of a tuning or a survey, which are numbered in order."""
    from nlds_vines.runs.partfile import UNSOUND, fetch, identity, path_of

    there = {path_of(folder, index).name: index for index in range(len(names))}
    for name, index in there.items():
        try:
            fetch(folder / name, identity(manifest.scan_hash, index))
        except FileNotFoundError:
            yield f"part {name} is missing, and others after it are there"
        except (*UNSOUND, OSError) as error:
            yield f"part {name} is damaged: {error}"
    for name in sorted(names - there.keys()):
        yield f"part {name} is out of order"


def _verified(path: Path, quiet: bool) -> int:
    """Verify one file or folder, print what is wrong and return the exit status that it means."""
    try:
        found = problems(path)
    except RequestError as error:
        complain(_NAME, f"error: {error}")
        return WRONG_REQUEST
    for problem in found:
        say(f"{path}: {problem}")
    if not found and not quiet:
        say(f"{path}: sound")
    return DAMAGED if found else DONE


def _declare(parser: Parser) -> None:
    parser.add_argument("files", nargs="+", metavar="FILE", help="FILE.h5 or FILE.h5.parts")
    parser.add_argument("--quiet", action="store_true", help="name only what is damaged")


COMMAND = Command(
    name=_NAME,
    description="Check archives, or folders of parts, from end to end.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=lambda options: max(_verified(Path(n), options.quiet) for n in options.files),
)
main = COMMAND.main
