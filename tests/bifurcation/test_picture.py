"""Pictures: drawn from the archive alone, labeled, named without overlaps, repeatable."""

import re

import numpy as np
import pytest
from commands import printed
from hypothesis import given
from hypothesis import strategies as st
from layout import collisions
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import LogNorm, Normalize, to_hex
from matplotlib.figure import Figure
from PIL import Image

from nlds_vines import load_system, read
from nlds_vines.bifurcation.picture.choices import Slice
from nlds_vines.bifurcation.picture.diagram import looks_of
from nlds_vines.bifurcation.picture.drawing import PICTURE
from nlds_vines.model.labels import FLAGS
from nlds_vines.plotting import bands, palette
from nlds_vines.plotting.page import TWO_COLUMNS, page_of
from scans import archived, scan_of, unfilled

WINDOWS = (
    *((7.36, "T,1"), (7.40, "2T,2"), (7.44, "chaos"), (7.50, "3T,2"), (7.58, "undetermined")),
    *((7.68, "T,0"), (7.76, "4T,2"), (7.92, "2T,1"), (9.0, "T,0")),
)
OMEGA = {"omega": {"start": 5.0, "stop": 8.0, "num": 151}}
MAP = {
    "omega": {"start": 7.0, "stop": 8.0, "num": 30},
    "P": {"start": 600.0, "stop": 1000.0, "num": 20},
}
USUAL = ("section", "impacts", "energy", "regime")
BOTH = {"policy": "both"}
THREE, FOUR = ({"policy": "random", "count": count, "seed": 1} for count in (3, 4))


def regime(omega):
    return next(label for high, label in WINDOWS if omega < high)


CHAOS_OF_ARCHIVE = "chaos (for 3013 T)"
"""What a legend says of chaos in `archive_of`: 1 + 12 periods, and 3000 of the standard effort."""


def archive_of(path, want=USUAL, vary=OMEGA, system="ssul-set6", start=None, **values):
    """Write an archive of made-up results like those of Figure 8, with these values by dataset."""
    scan = scan_of(
        system, want, vary, start or "rest", "a test of pictures", transient=1, periods=12
    )
    arrays = unfilled(scan)
    omega = scan.axes[0].values
    for name, array in arrays.items():
        along = omega.reshape((-1,) + (1,) * (array.ndim - 1))
        if name in values:
            array[...] = values[name]
        elif name == "label":
            array[...] = np.vectorize(regime, otypes=[object])(along)
        elif name == "regime":
            array[...] = FLAGS["periodic"]
        elif array.dtype == np.float64:
            array[...] = np.cos(along) + np.arange(array.shape[-1]) / 10
    return archived(path, scan, arrays)


def columns(values):
    """Return values along the first of two axes, for all else alike."""
    return np.asarray(values)[:, np.newaxis, np.newaxis]


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    return archive_of(tmp_path_factory.mktemp("figures") / "usual.h5")


def drawn(path, show=None, page=TWO_COLUMNS):
    with read(path) as view:
        return PICTURE.figure(view, show, page)


@pytest.fixture
def picture(tmp_path):
    """Return a function that draws an archive of made-up results."""

    def draw(want=USUAL, vary=OMEGA, show=None, **options):
        number = len(list(tmp_path.iterdir()))
        return drawn(archive_of(tmp_path / f"{number}.h5", want, vary, **options), show)

    return draw


def texts(axes):
    return [text.get_text() for text in axes.texts]


def legend_of(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def mesh_of(axes):
    """Return the cells of a map, without what is hatched."""
    return next(mesh for mesh in axes.collections if isinstance(mesh, QuadMesh))


def faces(axes, row=0):
    """Return the colors of the cells in a row of a map."""
    mesh = mesh_of(axes)
    return [to_hex(face) for face in mesh.to_rgba(mesh.get_array())[row]]


def strips(figure):
    return [axes for axes in figure.axes if not axes.get_yticks().size]


def named(figure):
    return texts(strips(figure)[0])


def test_the_dots_of_figure_8_are_those_of_the_archive(usual):
    damper, structure, strip, _ = drawn(usual).axes
    assert damper.get_xlim() == structure.get_xlim() == strip.get_xlim() == (4.99, 8.01)
    with read(usual) as view:
        for panel, component in ((damper, 2), (structure, 0)):
            (cloud,) = panel.get_lines()
            expected = view.take("section", start=0, component=component)
            np.testing.assert_array_equal(cloud.get_ydata(), expected.ravel())
            np.testing.assert_array_equal(cloud.get_xdata(), np.repeat(view["omega"], 12))


def test_regimes_are_named_without_overlaps_and_gaps_in_knowledge_are_hatched(usual, picture):
    assert named(picture(vary={"omega": [6.0]})) == ["T,1"]  # one value is a diagram, too
    figure = drawn(usual)
    (strip,) = strips(figure)
    assert " ".join(named(figure)) == "T,1 2T,1 2T,2 chaos 3T,2 undetermined 4T,2 T,0"
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in strip.texts]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[i + 1 :])
    assert all(figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1 for box in boxes)
    assert all(box.y1 <= figure.bbox.y1 for box in boxes)
    # gaps in knowledge look like gaps
    assert len(strip.patches) == len(WINDOWS)
    (gap,) = [patch for patch in strip.patches if patch.get_hatch()]
    assert gap.get_x() == pytest.approx(7.50, abs=0.02)


