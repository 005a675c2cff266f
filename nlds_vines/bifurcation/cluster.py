"""Blocks on the workers of a Dask cluster, which may be lost, killed and replaced at any time.

This is the only module that imports `distributed` (extra `cluster`).  A task computes one block,
writes the part into the shared folder and returns the number of the block.  A task that is done
twice does no harm: both times the same bytes are written under the same name.  So what is not known
to be finished is submitted again; only the verified part in the folder counts.
"""

from __future__ import annotations

import logging
import os
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nlds_vines.archives.provenance import makers
from nlds_vines.bifurcation.block_files import PartFiles, scan_of
from nlds_vines.bifurcation.blocks import Block
from nlds_vines.bifurcation.orbit_counts import Note
from nlds_vines.errors import RequestError, shown
from nlds_vines.runs.interrupts import Stop
from nlds_vines.runs.manifest import Manifest

if TYPE_CHECKING:
    from nlds_vines.bifurcation.block_files import Parts
    from nlds_vines.bifurcation.compute import Computer

BLOCKS_PER_WORKER = 2
"""Blocks submitted at a time for each worker: one to compute, one that waits beside it."""

POLL_SECONDS = 0.5
"""Seconds between two looks at the futures."""

STALL_SECONDS = 60.0
"""Seconds without a finished block until all is submitted again; doubled each time."""

MOST_STALLS = 6
"""Stalls in a row, two hours in all, after which the run ends."""

MOST_TRIES = 8
"""Tries of one block, after which the run ends."""

CONNECT_SECONDS = 30.0
"""Seconds to reach a scheduler."""

_UNREACHABLE = (OSError, ValueError, TypeError, RuntimeError, ImportError, TimeoutError)
"""The errors of a client: TypeError where it has no certificate for an address `tls://`."""

_one_at_a_time = threading.Lock()  # kernels are parallel inside: two at a time slow each other


def compute(
    parts: Parts,
    blocks: Sequence[Block],
    scheduler: str,
    threads: int | None,
    note: Note,
    stop: Stop,
) -> None:
    """Compute blocks on a cluster, and return when their parts are in the folder and verified.

    Arguments: `scheduler` is `local:N` for N processes here, or the address of a scheduler whose
    workers see the folder of the parts under the same path; `threads` of one worker, by default 1
    for processes here, and what they were started with for others; `note` is called with the
    arrays of every block that is done.

    Raises `RequestError` where there is no such scheduler, a worker cannot write, or no block is
    finished any more; `interrupts.Stopped` when a signal has asked to stop.
    """
    if not blocks:
        return
    with _without_logs(), _client(scheduler, threads) as client:
        try:
            _refuse_others(client)
            _Blocks(parts, blocks, client, threads, note).run(stop)
        except (OSError, TimeoutError, CancelledError) as error:
            text = f"--scheduler {shown(scheduler)} is gone; --resume goes on elsewhere"
            reason = "" if isinstance(error, CancelledError) else f": {error}"
            raise RequestError(f"{text}{reason}") from error


def _refuse_others(client: Any) -> None:
    """Raise `RequestError` where a worker has other versions than are here, or has not all."""
    try:
        there = client.run(makers)
    except ImportError as error:
        raise RequestError(f"a worker has not what it needs: {error}") from error
    for address, found in there.items():
        if different := _different(found):
            raise RequestError(f"the worker {address} is of another version: {different}")


def _different(found: Mapping[str, str]) -> str:
    """Return in which versions a worker differs from those here, in words; empty for none."""
    pairs = ((name, found.get(name), here) for name, here in makers().items())
    return ", ".join(f"{name} {there}, here {here}" for name, there, here in pairs if there != here)


