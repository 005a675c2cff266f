"""The legend names the lines and the hollow marks of the picture."""

import made_up_curves as made
from matplotlib.figure import Figure

from nlds_vines.accuracy.measured_cases import Known, Measured
from nlds_vines.accuracy.picture import family_of, fill


def legend(*results, doubt):
    axes = Figure().subplots()
    fill(axes, Measured(Known("a case", "", "", 2, "", doubt, 0.0, "", 1.0), results))
    return axes.get_legend_handles_labels()[1]


def test_the_legend_names_what_is_drawn_and_nothing_else():
    name = "SciPy DOP853, events"
    ours, sound = made.of_order(4), made.of_order(5, name)
    missed = made.result(64, 1e-3, 2e-6, method=name, missed=3.0)
    assert legend(*ours, missed, *sound, doubt=1e-15) == [
        "rk4",
        "SciPy, events",
        "SciPy, events: touches missed or invented",
        "doubt of the reference",
    ]
    assert legend(*ours, *sound, doubt=0.0) == ["rk4", "SciPy, events"]


def test_families_are_libraries_with_and_without_events():
    assert family_of("SciPy BDF, events") == "SciPy, events"
    assert family_of("naive RK4") == "naive"
    assert family_of("exact") == "exact"
