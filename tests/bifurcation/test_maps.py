"""Pictures of basins, and maps of the kind of modulation with bounds in closed form."""

import numpy as np
import pytest
from layout import collisions
from matplotlib.colors import to_hex
from test_picture import archive_of, columns, faces, legend_of

import nlds_vines as nv
from nlds_vines.archives import archive
from nlds_vines.archives.archive import read
from nlds_vines.archives.dataset import Dataset, Scale, Table
from nlds_vines.archives.provenance import SCHEMA
from nlds_vines.bifurcation.picture.drawing import PICTURE
from nlds_vines.bifurcation.picture.maps import IN_TITLE, manifold_bounds
from nlds_vines.plotting.page import page_of
from nlds_vines.plotting.palette import COUNTS, color_of
from nlds_vines.plotting.style import NO_VALUE
from scans import scan_of

TEXT = "of a test"


def made(path, axes, numbers, labels, shares=0.0, points=None):
    """Write an archive of made-up attractors; return it open."""
    lanes = (*axes, "start")
    row = (*(name for name in axes if not name.endswith("_0")), "number")
    tables = {
        "status": (lanes, "int8", np.zeros(numbers.shape, np.int8)),
        "attractor": (lanes, "int32", numbers),
        "label": (lanes, "str", np.full(numbers.shape, "T,1", object)),
        "attractor_label": (row, "str", np.array(labels, object)),
        "attractor_share": (row, "float64", np.broadcast_to(shares, np.shape(labels))),
    }
    if points is not None:
        tables["attractor_point"] = ((*row, "component"), "float64", points)
    lengths = {name: len(values) for name, values in axes.items()}
    lengths |= {"start": numbers.shape[-1], "number": np.shape(labels)[-1], "component": 2}
    datasets = [Dataset(n, dims, kind, "1", TEXT, "" if kind == "str" else 0)
                for n, (dims, kind, _) in tables.items()]  # fmt: skip
    scales = [Scale(name, np.array(values, float), "m", TEXT) for name, values in axes.items()]
    scales += [Scale("start", np.array(["rest"] * numbers.shape[-1]), "1", TEXT)]
    scales += [Scale("number", np.arange(lengths["number"]), "1", TEXT)]
    scales += [Scale("component", np.array(["x", "v"]), "1", TEXT)]
    pieces = [(n, (slice(None),) * len(dims), values) for n, (dims, _, values) in tables.items()]
    about = {"title": "made up", "scan": "", "scan_hash": "0", "schema": SCHEMA}
    archive.write(path, Table.of(datasets, lengths), scales, pieces, lambda: about)
    return nv.read(path)


@pytest.fixture
def plane(tmp_path):
    numbers = np.zeros((20, 30, 1), np.int32)
    numbers[10:] = 1
    numbers[:, 20:] = 2
    numbers[0, 0] = -1
    axes = {"x_0": np.linspace(0, 1, 20), "v_0": np.linspace(0, 2, 30)}
    points = np.array([[0.25, 0.5], [0.75, 0.5], [0.5, 9.0]])
    with made(tmp_path / "p.h5", axes, numbers, ["T,1", "T,1", "3T,2"], points=points) as view:
        yield view


def legend_in(figure):
    (axes,) = (axes for axes in figure.axes if axes.get_legend())
    return legend_of(axes)


def test_two_attractors_of_one_label_have_two_names_and_two_colors(plane):
    figure = PICTURE.figure(plane)
    assert collisions(figure) == collisions(PICTURE.figure(plane, page=page_of(1))) == []
    names = legend_in(figure)
    assert names == ["T,1 (0)", "T,1 (1)", "3T,2", "not known", "points of attractors"]
    (mesh,) = figure.axes[0].collections
    shades = {to_hex(color) for color in mesh.cmap.colors}
    assert len(shades) == 4
    assert {color_of("T,1"), color_of("3T,2")} <= shades
    lines = [line.get_xydata().tolist() for line in figure.axes[0].lines]
    assert lines == [[[0.25, 0.5]], [[0.75, 0.5]]]  # the third lies outside
    # other pictures are drawn on request
    regimes = PICTURE.figure(plane, "regimes")
    assert legend_in(regimes) == ["T,1"]
    assert "3T,2" in legend_in(PICTURE.figure(plane, "basins", ax=regimes.axes[0]))


def test_shares_stand_upon_each_other(tmp_path):
    axes = {"omega": [1.0, 2.0, 3.0]}
    labels = [["T,0", ""], ["T,0", "4T,2"], ["T,0", "2T,1"]]
    shares = np.array([[1.0, np.nan], [0.25, 0.5], [0.4, 0.6]])
    with made(tmp_path / "s.h5", axes, np.zeros((3, 5), np.int32), labels, shares) as view:
        figure = PICTURE.figure(view)
    assert legend_in(figure) == ["T,0", "2T,1", "4T,2", "not known"]
    bars = [(bar.get_y(), bar.get_height()) for bar in figure.axes[0].patches]
    assert np.allclose(bars[:3], [(0, 1), (0, 0.25), (0, 0.4)])
    assert np.allclose(bars[3:6], [(1, 0), (0.25, 0.5), (0.4, 0.6)])
    assert np.allclose(bars[6:], [(1, 0), (0.75, 0.25), (1, 0)])
    assert to_hex(figure.axes[0].patches[4].get_facecolor()) == color_of("4T,2")


