"""Which regimes coexist in a cell, from the labels of its starts.

Labels are strings as an archive holds them; the starts run along the last dimension.
"""

from __future__ import annotations

import numpy as np

from nlds_vines.model.labels import TRANSIENT

UNKNOWN = ("undetermined", "failed", "")
"""Labels that do not name a regime; no count of regimes includes them."""

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

    Where `wanted` is a final regime such as `T,0`, every start that ended in it counts; where it is
    `transient chaos to T,0`, only those that were chaotic before.
    """
    found = labels if wanted.startswith(TRANSIENT) else finals(labels)
    return (found == wanted).mean(axis=-1)


def coexisting(labels: np.ndarray) -> np.ndarray:
    """Return how many regimes coexist in each cell at least: (..., starts) to integers (...).

    Counted are the different known final regimes of its starts.  Chaos does not count where one
    start has left it: the chaos of the other starts may end as well.
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
    """Return one label for each cell, (..., starts) to strings (...).

    It is the final regime that most starts ended in.  Of equally frequent ones a known regime is
    preferred, and then the one that is more frequent in the other cells.  The label says `transient
    chaos to` where more than half of these starts were chaotic before.
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
    """Return the different labels, and at each place the index of the label there."""
    words, index = np.unique(labels.astype(np.str_), return_inverse=True)
    return words.tolist(), index.reshape(labels.shape)
