"""The command that makes the paper's figures, and its requests: pages, reuse, report, refusals."""

import sys
import tomllib
from pathlib import Path
from types import ModuleType

import numpy as np
import paper_results
import pytest
from commands import printed
from layout import collisions
from matplotlib.colors import to_hex

from nlds_vines.archives.archive import read
from nlds_vines.bifurcation import run as scan_run
from nlds_vines.bifurcation.picture import curves as drawing
from nlds_vines.bifurcation.request import load_scan
from nlds_vines.bifurcation.response_curves import curves_in
from nlds_vines.errors import RequestError
from nlds_vines.model import catalog as packaged_files
from nlds_vines.runs.interrupts import Interrupted
from paper import command, report
from paper.command import main, reproduce_paper
from paper.request import case_name, load_figure, packaged_figures, short_name
from scans import unfilled

PAGE = """
title = "a small page"
sampling = { transient = 40, periods = 5 }
record = { want = ["impacts", "energy"] }
set = { P = 700.0 }
[figure]
columns = 2
damper_energy = true
[vary]
omega = { start = 6.0, stop = 6.5, num = 6 }
[[panels]]
title = "one"
set = { c1 = 452.0 }
base = true
[[panels]]
set = { c1 = 552.0 }
[[curves]]
system = "none"
label = "alone"
[[curves]]
system = "none"
set = { k1 = 3.0e4 }
color = "blue"
line = "dashed"
base = true
shade = true
"""


@pytest.fixture
def here(here):
    (here / "page.toml").write_text(PAGE)
    return here


@pytest.fixture
def figure(here):
    def write(text=PAGE, name="page.toml"):
        (here / name).write_text(text)
        return load_figure(here / name)

    return write


@pytest.fixture
def make(monkeypatch):
    """Return the command with a request file of this folder in place of the paper's."""

    def run(name, *options):
        with monkeypatch.context() as patch:
            patch.setattr(command, "packaged_figures", lambda: {"own": load_figure(Path(name))})
            patch.setattr(report, "write", lambda *_: None)
            return main(["--only", "own", *options])

    return run


def never(*_, **__):
    raise AssertionError("nothing is to be computed")


def files(folder):
    return sorted(path.name for path in folder.rglob("*") if path.is_file())


# ---- from request to picture ---------------------------------------------------------------------


@pytest.mark.kernels
def test_what_is_computed_is_used_again_and_what_changes_computed(here, capsys, monkeypatch, make):
    assert make("page.toml", "-o", "out") == 0
    out = capsys.readouterr().out.splitlines()
    assert out[0].startswith("[1/1] page-")
    assert "24 orbits in" in out[0]
    assert out[-2] == "out/page.png"
    (archive,) = files(here / "out" / "archives")
    assert read(here / "out" / "archives" / archive).names
    before = (here / "out" / "page.png").read_bytes()

    with monkeypatch.context() as patch:
        patch.setattr(scan_run, "Computer", never)
        assert make("page.toml", "-o", "out") == 0
        assert capsys.readouterr().out.count("there already") == 1
        assert (here / "out" / "page.png").read_bytes() == before
        (here / "page.toml").write_text(PAGE.replace("552.0", "600.0"))
        with pytest.raises(AssertionError):
            make("page.toml", "-o", "out", "--quiet")

    assert make("page.toml", "-o", "out") == 0
    assert "there already" not in capsys.readouterr().out
    assert len(files(here / "out" / "archives")) == 2
    assert (here / "out" / "page.png").read_bytes() != before

    # a damaged archive is refused unless it is to be replaced
    path = here / "out" / "archives" / load_figure(here / "page.toml").archive
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert make("page.toml", "-o", "out", "--quiet") == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "cannot be opened" in err
    assert make("page.toml", "-o", "out", "--quiet", "--overwrite") == 0


@pytest.mark.kernels
def test_a_scan_file_is_drawn_as_well(here, make):
    (here / "scan.toml").write_text(
        'system = "none"\n[vary]\nomega = { values = [6.0, 6.1] }\n[record]\nwant = ["energy"]\n'
    )
    assert make("scan.toml", "--format", "svg", "-o", "out", "--quiet") == 0
    assert "scan.svg" in files(here / "out")
    assert "reproduction.md" not in files(here / "out")


