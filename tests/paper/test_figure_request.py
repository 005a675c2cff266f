"""Requests: what they mean, and one line for each way in which they can be wrong."""

import tomllib
from pathlib import Path

import pytest

from nlds_vines.bifurcation.request import load_scan
from nlds_vines.errors import RequestError
from nlds_vines.model import catalog as packaged_files
from paper.request import case_name, load_figure, packaged_figures, short_name

ROOT = Path(__file__).resolve().parents[2]
PAGE = """
title = "a page"
[figure]
columns = 2
damper_energy = true
[vary]
omega = { start = 6.0, stop = 6.5, num = 6 }
[record]
want = ["impacts", "energy"]
[set]
P = 700.0
[[panels]]
title = "one"
set = { c1 = 452.0 }
base = true
[[panels]]
set = { c1 = 300.0 }
[[curves]]
system = "none"
label = "alone"
[[curves]]
system = "ssul-set6"
set = { k1 = 3.0e4 }
color = "blue"
line = "dashed"
base = true
shade = true
"""


@pytest.fixture
def figure(tmp_path):
    def write(text=PAGE, name="page.toml"):
        path = tmp_path / name
        path.write_text(text)
        return load_figure(path)

    return write


def test_every_curve_stands_in_every_panel(figure):
    page = figure()
    request = page.computed
    assert (page.name, page.title) == ("page", "a page")
    assert (request.columns, request.damper_energy) == (2, True)
    assert [(panel.title, panel.base) for panel in request.panels] == [("one", True), ("", False)]
    assert [case.panel for case in request.cases] == [1, 1, 2, 2]
    first, second = request.cases[2:]
    assert first.scan.system.parameters["c1"] == second.scan.system.parameters["c1"] == 300
    assert second.scan.system.parameters["k1"] == 3.0e4
    assert first.scan.system.parameters["P"] == second.scan.system.parameters["P"] == 700
    assert first.scan.want == ("energy",)  # no walls
    assert second.settings == {"k1": 3.0e4}
    assert (second.color, second.line, second.base, second.shade) == (
        *("#0072b2", "dashed", True, True),
    )


def test_cases_have_different_names(figure):
    """In the archive by label and panel; in the paper by what is not as in the catalog."""
    page = figure()
    assert page.computed.names == (
        *("alone, one", "k₁ = 30000 N/m, one"),
        *("alone, c₁ = 300 N s/m", "k₁ = 30000 N/m, c₁ = 300 N s/m"),
    )
    assert list(page.scans) == [
        *("none_P=700", "ssul-set6_k1=30000_P=700"),
        *("none_c1=300_P=700", "ssul-set6_k1=30000_c1=300_P=700"),
    ]
    assert [case_name(case.scan) for case in page.computed.cases] == list(page.scans)


def test_another_request_has_another_archive(figure):
    page, again = figure(), figure(PAGE.replace("a page", "b"))
    longer = figure(PAGE.replace("num = 6", "num = 7"))
    other = figure(PAGE.replace('"alone"', '"bare"'))
    recolored = figure(PAGE.replace('"blue"', '"green"'))
    assert page.archive == again.archive == recolored.archive
    assert len({page.archive, longer.archive, other.archive}) == 3


def test_without_panels_there_is_one(figure):
    head, _, rest = PAGE.partition("[[panels]]")
    page = figure(head + "[[curves]]" + rest.partition("[[curves]]")[2])
    assert len(page.computed.panels) == 1
    assert [case.panel for case in page.computed.cases] == [1, 1]


def test_a_scan_file_is_a_request(figure):
    text = (ROOT / "scans" / "figure8.toml").read_text()
    request = figure(text, "figure8.toml")
    assert request.computed == load_scan()
    assert request.archive.startswith("figure8-")


def test_a_portrait_is_left_to_its_own_command(figure):
    request = figure('title = "an orbit"\n[portrait]\nomega = 7.4\n')
    assert (request.title, request.computed, request.scans, request.archive) == (
        "an orbit",
        None,
        {},
        "",
    )


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
        (
            "num = 6 }",
            "num = 6 }\nm1 = { values = [1.0, 2.0] }",
            ["[[curves]] 1", "2 parameters", "one"],
        ),
    ],
)
def test_a_faulty_request_is_one_line_with_file_and_key(figure, old, new, words, error_of):
    assert old in PAGE
    message = error_of(figure, PAGE.replace(old, new, 1))
    assert all(word in message for word in ("page.toml", *words)), message


@pytest.mark.parametrize("text", ["curves = 1", "curves = []", "[curves]\nsystem = 'tmd'"])
def test_curves_are_an_array_of_tables(figure, text):
    with pytest.raises(RequestError, match=r"must be one or more tables \[\[curves\]\]"):
        figure(text)


def test_the_same_curve_twice_is_refused(figure):
    twice = PAGE + '[[curves]]\nsystem = "none"\n'
    with pytest.raises(RequestError, match="stands twice"):
        figure(twice)


# ---- what travels with the package ---------------------------------------------------------------


def test_the_papers_figures_come_first_in_their_order():
    names = list(packaged_figures())
    figures = [name for name in names if name[0].isdigit()]
    assert names[: len(figures)] == figures
    assert figures[:8] == ["2a", "2b", "3", "4", "5", "6", "7", "8"]
    assert short_name("study-free-tmd") == "free-tmd"


def test_each_figure_of_the_paper_has_a_script_beside_its_request():
    for path in (ROOT / "scans").glob("figure*.toml"):
        assert path.with_suffix(".py").is_file(), path


def test_the_wheel_carries_every_request_file():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    carried = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert carried["scans"] == "nlds_vines/_data"  # whatever is put there travels
    assert {path.parent for path in packaged_files.figure_files()} == {ROOT / "scans"}


def test_an_installed_wheel_finds_its_own_requests(tmp_path, monkeypatch):
    (tmp_path / "_data").mkdir()
    (tmp_path / "_data" / "figure9.toml").write_text("")
    (tmp_path / "_data" / "dampers.toml").write_text("")
    monkeypatch.setattr(packaged_files, "files", lambda package: tmp_path)
    assert [path.name for path in packaged_files.figure_files()] == ["figure9.toml"]
