"""Response curves from request to archive, curve by curve: each is kept when it is complete."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

import numpy as np

from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves.curves_table import ARRAYS, ENDINGS, contents, scales_of
from nlds_vines.bifurcation.response_curves.request import CurvePage
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.interrupts import Stop
from nlds_vines.runs.journal import Made, complete
from nlds_vines.runs.numbered_parts import Arrays, NumberedParts
from nlds_vines.runs.progress import Progress


def run(page: CurvePage, output: Path, how: RunOptions | None = None) -> None:
    """Compute a page of response curves into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with every curve that is complete kept for
    --resume, and `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    threads, began = use_threads(how.threads), time.monotonic()

    def work(folder: NumberedParts, progress: Progress, stop: Stop) -> Made:
        found = []
        for i, curve in enumerate(page.curves):
            compute = partial(_computed, curve.scan, progress, stop)
            found.append(folder.piece(i, compute, threads))
            progress.note(curve.scan.lanes, f"curve {i + 1} of {len(page.curves)}")
        seconds = round(time.monotonic() - began, 3)
        return Made(
            scales_of(page), contents(page, found), {"threads": threads, "seconds": seconds}
        )

    complete(
        NumberedParts.open(output, page, resume=how.resume, overwrite=how.overwrite),
        work,
        Progress(page.lanes, "orbit", quiet=how.quiet),
        lambda _: "the curves that are complete are",
    )


def _computed(scan: Scan, progress: Progress, stop: Stop) -> Arrays:
    """Return the arrays of a curve's scan: of its start, and those of a second one as NAME_down.

    Of two walls the larger number.
    """
    computer, pieces = Computer(scan, tell=progress.wait), []
    for block in blocks_of(scan):
        stop.check()
        pieces.append(computer.block(block))
    found: dict[str, np.ndarray] = {}
    for name in (name for name in ARRAYS if name in scan.table.datasets):
        values = np.concatenate([piece[name] for piece in pieces])
        by_start = values.reshape(*values.shape[:2], -1).max(axis=-1)
        for ending, start in zip(ENDINGS, by_start.T, strict=False):
            found[name + ending] = np.ascontiguousarray(start)
    return found