@pytest.mark.kernels
def test_a_script_beside_a_request_does_the_same(here):
    script = Path(__file__).parents[2] / "scans" / "figure3.py"
    (here / "page.py").write_text(script.read_text())
    assert printed("page.py", cwd=here).endswith("page.h5\npage.png\n")
    assert (here / "page.png").stat().st_size > 0


# ---- the manners of a command --------------------------------------------------------------------


def test_a_dry_run_computes_and_writes_nothing(here, capsys, monkeypatch):
    monkeypatch.setattr(scan_run, "run", never)
    assert main(["--dry-run"]) == 0
    out = capsys.readouterr().out
    for name in ("figure2a.png", "figure8.png", "study-stiffness.png"):
        assert name in out
    assert "0 are there already" in out
    assert files(here) == ["page.toml"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--only", "13"], ["unknown figure '13'", "2a"]),
        (["--only", ""], ["unknown figure ''"]),
        (["--format", "gif"], ["'gif'", "png, pdf, svg"]),
        (["--threads", "0"], ["threads", "0"]),
        (["-o", "no/where"], ["there is no folder 'no'"]),
        (["-o", "page.toml"], ["page.toml", "name a folder"]),
        (["nothing.toml"], ["nothing.toml"]),
        (["page.toml"], ["nlds-vines response-curves page.toml", "--only 2a,3"]),
        (["--onyl", "3"], ["--only"]),
    ],
)
def test_a_wrong_request_is_one_line(here, capsys, arguments, words):
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("python -m paper: error: ")
    assert err.count("\n") == 1
    assert all(word in err for word in words)
    assert files(here) == ["page.toml"]


def test_failed_orbits_are_told_and_make_status_1(here, capsys, monkeypatch, make):
    def with_failures(scan):
        arrays = unfilled(scan)
        arrays["E1max"][:] = 1.0
        arrays["status"][:] = np.array([[1], [1], [0], [0], [0], [0]])
        return arrays

    monkeypatch.setattr(scan_run, "Computer", paper_results.Computed(with_failures))
    assert make("page.toml") == 1
    assert capsys.readouterr().err.count("8 of 24 orbits failed") == 1


def test_a_case_of_several_figures_is_computed_once(here, monkeypatch):
    (here / "other.toml").write_text(PAGE.replace("552.0", "600.0"))
    figures = {name: load_figure(Path(f"{name}.toml")) for name in ("page", "other")}
    computed = []

    def compute(scan):
        computed.append(scan.system.parameters["c1"])
        arrays = unfilled(scan)
        arrays["E1max"][:], arrays["status"][:] = scan.system.parameters["c1"], 0
        return arrays

    monkeypatch.setattr(command, "packaged_figures", lambda: figures)
    monkeypatch.setattr(report, "write", lambda *_: None)
    monkeypatch.setattr(scan_run, "Computer", paper_results.Computed(compute))
    assert main(["-o", "out", "--quiet"]) == 0
    assert computed == [452.0, 452.0, 552.0, 552.0, 600.0, 600.0]
    for name, changed in (("page", 552.0), ("other", 600.0)):
        curves = curves_in(here / "out" / "archives" / figures[name].archive)
        assert [curve.peak for curve in curves.curves] == [452.0, 452.0, changed, changed]


def test_an_interruption_is_status_130(here, capsys, monkeypatch, make):
    def stop(*_, **__):
        raise Interrupted("stopped")

    monkeypatch.setattr(scan_run, "run", stop)
    assert make("page.toml") == 130
    assert "goes on" in capsys.readouterr().err


def test_a_portrait_is_handed_to_its_command(here, monkeypatch, capsys, make):
    (here / "orbit.toml").write_text('title = "an orbit"\n[portrait]\n')
    asked = []
    fake = ModuleType("nlds_vines.portrait.command")
    fake.main = lambda arguments: asked.append(arguments) or 0
    monkeypatch.setitem(sys.modules, fake.__name__, fake)
    assert make("orbit.toml", "-o", "out") == 0
    (arguments,) = asked
    assert arguments == ["orbit.toml", "--plot", "out/orbit.png", "--quiet", "--overwrite"]
    for status in (1, 2, 130):  # an orbit lost, a wrong request, Ctrl-C
        fake.main = lambda arguments, status=status: status
        assert make("orbit.toml", "-o", "out") == status


# ---- the report ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def archives(tmp_path_factory):
    """Made-up archives of all packaged requests but the largest: results as published."""
    folder = tmp_path_factory.mktemp("archives")
    for short, request in paper_results.requests().items():
        if request.computed and not any("section" in s.want for s in request.scans.values()):
            paper_results.write_figure(folder, short, paper_results.MadeUp())
    return folder


