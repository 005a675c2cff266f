"""The examples in docstrings run and print what they show."""

import doctest
from importlib import import_module

import pytest

MODULES = (
    *("model.catalog", "model.slow_manifold", "model.system", "tuning.request"),
    *("orbits.simulation", "orbits.classification", "orbits.spectrum"),
    *("continuation.command", "continuation.request", "continuation.result"),
)
COMPILING = ("tuning.command",)


def run(name):
    module = import_module(f"nlds_vines.{name}")
    assert any(test.examples for test in doctest.DocTestFinder().find(module))
    failures, _ = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failures == 0


@pytest.mark.parametrize("name", MODULES)
def test_examples_print_what_they_show(name):
    run(name)


@pytest.mark.kernels
@pytest.mark.parametrize("name", COMPILING)
def test_examples_that_compile_print_what_they_show(name):
    run(name)