def test_a_parameter_and_a_start_have_a_map_and_shares(tmp_path):
    axes = {"omega": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "x_0": np.linspace(0, 1, 6)}
    labels = [["T,0", "9T,1"]] * 3 + [["T,0", "7T,1"]] * 3
    numbers = np.zeros((6, 6, 1), np.int32)
    numbers[:, 3:] = 1
    with made(tmp_path / "m.h5", axes, numbers, labels, 0.5) as view:
        figure = PICTURE.figure(view)
        for columns in (1, 2):
            assert collisions(PICTURE.figure(view, page=page_of(columns))) == []
    assert len(figure.axes) == 2
    assert figure.axes[0].get_xlim() == figure.axes[1].get_xlim()
    assert legend_in(figure) == ["T,0", "6T and longer"]


@pytest.mark.kernels
def test_what_has_no_basins_is_told(tmp_path, error_of):
    axes = {"omega": np.linspace(1, 2, 6), "P": np.linspace(1, 2, 6)}
    numbers, labels = np.zeros((6, 6, 1), np.int32), np.full((6, 6, 1), "T,0")
    with made(tmp_path / "n.h5", axes, numbers, labels) as view:
        assert legend_in(PICTURE.figure(view)) == ["T,1"]  # the usual map
        line = error_of(PICTURE.figure, view, "basins")
    assert "vary two initial conditions, or one parameter" in line
    path = nv.scan(scan_of("none", ["energy"], {"omega": [1.0, 2.0]}), quiet=True)
    line = error_of(path.plot, "basins")
    assert "needs attractors: scan with --record attractor" in line


OMEGA = {"omega": {"start": 0.93, "stop": 1.01, "num": 9}}
BOUNDED = {**OMEGA, "P": {"start": 0.1, "stop": 0.9, "num": 12}}


@pytest.fixture
def modulated(tmp_path):
    codes = columns(np.arange(9) % 5 - 1)
    return archive_of(tmp_path / "map.h5", ["modulation"], BOUNDED, "vi-nes", capture=codes)


def test_each_kind_of_modulation_has_a_color_and_a_word(modulated):
    figure = nv.plot(modulated, "capture")
    words = ["none", "no impacts", "strongly modulated", "sustained 1:1", "more impacts"]
    assert legend_of(figure.axes[0]) == words
    looks = [NO_VALUE, *COUNTS[:4]]
    assert faces(figure.axes[0]) == [looks[i % 5] for i in range(9)]
    with pytest.raises(nv.RequestError, match=r"show.*'capture'"):
        nv.plot(modulated, "log:capture")


def test_the_bounds_are_those_of_the_balance(modulated):
    """Inside them some amplitude has the system's Gamma, outside all of them have a smaller one."""
    with read(modulated) as view:
        values, low, high = manifold_bounds(view)
    there = np.isfinite(low)
    assert 0 < np.count_nonzero(~there) < values.size - 5
    assert high[there][0] - low[there][0] < 0.001  # where it ends, the bounds meet
    manifold = nv.slow_manifold(nv.load_system("vi-nes"))
    assert values[there][0] == pytest.approx(2e-3 * 75.0 / manifold.best.Gamma, rel=1e-3)
    for value, first, last in zip(values[there][1:], low[there][1:], high[there][1:], strict=True):
        one = nv.slow_manifold(nv.load_system("vi-nes", P=value))
        xi = np.geomspace(one.least * (1 + 1e-9), 100.0, 200_001)
        reached = [
            one.gamma(xi, np.array((bound + step) / one.omega_joint)).max() >= one.Gamma
            for bound in (first, last)
            for step in (-2e-5, 2e-5)
        ]
        assert reached == [False, True, True, False], value


def test_they_are_drawn_over_any_map_of_omega(modulated, tmp_path):
    with read(modulated) as view:
        values, *bounds = manifold_bounds(view)
    for show in ("capture", "two_impacts"):
        axes = nv.plot(modulated, show, manifold=True).axes[0]
        for line, bound in zip(axes.lines, bounds, strict=True):
            np.testing.assert_array_equal(line.get_xdata(), bound)
            np.testing.assert_array_equal(line.get_ydata(), values)
        assert axes.get_xlim() == (0.93, 1.01)
        titles = " ".join(text.get_text() for text in axes.figure.texts)
        assert IN_TITLE in titles.replace("\n", " ")
    vary = dict(reversed(BOUNDED.items()))
    turned = archive_of(tmp_path / "t.h5", ["modulation"], vary, "vi-nes")
    up, _ = nv.plot(turned, "two_impacts", manifold=True).axes[0].lines
    np.testing.assert_array_equal(up.get_ydata(), bounds[0])


@pytest.mark.parametrize(
    ("vary", "want", "words"),
    [
        (BOUNDED, ["energy"], "kind 'ssbl' with law 'restitution'"),
        (
            {**OMEGA, "C": {"start": 50.0, "stop": 80.0, "num": 9}},
            ["modulation"],
            "C = 50.0 and D = 75.0",
        ),
        (OMEGA, ["modulation"], "over maps; curves: response-curves --manifold"),
        (
            {"P": BOUNDED["P"], "e": {"start": 0.5, "stop": 0.9, "num": 9}},
            ["modulation"],
            "of omega and another parameter; this is of P and e",
        ),
    ],
)
def test_what_has_no_closed_form_is_refused(vary, want, words, tmp_path, error_of):
    system = "vi-nes" if want == ["modulation"] else "ssul-set6"
    path = archive_of(tmp_path / "map.h5", want, vary, system)
    assert words in error_of(nv.plot, path, manifold=True)
