"""A finished archive is drawn by `nlds-vines plot` and `nv.plot`; pictures are not replaced."""

import re
from math import pi, sqrt

import matplotlib
import numpy as np
import pytest
from layout import collisions
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import nlds_vines as nv
from nlds_vines.archives.dataset import Dataset
from nlds_vines.bifurcation.command import main
from nlds_vines.bifurcation.picture.choices import quantities
from nlds_vines.plotting import chosen_panels
from nlds_vines.scans.run_report import Report

SMALL = ["--vary", "omega=6:6.5:5", "--transient", "50", "--periods", "20", "--quiet"]
DEEP = {
    **{"kind": "ssvi-b", "m1": 1000.0, "k1": 3.95e4, "c1": 452.0, "m2": 60.0, "k2": 600.0},
    **{"c2": 262.0, "C": 0.05, "D": 0.02, "P": 800.0, "omega": 6.28, "K": 2.5e7},
}
"""A damper that passes its limit."""


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plot")
    assert main([*SMALL, "-o", str(folder / "small.h5"), "--plot", str(folder / "small.png")]) == 0
    return folder / "small.h5"


def test_a_figure_is_returned_or_drawn_into_given_axes_and_nothing_is_written(small, error_of):
    before = sorted(small.parent.iterdir())
    figure = nv.plot(small)
    assert isinstance(figure, Figure)
    assert figure.get_figwidth() == pytest.approx(16 / 2.54)
    assert nv.plot(str(small), columns=1).get_figwidth() == pytest.approx(8.4 / 2.54)
    assert sorted(small.parent.iterdir()) == before
    # or into given axes
    figure = Figure()
    one, other = figure.subplots(1, 2)
    assert nv.plot(small, "E1max", ax=other) is figure
    assert not one.get_lines()
    assert other.get_ylabel().endswith("[J]")
    assert other.get_lines()
    assert "unknown columns '3'" in error_of(nv.plot, small, columns=3)
    line = error_of(nv.plot, small, "x1,x2", ax=one)
    assert "'x1,x2' names several panels, axes take one of: E" in line


def test_any_recorded_quantity_is_an_ordinate_in_the_order_asked_for(small):
    figure = nv.plot(small, "v2,energy,impact_rate")
    labels = [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel()]
    assert [label.split(" $")[0] for label in labels] == [
        *("velocity of the damper", "energy of the structure", "energy of the damper"),
        "impacts per forcing period",
    ]  # fmt: skip
    with nv.read(small) as view:
        section = view.take("section", start=0, component=3)
    (cloud,) = figure.axes[0].get_lines()
    np.testing.assert_array_equal(cloud.get_ydata(), section.ravel())


def test_a_dataset_that_nobody_knows_yet_can_be_drawn_by_its_meaning_and_unit():
    new = Dataset("stroke", ("omega", "start"), "float64", "m", "largest stroke, exact", np.nan)
    codes = Dataset("kind", ("omega", "start"), "int8", "1", "a code", 0, {"a": 0})
    entries = quantities([new, codes], [])
    assert [name for name, one in entries.items() if not one.coded] == ["stroke"]
    assert entries["kind"].coded  # which maps alone show
    assert entries["stroke"].label == "largest stroke [m]"


PANELS = {
    "transients": (
        "--system tmd --starts 4 --transient 40 --periods 20",
        ["survival", "shares", "settling"], "forcing periods until settled",
    ),
    "tuning": (
        "--system tmd --surface k2,c2 --surface-size 3 --generations 2 --population 6 --polish 5",
        ["objective"], "damping between damper and structure",
    ),
    "continuation": ("--along omega=7:7.2", ["x2", "E1max"], "energy of the structure"),
    "response-curves": (
        "--system tmd --system ssul-set6 --vary omega=6:6.5:3 --transient 40 --periods 20",
        ["energies", "reduction"], "reduction [%]",
    ),
}  # fmt: skip
"""Options with which a task computes little, names of its panels, the ordinate of the last."""


