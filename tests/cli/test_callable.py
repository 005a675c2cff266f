"""A command's folder is called like its function, whichever was loaded first."""

import inspect
import subprocess
import sys
from importlib import import_module

import pytest

import nlds_vines as nv


@pytest.mark.parametrize("name", ["bifurcation", "portrait", "transients"])
def test_the_package_has_the_arguments_of_the_function(name):
    package = import_module(f"nlds_vines.{name}")
    assert inspect.signature(package) == inspect.signature(getattr(nv, name))
    assert "args" not in inspect.signature(package).parameters


@pytest.mark.parametrize(
    ("first", "name"), [("load_scan", "bifurcation"), ("Ensemble", "transients")]
)
def test_another_name_of_a_package_leaves_the_function_in_its_place(first, name):
    program = f"import nlds_vines as nv; nv.{first}; print(type(nv.{name}).__name__)"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout == "function\n"
