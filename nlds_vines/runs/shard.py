"""Shards: the share of a scan that one of several machines computes."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass

from nlds_vines.errors import RequestError, shown

MOST_SHARDS = 10_000
"""Shards of one scan: more than any cluster has tasks, so that a typing error is noticed."""


@dataclass(frozen=True)
class Shard:
    """One of `count` equal shares of a scan; `index` counts from 1."""

    index: int
    count: int

    def __str__(self) -> str:
        """Return it as it is given: `3/7`."""
        return f"{self.index}/{self.count}"

    def has(self, number: int) -> bool:
        """Tell whether the block of this number belongs to this share: every `count`-th does.

        So the regions of a scan that take long are spread over all shards.
        """
        return number % self.count == self.index - 1

    @classmethod
    def parse(cls, text: str, environment: Mapping[str, str] = os.environ) -> Shard:
        """Return the share that `3/7` means, or `slurm`: that of this task of a job array.

        Raises `RequestError` for anything else, and for an array with gaps in its numbers.
        """
        if text == "slurm":
            return cls._of_array(environment)
        if found := re.fullmatch(r"(\d{1,9})/(\d{1,9})", text, re.ASCII):
            index, count = map(int, found.groups())
            if 1 <= index <= count <= MOST_SHARDS:
                return cls(index, count)
        allowed = f"i/n with i from 1 to n and n up to {MOST_SHARDS}, or slurm"
        raise RequestError(f"--shard {shown(text)} must be {allowed}")

    @classmethod
    def _of_array(cls, environment: Mapping[str, str]) -> Shard:
        """Return the share of the task that SLURM's variables name."""
        names = ("ID", "MIN", "MAX", "COUNT")
        found = {name: environment.get(f"SLURM_ARRAY_TASK_{name}", "") for name in names}
        for name, text in found.items():
            if not (text.isascii() and text.isdigit()):
                where = f"SLURM_ARRAY_TASK_{name} = {shown(text)}"
                raise RequestError(f"--shard slurm: {where} must be a number; is this a job array?")
        here, low, high, count = (int(found[name]) for name in names)
        if not (low <= here <= high and high - low + 1 == count <= MOST_SHARDS):
            raise RequestError(
                f"--shard slurm: task {here} of {count} from {low} to {high}: the array must be "
                f"numbered without gaps and have up to {MOST_SHARDS} tasks; else give --shard i/n"
            )
        return cls(here - low + 1, count)
