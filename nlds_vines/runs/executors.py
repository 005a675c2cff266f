"""Who computes: threads of this process, other workers, one of several shards; what it has."""

from __future__ import annotations

import os
import re
import shutil
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from nlds_vines.errors import RequestError, option, shown
from nlds_vines.runs import interrupts

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

MOST_THREADS = 4096  # that may be asked for: more than any machine has, to notice a typing error
MOST_SHARDS = 10_000  # of one scan: more than any cluster has tasks, to notice a typing error
SHARE = 4  # a piece is at most this part of one thread's share of the lanes that are left
POLL_SECONDS = 0.2  # seconds between two looks at what other workers do
STALL_SECONDS = 60.0  # seconds without a finished block until a line says so, again and again
MOST_TRIES = 4  # tries of one block, after which the run ends

Item = TypeVar("Item")
Result = TypeVar("Result")

_used: int | None = None  # as `use_threads` was asked; None for all


def use_threads(threads: int | None) -> int:
    """Let the kernels use so many threads, at most and by default one per processor."""
    global _used
    most = most_threads()
    _used = most if threads is None else min(threads, most)
    return _used


def threads_in_use() -> int:
    """Return how many threads the kernels use: all there are until `use_threads` says otherwise."""
    return most_threads() if _used is None else _used


def most_threads(environment: Mapping[str, str] = os.environ) -> int:
    """Return how many may be used: NUMBA_NUM_THREADS, or the processors for this process.

    Raises `RequestError` for a number with which Numba could not even be loaded: Numba itself
    raises errors of many lines, or passes over what it cannot read.
    """
    number = environment.get("NUMBA_NUM_THREADS")
    if number is None:
        return processors()
    count = int(number) if re.fullmatch(r"\s*[0-9]{1,9}\s*", number) else 0
    if not 1 <= count <= MOST_THREADS:
        raise RequestError(
            f"NUMBA_NUM_THREADS = {shown(number)} in the environment must be a whole number from 1 "
            f"to {MOST_THREADS}"
        )
    return count