@pytest.mark.parametrize(
    ("system", "want", "panels"),
    [
        ("none", ["section"], ["structure $x_1$ [m]"]),
        ("tmd", ["energy"], ["energy of the structure", "energy of the damper"]),
        ("ssul-set6", ["impacts"], ["impacts per forcing period", "period $n$"]),
        ("ssul-set6", ["clearance"], ["smallest near miss"]),
        ("ssul-set6", ["regime"], ["period $n$"]),
    ],
)
def test_whatever_is_recorded_is_drawn(picture, system, want, panels):
    figure = picture(want, system=system)
    labels = [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel()]
    assert len(labels) == len(panels)
    for label, expected in zip(labels, panels, strict=True):
        assert label.startswith(expected)


def test_a_map_has_a_color_and_a_name_for_every_regime(tmp_path):
    path = archive_of(tmp_path / "m.h5", ["regime"], MAP)
    figure = drawn(path)
    (axes,) = figure.axes
    legend = legend_of(axes)
    assert legend == [
        *("T,0", "T,1", "2T,1", "2T,2", "3T,2", "4T,2", CHAOS_OF_ARCHIVE, "undetermined")
    ]  # fmt: skip
    assert mesh_of(axes).get_array().shape == (20, 30)
    colors = palette.colors("chaos" if name == CHAOS_OF_ARCHIVE else name for name in legend)
    with read(path) as view:
        labels = view.take("label", start=0)
    for i, j in ((0, 0), (12, 3), (29, 19)):
        assert faces(axes, j)[i] == colors[labels[i, j]]


def test_the_legend_of_a_map_names_every_regime_with_more_than_half_a_percent(tmp_path):
    """Seven and more regimes that filled a map were "and 7 more"."""
    large = [f"{n}T,{k}" for n in (2, 3, 4, 5) for k in range(n - 1, n + 3)]
    labels = np.array((large * 30)[:400], dtype=object)
    labels[:2] = "T,9", "T,8"  # a quarter of a percent each
    vary = {
        "omega": np.linspace(5.0, 6.0, 20).tolist(),
        "P": np.linspace(700.0, 800.0, 20).tolist(),
    }
    labels = labels.reshape(20, 20, 1)
    path = archive_of(tmp_path / "many.h5", ("section", "regime"), vary, label=labels)
    with read(path) as view:
        figure = PICTURE.figure(view, "regimes")
    (axes,) = (axes for axes in figure.axes if axes.get_legend())
    *named, last = legend_of(axes)
    assert set(named) == set(large)
    assert last == "and 2 more"
    assert collisions(figure) == []


def test_a_map_without_regimes_shows_the_largest_energy_of_all_starts(picture):
    figure = picture(["energy"], MAP, start={"policy": "random", "count": 2, "seed": 1})
    axes, bar = figure.axes
    assert bar.get_ylabel().startswith("energy of the structure")
    assert bar.get_ylabel().endswith("largest of 2 starts")
    assert figure.texts[0].get_text().endswith("; 2 starts")
    assert axes.collections[0].get_array().shape == (20, 30)


def hatched(axes):
    """Return the hatches on a map, with the number of their rectangles."""
    patches = (item for item in axes.collections if isinstance(item, PolyCollection))
    return {item.get_hatch(): len(item.get_paths()) for item in patches}


LIMITED = {"kind": "ssvi-b", **load_system("ssbl").parameters}