@pytest.mark.slow("figures of a made-up archive of each kind")
def test_the_report_holds_claims_retention_stiffness_and_what_is_missing(tmp_path, archives):
    """Of portraits, it asks for the orbits of those that were drawn."""
    for name in ("figure3.png", "figure9.png"):
        (tmp_path / name).write_bytes(b"")
    asked, path = [], tmp_path / "reproduction.md"

    def follow(request):
        asked.append(request.name)
        return paper_results.as_published("9")

    report.write(path, archives, "png", follow)
    text = path.read_text()
    assert asked == ["figure9"]
    assert "largest forces of a cycle 1400, 5100, 10200 N | **agree**" in text
    assert "figure10 has not been computed" in text
    for claim in report.CLAIMS:
        assert f"| {claim.statement}" in text
    for verdict in ("agree", "agree in part", "differ", "cannot be decided", "not computed"):
        assert f"**{verdict}**" in text
    assert "| Tuned mass damper | **39500** | 660.4 | 6.210 | 1.00 | 635.1 | 1.00 | 0.42 |" in text
    assert "| 2.5e+07 | 3T,3 | chaos | transient chaos to T,0 |" in text
    assert "Figures 4 and 5: the values of k1" in text
    assert "(figure3.png)" in text
    assert text.count("![") == 2  # only the pictures that are there
    columns = [line.count("|") for line in text.splitlines() if line.startswith("|")]
    assert set(columns) <= {5, 6, 7, 9}
    assert files(tmp_path) == ["figure3.png", "figure9.png", "reproduction.md"]


def test_the_report_of_nothing_says_so(tmp_path):
    (tmp_path / "archives").mkdir()
    report.write(tmp_path / "r.md", tmp_path / "archives", "png")
    text = (tmp_path / "r.md").read_text()
    assert "not computed" in text
    assert "**agree**" not in text
    with pytest.raises(RequestError, match="cannot write"):
        report.write(tmp_path / "no" / "r.md", tmp_path / "archives", "png")


# ---- pages of curves -----------------------------------------------------------------------------


def page_of(short, archives):
    """Return a request, its picture and the panels of that."""
    curves = curves_in(archives / paper_results.requests()[short].archive)
    figure = drawing.draw_curves(curves)
    return curves.request, figure, [axes for axes in figure.axes if axes.axison]


def known(line):
    values = np.asarray(line.get_ydata())
    return values[np.isfinite(values)].tolist()


def test_curves_are_the_archives_energies_solid_and_dotted(archives):
    request, figure, (frame,) = page_of("3", archives)
    lines = {(line.get_color(), line.get_linestyle()): line for line in frame.get_lines()}
    damped = request.cases[3]
    evidence = paper_results.MadeUp()("3", "ssul-set6")
    assert known(lines[damped.color, "-"]) == evidence["E1max"].tolist()
    of_damper = [line for line in frame.get_lines() if line._unscaled_dash_pattern[1] == (1, 1.6)]
    assert [line.get_color() for line in of_damper] == [c.color for c in request.cases[1:]]
    assert known(of_damper[-1]) == evidence["E2max"].tolist()
    assert frame.get_xlabel() == r"angular frequency of the force $\omega$ [rad/s]"
    assert "E_1" in frame.get_ylabel()
    assert "E_2" in frame.get_ylabel()
    assert frame.get_ylabel().endswith("[J]")
    assert frame.get_ylim()[0] == 0
    assert figure.get_figwidth() == pytest.approx(16 / 2.54)


