"""Public docstrings: numpydoc's own lint, and every example runs."""

import doctest
import inspect

import pytest

import nlds_vines as nv

validate = pytest.importorskip("numpydoc.validate").validate

NAMES = [name for name in nv.__all__ if name != "__version__"]
COMPILING: set[str] = set()
"""The names whose examples need kernels beyond the four configurations of this tier."""

UNASKED = {"ES01", "SA01", "EX01"}
"""Errors of numpydoc that are none here: no extended summary, no "See Also", and no example, which
an inherited or a generated docstring lacks."""


@pytest.mark.parametrize("name", NAMES)
def test_docstrings_pass_the_lint_of_numpydoc(name):
    errors = validate(f"nlds_vines.{name}")["errors"]
    assert not [text for code, text in errors if code not in UNASKED]


@pytest.mark.parametrize("name", NAMES)
def test_every_public_function_and_class_has_an_example(name):
    thing = getattr(nv, name)
    assert ">>>" in (inspect.getdoc(thing) or ""), name


def examples(name):
    thing = getattr(nv, name)
    return doctest.DocTestFinder(recurse=inspect.isclass(thing)).find(thing, name, globs={})


def run(name, folder, monkeypatch):
    monkeypatch.chdir(folder)
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    for example in examples(name):
        runner.run(example)
    assert runner.summarize(verbose=False).failed == 0


@pytest.mark.parametrize("name", [name for name in NAMES if name not in COMPILING])
def test_examples_run(name, tmp_path, monkeypatch):
    run(name, tmp_path, monkeypatch)


@pytest.mark.kernels
@pytest.mark.parametrize("name", sorted(COMPILING))
def test_examples_that_compile_run(name, tmp_path, monkeypatch):
    run(name, tmp_path, monkeypatch)