def test_a_map_of_numbers_marks_where_the_limit_of_its_scene_is_violated(picture):
    violations = np.zeros((30, 20, 1), int)
    violations[3:5, 7] = 2
    assert picture(["energy"], MAP).axes[0].get_legend() is None
    axes = picture(["energy"], MAP, system=LIMITED, violations=violations).axes[0]
    assert legend_of(axes) == ["passes the limit"]
    (cells,) = [item for item in axes.collections if isinstance(item, PolyCollection)]
    assert hatched(axes) == {palette.PASSED: 1}
    (corners,) = (path.vertices for path in cells.get_paths())
    omega, force = np.linspace(7, 8, 30), np.linspace(600, 1000, 20)
    assert corners[:, 0].min() == pytest.approx((omega[2] + omega[3]) / 2)
    assert corners[:, 0].max() == pytest.approx((omega[4] + omega[5]) / 2)
    assert corners[:, 1].min() == pytest.approx((force[6] + force[7]) / 2)


LATE = "transient chaos to T,0"


@pytest.fixture(scope="module")
def four(tmp_path_factory):
    """Write a map of four starts: alike, in two regimes, in three, and of unknown ones."""
    cells = (
        ["T,1"] * 4,
        ["T,0", "T,0", "2T,1", LATE],
        ["9T,6", "chaos", "T,0", "T,0"],
        ["undetermined"] * 4,
    )
    settling = np.tile(np.arange(1, 5), (30, 20, 1))
    settling[27:, :, 1] = -1
    values = {
        "label": np.repeat(np.array(cells, dtype=object), [9, 9, 9, 3], axis=0)[:, np.newaxis],
        "settling": settling,
        "lyapunov": columns(np.linspace(-0.3, 0.2, 30)),
    }
    path, want = tmp_path_factory.mktemp("four") / "four.h5", ("regime", "settling", "lyapunov")
    return archive_of(path, want, MAP, start=FOUR, **values)


def test_a_map_of_several_starts_shows_the_most_frequent_regime_and_how_many_coexist(four):
    above, below = drawn(four).axes
    assert legend_of(above) == ["T,0", "T,1", "undetermined"]
    assert above.get_legend().get_title().get_text() == "most frequent regime"
    assert legend_of(below) == ["none known", "1", "2", "3"]
    plain = palette.colors(["T,0", "T,1"])
    assert [faces(above)[i] for i in (0, 9, 18, 29)] == [
        *(plain["T,1"], plain["T,0"], plain["T,0"], palette.OTHERS["undetermined"])
    ]  # fmt: skip
    assert len({faces(below)[i] for i in (0, 9, 18, 29)}) == 4
    assert texts(below) == ["(b)"]
    assert set(texts(above)) == {"(a)", "T,0", "T,1"}  # large regions have their names inside
    assert hatched(above) == {palette.hatch_of("undetermined"): 20}  # a run in each of the rows


def test_maps_of_several_starts_show_coexistence_shares_settling_and_exponents(four):
    # coexistence alone is a panel of its own
    (axes,) = drawn(four, "coexisting").axes
    assert legend_of(axes) == ["none known", "1", "2", "3"]
    # a share goes from none to all
    axes, bar = drawn(four, "share:T,0").axes
    (mesh,) = axes.collections
    assert [mesh.get_array()[0, i] for i in (0, 9, 18, 29)] == [0.0, 0.75, 0.5, 0.0]
    assert mesh.get_clim() == (0.0, 1.0)
    assert bar.get_ylabel() == "share of 4 starts in T,0"
    one = drawn(four, f"share:{LATE}").axes[0].collections[0].get_array()
    assert (one[0, 9], one[0, 18]) == (0.25, 0.0)
    # shares stand side by side, the most frequent first
    figure = drawn(four, "shares")
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert titles[:2] == ["T,0", "T,1"]
    assert set(titles) == {"T,0", "T,1", "2T,1", "9T,6", "chaos"}
    # settling is the largest of all starts, and covered where one never did
    axes = drawn(four, "settling").axes[0]
    mesh, cover = axes.collections
    assert mesh.get_array()[0, 0] == 4
    np.testing.assert_array_equal(mesh.get_array().mask[0], [False] * 27 + [True] * 3)
    np.testing.assert_array_equal(cover.get_array().mask[0], [True] * 27 + [False] * 3)
    assert legend_of(axes) == ["not settled, or no orbit to settle on"]


