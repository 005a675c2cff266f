"""What an orbit is, in the paper's words."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import numpy as np

from nlds_vines.kernels.scene import codes

FLAGS: Mapping[str, int] = {
    "undetermined": codes.UNDETERMINED,
    "periodic": codes.PERIODIC,
    "quasiperiodic": codes.QUASIPERIODIC,
    "chaotic": codes.CHAOTIC,
    "transient_chaos": codes.TRANSIENT_CHAOS,
    "failed": codes.FAILED,
}
"""Regimes by name: the CF flags of the dataset `regime`."""

KEPT: Mapping[str, int] = {"no": 0, "yes": 1}
"""Whether a label is kept under refinement: the CF flags of the dataset `label_kept`."""

_WORDS = {
    FLAGS["undetermined"]: "undetermined",
    FLAGS["quasiperiodic"]: "quasiperiodic",
    FLAGS["chaotic"]: "chaos",
    FLAGS["failed"]: "failed",
}
PERIODIC = re.compile(r"([2-9]|[1-9][0-9]+)?T,(0|[1-9][0-9]*)")
"""How the label of a periodic orbit is written: `name_of`."""

TRANSIENT = "transient chaos to "
"""How a label begins whose orbit was chaotic for long before it settled."""


def name_of(period: int, impacts: int) -> str:
    """Return the paper's name of a periodic regime of period n > 0: `T,1`, `3T,3`."""
    return f"{'' if period == 1 else period}T,{impacts}"


def label_of(regime: int, period: int, impacts: int) -> str:
    """Return the label of one orbit from its regime (of `FLAGS`), n and k of nT,k."""
    if regime in _WORDS:
        return _WORDS[regime]
    before = TRANSIENT if regime == FLAGS["transient_chaos"] else ""
    return before + name_of(period, impacts)


def labels_of(regime: np.ndarray, period: np.ndarray, impacts: np.ndarray) -> np.ndarray:
    """Return the label of every lane, strings in an object array.

    Arguments: integer arrays of one shape: `regime` (of `FLAGS`), `period` n of nT (0 where
    there is none) and `impacts` k per nT.
    """
    triples, index = np.unique(
        np.stack([regime, period, impacts], axis=-1).reshape(-1, 3), axis=0, return_inverse=True
    )
    names = [label_of(*triple) for triple in triples.tolist()]
    return np.array(names, dtype=object)[index.ravel()].reshape(regime.shape)


def least_lifetime(watched: float, level: float = 0.95) -> float:
    """Return the mean lifetime [forcing periods] of chaos that was watched and did not end.

    A bound at confidence `level` under the exponential law exp(-t / mean) of transient chaos, one
    orbit watched for `watched` periods: -watched / ln(1 - level).
    """
    return -watched / math.log(1.0 - level)


def flags_of(status: np.ndarray, kind: np.ndarray) -> np.ndarray:
    """Return the regime of every lane (of `FLAGS`): its verdict, or that it failed."""
    return np.where(status == codes.OK, kind, FLAGS["failed"]).astype(np.int8)