def in_pieces(
    work: Callable[[int, int], object], lanes: int, least: int = 1, most: int | None = None
) -> None:
    """Call `work(begin, end)` for pieces that make up range(lanes), on the threads in use.

    Compiled kernels release the lock of Python's interpreter, so plain threads run side by side.
    A piece has at least `least` lanes, and `most` where a few may take as long as all others.  As
    lanes take very different times, a thread that has finished its piece takes the next one, and
    pieces become smaller towards the end.  The calling thread does its part.

    What a piece raises is raised here, when no thread is at work any more; no piece is begun after
    that, nor after the work was abandoned (`interrupts.stoppable`).
    """
    threads = min(threads_in_use(), lanes // max(1, least))
    if threads < 2:
        work(0, lanes)
        return
    lock, errors, begun = threading.Lock(), list[BaseException](), 0
    is_abandoned = interrupts.abandoned()

    def run() -> None:
        nonlocal begun
        try:
            while True:
                with lock:
                    left = 0 if errors or is_abandoned() else lanes - begun
                    begin, size = begun, left // (SHARE * threads)
                    size = max(least, size if most is None else min(size, most))
                    end = begun = begin + min(left, size)
                if begin == end:
                    return
                work(begin, end)
        except BaseException as error:
            errors.append(error)

    helpers = [threading.Thread(target=run, daemon=True) for _ in range(threads - 1)]
    for helper in helpers:
        helper.start()
    run()
    for helper in helpers:
        helper.join()
    if errors:
        raise errors[0]


def as_finished(
    executor: Executor, work: Callable[[Item], Result], items: Iterable[Item], ahead: int
) -> Iterator[tuple[Item, Result]]:
    """Yield each item with `work(item)`, as an executor of `concurrent.futures` finishes them.

    At most `ahead` are under way.  What fails is tried again, as a worker may be lost.

    Raises `RequestError` if a worker refuses an item, if one fails `MOST_TRIES` times or if no
    worker is left, `CancelledError` where the executor gives up, `Stopped` on a signal.
    """
    from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, wait

    waiting, failures = deque(items), Counter[Item]()
    under_way: dict[Future[Result], Item] = {}
    finished = reported = time.monotonic()
    try:
        while waiting or under_way:
            while waiting and len(under_way) < ahead:
                item = waiting.popleft()
                under_way[executor.submit(work, item)] = item
            interrupts.check()
            done, _ = wait(under_way, POLL_SECONDS, FIRST_COMPLETED)
            for future in done:
                item = under_way.pop(future)
                try:
                    result = future.result()
                except (RequestError, CancelledError, BrokenExecutor):
                    raise
                except Exception as error:
                    failures[item] += 1
                    if failures[item] == MOST_TRIES:
                        raise RequestError(
                            f"block {item} has failed {MOST_TRIES} times, at last: "
                            f"{type(error).__name__}: {error}; {option('resume')} tries again"
                        ) from error
                    waiting.appendleft(item)
                else:
                    finished = reported = time.monotonic()
                    yield item, result
            if time.monotonic() - reported > STALL_SECONDS:
                reported = time.monotonic()
                text = f"no block has been finished for {reported - finished:.0f} s"
                print(text, file=sys.stderr, flush=True)
    except BrokenExecutor as error:  # by `submit`, too, if the executor already knows
        raise RequestError(f"a worker has died: {error}; {option('resume')} goes on") from error
    finally:
        for future in under_way:
            future.cancel()


@dataclass(frozen=True)
class Shard:
    """One of `count` equal shares of the blocks of a scan; `index` counts from 1."""

    index: int
    count: int

    def __str__(self) -> str:
        return f"{self.index}/{self.count}"

    @property
    def blocks(self) -> slice:
        """Its blocks: every `count`-th, so that each shard has some of those that take long."""
        return slice(self.index - 1, None, self.count)

    @classmethod
    def parse(cls, text: str, environment: Mapping[str, str] = os.environ) -> Shard:
        """Return the share that `3/7` means, or `slurm`: that of this task of a job array."""
        if text != "slurm":
            if share := re.fullmatch(r"(\d{1,9})/(\d{1,9})", text, re.ASCII):
                index, count = map(int, share.groups())
                if 1 <= index <= count <= MOST_SHARDS:
                    return cls(index, count)
            allowed = f"i/n with i from 1 to n and n up to {MOST_SHARDS}, or slurm"
            raise RequestError(f"--shard {shown(text)} must be {allowed}")
        names = [f"SLURM_ARRAY_TASK_{name}" for name in ("ID", "MIN", "MAX", "COUNT")]
        texts = [environment.get(name, "") for name in names]
        for name, text in zip(names, texts, strict=True):
            if not (text.isascii() and text.isdigit()):
                where = f"{name} = {shown(text)}"
                raise RequestError(f"--shard slurm: {where} must be a number; is this a job array?")
        here, low, high, count = map(int, texts)
        if not (low <= here <= high and high - low + 1 == count <= MOST_SHARDS):
            raise RequestError(
                f"--shard slurm: task {here} of {count} from {low} to {high}: the array must be "
                f"numbered without gaps and have up to {MOST_SHARDS} tasks; else give --shard i/n"
            )
        return cls(here - low + 1, count)


def processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def free_memory() -> int | None:
    """Return the bytes that this process may still take; None if unknown."""
    limits = []
    for path, key in (
        ("/proc/meminfo", "MemAvailable:"),
        ("/sys/fs/cgroup/memory.max", ""),
        ("/proc/self/limits", "Max address space"),
    ):
        with suppress(OSError):
            for line in Path(path).read_text(encoding="ascii").splitlines():
                words = line.removeprefix(key).split()
                if line.startswith(key) and words and words[0].isdigit():
                    limits.append(int(words[0]) * (1024 if words[1:] == ["kB"] else 1))
    return min(limits, default=None)


def free_disk(folder: Path) -> int | None:
    try:
        return shutil.disk_usage(folder).free
    except OSError:
        return None