def test_numbers_that_span_decades_have_shades_by_logarithm_unless_told(tmp_path, error_of):
    many, few = columns(np.geomspace(1.0, 500.0, 30)), columns(np.linspace(2.0, 3.0, 30))
    path = archive_of(tmp_path / "m.h5", ["energy"], MAP, E1max=many, E2max=few)
    for show, norm in (
        ("E1max", LogNorm), ("log:E1max", LogNorm), ("linear:E1max", Normalize),
        ("E2max", Normalize), ("log:E2max", LogNorm),
    ):  # fmt: skip
        axes, bar = drawn(path, show).axes
        assert type(mesh_of(axes).norm) is norm, show
        low, high = bar.get_ylim()
        assert sum(low <= tick <= high for tick in bar.get_yticks()) >= 3
    assert "unknown show 'E9max'; did you mean" in error_of(drawn, path, "log:E9max")
    assert "it takes numbers above 0" in error_of(drawn, path, "log:reduction")


def test_a_curve_joins_no_two_regimes(picture):
    labels = np.repeat(["T,1", "3T,2", "T,1", "chaos", "T,1"], [20, 10, 10, 1, 110])
    values = {"label": labels[:, np.newaxis], "E1max": np.arange(151.0)[:, np.newaxis]}
    figure = picture(["section", "energy", "regime"], **values)
    (green,) = [axes for axes in figure.axes if axes.get_ylabel().startswith("energy")]
    curve, dots = green.get_lines()
    finite = np.isfinite(curve.get_ydata())
    assert np.split(curve.get_ydata(), np.flatnonzero(~finite))[0][-1] == 19.0
    assert (~finite).sum() == 4
    assert dots.get_ydata().tolist() == [40.0]


def test_names_that_would_stand_far_from_their_bands_are_in_the_legend(picture):
    labels = np.full((151, 1), "T,1", object)
    labels[20:50, 0] = [f"{2 + n % 4}T,{n}" for n in range(30)]
    figure = picture(["section", "regime"], label=labels)
    inside, rest = set(named(figure)), set(legend_of(figure.axes[-2]))
    assert not inside & rest
    assert {"T,1"} < inside
    assert any(word.startswith("and ") for word in rest)


def test_a_few_values_are_no_map_but_have_curves_and_panels_of_their_own(picture):
    vary = {"omega": {"start": 5.0, "stop": 8.0, "num": 61}, "P": [600.0, 800.0]}
    figure = picture(vary=vary)
    assert not any(isinstance(item, QuadMesh) for axes in figure.axes for item in axes.collections)
    one, other, energy = figure.axes[:3]
    assert one.get_ylabel() == other.get_ylabel() == "damper $x_2$ [m]"
    assert one.get_ylim() == other.get_ylim()
    for curve, dots in zip(energy.get_lines()[::2], energy.get_lines()[1::2], strict=True):
        abscissas = {*curve.get_xdata()[np.isfinite(curve.get_xdata())], *dots.get_xdata()}
        assert abscissas == set(np.linspace(5.0, 8.0, 61))
    assert "$P=600$ N" in legend_of(energy)
    assert "$P=800$ N" in legend_of(energy)
    assert [texts(strip)[-1] for strip in strips(figure)] == ["$P=600$ N", "$P=800$ N"]


def test_the_cells_of_a_map_end_where_the_values_end_and_have_the_width_of_the_page(picture):
    (axes,) = picture(["regime"], MAP).axes
    assert (axes.get_xlim(), axes.get_ylim()) == ((7.0, 8.0), (600.0, 1000.0))
    corners = mesh_of(axes).get_coordinates()
    assert (corners.min(axis=(0, 1)).tolist(), corners.max(axis=(0, 1)).tolist()) == (
        [7.0, 600.0], [8.0, 1000.0],
    )  # fmt: skip
    assert axes.get_position().x1 > 0.97
    legend = axes.get_legend().get_window_extent()
    assert legend.y1 < axes.get_window_extent().y0


def test_values_at_equal_ratios_stand_on_a_logarithmic_axis(picture):
    stiffnesses = {"start": 1e5, "stop": 1e9, "num": 9, "scale": "log"}
    vary = {"omega": {"start": 7.0, "stop": 8.0, "num": 9}, "K": stiffnesses}
    (axes,) = picture(["regime"], vary).axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "log")
    assert axes.get_ylim() == (1e5, 1e9)
    diagram = picture(("section", "energy"), {"K": vary["K"]})
    assert diagram.axes[0].get_xscale() == "log"
    assert axes.get_ylabel().endswith("[N/m$^{3/2}$]")


