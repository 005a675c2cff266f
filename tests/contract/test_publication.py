"""What a version needs that is published: files that agree, docstrings, types, what is shipped."""

import ast
import doctest
import inspect
import json
import os
import re
import subprocess
import tomllib
from importlib import import_module
from pathlib import Path

import pytest
from commands import python
from numpydoc.validate import validate

import nlds_vines as nv

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
VERSION = PROJECT["project"]["version"]
STUB = Path(nv.__path__[0], "__init__.pyi")
FORMS = ("config", "crash", "idea", "wrong-number")
YAML = (
    *("CITATION.cff", ".readthedocs.yaml", ".pre-commit-config.yaml", ".github/workflows/ci.yml"),
    *(f".github/ISSUE_TEMPLATE/{name}.yml" for name in FORMS),
)


def text_of(name):
    return (ROOT / name).read_text(encoding="utf-8")


def yaml_of(name):  # without PyYAML (extra `docs`) the test is skipped
    return pytest.importorskip("yaml").safe_load(text_of(name))


# ---- files ---------------------------------------------------------------------------------------


def test_the_files_name_one_version_title_and_license():
    zenodo = json.loads(text_of(".zenodo.json"))
    citation = dict(re.findall(r'^([\w-]+): "?(.*?)"?$', text_of("CITATION.cff"), re.M))
    assert zenodo["version"] == citation["version"] == VERSION
    assert zenodo["title"] == citation["title"]
    assert zenodo["license"] == citation["license"] == PROJECT["project"]["license"]
    assert citation["repository-code"] == PROJECT["project"]["urls"]["Homepage"]
    lines = text_of("CITATION.cff").splitlines()
    assert {f"  - {word}" for word in zenodo["keywords"]} <= {*lines}
    for creator in zenodo["creators"]:
        assert f'name: "{creator["name"]}"' in text_of("CITATION.cff")


def test_the_changelog_has_this_version_below_what_is_not_released():
    headings = re.findall(r"^## \[(.*?)\]", text_of("CHANGELOG.md"), re.M)
    assert headings[:2] == ["Unreleased", VERSION]
    targets = re.findall(r"^\[(.*?)\]: https://", text_of("CHANGELOG.md"), re.M)
    assert targets == headings


def test_all_yaml_is_well_formed_and_none_is_forgotten():
    for name in YAML:
        assert isinstance(yaml_of(name), dict), name
    paths = [*ROOT.glob(".*.yaml"), *ROOT.glob(".github/**/*.yml"), *ROOT.glob("*.cff")]
    assert {str(path.relative_to(ROOT)) for path in paths} == set(YAML)


def test_the_workflow_calls_the_gate_and_hooks_and_site_are_as_told():
    jobs = yaml_of(".github/workflows/ci.yml")["jobs"]
    lines = {name: [step.get("run", "") for step in job["steps"]] for name, job in jobs.items()}
    assert any(".ci/run ${{ matrix.part }}" in line for line in lines["linux"])
    assert jobs["linux"]["strategy"]["matrix"]["part"] == ["kernels", "others"]
    first = re.search(r"```sh\n(python3 -m venv .*?)\n```", text_of("README.md")).group(1)
    assert first in lines["others"]
    assert any("-m pytest" in line for line in lines["others"])
    systems = jobs["others"]["strategy"]["matrix"]["os"]
    assert {system.partition("-")[0] for system in systems} == {"macos", "windows"}
    assert jobs["others"]["continue-on-error"]
    assert not jobs["linux"].get("continue-on-error")
    # hooks are the checks of style and types
    (repository,) = yaml_of(".pre-commit-config.yaml")["repos"]
    programs = [hook["entry"].split()[0] for hook in repository["hooks"]]
    assert programs == ["ruff", "ruff", "mypy"]
    # the site is built as the README tells
    site = yaml_of(".readthedocs.yaml")
    assert site["sphinx"] == {"configuration": "docs/conf.py", "fail_on_warning": True}
    (install,) = site["python"]["install"]
    assert install["extra_requirements"] == ["docs"]


def test_the_page_of_the_paper_cites_what_there_is_and_tells_no_number_of_its_own():
    page, pages = text_of("paper.md"), text_of("README.md")
    pages += "".join(path.read_text("utf-8") for path in (ROOT / "docs").glob("*.md"))
    keys = re.findall(r"^@\w+\{(\w+),", text_of("paper.bib"), re.M)
    assert set(re.findall(r"@(\w+)", page)) == set(keys)
    body = re.sub(r"\[@\w+\]", "", page.split("---\n", 2)[2])
    numbers = set(re.findall(r"(?<![\w.])\d[\d.]*(?:e-?\d+)?(?![\w])", body))
    assert len(numbers) >= 8
    for number in numbers:
        number = number.rstrip(".")
        padded = re.sub(r"e-(\d)$", r"e-0\1", number)  # as tables write it
        either = f"{re.escape(number)}|{re.escape(padded)}"
        assert re.search(rf"(?<![\d.])({either})(?!\d)", pages), number
    assert len(page.split()) < 700  # one page


