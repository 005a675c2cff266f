"""Maps of the kind of modulation, and the bounds of 1:1 motion in closed form over maps."""

import numpy as np
import pytest
from test_picture import archive_of, faces, legend_of

import nlds_vines as nv
from nlds_vines.archives.archive import read
from nlds_vines.bifurcation.picture.maps import IN_TITLE, manifold_bounds
from nlds_vines.plotting.palette import COUNTS
from nlds_vines.plotting.style import NO_VALUE

MAP = {
    "omega": {"start": 0.93, "stop": 1.01, "num": 9},
    "P": {"start": 0.1, "stop": 0.9, "num": 12},
}


@pytest.fixture
def archive(tmp_path):
    def codes(name, array):
        if name == "capture":
            array[...] = (np.arange(array.shape[0]) % 5 - 1)[:, np.newaxis, np.newaxis]

    return archive_of(tmp_path / "map.h5", ["modulation"], MAP, "vi-nes", fill=codes)


def test_each_kind_of_modulation_has_a_color_and_a_word(archive):
    figure = nv.plot(archive, "capture")
    words = ["none", "no impacts", "strongly modulated", "sustained 1:1", "more impacts"]
    assert legend_of(figure.axes[0]) == words
    looks = [NO_VALUE, *COUNTS[:4]]
    assert faces(figure.axes[0]) == [looks[i % 5] for i in range(9)]
    with pytest.raises(nv.RequestError, match=r"show.*'capture'"):
        nv.plot(archive, "log:capture")


def test_the_bounds_are_those_of_the_balance(archive):
    """Inside them some amplitude has the system's Gamma, outside all of them have a smaller one."""
    with read(archive) as view:
        values, low, high = manifold_bounds(view)
    there = np.isfinite(low)
    assert 0 < np.count_nonzero(~there) < values.size - 5
    assert high[there][0] - low[there][0] < 0.001  # where it ends, the bounds meet
    manifold = nv.slow_manifold(nv.load_system("vi-nes"))
    assert values[there][0] == pytest.approx(2e-3 * 75.0 / manifold.best.Gamma, rel=1e-3)
    for value, first, last in zip(values[there][1:], low[there][1:], high[there][1:], strict=True):
        one = nv.slow_manifold(nv.load_system("vi-nes", P=value))
        xi = np.geomspace(one.least * (1 + 1e-9), 100.0, 200_001)
        for omega, inwards in ((first, 1.0), (last, -1.0)):
            reached = [
                one.gamma(xi, np.array((omega + step) / one.omega_joint)).max() >= one.Gamma
                for step in (-2e-5 * inwards, 2e-5 * inwards)
            ]
            assert reached == [False, True], (value, omega)


def test_they_are_drawn_over_any_map_of_omega(archive, tmp_path):
    for axes in (nv.plot(archive, "capture", manifold=True).axes[0],
                 nv.plot(archive, "two_impacts", manifold=True).axes[0]):  # fmt: skip
        with read(archive) as view:
            values, *bounds = manifold_bounds(view)
        assert len(axes.lines) == 2
        for line, bound in zip(axes.lines, bounds, strict=True):
            np.testing.assert_array_equal(line.get_xdata(), bound)
            np.testing.assert_array_equal(line.get_ydata(), values)
        assert axes.get_xlim() == (0.93, 1.01)
        titles = " ".join(text.get_text() for text in axes.figure.texts)
        assert IN_TITLE in titles.replace("\n", " ")
    turned = archive_of(tmp_path / "t.h5", ["modulation"], dict(reversed(MAP.items())), "vi-nes")
    up, _ = nv.plot(turned, "two_impacts", manifold=True).axes[0].lines
    np.testing.assert_array_equal(up.get_ydata(), bounds[0])


def test_what_has_no_closed_form_is_refused(archive, tmp_path):
    other = archive_of(tmp_path / "o.h5", ["energy"], {"omega": MAP["omega"], "P": MAP["P"]})
    with pytest.raises(nv.RequestError, match="kind 'ssbl' with law 'restitution'"):
        nv.plot(other, manifold=True)
    clearances = {"omega": MAP["omega"], "C": {"start": 50.0, "stop": 80.0, "num": 9}}
    wide = archive_of(tmp_path / "c.h5", ["energy"], clearances, "vi-nes")
    with pytest.raises(nv.RequestError, match=r"C = 50.0 and D = 75.0.*C = D"):
        nv.plot(wide, manifold=True)
    along = archive_of(tmp_path / "d.h5", ["energy"], {"omega": MAP["omega"]}, "vi-nes")
    with pytest.raises(nv.RequestError, match="over maps; curves: response-curves --manifold"):
        nv.plot(along, manifold=True)
    forces = {"P": MAP["P"], "e": {"start": 0.5, "stop": 0.9, "num": 9}}
    without = archive_of(tmp_path / "e.h5", ["energy"], forces, "vi-nes")
    with pytest.raises(nv.RequestError, match="of omega and another parameter; this is of P and e"):
        nv.plot(without, manifold=True)
