"""The heaps of an HDF5 file, in which it keeps its strings, looked at before HDF5 reads them.

Where the size of an entry is damaged, HDF5 may look for the next one at the same place for ever
(release 2.0). A heap is a block that begins with GCOL, a version and its length; of each entry the
number, a count, and the length of what follows are told, in multiples of 8 bytes (File Format
Specification, III.E).
"""

from __future__ import annotations

import errno
import mmap
import os
from collections.abc import Iterator
from pathlib import Path
from struct import Struct

_SIGN = b"GCOL\x01\x00\x00\x00"
_LENGTH = Struct("<Q")
_ENTRY = Struct("<HHIQ")


def heaps_are_whole(path: Path) -> bool:
    """Tell whether the entries of each heap of a file follow one another to its end.

    Holes of a sparse file, which may be as long as no disk is, are not looked at.
    """
    with path.open("rb") as file:
        if not path.stat().st_size:
            return True
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            for begin, end in _written(file.fileno(), len(data)):
                place = data.find(_SIGN, begin, end)
                while place >= 0:
                    if not _is_whole(data, place):
                        return False
                    place = data.find(_SIGN, place + len(_SIGN), end)
    return True


def _written(descriptor: int, size: int) -> Iterator[tuple[int, int]]:
    """Yield where the bytes of a file begin and end that are no hole."""
    end = 0
    while end < size:
        try:
            begin = os.lseek(descriptor, end, os.SEEK_DATA)
            end = os.lseek(descriptor, begin, os.SEEK_HOLE)
        except OSError as error:
            if error.errno != errno.ENXIO:  # a file system that knows no holes
                yield end, size
            return
        yield begin, end


def _is_whole(data: mmap.mmap, place: int) -> bool:
    """Tell it of the heap at a place."""
    begin = place + len(_SIGN)
    if begin + _LENGTH.size > len(data):
        return False
    (length,) = _LENGTH.unpack_from(data, begin)
    end, entry = place + length, begin + _LENGTH.size
    if not entry <= end <= len(data):
        return False
    while entry + _ENTRY.size <= end:
        number, _, _, size = _ENTRY.unpack_from(data, entry)
        # the rest that is free has the number 0, and its length counts from here
        size = size if number == 0 else _ENTRY.size + -(-size // 8) * 8
        if size < _ENTRY.size or entry + size > end:
            return False
        entry += size
    return True
