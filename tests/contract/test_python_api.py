"""From Python: verbs, names of systems, archives, what results and objects print."""

import csv
import dataclasses
import gc
import importlib
import inspect
import io
import os
import pickle
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import nlds_vines as nv
from nlds_vines.archives.archive import ArchivePath
from nlds_vines.archives.representation import MOST_LINES, WIDTH
from nlds_vines.bifurcation.response_curves import ResponseCurve, ResponseCurves, load_curves
from nlds_vines.loads.result import PEAKS, LoadScan, ResponseHistories, ResponseHistory
from nlds_vines.model.quantities import SHARES, WAYS
from nlds_vines.model.setting import Request
from nlds_vines.model.slow_manifold import FrequencyResponse
from nlds_vines.model.system import General, System
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


def test_an_archive_is_read_with_and_without_with_in_parts_by_names_of_dimensions(path, error_of):
    with nv.read(path) as view:
        inside = view["E1max"]
    view = nv.read(path)
    assert np.array_equal(view["E1max"], inside)
    view.close()
    assert "closed" in repr(view)
    assert "no such file" in error_of(nv.read, path.parent / "b.h5")
    view = nv.read(path)
    assert view.take("label", omega=0).shape == (3,)
    assert view.take("label", omega=-1, start=2) == view["label"][1, 2]
    assert view.take("section", start=0, component=2, forcing_period=slice(-2, None)).tolist() == (
        view["section"][:, 0, -2:, 2].tolist()
    )
    assert (view.axes, view.units("section")) == (("omega",), "m, m/s")
    line = error_of(view.take, "label", omgea=0)
    assert re.search(r"of label: 'omgea'; did you mean 'omega'\? .*start", line)
    line = error_of(view.take, "label", omega=2)
    assert re.search("omega of label = 2 must be .* from -2 to 1", line)
    assert "did you mean 'label'" in error_of(view.take, "lable", omega=0)


def test_a_table_has_a_row_for_each_orbit_or_period(path, tmp_path, error_of):
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
    view.to_csv(target, "section", "E1max", overwrite=True)
    rows = list(csv.DictReader(io.StringIO(target.read_text())))
    assert len(rows) == 6 * 5
    assert [float(row["x2"]) for row in rows] == view["section"][..., 2].ravel().tolist()
    assert float(rows[5]["E1max"]) == view["E1max"][0, 1]
    line = error_of(view.to_csv, target, "sections", overwrite=True)
    assert "unknown dataset" in line


def test_pandas_and_xarray_take_an_archive(path, monkeypatch, error_of):
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
    words = view.flags("regime")  # in place of codes
    assert words[3] == "chaotic"
    assert frame["regime"].tolist() == [words[code] for code in view["regime"].ravel()]
    assert view.to_dataframe("omega")["omega"].tolist() == view["omega"].tolist()
    monkeypatch.setitem(sys.modules, "pandas", None)  # a library that is missing is named
    line = error_of(nv.read(path).to_dataframe)
    assert re.search(r"pandas is not installed: pip install .*\[xarray\]", line)


