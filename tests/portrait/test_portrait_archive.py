"""A portrait in an archive: what it holds, the picture drawn from it, and what repeats it."""

import csv
import itertools
import os
import shutil
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from commands import printed
from layout import collisions
from matplotlib.figure import Figure
from matplotlib.image import imread
from test_portrait import OF_KIND, ROOT, figure11, place_of, request_of

import nlds_vines as nv
from nlds_vines.__main__ import main
from nlds_vines.errors import RequestError
from nlds_vines.portrait.picture import fit_forces
from nlds_vines.portrait.request import (
    PANELS,
    USUAL,
    Column,
    PortraitRequest,
    Window,
    load_portrait,
)
from nlds_vines.portrait.result import Portrait, portrait_in
from nlds_vines.portrait.run import run, views_of

DOCUMENT = {
    "title": "Two windows",
    "system": "ssul-set6",
    "sampling": {"windows": [[20, 26], [30, 42]], "samples": 32},
    "portrait": {"panels": ["relative", "phase2", "spectrum"], "taper": "hann"},
}


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    path = tmp_path_factory.mktemp("portrait") / "orbit.h5"
    run(load_portrait(DOCUMENT), path)
    return path


def same(one, other):
    def arrays(view):
        yield from (view.time, view.states, view.section)
        yield from (view.spectrum.order, view.spectrum.amplitude, view.spectrum.power)
        yield from (view.contacts[name] for name in view.contacts.dtype.names)

    pairs = zip(arrays(one), arrays(other), strict=True)
    return (
        all(np.array_equal(a, b, a.dtype.kind == "f") for a, b in pairs)
        and list(one.lines()) == list(other.lines())
        and replace(one.column, system=other.column.system) == other.column
        and one.column.system.parameters == other.column.system.parameters
    )


def test_windows_and_columns_with_parameters_of_their_own_come_back_to_the_last_bit(tmp_path):
    columns = [
        {"name": "soft", "set": {"K": 1e7}, "window": [4, 8]},
        {"name": "hard", "panels": ["relative"]},
    ]
    request = load_portrait({**DOCUMENT, "column": columns})
    run(request, tmp_path / "both.h5")
    stored, computed = portrait_in(tmp_path / "both.h5"), views_of(request, quiet=True)
    assert isinstance(nv.open_archive(tmp_path / "both.h5"), Portrait)
    assert [len(view.section) for view in stored.views] == [4, 6, 12]
    assert all(same(one, other) for one, other in zip(stored.views, computed, strict=True))
    assert stored.request.hash == request.hash
    with nv.read(tmp_path / "both.h5") as view:
        assert view["name"].tolist() == ["soft", "hard", "hard"]


def test_columns_of_several_kinds_are_refused(tmp_path):
    """No request file says them, so no archive could repeat them."""
    both = load_portrait(DOCUMENT)
    other = load_portrait({"system": "tmd", "sampling": DOCUMENT["sampling"]})
    request = replace(both, columns=(both.columns[0], other.columns[1]), signal=("x1",))
    with pytest.raises(nv.RequestError, match="several kinds, laws or hosts"):
        run(request, tmp_path / "both.h5")
    assert list(tmp_path.iterdir()) == []


def test_parseval_holds_in_the_archive(archive):
    """Of the untapered window the sum of the power is the variance of the samples."""
    path = archive.with_name("plain.h5")
    run(load_portrait(DOCUMENT, {"portrait": {"taper": "rectangular"}}), path)
    with nv.read(path) as view:
        first = slice(int(view["states"][0]))
        power = view["power"][: int(view["spectrum_bins"][0])].sum()
        assert power == pytest.approx(view["x2"][first].var(), rel=1e-12)


@pytest.mark.slow("two pages are drawn")
def test_the_picture_is_that_of_the_orbit_itself(archive, here):
    nv.orbit_portrait(DOCUMENT, to="direct.png", quiet=True)
    figure = nv.orbit_portrait(DOCUMENT, to="orbit.h5", quiet=True)
    figure.savefig("archived.png")
    nv.open_archive(archive).plot().savefig("opened.png")
    assert Path("archived.png").read_bytes() == Path("opened.png").read_bytes()
    shutil.copy(archive, "copy.h5")
    assert main(["plot", "copy.h5"]) == 0
    assert main(["plot", "copy.h5", "--show", "spectrum", "-o", "one.png"]) == 0
    direct, copy = (imread(name) for name in ("direct.png", "copy.png"))
    assert np.array_equal(direct, copy)
    axes = Figure().subplots()
    assert nv.plot("copy.h5", show="relative", ax=axes) is axes.figure
    assert axes.get_ylabel() == "$x_2-x_1$ [m]"
    assert nv.plot("copy.h5", show="energy", ax=Figure().subplots())  # which the page does not show
    with pytest.raises(nv.RequestError, match="unknown show 'energie'"):
        nv.plot("copy.h5", show="energie")


