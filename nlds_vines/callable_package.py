"""A package that can be called, as the function of its name: `nv.bifurcation(...)`.

`python -m nlds_vines.bifurcation` needs a package of that name, `nv.bifurcation(...)` a function.
Importing the package puts it in the function's place, so the package itself is made callable.
These functions have other names now, and the old ones go with version 0.2.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Any

from nlds_vines.errors import renamed


class CallablePackage(ModuleType):
    """A package whose call is that of the function of its name in its module `command`."""

    def __call__(self, *args: Any, **keywords: Any) -> Any:
        """Load the command's module and call the function; say what it is called now."""
        renamed(f"nv.{self.__name__.rpartition('.')[2]}", f"nv.{self.__dict__['NEW_NAME']}", 3)
        return self._function(*args, **keywords)

    @property
    def __signature__(self) -> inspect.Signature:
        """The arguments of the function, for help and editors."""
        return inspect.signature(self._function)

    @property
    def _function(self) -> Callable[..., Any]:
        name = self.__name__.rpartition(".")[2]
        return getattr(import_module(f"{self.__name__}.command"), name)


def make_callable(package: str, new_name: str) -> None:
    """Make the package of this name callable; its `__init__` calls this with `__name__`.

    Arguments: `new_name`, what the function is called now.
    """
    vars(sys.modules[package])["NEW_NAME"] = new_name
    sys.modules[package].__class__ = CallablePackage
