"""Ranges at equal distances and at equal ratios."""

import numpy as np
import pytest

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.errors import Reordered, RequestError
from nlds_vines.model.axis import Axis
from nlds_vines.plotting.bands import inner_edges, is_list, logarithmic


def test_equal_ratios_are_rounded_from_exact_powers():
    values = Axis.spaced("K", 1e5, 1e9, 41, "log").values
    assert values[[0, 10, 20, 30, 40]].tolist() == [1e5, 1e6, 1e7, 1e8, 1e9]
    np.testing.assert_allclose(values[1:] / values[:-1], 10**0.1, rtol=1e-15 * 4)
    assert Axis.spaced("K", 2.0, 8.0, 1, "log").values.tolist() == [2.0]
    assert Axis.of("K", {"start": 1.0, "stop": 4.0, "num": 3, "scale": "log"}).values.tolist() == [
        1.0, 2.0, 4.0,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"start": 0.0, "stop": 4.0, "num": 3, "scale": "log"}, "start = 0.0 must be > 0 where"),
        ({"start": 1.0, "stop": 4.0, "num": 3, "scale": "cubic"}, "unknown scale 'cubic'"),
        ({"values": [1.0], "scale": "log"}, "allowed: start, stop and num"),
    ],
)
def test_what_no_scale_can_be_is_refused(entry, message):
    with pytest.raises(RequestError, match=message):
        Axis.of("K", entry)


class Column:
    """Stands for a column of a table, such as that of pandas: no sequence, but an array."""

    ndim, size = 1, 3

    def __array__(self, dtype=None, copy=None):
        return np.array([5.0, 6.0, 7.0])


@pytest.mark.parametrize(
    "values",
    [
        [5.0, 6, 7.0], (5.0, 6.0, 7.0), range(5, 8), np.linspace(5, 7, 3), np.arange(5, 8),
        np.array([5, 6, 7], dtype=np.float32), Column(),
    ],
)  # fmt: skip
def test_any_sequence_of_numbers_is_an_axis(values):
    scan = load_scan("tmd", {"vary": {"omega": values}})
    assert scan == load_scan("tmd", {"vary": {"omega": {"values": [5.0, 6.0, 7.0]}}})


@pytest.mark.parametrize("values", ["567", b"567", np.zeros((2, 2)), 6.0, np.float64(6.0), None])
def test_anything_else_is_no_axis(values):
    with pytest.raises(RequestError, match="omega"):
        load_scan("tmd", {"vary": {"omega": values}})


def test_the_option_and_the_file_mean_the_same():
    from nlds_vines.cli.options import spaced

    entry = spaced("--vary K", "1e5:1e9:5:log")
    scan = load_scan(None, {"vary": {"K": entry}})
    assert scan.axes[0].values.tolist() == [1e5, 1e6, 1e7, 1e8, 1e9]
    assert load_scan(scan.document()) == scan
    with pytest.raises(RequestError, match="must be START:STOP:NUM"):
        spaced("--band", "1:2:log")


def test_ranges_and_lists_are_told_apart_by_their_values():
    assert logarithmic(Axis.spaced("K", 1e5, 1e9, 9, "log").values)
    assert not logarithmic(np.linspace(1.0, 2.0, 9))
    assert [is_list(np.array(v)) for v in ([600.0, 800.0], [1.0, 2.0, 3.0, 4.0, 5.0])] == [
        True, False,
    ]  # fmt: skip
    assert is_list(np.array([1.0, 2.0, 3.0, 5.0, 9.0, 10.0]))
    assert inner_edges(np.array([1.0, 2.0, 4.0, 8.0])).tolist() == pytest.approx(
        [1.0, 2**0.5, 2 * 2**0.5, 4 * 2**0.5, 8.0]
    )


def test_values_that_are_sorted_are_told():
    with pytest.warns(Reordered, match="omega: its values are sorted, 5 to 7"):
        axis = Axis("omega", np.array([6.0, 5.0, 7.0]))
    assert axis.values.tolist() == [5.0, 6.0, 7.0]
    with pytest.warns(Reordered):
        load_scan("tmd", {"vary": {"omega": {"values": [7.0, 6.0]}}})
