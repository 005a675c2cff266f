"""How many threads the kernels use, and whether the environment lets Numba start them."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping

from nlds_vines.errors import RequestError, shown

MOST_THREADS = 4096
"""Threads that may be asked for: more than any machine has, so that a typing error is noticed."""

_LAYERS = ("default", "safe", "threadsafe", "forksafe", "tbb", "omp", "workqueue")
_POOLS = {"tbb", "omp", "workqueue"}  # of which each stands once in the list of priorities


def check_environment(environment: Mapping[str, str] = os.environ) -> None:
    """Raise `RequestError` for variables with which Numba could not even be loaded.

    Numba itself is not loaded: it raises errors of many lines, or passes over what it cannot read.
    """
    number = environment.get("NUMBA_NUM_THREADS")
    if number is not None and not 1 <= _whole(number) <= MOST_THREADS:
        raise RequestError(
            f"NUMBA_NUM_THREADS = {shown(number)} in the environment must be a whole number from 1 "
            f"to {MOST_THREADS}"
        )
    layer = environment.get("NUMBA_THREADING_LAYER", "default")
    if layer.lower() not in _LAYERS:
        raise RequestError(
            f"NUMBA_THREADING_LAYER = {shown(layer)} in the environment must be one of "
            f"{', '.join(_LAYERS)}"
        )
    order = environment.get("NUMBA_THREADING_LAYER_PRIORITY")
    if order is not None and sorted(order.split()) != sorted(_POOLS):
        raise RequestError(
            f"NUMBA_THREADING_LAYER_PRIORITY = {shown(order)} in the environment must name "
            f"{', '.join(sorted(_POOLS))}, each once"
        )


def _whole(text: str) -> int:
    """Return the number in plain digits, 0 for anything else."""
    return int(text) if re.fullmatch(r"\s*[0-9]{1,9}\s*", text) else 0


def use_threads(threads: int | None) -> int:
    """Let the kernels use `threads` threads, at most one per processor; return how many.

    None takes one per processor.  The threads are started, so whatever keeps Numba from that is
    known before anything is computed.

    Raises `RequestError` where no threading layer, or not the one that is asked for, can be loaded.
    """
    check_environment()
    import numba

    most = int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]  # set at run time
    used = most if threads is None else min(threads, most)
    try:
        numba.set_num_threads(used)
    except (ValueError, ImportError, RuntimeError) as error:
        layer = os.environ.get("NUMBA_THREADING_LAYER", "default")
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise RequestError(
            f"NUMBA_THREADING_LAYER = {shown(layer)} in the environment: {reason} "
            "(workqueue is always there)"
        ) from error
    return used
