"""Public docstrings: numpydoc's own lint, and every example runs."""

import doctest
import inspect

import pytest
from numpydoc.validate import validate

import nlds_vines as nv

NAMES = [name for name in nv.__all__ if name != "__version__"]
FUNCTIONS = [name for name in NAMES if not inspect.isclass(getattr(nv, name))]

COMPILING = {"tune", "LoadScan", "ScanArchive", "basin_measures", "orbit_of", "response_curves"}
COMPILING |= {"scan", "transient_lifetimes", "ensemble_of", "response_history", "ResponseHistories"}
"""The names whose examples need kernels beyond the four configurations of this tier."""

UNASKED = {"ES01", "SA01", "SA04", "EX01"}
"""No extended summary and no "See Also", no words beside a name in it, no example of a class."""


@pytest.mark.parametrize("name", NAMES)
def test_docstrings_pass_the_lint_of_numpydoc(name):
    unasked = UNASKED | ({"PR01"} if name not in FUNCTIONS else set())  # they list attributes
    errors = validate(f"nlds_vines.{name}")["errors"]
    assert not [text for code, text in errors if code not in unasked]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_has_an_example(name):
    assert ">>>" in inspect.getdoc(getattr(nv, name))


def run(name, folder, monkeypatch):
    monkeypatch.chdir(folder)
    thing = getattr(nv, name)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    for example in doctest.DocTestFinder().find(thing, name, globs={}):
        runner.run(example)
    assert runner.summarize().failed == 0


@pytest.mark.parametrize("name", [name for name in NAMES if name not in COMPILING])
def test_examples_run(name, tmp_path, monkeypatch):
    run(name, tmp_path, monkeypatch)


@pytest.mark.kernels
@pytest.mark.parametrize("name", sorted(COMPILING))
def test_examples_that_compile_run(name, tmp_path, monkeypatch):
    run(name, tmp_path, monkeypatch)
