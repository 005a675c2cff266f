"""From the kernels' evidence to the datasets of an archive and to words."""

from __future__ import annotations

from typing import Any

import numpy as np

from nlds_vines.kernels.numerics.matrices import LOG, fill_multipliers
from nlds_vines.kernels.scene import codes as ev
from nlds_vines.kernels.scene.codes import OK
from nlds_vines.model.labels import flags_of, labels_of
from nlds_vines.model.quantities import held_in

COLUMNS = ev.LENGTH_OF_ROW


def multipliers_of(rows: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the Floquet multipliers and the logarithms of their moduli, the largest first.

    Arguments: rows of evidence (..., COLUMNS); `size` of a state.  Shapes (..., size, 2), real and
    imaginary parts, and (..., size); NaN for what is not periodic.
    """
    matrices = rows[..., ev.MONODROMY : ev.MONODROMY + 16].reshape(-1, 4, 4)
    matrices = np.ascontiguousarray(matrices[:, :size, :size].transpose(0, 2, 1))
    triples = np.full((len(matrices), size, 3), np.nan)
    fill_multipliers(matrices, triples)
    triples = triples.reshape(*rows.shape[:-1], size, 3)
    return triples[..., :LOG], triples[..., LOG]


def compile_multipliers(size: int) -> None:
    """Have `multipliers_of` states of a size compiled."""
    multipliers_of(np.empty((0, COLUMNS)), size)


def exponents_of(
    rows: np.ndarray, logarithms: np.ndarray, size: int, period: np.ndarray
) -> np.ndarray:
    """Return all Lyapunov exponents [1/s] (..., size); of an nT orbit, ln |mu| / nT.

    Where the evidence holds them, the orbit is not periodic, or too long for its matrix.

    Arguments: rows of evidence (..., COLUMNS); ln |mu| (..., size) of `multipliers_of`; `size` of a
    state; `period` T [s] of the forcing.
    """
    measured = rows[..., ev.EXPONENTS : ev.EXPONENTS + size].copy()
    with np.errstate(divide="ignore", invalid="ignore"):
        of_cycle = logarithms / (rows[..., ev.CYCLE_PERIOD] * period)[..., np.newaxis]
    return np.where(np.isnan(measured), of_cycle, measured)


def points_of(rows: np.ndarray, size: int, rest: np.ndarray) -> np.ndarray:
    """Return a section point of each periodic orbit as (x1, v1, x2, v2) [m, m/s].

    Arguments: rows of evidence (..., COLUMNS); `size` of a state; `rest` offset of the spring [m].
    """
    y = rows[..., ev.POINT : ev.POINT + 4]
    points = y[..., :size].copy()
    if size == 4:
        points[..., 2] = y[..., 0] - y[..., 2] + rest
        points[..., 3] = y[..., 1] - y[..., 3]
    return points


def regimes_of(status: np.ndarray, rows: np.ndarray, counts: np.ndarray) -> dict[str, np.ndarray]:
    """Return period, impacts by wall and in all, regime and label of every lane.

    Arguments: `status`, rows of evidence and impact `counts` (..., 2) of the sampled window.
    """
    period = rows[..., ev.CYCLE_PERIOD].astype(np.int64)
    of_cycle = rows[..., ev.NEAR_IMPACTS : ev.FAR_IMPACTS + 1]
    by_wall = np.where((period > 0)[..., np.newaxis], of_cycle, counts).astype(np.int64)
    impacts = by_wall.sum(axis=-1)
    regime = flags_of(status, rows[..., ev.KIND].astype(np.int64))
    return {
        "periodicity": period,
        "impact_count": impacts,
        "impacts_by_wall": by_wall,
        "regime": regime,
        "label": labels_of(regime, period, impacts),
    }


def labels_from(status: np.ndarray, rows: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return the labels alone, strings in an object array (arguments as above)."""
    labels: np.ndarray = regimes_of(status, _judged(status, rows), counts)["label"]
    return labels


def _judged(status: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return rows of evidence without that of lanes that failed."""
    rows = np.where((status == OK)[..., np.newaxis], rows, np.nan)
    columns = [ev.KIND, ev.CYCLE_PERIOD]
    rows[..., columns] = np.nan_to_num(rows[..., columns])
    return rows


def arrays_of(
    status: np.ndarray, rows: np.ndarray, counts: np.ndarray, cells: np.ndarray, size: int
) -> dict[str, np.ndarray]:
    """Return every dataset that rests on a verdict, by name (arguments as above).

    `cells` are the numbers of the lanes, of dtype `CELL`.
    """
    rows = _judged(status, rows)
    multipliers, logarithms = multipliers_of(rows, size)
    arrays: dict[str, Any] = {one.name: one.taken(rows) for one in held_in("evidence")}
    arrays["settling"] = np.nan_to_num(arrays["settling"], nan=-1.0).astype(np.int32)
    arrays["multipliers"] = multipliers
    with np.errstate(all="ignore"):  # lanes that failed may have no period
        period = 2 * np.pi / cells["omega"]
    arrays["exponents"] = exponents_of(rows, logarithms, size, period)
    arrays["orbit_point"] = points_of(rows, size, cells["rest"])
    return arrays | regimes_of(status, rows, counts)
