"""A request computed in blocks and its files: the whole of it, or the share of one shard."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nlds_vines.cli import command as commands
from nlds_vines.engine.records import failures_in_words
from nlds_vines.errors import RequestError
from nlds_vines.scans.block import Block, share_in_words
from nlds_vines.scans.run_report import Report


class ScanJob(commands.Job):
    """A job whose run returns a `Report`, and whose archive is written by the last of all shards.

    Its results are what the archive holds, or the report of a shard that has no archive yet.
    """

    def check_picture(self) -> None:
        if self.how.shard is not None:
            raise RequestError(
                "a shard draws nothing: --resume --plot without --shard draws the archive"
            )

    def share(self, blocks: Sequence[Block]) -> list[str]:
        """Return the line of a plan on the share of the blocks that a shard computes."""
        return [] if self.how.shard is None else [share_in_words(blocks, self.how.shard)]

    def results(self) -> Any:
        report: Report = self.compute_archive()
        return self.read(self.archive) if report.is_whole else report

    def lines(self, results: Any) -> list[str]:
        if isinstance(results, Report):
            return [results.summary(), *results.remarks()]
        return super().lines(results)

    def failure(self, results: Any) -> str:
        if isinstance(results, Report):
            return failures_in_words(results.failures, results.lanes)
        return super().failure(results)

    def paths(self) -> list[str]:
        there = self.how.shard is None or self.archive.exists()
        return super().paths() if there else ["the last shard to end writes the archive"]
