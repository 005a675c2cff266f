"""Rules of the house, read from sources and processes: layers, names, what loads what."""

import ast
import inspect
import json
import shutil
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import pytest
from commands import printed, python

import nlds_vines
from benchmarks.house import imports, modules, parsed, repeated_constants

PACKAGE = Path(nlds_vines.__path__[0])
MODULES = modules(PACKAGE)
ROOT = PACKAGE.parent

WORDS = {"request", "run", "result", "picture", "command", "__main__", "__init__"}
"""The words that stand in every wing; any other file name is used once."""


@cache
def imported_by():
    """Return what each module imports, at any depth."""
    return {name: imports(path, PACKAGE) for name, path in MODULES.items()}


def who_imports(library):
    return {
        name
        for name, names in imported_by().items()
        if any(f"{imported}.".startswith(f"{library}.") for imported in names)
    }


KERNELS = sorted(name for name in MODULES if name.split(".")[0] == "kernels")


# ---- floors and circles --------------------------------------------------------------------------


def linted(folder):
    program = "from importlinter.cli import lint_imports_command as main; main()"
    words = ["-c", program, "--config", ROOT / "pyproject.toml", "--no-cache"]
    done = python(*words, cwd=folder, PYTHONPATH="")
    return done.returncode, done.stdout + done.stderr


def test_arrows_point_down_and_in_no_circle():
    """The floors stand in pyproject.toml; every import counts, in functions and for types, too."""
    status, report = linted(ROOT)
    assert status == 0, report
    codes = imports(MODULES["kernels.scene.codes"], PACKAGE)  # which pictures may import
    assert not [name for name in codes if name.startswith(PACKAGE.name)]


@pytest.fixture
def copy(tmp_path):
    ignored = shutil.ignore_patterns("__pycache__")  # where other processes write
    return Path(shutil.copytree(PACKAGE, tmp_path / PACKAGE.name, ignore=ignored))


LATE = "def late():\n    from nlds_vines.{0} import {1}\n"
FOR_TYPES = "import typing\nif typing.TYPE_CHECKING:\n    from nlds_vines.{0} import {1}\n"


def test_a_hidden_circle_or_arrow_is_caught(copy):
    """In a function, for types, and of a wing on no floor."""
    (copy / "stray").mkdir()
    (copy / "stray" / "__init__.py").write_text("")
    status, report = linted(copy.parent)
    assert (status, "stray" in report) == (1, True)
    shutil.rmtree(copy / "stray")
    for where, hidden, imported in (
        ("runs/executors.py", LATE, ("runs", "store")),
        ("runs/store.py", FOR_TYPES, ("runs", "executors")),
        ("cli/running.py", FOR_TYPES, ("plotting.chosen_panels", "FORMATS")),
        ("archives/archive.py", LATE, ("bifurcation.request", "Scan")),
        ("model/labels.py", LATE, ("kernels.numerics", "elementary")),  # which pictures import
    ):
        with (copy / where).open("a") as file:
            file.write(hidden.format(*imported))
    status, report = linted(copy.parent)
    assert status == 1
    assert "No cycles are allowed in nlds_vines.runs" in report
    assert "nlds_vines.cli is not allowed to import nlds_vines.plotting" in report
    assert "nlds_vines.archives is not allowed to import nlds_vines.bifurcation" in report
    assert "nlds_vines.bifurcation.picture is not allowed to import nlds_vines.kernels" in report


def test_names_that_stand_twice_are_caught(copy):
    (copy / "runs" / "style.py").write_text("")
    assert used_twice(copy) == {"style"}
    with (copy / "kernels" / "numerics" / "elementary.py").open("a") as file:
        file.write("\n\nX = 1\nHUGE = 2\n")
    parsed.cache_clear()
    assert repeated_constants(copy) == {"SORTS", "X", "HUGE"}


def used_twice(package):
    stems = Counter(path.stem for path in modules(package).values())
    return {stem for stem, count in stems.items() if count > 1} - WORDS


def test_files_and_constants_have_names_of_their_own():
    assert used_twice(PACKAGE) == set()
    assert repeated_constants(PACKAGE) == {"SORTS"}  # of each law


