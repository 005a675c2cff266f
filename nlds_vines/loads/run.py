"""A response history from request to archive: damper by damper, or a scan block by block."""

from __future__ import annotations

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
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.store import Arrays, Blocks, Write

BLOCK = 256
"""Orbits of a scan that are kept together."""


def run(request: HistoryRequest, output: Path, how: RunOptions | None = None) -> None:
    """Compute a response history into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with all that is complete kept for
    --resume, and `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    use_threads(how.threads)
    size = BLOCK if request.vary else 1
    blocks = [range(i, min(i + size, request.cases)) for i in range(0, request.cases, size)]

    store = Blocks(output, request)
    store.keys = range(len(blocks))

    def work() -> Write:
        found = []
        with Progress(request.cases, "orbit", quiet=how.quiet) as progress:
            for number, cases in enumerate(blocks):
                orbits = partial(arrays_of, request, cases, progress.wait)
                found.append(store.piece(number, orbits))
                progress.note(len(cases), request.case(cases[0])[0].name)
        arrays = {name: np.concatenate([one[name] for one in found]) for name in found[0]}
        return store.writer(*contents(request, arrays))

    store.carry_out(how, work)


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