@pytest.mark.kernels
@pytest.mark.parametrize("kind", PANELS)
def test_panels_of_every_kind_are_chosen_narrow_and_in_given_axes(
    kind, tmp_path, ask, answer, error_of
):
    words, names, ordinate = PANELS[kind]
    path, picture, again = (tmp_path / name for name in ("a.h5", "a.png", "again.png"))
    ask(kind, *words.split(), "-o", path, "--plot", picture, "--quiet")
    ask("plot", path, "-o", again)
    assert again.read_bytes() == picture.read_bytes()
    listed = [line.split()[0] for line in answer("plot", path, "--show", "?").splitlines()]
    assert [name for name in listed if name in names] == names
    assert listed[0] == names[0]
    wide, narrow = nv.plot(path), nv.plot(path, columns=1)
    assert collisions(wide) == collisions(narrow) == []
    assert narrow.get_figwidth() == pytest.approx(8.4 / 2.54)
    assert [one.get_ylabel() for one in narrow.axes] == [one.get_ylabel() for one in wide.axes]
    for name in names:
        alone = nv.plot(path, name, columns=1).axes[0]
        figure = Figure(layout="constrained")
        one, other = figure.subplots(1, 2)
        assert nv.plot(path, name, ax=other) is figure
        assert not one.has_data()
        assert len(other.get_lines()) == len(alone.get_lines())
        assert other.get_ylabel() == alone.get_ylabel()
        assert other.has_data()
        figure.draw_without_rendering()
    assert other.get_ylabel().startswith(ordinate)
    figure = Figure()
    main = nv.plot(path, ax=figure.add_subplot()).axes[0]
    assert main.get_ylabel() == nv.plot(path, names[0]).axes[0].get_ylabel()
    line = error_of(nv.plot, path, "nosuch" if kind != "transients" else "survival,nosuch")
    assert re.search(f"unknown show 'nosuch'.* allowed: {names[0]}", line)
    if len(names) > 1:
        both = ",".join(names[:2])
        line = error_of(nv.plot, path, both, ax=main)
        assert f"'{both}' names several panels, axes take one of" in line


def test_what_users_set_in_matplotlib_stays(small, error_of):
    with matplotlib.rc_context({"font.size": 13, "axes.labelsize": 17}):
        figure = nv.plot(small, "E1max")
    assert figure.axes[0].yaxis.label.get_fontsize() == 17
    assert nv.plot(small, "E1max").axes[0].yaxis.label.get_fontsize() == 9
    dark = nv.plot(small, "E1max", style="dark_background")
    assert dark.get_facecolor() == (0.0, 0.0, 0.0, 1.0)
    line = error_of(nv.plot, small, style="nosuch")
    assert re.search("style 'nosuch' is no file; allowed: .*ggplot", line)


def test_a_panel_in_the_users_figure_leaves_the_others_and_has_the_users_letters(small):
    figure = Figure()
    one, other = figure.subplots(1, 2)
    nv.plot(small, "E1max", ax=one)
    usual = matplotlib.rcParamsDefault["font.family"]
    axes = {"f": {"start": 0.9, "stop": 1, "num": 5}, "C": {"start": 0.05, "stop": 0.1, "num": 5}}
    of_regimes = nv.scan("ssul-set6", vary=axes, sampling=SHORT, record=RECORD, quiet=True)
    nv.plot(of_regimes, "regimes", ax=other)
    assert "omega" in one.get_xlabel()
    assert "[Hz]" in other.get_xlabel()
    assert other.texts
    assert {text.get_fontfamily()[0] for text in other.texts} == {*usual}


@pytest.mark.slow("it draws seven figures")
def test_a_picture_has_the_width_and_the_title_that_options_state(small, tmp_path, ask, error_of):
    own, other = nv.plot(small), nv.plot(small, width=12, title="a map: ω = 6.28 rad/s")
    assert other.get_figwidth() == pytest.approx(12 / 2.54)
    assert other.get_suptitle() == r"a map: $\omega$ = 6.28 rad/s"
    none = nv.plot(small, columns=1, title="")
    assert none.get_suptitle() == ""
    assert none.get_figwidth() == pytest.approx(8.4 / 2.54)
    # no room is left for it, and panels keep their heights
    lost = own.get_figheight() - nv.plot(small, title="").get_figheight()
    assert 0.1 < lost < 0.4
    assert collisions(none) == []
    for figure in (nv.plot(small, title=""), other):
        for a, b in zip(figure.axes, own.axes, strict=True):
            a, b = (one.get_position().height * one.figure.get_figheight() for one in (a, b))
            assert a == pytest.approx(b, abs=1e-4)
    # a command that computes draws as `plot` does
    path, drawn, again = (tmp_path / name for name in ("a.h5", "a.png", "again.png"))
    look = ["--columns", "1", "--width", "9", "--title", ""]
    ask("bifurcation", *SMALL, "-o", path, "--plot", drawn, *look)
    ask("plot", path, "-o", again, *look)
    assert again.read_bytes() == drawn.read_bytes()
    for words, wrong in {
        "width = 2; allowed: 4 to 100 cm": {"width": 2},
        "unknown columns '3'": {"columns": 3},
        "title and width are those of a page": {"title": "", "ax": own.axes[0]},
    }.items():
        assert words in error_of(nv.plot, small, **wrong)


LOADED = ["--load", "tone:amplitude=3,omega=6"]


