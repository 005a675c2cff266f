"""The picture of a comparison says what its hollow marks and its grey line are."""

import dataclasses

import made_up_curves as made

from nlds_vines.accuracy.comparison_table import Measured
from nlds_vines.accuracy.curves import Curve
from nlds_vines.accuracy.picture import draw_comparison


def measured(curves, doubt):
    empty = {field.name: None for field in dataclasses.fields(Measured)}
    return Measured(**{**empty, "name": "a case", "curves": tuple(curves), "doubt": doubt})


def told(case):
    (legend,) = draw_comparison([case]).legends
    return [text.get_text() for text in legend.get_texts()]


def test_the_legend_names_what_is_drawn_and_nothing_else():
    name = "SciPy DOP853, events"
    sound = made.of_order(5, name)
    missed = made.result(64, 1e-3, 2e-6, method=name, missed=3.0)
    blind = Curve(name, (missed, *sound.results), 1e-15)
    assert told(measured([made.of_order(4), blind], 1e-15)) == [
        "rk4", "SciPy, events", "touches missed or invented", "doubt of the reference"
    ]  # fmt: skip
    assert told(measured([made.of_order(4), sound], 0.0)) == ["rk4", "SciPy, events"]
