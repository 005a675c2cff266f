"""Whether a file is an archive: its layout, its heaps, and whether its values mean something.

Checksums tell whether a file is as it was written; this tells of one that was written wrong.  HDF5
can do much more than archives need: a dataset may be a link to another file, or have its values in
another file, which nothing in this one can vouch for.  Whatever does is refused, before any of it
is followed.
"""

from __future__ import annotations

import errno
import math
import mmap
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from struct import Struct
from typing import Any

import numpy as np

from nlds_vines.errors import shown

_MOST_COMPRESSED = 1100
"""Bytes of values for which one byte of the file can stand at most: deflate reaches 1032."""


@dataclass(frozen=True)
class Member:
    """One entry of a file, as far as it is known before any value is read.

    Attributes:
        outside: what leads elsewhere, in words; empty for a dataset with values of its own.
        numbers, text: whether it holds whole numbers and floats, or strings.
        shape: its lengths; bytes: those of all values; stored: those that they take in the file.
        scales: of each dimension the names of its scales.
        values: of a scale of numbers returns them, None where they cannot be read; itself None for
            any other dataset.
    """

    outside: str = ""
    numbers: bool = False
    text: bool = False
    shape: tuple[int, ...] = ()
    bytes: int = 0
    stored: int = 0
    scales: tuple[tuple[str, ...], ...] = ()
    is_scale: bool = False
    values: Callable[[], np.ndarray | None] | None = None


def problems_of(members: Mapping[str, Member]) -> Iterator[str]:
    """Yield what keeps a file with these members from being an archive, one line each."""
    for name, member in members.items():
        if member.outside:
            yield f"{name!r} {member.outside}"
        elif not (member.numbers or member.text):
            yield f"dataset {name!r} holds neither numbers nor strings"
        elif not member.shape:
            yield f"dataset {name!r} has no dimensions"
        elif member.bytes > _MOST_COMPRESSED * member.stored:
            yield f"dataset {name!r} has more values, of {member.bytes} bytes, than are in the file"
        elif member.is_scale:
            yield from _of_scale(name, member)
        else:
            yield from _of_sides(name, member, members)


def _of_scale(name: str, scale: Member) -> Iterator[str]:
    """Yield what is wrong with a dimension: numbers are finite and rise."""
    if len(scale.shape) != 1:
        yield f"scale {name!r} has {len(scale.shape)} dimensions, not one"
    elif scale.values is not None:
        values = scale.values()
        if values is not None and not (
            np.isfinite(values).all() and (values[1:] > values[:-1]).all()
        ):
            yield f"scale {name!r} is not finite, or does not rise"


def _of_sides(name: str, dataset: Member, members: Mapping[str, Member]) -> Iterator[str]:
    """Yield what is wrong with the dimensions of a dataset: each has one scale of its length."""
    for number, (scales, length) in enumerate(zip(dataset.scales, dataset.shape, strict=True)):
        if len(scales) != 1 or scales[0] not in members:
            yield f"dataset {name!r} has no scale of its own along dimension {number}"
        elif math.prod(members[scales[0]].shape) != length:
            yield f"dataset {name!r} has {length} values along {scales[0]!r}, which has others"


# ---- heaps of strings ----------------------------------------------------------------------------


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


# ---- values that mean something ------------------------------------------------------------------


_NO_PERIOD = re.compile(r"(transient chaos to )?0[0-9]*T\b.*")
"""A label nT,k whose n is 0."""


def flags_of(attributes: Mapping[str, Any]) -> dict[int, str]:
    """Return the words of an enumeration by their codes, from the attributes of its dataset.

    Raises ValueError, or what HDF5 raises, where they do not belong together.
    """
    codes, meanings = np.asarray(attributes["flag_values"]), attributes["flag_meanings"]
    if codes.ndim != 1 or codes.dtype.kind not in "iu":
        raise ValueError("its codes are no whole numbers")
    words = meanings.split(" ") if isinstance(meanings, str) else []
    if len(words) != len(codes):
        raise ValueError(f"it has {len(codes)} codes, but {len(words)} words")
    return dict(zip(map(int, codes), words, strict=True))


def problems_of_values(
    attributes: Mapping[str, Any], fill: Any, slabs: Iterable[np.ndarray]
) -> Iterator[str]:
    """Yield what the values of a dataset hold that means nothing, one line at most.

    Arguments: the `attributes` of the dataset; `fill`, the value of what was not computed; its
    values in parts.
    """
    codes = [*flags_of(attributes), fill] if "flag_values" in attributes else None
    for values in slabs:
        if codes is not None:
            wrong = values[~np.isin(values, codes)].tolist()
        elif values.dtype.kind == "O":
            wrong = [text for text in values.flat if _NO_PERIOD.fullmatch(text)]
        else:
            wrong = []
        if wrong:
            yield f"it holds {shown(wrong[0])}, which means nothing"
            return
