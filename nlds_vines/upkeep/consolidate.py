"""Join the parts that shards have computed into one archive.

As a command: `nlds-vines consolidate FILE.h5`.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines.bifurcation.blocks import Block, blocks_of
from nlds_vines.cli.command_main import DONE, Command, say
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import file_path
from nlds_vines.errors import RequestError, shown
from nlds_vines.runs import interrupts
from nlds_vines.runs.interrupts import Interrupted
from nlds_vines.runs.shard import Shard

if TYPE_CHECKING:
    from nlds_vines.bifurcation.block_files import Parts

_EXAMPLES = """\
examples:
  nlds-vines consolidate map.h5
      map.h5.parts, filled by `nlds-vines bifurcation ... -o map.h5 --shard i/n`, becomes map.h5
  nlds-vines consolidate map.h5 --dry-run
      only say what is there and what is missing
exit status: 0 done; 2 blocks are missing, or a run is at work on them; 130, 143 interrupted
"""
_MOST_NAMED = 8  # shards that an error names


def shards_without(parts: Parts, missing: Sequence[Block]) -> list[Shard]:
    """Return the shards with missing blocks; none where the folder does not show their number."""
    names = (path.stem.split("-") for path in parts.folder.glob("shard-*-of-*.lock"))
    counts = {int(words[3]) for words in names}
    if len(counts) != 1:
        return []
    (count,) = counts
    indices = sorted({block.index % count + 1 for block in missing})
    return [Shard(index, count) for index in indices]


def _carry_out(options: argparse.Namespace) -> int:
    """Consolidate the parts of an archive to be; return the exit status."""
    path = file_path(options.file.removesuffix(".parts"))
    if not path.with_name(f"{path.name}.parts").is_dir():
        raise RequestError(f"{shown(str(path))} has no parts: nothing was begun, or all is done")
    return _consolidate(path, options.dry_run, options.quiet)


def _consolidate(path: Path, dry_run: bool, quiet: bool) -> int:
    from nlds_vines.bifurcation.block_files import Parts

    with Parts.begun(path) as parts, interrupts.stop_on_signals() as stop:
        if not parts.complete:
            blocks = list(blocks_of(parts.request))
            _refuse_missing(parts, blocks)
            if dry_run:
                say(f"{path}: all {len(blocks)} blocks are there")
                return DONE
            try:
                parts.consolidate(blocks, check=stop.check)
            except (interrupts.Stopped, KeyboardInterrupt):
                raise Interrupted(
                    f"interrupted: the parts in {parts.folder} are as they were", stop.status
                ) from None
    if not quiet:
        say(path)
    return DONE


def _refuse_missing(parts: Parts, blocks: Sequence[Block]) -> None:
    there = {block.index for block in parts.files.there(blocks)}
    missing = [block for block in blocks if block.index not in there]
    if not missing:
        return
    shards = [str(shard) for shard in shards_without(parts, missing)]
    named = ", ".join(shards[:_MOST_NAMED]) + (" ..." if len(shards) > _MOST_NAMED else "")
    whose = f", of the shards {named}: run these again" if shards else ": --resume computes them"
    raise RequestError(f"{parts.path}: {len(missing)} of {len(blocks)} blocks are missing{whose}")


def _declare(parser: Parser) -> None:
    parser.add_argument("file", metavar="FILE.h5", help="the archive that is to be")
    parser.add_argument("--dry-run", action="store_true", help="only say what is there")
    parser.add_argument("--quiet", action="store_true", help="do not name the archive made")


COMMAND = Command(
    name="consolidate",
    description="Join the parts of a scan into its archive.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
