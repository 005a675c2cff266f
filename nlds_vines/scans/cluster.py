"""Workers of a Dask cluster as an executor: processes of this machine, or those of a scheduler.

This is the only module that imports `distributed` (extra `cluster`).
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import ExitStack, contextmanager
from typing import Any

from nlds_vines.errors import RequestError, option, shown

CONNECT_SECONDS = 30.0  # seconds to reach a scheduler


@contextmanager
def workers(scheduler: str, threads: int | None) -> Iterator[Executor]:
    """Return an executor of `local:N` processes with so many threads each, or of a scheduler.

    Raises `RequestError` if the scheduler cannot be reached, or is lost.
    """
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)  # tracebacks of a lost scheduler
    try:
        with _client(scheduler, threads) as client:
            yield client.get_executor(pure=False)
    except CancelledError:
        gone = f"{option('scheduler', shown(scheduler))} is gone"
        raise RequestError(f"{gone}; {option('resume')} goes on elsewhere") from None
    finally:
        logging.disable(before)


@contextmanager
def _client(scheduler: str, threads: int | None) -> Iterator[Any]:
    """Connect to a scheduler, or start one with workers here; both end with the `with` block."""
    try:
        import distributed
        from distributed.config import dask
    except ImportError as error:
        text = "needs Dask: pip install 'nlds-vines[cluster]'"
        raise RequestError(f"{option('scheduler', shown(scheduler))} {text}") from error
    with ExitStack() as stack:
        address: Any = scheduler
        if scheduler.startswith("local:"):
            # pages need no credentials, and show paths and logs to every user of the machine
            pages = [f"distributed.{part}.http.routes" for part in ("scheduler", "worker")]
            stack.enter_context(dask.config.set({page: [] for page in pages}))
            path = os.pathsep.join(filter(None, sys.path))  # workers find what is imported here
            # whoever reaches a scheduler or a worker can run code there, so they listen on this
            # machine alone, and speak with those only that have the certificate of this run
            address = distributed.LocalCluster(
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
                env={"NUMBA_NUM_THREADS": str(threads or 1), "PYTHONPATH": path},
            )
            stack.enter_context(address)
            # a cluster of a fixed size ends when a worker is killed while it starts
            count = int(scheduler.removeprefix("local:"))
            address.adapt(minimum=count, maximum=count)
        try:
            client = distributed.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
            # a TypeError: without a certificate for an address `tls://`
            text = f"{option('scheduler', shown(scheduler))} cannot be reached"
            raise RequestError(f"{text}: {error}") from error
        stack.enter_context(client)
        stack.enter_context(client.as_current())
        yield client


def _security() -> Any:
    """Return credentials of this run alone, for scheduler, workers and client."""
    from distributed.security import Security

    try:
        return Security.temporary()
    except ImportError as error:  # it needs the package `cryptography`
        raise RequestError(
            f"{option('scheduler', 'local:N')} needs a certificate that keeps other users out: "
            "pip install 'nlds-vines[cluster]', which brings cryptography"
        ) from error
