"""Several starts of a cell: sorted by where they ended, shared out, counted."""

import numpy as np
import pytest

from nlds_vines.archives.dataset import Dataset
from nlds_vines.bifurcation.picture.choices import check_show, quantities, usual_show
from nlds_vines.model.labels import by_frequency, coexisting, finals, most_frequent, share_of

LATE = "transient chaos to T,0"
CELLS = np.array(
    [
        ["T,1", "T,1", "T,1", "T,1"],
        ["T,0", "2T,1", "T,0", LATE],
        [LATE, LATE, "T,0", "chaos"],
        ["chaos", "chaos", "T,0", "undetermined"],
        ["undetermined", "failed", "undetermined", "undetermined"],
        ["2T,1", "T,0", "quasiperiodic", "3T,2"],
    ],
    dtype=object,
)


def test_a_transient_ends_where_it_says():
    assert finals(CELLS)[2].tolist() == ["T,0", "T,0", "T,0", "chaos"]


def test_shares_count_final_regimes_or_the_way_there():
    np.testing.assert_allclose(share_of(CELLS, "T,0"), [0, 0.75, 0.75, 0.25, 0, 0.25])
    np.testing.assert_allclose(share_of(CELLS, LATE), [0, 0.25, 0.5, 0, 0, 0])
    assert share_of(CELLS, "9T,9").max() == 0


def test_coexisting_regimes_are_counted_and_gaps_in_knowledge_are_not():
    # in the third cell chaos may be the transient of the others
    assert coexisting(CELLS).tolist() == [1, 2, 1, 2, 0, 4]


def test_the_most_frequent_regime_stands_for_a_cell():
    labels = most_frequent(CELLS).tolist()
    assert labels[:5] == ["T,1", "T,0", LATE, "chaos", "undetermined"]
    assert labels[5] == "T,0"  # all four once: the one most frequent elsewhere


def test_of_equally_many_a_known_one_stands_for_a_cell():
    cells = np.array([["undetermined", "3T,2"], ["undetermined", "undetermined"]], dtype=object)
    assert most_frequent(cells).tolist() == ["3T,2", "undetermined"]


def test_any_shape_and_order_of_starts():
    grid = CELLS.reshape(2, 3, 4)
    assert most_frequent(grid).shape == coexisting(grid).shape == share_of(grid, "T,1").shape
    turned = grid[..., ::-1]
    assert most_frequent(turned).tolist() == most_frequent(grid).tolist()
    assert coexisting(turned).tolist() == coexisting(grid).tolist()
    assert by_frequency(grid)[0] == ("T,0", 5)


RANGE = np.linspace(5.0, 8.0, 9)


def known(*names):
    """Quantities of these names, as a scan of two parameters records them."""
    dims = ("omega", "P", "start")
    return quantities([Dataset(name, dims, "float64", "1", name, np.nan) for name in names], ())


def test_what_a_map_shows_unasked():
    assert usual_show(known("E1max"), True) == "regimes"
    assert usual_show(known("impact_rate", "E2max"), False) == "E2max"
    assert usual_show(known("status"), False) is None


@pytest.mark.parametrize("show", ["regimes", "coexisting", "shares", "share:T,0", "E1max"])
def test_what_can_be_shown_is_not_refused(show):
    check_show(show, [RANGE, RANGE], 4, known("E1max"), True)


@pytest.mark.parametrize(
    ("show", "axes", "starts", "labeled", "message"),
    [
        ("shares", 1, 4, True, "vary two parameters"),
        ("regime", 2, 4, True, "did you mean 'regimes'"),
        ("share:", 2, 4, True, "share:LABEL"),
        ("lyapunov", 2, 4, True, "not recorded"),
        ("regimes", 2, 4, False, "scan with regime in --record"),
        ("shares", 2, 1, True, "several starts"),
        ("share:T,0", 2, 1, True, "several starts"),
        ("coexisting", 2, 1, True, "several starts"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_one_line(
    show, axes, starts, labeled, message, error_of
):
    line = error_of(check_show, show, [RANGE] * axes, starts, known("E1max"), labeled)
    assert message in line
