"""How a run goes: threads, what exists, which blocks, and who computes them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nlds_vines.errors import RequestError, is_command, option, shown, truth, whole
from nlds_vines.runs.executors import MOST_THREADS, Shard, most_threads

if TYPE_CHECKING:
    from concurrent.futures import Executor

_MOST_WORKERS = 1024  # processes of --scheduler local:N

_SCHEDULERS = "local:N or an address such as tcp://node7:8786"

_EXCLUSIVE = (
    ("resume", "overwrite", "give one of them"),
    ("shard", "overwrite", "others may be at work"),
    ("shard", "scheduler", "give one of them"),
    ("scheduler", "executor", "give one of them"),
)
"""The options of a run that exclude each other, and why."""


@dataclass(frozen=True)
class RunOptions:
    """How a run goes; checked when made, before anything heavy is loaded.

    Arguments:
        threads: how many; None for as many as there are processors.
        resume, overwrite: continue or replace what exists; not both.
        shard: compute this share of the blocks only.
        scheduler: `local:N`, or the address of a Dask scheduler whose workers are to compute.
        executor: of `concurrent.futures`, whose workers are to compute; for Python alone.
    """

    threads: int | None = None
    resume: bool = False
    overwrite: bool = False
    shard: Shard | None = None
    scheduler: str | None = None
    quiet: bool = True
    executor: Executor | None = None

    def __post_init__(self) -> None:
        """Raise `RequestError` for wrong options and an environment that loads no kernel."""
        if self.threads is not None:
            whole("threads", self.threads, 1, MOST_THREADS)
        for name in ("resume", "overwrite", "quiet"):
            truth(name, getattr(self, name))
        if self.scheduler is not None and not isinstance(self.scheduler, str):
            raise RequestError(f"scheduler = {shown(self.scheduler)} must be a text: {_SCHEDULERS}")
        if self.executor is not None and not callable(getattr(self.executor, "submit", None)):
            raise RequestError(
                f"executor = {shown(self.executor)} must be an executor of concurrent.futures"
            )
        dashes = "--" if is_command() else ""
        for one, other, why in _EXCLUSIVE:
            has_one = getattr(self, one) not in (None, False)
            has_other = getattr(self, other) not in (None, False)
            if has_one and has_other:
                names = f"{dashes}{one} and {dashes}{other}"
                raise RequestError(f"{names} exclude each other: {why}")
        if (text := self.scheduler) is not None and text.startswith("local:"):
            count = text.removeprefix("local:")
            number = int(count) if re.fullmatch(r"[0-9]{1,9}", count) else count
            whole(f"N of {option('scheduler', 'local:N')}", number, 1, _MOST_WORKERS)
        elif text is not None:
            address = re.fullmatch(r"(tcp|tls|ucx|ws|wss)://\S+:([0-9]{1,5})", text)
            if not (address and 1 <= int(address[2]) <= 65535):
                flag = option("scheduler", shown(text))
                raise RequestError(f"{flag} must be {_SCHEDULERS}")
        most_threads()
