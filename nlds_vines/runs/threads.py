"""How many threads the kernels use."""

from __future__ import annotations

import numba


def use_threads(threads: int | None) -> int:
    """Let the kernels use `threads` threads, at most one per processor; return how many.

    None takes one per processor.
    """
    most = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]  # set at run time
    used = most if threads is None else min(threads, most)
    numba.set_num_threads(used)
    return used
