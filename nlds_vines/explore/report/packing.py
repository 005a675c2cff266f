"""The numbers of all cells in few bytes, for a page that carries them.

Codes stay as they are.  Numbers keep 12 bits after the leading one, which is 1.2e-4 of their size
at most; states of a section are 16 bits of the range of their component.  All bytes of one place
stand side by side, which lets `deflate` find more that repeats, and are written in base64.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any, NamedTuple

import numpy as np

BITS = 12
"""Bits that a number keeps after the leading one."""

_LAST = 65534  # the code of a component's largest value; the next one means that there is no state
_NONE = 65535
_LEVEL = 6  # of `deflate`: beyond, a page takes far longer and becomes little smaller


class Packed(NamedTuple):
    """A column packed: its name, its kind (f4, u2, u1, i1), how many values, the text in base64."""

    name: str
    kind: str
    length: int
    text: str

    @property
    def entry(self) -> dict[str, Any]:
        """What a browser must know to unpack it."""
        return {"name": self.name, "kind": self.kind, "length": self.length}


def packed(name: str, values: np.ndarray) -> Packed:
    """Pack a column of float32, int8, uint8 or uint16, of any shape."""
    kind = values.dtype.str.lstrip("|<")
    if kind == "f4":
        values = rounded(values)
    text = base64.b64encode(zlib.compress(_shuffled(values), _LEVEL)).decode()
    return Packed(name, kind, int(values.size), text)


def rounded(values: np.ndarray) -> np.ndarray:
    """Return float32 with `BITS` bits after the leading one, rounded to the nearest."""
    bits = np.ascontiguousarray(values, "<f4").view("<u4")
    drop = 23 - BITS
    with np.errstate(over="ignore"):
        near = (bits + np.uint32(1 << (drop - 1))) >> np.uint32(drop) << np.uint32(drop)
    special = ~np.isfinite(values.ravel())
    found = np.where(special, bits, near).astype("<u4").view("<f4")
    return np.where(np.isnan(found), np.float32(np.nan), found)  # one NaN: it packs best


def coded(states: np.ndarray) -> tuple[np.ndarray, list[list[float]]]:
    """Return states (lanes, points, components) as 16-bit codes, and the range of each component.

    A code c means low + c (high - low) / 65534; 65535 means that there is no state.
    """
    codes = np.full(states.shape, _NONE, "<u2")
    ranges = []
    for i in range(states.shape[-1]):
        values = states[..., i]
        known = np.isfinite(values)
        low, high = (
            (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 1.0)
        )
        size = high - low or 1.0
        places = np.rint((values[known] - low) * (_LAST / size))
        codes[..., i][known] = places.astype("<u2")
        ranges.append([low, low + size])
    return codes, ranges


def _shuffled(values: np.ndarray) -> bytes:
    """Return the first bytes of all values, then the second ones, and so on."""
    flat = np.ascontiguousarray(values).ravel()
    return flat.view(np.uint8).reshape(flat.size, flat.itemsize).T.tobytes()
