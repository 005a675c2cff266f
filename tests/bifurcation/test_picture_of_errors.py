"""Errors in pictures: labels that refinement changes are marked, errors shown by logarithm."""

import numpy as np
import pytest
from matplotlib.colors import LogNorm
from test_picture import (
    CHAOS_OF_ARCHIVE,
    FOUR,
    MAP,
    archive_of,
    drawn,
    faces,
    legend_of,
    shown,
    strips,
)

from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.picture.drawing import PICTURE
from nlds_vines.errors import RequestError
from nlds_vines.model.labels import KEPT
from nlds_vines.plotting.style import FLAGGED, ROUND_OFF

WANT = ("section", "energy", "regime", "error")
TWO = {"policy": "both"}


def kept_but(*places):
    """Return a filler of results: all labels are kept, but at these indices."""

    def fill(name, array):
        if name == "label_kept":
            array[...] = KEPT["yes"]
            for place in places:
                array[place] = KEPT["no"]
        elif name == "error":
            array[...] = np.geomspace(1e-14, 1e-9, len(array)).reshape(-1, *[1] * (array.ndim - 1))
            array.flat[0], array.flat[1] = 0.0, np.nan

    return fill


def flags(axes):
    """Return where on a strip something is marked."""
    return [segment[0, 0] for lines in axes.collections for segment in lines.get_segments()]


# ---- diagrams ------------------------------------------------------------------------------------


def test_a_diagram_marks_labels_that_are_not_kept(tmp_path):
    figure = drawn(archive_of(tmp_path / "a.h5", WANT, fill=kept_but((7, 0), (100, 0))))
    (strip,), structure = strips(figure), figure.axes[1]
    assert flags(strip) == pytest.approx([5.14, 7.0])
    assert legend_of(structure) == [FLAGGED, CHAOS_OF_ARCHIVE]
    assert strip.get_ylim() == (0, 1)
    assert structure.get_xlim() == (4.99, 8.01)


@pytest.mark.parametrize("want", [WANT, WANT[:-1]])
def test_where_all_labels_are_kept_there_is_no_mark_and_no_word_of_it(tmp_path, want):
    figure = drawn(archive_of(tmp_path / "a.h5", want, fill=kept_but()))
    assert flags(strips(figure)[0]) == []
    assert legend_of(figure.axes[1]) == [CHAOS_OF_ARCHIVE]


def test_each_strip_has_the_marks_of_its_start(tmp_path):
    path = archive_of(tmp_path / "a.h5", WANT, start=TWO, fill=kept_but((0, 0), (50, 1), (150, 1)))
    figure = drawn(path)
    up, down = (axes for axes in figure.axes if axes.get_ylabel() in ("up", "down"))
    assert flags(up) == pytest.approx([5.0])
    assert flags(down) == pytest.approx([6.0, 8.0])
    energy = figure.axes[2]
    assert legend_of(energy) == ["up and down alike", FLAGGED, CHAOS_OF_ARCHIVE]


def test_marks_of_starts_without_a_strip_are_not_announced(tmp_path):
    figure = drawn(archive_of(tmp_path / "a.h5", WANT, start=FOUR, fill=kept_but((50, 3))))
    assert FLAGGED not in legend_of(figure.axes[2])


def test_errors_alone_are_dots_on_a_logarithmic_scale(tmp_path):
    (panel,) = drawn(archive_of(tmp_path / "a.h5", ["error"], fill=kept_but())).axes
    assert panel.get_ylabel() == "error over a period [m, m/s]"
    assert panel.get_yscale() == "log"
    (dots,) = panel.get_lines()
    found = dots.get_ydata()
    assert found[0] == ROUND_OFF  # where zero is drawn
    assert np.isnan(found[1])
    assert found[-1] == 1e-9


# ---- maps ----------------------------------------------------------------------------------------


def test_a_map_puts_a_dot_into_cells_whose_label_is_not_kept(tmp_path):
    path = archive_of(tmp_path / "m.h5", ["regime", "error"], MAP, fill=kept_but((3, 4), (29, 0)))
    (axes,) = drawn(path).axes
    (dots,) = axes.get_lines()
    with read(path) as view:
        omega, force = view["omega"], view["P"]
    assert sorted(dots.get_xdata()) == [omega[3], omega[29]]
    assert sorted(dots.get_ydata()) == [force[0], force[4]]
    assert legend_of(axes)[-1] == FLAGGED.replace(" under", "\nunder")
    plain = drawn(archive_of(tmp_path / "p.h5", ["regime"], MAP)).axes[0]
    assert (axes.get_xlim(), axes.get_ylim()) == (plain.get_xlim(), plain.get_ylim())
    assert faces(axes) == faces(plain)
    assert legend_of(axes)[:-1] == legend_of(plain)


def test_a_map_of_kept_labels_is_as_ever(tmp_path):
    (axes,) = drawn(archive_of(tmp_path / "m.h5", ["regime", "error"], MAP, fill=kept_but())).axes
    assert not axes.get_lines()
    assert FLAGGED.split()[0] not in " ".join(legend_of(axes))


def test_of_several_starts_one_is_enough_and_only_the_regimes_are_marked(tmp_path):
    path = archive_of(
        tmp_path / "m.h5", ["regime", "error"], MAP, start=FOUR, fill=kept_but((5, 5, 2), (5, 5, 3))
    )
    above, below = drawn(path).axes
    (dots,) = above.get_lines()
    assert len(dots.get_xdata()) == 1
    assert not below.get_lines()


def test_dots_stand_in_the_cells_of_values_at_equal_ratios(tmp_path):
    vary = {
        "omega": {"start": 7.0, "stop": 8.0, "num": 5},
        "K": {"start": 1e5, "stop": 1e9, "num": 5, "scale": "log"},
    }
    (axes,) = drawn(
        archive_of(tmp_path / "m.h5", ["regime", "error"], vary, fill=kept_but((2, 1)))
    ).axes
    (dots,) = axes.get_lines()
    assert (dots.get_xdata().tolist(), dots.get_ydata().tolist()) == ([7.5], [1e6])


def test_a_map_shows_errors_by_logarithm_and_zero_as_the_least(tmp_path):
    path = archive_of(tmp_path / "m.h5", ["regime", "error"], MAP, fill=kept_but())
    axes, bar = shown(path, "error").axes
    (mesh,) = axes.collections
    assert isinstance(mesh.norm, LogNorm)
    assert (mesh.norm.vmin, mesh.norm.vmax) == pytest.approx((1e-14, 1e-9))
    assert mesh.norm(0.0) == 0.0
    assert mesh.get_array().mask.sum() == 1  # the one that is not known
    assert bar.get_ylabel() == "error over a period [m, m/s]"
    for other in ("error_at_end",):
        assert shown(path, other).axes[1].get_ylabel().startswith("difference from a refined run")


def test_a_map_of_errors_that_are_all_zero_or_unknown_can_be_drawn(tmp_path):
    def zero(name, array):
        if name.startswith("error"):
            array[...] = 0.0
            array[3:] = np.nan

    path = archive_of(tmp_path / "m.h5", ["error"], MAP, fill=zero)
    assert PICTURE.save(path, tmp_path / "m.png").stat().st_size > 0


def test_errors_that_were_not_recorded_cannot_be_shown(tmp_path):
    path = archive_of(tmp_path / "m.h5", ["regime"], MAP)
    with pytest.raises(RequestError, match="show = 'error' is not recorded"):
        shown(path, "error")