def test_a_source_archive_has_all_that_the_repository_has():
    listed = set(PROJECT["tool"]["hatch"]["build"]["targets"]["sdist"]["include"])
    assert all((ROOT / name).exists() for name in listed)
    if not (ROOT / ".git").exists():
        pytest.skip("no clone")
    names = subprocess.check_output(["git", "ls-tree", "--name-only", "HEAD"], cwd=ROOT, text=True)
    unasked = {"pyproject.toml", ".gitignore"}  # in every source archive
    assert set(names.split()) - unasked <= listed


def test_lowest_versions_classifiers_and_addresses():
    project = PROJECT["project"]
    assert "Operating System :: OS Independent" in project["classifiers"]
    lowest = project["requires-python"].removeprefix(">=")
    assert f"Programming Language :: Python :: {lowest}" in project["classifiers"]
    assert PROJECT["tool"]["mypy"]["python_version"] == lowest
    assert {"Homepage", "Documentation", "Changelog", "Issues"} <= set(project["urls"])


POSIX_ALONE = """
import builtins, os, signal, sys
import h5py, matplotlib.figure, multiprocessing, numba, pathlib, scipy, subprocess, tempfile

for name in ("getuid", "fork", "sched_getaffinity", "posix_fallocate", "O_NONBLOCK", "O_NOFOLLOW"):
    delattr(os, name)
for name in ("SIGUSR1", "SIGALRM", "setitimer", "pthread_kill"):
    delattr(signal, name)
plain = builtins.__import__

def without(name, *rest, **more):
    if name in ("fcntl", "resource", "pwd", "grp", "termios"):
        raise ImportError(name)
    return plain(name, *rest, **more)

builtins.__import__ = without
from nlds_vines.__main__ import main
scan = ["bifurcation", "--vary", "omega=6:7:3", "--transient", "50", "-o", "a.h5"]
sys.exit(main([*scan, "--plot", "a.png"]) or main([*scan, "--resume"]))
"""


@pytest.mark.slow("a process that loads kernels, and draws")
def test_nothing_is_needed_that_posix_alone_has(tmp_path):
    done = python("-c", POSIX_ALONE, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert sorted(os.listdir(tmp_path)) == ["a.h5", "a.png"]


# ---- types ---------------------------------------------------------------------------------------


def stub_names(text):
    """Return the public names of a stub: the module of each, "" for what it declares itself."""
    names = {}
    for node in ast.parse(text).body:
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                assert alias.asname == alias.name, "only `import NAME as NAME` is public in a stub"
                names[alias.name] = node.module.removeprefix("nlds_vines.")
        elif isinstance(node, ast.AnnAssign):
            names[node.target.id] = ""
    return names


def test_the_types_are_those_of_the_public_names():
    assert stub_names(STUB.read_text("utf-8")) == {**nv._HOMES, "__version__": ""}
    assert STUB.with_name("py.typed").is_file()
    for name in set(nv.__all__) - {"__version__"}:
        home = nv._HOMES[name]
        typed, real = getattr(import_module(f"nlds_vines.{home}"), name), getattr(nv, name)
        assert real is typed or inspect.signature(real) == inspect.signature(typed), name
    # every function says the types of all arguments
    for name in nv.__all__:
        real = getattr(nv, name)
        if callable(real) and not isinstance(real, type):
            named = inspect.signature(real).parameters.keys() | {"return"}
            assert named <= real.__annotations__.keys(), name


def test_a_stub_that_lags_behind_is_noticed():
    text = STUB.read_text("utf-8")
    assert stub_names(text.replace("tuning.command", "tuning.run")) != stub_names(text)
    with pytest.raises(AssertionError):
        stub_names(text.replace(" as tune\n", "\n"))


NAMES = [name for name in nv.__all__ if name != "__version__"]
FUNCTIONS = [name for name in NAMES if not inspect.isclass(getattr(nv, name))]

# the names whose examples need kernels beyond the four configurations of this tier
COMPILING = {"tune", "LoadScan", "ScanArchive", "basin_measures", "orbit_of", "response_curves"}
COMPILING |= {"scan", "transient_lifetimes", "ensemble_of", "response_history", "ResponseHistories"}

# no extended summary and no "See Also", no words beside a name in it, no example of a class
UNASKED = {"ES01", "SA01", "SA04", "EX01"}


@pytest.mark.parametrize("name", NAMES)
def test_docstrings_pass_the_lint_of_numpydoc(name):
    unasked = UNASKED | ({"PR01"} if name not in FUNCTIONS else set())  # they list attributes
    errors = validate(f"nlds_vines.{name}")["errors"]
    assert not [text for code, text in errors if code not in unasked]
    assert name not in FUNCTIONS or ">>>" in inspect.getdoc(getattr(nv, name))


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.kernels] * (n in COMPILING)) for n in NAMES]
)
def test_examples_run(name, here):
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    for example in doctest.DocTestFinder().find(getattr(nv, name), name, globs={}):
        runner.run(example)
    assert runner.summarize().failed == 0
