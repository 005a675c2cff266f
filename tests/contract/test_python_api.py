"""From Python: names wherever a system is taken, errors of one line, reprs of five lines."""

import csv
import io
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.archives.representation import MOST_LINES, WIDTH
from nlds_vines.runs import progress

SCAN = {
    "system": "ssul-set6",
    "vary": {"omega": {"values": [6.0, 6.5]}},
    "start": {"policy": "random", "count": 3, "seed": 1},
    "sampling": {"transient": 20, "periods": 5},
    "record": {"want": ["section", "energy", "regime"]},
}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return nv.scan(SCAN, to=tmp_path_factory.mktemp("api") / "a.h5", quiet=True)


# ---- systems -------------------------------------------------------------------------------------


@pytest.mark.kernels
def test_names_paths_and_systems_mean_the_same(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text('system = "ssul-set6"\n')
    for system in ("ssul-set6", nv.load_system("ssul-set6"), str(file), file):
        assert nv.simulate(system, 2).state.tolist() == nv.simulate("ssul-set6", 2).state.tolist()
    assert nv.classify("ssul-set6").label == "T,1"
    assert nv.load_scan("ssbl") == nv.load_scan(nv.load_system("ssbl"))
    assert nv.load_scan("ssbl").system.kind == "ssbl"
    assert nv.load_scan("ssbl").axes[0].name == nv.load_scan().axes[0].name


# ---- archives ------------------------------------------------------------------------------------


def test_an_archive_is_read_with_and_without_with(path):
    with nv.read(path) as view:
        inside = view["E1max"]
    view = nv.read(path)
    assert np.array_equal(view["E1max"], inside)
    view.close()
    assert "closed" in repr(view)
    with pytest.raises(nv.RequestError):
        nv.read(path.parent / "b.h5")


def test_a_part_is_taken_by_names_of_dimensions_alone(path):
    view = nv.read(path)
    assert view.take("label", omega=0).shape == (3,)
    assert view.take("label", omega=-1, start=2) == view["label"][1, 2]
    with pytest.raises(nv.RequestError, match=r"of label: 'omgea'; did you mean 'omega'\? .*start"):
        view.take("label", omgea=0)
    with pytest.raises(nv.RequestError, match=r"omega of label = 2 must be .* from -2 to 1"):
        view.take("label", omega=2)
    with pytest.raises(nv.RequestError, match="did you mean 'label'"):
        view.take("lable", omega=0)


def test_a_table_has_a_row_for_each_orbit_or_period(path, tmp_path):
    view = nv.read(path)
    target = tmp_path / "a.csv"
    view.to_csv(target)
    rows = list(csv.DictReader(io.StringIO(target.read_text())))
    assert len(rows) == 6
    assert {"omega", "start", "label", "E1max", "regime", "status"} <= rows[0].keys()
    assert [float(row["E1max"]) for row in rows] == view["E1max"].ravel().tolist()
    assert [row["label"] for row in rows] == view["label"].ravel().tolist()
    assert {row["status"] for row in rows} == {"ok"}
    assert [row["start"] for row in rows[:3]] == ["random 0", "random 1", "random 2"]
    with pytest.raises(nv.RequestError, match="exists"):
        view.to_csv(target, "section", "E1max")
    view.to_csv(target, "section", "E1max", overwrite=True)
    rows = list(csv.DictReader(io.StringIO(target.read_text())))
    assert len(rows) == 6 * 5
    assert [float(row["x2"]) for row in rows] == view["section"][..., 2].ravel().tolist()
    assert float(rows[5]["E1max"]) == view["E1max"][0, 1]
    with pytest.raises(nv.RequestError, match="unknown dataset"):
        view.to_csv(target, "sections", overwrite=True)


def test_pandas_and_xarray_take_an_archive(path):
    pytest.importorskip("xarray")
    view = nv.read(path)
    labeled = view.to_xarray()
    assert labeled["section"].dims == ("omega", "start", "forcing_period", "component")
    assert np.array_equal(labeled["section"].sel(component="x1"), view["section"][..., 0])
    assert labeled["E1max"].attrs["units"] == "J"
    assert labeled.attrs["title"] == view.text("title")
    frame = view.to_dataframe()
    assert frame.shape[0] == 6
    assert frame.attrs["units"]["E1max"] == "J"
    assert (frame[frame.start == "random 1"].E1max == view["E1max"][:, 1]).all()


def test_a_library_that_is_missing_is_named(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(nv.RequestError, match=r"pandas is not installed: pip install .*\[xarray\]"):
        nv.read(path).to_dataframe()


# ---- what objects say of themselves --------------------------------------------------------------


@pytest.fixture(scope="module")
def objects(path):
    orbit = nv.simulate("ssul-set6", 4, record=["section", "impacts", "energy", "trajectory"])
    branches = nv.continue_branch("ssul-set6", "omega", (6.2, 6.25), plane=("P", 700.0, 900.0))
    limited = nv.load_system("ssbl")
    limited = type(limited)("ssvi-c", {**limited.parameters, "L": 0.1})
    instances = [
        limited, nv.load_system("ssul-set6"), orbit, nv.simulate(limited, 4), nv.classify("tmd"),
        nv.load_scan(SCAN), nv.load_scan(), nv.load_tuning("ssul-set6"), nv.load_scan().axes[0],
        nv.load_continuation("ssul-set6"), nv.spectrum(orbit), nv.read(path), branches,
        branches.branches[0], branches.request, *branches.orbits_at(6.22), *branches.curves,
        nv.Ensemble(np.array(["T,1"] * 9, object), np.zeros(9, int), np.ones(9)),
    ]  # fmt: skip
    return instances


@pytest.mark.kernels
def test_a_repr_has_five_lines_at_most(objects):
    for one in objects:
        lines = repr(one).splitlines()
        assert 1 <= len(lines) <= MOST_LINES, one
        assert max(map(len, lines)) <= WIDTH, one
        assert lines[0].startswith(type(one).__name__)


@pytest.mark.kernels
def test_a_repr_says_what_matters(objects):
    text = "\n".join(map(repr, objects))
    for word in (
        "ssul-set6",
        "m1 = 1000",
        "ssvi-c",
        "omega = 5 to 8 rad/s (0.7958 to 1.273 Hz), 1201 values",
        "E1max = ",
    ):
        assert word in text, word


@pytest.mark.kernels
def test_a_notebook_shows_a_table(objects):
    for one in objects:
        text = one._repr_html_()
        assert text.startswith("<table>")
        assert text.count("<tr>") == text.count("</tr>") > 0 or type(one).__name__ == "Axis"


def test_what_comes_from_a_file_is_escaped_in_a_notebook():
    system = nv.load_system("ssul-set6")
    odd = type(system)(system.kind, system.parameters, title="<script>alert(1)</script>")
    assert "<script>" not in odd._repr_html_()
    assert "&lt;script&gt;" in odd._repr_html_()


# ---- progress in a notebook ----------------------------------------------------------------------


@pytest.fixture
def shown(monkeypatch):
    """Stand in for a notebook; return what it is shown."""
    pytest.importorskip("IPython")
    import IPython
    import IPython.display

    texts = []

    class Place:
        def update(self, data, raw):
            texts.append(data["text/plain"])

    def display(data, raw, display_id):
        texts.append(data["text/plain"])
        return Place()

    monkeypatch.setattr(IPython, "get_ipython", lambda: SimpleNamespace(kernel=object()))
    monkeypatch.setattr(IPython.display, "display", display)
    return texts


def test_a_notebook_has_a_bar_and_says_what_is_compiled(shown, capsys):
    with progress.Progress(4, "orbit") as bar:
        bar.wait("compiling (1 of 2)", 3.0)
        assert "compiling (1 of 2): 3 s" in shown[-1]
        bar.wait("", 3.0)
        bar.note(4, "4 T,1")
    assert "4/4" in shown[-1]
    assert "4 T,1" in shown[-1]
    assert capsys.readouterr() == ("", "")


@pytest.mark.kernels
def test_a_notebook_shows_a_figure(shown, monkeypatch):
    import IPython
    from IPython.core.interactiveshell import InteractiveShell

    shell = InteractiveShell()
    shell.kernel = object()
    monkeypatch.setattr(IPython, "get_ipython", lambda: shell)
    figure = nv.orbit_portrait("none", periods=4, transient=1, panels=["displacement"])
    data, _ = shell.display_formatter.format(figure)
    assert "image/png" in data


def test_in_a_notebook_a_single_orbit_says_it_too(shown):
    notice = progress.Notice()
    notice("compiling", 0.0)
    notice("compiling", 1.0)
    notice("", 2.0)
    assert shown[-1] == "compiling: done in 2 s"
    assert any("compiling: 1 s" in text for text in shown)
