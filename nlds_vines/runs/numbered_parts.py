"""Runs whose parts are numbered: results in the order in which they are found, or task by task."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from nlds_vines.archives import durable
from nlds_vines.runs.folder import RunFolder
from nlds_vines.runs.partfile import PATTERN, UNSOUND, Part, fetch, identity, path_of, store

Arrays = Mapping[str, np.ndarray]
"""What a part holds, by name."""


@dataclass
class NumberedParts(RunFolder):
    """The folder of a run whose parts have the numbers 0, 1, 2 ...; use it as a `RunFolder`."""

    def verified(self, number: int) -> Part:
        """Return the part of a number; raises one of `UNSOUND`, FileNotFoundError without one."""
        return fetch(path_of(self.folder, number), identity(self.request.hash, number)).by_us()

    def part(self, number: int) -> Part | None:
        """Return the verified part of a number, None where there is none.

        One that does not verify is removed, and `discarded` says so.
        """
        try:
            return self.verified(number)
        except FileNotFoundError:
            return None
        except UNSOUND as error:
            path = path_of(self.folder, number)
            self.discarded.append(f"{path.name} is computed again: {error}")
            path.unlink()
            return None

    def piece(self, number: int, compute: Callable[[], Arrays], threads: int = 1) -> Arrays:
        """Return the arrays of a piece of the work: of an earlier run, or computed."""
        part, began = self.part(number), time.monotonic()
        if part is not None:
            return part.arrays
        arrays = compute()
        self.write_part(number, arrays, seconds=time.monotonic() - began, threads=threads)
        return arrays

    def parts_in_order(self) -> Iterator[Part]:
        """Yield the verified parts from number 0 on, up to the first that does not verify.

        That one and what follows is removed then, and `discarded` says so.
        """
        paths, sound = sorted(self.folder.glob(PATTERN)), 0
        for path in paths:
            try:
                if path != path_of(self.folder, sound):
                    raise ValueError("the one before it is missing")
                part = self.verified(sound)
            except UNSOUND as error:
                self.discarded.append(f"{path.name} and what follows is computed again: {error}")
                break
            sound += 1
            yield part
        for path in paths[sound:]:
            path.unlink()

    def write_part(self, number: int, arrays: Arrays, *, seconds: float, threads: int = 1) -> None:
        """Store the part of a number: after this returns, it survives a power cut.

        Raises `RequestError` where it cannot be written.
        """
        whose = identity(self.request.hash, number)
        with durable.in_one_line(f"write a part in {self.folder}"):
            store(path_of(self.folder, number), whose, arrays, seconds=seconds, threads=threads)
