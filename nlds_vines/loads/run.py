"""A response history from request to archive: damper by damper, or a scan block by block."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.loads.cases import arrays_of
from nlds_vines.loads.fall import HISTORIES
from nlds_vines.loads.request import HistoryRequest
from nlds_vines.model.load_quantities import OF_LOADS, WAYS
from nlds_vines.model.loads.loading import words_of_number
from nlds_vines.model.parameters import DESCRIBED
from nlds_vines.orbits.status_words import STATUS_FLAGS
from nlds_vines.runs.executors import use_threads
from nlds_vines.runs.interrupts import Stop
from nlds_vines.runs.journal import Made, complete
from nlds_vines.runs.numbered_parts import Arrays, NumberedParts
from nlds_vines.runs.progress import Progress

BLOCK = 256
"""Orbits of a scan that are kept together."""


def run(request: HistoryRequest, output: Path, how: RunOptions | None = None) -> None:
    """Compute a response history into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with all that is complete kept for
    --resume, and `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    threads, began = use_threads(how.threads), time.monotonic()
    size = BLOCK if request.vary else 1
    blocks = [range(i, min(i + size, request.cases)) for i in range(0, request.cases, size)]

    def work(folder: NumberedParts, progress: Progress, stop: Stop) -> Made:
        found = []
        for number, cases in enumerate(blocks):
            orbits = partial(arrays_of, request, cases, stop, progress.wait)
            found.append(folder.piece(number, orbits, threads))
            progress.note(len(cases), request.case(cases[0])[0].name)
        seconds = round(time.monotonic() - began, 3)
        arrays = {name: np.concatenate([one[name] for one in found]) for name in found[0]}
        return Made(*contents(request, arrays), {"threads": threads, "seconds": seconds})

    complete(
        NumberedParts.open(output, request, resume=how.resume, overwrite=how.overwrite),
        work,
        Progress(request.cases, "orbit", quiet=how.quiet),
        lambda _: "the orbits that are complete are",
    )


def axis_words(request: HistoryRequest, name: str) -> tuple[str, str]:
    """Return the unit and the meaning of an axis."""
    if name in DESCRIBED:
        return DESCRIBED[name].unit, DESCRIBED[name].meaning
    return words_of_number(request.load, name)


def contents(
    request: HistoryRequest, found: Arrays
) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the dimensions of an archive, and its datasets with the values that were found."""
    dampers = np.arange(len(request.systems), dtype=np.int32)
    scales = [Scale("damper", dampers, "1", "damper"), Scale("time", request.times, "s", "time")]
    scales += [Scale(one.name, one.values, *axis_words(request, one.name)) for one in request.vary]
    dims = ("damper", *(axis.name for axis in request.vary))
    table = {entry.name: (dims, entry.unit, entry.words) for entry in OF_LOADS}
    if not request.vary:
        table |= {name: ((*dims, "time"), *said) for name, said in HISTORIES.items()}
        whose = zip(WAYS, ("dashpot c1", "dashpot c2", "contacts"), strict=True)
        table |= {
            f"dissipated_{way}": ((*dims, "time"), "J", f"energy dissipated by {where} so far")
            for way, where in whose
        }
    shape = (len(request.systems), *request.shape)
    filled = [
        (
            Dataset.real(name, its, unit, words),
            found[name].reshape(*shape, *found[name].shape[1:]),
        )
        for name, (its, unit, words) in table.items()
        if np.isfinite(found[name]).any()
    ]
    names = np.array([system.name for system in request.systems], dtype=object)
    status = Dataset.code("status", dims, "how an orbit ended", STATUS_FLAGS)
    return scales, [
        *filled,
        (status, found["status"].reshape(shape)),
        (Dataset.text("system", ("damper",), "system"), names),
    ]