def work(
    folder: str, scan_hash: str, block: Block, threads: int | None, asked_by: Mapping[str, str]
) -> int:
    """Compute a block of the scan in a folder of parts, on a worker; return the block's index.

    Arguments: `asked_by`, the versions of who asks; raises `RequestError` where others are here,
    as on a worker that came late.
    """
    if different := _different(asked_by):
        raise RequestError(f"its worker was asked by another version: {different}")
    with _one_at_a_time:
        began = time.perf_counter()
        from nlds_vines.runs.executors import use_threads

        computer, files = _prepared(folder, scan_hash)
        used = use_threads(threads)
        arrays = computer.block(block)
        files.write(block, arrays, seconds=time.perf_counter() - began, threads=used)
    return block.index


@lru_cache(maxsize=2)
def _prepared(folder: str, scan_hash: str) -> tuple[Computer, PartFiles]:
    """Return the computer and the part files of a scan, prepared once in a worker.

    Raises `RequestError` if the folder does not hold that scan, as seen from here.
    """
    from nlds_vines.bifurcation.compute import Computer

    manifest = Manifest.read(Path(folder))
    if manifest is None or manifest.scan_hash != scan_hash:
        raise RequestError(f"a worker does not find the scan in {folder}: is the folder shared?")
    scan = scan_of(manifest)
    return Computer(scan, helped=False), PartFiles(Path(folder), scan)


class _Blocks:
    """The blocks of one scan on a cluster: waiting, under way, done."""

    def __init__(
        self,
        parts: Parts,
        blocks: Sequence[Block],
        client: Any,
        threads: int | None,
        note: Note,
    ) -> None:
        self._parts, self._client, self._note = parts, client, note
        self._waiting = deque(blocks)
        self._under_way: dict[Any, Block] = {}  # by future
        self._failures: Counter[int] = Counter()
        self._longest = 0.0
        self._stalls = 0
        self._moved = time.monotonic()
        self._where = str(parts.folder.resolve()), parts.request.hash
        self._threads = threads

    def run(self, stop: Stop) -> None:
        """Submit, collect and submit again until every block is done."""
        while self._waiting or self._under_way:
            stop.check()
            self._submit()
            for future in self._ended():
                self._collect(future)
            self._watch()

    def _submit(self) -> None:
        """Keep about twice as many blocks under way as there are workers."""
        room = BLOCKS_PER_WORKER * max(1, self._workers()) - len(self._under_way)
        for _ in range(min(room, len(self._waiting))):
            block = self._waiting.popleft()
            future = self._client.submit(
                work, *self._where, block, self._threads, makers(), pure=False
            )
            self._under_way[future] = block

    def _workers(self) -> int:
        return len(self._client.nthreads())

    def _ended(self) -> list[Any]:
        """Return the futures that have ended, if need be after a moment."""
        from distributed import wait

        try:
            wait(list(self._under_way), timeout=POLL_SECONDS, return_when="FIRST_COMPLETED")
        except TimeoutError:
            return []
        return [future for future in self._under_way if future.status != "pending"]

    def _collect(self, future: Any) -> None:
        """Count the block of a future if its part is there and sound; else submit it again."""
        block = self._under_way.pop(future)
        reason = self._failure(future)
        future.release()
        reason = reason or self._count(block)
        if reason is not None:
            self._again(block, reason)

    def _count(self, block: Block) -> str | None:
        """Count a block whose part is there and sound; return what is wrong with it, else None."""
        try:
            part = self._parts.load(block)
        except FileNotFoundError:
            return f"its worker does not write into {self._parts.folder}: is it shared?"
        except ValueError as error:
            return str(error)
        self._longest = max(self._longest, part.made.seconds)
        self._moved, self._stalls = time.monotonic(), 0
        self._note(part.arrays)
        return None

    def _failure(self, future: Any) -> str | None:
        """Return why a future has no result; None where it has one."""
        if future.status == "finished":
            return None
        if future.status != "error":
            return f"its task was {future.status}"
        error = future.exception()
        return str(error) if isinstance(error, RequestError) else f"{type(error).__name__}: {error}"

    def _again(self, block: Block, reason: str) -> None:
        """Put a block back among those that wait; `RequestError` after too many tries."""
        self._failures[block.index] += 1
        if self._failures[block.index] >= MOST_TRIES:
            raise RequestError(
                f"block {block.index} has failed {MOST_TRIES} times, at last: {reason}; "
                "--resume tries again"
            )
        self._waiting.appendleft(block)

    def _watch(self) -> None:
        """Submit again what is under way when no block has been finished for long.

        The first blocks take as long as compiling does, so the time grows from stall to stall.
        Raises `RequestError` after `MOST_STALLS` of them.
        """
        if time.monotonic() - self._moved < STALL_SECONDS * 2**self._stalls + 10 * self._longest:
            return
        self._moved, self._stalls = time.monotonic(), self._stalls + 1
        workers = self._workers()
        if self._stalls > MOST_STALLS:
            raise RequestError(
                f"no block has been finished by {workers} workers for long; --resume goes on"
            )
        print(f"no progress: {workers} workers; submitting again", file=sys.stderr, flush=True)
        futures, blocks = list(self._under_way), list(self._under_way.values())
        self._client.cancel(futures, force=True)
        self._under_way.clear()
        # a worker that cannot be reached may have finished its block before
        self._waiting.extend(block for block in blocks if self._count(block) is not None)