@pytest.mark.kernels
def test_reprs_have_five_lines_and_notebooks_a_table(path):
    orbit = nv.simulate("ssul-set6", 4, record=["section", "impacts", "energy", "trajectory"])
    branches = nv.continue_branch("ssul-set6", "omega", (6.2, 6.25), plane=("P", 700.0, 900.0))
    limited = nv.load_system("ssbl")
    limited = type(limited)("ssvi-c", {**limited.parameters, "L": 0.1})
    objects = [
        limited, nv.load_system("ssul-set6"), orbit, nv.simulate(limited, 4), nv.classify("tmd"),
        nv.load_scan(SCAN), nv.load_scan(), nv.load_tuning("ssul-set6"), nv.load_scan().axes[0],
        nv.load_continuation("ssul-set6"), nv.spectrum(orbit), nv.read(path), branches,
        branches.branches[0], branches.request, *branches.orbits_at(6.22), *branches.curves,
        nv.Ensemble(np.array(["T,1"] * 9, object), np.zeros(9, int), np.ones(9)),
    ]  # fmt: skip
    for one in objects:
        lines = repr(one).splitlines()
        assert 1 <= len(lines) <= MOST_LINES, one
        assert max(map(len, lines)) <= WIDTH, one
        name = "System" if isinstance(one, nv.System) else type(one).__name__
        assert lines[0].startswith(name)
        table = one._repr_html_()
        assert table.startswith("<table>")
        assert table.count("<tr>") == table.count("</tr>") > 0 or type(one).__name__ == "Axis"
    text = "\n".join(map(repr, objects))
    axis = "omega = 5 to 8 rad/s (0.7958 to 1.273 Hz), 1201 values"
    for word in ("ssul-set6", "m1 = 1000", "ssvi-c", axis, "E1max = "):
        assert word in text, word


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
    notice = progress.Notice()  # of a single orbit
    for words, seconds in (("compiling", 0.0), ("compiling", 1.0), ("", 2.0)):
        notice(words, seconds)
    assert shown[-1] == "compiling: done in 2 s"
    assert any("compiling: 1 s" in text for text in shown)
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


SHORT = {"transient": 20, "periods": 12}
FEW = {"omega": {"start": 6.0, "stop": 6.2, "num": 3}}


def scan(**changes):
    return nv.scan(
        "ssul-set6", vary=FEW, sampling=SHORT, record=["section", "impacts", "energy", "regime"],
        quiet=True, **changes,
    )  # fmt: skip


def test_a_scan_in_memory_leaves_no_file(here):
    request = scan()
    assert os.listdir(here) == []
    assert request.request.axes[0].values.tolist() == [6.0, 6.1, 6.2]
    assert request.read()["E1max"].shape == (3, 1)
    assert not os.path.lexists(str(request.parent))  # nothing is written before a file is needed
    assert list(request.to_xarray()["label"].values.ravel()) == ["T,1"] * 3
    assert request.to_dataframe()["E1max"].gt(0).all()
    assert request.plot().axes
    place, folder = str(request), request.parent
    with request.read() as view:
        del request
        gc.collect()
        assert view["E1max"].shape == (3, 1)  # what is open stays open
    del view
    gc.collect()
    assert not os.path.exists(place)
    assert not folder.exists()


def test_a_file_has_what_memory_has_and_both_are_pickled_opened_and_read(here, error_of):
    named, nameless = scan(to="scan.h5"), scan()
    assert named == ArchivePath("scan.h5")
    assert os.listdir(here) == ["scan.h5"]
    assert named.to_xarray().equals(nameless.to_xarray())
    assert "scan.h5' exists" in error_of(scan, to="scan.h5")
    assert scan(to="scan.h5", resume=True) == named
    for name in ("resume", "overwrite"):  # of no file
        assert "name it by to=" in error_of(scan, **{name: True})
    assert scan(start="up").request.start.policy == "up"  # a start may be a word
    # both are pickled and opened
    copy = pickle.loads(pickle.dumps(nameless))
    assert copy != nameless
    assert copy.to_xarray().equals(nameless.to_xarray())
    assert pickle.loads(pickle.dumps(nv.scan)) is nv.scan
    assert pickle.loads(pickle.dumps(nameless.request)) == nameless.request
    assert pickle.loads(pickle.dumps(named)) == named
    assert type(nv.open_archive("scan.h5")) is type(nameless)
    assert "no such file" in error_of(nv.open_archive, "no.h5")
    assert "path of a file" in error_of(nv.open_archive, 3)
    # and read alike
    with nameless.read() as memory, nv.read(os.fspath(nameless)) as file:
        assert sorted(memory.names) == sorted(file.names)
        for name in (*memory.names, "omega", "component"):
            assert str(memory.describe(name)) == str(file.describe(name))  # nan is not nan
            assert memory.shape(name) == file.shape(name)
            np.testing.assert_array_equal(memory[name], file[name])
            assert memory[name].dtype == file[name].dtype
        assert {**memory.attrs, "hdf5_version": file.attrs["hdf5_version"]} == file.attrs
        assert (memory.content, memory.axes) == (file.content, file.axes)
        values = memory["E1max"]
        values[:] = 0.0  # a copy
        assert memory.take("E1max", omega=1)[0] > 0.0
        for call in (lambda view: view["x9"], lambda view: view.take("E1max", omega=9)):
            for view in (memory, file):
                error_of(call, view)