def test_every_module_and_every_public_name_has_a_docstring():
    assert all(ast.get_docstring(parsed(path)) for path in MODULES.values())
    for name in nlds_vines.__all__:
        value = getattr(nlds_vines, name)
        if isinstance(value, type) or inspect.isroutine(value):
            assert value.__doc__, name
        for member, part in vars(value).items() if isinstance(value, type) else ():
            if member[0] != "_" and (inspect.isfunction(part) or isinstance(part, property)):
                assert part.__doc__, f"{name}.{member}"


@pytest.mark.parametrize("folder", sorted({path.parent for path in MODULES.values()} - {PACKAGE}))
def test_the_docstring_of_a_folder_is_its_table_of_contents(folder):
    text = ast.get_docstring(parsed(folder / "__init__.py"), clean=False)
    lines = [line for line in text.splitlines() if line.startswith("    ") and line.strip()]
    listed = {line.split()[0].rstrip("/") for line in lines}
    listed |= {word.strip(".,") for word in text.partition("Modules in reading order:")[2].split()}
    there = {path.stem for path in folder.iterdir() if path.stem[:2] != "__"}
    assert there <= listed


# ---- who knows what ------------------------------------------------------------------------------


# modules that teach the compiler a type, say how kernels are compiled and kept, tell the compiler
# which of several kernels is called, and compute constants of kernels once in a process
TYPES = {"kernels.numerics.fours"}
COMPILING = {f"kernels.numerics.{name}" for name in ("compiling", "deciding", "stored_code")}
CHOOSING = {"kernels.scene.by_law"}
PREPARED = {"kernels.impact.arc", "kernels.hosts.cell_constants"}
UNCOMPILED = TYPES | COMPILING | CHOOSING | PREPARED


def test_kernels_import_numbers_only_and_are_compiled():
    for name in KERNELS:
        outside = {full.split(".")[0] for full in imported_by()[name]}
        allowed = {"nlds_vines", "__future__", "numba", "numpy", "math", "typing"}
        if name in TYPES | CHOOSING:
            allowed |= {"collections", "llvmlite", "operator"}
        if name in PREPARED:
            allowed |= {"collections", "dataclasses", "functools", "itertools"}
        assert name in COMPILING or outside <= allowed, name
        for node in parsed(MODULES[name]).body if name not in UNCOMPILED else ():
            if isinstance(node, ast.FunctionDef):
                used = {ast.unparse(decorator).split("(")[0] for decorator in node.decorator_list}
                assert used & {"jit", "by_wall", "by_flow"}, node.name


@pytest.mark.slow("all imports of the package")
def test_each_library_has_its_home():
    assert who_imports("numba") - TYPES == COMPILING
    assert not {*who_imports("benchmarks"), *who_imports("paper"), *who_imports("tests")}
    assert who_imports("h5py") == {"archives.hdf5"}
    assert who_imports("distributed") == {"scans.cluster"}
    types = {"engine.one_orbit", "bifurcation.result", "loads.response_spectrum"}
    types |= {"plotting.drawable", "upkeep.plot"}  # only the type of a figure
    importers = who_imports("matplotlib") - types
    homes = ("plotting.", "bifurcation.picture.", "portrait.")
    assert importers
    assert all(name.startswith(homes) or name.endswith("picture") for name in importers)
    importers = who_imports("bokeh") | who_imports("tornado") | who_imports("jinja2")
    assert importers
    assert all(name.startswith("explore.") for name in importers)
    assert not importers & {"upkeep.explore", "upkeep.report"}


def test_only_the_standard_library_and_what_is_declared_is_imported():
    declared = {"numba", "numpy", "scipy", "h5py", "matplotlib", "mpl_toolkits", "tqdm"}
    declared |= {"distributed", "cma"}  # of the extras `cluster` and `cma`
    declared |= {"IPython"}  # only asked for where a notebook has loaded it
    declared |= {"bokeh", "tornado", "jinja2"}  # of the extra `explore`, which needs all three
    declared |= {"llvmlite"}  # which numba is built on, in the one version that fits
    for name, names in imported_by().items():
        outside = {full.split(".")[0] for full in names} - {"nlds_vines"}
        assert outside - set(sys.stdlib_module_names) <= declared, name


HEAVY = {"numba", "llvmlite", "h5py", "matplotlib", "scipy", "tqdm", "bokeh", "tornado"}