@pytest.mark.parametrize(
    "command",
    [
        ["bifurcation"], ["response-curves"], ["portrait"], ["continuation"], ["tuning"],
        ["transients"], ["response-history", *LOADED],
    ],
)  # fmt: skip
def test_every_drawing_command_refuses_a_look_before_it_computes(command, tmp_path, refusal):
    asked = [*command, "-o", tmp_path / "a.h5", "--dry-run"]
    assert "allowed: 4 to 100 cm" in refusal(*asked, "--width", "2")
    assert "unknown columns '3'; allowed: 1, 2" in refusal(*asked, "--columns", "3")


def test_plot_draws_or_lists_quantities(small, tmp_path, answer, refusal, ask):
    picture = tmp_path / "v.pdf"
    ask("plot", small, "--show", "v1", "-o", picture)
    first = picture.read_bytes()
    ask("plot", small, "--show", "v2", "-o", picture, "--overwrite")
    assert picture.read_bytes() != first
    listed = answer("plot", small, "--show", "?")
    assert "E1max" in listed
    assert "[m/s]" in listed
    assert "did you mean 'x" in refusal("plot", small, "--show", "x9", "-o", tmp_path / "a.png")
    # in Python: the same names, and the same bytes
    assert all(name in listed for name in nv.panels(small))
    figure = nv.plot(small, "v2", to=tmp_path / "python.pdf")
    assert (tmp_path / "python.pdf").read_bytes() == picture.read_bytes()
    with pytest.raises(nv.RequestError, match="must end in one of"):
        nv.plot(small, to=tmp_path / "a.txt")
    with pytest.raises(nv.RequestError, match="to = 3 must be a path"):
        nv.plot(small, to=3)
    with pytest.raises(nv.RequestError, match="file of a page, not of axes"):
        nv.plot(small, "v2", figure.axes[0], to=tmp_path / "b.png")
    # an archive in place of a TOML file: the message names `plot`
    err = refusal("bifurcation", small, "--show", "regimes")
    assert "is an archive (HDF5)" in err
    assert "nlds-vines plot" in err


def test_resuming_draws_its_own_picture_and_keeps_another(here, ask):
    picture = here / "a.png"
    picture.write_bytes(b"of something else")
    command = ["bifurcation", *SMALL, "-o", "a.h5", "--plot", "a.png"]
    ask(*command, "--overwrite")
    drawn = picture.read_bytes()
    ask(*command, "--resume")
    assert picture.read_bytes() == drawn
    picture.write_bytes(b"of something else")
    ask(*command, "--resume", status=2)


@pytest.mark.plain
@pytest.mark.kernels
def test_orbits_beyond_the_limit_are_reported_hatched_and_in_the_legend(tmp_path):
    scan = {"system": DEEP, "vary": {"omega": {"values": [6.0, 6.2, 6.4]}}}
    sampling = {"transient": 50, "periods": 10}
    passing = nv.scan(scan, sampling=sampling, record=["section", "regime"], to=tmp_path / "a.h5")
    report = Report()
    with nv.read(passing) as view:
        report.note(view)
        depth = view["violation_depth"]
        assert (view["violations"] > 0).all()
    (line,) = [text for text in report.remarks() if text.startswith("inadmissible")]
    assert f"3 of 3 orbits pass the limit, by {depth.min():.2g} to {depth.max():.2g} m" in line
    figure = passing.plot()
    words = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert any(word.endswith(", inadmissible") for word in words)
    spans = [p for axes in figure.axes[:2] for p in axes.patches if p.get_hatch()]
    assert len(spans) == 2
    (legend,) = [axes.get_legend() for axes in figure.axes if axes.get_legend()]
    assert "passes the limit" in [text.get_text() for text in legend.get_texts()]


@pytest.mark.kernels
def test_words_fit_the_kind_of_one_mass(tmp_path):
    scan = {
        "system": "bilinear-oscillator",
        "vary": {"omega": {"values": [0.8, 0.9]}},
        "sampling": {"transient": 20, "periods": 5},
    }
    path = nv.scan(scan, to=tmp_path / "one.h5")
    labels = [axes.get_ylabel() for axes in path.plot("x,E1max").axes]
    assert [label.split(" $")[0] for label in labels if "$" in label] == [
        *("oscillator", "energy of the oscillator"),
    ]  # fmt: skip
    with path.read() as view:
        assert "the oscillator's energy" in view.long_name("E1max")


# ---- the axis of the frequency: in Hz, or over that of the structure -----------------------------


SHORT = {"transient": 10, "periods": 8}
RECORD = {"want": ["section", "impacts", "energy", "regime"]}


def labeled(figure) -> Axes:
    (axis,) = (frame for frame in figure.axes if frame.get_xlabel())
    figure.canvas.draw()
    return axis


