"""Response curves from request to archive, curve by curve: each is kept when it is complete."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from nlds_vines.bifurcation.blocks import blocks_of
from nlds_vines.bifurcation.compute import Computer
from nlds_vines.bifurcation.request import Scan
from nlds_vines.bifurcation.response_curves.curves_table import ARRAYS, contents, scales_of
from nlds_vines.bifurcation.response_curves.request import CurvePage
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.runs.interrupts import Stop
from nlds_vines.runs.journal import Made, complete
from nlds_vines.runs.manifest import RESPONSE_CURVES
from nlds_vines.runs.numbered_parts import NumberedParts
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.threads import use_threads

Arrays = Mapping[str, np.ndarray]
"""The arrays (n,) of one curve, by name."""


@dataclass
class CurveFolder(NumberedParts):
    """The curves of a page under way, a part for each."""

    content: ClassVar[str] = RESPONSE_CURVES

    request: CurvePage

    def recall(self, index: int) -> Arrays | None:
        """Return the arrays of a curve that an earlier run has computed; None if none has."""
        part = self.part(index)
        return None if part is None else part.arrays


def run(page: CurvePage, output: Path, how: RunOptions | None = None) -> None:
    """Compute a page of response curves into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with every curve that is complete kept for
    --resume, and `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    threads, began = use_threads(how.threads), time.monotonic()

    def work(folder: CurveFolder, progress: Progress, stop: Stop) -> Made:
        places = range(len(page.curves))
        found = [_curve(folder, index, progress, stop, threads) for index in places]
        seconds = round(time.monotonic() - began, 3)
        return Made(
            scales_of(page), contents(page, found), {"threads": threads, "seconds": seconds}
        )

    complete(
        CurveFolder.open(output, page, resume=how.resume, overwrite=how.overwrite),
        work,
        Progress(page.lanes, "orbit", quiet=how.quiet),
        lambda _: "the curves that are complete are",
    )


def _curve(folder: CurveFolder, index: int, progress: Progress, stop: Stop, threads: int) -> Arrays:
    """Return the arrays of a curve: those of an earlier run, or computed and kept."""
    curve, began = folder.request.curves[index], time.monotonic()
    arrays = folder.recall(index)
    if arrays is None:
        arrays = _computed(curve.scan, progress, stop)
        seconds = time.monotonic() - began
        folder.write_part(index, arrays, seconds=seconds, threads=threads)
    progress.note(curve.scan.lanes, f"curve {index + 1} of {len(folder.request.curves)}")
    return arrays


def _computed(scan: Scan, progress: Progress, stop: Stop) -> Arrays:
    """Return the arrays of a curve's scan, of its only start."""
    computer, pieces = Computer(scan, tell=progress.wait), []
    for block in blocks_of(scan):
        stop.check()
        pieces.append(computer.block(block))
    names = [name for name in ARRAYS if name in scan.table.datasets]
    return {
        name: np.ascontiguousarray(np.concatenate([piece[name] for piece in pieces])[:, 0])
        for name in names
    }