SEARCH = {"population": 5, "generations": 1, "seeds": 1, "polish": 0}
RESULTS = {
    "transient_lifetimes": (
        "ssul-set6", {"starts": 8, "transient": 200, "periods": 20},
        lambda result: (result.labels.size, result.request.starts) == (8, 8),
    ),
    "response_curves": (
        ["none", "ssul-set6"], {"vary": FEW, "sampling": SHORT},
        lambda result: (
            result["SSul NES, Set 6"].E1max.shape == (3,) and result.request.axis == "omega"
        ),
    ),
    "tune": (
        "ssul-set6", {"free": {"k2": {"low": 100.0, "high": 3000.0}}, "search": SEARCH,
                      "sampling": SHORT, "surface": {"parameters": ["k2", "c2"], "size": 2}},
        lambda result: result.request == result.tuning and result.best.objective > 0.0,
    ),
    "continue_branch": (
        "ssul-set6", {"parameter": "omega", "bounds": (6.2, 6.4)},
        lambda result: (
            result.branches[0].labels[0] == "T,1" and result.request.along.name == "omega"
        ),
    ),
}  # fmt: skip
"""Systems and keywords of functions that return a result, and what holds of it."""


@pytest.mark.slow("four tasks, twice each")
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.kernels] * (n != "continue_branch")) for n in RESULTS],
)
def test_a_task_leaves_a_file_only_where_it_is_named(name, here):
    system, options, holds = RESULTS[name]
    nameless = getattr(nv, name)(system, **options, quiet=True)
    assert os.listdir(here) == []
    assert holds(nameless)
    assert nameless.plot().axes
    getattr(nv, name)(system, **options, quiet=True, to="a.h5")
    assert os.listdir(here) == ["a.h5"]
    opened = nv.open_archive("a.h5")
    assert opened.to_xarray().equals(nameless.to_xarray())


def test_what_lies_along_a_dimension_is_a_table(here, ask, error_of):
    """The points of branches in Python and as CSV, beside the attributes of the branch."""
    found = nv.continue_branch("ssul-set6", "omega", (6.2, 6.4), quiet=True, to="b.h5")
    (branch,) = found.branches
    table = found.to_dataframe("points")
    assert table.equals(found.to_dataframe("point"))
    assert table["omega"].tolist() == branch.parameter.tolist()
    assert table["state_v2"].tolist() == branch.states[:, 3].tolist()
    assert table["multipliers_2_imaginary"].tolist() == branch.multipliers[:, 1].imag.tolist()
    assert set(table["stable"]) == {"stable"}
    assert found.to_dataframe("branches").equals(found.to_dataframe("branch"))
    assert "unknown dataset" in error_of(found.to_dataframe, "points", "label")
    assert "unknown dataset" in error_of(found.to_dataframe, "special")  # it has none
    ask("export", "b.h5", "points")
    head, first, *_ = Path("b.csv").read_text().splitlines()
    assert head.split(",") == [*table.columns]
    assert first.split(",")[0] == "0"


def test_a_portrait_is_a_figure_and_a_file_where_it_is_asked_for(here):
    options = {"transient": 5, "periods": 3, "samples": 32, "panels": ["phase"]}
    assert nv.orbit_portrait("ssul-set6", quiet=True, **options).axes
    assert os.listdir(here) == []
    nv.orbit_portrait("ssul-set6", to="p.png", quiet=True, **options)
    assert os.listdir(here) == ["p.png"]


MANY = 100_000

PATH = ArchivePath("x.h5")


