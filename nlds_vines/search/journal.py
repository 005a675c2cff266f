"""The journal of a search: every evaluation in order, in sealed parts beside the archive to be.

A search is a function of its request: run again, it asks for the same designs in the same order.
So it is resumed by replaying it, with the journal's values in place of the kernels'.
"""

from __future__ import annotations

import io
import json
import time
from pathlib import Path

import numpy as np

from nlds_vines import durable
from nlds_vines.errors import RequestError
from nlds_vines.folder import RunFolder
from nlds_vines.search.request import Tuning

FLUSH_EVERY = 1.0
"""Seconds of work that a killed process may lose."""


class Journal(RunFolder):
    """The evaluations of one tuning: rows of numbers, those asked for and then those found.

    `length` is the number of those that are on the disk.
    """

    scan: Tuning
    _known: np.ndarray = np.empty((0, 0))
    _replayed = 0
    _parts = 0
    length = 0
    _spoke = 0.0

    def begin(self) -> int:
        """Read what an earlier run left, up to the first part that does not verify.

        Returns how many evaluations that is.
        """
        self._waiting: list[np.ndarray] = []
        self._spoke = time.monotonic()
        found: list[np.ndarray] = []
        for path in sorted(self.folder.glob("block-*.npz")):
            try:
                found.append(self._read(path, len(found)))
            except (ValueError, KeyError) as error:
                self.discarded.append(f"{path.name} and what follows is computed again: {error}")
                break
        self._parts = len(found)
        for path in sorted(self.folder.glob("block-*.npz"))[len(found) :]:
            path.unlink()
        self._known = np.concatenate(found) if found else np.empty((0, 0))
        self.length = len(self._known)
        return self.length

    def recall(self, asked: np.ndarray) -> np.ndarray | None:
        """Return what an earlier run found for these rows, which must be next in the journal.

        None where the journal ends.  Raises `RequestError` where it goes on with other rows: then
        it was written by other versions of the libraries, and cannot be continued.
        """
        if self._replayed == len(self._known):
            return None
        rows = self._known[self._replayed : self._replayed + len(asked)]
        if rows.shape[0] != len(asked) or not np.array_equal(rows[:, : asked.shape[1]], asked):
            raise RequestError(
                f"{self.folder} does not fit this search (written by other versions?): "
                "--overwrite begins anew"
            )
        self._replayed += len(asked)
        return rows[:, asked.shape[1] :]

    def note(self, asked: np.ndarray, found: np.ndarray) -> None:
        """Add rows; they are on the disk at the latest a second of work later."""
        self._waiting.append(np.column_stack([asked, found]))
        if time.monotonic() - self._spoke > FLUSH_EVERY:
            self.flush()

    def flush(self) -> None:
        """Force everything to the disk that waits."""
        if self._waiting:
            buffer = io.BytesIO()
            rows, header = np.concatenate(self._waiting), self._header(self._parts)
            np.savez(buffer, rows=rows, header=np.array(header))
            with durable.in_one_line(f"write a part in {self.folder}"):
                durable.write(self._path(self._parts), buffer.getvalue())
            self._waiting.clear()
            self.length += len(rows)
            self._parts += 1
        self._spoke = time.monotonic()

    def finish(self, temporary: Path) -> None:
        """Put the finished archive `temporary` in place and remove the journal."""
        with durable.in_one_line(f"write {self.path} (the journal is intact, use --resume)"):
            durable.replace(temporary, self.path)
            self._remove()

    def _path(self, index: int) -> Path:
        return self.folder / f"block-{index:06d}.npz"

    def _header(self, index: int) -> str:
        return json.dumps([self._hash, index])

    def _read(self, path: Path, index: int) -> np.ndarray:
        """Return the rows of a part; ValueError says what is wrong with it."""
        with np.load(io.BytesIO(durable.read(path))) as part:
            if path != self._path(index) or str(part["header"]) != self._header(index):
                raise ValueError("it is of another tuning or out of order")
            return part["rows"]
