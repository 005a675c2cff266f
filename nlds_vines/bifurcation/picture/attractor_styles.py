"""How the orbits of several starts are told apart in a diagram: by attractor, not by start."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nlds_vines.bifurcation.observation_time import in_legend
from nlds_vines.bifurcation.picture.ordinates import SECTION, Slice, quantities_in
from nlds_vines.plotting.palette import ink_of, ordered, period_and_impacts, short
from nlds_vines.plotting.style import NAVY, start_colors

SWEEPS = ["up", "down"]
"""The starts of a scan that shows hysteresis."""

BOTH = "up and down alike"
"""What a legend says of orbits on which both sweeps are."""

_ALIKE = 0.01  # of the range of all values: the distance of two orbits that count as one


class Look(NamedTuple):
    """Some of the orbits, `which` (cells, starts), and how their dots look."""

    which: np.ndarray
    color: str
    name: str


def looks_of(cut: Slice, numbers: np.ndarray | None = None) -> list[Look]:
    """Return the looks of all orbits: what lies on one attractor looks alike.

    Arguments: the slice; the `numbers` (cells, starts, 1) that are drawn, where each orbit has one.

    Of a single start all orbits have one color.  Of sweeps up and down there are three: those of
    either, and one where both are on the same orbit.  Equal numbers of different orbits do not
    make them one: just beyond grazing T,0 and T,2 have nearly the same energy.  Of other starts the
    color is that of the regime; without labels all are alike.
    """
    starts, shape = cut.starts, (cut.values.size, len(cut.starts))
    if len(starts) == 1:
        name = "" if starts == ["rest"] else f"start: {starts[0]}"
        return [Look(np.ones(shape, dtype=bool), start_colors(starts)[0], name)]
    if starts == SWEEPS:
        return _of_sweeps(alike(cut, numbers))
    labels = cut.labels()
    if labels is None:
        return [Look(np.ones(shape, dtype=bool), NAVY, f"{len(starts)} starts")]
    words = ordered(labels.ravel().tolist())
    return [Look(labels == word, ink_of(word), in_legend(short(word), cut.view)) for word in words]


def _of_sweeps(both: np.ndarray) -> list[Look]:
    """Return the looks of two sweeps, given in which cells (cells,) both are alike."""
    up, down = start_colors(SWEEPS)
    one, other = (np.zeros((both.size, 2), dtype=bool) for _ in SWEEPS)
    one[:, 0], other[:, 1] = ~both, ~both
    shared = np.stack([both, np.zeros_like(both)], axis=1)
    found = [Look(shared, NAVY, BOTH), Look(one, up, "up"), Look(other, down, "down")]
    return [look for look in found if look.which.any()]


def alike(cut: Slice, numbers: np.ndarray | None = None) -> np.ndarray:
    """Return in which cells (cells,) two starts are on the same orbit.

    Arguments: the slice; the `numbers` (cells, starts, 1) to compare if neither sections nor E1max
    are recorded.

    Orbits are alike if they have the same nT,k and the same label, as far as these are recorded,
    and all points of either lie close to one of the other, in each coordinate that is recorded, or
    else in E1max; and if both are not periodic and have one label.
    """
    known = quantities_in(cut.view)
    of_section = [item for item in known.values() if item.dataset == SECTION]
    places = of_section or [item for item in known.values() if item.name == "E1max"]
    compared = [cut.of(item) for item in places]
    if not places and numbers is not None:
        compared = [numbers]
    found = np.ones(cut.values.size, dtype=bool)
    for values in compared:
        found &= _close(values)
    if "periodicity" in cut.view and "impact_count" in cut.view:
        n, k = (cut.view.take(name, **cut.at) for name in ("periodicity", "impact_count"))
        found &= (n[:, 0] == n[:, 1]) & ((k[:, 0] == k[:, 1]) | (n[:, 0] == 0))
    labels = cut.labels()
    if labels is None:
        return found
    same = labels[:, 0] == labels[:, 1]
    wild = np.array([period_and_impacts(label) is None for label in labels[:, 0]])
    return same & (found | wild)


def _close(values: np.ndarray) -> np.ndarray:
    """Return in which cells all points of each of two starts (cells, 2, m) lie near the other's."""
    finite = values[np.isfinite(values)]
    reach = _ALIKE * np.ptp(finite) if finite.size else np.inf
    close = np.ones(len(values), dtype=bool)
    for i, (one, other) in enumerate(values):
        one, other = one[np.isfinite(one)], other[np.isfinite(other)]
        if one.size and other.size:
            gaps = np.abs(one[:, np.newaxis] - other)
            close[i] = max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) <= reach
        else:
            close[i] = one.size == other.size
    return close