def annotations_of(value):
    """Yield the annotations of a class and its public members, or of what a function returns."""
    if not inspect.isclass(value):
        yield value.__annotations__.get("return", "")
        return
    yield from inspect.get_annotations(value).values()
    for name, member in vars(value).items():
        member = getattr(member, "fget", getattr(member, "func", member))
        if not name.startswith("_") and inspect.isfunction(member):
            yield member.__annotations__.get("return", "")


def test_every_result_has_a_short_form_of_its_own():
    """Neither the form that dataclasses make of all that they hold, nor that of a tuple."""
    stub = (Path(nv.__path__[0]) / "__init__.pyi").read_text()
    exported = re.findall(r"^from (\S+) import (\w+) as", stub, re.MULTILINE)
    left = [getattr(importlib.import_module(module), name) for module, name in exported]
    reached = set()  # by annotations, from what is exported
    while left:
        value = left.pop()
        left_out = Request, System, General
        if value in reached or (inspect.isclass(value) and issubclass(value, left_out)):
            continue
        reached.add(value)
        for base in value.__mro__ if inspect.isclass(value) else [value]:
            if base.__module__.startswith("nlds_vines."):
                module = importlib.import_module(base.__module__)
                words = re.findall(r"\w+", " ".join(map(str, annotations_of(base))))
                named = [getattr(module, word, None) for word in words]
                classes = filter(inspect.isclass, named)
                left += [one for one in classes if one.__module__.startswith("nlds_vines.")]
    generated = set()
    for kind in filter(inspect.isclass, reached):
        text = " ".join(map(str, inspect.get_annotations(kind).values()))
        if re.search(r"ndarray|Mapping|tuple\[\w+, \.\.\.\]|list\[", text):
            is_generated = getattr(kind.__repr__, "__module__", None) == "collections"
            if dataclasses.is_dataclass(kind):
                is_generated = kind.__dataclass_params__.repr
            generated |= {kind.__name__} if is_generated else set()
    assert generated == {"Dataset"}  # which describes a column, in a few words
    assert {ResponseHistories, LoadScan, ResponseHistory, FrequencyResponse} <= reached
    assert {ResponseCurve, ResponseCurves} <= reached


def fall(count):
    time = np.linspace(0.0, 60.0, count)
    numbers = {f"last_{100 * share:g}": 1.0 for share in SHARES}
    numbers |= {**dict.fromkeys(PEAKS, 1.0), "E1max": 1.0, "x1_rms": 0.1}
    numbers |= {f"share_{path}": 0.3 for path in WAYS}
    return ResponseHistory(time, time, time, time, time, time, dict.fromkeys(WAYS, time), numbers)


def made_up():
    names = ["none", "tmd", "ssbl", *(f"ssul-set{i}" for i in range(1, 7))]
    request = nv.load_response_history({"systems": names, "load": {"impulse": 300.0}})
    yield fall(MANY)
    yield ResponseHistories(PATH, request, {name: fall(2000) for name in names})
    axes = {"impulse": {"start": 1.0, "stop": 300.0, "num": 500}}
    many = nv.load_response_history({"systems": names, "load": {"impulse": 300.0}, "vary": axes})
    values = np.ones((len(names), 500))
    yield LoadScan(PATH, many, {"E1max": values, "x1_max": values}, np.zeros_like(values, int))
    omega = {"omega": {"start": 5.0, "stop": 8.0, "num": 100}}
    page = load_curves({"vary": omega, "curves": [{"system": name} for name in names]})
    numbers = dict.fromkeys(("E1max", "E2max"), np.ones((MANY, 1)))
    curves = [ResponseCurve(case.title, case, numbers) for case in page.cases]
    yield curves[0]
    yield ResponseCurves(PATH, page, tuple(curves))
    yield nv.slow_manifold(nv.load_system("vi-nes"))
    yield nv.slow_manifold(nv.load_system("vi-nes")).response()


def test_large_results_print_a_few_lines():
    for text in map(str, made_up()):
        lines = text.splitlines()
        assert len(lines) <= 6, text
        assert all(len(line) <= WIDTH + 100 for line in lines), text
        assert len(text) > 20