@pytest.mark.parametrize(
    ("unit", "factor", "words"),
    [
        ("Hz", 1 / (2 * pi), "frequency of the force $f$ [Hz]"),
        ("ratio", 1 / sqrt(39.5), r"frequency ratio $\omega/\omega_0$"),
    ],
)
def test_ticks_stand_at_round_numbers_of_the_unit(small, unit, factor, words):
    usual = labeled(nv.plot(small))
    frame = labeled(nv.plot(small, frequency=unit))
    assert frame.get_xlabel() == words
    assert frame.get_xlim() == usual.get_xlim()  # what is drawn stays
    low, high = frame.get_xlim()
    shown = [tick for tick in frame.get_xticks() if low <= tick <= high]
    assert len(shown) >= 3
    texts = [frame.xaxis.get_major_formatter()(tick) for tick in shown]
    assert np.array(texts, float) == pytest.approx(factor * np.array(shown), rel=1e-5)
    assert all(len(text) <= 5 for text in texts)
    written = [label.get_text() for label in frame.get_xticklabels() if label.get_text()]
    assert len({len(text.partition(".")[2]) for text in written}) == 1  # 0.90, 0.95, 1.00
    assert frame.get_xticklabels()[0].get_fontsize() == usual.get_xticklabels()[0].get_fontsize()


def test_what_has_no_axis_of_the_frequency_is_refused_and_panels_share_its_ticks(small, error_of):
    assert "frequency 'kHz'" in error_of(nv.plot, small, frequency="kHz")
    along = {"k1": {"values": [3.9e4, 4e4]}}
    path = nv.scan("ssul-set6", vary=along, sampling=SHORT, record=RECORD, quiet=True)
    assert "no axis of the frequency" in error_of(nv.plot, path, frequency="Hz")
    assert "needs one frequency" in error_of(nv.plot, path, frequency="ratio")
    # panels above have their ticks at the same places
    figure = nv.plot(small, frequency="Hz")
    figure.canvas.draw()
    places = [tuple(f.get_xticks()) for f in figure.axes if f.lines and len(f.get_xticks())]
    assert len(set(places)) == 1


def test_a_frequency_axis_has_round_numbers_also_where_it_is_logarithmic(tmp_path):
    """The request keeps f; omega follows from it bit for bit."""
    path, vary = tmp_path / "hertz.h5", {"f": {"start": 0.9, "stop": 1.1, "num": 4}}
    nv.scan("ssul-set6", vary=vary, sampling=SHORT, record=RECORD, to=path, quiet=True)
    archive = nv.open_archive(path)
    (axis,) = archive.request.axes
    np.testing.assert_array_equal(axis.values, 2 * pi * np.linspace(0.9, 1.1, 4))
    assert axis.heading().startswith("f = 0.9 to 1.1 Hz (5.655 to 6.912 rad/s)")
    assert archive.request.document()["vary"] == {"f": {"values": axis.stated.values.tolist()}}
    assert archive.request.title.endswith(": f")
    assert labeled(nv.plot(path)).get_xlabel() == "frequency of the force $f$ [Hz]"
    assert labeled(archive.plot()).get_xlabel() == "frequency of the force $f$ [Hz]"
    assert "rad/s" in labeled(nv.plot(path, frequency="rad/s")).get_xlabel()
    # a logarithmic axis has round numbers of Hz
    path = tmp_path / "log.h5"
    vary = {"f": {"start": 0.5, "stop": 5.0, "num": 4, "scale": "log"}}
    nv.scan("ssul-set6", vary=vary, sampling=SHORT, record=RECORD, to=path, quiet=True)
    frame = labeled(nv.plot(path))
    assert frame.get_xscale() == "log"
    places = np.array(frame.get_xticks()) / (2 * pi)
    assert {1.0, 2.0} <= {*np.round(places, 9)}


def test_every_drawing_command_has_a_unit_of_the_frequency(here, ask, refusal, monkeypatch):
    drawn = []
    monkeypatch.setattr(chosen_panels, "save_figure", lambda figure, *_: drawn.append(figure))
    words = ["--transient", "10", "--periods", "8", "--quiet", "--plot", "a.png"]
    ask("bifurcation", "--vary", "omega=5.5:7:4", *words, "--frequency", "Hz")
    assert labeled(drawn.pop()).get_xlabel() == "frequency of the force $f$ [Hz]"
    for name in ("bifurcation", "response-curves", "continuation", "tuning", "transients",
                 "response-history --impulse 1", "portrait"):  # fmt: skip
        assert "kHz" in refusal(*name.split(), "--frequency", "kHz")
    for name in ("explore", "report"):
        assert "kHz" in refusal(name, next(here.glob("*.h5")), "--frequency", "kHz")