LINES = {  # status of each, in one process: whatever one loads, all that follow have
    "--help": 0, "--version": 0,
    "bifurcation --help": 0, "bifurcation --system nothing": 2, "bifurcation nothing.toml": 2,
    "bifurcation --set P=nan": 2, "bifurcation -o no/x.h5": 2, "bifurcation -o old.h5": 2,
    "bifurcation --plot x.gif": 2, "bifurcation --shard 8/7": 2,
    "bifurcation --periods 1000000000": 2,
    "bifurcation --vary omega=5:8:9 --show shares -o new.h5": 2,
    "portrait --help": 0, "portrait --panels forces": 2, "portrait good.toml --dry-run": 0,
    "tuning --help": 0, "tuning --dry-run": 0, "tuning --free k2=2:1": 2, "tuning -o old.h5": 2,
    "transients --help": 0, "transients --starts 0": 2, "transients --delay -1": 2,
    "transients -o old.h5": 2,
    "accuracy --help": 0, "accuracy --want 2": 2, "accuracy --plot no/x.png": 2,
    "explore --help": 0, "explore --dry-run": 0, "explore --port -1": 2,
    "explore --system nothing": 2, "explore no.toml": 2,
    "report --help": 0, "report no.h5": 2, "report": 2,
    "plot --help": 0, "plot no.h5": 2, "plot no.h5 -o x.gif": 2,
    "rerun --help": 0, "rerun no.h5": 2,
    "paper --help": 0, "paper --only 13": 2, "paper --dry-run": 0,
}  # fmt: skip

PROGRAM = """
import contextlib, io, json, shlex, sys
from nlds_vines.__main__ import main
from nlds_vines.bifurcation.request import load_scan
from paper.command import main as paper

heavy, found = set(json.loads(sys.argv[1])), {}
load_scan().cells()
for line in json.loads(sys.argv[2]):
    first, *rest = words = shlex.split(line)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        status = paper(rest) if first == "paper" else main(words)
    found[line] = [status, sorted(heavy & sys.modules.keys())]
import h5py
print(json.dumps([found, sorted(heavy & sys.modules.keys())]))
"""


def test_nothing_heavy_is_loaded(tmp_path):
    (tmp_path / "old.h5").write_bytes(b"")
    (tmp_path / "good.toml").write_text('system = "tmd"\n[sampling]\nperiods = 4\n')
    argument = json.dumps(sorted(HEAVY)), json.dumps(list(LINES))
    statuses, after = json.loads(printed("-c", PROGRAM, *argument, cwd=tmp_path))
    assert statuses == {line: [status, []] for line, status in LINES.items()}
    assert after == ["h5py"]  # so that the probe sees what is loaded


EXPLORE = ", ".join(f"nlds_vines.explore.{n}" for n in ("page_state", "page_server", "live_page"))
SPECTRUM = """
from nlds_vines.engine.spectrum import spectrum_of
spectrum_of([1.0, 2.0, 1.0, 0.0] * 4, 4, 1.0, window={!r})
"""


@pytest.mark.parametrize(
    ("words", "needed", "not_yet"),
    [
        (["-m", "nlds_vines.bifurcation", "--set", "P=nan"], {"nlds_vines"}, HEAVY),
        (["-m", "nlds_vines", "bifurcation", "--set", "P=nan"], {"nlds_vines"}, HEAVY),
        (["-c", f"import {EXPLORE}"], {"bokeh"}, {"numba", "scipy", "matplotlib"}),
        (["-c", SPECTRUM.format("rectangular")], set(), {"scipy"}),
        (["-c", SPECTRUM.format("hann")], {"scipy"}, set()),  # a taper
    ],
    ids=["a command", "of all commands", "a page of explore", "a spectrum", "a taper"],
)
def test_nor_before_it_is_needed(words, needed, not_yet, tmp_path):
    if "bokeh" in needed:
        pytest.importorskip("bokeh", reason="Bokeh is not installed")
    times = python("-X", "importtime", *words, cwd=tmp_path).stderr.splitlines()
    names = [line.split("|")[-1] for line in times if line.startswith("import time:")]
    modules = {name.strip().split(".")[0] for name in names}
    assert needed <= modules
    assert not modules & not_yet
