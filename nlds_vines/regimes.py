"""What an orbit is, in the paper's words: labels `nT,k` from period and impact count."""

from __future__ import annotations

import numpy as np

from nlds_vines.record import FLAGS, OK


def name_of(period: int, impacts: int) -> str:
    """Return the paper's name of a periodic regime: `T,1`, `3T,3`; `undetermined` for period 0."""
    if period == 0:
        return "undetermined"
    return f"{'' if period == 1 else period}T,{impacts}"


def labels_of(status: np.ndarray, period: np.ndarray, impacts: np.ndarray) -> np.ndarray:
    """Return the label of every lane.

    Arguments: integer arrays of one shape: `status` (of `record.STATUS`), `period` n of nT
    (0: none found) and `impacts` k per nT.  Returns strings in an object array of that shape.

    A period is claimed by recurrence of the section alone; what does not recur is `undetermined`
    here, for want of evidence of anything else.
    """
    pairs, index = np.unique(
        np.stack([status, period, impacts], axis=-1).reshape(-1, 3), axis=0, return_inverse=True
    )
    names = [name_of(n, k) if code == OK else "failed" for code, n, k in pairs.tolist()]
    return np.array(names, dtype=object)[index.ravel()].reshape(status.shape)


def flags_of(status: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Return the regime of every lane as a code of `record.FLAGS` (arguments as `labels_of`)."""
    found = np.where(period > 0, FLAGS["periodic"], FLAGS["undetermined"])
    return np.where(status == OK, found, FLAGS["failed"]).astype(np.int8)