def test_what_a_map_or_a_diagram_cannot_show_is_refused(four, usual, picture, tmp_path, error_of):
    for path, what, message in (
        (four, "E1max", "not recorded"),
        (four, "shadows", "did you mean 'shares'"),
        (usual, "shares", "vary two"),
        (usual, "x1,x3", "unknown show 'x3'; did you mean 'x"),
    ):
        assert message in error_of(PICTURE.save, path, tmp_path / "a.png", what)
    assert list(tmp_path.iterdir()) == []
    line = error_of(picture, ["section"], MAP)
    assert re.search("holds only .*section.*: nothing to draw", line)
    line = error_of(picture, ["regime"], MAP, "shares", start=FOUR, label="undetermined")
    assert "no start ended in a known regime" in line


FEW = {**OMEGA, "P": [600.0, 800.0, 1000.0]}
RISING = columns(np.linspace(0.01, 1.0, 30))


@pytest.mark.parametrize("columns", [1, 2])
@pytest.mark.parametrize(
    ("want", "options", "shows"),
    [
        (USUAL, {}, [None, "regimes", "reduction,impact_rate"]),
        ((*USUAL, "lyapunov"), {"start": BOTH}, [None]),
        (USUAL, {"start": THREE}, [None]),
        (USUAL, {"vary": FEW}, [None]),
        (
            ("energy", "regime"),
            {"vary": MAP, "E1max": RISING, "reduction": RISING},
            [None, "reduction", "log:E1max", "periodicity"],
        ),
        (("energy",), {"vary": MAP, "system": LIMITED, "E1max": RISING}, ["E1max"]),
        (
            ("regime", "settling"),
            {"vary": MAP, "start": FOUR, "settling": [-1, 4, 40, 400]},
            [None, "shares", "settling"],
        ),
    ],
)
def test_no_text_is_cut_and_none_lies_over_another(tmp_path, want, options, shows, columns):
    path = archive_of(tmp_path / "x.h5", want, **options)
    for show in shows:
        assert collisions(drawn(path, show, page_of(columns))) == []


def test_an_overlap_and_a_cut_text_are_noticed():
    figure = Figure(figsize=(3, 3))
    figure.text(0.5, 0.5, "one")
    figure.text(0.52, 0.51, "other")
    figure.text(0.9, 0.1, "too long for it")
    assert collisions(figure) == ["'too long for it' is cut", "'one' lies over 'other'"]


@pytest.mark.parametrize(
    "want",
    [("section", "impacts", "energy", "regime"), ("energy", "regime"), ("energy", "impacts")],
)
def test_sweeps_on_two_orbits_with_equal_numbers_are_not_alike(want, tmp_path):
    """In the first 20 cells the sweeps are T,0 and T,2: everywhere with the same numbers."""
    differ = np.arange(151)[:, np.newaxis] + [20, 0] < 20  # in the sweep down alone
    values = dict.fromkeys(("section", "impact_rate", "E1max", "E2max", "reduction"), 0.5)
    values |= {"label": np.where(differ, "T,2", "T,0"), "impact_count": 2 * differ}
    path = archive_of(tmp_path / "b.h5", want, start=BOTH, periodicity=1, **values)
    with read(path) as view:
        both, up, down = looks_of(Slice(view, "omega"), np.zeros((151, 2, 1)))
    assert [look.name for look in (both, up, down)] == ["up and down alike", "up", "down"]
    assert up.which[:, 0].tolist() == down.which[:, 1].tolist() == [True] * 20 + [False] * 131


def test_random_starts_look_like_the_attractors_that_they_are_on(tmp_path):
    labels = np.repeat([[regime(omega)] for omega in np.linspace(5.0, 8.0, 151)], 3, axis=1)
    labels[:, 1] = "T,0"
    path = archive_of(tmp_path / "c.h5", start=THREE, label=labels)
    with read(path) as view:
        looks = looks_of(Slice(view, "omega"), np.zeros((151, 3, 1)))
    words = ["T,0", "T,1", "2T,1", "2T,2", "3T,2", "4T,2", "chaos", "undetermined"]
    assert [look.name for look in looks] == [*words[:6], CHAOS_OF_ARCHIVE, "undetermined"]
    for look, word in zip(looks, words, strict=True):
        np.testing.assert_array_equal(look.which, labels == word)


def test_without_orbits_the_numbers_that_are_drawn_decide_what_is_alike(tmp_path):
    path = archive_of(tmp_path / "b.h5", ["response"], start=BOTH)
    numbers = np.zeros((151, 2, 1))
    numbers[:20, 1] = 1.0
    with read(path) as view:
        both, up, _ = looks_of(Slice(view, "omega"), numbers)
    assert up.which.sum() == 20
    assert both.which.sum() == 131


