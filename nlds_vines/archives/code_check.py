"""Whether the values of an archive mean something: codes that have words, labels that can be.

Checksums tell whether a file is as it was written.  This tells of a file that was written wrong.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from nlds_vines.errors import shown

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
