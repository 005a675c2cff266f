"""Part files: results, piece by piece, in the folder of a run under way.

A part is one line of JSON (which part of what, made by what, which arrays), the bytes of the arrays
one after the other, and a checksum.  A part counts if its checksum, its identity, its arrays and
its makers are right.  The parts of a scan hold one block each.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nlds_vines.archives import durable
from nlds_vines.archives.provenance import makers

PATTERN = "block-*.part"
"""The names of part files."""

UNSOUND = (ValueError, KeyError, TypeError)
"""The errors of a part that does not verify; the message says what is wrong with it."""


@dataclass(frozen=True)
class Made:
    """How a part was made: by what (`provenance.makers`), in how long [s], on how many threads.

    The time runs from block to block, so that it counts computing and storing.
    """

    by: Mapping[str, str]
    seconds: float
    threads: int

    def __post_init__(self) -> None:
        """Raise TypeError or ValueError for a time or a number of threads that is none."""
        if not (float(self.seconds) >= 0.0 and int(self.threads) >= 0):
            raise ValueError("it says that it took no time, or no threads")


@dataclass(frozen=True)
class Part:
    """The content of a part file: arrays by name, and how they were made."""

    arrays: dict[str, np.ndarray]
    made: Made

    def by_us(self) -> Part:
        """Return the part itself; ValueError if other versions made it."""
        if self.made.by != makers():
            raise ValueError("it was made by another version of the program or its libraries")
        return self


def path_of(folder: Path, index: int) -> Path:
    """Return the path of the part of a number."""
    return folder / f"block-{index:06d}.part"


def store(
    path: Path,
    identity: list[Any],
    arrays: Mapping[str, np.ndarray],
    *,
    seconds: float,
    threads: int,
) -> Part:
    """Store contiguous arrays as a part: after this returns, it survives a power cut.

    Arguments: `identity`, as JSON has it, is what `fetch` must ask for; the rest as in `Made`.

    Returns the part as it stands in the file.  Raises OSError if it cannot be written.
    """
    made = Made(makers(), round(seconds, 6), threads)
    head = {
        "block": identity,
        "made": vars(made),
        "arrays": [[name, a.dtype.str, a.shape] for name, a in arrays.items()],
    }
    line = json.dumps(head).encode() + b"\n"
    durable.write(path, line, *(_bytes(array) for array in arrays.values()))
    return Part(dict(arrays), made)


def fetch(path: Path, identity: list[Any]) -> Part:
    """Return a verified part; its arrays cannot be written to.

    Raises one of `UNSOUND`, which says what is wrong with the part, or OSError where there is none.
    """
    data = memoryview(durable.read(path))
    head, start = _header(data)
    if head["block"] != identity:
        raise ValueError("it is of another request or another block")
    return Part(dict(_arrays(data, head["arrays"], start)), Made(**head["made"]))


def request_of(path: Path) -> str | None:
    """Return the hash of the request that a part says it is of; None where it cannot be read."""
    try:
        return str(_header(memoryview(durable.read(path)))[0]["block"][0])
    except (*UNSOUND, OSError, IndexError):
        return None


def _header(data: memoryview) -> tuple[dict[str, Any], int]:
    """Return the first line of a part, and where its arrays begin."""
    size = 1 << 12
    while (end := bytes(data[:size]).find(b"\n")) < 0:
        if size >= len(data):
            raise ValueError("it is no part file")
        size *= 2
    try:
        return json.loads(bytes(data[:end])), end + 1
    except RecursionError:
        raise ValueError("its first line is nested too deeply") from None


def _arrays(data: memoryview, table: Iterable[Any], start: int) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the arrays of a part by name; they share its memory."""
    for name, dtype, shape in table:
        count = math.prod(shape)
        yield name, np.frombuffer(data, dtype, count, start).reshape(shape)
        start += count * np.dtype(dtype).itemsize


def _bytes(array: np.ndarray) -> memoryview:
    """Return the memory of a contiguous array, which for strings has no buffer of its own."""
    return array.reshape(-1).view(np.uint8).data


def identity(request_hash: str, index: int) -> list[Any]:
    """Return what makes a part the one of this number, of the request of this hash."""
    return [request_hash, index]
