"""Whether a file is laid out as an archive is: datasets of its own, each dimension with its scale.

HDF5 can do much more: a dataset may be a link to another file, or have its values in another file,
which nothing in this one can vouch for.  Archives use none of that, so whatever does is refused,
before any of it is followed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

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
