"""Pictures: drawn from the archive alone, labelled, named without overlaps, repeatable."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import nlds_vines
from nlds_vines import figures
from nlds_vines.archive import read
from nlds_vines.errors import RequestError
from nlds_vines.figures import bands, palette
from nlds_vines.parts import Block, Parts
from nlds_vines.record import FLAGS, datasets, filled, sizes
from nlds_vines.scan import load_scan

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


def regime(omega):
    return next(label for high, label in WINDOWS if omega < high)


def archive_of(path, want=USUAL, vary=OMEGA, system="ssul-set6", start=None):
    """Write an archive of made-up results that look like those of Figure 8."""
    scan = load_scan(
        {
            "title": "a test of pictures",
            "system": system,
            "vary": vary,
            "start": start or {"policy": "rest"},
            "sampling": {"transient": 1, "periods": 12},
            "record": {"want": list(want)},
        }
    )
    length = sizes(scan)
    found = {e.name: filled(e, tuple(length[dim] for dim in e.dims)) for e in datasets(scan)}
    omega = scan.axes[0].values
    for name, array in found.items():
        along = omega.reshape((-1,) + (1,) * (array.ndim - 1))
        if name == "label":
            array[...] = np.vectorize(regime, otypes=[object])(along)
        elif array.dtype == np.float64:
            array[...] = np.cos(along) + np.arange(array.shape[-1]) / 10
    if "regime" in found:
        found["regime"][...] = FLAGS["periodic"]
    block = Block(0, tuple((0, size) for size in scan.shape))
    with Parts.open(path, scan) as parts:
        parts.write(block, found)
        return parts.consolidate([block], {})


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    return archive_of(tmp_path_factory.mktemp("figures") / "usual.h5")


def drawn(path):
    with read(path) as view:
        return figures.diagram(view) if len(view.axes) == 1 else figures.regime_map(view)


def texts(axes):
    return [text.get_text() for text in axes.texts]


def named(figure):
    """Return the regimes named on the strip."""
    return texts(figure.axes[-1])


# ---- diagrams ------------------------------------------------------------------------------------


def test_figure_8_has_two_panels_with_symbols_and_units_and_the_energy_in_green(usual):
    figure = drawn(usual)
    damper, structure, energy, strip = figure.axes
    assert damper.get_ylabel() == "damper $x_2$ [m]"
    assert structure.get_ylabel() == "structure $x_1$ [m]"
    assert structure.get_xlabel() == r"angular frequency of the force $\omega$ [rad/s]"
    assert "[J]" in energy.get_ylabel()
    assert energy.get_lines()[0].get_color() == "#009e73"
    assert damper.get_xlim() == structure.get_xlim() == strip.get_xlim() == (4.99, 8.01)
    assert figure.texts[0].get_text() == "a test of pictures"
    assert figure.get_figwidth() == pytest.approx(16 / 2.54)


def test_the_dots_are_the_archives_section(usual):
    figure = drawn(usual)
    with read(usual) as view:
        for panel, component in ((figure.axes[0], 2), (figure.axes[1], 0)):
            (cloud,) = panel.get_lines()
            expected = view.take("section", start=0, component=component)
            np.testing.assert_array_equal(cloud.get_ydata(), expected.ravel())
            np.testing.assert_array_equal(cloud.get_xdata(), np.repeat(view["omega"], 12))
            assert cloud.get_rasterized()
            assert cloud.get_linestyle() == "None"


def test_regimes_are_named_and_names_do_not_overlap(usual):
    figure = drawn(usual)
    strip = figure.axes[-1]
    assert named(figure) == [
        *("T,1", "2T,1", "2T,2", "chaos", "3T,2", "undetermined", "T,0", "4T,2", "T,0")
    ]
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in strip.texts]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[i + 1 :])
    assert all(figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1 for box in boxes)
    assert all(box.y1 <= figure.bbox.y1 for box in boxes)


def test_gaps_in_knowledge_look_like_gaps(usual):
    patches = drawn(usual).axes[-1].patches
    hatched = [patch for patch in patches if patch.get_hatch()]
    assert len(patches) == len(WINDOWS)
    assert len(hatched) == 1
    assert hatched[0].get_x() == pytest.approx(7.50, abs=0.02)


def test_several_starts_have_a_legend_and_colours_of_their_own(tmp_path):
    path = archive_of(tmp_path / "r.h5", start={"policy": "random", "count": 3, "seed": 1})
    structure = drawn(path).axes[1]
    assert len({line.get_color() for line in structure.get_lines()}) == 3
    legend = [text.get_text() for text in structure.get_legend().get_texts()]
    assert legend == ["start: random 0", "start: random 1", "start: random 2"]


def test_up_and_down_have_two_colours(tmp_path):
    colours = {
        drawn(archive_of(tmp_path / f"{policy}.h5", start={"policy": policy}))
        .axes[0].get_lines()[0].get_color()
        for policy in ("rest", "up", "down")
    }  # fmt: skip
    assert len(colours) == 3


@pytest.mark.parametrize(
    ("system", "want", "panels"),
    [
        ("none", ["section"], ["structure $x_1$ [m]"]),
        ("tmd", ["energy"], ["energy of the structure", "energy of the damper"]),
        ("ssul-set6", ["impacts"], ["impacts per forcing period"]),
        ("ssul-set6", ["clearance"], ["smallest near miss"]),
        ("ssul-set6", ["regime"], ["period $n$"]),
    ],
)
def test_whatever_is_recorded_is_drawn(tmp_path, system, want, panels):
    figure = drawn(archive_of(tmp_path / "x.h5", want, system=system))
    labels = [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel()]
    assert len(labels) == len(panels)
    for label, expected in zip(labels, panels, strict=True):
        assert label.startswith(expected)


def test_a_single_value_is_a_diagram_too(tmp_path):
    figure = drawn(archive_of(tmp_path / "x.h5", vary={"omega": {"values": [6.0]}}))
    assert named(figure) == ["T,1"]


# ---- maps ----------------------------------------------------------------------------------------


def test_a_map_has_a_colour_and_a_name_for_every_regime(tmp_path):
    path = archive_of(tmp_path / "m.h5", ["regime"], MAP)
    (axes,) = drawn(path).axes
    legend = [text.get_text() for text in axes.get_legend().get_texts()]
    assert legend == [
        *("T,0", "T,1", "2T,1", "2T,2", "3T,2", "4T,2", "chaos", "undetermined")
    ]  # fmt: skip
    assert axes.get_xlabel().endswith(r"$\omega$ [rad/s]")
    assert axes.get_ylabel() == "amplitude of the force $P$ [N]"
    (mesh,) = axes.collections
    assert mesh.get_array().shape == (20, 30)
    colours = palette.colours(legend)
    with read(path) as view:
        labels = view.take("label", start=0)
    faces = mesh.to_rgba(mesh.get_array()).reshape(20, 30, 4)
    for place in ((0, 0), (12, 3), (29, 19)):
        hexed = "#" + "".join(f"{round(255 * c):02x}" for c in faces[place[::-1]][:3])
        assert hexed == colours[labels[place]]


def test_a_map_without_regimes_shows_the_largest_energy_of_all_starts(tmp_path):
    start = {"policy": "random", "count": 2, "seed": 1}
    figure = drawn(archive_of(tmp_path / "m.h5", ["energy"], MAP, start=start))
    axes, bar = figure.axes
    assert bar.get_ylabel().startswith("energy of the structure")
    assert bar.get_ylabel().endswith("largest of 2 starts")
    assert figure.texts[0].get_text().endswith("; 2 starts")
    assert axes.collections[0].get_array().shape == (20, 30)


def test_diagram_and_map_refuse_each_others_archives(tmp_path, usual):
    with read(usual) as view, pytest.raises(RequestError, match="diagram"):
        figures.regime_map(view)
    with (
        read(archive_of(tmp_path / "m.h5", ["regime"], MAP)) as view,
        pytest.raises(RequestError, match="map"),
    ):
        figures.diagram(view)


# ---- files ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["png", "pdf", "svg"])
def test_pictures_carry_the_hash_and_repeat_byte_by_byte(tmp_path, usual, form):
    with read(usual) as view:
        scan_hash = view.attrs["scan_hash"]
    first, second = tmp_path / f"a.{form}", tmp_path / f"b.{form.upper()}"
    assert figures.save(usual, first) == first
    figures.save(usual, second)
    content = first.read_bytes()
    assert scan_hash.encode() in content
    assert content == second.read_bytes()
    assert sorted(file.name for file in tmp_path.iterdir()) == [first.name, second.name]


def test_a_png_has_200_dots_per_inch(tmp_path, usual):
    with Image.open(figures.save(usual, tmp_path / "a.png")) as picture:
        assert picture.info["scan_hash"]
        assert picture.size[0] == pytest.approx(16 / 2.54 * 200, abs=1)


def test_the_dots_of_a_pdf_are_an_image(tmp_path, usual):
    content = figures.save(usual, tmp_path / "a.pdf").read_bytes()
    assert b"/Subtype /Image" in content


def test_bad_requests_are_one_line_and_leave_nothing_behind(tmp_path, usual):
    with pytest.raises(RequestError, match=r"\.png, \.pdf, \.svg"):
        figures.save(usual, tmp_path / "a.gif")
    with pytest.raises(RequestError, match="cannot write"):
        figures.save(usual, tmp_path / "nowhere" / "a.png")
    with pytest.raises(RequestError, match="no such file"):
        figures.save(tmp_path / "absent.h5", tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_picture_leaves_the_old_one(tmp_path, usual, monkeypatch):
    old = tmp_path / "a.png"
    old.write_bytes(b"old")

    def die(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", die)
    with pytest.raises(KeyboardInterrupt):
        figures.save(usual, old)
    assert [file.read_bytes() for file in tmp_path.iterdir()] == [b"old"]


def test_drawing_loads_no_kernel_and_no_window_system(tmp_path, usual):
    code = (
        "import sys; from nlds_vines import figures; figures.save(*sys.argv[1:]);"
        "print([n for n in sys.modules if n.split('.')[0] in ('numba', 'llvmlite', 'tkinter')"
        " or n.startswith(('nlds_vines.kernels', 'matplotlib.pyplot'))])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, usual, tmp_path / "a.png"],
        capture_output=True,
        text=True,
        env={"PYTHONPATH": str(Path(nlds_vines.__path__[0]).parent)},
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "[]\n"), done.stderr


# ---- bands and colours ---------------------------------------------------------------------------


def test_bands_are_the_runs_of_equal_labels():
    values = np.array([1.0, 2.0, 3.0, 5.0])
    found = bands.bands(values, np.array(["a", "a", "b", "a"]))
    assert found == [("a", 0.5, 2.5), ("b", 2.5, 4.0), ("a", 4.0, 6.0)]


@given(st.lists(st.floats(0, 10), min_size=1, max_size=12))
def test_spread_places_keep_their_distance_order_and_range(wanted):
    places = bands.spread(sorted(wanted), 0.8, 0.0, 10.0)
    assert np.all(np.diff(places) >= 0.8 - 1e-9)
    assert places[0] >= -1e-9
    assert places[-1] <= 10 + 1e-9


def test_spread_moves_nothing_without_need_and_centres_a_group():
    np.testing.assert_allclose(bands.spread([1, 5, 9], 1, 0, 10), [1, 5, 9])
    np.testing.assert_allclose(bands.spread([5, 5, 5], 1, 0, 10), [4, 5, 6])
    np.testing.assert_allclose(bands.spread([2, 5, 5.5], 1, 0, 10), [2, 4.75, 5.75])
    assert bands.spread([], 1, 0, 10).size == 0
    with pytest.raises(ValueError, match="no room"):
        bands.spread([1, 2, 3], 6, 0, 10)


def test_colours_tell_regimes_apart_and_order_is_by_period():
    labels = ["chaos", "undetermined", "failed", "T,1", "12T,9", "2T,1", "T,0", "2T,2",
              "quasiperiodic", "transient chaos to T,0"]  # fmt: skip
    colours = palette.colours(labels)
    assert len(set(colours.values())) == len(labels)
    assert palette.ordered(labels) == [
        *("T,0", "T,1", "2T,1", "2T,2", "12T,9"),
        *("quasiperiodic", "chaos", "transient chaos to T,0", "undetermined", "failed"),
    ]
    assert palette.is_dark(colours["chaos"])
    assert not palette.is_dark(colours["T,0"])


def test_the_ramp_grows_lighter_with_the_period():
    def light(colour):
        red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
        return 0.299 * red + 0.587 * green + 0.114 * blue

    shades = [light(colour) for colour in palette.RAMP]
    assert shades == sorted(shades)
    assert palette.period_and_impacts("3T,2") == (3, 2)
    assert palette.period_and_impacts("T,0") == (1, 0)
    assert palette.period_and_impacts("chaos") is None