def test_exponents_stand_on_a_line_at_zero_with_their_intervals(picture):
    exponents = np.linspace(-0.2, 0.1, 151)[:, np.newaxis]
    exponents[3] = np.nan
    (axes,) = picture(["lyapunov"], lyapunov=exponents, lyapunov_width=0.02).axes
    zero, dots = axes.get_lines()
    assert zero.get_ydata() == [0.0, 0.0]
    assert dots.get_ydata().size == 150
    (bars,) = axes.collections
    first = bars.get_segments()[0]
    np.testing.assert_allclose(first[:, 1], [-0.22, -0.18])


@pytest.mark.parametrize("form", ["png", "pdf", "svg"])
def test_pictures_carry_the_hash_and_repeat_byte_by_byte(tmp_path, usual, form):
    with read(usual) as view:
        scan_hash = view.attrs["scan_hash"]
    first, second = tmp_path / f"a.{form}", tmp_path / f"b.{form.upper()}"
    PICTURE.save(usual, first)
    PICTURE.save(usual, second)
    content = first.read_bytes()
    assert scan_hash.encode() in content
    assert content == second.read_bytes()
    assert sorted(file.name for file in tmp_path.iterdir()) == [first.name, second.name]
    if form == "png":  # of 200 dots per inch
        with Image.open(first) as image:
            assert image.info["scan_hash"] == scan_hash
            assert image.size[0] == pytest.approx(16 / 2.54 * 200, abs=1)
    assert (b"/Subtype /Image" in content) == (form == "pdf")  # its dots are an image


def test_bad_requests_and_an_interrupt_leave_nothing_behind(tmp_path, usual, monkeypatch, error_of):
    for path, file, message in (
        (usual, "a.gif", ".png, .pdf, .svg"),
        (usual, "nowhere/a.png", "cannot write"),
        (tmp_path / "absent.h5", "a.png", "no such file"),
    ):
        assert message in error_of(PICTURE.save, path, tmp_path / file)
    assert list(tmp_path.iterdir()) == []
    # an interrupted picture leaves the old one
    old = tmp_path / "a.png"
    old.write_bytes(b"old")

    def die(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", die)
    with pytest.raises(KeyboardInterrupt):
        PICTURE.save(usual, old)
    assert [file.read_bytes() for file in tmp_path.iterdir()] == [b"old"]


def test_drawing_loads_no_kernel_and_no_window_system(tmp_path, usual):
    code = (
        "import sys; from nlds_vines.bifurcation.picture.drawing import PICTURE;"
        "PICTURE.save(*sys.argv[1:]);"
        "print(sorted(n for n in sys.modules if n.split('.')[0] in ('numba', 'llvmlite', 'tkinter')"
        " or n.startswith(('nlds_vines.kernels.', 'matplotlib.pyplot'))))"
    )
    # numbers, and no code
    scene = "nlds_vines.kernels.scene"
    numbers = f"{[scene, scene + '.codes']}\n"
    assert printed("-c", code, usual, tmp_path / "a.png") == numbers


def test_bands_are_the_runs_of_equal_labels_and_spread_only_where_they_must():
    values = np.array([1.0, 2.0, 3.0, 5.0])
    runs = bands.bands(values, np.array(["a", "a", "b", "a"]))
    assert runs == [("a", 0.5, 2.5), ("b", 2.5, 4.0), ("a", 4.0, 6.0)]
    np.testing.assert_allclose(bands.spread([1, 5, 9], 1, 0, 10), [1, 5, 9])
    np.testing.assert_allclose(bands.spread([5, 5, 5], 1, 0, 10), [4, 5, 6])
    np.testing.assert_allclose(bands.spread([2, 5, 5.5], 1, 0, 10), [2, 4.75, 5.75])
    assert bands.spread([], 1, 0, 10).size == 0
    with pytest.raises(ValueError, match="no room"):
        bands.spread([1, 2, 3], 6, 0, 10)


@given(st.lists(st.floats(0, 10), min_size=1, max_size=12))
def test_spread_places_keep_their_distance_order_and_range(wanted):
    places = bands.spread(sorted(wanted), 0.8, 0.0, 10.0)
    assert np.all(np.diff(places) >= 0.8 - 1e-9)
    assert places[0] >= -1e-9
    assert places[-1] <= 10 + 1e-9
