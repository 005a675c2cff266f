"""The options that say how a run goes: what they mean, what they exclude, how they are declared."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nlds_vines.cli.parser import Parser
from nlds_vines.errors import RequestError, shown, whole
from nlds_vines.runs.executors import MOST_THREADS, Shard, check_environment

if TYPE_CHECKING:
    from concurrent.futures import Executor

_MOST_WORKERS = 1024  # processes of --scheduler local:N, for the same reason


@dataclass(frozen=True)
class RunOptions:
    """How a run goes; checked when made, before anything heavy is loaded.

    Arguments:
        threads: how many; None for as many as there are processors.
        resume, overwrite: continue or replace what exists; not both.
        shard: compute this share of the blocks only.
        scheduler: `local:N`, or the address of a Dask scheduler whose workers are to compute.
        executor: of `concurrent.futures`, whose workers are to compute; for Python alone.
        quiet: show no progress.

    A command without one of these options leaves it at its default.
    """

    threads: int | None = None
    resume: bool = False
    overwrite: bool = False
    shard: Shard | None = None
    scheduler: str | None = None
    quiet: bool = True
    executor: Executor | None = None

    def __post_init__(self) -> None:
        """Raise `RequestError` for values out of range and options that exclude each other.

        Likewise for variables of the environment with which no kernel can be loaded.
        """
        if self.threads is not None:
            whole("threads", self.threads, 1, MOST_THREADS)
        if self.resume and self.overwrite:
            raise RequestError("resume and overwrite exclude each other: give one of them")
        if self.shard is not None and self.overwrite:
            raise RequestError("--shard and --overwrite exclude each other: others may be at work")
        if self.shard is not None and self.scheduler is not None:
            raise RequestError("--shard and --scheduler exclude each other: give one of them")
        if self.executor is not None and self.scheduler is not None:
            raise RequestError("scheduler and executor exclude each other: give one of them")
        if self.scheduler is not None:
            _check_scheduler(self.scheduler)
        check_environment()


def _check_scheduler(text: str) -> None:
    if text.startswith("local:"):
        count = text.removeprefix("local:")
        number = int(count) if re.fullmatch(r"[0-9]{1,9}", count) else count
        whole("N of --scheduler local:N", number, 1, _MOST_WORKERS)
    elif not (
        (found := re.fullmatch(r"(tcp|tls|ucx|ws|wss)://\S+:([0-9]{1,5})", text))
        and 1 <= int(found[2]) <= 65535
    ):
        allowed = "local:N or an address such as tcp://node7:8786"
        raise RequestError(f"--scheduler {shown(text)} must be {allowed}")


def add_run_options(parser: Parser) -> None:
    """Declare all options of a run, --dry-run beside them."""
    group = add_local_options(parser)
    group.add_argument("--shard", metavar="i/n", help="only this share of the blocks; or slurm")
    group.add_argument("--scheduler", metavar="WHERE", help="Dask: an address, or local:N")


def add_local_options(parser: Parser, threads: bool = True) -> argparse._ArgumentGroup:
    """Declare the options of a run on this machine alone, --dry-run beside them.

    Arguments: `threads` is False for a command that does not let them be chosen.
    Returns the group in the help, for further options.
    """
    group = parser.add_argument_group("running")
    if threads:
        group.add_argument("--threads", type=int, metavar="N", help="by default all processors")
    existing = group.add_mutually_exclusive_group()
    existing.add_argument("--resume", action="store_true", help="continue an archive")
    existing.add_argument("--overwrite", action="store_true", help="replace an archive")
    group.add_argument("--dry-run", action="store_true", help="only say what it would take")
    group.add_argument("--quiet", action="store_true", help="show no progress")
    return group


def run_options(options: argparse.Namespace) -> RunOptions:
    """Return how the options of a command say that the run goes; `RequestError` as `RunOptions`."""
    given = {name: value for name, value in vars(options).items() if name in _NAMES}
    if given.get("shard") is not None:
        given["shard"] = Shard.parse(given["shard"])
    return RunOptions(**given)


_NAMES = frozenset(RunOptions.__dataclass_fields__)
