"""The progress of a scan, read from its parts while it runs, without disturbing it.

As a command: `nlds-vines status FILE.h5`.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from nlds_vines.bifurcation.orbit_counts import COUNTED, Tally
from nlds_vines.cli.command_main import DONE, Command, say
from nlds_vines.cli.parser import Parser
from nlds_vines.cli.paths import file_path
from nlds_vines.errors import RequestError, shown
from nlds_vines.runs.progress import duration

if TYPE_CHECKING:
    from nlds_vines.bifurcation.request import Scan

_EXAMPLES = """\
examples:
  nlds-vines status map.h5
      blocks, orbits, regimes and failures so far, who is at work, how long it will take
  watch -n 60 nlds-vines status map.h5
      likewise, every minute
exit status: 0 done; 2 there is no such scan
"""
_RECENT = 64  # blocks from which the pace is taken: the latest
_PAUSE = 10.0  # a gap of this many times the longest block (plus 1 s) is a pause, and left out


@dataclass
class Standing:
    """The progress of the scan in a folder of parts."""

    scan: Scan
    began: str
    blocks: int
    tally: Tally = field(default_factory=Tally)
    unreadable: int = 0
    stored: list[tuple[float, int, float]] = field(default_factory=list)  # when, orbits, seconds
    workers: list[str] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Return it, one fact a line."""
        done, lanes = len(self.stored), self.scan.lanes
        share = f"{self.tally.lanes} of {lanes} ({100 * self.tally.lanes / lanes:.3g} %)"
        damaged = f", {self.unreadable} unreadable" if self.unreadable else ""
        return [
            self.scan.title,
            f"begun:    {self.began}",
            f"blocks:   {done} of {self.blocks}{damaged}",
            f"orbits:   {share}, {self.tally.failed} failed",
            f"regimes:  {self.tally.regimes() or 'none known yet'}",
            *self.tally.inadmissible(),
            f"at work:  {', '.join(self.workers) or 'no run that can be seen from here'}",
            *self._pace(),
        ]

    def _pace(self) -> list[str]:
        """Return the pace of the latest blocks, and how long the rest takes at that pace."""
        if not self.stored:
            return []
        ago = f"last block {duration(max(0.0, time.time() - self.stored[-1][0]))} ago"
        rate, left = self.rate(), self.scan.lanes - self.tally.lanes
        if rate is None:
            return [f"pace:     {ago}"]
        to_go = f"{duration(left / rate)} to go" if left else "only the archive is to be written"
        return [f"pace:     {rate:.3g} orbits a second, {ago}", f"estimate: {to_go}"]

    def rate(self) -> float | None:
        """Return the orbits stored per second in the latest blocks, without pauses; or None."""
        recent = self.stored[-_RECENT:]
        longest = max((seconds for _, _, seconds in recent), default=0.0)
        for i, (one, other) in reversed(list(enumerate(pairwise(recent), 1))):
            if other[0] - one[0] > _PAUSE * (longest + 1.0):
                recent = recent[i:]
                break
        span = recent[-1][0] - recent[0][0] if recent else 0.0
        return sum(lanes for _, lanes, _ in recent[1:]) / span if span > 0 else None


def standing(folder: Path) -> Standing:
    """Return the progress of the scan in a folder of parts, without a lock and without a change.

    Raises `RequestError` if nothing was begun there.
    """
    from nlds_vines.bifurcation.block_files import PartFiles, scan_of
    from nlds_vines.bifurcation.blocks import blocks_of
    from nlds_vines.runs.manifest import Manifest

    manifest = Manifest.read(folder)
    if manifest is None:
        raise RequestError(f"{shown(str(folder))}: nothing was begun there")
    scan = scan_of(manifest)
    blocks = list(blocks_of(scan))
    files = PartFiles(folder, scan)
    found = Standing(scan, manifest.began, len(blocks), workers=_workers(folder))
    for block in files.there(blocks):
        try:
            part, when = files.peek(block, COUNTED), files.path(block).stat().st_mtime
            found.tally.note(part.arrays)
        except FileNotFoundError:  # removed since: it is being computed again, or joined
            continue
        except (OSError, ValueError, KeyError, TypeError):
            found.unreadable += 1
            continue
        found.stored.append((when, part.arrays["status"].size, part.made.seconds))
    found.stored.sort()
    return found


def _workers(folder: Path) -> list[str]:
    """Return which runs and shards lock the folder, as far as its file system shows it."""
    from nlds_vines.archives.durable import held

    shards = [path.stem.split("-") for path in sorted(folder.glob("shard-*-of-*.lock"))]
    at_work = [f"{w[1]}/{w[3]}" for w in shards if held(folder / f"{'-'.join(w)}.lock")]
    return (["a run"] if held(folder / "lock") else []) + [f"shard {name}" for name in at_work]


def _carry_out(options: argparse.Namespace) -> int:
    """Print the progress of a scan; return the exit status."""
    path = file_path(options.file.removesuffix(".parts"))
    folder = path.with_name(f"{path.name}.parts")
    if folder.is_dir():
        say(*standing(folder).lines())
    elif path.is_file():
        say(*_of_archive(path))
    else:
        raise RequestError(f"{shown(str(path))}: there is no such archive, and no parts of one")
    return DONE


def _of_archive(path: Path) -> list[str]:
    """Return the counts of a finished scan, one line each."""
    from nlds_vines.archives import archive
    from nlds_vines.runs.manifest import refuse_unless_scan

    tally = Tally()
    with archive.read(path) as view:
        refuse_unless_scan(f"{shown(str(path))} holds", view.content)
        tally.note({name: view[name] for name in COUNTED if name in view})
        title = view.text("title")
    return [
        title,
        f"orbits:   {tally.lanes}, complete, {tally.failed} failed",
        f"regimes:  {tally.regimes() or 'not recorded'}",
        *tally.inadmissible(),
    ]


def _declare(parser: Parser) -> None:
    parser.add_argument("file", metavar="FILE.h5", help="the archive that is to be")


COMMAND = Command(
    name="status",
    description="Tell how a scan stands, while it runs or after it was interrupted.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
