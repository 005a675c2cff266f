"""Names of regimes in the paper's notation; the most frequent and the coexisting ones of a cell."""

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

_WORDS = {
    FLAGS["undetermined"]: "undetermined",
    FLAGS["quasiperiodic"]: "quasiperiodic",
    FLAGS["chaotic"]: "chaos",
    FLAGS["failed"]: "failed",
}

# the labels of periodic orbits, as `name_of` writes them
PERIODIC = re.compile(r"([2-9]|[1-9][0-9]+)?T,(0|[1-9][0-9]*)( \([0-9]+(\+[0-9]+)+\))?")
TRANSIENT = "transient chaos to "  # begins the label of an orbit with a long chaotic transient
CHAOS = "chaos"
QUASIPERIODIC = "quasiperiodic"
UNDETERMINED = "undetermined"
UNKNOWN = ("undetermined", "failed", "")  # name no regime: no count of regimes includes them


def name_of(period: int, impacts: int, *by_damper: int) -> str:
    """Return the paper's name of a periodic regime of period n > 0: `T,1`, `3T,3`.

    If several dampers share the impacts, that of a host: `2T,3 (2+1)`.
    """
    shares = f" ({'+'.join(map(str, by_damper))})" if len(by_damper) > 1 and impacts else ""
    return f"{'' if period == 1 else period}T,{impacts}{shares}"


def label_of(regime: int, period: int, impacts: int, *by_damper: int) -> str:
    if regime in _WORDS:
        return _WORDS[regime]
    before = TRANSIENT if regime == FLAGS["transient_chaos"] else ""
    return before + name_of(period, impacts, *by_damper)


def labels_of(
    regime: np.ndarray, period: np.ndarray, impacts: np.ndarray, *by_damper: np.ndarray
) -> np.ndarray:
    """Return the label of every orbit; `period` is n of nT (0 for none), `impacts` k per nT."""
    columns = np.stack([regime, period, impacts, *by_damper], axis=-1)
    rows, index = np.unique(columns.reshape(-1, columns.shape[-1]), axis=0, return_inverse=True)
    names = [label_of(*row) for row in rows.tolist()]
    return np.array(names, dtype=object)[index.ravel()].reshape(regime.shape)


def is_struck(numbers: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return whether orbits have impacts, from the datasets of a scan by name.

    Those of a periodic orbit are counted on its cycle, others by their rate.  Archives of 0.1.0
    may lack the rate: their counts are those of the sampled window without a period.
    """
    period, counts = numbers["periodicity"], numbers["impact_count"]
    rates = numbers.get("impact_rate", counts)
    return np.where(period > 0, counts > 0, rates > 0)


def least_lifetime(watched: float, level: float = 0.95) -> float:
    """Return a lower bound of the mean lifetime [forcing periods] of chaos that has not ended.

    At confidence `level`, under the exponential law exp(-t / mean) of transient chaos, for one
    orbit of `watched` periods: -watched / ln(1 - level).
    """
    return -watched / math.log(1.0 - level)


def flags_of(status: np.ndarray, kind: np.ndarray) -> np.ndarray:
    return np.where(status == codes.OK, kind, FLAGS["failed"]).astype(np.int8)


def final(label: str) -> str:
    """Return the regime that an orbit ended in: `transient chaos to T,0` ended in `T,0`."""
    return label.removeprefix(TRANSIENT)


def finals(labels: np.ndarray) -> np.ndarray:
    words, index = _words(labels)
    return np.array([final(word) for word in words], dtype=object)[index]


def share_of(labels: np.ndarray, wanted: str) -> np.ndarray:
    """Return the share of the starts (..., starts) in a regime, shape (...), from 0 to 1.

    Every start that ended in it counts; of `transient chaos to T,0`, those chaotic before.
    """
    compared = labels if wanted.startswith(TRANSIENT) else finals(labels)
    return (compared == wanted).mean(axis=-1)


def coexisting(labels: np.ndarray) -> np.ndarray:
    """Return the least number of coexisting regimes of each cell: (..., starts) to integers (...).

    Chaos does not count if one start has left it: that of the other starts may end as well.
    """
    words, index = _words(labels)
    ends = [final(word) for word in words]
    classes = [end for end in dict.fromkeys(ends) if end not in UNKNOWN]
    present = np.zeros((*labels.shape[:-1], len(classes)), dtype=bool)
    for number, end in enumerate(ends):
        if end in classes:
            present[..., classes.index(end)] |= (index == number).any(axis=-1)
    if CHAOS in classes and len(classes) > 1:
        left = np.isin(index, [i for i, w in enumerate(words) if w.startswith(TRANSIENT)])
        present[..., classes.index(CHAOS)] &= ~left.any(axis=-1)
    return present.sum(axis=-1)


def most_frequent(labels: np.ndarray) -> np.ndarray:
    """Return the final regime of most starts of each cell, (..., starts) to strings (...).

    Of equally frequent regimes, it is one that is not unknown, and then the one that is more
    frequent in all cells.  It begins with `TRANSIENT` if most of these starts were chaotic before.
    """
    words, index = _words(labels)
    ends = np.array([final(word) for word in words])
    classes, of_word = np.unique(ends, return_inverse=True)
    of_start = of_word[index]
    votes = np.stack([(of_start == i).sum(axis=-1) for i in range(classes.size)], axis=-1)
    everywhere = votes.reshape(-1, classes.size).sum(axis=0) / (labels.size + 1.0)
    winner = np.argmax(votes + everywhere * ~np.isin(classes, UNKNOWN), axis=-1)
    chosen = classes.astype(object)[winner]
    through = [word.startswith(TRANSIENT) for word in words]
    in_winner = of_start == winner[..., np.newaxis]
    passed = (in_winner & np.array(through)[index]).sum(axis=-1)
    return np.where(2 * passed > in_winner.sum(axis=-1), TRANSIENT + chosen, chosen)


def by_frequency(labels: np.ndarray) -> list[tuple[str, int]]:
    words, counts = np.unique(labels.astype(np.str_), return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return [(str(words[i]), int(counts[i])) for i in order]


def _words(labels: np.ndarray) -> tuple[list[str], np.ndarray]:
    words, index = np.unique(labels.astype(np.str_), return_inverse=True)
    return words.tolist(), index.reshape(labels.shape)
