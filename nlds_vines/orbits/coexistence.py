"""Which regimes coexist: the labels of several starts of one cell, sorted, shared out and counted.

Labels are strings as an archive has them, with the starts along their last dimension.
"""

from __future__ import annotations

import numpy as np

from nlds_vines.orbits.labels import TRANSIENT

UNKNOWN = ("undetermined", "failed", "")
"""Labels that say nothing of the orbit: they take part in no count of regimes."""

CHAOS = "chaos"


def final(label: str) -> str:
    """Return the regime that an orbit ended in: `transient chaos to T,0` ended in `T,0`."""
    return label.removeprefix(TRANSIENT)


def finals(labels: np.ndarray) -> np.ndarray:
    """Return the final regimes of an array of labels, strings in an object array."""
    words, index = _words(labels)
    return np.array([final(word) for word in words], dtype=object)[index]


def share_of(labels: np.ndarray, wanted: str) -> np.ndarray:
    """Return the share of the starts (..., starts) in a regime, shape (...), from 0 to 1.

    A `wanted` final regime counts whoever ended in it; `transient chaos to T,0` only those that
    came to it that way.
    """
    found = labels if wanted.startswith(TRANSIENT) else finals(labels)
    return (found == wanted).mean(axis=-1)


def coexisting(labels: np.ndarray) -> np.ndarray:
    """Return at least how many regimes coexist in each cell: (..., starts) to integers (...).

    The different final regimes of its starts, those that are not known left out.  Where one start
    has left chaos, chaos that others are still in may be the same that ends: it does not count.
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
    """Return the label that stands for each cell, (..., starts) to strings (...).

    The final regime that most starts ended in; of equally many, a known one, and of these the one
    that is more frequent in the other cells.  It is called a transient where most of those were.
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
    mine = of_start == winner[..., np.newaxis]
    passed = (mine & np.array(through)[index]).sum(axis=-1)
    return np.where(2 * passed > mine.sum(axis=-1), TRANSIENT + chosen, chosen)


def by_frequency(labels: np.ndarray) -> list[tuple[str, int]]:
    """Return the different labels with how often they occur, the most frequent first."""
    words, counts = np.unique(labels.astype(np.str_), return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return [(str(words[i]), int(counts[i])) for i in order]


def _words(labels: np.ndarray) -> tuple[list[str], np.ndarray]:
    """Return the different labels, and for each place which of them stands there."""
    words, index = np.unique(labels.astype(np.str_), return_inverse=True)
    return words.tolist(), index.reshape(labels.shape)
