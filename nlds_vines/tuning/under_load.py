"""Designs under a load: what becomes of each, in every draw and case."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from nlds_vines.loads.cases import numbers_of
from nlds_vines.loads.request import is_of_load
from nlds_vines.model.loads.loading import Loading
from nlds_vines.orbits.batch import Outcome
from nlds_vines.tuning.request import Tuning


def outcome_under(tuning: Tuning, grid: Mapping[str, np.ndarray]) -> Outcome:
    """Return the outcome of every orbit, in the shape of the grid.

    Arguments: the `grid` of parameters, numbers of the load and `draw`, by name, of one shape.

    What a number does not tell makes a design inadmissible: a last time that has not come.
    """
    decay, shape = tuning.decay, grid["draw"].shape
    assert decay is not None
    lanes = {name: values.ravel().tolist() for name, values in grid.items()}
    draws = lanes.pop("draw")
    of_load = {name: lanes.pop(name) for name in [*lanes] if is_of_load(name)}

    @cache  # the orbits of one load share its cells
    def load_of(draw: int, *values: float) -> Loading:
        return decay.load.redrawn(draw).with_(dict(zip(of_load, values, strict=True)))

    pairs = [
        (
            tuning.system.with_(**{name: values[i] for name, values in lanes.items()}),
            load_of(draw, *(values[i] for values in of_load.values())),
        )
        for i, draw in enumerate(draws)
    ]
    found = {name: values.reshape(shape) for name, values in numbers_of(decay, pairs).items()}
    value = found[tuning.search.objective]
    return Outcome(value, found["E2max"], found["status"], found["violations"], value)