def test_in_one_column_all_stands_below_one_another(archive):
    wide, narrow = nv.plot(archive), nv.plot(archive, columns=1)
    assert collisions(wide) == collisions(narrow) == []
    assert narrow.get_figwidth() == pytest.approx(8.4 / 2.54)
    assert len(narrow.axes) == len(wide.axes)
    boxes = [axes.get_position() for axes in narrow.axes]
    assert len({(box.x0, box.x1) for box in boxes}) == 1
    assert all(above.y0 > below.y1 for above, below in itertools.pairwise(boxes))
    named = [axes for axes in narrow.axes if "periods" in axes.get_title(loc="left")]
    assert named == narrow.axes[:: len(boxes) // 2]
    first, second = named
    assert first.get_ylabel() == second.get_ylabel()
    assert first.get_ylim() == second.get_ylim()  # windows can be compared


def test_histories_as_rows(archive, tmp_path, refusal):
    frame = nv.open_archive(archive).to_dataframe()
    assert {"time", "x1", "v1", "x2", "v2", "E1", "E2", "force"} <= {*frame.columns}
    assert len(frame) == (6 + 12) * 32
    request = tmp_path / "two.toml"
    request.write_text(load_portrait(DOCUMENT).to_toml())
    words = ["portrait", str(request), "--csv", str(tmp_path / "two.csv")]
    words += ["--plot", str(tmp_path / "two.png")]
    assert main([*words, "--quiet"]) == 0
    with open(tmp_path / "two.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [*rows[0]][:6] == ["state", "time", "x1", "v1", "x2", "v2"]
    assert [float(row["x2"]) for row in rows] == frame["x2"].tolist()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["two.csv", "two.png", "two.toml"]
    assert "--overwrite replaces it" in refusal(*words, "--quiet")


def test_a_second_run_resumes_and_repeats(archive, here, answer, refusal):
    shutil.copy(archive, "orbit.h5")
    before = Path("orbit.h5").read_bytes()
    Path("two.toml").write_text(load_portrait(DOCUMENT).to_toml())
    words = ["portrait", "two.toml", "-o", "orbit.h5"]
    assert main([*words, "--dry-run"]) == 2
    assert main([*words, "--resume"]) == 0
    assert Path("orbit.h5").read_bytes() == before
    assert "results are the same" in answer("rerun", "orbit.h5")
    assert "are for scans: this is a portrait" in refusal("rerun", "orbit.h5", "--shard", "1/2")
    options = ["--samples", "64", "--plot", "more.png", "--resume"]
    assert "holds another portrait" in refusal("portrait", "two.toml", "-o", "orbit.h5", *options)


@pytest.mark.kernels
def test_the_orbit_of_a_cell_names_its_scan(here, refusal, ask):
    scan = ["--vary", "omega=7:7.4:3", "--transient", "30", "--periods", "8", "--quiet"]
    ask("bifurcation", *scan, "-o", "scan.h5")
    words = ["portrait", "scan.h5", "--at", "omega=7.2", "--samples", "16", "-o", "cell.h5"]
    ask(*words, "--quiet")
    archive = nv.open_archive("cell.h5")
    with nv.read("scan.h5") as view:
        assert np.array_equal(archive.views[0].section, view["section"][1, 0])
    assert "portrait SCAN.h5 --at omega=7.2 --start rest" in refusal("rerun", "cell.h5")
    ask("plot", "cell.h5")
    ask("portrait", "scan.h5", "--at", f"f={7.2 / 2 / np.pi}", "-o", "hertz.h5", "--quiet")
    assert nv.open_archive("hertz.h5").views[0].column.system.parameters["omega"] == 7.2
    assert nv.orbit_of("scan.h5", f=7.2 / 2 / np.pi).system.parameters["omega"] == 7.2
    assert "f = 2.0 lies outside" in refusal("portrait", "scan.h5", "--at", "f=2")


def test_a_full_disk_is_one_line_that_claims_no_parts(here, monkeypatch, refusal):
    """A portrait has no parts: to run it again is all that helps."""
    full = Mock(side_effect=OSError(28, "No space left on device"))
    monkeypatch.setattr(os, "posix_fallocate", full)
    line = refusal("portrait", "--set", "omega=7.45", "--transient", "20", "-o", "p.h5", "--quiet")
    assert line.endswith("error: cannot write p.h5: No space left on device\n")


def test_an_orbit_draws_what_it_records(error_of):
    """Without a trajectory, the states at t = nT are dots."""
    orbit = nv.simulate("ssul-set6", 9, transient=30, omega=7.45, quiet=True)
    figure = orbit.plot()
    panels = [axes.get_label() for axes in figure.axes]
    assert panels == ["displacement", "relative", "section", "impact-section"]
    (_, damper), *_ = (axes.lines for axes in figure.axes)
    np.testing.assert_array_equal(damper.get_ydata(), orbit.section[:, 2])
    np.testing.assert_allclose(damper.get_xdata(), np.arange(31, 40))
    assert damper.get_linestyle() == "None"
    assert [axes.get_label() for axes in orbit.plot("section").axes] == ["section"]
    axes = Figure().add_subplot()
    assert orbit.plot("relative", ax=axes) is axes.figure
    assert "phase2" in error_of(orbit.plot, "phase2")
    assert "several panels" in error_of(orbit.plot, "section,relative", axes)


@pytest.mark.kernels
def test_an_orbit_with_a_trajectory_draws_curves(error_of):
    record = ["trajectory", "impacts"]
    orbit = nv.simulate("ssul-set6", 20, transient=30, omega=7.45, record=record, samples=64)
    figure = orbit.plot("displacement,phase2,spectrum")
    (body, damper, _), plane, spectrum = (axes.lines for axes in figure.axes)
    np.testing.assert_array_equal(damper.get_ydata(), orbit.trajectory[: 12 * 64, 2])
    assert figure.axes[0].get_xlim() == (30, 42)
    assert body.get_linestyle() == "-"
    assert len(plane[0].get_xdata()) > 64
    assert spectrum
    nothing = nv.simulate("ssul-set6", 2, transient=0, record=["energy"], quiet=True)
    assert "nothing to draw" in error_of(nothing.plot)


@pytest.mark.kernels
def test_the_exponents_are_those_of_the_orbit_after_the_window(here):
    document = {**DOCUMENT, "portrait": {"panels": ["section", "exponents"]}}
    document["column"] = [{"window": [30, 42]}, {"window": [30, 42], "panels": ["section"]}]
    run(load_portrait(document), Path("orbit.h5"))
    result = portrait_in("orbit.h5")
    view, other = result.views
    assert other.exponents is None
    expected = nv.classify("ssul-set6", start=view.section[-1], transient=0, periods=1, quiet=True)
    spectrum = view.exponents
    np.testing.assert_allclose(spectrum.exponents, spectrum.running[-1])
    np.testing.assert_allclose(spectrum.exponents.sum(), spectrum.divergence, rtol=1e-9)
    assert np.isclose(spectrum.exponents.sum(), expected.exponents.sum(), rtol=1e-6)
    line = next(line for line in result.lines() if "Lyapunov" in line)
    assert f"{spectrum.exponents[0]:.4g} +- " in line
    panel = next(axes for axes in result.page.axes if axes.get_label() == "exponents")
    curves = [line.get_ydata() for line in panel.lines if line.get_label().startswith("$")]
    np.testing.assert_array_equal(curves, spectrum.running.T)


@pytest.mark.parametrize(("other", "separate"), [(4.0, False), (6.0, True)])
def test_forces_of_very_different_sizes_have_scales_of_their_own(other, separate):
    figure = Figure()
    row = [place_of("force", axes) for axes in figure.subplots(1, 2)]
    for place, height in zip(row, (1.0, other), strict=True):
        place.axes.set_ylim(0.0, height)
    fit_forces(row)
    assert [place.axes.get_ylim()[1] for place in row] == [1.0 if separate else other, other]


@pytest.mark.parametrize("number", [9, 10, 11, 12])
def test_the_requests_of_the_papers_figures_state_their_assumption(number):
    path = ROOT / "scans" / f"figure{number}.toml"
    request = load_portrait(path)
    assert "K = 2.5e7 N/m^1.5 assumed" in request.title
    assert f"(Figure {number})" in request.title
    assert all(column.system.K == 2.5e7 for column in request.columns)
    script = path.with_suffix(".py")
    text = printed(script, "--dry-run")
    assert request.title in text
    assert f"picture: figure{number}.png" in text  # to come: a dry run makes none


def test_options_override_a_request():
    request = figure11(sampling={"windows": ["5:7", (8, 9)]}, set={"P": 700.0})
    windows = [column.window for column in request.columns]
    assert windows == [Window(5, 7), Window(8, 9)] * 2
    assert {column.system.parameters["P"] for column in request.columns} == {700.0}
    assert request.title == figure11().title  # that of a file stays
    single = figure11(sampling={"transient": 4, "periods": 2})
    assert [column.window for column in single.columns] == [Window(4, 6)] * 2


def test_panels_stand_in_the_order_asked_for_and_need_something_to_show():
    request = request_of("tmd", panels=["spectrum", "force", "energy"])
    assert request.panels == ("spectrum", "energy")
    usual = tuple(name for name in PANELS if name in USUAL and name != "shape")
    assert request_of("ssul-set6").panels == usual
    for panel in ("force", "impact-section"):
        with pytest.raises(RequestError, match=f"{panel} cannot be filled for kind 'tmd'"):
            request_of("tmd", panels=[panel])


def test_a_column_fills_panels_of_its_page(error_of):
    document = {"system": "ssul-set6", "portrait": {"panels": ["phase1"]}}
    for panels, words in (
        (["force"], "unknown panel of a column 'force'"),
        (["forces"], "unknown panels 'forces'"),
        ([], "empty"),
    ):
        column = {"window": [0, 3], "panels": panels}
        assert words in error_of(load_portrait, {**document, "column": [column]})
    # columns and requests are checked in Python, too
    column = Column(OF_KIND["tmd"], Window(0, 3), panels=("phase1",))
    line = error_of(PortraitRequest, "a title", (column,), ("phase1", "phase2"))
    assert "'phase2' is filled by no column" in line
    column = Column(OF_KIND["tmd"], Window(0, 3))
    assert PortraitRequest("a title", (column,)).signal == ("x2",)
    assert "number of columns = 5" in error_of(PortraitRequest, "a title", (column,) * 5)


def test_frequencies_and_phases_of_a_request():
    # a frequency that is set in Hz is told in Hz
    request = load_portrait(None, {"set": {"f": 1.0}, "portrait": {"panels": ["spectrum"]}})
    assert request.title.endswith("f = 1 Hz")
    assert request.frequency == "Hz"
    assert load_portrait(request.document()).hash == request.hash
    other = load_portrait(None, {"set": {"f": 1.0}, "portrait": {"frequency": "rad/s"}})
    assert other.title.endswith("ω = 6.28319 rad/s")
    # the phase of a section is of the hash where it is not zero
    plain = load_portrait("ssul-set6")
    assert load_portrait("ssul-set6", {"portrait": {"section_phase": 0.0}}).hash == plain.hash
    turned = load_portrait("ssul-set6", {"portrait": {"section_phase": 0.25}})
    assert turned.hash != plain.hash
    assert load_portrait(turned.document()).section_phase == 0.25


def test_exponents_are_printed_when_they_are_asked_for(answer, refusal, here):
    words = ("portrait", "--set", "omega=7.38", "--transient", "200", "--periods", "4")
    lines = answer(*words, "--panels", "relative", "--exponents", "64").splitlines()
    (line,) = (line for line in lines if "Lyapunov exponents [1/s] " in line)
    values = [float(part.split()[-3]) for part in line.split("; ") if " +- " in part]
    assert len(values) == 4
    assert sum(values) == pytest.approx(-1.35, abs=0.01)
    assert "; mean divergence -1.34999" in line
    assert line.endswith("; averages over 64 forcing periods, 54.4883 s")
    line = refusal(*words, "--exponents", "15")
    assert "--exponents = 15 must be a whole number from 16 to 10000000" in line


def test_exponents_are_computed_and_told_once(refusal):
    """Their panel and the option gave two lines, of 3200 periods and of others."""
    asked = ["--panels", "section,exponents", "--exponents", "200"]
    assert "beside the panel exponents" in refusal("portrait", *asked)
