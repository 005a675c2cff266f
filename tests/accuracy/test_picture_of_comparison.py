"""The picture says what its hollow marks and its grey line are; archives of old are drawn, too."""

import made_up_curves as made
import pytest
from matplotlib.figure import Figure

from nlds_vines.accuracy.measured_cases import COLUMNS, SHAPE, Known, Measured
from nlds_vines.accuracy.picture import PICTURE, _fill_comparison, draw, family_of
from nlds_vines.archives import archive
from nlds_vines.archives.record_columns import row_of
from nlds_vines.runs.survey import Survey, Task, run


def told(*results, doubt):
    case = Measured("a case", "", "", 2, "", doubt, 0.0, "", 1.0, results)
    axes = Figure().subplots()
    _fill_comparison(axes, case)
    return axes.get_legend_handles_labels()[1]


def test_the_legend_names_what_is_drawn_and_nothing_else():
    name = "SciPy DOP853, events"
    ours, sound = made.of_order(4), made.of_order(5, name)
    missed = made.result(64, 1e-3, 2e-6, method=name, missed=3.0)
    assert told(*ours, missed, *sound, doubt=1e-15) == [
        "rk4",
        "SciPy, events",
        "SciPy, events: touches missed or invented",
        "doubt of the reference",
    ]
    assert told(*ours, *sound, doubt=0.0) == ["rk4", "SciPy, events"]


@pytest.mark.parametrize("cases", [1, 2, 3])
def test_every_case_has_a_panel(cases, tmp_path):
    def rows(name):
        known = Known(name, "", "", 2, "", 1e-15, 0.0, "", 1.0)
        return [row_of(known, found.setting, found) for found in made.of_order(4)]

    names = [f"case {number}" for number in range(cases)]
    tasks = tuple(Task(name, lambda name=name: rows(name)) for name in names)
    run(Survey("A title", SHAPE, {}, COLUMNS, tasks), tmp_path / "a.h5")
    with archive.read(tmp_path / "a.h5") as view:
        assert list(PICTURE.panels(view)) == names
        drawn = [axes for axes in draw(view).axes if axes.lines]
    assert len(drawn) == cases


def test_families_are_libraries_with_and_without_events():
    assert family_of("SciPy BDF, events") == "SciPy, events"
    assert family_of("naive RK4") == "naive"
    assert family_of("exact") == "exact"
