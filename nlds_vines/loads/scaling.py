"""Records scaled to a common size: a peak, or a pseudo-acceleration at a period."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nlds_vines.errors import RequestError, at
from nlds_vines.loads.response_spectrum import response_spectrum
from nlds_vines.model.loads.loading import Loading
from nlds_vines.model.loads.record import Record
from nlds_vines.model.loads.suite import Size

DIGITS = 9  # of the factor to a spectral ordinate: exponentials of libraries differ in the last bit


def scaled(load: Loading) -> Loading:
    """Return a sum of loads whose records have the size `load.scale_to`."""
    size = load.scale_to
    if size is None:
        return load
    record = tuple(scaled_record(one, size) for one in load.record)
    suite = tuple(scaled_record(one, size) for one in load.suite)
    return replace(load, record=record, suite=suite, scale_to=None)


def scaled_record(record: Record, size: Size) -> Record:
    """Return a record with all samples times the factor that gives it a size.

    The factor is in its `reading`, which reports and archives state.
    """
    with at(f"scale_to: {record.source}"):
        if record.is_acceleration == size.is_force:
            raise RequestError(f"{size.words()} of a record in {record.unit}")
        present = _present_size(record, size)
        if not present > 0.0:
            raise RequestError("all samples are 0")
    factor = size.value / present
    if size.period is not None:
        factor = float(f"{factor:.{DIGITS}g}")
    values = tuple((np.array(record.values) * factor).tolist())
    words = f"times {factor:.6g} to {size.words()}"
    reading = f"{record.reading}, {words}" if record.reading else words
    return replace(record, values=values, reading=reading)


def _present_size(record: Record, size: Size) -> float:
    """Return the peak, or the pseudo-acceleration at the period, as it is [m/s^2 or N]."""
    if size.period is None:
        return float(np.abs(np.array(record.values)).max()) * record.factor
    spectrum = response_spectrum(record, size.zeta, [size.period])
    return float(spectrum.pseudo_acceleration[0])