def test_impacts_are_yellow_and_every_window_without_them_is_marked(tmp_path):
    request = paper_results.requests()["2b"].computed
    omega = request.values
    free = ((omega > 7.5) & (omega < 7.7)) | ((omega > 7.899) & (omega < 7.901))
    # by turns periodic and chaotic, which has a rate in place of a count
    n = np.arange(omega.size) % 2
    numbers = {"E1max": omega, "E2max": omega, "periodicity": n, "impact_rate": 1.0 * ~free}
    numbers["impact_count"] = np.where(n == 0, -1, np.where(free, 0, 1))
    curves = curves_in(paper_results.write_curves(tmp_path / "a.h5", request, [numbers]))
    (frame,) = drawing.draw_curves(curves).axes
    yellow = [patch for patch in frame.patches if to_hex(patch.get_facecolor()) == drawing.IMPACTS]
    spans = [(p.get_x(), p.get_x() + p.get_width()) for p in yellow]
    assert [tuple(np.round(span, 2)) for span in spans] == [(5.0, 7.5), (7.7, 7.9), (7.9, 8.0)]
    uprights = [line for line in frame.get_lines() if len(set(line.get_xdata())) == 1]
    marks = [line for line in uprights if line.get_color() == "#666666"]
    dashed = [line.get_xdata()[0] for line in marks if line.get_linestyle() == "--"]
    assert np.round(dashed, 2).tolist() == [7.5, 7.7]
    (narrow,) = [line.get_xdata()[0] for line in marks if line.get_linestyle() == "-"]
    assert narrow == pytest.approx(7.9)  # the window of one cell
    (resonance,) = (line for line in uprights if line.get_color() == drawing.RESONANCE)
    assert resonance.get_xdata()[0] == pytest.approx(np.sqrt(39.5))


@pytest.mark.parametrize("short", ["2a", "3", "4", "6", "free-tmd"])
def test_panels_share_their_axes_and_no_text_overlaps(archives, short):
    request, figure, frames = page_of(short, archives)
    assert len(frames) == len(request.panels)
    assert len({frame.get_xlim() for frame in frames}) == 1
    assert len({frame.get_ylim() for frame in frames}) == 1
    assert collisions(figure) == []


def test_the_tuning_is_marked_and_settings_name_panels_and_curves(archives):
    _, figure, frames = page_of("6", archives)
    titles = [frame.get_title(loc="left") for frame in frames]
    assert titles[0] == "(a)  $c_1=352$ N s/m"
    assert titles[1] == "(b)  $c_1=452$ N s/m (tuning)"
    assert figure.axes[1]._left_title.get_color() == drawing.BASE
    _, figure, _ = page_of("4", archives)
    labels = [text.get_text() for text in figure.axes[-1].get_legend().get_texts()]
    assert labels[3] == r"$k_1=3.95\times10^{4}$ N/m"
    lines = [line for line in figure.axes[0].get_lines() if line.get_marker() != "o"]
    widths = [line.get_linewidth() for line in lines][-7:]
    assert widths.index(max(widths)) == 3


def test_an_unknown_figure_is_refused_in_python_too(tmp_path):
    with pytest.raises(RequestError, match="unknown figure"):
        reproduce_paper(tmp_path / "out", only=["x"])


@pytest.mark.long
def test_the_whole_paper_is_reproduced(tmp_path):
    text = reproduce_paper(tmp_path / "out").read_text()
    for request in paper_results.requests().values():
        assert (tmp_path / "out" / f"{request.name}.png").stat().st_size > 0
    assert "not computed" not in text
    assert text.count("**agree**") >= 25


# ---- requests: what they mean, and one line for each way in which they can be wrong --------------


ROOT = Path(__file__).resolve().parents[2]


def test_every_curve_stands_in_every_panel_under_a_name_of_its_own(figure):
    page = figure()
    request = page.computed
    assert (page.name, page.title) == ("page", "a small page")
    assert (request.columns, request.damper_energy) == (2, True)
    assert [(panel.title, panel.base) for panel in request.panels] == [("one", True), ("", False)]
    assert [case.panel for case in request.cases] == [1, 1, 2, 2]
    first, second = request.cases[2:]
    assert first.scan.system.parameters["c1"] == second.scan.system.parameters["c1"] == 552
    assert second.scan.system.parameters["k1"] == 3.0e4
    assert first.scan.system.parameters["P"] == second.scan.system.parameters["P"] == 700
    assert first.scan.want == ("energy",)  # no walls
    assert second.settings == {"k1": 3.0e4}
    looks = (second.color, second.line, second.base, second.shade)
    assert looks == ("#0072b2", "dashed", True, True)
    # In the archive by label and panel; in the paper by what is not as in the catalog.
    assert request.names == (
        "alone, one", "k₁ = 30000 N/m, one",
        "alone, c₁ = 552 N s/m", "k₁ = 30000 N/m, c₁ = 552 N s/m",
    )  # fmt: skip
    assert list(page.scans) == [
        "none_P=700", "none_k1=30000_P=700",
        "none_c1=552_P=700", "none_k1=30000_c1=552_P=700",
    ]  # fmt: skip
    assert [case_name(case.scan) for case in request.cases] == list(page.scans)


