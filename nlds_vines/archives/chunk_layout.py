"""How an array is laid out on the disk and read again: chunks, slabs, checksums of its values."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator

import numpy as np

_CHUNK_BYTES = 1 << 18  # small enough to read a few cells, large enough to compress and to seek
_SLAB_VALUES = 1 << 22  # values read at a time where a dataset may be larger than the memory


def chunk_shape(shape: tuple[int, ...], itemsize: int) -> tuple[int, ...]:
    """Return the shape of the chunks of an array whose values take `itemsize` bytes.

    The longer of the first two sides is halved until a chunk takes at most 256 KiB, then the other
    sides.  So the samples of one orbit stay together as long as possible, and the layout does not
    depend on how the scan was cut into blocks.
    """
    chunk = list(shape)
    while math.prod(chunk) * itemsize > _CHUNK_BYTES:
        side = max(range(len(chunk)), key=lambda i: (i < 2 and chunk[i] > 1, chunk[i]))
        chunk[side] = -(-chunk[side] // 2)
    return tuple(chunk)


def slabs(shape: tuple[int, ...]) -> Iterator[slice]:
    """Yield slices along the first dimension of an array, each of which fits into the memory."""
    step = max(1, _SLAB_VALUES // max(1, math.prod(shape[1:])))
    for first in range(0, shape[0], step):
        yield slice(first, min(first + step, shape[0]))


def crc32_of(values: np.ndarray, crc: int = 0) -> int:
    """Return the CRC-32 of values, continued from `crc`; a zero byte ends each string."""
    if values.dtype.kind not in "UO":
        return zlib.crc32(np.ascontiguousarray(values).data, crc)
    return zlib.crc32("".join(f"{text}\0" for text in values.flat).encode(), crc)