@contextmanager
def _without_logs() -> Iterator[None]:
    """Keep what Dask logs, tracebacks of a lost scheduler among it, from the terminal."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)


@contextmanager
def _client(scheduler: str, threads: int | None) -> Iterator[Any]:
    """Connect to a scheduler, or start one with workers here; both end with the `with` block."""
    try:
        import distributed
    except ImportError as error:
        text = "needs Dask: pip install 'nlds-vines[cluster]'"
        raise RequestError(f"--scheduler {scheduler} {text}") from error
    with ExitStack() as stack:
        address: Any = scheduler
        if scheduler.startswith("local:"):
            stack.enter_context(_without_pages())
            address = stack.enter_context(_local(int(scheduler.removeprefix("local:")), threads))
        try:
            client = distributed.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
        except _UNREACHABLE as error:
            text = f"--scheduler {shown(scheduler)} cannot be reached"
            raise RequestError(f"{text}: {error}") from error
        stack.enter_context(client)
        stack.enter_context(client.as_current())
        yield client


def _local(workers: int, threads: int | None) -> Any:
    """Return a cluster of `workers` processes here; those that end are replaced.

    It adapts its size, because a cluster of a fixed size ends when a worker is killed while it
    starts.  Whoever reaches a scheduler or a worker can run code there, so they listen on this
    machine alone, and speak with those only that have the certificate of this run.
    """
    from distributed import LocalCluster

    cluster = LocalCluster(
        host="127.0.0.1",
        protocol="tls://",
        security=_security(),
        n_workers=0,
        threads_per_worker=1,
        processes=True,
        dashboard_address="127.0.0.1:0",
        scheduler_kwargs={"dashboard": False},
        local_directory=None,
        silence_logs=50,  # a lost worker is no news here
        env={"NUMBA_NUM_THREADS": str(threads or 1), **_on_path()},
    )
    cluster.adapt(minimum=workers, maximum=workers)
    return cluster


def _security() -> Any:
    """Return credentials of this run alone, by which scheduler, workers and client know each other.

    Raises `RequestError` where cryptography, which makes them, is not installed.
    """
    from distributed.security import Security

    try:
        return Security.temporary()
    except ImportError as error:  # it needs the package `cryptography`
        raise RequestError(
            "--scheduler local:N needs a certificate that keeps other users out: "
            "pip install 'nlds-vines[cluster]', which brings cryptography"
        ) from error


def _without_pages() -> Any:
    """Return a context in which schedulers and workers serve no web pages.

    Their pages need no credentials, and show paths and logs to every user of the machine.
    """
    from distributed.config import dask

    parts = ("scheduler", "worker")
    return dask.config.set({f"distributed.{part}.http.routes": [] for part in parts})


def _on_path() -> dict[str, str]:
    """Return the setting that lets workers find what this process imports."""
    return {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