def test_another_request_has_another_archive(figure):
    page, again = figure(), figure(PAGE.replace("a small page", "b"))
    longer = figure(PAGE.replace("num = 6", "num = 7"))
    other = figure(PAGE.replace('"alone"', '"bare"'))
    recolored = figure(PAGE.replace('"blue"', '"green"'))
    assert page.archive == again.archive == recolored.archive
    assert len({page.archive, longer.archive, other.archive}) == 3
    # without panels there is one
    head, _, rest = PAGE.partition("[[panels]]")
    page = figure(head + "[[curves]]" + rest.partition("[[curves]]")[2])
    assert len(page.computed.panels) == 1
    assert [case.panel for case in page.computed.cases] == [1, 1]


def test_a_scan_file_and_a_portrait_are_requests(figure):
    text = (ROOT / "scans" / "figure8.toml").read_text()
    request = figure(text, "figure8.toml")
    assert request.computed == load_scan()
    assert request.archive.startswith("figure8-")
    # a portrait is left to its own command
    request = figure('title = "an orbit"\n[portrait]\nomega = 7.4\n')
    assert (request.title, request.archive) == ("an orbit", "")
    assert (request.computed, request.scans) == (None, {})


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("columns = 2", "columns = 9", ["[figure]", "columns", "from 1 to 4"]),
        ("columns = 2", "rows = 2", ["[figure]", "'rows'", "columns"]),
        ("damper_energy = true", "damper_energy = 1", ["damper_energy", "true or false"]),
        ('"blue"', '"bleu"', ["[[curves]] 2", "'bleu'", "'blue'", "#rrggbb"]),
        ('"blue"', '"#0000GG"', ["[[curves]] 2", "color", "#rrggbb"]),
        ('"dashed"', '"dotted"', ["line", "solid, dashed, dashdot"]),
        ("k1 = 3.0e4", "c1 = 3.0e4", ["c1", "[[panels]]", "one of the two"]),
        ("k1 = 3.0e4", "k9 = 3.0e4", ["'k9'", "k1"]),
        ("k1 = 3.0e4", "k1 = -1.0", ["k1", "-1.0"]),
        ("k1 = 3.0e4", "omega = 6.0", ["omega", "not both"]),
        ('"none"', '"nothing"', ["[[curves]] 1", "'nothing'"]),
        ('title = "one"', 'system = "tmd"', ["system", "[[panels]]", "one of the two"]),
        ('title = "one"', "title = 1", ["[[panels]]", "title", "string"]),
        ('label = "alone"', "label = 1", ["[[curves]] 1", "label", "string"]),
        ('label = "alone"', "etikett = 1", ["[[curves]]", "'etikett'", "label"]),
        ("[vary]", "[vary]\nK = { values = [1e7] }\n[extra]", ["extra", "figure"]),
        ("[figure]", "[figures]", ["'figures'", "figure"]),
        ("num = 6 }", "num = 6 }\nP = { values = [1.0] }", ["P", "not both"]),
        ("num = 6 }", "num = 6 }\nm1 = { values = [1.0, 2.0] }", ["[[curves]] 1", "2 parameters"]),
        (PAGE, "curves = 1", ["must be one or more tables [[curves]]"]),
        (PAGE, "curves = []", ["must be one or more tables [[curves]]"]),
        (PAGE, "[curves]\nsystem = 'tmd'", ["must be one or more tables [[curves]]"]),
        (PAGE, PAGE + '[[curves]]\nsystem = "none"\n', ["stands twice"]),
    ],
)
def test_a_faulty_request_is_one_line_with_file_and_key(figure, old, new, words, error_of):
    assert old in PAGE
    message = error_of(figure, PAGE.replace(old, new, 1))
    assert all(word in message for word in ("page.toml", *words)), message


# ---- what travels with the package ---------------------------------------------------------------


def test_the_papers_figures_come_first_in_their_order_each_with_a_script():
    names = list(packaged_figures())
    figures = [name for name in names if name[0].isdigit()]
    assert names[: len(figures)] == figures
    assert figures[:8] == ["2a", "2b", "3", "4", "5", "6", "7", "8"]
    assert short_name("study-free-tmd") == "free-tmd"
    for path in (ROOT / "scans").glob("figure*.toml"):
        assert path.with_suffix(".py").is_file(), path


def test_the_wheel_carries_every_request_file():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    carried = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert carried["scans"] == "nlds_vines/_data"  # whatever is put there travels
    assert {path.parent for path in packaged_files.figure_files()} == {ROOT / "scans"}
