"""A decay from request to archive, damper by damper: each is kept when it is complete."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

import numpy as np

from nlds_vines.archives.dataset import Dataset, Scale
from nlds_vines.cli.run_options import RunOptions
from nlds_vines.loads.fall import SHARES, WAYS, Fall, fall_of
from nlds_vines.loads.request import Decay
from nlds_vines.model.system import System
from nlds_vines.orbits.simulation import IntegrationError
from nlds_vines.orbits.status_words import OK, STATUS
from nlds_vines.runs.interrupts import Stop
from nlds_vines.runs.journal import Made, complete
from nlds_vines.runs.numbered_parts import Arrays, NumberedParts
from nlds_vines.runs.progress import Progress
from nlds_vines.runs.threads import use_threads

HISTORIES = {
    "E1": ("J", "energy of the structure"),
    "E2": ("J", "energy of the damper"),
    "x1": ("m", "displacement of the structure"),
    "x2": ("m", "displacement of the damper"),
}
"""What is told over time, with its unit and its meaning."""

NUMBERS = {
    "x1_max": ("m", "largest displacement of the structure"),
    "v1_max": ("m/s", "largest velocity of the structure"),
    "a1_max": ("m/s^2", "largest acceleration of the structure, contacts included"),
    "stroke_max": ("m", "largest stroke of the damper, counted from where its spring rests"),
    "force_max": ("N", "largest contact force"),
    "impulse_max": ("N s", "largest impulse of an impact"),
    "impacts": ("1", "number of impacts"),
    "captured": ("s", "time from the first touch on with two impacts in each natural period"),
    "energy_in": ("J", "energy that the blow brought in"),
    "balance": ("1", "largest of |energy in - stored - dissipated| / energy in"),
    "damping_ratio": ("1", "of a linear structure whose E1 falls to 10 % in the same time"),
}
"""What is told of a damper in one number."""


def run(request: Decay, output: Path, how: RunOptions | None = None) -> None:
    """Compute a decay into the archive `output`.

    Raises `Interrupted` on Ctrl-C, SIGTERM and SIGUSR1, with every damper that is complete kept for
    --resume, and `RequestError` where the archive cannot be written.
    """
    how = RunOptions() if how is None else how
    threads, began = use_threads(how.threads), time.monotonic()

    def work(folder: NumberedParts, progress: Progress, stop: Stop) -> Made:
        found = []
        for i, system in enumerate(request.systems):
            found.append(folder.piece(i, partial(_fall, request, system, stop)))
            progress.note(1, system.name)
        seconds = round(time.monotonic() - began, 3)
        return Made(*contents(request, found), {"threads": threads, "seconds": seconds})

    complete(
        NumberedParts.open(output, request, resume=how.resume, overwrite=how.overwrite),
        work,
        Progress(len(request.systems), "damper", quiet=how.quiet),
        lambda _: "the dampers that are complete are",
    )


def _fall(request: Decay, system: System, stop: Stop) -> Arrays:
    """Return what becomes of a structure, as arrays; of one that cannot be followed, why."""
    try:
        return _as_arrays(fall_of(request, system, stop.check))
    except IntegrationError as error:
        time, ends = request.times, request.ends
        histories = {name: np.full(len(time), np.nan) for name in HISTORIES}
        gone = {way: np.full(len(ends), np.nan) for way in WAYS}
        last, numbers = np.full(len(SHARES), np.nan), dict.fromkeys(NUMBERS, np.nan)
        fall = Fall(
            time=time, ends=ends, dissipated=gone, last=last, numbers=numbers, status=error.code,
            **histories,
        )  # fmt: skip
        return _as_arrays(fall)


def _as_arrays(fall: Fall) -> Arrays:
    histories = {name: np.ascontiguousarray(getattr(fall, name)) for name in HISTORIES}
    gone = {f"dissipated_{way}": fall.dissipated[way] for way in WAYS}
    numbers = {name: np.array(fall.numbers[name]) for name in NUMBERS}
    return {**histories, **gone, **numbers, "last": fall.last, "status": np.array(fall.status)}


def contents(
    request: Decay, found: list[Arrays]
) -> tuple[list[Scale], list[tuple[Dataset, np.ndarray]]]:
    """Return the dimensions of an archive, and its datasets with the values that were found."""
    numbers = np.arange(len(found), dtype=np.int32)
    scales = [
        Scale("damper", numbers, "1", "damper"),
        Scale("time", request.times, "s", "time after the blow"),
        Scale("end", request.ends, "s", "time up to which the energy is dissipated"),
        Scale("share", np.array(SHARES), "1", "share of the largest E1"),
    ]
    table = {
        **{name: (("damper", "time"), *said) for name, said in HISTORIES.items()},
        **{
            f"dissipated_{way}": (("damper", "end"), "J", f"energy dissipated by {where}")
            for way, where in zip(WAYS, ("dashpot c1", "dashpot c2", "contacts"), strict=True)
        },
        "last": (("damper", "share"), "s", "last time at which E1 exceeds the share"),
        **{name: (("damper",), *said) for name, said in NUMBERS.items()},
    }
    filled = [
        (
            Dataset(name, dims, "float64", unit, words, np.nan),
            np.array([one[name] for one in found]),
        )
        for name, (dims, unit, words) in table.items()
        if any(np.isfinite(one[name]).any() for one in found)
    ]
    names = np.array([system.name for system in request.systems], dtype=object)
    codes = np.array([one["status"] for one in found])
    flags = {status.meaning: code for code, status in STATUS.items()}
    return scales, [
        *filled,
        (Dataset("status", ("damper",), "int8", "1", "how an orbit ended", OK, flags), codes),
        (Dataset("system", ("damper",), "str", "1", "system", ""), names),
    ]
