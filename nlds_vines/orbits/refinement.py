"""What refined settings find otherwise: the errors of a block, and in one line those of a scan.

The error of a period is local: each period begins anew with the state that the run had there, so
that it means something in chaos too, where any difference grows to the size of the attractor.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nlds_vines.model.labels import KEPT
from nlds_vines.model.quantities import RETRACED
from nlds_vines.orbits.evidence import labels_from
from nlds_vines.orbits.status_words import OK

if TYPE_CHECKING:
    from nlds_vines.orbits.batch import Kernels, Outputs


def retraced(kernels: Kernels, outputs: Outputs, chains: np.ndarray, periods: int) -> np.ndarray:
    """Return the error of the state over one period (chains, links) [m, m/s].

    Arguments: refined `kernels`; the `outputs` of a run of `chains` of cells (chains, links) that
    sampled so many `periods`.

    The largest difference of a component, over the last `RETRACED` sampled periods, between the
    state at the end of the period and that which the kernels reach from its beginning.  NaN where
    they fail in one of them; of a lane that failed itself it means nothing.
    """
    assert outputs.section is not None
    assert outputs.ends is not None
    count = min(periods, RETRACED)
    ends = outputs.section[:, :, -count:]
    begins = begins_of(outputs.section, outputs.ends[:, :, 0], chains["rest"], count)
    begins[outputs.status != OK] = 0.0  # what is not an orbit is not followed
    cells = np.repeat(chains.ravel(), count)
    found = kernels.after_a_period(cells, begins.reshape(-1, 4)).reshape(ends.shape)
    return _apart(found, ends).max(axis=2)


def begins_of(section: np.ndarray, first: np.ndarray, rest: np.ndarray, count: int) -> np.ndarray:
    """Return the states (x1, v1, r, s) [m, m/s] at which the last `count` periods began.

    Arguments: the section (chains, links, periods, components) of orbits as far as it was kept;
    their `first` states (chains, links, 4 or more), which count where that is all of their course;
    `rest` offsets [m] (chains, links).  Returns (chains, links, count, 4).
    """
    states = np.zeros((*section.shape[:2], count, 4))
    states[:, :, 0] = first[..., :4]
    known = section[:, :, -count - 1 : -1]
    later = states[:, :, count - known.shape[2] :]
    later[..., :2] = known[..., :2]
    if section.shape[-1] == 4:
        with np.errstate(all="ignore"):  # lanes that failed hold anything
            later[..., 2] = known[..., 0] - (known[..., 2] - rest[..., np.newaxis])
            later[..., 3] = known[..., 1] - known[..., 3]
    return states


def arrays_of(outputs: Outputs, fine: Outputs, label: np.ndarray | None) -> dict[str, np.ndarray]:
    """Return the datasets that tell the error of a block, by name.

    Arguments: its `outputs`, those of the refined run, and its labels, if it has any.
    """
    assert outputs.retraced is not None
    assert outputs.section is not None
    assert fine.section is not None
    sound = fine.status == OK
    apart = _apart(outputs.section[:, :, -1], fine.section[:, :, -1])
    found = {"error": outputs.retraced, "error_at_end": np.where(sound, apart, np.nan)}
    if outputs.energy is not None and fine.energy is not None:
        apart = _apart(outputs.energy[..., :1], fine.energy[..., :1])
        found["E1max_error"] = np.where(sound, apart, np.nan)
    if label is not None and fine.evidence is not None:
        found["refined_label"] = labels_from(fine.status, fine.evidence, fine.by_wall)
        found["label_kept"] = kept(label, found["refined_label"])
    return found


def kept(label: np.ndarray, refined: np.ndarray) -> np.ndarray:
    """Return the codes of `labels.KEPT`: whether two labels are the same words, lane by lane.

    So the kind has to be the same, of a periodic orbit n and k of nT,k, and of a chaotic transient
    the orbit that it ends in.  How long it takes, and how often chaos strikes, does not count.
    """
    return np.where(label == refined, KEPT["yes"], KEPT["no"]).astype(np.int8)


def _apart(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the largest difference of a component between states (..., components)."""
    with np.errstate(all="ignore"):  # lanes that failed hold anything
        return np.abs(one - other).max(axis=-1)
