"""A command's folder is called like its function, whichever was loaded first."""

import inspect
from importlib import import_module

import pytest
from commands import printed

import nlds_vines as nv

NAMES = ["bifurcation", "portrait", "transients"]


@pytest.mark.parametrize("name", NAMES)
def test_the_folder_has_the_arguments_of_its_function(name):
    function = getattr(import_module(f"nlds_vines.{name}.command"), name)
    assert inspect.signature(getattr(nv, name)) == inspect.signature(function)
    assert "args" not in inspect.signature(function).parameters


@pytest.mark.parametrize("name", NAMES)
def test_its_modules_are_found_before_and_after_it_is_used(name):
    program = f"import nlds_vines as nv; f = nv.{name}; import nlds_vines.{name}.command as c;"
    program += f"print(f is nv.{name}, callable(f), c.__name__)"
    assert printed("-c", program) == f"True True nlds_vines.{name}.command\n"
